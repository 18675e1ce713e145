"""Pictures of the scene in the real page: of two modes, and while the count of the pieces of the
beam changes. Each frame is drawn by the processor, so the window is small."""

import base64
import io
from collections.abc import Iterator
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from live.browser import Page, page
from scipy import ndimage

from beamviz.beam import Beam
from beamviz.explorer.app import explorer
from beamviz.scene import Scene

pytestmark = pytest.mark.browser

NODES = "window.__viserMutable?.nodeRefFromName"
SIZED = f"""(() => {{
  const sets = [];
  {NODES}?.['/scene/rotor/beam']?.traverse(node => {{
    const data = node.matricesTexture?._data;
    if (data && Math.hypot(...data.slice(4, 7)) > 1e-5) sets.push(node.instancesCount);
  }});
  return sets;
}})()"""  # how many pieces there are to be seen
RECORD = f"""window.seen = [];
  (function frame() {{ window.seen.push({SIZED}.join('+')); requestAnimationFrame(frame); }})()"""
HIDE = "document.head.append(Object.assign(document.createElement('style'), {textContent: " + (
    "'#scene > :not(#root, #caption-layer) { visibility: hidden !important }'}))"
)
HIDE_CAPTIONS = "document.querySelector('#caption-layer').style.visibility = 'hidden'"


BLOCK = 16  # [pixels]: letters drawn in two ways differ at their edges


@pytest.fixture(scope="module")
def shown() -> Iterator[Page]:
    """A page with its scene drawn, paused at full swing."""
    scene = Scene(Beam(mu=40)).changed(playing=False, nodes=False)
    with explorer(scene) as url, page(url, 640, 560, is_drawn=True) as opened:
        opened.wait(f"{NODES} && {SIZED}.length === 1")
        opened.wait("document.body.innerText.includes('Stable equilibrium')")
        opened.evaluate(RECORD)
        opened.evaluate(HIDE)
        opened.evaluate(HIDE_CAPTIONS)
        yield opened


def press(shown: Page, key: str, expected: int) -> None:
    """Press a key, and wait until the beam is in so many pieces."""
    shown.key(key)
    shown.wait(f"{SIZED}.join() === '{expected}'")
    shown.next_frame()


def seen(shown: Page, file: Path) -> np.ndarray:
    """The scene (h, w, 3) on the screen."""
    shown.picture(file)
    box = "(r => [r.x, r.y, r.width, r.height])(document.querySelector('#root canvas')"
    left, top, width, height = map(round, shown.evaluate(f"{box}.getBoundingClientRect())"))
    return matplotlib.image.imread(file)[top : top + height, left : left + width, :3]


def saved(shown: Page) -> np.ndarray:
    """The scene (h, w, 3) in the file that the page saves."""
    url = shown.evaluate("""new Promise(done => beamvizCaptions.picture(png => {
      const reader = new FileReader();
      reader.onload = () => done(reader.result);
      reader.readAsDataURL(png); }))""")
    content = base64.b64decode(url.partition(",")[2])
    return matplotlib.image.imread(io.BytesIO(content))[..., :3]


def block_means(pixels: np.ndarray) -> np.ndarray:
    """The brightness of a picture (h, w, 3), averaged over blocks."""
    height, width = (n // BLOCK * BLOCK for n in pixels.shape[:2])
    blocks = pixels[:height, :width].reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3)
    return blocks.mean(axis=(1, 3, 4))


def picture(shown: Page, file: Path) -> np.ndarray:
    """Where the scene (h, w) shows the colours of the beam: strong ones from blue over green to
    yellow, neither the collars of nodes nor the mark of the hub."""
    scene = seen(shown, file)
    red, green, blue = np.moveaxis(scene, 2, 0)
    strong = np.maximum(np.maximum(red, green), blue) - np.minimum(np.minimum(red, green), blue)
    return (strong > 0.25) & (green > 0.15) & (np.maximum(green, blue) > red)


def is_whole(beam: np.ndarray) -> bool:
    """Whether the beam is one connected patch of the picture that reaches far across it."""
    patches, _ = ndimage.label(beam, np.ones((3, 3)))
    sizes = np.bincount(patches.ravel(), minlength=2)[1:]
    across = np.flatnonzero((patches == 1 + sizes.argmax()).any(axis=0))
    return sizes.max() > 0.97 * beam.sum() > 0 and np.ptp(across) > 0.4 * beam.shape[1]


@pytest.mark.slow
def test_a_saved_picture_equals_the_scene(shown, tmp_path):
    """The present moment and viewpoint, on the background of the page."""
    pixels = saved(shown)
    assert np.ptp(pixels, axis=2).max() > 0.25
    assert np.abs(pixels - seen(shown, tmp_path / "page.png")).max() < 0.05


@pytest.mark.slow
def test_a_saved_picture_has_its_captions(tmp_path):
    """Of two nodes, and the speed: where they are on the screen."""
    scene = Scene.of(Beam(gamma=5), mode=3, playing=False)
    with explorer(scene) as url, page(url, 640, 560, is_drawn=True) as opened:
        opened.wait("document.querySelectorAll('#caption-layer > span').length === 3")
        opened.evaluate(HIDE)
        opened.next_frame()
        means = [block_means(each) for each in (saved(opened), seen(opened, tmp_path / "a.png"))]
    assert np.abs(means[0] - means[1]).max() < 0.08


@pytest.mark.slow
def test_the_beam_stays_whole_while_its_pieces_change(shown, tmp_path):
    """From few to many and back, paused and in motion: each frame has one set of pieces, and the
    beam is connected; pictures of two modes differ."""
    pictures = []
    for key, expected in (("1", 64), ("3", 256), ("1", 64), ("5", 256)):
        press(shown, key, expected)
        pictures.append(picture(shown, tmp_path / "page.png"))
        assert is_whole(pictures[-1])
    assert (pictures[0] != pictures[1]).mean() > 0.005
    for key, expected in (("p", 256), ("1", 64), ("3", 256)):
        press(shown, key, expected)
    assert set(shown.evaluate("window.seen")) <= {"16", "32", "64", "128", "256"}
    assert shown.problems == []
