"""Uniform cubic elements: the paper's method, split for a straight beam or fully planar, and
the linear prestressed one.

All assemble two stiffnesses about the straight state and share the rest.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam, check_int
from beamviz.errors import InvalidInput
from beamviz.solver import eigen
from beamviz.solver.eigen import gyroscopic_modes
from beamviz.solver.fem import assembly, planar
from beamviz.solver.fem import straight as cubic
from beamviz.solver.fem.equilibrium import Equilibrium, straight_equilibrium
from beamviz.solver.fem.hermite import interpolate, uniform
from beamviz.solver.problem import Problem

PAPER_ELEMENTS = 20
MAX_ELEMENTS = 1000


class Assembled(NamedTuple):
    """Equilibrium and what vibrates about it; N = elements + 1 nodes."""

    nodes: NDArray  # (N,)
    position: NDArray  # (2N,) r1, r1' of node after node
    iterations: int
    Ka: NDArray  # (2N - 1, 2N - 1) stiffness along the beam, softening included
    Kb: NDArray  # (2N - 2, 2N - 2) stiffness across it
    m: NDArray  # (2N, 2N) mass matrix of one component


Assemble = Callable[[Beam, Problem, int], Assembled]


class ElementModes(NamedTuple):
    """The lowest modes: omega^2, shapes as value and slope at each node."""

    assembled: Assembled
    omega_squared: NDArray  # (modes,)
    bending_energy_fraction: NDArray  # (modes,)
    along: NDArray  # (2N, modes), complex with Coriolis as is the next
    across: NDArray  # (2N, modes)


def split(beam: Beam, problem: Problem, elements: int) -> Assembled:
    """Half the coordinates twice (cubic.py), about the equilibrium of the full residual."""
    model, state = planar_equilibrium(beam, problem, elements)
    q = state.q[::2]
    cubics = cubic.Cubics.between(model.elements.nodes, beam, problem.strain_law)
    load = beam.gamma**2
    softening = load if problem.chordwise else 0.0
    Ka = assembly.dense(assembly.band(cubics.along(q, load)))
    Kb = assembly.dense(assembly.band(cubics.across(q, softening, problem.curvature_measure)))
    return _assembled(model, state, Ka, Kb)


def full(beam: Beam, problem: Problem, elements: int) -> Assembled:
    """The full planar tangent (planar.py)."""
    model, state = planar_equilibrium(beam, problem, elements)
    K = model.tangent(state.q, beam.gamma**2)
    Ka, Kb = assembly.dense(planar.along(K)), assembly.dense(planar.across(K))
    return _assembled(model, state, Ka, Kb)


def linear(beam: Beam, problem: Problem, elements: int) -> Assembled:
    """Linear statics under the load of the reference length, then vibration with its prestress.

    The bending elements are the same; the tension is mu^2 u' of the linear bar.
    """
    nodes = uniform(elements)
    cubics = cubic.Cubics.between(nodes, beam, problem.strain_law)
    load = beam.gamma**2
    softening = load if problem.chordwise else 0.0
    rest = np.column_stack((nodes, np.ones_like(nodes))).ravel()
    m = assembly.dense(assembly.band(cubics.m))
    K = assembly.dense(assembly.band(cubics.along(rest, 0.0)))
    arm = rest + beam.delta * np.tile([1.0, 0.0], len(nodes))
    u = np.zeros_like(rest)
    u[1:] = np.linalg.solve(K[1:, 1:], load * (m @ arm)[1:])
    Kb = assembly.dense(assembly.band(cubics.prestressed(u, softening)))
    return Assembled(nodes, rest + u, 1, (K - load * m)[1:, 1:], Kb[2:, 2:], m)


def planar_equilibrium(
    beam: Beam, problem: Problem, elements: int
) -> tuple[planar.Model, Equilibrium]:
    """The beam on its elements and the straight state of the full residual."""
    plane = "chordwise" if problem.chordwise else "flapwise"
    model = planar.model(
        beam, uniform(elements), problem.strain_law, problem.curvature_measure, plane
    )
    return model, straight_equilibrium(model)


def _assembled(model: planar.Model, state: Equilibrium, Ka: NDArray, Kb: NDArray) -> Assembled:
    """The matrices over the free coordinates: the clamp holds r1, r2 and r2' at x = 0."""
    m = assembly.dense(assembly.band(model.m))
    q, nodes = state.q[::2], model.elements.nodes
    return Assembled(nodes, q, state.iterations, Ka[1:, 1:], Kb[2:, 2:], m)


