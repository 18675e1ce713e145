"""What to see of a beam and how it moves: the choices of a picture, checked."""

import math
from dataclasses import dataclass, fields, replace
from typing import Any, Self

from beamviz.beam import checked
from beamviz.errors import InvalidInput

COLOURINGS = ("displacement", "axial strain")
MAX_AMPLITUDE = 0.4
MAX_PACE = 4.0
TOPS = {"pace": MAX_PACE, "amplitude": MAX_AMPLITUDE}
MAX_SHARES = 20


@dataclass(frozen=True)
class Look:
    """The choices of a picture. amplitude: largest displacement drawn, in lengths of the beam;
    shares: how much of mode 1, 2 ... is in it, each 0 .. 1; together: all modes at once, each in a
    picture of its own.

    Raises InvalidInput, which names the choice, its value and what is allowed.
    """

    shares: tuple[float, ...] = (0.0, 1.0)
    amplitude: float = 0.15
    playing: bool = True
    pace: float = 1.0
    riding: bool = True
    colouring: str = COLOURINGS[0]
    ghosts: bool = True
    nodes: bool = True
    thicken: bool = False
    together: bool = False
    dark: bool = False

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = sound(entry.name, entry.default, getattr(self, entry.name))
            object.__setattr__(self, entry.name, value)

    def changed(self, name: str, value: Any) -> Self:
        """With one choice changed as a browser sent it; what makes no sense changes nothing."""
        old = getattr(self, name)
        if name in TOPS:
            value = within(value, TOPS[name], old)
        changes: dict[str, Any] = {name: bool(value) if isinstance(old, bool) else value}
        try:
            return replace(self, **changes)
        except InvalidInput:
            return self

    def share(self, mode: int, value: Any) -> Self:
        """With the share of one mode (from 0) changed."""
        shares = list(self.shares) + [0.0] * (mode + 1 - len(self.shares))
        shares[mode] = within(value, 1.0, shares[mode])
        return replace(self, shares=tuple(shares))

    def only(self, mode: int) -> Self:
        """With one mode (from 0) shown alone."""
        return replace(self, shares=(0.0,) * mode + (1.0,), together=False)


def sound(name: str, default: Any, value: Any) -> Any:
    """`value` as the choice `name`, or InvalidInput; its kind is that of the default."""
    if isinstance(default, bool):
        if not isinstance(value, bool):
            raise InvalidInput(f"{name} = {value!r}: must be true or false")
        return value
    if isinstance(default, float):
        return checked(name, value, 0.0, TOPS[name])
    if isinstance(default, str):
        if value not in COLOURINGS:
            raise InvalidInput(f"{name} = {value!r}: must be one of {', '.join(COLOURINGS)}")
        return value
    if not isinstance(value, list | tuple) or len(value) > MAX_SHARES:
        raise InvalidInput(f"{name} = {value!r}: must be a list of at most {MAX_SHARES} numbers")
    return tuple(checked(name, share, 0.0, 1.0) for share in value)


def within(value: Any, top: float, old: float) -> float:
    """`value` within 0 .. top, or `old` where it is no number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return old
    return min(max(float(value), 0.0), top)
