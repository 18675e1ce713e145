"""The lessons: begun, turned through, met and reset by a visitor."""

import re
import threading
import time
from functools import partial
from typing import Any

import pytest
from live.server import held_back, wait_until
from live.visitor import PAPER, Visitor, catch_up, frequency_text, visitor

from beamviz.beam import Beam
from beamviz.explorer import explorer, solutions
from beamviz.explorer.experiment import PULLED, Experiment, MotionState
from beamviz.explorer.features.lessons import (
    AWAITED,
    CONTROLS,
    Facts,
    LessonState,
    controls,
    formatted,
    lesson_html,
)
from beamviz.explorer.features.run_up import RunUpState
from beamviz.explorer.page import typeset
from beamviz.explorer.session import Session
from beamviz.lessons import LESSONS, lesson
from beamviz.solver import solve


def begin(guest: Visitor, name: str) -> None:
    """Choose a lesson."""
    guest.do("lesson", name, until=formatted(lesson(name).question))


def test_every_lesson_has_a_card(guest):
    """With a picture; the scene is that of the server. Each control that a lesson names exists, and
    the instructions name at least one control or tab."""
    guest.says(f"{len(LESSONS)} short lessons")
    cards = guest.texts["tab-lessons"]
    assert ">Begin</button>" in cards
    pictures = re.findall("<svg.*?</svg>", cards)
    assert len(pictures) == len(LESSONS)
    assert len(set(pictures)) >= len(LESSONS) - 3
    assert not any("nan" in picture for picture in pictures)
    assert frequency_text(PAPER) in guest.text
    for one in LESSONS:
        texts = " ".join((one.do, one.see, one.meaning, one.task))
        assert {*re.findall(r"\*\*(.+?)\*\*", texts)} <= {*CONTROLS}
        assert controls(one.do)


@pytest.mark.parametrize("step", [1, 2])
def test_a_lesson_says_that_its_number_is_being_computed(step):
    """Beside its meaning, and in the challenge, which has no verdict until then."""
    shown = lesson("nodes")
    assert "being computed" in lesson_html(shown, step, None, None)
    assert "being computed" not in lesson_html(shown, step, None, Facts.of("nodes"))


def test_the_invitation_is_to_a_lesson_that_is_not_met_and_to_what_is_there(guest):
    """It names the tip where that can be pulled, else the chart below only in the tab that has it,
    and a last lesson finishes."""
    guest.says("Start lesson 1<")
    guest.says("at the tip aside, and let it go")
    guest.do("tab", "lessons")
    guest.says("at the tip aside, and let it go")
    guest.do("met", " ".join(one.name for one in LESSONS[:2]), until="Start lesson 3<")
    guest.do(
        "met", " ".join(one.name for one in LESSONS), until=lambda _: "Start" not in guest.text
    )
    guest.do("lesson", LESSONS[-1].name)
    guest.do("lesson_step", 1, until="Next ›")
    assert ">Begin</button>" not in guest.texts["tab-lessons"]
    guest.do("lesson_step", 2, until="Finish")


@pytest.mark.parametrize("one", LESSONS, ids=lambda one: one.name)
def test_what_a_lesson_watches_is_named_by_itself(one):
    """Not by the table that has it: on narrow pages it is in the scene, the table out of view."""
    assert not re.search(r"\btable\b", f"{one.do} {one.see} {one.task}")


def test_a_number_that_rounds_to_zero_has_no_sign():
    """The mass at the node found by a visitor changes B2 by less than can be read."""
    shown = lesson("nodes")
    found = solve(Beam(alpha=1, beta=round(shown.answer, 4)), state="straight")
    assert shown.gauge(found) < 0
    assert shown.measured(found, 1.0) == "the mass changes B2 by +0.00 %"


