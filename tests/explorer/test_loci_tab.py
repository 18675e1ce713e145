"""The tabs Frequencies and Veering in a running explorer, and the chart on the real page."""

import re
import threading
from functools import cache
from typing import Any

import numpy as np
import pytest
from charts import TIP, chart_of
from live.browser import SHIFT, Page, by_id
from live.server import wait_until
from live.visitor import Visitor, catch_up, frequency_text, pause, visitor

from beamviz.beam import Beam
from beamviz.explorer.features.veering import INVITATION, JOB, VeeringRequest
from beamviz.frequency_loci import loci
from beamviz.scene import Scene

FIRST = Scene(TIP)
EVENT = "B3 S1 1"  # the name of the crossing


@cache
def crossing(beam: Beam) -> Any:
    """The speed at which S1 crosses B3."""
    return pytest.approx(chart_of(beam).events[EVENT].at, rel=1e-6)


def chart_shown(guest: Visitor, beam: Beam) -> None:
    """Wait for the chart of a beam."""

    def places() -> list[float]:
        marks = guest.charts["loci-chart"].get("marks", [])
        return [mark["x"] for mark in marks if mark["key"] == EVENT]

    guest.wait(lambda _: places() == [crossing(beam)])


def test_moving_along_the_axis_sends_no_lines(guest, session):
    """Another mass moves the crossing; the speed only moves the line of the beam."""
    chart_shown(guest, TIP)
    guest.choose("alpha", 1.2)
    chart_shown(guest, TIP.replace(alpha=1.2))
    pause(guest)
    guest.charts["loci-chart"].pop("lines")
    guest.choose("gamma", 6.5)
    line = {"action": "gamma", "x": 6.5}
    guest.wait(lambda _: guest.charts["loci-chart"]["cursor"] == line)
    wait_until(lambda: not session.is_busy)
    catch_up(guest)
    assert "lines" not in guest.charts["loci-chart"]


def margins_shown(guest: Visitor) -> dict[str, list[str]]:
    """The table of margins: the cells of each mode."""
    rows = re.findall(r"<tr><td>(.*?)</td></tr>", guest.texts["loci-margins"])
    return {label: cells for label, *cells in (row.split("</td><td>") for row in rows)}


def test_the_margins_of_the_modes_to_the_lines_chosen(guest):
    """At the speed of the beam, as `loci` has them; there are none over another number."""
    pause(guest)
    guest.choose("per_rev_1", True)
    guest.choose("per_rev_4", True, until="Margins to per-rev lines at γ = 3")
    computed = loci(TIP, "gamma", np.array([0.0, 3.0]), per_rev=4)
    shown = margins_shown(guest)
    assert [*shown] == [margin.label for margin in computed.margins]
    for margin in computed.margins:
        cells = [float(cell.replace("−", "-")) for cell in shown[margin.label]]
        expected = [margin.percent[0], margin.percent[3]]
        assert cells == pytest.approx(expected, abs=0.05 + 0.005 * max(map(abs, expected)))
    guest.choose("gamma", 2.5, until="Margins to per-rev lines at γ = 2.5")
    guest.choose("over", "alpha")
    guest.wait(lambda _: not guest.texts["loci-margins"])


def test_the_tab_veering_magnifies_the_nearest_event(guest, session):
    """Nothing is computed while the tab is not open. Choosing an event moves the beam there; it is
    marked as long as the beam is at it."""
    chart_shown(guest, TIP)
    pause(guest)
    assert session.visitor.jobs[JOB].latest is None
    guest.do("tab", "veering", until="they cross at γ = 4.4641")
    guest.choose("gamma", 15.0, until="they cross at γ = 16.3")
    guest.do("go_to_event", EVENT)
    guest.shows(TIP.replace(gamma=chart_of(TIP).events[EVENT].at))
    guest.says("they cross at γ = 4.4641")
    guest.do("coriolis_percent", 100.0, until="at γ = 4.6502 (gap 0.241)")
    guest.do("coriolis_percent", 0.0, until="they cross at γ = 4.4641")
    guest.wait(lambda _: guest.charts["loci-chart"]["chosen"] == EVENT)
    guest.choose("alpha", 1.1)
    chart_shown(guest, TIP.replace(alpha=1.1))
    guest.wait(lambda _: guest.charts["loci-chart"]["chosen"] == "")
    guest.choose("over", "alpha")
    guest.wait(lambda _: guest.charts["loci-chart"]["x"]["label"] == "mass α")


