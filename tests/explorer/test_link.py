"""Links: a page opens on the scene of its address, and the address follows the scene."""

import contextlib
import re
from urllib.parse import parse_qsl

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from live.browser import by_id, page, says
from live.server import wait_until
from live.visitor import PAPER, Visitor, catch_up, visitor

from beamviz.beam import Beam
from beamviz.errors import InvalidInput
from beamviz.explorer.features.real_beam import STEEL_BEAM
from beamviz.explorer.links import linked, parse_link, query_of
from beamviz.explorer.state import State
from beamviz.lessons import lesson
from beamviz.scene import Scene

NODES = lesson("nodes").scene
RESPONSE = {"stacked": True, "force_per_rev": 2, "damping": 0.05, "forced_response": True}


@pytest.mark.parametrize(
    ("query", "found"),
    [
        *(("", None), ("fixedDpr=1&token=abc", None)),
        ("lesson=nodes&gamma=2", (NODES.changed(gamma=2), {"lesson": "nodes"})),
        ("lesson=nodes&step=3&tab=map", (NODES, {"lesson": "nodes", "step": 2, "tab": "map"})),
        ("method=linear&elements=200", (Scene.of(method="linear", elements=200), {})),
        ("plane=both&pitch=30", (Scene.of(plane="both", pitch=30), {})),
        ("gamma=3&compare=coriolis", (Scene.of(gamma=3), {"comparison": "coriolis"})),
        ("stacked=true&force=2&damping=0.05&response=true", (Scene(), RESPONSE)),
    ],
)
def test_a_link_is_parsed(query, found):
    """Lessons by name, scenes by their keys; parameters with other readers are ignored."""
    assert parse_link(query) == (found and (*found, ()))


@pytest.mark.parametrize(
    ("query", "errors"),
    [
        ("lesson=magic", ["must be one of stiffening"]),
        ("alpha=1%0Abeta=3", ["alpha = "]),  # a line end does not begin another key
        ("compare=all", ["compare = 'all': must be one of earlier, ancf, coriolis"]),
        ("tab=charts", ["tab = 'charts': must be one of frequencies, map, veering"]),
        ("force=7", ["force = 7: must be a whole number in 1 .. 6"]),
        ("damping=1", ["damping = 1: must lie in 0.001 .. 0.2"]),
        ("length=1", ["the link: missing key 'density'"]),
        ("alpha=-1&beta=3", ["alpha = -1: must lie in 0 .. 100", "beta = 3: must lie in 0 .. 1"]),
        ("colour=1&lenght=1", ["'colour': did you mean 'colouring'", "did you mean 'length'"]),
        ("shares=[2,0.5,-3,a]", ["shares = '"]),  # which is no list of TOML
        ("shares=[2,0.5,-3]", ["shares = 2, -3: must lie in 0 .. 1"]),
        ("position=[2e3,0,-3e3]", ["position = 2000, -3000: must lie in -1000 .. 1000"]),
        ("foo=1", ["unknown key 'foo': known: "]),
        (
            "length=-1&density=iron&mass=1",
            ["missing key 'area'", "length = -1", "density = 'iron'"],
        ),
        (
            "stations=[0,1,2]&mass_per_length=[1,2]&bending_stiffness=[1,2,-3]&axial_stiffness=x",
            [
                "mass_per_length: 2 values, 3",
                "bending_stiffness of station 3 at 2 m = -3",
                "axial_stiffness = 'x'",
            ],
        ),
        (
            "stations=[1,2]&mass_per_length=[1,2]&bending_stiffness=-3&axial_stiffness=[1,2]",
            ["stations = .* must ascend from 0", "bending_stiffness = -3"],
        ),
        ("entered={alpha=[1],beta={a=1}}", ["'alpha'.* must be numbers", "'beta'.* must be numb"]),
    ],
)
def test_a_link_without_a_valid_value_has_all_errors(query, errors):
    """Each mistake is told, also of a beam whose size is not known."""
    scene, values, refused = parse_link(query)
    assert (scene, values) == (None, {})
    assert len(refused) == len(errors)
    assert all(re.search(text, str(one)) for text, one in zip(errors, refused, strict=True))


