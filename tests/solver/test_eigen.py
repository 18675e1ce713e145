"""Gyroscopic eigenproblems of random matrices against the companion matrix of M q" + 2 gamma G q' +
K q = 0."""

import numpy as np
import pytest

from beamviz.solver import eigen


def random_problem(na, nb, seed):
    """K (definite), F of both families and gamma, as a stack of one."""
    random = np.random.default_rng(seed)
    factors = (random.normal(size=(1, n, n)) + 2 * np.eye(n) for n in (na, nb))
    K = tuple(A @ A.mT for A in factors)
    F = tuple(random.normal(size=(1, na + nb, n)) for n in (na, nb))
    return K, F, np.full((1, 1, 1), 0.7)


def matrices(K, F, gamma):
    """M, 2 gamma G and K of the whole problem."""
    (Ka, Kb), (Fa, Fb) = ([one[0] for one in pair] for pair in (K, F))
    zero = np.zeros((len(Ka), len(Kb)))
    C = Fa.T @ Fb
    G = np.block([[np.zeros_like(Ka), -C], [C.T, np.zeros_like(Kb)]])
    M = np.block([[Fa.T @ Fa, zero], [zero.T, Fb.T @ Fb]])
    return M, 2 * gamma.item() * G, np.block([[Ka, zero], [zero.T, Kb]])


@pytest.mark.parametrize("max_rounding", [1e6, 1.0])  # by Z Z', and by the singular values of Z
@pytest.mark.parametrize(("na", "nb"), [(3, 5), (6, 4), (1, 1), (20, 25)])
def test_definite_gyroscopic_modes(na, nb, max_rounding):
    """Frequencies, shapes of unit modal mass, and their energies."""
    K, F, gamma = random_problem(na, nb, na)
    found = eigen.gyroscopic_modes(K, F, gamma, na + nb, max_rounding)
    M, G, stiffness = matrices(K, F, gamma)
    companion = np.linalg.solve(M, np.hstack((-stiffness, -G)))
    n = na + nb
    eigenvalues = np.linalg.eigvals(np.vstack((np.eye(2 * n)[n:], companion)))
    squares = np.sort(eigenvalues[eigenvalues.imag > 0].imag) ** 2
    assert found.omega_squared[0] == pytest.approx(squares, rel=1e-8)
    q = np.concatenate((found.a[0], found.b[0]))
    s = 1j * np.sqrt(squares)
    residual = M @ q * s**2 + G @ q * s + stiffness @ q
    assert abs(residual).max() < 1e-7 * squares.max() * abs(M @ q).max()
    parts = [(q[:na], slice(0, na)), (q[na:], slice(na, n))]
    masses = [(v.conj() * (M[own, own] @ v)).sum(axis=0).real for v, own in parts]
    assert sum(masses) == pytest.approx(1)
    assert found.fraction[0] == pytest.approx(masses[1], abs=1e-9)
    stored = (q.conj() * (stiffness @ q)).sum(axis=0).real
    assert found.stored[0] == pytest.approx(stored, rel=1e-7, abs=1e-9)
