"""Methods on cubic elements: the paper's, and the linear one.

Each assembles the stiffness along and across a straight state; the eigenproblem is shared. At such
a state the full planar tangent couples nothing along the beam to anything across it: its even
coordinates (r1, r1' of each node) stretch, its odd ones (r2, r2') bend. In space those that bend
out of the plane of rotation follow these.
"""

import math
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.mechanics.cubic_elements import (
    CubicElements,
    assemble_band,
    dense,
    element_coordinates,
    interpolate,
    nodes_of,
)
from beamviz.mechanics.straight_properties import stack_of
from beamviz.mechanics.straight_residual import rotary_inertia
from beamviz.solver import constitutive
from beamviz.solver.continuation import Root, continue_load, newton_at
from beamviz.solver.families import Shapes, modes_of_matrices, no_equilibrium, solution_of
from beamviz.solver.problem import Problem
from beamviz.solver.solution import Solution, straight
from beamviz.solver.stability import may_buckle

MIN_CARRIED = 0.5  # share of the force at the end of a law that the load must account for
LAW_END = 0.1  # a limit at a stretch this close to the end of a force law is attributed to it
# Parts of a planar band that act along and across a straight beam: r1, r1' and r2, r2' of each
# node. The clamp takes r1 out of the first, r2 and r2' out of the second.
ALONG, ACROSS = np.s_[::2, ::2], np.s_[::2, 1::2]


class Assembled(NamedTuple):
    """A straight state of N nodes and its stiffness, without softening, the clamped coordinates
    taken out."""

    position: NDArray  # (2 N,) r1, r1' of each node
    iterations: int
    Ka: NDArray  # (2 N - 1, 2 N - 1) along the beam
    # (c (2 N - 2), c (2 N - 2)) across it, of c components; 2 N - 1 where the root is not clamped
    Kb: NDArray


