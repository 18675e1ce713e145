"""A computed motion in the scene: which moment of it, and the beam drawn then."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from beamviz.beam import Beam
from beamviz.drawing.forces import MotionForces
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.text import times
from beamviz.units import Units

PAUSE = 1.5  # [s] on the screen at the end, before it begins again


class PlayedShapes(Protocol):
    """What is played: m shapes, sampled as modes, with their amplitudes [L], and what they do in
    time [T*]."""

    sampled: SampledModes
    amplitudes: np.ndarray  # (m,)

    @property
    def forces(self) -> MotionForces | None:
        """The forces on the beam; None where they are not known."""

    @property
    def until(self) -> float:
        """The end."""

    def phases(self, t: float) -> np.ndarray:
        """The phases (m,) [rad] to draw the shapes at."""

    def angle(self, t: float) -> float | None:
        """The angle of the hub [rad]; None where it stays as it is."""

    def gamma(self, t: float) -> float:
        """The speed of the hub [1/T*]."""


class HeldShapes:
    """A beam at rest in the frame of the hub, in which it has these positions (n, 2) [L] at its
    stations x (n,)."""

    until = 0.0
    forces = None

    def __init__(self, beam: Beam, x: np.ndarray, positions: np.ndarray):
        self.beam = beam
        unloaded = np.stack([x, np.zeros_like(x)], axis=1)
        moved = positions - unloaded
        size = max(float(np.linalg.norm(moved, axis=1).max()), 1e-12)
        self.amplitudes = np.array([size])
        self.sampled = SampledModes(
            beam,
            plane="chordwise",
            x=x,
            centreline=unloaded,
            strain=np.zeros(len(x) - 1),
            labels=("held",),
            frequencies=np.zeros(1),
            modes=moved[None] / size,
            limits=np.full(1, np.inf),
        )

    def phases(self, t: float) -> np.ndarray:
        return np.full(1, np.pi / 2)

    def angle(self, t: float) -> None:
        """The hub stays where it is."""

    def gamma(self, t: float) -> float:
        return self.beam.gamma


@dataclass(frozen=True, eq=False)
class Film:
    """A motion to play."""

    beam: Beam
    shapes: PlayedShapes
    second: PlayedShapes | None  # of the motion without stiffening, drawn beside it
    rate: float  # suitable time [T*] per second on the screen
    has_body: Callable[[float], bool]  # whether the mass is on the beam at a time [T*]

    @property
    def until(self) -> float:
        """The time [T*] at which it ends."""
        return self.shapes.until

    @property
    def diverged(self) -> float | None:
        """The time at which the motion without stiffening has diverged; None where it does not."""
        end = self.second.until if self.second else self.until
        return end if end < self.until else None

    def advanced(self, moment: float, time: float) -> float:
        """The moment after a time [T*]; after the end it begins again."""
        moment += time
        return moment if moment < self.until + PAUSE * self.rate else 0.0


def time_text(time: float | None, units: Units | None) -> str:
    """A time [T*] as the chart shows it; "" for none."""
    return "" if time is None else times(units).text(time, 3)
