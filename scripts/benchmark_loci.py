"""How fast a loci chart is, as ratios measured in one run: python scripts/benchmark_loci.py

201 points, 6 modes, relative 1e-6, tracked, with every crossing and veering located. Beside the
time of the whole chart: the share of it that solves the points of the grid, and the time of as many
separate calls of solve(), without tracking. Times are the least of several repeats, in one thread.
The goal is 40 ms; one frame at 60 Hz is 16 ms.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from functools import partial
from typing import Any, NamedTuple

import numpy as np

from beamviz import Beam, loci, solve
from beamviz.benchmark.work_precision import least_time
from beamviz.frequency_loci.sweep import EXTRA_MODES
from beamviz.solver import solve_many

POINTS, MODES = 201, 6
REPEATS = 10


class Case(NamedTuple):
    """One sweep."""

    name: str
    beam: Beam
    over: str
    stop: float
    options: dict[str, Any]


CASES = (
    Case("gamma, mass at the tip", Beam(alpha=1), "gamma", 20, {}),
    Case("gamma, mass at 0.5", Beam(alpha=1, beta=0.5), "gamma", 20, {}),
    Case("alpha, gamma 10", Beam(gamma=10), "alpha", 2, {}),
    Case("delta, gamma 10", Beam(alpha=1, gamma=10), "delta", 2, {}),
    Case("beta, gamma 5", Beam(alpha=0.5, gamma=5), "beta", 1, {}),
    Case("gamma to 60, delta 1", Beam(alpha=1, delta=1), "gamma", 60, {}),
    Case("gamma, Coriolis", Beam(alpha=1), "gamma", 20, {"coriolis": True}),
)


def chart(case: Case, values: np.ndarray) -> int:
    """The chart with all its frequencies read; the number of its crossings and veerings."""
    found = loci(case.beam, case.over, values, MODES, **case.options)
    assert sum(np.isfinite(branch.frequency).sum() for branch in found.branches) == POINTS * MODES
    return len(found.events)


def one_by_one(beams: list[Beam], options: dict[str, Any]) -> None:
    """Every beam by a call of its own."""
    for beam in beams:
        solve(beam, MODES, **options)


def main() -> None:
    """Print one line for each sweep."""
    heads = ("201 points, 6 modes, tracked", "events", "ms", "solving", "separate", "ratio")
    print("{:30}{:>9}{:>8}{:>9}{:>10}{:>7}".format(*heads))
    for case in CASES:
        values = np.linspace(0, case.stop, POINTS)
        beams = [case.beam.replace(**{case.over: value}) for value in values]
        batch = partial(solve_many, beams, modes=MODES + EXTRA_MODES, **case.options)
        whole = least_time(partial(chart, case, values), REPEATS)
        solving = least_time(batch, REPEATS)
        separate_time = least_time(partial(one_by_one, beams, case.options), 2)
        print(
            f"{case.name:30}{chart(case, values):9}{1e3 * whole:8.1f}{solving / whole:9.0%}"
            f"{1e3 * separate_time:10.1f}{separate_time / whole:7.2f}"
        )


if __name__ == "__main__":
    main()
