"""A lesson: texts, a scene to start from, a computed proof and a challenge that is checked."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from beamviz.beam import NUMBERS, PARAMETERS, Beam
from beamviz.errors import BeamvizError
from beamviz.scene import Scene
from beamviz.solver import Solution

ACCURACY = ("elements", "tolerance")  # options that do not change a correct answer
ON_OFF = {True: "on", False: "off"}
LABELS = {"coriolis": "Coriolis", "softening": "spin softening"}
MIN_MASS = 0.5  # alpha, where a challenge leaves the mass free


class Verdict(NamedTuple):
    """Whether a challenge is met, and the reason."""

    met: bool
    words: str


@dataclass(frozen=True)
class Fact:
    """A sentence with placeholders, and the function that computes their numbers."""

    sentence: str
    compute: Callable[[], tuple[float, ...]]

    @cached_property
    def numbers(self) -> tuple[float, ...]:
        """The numbers, computed once."""
        return self.compute()

    @property
    def words(self) -> str:
        """The sentence with its numbers."""
        return self.sentence.format(*self.numbers)


@dataclass(frozen=True)
class Challenge:
    """Find a value of one of the five numbers; everything else stays as in the lesson's scene.

    number: "alpha", "beta", "gamma", "delta" or "mu"; within: accepted distance from the answer;
    compute: returns the answer; gauge: describes the quantity to watch, measured on a solution;
    free: numbers and options that may be changed as well.
    """

    task: str
    number: str
    within: float
    compute: Callable[[], float]
    gauge: Callable[[Solution], str]
    free: tuple[str, ...] = ()

    @cached_property
    def answer(self) -> float:
        """The value that meets the challenge, computed once."""
        return self.compute()


@dataclass(frozen=True)
class Lesson:
    """A question about the beam, answered by experiment.

    In the texts, *single stars* mark technical terms and **double stars** controls of the page.
    """

    name: str
    title: str
    question: str
    do: str
    see: str
    meaning: str
    proof: Fact
    challenge: Challenge
    scene: Scene

    def check(self, beam: Beam, options: Mapping[str, Any]) -> Verdict:
        """Whether `beam`, solved with the keywords `options` of `solve`, meets the challenge."""
        if obstacle := self._obstacle(beam, options):
            return Verdict(False, obstacle)
        number, within = self.challenge.number, self.challenge.within
        value, answer = getattr(beam, number), self.challenge.answer
        if abs(answer - value) > within:
            return Verdict(False, "")
        symbol = PARAMETERS[number].symbol
        return Verdict(True, f"{symbol} = {value:.5g} is within {within:g} of {answer:.5g}.")

    def measured(self, solution: Solution) -> str:
        """The challenge's gauge for a solution, "" where it is undefined."""
        try:
            words = self.challenge.gauge(solution)
        except BeamvizError:
            return ""
        return "" if "nan" in words else words

    def _obstacle(self, beam: Beam, options: Mapping[str, Any]) -> str:
        """The change that has to be undone before the challenge can be met, or ""."""
        free = (*self.challenge.free, self.challenge.number, *ACCURACY)
        if "alpha" in free and beam.alpha < MIN_MASS:
            return f"Make the mass α at least {MIN_MASS:g}: a lighter one has little effect."
        for name, parameter in NUMBERS.items():
            start = getattr(self.scene.beam, name)
            if name not in free and getattr(beam, name) != start:
                return f"Put the {parameter.label} {parameter.symbol} back to {start:g} first."
        for name, choice in self.scene.options.items():
            if name not in free and options.get(name, choice) != choice:
                return f"Put {LABELS.get(name, name)} back to {ON_OFF.get(choice, choice)} first."
        return ""
