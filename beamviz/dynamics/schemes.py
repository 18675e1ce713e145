"""Integrators, as a table: each is a set of coefficients for one kind of step.

In a step of length h the unknowns are the accelerations X (s, n) at s stages and, in the methods of
Newmark's family, that at the end, of which the one before is known. With c the instants of the
stages in units of h,

    a(c) = P X + p a0,    v(c) = v0 + h (E X + e a0),    q(c) = q0 + h c v0 + h^2 (D X + d a0),

and X makes the residuals of the equation of motion vanish at the s stages. Two families are of this
form:

collocation    a(tau) is a polynomial of degree s - 1 through X: the Runge-Kutta methods of Gauss
               and Radau, whose matrix is E, with D = E^2
Newmark        s = 1: X is the acceleration after the step; the residual at the end (trapezoidal
               rule), or between (generalised-alpha, Chung & Hulbert 1993)

P, E and D commute: with their eigenvectors Newton's method falls apart into s / 2 complex systems
of the size of the equation of motion.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import roots_jacobi, roots_legendre

from beamviz.dynamics.polynomials import legendre_integrals


@dataclass(frozen=True, eq=False)
class Scheme:
    """The coefficients of a step. c: (s,). P, E, D: (s, s) and p, e, d of the stages. order: of
    convergence of smooth motions.

    polynomial: of a method of collocation, the coefficients of the orthonormal Legendre polynomials
    of the step from the values at the stages (s, s); None in Newmark's family.
    """

    c: NDArray
    P: NDArray
    E: NDArray
    D: NDArray
    order: int
    polynomial: NDArray | None = None
    p: float = 0.0
    e: float = 0.0
    d: float = 0.0
    end: tuple[float, ...] = ()  # E, D, e and d of the end of the step, in Newmark's family

    def modes(self) -> tuple[NDArray, NDArray, NDArray]:
        """Eigenvectors of E, one of each pair: rows (i, s) into them, columns (s, i) back, of which
        the real part is to be taken, and the values of P, E and D (3, i)."""
        values, T = np.linalg.eig(self.E)
        one = values.imag >= 0
        inverse = np.linalg.inv(T)
        found = [np.diag(inverse @ A @ T)[one] for A in (self.P, self.E, self.D)]
        back = T[:, one] * np.where(values[one].imag > 0, 2, 1)
        return inverse[one], back, np.array(found)


def collocation(c: NDArray, order: int) -> Scheme:
    """The method of collocation at the instants c (s,) of a step."""
    P, integrals = legendre_integrals(c, len(c))
    polynomial = np.linalg.inv(P)
    E = integrals @ polynomial
    return Scheme(c, np.eye(len(c)), E, E @ E, order, polynomial)


def radau(s: int) -> Scheme:
    """Radau IIA of s stages, the last of which is the end of the step."""
    inner, _ = roots_jacobi(s - 1, 1.0, 0.0)
    return collocation(np.append((inner + 1) / 2, 1.0), 2 * s - 1)


def gauss(s: int) -> Scheme:
    """Gauss collocation of s stages, all within the step."""
    points, _ = roots_legendre(s)
    return collocation((points + 1) / 2, 2 * s)


def newmark(rho: float | None) -> Scheme:
    """The trapezoidal rule, or with `rho`, the spectral radius at infinite frequency,
    generalised-alpha."""
    am, af = (0.0, 0.0) if rho is None else ((2 * rho - 1) / (rho + 1), rho / (rho + 1))
    E = 0.5 - am + af
    D = (1 - am + af) ** 2 / 4
    e, d = 1 - E, 0.5 - D

    def one(value: float) -> NDArray:
        return np.array([[value]])

    return Scheme(
        c=np.array([1 - af]),
        P=one(1 - am),
        E=one((1 - af) * E),
        D=one((1 - af) * D),
        order=2,
        p=am,
        e=(1 - af) * e,
        d=(1 - af) * d,
        end=(E, D, e, d),
    )


class Integrator(NamedTuple):
    """A row of the table. scheme: builds its coefficients. source: publication. choose: when to use
    it."""

    scheme: Callable[[], Scheme]
    source: str
    choose: str


STAGES = 10
INTEGRATORS = {
    "radau": Integrator(
        lambda: radau(STAGES),
        "Radau IIA of order 19 (Ehle 1969; Hairer & Wanner 1999)",
        "unless you are studying another: fast vibration that the steps do not resolve is damped,"
        " what they resolve keeps its energy",
    ),
    "gauss": Integrator(
        lambda: gauss(STAGES),
        "Gauss collocation of order 20 (Kuntzmann 1961; Butcher 1964)",
        "to see what is lost without numerical damping",
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


@lru_cache(maxsize=16)
def scheme(name: str) -> Scheme:
    """The coefficients of an integrator by name."""
    return INTEGRATORS[name].scheme()
