"""The motion by the classical linear theory, without stiffening, for comparison.

Bending does not draw the tip inward, so that the centrifugal force only softens. With the modes at
rest, u = sum a_j psi_j along and w = sum b_k phi_k across the beam, of unit modal mass,

    b_k" + 2 zeta omega_k b_k' + (omega_k^2 - gamma^2) b_k
        + sum_j G_kj (2 gamma a_j' + gamma' a_j) + gamma' int rho phi_k (x + delta) dx = F phi_k,
    a_j" + 2 zeta omega_j a_j' + (omega_j^2 - gamma^2) a_j
        - sum_k G_kj (2 gamma b_k' + gamma' b_k) = gamma^2 int rho psi_j (x + delta) dx,

G_kj = int rho phi_k psi_j dx, rho = 1 + alpha Dirac(x - beta). From the lowest omega_k on, such a
beam diverges (Kane, Ryan & Banerjee 1987).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beamviz.beam import Beam
from beamviz.dynamics.drives import Hub, Ramp, Samples
from beamviz.dynamics.problem import MotionProblem
from beamviz.errors import InvalidInput, NotConverged
from beamviz.mechanics.cubic_elements import gauss
from beamviz.solver import Solution, solve

MODES, HIGHEST = 8, 250.0  # of the lowest, and their highest frequency: those above move a
# plucked tip by less than 1e-4 L
DIVERGED = 1.0  # [L] displacement of the tip at which a theory of small ones has failed
QUADRATURE = 40  # Gauss points on each side of the mass
RELATIVE = 1e-5  # tolerance of the integration; the absolute one is a part of that of the tip
ABSOLUTE = 1e-2


@dataclass(frozen=True, eq=False)
class LinearMotion:
    """A motion by the linear theory, until it ends or diverges."""

    beam: Beam
    t: NDArray  # (n,) times [T*]
    gamma: NDArray  # (n,) speed
    angle: NDArray  # (n,) of the hub [rad]
    tip: NDArray  # (n, 2) position of the tip from the clamp [L]
    parts: tuple["LinearPart", ...] = field(repr=False)

    def position(self, t: ArrayLike, x: ArrayLike) -> NDArray:
        """Position (len(t), len(x), 2) of the points x at times t, from the clamp."""
        t, x = np.atleast_1d(np.asarray(t, float)), np.asarray(x, float)
        positions, before = np.zeros((len(t), len(x), 2)), -1.0
        for part in self.parts:
            inside = (before < t) & (t <= part.end)
            if inside.any():
                c = part.solution(t[inside])[: part.modes.count]
                positions[inside] = np.einsum("kt,kxc->txc", c, part.modes.shapes(x))
            before = part.end
        positions[..., 0] += x
        return positions


class LinearPart(NamedTuple):
    """The motion between two times at which the mass docks or is released, or the speed has a
    corner."""

    modes: "RestModes"
    end: float  # the last time [T*]
    solution: Callable[[NDArray], NDArray]  # times (k,) -> amplitudes and rates (2 modes, k)


class RestModes:
    """The modes of a beam at rest, of unit modal mass."""

    def __init__(self, beam: Beam, options: Mapping[str, Any]):
        still = beam.replace(gamma=0.0)
        self.beam = beam
        self.solution: Solution = solve(still, modes=MODES, **options)
        self.omega = self.solution.frequencies[self.solution.frequencies < HIGHEST]
        self.count = len(self.omega)
        points, weights = gauss(2 * QUADRATURE - 1)
        ends = sorted({0.0, beam.beta, 1.0})
        x = [a + (b - a) * points for a, b in pairwise(ends)]
        along = [(b - a) * weights for a, b in pairwise(ends)]
        # A quadrature over the mass of the beam: (m,) each, of which the body is the last.
        self.x = np.append(np.concatenate(x), beam.beta)
        self.weights = np.append(np.concatenate(along), beam.alpha)
        self.scale = np.ones(self.count)
        values = self.shapes(self.x)
        self.scale = 1 / np.sqrt((values**2).sum(axis=2) @ self.weights)
        self.values = self.shapes(self.x)  # (k, m, 2)
        u, w = self.values[..., 0] * self.weights, self.values[..., 1]
        self.G = w @ u.T  # (k, j): coupling of transverse motion in mode k and axial in mode j
        arm = self.x + beam.delta
        self.axial, self.transverse = u @ arm, (w * self.weights) @ arm

    def shapes(self, x: NDArray) -> NDArray:
        """Displacements (k, len(x), 2)."""
        shapes = np.stack([self.solution.shape(k, x).real for k in range(self.count)])
        return self.scale[:, None, None] * shapes

    def rates(self, gamma: float, spin: float, damping: float, y: NDArray) -> NDArray:
        """Derivatives of amplitudes and rates (2 k,)."""
        c, v = np.split(y, 2)
        force = -2 * damping * self.omega * v - (self.omega**2 - gamma**2) * c
        moved = 2 * gamma * v + spin * c
        force += self.G.T @ moved - self.G @ moved
        return np.append(v, force + gamma**2 * self.axial - spin * self.transverse)

    def held(self, gamma: float, force: float, at: float) -> NDArray:
        """Amplitudes (k,) of the equilibrium under a force across the beam at a point."""
        load = gamma**2 * self.axial + force * self.shapes(np.array([at]))[:, 0, 1]
        return load / (self.omega**2 - gamma**2)

    def taken_over(self, before: "RestModes", y: NDArray, docking: tuple[float, float]) -> NDArray:
        """Amplitudes and rates (2 k,) after a body has docked with the velocity `docking` in the
        frame of the hub, or was released: displacements and momentum are kept."""
        c, v = np.split(y, 2)
        caught = self.beam.alpha > before.beam.alpha
        weights = self.weights.copy()
        displacement = np.einsum("k,kxc->xc", c, before.shapes(self.x))
        velocity = np.einsum("k,kxc->xc", v, before.shapes(self.x))
        kept = np.einsum("kxc,xc,x->k", self.values, displacement, weights)
        if caught:
            velocity[-1] = docking
        return np.append(kept, np.einsum("kxc,xc,x->k", self.values, velocity, weights))


def motion_without_stiffening(beam: Beam, until: float, **options: Any) -> LinearMotion:
    """The motion of a beam by the classical linear theory; arguments as in `motion`, without a
    start in modes, a hub of inertia, and choices of methods. It ends early, where the tip is
    displaced by DIVERGED. Raises InvalidInput and NotConverged."""
    problem = MotionProblem.of(beam=beam, until=until, **options)
    if not beam.is_uniform:
        raise InvalidInput(
            "the motion without stiffening: the beam has to be uniform and clamped, with at most"
            " one concentrated mass"
        )
    drive = problem.drive
    if problem.start or isinstance(drive, Hub) or problem.studied:
        raise InvalidInput(
            "the motion without stiffening takes a prescribed speed, no start in modes, and no"
            " choice of method, integrator or step"
        )
    parts = tuple(integrated(problem, drive))
    end = parts[-1].end
    t = np.append(problem.times[problem.times < end], end)
    gamma, angle = drive(t)[0], drive.angle(t)
    motion = LinearMotion(beam, t, gamma, angle, np.zeros((0, 2)), parts)
    return LinearMotion(beam, t, gamma, angle, motion.position(t, [1.0])[:, 0], parts)


def constant(y: NDArray, t: NDArray) -> NDArray:
    """The same y (n,) at all times t (k,): (n, k)."""
    return np.tile(y[:, None], len(t))


def integrated(problem: MotionProblem, drive: Ramp | Samples) -> list[LinearPart]:
    """The parts of a motion, until it diverges."""
    from scipy.integrate import solve_ivp

    parts: list[LinearPart] = []
    t, y = 0.0, np.zeros(0)
    modes: RestModes | None = None
    for part in problem.parts:
        beam = problem.beam if part.with_mass else problem.beam.replace(alpha=0.0)
        before = modes
        modes = RestModes(beam, {"strain": problem.strain})
        if before is None:
            still = modes.held(problem.first_speed, problem.release, problem.release_at)
            y = np.append(still, np.zeros_like(still))
        else:
            y = modes.taken_over(before, y, problem.body_velocity)
        at_tip = modes.shapes(np.ones(1))[:, 0]  # (k, 2)

        def rates(t: float, y: NDArray, modes: RestModes = modes) -> NDArray:
            (gamma,), (spin,) = drive(np.array([t]))
            problem.report(t)
            return modes.rates(gamma, spin, problem.damping, y)

        def left(t: float, y: NDArray, at_tip: NDArray = at_tip) -> float:
            return DIVERGED - float(np.linalg.norm(y[: len(at_tip)] @ at_tip))

        left.terminal = True  # type: ignore[attr-defined]
        stops = [*(b for b in drive.breaks if t < b < part.end), part.end]
        for stop in stops:
            if stop <= t:
                continue
            if left(t, y) <= 0:
                return parts or [LinearPart(modes, 0.0, partial(constant, y))]
            answer = solve_ivp(
                *(rates, (t, stop), y, "DOP853"),
                dense_output=True,
                events=left,
                rtol=RELATIVE,
                atol=ABSOLUTE * problem.tolerance,
            )
            if not answer.success:
                raise NotConverged(f"t = {answer.t[-1]:.4g}: the linear theory: {answer.message}")
            t, y = float(answer.t[-1]), answer.y[:, -1]
            parts.append(LinearPart(modes, t, answer.sol))
            if answer.status == 1:
                return parts
    return parts