STEEL = "length=0.5&density=7850&area=1e-4&second_moment=1e-10&youngs_modulus=2.1e11"


@pytest.mark.parametrize(
    ("query", "valid", "errors"),
    [
        ("alpha=-1&beta=0.5", "beta=0.5", ["alpha = -1: must lie in 0 .. 100"]),
        (
            "over=spin_up&gamma=3",
            "gamma=3",
            ["over = 'spin_up': must be one of gamma, alpha, beta"],
        ),
        (
            "gamma=-2&mu=10&tab=charts",
            "mu=10",
            ["gamma = -2: must", "tab = 'charts': must be one of"],
        ),
        ("lesson=magic&alpha=2", "alpha=2", ["lesson = 'magic': must be one of stiffening"]),
        ("lesson=nodes&step=4&beta=0.3", "lesson=nodes&beta=0.3", ["step = 4: must be a whole"]),
        ("guess=9&lesson=crossing", "lesson=crossing", ["guess = 9: must be a whole number in 1 "]),
        ("guess=3&lesson=nodes", "lesson=nodes", ["guess = 3: must be a whole number in 1 .. 2"]),
        ("guess=2&gamma=3", "gamma=3", ["guess = 2: there is no lesson"]),
        (f"mass=-1&{STEEL}&gamma=4", f"{STEEL}&gamma=4", ["mass = -1: must be 0 or more"]),
        (f"{STEEL.replace('7850', 'iron')}&mode=2", "mode=2", ["density = 'iron': must be"]),
        ("position=near&look_at=[0,0,1]&gamma=3", "gamma=3", ["position = "]),
        ("look_at=[0,0,1]&gamma=3", "gamma=3", ["the camera has a look_at but no position"]),
        (
            "elements=1000&method=linear",
            "method=linear",
            ["elements = 1000: a page solves with at"],
        ),
        (
            "motion={pull=2,until=-1,colour=3}",
            "motion={pull=2}",
            ["until = -1: must lie in", "motion: unknown key 'colour'"],
        ),
        (
            f"{STEEL}&masses=[{{mass=-1,position=0.1}},{{inertia=[1,-1,1],position=9}}]",
            STEEL,
            [
                "masses 1: mass = -1: must be 0 or more; masses 2: missing 'mass' [kg];"
                " masses 2: position = 9: must lie in 0 .. 0.5;"
                " masses 2: inertia = -1: must be 0 or more"
            ],
        ),
        (f"{STEEL}&mass=-1&mass_position=3", STEEL, ["mass = -1: must", "mass_position = 3: must"]),
        ("method=power-series&terms=101", "method=power-series", ["terms = 101: a page solves"]),
    ],
)
def test_a_link_with_wrong_values_has_the_others_and_the_errors(query, valid, errors):
    """Also where values depend on each other, in any order."""
    found, expected = parse_link(query), parse_link(valid)
    assert found[:2] == expected[:2]
    assert len(found.refused) == len(errors)
    assert all(text in str(one) for text, one in zip(errors, found.refused, strict=True))


@pytest.mark.slow
@given(st.text(max_size=60))
@settings(max_examples=200)
def test_any_link_is_parsed_or_refused(query):
    """No other error, whatever the address contains."""
    with contextlib.suppress(InvalidInput):
        parse_link(query)


def shows(guest: Visitor, query: str) -> None:
    """Wait until the address of the page has this query."""
    guest.wait(lambda _: guest.parts.get("address") == query)


def test_the_address_is_updated_and_a_reload_shows_the_same(guest, url):
    """Numbers, modes, terms, a comparison, a real beam by its dimensions; not the visitor's theme
    and pause. The first scene has no query, except the key."""
    guest.do("link", "?token=abc")
    guest.choose("gamma", 12.5)
    shows(guest, "token=abc&alpha=1.0&beta=0.5&gamma=12.5")
    guest.set(playing=False, dark=True, plane="flapwise")
    shows(guest, query := "token=abc&alpha=1.0&beta=0.5&gamma=12.5&plane=flapwise")
    guest.do("undo")
    guest.do("undo")
    shows(guest, "token=abc")
    guest.do("real.preset", "steel beam")
    guest.wait(lambda _: "youngs_modulus=" in guest.parts["address"])
    steel = dict(parse_qsl(guest.parts["address"]))
    assert float(steel["youngs_modulus"]) == 210e9
    assert float(steel["length"]) == STEEL_BEAM.values["length"]
    assert "mass" not in steel
    with visitor(url) as later:
        later.do("link", query)
        later.shows(PAPER.replace(gamma=12.5), plane="flapwise")
        shows(later, query)
        later.do("undo")  # there is nothing before the link
        later.choose("nodes", False)
        shows(later, f"{query}&nodes=false")


