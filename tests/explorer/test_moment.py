"""The moment of a motion in time: where it stands, is moved to, or goes on from, frame by frame."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any
from urllib.parse import parse_qsl

import pytest
from live.offline import STEP, Desk, lecture, offline

from beamviz.beam import Beam
from beamviz.dynamics import Motion, motion
from beamviz.explorer import computed_motion
from beamviz.explorer.experiment import PULLED, MotionState
from beamviz.explorer.features.motion import PRESETS
from beamviz.scene import Scene

FIRST = Scene(Beam(alpha=1, beta=0.5, gamma=3)).changed(playing=False)
LINK = "alpha=1&beta=0.5&gamma=3&tab=motion&moving=true&motion={until=4.0}"


def rough_motion(*given: Any, **options: Any) -> Motion:
    """A motion that is computed sooner."""
    return motion(*given, **options | {"points": 9, "tolerance": 1e-2})


@pytest.fixture(autouse=True)
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Motions are computed coarsely: what they are does not matter here."""
    monkeypatch.setattr(computed_motion, "motion", rough_motion)


@pytest.fixture
def desk() -> Iterator[Desk]:
    """A page that plays the motion of a link."""
    with offline():
        opened = Desk(FIRST)
        opened.do("link", f"?{LINK}")
        opened.do("playing", True)
        opened.frame(5)
        assert opened.session.snapshot.film
        yield opened


def moment(desk: Desk) -> float:
    """The moment that the scene shows."""
    return desk.visitor.clock.moment


def linked(desk: Desk) -> str | None:
    """The moment in the address."""
    return dict(parse_qsl(desk.address)).get("moment")


def step(desk: Desk) -> float:
    """The time [T*] from one frame to the next."""
    return STEP * desk.session.snapshot.rate


def test_a_motion_is_moved_while_it_plays_and_goes_on(desk):
    """Also twice to the same moment, and to its start, from which it began."""
    assert moment(desk) > 0
    for wanted in (0.0, 1.5, 1.5, 0.0, 0.0):
        desk.do("moment", wanted)
        desk.frame()
        assert moment(desk) == wanted
        desk.frame(3)
        assert moment(desk) == pytest.approx(wanted + 3 * step(desk))
        assert linked(desk) is None


def test_the_last_of_several_moments_is_shown(desk):
    """Those that come in one frame, as from a slider; and each of those that come in several."""
    for wanted in (1.0, 1.2, 1.4):
        desk.do("moment", wanted)
    desk.frame()
    assert moment(desk) == 1.4
    for k in range(5):
        desk.do("moment", 1.5 + 0.1 * k)
        desk.frame()
        assert moment(desk) == 1.5 + 0.1 * k


def test_a_motion_that_is_paused_stands_where_it_was(desk):
    """The address has its moment, to 4 digits, until it goes on, from there."""
    desk.frame(9)
    desk.do("playing", False)
    desk.frame(2)
    stands = moment(desk)
    assert stands > 0
    assert desk.state.slice(MotionState).moment == stands == round(stands, 4)
    desk.frame(3)
    assert moment(desk) == stands
    assert linked(desk) == f"{stands}"
    desk.do("playing", True)
    desk.frame(3)
    assert moment(desk) == pytest.approx(stands + 2 * step(desk))
    assert linked(desk) is None


def test_a_motion_that_is_paused_after_its_end_stands_at_its_end(desk):
    """That is shown for a while before the motion begins again."""
    desk.do("moment", 4.0)
    desk.frame(3)
    assert moment(desk) > 4.0
    desk.do("playing", False)
    desk.frame(2)
    assert linked(desk) == "4.0"
    assert moment(desk) == 4.0


def test_a_motion_that_is_moved_and_paused_at_once_stands_there(desk):
    """In either order."""
    for edits in (("moment", 1.25), ("playing", False)), (("playing", False), ("moment", 0.75)):
        desk.do("playing", True)
        desk.frame(3)
        for edit in edits:
            desk.do(*edit)
        desk.frame(3)
        assert moment(desk) == dict(edits)["moment"] == desk.state.slice(MotionState).moment


