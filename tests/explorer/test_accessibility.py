"""The page for everyone: sizes, light and dark, keyboard, names; axe-core finds nothing serious."""

import re

import numpy as np
import pytest
from live.axe import load_axe, violations
from live.browser import READY, Page, are_apart, by_id, says, tab
from live.server import wait_until

from beamviz.beam import Beam
from beamviz.drawing.colours import linear
from beamviz.explorer.feature import tabs
from beamviz.explorer.links import PAGE
from beamviz.scene import Scene

FIRST = Scene(Beam(alpha=1, beta=0.5, gamma=5))
SIZES = [(1920, 1080), (1440, 900), (1024, 768), (820, 1180), (390, 844)]
PHONE, DESK = SIZES[-1], SIZES[1]
LETTERS, PLAY = by_id("letters"), by_id("play")
# Own elements that can be seen, without those that only screen readers find.
SEEN = """[...document.querySelectorAll('body *')].filter(e => e.checkVisibility()
  && !e.closest('#root, .hidden, svg, canvas') && e.getBoundingClientRect().width > 1)"""
# Controls without a ring around them, their label or their flag while they have the focus.
RINGLESS = f"""{SEEN}.concat(document.getElementById('scene-file')).filter(e => e.matches(
  'button, select, input, summary, [tabindex="0"]') && e.closest('%s') && !e.disabled
  && e.checkVisibility())
  .filter(e => {{ e.focus({{focusVisible: true, preventScroll: true}});
    return ![e, e.firstElementChild, ...(e.labels ?? [])].some(one => one
      && getComputedStyle(one).outlineStyle !== 'none'
      && parseFloat(getComputedStyle(one).outlineWidth) >= 2) }}).map(e => e.outerHTML)"""
SCENE = f"{by_id('scene')}.getBoundingClientRect()"
OPEN_ALL = "document.querySelectorAll('#controls details').forEach(e => e.open = true)"
LESSON_IN_VIEW = f"""(() => {{ const lesson = {by_id("lesson")}.getBoundingClientRect();
    return lesson.top > {SCENE}.bottom - 2 && lesson.top < innerHeight - 100; }})()"""
on_desk_and_phone = pytest.mark.parametrize("size", [DESK, PHONE], ids="{0[0]}x{0[1]}".format)


@pytest.fixture(scope="module")
def shown(shown) -> Page:
    """The page of this file, paused, with axe-core."""
    load_axe(shown)
    shown.send("playing", False)
    shown.catch_up()
    return shown


def prefer(shown: Page, scheme: str, motion: str = "no-preference") -> None:
    """Set preferences of the system, and wait for the theme."""
    wanted = {"prefers-color-scheme": scheme, "prefers-reduced-motion": motion}
    features = [{"name": name, "value": value} for name, value in wanted.items()]
    shown.call("Emulation.setEmulatedMedia", features=features)
    shown.wait(f"document.documentElement.dataset.theme === '{scheme}'")


OWN_LESSON = {  # actions that write one
    "own.keep": None,
    "own.say": "A beam.",
    "own.ask": "Is it stiff?",
    "own.answer.1": "yes",
    "own.answer.2": "no",
    "own.right": 0,
}


def leave_lesson(shown: Page) -> None:
    """Show the first scene again, paused."""
    for action, value in (("lesson", ""), ("reset", None), ("playing", False)):
        shown.send(action, value)
    shown.catch_up()
    shown.wait(f"!location.search.includes('lesson') && {PLAY}.ariaPressed === 'false'")


