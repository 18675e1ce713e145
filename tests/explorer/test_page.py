"""The real page in a browser without a window; and, where the scene is drawn, pictures of it. Each
of these frames is drawn by the processor, so that window is small."""

import base64
import io
import math
from collections.abc import Iterator

import matplotlib.image
import numpy as np
import pytest
from helpers import slow
from live.browser import NODES, READY, Page, are_apart, by_id, page, says
from live.server import usual_port, wait_until
from live.visitor import PAPER, frequency_text
from scipy import ndimage

from beamviz.beam import Beam
from beamviz.blade import Blade, Mass
from beamviz.drawing.comparison import number
from beamviz.explorer import FrameLoop, explorer
from beamviz.explorer.features.mass_drag import DragState, Grip, nearest
from beamviz.scene import Scene
from beamviz.solver import solve

START = Beam()  # no mass, no rotation: mode 2 has its node at 0.7834
FIRST = Scene.of(START, playing=False)


def bodies(name: str, what: str, size: int) -> str:
    """Numbers (size * n) of the bodies of a node that are seen, as on the graphics card."""
    return f"""(() => {{
      const mesh = {shown_bodies(name)}.at(-1);
      return mesh && Array.from(mesh.{what}._data.slice(0, {size} * mesh.instancesCount)); }})()"""


def shown_bodies(name: str) -> str:
    """The sets of bodies of a node that are seen."""
    return f"""(() => {{
      const found = [];
      {NODES}?.['{name}']?.traverse(node => {{
        if (Math.hypot(...node.matricesTexture?._data.slice(4, 7) ?? []) > 1e-5) found.push(node);
      }});
      return found; }})()"""


PIECES = bodies("/scene/rotor/beam", "matricesTexture", 16)
COLOURS = bodies("/scene/rotor/beam", "colorsTexture", 4)
COLLARS = bodies("/scene/rotor/nodes", "matricesTexture", 16)


@pytest.fixture(scope="module")
def shown(shown) -> Page:
    """The page of this file, which starts paused at full swing."""
    shown.wait(PIECES)
    return shown


@pytest.fixture
def begun(shown) -> Page:
    """The same page with its first scene, paused at full swing, whichever tests came before."""
    shown.resize(1440, 900)
    shown.send("load", f"beam.toml\n{FIRST.to_toml()}")
    for preferences in ("still", ""):  # the first of which shows full swing
        shown.send("preferences", preferences)
        shown.catch_up()
    shown.wait(says(frequency_text(START)))
    return shown


def pieces(shown: Page) -> np.ndarray:
    """Middles (n, 3) of the pieces of the beam."""
    return np.array(shown.wait(PIECES)).reshape(-1, 16)[:, 12:15]


def test_mode_2_shows_its_node(begun):
    """Marked at 0.783, where the drawn beam crosses its line at rest."""

    def crossings() -> np.ndarray:
        places = pieces(begun)
        k = np.flatnonzero(np.diff(np.sign(places[:, 1])))
        (x, y), (dx, dy) = places[k, :2].T, (places[k + 1, :2] - places[k, :2]).T
        return x - y * dx / dy

    wait_until(lambda: crossings() == pytest.approx([0.7834], abs=1e-3))
    wait_until(lambda: np.abs(pieces(begun)[:, 1]).max() == pytest.approx(0.15, rel=0.05))
    assert begun.wait(COLLARS)[12] == pytest.approx(0.78344, abs=1e-4)


def test_dragging_a_slider_changes_beam_and_table(begun):
    """Below 70 the beam is thicker as 1 / mu; a mass changes its shape."""

    def table_is_of_the_fields() -> bool:
        beam = START.replace(mu=begun.number("mu"), alpha=begun.number("alpha"))
        return begun.evaluate(says(frequency_text(beam)))

    def thickness() -> float:
        return float(np.linalg.norm(begun.wait(PIECES)[4:7]))

    size = thickness()
    begun.drag_along(by_id("mu-slider"), 0.33, 0.1)
    wait_until(lambda: 10 <= begun.number("mu") < 50 and table_is_of_the_fields())
    wait_until(lambda: thickness() / size == pytest.approx(70 / begun.number("mu"), rel=1e-3))
    before = pieces(begun)
    begun.drag_along(by_id("alpha-slider"), 0.02, 0.6)
    wait_until(lambda: begun.number("alpha") > 1 and table_is_of_the_fields())
    wait_until(lambda: not same(pieces(begun), before))


