"""The validation page: published and independent values, computed again, with their tests.

    python scripts/validation.py > assets/validation.md

Frequencies are in 1/T* unless another unit is named. A tolerance counts units of the last digit
published; where it exceeds 1, a reason stands beside it.
"""

from collections.abc import Callable, Sequence
from functools import partial
from math import pi
from typing import Any, NamedTuple

import _script
import numpy as np

from beamviz.adjusting import adjust
from beamviz.beam import Beam
from beamviz.blade import Blade, Mass
from beamviz.dynamics import motion
from beamviz.dynamics.drives import Ramp
from beamviz.errors import NoEquilibrium
from beamviz.evidence.paper import compute, quantity
from beamviz.evidence.paper.figures import NODES, PRINTED, PrintedNumber, decimals
from beamviz.evidence.paper.tables import frequencies_by_label
from beamviz.files import markdown_table
from beamviz.frequency_loci import loci
from beamviz.plotting import OMEGAS
from beamviz.presets import preset
from beamviz.solver import Solution, solve_many

TEST = "tests/solver/test_"
COMMAND = "python scripts/validation.py > assets/validation.md"
FILE = "tests/evidence/paper/test_validation.py"
SUMMARY = (
    "Every claim of accuracy this program makes, row by row: a reference, published or computed"
    " independently of this program, and what this program finds, with one digit more. Frequencies"
    " are in units of 1/T* unless another unit is named. *Off by* and *allowed* count units of the"
    " last digit of the reference; of several numbers in a row the one farthest off counts."
)
NOTE = (
    f"Each row is held by the test in its last column, of `{FILE}`; the tests named below a table"
    f" hold more than its rows. The page is written by `{COMMAND}`; a test fails where it is not up"
    " to date, and another where a test it names does not exist."
)

TOLERANCE = 1e-10
SOLVED_MODES = 7  # enough to contain four bending modes and a stretching mode
LOOSE: dict[str, tuple[float, str]] = {  # by claim: tolerance in last digits, and its reason
    "paper-fig8-1.59": (2, "likely a root that holds the length of r' too, which gives 1.584"),
    "paper-fig11-0.225": (2, "read off a curve; eq. 16 gives 0.2242"),
    "rigid-coriolis-50": (30, "slightly unconverged in the source"),
    "coriolis-0": (100, "seven significant digits are claimed"),
    "coriolis-1": (100, "seven significant digits are claimed"),
    "cable": (5, "the limit itself is out of reach"),
    "taper-5": (2, "the strain, (gamma / mu)^2, is in the seventh digit"),
    "taper-10": (5, "the strain, (gamma / mu)^2, is in the seventh digit"),
    "bmodes-test01": (
        710,
        "1.1 %: BModes has twist of 11 degrees, offsets of the mass centre and rotary inertia of"
        " the sections, which couple the two planes",
    ),
    **dict.fromkeys(
        [f"pybmodes-{blade}" for blade in ("nrel-5mw-twisted-blade-0", "nrel-5mw-twisted-blade-1")]
        + [f"pybmodes-iea-3.4mw-blade-{part}" for part in (0, 1)],
        (2, "from 100 to 400 elements pyBModes still moves by 5 to 40"),
    ),
}
LOOSE |= {
    "measured-strip-bending_factor": (
        12,
        "1.3 %; three instruments of the report differ by 1.4 % in the first mode",
    ),
    "measured-strip-root": (38, "3.4 %: a soft root is not the reason"),
    "measured-strip-alpha": (38, "3.4 %: nor is a mass at the tip"),
}
MANOEUVRE_POINTS = 21601  # 0.001 T* apart
RIGID = 10000.0  # slenderness: the stretch, (gamma / mu)^2, is 1e-6 at most in the rigid tables


class Claim(NamedTuple):
    """Values from elsewhere, and the computation that must agree with them."""

    name: str  # of the row and of its test
    case: str
    quantity: str
    reference: str  # numbers as published, separated by spaces
    compute: Callable[[], Sequence[float]]

    @property
    def tolerance(self) -> tuple[float, str]:
        """In units of the last digit of the reference; the reason for more than 1."""
        return LOOSE.get(self.name, (1, ""))

    def check(self) -> tuple[list[str], float]:
        """The values computed, rounded to one digit more than published, and the largest
        difference in units of the last digit published."""
        shown, differences = [], []
        for reference, value in zip(self.reference.split(), self.compute(), strict=True):
            places = decimals(reference)
            shown.append(f"{value:.{places + 1}f}")
            differences.append(abs(float(shown[-1]) - float(reference)) * 10**places)
        return shown, round(max(differences), 1)


