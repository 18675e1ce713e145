"""The real page in a browser without a window."""

import time
from collections.abc import Iterator
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from live.browser import Page, button, control, field, page, says
from live.visitor import frequency_text

from beamviz.beam import Beam
from beamviz.explorer.app import explorer
from beamviz.scene import Scene

pytestmark = pytest.mark.browser

START = Beam()  # no mass, no rotation: mode 2 has its node at 0.7834
NODES = "window.__viserMutable && window.__viserMutable.nodeRefFromName"


def bodies(name: str, what: str, size: int) -> str:
    """Numbers (size * n) of the bodies of a node that are seen, as they are on the graphics card:
    those that are not seen have no size."""
    return f"""(() => {{
      let mesh;
      {NODES}['{name}'].traverse(node => {{
        if (node.{what} && Math.hypot(...node.matricesTexture._data.slice(4, 7)) > 1e-5)
          mesh = node;
      }});
      return mesh && Array.from(mesh.{what}._data.slice(0, {size} * mesh.instancesCount));
    }})()"""


PIECES = bodies("/scene/rotor/beam", "matricesTexture", 16)
COLOURS = bodies("/scene/rotor/beam", "colorsTexture", 4)
COLLARS = bodies("/scene/rotor/nodes", "matricesTexture", 16)


@pytest.fixture(scope="module")
def shown() -> Iterator[Page]:
    """One page that the tests of this file use in turn; it starts paused at full swing."""
    scene = Scene.of(START, playing=False)
    with explorer(scene) as url, page(url, 1280, 900) as opened:
        opened.wait(f"{NODES} && {NODES}['/scene/rotor/beam'] && {PIECES}")
        opened.wait(says(frequency_text(START)))
        settled(opened)
        yield opened


def pieces(shown: Page) -> np.ndarray:
    """Middles (n, 3) of the pieces of the beam."""
    return np.array(shown.wait(PIECES)).reshape(-1, 16)[:, 12:15]


def settled(shown: Page) -> np.ndarray:
    """Middles of the pieces, once they have stopped moving."""
    before = pieces(shown)
    for _ in range(60):
        time.sleep(0.3)
        now = pieces(shown)
        if np.array_equal(now, before):
            return now
        before = now
    raise TimeoutError("the beam does not come to rest")


def test_the_page_loads_without_complaint(shown):
    """No console error, no failed request, no exception; the table lists five modes."""
    assert shown.problems == []
    text = shown.evaluate("document.querySelector('table').innerText")
    for mode in range(5):
        assert frequency_text(START, mode) in text


def test_mode_2_shows_its_node(shown):
    """Marked at 0.783, and there the drawn beam crosses its line at rest."""
    places = settled(shown)
    (k,) = np.flatnonzero(np.diff(np.sign(places[:, 1])))
    x, y = places[k : k + 2, 0], places[k : k + 2, 1]
    assert x[0] - y[0] * (x[1] - x[0]) / (y[1] - y[0]) == pytest.approx(0.7834, abs=1e-3)
    assert np.abs(places[:, 1]).max() == pytest.approx(0.15, rel=0.05)
    collars = shown.wait(COLLARS)
    assert collars[12] == pytest.approx(0.78344, abs=1e-4)


def test_pictures_of_two_modes_are_not_blank_and_differ(shown, tmp_path):
    """The page itself, as a visitor sees it."""
    pictures = []
    for mode, crossings in (("3", 2), ("2", 1)):
        shown.click(button(mode))
        end = time.monotonic() + 20
        while np.diff(np.sign(pieces(shown)[:, 1])).nonzero()[0].size != crossings:
            assert time.monotonic() < end
            time.sleep(0.2)
        time.sleep(1.0)
        shown.picture(tmp_path / "page.png")
        pictures.append(scene_of(tmp_path / "page.png"))
    assert coloured(pictures[0]) > 0.01
    assert coloured(pictures[1]) > 0.01
    assert (np.abs(pictures[0] - pictures[1]).max(axis=2) > 0.1).mean() > 0.005


def scene_of(path: Path) -> np.ndarray:
    """The part of a picture of the page without panels (h, w, 3)."""
    whole = matplotlib.image.imread(path)[..., :3]
    return whole[350:, :900]


def coloured(picture: np.ndarray) -> float:
    """Share of the picture that is neither white nor grey."""
    return float((np.ptp(picture, axis=2) > 0.25).mean())


def test_dragging_a_slider_changes_beam_and_table(shown):
    """Dragged from 70 to a stouter beam: thicker as 1 / mu; then a mass: another shape."""
    size = thickness(shown)
    shown.drag(control("slenderness μ"), 0.33, 0.1)
    mu = value(shown, "slenderness μ")
    assert 10 <= mu < 50
    shown.wait(says(frequency_text(Beam(mu=mu))))
    settled(shown)
    assert thickness(shown) / size == pytest.approx(70 / mu, rel=1e-3)
    before = pieces(shown)
    shown.drag(control("mass α"), 0.02, 0.6)
    alpha = value(shown, "mass α")
    assert alpha > 1
    shown.wait(says(frequency_text(Beam(alpha=alpha, mu=mu))))
    after = settled(shown)
    assert after.shape != before.shape or not np.allclose(after, before, atol=1e-3)


def value(shown: Page, label: str) -> float:
    """The number beside a slider."""
    time.sleep(0.5)
    return float(shown.evaluate(f"{field(label)}.value"))


def thickness(shown: Page) -> float:
    """Thickness of the first piece of the beam."""
    return float(np.linalg.norm(np.array(shown.wait(PIECES))[4:7]))


def test_playing_moves_the_beam_and_pausing_stops_it(shown):
    """The box in the panel starts and stops the one clock."""
    before = settled(shown)
    shown.click(control("playing"))
    end = time.monotonic() + 20
    while np.allclose(pieces(shown), before, atol=1e-3):
        assert time.monotonic() < end
        time.sleep(0.2)
    shown.click(control("playing"))
    settled(shown)


def test_a_beam_in_equilibrium_is_coloured(shown):
    """By how far each piece moves."""
    assert len(np.unique(np.array(shown.wait(COLOURS)).reshape(-1, 4), axis=0)) > 20


def test_no_equilibrium_is_said_on_the_page_and_greys_the_beam(shown):
    """biot beyond its limit: in words, with the limit; every piece in the same grey."""
    with explorer(Scene(Beam(mu=10, gamma=20), {"strain": "biot"})) as url:
        shown.call("Page.navigate", url=url)
        shown.wait(says("No equilibrium"))
        shown.wait(says("there is one up to γ = 15.71"))
        shown.wait(f"{NODES} && {NODES}['/scene/rotor/beam'] && {COLOURS}")
        settled(shown)
        assert len(np.unique(np.array(shown.wait(COLOURS)).reshape(-1, 4), axis=0)) == 1
    assert shown.problems == []
