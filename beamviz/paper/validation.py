"""The validation page: published and independent values, computed again, with their tests.

    python -m beamviz.paper.validation > assets/validation.md

Frequencies are in 1/T* unless another unit is named. A tolerance counts units of the last digit
published; where it exceeds 1, a reason stands beside it.
"""

from functools import partial
from math import pi

from beamviz.beam import Beam
from beamviz.output import markdown_table
from beamviz.paper import claims
from beamviz.paper.claims import Claim, Source
from beamviz.paper.figures import NODES, printed_numbers

COMMAND = "python -m beamviz.paper.validation > assets/validation.md"
FILE = "tests/paper/test_validation.py"
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

LOOSE: dict[str, tuple[float, str]] = {
    "1.59": (2, "likely a root that holds the length of r' too, which gives 1.584"),
    "0.225": (2, "read off a curve; eq. 16 gives 0.2242"),
}
# Frequencies omega_1 .. by gamma.
UNIFORM_FLAPWISE = {
    0: "3.516 22.035 61.697",
    1: "3.682 22.181 61.842",
    2: "4.137 22.615 62.273",
    3: "4.797 23.320 62.985",
    4: "5.585 24.273 63.967",
    5: "6.450 25.446 65.205",
    6: "7.360 26.809 66.684",
    7: "8.300 28.334 68.386",
    8: "9.257 29.995 70.293",
    9: "10.226 31.771 72.387",
    10: "11.202 33.640 74.649",
    11: "12.184 35.589 77.064",
    12: "13.170 37.603 79.615",
}
TIP_MASS_FLAPWISE = {
    0: "1.557 16.25",
    1: "1.902 16.76",
    2: "2.670 18.19",
    3: "3.582 20.35",
    4: "4.543 23.03",
    5: "5.522 26.04",
    6: "6.509 29.29",
    7: "7.501 32.70",
    8: "8.495 36.21",
    9: "9.490 39.80",
    10: "10.49 43.45",
    11: "11.48 47.14",
    12: "12.48 50.86",
}
RIGID_CORIOLIS = {2: "3.6195", 4: "3.888", 6: "4.2393", 8: "4.6105", 10: "4.97", 50: "7.3362"}
TIP_MASS_AT_REST = "1.557298 16.25009 50.89584 105.1983 179.2320"  # alpha = beta = 1, omega_1 .. 5
STEEL_TUBE = "1.6554 16.0711 50.0235 76.4706 103.1995"  # [Hz] B1, B2, B3, S1, B4
# By alpha, beta, gamma, delta: B1 .. B4 and S1 (chordwise, green, spatial, mu 70); with Coriolis.
STRETCHED: dict[tuple[float, float, float, float], str] = {
    (0, 1, 0, 0): "3.5160153 22.0344916 61.6972144 120.9019161 109.9557429",
    (1, 0.5, 10, 0): "4.3905981 22.0954901 78.3525694 111.1520304 76.8632663",
    (1, 0.3, 50, 1): "55.7060158 124.7611423 234.4764718 380.8273268 154.1656016",
    (0, 1, 50, 1): "52.942507 172.905287 286.071455 408.016404 161.527165",
}
STRETCHED_CORIOLIS: dict[tuple[float, float, float, float], str] = {
    (1, 0.5, 10, 0): "4.2560380 21.9918226 78.2173207 79.5184410 111.0672016",
    (1, 0.3, 50, 1): "46.205059 117.208910 186.820598",
}
# The largest gamma with an equilibrium (alpha 0, mu 70), by strain law and delta.
LIMITS = {
    ("biot", 0): f"{35 * pi:.6f}",
    ("biot", 5): f"{35 * pi:.6f}",
    ("hencky", 0): "45.420",
    ("hencky", 1): "31.4887",
}
# S1 of the paper's elements beside a mass (alpha 1, beta 0.5, gamma 10), by number of elements.
SHARED_GRADIENT = {10: "77.005312", 20: "76.934327", 40: "76.898804", 80: "76.881037"}

