"""Mode shapes of solutions as vectors, orthogonal in a product that contains the mass matrix and,
with Coriolis forces, the gyroscopic one."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import BeamvizError
from beamviz.solver.quadrature import distributed_mass, gauss
from beamviz.solver.solution import Solution
from beamviz.solver.straight import displacements

GAUSS_POINTS = 16  # of a mode vector, plus two for each mode, and more for a buckled beam
MORE_IN_SPAN = 2  # Gauss points between two discontinuities of a blade, however close
STEP = 1e-4  # [x/L] of the finite difference for the rotation of a body
# The frequency that the product of modes takes for a rigid rotation, whose frequency is 0. The
# error of that product is the root of RIGID, plus the error of the quadrature over this root: for
# five hinged beams at most 0.02 with 1e-3, and 0.5 with 1e-6.
RIGID = 1e-3
TINY = float(np.finfo(float).tiny)

Outcome = Solution | BeamvizError  # at one value of a parameter


@dataclass(frozen=True, eq=False)
class ModeVectors:
    """Modes at n ascending values of one parameter, m at each, and a product of two modes that is 1
    of each with itself and 0 of two others at one value. The fields are smooth functions of the
    parameter, but for their sign.

    product: returns the product (..., m, k), not normalised, of the modes of two ModeVectors.
    """

    at: np.ndarray  # (n,)
    omega_squared: np.ndarray  # (n, m) ascending in each row
    gamma: np.ndarray  # (n,)
    # (n, m, 1 + c, points) u and the c components of w times the roots of weights and masses
    fields: np.ndarray
    product: Callable[["ModeVectors", "ModeVectors"], np.ndarray]

    def chosen(self, values: Any, modes: np.ndarray | None = None) -> "ModeVectors":
        """Those at the k values of these indices, or a slice; modes: indices (k, modes) of those
        at each, by default all."""
        index = values if modes is None else (values[:, None], modes)
        return replace(
            self,
            at=self.at[values],
            omega_squared=self.omega_squared[index],
            gamma=self.gamma[values],
            fields=self.fields[index],
        )

    def among(self, values: np.ndarray) -> "ModeVectors":
        """Those at these values (n,) of the parameter."""
        index = (self.at[:, None] == values).any(axis=1)
        return self if index.all() else self.chosen(index)

    @cached_property
    def norms(self) -> np.ndarray:
        """The products (n, m) of each mode with itself, not normalised."""
        return np.diagonal(self.product(self, self), axis1=1, axis2=2)

    def products(self, other: "ModeVectors") -> np.ndarray:
        """The products (n, m, k) of each mode with the k modes at each of the n values of other
        ModeVectors; n is 1 of either, or equal."""
        sizes = np.maximum(abs(self.norms[:, :, None] * other.norms[:, None]), TINY)
        return self.product(self, other) * np.sign(other.norms.real)[:, None] / np.sqrt(sizes)

    @property
    def frequencies(self) -> np.ndarray:
        """Frequencies or growth rates (n, m). The product of a rigid rotation about a hinge, of
        frequency 0, with itself vanishes: a small frequency instead makes it nearly orthogonal to
        the others."""
        omega = np.sqrt(abs(self.omega_squared))
        return np.where(omega == 0, RIGID, omega)


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
    sampled at `count` Gauss points of the whole beam and at the mass."""
    solutions = [outcome for outcome in outcomes if isinstance(outcome, Solution)]
    at = at[[isinstance(outcome, Solution) for outcome in outcomes]]
    if not solutions:
        none = np.empty((0, 0))
        return ModeVectors(at, none, at, np.empty((0, 0, 2, 0)), _mass_product)
    squares = np.array([solution.omega_squared for solution in solutions])
    factor = solutions[0].problem.coriolis_factor
    gamma = np.array([factor * solution.beam.gamma for solution in solutions])
    fields, masses = _fields(solutions, count)
    fields *= np.sqrt(masses)
    if solutions[0].problem.state != "straight":
        return ModeVectors(at, squares, gamma, _of_real_square(fields), _complex_product)
    if np.iscomplexobj(fields) and gamma.any():
        fields = _in_phase(fields, squares)
        return ModeVectors(at, squares, gamma, fields, _gyroscopic_product)
    return ModeVectors(at, squares, gamma, fields, _mass_product)


