"""The sources of published and independent values, with the tests that hold them."""

from functools import partial
from math import pi

from beamviz.beam import Beam
from beamviz.paper.claims import (
    RIGID,
    Claim,
    Source,
    cable,
    crossing,
    instability,
    labelled,
    limit,
    lowest,
    nodes,
    overshoot,
    tube,
    veering,
)
from beamviz.paper.data import ELEMENTS, NODES
from beamviz.paper.published import (
    INDEPENDENT,
    INDEPENDENT_CORIOLIS,
    TIP_MASS,
    UNIFORM,
    flapwise,
    in_families,
    independent,
    linear_coriolis,
    meetings,
    omegas,
    printed_meetings,
    shared_gradient,
)

PAPERS = {"method": "ancf", "elements": ELEMENTS}

SOURCES = (
    Source(
        "The paper",
        "The numbers printed in its text (figures 5 to 19); its meetings by the material measure,"
        " which fits them best (`beamviz reproduce numbers` shows both).",
        (
            *printed_meetings(),
            Claim("node-2", "figure 17", "node of mode 2", ("0.78344",), partial(nodes, 2, Beam())),
            Claim(
                "node-3",
                "figure 19",
                "nodes of mode 3",
                ("0.50355", "0.86768"),
                partial(nodes, 3, Beam()),
            ),
            Claim(
                "constant-2",
                "figure 18, a mass α = 1 at the node",
                "ω₂",
                ("22.0345",),
                partial(labelled, "B2", Beam(alpha=1, beta=float(NODES[0].at))),
            ),
            Claim(
                "constant-3",
                "figure 16, its 20 elements",
                "ω₃",
                ("61.6982",),
                partial(labelled, "B3", Beam(), **PAPERS),
            ),
        ),
        (
            "tests/solver/test_published.py::test_nodes_of_the_paper",
            "tests/solver/test_published.py::test_a_mass_at_a_node_changes_nothing",
            "tests/solver/test_ancf.py::test_force_of_the_paper",
            "tests/solver/test_ancf.py::test_tangent_of_the_paper",
        ),
    ),
    Source(
        "Meetings of loci",
        "Located independently of this project (green strain, μ = 70).",
        meetings(),
        ("tests/solver/test_published.py::test_meetings_of_the_loci",),
    ),
    Source(
        "A uniform beam, flapwise",
        "Wright, Smith, Thresher & Wang, J. Appl. Mech. 49 (1982), as quoted by Bir (2009, 2010);"
        " α = 0, δ = 0; no stretch (μ = 10000).",
        flapwise("uniform", UNIFORM, 0),
        ("tests/solver/test_published.py::test_uniform_beam_flapwise",),
    ),
    Source(
        "A beam with a tip mass, flapwise",
        "The same source; α = β = 1, δ = 0, μ = 10000.",
        flapwise("tip-mass", TIP_MASS, 1),
        ("tests/solver/test_published.py::test_tip_mass_flapwise",),
    ),
    Source(
        "At rest",
        "Math. Probl. Eng. 2017/1568019, table 1 (bending); ω = μz with z tan z = 1/α (stretching,"
        " μ = 70); VPCS, test SDLL15, as recomputed (a steel tube with a tip mass).",
        (
            Claim(
                "tip-mass-at-rest",
                "α = β = 1",
                omegas(5),
                ("1.557298", "16.25009", "50.89584", "105.1983", "179.2320"),
                partial(lowest, 5, Beam(alpha=1, mu=RIGID)),
            ),
            Claim("stretching-0", "α = 0", "S1", ("109.9557",), partial(labelled, "S1", Beam())),
            Claim(
                "stretching-1", "α = 1", "S1", ("60.2234",), partial(labelled, "S1", Beam(alpha=1))
            ),
            Claim(
                "tube",
                "steel tube",
                "B1, B2, B3, S1, B4 [Hz]",
                ("1.6554", "16.0711", "50.0235", "76.4706", "103.1995"),
                tube,
            ),
        ),
        (
            "tests/solver/test_published.py::test_tip_mass_at_rest_in_closed_form",
            "tests/solver/test_published.py::test_stretching_at_rest_in_closed_form",
            "tests/solver/test_published.py::test_tube_with_a_tip_mass",
        ),
    ),
    Source(
        "Coriolis",
        "Hamza Cherif & Houmat, 24th ICAS, table 2 (α = 0, δ = 0, μ = 70), whose four decimals are"
        " cut off, not rounded: `foac` with Coriolis. Crossing and veering of B3 and S1"
        " (α = β = 1) and the frequencies below them: independent of this project.",
        (
            *linear_coriolis(),
            Claim("crossing", "Coriolis off", "γ and gap", ("4.4641", "0.0000"), crossing),
            Claim("veering", "Coriolis on", "γ and least gap", ("4.650", "0.241"), veering),
            *independent(
                "coriolis",
                INDEPENDENT_CORIOLIS,
                "ω₁, ω₂, ..",
                partial(lowest, coriolis=True),
                100,
                "seven significant digits are claimed",
            ),
        ),
        (
            "tests/solver/test_published.py::test_independent_values_with_coriolis",
            "tests/solver/test_published.py::test_coriolis_turns_a_crossing_into_a_veering",
            "tests/solver/test_solve.py::test_coriolis_vanishes_with_the_speed",
            "tests/solver/test_against_oracle.py::test_random_beams_with_coriolis",
        ),
    ),
    Source(
        "Stretched beams",
        "Computed independently of this project, at least seven digits (green, spatial, μ = 70).",
        independent("independent", INDEPENDENT, "B1, B2, B3, B4, S1", in_families),
        (
            "tests/solver/test_published.py::test_independent_values",
            "tests/solver/test_against_oracle.py::test_random_beams",
            "tests/solver/test_against_oracle.py::test_random_beams_of_other_strain_laws",
        ),
    ),
    Source(
        "A spinning cable",
        "ω → γ √(k (2k − 1)) flapwise as bending stiffness vanishes (δ = 0), extrapolated from"
        " γ = 50, 100, 200.",
        (
            Claim(
                "cable",
                "EI → 0",
                "ω/γ, k = 1 .. 4",
                ("1.00", "2.45", "3.87", "5.29"),
                cable,
                5,
                "the limit itself is out of reach",
            ),
        ),
        ("tests/solver/test_published.py::test_spinning_cable",),
    ),
    Source(
        "Where equilibrium ends",
        "biot: γ = μπ/2 in closed form; hencky: computed independently of this project (α = 0,"
        " μ = 70).",
        (
            Claim("biot-0", "biot, δ = 0", "γ", (f"{35 * pi:.6f}",), partial(limit, "biot", 0)),
            Claim("biot-5", "biot, δ = 5", "γ", (f"{35 * pi:.6f}",), partial(limit, "biot", 5)),
            Claim("hencky-0", "hencky, δ = 0", "γ", ("45.420",), partial(limit, "hencky", 0)),
            Claim("hencky-1", "hencky, δ = 1", "γ", ("31.4887",), partial(limit, "hencky", 1)),
        ),
        (
            "tests/solver/test_published.py::test_no_equilibrium_beyond_the_limit",
            "tests/solver/test_equilibrium.py::test_hencky_limit",
        ),
    ),
    Source(
        "Where stability ends",
        "Inward beams (δ = −1): a Ritz computation of the inextensible beam, 2.994, and with the"
        " shortening at μ = 70, 2.996. Without tension (`zoac`): ω₁ at rest, the paradox of Kane,"
        " Ryan & Banerjee (1987).",
        (
            Claim(
                "buckling-rigid",
                "inward, no stretch",
                "γ",
                ("2.994",),
                partial(instability, Beam(delta=-1, mu=RIGID), 2.5, 3.5),
            ),
            Claim(
                "buckling",
                "inward, μ = 70",
                "γ",
                ("2.996",),
                partial(instability, Beam(delta=-1), 2.5, 3.5),
            ),
            Claim(
                "paradox",
                "zoac",
                "γ",
                ("3.516",),
                partial(instability, Beam(), 3, 4, method="zoac"),
            ),
        ),
        (
            "tests/solver/test_equilibrium.py::test_buckling_speed",
            "tests/solver/test_published.py::test_inward_beam_buckles",
            "tests/solver/test_solve.py::test_coriolis_does_not_move_the_point_of_buckling",
        ),
    ),
    Source(
        "What other methods miss",
        "Computed independently of this project: a rigid tension (`foac`), and the paper's uniform"
        " elements in a bending layer and beside an inner mass (α = 1, β = 0.5, γ = 10, where the"
        " exact answer is 76.86327).",
        (
            Claim(
                "rigid-tension",
                "foac, δ = 1, γ = 50",
                "ω₁ (exact 52.94)",
                ("61.59",),
                partial(lowest, 1, Beam(gamma=50, delta=1), method="foac"),
            ),
            Claim(
                "bending-layer",
                "20 elements, δ = 1, γ = 50",
                "ω₁ too high by [%]",
                ("0.18",),
                overshoot,
            ),
            *shared_gradient(),
        ),
        (
            "tests/solver/test_convergence.py::test_the_papers_elements_converge_as_declared",
            "tests/solver/test_convergence.py::test_the_default_converges_exponentially",
            "tests/solver/test_planar.py::test_stretching_beside_an_inner_mass",
        ),
    ),
)
