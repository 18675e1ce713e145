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

from beamviz.dynamics.equation import AnyBeam, Equation, Load
from beamviz.dynamics.polynomials import legendre_integrals
from beamviz.dynamics.schemes import Scheme
from beamviz.errors import NotConverged

NEWTON_STEPS = 10
SLOW = 0.2  # ratio of successive Newton steps above which the tangent is computed anew
DIVERGED = 2.0  # ratio of successive Newton steps at which a step is given up
# Errors left by Newton's method over the tolerance: in the positions in a step, and in the velocity
# in all steps together, if they add up.
CONVERGED, LEFT = 1e-3, 0.5
ROUNDED = 1e-11  # [L] a Newton step that may be rounding error
SAME = 1e-9  # relative: differences of steps of equal length are rounding errors
HALF = 0.5  # of a step in which Newton's method failed
SAFETY, SHORTEST, LONGEST = 0.9, 0.3, 3.0  # of the next step over this one
REPEATED = 2.0  # times the tolerance: a step that is worse is repeated
RECOVERY = 1.02  # of the longest step, in each step after a failure
GROWS = 1.2  # a smaller growth is not worth new factors
MAX_STEPS = 100_000  # of one run
# A motion that is not known within so many seconds is given up: one processor, 10 stages.
SECONDS = 20.0
STEP_TIME, LARGE = (
    1e-3,
    40,
)  # [s] of a step, and the number of unknowns from which it grows with these
GROWTH = 1.5  # of the work, from one run to the next
SMALLEST = 1e-9  # step over the whole time at which Newton's method is given up
BEFORE = 1 - 1e-9  # the end of a step belongs to it where the speed has a corner


@dataclass(frozen=True, eq=False)
class Path:
    """The motion as polynomials in time: in step i, with tau = (t - t_i) / h_i in 0 .. 1 and E the
    integrals of the orthonormal Legendre polynomials P,

        q = q_i + h E(tau) slopes_i,    v = v_i + h E(tau) rates_i.

    t: (steps + 1,). q, v: at the start of each step (steps, n); slopes, rates: (steps, s, n).
    """

    beam: AnyBeam
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
class Budget:
    """The work of all runs of a motion, by a model of its time: see SECONDS. It ends at the same
    step on every machine."""

    spent: float = 0.0  # [s]
    before: float = 0.0  # at the start of the last run

    def begin(self) -> None:
        """Begin a run."""
        self.before = self.spent

    def step(self, t: float, size: int) -> None:
        """Count a step that ends at t, of `size` unknowns; raises NotConverged where it is one too
        many."""
        self.spent += step_time(size)
        if self.spent > SECONDS:
            raise NotConverged(
                f"t = {t:.4g}: not computed to the end within {SECONDS:g} s; ask for a shorter time"
                " or a larger tolerance"
            )

    @property
    def allows_another(self) -> bool:
        """Whether a finer run is likely to come to its end."""
        return self.spent + GROWTH * (self.spent - self.before) <= SECONDS


def step_time(size: int) -> float:
    """The time [s] of a step with so many unknowns."""
    return STEP_TIME * (1 + (size / LARGE) ** 2)


@dataclass
class Control:
    """How the steps are chosen."""

    tolerance: float  # of the highest coefficient of a step [L]
    until: float  # the end of the motion
    step: float | None = None  # a constant length instead
    ends: NDArray | None = None  # of the steps, divided further where Newton's method fails
    progress: Callable[[float], object] = float  # called with the time after each step
    budget: Budget | None = None  # None where the resolution is given
    steps: int = 0
    failures: int = 0

    @property
    def adapts(self) -> bool:
        """Whether the lengths follow from the tolerance."""
        return self.step is None and self.ends is None

    def planned(self, t: float) -> float | None:
        """The length of the step from t, None where it follows from the tolerance."""
        if self.ends is None:
            return self.step
        next_end = np.searchsorted(self.ends[:-1], t * (1 + 1e-12), side="right")
        return float(self.ends[next_end]) - t

    def newton_error(self, h: float) -> float:
        """The error [L] that Newton's method may leave in a step of length h: it is 1 / h times as
        large in the velocity, and in the short steps of a fine run there are many of them."""
        return max(self.tolerance * min(CONVERGED, LEFT * h * h / self.until), ROUNDED)

    def count(self, t: float, size: int) -> None:
        """Count a step that ends at t, of `size` unknowns."""
        self.steps += 1
        self.progress(t)
        if self.budget:
            self.budget.step(t, size)
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
    accelerations: NDArray  # X
    error: float

    @property
    def degree(self) -> int:
        """The power of h that the error grows with."""
        return len(self.slopes)


