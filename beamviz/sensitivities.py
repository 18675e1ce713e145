"""Sensitivities of frequencies: d omega_k / dp of each mode k to each number p of a beam.

They are fourth-order differences of the solver's own frequencies in s^2, which is smooth where a
frequency goes through zero,

    d omega / dp = Im (d(s^2)/dp / (2 s)),

of beams that are solved in one stack to a tolerance of 1e-10. Modes of the changed beams are paired
with those of the beam by their shapes, so that loci may cross.
"""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.errors import InvalidInput
from beamviz.si import INEXTENSIBLE
from beamviz.solver import solve_many
from beamviz.solver.solution import Solution

TOLERANCE = 1e-10  # of the solutions: a step of 1e-3 divides their errors by it
STEP = 1e-3  # relative to the scale of a number; the truncation error is its fourth power
EXTRA_MODES = 2  # that may become one of the lowest
POINTS = np.linspace(0.04, 1.0, 25)  # of shapes that are compared


class Stencil(NamedTuple):
    """Places in steps, and the weights of a first derivative there."""

    places: tuple[int, ...]
    weights: tuple[float, ...]


CENTRAL = Stencil((-2, -1, 1, 2), (1 / 12, -2 / 3, 2 / 3, -1 / 12))
FORWARD = Stencil((0, 1, 2, 3, 4), (-25 / 12, 4.0, -3.0, 4 / 3, -1 / 4))
BACKWARD = Stencil((0, -1, -2, -3, -4), tuple(-weight for weight in FORWARD.weights))


class Difference(NamedTuple):
    """The beams of a derivative to one number."""

    number: str
    step: float
    weights: tuple[float, ...]
    beams: list[Beam]


def sensitivities(solution: Solution) -> dict[str, NDArray]:
    """The derivative (modes,) of each frequency of a solution to each number that the beam has, by
    name; nan where a mode has no frequency, or a changed beam no solution."""
    differences = list(differences_of(solution))
    options = solution.problem.options
    options["tolerance"] = min(TOLERANCE, options["tolerance"])
    known = np.isfinite(solution.frequencies) & (solution.s != 0)
    beams = [beam for each in differences for beam in each.beams]
    answers = iter(solve_many(beams, extra_modes=EXTRA_MODES, **options))
    by_number = {}
    for each in differences:
        squares = [paired_squares(solution, next(answers)) for _ in each.beams]
        derivative = np.tensordot(each.weights, squares, axes=1) / each.step  # of s^2, (modes,)
        rates = by_number[each.number] = np.full(len(known), np.nan)
        rates[known] = (derivative[known] / (2 * solution.s[known])).imag
    return by_number


def differences_of(solution: Solution) -> Iterator[Difference]:
    """The beams of the derivative to each number; of a number at its limit beyond it on one side
    only."""
    beam = solution.beam
    for number in numbers_that_apply(solution):
        value, step = getattr(beam, number), step_of(beam, number)
        for stencil in (CENTRAL, FORWARD, BACKWARD):
            try:
                beams = [beam.replace(**{number: value + k * step}) for k in stencil.places]
            except InvalidInput:
                continue
            yield Difference(number, step, stencil.weights, beams)
            break


def numbers_that_apply(solution: Solution) -> list[str]:
    """The numbers on which the frequencies of a solution may depend."""
    beam, problem = solution.beam, solution.problem
    numbers = ["alpha", "beta", "gamma", "delta"]
    numbers += ["mu"] if beam.mu != INEXTENSIBLE else []
    numbers += ["spin_up"] if beam.spin_up else []
    numbers += ["flap"] if problem.plane != "chordwise" and beam.blade is None else []
    numbers += ["pitch", "twist"] if problem.in_space else []
    return numbers + (["root"] if math.isfinite(beam.root) else [])


def step_of(beam: Beam, number: str) -> float:
    """The step of a number, by the scale on which frequencies change with it."""
    value = abs(getattr(beam, number))
    scale = {"beta": 1.0, "mu": value, "flap": value, "alpha": 0.3 + value}.get(number, 1 + value)
    if number in ("pitch", "twist"):
        scale = math.degrees(1.0)
    return STEP * scale


def paired_squares(solution: Solution, answer: Any) -> NDArray:
    """s^2 (modes,) of the modes of a changed beam in the order of those of the beam, by the
    greatest overlaps of their shapes; nan without a solution."""
    from scipy.optimize import linear_sum_assignment

    squares = np.full(len(solution.s), complex(math.nan, math.nan))
    if not isinstance(answer, Solution):
        return squares
    known = np.flatnonzero(np.isfinite(answer.s))
    overlaps = abs(unit_shapes(solution).conj().T @ unit_shapes(answer)[:, known])
    mode, place = linear_sum_assignment(overlaps, maximize=True)
    squares[mode] = answer.s[known][place] ** 2
    return squares


def unit_shapes(solution: Solution) -> NDArray:
    """The shapes of all modes at POINTS as unit vectors (points * components, modes)."""
    shapes = solution.fields(POINTS)
    flat = shapes.reshape(-1, shapes.shape[-1])
    return flat / np.linalg.norm(flat, axis=0)
