"""The lowest eigenvalues of the collocated equations, for the oracle."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs, splu

from oracle.collocation import Displacements

LARGEST_DENSE = 900
STILL = 1e-6  # share of |s| up to which a frequency is rounding
Linear = Callable[[np.ndarray], np.ndarray]


class UnresolvedError(Exception):
    """The oracle could not reach its own accuracy: it returns nothing rather than junk."""


class Pencil(NamedTuple):
    """A y = lambda B y, or with C the problem A y = omega C y + omega^2 B y.

    B and C see the displacements s alone, so iterations run on them, weighted by the root of their
    inertia: Green's function is symmetric, and in these variables nearly so is its matrix.
    """

    A: csc_array
    B: csc_array
    moving: Displacements
    C: csc_array | None = None

    def load(self, matrix: csc_array) -> csc_array:
        """B or C as a matrix of weighted displacements."""
        return matrix @ self.moving.lift(self.A.shape[0])

    def dense(self, load: csc_array) -> np.ndarray:
        """Weighted displacements under loads, as a full matrix."""
        if load.shape[1] > LARGEST_DENSE:
            raise UnresolvedError(f"{load.shape[1]} points: too many for all eigenvalues at once")
        y = factorised(self.A)(load.toarray())
        return np.sqrt(self.moving.inertia)[:, None] * y[self.moving.places]

    def refined(self, value: complex, s: np.ndarray) -> tuple[complex, np.ndarray]:
        """An eigenvalue to rounding by inverse iteration, with its y; the shift stays clear."""
        B, C = self.load(self.B), None if self.C is None else self.load(self.C)
        for _ in range(6):
            shift = value * (1 - 1e-8)
            if C is None:
                y = factorised(self.A - shift * self.B)(B @ s)
            else:
                shifted = self.A - shift * self.C - shift**2 * self.B
                y = factorised(shifted)(C @ s + 2 * shift * (B @ s))
            moved = self.moving.weighted(y)
            previous, value = value, shift + np.vdot(s, s) / np.vdot(s, moved)
            s = moved / np.linalg.norm(moved)
            if abs(value - previous) < 1e-6 * abs(value):  # and each step gains eight digits
                return value, y
        raise UnresolvedError(f"inverse iteration about {value:g} does not settle")


def lowest(pencil: Pencil, modes: int) -> tuple[np.ndarray, np.ndarray]:
    """The smallest lambda, all positive, and their y (n, modes)."""
    load, solve, moving = pencil.load(pencil.B), factorised(pencil.A), pencil.moving
    start = np.sqrt(moving.inertia)
    nu, shapes = real(*largest(lambda s: moving.weighted(solve(load @ s)), modes, start))
    if np.any(nu <= 0):
        raise UnresolvedError(f"eigenvalues {1 / nu} are not positive")
    pairs = [pencil.refined(1 / nu[k], shapes[:, k]) for k in np.argsort(-nu)]
    values, Y = zip(*pairs, strict=True)
    return np.array(values), np.column_stack(Y)


def lowest_indefinite(pencil: Pencil, modes: int, least: float) -> np.ndarray:
    """The smallest lambda, negative ones first; none is below `least`."""
    with np.errstate(divide="ignore"):
        nu, shapes = np.linalg.eig(pencil.dense(pencil.load(pencil.B)))
        values = 1 / nu
    picks = smallest(values.real, np.abs(nu.imag) <= 1e-6 * np.abs(nu), least, modes)
    return np.array([pencil.refined(values[k].real, shapes[:, k].real)[0] for k in picks])


def lowest_gyroscopic_indefinite(pencil: Pencil, modes: int, least: float) -> np.ndarray:
    """The smallest omega^2; where omega is complex (the motion grows while it swings) minus the
    square of its rate of growth.

    omega comes with -omega and with its conjugate, so of all squares every other one is kept.
    """
    RB, RC = (pencil.dense(pencil.load(matrix)) for matrix in (pencil.B, pencil.C))
    n, unit = len(RB), np.sqrt(np.linalg.norm(RB, 2))
    Z = np.block([[np.zeros((n, n)), unit * np.eye(n)], [RB / unit, RC]])
    nu, shapes = np.linalg.eig(Z)
    picks = smallest(growing(1 / nu), np.ones(2 * n, bool), least, 2 * modes)[::2]
    shapes = shapes[:n].astype(complex)
    return growing(np.array([pencil.refined(complex(1 / nu[k]), shapes[:, k])[0] for k in picks]))


def growing(omega: np.ndarray) -> np.ndarray:
    """omega^2 where it is real, otherwise minus the square of the rate of growth."""
    square = omega**2
    swings = np.abs(square.imag) > 1e-7 * np.abs(square)
    return np.where(swings, -(omega.imag**2), square.real)


def smallest(values: np.ndarray, kept: np.ndarray, least: float, count: int) -> np.ndarray:
    """Where the `count` smallest of the values kept are, none below `least`: those are noise."""
    places = np.flatnonzero(kept & (values >= least))
    return places[np.argsort(values[places], kind="stable")][:count]


def lowest_gyroscopic(pencil: Pencil, modes: int) -> np.ndarray:
    """The smallest omega > 0; they come in pairs +-omega."""
    nu, shapes = real(*inverse_pairs(pencil, modes))
    forward = [k for k in np.argsort(-nu) if nu[k] > 0]
    if len(forward) != modes:
        raise UnresolvedError(f"frequencies {1 / nu} do not come in pairs")
    return np.array([pencil.refined(1 / nu[k], shapes[:, k])[0] for k in forward])


def lowest_growing(pencil: Pencil, modes: int) -> np.ndarray:
    """The lowest complex eigenvalues s = growth + i omega by omega, of each pair the one that
    swings forward, or grows."""
    nu, shapes = inverse_pairs(pencil, modes + 4)
    s = 1 / nu
    forward = np.where(abs(s.imag) <= STILL * abs(s), s.real > 0, s.imag > 0)
    lowest = [k for k in np.lexsort((-s.real, s.imag.round(9))) if forward[k]][:modes]
    return np.array([pencil.refined(s[k], shapes[:, k])[0] for k in lowest])


def inverse_pairs(pencil: Pencil, modes: int) -> tuple[np.ndarray, np.ndarray]:
    """nu = 1 / omega of twice as many eigenvalues and their displacements s: with t = nu s, nu t =
    A^-1 (C t + B s)."""
    B, C = (pencil.load(matrix) for matrix in (pencil.B, pencil.C))
    solve, weighted = factorised(pencil.A), pencil.moving.weighted
    start = np.sqrt(pencil.moving.inertia)
    n = len(start)
    unit = np.sqrt(np.linalg.norm(weighted(solve(B @ start))) / np.linalg.norm(start))

    def inverse(st: np.ndarray) -> np.ndarray:
        s, t = st[:n], st[n:]
        return np.append(unit * t, weighted(solve(C @ t + B @ s / unit)))

    nu, shapes = largest(inverse, 2 * modes, np.append(start, start))
    return nu, shapes[:n]


def factorised(matrix: csc_array) -> Linear:
    """b -> the solution of matrix y = b."""
    return splu(matrix.tocsc(), permc_spec="NATURAL").solve  # a band already


def largest(apply: Linear, modes: int, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The largest eigenvalues and vectors of a linear function of vectors."""
    operator = LinearOperator((len(start),) * 2, apply, dtype=float)
    try:
        return eigs(operator, modes, which="LM", v0=start, ncv=4 * modes + 4, tol=1e-12)
    except ArpackNoConvergence as error:
        raise UnresolvedError(f"Arnoldi process: {error}") from None


def real(nu: np.ndarray, shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues that are real but for rounding, and their vectors."""
    if np.any(np.abs(nu.imag) > 1e-9 * np.abs(nu)):
        raise UnresolvedError(f"eigenvalues {1 / nu} are not real")
    return nu.real, shapes.real


def sign_changes(w: np.ndarray) -> int:
    """How often w changes its sign, but for noise."""
    w = w[np.abs(w) > 1e-9 * np.max(np.abs(w))]
    return int(np.sum(w[1:] * w[:-1] < 0))
