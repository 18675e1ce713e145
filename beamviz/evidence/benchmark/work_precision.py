"""Work against precision: the time of a solve against the error of its frequencies, for six beams
from gentle to harsh, every method of beamviz, and other programs.

The discretisation error is the largest relative error of the five lowest frequencies against the
limits to which the method's own model converges, known to twenty digits (limits.json). The model
error is the distance of these from the limits of the paper's model. They are two quantities and are
never added; the distance of an answer from the paper's model is a third. Time is processor time,
the least of many calls after a first one, in one thread, assembly included, so that the load of the
machine does not change it. For another program it is that of its whole process.
"""

import json
import math
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from importlib.metadata import PackageNotFoundError
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import BeamvizError
from beamviz.files import package_text
from beamviz.solver import solve
from beamviz.solver.problem import METHODS as METHOD_TABLE
from beamviz.solver.problem import parse_keywords

MODES = 5
SCENES = {
    "slow": Beam(gamma=2),
    "tip mass": Beam(alpha=1, gamma=5),
    "inner mass": Beam(alpha=1, beta=0.5, gamma=10),
    "fast": Beam(gamma=50, delta=1),
    "fast, inner mass": Beam(alpha=1, beta=0.3, gamma=50, delta=1),
    "fastest": Beam(gamma=200),
}
TOLERANCES = (0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10)
ELEMENTS = (5, 10, 20, 40, 80, 160)
TERMS = (1 / 4, 3 / 8, 1 / 2, 3 / 4, 1, 3 / 2, 2, 3)  # of the default number of each method
REFERENCE = "green"  # the paper's model
FLOOR = 1e-15  # errors are drawn on a logarithmic axis
CONVERGED = 1e-13  # an error that no finer resolution need improve

Theories = dict[str, np.ndarray | str]  # theory -> omega^2 (modes,) or why there is none


class SolveEffort(NamedTuple):
    """How long to measure."""

    seconds: float  # of repeats for each row
    budget: float  # [s] of a call, after which a solver is not asked for finer resolutions
    stride: int = 1  # only every stride-th resolution is measured, the finest included


FULL, QUICK = SolveEffort(0.2, 4.0), SolveEffort(0.03, 0.5, 2)


class Solver(NamedTuple):
    """A method of beamviz or another program, at several resolutions."""

    name: str
    theory: str  # the model to whose frequencies it converges, a key of limits.json
    option: str  # what its resolutions are
    resolutions: tuple[float, ...]
    # omega^2 (modes,) of a beam, by a resolution and the number of modes.
    omega_squared: Callable[[Beam, Any, int], np.ndarray]
    version: Callable[[], str] = str  # raises PackageNotFoundError where it is not installed
    install: str = ""  # the command that installs it

    @property
    def missing(self) -> str:
        """Why it cannot run; empty where it can."""
        try:
            self.version()
        except PackageNotFoundError:
            return f"not installed: {self.install}"
        return ""


def solver_of(name: str) -> Solver:
    """A method of beamviz at its resolutions: tolerances, or numbers of elements or terms."""
    theory, resolution = theory_of(name), METHOD_TABLE[name].resolution
    if resolution is None:
        return Solver(name, theory, "tolerance", TOLERANCES, partial(_solve, name, "tolerance"))
    option = resolution.option
    numbers: tuple[int, ...] = ELEMENTS
    if option == "terms":
        shares = (round(share * resolution.default) for share in TERMS)
        numbers = tuple(terms for terms in shares if terms >= MODES)
    return Solver(name, theory, option, numbers, partial(_solve, name, option))


def theory_of(method: str) -> str:
    """The model of a method, a key of limits.json."""
    problem = parse_keywords(method=method)
    if not problem.stiffens:
        return "none"
    return "rigid" if problem.rigid_tension else problem.strain


def _solve(method: str, option: str, beam: Beam, resolution: Any, modes: int) -> np.ndarray:
    options: dict[str, Any] = {option: resolution}
    return solve(beam, modes, method, **options).omega_squared


METHODS = tuple(map(solver_of, METHOD_TABLE))


