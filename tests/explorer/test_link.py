"""Links: a page opens on the scene of its address, and the address follows the scene."""

import contextlib
from collections.abc import Iterator
from urllib.parse import parse_qs

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from live.browser import Page, page, says
from live.visitor import PAPER, Visitor, frequency_text, visitor

from beamviz.errors import InvalidInput
from beamviz.explorer.app import explorer
from beamviz.explorer.features.comparison import CORIOLIS
from beamviz.explorer.features.links import Link, parse_link
from beamviz.lessons import lesson
from beamviz.presets import STEEL_BEAM
from beamviz.scene import START, Scene

NODES = lesson("nodes").scene


@pytest.mark.parametrize(
    ("query", "link"),
    [
        ("", None),
        ("fixedDpr=1&token=abc", None),
        ("lesson=nodes", Link(NODES, {"lesson": "nodes"})),
        (
            "lesson=nodes&step=3&gamma=2&tab=veering",
            Link(NODES.changed(gamma=2), {"lesson": "nodes", "step": 2}, "veering"),
        ),
        ("alpha=1&mode=3", Link(Scene.of(alpha=1, mode=3), {})),
        ("gamma=10.0&over=mu&dark=true", Link(Scene.of(gamma=10, over="mu", dark=True), {})),
        ("strain=hencky&shares=[0.5,%201]", Link(Scene.of(strain="hencky", shares=[0.5, 1.0]), {})),
        ("gamma=3&compare=coriolis", Link(Scene.of(gamma=3), {"comparison": CORIOLIS})),
        (
            "stacked=true&force=2&damping=0.05&response=true",
            Link(
                Scene(),
                {"stacked": True, "force_per_rev": 2, "damping": 0.05, "forced_response": True},
            ),
        ),
    ],
)
def test_a_link_is_followed(query, link):
    """Lessons by name, scenes by their keys; what others read from it is left alone."""
    assert parse_link(query) == link


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ("lesson=magic", "must be one of stiffening"),
        ("gama=3", "gama"),
        ("alpha=-1", "alpha = -1: must lie in 0 .. 100"),
        ("alpha=1%0Abeta=3", "alpha = "),  # a line end does not begin another key
        ("a&" * 1000, "no more than"),
        ("lesson=nodes&step=4", "step = 4: must be a whole number in 1 .. 3"),
        ("compare=all", "compare = 'all': must be one of ancf, coriolis"),
        ("tab=charts", "tab = 'charts': must be one of frequencies, map, veering"),
        ("force=7", "force = 7: must be a whole number in 1 .. 6"),
        ("damping=1", "damping = 1: must lie in 0.001 .. 0.2"),
        ("length=1", "the link: missing key 'density'"),
        ("method=linear&elements=1000", "elements = 1000: a page solves with at most 200"),
    ],
)
def test_a_link_without_sense_is_refused(query, words):
    """It says what is wrong."""
    with pytest.raises(InvalidInput, match=words):
        parse_link(query)


@given(st.text(max_size=60))
@settings(max_examples=200)
def test_no_link_does_more_than_be_refused(query):
    """Whatever is typed into the address: it is followed, or refused in words."""
    with contextlib.suppress(InvalidInput):
        parse_link(query)


# The address


def shows(guest: Visitor, query: str) -> None:
    """Wait until the address of the page is this query."""
    guest.wait(lambda _: guest.parts.get("address") == query)


