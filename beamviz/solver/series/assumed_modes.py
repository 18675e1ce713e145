"""Assumed modes: the modes of the beam at rest without a mass, as the basis for everything else.

Yoo & Shin (J. Sound Vib. 212, 1998) and, with a mass anywhere, Yoo, Seo & Huh (2002): linear
equations in w and u with the tension of the rigid reference length, Coriolis coupling on request.
The shapes stand as in the textbooks, cosh bx - cos bx - s (sinh bx - sin bx): cosh and sinh cancel
to one part in e^b, so that digits go from the eighth mode on and none is left at the twelfth.
An interior mass bends the beam sharply where no basis function does: convergence is slow there.
"""

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from beamviz.beam import Beam
from beamviz.solver import constitutive, eigen
from beamviz.solver.eigen import gyroscopic_modes
from beamviz.solver.problem import Problem
from beamviz.solver.series.families import Family, Modes, merged

NEWTON_ITERATIONS = 8


class Basis(NamedTuple):
    """Values and derivatives of basis functions at points: (len(x), terms) each."""

    value: np.ndarray
    slope: np.ndarray
    curvature: np.ndarray


class Forms(NamedTuple):
    """Stiffness without softening, and displacements: M = F' F."""

    K: np.ndarray  # (terms, terms)
    F: np.ndarray  # (points, terms)


def assumed_modes(beam: Beam, problem: Problem, terms: int, modes: int) -> Modes:
    """The lowest `modes` modes on `terms` functions across the beam and as many along it."""
    x, weights = quadrature(beam, terms)
    across, along = clamped_free(terms, x), fixed_free(terms, x)
    N = constitutive.rigid_tension(beam, x)
    Kb = (across.curvature.T * weights) @ across.curvature
    Kb += (across.slope.T * (weights * N)) @ across.slope
    Ka = beam.mu**2 * (along.slope.T * weights) @ along.slope
    at_mass = np.array([beam.beta])
    roots = np.sqrt(np.append(weights, beam.alpha))[:, None]
    Fb = roots * np.vstack((across.value, clamped_free(terms, at_mass).value))
    Fa = roots * np.vstack((along.value, fixed_free(terms, at_mass).value))
    solve = _coupled if problem.gyroscopic and beam.gamma else _uncoupled
    return solve(beam, problem, Forms(Ka, Fa), Forms(Kb, Fb), modes)


def quadrature(beam: Beam, terms: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points and weights on both sides of the mass, exact to rounding."""
    points, weights = legendre.leggauss(2 * terms + 12)
    ends = sorted({0.0, beam.beta, 1.0})
    x = [a + (b - a) * (points + 1) / 2 for a, b in pairwise(ends)]
    w = [(b - a) / 2 * weights for a, b in pairwise(ends)]
    return np.concatenate(x), np.concatenate(w)


def clamped_free(terms: int, x: np.ndarray) -> Basis:
    """Bending modes of a cantilever at rest, of unit mass."""
    b = wave_numbers(terms)
    ratio = (np.cosh(b) + np.cos(b)) / (np.sinh(b) + np.sin(b))
    z = x[:, None] * b
    c, s, ch, sh = np.cos(z), np.sin(z), np.cosh(z), np.sinh(z)
    return Basis(
        ch - c - ratio * (sh - s),
        b * (sh + s - ratio * (ch - c)),
        b**2 * (ch + c - ratio * (sh + s)),
    )


def wave_numbers(terms: int) -> np.ndarray:
    """The roots of cos b cosh b = -1, by Newton's method."""
    b = (np.arange(terms) + 0.5) * np.pi
    b[0] = 1.875
    for _ in range(NEWTON_ITERATIONS):
        b = b - (np.cos(b) + 1 / np.cosh(b)) / (-np.sin(b) - np.tanh(b) / np.cosh(b))
    return b


def fixed_free(terms: int, x: np.ndarray) -> Basis:
    """Stretching modes of a bar at rest, of unit mass."""
    z = (np.arange(terms) + 0.5) * np.pi
    sines, cosines = np.sqrt(2) * np.sin(x[:, None] * z), np.sqrt(2) * np.cos(x[:, None] * z)
    return Basis(sines, z * cosines, -(z**2) * sines)


def _uncoupled(beam: Beam, problem: Problem, along: Forms, across: Forms, modes: int) -> Modes:
    """The families apart; the softening is a multiple of M and shifts omega^2 alone."""
    shift = eigen.COMPRESSED if beam.delta < 0 else 0.0
    softening = beam.gamma**2
    bending, V, _ = eigen.symmetric_modes(across.K, across.F.T @ across.F, modes, shift)
    if problem.chordwise:
        bending = bending - softening
    stretching, U, _ = eigen.symmetric_modes(along.K, along.F.T @ along.F, modes)
    return merged(
        Family(bending, partial(_shapes, clamped_free, V)),
        Family(stretching - softening, partial(_shapes, fixed_free, U)),
        modes,
    )


def _coupled(beam: Beam, problem: Problem, along: Forms, across: Forms, modes: int) -> Modes:
    """Both families at once, with Coriolis forces."""
    softening = beam.gamma**2
    Ka, Kb = (form.K - softening * form.F.T @ form.F for form in (along, across))
    omega_squared, U, V, *_ = gyroscopic_modes(Ka, along.F, Kb, across.F, beam.gamma, modes)

    def displacement(x: np.ndarray) -> np.ndarray:
        return np.stack((_shapes(fixed_free, U, x), _shapes(clamped_free, V, x)), axis=1)

    return Modes(omega_squared, (abs(across.F @ V) ** 2).sum(axis=0), displacement)


def _shapes(
    functions: Callable[[int, np.ndarray], Basis], v: np.ndarray, x: np.ndarray
) -> np.ndarray:
    """The modes v (terms, modes) at x."""
    return functions(len(v), x).value @ v
