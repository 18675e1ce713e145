"""What a new user does on the real page: reads a text, types a number, goes back, uses keys."""

import json
import threading

import numpy as np
import pytest
from helpers import slow
from live.browser import READY, SHIFT, Page, are_apart, by_id, page, says, tab
from live.server import held_back, wait_until
from live.visitor import PAPER

from beamviz.explorer import computed_loci
from beamviz.scene import Scene

FIRST = Scene(PAPER.replace(gamma=5)).changed(playing=False)  # a scene that moves takes time


@pytest.fixture
def desk(shown) -> Page:
    """The page of this file at its first scene, 1440 x 900."""
    shown.resize(1440, 900)
    shown.open_tab("frequencies")
    edits = ("lesson", ""), ("comparison", "nothing"), ("stacked", False), ("reset", None)
    for action, value in edits:
        shown.send(action, value)
    shown.catch_up()
    shown.wait("location.search === '' && document.getElementById('gamma-field').value === '5'")
    return shown


def box(shown: Page, element: str) -> dict[str, float]:
    return shown.evaluate(f"{element}.getBoundingClientRect().toJSON()")


def is_beside(text: dict[str, float], mark: dict[str, float], size: tuple[int, int]) -> bool:
    """Whether a text is on the page of this size, and at most a line away from its mark."""
    gap = max(text["top"] - mark["bottom"], mark["top"] - text["bottom"])
    inside = min(text["left"], text["top"]) >= 0
    inside = inside and text["right"] <= size[0] and text["bottom"] <= size[1]
    return inside and text["left"] <= mark["right"] and 0 <= gap <= 20


@pytest.mark.parametrize("size", [(1440, 900), *slow(((390, 844),))], ids=str)
def test_a_text_opens_beside_its_question_mark(desk, size):
    """All of it on the page, at most a line away, and not cut off by its table."""
    desk.resize(*size)
    for name in ("alpha-row", "mode-rows", "modes", "per-rev"):
        mark = f"document.querySelector('#{name} .hint')"
        desk.click(mark)
        text = f"{by_id(desk.evaluate(f'{mark}.getAttribute(`popovertarget`)'))}"
        desk.wait(f"{text}.matches(':popover-open') && {text}.style.top !== ''")
        wait_until(lambda text=text, mark=mark: is_beside(box(desk, text), box(desk, mark), size))
        assert desk.evaluate(f"{text}.scrollWidth <= {text}.clientWidth")
        desk.evaluate(f"{text}.hidePopover(), {text}.style.top = ''")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_name_of_a_chosen_mode_is_legible_under_the_pointer(desk, scheme):
    """Its letters have not the colour of what is behind them."""
    desk.send("dark", scheme == "dark")
    desk.wait(f"document.documentElement.dataset.theme === '{scheme}'")
    name = "document.querySelector('#mode-rows tr.shown button.mode')"
    desk.mouse("mouseMoved", *desk.middle(name))
    desk.wait(f"{name}.matches(':hover')")
    colours = desk.evaluate(f"""(e => [getComputedStyle(e).color,
      getComputedStyle(e).backgroundColor,
      getComputedStyle(e.closest('tr')).backgroundColor])({name})""")
    assert colours[1] == "rgba(0, 0, 0, 0)"
    light, dark = (
        [sum(map(int, c.removeprefix("rgb(").rstrip(")").split(","))) for c in colours[::2]]
        if scheme == "dark"
        else [sum(map(int, c.removeprefix("rgb(").rstrip(")").split(","))) for c in colours[::-2]]
    )
    assert light - dark > 450
    desk.send("dark", False)


def enter(shown: Page, text: str) -> None:
    """Type a text into the field of the mass."""
    field = by_id("alpha-field")
    shown.click(field)
    shown.evaluate(f"{field}.select()")
    shown.call("Input.insertText", text=text)
    shown.key("Enter")


def test_a_decimal_comma_is_a_decimal_comma(desk):
    """And what is no number, or could be thousands, is said and stays until it is corrected."""
    enter(desk, "0,5")
    desk.wait("location.search.includes('alpha=0.5')")
    for text, words in (("1,500", "write 1500, or 1.500"), ("heavy", "write a number")):
        enter(desk, text)
        desk.wait(says(words))
        assert desk.evaluate(f"{by_id('alpha-field')}.value") == text
        assert desk.evaluate(f"{by_id('alpha-field')}.hasAttribute('aria-invalid')")
        assert "alpha=0.5" in desk.evaluate("location.search")
    enter(desk, "2.5")
    desk.wait("location.search.includes('alpha=2.5')")


THICKNESS = "document.querySelector('[data-set=\"real.thickness\"]')"
LATER = 700  # [ms], longer than any control waits before it shows the value of the server
AFTER_LATER = f"new Promise(done => setTimeout(done, {LATER}))"


