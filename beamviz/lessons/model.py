"""What a lesson is: words, a scene to start from, numbers that are computed, and a challenge."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from beamviz.beam import NAMES, Beam
from beamviz.errors import BeamvizError
from beamviz.plotting.style import SYMBOLS
from beamviz.scene import SavedScene
from beamviz.solver import Solution

ACCURACY = ("elements", "tolerance")  # which change no answer that is right
ON_OFF = {True: "on", False: "off"}
LABELS = {"coriolis": "Coriolis", "softening": "spin softening"}
LEAST_MASS = 0.5


class Verdict(NamedTuple):
    """Whether a challenge is met, and what to say about it."""

    met: bool
    words: str


@dataclass(frozen=True)
class Fact:
    """A sentence with places for numbers, and how they are computed."""

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
    """A value to be found for one number of the beam, while all else is as in the lesson.

    within: how near to an answer is near enough. gauge: what to watch, measured on the beam as
    it is. free: what may be changed as well.
    """

    task: str
    number: str
    within: float
    compute: Callable[[], tuple[float, ...]]
    gauge: Callable[[Solution], str]
    free: tuple[str, ...] = ()

    @cached_property
    def answers(self) -> tuple[float, ...]:
        """The values that meet it, computed once."""
        return self.compute()


@dataclass(frozen=True)
class Lesson:
    """A question about the beam, answered by playing with it.

    Words between single stars are the field's terms, between double ones names on the page.
    """

    name: str
    title: str
    question: str
    do: str
    see: str
    meaning: str
    proof: Fact
    challenge: Challenge
    scene: SavedScene

    def check(self, beam: Beam, options: Mapping[str, Any]) -> Verdict:
        """Whether a beam, solved with `options`, meets the challenge."""
        if words := self._astray(beam, options):
            return Verdict(False, words)
        number, within = self.challenge.number, self.challenge.within
        value = getattr(beam, number)
        answer = min(self.challenge.answers, key=lambda answer: abs(answer - value))
        if abs(answer - value) > within:
            return Verdict(False, "")
        words = f"{SYMBOLS[number]} = {value:.5g} is within {within:g} of {answer:.5g}."
        return Verdict(True, words)

    def measured(self, solution: Solution) -> str:
        """What the gauge says of a beam, "" where it cannot tell."""
        try:
            words = self.challenge.gauge(solution)
        except BeamvizError:
            return ""
        return "" if "nan" in words else words

    def _astray(self, beam: Beam, options: Mapping[str, Any]) -> str:
        """What has to be put back before the challenge can be met, or ""."""
        free, own = self.challenge.free, self.scene
        if "alpha" in free and beam.alpha < LEAST_MASS:
            return (
                f"Make the mass α at least {LEAST_MASS:g}: a lighter one is hardly felt anywhere."
            )
        for name, start in own.beam.numbers.items():
            if name not in (*free, self.challenge.number) and getattr(beam, name) != start:
                return f"Put the {NAMES[name]} {SYMBOLS[name]} back to {start:g} first."
        for name, choice in own.options.items():
            if name not in (*free, *ACCURACY) and options.get(name, choice) != choice:
                return f"Put {LABELS.get(name, name)} back to {ON_OFF.get(choice, choice)} first."
        return ""