class Stepper:
    """Steps of one integrator for one equation, by Newton's method with a tangent that is kept
    while it serves."""

    def __init__(self, equation: Equation, scheme: Scheme, control: Control):
        self.equation, self.scheme, self.control = equation, scheme, control
        self.into_modes, self.back, (self.in_M, self.in_C, self.in_K) = scheme.modes()
        self.middle = len(scheme.c) // 2
        self.inverse: NDArray | None = None  # of the systems (i, n, n)
        self.inverse_step = 0.0
        self.mass = np.zeros((0, 0))

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
            if fresh:
                self.take_tangent(h, load, Q, V, A)
            R = self.equation.residual(load, Q, V, A)
            dX = self.solved(R)
            X = X - dX
            size = h * h * float((np.abs(scheme.D @ dX) * self.equation.lengths).max())
            rate = min(size / last, 0.5)  # what is left is size times rate / (1 - rate)
            left = size * rate / (1 - rate) if last < math.inf else size
            if left <= self.control.newton_error(h):
                return self.finished(h, q, v, a, X)
            if not size < (DIVERGED * last if fresh else math.inf):
                break
            if size > SLOW * last:
                self.inverse = None
            last = size
        self.inverse = None
        self.control.failures += 1
        return None

    def take_tangent(self, h: float, load: Load, Q: NDArray, V: NDArray, A: NDArray) -> None:
        """The inverses of the systems of Newton's method, one for each pair of eigenvectors of the
        scheme, with the tangents of the stage in the middle."""
        one = slice(self.middle, self.middle + 1)
        K, C, M = self.equation.tangents((load[0][one], load[1][one]), Q[one], V[one], A[one])
        in_M, in_C, in_K = (part[:, None, None] for part in (self.in_M, self.in_C, self.in_K))
        self.inverse = np.linalg.inv(in_M * M + h * in_C * C + h * h * in_K * K)
        self.inverse_step, self.mass = h, M

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


class Recorder:
    """Collects the steps of a motion."""

    def __init__(self, beam: AnyBeam, start: float):
        self.beam, self.t = beam, [start]
        self.q: list[NDArray] = []
        self.v: list[NDArray] = []
        self.slopes: list[NDArray] = []
        self.rates: list[NDArray] = []

    def add(self, t: float, q: NDArray, v: NDArray, step: Step) -> None:
        """Take in a step that ends at t and begins with q and v (n,)."""
        self.t.append(t)
        self.q.append(q)
        self.v.append(v)
        self.slopes.append(step.slopes)
        self.rates.append(step.rates)

    @property
    def path(self) -> Path:
        """The steps so far."""
        arrays = (np.array(part) for part in (self.t, self.q, self.v, self.slopes, self.rates))
        return Path(self.beam, *arrays)


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
        a, guess = acceleration(equation, t, q, v), np.zeros((len(scheme.c), len(q)))
        while t < stop:
            h = control.planned(t) or min(length, most)
            if control.ends is not None:
                h = min(h, most)
            parts = max(math.ceil(min((stop - t) / h, 3) - 1e-9), 1)
            h = (stop - t) / parts if parts <= 2 else h  # no tiny last step
            step = stepper.step(t, h, q, v, a, guess)
            factor = HALF
            if step is not None:
                excess = max(step.error / control.tolerance, 1e-12)
                factor = min(max(SAFETY * excess ** (-1 / step.degree), SHORTEST), LONGEST)
            if (step is None and control.step is None) or (control.adapts and excess > REPEATED):
                length = h * factor
                if step is None:
                    most = length
                if length < SMALLEST * end:
                    raise failure(equation, t, h, v)
                continue
            if step is None:
                raise failure(equation, t, h, v)
            record.add(stop if parts == 1 else t + h, q, v, step)
            t, q, v, a = record.t[-1], step.q, step.v, step.accelerations[-1]
            guess = np.broadcast_to(step.rates[0], guess.shape)
            equation.check(t, q, v)
            control.count(t, equation.size)
            length = h if 1 <= factor < GROWS else h * factor
            most *= RECOVERY
    return q, v, length


def acceleration(equation: Equation, t: float, q: NDArray, v: NDArray) -> NDArray:
    """a (n,) at the start of a smooth part of the motion."""
    after = np.array([t * (1 + 1e-12) + 1e-12])  # the speed may have a corner here
    return equation.accelerations(after, q[None], v[None])[0]


def failure(equation: Equation, t: float, h: float, v: NDArray) -> NotConverged:
    """The error of a step of length h from t, with the velocities v (n,), that is given up."""
    gamma = float(equation.gamma(np.array([t]), v[None])[0])
    return NotConverged(
        f"t = {t:.4g}, gamma = {gamma:.4g}: Newton's method does not converge in a step of {h:.3g};"
        " ask for a smaller tolerance or step"
    )