def test_next_and_back_go_through_the_steps_and_lessons(guest):
    """Question, with the table of the beam and model of the lesson, meaning with its number,
    challenge; then the next lesson, after the last none."""
    for k, one in enumerate(LESSONS[:3], 1):
        for words in (one.question, one.proof, one.task):
            guest.do("lesson_turn", 1, until=typeset(formatted(words)))
            assert f">{k}. " in guest.texts["lesson-text"]
        guest.shows(one.scene.beam, **one.scene.options)
    begin(guest, LESSONS[-2].name)
    for words in (LESSONS[-2].proof, LESSONS[-2].task, LESSONS[-1].question, LESSONS[-1].proof):
        guest.do("lesson_turn", 1, until=typeset(formatted(words)))
    guest.do("lesson_turn", 1)
    guest.do("lesson_turn", -1, until=typeset(formatted(LESSONS[-1].proof)))
    for _ in range(2):
        guest.do("lesson_turn", 1)
    guest.wait(lambda _: guest.props["lesson"]["hidden"] is True)


def test_with_reduced_motion_a_lesson_moves_only_if_the_scene_before_it_did(guest):
    """Paused at first; after a press of P the next lesson moves."""
    guest.do("preferences", "still", until=lambda _: guest.values.get("playing") is False)
    begin(guest, "nodes")
    assert guest.values["playing"] is False
    guest.press("P")
    guest.wait(lambda _: guest.values["playing"] is True)
    begin(guest, "crossing")
    assert guest.values["playing"] is True


def test_a_lesson_fits_its_beam_into_the_picture(guest, monkeypatch):
    """The camera is the same as for a page that opens with that scene, even if late; such a page
    (`beamviz serve --lesson buckling`) opens the lesson."""
    scene = lesson("buckling").scene
    with explorer(scene) as address, visitor(address) as other:
        other.says(lesson("buckling").question)
        wanted = other.camera  # of the loaded beam: before its answer that of the unloaded one
    monkeypatch.setattr(solutions, "solve", lambda *a, **o: (time.sleep(0.4), solve(*a, **o))[1])
    begin(guest, "buckling")
    guest.says(frequency_text(scene.beam))
    guest.wait(lambda _: guest.camera == pytest.approx(wanted, rel=1e-6))


def test_a_step_of_a_lesson_keeps_the_beam_and_a_reset_restores_that_of_the_lesson(guest):
    """By the button of the lesson, and the key of that of the controls. An unknown lesson, step or
    direction is ignored."""
    begin(guest, "moving-mass")
    for value in ("Magic", -2, None, ["nodes"], 3):
        for action in ("lesson", "lesson_step", "lesson_turn"):
            guest.do(action, value)
    guest.shows(lesson("moving-mass").scene.beam)
    for again in (partial(guest.do, "lesson_restart"), partial(guest.press, "R")):
        guest.edit(beta=0.3)
        guest.do("lesson_turn", 1, until="proves it")
        assert frequency_text(Beam(alpha=1, beta=0.3)) in guest.text
        again()
        guest.shows(lesson("moving-mass").scene.beam)
        guest.do("lesson_turn", -1)


@pytest.mark.parametrize(
    ("action", "value", "opened"),
    [
        ("tab", "loads", PAPER),
        ("link", "?gamma=3", Beam(gamma=3)),
        ("load", "beam.toml\n[beam]\ngamma = 4.0", Beam(gamma=4)),
    ],
    ids=["start", "link", "file"],
)
def test_without_a_lesson_reset_returns_to_the_opened_scene(guest, action, value, opened):
    """That of the server, a link or a file; also after a lesson."""
    guest.do(action, value, until=frequency_text(opened))
    begin(guest, "moving-mass")
    guest.do("lesson", "", until=frequency_text(opened))
    guest.choose("gamma", 20.0, until=frequency_text(opened.replace(gamma=20)))
    guest.do("lesson_restart", until=frequency_text(opened))


SPUN = Experiment(pull=2.0, until=3.0)
OWN = f"?alpha=2&beta=0.3&gamma=4&damping=0.05&motion={SPUN.text}"
OWN_BEAM = Beam(alpha=2, beta=0.3, gamma=4)