def test_the_last_value_of_a_slider_that_moves_fast_is_that_of_the_beam(begun):
    """Though the page does not send each one. The track is coloured up to the thumb."""
    slider = by_id("gamma-slider")
    begun.evaluate(f"""(slider => {{
      for (const value of [3, 4, 5, 6]) {{
        slider.value = value;
        slider.dispatchEvent(new Event("input", {{bubbles: true}}));
      }} }})({slider})""")
    begun.wait("location.search.includes('gamma=6')")
    coloured = begun.evaluate(f"parseFloat(getComputedStyle({slider}).getPropertyValue('--part'))")
    assert coloured == pytest.approx(100 * begun.evaluate(f"6 / {slider}.max"))


def same(places: np.ndarray, others: np.ndarray) -> bool:
    """Whether two beams are the same."""
    return places.shape == others.shape and np.allclose(places, others, atol=1e-3)


def test_playing_moves_the_beam_and_pausing_stops_it(begun):
    """By the button over the scene."""
    before = pieces(begun)
    begun.click("document.getElementById('play')", until=lambda: not same(pieces(begun), before))
    begun.click("document.getElementById('play')")

    def at_rest() -> bool:
        before = pieces(begun)
        begun.next_frame(frames=20)
        begun.catch_up()
        return np.array_equal(pieces(begun), before)

    wait_until(at_rest)


@pytest.mark.slow
def test_play_that_is_pressed_twice_over_a_slow_line_pauses(begun):
    """The second press is for the button as the visitor has left it, not as the server knows it."""
    pressed = "document.getElementById('play').ariaPressed"
    with begun.slow_line():
        for _ in range(2):
            begun.click("document.getElementById('play')")
    begun.catch_up()
    assert begun.evaluate(pressed) == "false"


def test_a_beam_is_coloured_by_its_motion_and_grey_without_an_equilibrium(begun):
    """biot beyond its limit: the page names the limit, and all pieces are grey."""

    def colours() -> int:
        return len(np.unique(np.array(begun.wait(COLOURS)).reshape(-1, 4), axis=0))

    wait_until(lambda: colours() > 20)
    for key, value in {"strain": "biot", "alpha": 0, "mu": 10, "gamma": 20}.items():
        begun.send(key, value)
    begun.wait(says("No equilibrium above γ = 15.708"))
    wait_until(lambda: colours() == 1)
    assert begun.problems == []


BOXES = """[...document.querySelectorAll("#caption-layer > span:not([hidden])")].map(e =>
  ({text: e.innerText, size: parseFloat(getComputedStyle(e).fontSize),
    ...e.getBoundingClientRect().toJSON()}))"""


def test_captions_are_legible_and_keep_apart(shown):
    """The three nodes of the fourth bending mode and the speed, on a desk and on a phone: at least
    14 pixels high, inside the page, and none covers another."""
    scene = Scene.of(Beam(gamma=2), mode=5, playing=False)
    shown.send("load", f"beam.toml\n{scene.to_toml()}")
    for width, height in ((1280, 720), (390, 844)):
        shown.resize(width, height)
        shown.wait(f"{BOXES}.filter(box => box.text.includes('node at')).length === 3")
        wait_until(lambda width=width: are_legible(shown.evaluate(BOXES), width))
    assert not shown.problems


def are_legible(boxes: list[dict[str, float]], width: int) -> bool:
    """Whether captions are large enough, on a page of this width, and apart."""
    inside = all(0 <= box["left"] < box["right"] <= width for box in boxes)
    return all(box["size"] >= 14 for box in boxes) and inside and are_apart(boxes)


def test_a_caption_that_changes_stays_at_its_place(shown):
    """In the frame of the change: in a run-up the speed changes in every frame."""
    shown.evaluate("""window.places = [];
      new MutationObserver(() => places.push(...[...document.querySelectorAll(
        "#caption-layer > span:not([hidden])")].map(e => e.style.transform)))
        .observe(document.getElementById("caption-layer"), {childList: true})""")
    for speed in (3, 4):
        shown.send("gamma", speed, until=f"{BOXES}.some(box => box.text === 'speed γ = {speed}')")
    places = shown.evaluate("places")
    assert places
    assert all(places)


