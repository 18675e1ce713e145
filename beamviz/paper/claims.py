"""Claims of accuracy: values from elsewhere, and the computations that must agree with them.

Frequencies are in 1/T* unless another unit is named.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import pi
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium
from beamviz.frequency_loci import loci
from beamviz.paper.figures import PrintedNumber, decimals
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


def lowest(
    name: str, case: str, reference: str, beam: Beam, tolerance: tuple = (), **options: Any
) -> Claim:
    """The lowest frequencies of a beam, as many as the reference has; options of `solve`."""
    count = len(reference.split())

    def compute() -> list[float]:
        return solve(beam, count, **{"tolerance": TOLERANCE, **options}).frequencies.tolist()

    return Claim(name, case, ", ".join(OMEGAS[:count]), reference, compute, *tolerance)


def by_label(
    name: str, case: str, labels: str, reference: str, beam: Beam, **options: Any
) -> Claim:
    """Frequencies of a beam by label, as "B1 S1"; options of `solve`."""

    def compute() -> list[float]:
        return frequencies(labels, beam, **options)

    return Claim(name, case, labels.replace(" ", ", "), reference, compute)


def frequencies(labels: str, beam: Beam, **options: Any) -> list[float]:
    """Frequencies by label, as "B1 S1"."""
    solution = solve(beam, 7, **{"tolerance": TOLERANCE, **options})
    labelled = dict(zip(solution.labels, solution.frequencies.tolist(), strict=True))
    return [labelled[label] for label in labels.split()]


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
    return beam.units.hertz(np.array(frequencies("B1 B2 B3 S1 B4", beam))).tolist()


def ancf_excess() -> list[float]:
    """Error [%] of omega_1 of the paper's elements in a bending layer thinner than these."""
    beam = Beam(gamma=50, delta=1)
    (ancf,), (exact,) = frequencies("B1", beam, method="ancf"), frequencies("B1", beam)
    return [100 * (ancf / exact - 1)]


def described(alpha: float, beta: float, gamma: float, delta: float) -> str:
    """α = 1, β = 0.5, γ = 10, δ = 0."""
    return f"α = {alpha}, β = {beta}, γ = {gamma}, δ = {delta}"


def flapwise(name: str, alpha: float, table: Mapping[int, str]) -> list[Claim]:
    """Frequencies by gamma, without stretch."""
    return [
        lowest(
            f"{name}-{gamma}",
            f"γ = {gamma}",
            values,
            Beam(alpha=alpha, gamma=gamma, mu=RIGID),
            plane="flapwise",
        )
        for gamma, values in table.items()
    ]


def printed_number(number: PrintedNumber, digits: float = 1, reason: str = "") -> Claim:
    """A number as the paper prints it, by the material measure, which fits its crossings best."""
    compute = partial(_values, number, "material")
    name, case = f"paper-{number.figure}-{number.printed}", f"figure {number.figure[3:]}"
    return Claim(name, case, number.quantity, number.printed, compute, digits, reason)


def located_crossing(number: PrintedNumber) -> Claim:
    """A crossing as located independently, by both measures."""
    compute = partial(_values, number, "material", "spatial")
    name, case = f"crossing-{number.figure}-{number.printed}", f"figure {number.figure[3:]}"
    return Claim(name, case, f"{number.quantity} (material, spatial)", number.located, compute)


def _values(number: PrintedNumber, *curvatures: str) -> list[float]:
    return [number.compute(curvature=name, tolerance=TOLERANCE) for name in curvatures]