@pytest.mark.parametrize("size", [*SIZES, (1366, 768), (1280, 720), (720, 450)], ids=str)
def test_the_scene_has_half_of_the_page(shown, size):
    """At every size, or nearly where chart and sliders are beside it on a page of 1024 pixels, with
    nothing cut off at the sides; on wide pages the complete chart is beside it, on narrow ones
    panels scroll below it; at 1440x900 and 200 % zoom it too scrolls away."""
    shown.resize(*size)
    shown.open_tab("frequencies")
    shown.evaluate("scrollTo(0, 0)")
    left, top, width, height = shown.evaluate(f"(r => [r.x, r.y, r.width, r.height])({SCENE})")
    assert (
        min(height, size[1] - top) * width >= (0.5 if size[0] != 1024 else 0.44) * size[0] * size[1]
    )
    shown.wait(f"document.documentElement.scrollWidth <= {size[0]}")
    canvas = "document.querySelector('canvas[data-engine]').getBoundingClientRect()"
    wait_until(lambda: shown.evaluate(f"{canvas}.width") == pytest.approx(width, abs=2))
    bottom = "document.querySelector('#loci-chart .plot').getBoundingClientRect().bottom"
    if size[0] >= 960:
        shown.wait(f"{bottom} <= {size[1]}")
        return
    assert (left, width) == (0, size[0])
    stays = 0 if size[1] >= 500 else top - 300
    shown.wait(f"(scrollTo(0, 300), {SCENE}.top === {stays})")
    boxes = "[...document.querySelectorAll('#dock, #controls')].map(e => e.getBoundingClientRect())"
    end = f"{boxes}.every(box => box.bottom <= innerHeight + 1)"
    shown.wait(f"(scrollTo(0, 9999), {end})")  # again while results come, which move the end


def test_no_tab_and_no_table_is_cut_off(shown):
    """All tabs are in the window of a phone, the per-rev buttons in one row, and the controls of a
    chart, however wide its lists; on a wide page these fit their tables, also with a lesson."""
    shown.resize(*PHONE)
    shown.open_tab("frequencies")
    tabs = "[...document.querySelectorAll('#dock [role=tab]')]"
    shown.wait(f"{tabs}.every(e => e.getBoundingClientRect().right <= {PHONE[0]})")
    tops = "[...document.querySelectorAll('#per-rev button.toggle')].map(e => e.offsetTop)"
    shown.wait(f"(tops => tops[0] > 0 && tops.every(top => top === tops[0]))({tops})")
    shown.open_tab("methods")
    timings, right = by_id("timings"), "getBoundingClientRect().right"
    offered = f"{timings}.innerText.includes('Time all methods')"  # it stays as it is then
    wide = f"{timings}.innerHTML = '<table><td><div style=width:375px>a</div></table>'"
    shown.wait(offered)
    shown.evaluate(wide)
    column = f"{timings}.closest('.beside')"
    assert shown.evaluate(f"{column}.firstChild.{right}") < PHONE[0] - 8
    shown.resize(*DESK)
    shown.send("lesson", "nodes")
    shown.wait(f"location.search.includes('lesson=nodes') && !{by_id('lesson')}.hidden")
    shown.open_tab("methods")
    shown.wait(offered)
    shown.evaluate(wide)
    assert shown.evaluate(f"{timings}.firstChild.{right} <= {column}.{right}")
    leave_lesson(shown)


BOX = "(({left, right, top, bottom}) => ({left, right, top, bottom}))(e.getBoundingClientRect())"


@pytest.mark.parametrize("size", [(1112, 834), (1180, 820), (1366, 1024)], ids=str)
def test_on_a_tablet_no_button_beside_the_tabs_covers_another(shown, size):
    """The last tab, in view, the buttons that zoom, which are wider than for a mouse, and the one
    that enlarges; all are in the row of the tabs."""
    shown.resize(*size, touch=True)
    shown.open_tab("frequencies")
    shown.wait("!!beamviz.drawn['loci-chart'].x")
    shown.evaluate("document.querySelector('#loci-chart [aria-label=\"Zoom in\"]').click()")
    buttons = "#to-export, #loci-chart .zoom button, #enlarge"
    seen = f"[...document.querySelectorAll('{buttons}')].filter(e => e.checkVisibility())"
    shown.wait(f"{seen}.length === 5")
    shown.evaluate(f"{by_id('to-export')}.scrollIntoView({{block: 'nearest', inline: 'nearest'}})")
    boxes = shown.evaluate(f"{seen}.map(e => {BOX})")
    row = shown.evaluate(f"(e => {BOX})(document.querySelector('#dock > [role=tablist]'))")
    assert are_apart(boxes)
    assert all(row["top"] <= one["top"] and one["bottom"] <= row["bottom"] for one in boxes)
    shown.evaluate("document.querySelector('#loci-chart [aria-label^=\"Show the\"]').click()")


@on_desk_and_phone
def test_the_buttons_of_a_table_are_beside_its_first_column(shown, size):
    """Also when a table is scrolled, with buttons for a finger."""
    shown.resize(*size)
    shown.send("blade.preset", "nrel-5mw-blade")
    shown.wait("!!document.querySelector('.cells td input')")
    shown.evaluate("document.querySelector('.cells').scrollLeft = 60")
    row = "[...document.querySelector('.cells tbody tr:nth-child(2)').children].slice(0, 2)"
    assert are_apart(shown.evaluate(f"{row}.map(e => {BOX})"))
    shown.send("dimensionless")
    leave_lesson(shown)


