"""Links and keys in the real page: what only a browser can show."""

from collections.abc import Iterator

import pytest
from live.browser import Page, button, field, page, says

from beamviz.explorer.app import explorer
from beamviz.lessons import lesson
from beamviz.scene import Scene

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def served() -> Iterator[str]:
    """A running explorer."""
    with explorer(Scene()) as url:
        yield url


@pytest.fixture(scope="module")
def shown(served) -> Iterator[Page]:
    """A page opened by a link to a lesson."""
    with page(f"{served}/?lesson=nodes", 1280, 720) as opened:
        yield opened


def press(shown: Page, key: str) -> None:
    """A key, down and up."""
    for kind in ("keyDown", "keyUp"):
        shown.call("Input.dispatchKeyEvent", type=kind, key=key, code=f"Key{key.upper()}")


def test_a_link_opens_a_lesson_and_a_key_turns_its_pages(shown):
    """Its question, then its meaning; nothing of the asking is left in the page."""
    shown.wait(says(lesson("nodes").question))
    press(shown, "n")
    shown.wait(says(lesson("nodes").proof.words))
    assert shown.evaluate("localStorage.length") == 0
    assert shown.problems == []


def test_a_link_opens_a_scene(served, shown):
    """The sliders are where it says."""
    shown.call("Page.navigate", url=f"{served}/?alpha=1.25&gamma=7.5")
    shown.wait(
        "['1.25', '7.5'].every(text => Array.from(document.querySelectorAll('input'))"
        ".some(input => input.value === text))"
    )


def test_a_wrong_link_says_so(served, shown):
    """And the page shows its usual scene."""
    shown.call("Page.navigate", url=f"{served}/?lesson=magic")
    shown.wait(says("lesson = magic: must be one of stiffening"))
    shown.wait(says("New here?"))


def test_a_link_cannot_ask_for_more_than_a_page_may(served, shown):
    """1000 elements would take seconds for each solution, and minutes for the chart."""
    shown.call("Page.navigate", url=f"{served}/?method=linear&elements=1000")
    shown.wait(says("elements = 1000: a page solves with at most 200"))


def top(element: str) -> str:
    """Where an element begins, from the top of the page."""
    return f"Math.round({element}.getBoundingClientRect().top)"


NEXT = button("next ›")
TABLE = "document.querySelector('table[aria-label=modes]')"
SPEED = field("speed γ")


def test_nothing_moves_while_the_beam_changes(served, shown):
    """Neither the table, whether there is an equilibrium or none, nor the buttons of a lesson."""
    shown.call("Page.navigate", url=f"{served}/?lesson=no-equilibrium")
    shown.wait(says(lesson("no-equilibrium").question))
    shown.wait(says("8.3 % longer"))
    before = [shown.evaluate(top(element)) for element in (TABLE, NEXT)]
    press(shown, "n")
    shown.wait(says(lesson("no-equilibrium").proof.words))
    shown.evaluate(f"(({{}}) => {{ {SPEED}.focus(); {SPEED}.select(); }})({{}})")
    shown.call("Input.insertText", text="40")
    shown.wait(says("No equilibrium"))
    assert [shown.evaluate(top(element)) for element in (TABLE, NEXT)] == before