def select_thickness(desk):
    """Click the thickness of the steel beam, 5 mm, and select it."""
    desk.send("real.preset", "steel beam")
    desk.wait(f"{THICKNESS}?.value === '5'")
    desk.click(THICKNESS)
    desk.evaluate(f"{THICKNESS}.select()")


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("thickness", "400", "too thick for its length"),
        ("length", "0", "must be above 0"),
    ],
)
def test_a_bad_value_of_a_real_beam_stays_with_its_reason(desk, name, value, reason):
    """Beside its field; it is not taken back without a word."""
    select_thickness(desk)
    field = f"document.querySelector('[data-set=\"real.{name}\"]')"
    desk.click(field)
    desk.evaluate(f"{field}.select()")
    desk.call("Input.insertText", text=value)
    desk.key("Enter", until=f"{field}.closest('.field').innerText.includes('{reason}')")
    desk.evaluate(f"document.activeElement.blur(); {AFTER_LATER}")
    assert desk.evaluate(f"{field}.value") == value


def test_a_mass_that_is_too_large_stays_with_its_reason(desk):
    """500 kg on the steel beam of 1.2 kg; the status says what is allowed, in the same unit."""
    select_thickness(desk)
    enter(desk, "500")
    desk.wait(f"{by_id('equilibrium')}.innerText.includes('= 500: must lie in 0 .. 117.75')")
    desk.evaluate(f"document.activeElement.blur(); {AFTER_LATER}")
    assert desk.evaluate(f"{by_id('alpha-field')}.value") == "500"


def test_a_field_keeps_what_is_typed_until_it_is_entered(desk):
    """Also if it is typed at once after the click, and then slowly, while another edit fills its
    panel again."""
    select_thickness(desk)
    desk.call("Input.insertText", text="4")
    desk.send("real.width", 31)
    desk.wait("document.querySelector('[data-set=\"real.width\"]').value === '31'")
    desk.evaluate(AFTER_LATER)
    assert desk.evaluate(f"{THICKNESS}.value") == "4"
    desk.call("Input.insertText", text="2")
    desk.key("Enter", until="location.search.includes('second_moment=1.91')")  # 31 x 42^3 / 12
    assert desk.evaluate(f"{THICKNESS}.value") == "42"


@pytest.mark.slow
def test_a_bad_value_stays_with_its_reason_where_the_server_is_slow(desk):
    """The answer comes later than a control waits for it."""
    desk.send("real.preset", "steel beam")
    desk.wait(f"{THICKNESS}?.value === '5'")
    desk.evaluate(f"""window.direct = __viserMutable.sendMessage;
      __viserMutable.sendMessage = (message) => setTimeout(() => direct(message), {LATER})""")
    try:
        desk.click(THICKNESS)
        desk.evaluate(f"{THICKNESS}.select()")
        desk.call("Input.insertText", text="400")
        desk.key("Enter", until=f"{THICKNESS}.closest('.field').innerText.includes('too thick')")
        desk.wait(f"{THICKNESS}.value === '400'")
    finally:
        desk.evaluate("__viserMutable.sendMessage = direct")


def test_an_emptied_field_shows_the_number_of_the_beam(desk):
    """Not the value that was refused before, whose reason goes."""
    select_thickness(desk)
    desk.call("Input.insertText", text="400")
    desk.key("Enter", until=f"{THICKNESS}.closest('.field').innerText.includes('too thick')")
    desk.evaluate(f"{THICKNESS}.select()")
    desk.evaluate("document.execCommand('delete')")
    desk.key("Tab", until=f"{THICKNESS}.value === '5'")
    desk.wait(f"!{THICKNESS}.closest('.field').innerText.includes('too thick')")


@pytest.mark.parametrize("another", ["steel beam", "steel ruler"])
def test_a_text_that_is_no_number_stays_until_another_edit(desk, another):
    """Then the field shows the number of the beam, also where that is the one before."""
    select_thickness(desk)
    desk.call("Input.insertText", text="30 mm")
    desk.key("Tab", until=says("30 mm: write a number"))
    desk.evaluate(AFTER_LATER)
    assert desk.evaluate(f"{THICKNESS}.value") == "30 mm"
    desk.send("playing", False)
    assert desk.evaluate(f"{THICKNESS}.hasAttribute('aria-invalid')")
    desk.send("real.preset", another)
    desk.wait(f"{THICKNESS}.value === '{5 if another == 'steel beam' else 1}'")
    assert not desk.evaluate(f"{THICKNESS}.hasAttribute('aria-invalid')")


@pytest.mark.slow
def test_what_is_typed_while_the_units_change_is_not_read_in_the_new_ones(desk):
    """The field shows the speed in rpm, and what is typed then is taken."""
    speed = by_id("gamma-field")
    desk.click(speed)
    desk.evaluate(f"{speed}.select()")
    desk.call("Input.insertText", text="7")
    desk.send("real.preset", "steel beam")
    desk.wait(f"{speed}.value === '300'")
    desk.evaluate(f"{speed}.select()")
    desk.key("Enter")
    desk.evaluate(f"{speed}.blur()")
    desk.catch_up()
    assert desk.number("gamma") == 300
    desk.click(speed)
    desk.evaluate(f"{speed}.select()")
    desk.call("Input.insertText", text="400")
    desk.key("Enter", until="location.search.includes('rotation_speed=41.88')")


