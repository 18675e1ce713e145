"""What visitors come for, from the page as it opens: each job in one to four clicks, each on an
element that is seen."""

import contextlib
import json

import numpy as np
import pytest
from live.browser import Page, button, by_id, page, says, tab
from live.server import wait_until
from live.visitor import frequency_text
from PIL import Image

from beamviz.beam import Beam
from beamviz.drawing.text import five_digits, rounded_to_error
from beamviz.explorer import explorer
from beamviz.explorer.features.real_beam import RPM, STEEL_BEAM
from beamviz.scene import START
from beamviz.solver import solve

FIRST = START

STEEL = Beam.from_si(**STEEL_BEAM.values | {"length": 1.2, "rotation_speed": 600 * RPM})
HERTZ = STEEL.units.hertz(solve(STEEL).frequencies[:3])
BEAM = "window.__viserMutable.nodeRefFromName['/scene/rotor/beam']"
ROWS = "document.querySelectorAll('#comparison tbody tr').length"
SEEN = """(e => { if (!e) return false; const r = e.getBoundingClientRect();
  const at = (x, y) => e.contains(document.elementFromPoint(x, y));
  return at(r.left + r.width / 2, r.top + r.height / 2)
    && at(r.left + 4, r.top + 4) && at(r.right - 4, r.bottom - 4); })"""
REAL = "document.querySelector('[data-set=\"real.%s\"]')"
SHAPES = "[...document.querySelectorAll('.shapes td')]"
RESONANCES = "[...document.querySelectorAll('#loci-chart .mark.resonance')]"
LEFT_OVER = "#comparison table, #loci-chart .mark.resonance"
CLOSE = "for (const e of document.querySelectorAll('#real-beam details')) e.open = false"
# The elements to click (for a field, with the text to type), and what is true at the end.
JOBS = {
    "shift of the modes from alpha 1 to 2": (
        [tab("Compare"), button("twice the mass")],
        f"{ROWS} >= 5 && {says('twice the mass')} && {says('%')}",
    ),
    "veering with Coriolis forces, shapes in view": (
        ["document.querySelector('#status [data-set=coriolis]')", button("veering")],
        f"{SHAPES}.length === 6 && {SHAPES}.every({SEEN}) && {says('mixed')}",
    ),
    "steel beam 1.2 m x 30 mm x 5 mm at 600 rpm, in Hz": (
        [button("Real beam…"), button("steel beam"), (REAL % "length", "1200"),
         (by_id("gamma-field"), "600")],
        " && ".join(says(five_digits(one, 0)) for one in HERTZ),
    ),
    "resonances with 2 per revolution in the chart": (
        [button("2 ×")],
        f"{SEEN}({RESONANCES}[0]) || {RESONANCES}.length >= 2",
    ),
    "elements of the paper against the converged frequencies": (
        [tab("Compare"), button("20 ANCF elements (paper)")],
        f"{ROWS} >= 5 && {says('20 ANCF elements')} && {says('+0.')}",
    ),
}  # fmt: skip


@pytest.fixture
def opened(shown) -> Page:
    """The page as it opens: the first scene, without a query, the first tab, and no focus."""
    for action, value in (("reset", None), ("comparison", "nothing"), ("playing", True)):
        shown.send(action, value)
    shown.open_tab("frequencies")
    shown.catch_up()
    shown.evaluate("document.activeElement.blur()")
    shown.evaluate(CLOSE)
    shown.wait(f"location.search === '' && !document.querySelector('{LEFT_OVER}')")
    return shown


SHOWN = "[...document.querySelectorAll('#mode-rows tr.shown')].map(e => e.dataset.row)"


def row(label: str) -> str:
    """The button that shows a mode alone."""
    return f"document.querySelector('#mode-rows [data-row={label}] button')"


def click(shown: Page, element: str) -> None:
    """Click in the middle of an element, which must be visible without scrolling."""
    middle = "(r => [r.left + r.width / 2, r.top + r.height / 2])(e.getBoundingClientRect())"
    shown.click_at(*shown.wait(f"(e => {SEEN}(e) && {middle})({element})"))


@pytest.mark.parametrize(("clicks", "result"), JOBS.values(), ids=list(JOBS))
def test_a_job_takes_few_clicks(opened, clicks, result):
    """Without a look at the documentation."""
    for one in clicks:
        element, text = (one, "") if isinstance(one, str) else one
        click(opened, element)
        if text:
            opened.evaluate("document.activeElement.select()")
            opened.call("Input.insertText", text=text)
            opened.key("Enter")
    opened.wait(result)
    assert opened.problems == []


EVENT = "document.querySelector('#veering-events [data-set=go_to_event]')"
PLACES = f"""(found => {{
  {BEAM}.traverse(node => {{ found.push(...node.matricesTexture?._data ?? []); }});
  return found.join(); }})([])"""


