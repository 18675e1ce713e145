"""A lesson: texts, a scene to begin with, a computed fact, and a challenge with its check."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from beamviz.beam import NUMBERS, PARAMETERS, Beam
from beamviz.errors import BeamvizError
from beamviz.scene import Scene
from beamviz.solver import Solution

ACCURACY = ("elements", "tolerance")  # options that may be changed in all challenges
ON_OFF = {True: "on", False: "off"}
LABELS = {"coriolis": "Coriolis", "softening": "spin softening"}
MIN_MASS = 0.5  # alpha, in a challenge that leaves the mass free


class Verdict(NamedTuple):
    """Whether a challenge is met, and the reason."""

    met: bool
    reason: str


@dataclass(frozen=True, kw_only=True)
class Lesson:
    """A question about the beam that experiments answer, and a challenge: to find the value of one
    of the five numbers, with all others as in the lesson's scene.

    In the texts, *single stars* mark technical terms and **double stars** controls of the page.
    fact: a sentence with placeholders for the numbers of compute_fact; number: of the challenge,
    "alpha", "beta", "gamma", "delta" or "mu"; within: accepted distance from the answer, which is
    the first number of the fact where there is no compute_answer; gauge: describes the quantity of
    the challenge for a solution; free: other numbers and options that may be changed.
    """

    name: str
    title: str
    question: str
    do: str
    see: str
    meaning: str
    fact: str
    compute_fact: Callable[[], tuple[float, ...]]
    task: str
    number: str = "gamma"
    within: float = 0.1
    compute_answer: Callable[[], float] | None = None
    gauge: Callable[[Solution], str]
    scene: Scene
    free: tuple[str, ...] = ()

    @cached_property
    def numbers(self) -> tuple[float, ...]:
        """The numbers of the fact, computed once."""
        return self.compute_fact()

    @property
    def proof(self) -> str:
        return self.fact.format(*self.numbers)

    @cached_property
    def answer(self) -> float:
        """The value that meets the challenge, computed once."""
        return self.compute_answer() if self.compute_answer else self.numbers[0]

    @property
    def record(self) -> dict[str, Any]:
        """The texts, without marks of emphasis, the numbers and the scene, for JSON."""
        return {
            **{key: getattr(self, key) for key in ("name", "title", "question")},
            **{key: getattr(self, key).replace("*", "") for key in ("do", "see", "meaning")},
            "proof": {"words": self.proof, "numbers": self.numbers},
            "challenge": {
                **{key: getattr(self, key) for key in ("task", "number", "within")},
                "answers": [self.answer],
            },
            "scene": self.scene.tables,
        }

    def check(self, beam: Beam, options: Mapping[str, Any]) -> Verdict:
        """Whether `beam`, solved with the keywords `options` of `solve`, meets the challenge."""
        if obstacle := self._obstacle(beam, options):
            return Verdict(False, obstacle)
        value = getattr(beam, self.number)
        if abs(self.answer - value) > self.within:
            return Verdict(False, "")
        near = f"is within {self.within:g} of {self.answer:.5g}"
        return Verdict(True, f"{PARAMETERS[self.number].symbol} = {value:.5g} {near}.")

    def measured(self, solution: Solution) -> str:
        """The gauge of a solution; "" if it is undefined."""
        try:
            words = self.gauge(solution)
        except BeamvizError:
            return ""
        return "" if "nan" in words else words

    def _obstacle(self, beam: Beam, options: Mapping[str, Any]) -> str:
        """The change to undo before the challenge can be met, or ""."""
        free = (*self.free, self.number, *ACCURACY)
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
