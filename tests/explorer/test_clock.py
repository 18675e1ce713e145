"""The clock of a page: vibration, growth, a second beam, and the camera with its eased changes."""

import itertools
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from live.visitor import PAPER

from beamviz.beam import Beam
from beamviz.drawing import BeamView, camera
from beamviz.drawing.beam_mesh import DEFAULT_SCALE, DrawnBeam
from beamviz.drawing.camera import initial
from beamviz.drawing.modes import SampledModes, displacement, playback_rate
from beamviz.drawing.scene_graph import SceneGraph
from beamviz.explorer.camera import CHANGE_TIME, STEP, PageCamera, viewpoint
from beamviz.explorer.clock import EXPONENT, HELD, Clock, suitable_rate
from beamviz.explorer.solutions import solver_answer
from beamviz.explorer.state import Case
from beamviz.explorer.view import picture_of
from beamviz.scene import START, Camera, Scene, ViewOptions
from beamviz.solver import solve
from beamviz.units import Units


def sampled(beam: Beam, **options: Any) -> SampledModes:
    """The modes of a beam."""
    return SampledModes.sampled(solve(beam, **options))


def test_the_mass_of_the_start_page_can_be_taken_as_it_passes():
    """It moves by its own width, a twelfth of its circle, in twice the 0.2 s that a reaction takes
    or more."""
    picture = picture_of(solver_answer(Case.of(START)), START.view, DEFAULT_SCALE)
    turn = 2 * math.pi / (START.beam.gamma * picture.rate * START.view.pace)
    assert turn / 12 >= 0.4
    assert turn <= 10  # and one sees that it turns


def test_one_clock_keeps_the_ratio_of_frequencies():
    """In a period of mode 1, mode 2 has omega_2 / omega_1 periods and the hub gamma / omega_1
    turns."""
    shapes, clock, total = sampled(PAPER), Clock().for_modes(5), np.zeros(6)
    period = 2 * math.pi / shapes.frequencies[0]
    for _ in range(400):
        after = clock.advanced(period / 400, shapes, None)
        moved = np.append(after.phases, after.angle) - np.append(clock.phases, clock.angle)
        total, clock = total + moved % (2 * math.pi), after
    expected = np.append(shapes.frequencies, PAPER.gamma) / shapes.frequencies[0]
    assert total / (2 * math.pi) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("coriolis", [False, True])
def test_an_unstable_mode_grows_at_its_rate_is_held_and_begins_again(coriolis):
    """From 1/50 of the full size; a clock that has not begun shows the full size, as for reduced
    motion."""
    shapes = sampled(Beam(delta=-1, gamma=5), coriolis=coriolis)
    rate = float(shapes.solution.growth_rates.max())
    amplitudes = 0.1 * np.eye(len(shapes.modes))[int(np.argmax(shapes.solution.growth_rates))]

    def size(clock: Clock) -> float:
        return float(np.abs(displacement(shapes, clock.drawn_phases(shapes), amplitudes)).max())

    still = Clock().for_modes(len(shapes.modes))
    assert size(still) == pytest.approx(0.1, rel=1e-5)
    start = still.advanced(HELD / rate * (1 + 1e-12), shapes, None)
    assert size(start) == pytest.approx(0.1 * math.exp(-EXPONENT), rel=1e-5)
    for time in (0.3, 0.9):
        later = start.advanced(time * EXPONENT / rate, shapes, None)
        assert size(later) / size(start) == pytest.approx(math.exp(time * EXPONENT), rel=1e-6)
    end = start.advanced((EXPONENT + HELD / 2) / rate, shapes, None)
    assert size(end) == pytest.approx(0.1, rel=1e-5)


def test_a_growing_vibration_swings_while_it_grows():
    """Of a mode with a frequency and a growth rate: in a period by exp(growth rate * period)."""
    shapes = sampled(Beam(mu=1000, spin_up=100), state="stable")
    assert shapes.solution.equilibrium.status == "growing"
    k = int(np.argmax(shapes.solution.growth_rates))
    rate, frequency = shapes.solution.growth_rates[k], shapes.frequencies[k]
    amplitudes = 0.1 * np.eye(len(shapes.modes))[k]
    start = Clock(grown=0.0).for_modes(len(shapes.modes))
    period = 2 * math.pi / frequency
    assert rate * period < EXPONENT
    before, after = (
        displacement(shapes, one.drawn_phases(shapes), amplitudes)
        for one in (start, start.advanced(period, shapes, None))
    )
    assert np.allclose(after, math.exp(rate * period) * before, atol=1e-9)


def test_the_rate_is_a_round_number_near_the_suitable_one():
    """1, 2 or 5 times a power of ten, in T* or for a real beam in seconds: at most a factor of
    sqrt(2.5) from the rate at which the motion is followed best."""
    for frequency in np.geomspace(0.5, 500, 40):
        best = playback_rate(np.array([frequency]), 0.0)
        for units in (None, Units(1.0, 0.013)):
            rate = suitable_rate([frequency], 0.0, units)
            shown = rate * (units.time if units else 1.0)
            assert float(f"{shown:.0e}") == pytest.approx(shown)
            assert f"{shown:.0e}"[0] in "125"
            assert abs(math.log(rate / best)) <= math.log(2.5) / 2 + 1e-9