def test_a_chart_from_before_the_units_changed_moves_no_beam(desk, monkeypatch):
    """Its line is at another speed in rpm than in γ. The one after it moves the beam."""
    release = threading.Event()
    line = "document.querySelector('#loci-chart .operating')"
    desk.open_tab("frequencies")
    desk.wait(f"{line}.ariaValueNow === '5'")
    monkeypatch.setattr(computed_loci, "loci", held_back(computed_loci.loci, release))
    try:
        desk.send("real.preset", "steel beam")
        desk.wait(f"{by_id('gamma-field')}.value === '300' && {line}.ariaValueText.includes('γ')")
        desk.evaluate(f"{line}.focus()")
        desk.key("PageUp", until=f"{line}.ariaValueNow !== '5'")
        desk.catch_up()
        assert desk.number("gamma") == 300
    finally:
        release.set()
    desk.wait(f"{line}.ariaValueText === '300 rpm'")
    desk.key("PageUp")
    wait_until(lambda: desk.number("gamma") > 300)


@pytest.mark.slow
def test_a_button_works_before_the_first_chart_is_there(url, monkeypatch):
    """Though each chart is asked whether the button is that of one of its marks."""
    release = threading.Event()
    monkeypatch.setattr(computed_loci, "loci", held_back(computed_loci.loci, release))
    try:
        with page(url, 1440, 900) as fresh:
            fresh.wait(READY)
            for value in ("true", "false"):
                button = f"document.querySelector('[data-set=rotating_frame][data-value={value}]')"
                fresh.click(button, until=f"{button}.ariaPressed === 'true'")
            assert not fresh.evaluate("beamviz.drawn['loci-chart'].x")
            assert fresh.evaluate("document.querySelector('#loci-chart .zoom').hidden")
            assert fresh.problems == []
    finally:
        release.set()


@pytest.mark.parametrize("width", [1100, *slow(1280)])
def test_no_tab_is_behind_the_buttons_of_a_chart(desk, width):
    """Which are in their row, also while the chart is zoomed."""
    desk.resize(width, 720)
    desk.open_tab("frequencies")
    desk.wait("document.querySelectorAll('#loci-chart button.mark').length === 1")
    zoom = "document.querySelectorAll('#loci-chart .zoom button')"
    desk.click(f"{zoom}[1]", until=f"!{zoom}[2].hidden")
    end = desk.evaluate(f"{by_id('to-export')}.getBoundingClientRect().right")
    assert 0 < end <= desk.evaluate(f"{zoom}[0].getBoundingClientRect().left")
    between = desk.evaluate(f"""{by_id("enlarge")}.getBoundingClientRect().left
      - {zoom}[2].getBoundingClientRect().right""")
    assert between >= 0
    desk.click(f"{zoom}[2]", until=f"{zoom}[2].hidden")


@pytest.mark.parametrize(
    ("size", "name"),
    [
        ((390, 844), "veering"),
        *slow(((390, 844), "stiffening"), ((1280, 720), "veering"), ((940, 1080), "stiffening")),
    ],
    ids=str,
)
def test_a_guess_brings_what_to_look_for_into_view(desk, size, name):
    """Below what there is to do, in the lesson and in the page, as all answers were before; the
    next step begins at its top."""
    in_view = f"""(e => e.getBoundingClientRect().bottom
      <= Math.min({by_id("lesson")}.getBoundingClientRect().bottom, innerHeight) + 1)"""
    desk.resize(*size)
    desk.send("lesson", name, until=f"!!document.querySelector('.guesses') && {says('expect?')}")
    desk.wait(f"{in_view}(document.querySelector('.guesses button:last-child'))")
    desk.click("document.querySelector('.guesses button')", until=f"!!{by_id('try')}")
    desk.wait(f"{in_view}({by_id('try')})")
    desk.key("n", until="!!document.querySelector('#lesson .proof')")
    assert desk.evaluate(f"{by_id('lesson')}.scrollTop") == 0


def test_a_met_challenge_is_seen(desk):
    """In the lesson; on a phone, whose slider may be far from it, in the scene."""
    for size, shown in (((1280, 720), by_id("verdict")), ((390, 844), by_id("lesson-reading"))):
        desk.resize(*size)
        desk.send("lesson", "paradox", until=says("A theory that predicts"))
        desk.send("lesson_step", 2, until="!!document.querySelector('#verdict p')")
        desk.evaluate(f"{by_id('controls')}.scrollIntoView()")
        desk.send("gamma", 3.516, until="!!document.querySelector('#verdict .met')")
        desk.wait(f"{shown}.checkVisibility() && {shown}.innerText.includes('Right!')")
        ends = f"[{shown}, {by_id('dock')}].map(e => e.getBoundingClientRect())"
        desk.wait(f"""(([words, dock]) => words.top >= 0 && words.bottom <= innerHeight
          && (innerWidth < 500 || words.top > dock.top + 36))({ends})""")
        desk.send("lesson", "", until=f"{by_id('lesson')}.hidden")


