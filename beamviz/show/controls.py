"""What a visitor can choose, checked: nothing a browser sends is trusted."""

import math
from dataclasses import dataclass, field, replace
from typing import Any, Self

from beamviz.beam import Beam, Units
from beamviz.mechanics.solve import CURVATURES, METHODS, PLANES, STRAIN_LAWS
from beamviz.show.colours import COLOURINGS

MODES = 5
MAX_AMPLITUDE = 0.4
MAX_SPEED = 4.0
SWITCHES = {"stiffening": True, "softening": True, "coriolis": False}  # as `solve` has them
CHOICES = {
    "method": tuple(METHODS),
    "strain": tuple(STRAIN_LAWS),
    "curvature": tuple(CURVATURES),
    "plane": tuple(PLANES),
    "colouring": COLOURINGS,
}


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


@dataclass(frozen=True)
class Look:
    """What to see of it, and how it moves; amplitudes are in lengths of the beam.
    together: all modes at once, each in a picture of its own."""

    colouring: str = COLOURINGS[0]
    riding: bool = True
    ghosts: bool = True
    nodes: bool = True
    thicken: bool = False
    together: bool = False
    playing: bool = True
    speed: float = 1.0
    amplitude: float = 0.15
    shares: tuple[float, ...] = field(default=(0.0, 1.0))

    def changed(self, name: str, value: Any) -> Self:
        """With one choice changed; what makes no sense changes nothing."""
        old = getattr(self, name)
        new = old
        if isinstance(old, bool):
            new = bool(value)
        elif isinstance(old, float):
            new = within(value, {"speed": MAX_SPEED, "amplitude": MAX_AMPLITUDE}[name], old)
        elif value in CHOICES[name]:
            new = value
        changes: dict[str, Any] = {name: new}
        return replace(self, **changes)

    def share(self, mode: int, value: Any) -> Self:
        """With the share of one mode (from 0) changed."""
        shares = list(self.shares) + [0.0] * (mode + 1 - len(self.shares))
        shares[mode] = within(value, 1.0, shares[mode])
        return replace(self, shares=tuple(shares))

    def only(self, mode: int) -> Self:
        """With one mode (from 0) shown alone."""
        return replace(self, shares=(0.0,) * mode + (1.0,), together=False)


def within(value: Any, top: float, old: float) -> float:
    """`value` within 0 .. top, or `old` where it is no number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return old
    return min(max(float(value), 0.0), top)
