"""Two beams on one clock, small multiples, and the mass as a handle that leaves a ghost."""

import math
import re
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from beamviz.explorer.solve_queue import Turns
from hypothesis import given
from hypothesis import strategies as st
from live.visitor import PAPER, Visitor, visitor

from beamviz.beam import Beam
from beamviz.drawing import camera
from beamviz.drawing.all_modes import Multiples, heights, title
from beamviz.drawing.beam_view import BeamView
from beamviz.drawing.modes import Clock, Shapes, displacement
from beamviz.drawing.objects import placed
from beamviz.explorer.features import comparison as compare_tab
from beamviz.explorer.features import loci_tab as chart_tab
from beamviz.explorer.features.comparison import (
    BEFORE,
    CHOICES,
    NOTHING,
    OVERLAID,
    RULES,
    STACKED,
    Against,
    Comparison,
    against,
)
from beamviz.explorer.features.loci_chart import LANES, Charts, Point, Question, series
from beamviz.explorer.features.mass_drag import Grip, nearest
from beamviz.explorer.state import Case
from beamviz.scene import ViewOptions
from beamviz.server import run_server
from beamviz.solver import solve

WANTED = Case.of(Scene(PAPER))
GHOST = "/stage/wheel/ghost"
unit = st.floats(-1, 1)
points = st.tuples(unit, unit, unit).map(np.array)


def compared(api: Any, choice: str, wanted: Case = WANTED) -> Comparison:
    """A comparison that has its answer."""
    with ThreadPoolExecutor(1) as pool:
        comparison = Comparison(api, Turns(pool), lambda: None)
        comparison.choose(choice)
        comparison.follow(wanted)
    return comparison


# What is compared


def other(choice: str, wanted: Case) -> Case:
    """What a beam is compared with."""
    found = against(choice, wanted, None)
    assert isinstance(found, Against)
    return found.wanted


def test_each_rule_changes_one_thing():
    """The paper's elements, Coriolis forces, the mass; from the other side, the other way round."""
    assert other("the paper's elements", WANTED) == WANTED.changed("method", "ancf")
    assert (
        other("the paper's elements", WANTED.changed("method", "ancf")).options["method"] == "auto"
    )
    assert other("Coriolis on / off", WANTED) == WANTED.changed("coriolis", True)
    assert other("Coriolis on / off", WANTED.changed("coriolis", True)).options["coriolis"] is False
    assert other("twice the mass", WANTED).numbers == {**WANTED.numbers, "alpha": 2}
    assert set(CHOICES) == {NOTHING, BEFORE, *RULES}


def test_where_there_is_nothing_to_compare_with_words_say_so():
    """No mass to double, nothing kept, no Coriolis out of the plane; nothing chosen is no fault."""
    assert against(NOTHING, WANTED, None) == ""
    assert "no mass to double" in str(against("twice the mass", WANTED.changed("alpha", 0.0), None))
    assert "Nothing is kept" in str(against(BEFORE, WANTED, None))
    flapwise = WANTED.changed("plane", "flapwise")
    assert "choose chordwise" in str(against("Coriolis on / off", flapwise, None))


def test_the_table_pairs_modes_by_their_names():
    """alpha 1 against 2 at the tip: S1 is fourth, then third; each is compared with itself."""
    one, two = solve(Beam(alpha=1, beta=1)), solve(Beam(alpha=2, beta=1))
    assert (one.labels.index("S1"), two.labels.index("S1")) == (3, 2)
    html = compare_tab.compared(("this", one), ("other", two))
    cells = re.search(r"<b>S1</b></td><td>([\d.]+)</td><td>([\d.]+)</td><td>([-+\d.]+) %", html)
    assert cells
    first, second = one.frequencies[3], two.frequencies[2]
    assert float(cells[1]) == pytest.approx(first, rel=1e-5)
    assert float(cells[2]) == pytest.approx(second, rel=1e-5)
    assert float(cells[3]) == pytest.approx(100 * (second / first - 1), abs=0.5)


