"""Inertia: rigid motions weigh what they must, the mass sits where beta says."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamviz.solver.fem import assembly, inertia
from beamviz.solver.fem.hermite import coordinates, gauss, hermite, uniform

alphas = st.floats(0, 100)
betas = st.floats(0, 1) | st.sampled_from([0, 0.1, 0.5, 0.7, 1])
node_lists = st.lists(st.floats(0.02, 0.98), max_size=6, unique_by=lambda x: round(x, 2)).map(
    lambda inner: np.array([0.0, *sorted(inner), 1.0])
)
NODES = np.array([0, 0.2, 0.5, 0.6, 1])


def assembled(m, components):
    return assembly.dense(assembly.band(inertia.planar(m, components)))


def field(nodes, value, slope):
    """Planar coordinates of a field that moves along e1 only."""
    q = np.zeros((len(nodes), 4))
    q[:, 0], q[:, 2] = value, slope
    return q.ravel()


@given(nodes=node_lists, alpha=alphas, beta=betas)
def test_rigid_motions(nodes, alpha, beta):
    """Any rigid motion has the kinetic energy of the beam and of the mass at beta."""
    M = assembled(inertia.scalar_mass(nodes, alpha, beta), inertia.IDENTITY)
    shift, turn = field(nodes, 1, 0), field(nodes, nodes, 1)
    assert shift @ M @ shift == pytest.approx(1 + alpha, rel=1e-12)
    assert shift @ M @ turn == pytest.approx(1 / 2 + alpha * beta, rel=1e-12)
    assert turn @ M @ turn == pytest.approx(1 / 3 + alpha * beta**2, rel=1e-12)


def test_line_mass_of_the_paper():
    """The consistent mass is the integral of eq. 8: the textbook matrix of a cubic element."""
    length = 0.3
    textbook = np.array(
        [
            [156, 22 * length, 54, -13 * length],
            [22 * length, 4 * length**2, 13 * length, -3 * length**2],
            [54, 13 * length, 156, -22 * length],
            [-13 * length, -3 * length**2, -22 * length, 4 * length**2],
        ]
    )
    m = inertia.line_mass(np.array([0.4, 0.7]))
    assert m[0] == pytest.approx(length / 420 * textbook, rel=1e-13)


@pytest.mark.parametrize("beta", NODES[1:-1])
def test_mass_on_a_node(beta):
    """On a node the mass acts on that node's position only, and from both sides alike."""
    m = assembly.dense(assembly.band(inertia.point_mass(NODES, 3.0, beta)))
    node = 2 * NODES.tolist().index(beta)
    expected = np.zeros_like(m)
    expected[node, node] = 3.0
    assert m == pytest.approx(expected, abs=1e-14)
    left = assembly.band(inertia.point_mass(NODES, 3.0, beta - 1e-9))
    assert assembly.dense(left) == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize(("beta", "coordinate"), [(0.0, 0), (1.0, 8)])
def test_mass_at_the_ends(beta, coordinate):
    """At beta 0 the mass loads the clamped position, at beta 1 that of the tip."""
    m = assembly.dense(assembly.band(inertia.point_mass(NODES, 2.0, beta)))
    assert np.flatnonzero(m).tolist() == [coordinate * 10 + coordinate]
    assert m[coordinate, coordinate] == 2.0


def test_mass_inside_an_element():
    """Inside an element the mass is m S'S at its place (eq. 32), nothing elsewhere."""
    m = inertia.point_mass(NODES, 2.0, 0.275)
    S, _, _ = hermite(0.25, 0.3)
    assert m[1] == pytest.approx(2 * np.outer(S, S), rel=1e-12)
    assert not m[[0, 2, 3]].any()


@given(alpha=alphas, beta=betas)
def test_gyroscopic_matrix(alpha, beta):
    """G is skew, does no work, and turns a velocity by 90 degrees under the mass."""
    m = inertia.scalar_mass(NODES, alpha, beta)
    G = assembly.skew(inertia.planar(m, inertia.TURN))
    assert np.array_equal(G, -G.T)
    M = assembled(m, inertia.IDENTITY)
    q = np.random.default_rng(3).standard_normal(20)
    turned = (q.reshape(-1, 2) @ inertia.TURN.T).ravel()
    along, across = field(NODES, 1, 0), np.roll(field(NODES, 1, 0), 1)
    assert across @ G @ along == pytest.approx(1 + alpha)  # e3 x e1 = e2
    assert G @ q == pytest.approx(M @ turned, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("beta", [0.0, 0.33, 0.5, 1.0])
def test_hub_load_of_the_paper(beta):
    """The load of the hub radius is delta S_x of eqs. 25 and 34, integrated point by point."""
    alpha, delta = 1.7, -0.8
    x, weights = gauss(3)
    lengths = np.diff(NODES)
    S_x = np.einsum("p,npi->ni", weights, hermite(x, lengths[:, None])[0]) * lengths[:, None]
    element = min(np.searchsorted(NODES, beta, side="right") - 1, 3)
    S_x[element] += alpha * hermite((beta - NODES[element]) / lengths[element], lengths[element])[0]
    expected = np.zeros((4, 4, 2))
    expected[:, :, 0] = delta * S_x
    C = inertia.planar(inertia.scalar_mass(NODES, alpha, beta), inertia.IDENTITY)
    load = C @ inertia.lever_arm(np.zeros((4, 8)), delta)[..., None]
    assert load[..., 0] == pytest.approx(expected.reshape(4, 8), abs=1e-14)


def test_centrifugal_matrices():
    """Chordwise the centrifugal force grows with both components, flapwise along the beam only."""
    m = inertia.scalar_mass(NODES, 1.0, 0.4)
    M = assembled(m, inertia.IDENTITY)
    assert np.array_equal(assembled(m, inertia.PROJECTIONS["chordwise"]), M)
    C = assembled(m, inertia.PROJECTIONS["flapwise"])
    assert np.array_equal(C[::2, ::2], M[::2, ::2])
    assert not C[1::2].any()
    assert not C[:, 1::2].any()


def test_lever_arm_leaves_its_argument_alone():
    """The hub radius is added to both positions along the beam, in a copy."""
    q_e = coordinates(field(uniform(2), uniform(2), 1))
    before = q_e.copy()
    arm = inertia.lever_arm(q_e, 0.5)
    assert np.array_equal(q_e, before)
    assert (arm - q_e).tolist() == [[0.5, 0, 0, 0, 0.5, 0, 0, 0]] * 2
