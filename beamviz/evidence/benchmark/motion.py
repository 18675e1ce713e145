"""Integrators of the motion in time, compared: processor time against the error of the tip, and
where each of them fails over step and slenderness.

Two motions: Kane's manoeuvre, a slender arm that is spun up, and a plucked beam, held at gamma = 3
by a force at the tip and let go. Stretching vibrations, mu times faster than bending, make the
equation stiff. `auto` is `beamviz.motion` as a user calls it, with all runs that its error bar
takes; the others are single runs with constant steps, on a mesh that is fine enough for all but the
smallest errors, or on the paper's elements. The error is the largest of the tip at any time against
a motion computed with a much finer mesh and much smaller steps, for Exudyn with its strain and
curvature measures.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.dynamics import motion
from beamviz.dynamics.controllers import EqualSteps
from beamviz.dynamics.drives import Ramp
from beamviz.dynamics.equation import Equation
from beamviz.dynamics.initial_value import (
    Mesh,
    equation_of,
    initial_value_problem,
    start_solution,
)
from beamviz.dynamics.integration import IntegratedMotion, integrate
from beamviz.dynamics.meshes import with_orders
from beamviz.dynamics.problem import MotionProblem
from beamviz.dynamics.schemes import INTEGRATORS
from beamviz.dynamics.start import equilibrium, under_force
from beamviz.errors import BeamvizError, NoEquilibrium, NotConverged
from beamviz.evidence.benchmark.exudyn_motion import exudyn_tip, missing
from beamviz.evidence.benchmark.work_precision import processor_time

EXPLICIT = "explicit"  # the classical Runge-Kutta method, which is no row of the product
CUBIC = "cubic elements, generalised-alpha"
EXUDYN = "Exudyn"
NAMES = (*INTEGRATORS, EXPLICIT)
EXUDYN_MODEL = {"strain": "biot", "curvature": "material"}
ORDER, FINE_ORDER, REFERENCE_STEPS = 12, 22, 500
MAP_ORDER, MAP_UNTIL, MAP_RELEASE, MAP_GAMMA = 8, 4.0, 0.5, 3.0
FINEST = 0.02  # the step of the reference of the map
ENERGY_GROWS, INACCURATE = 0.02, 1e-3  # of the energy released; of the tip [L]
REPEATS, LEAST = 2, 0.3  # of each motion, and the time [s] for which it is repeated


class ComparedMotion(NamedTuple):
    """A motion that every integrator computes."""

    beam: Beam
    until: float  # [T*]
    options: dict[str, Any]  # of `motion`
    instants: int  # number of intervals between the times at which tips are compared

    @property
    def times(self) -> NDArray:
        return np.linspace(0.0, self.until, self.instants + 1)


SCENES = {
    "Kane's manoeuvre": ComparedMotion(
        Beam(mu=447.2136), 21.6, {"speed": Ramp(5.554921, 16.20185)}, instants=180
    ),
    "a plucked beam": ComparedMotion(Beam(gamma=3), 4.0, {"release": 0.5}, instants=200),
}


class MotionEffort(NamedTuple):
    """The resolutions at which motions are computed."""

    tolerances: tuple[float, ...]  # of `auto`
    high: tuple[int, ...]  # numbers of steps of integrators of an order above 2
    low: tuple[int, ...]  # numbers of steps of integrators of order 2
    elements: tuple[int, ...]  # numbers of cubic elements, with the last number of `low`
    peer: tuple[tuple[int, ...], tuple[int, ...]]  # of Exudyn: elements, steps in an interval
    mus: tuple[float, ...]  # of the map
    steps: tuple[float, ...]  # of the map [T*]


FULL = MotionEffort(
    tolerances=(1e-2, 1e-3, 1e-4),
    high=(15, 30, 60, 120),
    low=(180, 360, 720, 1440),
    elements=(2, 4, 8),
    peer=((4, 8), (1, 2, 4, 8, 16)),
    mus=(20.0, 70.0, 250.0, 1000.0),
    steps=tuple(np.geomspace(0.005, 0.5, 7).tolist()),
)
QUICK = MotionEffort(
    tolerances=(1e-2, 1e-4),
    high=(30, 60),
    low=(180, 720),
    elements=(2, 4),
    peer=((4,), (1, 4)),
    mus=(20.0, 250.0),
    steps=(0.05, 0.5),
)


class MotionRow(NamedTuple):
    """A motion by one solver at one resolution."""

    scene: str  # a key of SCENES
    name: str  # of the solver
    resolution: str
    seconds: float = math.nan  # processor time
    error: float = math.nan  # of the tip, the largest [L]
    reason: str = ""  # why time and error are nan


class MapCell(NamedTuple):
    """An integrator at one slenderness and step, and what it comes to."""

    integrator: str
    mu: float
    step: float  # [T*]
    outcome: str
    error: float  # of the tip, the largest [L]; nan where the motion is not completed
    seconds: float  # processor time; nan likewise


# Time against error


def measure(
    effort: MotionEffort, peers: bool, report: Callable[[str], Any] = print
) -> list[MotionRow]:
    """Rows of all scenes."""
    rows = []
    for name, scene in SCENES.items():
        report(f"{name}: reference")
        reference = reference_tip(scene, {})
        of_exudyn = reference_tip(scene, EXUDYN_MODEL) if peers and not missing() else None
        for solver, resolution, tip in works(scene, effort, peers):
            truth = of_exudyn if solver == EXUDYN and of_exudyn is not None else reference
            report(f"{name}: {solver}, {resolution}")
            rows.append(row_of(MotionRow(name, solver, resolution), tip, truth))
    return rows


def works(
    scene: ComparedMotion, effort: MotionEffort, peers: bool
) -> Iterator[tuple[str, str, Callable[[], NDArray]]]:
    """Solver, resolution and the work that gives the tip (n, 2)."""
    for tolerance in effort.tolerances:
        yield "auto", f"tolerance {tolerance:g}", partial(auto_tip, scene, tolerance)
    mesh = with_orders([0.0, 1.0], [ORDER])
    for name, row in INTEGRATORS.items():
        for count in effort.low if row.scheme().order == 2 else effort.high:
            work = partial(run_tip, scene, mesh, {"integrator": name}, scene.until / count)
            yield name, f"{count} steps", work
    for count in effort.elements:
        options = {"method": "ancf", "integrator": "generalised-alpha"}
        step = scene.until / effort.low[-1]
        work = partial(run_tip, scene, count, options, step)
        yield CUBIC, f"{count} elements, {effort.low[-1]} steps", work
    if peers:
        for elements, times in product(*effort.peer):
            count = times * scene.instants
            work = partial(peer_tip, scene, elements, count)
            yield EXUDYN, f"{elements} elements, {count} steps", work


def row_of(row: MotionRow, work: Callable[[], NDArray], reference: NDArray) -> MotionRow:
    """The row with its time and error."""
    seconds: list[float] = []
    while len(seconds) < REPEATS or sum(seconds) < LEAST:
        start = processor_time()
        try:
            with np.errstate(all="ignore"):
                tip = work()
        except BeamvizError as failure:
            return row._replace(reason=str(failure))
        seconds.append(processor_time() - start)
    error = float(np.linalg.norm(tip - reference, axis=1).max())
    if not error < 1:
        return row._replace(reason="the tip is off by more than the length of the beam")
    return row._replace(seconds=min(seconds), error=error)


def reference_tip(scene: ComparedMotion, model: dict[str, str]) -> NDArray:
    mesh = with_orders([0.0, 1.0], [FINE_ORDER])
    return run_tip(scene, mesh, model, scene.until / REFERENCE_STEPS)


def auto_tip(scene: ComparedMotion, tolerance: float) -> NDArray:
    points = scene.instants + 1
    moved = motion(scene.beam, scene.until, tolerance=tolerance, points=points, **scene.options)
    return moved.tip


def run_tip(scene: ComparedMotion, mesh: Mesh, options: dict[str, Any], step: float) -> NDArray:
    problem = MotionProblem(
        beam=scene.beam, until=scene.until, step=step, tolerance=1e-6, **scene.options, **options
    )
    return integrated(problem, mesh).tip(scene.times)


def integrated(problem: MotionProblem, mesh: Mesh) -> IntegratedMotion:
    """The motion on a mesh, with the constant step of the problem."""
    assert problem.step is not None
    discrete = initial_value_problem(problem, start_solution(problem), mesh)
    return integrate(discrete, EqualSteps(problem.step), problem.tolerance)


def peer_tip(scene: ComparedMotion, elements: int, steps: int) -> NDArray:
    drive = scene.options.get("speed")
    release = scene.options.get("release", 0.0)
    return exudyn_tip(scene.beam, scene.times, drive, release, elements, steps)


def time_to_error(rows: Iterable[MotionRow], scene: str, name: str, target: float) -> float | None:
    """The least time of a row with at most this error, none interpolated."""
    times = [
        row.seconds
        for row in rows
        if row.scene == scene and row.name == name and row.error <= target
    ]
    return min(times, default=None)


def summary(rows: list[MotionRow], targets: tuple[float, ...] = (1e-3, 1e-4)) -> Iterator[str]:
    """Times at equal error relative to auto's."""
    for target in targets:
        yield f"{f'time to tip error {target:g} / auto':34}" + "".join(f"{s:>18}" for s in SCENES)
        for name in dict.fromkeys(row.name for row in rows):
            cells = []
            for scene in SCENES:
                ours, theirs = (time_to_error(rows, scene, n, target) for n in ("auto", name))
                cells.append(f"{theirs / ours:.2g}" if ours and theirs else "not reached")
            yield f"{name:34}" + "".join(f"{cell:>18}" for cell in cells)
        yield ""


