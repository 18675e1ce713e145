"""The bare LAPACK time of a solve: the least that any solver of its eigenproblems would take; and
what they take from scipy.linalg.eigh, where anyone would start."""

import time
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from scipy.linalg import eigh, lapack

from beamviz.beam import Beam
from beamviz.solver import solve

REPEATS = 400
ROUTINES = ("dsygv", "dsygvd", "dsygvx", "dsyev", "dsyevd")


class Recorder:
    """Stands in for LAPACK's eigensolvers while open: times every call and keeps what was asked."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self.problems: list[partial[tuple]] = []

    def __enter__(self) -> "Recorder":
        self.real = {name: getattr(lapack, name) for name in ROUTINES}
        for name, routine in self.real.items():
            setattr(lapack, name, partial(self.timed, routine))
        return self

    def __exit__(self, *_: object) -> None:
        for name, routine in self.real.items():
            setattr(lapack, name, routine)

    def timed(self, routine: Callable[..., tuple], *matrices: Any, **options: Any) -> tuple:
        kept = [matrix.copy(order="K") for matrix in matrices]  # what LAPACK may overwrite
        self.problems.append(partial(routine, *kept, **options | {"overwrite_a": False}))
        start = time.perf_counter()
        answer = routine(*matrices, **options)
        self.seconds += time.perf_counter() - start
        return answer


class Bare(NamedTuple):
    """A default solve [s]; its eigenproblems alone, in a loop where caches are warm [s], by the
    routines of LAPACK and by scipy.linalg.eigh (all pairs); the share of the fastest solve that is
    spent in them."""

    solve: float
    alone: float
    eigh: float
    share: float

    @property
    def ratio(self) -> float:
        return self.solve / self.alone

    @property
    def ratio_to_eigh(self) -> float:
        return self.solve / self.eigh


def bare(beam: Beam, repeats: int = REPEATS) -> Bare:
    """A default solve against the eigenproblems in it."""
    seconds = least(partial(solve, beam), repeats)
    shares = []
    for _ in range(repeats):
        with Recorder() as recorder:
            start = time.perf_counter()
            solve(beam)
            total = time.perf_counter() - start
        shares.append((total, recorder.seconds / total))
    alone = sum(least(problem, repeats) for problem in recorder.problems)
    by_eigh = sum(least(partial(eigh, *problem.args), repeats) for problem in recorder.problems)
    return Bare(seconds, alone, by_eigh, min(shares)[1])


def least(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """The least time [s] of many calls."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)
