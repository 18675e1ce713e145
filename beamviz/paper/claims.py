"""Claims of accuracy: values from elsewhere, and the computations that must agree with them.

Frequencies are in 1/T* unless another unit is named.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import pi
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import PARAMETERS, Beam
from beamviz.errors import NoEquilibrium
from beamviz.frequency_loci import loci
from beamviz.paper.figures import LociFigure, PrintedCrossing, decimals, locate
from beamviz.plotting.style import OMEGAS
from beamviz.solver import solve

TOLERANCE = 1e-10
RIGID = 10000.0  # slenderness: the stretch, (gamma / mu)^2, is 1e-6 at most in the rigid tables


class Claim(NamedTuple):
    """Values from elsewhere, and the computation that must agree with them."""

    name: str  # of the row and of its test
    case: str
    quantity: str
    reference: str  # numbers as published, separated by spaces
    compute: Callable[[], Sequence[float]]
    digits: float = 1  # tolerance, in units of the last digit of the reference
    reason: str = ""  # for a larger tolerance

    def check(self) -> tuple[list[str], float]:
        """The values computed, rounded to one digit more than published, and the largest
        difference in units of the last digit published."""
        references = self.reference.split()
        pairs = list(zip(references, self.compute(), strict=True))
        shown = [f"{value:.{decimals(reference) + 1}f}" for reference, value in pairs]
        differences = (
            abs(float(ours) - float(reference)) * 10 ** decimals(reference)
            for reference, ours in zip(references, shown, strict=True)
        )
        return shown, round(max(differences), 1)


class Source(NamedTuple):
    """Claims from one source, and the tests that cover more than these."""

    title: str
    origin: str
    claims: list[Claim]
    tests: tuple[str, ...]


def frequencies(count: int, beam: Beam, **options: Any) -> list[float]:
    """The lowest frequencies."""
    return solve(beam, count, **{"tolerance": TOLERANCE, **options}).frequencies.tolist()


def by_label(labels: str, beam: Beam, **options: Any) -> list[float]:
    """Frequencies by label, as "B1 S1"."""
    solution = solve(beam, 7, **{"tolerance": TOLERANCE, **options})
    labelled = dict(zip(solution.labels, solution.frequencies.tolist(), strict=True))
    return [labelled[label] for label in labels.split()]


def by_family(count: int, beam: Beam) -> list[float]:
    """B1, B2, B3, B4 and S1."""
    return by_label("B1 B2 B3 B4 S1", beam)[:count]


def nodes(mode: int) -> list[float]:
    """The vibration nodes of a mode, counted from 1, of the bare beam at rest."""
    return solve(Beam(), mode, tolerance=TOLERANCE).nodes[mode - 1].tolist()


def equilibrium_limit(strain: str, delta: float) -> list[float]:
    """The largest gamma with an equilibrium (alpha 0, mu 70)."""
    try:
        solve(Beam(gamma=140, delta=delta), strain=strain)
    except NoEquilibrium as error:
        return [error.limit]
    return []


def stability_limit(beam: Beam, start: float, stop: float, **options: Any) -> list[float]:
    """The gamma at which a beam becomes unstable."""
    found = loci(beam, "gamma", np.linspace(start, stop, 6), modes=1, **options).limits
    return [limit.start for limit in found if limit.kind == "unstable"]


def closest_approach(coriolis: bool = False) -> list[float]:
    """The gamma at which S1 and B3 come closest (alpha = beta = 1), and their least gap."""
    gammas = np.linspace(4, 5, 11)
    event = loci(Beam(alpha=1), "gamma", gammas, coriolis=coriolis, tolerance=TOLERANCE).events[0]
    return [event.at, event.gap]


def cable() -> list[float]:
    """omega_k / gamma for vanishing bending stiffness, extrapolated in 1 / gamma from 50, 100 and
    200: the remainder is of order 1 / gamma^3."""
    ratios = [
        solve(Beam(gamma=g, mu=RIGID), 4, plane="flapwise", tolerance=TOLERANCE).frequencies / g
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
    return beam.units.hertz(np.array(by_label("B1 B2 B3 S1 B4", beam))).tolist()


def ancf_excess() -> list[float]:
    """Error [%] of omega_1 of the paper's elements in a bending layer thinner than these."""
    beam = Beam(gamma=50, delta=1)
    (ancf,), (exact,) = frequencies(1, beam, method="ancf", elements=20), frequencies(1, beam)
    return [100 * (ancf / exact - 1)]


def locations(figure: LociFigure, crossing: PrintedCrossing, *curvatures: str) -> list[float]:
    """Where two loci of a figure of the paper cross, by one or more curvature measures."""
    return [locate(figure, crossing, curvature=name, tolerance=TOLERANCE).at for name in curvatures]


# Rows of claims.


def omegas(count: int) -> str:
    """ω₁, ω₂, ω₃."""
    return ", ".join(OMEGAS[:count])


def flapwise(name: str, alpha: float, table: Mapping[int, str]) -> list[Claim]:
    """Frequencies by gamma, without stretch."""
    claims = []
    for gamma, values in table.items():
        count, beam = len(values.split()), Beam(alpha=alpha, gamma=gamma, mu=RIGID)
        compute = partial(frequencies, count, beam, plane="flapwise")
        claims.append(Claim(f"{name}-{gamma}", f"γ = {gamma}", omegas(count), values, compute))
    return claims


def _crossing(figure: LociFigure, crossing: PrintedCrossing) -> tuple[str, str]:
    """The end of the name of a claim, and its case."""
    low, high = crossing.loci
    return f"{figure.name}-{crossing.at}", f"figure {figure.name[3:]}, loci {low}/{high}"


def printed_crossing(
    figure: LociFigure, crossing: PrintedCrossing, digits: float = 1, reason: str = ""
) -> Claim:
    """A crossing as the paper prints it, by the material measure, which fits best."""
    name, case = _crossing(figure, crossing)
    compute = partial(locations, figure, crossing, "material")
    symbol = PARAMETERS[figure.over].symbol
    return Claim(f"paper-{name}", case, symbol, crossing.at, compute, digits, reason)


def located_crossing(figure: LociFigure, crossing: PrintedCrossing) -> Claim:
    """A crossing as located independently, by both measures."""
    name, case = _crossing(figure, crossing)
    quantity = f"{PARAMETERS[figure.over].symbol} (material, spatial)"
    values = f"{crossing.material} {crossing.spatial}"
    compute = partial(locations, figure, crossing, "material", "spatial")
    return Claim(f"crossing-{name}", case, quantity, values, compute)


def stretched(
    name: str,
    quantity: str,
    compute: Callable[[int, Beam], list[float]],
    table: Mapping[tuple[float, float, float, float], str],
    *tolerance: Any,
) -> list[Claim]:
    """Values computed for a beam, compute(number of values, beam), by its alpha .. delta."""
    claims = []
    for k, (numbers, values) in enumerate(table.items()):
        case = ", ".join(f"{symbol} = {x}" for symbol, x in zip("αβγδ", numbers, strict=True))
        values_of = partial(compute, len(values.split()), Beam(*numbers))
        claims.append(Claim(f"{name}-{k}", case, quantity, values, values_of, *tolerance))
    return claims
