"""A second beam, drawn with the first one, and how its modes compare."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.drawing.beam_mesh import DrawnBeam
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.text import frequencies, significant
from beamviz.frequency_loci.identity import identify_modes, match_modes
from beamviz.solver.solution import Solution

SPACING = 0.5  # [beam lengths] between two beams, one above the other
THIS = "this beam"  # title of the first one there
DIGITS = 6  # of the frequencies that are compared


class Pair(NamedTuple):
    """Two beams in one scene. partner: the mode of the first for each mode of the second (m,), -1
    where none corresponds."""

    first: DrawnBeam
    second: DrawnBeam
    partner: NDArray


def pair_of(
    first: DrawnBeam, modes: SampledModes, title: str, *, stacked: bool, swings: bool = True
) -> Pair:
    """The first beam and the one of these modes, which moves in the modes that correspond to those
    of the first, in the same amounts. stacked: it is above the first; swings: else it is at
    rest."""
    partner = corresponding(first.shapes, modes)
    sizes = np.append(first.amplitudes, 0.0)[partner] if swings else 0.0 * partner
    second = DrawnBeam(modes, first.view, first.scale, sizes, title=title)
    return Pair(replace(first, title=THIS if stacked else ""), second, partner)


def corresponding(first: SampledModes, second: SampledModes) -> NDArray:
    """The mode of one beam (m,) for each mode of another; -1 where none corresponds."""
    if first.solution is None or second.solution is None:
        return np.full(len(second.modes), -1)
    return match_modes(second.solution, first.solution).partner


def pair_heights(*, stacked: bool) -> list[float]:
    """Heights [beam lengths] of the first beam, and of the second if that is above it."""
    return [-SPACING / 2, SPACING / 2] if stacked else [0.0]


# The frequencies of both


def compared_rows(first: Solution, second: Solution) -> list[tuple[str, str, str, str]]:
    """For each mode its name, the frequencies of both beams, and the change; modes are matched by
    shape, and one without a match has dashes."""
    partner = match_modes(first, second).partner
    rows = [row(first, k, second, int(j)) for k, j in enumerate(partner)]
    return rows + [row(first, -1, second, j) for j in range(len(second.labels)) if j not in partner]


def row(first: Solution, k: int, second: Solution, j: int) -> tuple[str, str, str, str]:
    """The row of mode k of a beam and mode j of another; -1 for one that is not solved."""
    pair = (first, k), (second, j)
    labels = dict.fromkeys(identify_modes(solution).labels[i] for solution, i in pair if i >= 0)
    before, after = (
        frequencies(solution.beam.units).factor * float(solution.frequencies[i])
        if i >= 0
        else math.nan
        for solution, i in pair
    )
    change = 100 * (after / before - 1) if before > 0 else math.nan
    return " → ".join(labels), number(before), number(after), percent(change)


def percent(change: float) -> str:
    """A change [%] with its sign and two digits; a dash for nan."""
    if not math.isfinite(change):
        return "–"
    sign = "\u2212" if change < 0 else "+"
    return f"{sign}{significant(abs(change), 2)} %"


def number(frequency: float) -> str:
    """A frequency as text; a dash for nan."""
    return f"{frequency:#.{DIGITS}g}".rstrip(".") if math.isfinite(frequency) else "–"
