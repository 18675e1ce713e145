"""The planar ANCF elements: derivatives, symmetry, rigid motions, mass, the paper's formulas."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamviz.beam import Beam
from beamviz.solver.constitutive import CURVATURES, STRAIN_LAWS
from beamviz.solver.fem import elements
from beamviz.solver.fem.elements import PlanarBeam, element_coordinates, gauss, hermite
from beamviz.solver.problem import Problem

NODES = np.array([0, 0.12, 0.35, 0.6, 1])
STEP = 1e-30
TURN = np.array([[0, -1], [1, 0]])  # I~
SOFT = 10.0  # slenderness: bending is a hundredth of stretching, not a five-thousandth
every_model = pytest.mark.parametrize(
    ("strain", "curvature"), list(itertools.product(STRAIN_LAWS, CURVATURES))
)


def planar(strain="green", curvature="spatial", mu=70.0, plane="chordwise", **numbers):
    problem = Problem(strain=strain, curvature=curvature, plane=plane)
    return PlanarBeam(NODES, Beam(mu=mu, gamma=0, **numbers), problem)


def bent(seed):
    """A random state far from straight: tens of degrees, tens of percent of stretch."""
    noise = np.random.default_rng(seed).standard_normal((len(NODES), 4))
    return planar().unstressed + (noise * [0.05, 0.05, 0.25, 0.4]).ravel()


def energy(q, model, points=5):
    """int mu^2 e^2 / 2 + kappa^2 / 2 dx by a rule of its own."""
    x, weights = gauss(2 * points - 1)
    lengths = np.diff(model.nodes)[:, None]
    _, dS, ddS = hermite(x, lengths)
    q_e = element_coordinates(q, 4).reshape(-1, 1, 4, 2)
    (r1, r2), (dr1, dr2) = (np.moveaxis(S[..., None, :] @ q_e, -1, 0)[..., 0] for S in (dS, ddS))
    f = np.sqrt(r1**2 + r2**2)
    kappa = (r1 * dr2 - r2 * dr1) / f**model.curvature_power
    density = model.beam.mu**2 * model.law.strain(f) ** 2 + kappa**2
    return np.sum(weights * lengths * density) / 2


def force(q, model):
    return elements.assemble_vector(model.force(element_coordinates(q, 4)))


def tangent(q, model):
    """The assembled elastic tangent (20, 20), from element matrices that need not be symmetric."""
    K = np.zeros((len(q), len(q)))
    for e, K_e in enumerate(model.stiffness(element_coordinates(q, 4))):
        K[4 * e : 4 * e + 8, 4 * e : 4 * e + 8] += K_e
    return K


def complex_step(function, q):
    """The derivative of an analytic function of q, exact to rounding: (20, ...)."""
    return np.array([function(q + 1j * STEP * unit).imag / STEP for unit in np.eye(len(q))])


@every_model
@pytest.mark.parametrize("mu", [SOFT, 70.0])
@pytest.mark.parametrize("seed", range(3))
def test_force_and_tangent_are_derivatives(strain, curvature, mu, seed):
    """The force is dU/dq and the tangent d^2 U/dq^2 to rounding, and symmetric, at bent states."""
    model, q = planar(strain, curvature, mu), bent(seed)
    F = complex_step(lambda q: energy(q, model), q)
    K = complex_step(lambda q: force(q, model), q)
    scale = np.abs(K).max()
    assert force(q, model) == pytest.approx(F, abs=1e-12 * np.abs(F).max())
    assert tangent(q, model) == pytest.approx(K, abs=1e-12 * scale)
    assert tangent(q, model) == pytest.approx(tangent(q, model).T, abs=1e-13 * scale)


@settings(max_examples=20)
@given(seed=st.integers(0, 1000))
def test_residual_and_tangent_with_load(seed):
    """The tangent is the derivative of the residual at any state and load, in both planes."""
    rng = np.random.default_rng(seed)
    plane = ("chordwise", "flapwise")[seed % 2]
    model = planar(plane=plane, alpha=2, beta=0.6, delta=-0.4)
    q, load = model.unstressed + 0.1 * rng.standard_normal(20), 30 * rng.random()
    K = complex_step(lambda q: model.residual(q, load), q)
    assert elements.dense(model.tangent(q, load)) == pytest.approx(K, abs=1e-12 * np.abs(K).max())


@pytest.mark.parametrize("seed", range(5))
def test_force_and_tangent_of_the_paper(seed):
    """The force of a green beam with spatial curvature is the paper's eq. 17, term by term, and
    the tangent its eq. 44, with its one unsymmetric term, -6 Gamma q q' S'S', made symmetric: as
    printed it is not the derivative of eq. 17."""
    model, q_e = planar(mu=SOFT), element_coordinates(bent(seed), 4)
    paper = [paper_element(e, q, SOFT) for e, q in enumerate(q_e)]
    Q_f, K = map(np.array, zip(*paper, strict=True))
    assert model.force(q_e) == pytest.approx(-Q_f, abs=1e-12 * np.abs(Q_f).max())
    K_e, scale = model.stiffness(q_e), np.abs(K).max()
    assert K_e == pytest.approx((K + K.swapaxes(1, 2)) / 2, abs=1e-12 * scale)
    assert np.abs(K_e - K).max() > 1e-4 * scale


def paper_element(e, q, mu):
    """Q_fe (eq. 17) and K_e (eq. 44) of one element with the paper's own symbols, as printed."""
    length, EA, EI = np.diff(NODES)[e], mu**2, 1.0
    Q_f, K = np.zeros(8), np.zeros((8, 8))
    for xi, weight in zip(*gauss(9), strict=True):
        dx = weight * length
        dS, ddS = (np.kron(s, np.eye(2)) for s in hermite(xi, length)[1:])
        SS = dS.T @ dS
        Gamma = dS.T @ TURN.T @ ddS + ddS.T @ TURN @ dS
        f = np.linalg.norm(dS @ q)
        kappa = q @ Gamma @ q / 2 / f**3
        strain = (q @ SS @ q - 1) / 2
        bend = Gamma / f**3 - 3 * kappa / f**2 * SS
        Q_f -= dx * (EA * strain * SS @ q + EI * kappa * bend @ q)
        K += dx * (EA * np.outer(SS @ q, SS @ q) + EA * strain * SS)
        K += dx * EI * (np.outer(bend @ q, bend @ q) + kappa * bend)
        K += dx * EI * kappa * -6 / f**5 * np.outer(Gamma @ q, SS @ q)
        K += dx * EI * kappa * 15 * kappa / f**4 * np.outer(SS @ q, SS @ q)
    return Q_f, K


