"""Every claim of accuracy as a row: values from elsewhere, and how this program finds the same.

Frequencies are in 1/T* unless another unit is named. A tolerance counts units of the last digit
published; where it is more than 1, a reason stands beside it.
"""

from collections.abc import Callable, Sequence
from math import pi
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium
from beamviz.frequency_loci import Event, loci
from beamviz.paper.data import ELEMENTS, LociFigure, Meeting
from beamviz.paper.values import located
from beamviz.solver import solve

EXACT = 1e-10  # tolerance asked of the solver
RIGID = 10000.0  # slenderness: the stretch, (gamma / mu)^2, is 1e-6 at most in the rigid tables


class Claim(NamedTuple):
    """Some values from elsewhere, and the computation that must find them."""

    name: str  # of the row and of its test
    case: str
    quantity: str
    reference: tuple[str, ...]
    find: Callable[[], Sequence[float]]
    digits: float = 1  # units of the last digit of the reference that are allowed
    reason: str = ""


class Source(NamedTuple):
    """Claims from one source, and the tests that hold more than its rows."""

    title: str
    origin: str
    claims: tuple[Claim, ...]
    tests: tuple[str, ...] = ()


def lowest(count: int, beam: Beam, **options: Any) -> list[float]:
    """The lowest frequencies."""
    return solve(beam, count, **{"tolerance": EXACT, **options}).frequencies[:count].tolist()


def labelled(labels: str, beam: Beam, **options: Any) -> list[float]:
    """Frequencies by label."""
    solution = solve(beam, 7, **{"tolerance": EXACT, **options})
    found = dict(zip(solution.labels, solution.frequencies.tolist(), strict=True))
    return [found[label] for label in labels.split()]


def met(figure: LociFigure, meeting: Meeting, *curvatures: str) -> list[float]:
    """Where two loci of a figure of the paper meet."""
    return [
        located(figure, meeting, {"curvature": name, "tolerance": EXACT}).at for name in curvatures
    ]


def nodes(mode: int, beam: Beam) -> list[float]:
    """The vibration nodes of a mode, counted from 1."""
    return solve(beam, mode, tolerance=EXACT).nodes[mode - 1].tolist()


def limit(strain: str, delta: float) -> list[float]:
    """The largest gamma with an equilibrium (alpha 0, mu 70)."""
    try:
        solve(Beam(gamma=2 * 70, delta=delta), strain=strain)
    except NoEquilibrium as end:
        return [end.limit]
    return []


def instability(beam: Beam, start: float, stop: float, **options: Any) -> list[float]:
    """The gamma at which a beam becomes unstable."""
    found = loci(beam, "gamma", np.linspace(start, stop, 6), modes=1, **options).limits
    return [part.start for part in found if part.kind == "unstable"]


def veering() -> list[float]:
    """Where S1 and B3 come closest with Coriolis (alpha = beta = 1), and how close."""
    event: Event = loci(
        Beam(alpha=1), "gamma", np.linspace(4, 5, 11), coriolis=True, tolerance=EXACT
    ).events[0]
    return [event.at, event.gap]


def crossing() -> list[float]:
    """Where S1 and B3 meet without Coriolis, and how far apart they stay."""
    event: Event = loci(Beam(alpha=1), "gamma", np.linspace(4, 5, 11), tolerance=EXACT).events[0]
    return [event.at, event.gap]


def cable() -> list[float]:
    """omega_k / gamma as bending stiffness vanishes, extrapolated in 1 / gamma from 50, 100, 200.

    What is left falls with gamma^3.
    """
    ratios = [
        solve(Beam(gamma=g, mu=RIGID), 4, plane="flapwise", tolerance=EXACT).frequencies / g
        for g in (50, 100, 200)
    ]
    return ((ratios[0] - 6 * ratios[1] + 8 * ratios[2]) / 3).tolist()


def tube() -> list[float]:
    """Frequencies [Hz] of a steel tube with a mass at its tip."""
    beam = Beam.from_si(
        length=10.0,
        density=7800.0,
        area=pi / 4 * (0.35**2 - 0.32**2),
        second_moment=pi / 64 * (0.35**4 - 0.32**4),
        youngs_modulus=2.1e11,
        mass=1000.0,
    )
    assert beam.units is not None
    return beam.units.hertz(solve(beam, 5, tolerance=EXACT).frequencies).tolist()


def overshoot() -> list[float]:
    """How far off [%] the paper's omega_1 is in a bending layer thinner than its elements."""
    beam = Beam(gamma=50, delta=1)
    (paper,), (exact,) = lowest(1, beam, method="ancf", elements=ELEMENTS), lowest(1, beam)
    return [100 * (paper / exact - 1)]
