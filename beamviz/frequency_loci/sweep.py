"""Solutions along one number of a beam."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from beamviz.beam import PARAMETERS, Beam, check_float
from beamviz.errors import BeamvizError, InvalidInput, NoEquilibrium
from beamviz.frequency_loci.mode_vectors import places, sampled
from beamviz.frequency_loci.tracking import Points
from beamviz.solver import MAX_MODES, solve_many
from beamviz.solver.solution import Solution

BESIDE = 2  # modes solved for beyond those asked for: what enters and leaves the window
MAX_POINTS = 10_000
MAX_ADDED = 4000  # values solved to find meetings; random extreme beams take up to 1000

Answer = Solution | BeamvizError


def checked_values(over: str, values: ArrayLike) -> np.ndarray:
    """The values of a sweep as an array; InvalidInput where they do not make one."""
    if over not in PARAMETERS:
        raise InvalidInput(f"over = {over!r}: must be one of {', '.join(PARAMETERS)}")
    try:
        array = np.asarray(values, float)
    except (TypeError, ValueError, OverflowError):
        raise InvalidInput(f"values of {over}: must be numbers") from None
    if array.ndim != 1 or not 2 <= len(array) <= MAX_POINTS:
        count = len(array) if array.ndim == 1 else f"an array of {array.ndim} dimensions"
        raise InvalidInput(f"values of {over}: must be 2 .. {MAX_POINTS} numbers, not {count}")
    for value in array if not np.isfinite(array).all() else array[[0, -1]]:
        check_float(over, float(value), *PARAMETERS[over].limits)
    falls = np.flatnonzero(np.diff(array) <= 0)
    if len(falls):
        first, second = array[falls[0] : falls[0] + 2]
        raise InvalidInput(f"values of {over}: must ascend, but {second:g} follows {first:g}")
    return array


@dataclass(frozen=True)
class Sweep:
    """A beam with one number set free, and what is kept of each value that was solved."""

    beam: Beam
    over: str
    modes: int
    options: dict[str, Any]
    answers: dict[float, Answer] = field(default_factory=dict)  # of `solve`
    between: dict[float, tuple[str, ...]] = field(default_factory=dict)  # of `points`: the labels

    def at(self, value: float) -> Beam:
        """The beam with this value of the free number."""
        return self.beam.replace(**{self.over: float(value)})

    def solve(self, values: np.ndarray) -> list[Answer]:
        """The answer at each of ascending values: a solution, or the error that says why not."""
        beams = [self.at(value) for value in values]
        answers: list[Answer] = []
        if self.over == "gamma" and self.may_end:
            # The fastest tells how many have an equilibrium at all.
            answers = self._solved(beams[-1:])
            if isinstance(answers[0], NoEquilibrium):
                beyond = int((values > answers[0].limit).sum())
                answers *= beyond
            beams = beams[: len(beams) - len(answers)]
        answers = self._solved(beams) + answers
        self.answers.update(zip(values.tolist(), answers, strict=True))
        return answers

    @property
    def may_end(self) -> bool:
        """Whether the equilibrium may end as the speed grows: Green's law carries any tension."""
        return self.options.get("strain", "green") != "green" or self.beam.delta < 0

    def _solved(self, beams: list[Beam]) -> list[Answer]:
        """The answers for some beams, with a few modes more than asked for."""
        most = MAX_MODES
        elements = self.options.get("elements")
        if isinstance(elements, int):  # what is no number, solve_many refuses
            most = min(most, 2 * elements)
        beside = max(min(BESIDE, most - self.modes), 0)
        return solve_many(beams, extra_modes=beside, modes=self.modes, **self.options)

    @property
    def spent(self) -> bool:
        """Whether no more values are solved to find meetings."""
        return len(self.between) > MAX_ADDED

    @property
    def solves(self) -> int:
        """How many values have been solved, for whatever reason."""
        return len(self.answers.keys() | self.between.keys())

    def points(self, values: np.ndarray) -> Points:
        """What exists at ascending values, as points to track; nothing once enough is spent."""
        if self.spent:
            values = values[:0]
        answers = self._solved([self.at(value) for value in values])
        for value, answer in zip(values.tolist(), answers, strict=True):
            self.between[value] = answer.labels if isinstance(answer, Solution) else ()
        return self._points(values, answers)

    def solved_points(self, values: np.ndarray) -> Points:
        """What exists at values asked for, as points to track."""
        return self._points(values, [self.answers[value] for value in values.tolist()])

    def _points(self, values: np.ndarray, answers: list[Answer]) -> Points:
        """Those of some answers that are solutions, as points."""
        there = [k for k, answer in enumerate(answers) if isinstance(answer, Solution)]
        solutions = [answer for answer in answers if isinstance(answer, Solution)]
        return sampled(values[there], solutions, self.places)

    def labels(self, value: float) -> tuple[str, ...]:
        """The labels of the modes at a solved value."""
        answer = self.answers.get(value)
        return answer.labels if isinstance(answer, Solution) else self.between[value]

    @cached_property
    def places(self) -> int:
        """How many places all shapes of the sweep are taken at, by what was solved first."""
        return places([found for found in self.answers.values() if isinstance(found, Solution)])