# Dragging the mass


def test_no_point_without_a_line_of_sight():
    """For a line seen end on, a line of sight of length 0, or nan."""
    line, x, origin = np.array([[0.0, 0, 0], [1.0, 0, 0]]), np.array([0.0, 1.0]), np.zeros(3)
    assert nearest(line, x, np.array([-3.0, 0, 0]), origin) is None
    assert nearest(line, x, origin, origin) is None
    assert nearest(line, x, np.array([0.0, -3.0, 1.0]), np.full(3, np.nan)) is None


def grip(frame_loops: list[FrameLoop]) -> Grip | None:
    """What the servers know of a drag in one of their pages, of which some may have been closed."""
    sessions = (session for loop in frame_loops for session in list(loop.sessions.values()))
    return next(
        filter(None, (session.visitor.state.slice(DragState).grip for session in sessions)), None
    )


@pytest.mark.parametrize(
    ("beam", "state", "end", "turned"),
    [
        (Beam(alpha=0.2, beta=0.6, gamma=4, delta=-1), "stable", 0.8, True),
        *slow((PAPER.replace(delta=0.5, gamma=20), "straight", 0.95, False)),
    ],
    ids=["bent", "straight"],
)
def test_the_mass_is_dragged_by_a_mouse(shown, frame_loops, beam, state, end, turned):
    """Along a stretched or a bent beam, towards the tip, in both frames: beta is where the drag
    ended, to a hundredth. The beam before is drawn pale, its frequencies beside the new ones."""
    shown.resize(1440, 900)
    view = {"shares": [1.0], "amplitude": 0.0, "pace": 0.1, "rotating_frame": not turned}
    scene = Scene.of(beam, state=state, playing=turned, **view)
    shown.send("load", f"beam.toml\n{scene.to_toml()}")
    shown.wait(f"{NODES}?.['/scene/rotor/mass'] && {says(frequency_text(beam, state=state))}")
    if turned:
        shown.wait(f"Math.abs({NODES}['/scene/rotor'].quaternion.z) > 0.1")
        shown.send("playing", False)

    def place(x: float) -> list[float]:
        """Where the mass at x is on the page."""
        solution = solve(beam.replace(beta=x), state=state)
        along, across = solution.equilibrium.position([x])[0]
        return shown.evaluate(f"""(() => {{
          const {{ camera, canvas }} = window.__viserMutable, wheel = {NODES}['/scene/rotor'];
          const place = wheel.position.clone().set({beam.delta + along}, {across}, 0);
          const at = wheel.localToWorld(place).project(camera), r = canvas.getBoundingClientRect();
          return [r.left + r.width * (1 + at.x) / 2, r.top + r.height * (1 - at.y) / 2];
        }})()""")

    start, there = shown.at_rest(lambda: place(beam.beta)), place(end)
    arrived = f"Math.abs(parseFloat({by_id('beta-field')}.value) - {end}) < 0.01"
    shown.drag(start, there, taken=lambda: grip(frame_loops), arrived=arrived)
    wait_until(lambda: not grip(frame_loops))
    shown.catch_up()
    assert shown.number("beta") == pytest.approx(end, abs=0.01)
    shown.wait(f"{NODES}['/scene/rotor/overlay']?.visible === true")

    def both_are_compared() -> bool:
        """Once the mass is exactly under the pointer."""
        places = beam.beta, shown.number("beta")
        found = [solve(beam.replace(beta=x), state=state).frequencies[0] for x in places]
        text = shown.evaluate(f"{by_id('comparison')}.textContent")
        return all(words in text for words in ("before, ω", *map(number, found)))

    wait_until(both_are_compared)
    assert shown.problems == []