@pytest.mark.parametrize(
    ("size", "name"),
    [((390, 844), "mode-shift"), *slow(((390, 844), "nodes"), ((940, 1080), "veering"))],
    ids=str,
)
def test_what_a_lesson_watches_is_in_view_beside_every_slider(desk, size, name):
    """The frequencies, and in the challenge its number, while any slider of the beam is dragged."""
    desk.resize(*size)
    desk.send("lesson", name, until=f"!!document.querySelector('.guesses') && {says('expect?')}")
    told = f"{by_id('lesson-reading')}"
    for step, words in ((0, "B3"), (2, "Now: ")):
        desk.send("lesson_step", step, until=f"{told}.innerText.includes('{words}')")
        for number in ("alpha", "beta", "gamma"):
            desk.box(by_id(f"{number}-slider"))
            seen = f"""(([words, slider, scene]) => words.top >= 0 && words.bottom <= scene.bottom
              && slider.top >= scene.bottom && slider.bottom <= innerHeight)
              ([{told}, {by_id(f"{number}-slider")}, {by_id("scene")}]
              .map(e => e.getBoundingClientRect()))"""
            desk.wait(seen)
    before = desk.evaluate(f"{told}.innerText")
    desk.send("alpha", 1.23, until=f"{told}.innerText !== {before!r}")


@pytest.mark.slow
def test_on_a_phone_a_lesson_is_beside_the_slider_that_it_names(desk):
    """What to look for and the slider are in view together; a chart that it names comes next to
    another lesson."""
    desk.resize(390, 844)
    desk.send("lesson", "stiffening", until=f"!!document.querySelector('.guesses') && {says('1.')}")
    desk.click("document.querySelector('.guesses button')", until=f"!!{by_id('try')}")
    desk.click(f"{by_id('try')}.querySelector('.link')")
    ends = f"""[{by_id("try")}.lastChild, {by_id("gamma-slider")}]
      .map(e => e.getBoundingClientRect())"""
    desk.wait(f"""(([look, slider]) => look.top > innerHeight / 2 && slider.bottom <= innerHeight
      && look.bottom < slider.top)({ends})""")
    desk.send("lesson", "crossing", until=says("Meeting without touching"))
    gap = f"""{by_id("loci-chart")}.getBoundingClientRect().bottom
      - {by_id("controls")}.getBoundingClientRect().top"""
    desk.wait(f"{gap} <= 0")


ROWS = """(() => {
  const { camera, canvas } = window.__viserMutable, r = canvas.getBoundingClientRect();
  const texts = [...document.querySelectorAll('#caption-layer > span:not([hidden])')];
  const clamps = [1, 2, 3, 4, 5].map(k => {
    const node = window.__viserMutable.nodeRefFromName[`/mode ${k}/rotor`];
    const at = node?.localToWorld(node.position.clone().set(0, 0, 0)).project(camera);
    return at && r.left + r.width * (1 + at.x) / 2; });
  return texts.length === 5 && clamps.every(Boolean)
    && [clamps, texts.map(e => e.getBoundingClientRect().toJSON())]; })()"""


@pytest.mark.slow
@pytest.mark.parametrize("size", [(390, 844), (1440, 900)], ids=str)
def test_the_titles_of_all_modes_are_beside_their_beams(desk, size):
    """None covers another, nor its beam, which begins at its clamp."""
    desk.resize(*size)
    desk.evaluate("scrollTo(0, 0)")
    desk.send("all_modes", True)

    def apart() -> bool:
        clamps, titles = desk.wait(ROWS)
        ends = [title["right"] for title in titles]
        beside = all(end < clamp for end, clamp in zip(ends, clamps, strict=True))
        return beside and are_apart(titles)

    wait_until(apart)


@pytest.mark.slow
def test_a_replaced_scene_is_offered_back(desk):
    """A stray N, which begins a lesson, or R takes nothing away: a button brings it back."""
    offered = f"!!{by_id('replaced')}.querySelector('button')"
    desk.send("alpha", 3.25, until=f"location.search.includes('alpha=3.25') && !({offered})")
    for key in ("n", "r"):
        desk.key(key, until=offered)
        assert desk.number("alpha") != 3.25
        desk.click(f"{by_id('replaced')}.querySelector('button')", until=f"!({offered})")
        wait_until(lambda: desk.number("alpha") == 3.25)
    desk.key("n", until=offered)
    desk.send("gamma", 1.0, until=f"!({offered})")  # it would undo this only


@pytest.mark.slow
def test_the_palette_opens_from_a_number_field(desk):
    """By Ctrl+K, as from everywhere else."""
    desk.click(by_id("gamma-field"))
    desk.key("k", modifiers=2, until="!!document.activeElement.closest('[role=dialog]')")
    desk.call("Input.insertText", text="mode 3")
    desk.wait(says("Show mode 3 alone"))
    shown = "[...document.querySelectorAll('#mode-rows tr.shown')].map(e => e.dataset.row).join()"
    desk.key("Enter", until=f"{shown} === 'B3'")


def test_a_mode_that_changes_its_place_is_told_and_its_row_moves(desk):
    """S1 and B3 as the mass at the tip becomes lighter."""
    for name, value in (("gamma", 0.0), ("beta", 1.0), ("alpha", 1.9)):
        desk.send(name, value)
    order = "[...document.querySelectorAll('#mode-rows [data-row]')].map(e => e.dataset.row).join()"
    desk.wait(f"{order} === 'B1,B2,S1,B3,B4'")
    desk.evaluate("""window.moved = []; Element.prototype.animate = (real => function (...given) {
      if (this.matches("#mode-rows [data-row]")) window.moved.push(this.dataset.row);
      return real.apply(this, given); })(Element.prototype.animate)""")
    desk.send("alpha", 1.0, until=f"{order} === 'B1,B2,B3,S1,B4'")
    desk.wait(f"{by_id('told')}.textContent === 'B3 is now 3rd, S1 is now 4th'")
    assert {*desk.evaluate("window.moved")} == {"B3", "S1"}


