"""Lessons of a teacher's own: written, shared, answered by pupils, counted in a lecture."""

import random
import re
import time
from typing import Any

import pytest
from live.browser import READY, page
from live.offline import Desk, lecture, offline
from live.visitor import catch_up, visitor

from beamviz.errors import InvalidInput
from beamviz.explorer import explorer, serve
from beamviz.explorer.features.lesson_player import (
    RIGHT,
    SENT,
    WRONG,
    OwnLessonState,
    is_lesson_file,
)
from beamviz.explorer.features.lessons import LessonState
from beamviz.explorer.presenter import Votes
from beamviz.lessons.lesson_file import LessonStep, OwnLesson, packed
from beamviz.scene import START

STILL = START.changed(playing=False)
LESSON = OwnLesson(
    (
        LessonStep(
            "gamma=2.0&mode=1", "Slow <i>&amp;</i>", "Is it stiffer?", ("yes", "no"), right=1
        ),
        LessonStep("gamma=10.0&tab=map&compare=mass", "Fast.", "And <b>now</b>?", ("more", "less")),
    ),
    "Stiffening",
)


def own(session: Any) -> OwnLessonState:
    return session.visitor.state.slice(OwnLessonState)


def opened(guest: Any) -> None:
    """Open the lesson as a file that is dropped."""
    guest.do("load", f"my.toml\n{LESSON.to_toml()}", until="Slow")


def test_a_teacher_keeps_scenes_writes_and_shares_them(guest, session):
    """By a link, which begins with the first scene, and by a file; both have the same lesson."""
    guest.do("link", "")
    guest.edit(gamma=2.0)
    guest.do("own.keep", until="1 scene<")
    for name, text in {"say": "Slow.", "ask": "Why?", "answer.1": "a", "answer.2": "b"}.items():
        guest.do(f"own.{name}", text)
    guest.do("own.right", 1)
    guest.edit(gamma=10.0)
    guest.do("own.keep", until="2 scenes<")
    guest.do("own.title", "Two speeds")
    guest.wait(lambda _: guest.values["own.tab"] == "frequencies")
    guest.do("own.tab", "map")
    catch_up(guest)
    lesson = own(session).own_lesson
    first, second = lesson.steps
    assert (first.say, first.ask, first.answers, first.right) == ("Slow.", "Why?", ("a", "b"), 1)
    assert "gamma=2.0" in first.link
    assert "tab=map" in second.link
    guest.do("own.save")
    catch_up(guest)
    assert OwnLesson.from_bytes(guest.client.downloads["lesson.toml"], "saved") == lesson
    query = re.search(r'data-copy="([^"]+)"', guest.text)[1].replace("&amp;", "&")
    guest.do("link", "?gamma=7", until=lambda _: guest.values["gamma"] == 7)
    assert own(session).own_lesson == OwnLesson()
    guest.do("link", f"?{query}", until="Two speeds")
    guest.wait(lambda _: guest.values["gamma"] == 2)
    assert own(session).own_lesson == lesson
    guest.do("own.turn", 1, until=lambda _: guest.parts.get("open") == "map")
    guest.wait(lambda _: guest.values["gamma"] == 10)


def test_a_lesson_that_is_too_long_for_a_link_is_a_file(guest, session):
    """The page says so; the address is without it."""
    texts = random.Random(1)
    steps = [
        LessonStep("gamma=1", say="".join(chr(texts.randrange(0x4E00, 0x9000)) for _ in range(400)))
        for _ in range(20)
    ]
    guest.do("link", "")
    guest.do("load", f"my.toml\n{OwnLesson(tuple(steps)).to_toml()}", until="save the file")
    assert 'data-copy="' not in guest.text
    guest.wait(lambda _: "own_" not in guest.parts["address"])
    guest.do("own.keep", until=lambda _: guest.said and "at most 20" in guest.said[-1]["text"])
    assert len(own(session).own_lesson.steps) == 20


