"""Eigenproblems of vibration, solved so that the low modes keep their digits.

K v = lambda M v with thin elements or high order has eigenvalues 1e17 apart, and the usual
reduction by M loses the low ones. Here M v = nu K v is solved and lambda = 1/nu: the low
modes are the largest nu, and rounding falls on the high modes nobody asked for.
"""

from collections.abc import Iterable
from itertools import chain
from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from beamviz.errors import NotConverged

COMPRESSED = 16.0  # a shift for beams that may buckle: omega^2 of bending at rest is 12
SHIFTS = tuple(COMPRESSED * 4.0**k for k in range(28))
SUBSET = 32  # unknowns from which on a few eigenvectors come faster than all


class Lowest(NamedTuple):
    """The lowest eigenvalues of a stack of problems K v = lambda M v."""

    omega_squared: np.ndarray  # (..., count) lambda, ascending
    V: np.ndarray  # (..., n, count), V' M V = 1
    size: np.ndarray  # (..., count) lambda of what was solved, K + a multiple of M: that rounds


def symmetric_modes(K: np.ndarray, M: np.ndarray, count: int, shift: float = 0.0) -> Lowest:
    """The `count` lowest eigenvalues of K v = lambda M v and their vectors.

    K (..., n, n) symmetric, M (..., n, n) symmetric positive semidefinite. K + shift M is solved,
    the shift growing until that is positive definite: name one where K may not be (a compressed
    beam), for an eigenvalue near -shift takes the digits of the others.
    """
    stack, n = K.shape[:-2], K.shape[-1]
    count = min(count, n)
    nu, V, added = np.empty((*stack, count)), np.empty((*stack, count, n)), np.empty((*stack, 1))
    for k in _each(stack):
        nu[k], V[k], added[k] = _largest(M[k], K[k], count, shift)
    return _lowest(nu, V, added)


def lowest_of_families(
    K: np.ndarray, M: np.ndarray, d: np.ndarray, G: np.ndarray, count: int
) -> Lowest:
    """`symmetric_modes` of K v = lambda M v and, second in an axis after those of the stack, of
    diag(d) v = lambda G v, d (..., n) > 0, which takes less."""
    stack, n = d.shape[:-1], d.shape[-1]
    count = min(count, n)
    root = 1 / np.sqrt(d)[..., None, :]
    A = root.mT * G * root
    nu, V = np.empty((*stack, 2, count)), np.empty((*stack, 2, count, n))
    added = np.zeros((*stack, 2, 1))
    for k in _each(stack):
        nu[*k, 0], V[*k, 0], added[*k, 0] = _largest(M[k], K[k], count, 0.0)
        nu[*k, 1], V[*k, 1] = _last(symmetric(A[k]), count)
    V[..., 1, :, :] *= root
    return _lowest(nu, V, added)


def _each(stack: tuple[int, ...]) -> Iterable[tuple[int, ...]]:
    """The places in a stack; of one problem alone, the only one."""
    return np.ndindex(stack) if stack else ((),)


def _last(found: tuple[np.ndarray, np.ndarray], count: int) -> tuple[np.ndarray, np.ndarray]:
    """The last `count` eigenvalues of those found in ascending order, descending, and their
    vectors as rows."""
    nu, V = found
    return nu[: -count - 1 : -1], V.T[: -count - 1 : -1]


def _lowest(nu: np.ndarray, V: np.ndarray, added: np.ndarray) -> Lowest:
    """What was found of M v = nu (K + added M) v in terms of lambda; V (..., count, n) holds each
    v as a row, in one stretch of memory, and is overwritten."""
    size = 1 / nu
    V *= np.sqrt(abs(size))[..., None]
    return Lowest(size - added, V.mT, size)