def test_a_pause_outlasts_a_link_and_the_way_back(guest):
    """And a reset, as the theme does: both are the visitor's own."""
    guest.choose("playing", False)
    for gamma in (3.0, 6.0):
        guest.do("link", f"?gamma={gamma}", until=lambda _, own=gamma: guest.values["gamma"] == own)
        assert guest.values["playing"] is False
    guest.choose("gamma", 7.0, until=lambda _: guest.values["gamma"] == 7.0)
    guest.do("reset", until=lambda _: guest.values["gamma"] == 6.0)
    assert guest.values["playing"] is False


IMPOSSIBLE = {  # edits
    "number": [("alpha", 1e9)],
    "two numbers": [("mu", 20.0), ("gamma", 150.0)],
    "real beam": [("link", f"?{STEEL}&mass=0.1"), ("beta", -3.0)],
    "term": [("softening", False), ("method", "ancf")],
    "method": [("method", "chebyshev"), ("coriolis", True), ("keep", None), ("beta", 2.0)],
}


@pytest.mark.parametrize("edits", IMPOSSIBLE.values(), ids=IMPOSSIBLE)
def test_the_address_of_an_impossible_state_is_that_state(guest, url, edits):
    """With its numbers out of range and the options that its method does not take."""
    guest.do("link", "?gamma=7")
    shows(guest, "gamma=7.0")
    for name, value in edits:
        guest.do(name, value)
    catch_up(guest)  # of several edits, one alone is impossible too
    guest.wait(lambda _: "entered=" in guest.parts["address"])
    guest.wait(lambda _: "state bad" in guest.texts["equilibrium"])
    address = guest.parts["address"]
    with visitor(url) as later:
        later.do("link", f"?{address}")
        shows(later, address)

        def both_show_the_same() -> bool:
            catch_up(guest)
            catch_up(later)
            return later.texts["equilibrium"] == guest.texts["equilibrium"]

        wait_until(both_show_the_same)
        assert later.said == []
    guest.do("link", "?gamma=7")
    shows(guest, "gamma=7.0")


@pytest.mark.parametrize("entered", ["3", "{alpha = [1]}", "{beta = {a = 1}}", "{colour = 1}"])
def test_what_is_no_number_or_option_is_not_entered(entered):
    """A link that no page wrote."""
    (error,) = parse_link(f"entered={entered}").refused
    assert "entered" in str(error)


@pytest.mark.parametrize("number", ["inf", "-inf", "nan"])
def test_a_number_that_is_not_finite_is_in_the_address(number):
    """As an edit of a huge number may make it, in the units of a beam; the link has it again."""
    start = State.of(Scene())
    for query in (f"entered={{gamma={number}}}", f"gamma=3&entered={{delta={number}}}"):
        link = parse_link(query)
        state = linked(start, link.scene, link.values)
        again = parse_link(query_of(state, start))
        assert str(again.values["entered"]) == str(link.values["entered"])
        assert not again.refused


def test_a_beam_that_is_too_long_for_a_link_has_none(guest):
    """The link of an earlier beam would be copied in its place."""
    guest.do("link", "?gamma=7")
    shows(guest, "gamma=7.0")
    guest.do("blade.begin", until="Paste a table")
    x = [k / 199 for k in range(200)]
    guest.do("blade.paste", "\n".join(f"{at:.7f} {1 + at:.7f} 300 3e7 150" for at in x))
    guest.wait(lambda _: guest.props["copy-link"].get("disabled"))
    assert "save it as a scene file" in guest.props["copy-link"]["title"]
    assert guest.parts["address"] == ""
    guest.do("undo")
    guest.wait(lambda _: not guest.props["copy-link"].get("disabled"))
    assert "length=" in guest.parts["address"]


