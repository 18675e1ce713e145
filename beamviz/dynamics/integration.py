"""Integration of the equation of motion, step by step: Newton's method for the unknowns of a step,
and the length of the next.

The length follows from the polynomial of the step: the size of its highest coefficient, in the norm
of the kinetic energy, is kept near a tolerance, as elements of a mesh are chosen by the tails of
their polynomials. What this costs in accuracy is measured by integrating twice (`motion`).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from beamviz.dynamics.elements import PositionElements
from beamviz.dynamics.equation import Equation
from beamviz.dynamics.schemes import Scheme, legendre_integrals
from beamviz.errors import NotConverged

NEWTON_STEPS = 10
SLOW = 0.05  # ratio of successive Newton steps above which the tangent is computed anew
# Of a Newton step over the tolerance: the error left is a part of it, by the ratio above.
CONVERGED = 1e-4
ROUNDED = 1e-11  # [L] a Newton step that may be rounding error
HALF = 0.5  # of a step in which Newton's method failed
SAFETY, SHORTEST, LONGEST = 0.9, 0.3, 2.0  # of the next step over this one
REPEATED = 2.0  # times the tolerance: a step that is worse is repeated
RECOVERY = 1.02  # of the longest step, in each step after a failure
GROWS = 1.2  # a smaller growth is not worth new factors
MAX_STEPS = 100_000
SMALLEST = 1e-9  # step over the whole time at which Newton's method is given up
BEFORE = 1 - 1e-9  # the end of a step belongs to it where the speed has a corner


@dataclass(frozen=True, eq=False)
class Path:
    """The motion as polynomials in time: in step i, with tau = (t - t_i) / h_i in 0 .. 1 and E the
    integrals of the orthonormal Legendre polynomials P,

        q = q_i + h E(tau) slopes_i,    v = v_i + h E(tau) rates_i.

    t: (steps + 1,). q, v: at the start of each step (steps, n); slopes, rates: (steps, s, n).
    """

    elements: PositionElements
    t: NDArray
    q: NDArray
    v: NDArray
    slopes: NDArray
    rates: NDArray

    def at(self, t: NDArray) -> tuple[NDArray, NDArray]:
        """q and v (len(t), n) of the beam at times; at the start of a step those before it."""
        step = np.clip(np.searchsorted(self.t, t) - 1, 0, len(self.q) - 1)
        h = np.diff(self.t)[step]
        _, E = legendre_integrals((t - self.t[step]) / h, self.slopes.shape[1])
        E = h[:, None] * E
        q = self.q[step] + np.einsum("ts,tsn->tn", E, self.slopes[step])
        return q, self.v[step] + np.einsum("ts,tsn->tn", E, self.rates[step])


@dataclass
class Control:
    """How the steps are chosen. tolerance: of the highest coefficient of a step [L]; step: a
    constant length instead; ends: the ends of the steps instead, which are divided further where
    Newton's method fails; progress: called with the time after each step."""

    tolerance: float
    step: float | None = None
    ends: NDArray | None = None
    progress: Callable[[float], object] = float
    steps: int = 0
    newton_steps: int = 0
    failures: int = 0

    @property
    def adapts(self) -> bool:
        """Whether the lengths follow from the tolerance."""
        return self.step is None and self.ends is None

    def planned(self, t: float) -> float | None:
        """The length of the step from t, None where it follows from the tolerance."""
        if self.ends is None:
            return self.step
        return float(self.ends[np.searchsorted(self.ends, t * (1 + 1e-12), side="right")]) - t

    def count(self, t: float) -> None:
        """Count a step that ends at t."""
        self.steps += 1
        self.progress(t)
        if self.steps > MAX_STEPS:
            raise NotConverged(
                f"t = {t:.4g}: more than {MAX_STEPS} steps; ask for a shorter time or a larger"
                " tolerance"
            )