def symmetric(A: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All eigenvalues (..., n), ascending, and vectors (..., n, n) of symmetric A (overwritten)."""
    if A.ndim > 2:  # in one call numpy would set threads on each of these small problems
        nu, V = map(np.array, zip(*map(symmetric, A), strict=True))
        return nu, V
    routine = lapack.dsyev if len(A) < SUBSET else lapack.dsyevd
    nu, V, info = routine(A.T, overwrite_a=True)
    if info:
        raise NotConverged(f"the eigenvalues did not converge (LAPACK: {info})")
    return nu, V


def _largest(
    M: np.ndarray, K: np.ndarray, count: int, shift: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """The `count` largest nu (descending) of M v = nu (K + added M) v, each v a row, and added."""
    for added in chain((shift,), SHIFTS):
        found = _definite(M, K + added * M if added else K, count)
        if found is not None:
            if found[0][0] * added > 4:  # all but singular: that would cost digits
                again = _definite(M, K + 2 * added * M, count)
                found, added = (found, added) if again is None else (again, 2 * added)
            return *found, added
    raise NotConverged(
        f"the stiffness is not positive definite, nor with {SHIFTS[-1]:.3g} times the mass added:"
        " the beam may be too near a limit of its equilibrium"
    )


def _definite(M: np.ndarray, K: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray] | None:
    """The `count` largest nu (descending) of M v = nu K v, each v a row; None if K is not
    definite."""
    # Transposed, symmetric matrices come as LAPACK wants them: no conversion.
    n = len(K)
    if n < SUBSET:
        nu, V, info = lapack.dsygv(M.T, K.T)
    elif count > n / 2:
        nu, V, info = lapack.dsygvd(M.T, K.T)
    else:
        nu, V, _, _, info = lapack.dsygvx(M.T, K.T, range="I", il=n - count + 1, iu=n)
        nu, V = nu[:count], V[:, :count]
    if 0 < info <= n:
        raise NotConverged(f"the eigenvalues did not converge (LAPACK: {info})")
    return None if info else _last((nu, V), count)


EPS = float(np.finfo(float).eps)
FAR_APART = 1e10  # eigenvalues whose vectors Z' Z does not tell apart well enough
HIGHEST = 1e10  # times the lowest eigenvalue: modes above are rounding
MOST_UNSTABLE = 400  # unknowns of a beam that buckles: a twentieth of a second
ROUNDED_OFTEN = 2e4  # omega^2 of such a beam, on random ones


class GyroscopicModes(NamedTuple):
    """Modes of a stack of coupled problems: q = Re (a, b) e^(i omega t), or e^(growth t) where
    omega^2 = -growth^2."""

    omega_squared: np.ndarray  # (..., count) omega^2, ascending
    a: np.ndarray  # (..., na, count) complex, unit modal mass
    b: np.ndarray  # (..., nb, count)
    rounding: np.ndarray  # (..., count) how often omega^2 is rounded
    definite: bool  # whether K is


def gyroscopic_modes(
    Ka: np.ndarray,
    Fa: np.ndarray,
    Kb: np.ndarray,
    Fb: np.ndarray,
    gamma: float | np.ndarray,
    count: int,
    most_rounding: float = 1e6,
) -> GyroscopicModes:
    """The `count` lowest modes. Where K is positive definite their frequencies are real by
    construction; only one problem (no stack) may have an indefinite K.

    most_rounding: how often omega^2 may be rounded before more is done.
    """
    try:
        La, Lb = np.linalg.cholesky(Ka), np.linalg.cholesky(Kb)
    except np.linalg.LinAlgError:
        if Ka.ndim > 2:
            raise
        speed = float(np.squeeze(gamma))
        if np.linalg.eigvalsh(Ka)[0] > 0:
            omega_squared, a, b = _unstable(Ka, Fa, Kb, Fb, speed, count)
        else:  # a model without the stretched equilibrium
            omega_squared, b, a = _unstable(Kb, Fb, Ka, Fa, -speed, count)
        rounding, definite = np.full(count, ROUNDED_OFTEN), False
    else:
        definite = True
        omega_squared, a, b, rounding = _stable(La, Fa, Lb, Fb, gamma, count, most_rounding)
    mass = (abs(Fa @ a) ** 2).sum(axis=-2) + (abs(Fb @ b) ** 2).sum(axis=-2)
    root = np.sqrt(mass)[..., None, :]
    return GyroscopicModes(omega_squared, a / root, b / root, rounding, definite)


def _stable(
    La: np.ndarray,
    Fa: np.ndarray,
    Lb: np.ndarray,
    Fb: np.ndarray,
    gamma: float | np.ndarray,
    count: int,
    most_rounding: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The lowest modes for K = diag(La La', Lb Lb').

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
    omega_squared, Y = _largest_of(Z.mT @ Z, count)
    rounding = abs(omega_squared / omega_squared[..., :1])
    if rounding.max() > most_rounding:
        few = rounding.max() < FAR_APART
        among = Y if few else np.eye(nb + m)
        _, inverse, turn = np.linalg.svd(Z @ among, full_matrices=False)
        omega_squared, Y = 1 / inverse[..., :count] ** 2, among @ turn[..., :count, :].mT
        rounding = omega_squared / omega_squared[..., :1]
        rounding = np.sqrt(rounding) + (EPS * rounding**2 if few else 0)  # of values, of vectors
    X = Z @ Y * np.sqrt(omega_squared)[..., None, :]
    a = np.linalg.solve(La.mT, X[..., :na, :])
    b = np.linalg.solve(Lb.mT, Y[..., :nb, :])
    return omega_squared, a.astype(complex), 1j * b, rounding


def _largest_of(A: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Inverses (..., count), ascending, of the largest eigenvalues of A, and their vectors."""
    n = A.shape[-1]
    if A.ndim > 2:
        nu, Y = symmetric(A)
    else:
        nu, Y, _, _, _ = lapack.dsyevr(A.T, range="I", il=n - count + 1, iu=n)
        nu = nu[:count]
    with np.errstate(divide="ignore"):  # one that rounding took, and whose inverse tells
        return 1 / nu[..., : -count - 1 : -1], Y[..., : -count - 1 : -1]


def _unstable(
    Ka: np.ndarray, Fa: np.ndarray, Kb: np.ndarray, Fb: np.ndarray, gamma: float, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The lowest modes where Kb is indefinite; Ka is not, where the beam is stretched stably.

    With the family along the beam in its own modes, Ka = diag(l), Fa' Fa = 1 and C = Fa' Fb,
    and with y = sqrt(l) a and z = b' (q = (a, b) e^(s t)), the problem is symmetric:

        [         l             -2 gamma sqrt(l) C  ] [y]        [1         ] [y]
        [-2 gamma C' sqrt(l)   Kb + 4 gamma^2 C' C ] [z] = -s^2 [   Fb' Fb ] [z].

    So every s^2 is real: such a beam may buckle, it does not flutter.
    """
    if len(Ka) + len(Kb) > MOST_UNSTABLE:
        raise NotConverged(
            f"the straight beam is unstable; with Coriolis forces its {len(Ka) + len(Kb)} unknowns"
            f" are too many, at most {MOST_UNSTABLE} are tried: ask without them, or for a lower"
            " gamma"
        )
    l, A = _basis(Ka, Fa)
    if l[0] <= 0:
        raise NotConverged(
            "both families are unstable; with Coriolis forces such a beam is not solved: ask"
            " without them, or for a lower gamma"
        )
    na, n = len(l), len(l) + len(Kb)
    C = (Fa @ A).T @ Fb
    P, M = np.zeros((n, n)), np.eye(n)
    P[:na, :na], P[na:, na:] = np.diag(l), Kb + 4 * gamma**2 * C.T @ C
    P[:na, na:] = -2 * gamma * np.sqrt(l)[:, None] * C
    P[na:, :na], M[na:, na:] = P[:na, na:].T, Fb.T @ Fb
    omega_squared, V, _ = symmetric_modes(P, M, count, COMPRESSED)
    s = np.sqrt(-omega_squared + 0j)
    return omega_squared, A @ (s * V[:na] / np.sqrt(l)[:, None]), V[na:].astype(complex)


def _basis(K: np.ndarray, F: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All modes of one family alone that are more than rounding: lambda (k,), shapes (n, k)."""
    omega_squared, V, _ = symmetric_modes(K, F.T @ F, len(K), COMPRESSED)
    kept = (omega_squared >= omega_squared[0]) & (
        omega_squared < HIGHEST * (1 + abs(omega_squared[0]))
    )
    return omega_squared[kept], V[:, kept]
