"""The paper's rotating beam on ANCF elements: printed numbers, convergence, properties of modes."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from beamviz.beam import Beam
from beamviz.solver.constitutive import CURVATURES, STRAIN_LAWS
from beamviz.solver.fem import assembly, planar
from beamviz.solver.fem.equilibrium import straight_equilibrium
from beamviz.solver.fem.hermite import uniform


def model(elements=20, law="green", curvature="spatial", plane="chordwise", **numbers):
    nodes = uniform(elements) if isinstance(elements, int) else elements
    return planar.model(Beam(**numbers), nodes, STRAIN_LAWS[law], CURVATURES[curvature], plane)


def families(count=8, **options):
    """Frequencies of bending and of stretching, each ascending, at the straight equilibrium."""
    scene = model(**options)
    squares, shapes = planar.modes(scene, straight_equilibrium(scene).q, count)
    across = np.any(shapes[1::2], axis=0)
    return np.sqrt(squares[across]), np.sqrt(squares[~across])


def test_third_frequency_of_the_paper():
    """20 elements give the paper's omega_3 = 61.6982 for the bare beam at rest (figs. 16-19); the
    exact one is 61.697214."""
    bending, _ = families()
    assert round(bending[2], 4) == 61.6982
    assert families(elements=80)[0][2] == pytest.approx(61.697214, abs=5e-6)


def test_second_frequency_of_the_paper():
    """20 elements give the paper's omega_2 = 22.0345 (figs. 17-18)."""
    assert round(families()[0][1], 4) == 22.0345


# Closed forms at rest: Blevins; Karnovsky & Lebed. Tip mass: MPE 2017/1568019, table 1.
@pytest.mark.parametrize(
    ("alpha", "bending", "stretching"),
    [
        (0, [3.5160153, 22.0344916, 61.6972144, 120.9019161], 109.9557429),
        (1, [1.557298, 16.25009, 50.89584, 105.1983], 60.2234),
    ],
)
def test_at_rest(alpha, bending, stretching):
    """40 elements reproduce the closed forms of a beam at rest with and without a tip mass."""
    B, S = families(elements=40, alpha=alpha)
    assert B[:4] == pytest.approx(bending, rel=1e-5)
    assert S[0] == pytest.approx(stretching, rel=1e-6)


# Independent values, green, spatial, chordwise, mu 70. The tolerance is the error of uniform cubic
# elements: boundary layers at gamma 50 without a mass, first order in h beside an inner mass.
@pytest.mark.parametrize(
    ("numbers", "bending", "stretching", "elements", "tolerance"),
    [
        (
            {"alpha": 0, "gamma": 50, "delta": 1},
            [52.942507, 172.905287, 286.071455, 408.016404],
            161.527165,
            80,
            1e-4,
        ),
        (
            {"alpha": 1, "beta": 0.5, "gamma": 10},
            [4.3905981, 22.0954901, 78.3525694, 111.1520304],
            76.8632663,
            80,
            5e-4,
        ),
        (
            {"alpha": 1, "beta": 0.3, "gamma": 50, "delta": 1},
            [55.7060158, 124.7611423, 234.4764718, 380.8273268],
            154.1656016,
            80,
            1e-3,
        ),
    ],
)
def test_rotating(numbers, bending, stretching, elements, tolerance):
    """Rotating beams with no mass and with an inner one come near the exact frequencies."""
    B, S = families(elements=elements, **numbers)
    assert B[:4] == pytest.approx(bending, rel=tolerance)
    assert S[0] == pytest.approx(stretching, rel=tolerance)


@pytest.mark.parametrize(
    ("elements", "stretching"), [(10, 77.005312), (20, 76.934327), (40, 76.898804), (80, 76.881037)]
)
def test_stretching_beside_an_inner_mass(elements, stretching):
    """The stretch frequency at alpha 1, beta .5, gamma 10, computed apart from this package with
    monomials, 8 Gauss points and the axial residual alone."""
    _, S = families(elements=elements, alpha=1, beta=0.5, gamma=10)
    assert S[0] == pytest.approx(stretching, abs=1e-6)


