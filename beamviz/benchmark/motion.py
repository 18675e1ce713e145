"""Integrators of the motion in time, compared: processor time against the error of the tip, and
where each of them fails over step and slenderness.

A beam at gamma = 3 is held by a force at the tip and let go; its stretching vibrations, mu times
faster than bending, make the equation stiff. The mesh is the same for all, so that the error is
that of the integrator, against `radau` with the smallest step.
"""

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib import rc_context
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.benchmark.work_precision import processor_time
from beamviz.dynamics.case import Case
from beamviz.dynamics.elements import PositionElements, position_elements
from beamviz.dynamics.equation import Equation
from beamviz.dynamics.integration import Control
from beamviz.dynamics.run import equation_of, run, start_solution
from beamviz.dynamics.schemes import INTEGRATORS
from beamviz.dynamics.start import equilibrium, held
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.files import json_text, make_folder, write_files
from beamviz.plotting import STYLE, new_figure, picture_files

EXPLICIT = "explicit"  # the classical Runge-Kutta method, which is no row of the product
NAMES = (*INTEGRATORS, EXPLICIT)
ORDER, UNTIL, RELEASE, GAMMA = 8, 4.0, 0.5, 3.0
CURVE_MU, FINEST = 70.0, 0.0025  # of time against error, and the step of the reference
CURVE_STEPS = (0.08, 0.04, 0.02, 0.01, 0.005)
MAP_STEPS = tuple(np.geomspace(0.002, 0.5, 9).tolist())
MAP_MUS = (20.0, 70.0, 250.0, 1000.0)
TIMES = np.linspace(0.0, UNTIL, 201)
ENERGY_GROWS, INACCURATE = 0.02, 1e-3  # of the energy released; of the tip [L]
OUTCOMES = {  # from the worst, with a colour
    "does not converge": "#555555",
    "unstable": "#D55E00",
    "energy grows": "#E69F00",
    "inaccurate": "#F0E442",
    "accurate": "#0072B2",
}
COLOURS = ("#0072B2", "#009E73", "#56B4E9", "#D55E00", "#CC79A7", "#555555")


class Trial(NamedTuple):
    """One integration: its outcome, the largest error of the tip [L] and processor time [s], nan
    where there is none."""

    integrator: str
    mu: float
    step: float
    outcome: str
    error: float
    seconds: float


def case_of(mu: float, integrator: str, step: float) -> Case:
    return Case(
        beam=Beam(gamma=GAMMA, mu=mu),
        until=UNTIL,
        release=RELEASE,
        integrator="radau" if integrator == EXPLICIT else integrator,
        step=step,
    )


def elements() -> PositionElements:
    return position_elements((0.0, 1.0), (ORDER,), None)


def integrate(case: Case, integrator: str) -> tuple[NDArray, NDArray]:
    """Tip (n, 2) and energy (n,) at TIMES."""
    solution = start_solution(case)
    if integrator == EXPLICIT:
        return explicit(case, equation_of(case, elements(), False, None))
    found = run(case, solution, elements(), Control(case.tolerance, case.step))
    return found.tip(TIMES), found.energy(TIMES)


def explicit(case: Case, equation: Equation) -> tuple[NDArray, NDArray]:
    """The same by the classical Runge-Kutta method, with steps that end at TIMES."""
    q = held(equation, equilibrium(equation, start_solution(case)), GAMMA, RELEASE)
    state, tips, energies = np.array([q, 0 * q]), [equation.at_tip @ q], []
    assert case.step is not None
    count = int(np.ceil((TIMES[1] - TIMES[0]) / case.step))
    h = (TIMES[1] - TIMES[0]) / count

    def rates(state: NDArray) -> NDArray:
        (a,) = equation.accelerations(np.zeros(1), state[:1], state[1:])
        return np.array([state[1], a])

    for t in TIMES:
        energies.append(equation.energy(np.array([GAMMA]), state[:1], state[1:])[0])
        if t == TIMES[-1]:
            break
        for _ in range(count):
            k1 = rates(state)
            k2 = rates(state + h / 2 * k1)
            k3 = rates(state + h / 2 * k2)
            k4 = rates(state + h * k3)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            if not np.abs(state[0]).max() < 10:
                raise NoEquilibrium(f"t = {t:.3g}: the positions grow without bound", np.nan)
        equation.check(float(t), GAMMA, state[0])
        tips.append(equation.at_tip @ state[0])
    return np.array(tips), np.array(energies)


