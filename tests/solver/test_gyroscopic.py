"""M q" + 2 gamma G q' + K q = 0 as two structured problems: held against the doubled system."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamviz.errors import NotConverged
from beamviz.solver.eigen import gyroscopic_modes

COUNT = 4


def families(seed: int, sizes: tuple[int, int], softest: tuple[float, float]):
    """Ka, Fa, Kb, Fb of two families whose lowest eigenvalues are `softest`."""
    rng = np.random.default_rng(seed)
    parts = []
    for n, least in zip(sizes, softest, strict=True):
        turn = np.linalg.qr(rng.normal(size=(n, n)))[0]
        stiffness = least + np.append(0.0, rng.uniform(0.1, 50, n - 1))
        F = np.linalg.qr(rng.normal(size=(sum(sizes) + 3, n)))[0]
        parts += [(turn * stiffness) @ turn.T, F @ turn.T]
    return parts


def doubled(Ka, Fa, Kb, Fb, gamma):
    """M, G and K, and all exponents s of the first-order system of twice the size."""
    na, n = len(Ka), len(Ka) + len(Kb)
    M, G, K = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    M[:na, :na], M[na:, na:] = Fa.T @ Fa, Fb.T @ Fb
    K[:na, :na], K[na:, na:] = Ka, Kb
    G[na:, :na] = Fb.T @ Fa
    G -= G.T
    zero, one = np.zeros((n, n)), np.eye(n)
    first = np.block([[zero, one], [-np.linalg.solve(M, K), -2 * gamma * np.linalg.solve(M, G)]])
    return M, G, K, np.linalg.eigvals(first)


@settings(deadline=None)
@given(
    seed=st.integers(0, 10**6),
    sizes=st.tuples(st.integers(4, 9), st.integers(4, 9)),
    softest=st.sampled_from([(1.0, 1.0), (1.0, -5.0), (2.0, -40.0), (-3.0, 4.0), (0.5, -1e-3)]),
    gamma=st.floats(0.1, 20),
)
def test_modes_solve_the_equation_of_motion(seed, sizes, softest, gamma):
    """Stable or buckled: each mode satisfies (K + 2 s gamma G + s^2 M) q = 0, and its omega^2 is
    among those of the doubled system, whose lowest it has."""
    parts = families(seed, sizes, softest)
    M, G, K, exponents = doubled(*parts, gamma)
    found = gyroscopic_modes(*parts, gamma, COUNT)
    s = np.sqrt(-found.omega_squared + 0j)
    q = np.concatenate((found.a, found.b))
    residual = K @ q + 2 * gamma * (G @ q) * s + (M @ q) * s**2
    size = np.abs(K).max() + 2 * gamma * abs(s) + abs(s) ** 2
    assert np.all(np.abs(residual).max(axis=0) < 1e-6 * size)
    assert np.abs((q.conj() * (M @ q)).sum(axis=0) - 1).max() < 1e-9
    lowest = np.sort((-(exponents**2)).real)[: 2 * COUNT : 2]
    assert found.omega_squared == pytest.approx(lowest, rel=1e-6, abs=1e-6)


def test_two_unstable_families_are_refused():
    """Such a model has no stretched equilibrium: said, not guessed."""
    with pytest.raises(NotConverged, match="both families are unstable"):
        gyroscopic_modes(*families(1, (5, 5), (-2.0, -2.0)), 3.0, COUNT)
