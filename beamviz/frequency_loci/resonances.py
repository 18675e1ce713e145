"""Where a frequency is a whole multiple of the speed: the per-rev lines of the Campbell diagram."""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from scipy.optimize import brentq

from beamviz.errors import InvalidInput
from beamviz.frequency_loci import Branch, Loci
from beamviz.solver import solve_many
from beamviz.solver.solution import Solution

MAX_SOLVES = 6
SETTLED = 1e-10  # of the largest speed: a smaller shift is not solved again


class Resonance(NamedTuple):
    """omega = per_rev gamma: a force that turns with the beam per_rev times excites a mode."""

    per_rev: int
    branch: str
    at: float  # gamma
    frequency: float


def resonances(loci: Loci, count: int) -> list[Resonance]:
    """The intersections of loci over gamma with the lines omega = k gamma, k = 1 .. count.

    Raises InvalidInput for loci over another number.
    """
    if count and loci.over != "gamma":
        raise InvalidInput(f"per-rev lines need loci over gamma, not over {loci.over}")
    seen = [
        _Seen(k, branch, i, loci.values)
        for branch in loci.branches
        for k in range(1, count + 1)
        for i in _sign_changes(branch.frequency - k * loci.values)
    ]
    for _ in range(MAX_SOLVES):
        moving = [one for one in seen if one.shift > SETTLED * loci.values[-1]]
        beams = [loci.beam.replace(gamma=one.at) for one in moving]
        modes = 1 + max((one.place for one in moving), default=0)
        for one, answer in zip(moving, solve_many(beams, modes=modes, **loci.options), strict=True):
            one.move(answer)
    found = [Resonance(one.k, one.branch.label, one.at, one.k * one.at) for one in seen]
    return sorted(found, key=lambda resonance: resonance.at)


def _sign_changes(difference: np.ndarray) -> list[int]:
    """The values behind which a difference changes its sign, or at which it has none."""
    known, above = np.isfinite(difference), difference >= 0
    return np.flatnonzero((above[:-1] != above[1:]) & known[:-1] & known[1:]).tolist()


class _Seen:
    """An intersection seen between two values, moved to where it is by chords."""

    def __init__(self, k: int, branch: Branch, i: int, values: np.ndarray):
        near = slice(max(i - 1, 0), i + 3)
        known = np.isfinite(branch.frequency[near])
        x, y = values[near][known], (branch.frequency[near] - k * values[near])[known]
        curve = Polynomial.fit(x, y, len(x) - 1)
        self.k, self.branch = k, branch
        self.place = int(branch.places[i : i + 2].max())
        ends = np.array(values[i : i + 2])
        if np.prod(curve(ends)) < 0:
            self.at = float(brentq(curve, *ends))
        else:  # it is at an end, but for rounding
            self.at = float(ends[abs(curve(ends)).argmin()])
        self.slope = float(curve.deriv()(self.at))
        self.shift = np.inf

    def move(self, answer: object) -> None:
        """Move by one more solution, the one here."""
        shift = 0.0
        if isinstance(answer, Solution):
            off = answer.frequencies - self.k * self.at
            shift = float(off[np.nanargmin(abs(off))] / self.slope)
        self.at, self.shift = self.at - shift, abs(shift)