class Source(NamedTuple):
    """Claims from one source, and the tests that cover more than these."""

    title: str
    origin: str
    claims: list[Claim]
    tests: tuple[str, ...] = (f"{TEST}fixed_beams.py::test_every_error_is_within_the_reported_one",)


def frequencies(beam: Beam, count: int, labels: str = "", **options: Any) -> list[float]:
    """Frequencies of a beam by label, as "B1 S1", or the lowest; options of `solve`."""
    found = frequencies_by_label(beam, SOLVED_MODES, **{"tolerance": TOLERANCE, **options})
    return [found[label] for label in labels.split() or list(found)[:count]]


def claim(
    name: str, case: str, reference: str, beam: Beam, labels: str = "", **options: Any
) -> Claim:
    """The frequencies of a beam with these labels, or the lowest, as many as the reference has."""
    count = len(reference.split())
    compute = partial(frequencies, beam, count, labels, **options)
    quantity = labels.replace(" ", ", ") or ", ".join(OMEGAS[:count])
    return Claim(name, case, quantity, reference, compute)


def flapwise(name: str, alpha: float, table: Sequence[str]) -> list[Claim]:
    """Frequencies at gamma = 0, 1 .., without stretch; a row of the table for each mode."""
    return [
        claim(f"{name}-{g}", f"γ = {g}", " ".join(values), beam, plane="flapwise")
        for g, values in enumerate(zip(*map(str.split, table), strict=True))
        for beam in [Beam(alpha, gamma=g, mu=RIGID)]
    ]


def of_the_paper(prefix: str, number: PrintedNumber, reference: str, *curvatures: str) -> Claim:
    """A number that the paper prints, computed with some curvature measures."""

    def values() -> list[float]:
        return [compute(number, curvature=name, tolerance=TOLERANCE) for name in curvatures]

    name, case = f"{prefix}-{number.figure}-{number.printed}", f"figure {number.figure[3:]}"
    by = f" ({', '.join(curvatures)})" if len(curvatures) > 1 else ""
    return Claim(name, case, quantity(number) + by, reference, values)


def speed(name: str, case: str, reference: str, limit: Callable, *given: Any) -> Claim:
    """A speed that a function computes."""
    return Claim(name, case, "γ", reference, partial(limit, *given))


def equilibrium_limit(strain: str, delta: float) -> list[float]:
    """The largest gamma with an equilibrium (alpha 0, mu 70)."""
    answers = solve_many([Beam(gamma=140, delta=delta)], strain=strain)
    return [answer.limit for answer in answers if isinstance(answer, NoEquilibrium)]


def stability_limit(beam: Beam, start: float, method: str = "auto") -> list[float]:
    """The gamma at which a beam becomes unstable, within 1 above `start`."""
    found = loci(beam, "gamma", np.linspace(start, start + 1, 6), modes=1, method=method)
    return [limit.start for limit in found.limits if limit.kind == "unstable"]


def closest_approach(coriolis: bool = False) -> list[float]:
    """The gamma at which S1 and B3 come closest (alpha = beta = 1), and their least gap."""
    gammas = np.linspace(4, 5, 11)
    event = loci(Beam(alpha=1), "gamma", gammas, coriolis=coriolis, tolerance=TOLERANCE).events[0]
    return [event.at, event.gap]


veering = partial(closest_approach, coriolis=True)


