"""Hints at what is taken by the hand in the scene."""

import pytest
from live.browser import READY, page
from live.offline import Desk, offline

from beamviz.explorer.features.hints import HINTS
from beamviz.scene import START

FIRST = START.changed(playing=False)
SIZES = [(1920, 1080), (1440, 900), (1280, 720), (1024, 768), (390, 844)]
SHOWN = "[...document.querySelectorAll('#caption-layer > .hint')].filter(e => e.checkVisibility())"
COVERED = f"""(() => {{
  const boxes = all => [...document.querySelectorAll(all)].map(e => e.getBoundingClientRect());
  const hints = {SHOWN}.map(e => e.getBoundingClientRect());
  const texts = boxes('#captions > *, #legend, #transport, #caption-layer > span:not(.hint)');
  return hints.some(a => texts.some(b => b.width && a.left < b.right && b.left < a.right
    && a.top < b.bottom && b.top < a.bottom)); }})()"""


def hints(desk: Desk) -> list[str]:
    """The texts of the hints in the scene."""
    desk.frame(3)
    desk.guest.visitor.receive()
    captions = desk.guest.visitor.parts["captions"]
    return [caption["text"] for caption in captions if caption.get("hint")]


def test_a_hint_is_shown_until_it_was_followed_and_then_the_next():
    """One at a time, once the browser has told which were; neither in a lesson, also of a file, nor
    in a motion."""
    pull, turning = (hint.text for hint in HINTS.values())
    with offline():
        desk = Desk(FIRST)
        assert hints(desk) == []
        desk.do("used", "")
        assert hints(desk) == [pull]
        desk.do("lesson", "stiffening")
        assert hints(desk) == []
        desk.do("lesson", "")
        desk.do("load", "my.toml\n[[step]]\nlink = 'gamma=1'")
        assert hints(desk) == []
        desk.do("lesson", "")
        assert hints(desk) == [pull]
        desk.do("pull_tip", 0.1)
        assert hints(desk) == []
        desk.do("let_go", False)
        assert hints(desk) == [turning]
        points = [(0.0, 0.0, 0.0), (0.2, 0.2, 0.0), (0.2, 0.2, 0.0)]
        desk.guest.visitor.drag("/scene/rotor/wheel/handle", *points, between=desk.frame)
        assert hints(desk) == []
        assert desk.guest.visitor.parts["used"] == ["pull", "turn"]
        desk.do("undo")
        assert hints(desk) == []


def test_where_nothing_can_be_pulled_the_hub_can_be_turned():
    """And with all modes drawn, neither."""
    with offline():
        desk = Desk(FIRST)
        desk.do("used", "flap stop")
        desk.do("plane", "flapwise")
        assert hints(desk) == [HINTS["turn"].text]
        desk.do("all_modes", True)
        assert hints(desk) == []


@pytest.mark.slow
def test_hints_cover_no_text_and_stay_away_once_used(url):
    """At each size, in both frames, wherever the beam is; after a reload, too."""
    with page(url) as shown:
        shown.wait(READY)
        for used in ("", "pull"):
            shown.send("used", used)
            for size in SIZES:
                shown.resize(*size)
                for rotating in (True, False):
                    shown.send("rotating_frame", rotating)
                    for _ in range(2):
                        shown.next_frame(8)
                        assert not shown.evaluate(COVERED)
        shown.wait(f"{SHOWN}.length === 1")
        shown.wait("localStorage.getItem('beamviz-used') === 'pull'")
        shown.call("Page.reload")
        shown.wait(f"{READY} && {SHOWN}.length === 1")
        assert shown.evaluate(f"{SHOWN}[0].textContent") == HINTS["turn"].text
        assert shown.problems == []