@pytest.mark.slow
def test_a_drag_beside_the_beam_turns_the_view(url):
    """Also near the hub, and before the pointer was over a body; what was edited can be undone: the
    connection is the same."""
    scene = "?alpha=1&beta=0.5&gamma=2&shares=[1.0]&amplitude=0.0&playing=false"
    with page(f"{url}/{scene}", 1440, 900) as opened:
        opened.wait(f"{READY} && {NODES}?.['/scene/rotor/mass'] && {says('1st bending')}")
        opened.send("gamma", 3.0, until="!document.getElementById('undo').disabled")
        opened.evaluate("window.bridges = 0")
        opened.evaluate("""(apply => { beamviz.apply = update => {
          if (update.bridge) window.bridges++; apply(update); } })(beamviz.apply)""")
        viewpoint = "window.__viserMutable.camera.position.toArray()"
        before = opened.at_rest(lambda: opened.evaluate(viewpoint))

        def turned(least: float) -> bool:
            moved = np.subtract(opened.evaluate(viewpoint), before)
            return bool(np.linalg.norm(moved) > least)

        left, top, width, height = opened.box("document.querySelector('#scene canvas')")
        start = left + 0.45 * width, top + 0.85 * height
        opened.drag(start, (start[0] + 150, start[1] - 40), arrived=lambda: turned(0.5))
        opened.catch_up()
        assert opened.evaluate("window.bridges") == 0
        assert not opened.evaluate("document.getElementById('undo').disabled")
        assert opened.problems == []


@pytest.mark.slow
def test_each_body_is_dragged_by_a_mouse(shown, frame_loops):
    """A box and a collar, each without the other, and undone one by one."""
    shown.resize(1440, 900)
    masses = (Mass(0.3, 0.5, (0.001, 0.004, 0.004)), Mass(0.1, 1.0))
    beam = Beam(blade=Blade.tapered(0.5, 0.3), masses=masses, root=2.0, delta=0.3)
    scene = Scene.of(beam, shares=[1.0], amplitude=0.0, playing=False)
    shown.send("load", f"blade.toml\n{scene.to_toml()}")
    nodes = [f"/scene/rotor/{name}" for name in ("boxes", "mass")]
    seen_both = " && ".join(bodies(node, "matricesTexture", 16) for node in nodes)
    shown.wait(f"{says(frequency_text(beam))} && {seen_both}")

    def position(k: int) -> float:
        matrix = shown.evaluate(bodies(nodes[k], "matricesTexture", 16))
        return matrix[12] - beam.delta if matrix else math.nan

    def place(x: float) -> list[float]:
        return shown.evaluate(f"""(() => {{
          const {{ camera, canvas }} = window.__viserMutable, wheel = {NODES}['/scene/rotor'];
          const at = wheel.localToWorld(wheel.position.clone().set({beam.delta + x}, 0, 0));
          const {{ x, y }} = at.project(camera), r = canvas.getBoundingClientRect();
          return [r.left + r.width * (1 + x) / 2, r.top + r.height * (1 - y) / 2]; }})()""")

    for k, end in ((0, 0.3), (1, 0.8)):
        start = shown.at_rest(lambda k=k: place(position(k)))
        shown.drag(
            start,
            place(end),
            taken=lambda: grip(frame_loops),
            arrived=lambda k=k, end=end: abs(position(k) - end) < 0.01,
        )
        wait_until(lambda: not grip(frame_loops))
        shown.catch_up()
        assert position(k) == pytest.approx(end, abs=0.01)
    assert position(0) == pytest.approx(0.3, abs=0.01)
    shown.send("undo")
    wait_until(lambda: position(1) == pytest.approx(1.0, abs=1e-3))
    assert position(0) == pytest.approx(0.3, abs=0.01)


# Pictures of the scene

SIZED = f"{shown_bodies('/scene/rotor/beam')}.map(node => node.instancesCount)"
RECORD = f"""window.seen = [];
  (function frame() {{ window.seen.push({SIZED}.join('+')); requestAnimationFrame(frame); }})()"""
HIDE = """document.head.append(Object.assign(document.createElement('style'), {textContent:
  '#scene > :not(#root, #caption-layer) { visibility: hidden !important }'}))"""
HIDE_CAPTIONS = "document.querySelector('#caption-layer').style.visibility = 'hidden'"
BLOCK = 16  # [pixels] to average over: letters drawn in two ways differ at their edges