def test_a_lesson_is_no_larger_than_a_file_that_can_be_opened(guest, session):
    """What would make it larger is refused, with the remedy."""
    steps = [LessonStep(f"gamma=1&tab={'x' * 6000}", say="s" * 300) for _ in range(10)]
    state = session.visitor.state.with_values(OwnLessonState, own_lesson=OwnLesson(tuple(steps)))
    session.visitor.update(lambda _: state)
    guest.do("own.say", "é" * 500, until=lambda _: guest.said)
    assert "at most 64000 bytes" in guest.said[-1]["text"]
    assert "make two lessons" in guest.said[-1]["text"]
    assert own(session).own_lesson.steps[0].say == "s" * 300
    guest.do("own.say", "Short.", until="1. Short.")


def test_writing_a_lesson_is_no_step_to_undo(guest, session):
    """An undo takes back the last edit of the scene; a removed scene is put back by its button."""
    guest.do("link", "")
    guest.edit(gamma=2.0)
    guest.do("own.keep", until="1 scene<")
    guest.do("own.say", "Slow.")
    guest.do("own.remove", until="Put the removed scene back")
    guest.do("own.restore", until="1. Slow.")
    guest.do("undo", until=lambda _: guest.values["gamma"] != 2)
    assert own(session).own_lesson.steps[0].say == "Slow."


def test_a_pupil_goes_through_a_lesson_and_answers_it(guest, session):
    """Texts are escaped; an answer is judged, can be changed, and is kept by the browser, which
    brings it back; after the last step the scene from before is back."""
    guest.do("link", "")
    guest.edit(gamma=4.0)
    opened(guest)
    guest.wait(lambda _: guest.values["gamma"] == 2)
    guest.says("Slow &lt;i&gt;&amp;amp;&lt;/i&gt;")
    guest.do("own.answer", 0, until=WRONG)
    guest.do("own.answer", 1, until=RIGHT)
    key = LESSON.steps[0].key
    guest.wait(lambda _: guest.parts["answers"] == [f"{key}:1"])
    guest.do("own.answer", 2)
    guest.do("gamma", 5.0, until=lambda _: guest.values["gamma"] == 5)
    guest.do("lesson_restart", until=lambda _: guest.values["gamma"] == 2)
    guest.do("own.turn", 1, until="And &lt;b&gt;now&lt;/b&gt;?")
    guest.wait(lambda _: guest.values["comparison"] == "mass")
    guest.do("own.turn", -1, until=RIGHT)
    guest.do("own.turn", 1, until="Finish")
    guest.do("own.turn", 1, until=lambda _: guest.values["gamma"] == 4)
    assert guest.props["lesson"]["hidden"] is True
    assert session.visitor.state.slice(LessonState).before_lesson is None
    guest.do("answers", f"abc1 {key}:0 nonsense {key}:9 zz:1")
    guest.do("own.go", 0, until=WRONG)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("[[step]]\nlink = 'gamma=300'", "bad.toml, step 1: gamma = 300: must lie in"),
        ("[[step]]\nlink = ''", "bad.toml, step 1: link = '': has no scene"),
        ("[[step]]\nlink = 'lesson=nodes&guess=9'", "step 1: guess = 9: must be"),
        ("[[step]]\nlink = 'elements=1000&method=linear'", "a page solves with at most"),
    ],
)
def test_a_wrong_scene_of_a_file_is_named(guest, session, content, words):
    """And nothing changes."""
    guest.do("load", f"bad.toml\n{content}", until=lambda _: guest.said)
    assert words in guest.said[-1]["text"]
    assert own(session).own_lesson == OwnLesson()


def test_a_file_of_empty_lines_is_told_from_a_lesson_at_once():
    """The event loop, which serves all visitors, waits for it."""
    began = time.monotonic()
    assert not is_lesson_file("\n" * 128_000 + "[[" + " " * 64_000)
    assert is_lesson_file("title = 'x'\n\t[[ step ]]")
    assert time.monotonic() - began < 1


def test_a_wrong_step_of_a_link_is_named(guest):
    """The lesson is there nevertheless."""
    guest.do("link", f"?own_lesson={packed(LESSON)}&own_step=3", until="2 scenes<")
    assert "own_step = 3: must be a whole number in 1 .. 2" in guest.said[-1]["text"]
    guest.do("link", "?own_step=1", until=lambda _: "no own_lesson" in guest.said[-1]["text"])