def test_the_address_names_the_lesson_and_its_step(guest):
    """With the changes to its scene. An invalid link leaves that of the server, with a message."""
    guest.do("link", "?lesson=magic")
    guest.wait(lambda _: "must be one of stiffening" in str(guest.said))
    guest.shows(PAPER)
    guest.do("lesson", "nodes")
    shows(guest, "lesson=nodes")
    guest.do("lesson_step", 2)
    guest.choose("beta", 0.75)
    shows(guest, "lesson=nodes&step=3&beta=0.75")
    guest.do("lesson", "")
    shows(guest, "")


def test_a_link_with_a_wrong_value_opens_with_a_note_on_it(guest):
    """The note names the value and those allowed; the address has the values that are shown."""
    guest.do("link", "?alpha=-1&beta=0.5&gamma=4&over=spin_up")
    guest.shows(Beam(beta=0.5, gamma=4))
    shows(guest, "beta=0.5&gamma=4.0")
    (said,) = guest.said
    assert said["error"]
    assert "alpha = −1: must lie in 0 .. 100" in said["text"]
    assert "over = 'spin_up': must be one of gamma, alpha" in said["text"]


def test_a_link_with_many_mistakes_says_how_many_more(guest):
    """The first ones on a line each, none of them long; then their number."""
    wrong = "&".join(f"unknown_{k}=1" for k in range(30))
    guest.do("link", f"?lesson=magic&{wrong}&alpha={'9' * 400}")
    guest.wait(lambda _: guest.said)
    title, *lines, last = guest.said[-1]["text"].splitlines()
    assert title.startswith("The link is not valid")
    assert 3 <= len(lines) <= 8
    assert last == f"and {32 - len(lines)} more"
    assert max(map(len, lines)) < 150


@pytest.mark.slow
def test_the_page_shows_the_mistakes_of_its_link_on_a_line_each(url):
    """As many lines as mistakes and a title, where there is room for each. A screen reader gets
    them once, from the alert."""
    with page(f"{url}/?alpha=-1&beta=3&mode=0&gamma=3", 1440, 900) as shown:
        shown.wait("!document.getElementById('toast').hidden")
        lines = shown.evaluate("document.getElementById('toast').innerText").splitlines()
        assert len(lines) == 4
        height = "parseFloat(getComputedStyle(e).lineHeight)"
        box = "e.clientHeight - 2 * parseFloat(getComputedStyle(e).paddingTop)"
        rows = f"(e => Math.round(({box}) / {height}))({by_id('toast')})"
        assert shown.evaluate(rows) == len(lines)
        told = "[...document.querySelectorAll('[role=alert], [role=status]')]"
        told += f".filter(e => e.innerText.includes({lines[0]!r}))"
        assert shown.evaluate(f"{told}.map(e => e.id)") == ["toast"]


@pytest.mark.slow
def test_the_page_opens_its_link_and_updates_it(url):
    """A lesson; a key goes to its meaning; an edit, which a key undoes; a reload shows the same."""
    with page(f"{url}/?lesson=nodes", 1280, 720) as shown:
        shown.wait(says(lesson("nodes").question))
        shown.key("n", until=says(lesson("nodes").proof))
        shown.wait("location.search === '?lesson=nodes&step=2'")
        for name, value, edits in (("gamma", 9, ""), ("beta", 0.75, "beta=0.75&")):
            field = by_id(f"{name}-field")
            change = "dispatchEvent(new Event('change', {bubbles: true}))"
            shown.evaluate(f"{field}.value = {value}, {field}.{change}")
            shown.wait(f"location.search === '?lesson=nodes&step=2&{edits}gamma=9.0'")
        shown.key("z", modifiers=2, until="location.search === '?lesson=nodes&step=2&gamma=9.0'")
        shown.reload()
        shown.wait(f"{by_id('gamma-field')}?.value === '9'")
        shown.wait(says(lesson("nodes").proof))
        assert shown.problems == []
