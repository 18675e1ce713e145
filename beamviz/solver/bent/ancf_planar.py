"""Bent states by the paper's elements: the full planar residual and tangent (eqs. 17, 40-48).

Newton's method starts from the state that the default method finds, sampled at the nodes, and
converges to that of the elements. The clamp is the removal of its coordinates: r1, r2 and r2' of
the first node; the length of r' there is free.
"""

import time
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import LinearOperator, eigs, splu

from beamviz.beam import Beam
from beamviz.errors import NotConverged
from beamviz.solver.bent.equilibrium import State
from beamviz.solver.bent.modes import oscillating_or_growing, squared
from beamviz.solver.continuation import Root, continue_load, newton
from beamviz.solver.fem import element_count
from beamviz.solver.fem.ancf import PlanarBeam
from beamviz.solver.fem.hermite import element_coordinates, gauss, interpolate
from beamviz.solver.problem import Problem
from beamviz.solver.solution import Equilibrium, Solution, Stats

CLAMPED = (0, 1, 3)  # coordinates of the first node
SMALLEST_SHARE = 1e-3  # of the forces that hold a sampled state, taken away in one step
PER_ELEMENT = 4  # Gauss points for the energy of a mode
TURN = np.array([[0.0, -1.0], [1.0, 0.0]])  # e3 x


@dataclass(frozen=True, eq=False)
class PlanarEquilibrium(Equilibrium):
    """A bent state of the elements."""

    nodes: NDArray
    q: NDArray  # (N, 4) r1, r2, r1', r2' of each node
    state: State  # by the default method, next to it

    def position(self, x: NDArray) -> NDArray:
        """Position (len(x), 2) of the points x, measured from the clamp."""
        return components(self.nodes, self.q, x)

    def slope(self, x: NDArray) -> NDArray:
        """r' (len(x), 2)."""
        return components(self.nodes, self.q, x, 1)

    def stretch(self, x: NDArray) -> NDArray:
        """Stretch f = |r'| (len(x),)."""
        return np.hypot(*self.slope(x).T)

    def angle(self, x: NDArray) -> NDArray:
        """Angle theta [rad] of the beam's axis (len(x),), continuous along the beam."""
        along = np.union1d(np.linspace(0, 1, 20 * len(self.nodes)), x)
        angles = np.unwrap(np.arctan2(*self.slope(along).T[::-1]))
        return np.interp(np.atleast_1d(x), along, angles)


def components(nodes: NDArray, q: NDArray, x: NDArray, derivative: int = 0) -> NDArray:
    """Both components (len(x), 2, ...) of a field with coordinates q (N, 4, ...)."""
    x = np.atleast_1d(np.asarray(x, float))
    parts = (q[:, c::2].reshape(2 * len(nodes), *q.shape[2:]) for c in (0, 1))
    return np.stack([interpolate(nodes, part, x, derivative) for part in parts], axis=1)


class PlanarProblem:
    """The elements of a beam with its loads, as sparse matrices without the clamped coordinates."""

    def __init__(self, beam: Beam, problem: Problem, elements: int):
        self.beam, self.model = (
            beam,
            PlanarBeam.on(np.linspace(0.0, 1.0, elements + 1), beam, problem),
        )
        self.free = np.setdiff1d(np.arange(4 * (elements + 1)), CLAMPED)
        twist = np.einsum("eij,cd->eicjd", self.model.m, TURN).reshape(-1, 8, 8)
        self.G = self.assembled(twist)  # e3 x r against virtual displacements
        self.M = self.assembled(
            np.einsum("eij,cd->eicjd", self.model.m, np.eye(2)).reshape(-1, 8, 8)
        )
        self.euler = beam.spin_up * twist

    def assembled(self, parts: NDArray) -> csc_array:
        """The sum of element matrices (n, 8, 8), sum_e B_e' parts_e B_e, clamped."""
        n = len(parts)
        places = 4 * np.arange(n)[:, None] + np.arange(8)
        rows, columns = np.broadcast_arrays(places[:, :, None], places[:, None, :])
        total = coo_array((parts.ravel(), (rows.ravel(), columns.ravel()))).tocsc()
        return total[self.free][:, self.free]

    def residual(self, q: NDArray) -> NDArray:
        """Elastic, centrifugal and Euler forces (paper, eq. 40)."""
        arm = element_coordinates(q, 4).copy()
        arm[:, [0, 4]] += self.beam.delta
        euler = (self.euler @ arm[..., None])[..., 0]
        total = self.model.residual(q, self.beam.gamma**2)
        np.add.at(total, 4 * np.arange(len(arm))[:, None] + np.arange(8), euler)
        return total[self.free]

    def tangent(self, q: NDArray) -> csc_array:
        """The full planar tangent (paper, eqs. 42-44), with that of the Euler force."""
        q_e = element_coordinates(q, 4)
        stiffness = self.model.stiffness(q_e) - self.beam.gamma**2 * self.model.C
        return self.assembled(stiffness + self.euler)

    def equilibrium(self, guess: NDArray) -> tuple[NDArray, int]:
        """The state next to a guess (N, 4), and the iterations it takes: by continuation as the
        forces that hold the guess are taken away. Raises NotConverged, also where a slope turns
        back: with r1' < 0 at the clamp elements are a beam that is clamped pointing inward."""
        start = guess.ravel()
        holding = self.residual(start)

        def solve_at(share: float, near: NDArray) -> Root | None:
            def increment(q: NDArray) -> NDArray:
                dq = np.zeros_like(q)
                try:
                    left = self.residual(q) - (1 - share) * holding
                    dq[self.free] = -splu(self.tangent(q)).solve(left)
                except RuntimeError:
                    raise np.linalg.LinAlgError from None
                return dq

            found = newton(increment, near)
            if found is None:
                return None
            turned = (found.state.reshape(guess.shape) * guess)[:, 2:].sum(axis=1) <= 0
            return None if turned.any() else found

        try:
            path = continue_load(solve_at, start, 1.0, lambda *_: 1.0, precision=SMALLEST_SHARE)
        except NotConverged:
            raise NotConverged(
                f"{len(self.model.nodes) - 1} elements have no state next to the exact one; use"
                " more elements"
            ) from None
        return path.state.reshape(-1, 4), path.iterations