# How it is drawn


@pytest.mark.parametrize("layout", [OVERLAID, STACKED])
def test_both_beams_run_on_one_clock(layout):
    """After the same time each mode has moved on by its own frequency, from the same phase."""
    shapes = Shapes.sampled(solve(PAPER))
    clock = Clock(phases=np.linspace(0, 1, 5))
    with run_server() as server:
        comparison = compared(server.scene, "twice the mass")
        comparison.stack(layout)
        comparison.show(shapes, clock, ViewOptions(), [1])
        twice = solve(PAPER.replace(alpha=2))
        comparison.move(0.01, shapes, 0.15 * np.eye(5)[1])
        for k, label in enumerate(twice.labels):
            start = clock.phases[shapes.labels.index(label)]
            assert comparison.clock.phases[k] == pytest.approx(start + 0.01 * twice.frequencies[k])
        assert comparison.shapes
        other = comparison.ghost if layout == OVERLAID else comparison.scene.scene
        drawn = other.shapes
        moved = displacement(drawn, comparison.clock.phases, 0.15 * np.eye(5)[1])
        centreline, _ = placed(drawn, drawn.centreline + moved)
        if layout == OVERLAID:
            assert comparison.ghost
            rings = comparison.ghost.body.vertices.reshape(len(drawn.x), 4, 3).mean(axis=1)
            assert np.allclose(rings, centreline, atol=1e-6)
            assert np.allclose(comparison.ghost.mass.position, centreline[drawn.mass])
        else:
            assert comparison.scene
            middle = (centreline[:-1] + centreline[1:]) / 2
            second = comparison.scene.scene
            assert np.allclose(second.beam.batched_positions, middle, atol=1e-6)
            assert second.stage.position[2] == max(comparison.levels) == -min(comparison.levels)
            assert second.ground.grid.visible is False


def test_a_comparison_leaves_when_it_is_given_up():
    """Nothing of it is seen any more, whichever way it was drawn."""
    shapes = Shapes.sampled(solve(PAPER))
    with run_server() as server:
        comparison = compared(server.scene, "twice the mass")
        for layout in (OVERLAID, STACKED):
            comparison.stack(layout)
            comparison.show(shapes, Clock(phases=np.zeros(5)), ViewOptions(), [1])
        assert comparison.ghost
        assert comparison.scene
        assert (comparison.ghost.root.visible, comparison.scene.scene.stage.visible) == (
            False,
            True,
        )
        comparison.choose(NOTHING)
        comparison.follow(WANTED)
        comparison.show(shapes, Clock(phases=np.zeros(5)), ViewOptions(), [1])
        assert comparison.scene.scene.stage.visible is False
        assert comparison.levels == [0.0]


def test_small_multiples_show_each_mode_by_itself():
    """Five scenes above each other; in the k-th the beam moves as mode k; titles name them."""
    shapes = Shapes.sampled(solve(PAPER))
    with run_server() as server:
        multiples = Multiples(server.scene)
        multiples.show(shapes, ViewOptions(all_modes=True))
        multiples.move(np.full(5, math.pi / 2), 0.15, 0.0)
        levels = [part.scene.stage.position[2] for part in multiples.scenes]
        assert levels == heights(5) == sorted(levels, reverse=True)
        for k, part in enumerate(multiples.scenes):
            drawn = part.scene.shapes
            moved = displacement(drawn, np.full(5, math.pi / 2), 0.15 * np.eye(5)[k])
            line, _ = placed(drawn, drawn.centreline + moved)
            middle = (line[:-1] + line[1:]) / 2
            assert np.allclose(part.scene.beam.batched_positions, middle, atol=1e-6)
            assert part.title.text == title(shapes, k)
            assert shapes.labels[k] in part.title.text
        multiples.hide()
        assert not any(part.scene.stage.visible for part in multiples.scenes)