def cable() -> list[float]:
    """omega_k / gamma for vanishing bending stiffness, extrapolated in 1 / gamma from 50, 100 and
    200: the remainder is of order 1 / gamma^3."""
    ratios = [
        np.array(frequencies(Beam(gamma=gamma, mu=RIGID), 4, plane="flapwise")) / gamma
        for gamma in (50, 100, 200)
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
    return beam.units.hertz(np.array(frequencies(beam, 5, "B1 B2 B3 S1 B4"))).tolist()


def blade_hertz(name: str, part: float, count: int) -> list[float]:
    """The lowest frequencies [Hz] of a preset that is not stretched, at a part of its rated speed,
    in both planes."""
    si = preset(name).beam.si
    beam = Beam.from_si(**{key: value for key, value in si.items() if key != "axial_stiffness"})
    assert beam.units
    at_speed = beam.replace(gamma=part * beam.gamma)
    solution = solve_many([at_speed], modes=count, plane="both", tolerance=TOLERANCE)[0]
    assert isinstance(solution, Solution)
    return [float(value) for value in beam.units.hertz(solution.frequencies)]


def pybmodes_claim(name: str, part: float, reference: str) -> Claim:
    """Frequencies of a preset at a part of its rated speed, by pyBModes with 400 elements."""
    case = f"{preset(name).title}, {'at rated speed' if part else 'at rest'}"
    compute = partial(blade_hertz, name, part, len(reference.split()))
    quantity = "flap 1, edge 1, flap 2, edge 2 [Hz]"
    return Claim(f"pybmodes-{name}-{part:g}", case, quantity, reference, compute)


def certification_blade() -> list[float]:
    """Frequencies [Hz] of flap 1, lag 1, flap 2 and lag 2 of BModes' test 1: a blade of 33.25 m at
    60 rpm on a hub of 1.75 m, its properties constant in each of 12 elements, from the middle."""
    ends = np.array([0, 0.08, 0.16, 0.24, 0.32, 0.4, 0.48, 0.56, 0.64, 0.72, 0.8, 0.9, 1])
    x, *columns = np.array(CERTIFICATION_BLADE).T
    middle = (ends[1:] + ends[:-1]) / 2
    mass, flap, lag, axial = (np.repeat(np.interp(middle, x, column), 2) for column in columns)
    length, time = 33.25, 33.25**2 * np.sqrt(mass[0] / lag[0])
    blade = Blade(
        x=tuple(np.repeat(ends, 2)[1:-1]),
        mass=tuple(mass / mass[0]),
        bending=tuple(lag / lag[0]),
        axial=tuple(axial / axial[0]),
        flap=tuple(flap / lag[0]),
    )
    beam = Beam(
        gamma=2 * pi * time,
        delta=1.75 / length,
        mu=length * np.sqrt(axial[0] / lag[0]),
        blade=blade,
    )
    flap_1, flap_2 = frequencies(beam, 2, "B1 B2", plane="flapwise")
    lag_1, lag_2 = frequencies(beam, 2, "B1 B2")
    return [omega / (2 * pi * time) for omega in (flap_1, lag_1, flap_2, lag_2)]


def measured_strip(free: str, low: float, high: float) -> list[float]:
    """Frequencies [Hz] of a clamped strip after a fit of one number to those measured. Before, its
    first mode is at the 7.15 Hz of the theory in the report, which does not tell its length."""
    first, slenderness = 2 * pi * 7.15, 1000.0
    stiffness = (first / 3.5160153) ** 2  # E I of a strip of 1 m and 1 kg
    strip = Beam.from_si(
        length=1.0,
        mass_per_length=1.0,
        bending_stiffness=stiffness,
        axial_stiffness=stiffness * slenderness**2,
    )
    hertz = [float(text) for text in MEASURED_STRIP.split()]
    measured = {"mode": ["B1", "B2", "B3"], "hertz": hertz, "error": [0.01 * f for f in hertz]}
    fitted = adjust(strip, {free: (low, high)}, measured=measured).beam
    assert fitted.units is not None
    return [fitted.units.hertz(omega) for omega in frequencies(fitted, 3)]


def measured_claim(free: str, case: str, low: float, high: float) -> Claim:
    compute = partial(measured_strip, free, low, high)
    return Claim(f"measured-strip-{free}", case, "B1, B2, B3 [Hz]", MEASURED_STRIP, compute)


def ancf_excess() -> list[float]:
    """Error [%] of omega_1 of the paper's elements in a bending layer thinner than these."""
    (ancf,), (converged,) = frequencies(FAST, 1, method="ancf"), frequencies(FAST, 1)
    return [100 * (ancf / converged - 1)]


# omega_1 .. in rows, at gamma = 0, 1 .. 12.
def least_deflection() -> list[float]:
    """Of the tip in Kane's manoeuvre [L]."""
    moved = motion(
        Beam(mu=447.2136),
        21.6,
        speed=Ramp(5.554921, 16.20185),
        tolerance=1e-6,
        points=MANOEUVRE_POINTS,
    )
    return [float(moved.tip[:, 1].min())]


def spun_up() -> list[float]:
    """The deflection of the tip [L] at four times in Kane's law to gamma 5 within 10 T*."""
    moved = motion(Beam(), 10, speed=Ramp(5, 10), tolerance=1e-6, points=5)
    return moved.tip[1:, 1].tolist()


def let_go() -> list[float]:
    """The deflection of the tip [L] at three times after a release from half a length."""
    moved = motion(Beam(alpha=1, gamma=3), 2, release=3, tolerance=1e-6, points=5)
    return moved.tip[[1, 2, 4], 1].tolist()


UNIFORM_FLAPWISE = (
    "3.516 3.682 4.137 4.797 5.585 6.450 7.360 8.300 9.257 10.226 11.202 12.184 13.170",
    "22.035 22.181 22.615 23.320 24.273 25.446 26.809 28.334 29.995 31.771 33.640 35.589 37.603",
    "61.697 61.842 62.273 62.985 63.967 65.205 66.684 68.386 70.293 72.387 74.649 77.064 79.615",
)
TIP_MASS_FLAPWISE = (
    "1.557 1.902 2.670 3.582 4.543 5.522 6.509 7.501 8.495 9.490 10.49 11.48 12.48",
    "16.25 16.76 18.19 20.35 23.03 26.04 29.29 32.70 36.21 39.80 43.45 47.14 50.86",
)
RIGID_CORIOLIS = {2: "3.6195", 4: "3.888", 6: "4.2393", 8: "4.6105", 10: "4.97", 50: "7.3362"}
FOAC_CORIOLIS: dict[str, Any] = {"method": "foac", "coriolis": True}
TIP_MASS_AT_REST = "1.557298 16.25009 50.89584 105.1983 179.2320"  # alpha = beta = 1, omega_1 .. 5
STEEL_TUBE = "1.6554 16.0711 50.0235 76.4706 103.1995"  # [Hz] B1, B2, B3, S1, B4
# By beam: B1 .. B4 and S1 (chordwise, green, spatial, mu 70); with Coriolis.
STRETCHED = {
    Beam(0, 1, 0, 0): "3.5160153 22.0344916 61.6972144 120.9019161 109.9557429",
    Beam(1, 0.5, 10, 0): "4.3905981 22.0954901 78.3525694 111.1520304 76.8632663",
    Beam(1, 0.3, 50, 1): "55.7060158 124.7611423 234.4764718 380.8273268 154.1656016",
    Beam(0, 1, 50, 1): "52.942507 172.905287 286.071455 408.016404 161.527165",
}
STRETCHED_CORIOLIS = {
    Beam(1, 0.5, 10, 0): "4.2560380 21.9918226 78.2173207 79.5184410 111.0672016",
    Beam(1, 0.3, 50, 1): "46.205059 117.208910 186.820598",
}
# The largest gamma with an equilibrium (alpha 0, mu 70), by strain law and delta.
BIOT = f"{35 * pi:.6f}"
LIMITS = {("biot", 0): BIOT, ("biot", 5): BIOT, ("hencky", 0): "45.420", ("hencky", 1): "31.4887"}
# Flapwise, height tapered to half: omega_1 .. omega_4, by gamma.
TAPER = {
    0: "3.823785 18.317261 47.264827 90.450478",
    5: "6.743398 21.905324 50.933802 94.206348",
    10: "11.501550 30.182742 60.563866 104.611959",
}
# pyBModes 1.19.1, 400 elements [Hz]: by preset and part of the rated speed.
PYBMODES = {
    "nrel-5mw-twisted-blade": {
        0.0: "0.6777 1.0864 1.9542 4.0089",
        1.0: "0.7294 1.0952 2.0135 4.0314",
    },
    "iea-3.4mw-blade": {0.0: "0.7931 1.0323 2.3863 3.2181", 1.0: "0.8302 1.0420 2.4316 3.2447"},
    "iea-10mw-blade": {0.0: "0.3913 0.6494 1.0465 1.8781", 1.0: "0.4438 0.6598 1.1095 1.9027"},
    "iea-15mw-blade": {0.0: "0.5555 0.6414 1.6767 2.0542", 1.0: "0.5790 0.6486 1.7022 2.0707"},
}
# x / L, mass [kg/m], flapwise and lagwise bending stiffness [N m^2], axial stiffness [N].
CERTIFICATION_BLADE = (
    (0.0, 1447.607, 7681460000.0, 7681460000.0, 17152700000.0),
    (0.02105, 180.333, 1169870000.0, 1169870000.0, 2640800000.0),
    (0.05263, 181.672, 1020620000.0, 1092280000.0, 2611300000.0),
    (0.10526, 183.905, 771880000.0, 962970000.0, 2562100000.0),
    (0.15789, 186.138, 523140000.0, 833660000.0, 2512900000.0),
    (0.21053, 188.37, 274400000.0, 704350000.0, 2463600000.0),
    (0.26316, 178.321, 234570000.0, 614650000.0, 2332800000.0),
    (0.31579, 168.271, 194740000.0, 524960000.0, 2202000000.0),
    (0.36842, 158.222, 154900000.0, 435260000.0, 2071200000.0),
    (0.42105, 148.172, 115070000.0, 345570000.0, 1940400000.0),
    (0.47368, 138.123, 75230000.0, 255870000.0, 1809600000.0),
    (0.52632, 122.896, 62490000.0, 217870000.0, 1605300000.0),
    (0.57895, 107.669, 49750000.0, 179860000.0, 1401100000.0),
    (0.63158, 92.442, 37010000.0, 141860000.0, 1196800000.0),
    (0.68421, 77.215, 24270000.0, 103850000.0, 992600000.0),
    (0.73684, 61.988, 11530000.0, 65850000.0, 788300000.0),
    (0.78947, 51.861, 9270000.0, 54250000.0, 654300000.0),
    (0.84211, 41.734, 7010000.0, 42660000.0, 520400000.0),
    (0.89474, 31.607, 4750000.0, 31060000.0, 386400000.0),
    (0.94737, 21.48, 2490000.0, 19470000.0, 252400000.0),
    (1.0, 11.353, 230000.0, 7870000.0, 118500000.0),
)
FAST, INNER_MASS = Beam(gamma=50, delta=1), Beam(alpha=1, beta=0.5, gamma=10)
INWARD, INWARD_RIGID = Beam(delta=-1), Beam(delta=-1, mu=RIGID)
MEASURED_STRIP = "6.5 40.1 111.5"  # [Hz]
MASS_AT_NODE = Beam(alpha=1, beta=float(NODES[0].printed))
# S1 of the paper's elements beside a mass (alpha 1, beta 0.5, gamma 10), by number of elements.
SHARED_GRADIENT = {10: "77.005312", 20: "76.934327", 40: "76.898804", 80: "76.881037"}
beside_a_mass = partial(claim, beam=INNER_MASS, labels="S1", method="ancf")

NUMBERS = ("alpha", "beta", "gamma", "delta")
SOURCES = (
    Source(
        "The paper",
        "The numbers printed in its text (figures 5 to 19); its crossings by the material measure,"
        " which fits them best (`beamviz reproduce numbers` shows both).",
        [
            *(
                of_the_paper("paper", number, number.printed, "material")
                for number in PRINTED
                if number.kind in ("crossing", "node")
            ),
            claim("fig18", "figure 18, a mass α = 1 at the node", "22.0345", MASS_AT_NODE, "B2"),
            claim("fig16", "figure 16, its 20 elements", "61.6982", Beam(), "B3", method="ancf"),
        ],
        (
            f"{TEST}published.py::test_a_mass_at_a_node_changes_nothing",
            f"{TEST}ancf.py::test_force_and_tangent_of_the_paper",
        ),
    ),
    Source(
        "Crossings of loci",
        "Located independently of this project (green strain, μ = 70).",
        [
            of_the_paper("crossing", number, number.located, "material", "spatial")
            for number in PRINTED
            if number.kind == "crossing"
        ],
        ("tests/frequency_loci/test_crossings.py::test_crossings_of_the_paper",),
    ),
    Source(
        "A uniform beam, flapwise",
        "Wright, Smith, Thresher & Wang, J. Appl. Mech. 49 (1982), as quoted by Bir (2009, 2010);"
        " α = 0, δ = 0; no stretch (μ = 10000).",
        flapwise("uniform", 0, UNIFORM_FLAPWISE),
    ),
    Source(
        "A beam with a tip mass, flapwise",
        "The same source; α = β = 1, δ = 0, μ = 10000.",
        flapwise("tip-mass", 1, TIP_MASS_FLAPWISE),
    ),
    Source(
        "At rest",
        "Math. Probl. Eng. 2017/1568019, table 1 (bending); ω = μz with z tan z = 1/α (stretching,"
        " μ = 70); VPCS, test SDLL15, as recomputed (a steel tube with a tip mass).",
        [
            claim("tip-mass-at-rest", "α = β = 1", TIP_MASS_AT_REST, Beam(alpha=1, mu=RIGID)),
            claim("stretching-0", "α = 0", "109.9557", Beam(), "S1"),
            claim("stretching-1", "α = 1", "60.2234", Beam(alpha=1), "S1"),
            Claim("tube", "steel tube", "B1, B2, B3, S1, B4 [Hz]", STEEL_TUBE, tube),
        ],
        (
            f"{TEST}published.py::test_tip_mass_at_rest_in_closed_form",
            f"{TEST}published.py::test_stretching_at_rest_in_closed_form",
        ),
    ),
    Source(
        "Coriolis",
        "Hamza Cherif & Houmat, 24th ICAS, table 2 (α = 0, δ = 0, μ = 70), whose four decimals are"
        " cut off, not rounded: `foac` with Coriolis. Crossing and veering of B3 and S1"
        " (α = β = 1) and the frequencies below them: independent of this project.",
        [
            *(
                claim(f"rigid-coriolis-{g}", f"foac, γ = {g}", w, Beam(gamma=g), **FOAC_CORIOLIS)
                for g, w in RIGID_CORIOLIS.items()
            ),
            Claim("crossing", "Coriolis off", "γ and gap", "4.4641 0.0000", closest_approach),
            Claim("veering", "Coriolis on", "γ and least gap", "4.650 0.241", veering),
            *(
                claim(f"coriolis-{k}", beam.described(NUMBERS), values, beam, coriolis=True)
                for k, (beam, values) in enumerate(STRETCHED_CORIOLIS.items())
            ),
        ],
        (
            "tests/frequency_loci/test_crossings.py::test_with_coriolis_they_veer",
            f"{TEST}solve.py::test_coriolis_vanishes_with_the_speed",
            f"{TEST}fixed_beams.py::test_every_error_is_within_the_reported_one",
        ),
    ),
    Source(
        "Stretched beams",
        "Computed independently of this project, at least seven digits (green, spatial, μ = 70).",
        [
            claim(f"stretched-{k}", beam.described(NUMBERS), values, beam, "B1 B2 B3 B4 S1")
            for k, (beam, values) in enumerate(STRETCHED.items())
        ],
    ),
    Source(
        "Blades",
        "A section tapered in height, flapwise: Ozdemir & Kaya, Meccanica 41 (2006), where"
        " published; it, two bodies, a tip body with rotary inertia and a hinge: computed"
        " independently of this project (μ = 10000).",
        [
            *(
                claim(
                    f"taper-{g}",
                    f"height tapered to half, γ = {g}",
                    values,
                    Beam(gamma=g, mu=RIGID, blade=Blade.tapered(height=0.5)),
                    plane="flapwise",
                )
                for g, values in TAPER.items()
            ),
            claim(
                "two-masses",
                "masses 1 at 0.5 and 1 at 1",
                "1.496465 9.468440 48.560866",
                Beam(mu=RIGID, masses=(Mass(1, 0.5), Mass(1, 1))),
            ),
            claim(
                "rotary-inertia",
                "tip mass 1 with Jz = 0.1",
                "1.429626 6.275326 24.751604",
                Beam(mu=RIGID, masses=(Mass(1, 1, (0, 0, 0.1)),)),
            ),
            claim(
                "hinge",
                "hinged root, flapwise, γ = 5",
                "5.000000 19.919660 54.241931",
                Beam(gamma=5, mu=RIGID, root=0),
                plane="flapwise",
            ),
        ],
        (
            f"{TEST}fixed_beams.py::test_every_error_is_within_the_reported_one",
            f"{TEST}blade.py::test_independent_values",
        ),
    ),
    Source(
        "A wind-turbine blade",
        "BModes' certification test 1 at 60 rpm (its input and output are in the repositories of"
        " BModes and pyBModes). BModes takes the properties constant in each of 12 elements, and"
        " so does this row; with the properties of the table linear between its stations the"
        " frequencies are 1.7863, 1.9974, 4.3576 and 6.6695 Hz, as the stiff root of 2 % of the"
        " span is then not cut off.",
        [
            Claim(
                "bmodes-test01",
                "CertTest Test01",
                "flap 1, lag 1, flap 2, lag 2 [Hz]",
                "1.7517 1.9444 4.1912 6.3492",
                certification_blade,
            )
        ],
        (f"{TEST}fixed_beams.py::test_every_error_is_within_the_reported_one",),
    ),
    Source(
        "Blades of reference wind turbines",
        "Presets, in both planes with their twist: the first flapwise and edgewise frequency of"
        " the IEA 15 MW blade at rest as published (Gaertner et al., NREL/TP-5000-75698, 2020,"
        " table 2-1), and pyBModes 1.19.1 with the same tables, 400 elements and the twist, at"
        " rest and at rated speed. Left out by both programs: torsion (a hundred times the"
        " bending stiffness in pyBModes), stretch (0.05 % of the NREL blade at rated speed),"
        " offsets of the axes, prebend, cone, air and weight. The blades of the NREL 5 MW"
        " turbine on their turbine, 0.666 to 0.699 Hz flapwise and 1.079 to 1.090 Hz edgewise"
        " (NREL/TP-500-38060, table 9-1, FAST), move hub and tower, too.",
        [
            Claim(
                "iea15-published",
                "IEA 15 MW, at rest",
                "flap 1, edge 1 [Hz]",
                "0.555 0.642",
                partial(blade_hertz, "iea-15mw-blade", 0.0, 2),
            ),
            *(
                pybmodes_claim(name, *row)
                for name, rows in PYBMODES.items()
                for row in rows.items()
            ),
        ],
        (f"{TEST}both_planes.py::test_a_blade_with_a_table_of_twist",),
    ),
    Source(
        "A spinning cable",
        "ω → γ √(k (2k − 1)) flapwise as bending stiffness vanishes (δ = 0), extrapolated from"
        " γ = 50, 100, 200.",
        [Claim("cable", "EI → 0", "ω/γ, k = 1 .. 4", "1.00 2.45 3.87 5.29", cable)],
    ),
    Source(
        "Limits of equilibrium",
        "biot: γ = μπ/2 in closed form; hencky: computed independently of this project (α = 0,"
        " μ = 70).",
        [
            speed(f"{law}-{delta}", f"{law}, δ = {delta}", value, equilibrium_limit, law, delta)
            for (law, delta), value in LIMITS.items()
        ],
        (f"{TEST}limits.py::test_limit_of_the_speed",),
    ),
    Source(
        "Limits of stability",
        "Inward beams (δ = −1): a Ritz computation of the inextensible beam, 2.994, and with the"
        " shortening at μ = 70, 2.996. Without tension (`zoac`): ω₁ at rest, the paradox of Kane,"
        " Ryan & Banerjee (1987). Experiments on what comes after buckling, by centrifugal and"
        " Euler forces (arXiv 2308.16667), and on harmonic rotation (arXiv 2602.20803), are not"
        " compared here: only their abstracts could be had, without numbers.",
        [
            speed(
                "buckling-rigid", "inward, no stretch", "2.994", stability_limit, INWARD_RIGID, 2.5
            ),
            speed("buckling", "inward, μ = 70", "2.996", stability_limit, INWARD, 2.5),
            speed("paradox", "zoac", "3.516", stability_limit, Beam(), 3, "zoac"),
        ],
        (f"{TEST}limits.py::test_buckling_speed",),
    ),
    Source(
        "Motion in time",
        "The spin-up of a robot arm (Kane, Ryan & Banerjee 1987; Simo & Vu-Quoc 1986), the least"
        " deflection of its tip, refined independently of this project; the others by positions of"
        " order 9 to 13 and DOP853 (green, spatial, μ = 70): from rest to γ = 5 within 10 T*, and"
        " α = 1, γ = 3, released from a transverse force of 3 E I / L² at the tip.",
        [
            Claim(
                "motion-kane",
                "the manoeuvre",
                "least tip deflection",
                "-0.05738",
                least_deflection,
            ),
            Claim(
                "motion-spin-up",
                "spin-up",
                "tip at 2.5, 5, 7.5, 10 T*",
                "-0.044492 -0.085439 -0.034429 -0.000452",
                spun_up,
            ),
            Claim(
                "motion-release",
                "release",
                "tip at 0.5, 1, 2 T*",
                "0.291948 -0.184758 -0.378047",
                let_go,
            ),
        ],
        (
            "tests/dynamics/test_motion.py::test_released_tip_mass_by_independent_values",
            "tests/dynamics/test_motion.py::test_random_motions_by_an_independent_integration",
        ),
    ),
    Source(
        "Measured in a laboratory",
        "A clamped strip on a shaker, short beam of AE 417, Aerospace Structures and"
        " Instrumentation Laboratory, Embry-Riddle Aeronautical University (2025): measured by the"
        " sweep generator,"
        " where the theory of the report has 7.15, 44.5 and 124.72 Hz. One number is fitted in each"
        " row: a bending stiffness lower by a fifth, as of a strip thinner by a tenth, explains all"
        " three to 1.3 %; a soft root or a mass at the tip does not. Of a rotating beam no"
        " measurement was found whose numbers and properties are both public.",
        [
            measured_claim("bending_factor", "E I × 0.805", 0.3, 2.0),
            measured_claim("root", "a soft root", 1.0, 1e4),
            measured_claim("alpha", "a mass at the tip", 0.0, 1.0),
        ],
        ("tests/adjusting/test_fit.py::test_every_number_may_be_free",),
    ),
    Source(
        "Errors of other methods",
        "Computed independently of this project: a rigid tension (`foac`), and the paper's uniform"
        " elements in a bending layer and beside an inner mass (α = 1, β = 0.5, γ = 10, where the"
        " converged answer is 76.86327).",
        [
            claim("foac", "foac, δ = 1, γ = 50 (converged 52.94)", "61.59", FAST, method="foac"),
            Claim("layer", "20 elements, δ = 1, γ = 50", "ω₁ too high by [%]", "0.18", ancf_excess),
            *(
                beside_a_mass(f"shared-gradient-{n}", f"{n} elements beside a mass", S1, elements=n)
                for n, S1 in SHARED_GRADIENT.items()
            ),
        ],
        (
            f"{TEST}methods.py::test_methods_converge_as_declared",
            f"{TEST}refinement.py::test_the_default_converges_exponentially",
        ),
    ),
)


def page() -> str:
    """The validation page, in markdown."""
    heading = ("case", "quantity", "reference", "found", "off by", "allowed", "test")
    parts = ["# Validation", SUMMARY, NOTE]
    for source in SOURCES:
        rows = []
        for row in source.claims:
            shown, off = row.check()
            digits, reason = row.tolerance
            cells = [row.case, row.quantity, row.reference.replace(" ", ", "), ", ".join(shown)]
            cells += [f"{off:.1f}", f"{digits:g} ({reason})" if reason else f"{digits:g}"]
            rows.append([*cells, f"`test_claim[{row.name}]`"])
        parts += [f"## {source.title}", source.origin, markdown_table(heading, rows)]
        parts.append(f"Also held by {', '.join(f'`{test}`' for test in source.tests)}.")
    return "\n\n".join(parts) + "\n"


if __name__ == "__main__":
    _script.Parser(__doc__).parse_args()
    print(page(), end="")