@pytest.fixture(scope="module")
def drawn() -> Iterator[Page]:
    """A page with its scene drawn, paused at full swing."""
    scene = Scene(Beam(mu=40)).changed(playing=False, nodes=False)
    with (
        explorer(scene, port=usual_port()) as url,
        page(f"{url}/?fixedDpr=1", 640, 560, is_drawn=True) as opened,
    ):
        opened.wait(f"{SIZED}.length === 1 && {says('Stable equilibrium')}")
        for script in (RECORD, HIDE, HIDE_CAPTIONS):
            opened.evaluate(script)
        wait_until(lambda: is_whole(picture(opened)))  # the camera is fitted to the page
        yield opened


def press(shown: Page, key: str) -> None:
    """Press a key, and wait until the beam is in another number of pieces."""
    before = shown.evaluate(f"{SIZED}.join()")
    shown.key(key, until=f"{SIZED}.join() !== '{before}'")
    shown.next_frame()


def pixels(png: str) -> np.ndarray:
    """A picture (h, w, 3) in base64."""
    return matplotlib.image.imread(io.BytesIO(base64.b64decode(png)))[..., :3]


def seen(shown: Page) -> np.ndarray:
    """The scene on the screen."""
    left, top, width, height = map(round, shown.box("document.querySelector('#root canvas')", 1))
    screen = pixels(shown.call("Page.captureScreenshot")["data"])
    return screen[top : top + height, left : left + width]


def saved(shown: Page) -> np.ndarray:
    """The scene in the file that the page saves."""
    png = shown.evaluate("""new Promise(done => beamvizCaptions.picture(png => {
      const reader = new FileReader();
      reader.onload = () => done(reader.result.split(',')[1]);
      reader.readAsDataURL(png); }))""")
    return pixels(png)


def picture(shown: Page) -> np.ndarray:
    """Where the scene (h, w) shows the colours of the beam: strong ones from blue over green to
    yellow, neither the collars of nodes nor the mark of the hub."""
    red, green, blue = np.moveaxis(seen(shown), 2, 0)
    strong = np.maximum(np.maximum(red, green), blue) - np.minimum(np.minimum(red, green), blue)
    return (strong > 0.25) & (green > 0.15) & (np.maximum(green, blue) > red)


def is_whole(beam: np.ndarray) -> bool:
    """Whether the beam is one connected patch of the picture that reaches far across it."""
    patches, _ = ndimage.label(beam, np.ones((3, 3)))
    sizes = np.bincount(patches.ravel(), minlength=2)[1:]  # [0] of an empty picture
    across = np.flatnonzero((patches == 1 + sizes.argmax()).any(axis=0))
    return sizes.max() > 0.97 * beam.sum() and np.ptp(across) > 0.3 * beam.shape[1]


@pytest.mark.slow
def test_the_beam_stays_whole_while_its_pieces_change(drawn):
    """From few to many and back, paused and in motion: each frame has one set of pieces, and the
    beam is connected; pictures of two modes differ."""
    pictures = []
    for key in "135":
        press(drawn, key)
        pictures.append(picture(drawn))
        assert is_whole(pictures[-1])
    assert (pictures[0] != pictures[1]).mean() > 0.005
    drawn.key("p")
    for key in "13":
        press(drawn, key)
    assert all(count.isdigit() for count in drawn.evaluate("window.seen"))
    assert drawn.problems == []


@pytest.mark.slow
def test_a_saved_picture_equals_the_scene(drawn):
    """The moment, the viewpoint, the background of the page, and captions where they are on it."""
    drawn.send("used", "pull turn")  # hints are not in it
    drawn.send("playing", False, until="document.getElementById('play').ariaPressed === 'false'")
    drawn.next_frame(10)
    pixels = saved(drawn)
    assert np.ptp(pixels, axis=2).max() > 0.25
    assert np.abs(pixels - seen(drawn)).max() < 0.05
    scene = Scene.of(Beam(gamma=5), mode=3, playing=False)
    drawn.send("load", f"beam.toml\n{scene.to_toml()}")
    drawn.wait("document.querySelectorAll('#caption-layer > span').length === 3")
    drawn.evaluate("document.querySelector('#caption-layer').style.visibility = 'visible'")
    drawn.next_frame(10)
    grey = (each.mean(axis=2) for each in (saved(drawn), seen(drawn)))
    one, other = (ndimage.uniform_filter(each, BLOCK) for each in grey)
    assert np.abs(one - other).max() < 0.08
