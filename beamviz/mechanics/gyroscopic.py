"""Vibration with Coriolis forces: M q" + 2 gamma G q' + K q = 0, a structured problem.

q holds a family along the beam (a) and one across it (b): K = diag(Ka, Kb) with the softening in
it, M = diag(Fa' Fa, Fb' Fb), G = [[0, -Fa' Fb], [Fb' Fa, 0]]. The rows of Fa and Fb are
displacements at common points times the root of the mass there.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from beamviz.errors import NotConverged
from beamviz.mechanics import eigen
from beamviz.mechanics.eigen import COMPRESSED

HIGHEST = 1e10  # times the lowest eigenvalue: modes above are rounding
MOST_UNSTABLE = 240  # unknowns of the general eigenproblem: half a second
UNSTRUCTURED = 2e4  # rounding of the general eigenproblem, on random beams that may buckle


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

    most_rounding: how often omega^2 may be rounded before a slower way is taken.
    """
    try:
        La, Lb = np.linalg.cholesky(Ka), np.linalg.cholesky(Kb)
    except np.linalg.LinAlgError:
        if Ka.ndim > 2:
            raise
        squares, a, b = _unstable(Ka, Fa, Kb, Fb, float(np.squeeze(gamma)), count)
        rounding, definite = np.full(count, UNSTRUCTURED), False
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
    1/omega^2 the eigenvalues of Z' Z: faster, with half the digits between modes far apart.
    """
    na, nb, m = La.shape[-1], Lb.shape[-1], Fa.shape[-2]
    Ya, Yb = np.linalg.solve(La, Fa.mT), np.linalg.solve(Lb, Fb.mT).mT
    Z = np.zeros((*La.shape[:-2], na + m, nb + m))
    Z[..., :na, :nb] = -2 * gamma * (Ya @ Yb)
    Z[..., :na, nb:], Z[..., na:, :nb] = Ya, Yb
    squares, Y = _largest(Z.mT @ Z, count)
    rounding = squares / squares[..., :1]
    if rounding.max() > most_rounding:
        _, inverse, Y = np.linalg.svd(Z)
        squares, Y = 1 / inverse[..., :count] ** 2, Y[..., :count, :].mT
        rounding = np.sqrt(squares / squares[..., :1])
    X = Z @ Y * np.sqrt(squares)[..., None, :]
    a = np.linalg.solve(La.mT, X[..., :na, :])
    b = np.linalg.solve(Lb.mT, Y[..., :nb, :])
    return squares, a.astype(complex), 1j * b, rounding


def _largest(A: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Inverses (..., count), ascending, of the largest eigenvalues of A, and their vectors."""
    n = A.shape[-1]
    if A.ndim > 2:
        nu, Y = np.linalg.eigh(A)
    else:
        nu, Y, _, _, _ = lapack.dsyevr(A.T, range="I", il=n - count + 1, iu=n)
        nu = nu[:count]
    return 1 / nu[..., : -count - 1 : -1], Y[..., : -count - 1 : -1]


def _unstable(
    Ka: np.ndarray, Fa: np.ndarray, Kb: np.ndarray, Fb: np.ndarray, gamma: float, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The lowest modes where K is indefinite, by a general eigenproblem in the modes of each
    family: with Omega = |lambda|^(1/2) and p = Omega q,

        p' = Omega q',    q" = -sign(lambda) Omega p - 2 gamma G q'.

    The exponents s come as pairs +- s with s^2 = -omega^2. A complex one flutters: its growth
    rate is reported.
    """
    if len(Ka) + len(Kb) > MOST_UNSTABLE:
        raise NotConverged(
            f"the straight beam is unstable; with Coriolis forces its {len(Ka) + len(Kb)} unknowns"
            f" are too many, at most {MOST_UNSTABLE} are tried: ask without them, or for a lower"
            " gamma"
        )
    (la, A), (lb, B) = _basis(Ka, Fa), _basis(Kb, Fb)
    na, n = len(la), len(la) + len(lb)
    eigenvalues = np.concatenate((la, lb))
    root = np.sqrt(abs(eigenvalues))
    C = (Fa @ A).T @ (Fb @ B)
    G = np.zeros((n, n))
    G[:na, na:], G[na:, :na] = -C, C.T
    first_order = np.block(
        [[np.zeros((n, n)), np.diag(root)], [np.diag(-np.sign(eigenvalues) * root), -2 * gamma * G]]
    )
    s, y = np.linalg.eig(first_order)
    flutter = abs((s**2).imag) > 1e-7 * abs(s**2)
    squares = np.where(flutter, -(s.real**2), -(s**2).real)
    order = np.argsort(squares, kind="stable")[: 2 * count : 2]
    q = y[n:, order]
    q = q * np.exp(-1j * np.angle(q[abs(q).argmax(axis=0), np.arange(len(order))]))
    return squares[order], A @ q[:na], B @ q[na:]


def _basis(K: np.ndarray, F: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All modes of one family alone that are more than rounding: lambda (k,), shapes (n, k)."""
    squares, V, _ = eigen.lowest(K, F.T @ F, len(K), COMPRESSED)
    kept = (squares >= squares[0]) & (squares < HIGHEST * (1 + abs(squares[0])))
    return squares[kept], V[:, kept]
