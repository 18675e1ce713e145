"""Integrators, as a table: each is a set of coefficients for one kind of step.

In a step of length h the acceleration is a combination of unknown vectors X (s, n) and, in the
methods of Newmark's family, of the acceleration before. With c the instants of the stages in units
of h,

    a(c) = P X + p a0,    v(c) = v0 + h (E X + e a0),    q(c) = q0 + h c v0 + h^2 (D X + d a0),

and X solves W R = 0, with R (k, n) the residuals of the equation of motion at the k stages. Three
families are of this form:

collocation    a(tau) is a polynomial of degree s - 1, and R = 0 at s points: Gauss or Radau
energy         the same polynomial, and R orthogonal to all polynomials of that degree, by Gauss
               quadrature with k > s points: the line integral of the forces is exact to quadrature,
               so that the Jacobi integral is kept (Hairer 2010; Brugnano, Iavernaro & Trigiante
               2010, HBVM(k, s)); k = s is Gauss collocation
Newmark        s = 1: X is the acceleration after the step; residual at the end (trapezoidal rule),
               or between (generalised-alpha, Chung & Hulbert 1993)
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.special import roots_jacobi


@dataclass(frozen=True, eq=False)
class Scheme:
    """The coefficients of a step. c: (k,). W: (s, k). P, E, D: (k, s) of the stages and p, e, d:
    (k,); end_...: the same of the end of the step. order: of convergence of smooth motions.

    twice: where X are coefficients of the orthonormal Legendre polynomials of the step, (s, s):
    those of q' are twice @ X h, and v0; None in Newmark's family.
    """

    c: NDArray
    W: NDArray
    P: NDArray
    E: NDArray
    D: NDArray
    end_P: NDArray  # (s,)
    end_E: NDArray
    end_D: NDArray
    order: int
    twice: NDArray | None = None
    p: NDArray | float = 0.0
    e: NDArray | float = 0.0
    d: NDArray | float = 0.0
    end_p: float = 0.0
    end_e: float = 0.0
    end_d: float = 0.0


def legendre_integrals(c: NDArray, s: int) -> tuple[NDArray, NDArray]:
    """The orthonormal Legendre polynomials of degree 0 .. s - 1 on 0 .. 1 at c, and their integrals
    from 0: (len(c), s) each."""
    P = np.diag(np.sqrt(2 * np.arange(s) + 1.0))
    E = legendre.legint(P, lbnd=-1, scl=0.5)  # d tau = dz / 2
    z = 2 * np.asarray(c, float) - 1
    return legendre.legval(z, P).T, legendre.legval(z, E).T


def polynomial_scheme(c: NDArray, weights: NDArray | None, s: int, order: int) -> Scheme:
    """Collocation at c where there are no weights, else projection onto s polynomials. q' = v holds
    in the same sense as the equation of motion, so that D is E times the projection of E: a
    polynomial of a higher degree, with q' = v everywhere, would not be stable."""
    P, E = legendre_integrals(c, s)
    projection = np.linalg.inv(P) if weights is None else P.T * weights
    W = np.eye(len(c)) if weights is None else projection
    end_P, end_E = (array[0] for array in legendre_integrals(np.ones(1), s))
    twice = projection @ E  # (s, s)
    return Scheme(c, W, P, E, E @ twice, end_P, end_E, end_E @ twice, order, twice)


def energy(s: int, k: int) -> Scheme:
    z, w = legendre.leggauss(k)
    return polynomial_scheme((z + 1) / 2, w / 2, s, 2 * s)


def radau(s: int) -> Scheme:
    """Radau IIA: collocation at s points of which the last is the end of the step."""
    inner = (roots_jacobi(s - 1, 1, 0)[0] + 1) / 2
    return polynomial_scheme(np.append(inner, 1.0), None, s, 2 * s - 1)


def newmark(rho: float | None) -> Scheme:
    """The trapezoidal rule, or with `rho`, the spectral radius at infinite frequency,
    generalised-alpha."""
    am, af = (0.0, 0.0) if rho is None else ((2 * rho - 1) / (rho + 1), rho / (rho + 1))
    gamma = 0.5 - am + af
    beta = (1 - am + af) ** 2 / 4
    E, D, e, d = gamma, beta, 1 - gamma, 0.5 - beta

    def one(value: float) -> NDArray:
        return np.array([[value]])

    return Scheme(
        c=np.array([1 - af]),
        W=one(1.0),
        P=one(1 - am),
        E=one((1 - af) * E),
        D=one((1 - af) * D),
        end_P=np.ones(1),
        end_E=np.array([E]),
        end_D=np.array([D]),
        order=2,
        p=am,
        e=(1 - af) * e,
        d=(1 - af) * d,
        end_e=e,
        end_d=d,
    )


class Integrator(NamedTuple):
    """A row of the table. scheme: builds its coefficients. source: publication. choose: when to use
    it."""

    scheme: Callable[[], Scheme]
    source: str
    choose: str


INTEGRATORS = {
    "energy": Integrator(
        lambda: energy(STAGES, 2 * STAGES),
        "energy-keeping collocation (Hairer 2010; Brugnano, Iavernaro & Trigiante 2010)",
        "unless you are studying another integrator",
    ),
    "gauss": Integrator(
        lambda: energy(STAGES, STAGES),
        "Gauss collocation, symplectic (Kuntzmann 1961; Butcher 1964)",
        "to see what is lost without the exact line integral",
    ),
    "radau": Integrator(
        lambda: radau(5),
        "Radau IIA of order 9 (Ehle 1969; Hairer & Wanner 1999)",
        "where fast vibration is to be damped numerically",
    ),
    "generalised-alpha": Integrator(
        lambda: newmark(0.8),
        "Chung & Hulbert 1993, spectral radius 0.8",
        "to compare with structural codes",
    ),
    "trapezoidal": Integrator(
        lambda: newmark(None),
        "Newmark 1959, beta 1/4, gamma 1/2",
        "to see it fail: stable for linear problems only",
    ),
}
STAGES = 4


@lru_cache(maxsize=16)
def scheme(name: str) -> Scheme:
    """The coefficients of an integrator by name."""
    return INTEGRATORS[name].scheme()