# (strain, curvature, numbers, elements), family, mode, rate in h
RATES = [
    ({"gamma": 0}, (8, 16, 32), "bending", 0, 4),
    ({"gamma": 0}, (8, 16, 32), "bending", 2, 4),
    ({"gamma": 0, "curvature": "material", "alpha": 1}, (8, 16, 32), "bending", 2, 4),
    ({"gamma": 10, "alpha": 1}, (16, 32, 64), "bending", 0, 4),
    ({"gamma": 10, "delta": 1}, (16, 32, 64), "bending", 2, 4),
    ({"gamma": 10, "alpha": 1, "law": "hencky"}, (16, 32, 64), "bending", 1, 4),
    ({"gamma": 10, "delta": 1, "curvature": "material"}, (16, 32, 64), "bending", 1, 4),
    ({"gamma": 10, "delta": 1}, (8, 16, 32), "stretching", 0, 6),
    ({"gamma": 10, "alpha": 1, "beta": 0.5}, (10, 20, 40), "stretching", 0, 1),
    ({"gamma": 30, "alpha": 1, "beta": 0.3, "delta": 1}, (20, 40, 80), "stretching", 0, 1),
    ({"gamma": 0, "alpha": 1, "beta": 0.5}, (10, 20, 40), "stretching", 0, 1),
]


@pytest.mark.parametrize(("options", "elements", "family", "mode", "rate"), RATES)
def test_convergence_rate(options, elements, family, mode, rate):
    """Frequencies converge at the declared order: 4 in h for bending without an inner mass, 6 for
    stretching, 1 for stretching beside an inner mass (the gradient cannot jump there)."""
    coarse, middle, fine = (
        families(elements=n, count=12, **options)[family == "stretching"][mode] for n in elements
    )
    assert np.log2((coarse - middle) / (middle - fine)) == pytest.approx(rate, abs=0.3)


# The paper's meetings of loci at mu 70, delta 0 (its figs. 5-7), located exactly for both
# measures of curvature; 20 elements, so the inner mass is loose (its stretch is 0.1 % high).
MEETINGS = [
    (1.0, 3, {"spatial": 4.464, "material": 4.406}, 2e-3),
    (1.0, 2, {"spatial": 16.319, "material": 16.215}, 2e-3),
    (0.5, 3, {"spatial": 9.373, "material": 9.206}, 0.06),
    (0.8, 3, {"spatial": 6.824, "material": 6.662}, 0.06),
    (0.8, 2, {"spatial": 17.589, "material": 17.343}, 0.06),
]


@pytest.mark.parametrize("curvature", CURVATURES)
@pytest.mark.parametrize(("beta", "bending_mode", "at", "tolerance"), MEETINGS)
def test_meetings_of_loci(beta, bending_mode, at, tolerance, curvature):
    """The first stretching locus meets a bending locus at the speed located independently."""

    def gap(gamma):
        B, S = families(alpha=1, beta=beta, gamma=gamma, curvature=curvature)
        return B[bending_mode - 1] - S[0]

    gamma = brentq(gap, at[curvature] - 0.5, at[curvature] + 0.5, xtol=1e-6)
    assert gamma == pytest.approx(at[curvature], abs=tolerance)


@given(alpha=st.floats(0, 3), beta=st.floats(0, 1), gamma=st.floats(0.1, 30), delta=st.floats(0, 2))
@settings(max_examples=25)
def test_flapwise_and_chordwise(alpha, beta, gamma, delta):
    """omega_flap^2 - omega_chord^2 = gamma^2 in bending; stretching does not know the plane."""
    numbers = {"alpha": alpha, "beta": beta, "gamma": gamma, "delta": delta}
    chord, S = families(elements=10, **numbers)
    flap, same = families(elements=10, plane="flapwise", **numbers)
    count = min(len(chord), len(flap))
    difference = flap[:count] ** 2 - chord[:count] ** 2
    assert difference == pytest.approx(gamma**2, rel=1e-6, abs=1e-6 * flap[count - 1] ** 2)
    assert S[: len(same)] == pytest.approx(same[: len(S)], rel=1e-9)


@pytest.mark.parametrize("x", [0.78344, 0.50355, 0.86768])
def test_mass_at_a_node_of_the_paper(x):
    """A mass at the node of mode 2 or 3 leaves its frequency alone at rest (paper, figs. 16-19)."""
    mode = 1 if x == 0.78344 else 2
    bare = families()[0][mode]
    loaded = [families(alpha=alpha, beta=x)[0][mode] for alpha in (0.5, 2, 10)]
    assert loaded == pytest.approx([bare] * 3, abs=2e-4)
    moved = families(alpha=2, beta=x - 0.05)[0][mode]
    assert abs(moved - bare) > 0.1


