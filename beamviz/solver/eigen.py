"""Symmetric and gyroscopic eigenproblems, solved so that the low modes are accurate.

With thin elements or high order the eigenvalues of K v = lambda M v span a factor of 1e17, and the
usual reduction by M loses the low ones. Here M v = nu K v is solved and lambda = 1/nu: the low
modes are the largest nu, and the rounding errors are in the high modes, which are not returned.

Coriolis forces make the problem M q" + 2 gamma G q' + K q = 0. Its unknowns q are those along the
beam (a) and those across it (b), with K = diag(Ka, Kb), softening included, M = diag(Fa' Fa,
Fb' Fb) and G = [[0, -Fa' Fb], [Fb' Fa, 0]]. The rows of Fa and Fb are displacements at common
points times the root of the mass there.
"""

from functools import lru_cache
from itertools import chain
from typing import NamedTuple

import numpy as np
from scipy.linalg import blas, lapack

from beamviz.errors import NotConverged

EPS = float(np.finfo(float).eps)  # 2.2e-16
# Shift of beams that may buckle, and the least scale of the errors of omega^2, which compression
# may bring near zero: omega^2 of bending at rest is 12.
COMPRESSED = 16.0
SHIFTS = tuple(COMPRESSED * 4.0**k for k in range(28))
NEARLY_SINGULAR = 4.0  # ratio of shift to least shifted eigenvalue above which both lose digits
FEW = 30  # number of unknowns from which a few eigenvectors are computed faster than all
BLOCK = 8  # columns that LAPACK reduces at once: faster than its choice of 32 up to 250 unknowns
FAR_APART = 1e10  # ratio of eigenvalues from which the eigenvectors of Z Z' are too inaccurate
HIGHEST = 1e10  # ratio to the lowest eigenvalue above which modes are rounding error
MAX_INDEFINITE = 400  # most unknowns of an unstable gyroscopic problem: 0.05 s
INDEFINITE_ROUNDING = 2e4  # of omega^2 in such a problem, in units of EPS, on random beams


