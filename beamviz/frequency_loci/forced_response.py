"""Running up through resonances: steady vibration under a force that comes per_rev times a turn.

The force acts on every particle in proportion to its mass, as weight does on a beam that turns in a
vertical plane: seen from the beam it goes round once a turn, along it and across it (out of the
plane of rotation: across it only). Here it may go round 2, 3 ... times a turn. The response is
linear and steady, as if each speed were held until the beam has settled, and every mode has the
same damping ratio. 1 is the deflection of the tip at rest under the same force held still.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from scipy.optimize import brentq

from beamviz.beam import Beam, check_float, check_int
from beamviz.errors import InvalidInput
from beamviz.frequency_loci import Branch, Loci, loci
from beamviz.solver import solve_many
from beamviz.solver.solution import Solution

MAX_SOLVES = 6
SETTLED = 1e-10  # of the largest speed: a smaller shift is not solved again


class Resonance(NamedTuple):
    """omega = per_rev gamma: a force that turns with the beam per_rev times excites a mode."""

    per_rev: int
    branch: str
    at: float  # gamma
    frequency: float


def resonances(loci: Loci, count: int) -> list[Resonance]:
    """The intersections of loci over gamma with the lines omega = k gamma, k = 1 .. count.

    Raises InvalidInput for loci over another number.
    """
    if count and loci.over != "gamma":
        raise InvalidInput(f"per-rev lines need loci over gamma, not over {loci.over}")
    seen = [
        _Seen(k, branch, i, loci.values)
        for branch in loci.branches
        for k in range(1, count + 1)
        for i in _sign_changes(branch.frequency - k * loci.values)
    ]
    for _ in range(MAX_SOLVES):
        moving = [one for one in seen if one.shift > SETTLED * loci.values[-1]]
        beams = [loci.beam.replace(gamma=one.at) for one in moving]
        modes = 1 + max((one.place for one in moving), default=0)
        for one, answer in zip(moving, solve_many(beams, modes=modes, **loci.options), strict=True):
            one.move(answer)
    found = [Resonance(one.k, one.branch.label, one.at, one.k * one.at) for one in seen]
    return sorted(found, key=lambda resonance: resonance.at)


def _sign_changes(difference: np.ndarray) -> list[int]:
    """The values behind which a difference changes its sign, or at which it has none."""
    known, above = np.isfinite(difference), difference >= 0
    return np.flatnonzero((above[:-1] != above[1:]) & known[:-1] & known[1:]).tolist()


class _Seen:
    """An intersection seen between two values, moved to where it is by chords."""

    def __init__(self, k: int, branch: Branch, i: int, values: np.ndarray):
        near = slice(max(i - 1, 0), i + 3)
        known = np.isfinite(branch.frequency[near])
        x, y = values[near][known], (branch.frequency[near] - k * values[near])[known]
        curve = Polynomial.fit(x, y, len(x) - 1)
        self.k, self.branch = k, branch
        self.place = int(branch.mode_index[i : i + 2].max())
        ends = np.array(values[i : i + 2])
        if np.prod(curve(ends)) < 0:
            self.at = float(brentq(curve, *ends))
        else:  # it is at an end, but for rounding
            self.at = float(ends[abs(curve(ends)).argmin()])
        self.slope = float(curve.deriv()(self.at))
        self.shift = np.inf

    def move(self, answer: object) -> None:
        """Move by one more solution, the one here."""
        shift = 0.0
        if isinstance(answer, Solution):
            off = answer.frequencies - self.k * self.at
            shift = float(off[np.nanargmin(abs(off))] / self.slope)
        self.at, self.shift = self.at - shift, abs(shift)


LOADS = {"chordwise": (1j, -1.0), "flapwise": (0.0, -1.0)}  # along, across; times exp(i omega t)
DAMPING = (0.001, 0.2)
MAX_PER_REV = 20
SPEEDS = 81  # evenly spread
NEAR = np.sinh(np.linspace(-3.5, 3.5, 33)) / 2  # in half widths of a resonance
GAUSS_X, GAUSS_W = np.polynomial.legendre.leggauss(64)
TIP = np.ones(1)


def response(solution: Solution, frequency: float, damping: float, x: np.ndarray) -> np.ndarray:
    """Amplitudes (len(x), 2) along and across the beam at x under the force at `frequency`; the
    displacement is the real part of them times exp(i frequency t), over the static deflection.

    Sums the modes of the solution: with shapes phi and poles p, D(omega) = K + 2 i omega gamma G -
    omega^2 M has the inverse sum of phi phi^H / (n (p - omega)) and, for the same modes turning the
    other way, of their conjugates. nan where a mode is unstable, as nothing settles then.
    """
    if solution.omega_squared[0] < 0:
        return np.full((len(x), 2), np.nan + 0j)
    modes = _Modes.of(solution)
    swing = np.sqrt(1 - damping**2)
    pole, norm = modes.omega * (swing + 1j * damping), modes.norm * swing
    shapes = solution.displacement(x)  # (len(x), 2, modes)
    ahead = shapes @ (modes.force / (norm * (pole - frequency)))
    behind = shapes.conj() @ (modes.force_back / (norm * (pole.conj() + frequency)))
    return (ahead + behind) / static_deflection(solution.beam)


class _Modes(NamedTuple):
    """What a response needs of each mode: omega, n = -d(phi^H D phi)/d omega there, and the work
    of the force on its shape and on the conjugate one."""

    omega: np.ndarray
    norm: np.ndarray
    force: np.ndarray
    force_back: np.ndarray

    @classmethod
    def of(cls, solution: Solution) -> "_Modes":
        """By quadrature over the shapes."""
        beam, omega = solution.beam, solution.frequencies
        x, weight = quadrature(beam)
        u, w = np.moveaxis(solution.displacement(x), 1, 0)  # (len(x), modes) each
        along, across = LOADS[solution.problem.plane]
        mass = weight @ (abs(u) ** 2 + abs(w) ** 2)
        turning = weight @ (w.conj() * u - u.conj() * w)  # phi^H G phi, 0 for real shapes
        return cls(
            omega,
            (2 * omega * mass - 2j * beam.gamma * turning).real,
            weight @ (along * u.conj() + across * w.conj()),
            weight @ (along * u + across * w),
        )


def quadrature(beam: Beam) -> tuple[np.ndarray, np.ndarray]:
    """Points and weights of an integral over the mass of a beam, the concentrated one included."""
    ends = [0.0, *([beam.beta] if 0 < beam.beta < 1 else []), 1.0]
    x = [a + (b - a) * (GAUSS_X + 1) / 2 for a, b in pairwise(ends)]
    weight = [(b - a) * GAUSS_W / 2 for a, b in pairwise(ends)]
    return np.append(np.concatenate(x), beam.beta), np.append(np.concatenate(weight), beam.alpha)


def static_deflection(beam: Beam) -> float:
    """Deflection of the tip at rest under the force held still across the beam."""
    return 1 / 8 + beam.alpha * beam.beta**2 * (3 - beam.beta) / 6


@dataclass(frozen=True)
class RunUp:
    """Steady responses at rising speeds (n,), closer together near the resonances.

    amplitudes: (n,) of the tip, over the static deflection; nan where there is no equilibrium or
    no stable one. solutions: for each speed, None without equilibrium.
    """

    beam: Beam
    per_rev: int
    damping: float
    speeds: np.ndarray
    solutions: tuple[Solution | None, ...]
    resonances: tuple[Resonance, ...]

    @cached_property
    def amplitudes(self) -> np.ndarray:
        """Amplitude of the tip at each speed."""
        return np.array([self.amplitude(solution) for solution in self.solutions])

    def amplitude(self, solution: Solution | None) -> float:
        """Amplitude of the tip in one solution."""
        if solution is None:
            return float("nan")
        tip = response(solution, self.per_rev * solution.beam.gamma, self.damping, TIP)[0]
        return _largest(tip)

    def peak(self, resonance: Resonance) -> float:
        """The amplitude of the tip at a resonance."""
        return float(self.amplitudes[np.argmin(abs(self.speeds - resonance.at))])


def _largest(amplitude: np.ndarray) -> float:
    """The largest distance from rest of a point that moves on an ellipse, Re (a e^ip) (2,)."""
    a, b = amplitude.real, amplitude.imag
    sizes = float(a @ a + b @ b) / 2
    return float(np.sqrt(sizes + np.hypot(float(a @ a - b @ b) / 2, float(a @ b))))


def run_up(
    beam: Beam, per_rev: int, damping: float, stop: float, modes: int = 5, **options: Any
) -> RunUp:
    """Steady responses of a beam from rest to the speed `stop`, whatever its own gamma.

    options: as for solve(). Raises InvalidInput, and NoEquilibrium or NotConverged where that is
    so at all speeds.
    """
    per_rev = check_int("per_rev", per_rev, 1, MAX_PER_REV)
    damping = check_float("damping", damping, *DAMPING)
    even = np.linspace(0.0, stop, SPEEDS)
    found = loci(beam, "gamma", even, modes=modes, **options)
    own = tuple(one for one in resonances(found, per_rev) if one.per_rev == per_rev)
    near = [one.at * (1 + damping * NEAR) for one in own]
    speeds = np.unique(np.concatenate([even, *near]))
    speeds = speeds[(speeds >= 0) & (speeds <= stop)]
    answers = solve_many([beam.replace(gamma=speed) for speed in speeds], modes=modes, **options)
    solutions = tuple(answer if isinstance(answer, Solution) else None for answer in answers)
    return RunUp(beam, per_rev, damping, speeds, solutions, own)