PUBLISHED = "tests/solver/test_published.py"
SOURCES = (
    Source(
        "The paper",
        "The numbers printed in its text (figures 5 to 19); its crossings by the material measure,"
        " which fits them best (`beamviz reproduce numbers` shows both).",
        [
            *(
                claims.printed_number(number, *LOOSE.get(number.printed, ()))
                for number in printed_numbers()
                if number.kind in ("crossing", "node")
            ),
            claims.by_label(
                "constant-2",
                "figure 18, a mass α = 1 at the node",
                "B2",
                "22.0345",
                Beam(alpha=1, beta=float(NODES[0].at)),
            ),
            claims.by_label(
                "constant-3", "figure 16, its 20 elements", "B3", "61.6982", Beam(), method="ancf"
            ),
        ],
        (
            f"{PUBLISHED}::test_a_mass_at_a_node_changes_nothing",
            "tests/solver/test_ancf.py::test_force_of_the_paper",
            "tests/solver/test_ancf.py::test_tangent_of_the_paper",
        ),
    ),
    Source(
        "Crossings of loci",
        "Located independently of this project (green strain, μ = 70).",
        [claims.located_crossing(row) for row in printed_numbers() if row.kind == "crossing"],
        ("tests/oracle/test_oracle.py::test_crossings_of_the_loci",),
    ),
    Source(
        "A uniform beam, flapwise",
        "Wright, Smith, Thresher & Wang, J. Appl. Mech. 49 (1982), as quoted by Bir (2009, 2010);"
        " α = 0, δ = 0; no stretch (μ = 10000).",
        claims.flapwise("uniform", 0, UNIFORM_FLAPWISE),
        ("tests/solver/test_series.py::test_uniform_beam_flapwise",),
    ),
    Source(
        "A beam with a tip mass, flapwise",
        "The same source; α = β = 1, δ = 0, μ = 10000.",
        claims.flapwise("tip-mass", 1, TIP_MASS_FLAPWISE),
        ("tests/solver/test_series.py::test_tip_mass_flapwise",),
    ),
    Source(
        "At rest",
        "Math. Probl. Eng. 2017/1568019, table 1 (bending); ω = μz with z tan z = 1/α (stretching,"
        " μ = 70); VPCS, test SDLL15, as recomputed (a steel tube with a tip mass).",
        [
            claims.lowest(
                "tip-mass-at-rest", "α = β = 1", TIP_MASS_AT_REST, Beam(alpha=1, mu=claims.RIGID)
            ),
            claims.by_label("stretching-0", "α = 0", "S1", "109.9557", Beam()),
            claims.by_label("stretching-1", "α = 1", "S1", "60.2234", Beam(alpha=1)),
            Claim("tube", "steel tube", "B1, B2, B3, S1, B4 [Hz]", STEEL_TUBE, claims.tube),
        ],
        (
            f"{PUBLISHED}::test_tip_mass_at_rest_in_closed_form",
            f"{PUBLISHED}::test_stretching_at_rest_in_closed_form",
        ),
    ),
    Source(
        "Coriolis",
        "Hamza Cherif & Houmat, 24th ICAS, table 2 (α = 0, δ = 0, μ = 70), whose four decimals are"
        " cut off, not rounded: `foac` with Coriolis. Crossing and veering of B3 and S1"
        " (α = β = 1) and the frequencies below them: independent of this project.",
        [
            *(
                claims.lowest(
                    f"rigid-coriolis-{gamma}",
                    f"foac, γ = {gamma}",
                    value,
                    Beam(gamma=gamma),
                    tolerance=(30, "slightly unconverged in the source") if gamma == 50 else (),
                    method="foac",
                    coriolis=True,
                )
                for gamma, value in RIGID_CORIOLIS.items()
            ),
            Claim(
                "crossing", "Coriolis off", "γ and gap", "4.4641 0.0000", claims.closest_approach
            ),
            Claim(
                "veering",
                "Coriolis on",
                "γ and least gap",
                "4.650 0.241",
                partial(claims.closest_approach, coriolis=True),
            ),
            *(
                claims.lowest(
                    f"coriolis-{k}",
                    claims.described(*beam),
                    values,
                    Beam(*beam),
                    tolerance=(100, "seven significant digits are claimed"),
                    coriolis=True,
                )
                for k, (beam, values) in enumerate(STRETCHED_CORIOLIS.items())
            ),
        ],
        (
            f"{PUBLISHED}::test_coriolis_turns_a_crossing_into_a_veering",
            "tests/solver/test_solve.py::test_coriolis_vanishes_with_the_speed",
            "tests/solver/test_against_oracle.py::test_random_beams_with_coriolis",
        ),
    ),
    Source(
        "Stretched beams",
        "Computed independently of this project, at least seven digits (green, spatial, μ = 70).",
        [
            claims.by_label(
                f"stretched-{k}", claims.described(*beam), "B1 B2 B3 B4 S1", values, Beam(*beam)
            )
            for k, (beam, values) in enumerate(STRETCHED.items())
        ],
        (
            "tests/solver/test_against_oracle.py::test_random_beams",
            "tests/solver/test_against_oracle.py::test_random_beams_of_other_strain_laws",
        ),
    ),
    Source(
        "A spinning cable",
        "ω → γ √(k (2k − 1)) flapwise as bending stiffness vanishes (δ = 0), extrapolated from"
        " γ = 50, 100, 200.",
        [
            Claim(
                "cable",
                "EI → 0",
                "ω/γ, k = 1 .. 4",
                "1.00 2.45 3.87 5.29",
                claims.cable,
                5,
                "the limit itself is out of reach",
            ),
        ],
        ("tests/oracle/test_oracle.py::test_spinning_cable",),
    ),
    Source(
        "Where equilibrium ends",
        "biot: γ = μπ/2 in closed form; hencky: computed independently of this project (α = 0,"
        " μ = 70).",
        [
            Claim(
                f"{strain}-{delta}",
                f"{strain}, δ = {delta}",
                "γ",
                value,
                partial(claims.equilibrium_limit, strain, delta),
            )
            for (strain, delta), value in LIMITS.items()
        ],
        ("tests/solver/test_fem.py::test_hencky_limit",),
    ),
    Source(
        "Where stability ends",
        "Inward beams (δ = −1): a Ritz computation of the inextensible beam, 2.994, and with the"
        " shortening at μ = 70, 2.996. Without tension (`zoac`): ω₁ at rest, the paradox of Kane,"
        " Ryan & Banerjee (1987).",
        [
            Claim(
                name,
                case,
                "γ",
                value,
                partial(claims.stability_limit, beam, start, start + 1, method=method),
            )
            for name, case, value, beam, start, method in (
                (
                    "buckling-rigid",
                    "inward, no stretch",
                    "2.994",
                    Beam(delta=-1, mu=claims.RIGID),
                    2.5,
                    "auto",
                ),
                ("buckling", "inward, μ = 70", "2.996", Beam(delta=-1), 2.5, "auto"),
                ("paradox", "zoac", "3.516", Beam(), 3, "zoac"),
            )
        ],
        (
            "tests/solver/test_fem.py::test_buckling_speed",
            f"{PUBLISHED}::test_inward_beam_buckles",
            "tests/solver/test_solve.py::test_coriolis_does_not_move_the_point_of_buckling",
        ),
    ),
    Source(
        "What other methods miss",
        "Computed independently of this project: a rigid tension (`foac`), and the paper's uniform"
        " elements in a bending layer and beside an inner mass (α = 1, β = 0.5, γ = 10, where the"
        " exact answer is 76.86327).",
        [
            claims.lowest(
                "rigid-tension",
                "foac, δ = 1, γ = 50 (exact 52.94)",
                "61.59",
                Beam(gamma=50, delta=1),
                method="foac",
            ),
            Claim(
                "bending-layer",
                "20 elements, δ = 1, γ = 50",
                "ω₁ too high by [%]",
                "0.18",
                claims.ancf_excess,
            ),
            *(
                claims.by_label(
                    f"shared-gradient-{count}",
                    f"{count} elements beside a mass",
                    "S1",
                    value,
                    Beam(alpha=1, beta=0.5, gamma=10),
                    method="ancf",
                    elements=count,
                )
                for count, value in SHARED_GRADIENT.items()
            ),
        ],
        (
            "tests/solver/test_fem.py::test_finite_elements_converge_as_declared",
            "tests/solver/test_convergence.py::test_the_default_converges_exponentially",
        ),
    ),
)


def page() -> str:
    """The validation page, in markdown."""
    heading = ("case", "quantity", "reference", "found", "off by", "allowed", "test")
    parts = ["# Validation", SUMMARY, NOTE]
    for source in SOURCES:
        rows = [_cells(claim) for claim in source.claims]
        tests = ", ".join(f"`{test}`" for test in source.tests)
        parts += [f"## {source.title}", source.origin, markdown_table(heading, rows)]
        parts.append(f"Also held by {tests}.")
    return "\n\n".join(parts) + "\n"


def _cells(claim: Claim) -> list[str]:
    shown, off = claim.check()
    allowed = f"{claim.digits:g}" + (f" ({claim.reason})" if claim.reason else "")
    values = [", ".join(numbers) for numbers in (claim.reference.split(), shown)]
    test = f"`test_claim[{claim.name}]`"
    return [claim.case, claim.quantity, *values, f"{off:.1f}", allowed, test]


if __name__ == "__main__":
    print(page(), end="")
