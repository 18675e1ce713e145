"""Work against precision: the time of a solve against the error of its frequencies, for six beams
from gentle to harsh, every method of beamviz, and other programs.

The discretisation error is the largest relative error of the five lowest frequencies against the
exact ones of the method's own model (limits.json). The model error is the distance of these from
the exact ones of the paper's model. They are two quantities and are never added; the distance of
an answer from the paper's model is a third. Time is processor time, the least of many calls after
a first one, in one thread, assembly included, so that the load of the machine does not change it.
For another program it is that of its whole process.
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
from scipy.linalg import eigh

from beamviz.beam import Beam
from beamviz.errors import BeamvizError
from beamviz.files import package_text
from beamviz.solver import eigen, solve

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
REFERENCE = "green"  # the paper's model
FLOOR = 1e-15  # errors are drawn on a logarithmic axis
EXACT = 1e-13  # an error that no finer resolution need improve
REPEATS = 400

Theories = dict[str, np.ndarray | str]  # theory -> omega^2 (modes,) or why there is none


class Effort(NamedTuple):
    """How long to measure: `seconds` of repeats for each row, at most `budget` seconds for one
    call, only every `stride`-th resolution, the finest included, and `repeats` of eigenproblems."""

    seconds: float
    budget: float
    stride: int = 1
    repeats: int = REPEATS


FULL, QUICK = Effort(0.2, 4.0), Effort(0.03, 0.5, 2, 50)


class Solver(NamedTuple):
    """A method of beamviz or another program, at several resolutions.

    `theory` is the model whose exact frequencies it converges to, a key of limits.json; `option`
    says what its resolutions are; `omega_squared` maps beam, resolution and number of modes to
    omega^2 (modes,). For another program, `version` raises PackageNotFoundError where it is not
    installed, and `install` is the command that installs it.
    """

    name: str
    theory: str
    option: str
    resolutions: tuple[float, ...]
    omega_squared: Callable[[Beam, Any, int], np.ndarray]
    version: Callable[[], str] = str
    install: str = ""

    @property
    def missing(self) -> str:
        """Why it cannot run; empty where it can."""
        try:
            self.version()
        except PackageNotFoundError:
            return f"not installed: {self.install}"
        return ""


def _solve(method: str, option: str, beam: Beam, resolution: Any, modes: int) -> np.ndarray:
    options: dict[str, Any] = {option: resolution}
    return solve(beam, modes, method, **options).omega_squared


METHODS = tuple(
    Solver(name, theory, option, resolutions, partial(_solve, name, option))
    for name, theory, option, resolutions in (
        ("auto", "green", "tolerance", TOLERANCES),
        ("ancf", "green", "elements", ELEMENTS),
        ("ancf-planar", "green", "elements", ELEMENTS),
        ("chebyshev", "green", "terms", (8, 12, 16, 24, 32, 48, 64, 96)),
        ("foac", "rigid", "tolerance", TOLERANCES),
        ("linear", "rigid", "elements", ELEMENTS),
        ("assumed-modes", "rigid", "terms", (5, 6, 8, 10, 12, 14, 20)),
        ("power-series", "rigid", "terms", (24, 32, 40, 60, 80, 120)),
        ("zoac", "none", "tolerance", TOLERANCES),
    )
)


class Row(NamedTuple):
    """One solve: time [s], error and distance from the paper's model, or, where nan, the reason."""

    scene: str
    name: str
    theory: str
    option: str
    resolution: float | None = None
    seconds: float = math.nan
    error: float = math.nan
    from_paper: float = math.nan
    reason: str = ""


def limits() -> dict[str, Theories]:
    """The exact omega^2 of every scene in every model, or why there are none."""
    found = json.loads(package_text("benchmark/limits.json"))["limits"]
    for theories in found.values():
        theories |= {k: np.array(v, float) for k, v in theories.items() if isinstance(v, list)}
    return found


def relative_error(omega_squared: np.ndarray, exact: np.ndarray) -> float:
    """The largest relative error of a frequency or growth rate, from omega^2 (modes,)."""
    difference = abs(omega_squared - exact).max()
    return float(max(difference and (abs(omega_squared / exact - 1) / 2).max(), FLOOR))