def test_the_address_follows_the_scene_and_a_reload_shows_the_same(url):
    """Numbers, modes, terms, a comparison, a real beam by its sizes; not what is the visitor's own:
    the colours and whether it plays. The first scene has no query, but for the key."""
    with visitor(url) as guest:
        guest.do("link", "?token=abc")
        guest.choose("gamma", 12.5)
        shows(guest, "token=abc&alpha=1.0&beta=0.5&gamma=12.5")
        guest.choose("playing", False)
        guest.choose("dark", True)
        guest.choose("plane", "flapwise")
        shows(guest, query := "token=abc&alpha=1.0&beta=0.5&gamma=12.5&plane=flapwise")
        guest.do("undo")
        guest.do("undo")
        shows(guest, "token=abc")
        guest.do("real.preset", "steel beam")
        guest.wait(lambda _: "youngs_modulus=" in guest.parts.get("address", ""))
        steel = parse_qs(guest.parts["address"])
    with visitor(url) as guest:
        guest.do("link", query)
        guest.says(frequency_text(PAPER.replace(gamma=12.5), plane="flapwise"))
        shows(guest, query)
    assert float(steel["youngs_modulus"][0]) == 210e9
    assert float(steel["length"][0]) == STEEL_BEAM.values["length"]
    assert "mass" not in steel


def test_the_address_names_the_lesson_and_its_step(url):
    """With what was changed of its scene."""
    with visitor(url) as guest:
        guest.do("link", "")
        guest.do("lesson", "nodes")
        shows(guest, "lesson=nodes")
        guest.do("lesson_step", 2)
        guest.choose("beta", 0.75)
        shows(guest, "lesson=nodes&step=3&beta=0.75")
        guest.do("lesson", "")
        shows(guest, "alpha=1.0&beta=0.75&over=beta")


# In a browser


@pytest.fixture(scope="module")
def served() -> Iterator[str]:
    """A running explorer."""
    with explorer(START) as url:
        yield url


@pytest.fixture(scope="module")
def shown(served) -> Iterator[Page]:
    """A page opened by a link to a lesson."""
    with page(f"{served}/?lesson=nodes", 1280, 720) as opened:
        yield opened


def press(shown: Page, key: str, modifiers: int = 0) -> None:
    """A key, down and up; 2: with Ctrl."""
    for kind in ("keyDown", "keyUp"):
        code = f"Key{key.upper()}"
        shown.call("Input.dispatchKeyEvent", type=kind, key=key, code=code, modifiers=modifiers)


def field(name: str) -> str:
    """The field of a number."""
    return f"document.getElementById('{name}-field')"


def type_in(shown: Page, name: str, value: float) -> None:
    """Type a number beside a slider."""
    shown.evaluate(
        f"(e => {{ e.value = {value};"
        f" e.dispatchEvent(new Event('change', {{bubbles: true}})) }})({field(name)})"
    )


@pytest.mark.browser
def test_a_link_opens_a_lesson_and_a_key_turns_its_pages(shown):
    """Its question, then its meaning; a reload shows that page again."""
    shown.wait(says(lesson("nodes").question))
    press(shown, "n")
    shown.wait(says(lesson("nodes").proof))
    shown.wait("location.search === '?lesson=nodes&step=2'")
    shown.call("Page.reload")
    shown.wait(says(lesson("nodes").proof))
    assert shown.problems == []


@pytest.mark.browser
def test_edits_are_undone_by_a_key_and_a_link_brings_them_back(served, shown):
    """The sliders are where the address says, after a reload too."""
    values = f"[{field('alpha')}, {field('gamma')}].map(e => e?.value).join()"
    shown.call("Page.navigate", url=f"{served}/?alpha=1.25&gamma=7.5")
    shown.wait(f"{values} === '1.25,7.5'")
    type_in(shown, "gamma", 9)
    shown.wait("location.search.includes('gamma=9.0')")
    shown.call("Page.reload")
    shown.wait(f"{values} === '1.25,9'")
    type_in(shown, "alpha", 3)
    shown.wait("location.search.includes('alpha=3.0')")
    press(shown, "z", modifiers=2)
    shown.wait("location.search.includes('alpha=1.25')")
    shown.wait(f"{values} === '1.25,9'")


@pytest.mark.browser
def test_a_wrong_link_says_so(served, shown):
    """And the page shows its usual scene."""
    shown.call("Page.navigate", url=f"{served}/?lesson=magic")
    shown.wait(says("lesson = magic: must be one of stiffening"))
    shown.wait(f"{field('gamma')}?.value === '5'")
