"""Resonances with multiples of the speed, and the steady response while running up through them.

The force acts on every particle in proportion to its mass, as weight does on a beam that rotates in
a vertical plane: in the frame of the beam it rotates once per revolution, with a component along
the beam and one across it (out of the plane of rotation: across it only). A force of higher order
rotates 2, 3 ... times per revolution. The response is linear and steady, as if each speed were held
until transients have decayed, and every mode has the same damping ratio. Amplitudes are in units of
the static deflection of the tip under the same force at rest.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import make_interp_spline

from beamviz.beam import Beam, check_float, check_int
from beamviz.errors import InvalidInput
from beamviz.frequency_loci import Branch, Loci, loci
from beamviz.solver import solve_many
from beamviz.solver.solution import Solution

DEGREES = (5, 3)  # of the splines of omega^2; the difference of the two is the error of the first
SAFETY = 10.0  # times that error
SAMPLES = 8  # of the interpolation in each interval
COARSE = 1 / 40  # of the sweep: longer intervals are halved in any case
FINEST = 1e-6  # of the sweep: shorter intervals are not
NEAR_LIMIT = (1e-4, 1e-2, 0.1, 0.3, 0.6)  # of an interval that ends at a limit: added speeds
MAX_ROUNDS = 30
MAX_CORRECTIONS = 6
SETTLED = 1e-10  # of the largest speed: a smaller correction is the last one

LOADS = {"chordwise": (1j, -1.0), "flapwise": (0.0, -1.0)}  # along, across; times exp(i omega t)
DAMPING = (0.001, 0.2)  # least and greatest damping ratio
MAX_PER_REV = 20
SPEEDS = 81  # evenly spaced
NEAR = np.sinh(np.linspace(-3.5, 3.5, 33)) / 2  # in half widths of a resonance
GAUSS_X, GAUSS_W = np.polynomial.legendre.leggauss(64)
TIP = np.ones(1)


class Resonance(NamedTuple):
    """omega = per_rev gamma: a force of per_rev periods per revolution excites a mode."""

    per_rev: int
    branch: str
    at: float  # gamma
    frequency: float


def resonances(found: Loci, count: int) -> list[Resonance]:
    """The intersections of loci over gamma with the per-rev lines omega = k gamma, k = 1 .. count.

    Between the speeds of the loci omega^2 is interpolated, and solved for at more speeds until its
    intersections with the lines are certain: close pairs and coarse sweeps are resolved. Raises
    InvalidInput for loci over another parameter.
    """
    if not count:
        return []
    if found.over != "gamma":
        raise InvalidInput(f"per-rev lines need loci over gamma, not over {found.over}")
    located = [
        Resonance(root.per_rev, names.get(root.label, root.label), root.at, root.per_rev * root.at)
        for chart, names in [(found, {}), *_beside_limits(found)]
        for root in _roots(chart, range(1, count + 1), COARSE * np.ptp(found.values))
    ]
    return sorted(located, key=lambda resonance: resonance.at)


def _beside_limits(found: Loci) -> Iterator[tuple[Loci, dict[str, str]]]:
    """The loci between the last values with an equilibrium and its limits, and for the labels of
    their branches those of the same branches in `found`."""
    values = found.values
    for limit in (limit for limit in found.limits if limit.kind != "unstable"):
        below, above = values[values < limit.start][-1:], values[values > limit.stop][:1]
        for edge, value in [(limit.start, x) for x in below] + [(limit.stop, x) for x in above]:
            nearer = [edge + share * (value - edge) for share in NEAR_LIMIT]
            speeds = [x for x, solved in _solve(found, np.sort([value, *nearer])).items() if solved]
            if len(speeds) > 1 and value in speeds:
                chart = loci(found.beam, "gamma", speeds, found.modes, **found.options)
                labels = zip(chart.labels_at(value), found.labels_at(value), strict=False)
                yield chart, dict(labels)


def _roots(found: Loci, lines: range, coarse: float) -> list["_Root"]:
    """The intersections of loci with lines, after all intervals longer than `coarse` are halved."""
    curves = [curve for branch in found.branches for curve in _curves(found, branch)]
    solved: dict[float, dict[str, float]] = {}
    for _ in range(MAX_ROUNDS):
        uncertain = {speed for curve in curves for speed in curve.uncertain(lines, coarse)}
        speeds = np.array(sorted(uncertain - solved.keys()))
        if not len(speeds):
            break
        solved |= _solve(found, speeds)
        curves = [curve.with_points(solved) for curve in curves]
    roots = [root for curve in curves for k in lines for root in curve.roots(k)]
    for _ in range(MAX_CORRECTIONS):
        moving = [root for root in roots if abs(root.shift) > SETTLED * found.values[-1]]
        if not moving:
            break
        solved = _solve(found, np.unique([root.at for root in moving]))
        for root in moving:
            root.correct(solved[root.at].get(root.label), *found.values[[0, -1]].tolist())
    return roots


def _solve(found: Loci, speeds: np.ndarray) -> dict[float, dict[str, float]]:
    """omega^2 by branch at each of some speeds (n,); nothing where there is no solution."""
    beams = [found.beam.replace(gamma=float(speed)) for speed in speeds]
    outcomes = solve_many(beams, modes=found.modes, **found.options)
    return {
        speed: dict(zip(found.labels_at(speed), outcome.omega_squared.tolist(), strict=False))
        if isinstance(outcome, Solution)
        else {}
        for speed, outcome in zip(speeds.tolist(), outcomes, strict=True)
    }


def _curves(found: Loci, branch: Branch) -> Iterator["_Curve"]:
    """The parts of a branch that are among the requested modes."""
    x, y = found.values, branch.omega_squared
    padded = np.isfinite([np.nan, *y, np.nan])
    edges = np.flatnonzero(padded[1:] != padded[:-1])
    crossings = [e for e in found.events if e.kind == "crossing" and branch.label in e.branches]
    for start, stop in edges.reshape(-1, 2).tolist():
        low, high = x[max(start - 1, 0)], x[min(stop, len(x) - 1)]
        curve = _Curve(branch.label, low, high, np.ptp(x), x[start:stop], y[start:stop])
        # Where it enters or leaves the requested modes it crosses the one above them.
        outside = [e for e in crossings if low < e.at < x[start] or x[stop - 1] < e.at < high]
        yield curve.with_points({e.at: {branch.label: e.frequency**2} for e in outside})


@dataclass(frozen=True)
class _Curve:
    """omega^2 of a branch over neighbouring speeds, interpolated."""

    label: str
    low: float  # speeds between which it may be extended
    high: float
    length: float  # of the sweep
    x: np.ndarray  # (n,) speeds
    y: np.ndarray  # (n,) omega^2

    def with_points(self, solved: dict[float, dict[str, float]]) -> "_Curve":
        """The curve with omega^2 at more speeds."""
        more = [
            (speed, branches[self.label])
            for speed, branches in solved.items()
            if self.low < speed < self.high and self.label in branches
        ]
        x, y = np.array([*zip(self.x, self.y, strict=True), *more]).T
        x, first = np.unique(x, return_index=True)
        return replace(self, x=x, y=y[first])

    @cached_property
    def _sampled(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Speeds, omega^2 and the error of its interpolation, (SAMPLES (n - 1) + 1,) each."""
        x, y, n = self.x, self.y, len(self.x)
        s = x[:-1, None] + np.diff(x)[:, None] * np.arange(SAMPLES) / SAMPLES
        if n > max(DEGREES):
            fine, rough = (make_interp_spline(x, y, degree)(s) for degree in DEGREES)
            error = abs(fine - rough).max(axis=1)
        else:
            fine, error = np.interp(s, x, y), np.full(n - 1, np.inf)
        error = np.pad(error, 1, mode="edge")
        error = np.maximum(np.maximum(error[:-2], error[2:]), error[1:-1])
        return (
            np.append(s, x[-1]),
            np.append(fine, self.y[-1]),
            np.append(np.repeat(error, SAMPLES), error[-1]),
        )

    def uncertain(self, lines: range, coarse: float) -> list[float]:
        """Middles of the intervals in which an intersection with a line may be overlooked."""
        step = np.diff(self.x)
        if not len(step):
            return []
        s, omega_squared, error = self._sampled
        halve = step > coarse
        for k in lines:
            G = omega_squared - (k * s) ** 2
            changes, size = np.diff(G >= 0), abs(G)
            sides = np.maximum(size[:-2], size[2:])
            # At a lowest sample the minimum may be deeper, by much less than the rise beside it.
            rise = np.where(np.minimum(size[:-2], size[2:]) >= size[1:-1], sides - size[1:-1], 0.0)
            doubtful = size - np.pad(rise, 1) / 2 <= SAFETY * error
            doubtful &= ~(np.append(changes, False) | np.append(False, changes))
            halve |= doubtful[:-1].reshape(-1, SAMPLES).any(axis=1)
        halve &= step > FINEST * self.length
        return ((self.x[:-1] + self.x[1:]) / 2)[halve].tolist()

    def roots(self, k: int) -> Iterator["_Root"]:
        """The intersections with the line omega = k gamma."""
        if len(self.x) < 2:
            return
        s, omega_squared, _ = self._sampled
        G = omega_squared - (k * s) ** 2
        for i in np.flatnonzero(np.diff(G >= 0)).tolist():
            slope = (G[i + 1] - G[i]) / (s[i + 1] - s[i])
            yield _Root(k, self.label, float(s[i] - G[i] / slope), float(slope))