def mass_weighted(
    solutions: Sequence[Solution], squares: np.ndarray, count: int, beside: Sequence[Beam] = ()
) -> np.ndarray:
    """u and w (n, m, 1 + c, points) of all modes at Gauss points and at the bodies, times the roots
    of weights and masses. beside: beams of another blade or with other bodies; the vectors have
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
    u, w = fields[:, :, :1], fields[:, :, 1:]
    stable = (squares >= 0)[:, :, None, None]
    return np.concatenate((u.real + u.imag, np.where(stable, w.imag - w.real, w.real)), axis=2)


def _fields(solutions: Sequence[Solution], count: int) -> tuple[np.ndarray, np.ndarray]:
    """Displacements (n, m, 1 + c, points) of all modes at Gauss points and at the bodies, of
    arbitrary phase, and rotations of bodies with inertia in place of displacements across the beam;
    weights, masses and moments of inertia there (n, 1, 1, points)."""
    if not all(solution.beam.is_uniform for solution in solutions):
        return _fields_of_blades(solutions, count)
    x, w = gauss(count)
    alpha = np.array([solution.beam.alpha for solution in solutions])
    beta = np.array([solution.beam.beta for solution in solutions])
    n = len(solutions)
    stations = np.column_stack((np.tile((x + 1) / 2, (n, 1)), beta))
    masses = np.column_stack((np.tile(w / 2, (n, 1)), alpha))
    fields = displacements(solutions, stations)  # (n, count + 1, 1 + c, m)
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
    x, w = distributed_mass(first, ends, count, MORE_IN_SPAN)
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
        places = [place for place, _ in turning]
        moments = np.array([moments for _, moments in turning]) / len(every)
        rotations, inertia = _rotations_of_bodies(solutions, places, moments)
        fields = np.concatenate((fields, rotations), axis=3)
        masses = np.column_stack((masses, np.tile(inertia, (n, 1))))
    return fields, masses[:, None, None, :]


def _rotations_of_bodies(
    solutions: Sequence[Solution], places: Sequence[float], moments: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Rotations (n, m, 1 + c, k) of bodies with principal moments of inertia (bodies, 3), about the
    axes of which they have one, in the last component; and those moments (k,)."""
    angles = np.stack([_rotations(solutions, place) for place in places], axis=3)  # (n, m, c, k)
    problem = solutions[0].problem
    if problem.in_space:
        turns = [[_turn(solution.beam, place) for place in places] for solution in solutions]
        c, s = (function(np.radians(turns))[:, None] for function in (np.cos, np.sin))
        v, w = angles[:, :, 0], angles[:, :, 1]
        angles = np.concatenate((c * v + s * w, c * w - s * v), axis=2)[:, :, None]
        inertia = np.concatenate((moments[:, 2], moments[:, 1]))
    else:
        inertia = moments[:, 2 if problem.chordwise else 1]
    rotations = np.zeros(
        (*angles.shape[:2], 3 if problem.in_space else 2, len(inertia)), angles.dtype
    )
    rotations[:, :, -1] = angles[:, :, 0]
    return rotations, inertia


def _turn(beam: Beam, x: float) -> float:
    """The angle [deg] of the section at x."""
    own = 0.0 if beam.blade is None else float(beam.blade.at("twist", x))
    return beam.pitch + beam.twist * x + own


def _rotations(solutions: Sequence[Solution], x: float) -> np.ndarray:
    """Rotations (n, m, c) of the section at x, by differences toward the root; at the root, toward
    the tip."""
    step = STEP if x >= 2 * STEP else -STEP
    near = x - step * np.arange(3)
    moved = displacements(solutions, np.tile(near, (len(solutions), 1)))  # (n, 3, 1 + c, m)
    slope = np.array([1.5, -2.0, 0.5]) / step
    angles = np.array([solution.equilibrium.angle(near) for solution in solutions])
    f = np.array([solution.equilibrium.stretch(near)[0] for solution in solutions])
    along, across = moved[:, 0, 0], np.einsum("p,npcm->nmc", slope, moved[:, :, 1:])
    return (across + ((angles @ slope)[:, None] * along)[..., None]) / f[:, None, None]


def _of_real_square(fields: np.ndarray) -> np.ndarray:
    """Complex u and w (n, m, 2, points), of any phase, in that in which the sum of u^2 - w^2 is
    real: of a straight beam (u, i w)."""
    square = (fields[:, :, 0] ** 2 - fields[:, :, 1] ** 2).sum(axis=2)
    return fields * np.exp(-0.5j * np.angle(square))[:, :, None, None]