class SolveRow(NamedTuple):
    """A beam by one solver at one resolution."""

    scene: str  # a key of SCENES
    name: str  # of the solver
    theory: str
    option: str
    resolution: float | None = None  # None where it was asked for none
    seconds: float = math.nan  # processor time
    error: float = math.nan  # relative, of the five frequencies the largest
    from_paper: float = math.nan  # the same from the limits of the paper's model
    reason: str = ""  # why the three are nan


def limits() -> dict[str, Theories]:
    """omega^2 of every scene in every model to twenty digits, or why there are none."""
    stored = json.loads(package_text("evidence/benchmark/limits.json"))["limits"]
    for theories in stored.values():
        theories |= {k: np.array(v, float) for k, v in theories.items() if isinstance(v, list)}
    return stored


def relative_error(omega_squared: np.ndarray, limit: np.ndarray) -> float:
    """The largest relative error of a frequency or growth rate, from omega^2 (modes,)."""
    difference = abs(omega_squared - limit).max()
    return float(max(difference and (abs(omega_squared / limit - 1) / 2).max(), FLOOR))


def measure(solvers: Sequence[Solver], effort: SolveEffort) -> list[SolveRow]:
    """A row for every scene, solver and resolution."""
    known = limits()
    rows: list[SolveRow] = []
    for scene in SCENES:
        for solver in solvers:
            print(f"{scene}: {solver.name}", file=sys.stderr)
            rows += _rows_of(scene, solver, known[scene], effort)
    return rows


def _rows_of(
    scene: str, solver: Solver, theories: Theories, effort: SolveEffort
) -> Iterator[SolveRow]:
    """The rows of one solver in one scene, coarse to fine; the budget ends them. The first call
    warms up and gives the errors, the fastest of the others the time."""
    limit, paper = theories[solver.theory], np.asarray(theories[REFERENCE])
    blank = SolveRow(scene, solver.name, solver.theory, solver.option)
    if isinstance(limit, str) or solver.missing:
        yield blank._replace(reason=solver.missing or str(limit))
        return
    spent = 0.0
    for resolution in solver.resolutions[:: -effort.stride][::-1]:
        row = blank._replace(resolution=resolution)
        if spent > effort.budget:
            yield row._replace(reason=f"out of budget: the coarser one took {spent:.1f} s")
            continue
        work = partial(solver.omega_squared, SCENES[scene], resolution, MODES)
        start = processor_time()
        try:
            omega_squared = work()
        except BeamvizError as failure:
            spent = processor_time() - start
            yield row._replace(reason=str(failure))
            continue
        spent = least_time(work, seconds=effort.seconds)
        error = relative_error(omega_squared, limit)
        from_paper = relative_error(omega_squared, paper)
        yield row._replace(seconds=spent, error=error, from_paper=from_paper)
        if error < CONVERGED:
            break


def least_time(work: Callable, repeats: int = 400, seconds: float = math.inf) -> float:
    """The least processor time [s] of the calls that fit into `seconds`, and of one at least."""
    times: list[float] = []
    began = processor_time()
    while not times or (len(times) < repeats and processor_time() - began < seconds):
        start = processor_time()
        work()
        times.append(processor_time() - start)
    return min(times)


def processor_time() -> float:
    """Processor time [s] of this process and the programs it has run."""
    times = os.times()
    return time.process_time() + times.children_user + times.children_system


def model_errors() -> dict[str, dict[str, float | str]]:
    """Scene, theory -> distance of its frequencies from the paper's model, or a reason."""
    errors = {}
    for scene, theories in limits().items():
        paper = np.asarray(theories.pop(REFERENCE))
        errors[scene] = {
            theory: values if isinstance(values, str) else relative_error(values, paper)
            for theory, values in theories.items()
        }
    return errors


def dominated(rows: list[SolveRow], name: str) -> list[tuple[SolveRow, SolveRow]]:
    """Each row of a solver with one of another solver that is faster and at least as close to the
    paper's model; none where the solver is on the Pareto front."""
    return [
        (row, other)
        for row, other in product(rows, rows)
        if row.name == name != other.name and row.scene == other.scene
        if other.seconds < row.seconds and other.from_paper <= row.from_paper
    ]


def time_to_error(rows: list[SolveRow], name: str, target: float) -> float | None:
    """The least time of a row of a solver with at most this error, none interpolated."""
    times = (row.seconds for row in rows if row.name == name and row.error <= target)
    return min(times, default=None)