def test_back_and_forward_go_between_scenes(desk):
    """A lesson, and the scene before it."""
    desk.send("lesson", "nodes", until="location.search === '?lesson=nodes'")
    desk.send("beta", 0.3, until="location.search.includes('beta=0.3')")
    desk.evaluate("new Promise(done => setTimeout(done, 700))")  # the address is at rest
    desk.evaluate("history.back()")
    desk.wait("location.search === '' && document.getElementById('lesson').hidden")
    wait_until(lambda: desk.number("gamma") == 5)
    desk.evaluate("history.forward()")
    desk.wait(
        "location.search.includes('lesson=nodes') && !document.getElementById('lesson').hidden"
    )
    wait_until(lambda: desk.number("beta") == 0.3)
    desk.send("lesson", "", until="document.getElementById('lesson').hidden")
    desk.send("real.preset", "steel beam", until="location.search.includes('length=')")
    desk.evaluate("new Promise(done => setTimeout(done, 700))")
    desk.evaluate("history.back()")
    desk.wait("location.search === ''")  # that from before the lesson, not one of before an edit
    desk.wait("document.getElementById('units').innerText !== 'SI units'")  # and its scene
    desk.send("undo", until="location.search.includes('length=')")
    desk.send("undo", until="location.search === ''")


def test_on_half_of_a_screen_the_sliders_are_in_view(desk):
    """960 x 1080: mass, position and speed below the scene, without scrolling."""
    desk.resize(960, 1080)
    for name in ("alpha", "beta", "gamma"):
        desk.wait(f"{by_id(f'{name}-slider')}.getBoundingClientRect().bottom <= 1080")


@pytest.mark.parametrize("size", [(390, 844), *slow(((1024, 768),))], ids=str)
def test_a_tab_stays_at_its_place_when_it_is_opened(desk, size):
    """Beside the others, in full rows, its name not cut off, though it is bold then."""
    desk.resize(*size)
    every = "[...document.querySelectorAll('#dock [role=tab]:not([hidden])')]"
    places = f"(all => all.map(e => [e.offsetLeft, e.offsetTop - all[0].offsetTop]))({every})"
    before = desk.evaluate(places)
    for k in range(len(before)):
        desk.evaluate(f"{every}.forEach((e, k) => e.ariaSelected = k === {k})")  # as if opened
        assert np.abs(np.subtract(desk.evaluate(places), before)).max() <= 1, k
        wide = f"{every}.map(e => [e.scrollWidth, e.clientWidth])"
        assert all(inner <= outer for inner, outer in desk.evaluate(wide))
    rows = [top for _, top in before]
    counts = [rows.count(top) for top in sorted({*rows})]
    assert counts[:-1] == [counts[0]] * (len(counts) - 1)
    assert counts[-1] > 1
    desk.open_tab("frequencies")


def test_no_tab_scrolls_the_page(desk):
    """What has no room scrolls within its tab."""
    desk.resize(1280, 720)
    for name in desk.evaluate("[...document.querySelectorAll('#dock [role=tab]')].map(e => e.id)"):
        desk.open_tab(name.removeprefix("to-"))
        assert desk.evaluate("document.body.scrollHeight - innerHeight") <= 0, name
    desk.open_tab("frequencies")


@pytest.mark.slow
def test_the_mode_shift_by_keys_alone(url):
    """From the start: the skip link, the mass and its position by keys; S1 is third then."""
    with page(url, 1440, 900) as fresh:
        fresh.wait(f"{READY} && {says('1st stretching')}")
        fresh.key("Tab", until="document.activeElement.id === 'skip'")
        fresh.key("Enter", until="document.activeElement.id === 'alpha-slider'")
        for name, key, end, shift in (("beta", "End", 1.0, 0), ("alpha", "PageUp", 2.0, SHIFT)):
            for _ in range(6):  # a question mark and a field are between two sliders
                if fresh.evaluate("document.activeElement.id") == f"{name}-slider":
                    break
                fresh.key("Tab", modifiers=shift)
            assert fresh.evaluate("document.activeElement.id") == f"{name}-slider"
            while (before := fresh.number(name)) < end:
                fresh.key(key, until=lambda name=name, before=before: fresh.number(name) > before)
        order = "[...document.querySelectorAll('#mode-rows [data-row]')].map(e => e.dataset.row)"
        fresh.wait(f"{order}[2] === 'S1'")


OVER_THE_SCENE = "#transport button, #captions button, #captions > *"


