"""The lessons: begun, turned through, met and reset by a visitor."""

import re
import time
from collections.abc import Callable, Iterator
from functools import partial

import pytest
from live.visitor import PAPER, Visitor, frequency_text, visitor

from beamviz.beam import Beam
from beamviz.explorer import jobs
from beamviz.explorer.app import explorer
from beamviz.explorer.features.lessons import CONTROLS, formatted, points, tabs
from beamviz.lessons import LESSONS, lesson


@pytest.fixture
def guest(url) -> Iterator[Visitor]:
    """A new visitor."""
    with visitor(url) as visiting:
        yield visiting


def reads(guest: Visitor, words: str) -> None:
    """Wait until the open lesson has these words."""
    guest.wait(lambda _: words in guest.texts.get("lesson-text", ""))


def begin(guest: Visitor, name: str) -> None:
    """Choose a lesson."""
    guest.do("lesson", name)
    reads(guest, formatted(lesson(name).question))


def challenged(guest: Visitor, name: str) -> None:
    """Begin a lesson and go to its challenge."""
    begin(guest, name)
    guest.do("lesson_step", 2)
    reads(guest, formatted(lesson(name).task))


# Cards and steps


def test_a_card_for_every_lesson_invites_a_newcomer(guest):
    """With a picture; the scene is that of the server."""
    guest.says(f"{len(LESSONS)} short lessons")
    cards = guest.texts["tab-lessons"]
    pictures = re.findall("<svg.*?</svg>", cards)
    assert len(pictures) == len(LESSONS)
    assert len(set(pictures)) >= len(LESSONS) - 3
    assert not any("nan" in picture for picture in pictures)
    assert frequency_text(PAPER) in guest.text


def test_next_leads_through_every_page_and_back_again(guest):
    """Question, meaning with its number, challenge; then the next lesson; behind the last none."""
    for one in LESSONS[:2]:
        for words in (one.question, one.proof, one.task):
            guest.do("lesson_turn", 1)
            reads(guest, formatted(words))
    guest.do("lesson_turn", -1)
    reads(guest, LESSONS[1].proof)
    challenged(guest, LESSONS[-1].name)
    guest.do("lesson_turn", 1)
    guest.wait(lambda _: guest.props["lesson"]["hidden"] is True)


@pytest.mark.parametrize("one", LESSONS, ids=[one.name for one in LESSONS])
def test_what_is_to_be_done_points_at_controls(one):
    """Every control named in a lesson is one of the page."""
    for text in (one.do, one.see, one.meaning, one.task):
        for name in re.findall(r"\*\*(.+?)\*\*", text):
            assert name in CONTROLS
    assert points(one.do) or tabs(one)


@pytest.mark.slow
def test_a_lesson_brings_its_scene(guest):
    """The table is that of its beam and model."""
    for one in LESSONS:
        begin(guest, one.name)
        guest.says(frequency_text(one.scene.beam, **one.scene.options))


def test_a_lesson_fits_its_beam_into_the_picture(guest, monkeypatch):
    """The camera is where it is for who begins with that scene, however late the answer comes."""
    scene = lesson("buckling").scene
    with explorer(scene) as address, visitor(address) as other:
        wanted = other.camera
    slow = partial(late, jobs.solve)
    monkeypatch.setattr(jobs, "solve", slow)
    begin(guest, "buckling")
    guest.says(frequency_text(scene.beam))
    guest.wait(lambda _: guest.camera == pytest.approx(wanted, rel=1e-6))


def late(solve_: Callable, beam: Beam, **options):
    """A solution after a while."""
    time.sleep(0.4)
    return solve_(beam, **options)


def test_turning_a_page_leaves_the_beam_alone(guest):
    """Only the next lesson has a scene of its own."""
    begin(guest, "stiffening")
    guest.choose("gamma", 7.0)
    moved = frequency_text(Beam(gamma=7), plane="flapwise")
    guest.says(moved)
    guest.do("lesson_turn", 1)
    guest.says("proves it")
    assert moved in guest.text


