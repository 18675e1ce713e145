"""The real page in a browser without a window."""

from collections.abc import Iterator

import numpy as np
import pytest
from live.browser import Page, control, field, page, says
from live.server import wait_until
from live.visitor import frequency_text

from beamviz.beam import Beam
from beamviz.explorer.app import explorer
from beamviz.scene import Scene, ViewOptions

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
        yield opened


def pieces(shown: Page) -> np.ndarray:
    """Middles (n, 3) of the pieces of the beam."""
    return np.array(shown.wait(PIECES)).reshape(-1, 16)[:, 12:15]


def crossings(shown: Page) -> np.ndarray:
    """The x at which the drawn beam crosses its line at rest, but for its root."""
    places = pieces(shown)
    k = np.flatnonzero(np.diff(np.sign(places[:, 1])))
    (x, y), (dx, dy) = places[k, :2].T, (places[k + 1, :2] - places[k, :2]).T
    return x - y * dx / dy


def test_mode_2_shows_its_node(shown):
    """Marked at 0.783, where the drawn beam crosses its line at rest."""
    wait_until(lambda: crossings(shown) == pytest.approx([0.7834], abs=1e-3))
    wait_until(lambda: np.abs(pieces(shown)[:, 1]).max() == pytest.approx(0.15, rel=0.05))
    assert shown.wait(COLLARS)[12] == pytest.approx(0.78344, abs=1e-4)


def test_dragging_a_slider_changes_beam_and_table(shown):
    """Below 70 the beam is thicker as 1 / mu; a mass changes its shape."""
    size = thickness(shown)
    shown.drag(control("slenderness μ"), 0.33, 0.1)
    wait_until(
        lambda: (
            (beam := solved_beam(shown))
            and 10 <= beam.mu < 50
            and thickness(shown) / size == pytest.approx(70 / beam.mu, rel=1e-3)
        )
    )
    before = pieces(shown)
    shown.drag(control("mass α"), 0.02, 0.6)
    wait_until(
        lambda: (beam := solved_beam(shown)) and beam.alpha > 1 and not same(pieces(shown), before)
    )


def solved_beam(shown: Page) -> Beam | None:
    """The beam of the fields beside the sliders, once the table has its frequency."""
    mu, alpha = (
        float(shown.evaluate(f"{field(label)}.value")) for label in ("slenderness μ", "mass α")
    )
    beam = START.replace(mu=mu, alpha=alpha)
    return beam if shown.evaluate(says(frequency_text(beam))) else None


def thickness(shown: Page) -> float:
    """Thickness of the first piece of the beam."""
    return float(np.linalg.norm(np.array(shown.wait(PIECES))[4:7]))


def same(places: np.ndarray, others: np.ndarray) -> bool:
    """Whether two beams are the same."""
    return places.shape == others.shape and np.allclose(places, others, atol=1e-3)


def test_playing_moves_the_beam_and_pausing_stops_it(shown):
    """By the button over the scene."""
    before = pieces(shown)
    shown.click("document.getElementById('play')")
    wait_until(lambda: not same(pieces(shown), before))
    shown.click("document.getElementById('play')")

    def at_rest() -> bool:
        before = pieces(shown)
        shown.next_frame(frames=20)
        return np.array_equal(pieces(shown), before)

    wait_until(at_rest)


def colours(shown: Page) -> int:
    """How many colours the pieces of the beam have."""
    return len(np.unique(np.array(shown.wait(COLOURS)).reshape(-1, 4), axis=0))


def test_a_beam_is_coloured_by_its_motion_and_grey_without_an_equilibrium(shown):
    """biot beyond its limit: the page names the limit, and all pieces are grey."""
    assert colours(shown) > 20
    for key, value in {"strain": "'biot'", "alpha": 0, "mu": 10, "gamma": 20}.items():
        shown.evaluate(f"beamviz.send('{key}', {value})")
    shown.wait(says("No equilibrium above γ = 15.71"))
    wait_until(lambda: colours(shown) == 1)
    assert shown.problems == []


# Texts over the scene

BOXES = """[...document.querySelectorAll("#caption-layer > span:not([hidden])")].map(e =>
  ({text: e.innerText, size: parseFloat(getComputedStyle(e).fontSize),
    ...e.getBoundingClientRect().toJSON()}))"""


def test_captions_are_legible_and_keep_apart():
    """The three nodes of the fourth bending mode and the speed, on a desk and on a phone: at least
    14 pixels high, inside the page, and none covers another."""
    scene = Scene(Beam(gamma=2), view=ViewOptions(playing=False).only(4))
    with explorer(scene) as url, page(url, 1280, 720) as shown:
        for width, height in ((1280, 720), (390, 844)):
            shown.resize(width, height)
            shown.wait("document.querySelectorAll('#caption-layer > span').length === 4")
            shown.next_frame(10)
            boxes = shown.evaluate(BOXES)
            assert sum("node at" in box["text"] for box in boxes) == 3
            assert all(box["size"] >= 14 for box in boxes)
            assert all(0 <= box["left"] < box["right"] <= width for box in boxes)
            for k, one in enumerate(boxes):
                for other in boxes[:k]:
                    beside = one["right"] <= other["left"] or other["right"] <= one["left"]
                    assert beside or abs(one["top"] - other["top"]) >= one["height"] - 1
        assert not shown.problems
