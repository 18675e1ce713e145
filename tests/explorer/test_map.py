"""The tab Map: colours over two of the numbers, and the beam moved by a press on it."""

import math
import re
from typing import Any

import numpy as np
import pytest
from live.browser import SHIFT, Page
from live.offline import Desk, offline
from live.server import wait_until
from live.visitor import Visitor, pause

from beamviz.beam import Beam
from beamviz.explorer import jobs
from beamviz.explorer.features import map as map_tab
from beamviz.explorer.features.real_beam import RPM, STEEL_BEAM
from beamviz.presets import PRESETS
from beamviz.scene import Scene
from beamviz.solver import solve

BEAM = Beam(alpha=1, beta=0.5, gamma=5)
FIRST = Scene(BEAM)


def map_shown(guest: Visitor, **expected: Any) -> dict[str, Any]:
    """Wait for a map that has these entries, or words in its name."""
    data, expected = guest.charts["map-chart"], {"values": "[", **expected}
    guest.wait(lambda _: all(text in str(data.get(key)) for key, text in expected.items()))
    return data


def grid(data: dict[str, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The axes and the values (rows, columns) of a map, nan where there is none."""
    values = np.array(data["values"], float).reshape(-1, data["columns"])
    ends = zip((data["x"]["range"], data["y"]["range"]), values.shape[::-1], strict=True)
    x, y = (np.linspace(*end, count) for end, count in ends)
    return x, y, values


def place(guest: Visitor) -> list[float]:
    """The numbers of the beam in the map."""
    return [guest.charts["map-chart"]["cursor"][axis] for axis in "xy"]


@pytest.fixture
def few_columns(monkeypatch) -> int:
    """The columns of a map that is computed sooner."""
    columns, _ = size = 27, 15
    monkeypatch.setattr(map_tab, "SIZE", size)
    return columns


@pytest.mark.usefixtures("few_columns")
@pytest.mark.parametrize("coriolis", [False, True])
def test_the_values_are_those_of_solve(guest, coriolis):
    """The smallest gap and the frequency of a mode; buttons move the beam to the extremes."""
    pause(guest)
    guest.edit(coriolis=coriolis)
    guest.do("tab", "map")
    guest.choose("across", "delta")
    for mapped, words, head in (("gap", "smallest frequency gap", "gap"), ("3", "of mode 3", "ω")):
        guest.choose("mapped", mapped)
        x, y, values = grid(map_shown(guest, name=words, y="hub"))
        assert values.shape == (15, 27)
        for row, column in ((0, 0), (3, 20), (14, 10)):
            beam = BEAM.replace(gamma=float(x[column]), delta=float(y[row]))
            frequencies = solve(beam, coriolis=coriolis).frequencies
            expected = np.diff(frequencies).min() if mapped == "gap" else frequencies[2]
            assert values[row, column] == pytest.approx(expected, abs=1e-4 * frequencies[-1])
        guest.says(f">{head} [1/T*]</th>")
    row, column = np.unravel_index(values.argmax(), values.shape)
    for words in (f"{values.max():.3g}", f'data-value="&quot;{x[column]} {y[row]}&quot;"'):
        guest.wait(lambda _, words=words: words in guest.texts["map-text"])


@pytest.mark.usefixtures("few_columns")
def test_a_point_of_the_map_sets_two_numbers_and_its_axes_can_be_exchanged(guest, session):
    """In one step, which one undo restores; near the end of an axis the map is not sent again. The
    same number cannot be on both axes; what is neither a point nor an axis is ignored."""
    guest.do("tab", "map")
    data = map_shown(guest, name="gap", x="speed", y="mass")
    assert (place(guest), data["x"]["range"]) == ([5, 1], [0, 20])
    pause(guest)
    data.pop("values")
    guest.do("move_beam", "19 0.25", until=lambda _: place(guest) == [19, 0.25])
    wait_until(lambda: not session.is_busy)
    guest.do("undo", until=lambda _: place(guest) == [5, 1])
    assert "values" not in data
    guest.choose("gamma", 25.0)  # beyond the axis
    assert map_shown(guest)["x"]["range"] == [0, 40]
    for action, value in (
        ("across", "spin_up"), ("across", 1), ("mapped", "6"), ("mapped", True),
        ("move_beam", "nan"), ("move_beam", "1 2 3"), ("move_beam", True),
    ):  # fmt: skip
        guest.do(action, value)
    guest.choose("across", "gamma")
    map_shown(guest, x="mass", y="speed")
    assert (guest.values["over"], guest.values["across"]) == ("alpha", "gamma")
    assert place(guest) == [1, 25]


def test_a_point_of_the_map_of_a_real_beam_is_in_its_units(monkeypatch):
    """A press at 600 rpm and 0.1 kg gives the beam these, as `from_si` has them; and an end of the
    axis in another unit, the mass in g."""
    monkeypatch.setattr(map_tab, "SIZE", (9, 5))
    values = STEEL_BEAM.values
    with offline():
        desk = Desk(Scene(STEEL_BEAM.beam).changed(playing=False))
        desk.do("tab", "map")
        desk.frame(5)
        data = desk.guest.visitor.charts["map-chart"]
        desk.guest.visitor.receive()
        assert (data["x"]["unit"], data["y"]["unit"]) == ("rpm", "kg")
        desk.do("move_beam", "600 0.1")
        desk.frame(3)
        physical = desk.state.case.beam.physical
        expected = Beam.from_si(
            **values | {"rotation_speed": 600 * RPM, "mass": 0.1, "mass_position": 1.0}
        )
        assert physical.rotation_speed == pytest.approx(600 * math.pi / 30, rel=1e-9)
        assert physical.mass == pytest.approx(0.1, rel=1e-9)
        assert desk.state.case.beam.numbers == pytest.approx(expected.numbers, rel=1e-9)
        desk.guest.visitor.receive()
        assert data["cursor"] == {
            "action": "move_beam",
            "x": pytest.approx(600),
            "y": pytest.approx(0.1),
        }


def test_a_map_over_the_angles_of_the_section(monkeypatch):
    """Offered with both planes only; a press sets both angles. In one plane the axes, also that of
    the loci, are usual ones again."""
    monkeypatch.setattr(map_tab, "SIZE", (5, 4))
    start = Scene.of(alpha=0, gamma=5, flap=0.1, pitch=20, plane="both")
    with offline():
        desk = Desk(start.changed(playing=False))
        desk.do("tab", "map")
        desk.do("over", "pitch")
        desk.do("across", "twist")
        desk.do("mapped", "2")
        desk.frame(5)
        visitor = desk.guest.visitor
        visitor.receive()
        data, shown = visitor.charts["map-chart"], visitor.texts["map-over"]
        assert all(f'value="{name}"' in shown for name in ("gamma", "flap", "pitch", "twist"))
        assert (data["x"]["unit"], data["x"]["range"]) == ("deg", [0, 90])
        x, y, values = grid(data)
        beam = start.beam.replace(pitch=float(x[3]), twist=float(y[2]))
        assert values[2, 3] == pytest.approx(solve(beam, plane="both").frequencies[1], rel=1e-4)
        desk.do("move_beam", "30 60")
        desk.frame(3)
        assert (desk.state.case.beam.pitch, desk.state.case.beam.twist) == (30, 60)
        desk.do("plane", "flapwise")
        desk.frame(5)
        visitor.receive()
        assert (desk.state.over, desk.state.slice(map_tab.MapState).across) == ("gamma", "alpha")
        assert "pitch" not in visitor.texts["map-over"] + visitor.texts["loci-over"]


@pytest.mark.usefixtures("few_columns")
def test_beams_without_a_frequency_are_explained(guest):
    """An inward beam buckles: no colour there, and a sentence with the percentage. Its higher modes
    have a frequency, and a beam that has buckled in the other plane all: these are named too."""
    guest.do("tab", "map")
    guest.set(mapped="1", delta=-1.0)
    guest.says("Grey: divergence")
    *_, values = grid(map_shown(guest, name="mode 1"))
    assert 0 < np.isnan(values).mean() < 1
    guest.set(mapped="2")
    guest.says("In colour, but: divergence")
    guest.set(plane="flapwise")
    guest.says("In colour, but: buckled chordwise")


@pytest.fixture
def impatient(monkeypatch) -> None:
    """To cancel a computation is offered at once."""
    monkeypatch.setattr(jobs, "PATIENCE", 0.05)


@pytest.mark.usefixtures("impatient")
def test_a_slow_map_is_cancelled_and_restarted(connected, few_columns):
    """With its progress, of which the last map tells too while it is there."""
    pause(connected)
    connected.do("tab", "map")
    map_shown(connected, columns=str(few_columns))
    connected.choose("method", "ancf")
    running = r"computing: map .* [1-9]\d? %"
    for action, place in (("cancel_jobs", "work"), (None, "map-chart-wait")):
        connected.wait(lambda _, p=place: re.search(running, connected.texts[p]))
        for part in ("map-chart", "map-text"):
            told = connected.props[part]["data-outdated"]
            assert re.search(r"outdated: computing … [1-9]\d? %", told)
        if action:
            assert not connected.props["map-chart"]["hidden"]
            connected.do(action, until=lambda _: "cancelled: map" in connected.texts["work"])
            assert connected.props["map-chart"]["hidden"]
            connected.do("retry_jobs", None)
    connected.do("tab", "loads")  # for the same beam it goes on
    connected.wait(lambda _: re.search(r"computing: map .* [1-9]\d? %", connected.texts["work"]))
    connected.choose("method", "auto")  # for another one it does not
    connected.wait(lambda _: not connected.texts["work"])
    connected.do("tab", "map")
    connected.wait(lambda _: connected.props["map-chart"]["data-outdated"] is None)


@pytest.mark.usefixtures("impatient")
def test_an_empty_tab_says_what_is_computed_and_how_far_it_is(connected, served):
    """In its place, with a button to cancel it: the first map of a blade takes long. Cancelled, it
    can be computed again."""
    served.visitor.open(Scene(PRESETS["nrel-5mw-blade"].beam))
    connected.do("tab", "map")
    told = r"computing: map .* [1-9]\d? %.*Cancel"
    connected.wait(lambda _: re.search(told, connected.texts["map-chart-wait"]))
    assert not connected.charts["map-chart"]
    assert "computing: map" not in connected.texts["work"]
    connected.do("tab", "export", until=lambda _: re.search(told, connected.texts["work"]))
    connected.do("tab", "map", until=lambda _: "computing: map" not in connected.texts["work"])
    connected.do("cancel_jobs")
    connected.wait(lambda _: "Compute again" in connected.texts["map-chart-wait"])


# On the page

PLOT, RING, SVG, CANVAS = (
    f"document.querySelector('#map-chart {part}')"
    for part in (".plot", "[role=slider]", "svg", "canvas")
)


def numbers(shown: Page) -> list[float]:
    """Speed and mass as the server says, empty until it says the same of the map."""
    fields = [shown.number("gamma"), shown.number("alpha")]
    place = shown.evaluate("(({x, y}) => [x, y])(beamviz.drawn['map-chart'].cursor)")
    return fields if place == pytest.approx(fields, rel=1e-4) else []


@pytest.mark.slow
def test_the_map_works_by_mouse_and_keys(shown):
    """A click sets both numbers, an arrow key one of them; the map and its ring have names. The
    canvas has the first colour at the smallest value, the last at the largest."""
    shown.open_tab("map")
    shown.wait(f"!!{SVG}?.querySelector('.region')")
    left, top, width, height = shown.box(PLOT, frames=40)
    x, y = left + 62 + 0.5 * (width - 62 - 39), top + 20 + 0.75 * (height - 62)
    shown.click_at(x, y)
    there = [pytest.approx(10, abs=0.1), pytest.approx(0.5, abs=0.05)]
    wait_until(lambda: numbers(shown) == there)
    before = numbers(shown)
    shown.evaluate(f"{RING}.focus()")
    shown.key("ArrowUp")
    one_step = wait_until(lambda: numbers(shown) not in ([], before) and numbers(shown))
    assert one_step[0] == before[0]
    step = one_step[1] - before[1]
    assert step > 0
    assert shown.evaluate(f"{RING}.getAttribute('aria-valuetext')").startswith("γ = 10")
    shown.key("ArrowUp", modifiers=SHIFT)  # a finer step, as in a chart
    finer = pytest.approx([before[0], before[1] + 1.2 * step], abs=1e-3 * step)
    wait_until(lambda: numbers(shown) == finer)
    shown.key("PageUp")
    coarser = pytest.approx([before[0], before[1] + 11.2 * step], abs=1e-3 * step)
    wait_until(lambda: numbers(shown) == coarser)
    name = shown.evaluate(f"{SVG}.getAttribute('aria-label')")
    assert name.startswith("Map: smallest frequency gap over speed γ and mass α, from ")
    ends = shown.evaluate(f"""(values => [Math.min(...values), Math.max(...values)].map(value => {{
      const k = values.indexOf(value), canvas = {CANVAS}.getContext('2d');
      return [...canvas.getImageData(k % 81, 40 - Math.floor(k / 81), 1, 1).data];
    }}))(beamviz.drawn['map-chart'].values)""")
    assert ends == [[62, 84, 150, 255], [253, 231, 37, 255]]
    assert shown.problems == []
