"""Chebyshev collocation of linear first-order systems on elements, for the oracle.

Y' = C(x) Y, with rho Y' where there is mass. On each element Y - Y_left = h/2 Q (C Y) at the p
Chebyshev points and, as a step, at the right end: the integrated form, so that elements may be as
thin as the layers without loss of digits.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from scipy.sparse import coo_array, csc_array

Coefficients = dict[tuple[int, int], np.ndarray]  # Y_a' holds coefficient[a, b] Y_b; (elements, p)
Index = int | np.ndarray


@dataclass(frozen=True)
class Displacements:
    """Where among the unknowns the displacements with inertia are, and that inertia."""

    places: np.ndarray  # (k,)
    inertia: np.ndarray  # (k,)

    def weighted(self, y: np.ndarray) -> np.ndarray:
        """The displacements in y times the root of their inertia."""
        return np.sqrt(self.inertia) * y[self.places]

    def lift(self, n: int) -> csc_array:
        """Weighted displacements -> n unknowns."""
        k = len(self.places)
        return csc_array((1 / np.sqrt(self.inertia), (self.places, np.arange(k))), shape=(n, k))


@dataclass(frozen=True)
class Mesh:
    """Elements (left ends, lengths) with p Chebyshev points each, and where the mass sits.

    d unknowns at the left end of each element and at its points, then at the tip. Of them the
    first d/2 vanish at the clamp, the last d/2 at the tip. Equations: the clamp; then for each
    element the p points and the step to the next element; then the tip.
    """

    lefts: np.ndarray  # (elements,)
    lengths: np.ndarray  # (elements,)
    points: int
    alpha: float
    mass_element: int | None  # the mass sits at the right end of this element
    Q: np.ndarray  # (p + 1, p) values -> integrals from -1 to each point, and to 1

    @property
    def x(self) -> np.ndarray:
        """The collocation points (elements, p)."""
        return self.lefts[:, None] + self.lengths[:, None] / 2 * (chebyshev_points(self.points) + 1)

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
        """Y_a' holds units[a, b] rho Y_b: spread over the beam, and a jump at the mass."""
        ones = np.ones((len(self.lengths), self.points))
        total = self.integral(d, {pair: unit * ones for pair, unit in units.items()})
        if self.mass_element is None:
            return total
        for (a, b), unit in units.items():
            row = self.equation(d, self.mass_element, self.points, a)
            column = self.unknown(d, self.mass_element + 1, -1, b)
            total = total + self.matrix(d, row, column, unit * self.alpha)
        return total

    def moving(self, d: int, displacements: tuple[int, ...]) -> Displacements:
        """The unknowns numbered in `displacements` at the points and at the mass."""
        e, i = np.ix_(range(len(self.lengths)), range(self.points))
        places = self.unknown(d, e, i, 0).ravel()
        inertia = np.outer(self.lengths / 2, self.Q[-1]).ravel()
        if self.mass_element is not None:
            places = np.append(places, self.unknown(d, self.mass_element + 1, -1, 0))
            inertia = np.append(inertia, self.alpha)
        return Displacements(
            np.concatenate([places + a for a in displacements]),
            np.tile(inertia, len(displacements)),
        )


def chebyshev_points(p: int) -> np.ndarray:
    """The roots of the p-th Chebyshev polynomial, ascending."""
    return -np.cos((2 * np.arange(p) + 1) * np.pi / (2 * p))


def integration(p: int) -> np.ndarray:
    """(p + 1, p): values at the points -> integrals from -1 to each point, and to 1."""
    xi = chebyshev_points(p)
    to_coefficients = np.linalg.inv(chebyshev.chebvander(xi, p - 1))
    integrals = chebyshev.chebint(np.eye(p), lbnd=-1, axis=0) @ to_coefficients
    return chebyshev.chebvander(np.append(xi, 1.0), p) @ integrals
