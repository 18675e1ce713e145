"""One step of the equation of motion, by Newton's method for the accelerations at its stages."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beamviz.dynamics.equation import Equation, Load
from beamviz.dynamics.schemes import Scheme

NEWTON_STEPS = 10
SLOW = 0.2  # ratio of successive Newton steps above which the tangent is computed anew
DIVERGED = 2.0  # ratio of successive Newton steps at which a step is given up
# Errors left by Newton's method over the tolerance: in the positions in a step, and in the velocity
# in all steps together, if they add up.
CONVERGED, LEFT = 1e-3, 0.5
ROUNDED = 1e-11  # [L] a Newton step that may be rounding error
SAME = 1e-9  # relative: differences of steps of equal length are rounding errors
# Instants of a step are at most this part of it, so that the speed at its end is that before a
# corner of the speed there.
BEFORE = 1 - 1e-9


@dataclass
class Step:
    """A step of length h and the motion in it, as polynomials (see Trajectory)."""

    h: float
    q: NDArray  # (n,) at its end
    v: NDArray  # (n,) likewise
    slopes: NDArray  # (s, n) coefficients of the velocity
    rates: NDArray  # (s, n) coefficients of the acceleration
    accelerations: NDArray  # (s, n) X
    error: float  # [L] norm of the highest coefficient of the position

    @property
    def degree(self) -> int:
        """The power of h that the error grows with."""
        return len(self.slopes)


class Stepper:
    """Steps of one integrator for one equation, by the simplified Newton's method: its tangent is
    kept while it serves, for many steps. It converges in proportion, and ends by the error that the
    rate leaves, not by the rule of `continuation.newton`, whose errors are squares.

    tolerance: of the motion [L], which ends at `until`.
    """

    def __init__(self, equation: Equation, scheme: Scheme, tolerance: float, until: float):
        self.equation, self.scheme = equation, scheme
        self.tolerance, self.until = tolerance, until
        self.into_modes, self.back, (self.in_M, self.in_C, self.in_K) = scheme.modes()
        self.middle = len(scheme.c) // 2
        self.inverse: NDArray | None = None  # of the systems (i, n, n)
        self.inverse_step = 0.0
        self.mass = np.zeros((0, 0))

    @np.errstate(over="ignore", invalid="ignore", divide="ignore")  # divergence is detected
    def step(
        self, t: float, h: float, q: NDArray, v: NDArray, a: NDArray, guess: NDArray
    ) -> Step | None:
        """A step of length h from q, v and a (n,), None where Newton's method does not converge.
        guess: of the accelerations X (s, n)."""
        scheme, c = self.scheme, self.scheme.c
        load = self.equation.load(t + h * np.minimum(c, BEFORE))
        start_q = q + h * np.outer(c, v) + h * h * scheme.d * a
        start_v, start_a = v + h * scheme.e * a, scheme.p * a
        X, last = guess, math.inf
        for _ in range(NEWTON_STEPS):
            Q = start_q + h * h * (scheme.D @ X)
            V = start_v + h * (scheme.E @ X)
            A = start_a + scheme.P @ X
            fresh = self.inverse is None or abs(self.inverse_step - h) > SAME * h
            if fresh and not self.take_tangent(h, load, Q, V, A):
                break
            R = self.equation.residual(load, Q, V, A)
            dX = self.solved(R)
            X = X - dX
            size = h * h * float((np.abs(scheme.D @ dX) * self.equation.lengths).max())
            rate = min(size / last, 0.5)  # what is left is size times rate / (1 - rate)
            left = size * rate / (1 - rate) if last < math.inf else size
            if left <= self.newton_error(h):
                return self.finished(h, q, v, a, X)
            if not size < (DIVERGED * last if fresh else math.inf):
                break
            if size > SLOW * last:
                self.inverse = None
            last = size
        self.inverse = None
        return None

    def newton_error(self, h: float) -> float:
        """The error [L] that Newton's method may leave in a step of length h: it is 1 / h times as
        large in the velocity, and in the short steps of a fine run there are many of them."""
        return max(self.tolerance * min(CONVERGED, LEFT * h * h / self.until), ROUNDED)

    def take_tangent(self, h: float, load: Load, Q: NDArray, V: NDArray, A: NDArray) -> bool:
        """Whether there are inverses of the systems of Newton's method, which are kept: one for
        each pair of eigenvectors of the scheme, with the tangents of the stage in the middle."""
        stage = slice(self.middle, self.middle + 1)
        middle = load[0][stage], load[1][stage]
        K, C, M = self.equation.tangents(middle, Q[stage], V[stage], A[stage])
        in_M, in_C, in_K = (part[:, None, None] for part in (self.in_M, self.in_C, self.in_K))
        try:
            self.inverse = np.linalg.inv(in_M * M + h * in_C * C + h * h * in_K * K)
        except np.linalg.LinAlgError:
            return False
        self.inverse_step, self.mass = h, M
        return True

    def solved(self, R: NDArray) -> NDArray:
        """The Newton step (s, n) of residuals (s, n)."""
        assert self.inverse is not None
        modes = self.inverse @ (self.into_modes @ R)[:, :, None]
        return (self.back @ modes[:, :, 0]).real

    def finished(self, h: float, q: NDArray, v: NDArray, a: NDArray, X: NDArray) -> Step:
        """The step from q, v and a (n,) with the solution X (s, n): its polynomials, the state at
        its end and its error, the norm of the highest coefficient of the position."""
        scheme = self.scheme
        if scheme.polynomial is not None:
            slopes = scheme.polynomial @ (v + h * (scheme.E @ X))
            rates = scheme.polynomial @ X
        else:
            E, D, e, d = scheme.end
            (end,) = X
            moved = v + h * (D * end + d * a)
            slopes, rates = hermite_coefficients(moved, v, v + h * (E * end + e * a), h, end - a)
        top = h * slopes[-1] / (2 * math.sqrt(2 * len(slopes) - 1))
        error = math.sqrt(abs(float(top @ self.mass @ top)))
        q1 = q + h * slopes[0]  # the higher polynomials have no mean
        return Step(h, q1, v + h * rates[0], slopes, rates, X, error)


def hermite_coefficients(
    mean: NDArray, v0: NDArray, v1: NDArray, h: float, change: NDArray
) -> tuple[NDArray, NDArray]:
    """Legendre coefficients (3, n) of the velocity that is the derivative of the cubic with the
    positions and velocities at both ends of a step, and of an acceleration with the same change of
    velocity."""
    slope = (v1 - v0) / (2 * math.sqrt(3))
    bend = ((v0 + v1) / 2 - mean) / math.sqrt(5)
    rates = np.stack(((v1 - v0) / h, change / (2 * math.sqrt(3)), np.zeros_like(v0)))
    return np.stack((mean, slope, bend)), rates
