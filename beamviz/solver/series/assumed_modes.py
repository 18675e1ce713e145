"""Assumed modes: the modes of the beam at rest without a mass are the basis.

Yoo & Shin (J. Sound Vib. 212, 1998) and, with a mass anywhere, Yoo, Seo & Huh (2002): linear
equations in w and u with the tension of the rigid reference length, Coriolis coupling on request.
The bending functions are evaluated as in the textbooks, cosh bx - cos bx - s (sinh bx - sin bx):
cosh and sinh cancel to one part in e^b, so digits are lost from the eighth mode on and all at the
twelfth. An interior mass bends the beam more sharply than any basis function: convergence is slow.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

from beamviz.beam import Beam
from beamviz.solver.constitutive import rigid_tension
from beamviz.solver.families import build_solution, modes_of_matrices, quadrature
from beamviz.solver.problem import Problem
from beamviz.solver.solution import Solution

NEWTON_ITERATIONS = 8


Basis = Callable[[int, np.ndarray], tuple[np.ndarray, ...]]
"""Number of terms, points x -> values and derivatives of basis functions, (len(x), terms) each."""


def solve(beam: Beam, problem: Problem, start: float) -> Solution:
    """The modes on some functions across the beam and as many along it. start: the clock at the
    call."""
    terms = problem.resolution
    x, masses = quadrature(beam, 2 * terms + 12)  # exact to rounding
    (u, du), (w, dw, ddw) = fixed_free(terms, x), clamped_free(terms, x)
    lengths = np.append(masses[:-1], 0.0)  # the concentrated mass has no stiffness
    Ka = beam.mu**2 * (du.T * lengths) @ du
    Kb = (ddw.T * lengths) @ ddw + (dw.T * (lengths * rigid_tension(beam, x))) @ dw
    # M = F' F: rows of F are displacements at the points
    Fa, Fb = (np.sqrt(masses)[:, None] * displacement for displacement in (u, w))
    shapes = partial(partial, _combined, fixed_free), partial(partial, _combined, clamped_free)
    modes = modes_of_matrices(beam, problem, (Ka, Kb), (Fa, Fb), shapes)
    return build_solution(beam, problem, start, modes, (2 * terms, 1, terms))


def clamped_free(terms: int, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Bending modes of a cantilever at rest, of unit mass."""
    b = wave_numbers(terms)
    ratio = (np.cosh(b) + np.cos(b)) / (np.sinh(b) + np.sin(b))
    z = x[:, None] * b
    c, s, ch, sh = np.cos(z), np.sin(z), np.cosh(z), np.sinh(z)
    slope, curvature = b * (sh + s - ratio * (ch - c)), b**2 * (ch + c - ratio * (sh + s))
    return ch - c - ratio * (sh - s), slope, curvature


def wave_numbers(terms: int) -> np.ndarray:
    """The roots of cos b cosh b = -1, by Newton's method."""
    b = (np.arange(terms) + 0.5) * np.pi
    b[0] = 1.875
    for _ in range(NEWTON_ITERATIONS):
        b = b - (np.cos(b) + 1 / np.cosh(b)) / (-np.sin(b) - np.tanh(b) / np.cosh(b))
    return b


def fixed_free(terms: int, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Stretching modes of a bar at rest, of unit mass."""
    z = (np.arange(terms) + 0.5) * np.pi
    return np.sqrt(2) * np.sin(x[:, None] * z), np.sqrt(2) * z * np.cos(x[:, None] * z)


def _combined(basis: Basis, coefficients: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Combinations (len(x), modes) of basis functions, coefficients (terms, modes)."""
    return basis(len(coefficients), x)[0] @ coefficients