def solve(beam: Beam, problem: Problem) -> Solution:
    """Equilibrium and modes, or an error of `beamviz.solve`."""
    nodes = nodes_of(beam, problem.resolution)
    model = CubicElements(nodes, beam, problem.theory)
    try:
        position, iterations, Ka, Kb = ASSEMBLERS[problem.method](model)
    except NotConverged as error:
        raise no_equilibrium(beam, problem) or error from None
    F, shapes = np.linalg.cholesky(_dense(model.m)).T, partial(_shapes, nodes)
    components = len(problem.components_in_plane)
    Fa, F_across = F[:, 1:], F[:, -len(Kb) // components :]
    Fb = np.kron(np.eye(components), F_across)
    if components > 1:
        Fa = np.vstack((Fa, np.zeros_like(Fa)))
        if problem.softening:
            inside = len(F_across.T)
            Kb[:inside, :inside] -= beam.gamma**2 * F_across.T @ F_across
    if any(any(mass.inertia) for mass in beam.masses):
        Fa, Fb, Kb = with_rotary_inertia(model, position, Fa, Fb, Kb, problem)
    modes = modes_of_matrices(beam, problem, (Ka, Kb), (Fa, Fb), (shapes, shapes))
    size, curve = (len(Ka) + len(Kb), len(nodes) - 1, 3), partial(_curve, nodes, position)
    return solution_of(beam, problem, modes, size, curve, iterations, nodes)


def with_rotary_inertia(
    model: CubicElements, position: NDArray, Fa: NDArray, Fb: NDArray, Kb: NDArray, problem: Problem
) -> tuple[NDArray, NDArray, NDArray]:
    """Factors of the mass matrices and the stiffness across the beam with bodies that turn: as in
    `mechanics.straight.add_rotary_inertia`."""
    beam, nodes = model.beam, model.nodes
    J, stiffness = rotary_inertia(stack_of([beam]), problem)  # (masses, c, c)
    if problem.chordwise:
        stiffness = stiffness + J
    at = np.array([mass.beta for mass in beam.masses])
    f = 1.0 if problem.rigid_tension else interpolate(nodes, position, at, 1)[:, None]
    components = J.shape[-1]
    unknowns = Fb.shape[1] // components
    rows = interpolate(nodes, np.eye(2 * len(nodes)), at, 1)[:, -unknowns:] / f  # theta = w' / f
    angles = np.einsum("mu,cd->mcdu", rows, np.eye(components))
    angles = angles.reshape(len(at), components, -1)  # (masses, c, unknowns)
    Kb = Kb + beam.gamma**2 * np.einsum("mcu,mcd,mdv->uv", angles, stiffness, angles)
    values, axes = np.linalg.eigh(J)
    turning = (np.sqrt(np.maximum(values, 0.0))[..., None] * (axes.mT @ angles)).reshape(
        -1, Fb.shape[1]
    )
    still = np.zeros((len(turning), Fa.shape[1]))
    return np.vstack((Fa, still)), np.vstack((Fb, turning)), Kb


def _across(model: CubicElements, q: NDArray, tension: NDArray) -> NDArray:
    """The stiffness of bending under a tension (n, p), of all components, without the clamped
    coordinates: of each r2 of the first node, and its slope, or the root spring on that."""
    if not model.in_space:
        return _held(model, _dense(bending(model, q, model.EI, tension)), q[1])
    inside, coupling, outside = model.EI_in_space
    no_tension = np.zeros_like(tension)
    Kv, Kw = (
        _held(model, _dense(bending(model, q, EI, tension)), q[1]) for EI in (inside, outside)
    )
    Kvw = _dense(bending(model, q, coupling, no_tension))[-len(Kv) :, -len(Kv) :]
    return np.block([[Kv, Kvw], [Kvw.T, Kw]])


def _held(model: CubicElements, Kb: NDArray, f: float) -> NDArray:
    """The stiffness across the beam without the clamped coordinates: r2 of the first node, and its
    slope, or the root spring on that. f: stretch at the root."""
    if model.beam.root == math.inf:
        return Kb[2:, 2:]
    Kb[1, 1] += model.beam.root / f**2
    return Kb[1:, 1:]


def _ancf(model: CubicElements) -> Assembled:
    """The stiffness of stretching and that of bending, integrated separately, about the equilibrium
    of the full residual."""
    root = straight_equilibrium(model)
    q = root.state[::2]
    tension = model.beam.mu**2 * model.EA * model.law.force(gradient(model, q))
    Ka = _dense(axial(model, q))
    return Assembled(q, root.iterations, Ka[1:, 1:], _across(model, q, tension))


def _linear(model: CubicElements) -> Assembled:
    """Linear statics under the load of the reference length, then vibration with its prestress."""
    rest, load = model.unstressed[::2], model.beam.gamma**2
    m, K = _dense(model.m), _dense(axial(model, rest))
    arm = rest + model.beam.delta * np.tile([1.0, 0.0], len(model.nodes))
    u = np.zeros_like(rest)
    u[1:] = np.linalg.solve(K[1:, 1:], load * (m @ arm)[1:])
    tension = model.beam.mu**2 * model.EA * gradient(model, u)
    return Assembled(rest + u, 1, K[1:, 1:], _across(model, rest, tension))


ASSEMBLERS = {"ancf": _ancf, "linear": _linear}


def _dense(parts: NDArray) -> NDArray:
    """The sum of symmetric element matrices as a full matrix."""
    return dense(assemble_band(parts))


def _curve(nodes: NDArray, position: NDArray, x: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Position, stretch and angle of the straight state."""
    return straight(*(interpolate(nodes, position, x, derivative) for derivative in (0, 1)))


def _shapes(nodes: NDArray, free: NDArray) -> Shapes:
    """Shapes from the coordinates that the clamp leaves free."""
    if len(free) > 2 * len(nodes):  # of both planes
        in_plane, out_of_plane = (_shapes(nodes, part) for part in np.split(free, 2))
        return partial(_both, in_plane, out_of_plane)
    clamped = np.zeros((2 * len(nodes) - len(free), free.shape[1]))
    return partial(interpolate, nodes, np.concatenate((clamped, free)))


def _both(in_plane: Shapes, out_of_plane: Shapes, x: NDArray) -> NDArray:
    """Shapes (len(x), 2, modes) of both planes."""
    return np.stack((in_plane(x), out_of_plane(x)), axis=1)


def straight_equilibrium(model: CubicElements) -> Root:
    """The straight state (paper, eq. 40), followed by Newton-Raphson from rest to the beam's gamma.
    Returns its planar coordinates and the number of iterations; it may be unstable (delta < 0).
    Raises NoEquilibrium with the limit in gamma, and NotConverged."""

    def increment(load: float, q: NDArray) -> NDArray:
        dq = np.zeros_like(q)
        dq[2::2] = -_solve_along(model, load, q, model.residual(q, load)[2::2])
        return dq

    load = model.beam.gamma**2
    margins = partial(straight_margins, model)
    path = continue_load(newton_at(increment), model.unstressed, load, margins)
    if path.limit is not None:
        raise _no_equilibrium(model, path.limit, path.state)
    if not may_buckle(model.beam):
        try:
            cholesky_banded(model.tangent(path.state, load)[ACROSS][:, 2:], lower=True)
        except np.linalg.LinAlgError:
            raise _overshoot(model, load, path.state) from None
    return path


def straight_margins(model: CubicElements, load: float, q: NDArray) -> NDArray:
    """Distances (3,) of a straight state from the end of its branch, 1 at rest, where one of them
    is 0: the least stretch, the least slope n' of the force law, and the static stiffness of the
    tip. All are 0 where the tangent is not positive definite."""
    f, unit = model.slopes(q)[:, 0], np.zeros(len(q) // 2 - 1)
    unit[-2] = 1
    try:
        displacement = _solve_along(model, load, q, unit)[-2] if f.min() > 0 else math.inf
    except np.linalg.LinAlgError:
        return np.zeros(3)
    return np.array([f.min(), model.law.stiffness(f).min(), 1 / (displacement * model.beam.mu**2)])


def _solve_along(model: CubicElements, load: float, q: NDArray, force: NDArray) -> NDArray:
    """The displacement under a force along the beam; LinAlgError for an indefinite tangent."""
    L = cholesky_banded(model.tangent(q, load)[ALONG][:, 1:], lower=True, check_finite=False)
    return cho_solve_banded((L, True), force, check_finite=False)


def _no_equilibrium(model: CubicElements, limit: float, q: NDArray) -> NoEquilibrium | NotConverged:
    """The error for a path that ends at a load `limit`, with the cause."""
    law, gamma, f = model.law, math.sqrt(limit), model.slopes(q)[:, 0]
    *of_law, tip_stiffness = straight_margins(model, limit, q)
    # Axial force / mu^2 at the nodes that balances the load outboard of them: it depends on
    # positions only, so it stays correct where the stretch of the elements does not.
    outward = model.centrifugal_force(element_coordinates(q, 4), limit)[:, ::4].sum(axis=1)
    n = np.append(np.cumsum(outward[::-1])[::-1], 0.0) / model.beam.mu**2
    if model.beam.blade:
        n /= model.beam.blade.at("axial", model.nodes, inboard=True)
    reason = "the stiffness of the beam along itself falls to zero there"
    ends = ((law.min_stretch, f.min(), n.min()), (law.max_stretch, f.max(), n.max()))
    for end, f_reached, n_carried in ends:
        if abs(f_reached - end) >= LAW_END:
            continue
        if abs(n_carried) >= MIN_CARRIED * abs(law.force(f_reached)):
            reason = f"the {law.name} force law ends there, at a stretch of {end:.4g}"
        elif min(of_law) < tip_stiffness:
            return _overshoot(model, limit, q)
    return NoEquilibrium(f"no equilibrium beyond gamma = {gamma:.9g}: {reason}", gamma)


def _overshoot(model: CubicElements, load: float, q: NDArray) -> NotConverged:
    """The error for a stretch of the elements that the force in the beam cannot cause."""
    f = model.slopes(q)[:, 0]
    return NotConverged(
        f"at gamma = {math.sqrt(load):.6g} the stretch of the elements ranges over"
        f" {f.min():.3g} .. {f.max():.3g}, more than the force in the beam can cause: neighbours"
        " share one gradient, although at a mass or a jump of a property the stretch jumps. This is"
        " a limit of the method, not of the beam: method auto has none"
    )


# Coordinates along the beam or across it: values and slopes of node after node.


def gradient(model: CubicElements, q: NDArray) -> NDArray:
    """The derivative (n, p) at the Gauss points of a field with coordinates q (2 (n + 1),)."""
    return (model.dS @ element_coordinates(q, 2)[:, :, None])[..., 0]


def axial(model: CubicElements, q: NDArray) -> NDArray:
    """Stiffness of each element along the beam at r1 = q: (n, 4, 4)."""
    stiffness = constitutive.axial_stiffness(gradient(model, q), model.beam.mu, model.law)
    return _form(model.dS, model.weights * model.EA * stiffness)


def bending(model: CubicElements, q: NDArray, EI: NDArray, tension: NDArray) -> NDArray:
    """Stiffness (n, 4, 4) of each element across the beam at r1 = q, of a bending stiffness (n, p)
    under a tension (n, p)."""
    f = gradient(model, q)
    df = (model.ddS @ element_coordinates(q, 2)[:, :, None])[..., 0]
    angle = model.dS / f[..., None]  # theta = w'/f
    slope = (model.ddS - df[..., None] * angle) / f[..., None]  # theta'
    stiffness = model.weights * EI * constitutive.bending_stiffness(f, model.curvature_power)
    return _form(slope, stiffness) + _form(angle, model.weights * tension * f)


def _form(B: NDArray, density: NDArray) -> NDArray:
    """int B' density B of each element; B (n, p, 4), density with its weights (n, p)."""
    return B.transpose(0, 2, 1) @ (density[..., None] * B)