def test_the_section_is_an_axis_where_both_planes_bend(guest):
    """Its numbers are offered there alone; in degrees, with a line at the beam."""
    pause(guest)
    assert "pitch" not in guest.texts["loci-over"]
    guest.edit(plane="both", flap=0.25, gamma=3.0)
    guest.choose("over", "pitch")
    chart = guest.charts["loci-chart"]
    guest.wait(lambda _: chart["x"]["label"] == "pitch [deg]" and "F1" in str(chart["lines"]))
    assert chart["cursor"] == {"action": "pitch", "x": 0}
    assert "pitch" in guest.texts["map-over"]
    guest.choose("plane", "flapwise")
    guest.wait(lambda _: chart["x"]["symbol"] == "γ" and guest.values["over"] == "gamma")
    assert "pitch" not in guest.texts["loci-over"]


def test_no_event_is_missing_while_it_is_computed(url, monkeypatch):
    """Its button is there immediately, the loci later."""
    release, pairs = threading.Event(), VeeringRequest.pairs
    monkeypatch.setattr(VeeringRequest, "pairs", lambda self: (release.wait(60), pairs(self))[1])
    with visitor(url) as guest:
        chart_shown(guest, TIP)
        guest.do("tab", "veering", until='data-set="go_to_event"')
        pause(guest)
        assert INVITATION not in guest.text
        release.set()
        guest.says("they cross at γ = 4.4641")


# The chart on the page

PLOT, LINE, READOUT, RESET = (
    f"document.querySelector('#loci-chart {part}')"
    for part in (".plot", "[role=slider]", ".readout", ".zoom button:last-child")
)
MARKS = "document.querySelectorAll('#loci-chart button.mark')"
FIELD = by_id("gamma-field")
RANGE = "[...document.querySelectorAll('#loci-chart .tick:not(.y)')].map(e => +e.textContent)"


@pytest.fixture
def desk(shown) -> Page:
    """A page 1440 pixels wide with its chart drawn, at the speed 3."""
    shown.resize(1440, 900)
    shown.wait(f"{MARKS}.length === 2")
    shown.box(PLOT, frames=40)
    set_speed(shown, 3.0)
    return shown


def set_speed(shown: Page, speed: float) -> None:
    """Set the speed, and wait for the line."""
    shown.send("gamma", speed, until=lambda: value(shown) == speed)


def value(shown: Page) -> float:
    """The value at the line of the beam."""
    return float(shown.evaluate(f"{LINE}.getAttribute('aria-valuenow')"))


def test_the_line_of_the_beam_is_dragged(desk):
    """It moves with the pointer, and the speed with it; the axis changes only after the drag. No
    value of a drag, which waits for its turn, comes after one that is sent later."""
    left, top, width, height = desk.box(PLOT)
    y = top + 0.3 * height
    desk.mouse("mousePressed", left + 0.4 * width, y, 1)
    desk.mouse("mouseMoved", left + 0.5 * width, y, 1)
    middle = value(desk)
    assert 8 < middle < 11
    wait_until(lambda: desk.number("gamma") == middle)
    desk.mouse("mouseMoved", left + width - 45, y, 1)
    wait_until(lambda: desk.number("gamma") > 18)
    desk.wait("beamviz.drawn['loci-chart'].x.range[1] > 30")
    assert desk.evaluate(f"Math.max(...{RANGE})") <= 20
    desk.mouse("mouseReleased", left + width - 45, y)
    desk.wait(f"Math.max(...{RANGE}) > 30")
    desk.evaluate("""[5, 6].forEach(speed => beamviz.sendOften('gamma', speed));
      beamviz.send('gamma', 3); new Promise(done => setTimeout(done, 500))""")
    desk.catch_up()
    assert desk.number("gamma") == 3.0
    desk.wait(f"Math.max(...{RANGE}) <= 20")


