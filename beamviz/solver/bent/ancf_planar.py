"""Bent states by the paper's elements: the full planar residual and tangent (eqs. 17, 40-48).

Newton's method starts from the state that the default method finds, sampled at the nodes, and
converges to that of the elements.
"""

from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import splu

from beamviz.beam import Beam
from beamviz.errors import NotConverged
from beamviz.mechanics.cubic_elements import TURN, CubicElements, element_coordinates, interpolate
from beamviz.solver.bent.beam import corotational_components
from beamviz.solver.continuation import continue_load, newton_at
from beamviz.solver.loads import Loads
from beamviz.solver.pencil import lowest_modes
from beamviz.solver.pencil.matrices import Pencil
from beamviz.solver.problem import Problem
from beamviz.solver.quadrature import quadrature
from beamviz.solver.solution import Equilibrium, Solution, Stats
from beamviz.solver.stability import status_of
from beamviz.space.spans import ends_of_spans

CLAMPED = (0, 1, 3)  # coordinates of the first node
ENERGY_POINTS = 160  # of the quadrature of the kinetic energy of modes, on either side of the mass
LARGEST_STEP = 1.0  # of a coordinate, in one iteration
SMALLEST_SHARE = 1e-3  # of the forces that hold a sampled state, taken away in one step


def components(nodes: NDArray, q: NDArray, x: NDArray, derivative: int = 0) -> NDArray:
    """Both components (len(x), 2, ...) of a field with coordinates q (N, 4, ...)."""
    parts = (q[:, c::2].reshape(2 * len(nodes), *q.shape[2:]) for c in (0, 1))
    return np.stack([interpolate(nodes, part, x, derivative) for part in parts], axis=1)


class PlanarProblem:
    """The elements of a beam with its loads, as sparse matrices without the clamped coordinates."""

    def __init__(self, beam: Beam, problem: Problem, elements: int):
        self.beam = beam
        self.model = CubicElements(np.linspace(0.0, 1.0, elements + 1), beam, problem.theory)
        self.free = np.setdiff1d(np.arange(4 * (elements + 1)), CLAMPED)
        self.G, self.M = (self.assembled(self.model.planar(part)) for part in (TURN, np.eye(2)))

    def assembled(self, parts: NDArray) -> csc_array:
        """The sum of element matrices (n, 8, 8), sum_e B_e' parts_e B_e, clamped."""
        n = len(parts)
        places = 4 * np.arange(n)[:, None] + np.arange(8)
        rows, columns = np.broadcast_arrays(places[:, :, None], places[:, None, :])
        total = coo_array((parts.ravel(), (rows.ravel(), columns.ravel()))).tocsc()
        return total[self.free][:, self.free]

    def residual(self, q: NDArray) -> NDArray:
        """Elastic, centrifugal and Euler forces (paper, eq. 40)."""
        return self.model.residual(q, self.beam.gamma**2)[self.free]

    def tangent(self, q: NDArray) -> csc_array:
        """The full planar tangent (paper, eqs. 42-44), with that of the Euler force."""
        stiffness = self.model.stiffness(element_coordinates(q, 4))
        return self.assembled(stiffness - self.model.field(self.beam.gamma**2))

    def equilibrium(self, guess: NDArray) -> tuple[NDArray, int]:
        """The state next to a guess (N, 4), and the iterations it takes: by continuation as the
        forces that hold the guess are taken away. Raises NotConverged, also where a slope turns
        back: with r1' < 0 at the clamp elements are a beam that is clamped pointing inward."""
        start = guess.ravel()
        holding = self.residual(start)

        def increment(share: float, q: NDArray) -> NDArray:
            dq = np.zeros_like(q)
            try:
                left = self.residual(q) - (1 - share) * holding
                dq[self.free] = -splu(self.tangent(q)).solve(left)
            except RuntimeError:
                raise np.linalg.LinAlgError from None
            if not abs(dq).max() <= LARGEST_STEP:  # it would lead to another state
                raise np.linalg.LinAlgError
            return dq

        def forward(_: float, q: NDArray) -> float:
            return float(((q.reshape(guess.shape) * guess)[:, 2:].sum(axis=1) > 0).all())

        try:
            path = continue_load(
                newton_at(increment), start, 1.0, forward, precision=SMALLEST_SHARE
            )
        except NotConverged:
            raise NotConverged(
                f"{len(self.model.nodes) - 1} elements have no state next to the converged one; use"
                " more elements"
            ) from None
        return path.state.reshape(-1, 4), path.iterations


def solve_planar(beam: Beam, problem: Problem, converged: Solution) -> Solution:
    """The modes about the elements' state next to the converged one, a solution of method auto."""
    count, elements = problem.modes, problem.resolution
    planar = PlanarProblem(beam, problem, elements)
    nodes = planar.model.nodes
    position, f, angle = converged.equilibrium.curve(nodes)
    slopes = f[:, None] * np.column_stack((np.cos(angle), np.sin(angle)))
    q, iterations = planar.equilibrium(np.hstack((position, slopes)))
    C = 2 * beam.gamma * planar.G if problem.gyroscopic and beam.gamma else None
    modes = lowest_modes(Pencil(planar.tangent(q.ravel()), planar.M, C, symmetric=False), count)
    s, free = modes.s, modes.V
    if not (beam.spin_up or problem.gyroscopic):
        free = free.real
    V = np.zeros((q.size, count), free.dtype)
    V[planar.free] = free / np.sqrt(abs((free.conj() * (planar.M @ free)).sum(axis=0)))
    fields = partial(_fields, nodes, q, V.reshape(len(nodes), 4, count))
    errors = abs(s**2 - converged.s[:count] ** 2) + converged.omega_squared_errors[:count]
    breaks = np.union1d(nodes, ends_of_spans(beam))
    loads = Loads(beam, problem.chordwise, breaks, partial(_curve, nodes, q))
    equilibrium = Equilibrium(
        status_of(s if modes.all_s is None else modes.all_s),
        iterations,
        loads,
        converged.equilibrium.bent_state,
    )
    stats = Stats(len(planar.free), problem.method, elements, 3)
    x, mass = quadrature(beam, ENERGY_POINTS)
    along, across = np.einsum("x,xck->ck", mass, abs(fields(x)) ** 2)
    return Solution(
        beam=beam,
        problem=problem,
        equilibrium=equilibrium,
        stats=stats,
        s=s,
        estimate_errors=partial(np.array, errors),
        bending_energy_fraction=across / (along + across),
        fields=fields,
    )


def _curve(nodes: NDArray, q: NDArray, x: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Position, stretch and angle of a state q (N, 4): r1, r2, r1', r2' of each node."""
    along = np.union1d(np.linspace(0, 1, 20 * len(nodes)), x)
    angles = np.unwrap(np.arctan2(*components(nodes, q, along, 1).T[::-1]))
    stretch = np.hypot(*components(nodes, q, x, 1).T)
    return components(nodes, q, x), stretch, np.interp(x, along, angles)


def _fields(nodes: NDArray, q: NDArray, V: NDArray, x: NDArray) -> NDArray:
    """Displacements (len(x), 2, modes) along and across the bent beam; V (N, 4, modes)."""
    moved = components(nodes, V, x)
    return corotational_components(moved[:, 0], moved[:, 1], _curve(nodes, q, x)[2])