def symmetric_modes(
    K: np.ndarray, M: np.ndarray, count: int, shift: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """The `count` lowest eigenvalues lambda of K v = lambda M v, ascending, and their vectors
    (n, count), V' M V = 1.

    M is positive semidefinite. shift: the eigenvalues of K + shift M are computed, with a larger
    shift where that is not positive definite. Give one for an indefinite K (a compressed beam): an
    eigenvalue near -shift makes the others inaccurate. Raises NotConverged.
    """
    nu, rows, added = inverse_modes_with_shift(M, K, count, shift)
    return 1 / nu - added, rows.T / np.sqrt(abs(nu))  # from V' (K + added M) V = 1


def family_modes(
    K: np.ndarray, M: np.ndarray, A: np.ndarray, count: int, shift: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """`symmetric_modes` of two families of a stack: K v = lambda M v, all (beams, n, n), and the
    smaller problem c = lambda A c, A (beams, r, r), which needs no shift.

    Returns the vectors v (beams, n, count) and c (beams, r, count); lambda + shift (beams, 2,
    count), which has the rounding error; and the shift (beams, 2, 1). Lambda and the vectors are
    nan beyond the r modes of the second family, and where 1 / (lambda + shift) is only rounding
    error: of either sign, it would pass for an instability.
    """
    stack, n, r = len(K), K.shape[-1], A.shape[-1]
    count = min(count, n)
    few = min(count, r)
    nu, added = np.empty((stack, 2, count)), np.zeros((stack, 2, 1))
    V, C = np.empty((stack, count, n)), np.empty((stack, count, r))
    for k in range(stack):
        nu[k, 0], V[k], added[k, 0] = inverse_modes_with_shift(M[k], K[k], count, shift)
        nu[k, 1, :few], C[k, :few] = eigh_largest(A[k], few)
    if few < count:
        nu[:, 1, few:], C[:, few:] = np.nan, np.nan
    # An element beside a mass near the clamp is short, and has hardly any mass.
    nu[nu <= EPS * nu[..., :1]] = np.nan
    size = 1 / nu
    root = np.sqrt(abs(size))[..., None]
    V *= root[:, 0]
    C *= root[:, 1]
    return V.mT, C.mT, size, added


def eigh_largest(A: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The `count` largest eigenvalues (count,), descending, of symmetric A (n, n), of which the
    upper triangle is read, and their vectors, each a row.

    Of a larger problem a few vectors are computed by inverse iteration on the tridiagonal matrix:
    scipy.linalg.eigh with subset_by_index takes twice as long, which is a tenth to a fifth of a
    solve with Coriolis forces or of a fast beam. Below that size its checks alone are 7 % of one.
    """
    # The transpose is in column order as LAPACK requires: no copy.
    n, count = len(A), min(count, len(A))
    if n >= max(FEW, 2 * count):
        reflectors, d, e, tau, _ = lapack.dsytrd(A.T, lower=1, lwork=BLOCK * n)
        nu, failed = lapack.dsterf(d, e)
        if not failed:
            V, failed = lapack.dstein(d, e, nu[n - count :], *_one_block(n))
        if not failed:
            V[1:] = lapack.dormqr("L", "N", reflectors[1:, :-1], tau, V[1:], BLOCK * n)[0]
            return nu[: -count - 1 : -1], V.T[count - 1 :: -1]
    nu, V, info = lapack.dsyevd(A.T, lower=1)
    if info:
        raise NotConverged(f"the eigenvalues did not converge (LAPACK: {info})")
    return nu[: -count - 1 : -1], V.T[: -count - 1 : -1]


@lru_cache
def _one_block(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Numbers and ends (n,) of the blocks of a tridiagonal matrix of one block."""
    return np.ones(n, np.int32), np.full(n, n, np.int32)


def generalized_eigh(
    M: np.ndarray, K: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray] | None:
    """The `count` largest nu, descending, of M v = nu K v, V K V' = 1, their v as rows; None for an
    indefinite K."""
    L, info = lapack.dpotrf(K.T, lower=1)
    if info:
        return None
    A, _ = lapack.dsygst(M.T, L, lower=1)
    nu, V = eigh_largest(A.T, count)
    return nu, blas.dtrsm(1, L, V.T, lower=1, trans_a=1).T


def inverse_modes_with_shift(
    M: np.ndarray, K: np.ndarray, count: int, shift: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """The `count` largest nu, descending, of M v = nu (K + added M) v, their v as rows, and the
    shift added: the one given, or one that makes it positive definite."""
    for added in chain((shift,), SHIFTS):
        modes = generalized_eigh(M, K + added * M if added else K, count)
        if modes is None:
            continue
        nu, vectors = modes
        if nu[0] * added > NEARLY_SINGULAR:
            modes = generalized_eigh(M, K + 2 * added * M, count)
            if modes is not None:
                return *modes, 2 * added
        return nu, vectors, added
    raise NotConverged(
        f"the stiffness is not positive definite, nor with {SHIFTS[-1]:.3g} times the mass added:"
        " the beam may be too near a limit of its equilibrium"
    )


class GyroscopicModes(NamedTuple):
    """Modes of a stack of coupled problems: q = Re (a, b) e^(i omega t), or e^(growth t) where
    omega^2 = -growth^2."""

    omega_squared: np.ndarray  # (beams, count) ascending
    a: np.ndarray  # (beams, na, count) complex, unit modal mass
    b: np.ndarray  # (beams, nb, count)
    fraction: np.ndarray  # (beams, count) share of b in the kinetic energy
    stored: np.ndarray  # (beams, count) a* Ka a + b* Kb b
    relative_rounding: np.ndarray  # (beams, count) rounding error of omega^2, in units of EPS
    definite: bool  # whether K is positive definite


Stacks = tuple[np.ndarray, np.ndarray]  # matrices of each beam, of family a and of family b


def gyroscopic_modes(
    K: Stacks,
    F: Stacks,
    gamma: np.ndarray,
    count: int,
    max_rounding: float = 1e6,
    singular: bool = False,
) -> GyroscopicModes:
    """The `count` lowest modes of a stack of problems, gamma (beams, 1, 1).

    Frequencies are real by construction where K is positive definite; LinAlgError is raised where
    it is not for one of several. max_rounding: rounding error of omega^2, in units of EPS, above
    which a more accurate algorithm is used. singular: whether K of a single problem is known to be
    singular. Raises NotConverged.
    """
    if singular:
        return _indefinite_gyroscopic(K, F, gamma.item(), count)
    try:
        L = np.linalg.cholesky(K[0]), np.linalg.cholesky(K[1])
    except np.linalg.LinAlgError:
        if len(gamma) > 1:
            raise
        return _indefinite_gyroscopic(K, F, gamma.item(), count)
    return _definite_gyroscopic(L, F, gamma, count, max_rounding)


class InverseRoot(NamedTuple):
    """Z of `_definite_gyroscopic`, whose singular values are 1 / omega, of a stack of problems.

    A column of Z' X is (Lb' b, omega Fa a) / omega for a column (La' a, omega Fb b) of X.
    """

    Ya: np.ndarray  # (beams, na, m) La^-1 Fa'
    Yb: np.ndarray  # (beams, m, nb) Fb Lb^-T
    gamma: np.ndarray  # (beams, 1, 1)

    def squared(self) -> np.ndarray:
        """Z Z' (beams, na + m, na + m), of which only the upper triangle is set."""
        Ya, Yb, gamma = self
        na, P = Ya.shape[-2], Yb @ Yb.mT
        n = na + P.shape[-1]
        H = np.empty((len(P), n, n))
        coupling = -2 * gamma * (Ya @ P)
        H[:, :na, :na] = (Ya - 2 * gamma * coupling) @ Ya.mT
        H[:, :na, na:] = coupling
        H[:, na:, na:] = P
        return H

    def transposed_times(self, X: np.ndarray) -> np.ndarray:
        """Z' X (beams, nb + m, k) of X (beams, na + m, k)."""
        na = self.Ya.shape[-2]
        velocity = self.Ya.mT @ X[:, :na]
        across = self.Yb.mT @ (X[:, na:] - 2 * self.gamma * velocity)
        return np.concatenate((across, velocity), axis=1)


def _definite_gyroscopic(
    L: Stacks, F: Stacks, gamma: np.ndarray, count: int, max_rounding: float
) -> GyroscopicModes:
    """The modes for K = diag(La La', Lb Lb').

    With q = (a, i b) e^(i omega t) the problem is real; with the velocities omega Fb b and
    omega Fa a as further unknowns it is linear in 1/omega:

        [-2 gamma Fa' Fb  Fa'] [   b      ]             [Ka  ] [   a      ]
        [      Fb         0  ] [omega Fa a]  = 1/omega  [   1] [omega Fb b],

    so 1/omega are the singular values of the left matrix between the Cholesky factors, Z, and
    1/omega^2 the eigenvalues of Z Z', with Ya = La^-1 Fa', Yb = Fb Lb^-T and P = Yb Yb':

        [Ya (1 + 4 gamma^2 P) Ya'  -2 gamma Ya P] [ La' a    ]               [ La' a    ]
        [      -2 gamma P Ya'            P      ] [omega Fb b]  = 1/omega^2  [omega Fb b].

    These have half the digits where modes are far apart: then `_by_singular_values`.
    """
    (La, Lb), (Fa, Fb) = L, F
    na, nb = La.shape[-1], Lb.shape[-1]
    Ya = _divide_by_factor(La, Fa, transposed=True).mT
    Yb = _divide_by_factor(Lb, Fb, transposed=True)
    Z = InverseRoot(Ya, Yb, gamma)
    # One by one: numpy's stacked call computes all vectors, not a few.
    pairs = (eigh_largest(H, count) for H in Z.squared())
    nu, rows = map(np.array, zip(*pairs, strict=True))
    X = rows.mT  # columns (La' a, omega Fb b)
    with np.errstate(divide="ignore", over="ignore"):  # near zero, by rounding: infinite
        omega_squared = 1 / nu
    rounding = abs(omega_squared / omega_squared[:, :1])
    if rounding.max() > max_rounding:
        omega_squared, X, rounding = _by_singular_values(Z, X, rounding)
    Y = Z.transposed_times(X) * np.sqrt(omega_squared)[:, None]  # columns (Lb' b, omega Fa a)
    along, across = np.square(Y[:, nb:]).sum(axis=1), np.square(X[:, na:]).sum(axis=1)
    mass = (along + across) / omega_squared
    stored = np.square(X[:, :na]).sum(axis=1) + np.square(Y[:, :nb]).sum(axis=1)
    root = np.sqrt(mass)[:, None]
    a, b = (
        _divide_by_factor(l, (q / root).mT, transposed=False).mT
        for l, q in ((La, X[:, :na]), (Lb, Y[:, :nb]))
    )
    return GyroscopicModes(
        omega_squared=omega_squared,
        a=a.astype(complex),
        b=1j * b,
        fraction=across / (along + across),
        stored=stored / mass,
        relative_rounding=rounding,
        definite=True,
    )


def _by_singular_values(
    Z: InverseRoot, X: np.ndarray, rounding: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """omega^2 (beams, count), vectors (beams, na + m, count) and rounding errors (beams, count) in
    units of EPS, by singular values of Z', from vectors X of Z Z' and the rounding errors of their
    omega^2. Z' is restricted to X, or where that is too inaccurate is taken whole."""
    stack, n, count = X.shape
    restricted = rounding.max() < FAR_APART
    basis = X if restricted else np.broadcast_to(np.eye(n), (stack, n, n))
    _, singular, rotation = np.linalg.svd(Z.transposed_times(basis), full_matrices=False)
    omega_squared = 1 / singular[:, :count] ** 2
    ratio = omega_squared / omega_squared[:, :1]
    errors = np.sqrt(ratio)  # of the singular values
    if restricted:
        errors = errors + EPS * ratio**2  # of the vectors that they are restricted to
    return omega_squared, basis @ rotation[:, :count].mT, errors


def _divide_by_factor(L: np.ndarray, B: np.ndarray, transposed: bool) -> np.ndarray:
    """B L^-T if `transposed`, else B L^-1, of stacks of lower triangles L (beams, n, n) and
    matrices B (beams, m, n)."""
    # l.T and b.T are in column order, as BLAS requires: to BLAS l.T is an upper triangle.
    pairs = zip(L, B, strict=True)
    return np.array([blas.dtrsm(1, l.T, b.T, trans_a=transposed).T for l, b in pairs])


def _indefinite_gyroscopic(K: Stacks, F: Stacks, gamma: float, count: int) -> GyroscopicModes:
    """The modes of a single problem where either Ka or Kb is indefinite."""
    (Ka, Kb), (Fa, Fb) = K, F
    omega_squared, a, b = _indefinite(Ka[0], Fa[0], Kb[0], Fb[0], gamma, count)
    a, b = a[None], b[None]
    along, across = (abs(Fa @ a) ** 2).sum(axis=1), (abs(Fb @ b) ** 2).sum(axis=1)
    stored = sum((q.conj() * (k @ q)).real.sum(axis=1) for k, q in ((Ka, a), (Kb, b)))
    mass = along + across
    root = np.sqrt(mass)[:, None]
    return GyroscopicModes(
        omega_squared=omega_squared[None],
        a=a / root,
        b=b / root,
        fraction=across / mass,
        stored=stored / mass,
        relative_rounding=np.full((1, len(omega_squared)), INDEFINITE_ROUNDING),
        definite=False,
    )


def _indefinite(
    Ka: np.ndarray, Fa: np.ndarray, Kb: np.ndarray, Fb: np.ndarray, gamma: float, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The lowest modes (omega^2, a, b) of one problem where either Ka or Kb is indefinite.

    Let it be Kb. In the modal coordinates of the other family, Ka = diag(l), Fa' Fa = 1 and
    C = Fa' Fb; with y = sqrt(l) a and z = b' (q = (a, b) e^(s t)) the problem is symmetric:

        [         l             -2 gamma sqrt(l) C  ] [y]        [1         ] [y]
        [-2 gamma C' sqrt(l)   Kb + 4 gamma^2 C' C ] [z] = -s^2 [   Fb' Fb ] [z].

    Every s^2 is real: such a beam may buckle but does not flutter.
    """
    unknowns = len(Ka) + len(Kb)
    if unknowns > MAX_INDEFINITE:
        raise NotConverged(
            f"the straight beam is unstable; with Coriolis forces its {unknowns} unknowns are too"
            f" many (at most {MAX_INDEFINITE}): leave out Coriolis forces, lower gamma, or ask for"
            " fewer elements or modes"
        )
    l, A = symmetric_modes(Ka, Fa.T @ Fa, len(Ka), COMPRESSED)
    if l[0] <= 0:
        if np.linalg.eigvalsh(Kb)[0] <= 0:
            raise NotConverged(
                "both families are unstable; such a beam is not solved with Coriolis forces: leave"
                " them out, or lower gamma"
            )
        omega_squared, b, a = _indefinite(Kb, Fb, Ka, Fa, -gamma, count)
        return omega_squared, a, b
    kept = (l >= l[0]) & (l < HIGHEST * (1 + l[0]))
    l, A = l[kept], A[:, kept]
    na, n = len(l), len(l) + len(Kb)
    C = (Fa @ A).T @ Fb
    K, M = np.zeros((n, n)), np.eye(n)
    K[:na, :na] = np.diag(l)
    K[:na, na:] = -2 * gamma * np.sqrt(l)[:, None] * C
    K[na:, :na] = K[:na, na:].T
    K[na:, na:] = Kb + 4 * gamma**2 * C.T @ C
    M[na:, na:] = Fb.T @ Fb
    omega_squared, V = symmetric_modes(K, M, count, COMPRESSED)
    s = np.sqrt(-omega_squared + 0j)
    a = A @ (s * V[:na] / np.sqrt(l)[:, None])
    return omega_squared, a, V[na:].astype(complex)