# The map


def map_problem(mu: float, integrator: str, step: float) -> MotionProblem:
    return MotionProblem(
        beam=Beam(gamma=MAP_GAMMA, mu=mu),
        until=MAP_UNTIL,
        release=MAP_RELEASE,
        integrator="radau" if integrator == EXPLICIT else integrator,
        step=step,
    )


MAP_TIMES = np.linspace(0.0, MAP_UNTIL, 201)


def motion_of_map(problem: MotionProblem, integrator: str) -> tuple[NDArray, NDArray]:
    """Tip (n, 2) and energy (n,) at the times of the map."""
    mesh = with_orders([0.0, 1.0], [MAP_ORDER])
    if integrator == EXPLICIT:
        return explicit(problem, equation_of(problem, mesh, False))
    moved = integrated(problem, mesh)
    return moved.tip(MAP_TIMES), moved.energy(MAP_TIMES)


def explicit(problem: MotionProblem, equation: Equation) -> tuple[NDArray, NDArray]:
    """The same by the classical Runge-Kutta method, with steps that end at the times of the map."""
    beam = equation.beam
    q = under_force(beam, equilibrium(beam, start_solution(problem)), MAP_GAMMA, MAP_RELEASE)
    assert problem.step is not None
    count = math.ceil((MAP_TIMES[1] - MAP_TIMES[0]) / problem.step)
    h = (MAP_TIMES[1] - MAP_TIMES[0]) / count
    state, states = np.array([q, 0 * q]), []

    def rates(state: NDArray) -> NDArray:
        (a,) = equation.accelerations(np.zeros(1), state[:1], state[1:])
        return np.array([state[1], a])

    for t in MAP_TIMES:
        states.append(state)
        for _ in range(count if t < MAP_UNTIL else 0):
            k1 = rates(state)
            k2 = rates(state + h / 2 * k1)
            k3 = rates(state + h / 2 * k2)
            k4 = rates(state + h * k3)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            if not np.abs(state[0]).max() < 10:
                raise NoEquilibrium(f"t = {t:.3g}: the positions grow without bound", np.nan)
        equation.check(float(t), *state)
    positions, velocities = np.array(states).swapaxes(0, 1)
    tip = beam.state(positions).positions(np.ones(1))[:, 0]
    energy = equation.energy(np.full(len(tip), MAP_GAMMA), positions, velocities)
    return np.stack((tip.real, tip.imag), axis=1), energy


