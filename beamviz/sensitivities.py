"""Sensitivities of frequencies: d omega_k / dp of each mode k to each number p of a beam.

In the coordinates of the modes of the beam itself, the operator of its lowest modes is

    A(p) = O diag(lambda(p)) O^-1,   O = W Phi(p),   W Phi(p_0) = 1,

with the shapes Phi and lambda = s^2; with Coriolis forces the states (v, s v) and the conjugates of
those that vibrate, and lambda = s. A is diagonal at p_0, so that d lambda_k / dp = (dA / dp)_kk;
and it is smooth in p where loci cross or veer, as it does not depend on the order of the modes, nor
on how they mix among each other. dA / dp are fourth-order differences of beams solved in one stack,
to a tolerance of 1e-10; of blades 1e-7, which on blades of reference turbines, straight and
deflected, costs less than 1e-6 of a sensitivity.
"""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.errors import InvalidInput
from beamviz.si import INEXTENSIBLE
from beamviz.solver import solve_many
from beamviz.solver.solution import Solution
from beamviz.space.spans import ends_of_spans

TOLERANCE = 1e-10  # of the solutions: a step of 1e-3 divides their errors by it
BLADE_TOLERANCE = 1e-7  # of those of blades: 1e-10 takes 1.5 to 10 times as long, deflected 27
STEP = 1e-3  # relative to the scale of a number; the truncation error is its fourth power
EXTRA_MODES = 3  # of which those are taken that are near the lowest
SINGULAR = 1e8  # condition of O from which the lowest modes are not those of the beam
POINTS = np.linspace(0.025, 1.0, 40)  # of shapes that are compared


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


class ModalBasis(NamedTuple):
    """The lowest modes of a beam, as coordinates for those of changed beams."""

    beam: Beam
    size: int  # number of the modes
    has_states: bool  # of displacements and velocities, not of shapes alone
    inverse: NDArray  # W (vectors, rows)

    @classmethod
    def of(cls, solution: Solution, least: int) -> Self:
        """Of `least` modes or more, up to the greatest step of their squares."""
        s = solution.s[np.isfinite(solution.s)]
        squares = abs(s**2)
        least = min(least, len(s))
        steps = squares[least:] / np.maximum(squares[least - 1 : -1], 1e-300)
        count = least + int(steps.argmax()) if len(steps) else least
        has_states = solution.problem.gyroscopic and bool((s[:count] != 0).all())
        basis = cls(solution.beam, count, has_states, np.empty(0))
        return basis._replace(inverse=np.linalg.pinv(basis.vectors(solution)[1]))

    def vectors(self, solution: Solution) -> tuple[NDArray, NDArray]:
        """lambda (vectors,) and unit vectors (rows, vectors) of the modes of a changed beam: their
        shapes at POINTS, which move with the masses."""
        ends, changed = ends_of_spans(self.beam), ends_of_spans(solution.beam)
        points = np.interp(POINTS, ends, changed) if len(ends) == len(changed) else POINTS
        known = np.flatnonzero(np.isfinite(solution.s))[: self.size]
        shapes = solution.fields(points)
        shapes, s = shapes.reshape(-1, shapes.shape[-1])[:, known], solution.s[known]
        if not self.has_states:
            return s**2, shapes / np.linalg.norm(shapes, axis=0)
        states = np.vstack((shapes, s * shapes))
        states /= np.linalg.norm(states, axis=0)
        vibrates = s.imag > 0  # a mode that diverges has a real state, which is its own conjugate
        conjugates = states[:, vibrates].conj()
        return np.concatenate((s, s[vibrates].conj())), np.hstack((states, conjugates))

    def operator(self, answer: Any) -> NDArray:
        """A (vectors, vectors) of a changed beam; nan without a solution, or with fewer modes."""
        count = len(self.inverse)
        if isinstance(answer, Solution):
            values, vectors = self.vectors(answer)
            O = self.inverse @ vectors
            if O.shape == (count, count) and np.linalg.cond(O) < SINGULAR:
                operator: NDArray = (O * values) @ np.linalg.inv(O)
                return operator
        return np.full((count, count), math.nan + 0j)


def sensitivities(solution: Solution) -> dict[str, NDArray]:
    """The derivative (modes,) of each frequency of a solution to each number that the beam has, by
    name; nan where a mode has no frequency, or a changed beam no solution."""
    differences = list(differences_of(solution))
    options = solution.problem.options
    tolerance = BLADE_TOLERANCE if solution.beam.blade else TOLERANCE
    options["tolerance"] = min(tolerance, options["tolerance"])
    beams = [solution.beam, *(beam for each in differences for beam in each.beams)]
    finer, *changed = solve_many(beams, extra_modes=EXTRA_MODES, **options)
    by_number = {each.number: np.full(len(solution.s), math.nan) for each in differences}
    if not isinstance(finer, Solution):
        return by_number
    basis, answers = ModalBasis.of(finer, len(solution.s)), iter(changed)
    modes, places = paired(solution, finer, basis.size)
    s = solution.s[modes]
    known = np.isfinite(solution.frequencies[modes]) & (s != 0)
    for each in differences:
        operators = np.array([basis.operator(next(answers)) for _ in each.beams])
        slopes = np.tensordot(each.weights, operators, axes=1).diagonal()[places] / each.step
        slopes = slopes if basis.has_states else slopes / np.where(known, 2 * s, 1.0)
        by_number[each.number][modes[known]] = slopes[known].imag
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
    """The step of a number, by the scale on which frequencies change with it: a mass moves those of
    a blade by that of its lightest part."""
    value = abs(getattr(beam, number))
    lightest = min(beam.blade.mass) / 10 if beam.blade else 1.0
    scales = {"beta": 0.3, "mu": value, "flap": value, "alpha": 0.3 * lightest + value}
    scale = scales.get(number, 1 + value)
    if number in ("pitch", "twist"):
        scale = math.degrees(1.0)
    return STEP * scale


def paired(solution: Solution, finer: Solution, count: int) -> tuple[NDArray, NDArray]:
    """The indices of modes of a solution and of those of a finer one of its beam, of the lowest
    `count`, with the greatest overlaps: two of one frequency may be in another order."""
    from scipy.optimize import linear_sum_assignment

    known = np.flatnonzero(np.isfinite(finer.s))[:count]
    overlaps = unit_shapes(solution).conj().T @ unit_shapes(finer)[:, known]
    return linear_sum_assignment(abs(overlaps), maximize=True)


def unit_shapes(solution: Solution) -> NDArray:
    """The shapes of all modes at POINTS as unit vectors (points * components, modes)."""
    shapes = solution.fields(POINTS)
    flat = shapes.reshape(-1, shapes.shape[-1])
    return flat / np.linalg.norm(flat, axis=0)
