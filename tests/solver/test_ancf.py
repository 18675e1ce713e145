"""The planar ANCF element at bent states: derivatives, symmetry, rigid motions, the paper."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamviz.solver.constitutive import CURVATURES, STRAIN_LAWS
from beamviz.solver.fem import ancf, assembly
from beamviz.solver.fem.hermite import coordinates, gauss, hermite

NODES = np.array([0, 0.12, 0.35, 0.6, 1])
ELEMENTS = ancf.Elements.between(NODES)
STEP = 1e-30
every_model = pytest.mark.parametrize(
    ("law", "curvature"), list(itertools.product(STRAIN_LAWS, CURVATURES))
)


def material(law="green", curvature="spatial", mu=70.0):
    return ancf.Material(mu, STRAIN_LAWS[law], CURVATURES[curvature])


def straight(stretch=1.0):
    q = np.zeros((len(NODES), 4))
    q[:, 0], q[:, 2] = stretch * NODES, stretch
    return q.ravel()


def bent(seed):
    """A random state far from straight: tens of degrees, tens of percent of stretch."""
    noise = np.random.default_rng(seed).standard_normal((len(NODES), 4))
    return straight() + (noise * [0.05, 0.05, 0.25, 0.4]).ravel()


def energy(q, model):
    return ancf.energy(ELEMENTS, model, coordinates(q))


def force(q, model):
    return assembly.vector(ancf.force(ELEMENTS, model, coordinates(q)))


def tangent(q, model):
    """The assembled tangent (20, 20), from element matrices that need not be symmetric."""
    K = np.zeros((20, 20))
    for e, K_e in enumerate(ancf.tangent(ELEMENTS, model, coordinates(q))):
        K[4 * e : 4 * e + 8, 4 * e : 4 * e + 8] += K_e
    return K


def complex_step(function, q):
    """The derivative of an analytic function of q, exact to rounding: (20, ...)."""
    return np.array([function(q + 1j * STEP * unit).imag / STEP for unit in np.eye(len(q))])


@every_model
@pytest.mark.parametrize("seed", range(5))
def test_force_and_tangent_are_derivatives(law, curvature, seed):
    """At random bent states the force is dU/dq and the tangent d^2 U/dq^2, to rounding."""
    model, q = material(law, curvature), bent(seed)
    F = complex_step(lambda q: energy(q, model), q)
    K = complex_step(lambda q: force(q, model), q)
    assert force(q, model) == pytest.approx(F, abs=1e-13 * np.abs(F).max())
    assert tangent(q, model) == pytest.approx(K, abs=1e-13 * np.abs(K).max())


@every_model
@pytest.mark.parametrize("seed", range(5))
def test_bending_part_alone(law, curvature, seed):
    """With hardly any axial stiffness the same holds: nothing of the curvature hides behind mu."""
    model, q = material(law, curvature, mu=1e-3), bent(seed)
    K = complex_step(lambda q: force(q, model), q)
    assert tangent(q, model) == pytest.approx(K, abs=1e-12 * np.abs(K).max())


@every_model
@pytest.mark.parametrize("seed", range(3))
def test_tangent_is_symmetric(law, curvature, seed):
    """The tangent of a potential is symmetric, at bent states too."""
    K = tangent(bent(seed), material(law, curvature))
    assert np.abs(K - K.T).max() < 1e-14 * np.abs(K).max()


@every_model
@given(angle=st.floats(-3.1, 3.1), x=st.floats(-2, 2), y=st.floats(-2, 2))
def test_rigid_motion_of_the_beam_costs_nothing(law, curvature, angle, x, y):
    """A beam turned and moved as a whole stores no energy and feels no force."""
    model, q = material(law, curvature), moved(straight(), angle, x, y)
    assert abs(energy(q, model)) < 1e-20 * model.mu**2
    assert np.abs(force(q, model)).max() < 1e-11 * model.mu**2


@every_model
@given(angle=st.floats(-3.1, 3.1), seed=st.integers(0, 50))
def test_rigid_motion_of_a_bent_state(law, curvature, angle, seed):
    """Energy does not see a rigid motion of a bent state, and the force turns with it."""
    model, q = material(law, curvature), bent(seed)
    turned = moved(q, angle, 0.3, -0.2)
    assert energy(turned, model) == pytest.approx(energy(q, model), rel=1e-11)
    F = force(q, model)
    assert force(turned, model) == pytest.approx(moved(F, angle), abs=1e-10 * np.abs(F).max())


def moved(q, angle, x=0.0, y=0.0):
    """Planar coordinates after a rotation and a translation."""
    c, s = np.cos(angle), np.sin(angle)
    q = q.reshape(-1, 2) @ np.array([[c, s], [-s, c]])
    q[::2] += (x, y)
    return q.ravel()


@every_model
def test_three_rigid_modes_at_rest(law, curvature):
    """The tangent of the beam at rest has exactly two translations and a rotation for free."""
    model = material(law, curvature)
    K = tangent(straight(), model)
    rotation = moved(straight(), np.pi / 2)
    for rigid in (np.tile([1, 0, 0, 0], 5), np.tile([0, 1, 0, 0], 5), rotation):
        assert np.abs(K @ rigid).max() < 1e-10 * np.abs(K).max()
    values = np.linalg.eigvalsh(K)
    assert np.count_nonzero(np.abs(values) < 1e-9 * values[-1]) == 3
    assert values[3] > 1


def test_pure_bending():
    """An arc of angle phi stores phi^2 / 2: EI = L = 1, whatever the law and the measure."""
    phi, nodes = 0.8, np.linspace(0, 1, 41)
    x = phi * nodes
    q = np.column_stack((np.sin(x) / phi, (1 - np.cos(x)) / phi, np.cos(x), np.sin(x)))
    for law, curvature in itertools.product(STRAIN_LAWS, CURVATURES):
        elements = ancf.Elements.between(nodes)
        stored = ancf.energy(elements, material(law, curvature), coordinates(q.ravel()))
        assert stored == pytest.approx(phi**2 / 2, rel=1e-6)


@every_model
def test_uniform_stretch(law, curvature):
    """A stretched bar stores mu^2 e^2 / 2 and pulls with mu^2 n at its ends."""
    f, model = 1.3, material(law, curvature)
    row = STRAIN_LAWS[law]
    F = force(straight(f), model)
    assert energy(straight(f), model) == pytest.approx(model.mu**2 * row.strain(f) ** 2 / 2)
    assert [F[0], F[-4]] == pytest.approx(
        model.mu**2 * row.force(np.float64(f)) * np.array([-1, 1])
    )


def test_quadrature_follows_from_the_degree():
    """5 points integrate the green axial energy exactly at bent states: 9 change nothing, 4 do."""
    model, q = material(mu=1e6), bent(1)  # mu so large that the curvature is lost in rounding
    stored = [axial_energy(q, model, points) for points in (4, 5, 9)]
    assert ELEMENTS.weights.shape == (4, 5)
    assert stored[1] == pytest.approx(stored[2], rel=1e-13)
    assert abs(stored[0] / stored[2] - 1) > 1e-6
    assert energy(q, model) == pytest.approx(stored[2], rel=1e-8)


def axial_energy(q, model, points):
    """int mu^2 (f^2 - 1)^2 / 8 by a rule of its own."""
    x, weights = gauss(2 * points - 1)
    lengths = np.diff(NODES)[:, None]
    slopes = hermite(x, lengths)[1] @ coordinates(q).reshape(-1, 4, 2)
    f2 = np.sum(slopes**2, axis=-1)
    return model.mu**2 * np.sum(weights * lengths * (f2 - 1) ** 2) / 8


@pytest.mark.parametrize("seed", range(5))
def test_force_of_the_paper(seed):
    """The force of a green beam with spatial curvature is the paper's eq. 17, term by term."""
    model, q_e = material(), coordinates(bent(seed))
    expected = -np.array([paper_element(e, q, model.mu)[0] for e, q in enumerate(q_e)])
    assert ancf.force(ELEMENTS, model, q_e) == pytest.approx(
        expected, abs=1e-12 * np.abs(expected).max()
    )


