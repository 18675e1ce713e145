"""The state of a visitor: what edits make of it, and controls that show it."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from live.visitor import PAPER

from beamviz.beam import Beam
from beamviz.explorer.declarations import choices_of
from beamviz.explorer.feature import tabs, usual_state
from beamviz.explorer.features.map import MapState
from beamviz.explorer.features.mass_drag import DragState, Grip
from beamviz.explorer.features.run_up import RunUpState
from beamviz.explorer.links import PAGE
from beamviz.explorer.state import EARLIER, PAUSE, Case, History, State
from beamviz.presets import preset
from beamviz.scene import Camera, Scene

START = State.of(Scene(PAPER))


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("gamma", 12.0, 12.0), ("gamma", "fast", "fast"),  # checked when the beam is solved
        ("strain", "hencky", "hencky"), ("strain", "rubber", "green"), ("coriolis", 1, True),
        ("plane", ["flapwise"], "chordwise"), ("colouring", "rainbow", "displacement"),
        ("pace", 9.0, 4.0), ("pace", math.nan, 1.0), ("shares", "all", (0.0, 1.0)),
        ("amplitude", "large", 0.15), ("amplitude", 1e9, 0.4), ("amplitude", math.inf, 0.15),
        ("over", "delta", "delta"), ("over", ["delta"], "gamma"), ("over", "speed", "gamma"),
        ("per_rev", [2, 1], (1, 2)), ("per_rev", [7], ()),
    ],
)  # fmt: skip
def test_an_edit_changes_one_value_and_an_invalid_one_none(name, value, expected):
    """A browser may send anything."""
    values = START.changed(name, value).values
    assert values[name] == expected
    assert values["alpha"] == START.values["alpha"]


@pytest.mark.parametrize(("name", "value"), [("method", "magic"), ("plane", "sideways")])
def test_a_choice_of_the_model_that_there_is_not_ends_nothing(name, value):
    """No run-up, and no viewpoint."""
    opened = State.of(Scene(PAPER, camera=Camera((1, 2, 3))))
    state = opened.with_values(RunUpState, run_speed=2.0, forced_response=True)
    assert state.changed(name, value) is state


def test_shares_of_modes_are_clamped_and_a_spin_up_bends_a_straight_beam():
    """To 0 .. 1, for modes that had none; one mode may be shown alone. With a spin-up there is no
    straight state; a state that was chosen is kept."""
    assert START.share(-5, 3).view.shares == (0.0, 1.0, 0.0, 0.0)
    assert START.only(2).view.shares == (0.0, 0.0, 1.0)
    state = START.changed("spin_up", 3.0)
    assert state.values["state"] == "stable"
    assert state.to_scene().beam == PAPER.replace(spin_up=3.0)
    assert START.changed("state", "bent").changed("spin_up", 3.0).values["state"] == "bent"
    assert START.changed("spin_up", 0.0) == START


def test_another_method_has_its_own_resolution():
    """No control shows the number of elements of a link, and not every method takes one."""
    case = Case.of(Scene(PAPER, {"method": "linear", "elements": 30}))
    assert case.changed("method", "ancf").options["elements"] == 30
    for method in ("auto", "chebyshev"):
        assert case.changed("method", method).options["elements"] is None


def test_a_fixed_viewpoint_is_dropped_if_the_beam_leaves_the_picture():
    """Other edits keep it."""
    state = START.loaded(Scene(PAPER, camera=Camera((1, 2, 3))))
    assert state.changed("gamma", 3.0).camera
    for name, value in (("plane", "flapwise"), ("rotating_frame", False), ("all_modes", True)):
        assert state.changed(name, value).camera is None


def test_the_axes_of_the_map_are_two_numbers():
    """One chosen for both takes the place of the other, also in a loaded scene."""
    scene, start = Scene(PAPER, over="alpha"), usual_state(Scene(PAPER), PAGE)
    loaded = start.loaded(scene)
    across = start.picked(choices_of(MapState)["across"], "gamma")
    for state in (start.changed("over", "alpha"), across, loaded):
        assert (state.over, state.slice(MapState).across) == ("alpha", "gamma")
    assert usual_state(scene, PAGE) == replace(loaded, opened=scene)


def test_charts_over_the_section_are_of_both_planes():
    """In one plane a usual axis takes its place, also that of the map. A blade has no ratio of its
    stiffnesses."""
    start = usual_state(Scene.of(plane="both", over="pitch"), PAGE)
    start = start.picked(choices_of(MapState)["across"], "flap")
    assert (start.over, start.slice(MapState).across) == ("pitch", "flap")
    assert {"flap", "pitch", "twist"} < {*start.case.axes}
    plane = start.changed("plane", "flapwise")
    assert (plane.over, plane.slice(MapState).across) == ("gamma", "alpha")
    assert plane.changed("over", "twist").over == "gamma"
    speed = start.picked(choices_of(MapState)["across"], "gamma").changed("plane", "chordwise")
    assert (speed.over, speed.slice(MapState).across) == ("gamma", "alpha")
    blade = start.loaded(Scene(preset("nrel-5mw-twisted-blade").beam, {"plane": "both"}))
    assert "flap" not in blade.case.axes
    assert blade.slice(MapState).across == "alpha"


def test_a_kept_case_belongs_to_its_scene():
    """Another scene drops it; keeping a case does not replace another comparison. A case has all
    options, so that cases with equal solutions are equal."""
    kept = START.keep_for_comparison()
    assert (kept.kept, kept.comparison) == (START.case, EARLIER)
    assert (kept.loaded(Scene()).kept, kept.loaded(Scene()).comparison) == (None, "nothing")
    assert START.changed("comparison", "mass").keep_for_comparison().comparison == "mass"
    case = START.changed("gamma", 3.0).keep().kept
    assert case == Case.of(Scene(PAPER.replace(gamma=3), {"strain": "green"}))
    assert case.changed("unknown", 1.0) is case
    assert case.beam == PAPER.replace(gamma=3)


def test_undo_and_redo_go_by_steps():
    """A drag of one slider is one step, also if it keeps the beam for comparison; another value, or
    a pause, begins another; an edit discards what could be redone. Theme and pause are no steps."""
    history, mass = History(), START.keep_for_comparison()
    *_, dragged = drag = [mass.changed("beta", 0.5 + 0.01 * k) for k in range(5)]
    rested = (faster := dragged.changed("gamma", 3.0)).changed("gamma", 4.0)
    last = (other := rested.loaded(Scene(Beam(gamma=2)))).changed("gamma", 5.0)
    states = [START, *drag, faster, rested, other, last]
    for k, (before, after) in enumerate(pairwise(states)):
        time = 0.1 * k + PAUSE * (after in (rested, other, last))
        history.record(before, after, time, loaded=after is other)
    back = [last := history.undo(last) for _ in range(5)]
    assert back == [other, rested, faster, dragged, START]
    assert history.undo(START) is START
    assert [history.redo(START), history.redo(dragged)] == [dragged, faster]
    history.record(faster, other := faster.only(0), 9.0)
    assert history.redo(other) is other
    history, still = History(), START.changed("dark", True).changed("playing", False)
    history.record(START, still, 0.0)
    assert history.undo(still) is still
    history.record(still, faster := still.changed("gamma", 3.0), 1.0)
    loud = faster.changed("dark", False)
    history.record(faster, loud, 2.0)
    assert history.undo(loud) == still.changed("dark", False)


def test_what_is_done_with_a_body_in_the_hand_is_one_step():
    """However long it is held still, and however soon after another one."""
    history, ray = History(), (np.zeros(3), np.ones(3))
    held = START.with_values(DragState, grip=Grip(ray, 0.0))
    moved = held.changed("beta", 0.6)
    rested = moved.changed("beta", 0.7)
    free = rested.with_values(DragState, grip=None)
    again = free.with_values(DragState, grip=Grip(ray, 0.0))
    last = again.changed("beta", 0.8)
    states, times = (START, held, moved, rested, free, again, last), (0, 1, 9, 9.1, 9.2, 9.3)
    for (before, after), time in zip(pairwise(states), times, strict=True):
        history.record(before, after, float(time))
    betas = [(last := history.undo(last)).case.numbers["beta"] for _ in range(3)]
    assert betas == [0.7, START.case.numbers["beta"], START.case.numbers["beta"]]


def test_each_tab_has_a_place_of_its_own():
    """Their order does not depend on which module is imported first."""
    places = [tab.place for tab in tabs(PAGE).values()]
    assert len(set(places)) == len(places) > 8
