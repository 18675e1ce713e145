"""Margins of modes to per-rev lines at the operating speed, and their Southwell coefficients.

With omega the frequency of a mode at the speed gamma and omega_0 that at rest,

    margin to the line k = (omega - k gamma) / (k gamma),    omega^2 = omega_0^2 + S gamma^2.

S is about constant from speed to speed, unless the locus veers (Southwell & Gough 1921).
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.frequency_loci.branches import LabelledTrack, branches_at
from beamviz.frequency_loci.events.record import Event
from beamviz.frequency_loci.path import ParameterPath


class Margin(NamedTuple):
    """A mode at the operating speed. mode_index: by frequency, from 0. southwell: None where the
    mode is not known at rest, as loci that do not begin there. percent (per_rev,): to the lines
    1 .. per_rev, above 0 where the frequency is above the line. on_lines: the multiples on whose
    line the locus lies at all speeds around this one."""

    label: str
    mode_index: int
    speed: float
    frequency: float
    southwell: float | None
    percent: tuple[float, ...]
    on_lines: tuple[int, ...] = ()

    @property
    def nearest(self) -> int:
        """The multiple of the nearest line."""
        return int(np.argmin(np.abs(self.percent))) + 1

    @property
    def record(self) -> dict[str, Any]:
        """What files have of it."""
        label, mode_index, *values = self
        named = dict(zip(self._fields[2:], values, strict=True))
        return {"label": label, "index": mode_index + 1, **named, "nearest": self.nearest}


def percent(frequency: float, speed: float, multiples: NDArray) -> NDArray:
    """The margins [%] (lines,) of a frequency to the lines of these multiples of the speed."""
    lines = multiples * speed
    return 100 * (frequency - lines) / lines


def margins_at(
    path: ParameterPath, parts: Sequence[LabelledTrack], per_rev: int, events: Sequence[Event]
) -> tuple[Margin, ...]:
    """The margins of the modes to the lines 1 .. per_rev, by frequency, at the speed of the beam;
    none where it is at rest, or that speed not among the loci."""
    speed, (low, high) = path.beam.gamma, (parts[0].track.low, parts[-1].track.high)
    if not per_rev or path.over != "gamma" or not low <= speed <= high or speed == 0:
        return ()
    values = np.array([0.0, speed] if low == 0 else [speed])
    multiples = np.arange(1, per_rev + 1)
    margins = []
    for branch in branches_at(path, values, parts):
        frequency = float(branch.frequency[-1])
        if branch.mode_index[-1] < 0 or not math.isfinite(frequency):
            continue
        southwell = None
        if low == 0 and branch.mode_index[0] >= 0:
            squares = branch.omega_squared
            southwell = float((squares[1] - squares[0]) / speed**2)
        margins.append(
            Margin(
                branch.label,
                int(branch.mode_index[-1]),
                speed,
                frequency,
                southwell,
                tuple(percent(frequency, speed, multiples).tolist()),
                tuple(
                    event.per_rev
                    for event in events
                    if event.until is not None
                    and event.branches == (branch.label,)
                    and event.at <= speed <= event.until
                ),
            )
        )
    return tuple(sorted(margins, key=lambda margin: margin.mode_index))