def test_reset_brings_back_the_start_of_the_lesson(guest):
    """By the button among its pages, by that among the controls, and by the key."""
    begin(guest, "moving-mass")
    start = frequency_text(lesson("moving-mass").scene.beam)
    for again in (
        lambda: guest.do("lesson_restart"),
        lambda: guest.do("reset"),
        lambda: guest.press("R"),
    ):
        guest.choose("beta", 0.3)
        guest.says(frequency_text(Beam(alpha=1, beta=0.3)))
        again()
        guest.says(start)


@pytest.mark.parametrize(
    ("action", "value", "opened"),
    [
        ("tab", "tab-map", PAPER),
        ("link", "?gamma=3", Beam(gamma=3)),
        ("load", "beam.toml\n[beam]\ngamma = 4.0", Beam(gamma=4)),
    ],
    ids=["start", "link", "file"],
)
def test_without_a_lesson_reset_brings_back_the_opened_scene(guest, action, value, opened):
    """What the server was started with, or else a link or a file; also after a lesson."""
    guest.do(action, value)
    guest.says(frequency_text(opened))
    begin(guest, "moving-mass")
    guest.do("lesson", "")
    guest.choose("gamma", 20.0)
    guest.says(frequency_text(Beam(alpha=1, gamma=20)))
    guest.do("lesson_restart")
    guest.says(frequency_text(opened))


def test_a_scene_that_is_that_of_a_lesson_begins_it():
    """`beamviz serve --lesson nodes` opens the page there."""
    with explorer(lesson("nodes").scene) as address, visitor(address) as guest:
        guest.says(lesson("nodes").question)


def test_nonsense_opens_nothing(guest):
    """An unknown name, step or direction."""
    for value in ("Magic", 7, None, ["nodes"]):
        guest.do("lesson", value)
    for value in (-1, 3, "why", 1):
        guest.do("lesson_step", value)
        guest.do("lesson_turn", 5)
    begin(guest, "nodes")


# Challenges


@pytest.mark.parametrize(
    ("name", "label", "value"),
    [("nodes", "beta", 0.785), ("crossing", "gamma", 4.5), ("paradox", "gamma", 3.5)],
)
def test_the_answer_is_checked_live(guest, name, label, value):
    """Not yet, with what is measured; then right, with the computed answer, and a tick."""
    challenged(guest, name)
    guest.says("Not yet.")
    guest.wait(lambda _: "Now: " in guest.texts["verdict"])
    guest.choose(label, value)
    guest.says("Right!")
    answer = lesson(name).answer
    assert f"{answer:.5g}" in guest.text
    guest.do("lesson", "")
    guest.says(f"Challenges met: 1 of {len(LESSONS)}")


def test_what_is_in_the_way_of_the_answer_is_said(guest):
    """Another slenderness cannot meet the challenge."""
    challenged(guest, "crossing")
    guest.choose("mu", 80.0)
    guest.choose("gamma", 4.5)
    guest.says("Put the slenderness μ back to 70 first.")
    guest.choose("mu", 70.0)
    guest.says("Right!")


def test_beyond_the_last_equilibrium_the_challenge_still_answers(guest):
    """Where there is no solution nothing is measured, and the answer is still judged."""
    challenged(guest, "no-equilibrium")
    guest.says("the root is stretched")
    guest.choose("gamma", 40.0)
    guest.says("No equilibrium above γ = 31.49 with this material law")
    guest.says("Not yet.")
    guest.choose("gamma", 31.5)
    guest.says("Right!")


# Keys


def test_keys_do_what_the_controls_do(guest):
    """Modes and Coriolis; lessons by their titles in the palette."""
    keys = {*re.findall('data-key="(.)"', guest.text), *map(str.lower, guest.commands)}
    assert set("12345prvhscd") <= keys
    guest.press("C")
    with_coriolis = frequency_text(PAPER, coriolis=True)
    guest.says(with_coriolis)
    guest.press("Lesson: " + lesson("veering").title)
    guest.says(formatted(lesson("veering").question))


def test_a_key_pauses_and_another_makes_it_dark(guest):
    """The boxes of the panel follow."""
    guest.press("P")
    guest.wait(lambda _: guest.values.get("playing") is False)
    guest.press("D")
    guest.wait(lambda _: guest.values.get("dark") is True)
    guest.press("R")
    guest.wait(lambda _: guest.values.get("playing") is True)
    assert guest.values["dark"] is True
