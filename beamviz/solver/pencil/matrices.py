"""What a pencil consists of, and the record of its modes."""

from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

EPS = float(np.finfo(float).eps)  # 2.2e-16
TINY = 1e-300  # keeps a quotient finite whose denominator vanishes where modes coalesce

# What is known of a stiffness beforehand. "semidefinite": its least eigenvalue may be as small as
# one likes, or zero; "indefinite": it may be negative.
Definiteness = Literal["definite", "semidefinite", "indefinite"]


class Family(NamedTuple):
    """Matrices of one family of motions, of a stack of beams."""

    K: NDArray | None  # (beams, n, n) stiffness without softening; None: the identity
    M: NDArray | None = None  # (beams, n, n) mass matrix; None: F' F
    F: NDArray | None = None  # (beams, m, n) displacements times the root of the mass, M = F' F

    @property
    def mass(self) -> NDArray:
        """M (beams, n, n)."""
        if self.M is not None:
            return self.M
        assert self.F is not None
        return self.F.mT @ self.F


class Families(NamedTuple):
    """Two families of motions of a stack of beams, across the beam (b) and along it (a).

    With Coriolis forces, gamma, they are coupled: C = 2 gamma [[0, -Fa' Fb], [Fb' Fa, 0]] for
    q = (a, b), where the rows of Fa and Fb are displacements at common points. K is that of the
    families less softening times M.
    """

    across: Family
    along: Family
    softening: NDArray  # (beams, 2, 1) of the family across the beam, and of that along it
    gamma: NDArray | None = None  # (beams, 1, 1) speed, times the factor of the Coriolis forces
    definiteness: Definiteness = "definite"  # of K across the beam, without softening
    # (beams,) number of the lowest modes that are rigid motions that nothing holds: s = 0
    rigid: NDArray | None = None
    # (beams, 2, 1) what K of a family is already less by, in units of M: its digits cancel
    cancelled: NDArray | None = None
    # Of frequencies, relative: where rounding errors are above a tenth of it, a slower and more
    # accurate algorithm is used.
    tolerance: float = 1e-7


class Pencil:
    """K, M and C (n, n) of one beam, each a dense or a sparse matrix.

    symmetric: whether K is symmetric and C, if any, skew; F (m, n): a factor of M = F' F.
    softening: the multiple of M that K is less by, in which its digits cancel.
    """

    def __init__(
        self,
        K: Any,
        M: Any,
        C: Any = None,
        F: NDArray | None = None,
        symmetric: bool = True,
        softening: float = 0.0,
    ):
        self.K, self.M, self.C, self.F = K, M, C, F
        self.symmetric, self.softening = symmetric, softening

    @cached_property
    def factor(self) -> NDArray | None:
        """L (n, n) of a dense K = L L'; None where K is not positive definite."""
        L, failed = lapack.dpotrf(self.K, lower=1)
        return None if failed else L


class Modes(NamedTuple):
    """The lowest modes of a pencil, or of each pencil of a stack.

    Of two uncoupled families arrays are (beams, 2, count), those across the beam first; where a
    family has fewer modes the others are nan.
    """

    # (..., count) -s^2, by ascending frequency; complex where a mode has a frequency and a growth
    # rate
    omega_squared: NDArray
    # (..., n, count), complex with Coriolis forces or an unsymmetric K, of unit modal mass; of two
    # families a pair (across, along)
    V: Any
    rounding: NDArray  # (..., count) estimated rounding error of y* T(s) v, y the left vector
    definite: bool  # whether K is known to be positive definite
    # (..., count) |y* T'(s) v|, small where modes coalesce: s changes by y* T(s) v over it
    pairing: NDArray
    fraction: NDArray | None = None  # (..., count) of coupled families: share of b in the mass
    rigid: NDArray | None = None  # (..., count) whether a mode is a rigid motion, where any may be
    all_s: NDArray | None = None  # of more modes than asked for, in which an instability is seen

    @property
    def s(self) -> NDArray:
        """Growth rate + i frequency (..., count), with Im s > 0 or Re s >= 0."""
        s = exponents(self.omega_squared)
        return np.where(s.imag < 0, -s, s)

    @property
    def rounding_of_s(self) -> NDArray:
        """Estimated rounding error of s (..., count)."""
        return self.rounding / np.maximum(self.pairing, TINY)


def exponents(omega_squared: NDArray) -> NDArray:
    """s (...), growth rate + i frequency, of modes that either vibrate or grow."""
    return np.sqrt(-omega_squared + 0j)


def product(A: Any, V: NDArray) -> NDArray:
    """A V of a real matrix A (k, n) and vectors V (n, modes), which may be complex: numpy would
    make the matrix complex, a copy of twice its size."""
    if V.dtype != complex:
        return A @ V
    V = np.ascontiguousarray(V)
    return (A @ V.view(float)).view(V.dtype)
