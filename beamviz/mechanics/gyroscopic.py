"""Vibration with Coriolis forces: M q" + 2 gamma G q' + K q = 0, a structured problem.

q holds a family along the beam (a) and one across it (b): K = diag(Ka, Kb) with the softening in
it, M = diag(Fa' Fa, Fb' Fb), G = [[0, -Fa' Fb], [Fb' Fa, 0]]. The rows of Fa and Fb are
displacements at common points times the root of the mass there.
"""

import numpy as np

from beamviz.mechanics import eigen
from beamviz.mechanics.eigen import COMPRESSED

HIGHEST = 1e10  # times the lowest eigenvalue: modes above are rounding


def gyroscopic(
    Ka: np.ndarray, Fa: np.ndarray, Kb: np.ndarray, Fb: np.ndarray, gamma: float, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """omega^2 (count,) ascending, and the complex shapes a (na, count), b (nb, count) of unit
    modal mass: q = Re (a, b) e^(i omega t), or e^(growth t) where omega^2 = -growth^2.

    Where K is positive definite the frequencies are real by construction.
    """
    try:
        La, Lb = np.linalg.cholesky(Ka), np.linalg.cholesky(Kb)
    except np.linalg.LinAlgError:
        squares, a, b = _unstable(Ka, Fa, Kb, Fb, gamma, count)
    else:
        squares, a, b = _stable(La, Fa, Lb, Fb, gamma, count)
    mass = (abs(Fa @ a) ** 2).sum(axis=0) + (abs(Fb @ b) ** 2).sum(axis=0)
    return squares, a / np.sqrt(mass), b / np.sqrt(mass)


def _stable(
    La: np.ndarray, Fa: np.ndarray, Lb: np.ndarray, Fb: np.ndarray, gamma: float, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The lowest modes for K = diag(La La', Lb Lb').

    With q = (a, i b) e^(i omega t) all is real, and with the velocities omega Fb b and
    omega Fa a as unknowns omega appears once:

        [-2 gamma Fa' Fb  Fa'] [   b      ]             [Ka  ] [   a      ]
        [      Fb         0  ] [omega Fa a]  = 1/omega  [   1] [omega Fb b],

    so between the Cholesky factors 1/omega are the singular values of that matrix.
    """
    na, nb, m = len(La), len(Lb), len(Fa)
    Ya = np.linalg.solve(La, Fa.T)
    Yb = np.linalg.solve(Lb, Fb.T).T
    Z = np.block([[-2 * gamma * Ya @ Yb, Ya], [Yb, np.zeros((m, m))]])
    X, inverse, Y = np.linalg.svd(Z)
    a = np.linalg.solve(La.T, X[:na, :count])
    b = np.linalg.solve(Lb.T, Y[:count, :nb].T)
    return 1 / inverse[:count] ** 2, a.astype(complex), 1j * b


def _unstable(
    Ka: np.ndarray, Fa: np.ndarray, Kb: np.ndarray, Fb: np.ndarray, gamma: float, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The lowest modes where K is indefinite, by a general eigenproblem in the modes of each
    family: with Omega = |lambda|^(1/2) and p = Omega q,

        p' = Omega q',    q" = -sign(lambda) Omega p - 2 gamma G q'.

    The exponents s come as pairs +- s with s^2 = -omega^2. A complex one flutters: its growth
    rate is reported.
    """
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
    squares, V = eigen.lowest(K, F.T @ F, len(K), COMPRESSED)
    kept = (squares >= squares[0]) & (squares < HIGHEST * (1 + abs(squares[0])))
    return squares[kept], V[:, kept]