def test_a_presenter_sees_how_many_have_chosen_what():
    """Live, each visitor once, also after a return; the visitors do not see it, nor which answer is
    right until it is shown; to answer does not end that they follow."""
    with offline():
        lead, one, other = Desk(STILL), Desk(STILL), Desk(STILL)
        votes = Votes(lead.visitor.wake)
        for desk in (lead, one, other):
            desk.visitor.votes = votes
        lead.visitor.presents, votes.present = True, 2
        rounds = [lecture(lead, desk) for desk in (one, other)]
        for desk, name in ((one, "anna"), (other, "ben")):
            desk.visitor.may_follow = True
            desk.do("answers", f"{name} ")
        lead.do("load", f"my.toml\n{LESSON.to_toml()}")

        def shown() -> list[str]:
            for both in rounds:
                both(2)
            for desk in (lead, one, other):
                desk.guest.visitor.receive()
            return [desk.guest.visitor.texts["own-step"] for desk in (lead, one, other)]

        assert "0 answered, 2 pages open" in shown()[0]
        one.do("own.answer", 0)
        other.do("own.answer", 1)
        of_lead, of_one, of_other = shown()
        assert counts(of_lead) == [1, 1]
        assert SENT in of_one
        assert SENT in of_other
        assert "answered" not in of_one
        other.do("own.answer", 0)
        assert counts(shown()[0]) == [2, 0]
        for name in ("anna", "carl"):  # their page was loaded again; a name is taken once
            one.do("answers", f"{name} {LESSON.steps[0].key}:0")
        lead.do("own.show_answer")
        of_lead, of_one, _ = shown()
        assert counts(of_lead) == [2, 0]
        assert "✓" in of_lead
        assert "<b>no\u00a0✓</b>" in of_one
        assert "Your answer: yes" in of_one
        one.do("own.answer", 1)  # too late
        assert counts(shown()[0]) == [2, 0]
        assert one.state.following
        lead.do("own.turn", 1)
        of_lead, of_one, _ = shown()
        assert counts(of_lead) == [0, 0]
        assert "✓" not in of_one


@pytest.mark.slow
def test_an_answer_stays_in_the_browser():
    """Also after a reload; the field of a scene that was kept has the focus."""
    with explorer(STILL) as url, page(url, 390, 844) as opened:
        opened.wait(READY)
        opened.open_tab("lessons")
        opened.click("document.querySelector('.own summary')")
        opened.click("document.querySelector('[data-do=\"own.keep\"]')")
        opened.wait("document.activeElement.id === 'own-say'")
        typed = {"own-say": "Look at this.", "own-ask": "Why so?"}
        for name, text in typed.items():  # at once, while the server answers the field before
            opened.click(f"document.getElementById('{name}')")
            opened.call("Input.insertText", text=text)
        opened.catch_up()
        for name, text in typed.items():
            assert opened.evaluate(f"document.getElementById('{name}').value") == text
        query = f"own_lesson={packed(LESSON)}&own_step=1"
        opened.evaluate(f"location.search = '?{query}'")
        chosen = "document.querySelector('#lesson .guesses button:last-child')"
        opened.wait(f"{READY} && !!{chosen}")
        opened.click(chosen)
        opened.wait(f"document.body.innerText.includes('{RIGHT}')")
        opened.reload()
        opened.wait(f"{READY} && {chosen}?.ariaPressed === 'true'")
        opened.key("n", "document.body.innerText.includes('2 of 2')")
        opened.key("b", "document.body.innerText.includes('1 of 2')")


def counts(text: str) -> list[int]:
    """The numbers in the table of votes."""
    return [int(count) for count in re.findall(r"<td>(\d+)</td>", text)]


def test_votes_reach_the_presenter_and_stay_when_a_visitor_leaves():
    """As a phone that is locked."""
    key = "k" * 22
    with (
        explorer(STILL, presenter_key=key, lesson=LESSON) as url,
        visitor(url) as one,
        visitor(f"{url}/?token={key}") as lead,
    ):
        with visitor(url) as other:
            lead.says("0 answered, 2 pages open")
            other.do("answers", "ben ")
            other.says("1 of 2")
            other.do("own.answer", 1)
            lead.says("1 answered, 2 pages open")
        lead.says("1 answered, 1 page open")
        one.do("own.answer", 1)
        lead.says("2 answered, 1 page open")


