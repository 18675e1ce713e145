"""The lesson of a teacher as a file and as a text in a link."""

import base64
import re
import zlib

import pytest

from beamviz.errors import InvalidInput
from beamviz.input_files import MAX_TOML_BYTES
from beamviz.lessons.lesson_file import MAX_STEPS, LessonStep, OwnLesson, packed, unpacked

LESSON = OwnLesson(
    (
        LessonStep("gamma=0.0&mode=1", "At rest.\nLook: “B1”\x7f 😀", 'Is "B1" <b>3.5</b>?'),
        LessonStep("gamma=10.0&mode=1", "", "Faster?", ("yes", "no", "it depends"), right=2),
        LessonStep("alpha=1.0"),
    ),
    "Why do blades stiffen?",
)


def test_a_lesson_is_the_same_after_a_file_and_after_a_link(tmp_path):
    """With texts in any characters; the text of a link has those that an address has as they are,
    and a short lesson is short."""
    path = tmp_path / "lesson.toml"
    path.write_text(LESSON.to_toml(), encoding="utf-8")
    assert OwnLesson.from_toml(path) == LESSON
    text = packed(LESSON)
    assert unpacked(text) == LESSON
    assert re.fullmatch(r"[\w-]+", text, re.ASCII)
    assert len(text) < 400


def test_a_scene_may_be_the_tables_of_a_scene_file():
    """Which become the link to it."""
    tables = b"[[step]]\nsay = 'a'\n[step.scene.beam]\ngamma = 3\n[step.scene.view]\nmode = 3"
    (step,) = OwnLesson.from_bytes(tables, "a.toml").steps
    assert step == LessonStep("gamma=3.0&mode=3", "a")


STEP = "[[step]]\nlink = 'gamma=1'\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[[step]", "a.toml: not a TOML file"),
        ("", "a.toml: a lesson has at least one table"),
        ("step = 3", "a.toml: step = 3: must be tables [[step]]"),
        ("title = 3", "a.toml: title = 3: must be a text of at most 80 characters"),
        (STEP + "asks = 'a'", "a.toml, step 1: [[step]]: unknown key 'asks'"),
        (STEP + STEP + "say = 1", "a.toml, step 2: say = 1: must be a text of at most 500"),
        (STEP + f"ask = '{'a' * 301}'", "has 301 characters; shorten it to 300"),
        (STEP + "answers = ['a']", "answers = ['a']: must be 2 to 4 texts, or be left out"),
        (STEP + "answers = ['a', ' ']", "an answer is empty; write it or remove it"),
        (STEP + "answers = ['a', 'a']", "two answers are the same; change one"),
        (STEP + "answers = ['a', 'b']\nright = 3", "right = 3: must be a whole number in 1 .. 2"),
        (STEP + "right = 1", "right = 1: there are no answers; add answers"),
        ("[[step]]\nsay = 'a'", "step 1: a step has a scene: either link or tables [step.scene]"),
        ("[[step]]\nlink = 'own_step=1'", "link: has the key 'own_step'"),
        ("[[step]]\n[step.scene.beam]\ngamma = -1", "step 1: scene: gamma = -1: must"),
        ("[[step]]\n[step.scene.beams]\ngamma = 1", "step 1: scene: unknown key 'beams'"),
        (STEP * (MAX_STEPS + 1), "21 tables [[step]]: a lesson has at most 20"),
    ],
)
def test_a_wrong_value_is_named_with_its_file_its_step_and_the_remedy(text, words):
    with pytest.raises(InvalidInput) as error:
        OwnLesson.from_bytes(text.encode(), "a.toml")
    assert words in str(error.value)


def bomb() -> str:
    """A short text of a very long file."""
    compressed = zlib.compress(b"#" * 50_000_000, 9)
    return base64.urlsafe_b64encode(compressed).decode()


@pytest.mark.parametrize("text", [packed(LESSON)[:-9], "a", "é", "", 3, [1], packed(LESSON)[4:]])
def test_a_link_that_was_cut_off_is_refused(text):
    with pytest.raises(InvalidInput, match=r"own_lesson = .*: is not a whole lesson; copy the"):
        unpacked(text)


def test_a_link_does_not_unpack_more_than_a_file_has():
    with pytest.raises(InvalidInput, match=f"larger than {MAX_TOML_BYTES} bytes"):
        unpacked(bomb())
