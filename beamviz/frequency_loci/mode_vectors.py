"""Mode shapes of solutions as vectors, orthogonal in a product that contains the mass matrix and,
with Coriolis forces, the gyroscopic one."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import BeamvizError
from beamviz.solver.hp import displacements
from beamviz.solver.quadrature import distributed_mass, gauss
from beamviz.solver.solution import Solution

GAUSS_POINTS = 16  # of a mode vector, plus two for each mode, and more for a buckled beam
MORE_IN_SPAN = 2  # Gauss points between two discontinuities of a blade, however close
STEP = 1e-4  # of the difference that is the rotation of a body
RIGID = 1e-6  # for the frequency of a rigid rotation

Outcome = Solution | BeamvizError  # at one value of a parameter


class ModeVectors(NamedTuple):
    """Modes at n ascending values of one parameter, m at each, as vectors with shape_i . dual_j = 1
    for i = j and 0 otherwise. Shapes and duals are smooth functions of the parameter."""

    at: np.ndarray  # (n,)
    omega_squared: np.ndarray  # (n, m) ascending in each row
    shapes: np.ndarray  # (n, m, d)
    duals: np.ndarray  # (n, m, d)

    def among(self, values: np.ndarray) -> "ModeVectors":
        """Those at these values (n,) of the parameter."""
        index = (self.at[:, None] == values).any(axis=1)
        return self if index.all() else ModeVectors(*(array[index] for array in self))


def gauss_points(solutions: Sequence[Solution]) -> int:
    """Number of Gauss points for which the modes of the solutions are orthogonal.

    A beam under compression P, with growth rate g ~ P / 2, has wave numbers up to
    k = sqrt(P) = sqrt(2 g). A product of two modes has wave number 2 k and is, with an error that
    decays fast, a polynomial of degree k on 0 .. 1, which k / 2 = sqrt(g / 2) points integrate.
    """
    s = np.array([solution.s for solution in solutions])
    growth = max(float(s.real.max()), 0.0)
    return GAUSS_POINTS + 2 * s.shape[1] + math.ceil(math.sqrt(growth / 2))


def mode_vectors(at: np.ndarray, outcomes: Sequence[Outcome], count: int) -> ModeVectors:
    """The modes, equal in number, of the outcomes at values (n,) that are solutions. Shapes are
    sampled at `count` Gauss points of the whole beam and at the mass; inner products of shapes and
    duals contain the weights and the mass."""
    solutions = [outcome for outcome in outcomes if isinstance(outcome, Solution)]
    at = at[[isinstance(outcome, Solution) for outcome in outcomes]]
    if not solutions:
        no_vectors = np.empty((0, 0, 0))
        return ModeVectors(at, np.empty((0, 0)), no_vectors, no_vectors)
    squares = np.array([solution.omega_squared for solution in solutions])
    fields, masses = _fields(solutions, count)
    if solutions[0].problem.state != "straight":
        vectors = _complex_vectors(fields * np.sqrt(masses), solutions)
        return ModeVectors(at, squares, *_normalised(*vectors))
    gamma = np.array([solution.beam.gamma for solution in solutions])
    if np.iscomplexobj(fields) and gamma.any():
        fields = _in_phase(fields, squares)
        vectors = _gyroscopic_vectors(fields, masses, squares, gamma)
        return ModeVectors(at, squares, *_normalised(*vectors))
    shapes = fields.reshape(*squares.shape, -1)
    return ModeVectors(at, squares, shapes, (fields * masses).reshape(shapes.shape))


def mass_weighted(
    solutions: Sequence[Solution], squares: np.ndarray, count: int, beside: Sequence[Beam] = ()
) -> np.ndarray:
    """u and w (n, m, 2, points) of all modes at Gauss points and at the bodies, times the roots of
    weights and masses. beside: beams of another blade or with other bodies; the vectors have
    components at their discontinuities, too, so that theirs, with these beams beside, match."""
    if beside:
        fields, masses = _fields_of_blades(solutions, count, beside)
    else:
        fields, masses = _fields(solutions, count)
    if np.iscomplexobj(fields):
        fields = _in_phase(fields, squares)
    return fields * np.sqrt(masses)


def _in_phase(fields: np.ndarray, squares: np.ndarray) -> np.ndarray:
    """u and w of gyroscopic modes of any phase: of (u, i w) where stable, else of (u, w)."""
    u, w = fields[:, :, 0], fields[:, :, 1]
    stable = (squares >= 0)[:, :, None]
    return np.stack((u.real + u.imag, np.where(stable, w.imag - w.real, w.real)), axis=2)


def _fields(solutions: Sequence[Solution], count: int) -> tuple[np.ndarray, np.ndarray]:
    """Displacements (n, m, 2, points) of all modes at Gauss points and at the bodies, of arbitrary
    phase, and rotations of bodies with inertia in place of displacements across the beam; weights,
    masses and moments of inertia there (n, 1, 1, points)."""
    if not all(solution.beam.is_uniform for solution in solutions):
        return _fields_of_blades(solutions, count)
    x, w = gauss(count)
    alpha = np.array([solution.beam.alpha for solution in solutions])
    beta = np.array([solution.beam.beta for solution in solutions])
    n = len(solutions)
    stations = np.column_stack((np.tile((x + 1) / 2, (n, 1)), beta))
    masses = np.column_stack((np.tile(w / 2, (n, 1)), alpha))
    fields = displacements(solutions, stations)  # (n, count + 1, 2, m)
    return fields.swapaxes(1, 3), masses[:, None, None, :]


def _fields_of_blades(
    solutions: Sequence[Solution], count: int, beside: Sequence[Beam] = ()
) -> tuple[np.ndarray, np.ndarray]:
    """`_fields` of beams that differ in their numbers, not in blade, masses and root. beside: see
    `mass_weighted`; then the bodies are those of all these beams, at the places of each, with the
    mean of what they carry."""
    first = solutions[0].beam
    every = (first, *beside)
    breaks = {place for beam in every if beam.blade for place in beam.blade.breaks}
    ends = tuple(sorted({0.0, 1.0, *breaks, *(m.beta for beam in every for m in beam.masses)}))
    points = MORE_IN_SPAN + np.ceil(count * np.diff(ends)).astype(int)
    x, w = distributed_mass(first, ends, points.tolist())
    n = len(solutions)
    turning = [(m.beta, m.inertia) for beam in every for m in beam.masses if any(m.inertia)]
    if beside:
        bodies = sorted((m.alpha / len(every), m.beta) for beam in every for m in beam.bodies)
        carried = np.array([bodies] * n).reshape(n, len(bodies), 2)
        turning.sort()
    else:
        others = [(m.alpha, m.beta) for m in first.masses]
        carried = np.array([[(each.beam.alpha, each.beam.beta), *others] for each in solutions])
    alpha, beta = np.moveaxis(carried, 2, 0)
    fields = displacements(solutions, np.column_stack((np.tile(x, (n, 1)), beta))).swapaxes(1, 3)
    masses = np.column_stack((np.tile(w, (n, 1)), alpha))
    if turning:
        axis = 2 if solutions[0].problem.chordwise else 1
        rotations = np.zeros((*fields.shape[:3], len(turning)), fields.dtype)
        for k, (place, _) in enumerate(turning):
            # A body at the clamp: the differences need points on the beam.
            rotations[:, :, 1, k] = _rotations(solutions, max(place, 3 * STEP))
        fields = np.concatenate((fields, rotations), axis=3)
        inertia = [moments[axis] / len(every) for _, moments in turning]
        masses = np.column_stack((masses, np.tile(inertia, (n, 1))))
    return fields, masses[:, None, None, :]


def _rotations(solutions: Sequence[Solution], x: float) -> np.ndarray:
    """Rotations (n, m) of the section at x, by differences toward the root."""
    near = x - STEP * np.arange(3)
    moved = displacements(solutions, np.tile(near, (len(solutions), 1)))  # (n, 3, 2, m)
    slope = np.array([1.5, -2.0, 0.5]) / STEP
    angles = np.array([solution.equilibrium.angle(near) for solution in solutions])
    f = np.array([solution.equilibrium.stretch(near)[0] for solution in solutions])
    along, across = moved[:, 0, 0], np.einsum("p,npm->nm", slope, moved[:, :, 1])
    return (across + (angles @ slope)[:, None] * along) / f[:, None]


def _gyroscopic_vectors(
    fields: np.ndarray, masses: np.ndarray, squares: np.ndarray, gamma: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Shapes and duals (n, m, d), not normalised, of modes phi = (u, i w) of M q" + 2 gamma G q' +
    K q = 0.

    The equation of mode j times phi_i*, less that of mode i times phi_j*, is omega_i - omega_j
    times a product in which modes are therefore orthogonal,

        (omega_i + omega_j) phi_i* M phi_j - 2 i gamma phi_i* G phi_j
            = (omega_i + omega_j) (u_i M u_j + w_i M w_j) - 2 gamma (w_i M u_j + u_i M w_j).

    An unstable mode is (u, w), with the growth rate for omega. It is orthogonal to both modes of a
    pair +-omega, so to their sum and to their difference, which are the two halves of the product.
    Half the product changes its sign where that keeps it from vanishing at the onset of
    instability.
    """
    omega = _positive_frequencies(squares)
    stable = (squares >= 0)[:, :, None]
    u, w = fields[:, :, 0], fields[:, :, 1]
    Mu, Mw = np.moveaxis(fields * masses, 2, 0)
    bends = (w * Mw).sum(axis=2, keepdims=True) > (u * Mu).sum(axis=2, keepdims=True)
    sign = np.where(stable | ~bends, 1.0, -1.0)
    double, signed = 2 * gamma[:, None, None], np.where(stable, omega, -omega)
    terms = (  # of the product: a factor with mode i and one with mode j
        (omega * u, Mu),
        (w, signed * Mw),
        (w, -double * Mu),
        (sign * signed * w, sign * Mw),
        (sign * u, sign * omega * Mu),
        (sign * u, -sign * double * Mw),
    )
    shapes, duals = (np.concatenate(factors, axis=2) for factors in zip(*terms, strict=True))
    return shapes, duals