@dataclass
class _Root:
    """An intersection of a branch with a per-rev line, located by the secant method."""

    per_rev: int
    label: str
    at: float
    slope: float  # of omega^2 - (per_rev gamma)^2
    shift: float = np.inf  # the last correction
    residual: float = np.nan  # before it

    def correct(self, omega_squared: float | None, low: float, high: float) -> None:
        """Correct by omega^2 solved for at the present speed, within low .. high; None ends it."""
        if omega_squared is None:
            self.shift = 0.0
            return
        residual = omega_squared - (self.per_rev * self.at) ** 2
        if np.isfinite(self.shift) and residual != self.residual:
            self.slope = (residual - self.residual) / self.shift
        corrected = min(max(self.at - residual / self.slope, low), high)
        self.at, self.shift, self.residual = corrected, corrected - self.at, residual


def response(solution: Solution, frequency: float, damping: float, x: np.ndarray) -> np.ndarray:
    """Amplitudes (len(x), 2) along and across the beam at x under the force at `frequency`; the
    displacement is the real part of them times exp(i frequency t), over the static deflection.

    Sums the modes of the solution: with shapes phi and poles p, D(omega) = K + 2 i omega gamma G -
    omega^2 M has the inverse sum of phi phi^H / (n (p - omega)) and the same over the conjugate
    modes, whose poles are -conj(p). nan where a mode is unstable: there is no steady response.
    """
    if solution.omega_squared[0] < 0:
        return np.full((len(x), 2), np.nan + 0j)
    beam, omega = solution.beam, solution.frequencies
    nodes, weight = quadrature(beam)
    u, w = np.moveaxis(solution.displacement(nodes), 1, 0)  # (len(nodes), modes) each
    mass = weight @ (abs(u) ** 2 + abs(w) ** 2)
    coriolis = weight @ (w.conj() * u - u.conj() * w)  # phi^H G phi, 0 for real shapes
    along, across = LOADS[solution.problem.plane]
    force = weight @ (along * u.conj() + across * w.conj())  # its work on each shape
    force_conjugate = weight @ (along * u + across * w)  # and on its conjugate
    ratio = np.sqrt(1 - damping**2)
    pole = omega * (ratio + 1j * damping)
    norm = ratio * (2 * omega * mass - 2j * beam.gamma * coriolis).real
    shapes = solution.displacement(x)  # (len(x), 2, modes)
    direct = shapes @ (force / (norm * (pole - frequency)))
    conjugate = shapes.conj() @ (force_conjugate / (norm * (pole.conj() + frequency)))
    return (direct + conjugate) / static_deflection(beam)


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

    solutions: for each speed, None without equilibrium.
    """

    beam: Beam
    per_rev: int
    damping: float
    speeds: np.ndarray
    solutions: tuple[Solution | None, ...]
    resonances: tuple[Resonance, ...]

    @cached_property
    def amplitudes(self) -> np.ndarray:
        """Amplitude (n,) of the tip over the static deflection: the largest distance from rest on
        its ellipse Re (a exp(i p)); nan where there is no equilibrium or no stable one."""
        found = np.full(len(self.speeds), np.nan)
        for k, solution in enumerate(self.solutions):
            if solution is not None:
                tip = response(solution, self.per_rev * self.speeds[k], self.damping, TIP)[0]
                a, b = tip.real, tip.imag
                found[k] = np.sqrt((a @ a + b @ b) / 2 + np.hypot((a @ a - b @ b) / 2, a @ b))
        return found

    def peak(self, resonance: Resonance) -> float:
        """The amplitude of the tip at a resonance."""
        return float(self.amplitudes[np.argmin(abs(self.speeds - resonance.at))])


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