@pytest.mark.parametrize("seed", range(5))
def test_tangent_of_the_paper(seed):
    """The tangent is the paper's eq. 44, term by term, with its one unsymmetric term, -6 Gamma
    q q' S'S', made symmetric: as printed it is not the derivative of eq. 17."""
    model, q_e = material(mu=5.0), coordinates(bent(seed))
    printed = np.array([paper_element(e, q, model.mu)[1] for e, q in enumerate(q_e)])
    K_e, scale = ancf.tangent(ELEMENTS, model, q_e), np.abs(printed).max()
    assert K_e == pytest.approx((printed + printed.swapaxes(1, 2)) / 2, abs=1e-12 * scale)
    assert np.abs(K_e - printed).max() > 1e-4 * scale


def paper_element(e, q, mu):
    """Q_fe (eq. 17) and K_e (eq. 44) of one element with the paper's own symbols, as printed."""
    length, EA, EI = np.diff(NODES)[e], mu**2, 1.0
    turn = np.array([[0, -1], [1, 0]])  # I~
    Q_f, K = np.zeros(8), np.zeros((8, 8))
    for xi, weight in zip(*gauss(9), strict=True):
        dx = weight * length
        dS, ddS = (np.kron(s, np.eye(2)) for s in hermite(xi, length)[1:])
        SS = dS.T @ dS
        Gamma = dS.T @ turn.T @ ddS + ddS.T @ turn @ dS
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


