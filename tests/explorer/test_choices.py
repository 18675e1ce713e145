"""Choices of the visitor: each is declared once, and controls, undo and links know it."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

import pytest
from live.visitor import PAPER, visitor

from beamviz.explorer import explorer, links, page
from beamviz.explorer.blade_table import Draft
from beamviz.explorer.declarations import Tab, choice, choices_of, name_key
from beamviz.explorer.feature import Feature, usual_state
from beamviz.explorer.features.blade import BladeState
from beamviz.explorer.features.files import FileState
from beamviz.explorer.features.lessons import LessonState
from beamviz.explorer.features.map import MapState
from beamviz.explorer.features.method_timing import TimingState
from beamviz.explorer.links import PAGE, linked, linked_choices, parse_link, query_of
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.state import SHARED, History, Slice, State
from beamviz.scene import KEYS, Scene

START = usual_state(Scene(PAPER), PAGE)
GRIDS = ("none", "coarse", "fine")


def new_feature() -> type[Feature]:
    """A feature as its file would declare it: a tab with one control, and what it shows."""

    @dataclass(frozen=True)
    class MarksState(Slice):
        grid_of_marks: str = field(
            default="none",
            metadata=choice(values=GRIDS, key=name_key("grid", GRIDS), until=("scene",)),
        )

    class Marks(Feature):
        tab = Tab(
            "Marks",
            20,
            "A grid of marks",
            page.select("grid_of_marks", "grid", GRIDS) + '<p id="grid-text"></p>',
        )
        state = MarksState

        def content(self, snapshot: Snapshot) -> Content:
            grid = snapshot.state.slice(MarksState).grid_of_marks
            return page.html("grid-text", f"The grid is {grid}.")

    return Marks


@pytest.fixture
def marks_url(monkeypatch) -> Iterator[str]:
    """A running explorer with one more feature."""
    monkeypatch.setattr(links, "PAGE", (*links.PAGE, new_feature()))
    with explorer(Scene(PAPER)) as url:
        yield url


def test_a_new_feature_is_one_class(marks_url):
    """Its control is bound; undo, redo and links know its choice, which ends as it declares; what
    is none of its values is refused."""
    with visitor(marks_url) as guest, visitor(marks_url) as later:
        guest.do("link", "")
        guest.do("tab", "marks", until="The grid is none.")
        guest.choose("grid_of_marks", "fine", until="The grid is fine.")
        guest.wait(lambda _: guest.values["grid_of_marks"] == "fine")
        guest.wait(lambda _: "grid=fine" in guest.parts["address"])
        guest.do("grid_of_marks", "huge")
        guest.do("undo", until="The grid is none.")
        guest.wait(lambda _: "grid=" not in guest.parts["address"])
        guest.do("redo", until="The grid is fine.")
        guest.wait(lambda _: "grid=fine" in guest.parts["address"])
        later.do("link", f"?{guest.parts['address']}", until="The grid is fine.")
        later.wait(lambda _: later.values["grid_of_marks"] == "fine")
        later.wait(lambda _: later.parts["open"] == "marks")
        later.do("link", "?grid=huge", until=lambda _: later.said)
        assert "grid = 'huge': must be one of none, coarse, fine" in later.said[-1]["text"]
        later.do("link", "?gamma=3", until="The grid is none.")
        guest.do("real.preset", "steel beam", until="The grid is none.")


@pytest.mark.parametrize(
    ("undo", "undone", "redone"), [("changes", 1, 2), ("keeps", 3, 4), ("ends", 0, 0)]
)
def test_undo_does_with_a_choice_what_it_declares(undo, undone, redone):
    """It changes it back, or leaves it as it is now, or ends it; only a change is a step."""

    @dataclass(frozen=True)
    class Numbered(Slice):
        number: int = field(default=0, metadata=choice(undo=undo))

    history, before = History(), START.with_values(Numbered, number=1)
    after = before.changed("gamma", 3.0).with_values(Numbered, number=2)
    assert after.differences(before) == {"gamma"} | ({"number"} if undo == "changes" else set())
    history.record(before, after, 0.0)
    now = after if undo == "changes" else after.with_values(Numbered, number=3)
    back = history.undo(now)
    assert (back.slice(Numbered).number, back.case) == (undone, before.case)
    now = back if undo == "changes" else back.with_values(Numbered, number=4)
    assert history.redo(now).slice(Numbered).number == redone


def test_the_ends_of_a_map_last_as_long_as_its_axes():
    """And its scene; not only as long as its beam."""
    state = START.with_values(MapState, map_ends=(19.0, 1.0))
    assert state.changed("gamma", 3.0).slice(MapState).map_ends == (19.0, 1.0)
    across = state.picked(choices_of(MapState)["across"], "mu")
    for other in (state.changed("over", "delta"), across, state.loaded(Scene())):
        assert other.slice(MapState).map_ends is None


def state_of_link(query: str, before: State = START) -> State:
    """The state that a page shows on a link."""
    link = parse_link(query)
    assert link
    assert link.scene
    return linked(before, link.scene, link.values)


def test_a_link_without_a_choice_has_the_usual_one():
    """Whatever the page has shown before."""
    state = state_of_link("methods=true&map=3&lesson=nodes&step=2&film=1+period")
    named = {TimingState: "time_methods", MapState: "mapped", LessonState: "step"}
    choices = [
        choices_of(kind)[name] for kind, name in (named | {FileState: "film_length"}).items()
    ]
    assert [state[one] for one in choices] == [True, 3, 1, "1 period"]
    later = state_of_link("gamma=3", state)
    assert [later[one] for one in choices] == [one.usual for one in choices]


def test_tables_as_typed_are_left_out_of_a_link_without_room_for_them():
    """Which keeps all else."""
    short = Draft((("0", "1", "2", "3", "", ""), ("x", "1", "2", "3", "", "")))
    long = short._replace(stations=tuple(("1" * 40, "2", "3", "4", "", "") for _ in range(200)))
    state = state_of_link("gamma=3&film=1+period")
    with_room, without = (
        query_of(state.with_values(BladeState, draft=draft), START) for draft in (short, long)
    )
    assert state_of_link(with_room).slice(BladeState).draft == short
    assert without == query_of(state, START)
    assert "film=" in without


def test_names_and_keys_of_choices_are_unique():
    """Those of all features, of the state and of a scene."""
    own = [one.name for kind in PAGE for one in kind.choices()]
    keys = [
        one.key.name
        for one in (*SHARED.values(), *(one for kind in PAGE for one in kind.choices()))
        if one.key
    ]
    assert max(Counter([*own, *START.values]).values()) == 1
    assert max(Counter([*keys, *KEYS]).values()) == 1
    assert {*keys} == {*linked_choices()}


@pytest.mark.parametrize(
    "before", ["over=alpha", "over=beta", "across=beta", "over=beta&across=mu"]
)
@pytest.mark.parametrize(
    ("query", "axes"),
    [
        ("gamma=2", ("gamma", "alpha")),
        ("over=alpha", ("alpha", "gamma")),
        ("over=alpha&across=gamma", ("alpha", "gamma")),
        ("over=alpha&across=alpha", ("gamma", "alpha")),
        ("over=beta", ("beta", "alpha")),
        ("across=mu", ("gamma", "mu")),
    ],
)
def test_the_axes_of_a_link_do_not_depend_on_those_before(before, query, axes):
    """Also where only one is named, which takes the place of the other one."""
    state = state_of_link(query, state_of_link(before))
    assert (state.over, state.slice(MapState).across) == axes