def shown_state(session: Session) -> tuple[Any, ...]:
    """What belongs to the scene and the experiment of a visitor."""
    state = session.visitor.state
    motion, now = state.slice(MotionState), state.slice(LessonState)
    experiment = motion.experiment, motion.in_motion, state.slice(RunUpState).damping
    return state.case, state.view.shares, state.rate, experiment, now.lesson, now.step


def test_leaving_lessons_returns_to_the_scene_and_the_experiment_before_them(guest, session):
    """Also after several of them, edits in them and a restart; it is offered to undo that, and a
    step back in the history returns to the lesson."""
    guest.do("link", OWN, until=frequency_text(OWN_BEAM))
    before = shown_state(session)
    begin(guest, "moving-mass")
    begin(guest, "spin-up")
    guest.do("alpha", 0.7)
    guest.do("lesson_restart", until="The scene is reset.")
    guest.do("motion.until", 6.0)
    guest.do("gamma", 3.0)
    catch_up(guest)
    within = shown_state(session)
    assert within[3][1]
    guest.do("lesson", "", until="Your scene is back")
    catch_up(guest)
    guest.shows(OWN_BEAM)
    assert shown_state(session) == before
    guest.do("undo", until=formatted(lesson("spin-up").question))
    catch_up(guest)
    assert shown_state(session) == within
    guest.do("lesson", "")
    catch_up(guest)
    guest.shows(OWN_BEAM)
    assert shown_state(session) == before


def test_a_reset_resets_the_experiment_too(guest, session):
    """To that of the lesson, and without one to that of the link."""
    begin(guest, "hear-the-modes")
    first = shown_state(session)[3]
    guest.do("motion.pull_at", 0.3)
    guest.do("lesson_restart", until="The scene is reset.")
    catch_up(guest)
    assert shown_state(session)[3] == first
    guest.do("link", OWN, until=frequency_text(OWN_BEAM))
    guest.do("experiment", "stop")
    guest.press("R")
    guest.says("The scene is reset.")
    catch_up(guest)
    assert shown_state(session)[3][:2] == (SPUN, False)
    guest.do("link", "?gamma=3", until=frequency_text(Beam(gamma=3)))
    guest.do("experiment", "stop")
    guest.press("R")
    guest.says("The scene is reset.")
    catch_up(guest)
    assert shown_state(session)[3][:2] == (PULLED, False)


@pytest.mark.parametrize("name", [one.name for one in LESSONS if one.motion])
def test_the_motion_of_a_lesson_is_played_at_a_rate_that_suits_it(guest, session, name):
    """Its own: that of the modes of the scene may be ten times slower."""
    begin(guest, name)
    guest.wait(lambda _: session.snapshot.film)
    assert session.snapshot.rate == session.snapshot.film.rate


def test_a_file_ends_the_lesson(guest, session):
    """Which is about another scene: a reset returns to that of the file, and the address does not
    name a step."""
    guest.do("link", "")
    begin(guest, "spin-up")
    guest.do("lesson_step", 1, until=formatted(lesson("spin-up").meaning))
    guest.do("load", "beam.toml\n[beam]\ngamma = 4.0", until=frequency_text(Beam(gamma=4)))
    guest.wait(lambda _: guest.props["lesson"]["hidden"] is True)
    assert shown_state(session)[3][:2] == (PULLED, False)
    guest.do("gamma", 6.0, until=frequency_text(Beam(gamma=6)))
    guest.wait(lambda _: "gamma=6.0" in guest.parts["address"])
    assert "step=" not in guest.parts["address"]
    guest.press("R")
    guest.shows(Beam(gamma=4))