@pytest.mark.parametrize("beta", [0.0, 0.33, 0.6, 1.0])
def test_hub_load_of_the_paper(beta):
    """The load of the hub radius is delta S_x of eqs. 25 and 34, integrated point by point."""
    alpha, delta = 1.7, -0.8
    x, weights = gauss(3)
    lengths = np.diff(NODES)
    S_x = np.einsum("p,npi->ni", weights, hermite(x, lengths[:, None])[0]) * lengths[:, None]
    element = min(np.searchsorted(NODES, beta, side="right") - 1, 3)
    S_x[element] += alpha * hermite((beta - NODES[element]) / lengths[element], lengths[element])[0]
    model = planar(alpha=alpha, beta=beta, delta=delta)
    load = model.centrifugal_force(np.zeros((4, 8)), 1.0)
    assert load[:, ::2] == pytest.approx(delta * S_x, abs=1e-14)
    assert not load[:, 1::2].any()


def test_mass_matrix_of_the_paper():
    """The consistent mass is the integral of eq. 8: the textbook matrix of a cubic element."""
    l = 0.3
    textbook = [
        [156, 22 * l, 54, -13 * l],
        [22 * l, 4 * l**2, 13 * l, -3 * l**2],
        [54, 13 * l, 156, -22 * l],
        [-13 * l, -3 * l**2, -22 * l, 4 * l**2],
    ]
    (m,) = elements.mass(np.array([0.4, 0.7]), 0.0, 0.5)
    assert m == pytest.approx(l / 420 * np.array(textbook), rel=1e-13)
