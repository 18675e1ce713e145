"""Trial functions of stretch and bending on elements, which may span several stations of a blade.

Where a property or its slope jumps, the stretch and the curvature jump with it, but the axial force
and the bending moment are smooth. So a change of the stretch is a polynomial over E A, one of the
curvature a polynomial over E I, and an element may span many stations. Integrals are sums over
pieces, between stations and ends of elements, each with Gauss points of its own.

The functions are orthonormal in the energy at rest (of mu = 1), so that their coefficients are in
natural units and the highest of each element, its tail, estimate what those left out carry. A
function of bending other than the two lowest of an element is orthogonal to 1 / EI and x / EI: its
angle and its displacement vanish outside of the element.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from beamviz.blade import STIFFNESSES, Blade
from beamviz.solver.solution import read_only
from beamviz.space.elements import Elements
from beamviz.space.grid import SMALL, Grid, Mesh, blocks, make_grid, reference
from beamviz.space.spans import AT_END

TAIL = 2  # functions in the tail of an element: one even, one odd
# Size of the ellipse around a piece through a pole of 1 / E I or 1 / E A from which the piece is
# not divided: the quadrature then gains 1.1 digits with each point.
LEAST_ELLIPSE = 3.5
MOST_ELLIPSE = 100.0  # where there is no pole: larger ones change no number of points
ELLIPSES = 1.5  # ratio of the ellipses of which the best bound is taken
# Wave number of the highest modes that an element resolves, over that of its order. Of 98 solves of
# blades 0.6 takes a fourth more time and 0.3 a tenth less, with errors up to 0.37 and 0.46 of their
# estimates, as here 0.37; with 0.15 two are larger, up to 18 times.
WAVES = 0.4


class Pieces(NamedTuple):
    """Pieces of elements, as arguments of `make_grid`, and the number of them in each element."""

    breaks: tuple[float, ...]
    orders: tuple[int, ...]
    counts: tuple[int, ...]


@lru_cache(maxsize=4)
def pieces_of(elements: Elements, blade: Blade | None, bending: str, share: float) -> Pieces:
    """The pieces of elements between the ends of the segments of a blade, shorter beside a pole of
    1 over its properties, with as many Gauss points as the trial functions need. share: of the
    energy of a mode that may be lost."""
    if blade is None:
        return Pieces(elements.breaks, elements.orders, (1,) * len(elements.orders))
    breaks, orders, counts = [0.0], [], []
    poles = poles_of(blade, bending)
    for (start, stop), order in zip(pairwise(elements.breaks), elements.orders, strict=True):
        inside = [x for x in blade.breaks if start + AT_END < x < stop - AT_END]
        ends = [start]
        for a, b in pairwise([start, *inside, stop]):
            here = poles_at(blade, poles, a, b)
            for end, ellipse in pieces_beside_poles(a, b, here):
                phase = order * (angle_of(ends[-1], start, stop) - angle_of(end, start, stop))
                phase += 2 * turn_between(blade, bending, ends[-1], end) / WAVES
                orders.append(gauss_points(phase, ellipse, share))
                ends.append(end)
        counts.append(len(ends) - 1)
        breaks += ends[1:]
    return Pieces(tuple(breaks), tuple(orders), tuple(counts))


@lru_cache(maxsize=4)
def poles_of(blade: Blade, bending: str) -> tuple[tuple[complex, ...], ...]:
    """The poles x of 1 over the stiffnesses of each segment of a blade."""
    rows = []
    for start, stop, polynomials in blade.segments:
        roots: list[complex] = []
        for name in (*STIFFNESSES[bending], "axial"):
            coefficients = polynomials[name].coef.tolist()
            if len(coefficients) == 2:
                constant, slope = coefficients
                roots += [-constant / slope] if slope else []
            else:
                roots += polynomials[name].roots().tolist()
        rows.append(tuple(start + (stop - start) * root for root in roots))
    return tuple(rows)


def poles_at(
    blade: Blade, poles: Sequence[tuple[complex, ...]], start: float, stop: float
) -> tuple[complex, ...]:
    """The poles of the segment that a piece is in."""
    middle = (start + stop) / 2
    return poles[sum(x <= middle for x in blade.breaks[1:-1])]


def pieces_beside_poles(
    start: float, stop: float, poles: tuple[complex, ...]
) -> list[tuple[float, float]]:
    """Ends of the pieces that a piece is divided into, none with a pole nearby, and the size of the
    ellipse around each through the nearest pole (Bernstein)."""
    places = [complex(2 * pole - start - stop) / (stop - start) for pole in poles]
    nearest = min((abs(z + (z - 1) ** 0.5 * (z + 1) ** 0.5) for z in places), default=MOST_ELLIPSE)
    if nearest >= LEAST_ELLIPSE:
        return [(stop, min(nearest, MOST_ELLIPSE))]
    middle = (start + stop) / 2
    parts = (start, middle), (middle, stop)
    return [row for part in parts for row in pieces_beside_poles(*part, poles)]


def angle_of(x: float, start: float, stop: float) -> float:
    """phi of x in an element: a polynomial of degree n has cos(n phi) as its waves."""
    return math.acos(min(max(2 * (x - start) / (stop - start) - 1, -1.0), 1.0))


def turn_between(blade: Blade, bending: str, start: float, stop: float) -> float:
    """The angle [rad] by which the section at the end of a piece is turned from that at its start;
    0 where bending is that in one plane."""
    if bending != "both" or blade.twist is None:
        return 0.0
    return abs(math.radians(float(blade.at("twist", stop, True) - blade.at("twist", start))))


def gauss_points(phase: float, ellipse: float, share: float) -> int:
    """The number of Gauss points in a piece that has this phase of the highest polynomial of its
    element, with no pole in an ellipse around it. Waves exp(i K z) times what has the pole are
    integrated by n points with an error of at most exp(K (rho - 1 / rho) / 2) rho^-2n on each
    ellipse rho within it. share: the error allowed, of squares of a mode."""
    K, left = WAVES * phase, math.log(1 / share)
    rho, least = 1.0, math.inf
    while rho < ellipse:
        rho = min(ELLIPSES * rho, ellipse)
        least = min(least, (left + K / 2 * (rho - 1 / rho)) / (2 * math.log(rho)))
    return math.ceil(max(least, phase / math.pi + 1))


class Block(NamedTuple):
    """The p points and the functions of an element, all in it. Matrices of all points and functions
    would hold little but zeros. Where the beam bends in both planes, functions of bending are
    (..., 2, p, functions): curvatures about the principal axes of the section."""

    points: slice
    along: slice  # numbers of the functions of stretch
    across: slice  # numbers of the functions of bending
    stretch: NDArray  # (..., p, functions of stretch)
    bending: NDArray  # (..., p, functions of bending)


@dataclass(frozen=True, eq=False)
class Trial:
    """Trial functions on the elements of a beam, with its properties at the Gauss points: n points,
    in all r functions of bending, of the orders of the elements, and of stretch of their axial
    orders. Or a stack of these for uniform beams, with other breaks, in leading axes.

    Where the beam bends in both planes there are 2 components, and 2 r functions. Their curvatures
    are those about the principal axes of the section, whose stiffnesses are EI (2 n,); those in the
    plane of rotation and out of it are turned back by the angle `turn` of the section.
    """

    elements: Elements  # of a stack those of the first
    mesh: Mesh  # of the pieces
    J: NDArray  # (..., n, n) integrates values at the points from the clamp to each point
    counts: tuple[int, ...]  # of pieces of each element
    mass: NDArray  # (..., n) rho A
    EI: NDArray  # (..., n), of both planes (2 n,)
    EA: NDArray  # (..., n)
    blocks: list[Block]  # of each element
    force: list[NDArray]  # of each element (..., p, tail): highest functions of the stretch at rest
    quadrature: float  # share of the elastic energy by which its integral may be wrong
    turn: NDArray | None = None  # (n,) [rad] of the section; None where it bends in one plane

    @property
    def components(self) -> int:
        """The number of planes that the beam bends in."""
        return 1 if self.turn is None else 2

    def turned(self, curvatures: NDArray, back: bool = False) -> NDArray:
        """Curvatures (..., 2 n, k) about the principal axes as those in the plane of rotation and
        out of it, or `back` from these; of one component as they are."""
        if self.turn is None:
            return curvatures
        c, s = np.cos(self.turn)[:, None], np.sin(self.turn)[:, None]
        s = -s if back else s
        n = len(self.turn)
        first, second = curvatures[..., :n, :], curvatures[..., n:, :]
        return np.concatenate((c * first - s * second, s * first + c * second), axis=-2)

    @property
    def grid(self) -> Grid:
        """The Gauss points of the pieces."""
        return self.mesh.grid

    @cached_property
    def rows(self) -> NDArray:
        """The functions of bending at the n points, and after them their integrals from the clamp
        (..., 2 n, r); of both components (4 n, 2 r), the integrals of turned curvatures."""
        if self.turn is not None:
            return self._rows_of_both
        *stack, n = self.grid.weights.shape
        rows = np.zeros((*stack, 2 * n, sum(self.elements.orders)))
        for points, _, across, _, bending in self.blocks:
            rows[..., points, across] = bending
            angle = rows[..., n:, across]
            angle[..., points, :] = self.J[..., points, points] @ bending
            whole = np.vecmat(self.grid.weights[..., points], bending)
            angle[..., points.stop :, :] = whole[..., None, :]
        return read_only(rows)

    @cached_property
    def _rows_of_both(self) -> NDArray:
        """`rows` of both components."""
        n = len(self.grid.weights)
        rows = np.zeros((4 * n, 2 * sum(self.elements.orders)))
        principal = rows[: 2 * n].reshape(2, n, -1)
        for points, _, across, _, bending in self.blocks:
            principal[:, points, across] = bending
        rows[2 * n :] = (self.J @ self.turned(rows[: 2 * n]).reshape(2, n, -1)).reshape(2 * n, -1)
        return read_only(rows)

    @cached_property
    def curvatures(self) -> NDArray:
        """The functions of bending (..., n, r), of both components turned: (2 n, 2 r)."""
        return self.turned(self.bending)

    @property
    def bending(self) -> NDArray:
        """The functions of bending (..., n, r)."""
        return self.rows[..., : self.rows.shape[-2] // 2, :]

    @property
    def angle(self) -> NDArray:
        """Integrals (..., n, r) of the functions of bending, from the clamp."""
        return self.rows[..., self.rows.shape[-2] // 2 :, :]

    @cached_property
    def stretch(self) -> NDArray:
        """The functions of stretch (..., n, functions)."""
        *stack, n = self.grid.weights.shape
        functions = np.zeros((*stack, n, sum(self.elements.axial_orders)))
        for block in self.blocks:
            functions[..., block.points, block.along] = block.stretch
        return read_only(functions)

    @cached_property
    def force_tails(self) -> NDArray:
        """Matrix (..., tails, n): the stretch at the points -> its coefficients of `force`."""
        *stack, n = self.grid.weights.shape
        rows = np.zeros((*stack, TAIL * len(self.blocks), n))
        weights = self.grid.weights * self.EA
        for k, (block, functions) in enumerate(zip(self.blocks, self.force, strict=True)):
            rows[..., TAIL * k : TAIL * (k + 1), block.points] = (
                functions * weights[..., block.points, None]
            ).mT
        return read_only(rows)

    @cached_property
    def tail_starts(self) -> NDArray:
        """The first of the tail of each element (elements,) among the functions of all tails."""
        return TAIL * np.arange(len(self.blocks))

    def by_element(self, energies: NDArray) -> NDArray:
        """Sums (..., elements) of energies (..., tails, k), for each k: (..., k, elements)."""
        return np.add.reduceat(energies, self.tail_starts, axis=-2).mT

    @cached_property
    def highest(self) -> list[tuple[NDArray, NDArray]]:
        """Numbers of the two highest functions of each element, of stretch and of bending."""
        return [
            (
                np.arange(along.stop - TAIL, along.stop),
                np.arange(across.stop - TAIL * self.components, across.stop),
            )
            for _, along, across, _, _ in self.blocks
        ]

    @cached_property
    def highest_of_all(self) -> tuple[NDArray, NDArray]:
        """Numbers of the highest functions of all elements, of stretch and of bending."""
        along, across = zip(*self.highest, strict=True)
        return np.concatenate(along), np.concatenate(across)

    @cached_property
    def tail_squares(self) -> NDArray:
        """Squares (..., 2 n, tails) of the highest functions of bending and of their integrals."""
        return read_only(self.rows[..., self.highest_of_all[1]] ** 2)

    @cached_property
    def stretch_tail_squares(self) -> NDArray:
        """Squares (..., n, tails) of the highest functions of stretch."""
        return read_only(self.stretch[..., self.highest_of_all[0]] ** 2)

    @cached_property
    def stretch_tails(self) -> NDArray:
        """Matrix (..., tails, n): the stretch at the points -> coefficients of these functions."""
        weights = (self.grid.weights * self.EA)[..., None]
        return read_only((weights * self.stretch[..., self.highest_of_all[0]]).mT)

    @cached_property
    def bending_weights(self) -> NDArray:
        """Weights of the points times E I (..., n), of both components (2 n,)."""
        weights = self.grid.weights
        return read_only((weights if self.turn is None else np.tile(weights, 2)) * self.EI)

    @cached_property
    def is_kinked(self) -> NDArray:
        """Whether each element (elements,) has several pieces, and more points than functions."""
        return np.array(self.counts) > 1

    @cached_property
    def has_kinks(self) -> bool:
        """Whether any element has."""
        return bool(self.is_kinked.any())

    def of_kinked(self, energies: NDArray) -> NDArray:
        """Sums (..., elements) of energies (..., n, k) at the points of the elements of several
        pieces, for each k: (..., k, elements)."""
        firsts = [block.points.start for block in self.blocks]
        return np.add.reduceat(energies, firsts, axis=-2).mT * self.is_kinked

    @cached_property
    def element_of_points(self) -> NDArray:
        """The number of the element of each point (n,)."""
        pieces = np.repeat(np.arange(len(self.counts)), self.counts)
        return np.repeat(pieces, self.grid.orders)


def make_trial(elements: Elements, blade: Blade | None, bending: str, share: float) -> Trial:
    """The trial functions on elements. bending: the property that is the bending stiffness, or
    "both"."""
    if blade is None:
        return uniform_trial(np.array(elements.breaks), elements)
    pieces = pieces_of(elements, blade, bending, share)
    grid = make_grid(np.array(pieces.breaks), pieces.orders)
    x = grid.points
    rho, EA = blade.at("mass", x), blade.at("axial", x)
    principal = np.stack([blade.at(name, x) for name in STIFFNESSES[bending]])  # (components, n)
    turn = np.radians(blade.at("twist", x)) if bending == "both" else None
    components = len(principal)
    parts, force = [], []
    ends = zip(_blocks(elements, pieces), pairwise(elements.breaks), strict=True)
    for (points, along, across), (start, stop) in ends:
        xi, w = (2 * x[points] - start - stop) / (stop - start), grid.weights[points]
        order = across.stop - across.start
        stretch = orthonormal(xi, w, EA[points], order)
        if turn is None:
            bending_functions = orthonormal(xi, w, principal[0, points], order)
        else:
            bending_functions = orthonormal_in_space(
                xi, w, principal[:, points], turn[points], order
            )
            across = slice(components * across.start, components * across.stop)
        modes_along = stretch[:, : along.stop - along.start]
        parts.append(Block(points, along, across, modes_along, bending_functions))
        force.append(stretch[:, -TAIL:])
    mesh = Mesh(grid, grid.integration_matrix)
    EI = principal.ravel()
    return Trial(elements, mesh, mesh.J, pieces.counts, rho, EI, EA, parts, force, share, turn)


def uniform_trial(breaks: NDArray, elements: Elements) -> Trial:
    """The trial functions of a uniform beam, or of a stack with breaks (..., elements + 1):
    Legendre polynomials. elements: of the first."""
    orders, axial_orders = elements.all_orders
    grid = make_grid(breaks, orders)
    halves = np.diff(breaks)[..., None, None] / 2
    columns = zip(blocks(orders), blocks(axial_orders), strict=True)
    parts, force = [], []
    for k, (points, along) in enumerate(columns):
        e = reference(orders[k])
        functions = e.legendre / np.sqrt(halves[..., k, :, :] * e.weights[:, None])
        stretch = functions[..., : axial_orders[k]]
        parts.append(Block(points, along, points, stretch, functions))
        force.append(functions[..., -TAIL:])
    ones = np.ones(grid.points.shape)
    mesh = Mesh(grid, grid.integration_matrix)
    return Trial(elements, mesh, mesh.J, (1,) * len(orders), ones, ones, ones, parts, force, 0.0)


def cached_trial(elements: Elements, blade: Blade | None, bending: str, share: float) -> Trial:
    """`make_trial`, where small cached for the next of many beams on the same elements. Those of
    uniform beams depend on the elements alone."""
    if blade is None:
        return _cached(elements, None, "", 1.0)
    small = sum(pieces_of(elements, blade, bending, share).orders) <= SMALL
    return (_cached if small else make_trial)(elements, blade, bending, share)


_cached = lru_cache(maxsize=4)(make_trial)


def orthonormal(xi: NDArray, w: NDArray, rigidity: NDArray, count: int) -> NDArray:
    """The first `count` polynomials over a rigidity (p,) that are orthonormal in the energy, at p
    points xi in -1 .. 1 with weights w: (p, count)."""
    P = legendre.legvander(xi, count - 1)
    Q, _ = np.linalg.qr(np.sqrt(w / rigidity)[:, None] * P)
    return Q / np.sqrt(w * rigidity)[:, None]


def orthonormal_in_space(
    xi: NDArray, w: NDArray, rigidities: NDArray, turn: NDArray, count: int
) -> NDArray:
    """Curvatures (2, p, 2 count) about the principal axes of a section, orthonormal in the energy,
    whose moments in the plane of rotation and out of it are the first `count` polynomials, by
    ascending degree. rigidities (2, p) about the axes, turn (p,) [rad] of these."""
    P = legendre.legvander(xi, count - 1)
    c, s = np.cos(turn)[:, None], np.sin(turn)[:, None]
    moments = np.stack((np.stack((c * P, s * P), -1), np.stack((-s * P, c * P), -1)))
    root = np.sqrt(w / rigidities)[:, :, None]
    Q, _ = np.linalg.qr((root * moments.reshape(2, len(xi), -1)).reshape(2 * len(xi), -1))
    return Q.reshape(2, len(xi), -1) / np.sqrt(w * rigidities)[:, :, None]


def _blocks(elements: Elements, pieces: Pieces) -> list[tuple[slice, slice, slice]]:
    """The points, the functions of stretch and those of bending of each element."""
    points = np.cumsum([0, *pieces.orders])[np.cumsum([0, *pieces.counts])]
    along, across = (np.cumsum([0, *row]) for row in (elements.axial_orders, elements.orders))
    rows = ((slice(*ends) for ends in pairwise(row.tolist())) for row in (points, along, across))
    return list(zip(*rows, strict=True))