def test_a_veering_is_seen_with_its_two_modes_in_three_clicks(opened):
    """Coriolis forces, the tab, the event: S1 and B3 are chosen, and move in the scene."""
    click(opened, "document.querySelector('#status [data-set=coriolis]')")
    click(opened, button("veering"))
    opened.wait(f"{SHAPES}.length === 6")
    click(opened, EVENT)
    opened.wait(f"{SHOWN}.sort().join() === 'B3,S1'")
    opened.wait("location.search.includes('coriolis=true')")
    before = opened.evaluate(PLACES)
    opened.wait(f"{PLACES} !== {json.dumps(before)}")
    opened.send("coriolis", False)


def test_a_picture_is_saved_in_two_clicks(opened, tmp_path):
    """A PNG of the size of the scene, with its captions; the scene itself is not drawn here."""
    opened.call("Page.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
    opened.wait("!!document.querySelector('#caption-layer span')")
    click(opened, tab("Export"))
    click(opened, button("Picture (PNG)"))
    file = tmp_path / "beam.png"
    wait_until(file.exists)
    canvas = "__viserMutable.canvas"
    with Image.open(file) as saved:
        ratio = opened.evaluate(f"{canvas}.width / {canvas}.height")  # viser draws fewer when slow
        assert saved.width / saved.height == pytest.approx(ratio, rel=0.01)
        dark, light = np.quantile(saved.convert("L"), [0, 0.5])
    assert dark < 100 < 200 < light


def test_modes_are_shown_by_a_click_a_drag_or_a_command(opened):
    """One alone by its row, then the amount of another. Ctrl+K opens the list of commands, also
    from a slider; after it is closed the pointer works as before."""
    for focus in ("document.body", by_id("share-2"), "document.body"):
        click(opened, row("B2"))
        opened.wait(f"{SHOWN}.join() === 'B2'")
        opened.drag_along(by_id("share-2"), 0.1, 0.7)
        opened.wait(f"{SHOWN}.join() === 'B2,B3'")
        opened.evaluate(f"{focus}.focus()")
        opened.key("k", modifiers=2, until="!!document.activeElement.closest('[role=dialog]')")
        opened.call("Input.insertText", text="mode 3")
        opened.wait(says("Show mode 3 alone"))
        opened.key("Enter", until=f"{SHOWN}.join() === 'B3'")


@pytest.mark.slow
def test_all_digits_and_their_errors_are_shown_by_a_switch(opened):
    """It is kept for the next visit; the controls below the table stay at their places."""
    rows, top = "document.querySelector('#mode-rows').innerText", f"{by_id('beam')}.offsetTop"
    found = solve(START.beam, **START.solver_options)
    accurate = rounded_to_error(found.frequencies[0], found.errors[0])
    few = five_digits(found.frequencies[0], found.errors[0])
    opened.wait(f"{rows}.includes('{few}') && !{rows}.includes('{accurate}')")
    before = opened.evaluate(top)
    assert "±" not in opened.evaluate(rows)
    click(opened, by_id("digits"))
    opened.wait(f"{rows}.includes('{accurate}') && {rows}.includes('±')")
    assert opened.evaluate(top) == before
    opened.reload()
    opened.wait(f"{by_id('digits')}?.ariaPressed === 'true' && {rows}.includes('{accurate}')")
    click(opened, by_id("digits"))
    opened.wait(f"!{rows}.includes('±')")


@pytest.mark.slow
def test_a_lost_connection_is_shown_and_restored():
    """The scene stays visible; a server that starts again shows the visitor's choices."""
    offline, beam = by_id("offline"), START.beam.replace(gamma=7.5)
    lost, frequency = f"{offline}.open", frequency_text(beam, **START.solver_options)
    chosen = f"{by_id('mode-rows')}.innerText.includes('{frequency}')"
    with contextlib.ExitStack() as first:
        url = first.enter_context(explorer(START))
        with page(url, 1440, 900) as shown:
            shown.wait(f"{says('S1')} && !{lost}")
            shown.send("gamma", 7.5, until=f"location.search.includes('gamma=7.5') && {chosen}")
            first.close()
            shown.wait(f"{lost} && {SEEN}({offline})")
            assert "No connection" in shown.evaluate(f"{offline}.innerText")
            assert shown.evaluate(f"{says('S1')} && !!{BEAM}")
            shown.evaluate("document.querySelector('#mode-rows tr').dataset.former = ''")
            with explorer(START, port=int(url.rstrip("/").rpartition(":")[2])):
                restored = f"{chosen} && !document.querySelector('[data-former]')"
                shown.wait(f"!{lost} && !!{BEAM} && {restored}")
                click(shown, row("B2"))
                shown.wait(f"{SHOWN}.join() === 'B2'")
                assert shown.evaluate(f"{by_id('gamma-field')}.value") == "7.5"
