"""Vibration with Coriolis forces: M q" + 2 gamma G q' + K q = 0, a structured problem.

q holds a family along the beam (a) and one across it (b): K = diag(Ka, Kb) with the softening in
it, M = diag(Fa' Fa, Fb' Fb), G = [[0, -Fa' Fb], [Fb' Fa, 0]]. The rows of Fa and Fb are
displacements at common points times the root of the mass there.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from beamviz.errors import NotConverged
from beamviz.solver import eigen
from beamviz.solver.eigen import COMPRESSED

EPS = float(np.finfo(float).eps)
FAR_APART = 1e10  # eigenvalues whose vectors Z' Z does not tell apart well enough
HIGHEST = 1e10  # times the lowest eigenvalue: modes above are rounding
MOST_UNSTABLE = 400  # unknowns of a beam that buckles: a twentieth of a second
ROUNDED_OFTEN = 2e4  # omega^2 of such a beam, on random ones


class Coupled(NamedTuple):
    """Modes of a stack of coupled problems: q = Re (a, b) e^(i omega t), or e^(growth t) where
    omega^2 = -growth^2."""

    squares: np.ndarray  # (..., count) omega^2, ascending
    a: np.ndarray  # (..., na, count) complex, unit modal mass
    b: np.ndarray  # (..., nb, count)
    rounding: np.ndarray  # (..., count) how often omega^2 is rounded
    definite: bool  # whether K is


def gyroscopic(
    Ka: np.ndarray,
    Fa: np.ndarray,
    Kb: np.ndarray,
    Fb: np.ndarray,
    gamma: float | np.ndarray,
    count: int,
    most_rounding: float = 1e6,
) -> Coupled:
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
            squares, a, b = _unstable(Ka, Fa, Kb, Fb, speed, count)
        else:  # a model without the stretched equilibrium
            squares, b, a = _unstable(Kb, Fb, Ka, Fa, -speed, count)
        rounding, definite = np.full(count, ROUNDED_OFTEN), False
    else:
        definite = True
        squares, a, b, rounding = _stable(La, Fa, Lb, Fb, gamma, count, most_rounding)
    mass = (abs(Fa @ a) ** 2).sum(axis=-2) + (abs(Fb @ b) ** 2).sum(axis=-2)
    root = np.sqrt(mass)[..., None, :]
    return Coupled(squares, a / root, b / root, rounding, definite)


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
    squares, Y = _largest(Z.mT @ Z, count)
    rounding = abs(squares / squares[..., :1])
    if rounding.max() > most_rounding:
        few = rounding.max() < FAR_APART
        among = Y if few else np.eye(nb + m)
        _, inverse, turn = np.linalg.svd(Z @ among, full_matrices=False)
        squares, Y = 1 / inverse[..., :count] ** 2, among @ turn[..., :count, :].mT
        rounding = squares / squares[..., :1]
        rounding = np.sqrt(rounding) + (EPS * rounding**2 if few else 0)  # of values, of vectors
    X = Z @ Y * np.sqrt(squares)[..., None, :]
    a = np.linalg.solve(La.mT, X[..., :na, :])
    b = np.linalg.solve(Lb.mT, Y[..., :nb, :])
    return squares, a.astype(complex), 1j * b, rounding


def _largest(A: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Inverses (..., count), ascending, of the largest eigenvalues of A, and their vectors."""
    n = A.shape[-1]
    if A.ndim > 2:
        nu, Y = eigen.symmetric(A)
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
    squares, V, _ = eigen.lowest(P, M, count, COMPRESSED)
    s = np.sqrt(-squares + 0j)
    return squares, A @ (s * V[:na] / np.sqrt(l)[:, None]), V[na:].astype(complex)


def _basis(K: np.ndarray, F: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All modes of one family alone that are more than rounding: lambda (k,), shapes (n, k)."""
    squares, V, _ = eigen.lowest(K, F.T @ F, len(K), COMPRESSED)
    kept = (squares >= squares[0]) & (squares < HIGHEST * (1 + abs(squares[0])))
    return squares[kept], V[:, kept]
