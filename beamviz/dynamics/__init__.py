"""Motion in time: the nonlinear equation of motion in the rotating frame, integrated.

A motion is computed on meshes and with steps that become finer, until two of them agree to the
tolerance. Their difference, in the position of the tip, is the error estimate of the finer one.
"""

import math
import time
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.dynamics.case import DEFAULT_ELEMENTS, Case
from beamviz.dynamics.drives import Hub
from beamviz.dynamics.integration import Budget, Control
from beamviz.dynamics.meshes import first_mesh, refined
from beamviz.dynamics.result import Motion, MotionStats
from beamviz.dynamics.run import Mesh, Run, run, start_solution
from beamviz.errors import BeamvizError, NoEquilibrium, NotConverged
from beamviz.solver import Solution
from beamviz.solver.solution import read_only

COMPARED = 401  # times at which the tips of two runs are compared
REFINEMENTS = 9  # after which a motion counts as not converged
TAIL = 1.0  # of the first steps, over the tolerance
# Steps in a row of the first run whose median length is that of the others, where it is the least:
# later ones may have lost a vibration that does not fade, and of which no finer run would tell.
SUSTAINED = 8
GROWING = 2.0  # times as long is the step after one whose length follows from that before it
# The error estimate: this times the changes to come, by halved steps and finer meshes, if each is
# the last one times the ratio of the last two, and a part of the tolerance for vibrations that none
# of them resolves; measured by scripts/measure_motion_error_bars.py.
ESTIMATE, UNRESOLVED = 2.0, 0.1
LEAST_RATIO, GREATEST_RATIO = 0.2, 0.6
COARSER = 2.0  # the same for the coarser one: 4/3 where the second order has been reached


def motion(
    beam: Beam,
    until: float,
    *,
    speed: Any = None,
    release: float = 0.0,
    start: Mapping[str, float] | None = None,
    damping: float = 0.0,
    tolerance: float = 1e-4,
    points: int = 401,
    method: str = "auto",
    **options: Any,
) -> Motion:
    """The motion of a beam from t = 0 until a time [T*], in the plane of rotation.

    speed: None, constantly beam.gamma; a Ramp; a pair of arrays (t, gamma), linear between samples
    and constant after the last; or a Hub, which turns under a torque. It starts at rest in the
    equilibrium at the first speed; release: held out of it by a transverse force [E I / L^2] until
    t = 0, at the point release_at of the beam, the tip by default; start: amplitudes of modes [L],
    as {"B1": 0.1}. damping: ratio of all modes about that equilibrium. tolerance: of the tip at all
    times [L], 1e-9 to 1e-2. points: of the results in time. method: "auto", or "ancf" for the
    paper's cubic elements.

    options: strain, curvature and state of the equilibrium as in `solve`. catch, drop: times at
    which the concentrated mass docks and is released; body_velocity: its velocity when it docks,
    relative to the frame of the hub. elements: of ancf. integrator: a name in INTEGRATORS; step: a
    constant step in time. progress: called with the time that has been reached.

    Raises InvalidInput; NoEquilibrium where there is none to start from (with .limit) or a stretch
    leaves the range of its strain law; NotConverged.
    """
    case = Case.of(
        beam=beam,
        until=until,
        speed=speed,
        release=release,
        start=start,
        damping=damping,
        tolerance=tolerance,
        points=points,
        method=method,
        **options,
    )
    begun = time.perf_counter()
    solution = start_solution(case)
    found, error, runs = (at_resolution if case.studied else to_tolerance)(case, solution)
    return record(case, found, error, runs, time.perf_counter() - begun)


def to_tolerance(case: Case, solution: Solution) -> tuple[Run, float, int]:
    """A motion refined until its error estimate is within the tolerance, the estimate, and the
    number of runs.

    A first run, whose steps adapt to the motion, tells how short they have to be; in the others
    their number is doubled while the orders of the mesh are raised. Without damping there is one
    more in between, with about as many steps as in the first, of equal length.
    """
    mesh, steps, budget = first_mesh(fastest(case), case.problem), None, Budget()
    last, change = attempt(case, solution, mesh, steps, budget), math.inf
    for runs in range(2, REFINEMENTS + 2):
        doubled = runs > 2 or case.damping > 0
        before, steps, mesh = last, divided_steps(case, last, 1 + doubled), refined(mesh)
        last, change_before = attempt(case, solution, mesh, steps, budget), change
        if isinstance(last, NoEquilibrium) and isinstance(before, NoEquilibrium):
            break
        change = difference(case, last, before)
        error = estimate(case, change, change_before)
        if doubled and isinstance(last, Run) and error <= case.tolerance:
            return last, error, runs
        if not budget.allows_another:
            break
    if isinstance(last, BeamvizError):
        raise last
    raise not_settled(case, before, last)


