"""Methods with functions of the whole beam: assumed modes, power series, Chebyshev polynomials.

Assumed modes (Yoo & Shin, J. Sound Vib. 212, 1998; with a mass anywhere Yoo, Seo & Huh, 2002): with
the tension of the reference length, the modes of the beam at rest without a mass are the basis of
linear equations in w and u, with Coriolis coupling on request. The bending functions are evaluated
as in the textbooks, cosh bx - cos bx - s (sinh bx - sin bx): cosh and sinh cancel to one part in
e^b, so digits are lost from the eighth mode on and all at the twelfth. An interior mass bends the
beam more sharply than any basis function: convergence is slow.

Power series (Wright, Smith, Thresher & Wang, J. Appl. Mech. 49, 1982), which converge: with
the tension of the reference length, N(x) a polynomial of degree two, w'''' - (N w')' = Lambda w has
solutions sum c_k xi^k by recurrence. Two of them satisfy the clamp; at the mass N and the shear are
discontinuous, and the series start again; at the tip moment and shear vanish where Lambda is an
eigenvalue. Lambda is omega^2 + gamma^2 in the plane of rotation, omega^2 across it. Stretching is
sine and cosine. Both solutions grow as e^(length of the beam in boundary-layer widths), and the
determinant is their small difference: digits are lost with speed, and beyond gamma of about 40 too
few are left.

Chebyshev collocation of the differential equations about the stretched equilibrium: those of a
straight beam with stretch f, tension N and a line density rho that holds the concentrated mass,
each integrated from the end where its unknown is known:

    equilibrium  mu^2 n(f) = gamma^2 R (u + delta),         u = J f
    stretching   mu^2 n'(f) s = Lambda R u,                 u = J s
    bending      a theta' = R f (V - N theta),              theta = J theta', w = J f theta
                 V = Lambda R w

with J = int from the clamp, R = int to the tip (rho in it where it acts on an inertia), a the
bending rigidity and Lambda = omega^2 + gamma^2 (omega^2 across the plane). They hold at the
Chebyshev points of the beam, or of both its spans where a mass sits between: integrals keep the
digits that differentiation matrices lose (El-Gendi, Computer J. 12, 1969; Greengard, SIAM J. Numer.
Anal. 28, 1991). Boundary layers get no points of their own.
"""

from collections.abc import Callable
from functools import lru_cache, partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.errors import NotConverged
from beamviz.solver import constitutive, families
from beamviz.solver.constitutive import Function, StrainLaw, rigid_tension
from beamviz.solver.continuation import Root, continue_load, newton_at
from beamviz.solver.families import FamilyModes, Shapes
from beamviz.solver.pencil.inverse import real_modes
from beamviz.solver.problem import Problem
from beamviz.solver.quadrature import quadrature
from beamviz.solver.solution import Solution, false_position, read_only, straight
from beamviz.solver.stability import may_buckle
from beamviz.space.spans import AT_END, ends_of_spans

MOST_WITH_DIGITS = 12  # assumed modes; of the next ones rounding leaves nothing
# Steps of the scan, in the root of Lambda. Of 7 modes of 250 random beams none is skipped with
# either of them 4 times as large, and one or two with 8 times; 10 scans find all of them.
MIN_STEP, RELATIVE_STEP = 0.4, 0.03
SCAN_POINTS = 24  # values of Lambda at a time
MAX_SCANS = 40
MAX_WIDTHS = 24.0  # boundary layers: e^-24 is left of the determinant, e^-36 is rounding


def assumed_modes(beam: Beam, problem: Problem) -> Solution:
    """The modes in terms of the bending modes of a cantilever at rest and as many stretching modes
    of a bar at rest. Raises NotConverged."""
    terms = problem.resolution
    x, masses = quadrature(beam, 2 * terms + 12)  # exact to rounding
    (u, du), (w, dw, ddw) = fixed_free(terms, x), clamped_free(terms, x)
    lengths = np.append(masses[:-1], 0.0)  # the concentrated mass has no stiffness
    Ka = beam.mu**2 * (du.T * lengths) @ du
    Kb = (ddw.T * lengths) @ ddw + (dw.T * (lengths * rigid_tension(beam, x))) @ dw
    # M = F' F: rows of F are displacements at the points
    Fa, Fb = (np.sqrt(masses)[:, None] * displacement for displacement in (u, w))
    shapes = partial(partial, _combined, fixed_free), partial(partial, _combined, clamped_free)
    try:
        modes = families.modes_of_matrices(beam, problem, (Ka, Kb), (Fa, Fb), shapes)
    except NotConverged as error:
        if terms <= MOST_WITH_DIGITS:
            raise error
        raise NotConverged(
            f"terms = {terms}: beyond {MOST_WITH_DIGITS}, cosh and sinh cancel, and no digit is"
            " left; fewer terms help"
        ) from None
    return families.solution_of(beam, problem, modes, (2 * terms, 1, terms))


