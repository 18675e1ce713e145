"""The numbers in the lessons, computed when they are needed."""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import brentq

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium
from beamviz.frequency_loci import Event, loci
from beamviz.frequency_loci.forced_response import resonances
from beamviz.solver import Solution, solve

BARE = Beam()  # at rest, without mass
TIP = Beam(alpha=1, beta=1)
MIDDLE = Beam(alpha=1, beta=0.5)


def frequency(beam: Beam, label: str = "B1", **options: Any) -> float:
    """Frequency of the mode `label` of a beam."""
    return labelled(solve(beam, **options), label)


def labelled(solution: Solution, label: str) -> float:
    """Frequency of the mode `label`; nan where it is unstable or not among the modes solved."""
    frequencies = dict(zip(solution.labels, solution.frequencies, strict=True))
    return float(frequencies.get(label, np.nan))


def ratio_to_rest(solution: Solution) -> float:
    """Lowest frequency over that of the same beam at rest."""
    rest = frequency(solution.beam.replace(gamma=0), plane=solution.problem.plane)
    return float(solution.frequencies[0]) / rest


def ratio_of_planes(solution: Solution) -> float:
    """Flapwise B1 over chordwise B1 of the same beam."""
    beam = solution.beam
    return frequency(beam, plane="flapwise") / frequency(beam, plane="chordwise")


def ratio_to_bare(solution: Solution, label: str = "B1") -> float:
    """Frequency of a mode over that of the beam without its mass."""
    return labelled(solution, label) / frequency(solution.beam.replace(alpha=0), label)


def node() -> float:
    """The only vibration node of B2 of the bare beam."""
    (x,) = solve(BARE).nodes[1]
    return float(x)


def difference(solution: Solution) -> float:
    """|S1 - B3|."""
    return abs(labelled(solution, "S1") - labelled(solution, "B3"))


def crossing(over: str, stop: float, **options: Any) -> Event:
    """Crossing or veering of S1 and B3 with a mass as heavy as the beam at its tip."""
    found = loci(TIP, over, np.linspace(0, stop, 21), **options)
    return next(event for event in found.events if set(event.branches) == {"B3", "S1"})


def resonance(per_rev: int, label: str) -> float:
    """Speed at which omega = per_rev gamma for a mode of the bare beam."""
    found = resonances(loci(BARE, "gamma", np.linspace(0, 15, 31)), per_rev)
    return next(one.at for one in found if (one.per_rev, one.branch) == (per_rev, label))


def first_unstable(beam: Beam, stop: float, **options: Any) -> float:
    """Speed at which the straight beam becomes unstable."""
    found = loci(beam, "gamma", np.linspace(0, stop, 21), modes=1, **options)
    return next(limit.start for limit in found.limits if limit.kind == "unstable")


def last_equilibrium(beam: Beam, **options: Any) -> float:
    """Highest speed with an equilibrium."""
    try:
        solve(beam.replace(gamma=2 * beam.mu), **options)
    except NoEquilibrium as error:
        return error.limit
    raise ValueError(f"{beam} has an equilibrium at every speed tried")


def strain_at_mass(solution: Solution) -> tuple[float, float]:
    """Strain at the inner and at the outer side of the mass."""
    beta = solution.beam.beta
    inside, outside = solution.equilibrium.stretch(np.clip([beta - 1e-9, beta + 1e-9], 0, 1)) - 1
    return float(inside), float(outside)


def tip(beam: Beam) -> np.ndarray:
    """Position (2,) of the tip from the clamp in the stable state."""
    return solve(beam, state="stable").equilibrium.tip


def value_where(
    gauge: Callable[[Solution], float],
    level: float,
    beam: Beam,
    stop: float,
    number: str = "gamma",
    **options: Any,
) -> float:
    """The value of one of the five numbers, in 0.2 .. stop, at which a gauge has a level."""

    def excess(value: float) -> float:
        return gauge(solve(beam.replace(**{number: value}), **options)) - level

    return brentq(excess, 0.2, stop, xtol=1e-9)
