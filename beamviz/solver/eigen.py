"""Eigenproblems of vibration, symmetric and gyroscopic, solved so that the low modes keep their
digits.

K v = lambda M v with thin elements or high order has eigenvalues 1e17 apart, and the usual
reduction by M loses the low ones. Here M v = nu K v is solved and lambda = 1/nu: the low
modes are the largest nu, and rounding falls on the high modes, which are not returned.

With Coriolis forces M q" + 2 gamma G q' + K q = 0 has a structure. q holds a family along the beam
(a) and one across it (b): K = diag(Ka, Kb) with the softening in it, M = diag(Fa' Fa, Fb' Fb),
G = [[0, -Fa' Fb], [Fb' Fa, 0]]. The rows of Fa and Fb are displacements at common points times the
root of the mass there.
"""

from itertools import chain
from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from beamviz.errors import NotConverged

EPS = float(np.finfo(float).eps)
COMPRESSED = 16.0  # a shift for beams that may buckle: omega^2 of bending at rest is 12
SHIFTS = tuple(COMPRESSED * 4.0**k for k in range(28))
FEW = 30  # unknowns from which on a few eigenvectors come faster than all
BLOCK = 32  # columns that LAPACK treats together
FAR_APART = 1e10  # ratio of eigenvalues whose vectors Z' Z does not separate well enough
HIGHEST = 1e10  # times the lowest eigenvalue: modes above are rounding
MAX_INDEFINITE = 400  # unknowns of an unstable gyroscopic problem: a twentieth of a second
INDEFINITE_ROUNDING = 2e4  # roundings of omega^2 in such a problem, measured on random beams


