"""Integration of the equation of motion, step by step, and the motion as polynomials in time.

What this costs in accuracy is measured by integrating with shorter steps, too (`refinement`).
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beamviz.dynamics.controllers import Controller
from beamviz.dynamics.equation import AnyBeam, Energies, Equation
from beamviz.dynamics.initial_value import InitialValueProblem
from beamviz.dynamics.newton_step import Step, Stepper
from beamviz.dynamics.polynomials import legendre_integrals
from beamviz.errors import NotConverged

MAX_STEPS = 100_000  # of one run
# A motion that is not known within so many seconds is given up: one processor, 10 stages.
SECONDS = 20.0
STEP_TIME = 1e-3  # [s] of a step
LARGE = 40  # number of unknowns from which on the time of a step grows with it
GROWTH = 1.5  # of the work, from one run to the next
SMALLEST = 1e-9  # step over the whole time at which Newton's method is given up


@dataclass(frozen=True, eq=False)
class Trajectory:
    """The motion as polynomials in time: in step i, with tau = (t - t_i) / h_i in 0 .. 1 and E the
    integrals of the orthonormal Legendre polynomials P,

        q = q_i + h E(tau) slopes_i,    v = v_i + h E(tau) rates_i.

    """

    beam: AnyBeam
    t: NDArray  # (steps + 1,) ends of the steps
    q: NDArray  # (steps, n) at the start of each step
    v: NDArray  # (steps, n) likewise
    slopes: NDArray  # (steps, s, n)
    rates: NDArray  # (steps, s, n)

    def at(self, t: NDArray) -> tuple[NDArray, NDArray]:
        """q and v (len(t), n) of the beam at times; at the start of a step those before it."""
        step = np.clip(np.searchsorted(self.t, t) - 1, 0, len(self.q) - 1)
        h = np.diff(self.t)[step]
        _, E = legendre_integrals((t - self.t[step]) / h, self.slopes.shape[1])
        E = h[:, None] * E
        q = self.q[step] + np.einsum("ts,tsn->tn", E, self.slopes[step])
        return q, self.v[step] + np.einsum("ts,tsn->tn", E, self.rates[step])

    def accelerations_at(self, t: NDArray) -> NDArray:
        """v' (len(t), n) of the beam at times; at the start of a step those before it."""
        step = np.clip(np.searchsorted(self.t, t) - 1, 0, len(self.q) - 1)
        P, _ = legendre_integrals((t - self.t[step]) / np.diff(self.t)[step], self.rates.shape[1])
        return np.einsum("ts,tsn->tn", P, self.rates[step])


@dataclass(frozen=True)
class IntegratedMotion:
    """A motion that was integrated once."""

    trajectory: Trajectory
    parts: tuple[tuple[float, Equation], ...]  # the ends of parts, and the equation of each

    def tip(self, t: NDArray) -> NDArray:
        """Position of the tip (len(t), 2)."""
        q, _ = self.trajectory.at(t)
        beam = self.trajectory.beam
        tip = beam.state(q[:, : beam.size]).positions(np.ones(1))[:, 0]
        return np.stack((tip.real, tip.imag), axis=1)

    def speed(self, t: NDArray) -> NDArray:
        """gamma (len(t),)."""
        _, v = self.trajectory.at(t)
        return self.parts[0][1].gamma(t, v)

    def energies(self, t: NDArray) -> Energies:
        """The energies in the rotating frame (len(t),)."""
        q, v = self.trajectory.at(t)
        energies, before = np.empty((len(Energies._fields), len(t))), -1.0
        for end, equation in self.parts:
            inside = (before < t) & (t <= end)
            gamma, n = equation.gamma(t[inside], v[inside]), equation.size
            energies[:, inside] = equation.energies(gamma, q[inside, :n], v[inside, :n])
            before = end
        return Energies(*energies)

    def energy(self, t: NDArray) -> NDArray:
        """Their sum (len(t),)."""
        return self.energies(t).total


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