@dataclass
class Step:
    """One step and its solution X, None where Newton's method did not converge."""

    h: float
    q: NDArray
    v: NDArray
    slopes: NDArray
    rates: NDArray
    last: NDArray  # acceleration at its end
    error: float

    @property
    def degree(self) -> int:
        """The power of h that the error grows with."""
        return len(self.slopes)


class Stepper:
    """Steps of one integrator for one equation."""

    def __init__(self, equation: Equation, scheme: Scheme, control: Control):
        self.equation, self.scheme, self.control = equation, scheme, control
        W, (s, k) = scheme.W, scheme.W.shape
        # The contributions of the three tangents at each stage to the blocks of the matrix.
        products = (np.einsum("jk,ki->jik", W, part) for part in (scheme.P, scheme.E, scheme.D))
        self.in_M, self.in_C, self.in_K = (part.reshape(s * s, k) for part in products)
        self.factors: tuple[NDArray, NDArray] | None = None
        self.factored_step = 0.0

    def step(
        self, t: float, h: float, q: NDArray, v: NDArray, a: NDArray, mean: NDArray
    ) -> Step | None:
        """A step of length h from q, v and a (n,), None where Newton's method does not converge.
        mean: a first guess of the acceleration, that of the step before."""
        scheme, c = self.scheme, self.scheme.c
        times = t + h * np.minimum(c, BEFORE)
        start_q = q + h * np.outer(c, v) + h * h * np.multiply.outer(scheme.d, a)
        start_v = v + h * np.multiply.outer(scheme.e, a)
        start_a = np.multiply.outer(scheme.p, a)
        if self.factored_step != h:
            self.factors = None
        load = self.equation.load(times)
        X = np.zeros((len(scheme.W), len(q)))
        X[0] = mean
        last = math.inf
        for _ in range(NEWTON_STEPS):
            Q = start_q + h * h * (scheme.D @ X)
            V = start_v + h * (scheme.E @ X)
            A = start_a + scheme.P @ X
            R = scheme.W @ self.equation.residual(load, Q, V, A)
            fresh = self.factors is None
            if self.factors is None:
                self.factors = self.factored(h, self.equation.tangents(load, Q, V, A))
            dX = lapack.dgetrs(*self.factors, R.ravel())[0].reshape(X.shape)
            X = X - dX
            self.control.newton_steps += 1
            size = h * h * float(np.abs(scheme.D @ dX).max())
            if size <= max(CONVERGED * self.control.tolerance, ROUNDED):
                return self.finished(h, q, v, a, X)
            if not math.isfinite(size) or (fresh and size > 2 * last):
                break
            if size > SLOW * last and not fresh:
                self.factors = None
            last = size
        self.factors = None
        self.control.failures += 1
        return None

    def factored(
        self, h: float, tangents: tuple[NDArray, NDArray, NDArray]
    ) -> tuple[NDArray, NDArray]:
        """LU factors of the matrix of Newton's method for all unknowns of a step."""
        K, C, M = (tangent.reshape(len(tangent), -1) for tangent in tangents)
        s, n = len(self.scheme.W), self.equation.unknowns
        J = self.in_M @ M + h * (self.in_C @ C) + h * h * (self.in_K @ K)
        J = J.reshape(s, s, n, n).swapaxes(1, 2).reshape(s * n, s * n)
        lu, pivots, _ = lapack.dgetrf(J)
        self.factored_step = h
        return lu, pivots

    def finished(self, h: float, q: NDArray, v: NDArray, a: NDArray, X: NDArray) -> Step:
        scheme, n = self.scheme, self.equation.size
        end = scheme.end_P @ X + scheme.end_p * a
        if scheme.twice is not None:
            slopes = h * (scheme.twice @ X)
            slopes[0] += v
            rates = X
        else:
            q1 = h * v + h * h * (scheme.end_D @ X + scheme.end_d * a)
            v1 = v + h * (scheme.end_E @ X + scheme.end_e * a)
            slopes, rates = hermite_coefficients(q1 / h, v, v1, h, end - a)
        top = h * slopes[-1, :n] / (2 * math.sqrt(2 * len(slopes) - 1))
        error = math.sqrt(float(top @ self.equation.M @ top))
        q1 = q + h * slopes[0]  # the higher polynomials have no mean
        return Step(h, q1, v + h * rates[0], slopes, rates, end, error)


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


