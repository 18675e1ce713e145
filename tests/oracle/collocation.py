"""Chebyshev collocation of linear first-order systems on elements, for the oracle.

Y' = C(x) Y, with rho Y' where there is mass. On each element Y - Y_left = h/2 Q (C Y) at the p
Chebyshev points and, as a step, at the right end: the integrated form, so that elements may be as
thin as the layers without loss of digits.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.polynomial.chebyshev import chebint, chebpts1, chebvander
from scipy.sparse import coo_array, csc_array

from beamviz import Beam
from beamviz.blade import Mass
from oracle import properties

Coefficients = dict[tuple[int, int], np.ndarray]  # Y_a' holds coefficient[a, b] Y_b; (elements, p)
Index = int | np.ndarray


@dataclass(frozen=True)
class Mesh:
    """Elements (left ends, lengths) with p Chebyshev points each, and where the bodies sit.

    d unknowns at the left end of each element and at its points, then at the tip. Of them the
    first d/2 vanish at the clamp, the last d/2 at the tip. Equations: the clamp; then for each
    element the p points and the step to the next element; then the tip.
    """

    lefts: np.ndarray  # (elements,)
    lengths: np.ndarray  # (elements,)
    points: int
    rho: np.ndarray  # (elements, p) line density
    bodies: tuple[tuple[int, Mass], ...]  # each at the right end of an element

    @cached_property
    def x(self) -> np.ndarray:
        """The collocation points (elements, p)."""
        return self.lefts[:, None] + self.lengths[:, None] / 2 * (chebpts1(self.points) + 1)

    @cached_property
    def Q(self) -> np.ndarray:  # noqa: N802
        """(p + 1, p): values at the points -> integrals from -1 to each point, and to 1."""
        p, xi = self.points, chebpts1(self.points)
        integrals = chebint(np.linalg.inv(chebvander(xi, p - 1)), lbnd=-1, axis=0)
        return chebvander(np.append(xi, 1.0), p) @ integrals

    def size(self, d: int) -> int:
        """Number of unknowns, and of equations."""
        return (len(self.lengths) * (self.points + 1) + 1) * d

    def unknown(self, d: int, e: Index, i: Index, a: Index) -> np.ndarray:
        """Place of unknown a at point i of element e; i = -1 is its left end."""
        return np.asarray((e * (self.points + 1) + i + 1) * d + a)

    def equation(self, d: int, e: Index, i: Index, a: Index) -> np.ndarray:
        """Place of equation a at point i of element e; i = p is the step to the next element."""
        return np.asarray((e * (self.points + 1) + i) * d + a + d // 2)

    def matrix(self, d: int, rows: Index, columns: Index, values: np.ndarray | float) -> csc_array:
        """The sparse square matrix with these entries, all broadcast together."""
        rows, columns, values = np.broadcast_arrays(rows, columns, values)
        entries = values.ravel(), (rows.ravel(), columns.ravel())
        return coo_array(entries, shape=(self.size(d), self.size(d))).tocsc()

    def at_points(self, y: np.ndarray, d: int) -> np.ndarray:
        """The unknowns at the points (elements, p, d)."""
        return y[:-d].reshape(len(self.lengths), self.points + 1, d)[:, 1:]

    def differences(self, d: int) -> csc_array:
        """Y - Y_left in each equation; clamp and tip."""
        e, i, a = np.ix_(range(len(self.lengths)), range(self.points + 1), range(d))
        row = self.equation(d, e, i, a)
        here = self.matrix(d, row, self.unknown(d, e, i, a), 1.0)
        left = self.matrix(d, row, self.unknown(d, e, -1, a), 1.0)
        n, half = self.size(d), np.arange(d // 2)
        clamp = self.matrix(d, half, half, 1.0)
        tip = self.matrix(d, n - 1 - half, n - 1 - half, 1.0)
        return here - left + clamp + tip

    def integral(self, d: int, coefficients: Coefficients) -> csc_array:
        """h/2 Q times the coefficients."""
        e, i, j = np.ix_(range(len(self.lengths)), range(self.points + 1), range(self.points))
        weights = self.lengths[:, None, None] / 2 * self.Q
        return sum(
            self.matrix(
                d, self.equation(d, e, i, a), self.unknown(d, e, j, b), weights * c[:, None, :]
            )
            for (a, b), c in coefficients.items()
        )

    def mass(self, d: int, units: dict[tuple[int, int], float]) -> csc_array:
        """Y_a' holds units[a, b] rho Y_b: spread over the beam, and a jump at each body."""
        total = self.integral(d, {pair: unit * self.rho for pair, unit in units.items()})
        for pair, unit in units.items():
            jumps = [unit * body.alpha for _, body in self.bodies]
            total = total + self.jumps(d, pair, jumps)
        return total

    def jumps(self, d: int, pair: tuple[int, int], sizes: list[float]) -> csc_array:
        """Y_a jumps by size times Y_b at each body, pair = (a, b)."""
        a, b = pair
        total = self.matrix(d, 0, 0, 0.0)
        for (element, _), size in zip(self.bodies, sizes, strict=True):
            row = self.equation(d, element, self.points, a)
            total = total + self.matrix(d, row, self.unknown(d, element + 1, -1, b), size)
        return total

    @cached_property
    def inertia(self) -> np.ndarray:
        """Weights (size(1),) that integrate with rho, of left ends, points and tip."""
        weights = np.zeros(self.size(1))
        self.at_points(weights, 1)[..., 0] = np.outer(self.lengths / 2, self.Q[-1]) * self.rho
        for element, body in self.bodies:
            weights[self.unknown(1, element + 1, -1, 0)] += body.alpha
        return weights


def refined_mesh(
    ends: list[float], beam: Beam, points: int, longest: Callable[[float, float, float], float]
) -> Mesh:
    """Elements from end to end, halved until the one of length h from x to x + h, at a distance to
    the nearest end, is no longer than longest(x, h, distance)."""
    found, todo = [], [(a, b - a) for a, b in pairwise(ends)]
    while todo:
        x, h = todo.pop()
        distance = min(max(end - x - h, x - end, 0.0) for end in ends)
        if h <= longest(x, h, distance):
            found.append((x, h))
        else:
            todo += [(x, h / 2), (x + h / 2, h / 2)]
    lefts, lengths = np.array(sorted(found)).T
    x = lefts[:, None] + lengths[:, None] / 2 * (chebpts1(points) + 1)
    rights = lefts + lengths
    bodies = tuple(
        (int(np.argmin(abs(rights - body.beta))), body) for body in beam.bodies if body.beta
    )
    return Mesh(lefts, lengths, points, properties.at(beam, "mass", x), bodies)