def test_the_motion_of_another_beam_begins_at_its_start_while_it_plays(desk):
    """Though the last one was moved; paused, it stands where that stood."""
    desk.do("moment", 2.0)
    desk.frame(2)
    desk.do("alpha", 2.0)
    desk.frame()
    assert moment(desk) > 2
    desk.frame(3)
    assert desk.session.snapshot.film.beam.alpha == 2
    assert moment(desk) < 1
    desk.do("playing", False)
    desk.do("moment", 2.0)
    desk.frame()
    desk.do("alpha", 3.0)
    desk.frame(4)
    assert desk.session.snapshot.film.beam.alpha == 3
    assert moment(desk) == 2


def test_undo_leaves_a_motion_at_its_moment(desk):
    """It goes on, or stands; also where undo follows at once."""
    desk.do("moment", 2.0)
    desk.frame()
    desk.do("ghosts", False)
    desk.frame()
    desk.do("undo")
    desk.frame()
    assert moment(desk) == pytest.approx(2 + 2 * step(desk))
    desk.do("playing", False)
    desk.frame(2)
    stands = moment(desk)
    for action in ("redo", "undo"):
        desk.do(action)
        desk.frame(2)
        assert moment(desk) == stands


@pytest.mark.parametrize("playing", [False, True])
def test_an_experiment_begins_at_its_start(desk, playing):
    """A new one, the same again, and the motion that the scene showed before its modes."""
    desk.do("preferences", "" if playing else "still")
    desk.do("playing", playing)
    for name in ("stop", "stop"):
        desk.do("moment", 2.0)
        desk.frame(2)
        desk.do("experiment", name)
        desk.frame()
        assert moment(desk) == 0
        desk.frame(4)
        assert desk.state.slice(MotionState).experiment == PRESETS[name][1]
        assert moment(desk) < 1
    desk.do("moment", 2.0)
    desk.frame(2)
    desk.do("only", 0)
    desk.frame(2)
    assert desk.session.snapshot.film is None
    desk.do("motion.begin")
    desk.frame()
    assert moment(desk) == 0


def test_a_reset_begins_at_the_start(desk):
    """With the motion of the link, which is known."""
    desk.do("moment", 2.0)
    desk.frame(2)
    desk.do("reset")
    desk.frame()
    assert desk.state.slice(MotionState).experiment == replace(PULLED, until=4.0)
    assert moment(desk) == 0


@pytest.mark.parametrize("still", [False, True])
def test_a_link_opens_a_motion_at_its_moment(still):
    """Where it stands until it is played, as on the page of the sender; a link to the same one
    moves it there."""
    with offline():
        desk = Desk(FIRST)
        desk.do("playing", not still)
        desk.do("link", f"?{LINK}&moment=1.5")
        while desk.session.snapshot.film is None:
            desk.frame()
        for _ in range(2):
            assert moment(desk) == 1.5
            desk.frame(2)
            assert moment(desk) == 1.5
            assert linked(desk) == "1.5"
            desk.do("playing", True)
            desk.frame(2)
            assert moment(desk) == pytest.approx(1.5 + step(desk))  # the first frame begins there
            assert linked(desk) is None
            desk.do("moment", 3.0)
            desk.frame(2)
            desk.do("link", f"?{LINK}&moment=1.5")
            desk.frame()


def test_a_lesson_that_is_left_returns_to_the_moment_before_it(desk):
    """Where the motion stood."""
    desk.do("playing", False)
    desk.do("moment", 1.5)
    desk.frame()
    desk.do("lesson", "nodes")
    desk.frame(2)
    desk.do("lesson", "")
    desk.do("playing", False)
    desk.frame(4)
    assert desk.session.snapshot.film
    assert moment(desk) == 1.5


def test_a_lecture_has_the_moment_of_the_presenter(desk):
    """Moved, going on, paused; whoever leaves it stays there."""
    one = Desk(FIRST)
    both = lecture(desk, one)
    both()
    for wanted in (2.0, 0.0):
        desk.do("moment", wanted)
        for _ in range(4):
            both()
            assert moment(one) == moment(desk)
    desk.do("moment", 1.0)
    desk.frame()
    desk.moment()
    one.frame()
    assert moment(one) == moment(desk) > 1
    desk.do("playing", False)
    both(3)
    assert moment(one) == moment(desk) == one.state.slice(MotionState).moment
    one.do("tab", "methods")
    one.do("ghosts", False)
    one.frame(6)
    assert not one.state.following
    assert moment(one) == moment(desk)