def test_who_follows_a_presenter_keeps_the_lesson_that_they_write():
    """The presenter's lesson is shown, also after an edit has ended that; the right answers are
    nowhere to edit."""
    with offline():
        lead, pupil = Desk(STILL), Desk(STILL)
        lead.visitor.presents = pupil.visitor.may_follow = True
        pupil.do("own.keep")
        pupil.do("own.say", "Mine.")
        written = own(pupil).own_lesson
        lead.do("load", f"my.toml\n{LESSON.to_toml()}")
        lecture(lead, pupil)(2)

        def step() -> str:
            pupil.frame(2)
            pupil.guest.visitor.receive()
            return pupil.guest.visitor.texts["own-step"]

        assert "Is it stiffer?" in step()
        assert pupil.guest.visitor.values["own.right"] is None
        pupil.do("gamma", 3.0)
        assert "Is it stiffer?" in step()
        pupil.do("own.turn", 1)
        assert "2 of 2" in step()
        assert own(pupil).own_lesson == written
        pupil.do("own.go", 0)
        assert "Mine." in step()
        pupil.do("lesson", "")
        assert step() == ""


def test_a_lesson_that_another_has_replaced_is_brought_back(guest, session):
    """Of a file or a link, or a link without one; what was removed is no part of the new lesson."""
    guest.do("link", "")
    guest.do("own.keep", until="1 scene<")
    guest.do("own.keep", until="2 scenes<")
    guest.do("own.say", "Mine.")
    guest.do("own.edit", 0)
    guest.do("own.remove", until="Put the removed scene back")
    written = own(session).own_lesson
    opened(guest)
    guest.says("Bring back the lesson before")
    assert "Put the removed scene back" not in guest.text
    guest.do("own.bring_back", until="1. Mine.")
    assert own(session).own_lesson == written
    guest.do("own.bring_back", until="1. Slow")
    guest.do("link", "?gamma=7", until=lambda _: guest.values["gamma"] == 7)
    assert own(session).own_lesson == OwnLesson()
    guest.do("own.bring_back", until="1. Slow")
    guest.do("own.bring_back", until="1. Mine.")


def test_votes_take_no_more_than_there_is_room_for(monkeypatch):
    """Whatever a browser sends: the latest voters, and of each the latest votes."""
    monkeypatch.setattr("beamviz.explorer.presenter.MOST_VOTERS", 2)
    monkeypatch.setattr("beamviz.explorer.presenter.MOST_VOTES", 2)
    votes = Votes()
    for voter in "abc":
        for question in "xyz":
            votes.cast(voter, question, 0)
    votes.cast("b", "y", 1)
    earlier = votes.counts
    votes.cast("d", "z", 1)
    assert earlier == {"y": {0: 1, 1: 1}, "z": {0: 2}}
    assert votes.counts == {"y": {1: 1}, "z": {0: 1, 1: 1}}


def test_a_server_opens_every_page_in_a_lesson(tmp_path):
    """(`beamviz serve --lesson FILE`.) On its plain address; leaving it returns to the scene of the
    server; one with a wrong scene does not start."""
    with explorer(START, lesson=LESSON) as url, visitor(url) as guest:
        guest.do("link", "", until="Slow")
        guest.wait(lambda _: guest.values["gamma"] == 2)
        guest.wait(lambda _: guest.parts["address"] == "")
        guest.do("lesson", "", until=lambda _: guest.values["gamma"] == START.beam.gamma)
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(OwnLesson((*LESSON.steps, LessonStep("gamma=999"))).to_toml())
    with pytest.raises(InvalidInput, match=r"wrong.toml, step 3: gamma = 999: must lie in"):
        serve(START, lesson_file=wrong)


def test_undo_after_a_removal_shows_a_step_that_is_there(guest):
    """The step of an earlier state may be gone."""
    guest.do("link", "")
    opened(guest)
    guest.do("own.turn", 1, until="Fast.")
    guest.do("own.turn", -1, until="Slow")
    guest.do("own.edit", 1)
    guest.do("own.remove", until="1 scene<")
    guest.do("undo", until="Slow")
