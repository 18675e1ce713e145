"""The clock of one page: rotation, vibration, growth, and changes of the view under way.

A growing mode leaves the equilibrium as exp(growth rate * time), is held at its full size for a
moment, and begins again.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from beamviz.drawing.modes import SampledModes, playback_rate
from beamviz.explorer.camera import Transition
from beamviz.explorer.film import Film
from beamviz.units import Units

FULL = math.pi / 2  # [rad] the phase of the largest displacement, where every mode begins
EXPONENT = 4.0  # growth from exp(-4), 1/50 of the full size, to the full size
HELD = 2.0  # the same, for which the full size is held
ROUND = (1.0, 2.0, 5.0, 10.0)


@dataclass(frozen=True, eq=False)
class Clock:
    """A moment of what the scene shows."""

    angle: float = 0.0  # of the hub [rad]
    phases: np.ndarray = field(default_factory=lambda: np.zeros(0))  # of the modes (m,) [rad]
    other_phases: np.ndarray = field(default_factory=lambda: np.zeros(0))  # of the second beam's
    compared: tuple[object, ...] = ()  # the choices with which the second beam's modes began
    grown: float = EXPONENT  # exponent of the fastest growth, 0 .. EXPONENT + HELD
    moment: float = 0.0  # of `film` [T*]
    film: Film | None = None  # the computed motion
    transition: Transition | None = None  # of the view

    def begun_again(self) -> Self:
        """With every mode at its full displacement, and growth at its full size."""
        none = np.zeros(0)
        return replace(self, phases=none, other_phases=none, compared=(), grown=EXPONENT)

    def for_modes(self, count: int) -> Self:
        """With phases for this number of modes; another number begins at full displacement."""
        return self if len(self.phases) == count else replace(self, phases=np.full(count, FULL))

    def with_second(self, compared: tuple[object, ...], partner: np.ndarray) -> Self:
        """With phases for the modes of a second beam: those of their partners (m,) among the modes
        of the first (-1: none) when another choice is made, else they go on."""
        if compared == self.compared and len(partner) == len(self.other_phases):
            return self
        phases = self.phases % (2 * math.pi)  # counts of periods begin at the same time
        others = np.append(phases, FULL)[partner]
        return replace(self, phases=phases, other_phases=others, compared=compared)

    def with_film(self, film: Film | None, moment: float | None) -> Self:
        """With a computed motion at a moment; without one the same motion goes on, and another
        begins."""
        if film is None or (film is self.film and moment is None):
            return self
        return replace(self, film=film).at(moment or 0.0)

    def at(self, moment: float) -> Self:
        """At a moment of the computed motion."""
        if self.film is None:
            return self
        angle = self.film.shapes.angle(moment)
        angle = self.angle if angle is None else angle % (2 * math.pi)
        return replace(self, moment=moment, angle=angle)

    def advanced(self, time: float, shapes: SampledModes, other: SampledModes | None) -> Self:
        """After a time [T*] of the modes of a beam, and of a second one."""
        if not time:
            return self
        grown = self.grown + time * fastest_growth(shapes)
        return replace(
            self,
            angle=(self.angle + time * shapes.beam.gamma) % (2 * math.pi),
            phases=turned(self.phases, time, shapes),
            other_phases=turned(self.other_phases, time, other) if other else self.other_phases,
            grown=grown % (EXPONENT + HELD),
        )

    def drawn_phases(self, shapes: SampledModes) -> np.ndarray:
        """The phases (m,) to draw the modes at: those of a growing mode give its present size."""
        fastest = fastest_growth(shapes)
        if not fastest:
            return self.phases
        rates = growth_rates(shapes)
        exponent = min(self.grown, EXPONENT)
        size = np.exp(np.where(rates > 0, rates / fastest * (exponent - EXPONENT), 0.0))
        if np.iscomplexobj(shapes.modes):
            return self.phases - 1j * np.log(size)
        return np.where(rates > 0, np.arcsin(size), self.phases)


def growth_rates(shapes: SampledModes) -> np.ndarray:
    """Growth rates (m,) [1/T*] of the modes."""
    return shapes.solution.growth_rates if shapes.solution else np.zeros(len(shapes.modes))


def fastest_growth(shapes: SampledModes) -> float:
    """The largest growth rate [1/T*], 0 if nothing grows."""
    return max(0.0, float(np.max(growth_rates(shapes), initial=0.0)))


def turned(phases: np.ndarray, time: float, shapes: SampledModes) -> np.ndarray:
    """Phases (m,) after a time [T*]."""
    frequencies = shapes.frequencies
    return phases + time * np.where(np.isfinite(frequencies), frequencies, 0.0)


def suitable_rate(rates: Sequence[float] | np.ndarray, gamma: float, units: Units | None) -> float:
    """The time [T*] per second on the screen that suits frequencies and growth rates [1/T*] and a
    speed, so that it is 1, 2 or 5 times a power of ten of T*, or of a second for a real beam: it
    does not follow every change of the motion, and can be read."""
    unit = units.time if units else 1.0
    best = unit * playback_rate(np.asarray(rates, float), gamma)
    power = 10.0 ** math.floor(math.log10(best))
    return power * min(ROUND, key=lambda digit: abs(math.log(digit * power / best))) / unit