def test_modes_of_a_straight_state_are_apart():
    """Shapes have unit mass, are orthogonal, obey the clamp, and do not mix families: not even
    where a bending and a stretching frequency are equal to 1e-5."""
    scene = model(alpha=1, gamma=4.46417)
    squares, shapes = planar.modes(scene, straight_equilibrium(scene).q, 6)
    M = assembly.dense(scene.mass)
    assert abs(np.diff(np.sqrt(squares))).min() < 1e-2
    assert shapes.T @ M @ shapes == pytest.approx(np.eye(6), abs=1e-9)
    assert not shapes[list(planar.CLAMPED)].any()
    assert [bool(v[::2].any()) + bool(v[1::2].any()) for v in shapes.T] == [1] * 6


@pytest.mark.parametrize(("thin", "tolerance"), [(1e-2, 1e-7), (1e-3, 1e-5)])
def test_low_modes_survive_thin_elements(thin, tolerance):
    """Thin elements leave the low frequencies alone as far as rounding in the stiffness allows:
    its entries grow as 12 / h^3, so an element of 1e-3 costs six digits, not the mode."""
    nodes = np.unique(np.concatenate((uniform(20), [thin, 0.5 - thin, 0.5 + thin])))
    even = families(alpha=1, beta=0.5)[0]
    uneven = families(elements=nodes, alpha=1, beta=0.5)[0]
    assert uneven[:2] == pytest.approx(even[:2], rel=tolerance)


@given(seed=st.integers(0, 1000))
@settings(max_examples=20)
def test_residual_and_tangent_with_load(seed):
    """The tangent is the derivative of the residual at any state and load, in both planes; the
    clamp holds r(0) and the direction of r'(0) and nothing else."""
    rng = np.random.default_rng(seed)
    plane = ("chordwise", "flapwise")[seed % 2]
    scene = model(4, alpha=2, beta=0.6, delta=-0.4, plane=plane)
    q, load = scene.unstressed + 0.1 * rng.standard_normal(20), 30 * rng.random()
    K = assembly.dense(scene.tangent(q, load))
    free = [2, *range(4, 20)]
    columns = [scene.residual(q + 1e-30j * np.eye(20)[j], load).imag / 1e-30 for j in free]
    assert K[np.ix_(free, free)] == pytest.approx(
        np.array(columns)[:, free], abs=1e-12 * np.abs(K).max()
    )
    assert np.array_equal(K[list(planar.CLAMPED)], np.eye(20)[list(planar.CLAMPED)])
    assert not scene.residual(q, load)[list(planar.CLAMPED)].any()


@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
def test_coordinates_turn_with_the_beam(plane):
    """Chordwise the centrifugal field has no preferred direction at delta 0, flapwise it has."""
    scene = model(6, gamma=5, plane=plane)
    nodes, (c, s) = scene.elements.nodes, (np.cos(0.7), np.sin(0.7))
    turned = np.outer(nodes, [c, s, 0, 0]) + [0, 0, c, s]
    straight, tilted = (scene.residual(q, 25.0) for q in (scene.unstressed, turned.ravel()))
    back = tilted.reshape(-1, 2) @ np.array([[c, -s], [s, c]])
    alike = np.allclose(back[2:].ravel(), straight[4:], atol=1e-9)
    assert alike == (plane == "chordwise")


def test_gyroscopic_matrix_is_skew():
    """G is skew and couples stretching to bending only."""
    G = model(5, alpha=1, beta=0.3).gyroscopic
    assert np.array_equal(G, -G.T)
    assert not G[::2, ::2].any()
    assert G[1::2, ::2].any()


@pytest.mark.parametrize(("law", "curvature"), list(itertools.product(STRAIN_LAWS, CURVATURES)))
def test_all_models_agree_at_rest(law, curvature):
    """Laws and measures differ in nothing at rest."""
    B, S = families(law=law, curvature=curvature, alpha=0.5, beta=0.4)
    bending, stretching = families(alpha=0.5, beta=0.4)
    assert bending == pytest.approx(B, rel=1e-9)
    assert stretching == pytest.approx(S, rel=1e-9)