def test_nothing_is_over_the_scene_without_a_text(desk):
    """No empty frame under the status, once the invitation is gone."""
    desk.send("gamma", 6.0, until="location.search.includes('gamma=6')")
    desk.wait(f"{by_id('scene-caption')}.innerText === ''")
    seen = f"[...document.querySelectorAll('{OVER_THE_SCENE}')].filter(e => e.checkVisibility()"
    seen += " && e.getBoundingClientRect().width > 0)"
    assert desk.evaluate(f"{seen}.length") > 2
    assert desk.evaluate(f"{seen}.filter(e => !(e.innerText.trim() || e.ariaLabel)).length") == 0


@pytest.mark.parametrize("size", [(1440, 900), *slow(((390, 844),), ((720, 450),))], ids=str)
def test_what_the_scene_cannot_show_is_said_in_it(desk, size):
    """Also with all modes on a phone, and at a large zoom."""
    desk.resize(*size)
    desk.send("all_modes", True)
    desk.send("alpha", 1e9, until=says("nearest values in range"))
    note = by_id("scene-caption")
    assert desk.evaluate(f"{note}.checkVisibility() && {note}.getBoundingClientRect().height > 10")


@pytest.mark.parametrize("size", [(1440, 900), *slow(((390, 844),))], ids=str)
def test_a_screen_reader_knows_a_region_before_its_first_text(desk, size):
    """A region that is not displayed while it is empty is told of too late."""
    desk.resize(*size)
    desk.send("gamma", 6.0, until="location.search.includes('gamma=6')")
    regions = "document.querySelectorAll('#captions > [role=status], #live')"
    shown = "(e => e.id !== 'lesson-reading' && getComputedStyle(e).display === 'none')"
    assert desk.evaluate(f"{regions}.length") >= 4
    assert desk.evaluate(f"[...{regions}].filter({shown}).map(e => e.id)") == []


@pytest.mark.parametrize("size", [(390, 844), *slow(((1440, 900),))], ids=str)
def test_no_caption_of_the_scene_is_over_a_control(desk, size):
    """Of two beams one above the other, of all modes in rows, and of one alone."""
    desk.resize(*size)
    texts = "[...document.querySelectorAll('#caption-layer span:not([hidden])')]"
    texts += ".filter(e => e.checkVisibility())"
    controls = (
        f"[...document.querySelectorAll('{OVER_THE_SCENE}')].filter(e => e.checkVisibility())"
    )
    boxes = "%s.map(e => e.getBoundingClientRect().toJSON())"

    def is_clear() -> bool:
        found, others = (desk.evaluate(boxes % one) for one in (texts, controls))
        return all(are_apart([one, other]) for one in found for other in others)

    edits = (("only", 1), ("all_modes", True), ("comparison", "mass"), ("stacked", True))
    for action, value in (*edits, ("all_modes", False)):
        desk.send(action, value)
        desk.catch_up()
        desk.wait(f"{texts}.length > 0")
        wait_until(is_clear, about=f": {action} = {value}")
    desk.send("stacked", False)


@pytest.mark.slow
def test_no_captions_cover_each_other_in_a_comparison(desk):
    """One beam above the other: their titles and the speed keep apart."""
    desk.click(tab("Compare"))
    for action, value in (("comparison", "mass"), ("stacked", True)):
        desk.send(action, value)
    texts = "[...document.querySelectorAll('#caption-layer span:not([hidden])')]"
    desk.wait(f"{texts}.length >= 2 && {texts}.some(e => e.textContent === 'this beam')")
    boxes = f"{texts}.map(e => e.getBoundingClientRect().toJSON())"
    wait_until(lambda: are_apart(desk.evaluate(boxes)))


@pytest.mark.parametrize("rotating", [True, *slow(False)])
def test_the_title_of_the_upper_beam_is_above_that_of_the_lower_one(desk, rotating):
    """From the side, and from the top, where the beams cover each other."""
    edits = ("rotating_frame", rotating), ("comparison", "mass"), ("stacked", True)
    for action, value in edits:
        desk.send(action, value)
    desk.send("reset_view")
    texts = "[...document.querySelectorAll('#caption-layer span:not([hidden])')]"
    upper, lower = (
        f"{texts}.find(e => e.textContent.startsWith('{title}')).getBoundingClientRect()"
        for title in ("twice the mass", "this beam")
    )
    between = f"[{lower}.top - {upper}.bottom]"
    desk.wait(between)  # the other beam is solved
    (from_side,) = desk.at_rest(lambda: desk.evaluate(between))
    left, top, width, height = desk.box("document.querySelector('#scene canvas')")
    x, y = left + 0.1 * width, top + 0.3 * height
    desk.drag((x, y), (x, y + 0.5 * height))

    def from_top() -> float | None:
        (gap,) = desk.at_rest(lambda: desk.evaluate(between))
        return gap if gap < from_side else None

    assert wait_until(from_top) > -1
    for action, value in (("stacked", False), ("comparison", "nothing"), ("reset_view", None)):
        desk.send(action, value)


@pytest.mark.slow
def test_a_tab_and_a_lesson_of_a_link_are_in_view_on_a_phone(url):
    """Below the scene; without one the page begins at its top."""
    height = f"{by_id('tab-veering')}.getBoundingClientRect().top"
    end = f"{by_id('lesson')}.getBoundingClientRect().bottom"
    expected = {
        "": "scrollY === 0",
        "?tab=veering": f"{height} < innerHeight - 160",
        "?lesson=buckling": f"!{by_id('lesson')}.hidden && {end} <= innerHeight + 1",
    }
    with page(url, 390, 844) as fresh:
        for query, shown in expected.items():
            fresh.call("Page.navigate", url=f"{url}/{query}")
            fresh.wait(f"location.search === '{query}' && {READY} && {says('1st bending')}")
            fresh.catch_up()
            fresh.wait(shown)