def solve_elements(
    beam: Beam, modes: int, problem: Problem, assemble: Assemble, elements: int | None
) -> ElementModes:
    """Equilibrium and the lowest `modes` modes on uniform elements, by `split` or `full`.

    Raises InvalidInput, NoEquilibrium with the limit, NotConverged.
    """
    elements = check_int(
        "elements", PAPER_ELEMENTS if elements is None else elements, 1, MAX_ELEMENTS
    )
    if modes > 2 * elements:
        raise InvalidInput(f"modes = {modes}: at most {2 * elements} with elements = {elements}")
    assembled = assemble(beam, problem, elements)
    coupled = problem.gyroscopic and beam.gamma > 0
    omega_squared, along, across = (_coupled if coupled else _uncoupled)(assembled, beam, modes)
    fractions = ((assembled.m @ across) * across.conj()).sum(axis=0).real
    return ElementModes(assembled, omega_squared, fractions, along, across)


def _uncoupled(assembled: Assembled, beam: Beam, modes: int) -> tuple[NDArray, NDArray, NDArray]:
    """omega^2 and shapes (2N, modes) along and across, the families apart."""
    m = assembled.m
    bending, V, _ = eigen.symmetric_modes(assembled.Kb, m[2:, 2:], modes)
    stretching, U, _ = eigen.symmetric_modes(assembled.Ka, m[1:, 1:], modes)
    omega_squared = np.concatenate((bending, stretching))
    picks = omega_squared.argsort()[:modes]
    shapes = np.zeros((2, len(m), 2 * modes))
    shapes[1, 2:, :modes], shapes[0, 1:, modes:] = V, U
    return omega_squared[picks], *shapes[:, :, picks]


def _coupled(assembled: Assembled, beam: Beam, modes: int) -> tuple[NDArray, NDArray, NDArray]:
    """As `_uncoupled`, with Coriolis forces."""
    m = assembled.m
    F = np.linalg.cholesky(m).T
    omega_squared, U, V, *_ = gyroscopic_modes(
        assembled.Ka, F[:, 1:], assembled.Kb, F[:, 2:], beam.gamma, modes
    )
    shapes = np.zeros((2, len(m), modes), complex)
    shapes[0, 1:], shapes[1, 2:] = U, V
    return omega_squared, *shapes


def displacement(found: ElementModes, x: NDArray) -> NDArray:
    """Fields (len(x), 2, modes) along and across the beam."""
    nodes = found.assembled.nodes
    return np.stack(
        [_planar(nodes, u, w, x) for u, w in zip(found.along.T, found.across.T, strict=True)], -1
    )


def axial(found: ElementModes, x: NDArray) -> tuple[NDArray, NDArray]:
    """u(x) and f(x) of the equilibrium."""
    nodes, r = found.assembled.nodes, found.assembled.position
    q = np.zeros(2 * len(r))
    q[::2] = r
    return interpolate(nodes, q, x)[:, 0], interpolate(nodes, q, x, 1)[:, 0]


def _planar(nodes: NDArray, u: NDArray, w: NDArray, x: NDArray) -> NDArray:
    """(len(x), 2) of coordinates along and across, value and slope of node after node."""
    q = np.zeros(2 * len(u), np.result_type(u, w))
    q[::2], q[1::2] = u, w
    return interpolate(nodes, q, x)