def contrast(colours: list[str]) -> float:
    """The contrast of two opaque colours, rgb(...), by WCAG 2."""
    channels = np.array([re.findall(r"\d+", one)[:3] for one in colours], float)
    luminance = linear(channels) @ [0.2126, 0.7152, 0.0722]
    return (luminance.max() + 0.05) / (luminance.min() + 0.05)


def test_a_name_in_a_lesson_leads_to_the_control_not_to_a_button_that_sets_one_value(shown):
    """To the slider of the speed, though the table of a run-up has buttons that go to a speed. None
    of these is a switch, as the speed shown has fewer digits than theirs."""
    shown.resize(*DESK)
    shown.send("force_per_rev", "3")
    shown.open_tab("run-up")
    shown.wait("!!document.querySelector('#run-up-list td button')")
    assert shown.evaluate("document.querySelector('#run-up-list td button').ariaPressed") is None
    shown.open_tab("compare")
    shown.evaluate("beamviz.apply({point: ['gamma']})")
    shown.wait(f"{by_id('gamma-row')}.matches('.pulse')")
    assert shown.evaluate(f"{tab('Compare')}.ariaSelected") == "true"
    leave_lesson(shown)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_sign_of_the_event_at_the_beam_is_seen(shown, scheme):
    """On its own ground, which axe-core does not look at."""
    shown.resize(*DESK)
    prefer(shown, scheme)
    shown.open_tab("frequencies")
    chosen = "document.querySelector('#loci-chart .mark[aria-pressed=true]')"
    key = shown.wait("beamviz.drawn['loci-chart'].marks?.[0]?.key")
    shown.send("go_to_event", key, until=f"!!{chosen}")
    style = f"getComputedStyle({chosen}, '::before')"
    assert contrast(shown.evaluate(f"[{style}.color, {style}.backgroundColor]")) > 4.5
    leave_lesson(shown)


@on_desk_and_phone
def test_letters_and_targets_are_large_enough(shown, size):
    """14 px at least; targets of 24 px, of 44 px on a touch screen; also in tables of results."""
    shown.resize(*size)
    shown.send("comparison", "mass")
    shown.send("per_rev_2", True)
    shown.wait("document.querySelectorAll(':is(#comparison, #loci-resonances) table').length === 2")
    least = 44 if size == PHONE else 24
    for name in tabs(PAGE):
        shown.open_tab(name)
        small = f"""{SEEN}.filter(e => parseFloat(getComputedStyle(e).fontSize) < 13.99
          && [...e.childNodes].some(n => n.nodeType === 3 && n.data.trim()))"""
        narrow = f"""{SEEN}.filter(e => e.matches('button, select, input, summary')
          && !e.closest('table .hint, label, .mark')).filter(e => {{
            const r = e.getBoundingClientRect(); return Math.min(r.width, r.height) < {least - 0.5}
          }})"""
        for found in (small, narrow):
            assert shown.evaluate(f"{found}.map(e => e.outerHTML.slice(0, 120))") == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("size", "scheme"),
    [(DESK, "light"), (PHONE, "dark")],
    ids=str,
)
def test_axe_finds_nothing_serious_and_the_focus_is_seen(shown, size, scheme):
    """On the start page, in every tab, in the help, in two lessons at their first step, whose text
    is in view, below the scene, though the controls that it names are further down, and in a lesson
    of the visitor's own."""
    shown.resize(*size)
    prefer(shown, scheme, "reduce")  # no colour depends on the moment of an animation
    for action, value in OWN_LESSON.items():
        shown.send(action, value)
    shown.wait(f"!!{by_id('own-answer-2')}")
    shown.evaluate(OPEN_ALL)
    for name in tabs(PAGE):
        shown.open_tab(name)
        part = "html" if name == "frequencies" else f"#tab-{name}"
        assert violations(shown, part) == []
        assert shown.evaluate(RINGLESS % part) == []
    shown.evaluate(f"{by_id('help')}.showModal()")
    assert violations(shown, "#help") == []
    shown.evaluate(f"{by_id('help')}.close()")
    for name in ("veering", "nodes"):
        shown.send("lesson", name)
        shown.wait(f"location.search.includes('lesson={name}') && {LESSON_IN_VIEW}")
        assert violations(shown) == []
    shown.send("own.go", 0)
    shown.send("own.answer", 0)
    shown.wait(f"{by_id('own-step')}?.innerText.includes('Right!')")
    assert violations(shown, "#lesson") == []
    shown.send("own.remove")
    leave_lesson(shown)