# The highest point [px] of the way of the tip around the hub, and the lowest of the invitation.
ABOVE_THE_TIP = """(() => {
  const { camera, canvas, nodeRefFromName } = __viserMutable, scene = nodeRefFromName["/scene"];
  const { top, height } = canvas.getBoundingClientRect();
  const heights = [...Array(360).keys()].map(degree => {
    const angle = degree * Math.PI / 180, tip = scene.position.clone();
    tip.set(Math.cos(angle), Math.sin(angle), 0).applyMatrix4(scene.matrixWorld).project(camera);
    return top + (1 - tip.y) / 2 * height; });
  const text = document.getElementById("scene-caption").getBoundingClientRect();
  return [Math.min(...heights), text.bottom]; })()"""
LETTERS = 22  # [px] a line of text, of which another font may need one more on a phone


SIZES = (1440, 900), (960, 1080), (390, 844)


@pytest.mark.slow
def test_the_beam_does_not_swing_behind_the_invitation(url):
    """In the stationary frame its tip passes below it, on every screen. The words of the invitation
    are one text, not a column for each of its parts."""
    with page(url, *SIZES[0]) as shown:
        shown.wait(f"{READY} && !!{by_id('scene-caption')}.querySelector('button')")
        shown.send("rotating_frame", False)
        for size in SIZES:
            shown.resize(*size)
            shown.catch_up()
            words = shown.evaluate("document.querySelector('#scene-caption > span').innerText")
            assert "A beam on a turning hub" in words
            assert "how does it vibrate, and what changes that?" in words
            tip, text = shown.at_rest(lambda: shown.evaluate(ABOVE_THE_TIP))
            assert text < tip + (LETTERS if size[0] < 500 else 0), size


@pytest.mark.parametrize("size", [(1440, 900), *slow(((390, 844),))], ids=str)
def test_the_menu_of_methods_has_a_visible_name(desk, size):
    """Beside it: its choices alone, as "auto", do not say what they are of."""
    desk.resize(*size)
    desk.evaluate(f"{by_id('model')}.closest('details').open = true")
    menu = "document.querySelector('select[data-set=method]')"
    desk.evaluate(f"{menu}.scrollIntoView()")
    name = f"{menu}.labels[0].firstChild"
    assert desk.evaluate(f"{name}.textContent.trim()") == "method"
    letters = f"(r => (r.selectNode({name}), r.getBoundingClientRect().toJSON()))(new Range())"
    text, field = desk.evaluate(letters), box(desk, menu)
    assert 0 < text["left"] < text["right"] <= field["left"]
    assert field["top"] <= text["top"] < text["bottom"] <= field["bottom"]


@pytest.mark.slow
def test_the_panel_of_a_real_beam_stays_open_or_closed(desk):
    """As the visitor has left it, whatever the beam is: of another size, of none, a blade."""
    panel = "[...document.querySelectorAll('#real-beam > details, #blade > details')][0]"
    desk.wait(f"{panel}.textContent.includes('dimensionless')")
    if not desk.evaluate(f"{panel}.open"):
        desk.click(f"{panel}.querySelector('summary')", until=f"{panel}.open")
    for key, name in (("real.preset", "steel beam"), ("blade.preset", "tapered-steel-blade")):
        desk.send(key, name, until=says("dimensionless"))
        desk.wait(f"document.getElementById('units').innerText === 'SI units' && {panel}.open")
        back = f"{panel}.querySelector('[data-do=dimensionless]')"
        desk.click(back, until="document.getElementById('units').innerText !== 'SI units'")
        desk.catch_up()
        assert desk.evaluate(f"{panel}.open")
    desk.click(f"[...{panel}.querySelectorAll('button')].find(e => e.innerText === 'steel beam')")
    desk.wait(f"{panel}.innerText.includes('density')")
    desk.click(f"{panel}.querySelector('summary')", until=f"!{panel}.open")
    speed = desk.number("gamma")
    desk.drag_along(by_id("gamma-slider"), 0.3, 0.6)
    desk.wait(f"Number({by_id('gamma-field')}.value) !== {speed}")
    desk.catch_up()
    assert not desk.evaluate(f"{panel}.open")


@pytest.mark.parametrize(("key", "modifiers"), [("y", 2), *slow(("Z", 2 + 8))])
def test_what_was_undone_is_redone_by_either_key(desk, key, modifiers):
    """Ctrl+Y, as in most programs of an office, or Ctrl+Shift+Z."""
    field = f"{by_id('gamma-field')}.value"
    desk.send("gamma", 8.0, until=f"{field} === '8'")
    desk.evaluate("document.activeElement?.blur()")
    desk.key("z", until=f"{field} === '5'", modifiers=2)
    desk.key(key, until=f"{field} === '8'", modifiers=modifiers)