def map_cell(integrator: str, mu: float, step: float, reference: NDArray) -> MapCell:
    """The cell of an integrator: it computes the motion, and its tip is compared with a reference
    (n, 2) at the times of the map."""
    result = partial(MapCell, integrator, mu, step)
    start = processor_time()
    try:
        with np.errstate(all="ignore"):
            tip, energy = motion_of_map(map_problem(mu, integrator, step), integrator)
    except NotConverged:
        return result("does not converge", np.nan, np.nan)
    except NoEquilibrium:
        return result("unstable", np.nan, np.nan)
    seconds = processor_time() - start
    error = float(np.linalg.norm(tip - reference, axis=1).max())
    released = MAP_RELEASE * abs(reference[0, 1]) / 2
    if not error < 1:
        outcome = "unstable"
    elif (energy - energy[0]).max() > ENERGY_GROWS * released:
        outcome = "energy grows"
    else:
        outcome = "inaccurate" if error > INACCURATE else "accurate"
    return result(outcome, error, seconds)


def trials(
    names: Iterable[str],
    mus: Iterable[float],
    steps: Iterable[float],
    report: Callable[[str], Any] = print,
) -> list[MapCell]:
    """Every integrator with every slenderness and step."""
    steps, cells = tuple(steps), list[MapCell]()
    for mu in mus:
        reference, _ = motion_of_map(map_problem(mu, "radau", FINEST), "radau")
        for name in names:
            report(f"map: {name}, mu = {mu:g}")
            cells += [map_cell(name, mu, step, reference) for step in steps]
    return cells