@pytest.mark.slow
def test_every_control_is_reached_by_keyboard(shown):
    """Tab goes through all of them; an arrow key moves a slider."""
    shown.resize(*DESK)
    shown.evaluate(f"{OPEN_ALL}; document.activeElement.blur(); document.body.focus()")
    count = shown.evaluate(f"""(all => (all.forEach(e => e.dataset.unseen = ''), all.length))({SEEN}
      .filter(e => e.matches('button:not([role=tab], :disabled), select, input, summary')))""")
    assert count > 40
    for _ in range(2 * count):
        shown.key("Tab")
        shown.evaluate("delete document.activeElement.dataset.unseen")
    left = "[...document.querySelectorAll('[data-unseen]')].map(e => e.outerHTML.slice(0, 120))"
    assert shown.evaluate(left) == []
    shown.evaluate(f"{by_id('gamma-slider')}.focus()")
    shown.key("ArrowRight")
    shown.wait(f"{by_id('gamma-slider')}.getAttribute('aria-valuetext') === '5.1'")
    shown.wait(f"{by_id('gamma-field')}.value === '5.1'")


def test_arrow_keys_change_the_tab(shown):
    """Right, and left around the end; only the chosen tab has a tab stop."""
    shown.resize(*DESK)
    shown.click(tab("Frequencies"))
    shown.key("ArrowLeft")
    shown.wait(f"document.activeElement.id === 'to-export' && !{by_id('tab-export')}.hidden")
    shown.key("ArrowRight", until="document.activeElement.id === 'to-frequencies'")
    stops = "[...document.querySelectorAll('#dock [role=tab]')].filter(e => e.tabIndex === 0)"
    assert shown.evaluate(f"{stops}.map(e => e.id)") == ["to-frequencies"]


def test_letters_do_not_move_the_camera_and_can_be_switched_off(shown):
    """W and A do nothing; P plays and pauses, but not when single-letter keys are off."""
    camera = "Object.values(window.__viserMutable.camera.position).map(x => x.toFixed(6)).join()"
    shown.evaluate("document.activeElement.blur()")

    def at_rest() -> str | None:
        before = shown.evaluate(camera)
        shown.next_frame(20)
        return before if shown.evaluate(camera) == before else None

    before = wait_until(at_rest)
    for letter in "waqe":
        shown.key(letter, frames=5)
    assert shown.evaluate(camera) == before
    shown.key("p", until=f"{PLAY}.ariaPressed === 'true'")
    shown.evaluate(f"{LETTERS}.click()")
    shown.key("p")
    shown.catch_up()
    assert shown.evaluate(f"{PLAY}.ariaPressed") == "true"
    shown.evaluate(f"{LETTERS}.click()")
    shown.key("p", until=f"{PLAY}.ariaPressed === 'false'")


def test_every_slider_has_a_name_and_a_spoken_value_and_viser_shows_no_controls(shown):
    """No address field, no developer settings, no scene tree, no notice over the scene."""
    sliders = "[...document.querySelectorAll('input[type=range]')]"
    unnamed = "!(e.labels.length || e.ariaLabel) || !e.getAttribute('aria-valuetext')"
    assert shown.evaluate(f"{sliders}.filter(e => {unnamed}).map(e => e.id)") == []
    for words in ("Dev Settings", "Scene tree", "ws://", "Software WebGL", "Connected"):
        assert not shown.evaluate(says(words))
    assert shown.evaluate("document.title") == "beamviz"


@pytest.mark.slow
def test_a_page_starts_paused_with_reduced_motion(url, shown):
    """The last test, as it opens the page anew."""
    prefer(shown, "dark", "reduce")
    shown.call("Page.navigate", url=url)
    shown.wait(f"{READY} && {says('1st bending')}")
    shown.catch_up()
    shown.wait(f"{PLAY}.ariaPressed === 'false'")
    shown.wait("document.documentElement.dataset.theme === 'dark'")