class Recorder:
    """The steps of a motion so far, and the state at the end of the last."""

    def __init__(self, beam: AnyBeam, q: NDArray, v: NDArray):
        self.beam = beam
        self.ends = [0.0]
        self.steps: list[tuple[NDArray, NDArray, Step]] = []  # q and v at the start, and the step
        self.q, self.v = q, v  # (n,)

    @property
    def time(self) -> float:
        """The end of the last step."""
        return self.ends[-1]

    def add(self, end: float, step: Step) -> None:
        """Take in a step, which ends at a time."""
        self.ends.append(end)
        self.steps.append((self.q, self.v, step))
        self.q, self.v = step.q, step.v

    @property
    def trajectory(self) -> Trajectory:
        """The steps as arrays."""
        q, v, steps = zip(*self.steps, strict=True)
        slopes = np.array([step.slopes for step in steps])
        rates = np.array([step.rates for step in steps])
        return Trajectory(self.beam, np.array(self.ends), np.array(q), np.array(v), slopes, rates)


def integrate(
    problem: InitialValueProblem,
    controller: Controller,
    tolerance: float,
    *,
    budget: Budget | None = None,
    progress: Callable[[float], object] = float,
) -> IntegratedMotion:
    """The motion of a problem, with steps of the lengths that a controller chooses. tolerance: of
    which Newton's method leaves a part [L]; budget: of all runs of a motion, None without a limit;
    progress: called with the time after each step. Raises NotConverged, and NoEquilibrium where the
    stretch leaves the range of the strain law."""
    if budget:
        budget.begin()
    record = Recorder(problem.parts[0].equation.beam, problem.q, problem.v)
    parts: list[tuple[float, Equation]] = []
    before: Equation | None = None
    for end, with_mass, equation in problem.parts:
        if before and with_mass:
            v = equation.after_docking(record.q, record.v, before, problem.body_velocity)
            record.v = v
        if end > record.time:
            stepper = Stepper(equation, problem.scheme, tolerance, problem.parts[-1].end)
            controller.begin()
            stops = [*sorted(t for t in problem.breaks if record.time < t < end), end]
            for stop in stops:
                for t in advance(record, stepper, controller, stop, SMALLEST * end):
                    count(t, len(record.steps), equation.size, budget, progress)
            parts.append((end, equation))
        before = equation
    return IntegratedMotion(record.trajectory, tuple(parts))


def advance(
    record: Recorder, stepper: Stepper, controller: Controller, stop: float, shortest: float
) -> Iterator[float]:
    """Integrates up to a time, until which the motion is smooth, and yields the end of each step.
    shortest: the length of a step at which Newton's method is given up."""
    equation = stepper.equation
    a = acceleration(equation, record.time, record.q, record.v)
    guess = np.zeros((len(stepper.scheme.c), len(record.q)))
    while record.time < stop:
        t = record.time
        h = controller.length(t)
        left = max(math.ceil(min((stop - t) / h, 3) - 1e-9), 1)  # number of steps; 3: or more
        h = (stop - t) / left if left <= 2 else h  # no tiny last step
        step = stepper.step(t, h, record.q, record.v, a, guess)
        if not controller.takes(h, step):
            if not controller.divides or controller.length(t) < shortest:
                raise failure(equation, t, h, record.v)
            continue
        assert step is not None
        record.add(stop if left == 1 else t + h, step)
        a = step.accelerations[-1]
        guess = np.broadcast_to(step.rates[0], guess.shape)
        equation.check(record.time, record.q, record.v)
        yield record.time


def count(
    t: float,
    steps: int,
    size: int,
    budget: Budget | None,
    progress: Callable[[float], object],
) -> None:
    """Count a step that ends at t, of `size` unknowns. Raises NotConverged where it is one too
    many."""
    progress(t)
    if budget:
        budget.step(t, size)
    if steps > MAX_STEPS:
        raise NotConverged(
            f"t = {t:.4g}: more than {MAX_STEPS} steps; ask for a shorter time or a larger"
            " tolerance"
        )


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
