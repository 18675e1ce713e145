"""A saved scene, solved: what a picture or a film shows at any moment."""

import math
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from beamviz.beam import check_float
from beamviz.drawing import camera
from beamviz.drawing.all_modes import heights
from beamviz.drawing.modes import Shapes, amplitudes
from beamviz.drawing.subdivision import SCALE, Seen
from beamviz.errors import InvalidInput
from beamviz.messages import stability_warning
from beamviz.scene import Camera, Scene
from beamviz.solver import Solution, solve

Direction = tuple[float, float, float]
ZOOMS = (0.1, 100.0)
STEEP = 1e-3  # from straight above, y is up in the picture


class Moment(NamedTuple):
    """Phase (m,) [rad] of every mode, and the angle [rad] by which the hub has turned."""

    phases: np.ndarray
    angle: float


@dataclass(frozen=True)
class Shot:
    """A scene with its solution. Time runs in T* from a moment at which every mode has its
    largest displacement; `words` say what is wrong with the equilibrium, if anything is."""

    scene: Scene
    solution: Solution
    shapes: Shapes
    words: str
    direction: Direction | None = None
    zoom: float = 1.0

    @classmethod
    def of(cls, scene: Scene, direction: Direction | None = None, zoom: float = 1.0) -> Self:
        """Solve a scene; raises what `solve` raises. direction, zoom: where to look from to the
        middle of the scene, in place of its camera."""
        if direction and not any(direction):
            raise InvalidInput("from = 0,0,0: must be a direction")
        zoom = check_float("zoom", zoom, *ZOOMS)
        solution = solve(scene.beam, **scene.solver_options)
        return cls(scene, solution, Shapes.sampled(solution), stability_warning(solution), direction, zoom)

    @property
    def amplitudes(self) -> np.ndarray:
        """Amplitude (m,) of every mode."""
        return amplitudes(self.scene.view, len(self.shapes.modes))

    @property
    def shown(self) -> list[int]:
        """The modes (from 0) in the picture."""
        if self.all_modes:
            return list(range(len(self.shapes.modes)))
        return np.flatnonzero(self.amplitudes).tolist()

    def moment(self, time: float) -> Moment:
        """The scene at a time."""
        turned = time * np.nan_to_num(self.shapes.frequencies)
        return Moment(math.pi / 2 + turned, time * self.scene.beam.gamma)

    def time(self, phase: float) -> float:
        """The time at which the first mode shown is at `phase`, in cycles: 0.25 is time 0."""
        shown = self.shapes.frequencies[self.shown]
        moving = shown[np.isfinite(shown) & (shown > 0)]
        return (phase - 0.25) * 2 * math.pi / moving[0] if len(moving) else 0.0

    @property
    def all_modes(self) -> bool:
        """Whether every mode has a picture of its own."""
        return self.scene.view.all_modes and not self.words

    def camera(self, aspect: float) -> Camera:
        """Where to look from in a picture with width / height = `aspect`."""
        given = self.scene.camera
        if given and not self.direction:
            away = np.subtract(given.position, given.look_at) / self.zoom
            return Camera((given.look_at + away).tolist(), given.look_at)
        levels = heights(len(self.shapes.modes)) if self.all_modes else (0.0,)
        rotating_frame = self.scene.view.rotating_frame
        position = camera.viewpoint(
            self.shapes, rotating_frame, aspect, 0.0, levels, self.from_above()
        )
        return Camera((position * (1 + self.reach) / self.zoom).tolist())

    def scale(self, width: int, height: int) -> float:
        """Pixels that a length of the beam takes in a picture."""
        view = self.camera(width / height)
        away = float(np.linalg.norm(np.subtract(view.position, view.look_at)))
        return camera.scale(away, height)

    def seen(self, scale: float = SCALE) -> Seen:
        """What a picture shows of the beam."""
        return Seen.of(self.shapes, self.amplitudes, self.scene.view.colouring, scale)

    @property
    def reach(self) -> float:
        """How far the beam gets out along itself, in lengths of the beam."""
        sizes = np.minimum(self.amplitudes, self.shapes.limits)
        return float(sizes @ np.abs(self.shapes.modes[:, :, 0]).max(axis=1))

    def from_above(self) -> Direction | None:
        """The direction to look from, never quite along the axis."""
        if self.direction is None:
            return None
        x, y, z = self.direction
        return (x, y if math.hypot(x, y) > STEEP * abs(z) else -STEEP * abs(z), z)
