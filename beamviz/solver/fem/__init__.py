"""Methods on uniform cubic elements: the paper's, by parts or fully planar, and the linear one.

Each assembles the stiffness along and across a straight state; the eigenproblem is shared.
"""

from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam, check_int
from beamviz.errors import InvalidInput
from beamviz.solver import eigen
from beamviz.solver.families import (
    Family,
    Modes,
    Shapes,
    Solved,
    build_solution,
    centrifugal_softening,
    coupled_modes,
    merge,
)
from beamviz.solver.fem import straight
from beamviz.solver.fem.ancf import PlanarBeam
from beamviz.solver.fem.hermite import assemble_band, dense, interpolate
from beamviz.solver.problem import Problem
from beamviz.solver.solution import Solution

PAPER_ELEMENTS = 20
MAX_ELEMENTS = 1000


class Assembled(NamedTuple):
    """A straight state and the matrices of vibration about it, the clamp taken out; N nodes."""

    position: NDArray  # (2N,) r1, r1' of node after node
    iterations: int
    Ka: NDArray  # (2N - 1, 2N - 1) stiffness along the beam, softened
    Kb: NDArray  # (2N - 2, 2N - 2) stiffness across it, softened in the plane of rotation
    m: NDArray  # (2N, 2N) mass matrix of one component, with the clamped coordinates


def solve(beam: Beam, problem: Problem, start: float) -> Solution:
    """Equilibrium and modes on `problem.elements` elements (the paper's 20 by default).

    start: the clock (time.perf_counter) at the call. Raises InvalidInput, NoEquilibrium with the
    limit, and NotConverged.
    """
    elements = PAPER_ELEMENTS if problem.elements is None else problem.elements
    elements = check_int("elements", elements, 1, MAX_ELEMENTS)
    if problem.modes > 2 * elements:
        raise InvalidInput(
            f"modes = {problem.modes}: at most {2 * elements} with elements = {elements}"
        )
    nodes = np.linspace(0.0, 1.0, elements + 1)
    assembled = ASSEMBLERS[problem.method](beam, problem, nodes)
    coupled = problem.gyroscopic and beam.gamma > 0
    modes = (_gyroscopic if coupled else _uncoupled)(assembled, nodes, beam, problem.modes)
    solved = Solved(
        modes,
        dof=len(assembled.Ka) + len(assembled.Kb),
        axial=partial(_axial, nodes, assembled.position),
        iterations=assembled.iterations,
    )
    return build_solution(beam, problem, start, solved, order=3, elements=elements)


def _ancf(beam: Beam, problem: Problem, nodes: NDArray) -> Assembled:
    """Half the coordinates at a time, about the equilibrium of the full residual."""
    model = PlanarBeam.on(nodes, beam, problem)
    root = straight.straight_equilibrium(model)
    q = root.state[::2]
    Ka = _dense(straight.axial(model, q, beam.gamma**2))
    Kb = _dense(straight.bending(model, q, centrifugal_softening(beam, problem)))
    return Assembled(q, root.iterations, Ka[1:, 1:], Kb[2:, 2:], _dense(model.m))


def _ancf_planar(beam: Beam, problem: Problem, nodes: NDArray) -> Assembled:
    """The full planar tangent."""
    model = PlanarBeam.on(nodes, beam, problem)
    root = straight.straight_equilibrium(model)
    K = model.tangent(root.state, beam.gamma**2)
    Ka, Kb = dense(straight.along(K)), dense(straight.across(K))
    return Assembled(root.state[::2], root.iterations, Ka, Kb, _dense(model.m))


def _linear(beam: Beam, problem: Problem, nodes: NDArray) -> Assembled:
    """Linear statics under the load of the reference length, then vibration with its prestress."""
    model, load = PlanarBeam.on(nodes, beam, problem), beam.gamma**2
    rest = model.unstressed[::2]
    m, K = _dense(model.m), _dense(straight.axial(model, rest, 0.0))
    arm = rest + beam.delta * np.tile([1.0, 0.0], len(nodes))
    u = np.zeros_like(rest)
    u[1:] = np.linalg.solve(K[1:, 1:], load * (m @ arm)[1:])
    Kb = _dense(straight.prestressed(model, u, centrifugal_softening(beam, problem)))
    return Assembled(rest + u, 1, (K - load * m)[1:, 1:], Kb[2:, 2:], m)


ASSEMBLERS = {"ancf": _ancf, "ancf-planar": _ancf_planar, "linear": _linear}


def _dense(parts: NDArray) -> NDArray:
    """The sum of symmetric element matrices as a full matrix."""
    return dense(assemble_band(parts))


def _uncoupled(assembled: Assembled, nodes: NDArray, beam: Beam, modes: int) -> Modes:
    """The families apart."""
    m = assembled.m
    stretching, U, _ = eigen.symmetric_modes(assembled.Ka, m[1:, 1:], modes)
    bending, W, _ = eigen.symmetric_modes(assembled.Kb, m[2:, 2:], modes)
    return merge(Family(stretching, _shapes(nodes, U)), Family(bending, _shapes(nodes, W)), modes)


def _gyroscopic(assembled: Assembled, nodes: NDArray, beam: Beam, modes: int) -> Modes:
    """Both families coupled by Coriolis forces."""
    F, shapes = np.linalg.cholesky(assembled.m).T, partial(_shapes, nodes)
    Ka, Kb = assembled.Ka, assembled.Kb
    return coupled_modes(Ka, F[:, 1:], Kb, F[:, 2:], beam.gamma, modes, shapes, shapes)


def _shapes(nodes: NDArray, free: NDArray) -> Shapes:
    """Shapes from the coordinates that the clamp leaves free."""
    clamped = np.zeros((2 * len(nodes) - len(free), free.shape[1]))
    return partial(interpolate, nodes, np.concatenate((clamped, free)))


def _axial(nodes: NDArray, position: NDArray, x: NDArray) -> tuple[NDArray, NDArray]:
    """u(x) and f(x) of the equilibrium."""
    return interpolate(nodes, position, x), interpolate(nodes, position, x, 1)
