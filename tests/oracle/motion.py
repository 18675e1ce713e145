"""Motion in time, independently of the package: positions as power series in x, the energy by
Gauss quadrature, its gradient by hand in terms of r' and r'', and scipy's DOP853.

Green's strain and the spatial curvature; a mass at the tip; constant speed; held by a transverse
force at the tip until t = 0.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

ORDER, POINTS = 9, 24


def tip_by_polynomials(alpha, gamma, delta, mu, release, times):
    """Position of the tip (len(times), 2), from the clamp, in the rotating frame."""
    x, w = np.polynomial.legendre.leggauss(POINTS)
    x, w = (x + 1) / 2, w / 2
    # r1 = sum a_k x^k, k >= 1; r2 = sum b_k x^k, k >= 2; in shifted Legendre polynomials' place
    # Chebyshev ones times x or x^2, for their conditioning.
    T = np.polynomial.chebyshev.Chebyshev
    one = [T.basis(k, [0, 1]) * T([0.5, 0.5], [0, 1]) for k in range(ORDER)]
    two = [f * T([0.5, 0.5], [0, 1]) for f in one[: ORDER - 1]]
    n = len(one)

    def table(functions, derivative, at):
        made = [f.deriv(derivative) if derivative else f for f in functions]
        return np.array([f(at) for f in made]).T

    S1, d1, dd1 = (table(one, k, x) for k in range(3))
    S2, d2, dd2 = (table(two, k, x) for k in range(3))
    e1, e2 = table(one, 0, 1.0), table(two, 0, 1.0)
    rho = np.append(w, alpha)
    A, B = np.vstack((S1, e1)), np.vstack((S2, e2))
    M = np.block(
        [
            [(A.T * rho) @ A, np.zeros((n, n - 1))],
            [np.zeros((n - 1, n)), (B.T * rho) @ B],
        ]
    )

    def forces(q, v, load):
        a, b = q[:n], q[n:]
        r1, r2, k1, k2 = d1 @ a, d2 @ b, dd1 @ a, dd2 @ b
        f2 = r1**2 + r2**2
        N = mu**2 * (f2 - 1) / 2  # green: e e' / f = (f^2 - 1) / 2
        cross = r1 * k2 - r2 * k1
        kappa = cross / f2**1.5
        by_cross = kappa / f2**1.5
        by_f2 = -1.5 * kappa * cross / f2**2.5
        g1 = d1.T @ (w * (N * r1 + by_cross * k2 + 2 * by_f2 * r1))
        g1 += dd1.T @ (w * -by_cross * r2)
        g2 = d2.T @ (w * (N * r2 - by_cross * k1 + 2 * by_f2 * r2))
        g2 += dd2.T @ (w * by_cross * r1)
        X, Y, vx, vy = A @ a + delta, B @ b, A @ v[:n], B @ v[n:]
        fx = rho * (gamma**2 * X + 2 * gamma * vy)
        fy = rho * (gamma**2 * Y - 2 * gamma * vx)
        return np.append(A.T @ fx - g1, B.T @ fy - g2 + load * e2)

    still = np.zeros(2 * n - 1)
    q = np.zeros(2 * n - 1)
    q[0] = 1.0
    for share in np.linspace(0.25, 1, 4):
        found = root(lambda q, load=share * release: forces(q, still, load), q, tol=1e-12)
        q = found.x
    inverse = np.linalg.inv(M)

    def rates(_, state):
        q, v = np.split(state, 2)
        return np.append(v, inverse @ forces(q, v, 0.0))

    state = np.append(q, still)
    options = {"rtol": 1e-9, "atol": 1e-10, "method": "DOP853"}
    path = solve_ivp(rates, (0, times[-1]), state, t_eval=times, **options).y[: 2 * n - 1]
    return np.column_stack((e1 @ path[:n], e2 @ path[n:]))