@pytest.mark.slow
def test_what_a_field_has_sent_is_undone_from_it(desk):
    """By the key, with focus still in the field or list; what is being typed is left to the
    browser."""
    field, plane = by_id("gamma-field"), "document.querySelector('select[data-set=plane]')"
    desk.click(field)
    desk.evaluate(f"{field}.select()")
    desk.call("Input.insertText", text="8")
    desk.key("z", modifiers=2)
    desk.catch_up()
    assert desk.evaluate(f"{field}.value") == "8"
    desk.key("Enter", until="location.search.includes('gamma=8')")
    desk.key("z", until=f"{field} === document.activeElement && {field}.value === '5'", modifiers=2)
    before = desk.evaluate(f"{plane}.value")
    desk.evaluate(f"{plane}.focus()")
    desk.key("ArrowDown", until=f"{plane}.value !== '{before}' && location.search !== ''")
    desk.key("z", until=f"{plane}.value === '{before}' && location.search === ''", modifiers=2)


@pytest.mark.slow
def test_a_slider_keeps_its_place_until_a_slow_server_has_answered(desk):
    """No key is lost that is pressed between an edit and its answer."""
    with desk.slow_line():
        desk.evaluate(f"{by_id('gamma-slider')}.focus()")
        for _ in range(4):
            desk.key("ArrowRight")
            desk.evaluate("new Promise(done => setTimeout(done, 400))")
    desk.catch_up()
    assert desk.number("gamma") == pytest.approx(5.4)
    assert desk.evaluate(f"{by_id('gamma-slider')}.value") == "5.4"


@pytest.mark.slow
def test_the_text_at_the_pointer_has_the_frequencies_there(desk):
    """Between the points of the chart, too: as of two lines that are straight between their ends.
    Negative numbers of the axis have a true minus sign."""
    desk.open_tab("frequencies")
    desk.send("over", "delta", until="beamviz.drawn['loci-chart'].x?.symbol === 'δ'")
    desk.send("delta", -0.5, until="beamviz.drawn['loci-chart'].x.range[0] < 0")
    lines = [
        {"label": name, "at": [-0.5, 1.5], "y": [low, high], "runs": [[0, 1, "bending", name]]}
        for name, low, high in (("B1", 4.0, 8.0), ("B2", 20.0, 30.0))
    ]
    desk.evaluate(f"beamviz.apply({{charts: {{'loci-chart': {{lines: {json.dumps(lines)}}}}}}})")
    chart = by_id("loci-chart")
    left, top, width, height = desk.box(f"{chart}.querySelector('.plot')")
    desk.mouse("mouseMoved", left + 0.5 * width, top + 0.5 * height)
    text = desk.wait(f"{chart}.querySelector('.readout:not([hidden])')?.innerText")
    first, *told = text.replace("−", "-").splitlines()
    share = (float(first.split()[-1]) + 0.5) / 2
    assert 0.1 < share < 0.9
    found = dict(line.split()[:2] for line in told if line.startswith("B"))
    assert float(found["B1"]) == pytest.approx(4 + 4 * share, rel=0.01)
    assert float(found["B2"]) == pytest.approx(20 + 10 * share, rel=0.01)
    ticks = f"[...{chart}.querySelectorAll('text.tick')].map(e => e.textContent)"
    assert any(one.startswith("−") for one in desk.evaluate(ticks))


def test_a_checkbox_shows_what_the_server_says(desk):
    """Also where another control, or an undo, has changed it."""
    name = "document.querySelector('#controls input[type=checkbox][data-set]')"
    key, before = desk.evaluate(f"[{name}.dataset.set, {name}.checked]")
    for value in (not before, before):
        desk.send(key, value, until=f"{name}.checked === {str(value).lower()}")


def test_a_finger_scrolls_the_page_from_a_chart_too(desk):
    """Which takes only what moves along its axis; and the chart has room on a phone."""
    desk.resize(390, 844)
    plot = f"{by_id('loci-chart')}.querySelector('.plot')"
    desk.wait(f"{plot}.clientHeight >= 200")
    assert desk.evaluate(f"getComputedStyle({plot}).touchAction") == "pan-y"
    height = "document.querySelector('.chart').clientHeight"
    assert desk.evaluate(height) >= desk.evaluate(f"{plot}.clientHeight")


CROSSING = """(() => {
  const middle = (e) => { const r = e.getBoundingClientRect();
    return [(r.left + r.right) / 2, (r.top + r.bottom) / 2]; };
  const chart = document.getElementById('loci-chart');
  const mark = chart.querySelector('.events > .mark[aria-label*="S1 and B3"]');
  return mark && [middle(mark), ...[...chart.querySelectorAll('.ring')].map(middle)]; })()"""


def test_the_mark_of_a_crossing_is_at_the_rings_of_a_beam_there(desk):
    """S1 and B3 cross at gamma = 9.3733."""
    desk.open_tab("frequencies")
    desk.send("gamma", 9.3733, until=f"({CROSSING})?.length > 4")

    def apart() -> float:
        mark, *rings = desk.evaluate(CROSSING)
        return min(np.linalg.norm(np.subtract(mark, ring)) for ring in rings)

    wait_until(lambda: apart() < 1.5)  # [px]