class Recorder:
    """Collects the steps of a motion."""

    def __init__(self, elements: PositionElements, start: float):
        self.elements, self.t = elements, [start]
        self.q: list[NDArray] = []
        self.v: list[NDArray] = []
        self.slopes: list[NDArray] = []
        self.rates: list[NDArray] = []

    def add(self, t: float, q: NDArray, v: NDArray, step: Step) -> None:
        self.t.append(t)
        self.q.append(q)
        self.v.append(v)
        self.slopes.append(step.slopes)
        self.rates.append(step.rates)

    @property
    def path(self) -> Path:
        arrays = (np.array(part) for part in (self.t, self.q, self.v, self.slopes, self.rates))
        return Path(self.elements, *arrays)


def integrate(
    equation: Equation,
    scheme: Scheme,
    state: tuple[NDArray, NDArray],
    start: float,
    end: float,
    breaks: list[float],
    control: Control,
    record: Recorder,
    length: float,
) -> tuple[NDArray, NDArray, float]:
    """Integrates from `start` to `end`; steps end at the breaks. state: q and v (n,); length: of
    the first step. Returns q, v and the length of a next step. Raises NotConverged, and
    NoEquilibrium where the stretch leaves the range of the strain law."""
    q, v = state
    stepper = Stepper(equation, scheme, control)
    stops = [*sorted(t for t in breaks if start < t < end), end]
    t, most = start, math.inf  # most: the longest step that Newton's method is tried with
    for stop in stops:
        a, mean = acceleration(equation, t, q, v), np.zeros_like(q)
        while t < stop:
            h = control.planned(t) or min(length, most)
            if control.ends is not None:
                h = min(h, most)
            parts = math.ceil((stop - t) / h - 1e-9)
            h = (stop - t) / parts if parts <= 2 else h  # no tiny last step
            step = stepper.step(t, h, q, v, a, mean)
            factor = HALF
            if step is not None:
                excess = max(step.error / control.tolerance, 1e-12)
                factor = min(max(SAFETY * excess ** (-1 / step.degree), SHORTEST), LONGEST)
            if (step is None and control.step is None) or (control.adapts and excess > REPEATED):
                length = h * factor
                if step is None:
                    most = length
                if length < SMALLEST * end:
                    raise failure(equation, t, h, q, v)
                continue
            if step is None:
                raise failure(equation, t, h, q, v)
            record.add(stop if parts == 1 else t + h, q, v, step)
            t, q, v, a, mean = record.t[-1], step.q, step.v, step.last, step.rates[0]
            equation.check(t, float(equation.gamma(np.array([t]), v[None])[0]), q[: equation.size])
            control.count(t)
            length = h if 1 <= factor < GROWS else h * factor
            most *= RECOVERY
    return q, v, length


def acceleration(equation: Equation, t: float, q: NDArray, v: NDArray) -> NDArray:
    """a (n,) at the start of a smooth part of the motion."""
    after = np.array([t * (1 + 1e-12) + 1e-12])  # the speed may have a corner here
    return equation.accelerations(after, q[None], v[None])[0]


def failure(equation: Equation, t: float, h: float, q: NDArray, v: NDArray) -> NotConverged:
    gamma = float(equation.gamma(np.array([t]), v[None])[0])
    return NotConverged(
        f"t = {t:.4g}, gamma = {gamma:.4g}: Newton's method does not converge in a step of {h:.3g};"
        " ask for a smaller tolerance or step"
    )
