"""Chebyshev collocation of the differential equations about the stretched equilibrium.

The equations of a straight beam with stretch f, tension N and a line density rho that holds the
concentrated mass, each integrated from the end where its unknown is known:

    equilibrium  mu^2 n(f) = gamma^2 R (u + delta),         u = J f
    stretching   mu^2 n'(f) s = Lambda R u,                 u = J s
    bending      a theta' = R f (N theta - V),              theta = J theta', w = J f theta
                 V = Lambda R w

with J = int from the clamp, R = int to the tip (rho in it where it acts on an inertia), a the
bending rigidity and Lambda = omega^2 + gamma^2 (omega^2 across the plane). They hold at the
Chebyshev points of the beam, or of both its parts where a mass sits between: integrals keep the
digits that differentiation matrices lose (El-Gendi, Computer J. 12, 1969; Greengard, SIAM J. Numer.
Anal. 28, 1991). Boundary layers get no points of their own.
"""

from functools import lru_cache, partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from beamviz.beam import Beam
from beamviz.errors import NotConverged
from beamviz.solver import constitutive, families
from beamviz.solver.constitutive import StrainLaw
from beamviz.solver.continuation import Root, continue_load, newton_at
from beamviz.solver.families import Family, Shapes
from beamviz.solver.hp.mesh import interpolation_matrix
from beamviz.solver.problem import Problem
from beamviz.solver.solution import Solution, read_only, straight

SPURIOUS = 1e-12  # share of the largest 1/omega^2 below which one is rounding
REAL = 1e-6  # an eigenvalue is real whose imaginary part is a smaller share


class Grid(NamedTuple):
    """Chebyshev points of each part of the beam, its ends included, and integrals between them."""

    ends: tuple[float, ...]  # of the parts
    points: np.ndarray  # (n,)
    from_clamp: np.ndarray  # (n, n): values -> integral from the clamp to each point
    to_tip: np.ndarray  # (n, n): values -> integral from each point to the tip


@lru_cache(maxsize=32)
def grid(ends: tuple[float, ...], order: int) -> Grid:
    """Polynomials of `order` on each part of the beam."""
    xi = -np.cos(np.pi * np.arange(order + 1) / order)
    Q = chebyshev.chebvander(xi, order + 1) @ chebyshev.chebint(np.eye(order + 1), lbnd=-1)
    Q = Q @ np.linalg.inv(chebyshev.chebvander(xi, order))  # integrals from the left end
    parts, size = len(ends) - 1, order + 1
    points, J = np.empty(parts * size), np.zeros((parts * size, parts * size))
    for k, (a, b) in enumerate(pairwise(ends)):
        here, half = slice(k * size, (k + 1) * size), (b - a) / 2
        points[here] = a + half * (xi + 1)
        J[k * size :, here] = half * Q[-1]  # of the parts further out; here it is replaced
        J[here, here] = half * Q
    return Grid(ends, *map(read_only, (points, J, J[-1] - J)))


def solve(beam: Beam, problem: Problem, start: float) -> Solution:
    """The modes with polynomials of an order, about the state of the same. start: the clock at the
    call. Raises NoEquilibrium with the limit, NotConverged."""
    order = problem.resolution
    interior = beam.alpha > 0 and 0 < beam.beta < 1
    on = grid((0.0, beam.beta, 1.0) if interior else (0.0, 1.0), order)
    R = on.to_tip.copy()
    if beam.beta in on.ends[1:]:  # the value at the mass acts on what is inboard of it
        inboard = (order + 1) * on.ends.index(beam.beta)
        R[:inboard, inboard - 1] += beam.alpha
    root = equilibrium(on, R, beam, problem.strain_law)
    f = root.state
    stretching = _stretching(on, R, f, beam, problem)
    bending = _bending(on, R, f, beam, problem)
    modes = families.merge(stretching, bending, problem.modes)
    size, curve = (2 * len(on.points), 1, order), partial(_curve, on, f)
    return families.build_solution(beam, problem, start, modes, size, curve, root.iterations)


