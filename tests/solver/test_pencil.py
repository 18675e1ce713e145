"""Pencils of random matrices against the companion matrix of M q" + C q' + K q = 0."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.sparse import csc_array

from beamviz.errors import NotConverged
from beamviz.solver.pencil import lowest_modes
from beamviz.solver.pencil.matrices import Families, Family, Pencil
from beamviz.solver.stability import status_of

GAMMA = 0.7
NO_SOFTENING = np.zeros((1, 2, 1))


@dataclass
class Matrices:
    """Those of two families, along the beam (a) and across it (b)."""

    Ka: np.ndarray
    Kb: np.ndarray
    Fa: np.ndarray
    Fb: np.ndarray

    @property
    def mass(self):
        zero = np.zeros((len(self.Ka), len(self.Kb)))
        return np.block([[self.Fa.T @ self.Fa, zero], [zero.T, self.Fb.T @ self.Fb]])

    @property
    def coriolis(self):
        coupling = self.Fa.T @ self.Fb
        zero = np.zeros_like(self.Ka), np.zeros_like(self.Kb)
        return 2 * GAMMA * np.block([[zero[0], -coupling], [coupling.T, zero[1]]])

    @property
    def stiffness(self):
        zero = np.zeros((len(self.Ka), len(self.Kb)))
        return np.block([[self.Ka, zero], [zero.T, self.Kb]])

    @property
    def factor(self):
        """Of the whole: F' F = M."""
        return np.linalg.cholesky(self.mass).T

    def families(self, coupled, **options):
        across = Family(self.Kb[None], (self.Fb.T @ self.Fb)[None], self.Fb[None])
        along = Family(self.Ka[None], (self.Fa.T @ self.Fa)[None], self.Fa[None])
        gamma = np.full((1, 1, 1), GAMMA) if coupled else None
        return Families(across, along, **{"softening": NO_SOFTENING, "gamma": gamma, **options})


def random_matrices(na, nb, least=0.1):
    """least: the least eigenvalue of Kb, the others are up to 10."""
    random = np.random.default_rng(na)

    def stiffness(n, least):
        Q = np.linalg.qr(random.normal(size=(n, n)))[0]
        return (Q * np.append(least, np.geomspace(0.5, 10, n)[1:])) @ Q.T

    F = (random.normal(size=(na + nb, n)) for n in (na, nb))
    return Matrices(stiffness(na, 0.3), stiffness(nb, least), *F)


def exact(M, C, K):
    """s of all modes with Im s > 0, or Im s = 0 and Re s > 0, by descending imaginary part."""
    n = len(M)
    companion = np.linalg.solve(M, np.hstack((-K, -C)))
    s = np.linalg.eigvals(np.vstack((np.eye(2 * n)[n:], companion)))
    s = np.where(abs(s.real) < 1e-9, 0.0, s.real) + 1j * np.where(abs(s.imag) < 1e-9, 0.0, s.imag)
    s = s[(s.imag > 0) | ((s.imag == 0) & (s.real > 0))]
    return s[np.lexsort((-s.real, s.imag))]


def residual(M, C, K, s, V):
    """The largest of T(s) v, relative to the stiffness."""
    return abs(M @ V * s**2 + C @ V * s + K @ V).max() / abs(K).max()


@pytest.mark.parametrize("tolerance", [1e-7, 1e-15])  # by Z Z', and by the singular values of Z
@pytest.mark.parametrize(("na", "nb"), [(3, 5), (6, 4), (1, 1), (20, 25)])
def test_definite_coupled_families(na, nb, tolerance):
    """Frequencies, shapes of unit modal mass, and their energies."""
    whole = random_matrices(na, nb)
    modes = lowest_modes(whole.families(coupled=True, tolerance=tolerance), na + nb)
    M, C, K = whole.mass, whole.coriolis, whole.stiffness
    s = exact(M, C, K)
    assert modes.definite
    assert modes.s[0] == pytest.approx(s, rel=1e-8)
    b, a = modes.V
    q = np.concatenate((a[0], b[0]))
    assert residual(M, C, K, s, q) < 1e-7
    masses = [(abs(F @ v) ** 2).sum(axis=0) for F, v in ((whole.Fa, q[:na]), (whole.Fb, q[na:]))]
    assert sum(masses) == pytest.approx(1)
    assert modes.fraction[0] == pytest.approx(masses[1], abs=1e-9)
    pairing = abs((q.conj() * (2 * (M @ q) * s + C @ q)).sum(axis=0))
    assert modes.pairing[0] == pytest.approx(pairing, rel=1e-7)


@pytest.mark.parametrize(("na", "nb"), [(3, 5), (6, 4), (12, 15)])
@pytest.mark.parametrize("swapped", [False, True])
def test_indefinite_coupled_families(na, nb, swapped):
    """One mode of either family grows; with both indefinite there is no answer."""
    whole = random_matrices(na, nb, least=-0.2)
    if swapped:
        whole = Matrices(whole.Kb, whole.Ka, whole.Fb, whole.Fa)
    modes = lowest_modes(whole.families(coupled=True), na + nb)
    s = exact(whole.mass, whole.coriolis, whole.stiffness)
    assert not modes.definite
    assert modes.s[0] == pytest.approx(s, rel=1e-8)
    assert modes.s[0, 0].real > 0
    b, a = modes.V
    assert (
        residual(whole.mass, whole.coriolis, whole.stiffness, s, np.concatenate((a[0], b[0])))
        < 1e-7
    )
    both = Matrices(whole.Ka - 20 * np.eye(len(whole.Ka)), whole.Kb, whole.Fa, whole.Fb)
    both = Matrices(both.Ka, both.Kb - 20 * np.eye(len(both.Kb)), both.Fa, both.Fb)
    with pytest.raises(NotConverged):
        lowest_modes(both.families(coupled=True), 2)