@every_model
def test_straight_tangent_splits(law, curvature):
    """At an unevenly stretched straight state the tangent is int mu^2 n' du'^2 along the beam and
    int dk^2 + mu^2 (n/f) w'^2 across it, with no coupling."""
    model, row, c = material(law, curvature), STRAIN_LAWS[law], CURVATURES[curvature].power
    q = straight()
    q[::4] += [0, 0.02, 0.05, 0.12, 0.3]
    q[2::4] += [0.1, 0.2, 0.15, 0.3, 0.4]
    K = tangent(q, model)
    x, weights = gauss(9)
    lengths = np.diff(NODES)[:, None]
    _, dS, ddS = hermite(x, lengths)
    u_e = coordinates(q)[:, ::2, None]
    f, df = (dS @ u_e), (ddS @ u_e)
    dk = (f * ddS - df * dS) / f**c
    dx = (weights * lengths)[..., None]
    along = np.einsum("epi,epj->eij", dx * model.mu**2 * row.stiffness(f) * dS, dS)
    tension = np.einsum("epi,epj->eij", dx * model.mu**2 * row.force(f) / f * dS, dS)
    across = np.einsum("epi,epj->eij", dx * dk, dk) + tension
    scale = np.abs(K).max()
    assert K[::2, ::2] == pytest.approx(assembly.dense(assembly.band(along)), abs=1e-13 * scale)
    assert K[1::2, 1::2] == pytest.approx(assembly.dense(assembly.band(across)), abs=1e-13 * scale)
    assert not K[::2, 1::2].any()


def test_prestress_may_be_given():
    """The tangent takes the prestress of a given strain; its own strain gives its own tangent."""
    model, q_e = material("hencky"), coordinates(bent(2))
    f = ancf.stretch(ancf.strain_state(ELEMENTS, q_e))
    K = ancf.tangent(ELEMENTS, model, q_e)
    assert np.array_equal(ancf.tangent(ELEMENTS, model, q_e, np.log(f)), K)
    assert not np.allclose(ancf.tangent(ELEMENTS, model, q_e, np.log(f) + 0.1), K)
