"""The numbers in the lessons, each computed when it is asked for."""

from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import brentq

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium
from beamviz.frequency_loci import Event, loci
from beamviz.frequency_loci.forced_response import resonances
from beamviz.solver import Solution, solve

BARE = Beam()  # at rest, without a mass
TIP = Beam(alpha=1, beta=1)  # with a mass as heavy as itself at its tip
MIDDLE = Beam(alpha=1, beta=0.5)


def omega(beam: Beam, label: str = "B1", **options: Any) -> float:
    """The frequency of the mode of that label."""
    return named(solve(beam, **options), label)


def named(solution: Solution, label: str) -> float:
    """The frequency of the mode of that label; nan where it is unstable or not among these."""
    frequencies = dict(zip(solution.labels, solution.frequencies, strict=True))
    return float(frequencies.get(label, np.nan))


def place(beam: Beam, label: str) -> int:
    """Which mode by frequency, from 1, has that label."""
    return solve(beam).labels.index(label) + 1


def ratio_to_rest(solution: Solution) -> float:
    """The lowest frequency over that of the same beam at rest."""
    rest = omega(solution.beam.replace(gamma=0), plane=solution.model.plane)
    return float(solution.frequencies[0]) / rest


def doubling_speed() -> float:
    """Where B1, out of the plane of rotation, is twice what it is at rest."""
    return root(lambda x: ratio_to_rest(solve(BARE.replace(gamma=x), plane="flapwise")) - 2, 1, 20)


def ratio_of_planes(solution: Solution) -> float:
    """B1 out of the plane of rotation over B1 in it, of the same beam."""
    up, aside = (omega(solution.beam, plane=plane) for plane in ("flapwise", "chordwise"))
    return up / aside


def speed_of_double_planes() -> float:
    """Where B1 is twice as fast out of the plane of rotation as in it."""
    return root(lambda x: ratio_of_planes(solve(BARE.replace(gamma=x))) - 2, 1, 20)


def share_of_bare(solution: Solution, label: str = "B1") -> float:
    """A frequency over that of the beam without its mass."""
    return named(solution, label) / omega(solution.beam.replace(alpha=0), label)


def place_of_two_thirds() -> float:
    """Where a mass as heavy as the beam lowers B1 to two thirds."""
    return root(lambda x: share_of_bare(solve(TIP.replace(beta=x))) - 2 / 3, 0.2, 1)


def node(mode: int = 2) -> float:
    """The only vibration node of mode 2 of the bare beam."""
    (x,) = solve(BARE).nodes[mode - 1]
    return float(x)


def distance(solution: Solution, one: str = "S1", other: str = "B3") -> float:
    """How far apart two frequencies are."""
    return abs(named(solution, one) - named(solution, other))


def gap(solution: Solution) -> float:
    """How far apart the third and the fourth frequency are, whatever they are called."""
    return float(solution.frequencies[3] - solution.frequencies[2])


def meeting(over: str, stop: float, **options: Any) -> Event[str]:
    """Where S1 and B3 meet with a mass as heavy as the beam at its tip."""
    found = loci(TIP, over, np.linspace(0, stop, 21), **options)
    return next(event for event in found.events if set(event.branches) == {"B3", "S1"})


def resonance(per_rev: int, label: str) -> float:
    """The speed at which a mode of the bare beam is pushed `per_rev` times per turn."""
    found = resonances(loci(BARE, "gamma", np.linspace(0, 15, 31)), per_rev)
    return next(one.at for one in found if (one.per_rev, one.branch) == (per_rev, label))


def first_unstable(beam: Beam, stop: float, **options: Any) -> float:
    """The speed at which the straight beam becomes unstable."""
    found = loci(beam, "gamma", np.linspace(0, stop, 21), modes=1, **options)
    return next(limit.start for limit in found.limits if limit.kind == "unstable")


def last_equilibrium(beam: Beam, **options: Any) -> float:
    """The highest speed with an equilibrium."""
    try:
        solve(beam.replace(gamma=2 * beam.mu), **options)
    except NoEquilibrium as error:
        return error.limit
    raise ValueError(f"{beam} has an equilibrium at every speed tried")


def strain_at_mass(solution: Solution) -> tuple[float, float]:
    """Stretch less one just inside the mass and just outside it."""
    beta = solution.beam.beta
    ends = np.clip([beta - 1e-9, beta + 1e-9], 0, 1)
    inside, outside = solution.equilibrium.stretch(ends) - 1
    return float(inside), float(outside)


def speed_of_strain(strain: float) -> float:
    """Where the beam is that much longer just inside a mass in its middle."""
    return root(lambda x: strain_at_mass(solve(MIDDLE.replace(gamma=x)))[0] - strain, 1, 30)


root = partial(brentq, xtol=1e-9)