def _mass_product(first: ModeVectors, second: ModeVectors) -> np.ndarray:
    """phi_i* M phi_j."""
    return _sums(_joined(first.fields), _joined(second.fields))


def _complex_product(first: ModeVectors, second: ModeVectors) -> np.ndarray:
    """The product of modes phi = (u, w) of M q" + 2 gamma G q' + K q = 0 with complex u and w.

    The equation of mode j times phi_i*, less that of mode i times phi_j*, is omega_i - omega_j
    times a product in which modes are therefore orthogonal,

        (omega_i + omega_j) phi_i* M phi_j - 2 i gamma phi_i* G phi_j,

    with i phi_i* G phi_j = i sum (w_i* u_j - u_i* w_j). This is its real part.
    """
    (u, w), (second_u, second_w) = _components(first), _components(second)
    omega, gamma = _sum_of_each(first.frequencies, second.frequencies), _sum_of_gamma(first, second)
    inertia = _sums(u, second_u) + _sums(w, second_w)
    swirl = _sums(w, second_u) - _sums(u, second_w)
    return omega * inertia.real + gamma * swirl.imag


def _gyroscopic_product(first: ModeVectors, second: ModeVectors) -> np.ndarray:
    """The same product of modes (u, i w) of a straight beam, with real u and w,

        (omega_i + omega_j) (u_i M u_j + w_i M w_j) - 2 gamma (w_i M u_j + u_i M w_j).

    An unstable mode is (u, w), with the growth rate for omega. It is orthogonal to both modes of a
    pair +-omega, so to their sum and to their difference, which are the two halves of the product,

        omega_i u_i M u_j + omega_j w_i M w_j - 2 gamma w_i M u_j and
        omega_i w_i M w_j + omega_j u_i M u_j - 2 gamma u_i M w_j.

    Half the product changes its sign where that keeps it from vanishing at the onset of
    instability.
    """
    (u, w), (other_u, other_w) = _components(first), _components(second)
    sign, other_sign = _signs(first)[:, :, None], _signs(second)[:, None]
    omega, other_omega = first.frequencies[:, :, None], second.frequencies[:, None]
    signed = np.where(first.omega_squared >= 0, 1.0, -1.0)[:, :, None] * omega
    other_signed = np.where(second.omega_squared >= 0, 1.0, -1.0)[:, None] * other_omega
    # In space w, which the Coriolis force acts on, is the component in the plane of rotation.
    along = _sums(u, other_u)
    across = _sums(_joined(first.fields[:, :, 1:]), _joined(second.fields[:, :, 1:]))
    gamma = _sum_of_gamma(first, second)
    half = omega * along + other_signed * across - gamma * _sums(w, other_u)
    other_half = signed * across + other_omega * along - gamma * _sums(u, other_w)
    return half + sign * other_sign * other_half


def _signs(vectors: ModeVectors) -> np.ndarray:
    """The sign (n, m) of each mode in half the product: -1 of an unstable one that bends."""
    squares = (vectors.fields**2).sum(axis=3)  # (n, m, components)
    bends = squares[:, :, 1:].sum(axis=2) > squares[:, :, 0]
    return np.where((vectors.omega_squared >= 0) | ~bends, 1.0, -1.0)


def _components(vectors: ModeVectors) -> tuple[np.ndarray, np.ndarray]:
    """u and w (n, m, points)."""
    return vectors.fields[:, :, 0], vectors.fields[:, :, 1]


def _joined(fields: np.ndarray) -> np.ndarray:
    """All components in one axis: (n, m, components * points)."""
    return fields.reshape(*fields.shape[:2], math.prod(fields.shape[2:]))


def _sums(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Sums over the points (n, m, k) of first* (n, m, points) times second (n, k, points)."""
    return first.conj() @ second.mT


def _sum_of_each(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """The sums (n, m, k) of numbers of modes (n, m) and (n, k)."""
    return first[:, :, None] + second[:, None]


def _sum_of_gamma(first: ModeVectors, second: ModeVectors) -> np.ndarray:
    """The sum (n, 1, 1) of gamma: twice their mean."""
    return (first.gamma + second.gamma)[:, None, None]
