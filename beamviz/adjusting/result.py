"""The result of `adjust`."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.solver import solve
from beamviz.tables import html_table
from beamviz.units import Units


class Match(NamedTuple):
    """A measured or a target frequency and that of the mode it belongs to, both in the 1/T* of the
    given beam, and the numbers of the beam there. residual: predicted minus measured, in units of
    the error, or relative where no error was given. mode: "" where the beam has no such mode."""

    mode: str
    numbers: dict[str, float]
    measured: float
    predicted: float
    error: float  # of the measured frequency, nan where it was not given
    residual: float


class HeldMargin(NamedTuple):
    """The least margin of a range of speeds and the mode, the line and the speed that hold it.
    margin: relative distance of the frequency from the line, below 0 where they cross: minus the
    least relative change of that frequency which clears the line; -inf where the beam has no stable
    equilibrium at this speed."""

    margin: float
    mode: str
    per_rev: int
    speed: float  # gamma, in 1/T* of the given beam
    frequency: float


@dataclass(frozen=True, eq=False, repr=False)
class Adjusted:
    """A beam whose free numbers were adjusted to a goal. Arrays are read-only."""

    beam: Beam
    goal: str  # "measured", "targets" or "clear"
    free: dict[str, float]  # the free numbers, in the units of their names
    bounds: dict[str, tuple[float, float]]
    options: dict[str, Any]  # of `solve`
    units: Units | None  # of the given beam, in which frequencies and speeds are
    errors: dict[str, float]  # a standard deviation each, inf where the data do not determine it
    correlations: NDArray  # (free, free) of the free numbers, nan where not determined
    matches: tuple[Match, ...] = ()
    undetermined: tuple[str, ...] = ()  # the free numbers that the data do not determine
    at_bounds: tuple[str, ...] = ()  # those that are at one of their bounds
    alternatives: tuple[dict[str, float], ...] = ()  # other values that fit as well
    held: HeldMargin | None = None  # of the goal "clear"
    solves: int = 0
    seconds: float = field(default=0.0)

    @property
    def residuals(self) -> NDArray:
        """The residual (measured,) of each measured frequency."""
        return np.array([match.residual for match in self.matches])

    @cached_property
    def sensitivities(self) -> dict[str, NDArray]:
        """Those of the adjusted beam; see `Solution.sensitivities`."""
        return solve(self.beam, **self.options).sensitivities

    @property
    def root_mean_square(self) -> float:
        """The root mean square of the residuals, nan without any."""
        return float(np.sqrt(np.mean(self.residuals**2))) if self.matches else float("nan")

    def _repr_html_(self) -> str:
        errors = [self.errors.get(name, np.nan) for name in self.free]
        columns = {
            "number": [*self.free],
            "value": [f"{value:.7g}" for value in self.free.values()],
            "error": [f"{error:.2g}" if np.isfinite(error) else "-" for error in errors],
            "bounds": [f"{low:g} .. {high:g}" for low, high in self.bounds.values()],
        }
        return html_table(repr(self), columns)

    def __repr__(self) -> str:
        numbers = ", ".join(
            f"{name}={value:.6g}"
            + (f" ± {self.errors[name]:.2g}" if np.isfinite(self.errors.get(name, np.nan)) else "")
            for name, value in self.free.items()
        )
        notes = [f"not determined: {', '.join(self.undetermined)}"] if self.undetermined else []
        if self.held:
            notes.append(f"margin {100 * self.held.margin:.3g} %")
        elif self.matches:
            notes.append(f"rms residual {self.root_mean_square:.3g}")
        return f"<Adjusted to {self.goal}: {numbers}; {'; '.join(notes)}>"