def measure(solvers: Sequence[Solver], effort: Effort) -> list[Row]:
    """A row for every scene, solver and resolution."""
    exact = limits()
    rows: list[Row] = []
    for scene in SCENES:
        for solver in solvers:
            print(f"{scene}: {solver.name}", file=sys.stderr)
            rows += _rows_of(scene, solver, exact[scene], effort)
    return rows


def _rows_of(scene: str, solver: Solver, theories: Theories, effort: Effort) -> Iterator[Row]:
    """The rows of one solver in one scene, coarse to fine; the budget ends them. The first call
    warms up and gives the errors, the fastest of the others the time."""
    exact, paper = theories[solver.theory], np.asarray(theories[REFERENCE])
    blank = Row(scene, solver.name, solver.theory, solver.option)
    if isinstance(exact, str) or solver.missing:
        yield blank._replace(reason=solver.missing or str(exact))
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
            found = work()
        except BeamvizError as failure:
            spent = processor_time() - start
            yield row._replace(reason=str(failure))
            continue
        spent = least_time(work, seconds=effort.seconds)
        error, distance = relative_error(found, exact), relative_error(found, paper)
        yield row._replace(seconds=spent, error=error, from_paper=distance)
        if error < EXACT:
            break


def least_time(work: Callable, repeats: int = REPEATS, seconds: float = math.inf) -> float:
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


def lapack_ratios(beam: Beam, repeats: int = REPEATS) -> dict[str, float]:
    """The time of a default solve over that of its eigenproblems alone, repeated while caches are
    warm, by its own few calls of LAPACK ("bare_lapack") and by scipy.linalg.eigh ("eigh": the usual
    one, with all modes)."""
    problems, whole = eigenproblems(beam), least_time(partial(solve, beam), repeats)
    by_eigh = [partial(eigh, *(one.T for one in problem.args[:-1])) for problem in problems]
    works = {"bare_lapack": problems, "eigh": by_eigh}
    times = {name: sum(least_time(one, repeats) for one in alone) for name, alone in works.items()}
    return {name: whole / seconds for name, seconds in times.items()}


def eigenproblems(beam: Beam) -> list[partial[Any]]:
    """The eigenproblems of a default solve, as calls of the functions that solve them: with copies
    of M and K of M v = nu K v, or of A of A v = nu v, and the number of vectors."""
    problems: list[partial[Any]] = []

    def record(function: Callable[..., Any], *arguments: Any) -> Any:
        copies = (one.copy() if isinstance(one, np.ndarray) else one for one in arguments)
        place, problem = len(problems), partial(function, *copies)
        answer = function(*arguments)
        problems[place:] = [problem]  # without the calls that it made itself
        return answer

    functions = {name: getattr(eigen, name) for name in ("generalized_eigh", "eigh_largest")}
    try:
        for name, function in functions.items():
            setattr(eigen, name, partial(record, function))
        solve(beam)
    finally:
        vars(eigen).update(functions)
    return problems


def model_errors() -> dict[str, dict[str, float | str]]:
    """Scene, theory -> distance of its exact frequencies from the paper's model, or a reason."""
    errors = {}
    for scene, theories in limits().items():
        paper = np.asarray(theories.pop(REFERENCE))
        errors[scene] = {
            theory: values if isinstance(values, str) else relative_error(values, paper)
            for theory, values in theories.items()
        }
    return errors


def dominated(rows: list[Row], name: str) -> list[tuple[Row, Row]]:
    """Each row of a solver with one of another solver that is faster and at least as close to the
    paper's model; none where the solver is on the Pareto front."""
    return [
        (row, other)
        for row, other in product(rows, rows)
        if row.name == name != other.name and row.scene == other.scene
        if other.seconds < row.seconds and other.from_paper <= row.from_paper
    ]


def time_to_error(rows: list[Row], name: str, target: float) -> float | None:
    """The least time of a row of a solver with at most this error, none interpolated."""
    times = (row.seconds for row in rows if row.name == name and row.error <= target)
    return min(times, default=None)
