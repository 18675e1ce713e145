"""A saved scene, solved: what a picture or a film shows at any moment."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from beamviz.mechanics.solve import Solution, solve
from beamviz.scene_file import Camera, SavedScene
from beamviz.show import camera
from beamviz.show.controls import Wanted
from beamviz.show.motion import Shapes, amplitudes
from beamviz.show.words import unstable


@dataclass(frozen=True)
class Shot:
    """A scene with its solution. Time runs in T* from a moment at which every mode has its
    largest displacement; `words` say what is wrong with the equilibrium, if anything is."""

    scene: SavedScene
    solution: Solution
    shapes: Shapes
    words: str

    @classmethod
    def of(cls, scene: SavedScene) -> Self:
        """Solve a scene; raises what `solve` raises."""
        solution = solve(scene.beam, **Wanted.by(scene).options)
        return cls(scene, solution, Shapes.sampled(solution), unstable(solution))

    @property
    def amplitudes(self) -> np.ndarray:
        """Amplitude (m,) of every mode."""
        return amplitudes(self.scene.look, len(self.shapes.modes))

    @property
    def shown(self) -> list[int]:
        """The modes (from 0) in the picture."""
        return list(np.flatnonzero(self.amplitudes))

    def phases(self, time: float) -> np.ndarray:
        """Phase (m,) [rad] of every mode."""
        return math.pi / 2 + time * np.nan_to_num(self.shapes.frequencies)

    def angle(self, time: float) -> float:
        """Angle [rad] the hub has turned."""
        return time * self.scene.beam.gamma

    def wheel_angle(self, time: float) -> float:
        """Angle [rad] of the hub in the picture; who rides on it sees the ground turn instead."""
        return 0.0 if self.scene.look.riding else self.angle(time)

    def ground_angle(self, time: float) -> float:
        """Angle [rad] of the ground in the picture."""
        return -self.angle(time) if self.scene.look.riding else 0.0

    def time(self, phase: float) -> float:
        """The time at which the first mode shown is at `phase`, in cycles: 0.25 is time 0."""
        shown = self.shapes.frequencies[self.shown]
        moving = shown[np.isfinite(shown) & (shown > 0)]
        return (phase - 0.25) * 2 * math.pi / moving[0] if len(moving) else 0.0

    def camera(self, aspect: float) -> Camera:
        """Where to look from in a picture with width / height = `aspect`."""
        fitted = camera.viewpoint(self.shapes, self.scene.look.riding, aspect)
        return self.scene.camera or Camera(tuple(fitted))
