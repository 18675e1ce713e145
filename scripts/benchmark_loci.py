"""How fast a loci chart is, as ratios measured in one run: python scripts/benchmark_loci.py

201 and 2001 points, 6 modes, relative 1e-6, with every crossing and veering located, beside bare
batched numpy.linalg.eigh of 201 matrices of 20 x 20. Times are of the processor, in one thread, the
least of several repeats in which the three take turns: so the ratios survive a busy machine.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from _arguments import Parser

from beamviz import Beam, loci

POINTS, MODES = 201, 6
REPEATS = 20


class Case(NamedTuple):
    """One sweep."""

    name: str
    beam: Beam
    over: str
    stop: float
    options: dict[str, Any]
    start: float = 0.0


CORIOLIS = {"coriolis": True}
MIDDLE = Beam(alpha=1, beta=0.5, gamma=10)
CASES = (
    Case("gamma, mass at the tip", Beam(alpha=1), "gamma", 20, {}),
    Case("gamma, mass at 0.5", Beam(alpha=1, beta=0.5), "gamma", 20, {}),
    Case("alpha, gamma 10", Beam(gamma=10), "alpha", 2, {}),
    Case("delta, gamma 10", Beam(alpha=1, gamma=10), "delta", 2, {}),
    Case("mu, gamma 10", Beam(alpha=1, gamma=10), "mu", 100, {}, 10.0),
    Case("beta, gamma 5", Beam(alpha=0.5, gamma=5), "beta", 1, {}),
    Case("gamma to 60, delta 1", Beam(alpha=1, delta=1), "gamma", 60, {}),
    Case("gamma, Coriolis", Beam(alpha=1), "gamma", 20, CORIOLIS),
    Case("alpha, Coriolis", MIDDLE, "alpha", 2, CORIOLIS),
    Case("delta, Coriolis", MIDDLE, "delta", 2, CORIOLIS),
    Case("mu, Coriolis", MIDDLE, "mu", 200, CORIOLIS, 10.0),
    Case("beta, Coriolis", MIDDLE, "beta", 1, CORIOLIS),
)


def chart(case: Case, values: np.ndarray) -> int:
    """The chart with all its frequencies read; the number of its crossings and veerings."""
    found = loci(case.beam, case.over, values, MODES, **case.options)
    assert (
        sum(np.isfinite(branch.frequency).sum() for branch in found.branches) == len(values) * MODES
    )
    return len(found.events)


def least_times(*functions: Callable[[], object]) -> list[float]:
    """The least processor times [s] of functions that are called in turn."""
    least = [float("inf")] * len(functions)
    for _ in range(REPEATS):
        for k, function in enumerate(functions):
            start = time.process_time()
            function()
            least[k] = min(least[k], time.process_time() - start)
    return least


def main() -> None:
    """Print one line for each sweep."""
    A = np.random.default_rng(0).normal(size=(201, 20, 20))
    bare = partial(np.linalg.eigh, A + A.mT)
    print(
        "{:30}{:>9}{:>8}{:>10}{:>8}{:>14}".format(
            "", "events", "ms", "eigh, ms", "ratio", "2001 / 201"
        )
    )
    for case in CASES:
        charts = [
            partial(chart, case, np.linspace(case.start, case.stop, n)) for n in (POINTS, 2001)
        ]
        few, many, eigh = least_times(*charts, bare)
        print(
            f"{case.name:30}{charts[0]():9}{1e3 * few:8.1f}{1e3 * eigh:10.1f}{few / eigh:8.2f}"
            f"{many / few:14.2f}"
        )


if __name__ == "__main__":
    Parser(__doc__).parse_args()
    main()