def not_settled(case: Case, before: Run | BeamvizError, last: Run) -> BeamvizError:
    """The error for a motion of which two runs differ by more than the tolerance."""
    if isinstance(before, BeamvizError):
        return before
    t = np.linspace(0.0, case.until, COMPARED)
    apart = np.linalg.norm(last.tip(t) - before.tip(t), axis=1)
    with_what = f"with {len(last.path.q)} steps and {last.path.beam.size} unknowns"
    remedy = "ask for a shorter time or a larger tolerance"
    if apart.max() <= case.tolerance:
        return NotConverged(
            f"the position of the tip still changes by {apart.max():.1e} L {with_what}, and not"
            f" less than before, so it is not known to {case.tolerance:g} L; {remedy}"
        )
    agree = t[max(int(np.argmax(apart > case.tolerance)) - 1, 0)]
    return NotConverged(
        f"the position of the tip is known to {case.tolerance:g} L until t = {agree:.3g} only;"
        f" then it still changes by up to {apart.max():.1e} L {with_what}, as small differences"
        f" grow; {remedy}"
    )


def at_resolution(case: Case, solution: Solution) -> tuple[Run, float, int]:
    """A motion at a given resolution, its error estimate by one of twice that, and 2."""
    count = case.elements or DEFAULT_ELEMENTS
    meshes: tuple[Mesh, Mesh] = count, 2 * count
    if not case.cubic:
        mesh = refined(first_mesh(fastest(case), case.problem))
        meshes = mesh, refined(mesh)
    controls = [
        Control(tail * case.tolerance, case.until, step, progress=case.report)
        for tail, step in ((TAIL, case.step), (TAIL / 32, case.step and case.step / 2))
    ]
    found, finer = (
        run(case, solution, mesh, control) for mesh, control in zip(meshes, controls, strict=True)
    )
    return found, COARSER * difference(case, found, finer), 2


def fastest(case: Case) -> Beam:
    """The beam at the speed that the first mesh resolves."""
    return case.beam.replace(gamma=case.greatest_speed)


def estimate(case: Case, change: float, before: float) -> float:
    """The error bar of a run that differs by a change from a coarser one, which differed by the
    change before from one still coarser: the sum of the changes to come, if they go on so."""
    ratio = (
        min(max(change / max(before, 1e-300), LEAST_RATIO), GREATEST_RATIO)
        if before < math.inf
        else GREATEST_RATIO
    )
    return ESTIMATE * change * ratio / (1 - ratio) + UNRESOLVED * case.tolerance


def attempt(
    case: Case, solution: Solution, mesh: Mesh, ends: NDArray | None, budget: Budget
) -> Run | BeamvizError:
    """A run with steps between given ends, or by the tolerance, or its failure: a finer one may
    succeed."""
    try:
        tail = TAIL * case.tolerance
        control = Control(tail, case.until, ends=ends, progress=case.report, budget=budget)
        return run(case, solution, mesh, control)
    except (NoEquilibrium, NotConverged) as error:
        return error


def divided_steps(case: Case, coarse: Run | BeamvizError, times: int) -> NDArray | None:
    """The ends of once or twice as many steps as in a run; None where it has failed. With damping
    they are its steps, divided; without, they are equal in each smooth part of the motion: an
    undamped vibration does not fade, and longer steps later would lose it."""
    if isinstance(coarse, BeamvizError):
        return None
    if case.damping:
        t = coarse.path.t
        return np.append(np.linspace(t[:-1], t[1:], times, endpoint=False, axis=1).ravel(), t[-1])
    corners = sorted({0.0, *case.corners, case.until})
    ends = [np.zeros(1)]
    for start, end in pairwise(corners):
        t = coarse.path.t
        length = shortest_sustained(np.diff(t)[(t[1:] > start) & (t[1:] <= end)])
        count = math.ceil((end - start) / length - 1e-6)
        ends.append(np.linspace(start, end, times * count + 1)[1:])
    return np.concatenate(ends)


def shortest_sustained(lengths: NDArray) -> float:
    """The least median length of SUSTAINED steps in a row, without those that only grow from a
    shorter one, at the start."""
    settled = lengths[np.append(lengths[1:] < GROWING * lengths[:-1], True)]
    rows = sliding_window_view(settled, min(SUSTAINED, len(settled)))
    return float(np.median(rows, axis=1).min())


def difference(case: Case, one: Run | BeamvizError, other: Run | BeamvizError) -> float:
    """The largest distance of the tip in two runs, infinite where one has failed."""
    if isinstance(one, BeamvizError) or isinstance(other, BeamvizError):
        return math.inf
    t = np.linspace(0.0, case.until, COMPARED)
    return float(np.linalg.norm(one.tip(t) - other.tip(t), axis=1).max())


def record(case: Case, found: Run, error: float, runs: int, seconds: float) -> Motion:
    """The result: a run at the times asked for, with its error estimate, the number of runs it took
    and their time [s]."""
    t, path = case.times, found.path
    drive = case.drive
    angle = path.at(t)[0][:, -1] if isinstance(drive, Hub) else drive.angle(t)
    orders = path.beam.orders
    stats = MotionStats(
        dof=path.beam.size,
        elements=len(orders),
        order=max(orders),
        steps=len(path.q),
        runs=runs,
        seconds=seconds,
    )
    arrays = (t, found.speed(t), angle, found.tip(t), found.energy(t))
    t, gamma, angle, tip, energy = map(read_only, arrays)
    return Motion(
        beam=case.beam,
        drive=drive,
        model=case.model,
        start=case.amplitudes,
        release=case.release,
        release_at=case.release_at,
        catch=case.catch,
        drop=case.drop,
        t=t,
        gamma=gamma,
        angle=angle,
        tip=tip,
        energy=energy,
        error=error,
        stats=stats,
        path=path,
    )