def equilibrium(on: Grid, R: np.ndarray, beam: Beam, law: StrainLaw) -> Root:
    """The stretch (n,) in balance with its own centrifugal force, followed from rest."""
    RJ, pull = R @ on.from_clamp, beam.delta * R.sum(axis=1)

    def increment(load: float, f: np.ndarray) -> np.ndarray:
        tangent = np.diag(law.stiffness(f)) - load * RJ
        return -np.linalg.solve(tangent, law.force(f) - load * (RJ @ f + pull))

    def margin(load: float, f: np.ndarray) -> float:
        """1 at rest, 0 where the branch ends: the law's slope, and the beam's along itself."""
        slope = law.stiffness(f)
        if f.min() <= law.min_stretch or slope.min() <= 0:
            return 0.0
        softest = np.linalg.eigvals(RJ / slope[:, None]).real.max()
        return min(slope.min(), 1 - load * softest)

    load = (beam.gamma / beam.mu) ** 2
    path = continue_load(newton_at(increment), np.ones(len(on.points)), load, margin)
    if path.limit is not None:
        raise constitutive.no_equilibrium(beam, beam.mu * path.limit**0.5, law)
    return path


def _stretching(on: Grid, R: np.ndarray, f: np.ndarray, beam: Beam, problem: Problem) -> Family:
    """s = Lambda B s, softening taken into the operator."""
    stiffness = constitutive.axial_stiffness(f, beam.mu, problem.strain_law)
    J = on.from_clamp
    B = (R @ J) / stiffness[:, None]
    omega_squared, s = _lowest(np.eye(len(B)) - beam.gamma**2 * B, B, problem.modes)
    return Family(omega_squared, _unit_mass_shapes(on, beam, J @ s))


def _bending(on: Grid, R: np.ndarray, f: np.ndarray, beam: Beam, problem: Problem) -> Family:
    """A theta = Lambda B theta, softening taken into the operator."""
    N = beam.gamma**2 * R @ (on.from_clamp @ f + beam.delta)
    stiffness = constitutive.bending_stiffness(f, problem.curvature_power)
    J = on.from_clamp
    rotation = (J / stiffness) @ on.to_tip  # f (N theta - V) -> -theta
    A = np.eye(len(f)) + rotation * (f * N)
    B = (rotation * f) @ R @ (J * f)
    softened = A - families.centrifugal_softening(beam, problem) * B
    omega_squared, theta = _lowest(softened, B, problem.modes)
    return Family(omega_squared, _unit_mass_shapes(on, beam, J @ (f[:, None] * theta)))


def _lowest(A: np.ndarray, B: np.ndarray, modes: int) -> tuple[np.ndarray, np.ndarray]:
    """The lowest real omega^2 of A y = omega^2 B y, through 1 / omega^2, and their y."""
    inverse, y = np.linalg.eig(np.linalg.solve(A, B))
    real = abs(inverse.imag) <= REAL * abs(inverse)
    kept = np.flatnonzero(real & (abs(inverse) > SPURIOUS * abs(inverse).max()))
    omega_squared = 1 / inverse[kept].real
    picks = omega_squared.argsort()[:modes]
    if len(picks) < modes:
        raise NotConverged(
            f"only {len(picks)} modes of a family came out real with {len(A)} points; more terms"
            " may help"
        )
    return omega_squared[picks], y[:, kept[picks]].real


def _unit_mass_shapes(on: Grid, beam: Beam, shapes: np.ndarray) -> Shapes:
    """The polynomials through shapes (n, modes), of unit modal mass."""
    at_mass = np.argmin(abs(on.points - beam.beta))
    mass = on.from_clamp[-1] @ shapes**2
    if on.points[at_mass] == beam.beta:
        mass = mass + beam.alpha * shapes[at_mass] ** 2
    return partial(_values, on, shapes / np.sqrt(mass))


def _values(on: Grid, values: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Polynomials through values (n, k) at the points, at x: (len(x), k)."""
    size = len(on.points) // (len(on.ends) - 1)
    part = np.maximum(np.searchsorted(on.ends, x) - 1, 0)
    barycentric = np.where(np.arange(size) % 2, -1.0, 1.0)
    barycentric[[0, -1]] /= 2  # of Chebyshev points
    found = np.empty((len(x), values.shape[1]))
    for k in range(len(on.ends) - 1):
        own, here = slice(k * size, (k + 1) * size), part == k
        found[here] = interpolation_matrix(x[here], on.points[own], barycentric) @ values[own]
    return found


def _curve(on: Grid, f: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position, stretch and angle of the equilibrium."""
    return straight(*_values(on, np.column_stack((on.from_clamp @ f, f)), x).T)