def test_all_scenes_above_each_other_are_inside_the_picture():
    """The highest and the lowest one, in a tall picture and in a wide one."""
    shapes = Shapes.at_rest(PAPER, "chordwise")
    for aspect in (0.6, 2.0):
        position = camera.viewpoint(shapes, True, aspect, 0.1, heights(5))
        for height in heights(5):
            corners = camera.corners(shapes, True) + [0, 0, height]
            seen = (corners - position) @ camera.axes(position)
            tall = math.tan(camera.FIELD_OF_VIEW / 2)
            assert np.abs(seen[:, 0] / seen[:, 2]).max() <= tall * aspect
            assert np.abs(seen[:, 1] / seen[:, 2]).max() <= tall


def test_the_loci_compared_with_are_drawn_under_the_chart():
    """They are those of the other beam at the same speeds, as far as the picture goes."""
    question = Question.of(WANTED, "gamma")
    twice = question.asked_of(other("twice the mass", WANTED))
    assert (twice.start, twice.stop, twice.over) == (question.start, question.stop, question.over)
    answered = Charts.answered
    chart, second = answered(None, question), answered(None, twice)  # type: ignore[arg-type]
    assert second.loci
    room = 4
    point = Point.of(solve(PAPER), "gamma")
    x, *lines = series(chart, point, LANES, per_rev=False, second=second, second_room=room)
    assert 1 + len(lines) == len(chart_tab.styles(LANES, room))
    own = lines[-2 - 3 * room : -2]
    k = int(np.searchsorted(x, 10.0))
    drawn = sorted(float(line[k]) for line in own if np.isfinite(line[k]))
    assert drawn == pytest.approx(solve(PAPER.replace(alpha=2)).frequencies, rel=1e-6)


# The mass as a handle


@given(points, points, points, st.floats(-2, 2), st.floats(0.1, 5))
def test_the_place_on_a_line_nearest_to_a_line_of_sight(start, along, eye, place, far):
    """Looking at a point of the line gives that point; whatever is found, no other is nearer."""
    if np.linalg.norm(along) < 0.1:
        along = along + [1.0, 0, 0]
    along = along / np.linalg.norm(along)
    target = start + place * along
    if np.linalg.norm(target - eye) < 0.1:
        return
    found = nearest(start, along, eye, eye + far * (target - eye))
    sight = (target - eye) / np.linalg.norm(target - eye)
    if found is None:
        assert abs(along @ sight) > 0.99
    else:
        assert found == pytest.approx(place, abs=1e-6)


def test_no_line_of_sight_is_no_place():
    """Along the beam, from the point itself, or not a number."""
    x, origin = np.array([1.0, 0.0, 0.0]), np.zeros(3)
    assert nearest(origin, x, -3 * x, origin) is None
    assert nearest(origin, x, origin, origin) is None
    assert nearest(origin, x, np.array([0.0, -3.0, 1.0]), np.full(3, np.nan)) is None


@pytest.mark.parametrize("rotating_frame", [True, False])
def test_a_place_on_the_stretched_beam_is_its_reference_point(rotating_frame):
    """Riding on the hub or beside it, turned: what is seen on the beam is where it is on it."""
    shapes = Shapes.sampled(solve(PAPER.replace(delta=0.5, gamma=40)))
    with run_server() as server:
        scene = BeamView(server.scene)
        scene.show(shapes, ViewOptions(rotating_frame=rotating_frame), [0])
        scene.move(np.zeros(5), np.zeros(5), angle=0.7)
        eye = np.array([0.3, -3.0, 2.0])
        grip = Grip(scene, lambda: eye, None)  # type: ignore[arg-type]
        turn = 0.0 if rotating_frame else 0.7
        for k in (10, 64, 120):
            radius = shapes.beam.delta + shapes.centreline[k, 0]
            point = np.array(scene.stage.position) + radius * np.array(
                [math.cos(turn), math.sin(turn), 0.0]
            )
            place = grip.place(point)
            assert place is not None
            assert grip.position(place) == pytest.approx(shapes.x[k], abs=1e-3)