def test_the_line_and_the_crossings_have_names_and_work_by_keys(desk):
    """Arrows move the line, Page Up further, Home to the start of the axis. The marks are buttons
    in the order of Tab; one that is pressed or clicked moves the beam there."""

    def focused(name: str) -> str:
        return desk.evaluate(f"document.activeElement.getAttribute('{name}')")

    desk.evaluate(f"{LINE}.focus()")
    assert focused("aria-label") == "speed γ: line of this beam in the Campbell diagram"
    desk.key("ArrowRight", until=lambda: 3.0 < desk.number("gamma") == value(desk) < 3.2)
    step = desk.number("gamma") - 3.0
    desk.key("PageUp")
    wait_until(lambda: desk.number("gamma") == value(desk) == pytest.approx(3.0 + 11 * step))
    assert focused("aria-valuetext").startswith("γ = ")
    desk.key("ArrowLeft", modifiers=SHIFT)  # a finer step
    wait_until(lambda: desk.number("gamma") == value(desk) == pytest.approx(3.0 + 10.8 * step))
    desk.key("Home", until=lambda: desk.number("gamma") == 0)
    desk.key("Tab")
    assert focused("aria-label") == "Go to crossing of S1 and B3: γ = 4.4641, ω = 60.559"
    assert not desk.evaluate(f"{READOUT}.hidden")
    desk.key("Enter", until=lambda: desk.number("gamma") == crossing(TIP))
    set_speed(desk, 3.0)
    desk.click(f"{MARKS}[0]", until=lambda: desk.number("gamma") == crossing(TIP))
    desk.wait(f"{MARKS}[0].getAttribute('aria-pressed') === 'true'")


def test_values_are_read_at_the_pointer(desk):
    """Speed, all frequencies, and the gap from the nearest to the next; at a mark its text; none
    outside the axes."""
    left, top, width, height = desk.box(PLOT)
    desk.mouse("mouseMoved", left + 0.6 * width, top + 0.5 * height)
    lines = desk.wait(f"!{READOUT}.hidden && [...{READOUT}.children].map(e => e.textContent)")
    speed = float(lines[0].removeprefix("γ = "))
    found = dict(line.split("\u2002") for line in lines[1:-1])
    assert list(found) == ["B4", "B3", "S1", "B2", "B1"]
    expected = float(frequency_text(TIP.replace(gamma=speed), 3))
    assert float(found["B3"]) == pytest.approx(expected, rel=2e-3)
    gap = float(lines[-1].split("\u2002")[1])
    assert lines[-1].startswith(("gap B3–S1", "gap S1–B3"))
    assert gap == pytest.approx(float(found["B3"]) - float(found["S1"]), abs=0.02)
    desk.mouse("mouseMoved", *desk.middle(f"{MARKS}[0]"))
    desk.wait(f"{READOUT}.textContent.includes('click to go there')")
    desk.mouse("mouseMoved", left + 0.6 * width, top - 60)
    desk.wait(f"{READOUT}.hidden")


@pytest.mark.slow
def test_a_resonance_is_zoomed_in_on_each_time_that_it_is_chosen(desk):
    """That at γ = 0.798 with 2 per revolution, also after a drag of the line; and back."""
    desk.drag_along(PLOT, 0.3, 0.4)
    set_speed(desk, 3.0)
    desk.click("document.querySelector('[data-set=per_rev_2]')")
    mark = "document.querySelector('#loci-chart .mark.resonance[aria-label*=\"γ = 0.79\"]')"
    desk.wait(f"!!{mark}")
    for _ in range(3):
        desk.click("document.querySelector('#loci-resonances button')")
        wait_until(lambda: desk.number("gamma") == pytest.approx(0.79791, abs=1e-5))
        assert desk.evaluate(f"{FIELD}.scrollWidth <= {FIELD}.clientWidth")  # all its digits
        desk.wait(f"Math.max(...{RANGE}) < 2")
        left, top, width, height = desk.box(PLOT)
        x, y = desk.middle(mark)
        assert 0.3 < (x - left) / width < 0.7
        assert 0.2 < (y - top) / height < 0.8
        desk.click(RESET, until=f"Math.max(...{RANGE}) === 20")
    desk.click("document.querySelector('[data-set=per_rev_2]')", until=f"{MARKS}.length === 2")


@pytest.mark.slow
def test_on_a_phone_the_line_is_dragged_by_touch_and_a_crossing_is_tapped(desk):
    """A horizontal drag moves the line; a tap on a crossing moves the beam there."""
    desk.resize(390, 844)
    desk.wait(f"{MARKS}.length === 2")

    left, top, width, height = desk.box(PLOT, frames=40)
    y = top + 0.25 * height
    desk.swipe((left + 0.4 * width, y), (left + 0.64 * width, y))
    wait_until(lambda: 8 < desk.number("gamma") == pytest.approx(value(desk)))
    left, top, width, height = desk.box(f"{MARKS}[0]", frames=40)
    desk.touch("touchStart", (left + width / 2, top + height / 2))
    desk.touch("touchEnd")
    wait_until(lambda: desk.number("gamma") == crossing(TIP))
    assert desk.evaluate("document.documentElement.scrollWidth") <= 390