SLEEVE = "/scene/rotor/sleeve"


def pull(desk: Desk, aside: float, held: Callable[[], Any] = lambda: None) -> None:
    """Pull the beam aside at its tip, and let go of it; held: called while it is in the hand."""

    def between() -> None:
        desk.frame(3)
        hold = desk.state.slice(MotionState).hold
        if hold and hold.held and hold.deflection:
            held()
            stands = desk.visitor.clock.angle
            desk.frame(3)
            assert desk.visitor.clock.angle == stands  # nothing plays

    points = [(1.0, part * aside, 0.0) for part in (0.0, 1.0, 1.0)]
    desk.guest.visitor.drag(SLEEVE, *points, between=between)


def test_a_beam_in_the_hand_is_that_of_the_numbers(desk):
    """Not the one that was pulled before at the same place."""
    shown = list[Beam]()
    pull(desk, 0.2)
    desk.do("alpha", 3.0)
    desk.frame(3)
    threads = desk.guest.workers  # which are all at work elsewhere
    threads.chance, threads.run = None, lambda: None
    pull(desk, 0.2, lambda: shown.append(desk.session.snapshot.picture.drawn.shapes.beam))
    assert [beam.alpha for beam in shown] == [3.0]


def test_a_beam_in_the_hand_is_not_shown_as_it_was_held_before(desk):
    """At the same place, by another distance: until it is computed, as it is without the hand."""
    shown = list[float]()
    pull(desk, 0.3)
    desk.frame(3)
    threads = desk.guest.workers  # which are all at work elsewhere
    threads.chance, threads.run = None, lambda: None
    pull(desk, 0.1, lambda: shown.append(desk.session.snapshot.film.until))
    assert shown == [4.0]  # the motion, which the hand has stopped


def test_a_beam_in_the_hand_can_be_let_go_of_where_no_motion_is_offered(desk):
    """As after a key that shows a mode instead."""
    desk.do("tab", "frequencies")
    desk.frame()
    pull(desk, 0.2, lambda: desk.do("only", 0))
    desk.frame(3)
    assert desk.state.slice(MotionState).hold is None
    assert desk.state.slice(MotionState).experiment.pull != PULLED.pull


def test_the_tip_is_pulled_in_any_tab_and_plays_at_once(desk):
    """Also with reduced motion; a click on the tip is no pull."""
    desk.do("tab", "frequencies")
    desk.do("preferences", "still")
    desk.do("only", 0)
    desk.frame(3)
    for aside, plays in ((0.0, False), (0.2, True)):
        pull(desk, aside)
        desk.frame(4)
        assert desk.state.slice(MotionState).in_motion is desk.state.view.playing is plays
    assert desk.session.snapshot.film
    desk.do("undo")
    desk.frame(3)
    assert desk.session.snapshot.film is None


def test_a_visitor_of_a_lecture_pulls_the_beam(desk):
    """Which they explore by themselves then."""
    one = Desk(FIRST)
    both = lecture(desk, one)
    both(3)
    pull(one, 0.2)
    one.frame(3)
    assert not one.state.following
    pulls = [each.state.slice(MotionState).experiment.pull for each in (one, desk)]
    assert pulls[0] != pulls[1]
    assert desk.state.slice(MotionState).hold is None


def test_the_tip_is_pulled_by_keys(desk):
    """Enter lets it go, Escape puts it back; the slider shows where it is held. Once it is let go,
    leaving the slider ends nothing."""
    desk.do("only", 0)
    desk.frame(3)
    desk.do("pull_tip", 0.1)
    desk.frame(3)
    assert desk.session.view.beam.line[-1, 1] == pytest.approx(0.1, abs=1e-3)
    desk.do("let_go", False)
    desk.frame(3)
    assert desk.session.snapshot.film is None
    for deflection in (0.06, 0.14):
        desk.do("pull_tip", deflection)
        desk.frame(3)
    desk.do("let_go", True)
    desk.do("let_go", False)
    desk.frame(4)
    state = desk.state
    assert state.slice(MotionState).in_motion
    assert state.slice(MotionState).experiment.pull_at == 1.0
    assert desk.session.snapshot.film.until > 1
    desk.do("undo")
    desk.frame(3)
    assert desk.session.snapshot.film is None
