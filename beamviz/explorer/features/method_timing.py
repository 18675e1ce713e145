"""What each method takes, in time, and gives, in accuracy, for the beam that is shown."""

from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from typing import Any, NamedTuple

import numpy as np

from beamviz.errors import BeamvizError
from beamviz.explorer.jobs import Latest, stale
from beamviz.explorer.request import Wanted
from beamviz.explorer.solver_job import Answer
from beamviz.server.log import RateLimitedLog
from beamviz.solver import METHODS, Solution, solve

EXACT = 1e-11  # relative tolerance of what all are held against
FLOOR = 1e-12  # a smaller error is not told from it
REPEATS = 3  # the fastest counts
RESOLUTIONS: dict[str, tuple[float, ...]] = {
    "tolerance": (1e-2, 1e-4, 1e-6, 1e-8),
    "elements": (5, 10, 20, 40),
    "terms": (8, 16, 32),
}
OPTION = {
    **dict.fromkeys(("auto", "foac", "zoac"), "tolerance"),
    **dict.fromkeys(("ancf", "ancf-planar", "linear"), "elements"),
    **dict.fromkeys(("assumed-modes", "power-series", "chebyshev"), "terms"),
}

log = RateLimitedLog(__name__)


class Effort(NamedTuple):
    """One solve: its time [s], and the largest relative distance of a frequency from the exact
    one; or why there is none."""

    method: str
    resolution: str
    seconds: float
    error: float
    reason: str = ""


class Efforts(NamedTuple):
    """Every method at some resolutions, for one wish; why there is nothing to compare with."""

    wanted: Wanted
    points: tuple[Effort, ...]
    words: str = ""


def efforts(wanted: Wanted) -> Efforts:
    """All methods, timed on the beam that is wanted and held against its exact frequencies."""
    try:
        beam = wanted.beam()
        options = {**wanted.options, "method": "auto"}
        exact = solve(beam, **{**options, "tolerance": EXACT})
    except BeamvizError as error:
        return Efforts(wanted, (), str(error))

    def tried(method: str, resolution: float) -> Effort:
        option = OPTION[method]
        shown = f"{option} {resolution:g}"
        settings: dict[str, Any] = {**options, "method": method, option: resolution}
        try:
            runs = [solve(beam, **settings) for _ in range(REPEATS)]
        except BeamvizError as failure:
            return Effort(method, shown, np.nan, np.nan, str(failure))
        error, reason = distance(runs[0], exact)
        return Effort(method, shown, min(run.stats.seconds for run in runs), error, reason)

    points = [tried(method, r) for method in METHODS for r in RESOLUTIONS[OPTION[method]]]
    return Efforts(wanted, tuple(points))


def distance(solution: Solution, exact: Solution) -> tuple[float, str]:
    """The largest relative distance of a mode's frequency from the exact one of its name, and
    what is wrong beyond numbers."""
    if solution.equilibrium.status != exact.equilibrium.status:
        return np.nan, f"says {solution.equilibrium.status}: the beam is {exact.equilibrium.status}"
    pairs = list(paired(solution, exact))
    return max([FLOOR, *(abs(a - b) / abs(b) for a, b in pairs if b)]), ""


def paired(solution: Solution, exact: Solution) -> Iterator[tuple[float, float]]:
    """Frequencies (growth rates where unstable) of the modes that both have among theirs."""
    for k, label in enumerate(exact.labels):
        if label in solution.labels:
            j = solution.labels.index(label)
            if exact.omega_squared[k] >= 0 and solution.omega_squared[j] >= 0:
                yield float(solution.frequencies[j]), float(exact.frequencies[k])
            else:
                yield float(solution.growth_rates[j]), float(exact.growth_rates[k])


class Trials(Latest[Wanted, Efforts]):
    """Tries all methods for the latest wish of one visitor."""

    def answered(self, wanted: Wanted) -> Efforts:
        """Try all methods."""
        try:
            return efforts(wanted)
        except Exception as error:  # a mistake of ours must not end a visitor's session
            log.error("trial of methods", wanted, error)
            return Efforts(wanted, (), f"unexpected: {error}")


class Weighing:
    """Follows the scene while it is asked to; `draw` shows what has been measured since."""

    def __init__(self, pool: Executor, wake: Callable[[], None]):
        self.trials, self.wake = Trials(pool, wake), wake
        self.on = False
        self.answer: Answer | None = None
        self.drawn: tuple = ()

    def switch(self, on: Any) -> None:
        """Measure all methods for every beam that is shown, or stop."""
        self.on = bool(on)
        self.wake()

    @property
    def state(self) -> tuple:
        """What the tab depends on."""
        return self.answer, self.on, self.trials.answer

    @property
    def fresh(self) -> bool:
        """Whether something waits to be drawn."""
        return stale(self.drawn, self.state)

    def follow(self, answer: Answer | None) -> None:
        """Hear of what the scene shows."""
        self.answer = answer

    def shown(self) -> tuple[Answer | None, Efforts | None]:
        """What to draw; asks for what is missing."""
        self.drawn = self.state
        if not (self.on and self.answer):
            return self.answer, None
        wanted = self.answer.wanted
        beside = Wanted(wanted.numbers, {**wanted.options, "method": "auto"}, wanted.units)
        if beside != self.trials.wanted:
            self.trials.want(beside)
        return self.answer, self.trials.answer

    def close(self) -> None:
        """Nothing more is measured."""
        self.trials.close()
