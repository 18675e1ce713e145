"""The beam in the real page while the count of its pieces changes."""

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


def press(shown: Page, key: str, expected: int) -> None:
    """Press a key, and wait until the beam is in so many pieces."""
    kind = "Digit" if key.isdigit() else "Key"
    for part in ("keyDown", "keyUp"):
        shown.call("Input.dispatchKeyEvent", type=part, key=key, code=f"{kind}{key.upper()}")
    shown.wait(f"{SIZED}.join() === '{expected}'")
    shown.next_frame()


def coloured(file: Path) -> np.ndarray:
    """Where a picture (h, w) shows the colours of the beam: strong ones from blue over green to
    yellow, neither the collars of nodes nor the mark of the hub."""
    red, green, blue = np.moveaxis(matplotlib.image.imread(file)[..., :3], 2, 0)
    strong = np.maximum(np.maximum(red, green), blue) - np.minimum(np.minimum(red, green), blue)
    return (strong > 0.25) & (green > 0.15) & (np.maximum(green, blue) > red)


def unbroken(shown: Page, file: Path) -> None:
    """The beam is one connected patch of the picture that reaches across it."""
    shown.picture(file)
    beam = coloured(file)[250:520, 340:930]  # the scene without its captions
    patches, count = ndimage.label(beam, np.ones((3, 3)))
    sizes = np.bincount(patches.ravel())[1:]
    assert count
    assert sizes.max() > 0.97 * sizes.sum()
    across = np.flatnonzero((patches == 1 + sizes.argmax()).any(axis=0))
    assert np.ptp(across) > 300


def test_the_beam_stays_whole_while_its_pieces_change(tmp_path):
    """From few to many and back, paused and in motion: in every frame there is one set of pieces
    and it is a whole beam in the picture."""
    scene = Scene(Beam(mu=40)).changed(playing=False, nodes=False)
    with explorer(scene) as url, page(url, 1280, 900) as shown:
        shown.wait(f"{NODES} && {SIZED}.length === 1")
        shown.wait("document.body.innerText.includes('Stable equilibrium')")
        shown.evaluate(RECORD)
        for k, (key, expected) in enumerate([("1", 64), ("3", 256), ("1", 64), ("5", 256)]):
            press(shown, key, expected)
            unbroken(shown, tmp_path / f"{k}.png")
        for key, expected in (("p", 256), ("1", 64), ("3", 256)):
            press(shown, key, expected)
        frames = shown.evaluate("window.seen")
        assert set(frames) <= {"16", "32", "64", "128", "256"}
        assert shown.problems == []