# In the explorer


def frequency(beam: Beam, mode: int = 0, **options: Any) -> str:
    """A frequency as the comparison prints it."""
    return compare_tab.number(solve(beam, **options).frequencies[mode])


def drag(guest: Visitor, phase: str, x: float) -> None:
    """A step of a drag of the mass, over a place of the picture."""
    guest.send(
        type="SceneNodeDragMessage",
        phase=phase,
        name="/stage/wheel/mass",
        instance_index=0,
        start_position=(0.0, 0.0, 0.0),
        start_screen_pos=(0.5, 0.5),
        end_position=(x, 0.0, 0.0),
        end_screen_pos=(0.5, 0.5),
        button="left",
        modifier=None,
        owner=guest.nodes["/stage/wheel/mass"]["owner"],
    )


def test_dragging_the_mass_moves_beta_and_leaves_a_ghost(url):
    """By 0.2 to the right: beta follows, and the beam before is drawn pale with its numbers."""
    with visitor(url) as guest:
        guest.choose("playing", False)
        assert GHOST not in guest.nodes
        drag(guest, "start", 0.0)
        drag(guest, "update", 0.1)
        drag(guest, "update", 0.2)
        drag(guest, "end", 0.2)
        guest.says(frequency(PAPER))  # as the comparison prints it: before
        guest.wait(lambda _: guest.nodes.get(GHOST, {}).get("visible"))
        guest.says("before<br>")
        beta = beta_near(guest, 0.7)
        guest.says(frequency(PAPER.replace(beta=beta)))


def beta_near(guest: Visitor, place: float) -> float:
    """Where the slider of beta is, once it is near a place."""
    guest.wait(lambda _: abs(guest.values.get("position β", math.inf) - place) < 0.01)
    return float(guest.values["position β"])


def test_comparing_is_chosen_drawn_and_given_up(url):
    """Both frequencies are told; the ghost is drawn, or a second scene; none when it is over."""
    with visitor(url) as guest:
        guest.choose("compare with", "twice the mass")
        guest.says(frequency(PAPER.replace(alpha=2)))
        guest.wait(lambda _: guest.nodes.get(GHOST, {}).get("visible"))
        guest.choose("drawn", STACKED)
        guest.wait(lambda _: "/other/wheel/beam" in guest.nodes)
        guest.choose("compare with", "Coriolis on / off")
        guest.says(frequency(PAPER, coriolis=True))
        guest.choose("compare with", "rubber")
        guest.choose("compare with", NOTHING)
        guest.wait(lambda _: guest.nodes["/other"].get("visible") is False)
        guest.says("see what one change does")


def test_a_kept_beam_stays_while_the_other_changes(url):
    """The button keeps it; the change is from it to the present one."""
    with visitor(url) as guest:
        guest.choose("Keep this beam", True)
        guest.says("before<br>")
        guest.choose("speed γ", 20.0)
        guest.says(frequency(PAPER.replace(gamma=20)))
        guest.says(frequency(PAPER))


def test_a_ghost_leaves_when_another_scene_begins(url):
    """It belongs to the scene that is left."""
    with visitor(url) as guest:
        guest.choose("Keep this beam", True)
        guest.wait(lambda _: guest.nodes.get(GHOST, {}).get("visible"))
        guest.choose("reset", "beam")
        guest.wait(lambda _: guest.nodes[GHOST].get("visible") is False)
        guest.says("see what one change does")


def test_all_modes_are_shown_and_one_again(url):
    """The button beside the numbers of the modes: five scenes in place of one."""
    with visitor(url) as guest:
        guest.choose("show", "all")
        guest.wait(lambda _: "/mode 5/wheel/beam" in guest.nodes)
        guest.wait(lambda _: guest.nodes["/stage"].get("visible") is False)
        guest.choose("show", "2")
        guest.wait(lambda _: guest.nodes["/stage"].get("visible") is True)
        guest.wait(lambda _: guest.nodes["/mode 5"].get("visible") is False)