def test_the_modes_of_a_second_beam_begin_at_the_phases_of_their_partners():
    """When a choice is made; then they go on, also if the first beam changes."""
    clock = Clock(phases=np.array([0.1, 0.2, 0.3]))
    begun = clock.with_second(("mass",), np.array([1, 0, -1]))
    assert begun.other_phases.tolist() == [0.2, 0.1, math.pi / 2]
    assert begun.with_second(("mass",), np.array([0, 1, 2])) is begun
    again = begun.with_second(("earlier",), np.array([0, 1, 2]))
    assert again.other_phases.tolist() == [0.1, 0.2, 0.3]


def page(aspect: float = 1.8) -> Any:
    """A page with a camera, as viser has it."""
    start = {"position": np.array([0.0, 0, 3]), "look_at": np.zeros(3)}
    return SimpleNamespace(**start, aspect=aspect, image_height=900)


def test_the_viewpoint_moves_in_steps_and_contains_the_beam():
    """At most STEP times as far as needed, and the same for beams of nearly the same size."""
    for delta in np.linspace(0, 3, 40):
        for frame in (False, True):
            shapes = SampledModes.at_rest(Beam(delta=float(delta)), "chordwise")
            fit, found = camera.fitted(shapes, frame, 1.8), viewpoint(shapes, frame, 1.8, [0.0])
            ratio = math.dist(found.position, found.look_at) / math.dist(fit.position, fit.look_at)
            assert 1 - 1e-9 <= ratio <= STEP + 1e-9


@pytest.mark.parametrize("rotating_frame", [False, True])
def test_a_drag_of_the_speed_rarely_moves_the_viewpoint(rotating_frame):
    """Each stretches the beam a little; position and target are chosen in steps."""
    drag = [sampled(PAPER.replace(gamma=float(gamma))) for gamma in np.linspace(0, 10, 40)]
    points = [viewpoint(shapes, rotating_frame, 1.8, [0.0]) for shapes in drag]
    assert sum(one != next for one, next in itertools.pairwise(points)) <= 2


def test_a_camera_that_crossed_a_message_of_the_page_is_sent_again():
    """A page that reports its old viewpoint while it gets two others may end with the first of
    these, and tell it twice; a busy one with the initial viewpoint; and one that opens may report
    its own position with our target."""
    view, start = page(), initial(Scene(Beam()))
    page_camera, shapes = PageCamera(view, start), SampledModes.at_rest(Beam(), "chordwise")
    page_camera.look(viewpoint(shapes, True, 1.8, [0.0]), True, None, eased=True)
    wide = view.position, view.look_at
    last = viewpoint(shapes, True, 1.3, [0.0])
    page_camera.look(last, True, None, eased=True)
    mixed = (3.0, 3.0, 3.0), view.look_at
    for old in (wide, wide, (start.position, start.look_at), mixed):
        view.position, view.look_at = old
        assert page_camera.turned is None
        page_camera.look(last, True, None, eased=True)
        assert (view.position, view.look_at) == (last.position, last.look_at)


def test_a_viewpoint_that_the_server_has_not_set_is_that_of_the_visitor():
    """It is left alone while it is wanted, also where the server's last one has changed."""
    view, own, fit = page(), np.array([1.0, -2.0, 1.0]), Camera((0.0, -3.0, 2.0))
    page_camera = PageCamera(view, fit)
    page_camera.look(fit, True, None, eased=True)
    assert page_camera.turned is None
    view.position = own
    turned = page_camera.turned
    assert turned.position == (*own,)
    page_camera.look(turned, True, None, eased=True)
    assert view.position is own
    page_camera.look(fit, True, None, eased=True)
    assert view.position == fit.position


@pytest.mark.parametrize("back", [None, 15])
def test_a_change_of_view_is_eased(back):
    """Camera, place and floor go from one view to the other in small steps, with the hub at more
    than half a turn, which passes a whole one meanwhile; also where the visitor turns back."""
    view, scene = page(), BeamView(SceneGraph())
    page_camera, shapes = PageCamera(view, Camera((1.0, 1.0, 1.0))), sampled(Beam(gamma=3))
    outside, inside = (viewpoint(shapes, frame, view.aspect, [0.0]) for frame in (False, True))
    page_camera.look(outside, False, None, eased=True)
    scene.show(DrawnBeam(shapes, ViewOptions()))
    view.position, view.look_at = np.array(view.position), np.array(view.look_at)
    change = page_camera.look(inside, True, None, eased=True)
    path, places, angle, rest = [], [], 6.0, np.zeros(len(shapes.modes))
    while change:
        angle = (angle + 0.02) % (2 * np.pi)
        change = change.advanced(CHANGE_TIME / 40, angle)
        if change is None:
            break
        path.append(np.array(change.camera.position))
        view.position, view.look_at = np.array(path[-1]), np.array(change.camera.look_at)
        scene.choose_frame(change.rotating_share)
        scene.move(rest, change.angle)
        floor = scene.surroundings.floor.wxyz
        places.append([*scene.frame.position, 2 * math.atan2(floor[3], floor[0])])
        if len(path) == back:
            change = page_camera.look(outside, False, change, eased=True)
    assert np.allclose(path[-1], (outside if back else inside).position)
    turn = (0.02 - angle) * (back is None)
    target = camera.target(shapes, back is None)
    assert np.allclose(places[-1], [*-target, turn], atol=1e-5)
    for points in (path, places):
        ways = np.abs(np.diff(points, axis=0))
        span = np.linalg.norm(np.ptp(points, axis=0))
        assert ways.max() < 0.05 * span * (1 if back is None else 4)
