"""The lowest eigenvalues of the collocated equations, for the oracle."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs, splu

LARGEST_DENSE = 900
STILL = 1e-6  # share of |omega| up to which a frequency is rounding
Linear = Callable[[np.ndarray], np.ndarray]


class UnresolvedError(Exception):
    """The oracle could not reach its own accuracy: it returns nothing rather than junk."""


class Pencil(NamedTuple):
    """A y = lambda B y + lambda^2 C y. B and C see the displacements s alone, so iterations run on
    them."""

    A: csc_array
    B: csc_array
    C: csc_array

    @property
    def moving(self) -> np.ndarray:
        """Where among the unknowns the displacements are."""
        return np.flatnonzero(np.diff((abs(self.B) + abs(self.C)).indptr))

    def dense(self, load: csc_array) -> np.ndarray:
        """Displacements under loads of B or C, as a full matrix."""
        places = self.moving
        if len(places) > LARGEST_DENSE:
            raise UnresolvedError(f"{len(places)} points: too many for all eigenvalues at once")
        return factorised(self.A)(load[:, places].toarray())[places]

    def refined(self, value: complex, s: np.ndarray) -> tuple[complex, np.ndarray]:
        """An eigenvalue to rounding by inverse iteration, with its y; the shift stays clear."""
        if np.isreal(value):
            value, s = value.real, s.real
        A, B, C = self
        places, y = self.moving, np.zeros(A.shape[0], s.dtype)
        y[places] = s
        for _ in range(6):
            shift = value * (1 - 1e-8)
            moved = factorised(A - shift * B - shift**2 * C)(B @ y + 2 * shift * (C @ y))
            s = y[places]
            previous, value = value, shift + np.vdot(s, s) / np.vdot(s, moved[places])
            y = moved / np.linalg.norm(moved[places])
            if abs(value - previous) < 1e-6 * abs(value):  # and each step gains eight digits
                return value, y
        raise UnresolvedError(f"inverse iteration about {value:g} does not settle")


def lowest(pencil: Pencil, modes: int) -> tuple[np.ndarray, np.ndarray]:
    """The smallest lambda, all positive, and their y (n, modes)."""
    places, solve = pencil.moving, factorised(pencil.A)
    load = pencil.B[:, places]
    nu, shapes = largest(lambda s: solve(load @ s)[places], modes, len(places))
    if np.any(nu.real <= 0) or np.any(np.abs(nu.imag) > 1e-9 * np.abs(nu)):
        raise UnresolvedError(f"eigenvalues {1 / nu} are not real and positive")
    pairs = [pencil.refined(1 / nu[k], shapes[:, k]) for k in np.argsort(-nu)]
    values, Y = zip(*pairs, strict=True)
    return np.array(values), np.column_stack(Y)


def lowest_indefinite(pencil: Pencil, modes: int, least: float) -> np.ndarray:
    """The smallest lambda, negative ones first; none is below `least`."""
    with np.errstate(divide="ignore"):
        nu, shapes = np.linalg.eig(pencil.dense(pencil.B))
        values = 1 / nu
    picks = smallest(values.real, np.abs(nu.imag) <= 1e-6 * np.abs(nu), least, modes)
    return np.array([pencil.refined(values[k].real, shapes[:, k])[0] for k in picks])


def lowest_gyroscopic_indefinite(pencil: Pencil, modes: int, least: float) -> np.ndarray:
    """The smallest omega^2 by all eigenvalues; each comes as omega and -omega, so that every other
    one is kept."""
    RB, RC = (pencil.dense(matrix) for matrix in (pencil.B, pencil.C))
    n, unit = len(RC), np.sqrt(np.linalg.norm(RC, 2))
    Z = np.block([[np.zeros((n, n)), unit * np.eye(n)], [RC / unit, RB]])
    nu, shapes = np.linalg.eig(Z)
    picks = smallest(squares(1 / nu), np.ones(2 * n, bool), least, 2 * modes)[::2]
    return squares(np.array([pencil.refined(1 / nu[k], shapes[:n, k])[0] for k in picks]))


def squares(omega: np.ndarray) -> np.ndarray:
    """omega^2 where it is real; where the motion grows while it swings minus the square of its rate
    of growth."""
    square = omega**2
    swings = np.abs(square.imag) > 1e-7 * np.abs(square)
    return np.where(swings, -(omega.imag**2), square.real)


def smallest(values: np.ndarray, kept: np.ndarray, least: float, count: int) -> np.ndarray:
    """Where the `count` smallest of the values kept are, none below `least`: those are noise."""
    places = np.flatnonzero(kept & (values >= least))
    return places[np.argsort(values[places], kind="stable")][:count]


def lowest_gyroscopic(pencil: Pencil, modes: int, unit_of_omega: complex = 1) -> np.ndarray:
    """The lowest omega = lambda * unit by their real parts, of each pair the one that swings
    forward, or grows: with t = nu s and nu = 1 / lambda, nu t = A^-1 (B t + C s)."""
    places, solve = pencil.moving, factorised(pencil.A)
    B, C = pencil.B[:, places], pencil.C[:, places]
    n = len(places)
    unit = np.sqrt(np.linalg.norm(solve(C @ np.ones(n))[places]) / np.sqrt(n))

    def inverse(st: np.ndarray) -> np.ndarray:
        s, t = st[:n], st[n:]
        return np.append(unit * t, solve(B @ t + C @ s / unit)[places])

    nu, shapes = largest(inverse, 2 * (modes + 4), 2 * n)
    omega = unit_of_omega / nu
    still = abs(omega.real) <= STILL * abs(omega)
    forward = np.where(still, omega.imag < 0, omega.real > 0)
    found = [k for k in np.lexsort((omega.imag, omega.real.round(9))) if forward[k]][:modes]
    values = [pencil.refined(1 / nu[k], shapes[:n, k])[0] for k in found]
    return unit_of_omega * np.array(values)


def factorised(matrix: csc_array) -> Linear:
    """b -> the solution of matrix y = b."""
    return splu(matrix.tocsc(), permc_spec="NATURAL").solve  # a band already


def largest(apply: Linear, modes: int, size: int) -> tuple[np.ndarray, np.ndarray]:
    """The largest eigenvalues and vectors of a linear function of vectors."""
    operator = LinearOperator((size, size), apply, dtype=float)
    try:
        return eigs(operator, modes, v0=np.ones(size), ncv=2 * modes + 12, tol=1e-12)
    except ArpackNoConvergence as error:
        raise UnresolvedError(f"Arnoldi process: {error}") from None


def sign_changes(w: np.ndarray) -> int:
    """How often w changes its sign, but for noise."""
    w = w[np.abs(w) > 1e-9 * np.max(np.abs(w))]
    return int(np.sum(w[1:] * w[:-1] < 0))