def clamped_free(terms: int, x: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Bending modes of a cantilever at rest, of unit mass, and their first two derivatives at x:
    (len(x), terms) each."""
    b = (np.arange(terms) + 0.5) * np.pi
    b[0] = 1.875  # of the lowest mode this is too far off
    for _ in range(8):  # the roots of cos b cosh b = -1
        b = b - (np.cos(b) + 1 / np.cosh(b)) / (-np.sin(b) - np.tanh(b) / np.cosh(b))
    ratio = (np.cosh(b) + np.cos(b)) / (np.sinh(b) + np.sin(b))
    z = x[:, None] * b
    c, s, ch, sh = np.cos(z), np.sin(z), np.cosh(z), np.sinh(z)
    slope, curvature = b * (sh + s - ratio * (ch - c)), b**2 * (ch + c - ratio * (sh + s))
    return ch - c - ratio * (sh - s), slope, curvature


def fixed_free(terms: int, x: NDArray) -> tuple[NDArray, NDArray]:
    """Stretching modes of a bar at rest, of unit mass, and their derivative at x: (len(x), terms)
    each."""
    z = (np.arange(terms) + 0.5) * np.pi
    return np.sqrt(2) * np.sin(x[:, None] * z), np.sqrt(2) * z * np.cos(x[:, None] * z)


def _combined(basis: Callable[[int, NDArray], tuple], coefficients: NDArray, x: NDArray) -> NDArray:
    """Combinations (len(x), modes) of basis functions, coefficients (terms, modes)."""
    return basis(len(coefficients), x)[0] @ coefficients


class TensionSpan(NamedTuple):
    """A span of the beam, without a mass inside, whose tension is N = sum tension[i] xi^i with
    xi = x - start."""

    start: float
    length: float
    tension: tuple[float, float, float]


@np.errstate(over="ignore", invalid="ignore")  # in a scan that finds no roots
def power_series(beam: Beam, problem: Problem) -> Solution:
    """The modes, w with as many powers as terms on each span of the beam: the roots of the
    determinant of moment and shear at the tip. Raises NotConverged where that is rounding, and for
    too few roots."""
    from scipy.interpolate import PPoly  # loads much that assumed modes do not need

    terms, modes = problem.resolution, problem.modes

    def determinant(s: NDArray) -> NDArray:
        """The determinant at each s (k,), relative to the sum of its two products: (k,)."""
        _, moment, shear = series(beam, terms, s * abs(s))
        first, second = moment[0] * shear[1], moment[1] * shear[0]
        return (first - second) / (abs(first) + abs(second))

    s = _lowest_roots(determinant, beam, terms, modes)
    coefficients, moment, _ = series(beam, terms, s * abs(s))
    shares = np.stack((-moment[1], moment[0])) / np.hypot(*moment)
    c = np.stack([(c * shares).sum(axis=1) for c in coefficients], axis=1)
    ends = [*(span.start for span in tension_spans(beam)), 1.0]
    scale = _unit_mass(beam, PPoly(c[::-1], ends))  # powers descend
    omega_squared = s * abs(s) - beam.gamma**2 * problem.chordwise
    bending = FamilyModes(omega_squared, PPoly(c[::-1] * scale, ends))
    both = families.merge(_stretching(beam, modes), bending, modes)
    return families.solution_of(beam, problem, both, (2, 1, terms))


def tension_spans(beam: Beam) -> list[TensionSpan]:
    """The spans between clamp, mass and tip, under the tension of the unstretched beam."""
    load = beam.gamma**2
    between = []
    for a, b in pairwise(ends_of_spans(beam)):
        carried = beam.alpha * (beam.beta + beam.delta) if b <= beam.beta + AT_END else 0.0
        at_start = (1 - a) * ((1 + a) / 2 + beam.delta) + carried
        tension = (load * at_start, -load * (a + beam.delta), -load / 2)
        between.append(TensionSpan(a, b - a, tension))
    return between


def series(beam: Beam, terms: int, Lambda: NDArray) -> tuple[list[NDArray], NDArray, NDArray]:
    """The two solutions that satisfy the clamp for each Lambda (k,): their coefficients (terms, 2,
    k) in xi on each span, from w'''' = (N w')' + Lambda w power by power, and moment and shear (2,
    k) at the tip."""
    start = np.zeros((4, 2, len(Lambda)))  # w, w', w''/2, w'''/6
    start[2, 0] = start[3, 1] = 1.0
    coefficients = []
    for span in tension_spans(beam):
        (n0, n1, n2), c = span.tension, np.zeros((terms, *start.shape[1:]))
        c[:4] = start
        for k in range(terms - 4):
            a = 1 / ((k + 2) * (k + 3) * (k + 4))
            from_tension = a * n0 * (k + 2) * c[k + 2] + a * n1 * (k + 1) * c[k + 1]
            c[k + 4] = from_tension + (a * n2 * k + a / (k + 1) * Lambda) * c[k]
        coefficients.append(c)
        at_end = derivatives_of_powers(span.length, terms) @ c.reshape(terms, -1)
        w, slope, moment, third = at_end.reshape(start.shape)
        N: float = sum(t * span.length**i for i, t in enumerate(span.tension))
        shear = N * slope - third
        if abs(span.start + span.length - beam.beta) <= AT_END:
            N -= beam.gamma**2 * beam.alpha * (beam.beta + beam.delta)
            shear -= Lambda * beam.alpha * w
        start = np.stack((w, slope, moment / 2, (N * slope - shear) / 6))
    return coefficients, moment, shear


def derivatives_of_powers(x: float, terms: int) -> NDArray:
    """The powers x^k, k < terms, and their first three derivatives: (4, terms)."""
    k = np.arange(1, terms)
    rows = [x ** np.arange(terms)]
    for _ in range(3):
        rows.append(np.append(0.0, k * rows[-1][:-1]))
    return np.array(rows)


def _stretching(beam: Beam, modes: int) -> FamilyModes:
    """u = sin zx up to the mass, and a second sine beyond it; Lambda = (mu z)^2.

    The phase of u, tan phase = z u / u', is z at the tip of a bar. A mass turns it by less than pi
    more. It grows with z, and is (k + 1/2) pi at the tip in mode k, from 0.
    """
    alpha, beta = beam.alpha, beam.beta
    at_tip = (np.arange(modes) + 0.5) * np.pi

    def phase_left(z: NDArray) -> NDArray:
        turn = 1 - alpha * z * np.sin(beta * z) * np.exp(-1j * beta * z)  # by the mass
        # With this factor it has no steps where a heavy mass is at a node.
        return abs(turn) * np.sin((z + np.angle(turn) - at_tip) / 2)

    z = false_position(phase_left, np.maximum(at_tip - np.pi, 0.0), at_tip)
    scale = _unit_mass(beam, partial(_sines, beam, z, 1.0))
    return FamilyModes((beam.mu * z) ** 2 - beam.gamma**2, partial(_sines, beam, z, scale))


def _lowest_roots(determinant: Function, beam: Beam, terms: int, modes: int) -> NDArray:
    """The lowest `modes` roots s, Lambda = s |s|, by a scan whose steps grow but stay smaller than
    the distance of bending modes. A wave in a beam under the compression P has Lambda >= -P^2 / 4.
    """
    x = (np.arange(200) + 0.5) / 200
    N = rigid_tension(beam, x)
    # int sqrt(abs(N)) dx; compression, whose solutions do not grow, costs the digits twice.
    widths = float((np.sqrt(abs(N)) * np.where(N < 0, 2, 1)).mean())
    if widths > MAX_WIDTHS:
        raise NotConverged(
            f"gamma = {beam.gamma:g}: power-series is ill-conditioned here, as the beam is"
            f" {widths:.0f} boundary-layer widths long (at most {MAX_WIDTHS:g}); method foac solves"
            " the same model"
        )
    points = [min(0.0, *(span.tension[0] for span in tension_spans(beam))) / 2 - MIN_STEP]
    values = determinant(np.array(points))
    for _ in range(MAX_SCANS):
        for _ in range(SCAN_POINTS):
            points.append(points[-1] + max(MIN_STEP, RELATIVE_STEP * abs(points[-1])))
        values = np.append(values, determinant(np.array(points[-SCAN_POINTS:])))
        below = np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0)[:modes]
        if len(below) == modes:
            grid = np.array(points)
            return false_position(determinant, grid[below], grid[below + 1])
    raise NotConverged(f"terms = {terms}: the power series has not converged; more terms may help")