def test_back_to_a_lesson_and_out_of_it(guest, session):
    """By the history of the browser: what was before it is still returned to."""
    guest.do("link", OWN, until=frequency_text(OWN_BEAM))
    before = shown_state(session)
    guest.do("link", "?lesson=spin-up&step=2", until=formatted(lesson("spin-up").meaning))
    guest.do("link", "?lesson=nodes", until=formatted(lesson("nodes").question))
    guest.do("lesson", "")
    catch_up(guest)
    guest.shows(OWN_BEAM)
    assert shown_state(session) == before


def test_out_of_a_lesson_in_which_the_page_was_opened(guest):
    """As after a reload: the scene before is in no address, and the page says so; not where the
    lesson was begun on the page."""
    guest.do("link", "?lesson=nodes", until=formatted(lesson("nodes").question))
    guest.do("lesson", "", until="the page as it starts")
    guest.shows(PAPER)
    begin(guest, "nodes")
    guest.do("gamma", 3.0, until=frequency_text(lesson("nodes").scene.beam.replace(gamma=3)))
    guest.do("lesson", "", until="Your scene is back")


RIGHT, SLENDER = "Right!", "Put the slenderness μ back to 70 first."
# Controls to be set, by lesson, each with the words that the page shows then.
CHALLENGES = {
    "nodes": [("beta", 0.785, RIGHT)],
    "paradox": [("gamma", 3.5, RIGHT)],
    "crossing": [("mu", 80.0, "Not yet."), ("gamma", 4.5, SLENDER), ("mu", 70.0, RIGHT)],
    "no-equilibrium": [
        ("gamma", 31.0, "the root is stretched"),
        ("gamma", 40.0, "No equilibrium above γ = 31.489 with this material law"),
        ("gamma", 41.0, "Not yet."),
        ("gamma", 31.5, RIGHT),
    ],
}


@pytest.mark.parametrize("name", CHALLENGES)
def test_the_challenge_is_checked_continuously(guest, session, name):
    """Not yet, with the value or a change to undo, also without equilibrium; then right, a tick."""
    begin(guest, name)
    guest.do("lesson_step", 2, until=formatted(lesson(name).task))
    guest.says("Not yet.")
    guest.says("Now: ")
    for key, value, words in CHALLENGES[name]:
        guest.choose(key, value)
        catch_up(guest)
        wait_until(lambda: not session.visitor.solver.busy)
        catch_up(guest)
        assert words in guest.text
    assert f"{lesson(name).answer:.5g}" in guest.text
    guest.do("lesson", "", until=f"Challenges met: 1 of {len(LESSONS)}")


def test_no_page_waits_for_the_answer_of_a_challenge(guest, monkeypatch):
    """It opens while the answer is computed, with the scene of the lesson: whether it is met in
    that of the visitor is not known yet."""
    shown, release = lesson("crossing"), threading.Event()
    for computed in ("numbers", "answer"):
        monkeypatch.delitem(vars(shown), computed, raising=False)
    monkeypatch.setitem(vars(shown), "compute_fact", held_back(shown.compute_fact, release))
    try:
        begin(guest, shown.name)
        guest.choose("gamma", 4.464)
        guest.do("lesson_step", 2, until=formatted(shown.task))
        guest.shows(shown.scene.beam)
        assert AWAITED in guest.text
    finally:
        release.set()
    guest.says("Not yet.")


def test_keys_and_commands_work(guest):
    """Coriolis forces, pause and theme, which a reset keeps; lessons by title in the palette."""
    keys = {*re.findall('data-key="(.)"', guest.text), *map(str.lower, guest.commands)}
    assert set("12345prvhscd") <= keys
    guest.press("C")
    guest.says(frequency_text(PAPER, coriolis=True))
    for key, name, value in (
        ("P", "playing", False),
        ("D", "dark", True),
        ("R", "coriolis", False),
    ):
        guest.press(key)
        guest.wait(lambda _, name=name, value=value: guest.values.get(name) is value)
    assert (guest.values["playing"], guest.values["dark"]) == (False, True)
    guest.press("Lesson: " + lesson("veering").title)
    guest.says(formatted(lesson("veering").question))