def _complex_vectors(
    fields: np.ndarray, solutions: Sequence[Solution]
) -> tuple[np.ndarray, np.ndarray]:
    """Shapes and duals (n, m, d), not normalised, of modes of beams that may be bent, complex in
    both components.

    fields: u and w (n, m, 2, points) times the root of the mass. The product is the real part of
    (omega_i + omega_j) phi_i* M phi_j - 2 i gamma phi_i* G phi_j, with i phi_i* G phi_j =
    i sum (w_i* u_j - u_i* w_j). The phase makes sum (u^2 - w^2) real: (u, i w) of a straight beam.
    """
    omega = _positive_frequencies(np.array([solution.omega_squared for solution in solutions]))
    gamma = [solution.beam.gamma if solution.problem.gyroscopic else 0.0 for solution in solutions]
    root = np.sqrt(gamma)[:, None, None]
    fields = fields.astype(complex)
    square = (fields[:, :, 0] ** 2 - fields[:, :, 1] ** 2).sum(axis=2)
    fields = fields * np.exp(-0.5j * np.angle(square))[:, :, None, None]
    u, w = fields[:, :, 0], fields[:, :, 1]
    both = np.concatenate((u.real, u.imag, w.real, w.imag), axis=2)
    shapes, duals = [omega * both, both], [both, omega * both]
    if root.any():
        shapes.append(root * np.concatenate((w.real, -w.imag, -u.real, u.imag), axis=2))
        duals.append(2 * root * np.concatenate((u.imag, u.real, w.imag, w.real), axis=2))
    return np.concatenate(shapes, axis=2), np.concatenate(duals, axis=2)


def _positive_frequencies(squares: np.ndarray) -> np.ndarray:
    """Frequencies or growth rates (n, m, 1). The product of a rigid rotation about a hinge, of
    frequency 0, with itself vanishes: a small frequency instead makes it orthogonal to the others
    but for a share as small."""
    omega = np.sqrt(abs(squares))[:, :, None]
    return np.where(omega == 0, RIGID, omega)


def _normalised(shapes: np.ndarray, duals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Shapes and duals (n, m, d) of product 1, in place of those given: of a chart of a blade they
    take tens of megabytes."""
    norms = np.vecdot(shapes, duals)[..., None]
    size = np.sqrt(np.maximum(abs(norms), np.finfo(float).tiny))
    shapes /= size
    duals /= size
    duals *= np.sign(norms)
    return shapes, duals