@pytest.mark.parametrize("definiteness", ["definite", "semidefinite", "indefinite"])
@pytest.mark.parametrize("coupled", [False, True])
def test_softening_is_a_multiple_of_the_mass(coupled, definiteness):
    """Given as a number or in the stiffness, it gives the same modes."""
    whole, softening = random_matrices(5, 4), 0.01
    by = np.full((1, 2, 1), softening)
    modes = lowest_modes(whole.families(coupled, softening=by, definiteness=definiteness), count=4)
    M, C, K = whole.mass, whole.coriolis, whole.stiffness
    s = exact(M, C if coupled else 0 * C, K - softening * M)
    assert np.sort(modes.s.imag.ravel())[:4] == pytest.approx(s.imag[:4], rel=1e-8)


def test_uncoupled_families_of_unlike_numbers_of_modes():
    """Each has those of its own problem; a family with fewer modes has nan beyond them."""
    whole = random_matrices(3, 6)
    modes = lowest_modes(whole.families(coupled=False), 5)
    bending, stretching = modes.omega_squared[0]
    of_b = np.linalg.eigvals(np.linalg.solve(whole.Fb.T @ whole.Fb, whole.Kb)).real
    of_a = np.linalg.eigvals(np.linalg.solve(whole.Fa.T @ whole.Fa, whole.Ka)).real
    assert bending == pytest.approx(np.sort(of_b)[:5])
    assert stretching[:3] == pytest.approx(np.sort(of_a))
    assert np.isnan(stretching[3:]).all()


@pytest.mark.parametrize("coupled", [False, True])
def test_a_rigid_motion_has_frequency_zero(coupled):
    """The stiffness across the beam is singular."""
    whole = random_matrices(4, 5, least=0.0)
    options = {"definiteness": "indefinite", "rigid": np.array([True])}
    modes = lowest_modes(whole.families(coupled, **options), 3)
    assert (modes.omega_squared[modes.rigid] == 0).all()
    assert modes.rigid.sum() == 1
    s = exact(whole.mass, whole.coriolis if coupled else 0 * whole.coriolis, whole.stiffness)
    others = np.sort(modes.s.imag[~modes.rigid])[:2]
    assert others == pytest.approx(s.imag[s.imag > 1e-6][:2], rel=1e-6)


@pytest.mark.parametrize("size", [4, 40])  # all modes, and some by Arnoldi's method
@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize("least", [0.1, -0.3])
def test_one_symmetric_pencil(size, coriolis, least):
    """A stable one, and one with divergence, which is seen."""
    whole = random_matrices(size, size + 2, least)
    M, C, K = whole.mass, whole.coriolis if coriolis else 0 * whole.coriolis, whole.stiffness
    modes = lowest_modes(Pencil(K, M, C if coriolis else None, whole.factor), 5)
    all_s = exact(M, C, K)
    by_size = all_s[abs(all_s).argsort()[:5]]
    s = by_size[np.lexsort((-by_size.real, by_size.imag))]
    assert modes.definite == (least > 0)
    assert status_of(modes.s) == ("stable" if least > 0 else "unstable")
    assert modes.s == pytest.approx(s, rel=1e-7)
    assert residual(M, C, K, s, modes.V) < 1e-6
    assert (modes.rounding_of_s < 1e-6).all()
    assert (modes.V.conj() * (M @ modes.V)).sum(axis=0).real == pytest.approx(1)


@pytest.mark.parametrize("size", [4, 40])
@pytest.mark.parametrize("sparse", [False, True])
@pytest.mark.parametrize("coriolis", [False, True])
def test_an_unsymmetric_pencil(size, sparse, coriolis):
    """Of a skew part of the stiffness modes grow and decay, in pairs."""
    whole = random_matrices(size, size + 2)
    skew = np.triu(np.full(whole.stiffness.shape, 0.3), 1)
    M, C, K = (
        whole.mass,
        whole.coriolis if coriolis else 0 * whole.coriolis,
        whole.stiffness + skew - skew.T,
    )
    made = csc_array if sparse else np.array
    pencil = Pencil(made(K), made(M), made(C) if coriolis else None, symmetric=False)
    modes = lowest_modes(pencil, 6)
    s, all_s = modes.s, exact(M, C, K)
    assert (abs(s.real) > 1e-3).any()
    nearest = abs(all_s[:, None] - s).min(axis=0)
    if not coriolis:  # -s of a mode is one too: the branch with Im s > 0
        nearest = np.minimum(nearest, abs(-all_s.conj()[:, None] - s).min(axis=0))
    assert (nearest < 1e-7 * abs(s)).all()
    assert residual(M, C, K, s, modes.V) < 1e-6
    lowest = np.sort(abs(all_s))
    assert np.sort(abs(s)) == pytest.approx(lowest[:6], rel=1e-7)


def test_low_modes_keep_their_digits():
    """The eigenvalues span a factor of 1e16."""
    size = 17
    squares = 10.0 ** np.arange(size)
    B = np.tril(np.full((size, size), 0.1)) + np.eye(size)
    K, M = B.T @ B, (B.T / squares) @ B
    modes = lowest_modes(Pencil(K, M), 3)
    assert modes.omega_squared == pytest.approx(squares[:3], rel=1e-12)
