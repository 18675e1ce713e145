"""Eigenproblems of vibration, solved so that the low modes keep their digits.

K v = lambda M v with thin elements or high order has eigenvalues 1e17 apart, and the usual
reduction by M loses the low ones. Here M v = nu K v is solved and lambda = 1/nu: the low
modes are the largest nu, and rounding falls on the high modes nobody asked for.
"""

import numpy as np
from scipy.linalg import lapack

from beamviz.errors import NotConverged

SHIFTS = (0.0, *(4.0**k for k in range(2, 30)))


def lowest(K: np.ndarray, M: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The `count` lowest eigenvalues (ascending) of K v = lambda M v and their vectors.

    K (n, n) symmetric, M (n, n) symmetric positive semidefinite. A K that is not positive
    definite (a compressed beam) is shifted by a multiple of M until it is.
    Returns lambda (count,) and V (n, count) with V' M V = 1; for stacks of matrices, stacks.
    """
    if K.ndim == 3:
        pairs = [lowest(K_one, M_one, count) for K_one, M_one in zip(K, M, strict=True)]
        return np.array([values for values, _ in pairs]), np.array([V for _, V in pairs])
    for shift in SHIFTS:
        # Transposed, symmetric matrices come as LAPACK wants them: no conversion.
        nu, V, info = lapack.dsygvd(M.T, (K + shift * M if shift else K).T)
        if not info:
            nu = nu[: -count - 1 : -1]
            return 1 / nu - shift, V[:, : -count - 1 : -1] / np.sqrt(nu)
        if info <= len(K):
            raise NotConverged(f"the eigenvalues did not converge (LAPACK dsygvd: {info})")
    raise NotConverged(f"no shift up to {SHIFTS[-1]:.3g} made the stiffness positive definite")


def gyroscopic(
    Ka: np.ndarray, Fa: np.ndarray, Kb: np.ndarray, Fb: np.ndarray, gamma: float, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The lowest modes of M q" + 2 gamma G q' + K q = 0, G coupling along (a) and across (b).

    K = diag(Ka, Kb), M = diag(Fa' Fa, Fb' Fb), G = [[0, -Fa' Fb], [Fb' Fa, 0]]: K (n, n) are
    stiffnesses with the softening in them, F (m, n) displacements at common points times the
    root of their mass. With q = Re (a, i b) e^(i omega t) everything is real, and with the
    velocities omega Fb b and omega Fa a as unknowns omega appears once and off the diagonal:

        [-2 gamma Fa' Fb  Fa'] [   b      ]             [Ka  ] [   a      ]
        [      Fb         0  ] [omega Fa a]  = 1/omega  [   1] [omega Fb b].

    So the frequencies are the inverse singular values of that matrix between the Cholesky
    factors of diag(Ka, 1) and diag(Kb, 1): real by construction. Only where Kb is not positive
    definite (the straight state is unstable) is a general eigenproblem solved.

    Returns omega^2 (count,) ascending, a (na, count) and b (nb, count) of unit modal mass.
    """
    na, nb, m = Ka.shape[0], Kb.shape[0], Fa.shape[0]
    La = np.linalg.cholesky(Ka)
    Ya = np.linalg.solve(La, Fa.T).T
    Z = np.zeros((na + m, nb + m))
    Z[:na, :nb], Z[:na, nb:], Z[na:, :nb] = -2 * gamma * Ya.T @ Fb, Ya.T, Fb
    try:
        Lb = np.linalg.cholesky(Kb)
    except np.linalg.LinAlgError:
        squares, y = _unstable(Z, Kb, count)
    else:
        Z[:, :nb] = np.linalg.solve(Lb, Z[:, :nb].T).T
        _, y, _, _, info = lapack.dsyevr(Z.T @ Z, range="I", il=nb + m - count + 1, iu=nb + m)
        if info:
            raise NotConverged(f"the eigenvalues did not converge (LAPACK dsyevr: {info})")
        y = y[:, ::-1]
        # Z' Z squares the largest singular value and its rounding; |Z y| has not.
        squares = 1 / ((Z @ y) ** 2).sum(axis=0)
        y[:nb] = np.linalg.solve(Lb.T, y[:nb])
        Z[:, :nb] = Z[:, :nb] @ Lb.T
    a = np.linalg.solve(La.T, (Z @ y)[:na]) * np.sqrt(abs(squares))
    b = y[:nb]
    mass = ((Fa @ a) ** 2).sum(axis=0) + ((Fb @ b) ** 2).sum(axis=0)
    return squares, a / np.sqrt(mass), b / np.sqrt(mass)


def _unstable(Z: np.ndarray, Kb: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """omega^2 ascending and y of Z' Z y = omega^-2 diag(Kb, 1) y, for an indefinite Kb.

    A complex pair flutters: its growth rate is reported, as omega^2 = -(Im omega)^2.
    """
    nb = len(Kb)
    A = Z.T @ Z
    A[:nb] = np.linalg.solve(Kb, A[:nb])
    values, y = np.linalg.eig(A)
    seen = abs(values) > 1e-9 * abs(values).max()  # the rest is rounding of 1 / infinity
    values, y = values[seen], y[:, seen]
    omega = 1 / np.sqrt(values.astype(complex))
    growth = abs(omega.imag)
    squares = np.where(growth > 1e-7 * abs(omega), -(growth**2), omega.real**2)
    order = np.argsort(squares)[:count]
    return squares[order], y[:, order].real