def _sines(beam: Beam, z: NDArray, scale: NDArray | float, x: NDArray) -> NDArray:
    """Stretching shapes of wave numbers z at x: (len(x), modes)."""
    beyond = np.maximum(x - beam.beta, 0.0)[:, None]
    kink = beam.alpha * z * np.sin(z * beam.beta) * np.sin(z * beyond)
    return scale * (np.sin(x[:, None] * z) - kink)


def _unit_mass(beam: Beam, shapes: Shapes, points: int = 64) -> NDArray:
    """The factors (modes,) that give shapes unit modal mass, by so many Gauss points on a span."""
    x, weights = quadrature(beam, points)
    return 1 / np.sqrt(weights @ shapes(x) ** 2)


class ChebyshevGrid(NamedTuple):
    """Chebyshev points of each span of the beam, its ends included, and integrals between them."""

    ends: tuple[float, ...]  # of the spans
    points: NDArray  # (n,)
    from_clamp: NDArray  # (n, n): values -> integral from the clamp to each point
    to_tip: NDArray  # (n, n): values -> integral from each point to the tip
    to_series: NDArray  # (order + 1, order + 1): values on a span -> Chebyshev coefficients


@lru_cache(maxsize=4)  # one is 3 MB at 200 terms, and takes a tenth of a solve
def chebyshev_grid(ends: tuple[float, ...], order: int) -> ChebyshevGrid:
    """The grid of polynomials of `order` on each span of the beam between `ends`."""
    xi = -np.cos(np.pi * np.arange(order + 1) / order)
    to_series = np.linalg.inv(chebyshev.chebvander(xi, order))
    integrals = chebyshev.chebint(np.eye(order + 1), lbnd=-1) @ to_series
    Q = chebyshev.chebvander(xi, order + 1) @ integrals  # from the left end
    spans, size = len(ends) - 1, order + 1
    points, J = np.empty(spans * size), np.zeros((spans * size, spans * size))
    for k, (a, b) in enumerate(pairwise(ends)):
        here, half = slice(k * size, (k + 1) * size), (b - a) / 2
        points[here] = a + half * (xi + 1)
        J[k * size :, here] = half * Q[-1]  # of the spans further out; here it is replaced
        J[here, here] = half * Q
    return ChebyshevGrid(ends, *map(read_only, (points, J, J[-1] - J, to_series)))


