"""Files made of a motion in time: numbers, a chart, a film."""

import json
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beamviz.checks import check_float, check_int
from beamviz.drawing import BeamScene, camera
from beamviz.drawing.beam_mesh import DEFAULT_SCALE, DrawnBeam
from beamviz.drawing.modes import playback_rate
from beamviz.drawing.motion import MotionShapes, dominant_frequency
from beamviz.drawing.scene_graph import DrawnScene
from beamviz.dynamics import Motion
from beamviz.exports import (
    FORMATS,
    FRAME_RATES,
    PIXELS,
    SAMPLE,
    check_format,
    rendered,
    structure_record,
    write_film,
)
from beamviz.exports.renderer import Renderer
from beamviz.exports.solved_scene import Moment
from beamviz.files import check_suffix, replaced
from beamviz.output.motion import motion_csv, si_columns
from beamviz.plotting import SUFFIXES as CHARTS
from beamviz.plotting import save_figure
from beamviz.plotting.motion import draw_motion
from beamviz.scene import Camera, Scene

SUFFIXES = (".csv", ".npz", *CHARTS, *FORMATS)
SECONDS = 3.0, 20.0  # shortest and longest film


def export_motion(
    path: str | Path, motion: Motion, progress: Callable[[int], Iterable[int]] = range
) -> None:
    """Write a motion as a file of the format its suffix names: .csv, .npz; a chart, .png, .svg or
    .pdf; a film, .gif, .webp or .mp4. progress: as in `beamviz.animate`. Raises InvalidInput and
    Unavailable; the file is complete or untouched."""
    suffix = check_suffix(path, SUFFIXES)
    if suffix in CHARTS:
        spectrum = motion.spectrum()
        figure = draw_motion(
            *(motion.t, motion.tip[:, 1], motion.gamma, spectrum), motion.beam.units
        )
        save_figure(Path(path), figure)
    elif suffix in FORMATS:
        animate_motion(path, motion, progress=progress)
    else:
        with replaced(path) as file:
            if suffix == ".csv":
                file.write_text(motion_csv(motion), encoding="utf-8")
                return
            with file.open("wb") as stream:
                np.savez_compressed(stream, **motion_arrays(motion))


def motion_arrays(motion: Motion) -> dict[str, Any]:
    """Everything in a motion as arrays: (n,) over time, and positions (n, stations, 2)."""
    x = np.linspace(0.0, 1.0, 101)
    beam = motion.beam
    return {
        **motion.columns,
        "x": x,
        "positions": motion.position(motion.t, x),
        "error": np.array(motion.error),
        "beam": np.array(list(beam.numbers.values())),
        "beam_names": np.array(list(beam.numbers)),
        "structure": np.array(json.dumps(structure_record(beam))),
        "units": np.array([beam.units.length, beam.units.time] if beam.units else []),
        **(si_columns(motion) if beam.units else {}),
        "model": np.array(json.dumps(dict(motion.model))),
        "drive": np.array(json.dumps(motion.drive.record)),
    }


def animate_motion(
    path: str | Path,
    motion: Motion,
    width: int = 640,
    height: int = 360,
    fps: float = 25.0,
    progress: Callable[[int], Iterable[int]] = range,
    workers: int | None = None,
) -> None:
    """Write a motion as a film, in the rotating frame; options as in `beamviz.animate`."""
    suffix = check_suffix(path, tuple(FORMATS))
    size = check_int("width", width, *PIXELS), check_int("height", height, *PIXELS)
    fps = check_format(suffix, size, check_float("fps", fps, *FRAME_RATES))
    with replaced(path) as file:
        scene = MotionScene(motion)
        count = max(round(scene.seconds * fps), 2)
        renderer = Renderer(scene, *size)
        frames, sample = (
            rendered(
                renderer,
                (scene.moment(k / (count - 1)) for k in numbers),
                workers or os.cpu_count() or 1,
            )
            for numbers in (progress(count), (count - 1) * np.arange(SAMPLE) // (SAMPLE - 1))
        )
        write_film(file, frames, fps, sample)


class MotionScene:
    """A motion as a scene of a film. seconds: of the film."""

    def __init__(self, motion: Motion):
        self.motion, self.scene = motion, Scene.of(nodes=False)
        self.shapes = MotionShapes(motion)
        rate = playback_rate(dominant_frequency(motion), float(motion.gamma.max()))
        self.seconds = float(np.clip(motion.t[-1] / rate, *SECONDS))

    def moment(self, part: float) -> Moment:
        """The scene when a part (0 .. 1) of the time has passed."""
        t = part * self.motion.t[-1]
        return Moment(self.shapes.phases(t), self.shapes.angle(t))

    def camera(self, aspect: float) -> Camera:
        """A camera that sees the beam at all times."""
        position = camera.viewpoint(self.shapes.sampled, True, aspect)
        reach = 1 + np.linalg.norm(self.reach(), ord=np.inf)
        return Camera((position * reach).tolist())

    def reach(self) -> NDArray:
        """How far the tip moves from the mean (2,)."""
        return abs(self.motion.tip - self.motion.tip.mean(axis=0)).max(axis=0)

    def draw(self, scene: DrawnScene, scale: float = DEFAULT_SCALE) -> BeamScene:
        """The scene, at `scale` [pixels per beam length]."""
        beams = BeamScene(scene)
        shapes = self.shapes
        beams.show(DrawnBeam(shapes.sampled, self.scene.view, scale, sizes=shapes.amplitudes))
        return beams