def solve_planar(
    beam: Beam, problem: Problem, exact: Solution, state: State, start: float
) -> Solution:
    """The modes about the elements' state next to the exact one, a solution of method auto."""
    count = problem.modes
    elements = element_count(problem)
    planar = PlanarProblem(beam, problem, elements)
    nodes, near = planar.model.nodes, exact.equilibrium
    angle, f = near.angle(nodes), near.stretch(nodes)
    slopes = f[:, None] * np.column_stack((np.cos(angle), np.sin(angle)))
    q, iterations = planar.equilibrium(np.hstack((near.position(nodes), slopes)))
    s, free = _modes(planar, q, problem.gyroscopic, count)
    V = np.zeros((q.size, count), free.dtype)
    V[planar.free] = free / np.sqrt(abs((free.conj() * (planar.M @ free)).sum(axis=0)))
    omega_squared = squared(s)
    stable = exact.equilibrium.stable and bool(omega_squared.min() > 0)
    equilibrium = PlanarEquilibrium(stable, iterations, None, nodes, q, state)
    fields = PlanarFields(equilibrium, V.reshape(len(nodes), 4, count))
    errors = abs(omega_squared - exact.omega_squared[:count]) + exact.omega_squared_errors[:count]
    return Solution(
        beam=beam,
        problem=problem,
        equilibrium=equilibrium,
        stats=Stats(len(planar.free), time.perf_counter() - start, problem.method, elements, 3),
        omega_squared=omega_squared,
        estimate_errors=partial(np.array, errors),
        bending_energy_fraction=fields.across_fraction(beam),
        fields=fields,
        spin_up_growth=s.real if beam.spin_up else None,
    )


@dataclass(frozen=True, eq=False)
class PlanarFields:
    """Displacements along and across the bent beam as functions of x."""

    equilibrium: PlanarEquilibrium
    V: NDArray  # (N, 4, modes)

    def __call__(self, x: NDArray) -> NDArray:
        """Displacements (len(x), 2, modes)."""
        d = components(self.equilibrium.nodes, self.V, x)
        theta = self.equilibrium.angle(x)[:, None]
        c, s = np.cos(theta), np.sin(theta)
        return np.stack((c * d[:, 0] + s * d[:, 1], c * d[:, 1] - s * d[:, 0]), axis=1)

    def across_fraction(self, beam: Beam) -> NDArray:
        """Share (modes,) of the kinetic energy across the beam."""
        points, weights = gauss(2 * PER_ELEMENT - 1)
        nodes = self.equilibrium.nodes
        lengths = np.diff(nodes)[:, None]
        x = np.append((nodes[:-1, None] + lengths * points).ravel(), beam.beta)
        mass = np.append((lengths * weights).ravel(), beam.alpha)
        energy = np.einsum("x,xck->ck", mass, abs(self(x)) ** 2)
        return energy[1] / energy.sum(axis=0)


def _modes(
    planar: PlanarProblem, q: NDArray, gyroscopic: bool, count: int
) -> tuple[NDArray, NDArray]:
    """s and vectors of the lowest modes: the largest eigenvalues of the inverse problem."""
    n, rng = len(planar.free), np.random.default_rng(0)
    M, solve = planar.M, splu(planar.tangent(q.ravel())).solve
    start = rng.standard_normal(2 * n)
    if not (gyroscopic and planar.beam.gamma):
        inverse = LinearOperator((n, n), lambda v: solve(M @ v), dtype=float)
        nu, V = eigs(inverse, min(count + 2, n - 2), v0=start[:n])
        s = oscillating_or_growing(1j * np.sqrt(1 / nu))
        chosen = np.argsort(abs(s), kind="stable")[:count]
        V = V if planar.beam.spin_up else V.real
    else:
        C = 2 * planar.beam.gamma * planar.G

        def inverse_pair(v: NDArray) -> NDArray:
            return np.append(-solve(C @ v[:n] + M @ v[n:]), v[:n])

        operator = LinearOperator((2 * n, 2 * n), inverse_pair, dtype=float)
        nu, V = eigs(operator, min(2 * count + 6, 2 * n - 2), v0=start)
        s, V = 1 / nu, V[:n]
        upward = np.flatnonzero(oscillating_or_growing(s) == s)
        chosen = upward[np.argsort(abs(s[upward]), kind="stable")[:count]]
    s, V = s[chosen], V[:, chosen]
    order = np.lexsort((-s.real, s.imag))
    return s[order], V[:, order]