def chebyshev_collocation(beam: Beam, problem: Problem) -> Solution:
    """The modes with polynomials of an order, about the equilibrium with the same polynomials.
    Raises NoEquilibrium with the limit, NotConverged."""
    order = problem.resolution
    ends = ends_of_spans(beam)
    grid = chebyshev_grid(ends, order)
    R = grid.to_tip.copy()
    inboard = (order + 1) * sum(end <= beam.beta + AT_END for end in ends[1:])  # points
    if inboard:  # the value at the mass acts on what is inboard of it
        R[:inboard, inboard - 1] += beam.alpha
    try:
        root = _equilibrium(grid, R, beam, problem.strain_law)
    except NotConverged as error:
        raise families.no_equilibrium(beam, problem) or error from None
    f, J = root.state, grid.from_clamp
    A, B = _stretching_operators(grid, R, f, beam, problem)
    stretching = _lowest_modes(grid, beam, A, B, J, problem.modes)
    A, B = _bending_operators(grid, R, f, beam, problem)
    bending = _lowest_modes(grid, beam, A, B, J * f, problem.modes)
    modes = families.merge(stretching, bending, problem.modes)
    curve = partial(_curve, grid.ends, grid.to_series, np.column_stack((J @ f, f)))
    size = (2 * len(grid.points), 1, order)
    return families.solution_of(beam, problem, modes, size, curve, root.iterations)