def trial(integrator: str, mu: float, step: float, reference: NDArray) -> Trial:
    """Integrates, and tells the kind of failure."""
    result = partial(Trial, integrator, mu, step)
    start = processor_time()
    try:
        with np.errstate(all="ignore"):
            tip, energy = integrate(case_of(mu, integrator, step), integrator)
    except NotConverged:
        return result("does not converge", np.nan, np.nan)
    except NoEquilibrium:
        return result("unstable", np.nan, np.nan)
    seconds = processor_time() - start
    error = float(np.linalg.norm(tip - reference, axis=1).max())
    released = RELEASE * abs(reference[0, 1]) / 2
    if not error < 1:
        outcome = "unstable"
    elif (energy - energy[0]).max() > ENERGY_GROWS * released:
        outcome = "energy grows"
    else:
        outcome = "inaccurate" if error > INACCURATE else "accurate"
    return result(outcome, error, seconds)


def trials(names: Iterable[str], mus: Iterable[float], steps: Iterable[float]) -> list[Trial]:
    """Every integrator with every slenderness and step."""
    steps, found = tuple(steps), []
    for mu in mus:
        reference, _ = integrate(case_of(mu, "radau", FINEST), "radau")
        found += [trial(name, mu, step, reference) for name in names for step in steps]
    return found


def draw_curves(rows: list[Trial]) -> Figure:
    """Processor time against the error of the tip."""
    with rc_context(STYLE):
        figure = new_figure(6.0, 4.2, layout="constrained")
        axes = figure.subplots()
        for name, colour in zip(NAMES, COLOURS, strict=True):
            points = [(r.error, r.seconds) for r in rows if r.integrator == name]
            points = [point for point in points if np.isfinite(point[0])]
            if points:
                axes.loglog(*zip(*points, strict=True), "o-", color=colour, label=name, ms=4)
        axes.set(xlabel="largest error of the tip [L]", ylabel="processor time [s]")
        axes.legend(frameon=False, fontsize=8)
    return figure


def draw_map(rows: list[Trial]) -> Figure:
    """Where each integrator fails, and how: a frame for each, step against slenderness."""
    kinds = list(OUTCOMES)
    with rc_context(STYLE):
        figure = new_figure(8.0, 5.0, layout="constrained")
        frames = figure.subplots(2, 3, sharex=True, sharey=True)
        for axes, name in zip(frames.ravel(), NAMES, strict=True):
            own = [row for row in rows if row.integrator == name]
            mus, steps = (sorted({getattr(row, key) for row in own}) for key in ("mu", "step"))
            cells = np.zeros((len(mus), len(steps)))
            for row in own:
                cells[mus.index(row.mu), steps.index(row.step)] = kinds.index(row.outcome)
            colours = ListedColormap([*OUTCOMES.values()])
            axes.pcolormesh(cells, cmap=colours, vmin=-0.5, vmax=len(kinds) - 0.5, ec="white")
            axes.set_title(name, loc="left", size=9, weight="bold")
            axes.set_xticks(np.arange(len(steps)) + 0.5, [f"{step:.2g}" for step in steps], size=6)
            axes.set_yticks(np.arange(len(mus)) + 0.5, [f"{mu:g}" for mu in mus])
        for axes in frames[-1]:
            axes.set_xlabel("step [T*]")
        figure.supylabel("slenderness μ", size=9)
        patches = [Patch(color=colour, label=kind) for kind, colour in OUTCOMES.items()]
        figure.legend(handles=patches, loc="outside lower center", ncols=5, frameon=False)
    return figure


def compare_integrators(out: Path, report: Callable[[str], Any] = print) -> None:
    """Write both charts and their numbers to a folder."""
    make_folder(out)
    curves = trials(NAMES, [CURVE_MU], CURVE_STEPS)
    report("time against error: done")
    cells = trials(NAMES, MAP_MUS, MAP_STEPS)
    files = picture_files(draw_curves(curves), "motion-time-error")
    files |= picture_files(draw_map(cells), "motion-failures")
    files["motion-integrators.json"] = json_text({"curves": curves, "map": cells}).encode()
    write_files(out, files)