def symmetric_modes(
    K: np.ndarray, M: np.ndarray, count: int, shift: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """The `count` lowest eigenvalues lambda of K v = lambda M v, ascending, and their vectors
    (n, count), V' M V = 1.

    K (n, n) symmetric, M (n, n) symmetric positive semidefinite. K + shift M is solved, the shift
    growing until that is positive definite: name one where K may not be (a compressed beam), for an
    eigenvalue near -shift takes the digits of the others. Raises NotConverged.
    """
    count = min(count, len(K))
    nu, V, added = _largest(M, K, count, shift)
    return 1 / nu[:count] - added, V.T / np.sqrt(abs(nu[:count]))


class FamilyModes(NamedTuple):
    """The lowest modes of two uncoupled families of a stack of beams: omega^2 = size - added."""

    V: np.ndarray  # (beams, 2, n, count) of unit modal mass
    size: np.ndarray  # (beams, 2, count) what was solved, and rounds
    added: np.ndarray  # (beams, 2, 1) the shift
    nu: np.ndarray  # (beams, 2, n) 1 / size of all modes


def family_modes(
    K: np.ndarray, M: np.ndarray, d: np.ndarray, G: np.ndarray, count: int, shift: float
) -> FamilyModes:
    """`symmetric_modes` of a stack of problems K v = lambda M v (beams, n, n) and, second, of
    diag(d) v = lambda G v, d (beams, n) > 0, which needs no shift and is cheaper."""
    n = d.shape[-1]
    count = min(count, n)
    root = 1 / np.sqrt(d)
    A = root[:, :, None] * G * root[:, None, :]
    nu, V = np.empty((len(d), 2, n)), np.empty((len(d), 2, count, n))
    added = np.zeros((len(d), 2, 1))
    for k in range(len(d)):
        nu[k, 0], V[k, 0], added[k, 0] = _largest(M[k], K[k], count, shift)
        nu[k, 1], vectors = largest(A[k], count)
        np.multiply(vectors, root[k], out=V[k, 1])
    size = 1 / nu[..., :count]
    V *= np.sqrt(abs(size))[..., None]
    return FamilyModes(V.mT, size, added, nu)


def largest(A: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """All eigenvalues (n,), descending, of symmetric A (n, n), of which the upper triangle is read,
    and the vectors of the `count` largest, each a row.

    By QR of all vectors, or of a larger problem by inverse iteration of a few.
    """
    # Transposed, symmetric matrices come as LAPACK wants them: no conversion.
    n, count = len(A), min(count, len(A))
    if n >= max(FEW, 2 * count):
        reflectors, d, e, tau, _ = lapack.dsytrd(A.T, lower=1, lwork=BLOCK * n)
        nu, failed = lapack.dsterf(d, e)
        if not failed:
            one_block = np.ones(n, np.int32), np.full(n, n, np.int32)
            V, failed = lapack.dstein(d, e, nu[n - count :], *one_block)
        if not failed:
            V[1:] = lapack.dormqr("L", "N", reflectors[1:, :-1], tau, V[1:], BLOCK * n)[0]
            return nu[::-1], V.T[count - 1 :: -1]
    nu, V, info = (lapack.dsyev if n < FEW else lapack.dsyevd)(A.T, lower=1)
    if info:
        raise NotConverged(f"the eigenvalues did not converge (LAPACK: {info})")
    return nu[::-1], V.T[: -count - 1 : -1]


def _largest(
    M: np.ndarray, K: np.ndarray, count: int, shift: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """All nu (descending) of M v = nu (K + added M) v, `count` of the v, each a row, and added."""
    for added in chain((shift,), SHIFTS):
        found = _definite(M, K + added * M if added else K, count)
        if found is not None:
            if found[0][0] * added > 4:  # almost singular: that would cost digits
                again = _definite(M, K + 2 * added * M, count)
                found, added = (found, added) if again is None else (again, 2 * added)
            return *found, added
    raise NotConverged(
        f"the stiffness is not positive definite, nor with {SHIFTS[-1]:.3g} times the mass added:"
        " the beam may be too near a limit of its equilibrium"
    )


def _definite(M: np.ndarray, K: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray] | None:
    """All nu (descending) of M v = nu K v and `count` of the v, each a row; None if K is not
    definite."""
    n = len(K)
    if n >= FEW:
        L, info = lapack.dpotrf(K.T, lower=1)
        if info:
            return None
        A, _ = lapack.dsygst(M.T, L, lower=1)
        nu, V = largest(A.T, count)
        return nu, lapack.dtrtrs(L, V.T, lower=1, trans=1)[0].T
    nu, V, info = lapack.dsygv(M.T, K.T)
    if 0 < info <= n:
        raise NotConverged(f"the eigenvalues did not converge (LAPACK: {info})")
    return None if info else (nu[::-1], V.T[: -count - 1 : -1])


class GyroscopicModes(NamedTuple):
    """Modes of a stack of coupled problems: q = Re (a, b) e^(i omega t), or e^(growth t) where
    omega^2 = -growth^2."""

    omega_squared: np.ndarray  # (..., count) ascending
    a: np.ndarray  # (..., na, count) complex, unit modal mass
    b: np.ndarray  # (..., nb, count)
    roundings: np.ndarray  # (..., count) how many times omega^2 is rounded
    spectrum: np.ndarray | None  # (..., n) all omega^2, where K is positive definite


def gyroscopic_modes(
    Ka: np.ndarray,
    Fa: np.ndarray,
    Kb: np.ndarray,
    Fb: np.ndarray,
    gamma: float | np.ndarray,
    count: int,
    most_rounding: float = 1e6,
) -> GyroscopicModes:
    """The `count` lowest modes of one problem or of a stack of them, gamma (..., 1, 1) then.

    Where K is positive definite their frequencies are real by construction; only a single problem
    may have an indefinite K: LinAlgError is raised for a stack. most_rounding: how many times
    omega^2 may be rounded before more is done. Raises NotConverged.
    """
    try:
        La, Lb = np.linalg.cholesky(Ka), np.linalg.cholesky(Kb)
    except np.linalg.LinAlgError:
        if Ka.ndim > 2 and len(Ka) > 1:
            raise
        one = [part.reshape(part.shape[-2:]) for part in (Ka, Fa, Kb, Fb)]
        found = _indefinite(one[0], one[1], one[2], one[3], float(np.squeeze(gamma)), count)
        omega_squared, a, b = (part.reshape(*Ka.shape[:-2], *part.shape) for part in found)
        roundings, spectrum = np.full(omega_squared.shape, INDEFINITE_ROUNDING), None
    else:
        omega_squared, a, b, roundings, spectrum = _definite_gyroscopic(
            La, Fa, Lb, Fb, gamma, count, most_rounding
        )
    mass = (abs(Fa @ a) ** 2).sum(axis=-2) + (abs(Fb @ b) ** 2).sum(axis=-2)
    root = np.sqrt(mass)[..., None, :]
    return GyroscopicModes(omega_squared, a / root, b / root, roundings, spectrum)


def _definite_gyroscopic(
    La: np.ndarray,
    Fa: np.ndarray,
    Lb: np.ndarray,
    Fb: np.ndarray,
    gamma: float | np.ndarray,
    count: int,
    most_rounding: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The lowest modes for K = diag(La La', Lb Lb'), and all omega^2.

    With q = (a, i b) e^(i omega t) all is real, and with the velocities omega Fb b and
    omega Fa a as unknowns omega appears once:

        [-2 gamma Fa' Fb  Fa'] [   b      ]             [Ka  ] [   a      ]
        [      Fb         0  ] [omega Fa a]  = 1/omega  [   1] [omega Fb b],

    so between the Cholesky factors 1/omega are the singular values of that matrix Z, and
    1/omega^2 the eigenvalues of Z' Z: with half the digits between modes far apart, which the
    singular values of Z on the few vectors found give back.
    """
    na, nb, m = La.shape[-1], Lb.shape[-1], Fa.shape[-2]
    Ya, Yb = np.linalg.solve(La, Fa.mT), np.linalg.solve(Lb, Fb.mT).mT
    Z = np.zeros((*La.shape[:-2], na + m, nb + m))
    Z[..., :na, :nb] = -2 * gamma * (Ya @ Yb)
    Z[..., :na, nb:], Z[..., na:, :nb] = Ya, Yb
    spectrum, Y = _inverse_largest(Z.mT @ Z, count)
    spectrum = spectrum[..., : na + nb]
    omega_squared = spectrum[..., :count]
    roundings = abs(omega_squared / omega_squared[..., :1])
    if roundings.max() > most_rounding:
        few = roundings.max() < FAR_APART
        basis = Y if few else np.eye(nb + m)
        _, inverse, rotation = np.linalg.svd(Z @ basis, full_matrices=False)
        omega_squared, Y = 1 / inverse[..., :count] ** 2, basis @ rotation[..., :count, :].mT
        spectrum[..., :count] = omega_squared
        roundings = omega_squared / omega_squared[..., :1]
        roundings = np.sqrt(roundings) + (EPS * roundings**2 if few else 0)  # of values, of vectors
    X = Z @ Y * np.sqrt(omega_squared)[..., None, :]
    a = np.linalg.solve(La.mT, X[..., :na, :])
    b = np.linalg.solve(Lb.mT, Y[..., :nb, :])
    return omega_squared, a.astype(complex), 1j * b, roundings, spectrum


def _inverse_largest(A: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Inverses (..., n), ascending, of the eigenvalues of A, and the first `count` vectors."""
    n = A.shape[-1]
    # In one call numpy would set threads on each of these small problems.
    found = [largest(one, count) for one in A.reshape(-1, n, n)]
    nu, V = map(np.array, zip(*found, strict=True))
    nu, V = nu.reshape(*A.shape[:-2], n), V.reshape(*A.shape[:-2], -1, n)
    with np.errstate(divide="ignore"):  # a mode lost to rounding, whose inverse shows it
        return 1 / nu, V.mT


def _indefinite(
    Ka: np.ndarray, Fa: np.ndarray, Kb: np.ndarray, Fb: np.ndarray, gamma: float, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The lowest modes (omega^2, a, b) of one problem where Ka or Kb is indefinite, not both.

    Say it is Kb. With the other family in its own modes, Ka = diag(l), Fa' Fa = 1 and C = Fa' Fb,
    and with y = sqrt(l) a and z = b' (q = (a, b) e^(s t)), the problem is symmetric:

        [         l             -2 gamma sqrt(l) C  ] [y]        [1         ] [y]
        [-2 gamma C' sqrt(l)   Kb + 4 gamma^2 C' C ] [z] = -s^2 [   Fb' Fb ] [z].

    So every s^2 is real: such a beam may buckle, it does not flutter.
    """
    unknowns = len(Ka) + len(Kb)
    if unknowns > MAX_INDEFINITE:
        raise NotConverged(
            f"the straight beam is unstable; with Coriolis forces its {unknowns} unknowns are too"
            f" many, at most {MAX_INDEFINITE} are tried: ask without them, or for a lower gamma"
        )
    l, A = symmetric_modes(Ka, Fa.T @ Fa, len(Ka), COMPRESSED)
    if l[0] <= 0:
        if np.linalg.eigvalsh(Kb)[0] <= 0:
            raise NotConverged(
                "both families are unstable; with Coriolis forces such a beam is not solved: ask"
                " without them, or for a lower gamma"
            )
        omega_squared, b, a = _indefinite(Kb, Fb, Ka, Fa, -gamma, count)
        return omega_squared, a, b
    kept = (l >= l[0]) & (l < HIGHEST * (1 + l[0]))
    l, A = l[kept], A[:, kept]
    na, n = len(l), len(l) + len(Kb)
    C = (Fa @ A).T @ Fb
    P, M = np.zeros((n, n)), np.eye(n)
    P[:na, :na], P[na:, na:] = np.diag(l), Kb + 4 * gamma**2 * C.T @ C
    P[:na, na:] = -2 * gamma * np.sqrt(l)[:, None] * C
    P[na:, :na], M[na:, na:] = P[:na, na:].T, Fb.T @ Fb
    omega_squared, V = symmetric_modes(P, M, count, COMPRESSED)
    s = np.sqrt(-omega_squared + 0j)
    return omega_squared, A @ (s * V[:na] / np.sqrt(l)[:, None]), V[na:].astype(complex)