def _stretching_operators(
    grid: ChebyshevGrid, R: NDArray, f: NDArray, beam: Beam, problem: Problem
) -> tuple[NDArray, NDArray]:
    """A and B (n, n) of A s = omega^2 B s about the stretch f (n,): s = Lambda B s with the
    softening, gamma^2 of Lambda, taken into A."""
    stiffness = constitutive.axial_stiffness(f, beam.mu, problem.strain_law)
    B = (R @ grid.from_clamp) / stiffness[:, None]
    return np.eye(len(f)) - beam.gamma**2 * B, B


def _bending_operators(
    grid: ChebyshevGrid, R: NDArray, f: NDArray, beam: Beam, problem: Problem
) -> tuple[NDArray, NDArray]:
    """A and B (n, n) of A theta = omega^2 B theta about the stretch f (n,). In the plane of
    rotation the softening, gamma^2 of Lambda, is taken into A."""
    J = grid.from_clamp
    N = beam.gamma**2 * R @ (J @ f + beam.delta)
    rigidity = constitutive.bending_stiffness(f, problem.curvature_power)
    to_angle = (J / rigidity) @ grid.to_tip  # f (V - N theta) -> theta
    A = np.eye(len(f)) + to_angle * (f * N)
    B = (to_angle * f) @ R @ (J * f)
    return A - beam.gamma**2 * problem.chordwise * B, B


def _equilibrium(grid: ChebyshevGrid, R: NDArray, beam: Beam, law: StrainLaw) -> Root:
    """The stretch (n,) in balance with its own centrifugal force, followed from rest."""
    RJ, pull = R @ grid.from_clamp, beam.delta * R.sum(axis=1)

    def increment(load: float, f: NDArray) -> NDArray:
        tangent = np.diag(law.stiffness(f)) - load * RJ
        return -np.linalg.solve(tangent, law.force(f) - load * (RJ @ f + pull))

    def margin(load: float, f: NDArray) -> float:
        """1 at rest, 0 where the branch ends: the law's slope, and the beam's along itself."""
        slope = law.stiffness(f)
        if f.min() <= law.min_stretch or slope.min() <= 0:
            return 0.0
        softest = np.linalg.eigvals(RJ / slope[:, None]).real.max()
        return min(slope.min(), 1 - load * softest)

    load = (beam.gamma / beam.mu) ** 2
    path = continue_load(newton_at(increment), np.ones(len(grid.points)), load, margin)
    if path.limit is not None:
        raise constitutive.no_equilibrium(beam, beam.mu * path.limit**0.5, law)
    return path


def _lowest_modes(
    grid: ChebyshevGrid, beam: Beam, A: NDArray, B: NDArray, displacement: NDArray, modes: int
) -> FamilyModes:
    """The modes with the lowest real omega^2 of A y = omega^2 B y. displacement (n, n): y ->
    displacements at the points. Raises NotConverged for too few."""
    omega_squared, y = real_modes(A, B, modes, may_buckle(beam))
    if len(omega_squared) < modes:
        raise NotConverged(
            f"only {len(omega_squared)} modes of a family came out real with {len(A)} points; more"
            " terms may help"
        )
    values = displacement @ y
    ends, to_series = grid.ends, grid.to_series  # not all of the grid: solutions keep them
    scale = _unit_mass(beam, partial(_values, ends, to_series, values), len(to_series))
    return FamilyModes(omega_squared, partial(_values, ends, to_series, values * scale))


def _values(ends: tuple[float, ...], to_series: NDArray, values: NDArray, x: NDArray) -> NDArray:
    """The polynomials through values (n, k) at the points of a grid, evaluated at x: (len(x), k).
    ends, to_series: of the grid."""
    size = len(to_series)
    span = np.maximum(np.searchsorted(ends, x) - 1, 0)
    at_x = np.empty((len(x), values.shape[1]))
    for k, (a, b) in enumerate(pairwise(ends)):
        here = span == k
        coefficients = to_series @ values[k * size : (k + 1) * size]
        xi = (2 * x[here] - a - b) / (b - a)
        at_x[here] = chebyshev.chebvander(xi, size - 1) @ coefficients
    return at_x


def _curve(
    ends: tuple[float, ...], to_series: NDArray, values: NDArray, x: NDArray
) -> tuple[NDArray, NDArray, NDArray]:
    """Position, stretch and angle of the equilibrium, from position and stretch (n, 2)."""
    return straight(*_values(ends, to_series, values, x).T)
