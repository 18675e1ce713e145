"""What a visitor can choose, checked: nothing a browser sends is trusted."""

from dataclasses import dataclass, replace
from typing import Any, Self

from beamviz import solver as solve
from beamviz.beam import Beam, Units
from beamviz.scene import Scene
from beamviz.solver import PLANES, Problem

MODES = 5
SWITCHES = {name: getattr(Problem, name) for name in ("stiffening", "softening", "coriolis")}
CHOICES = {name: tuple(choices) for name, choices in solve.CHOICES.items()}


@dataclass(frozen=True)
class Wanted:
    """What to solve: the five numbers as they were sent, and the keywords of `solve`."""

    numbers: dict[str, float]
    options: dict[str, Any]
    units: Units | None = None

    @classmethod
    def of(cls, beam: Beam, options: dict[str, Any]) -> Self:
        """A beam and keywords as a starting point."""
        return cls(beam.numbers, {"plane": PLANES[0], "modes": MODES, **options}, beam.units)

    @classmethod
    def by(cls, scene: Scene) -> Self:
        """What a scene shows, as a starting point."""
        modes = max(MODES, len(scene.view.shares))
        return cls.of(scene.beam, {**scene.options, "modes": modes})

    def beam(self) -> Beam:
        """The beam; InvalidInput names the number that is none."""
        return Beam(**self.numbers, units=self.units)

    def switched_on(self, name: str) -> bool:
        """Whether a term, one of SWITCHES, is part of it."""
        return bool(self.options.get(name, SWITCHES[name]))

    def changed(self, name: str, value: Any) -> Self:
        """With one number or keyword changed; a number is checked by `beam`, a choice here."""
        if name in self.numbers:
            return replace(self, numbers={**self.numbers, name: value})
        if name in SWITCHES:
            return replace(self, options={**self.options, name: bool(value)})
        if name in CHOICES and value in CHOICES[name]:
            return replace(self, options={**self.options, name: value})
        return self
