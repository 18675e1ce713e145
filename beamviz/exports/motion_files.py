"""Files made of a motion in time: numbers, a chart, a film, a page that plays offline."""

import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from beamviz.checks import check_float, check_int
from beamviz.dynamics import Motion
from beamviz.dynamics.linear import LinearMotion
from beamviz.exports import (
    FORMATS,
    FRAME_RATES,
    MAX_WORKERS,
    PIXELS,
    SAMPLE,
    check_format,
    rendered,
    write_film,
)
from beamviz.exports.arrays import structure_record
from beamviz.exports.motion_scene import USUAL_VIEW, MotionScene, beside
from beamviz.exports.renderer import Renderer
from beamviz.files import check_suffix, replaced
from beamviz.output.motion import motion_csv, si_columns
from beamviz.plotting import SUFFIXES as CHARTS
from beamviz.plotting import save_figure
from beamviz.plotting.motion import draw_motion
from beamviz.scene import ViewOptions

SUFFIXES = (".csv", ".npz", ".html", *CHARTS, *FORMATS)


def export_motion(
    path: str | Path,
    motion: Motion,
    progress: Callable[[int], Iterable[int]] = range,
    *,
    view: ViewOptions = USUAL_VIEW,
    unstiffened: LinearMotion | None = None,
) -> None:
    """Write a motion as a file of the format its suffix names: .csv, .npz; a chart, .png, .svg or
    .pdf; a film, .gif, .webp or .mp4; .html, one page with film, chart and numbers that needs no
    network. progress: as in `beamviz.animate`; view: how a film or page draws the beam, and whether
    it is dark; unstiffened: the motion without stiffening, beside it in charts, films and pages.
    Raises InvalidInput and Unavailable; the file is complete or untouched."""
    suffix = check_suffix(path, SUFFIXES)
    if suffix in CHARTS:
        spectrum = motion.spectrum()
        columns = motion.t, motion.tip[:, 1], motion.gamma, spectrum
        figure = draw_motion(*columns, motion.beam.units, second=beside(unstiffened))
        save_figure(Path(path), figure)
    elif suffix in FORMATS:
        animate_motion(path, motion, progress=progress, view=view, unstiffened=unstiffened)
    elif suffix == ".html":
        from beamviz.exports.motion_page import motion_page

        with replaced(path) as file:
            file.write_text(motion_page(motion, unstiffened, view), encoding="utf-8")
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
    width: int = 800,
    height: int = 450,
    fps: float = 25.0,
    progress: Callable[[int], Iterable[int]] = range,
    workers: int | None = None,
    *,
    view: ViewOptions = USUAL_VIEW,
    unstiffened: LinearMotion | None = None,
) -> None:
    """Write a motion as a film, in the rotating frame; options as in `beamviz.animate`, and as in
    `export_motion`."""
    suffix = check_suffix(path, tuple(FORMATS))
    size = check_int("width", width, *PIXELS), check_int("height", height, *PIXELS)
    fps = check_format(suffix, size, check_float("fps", fps, *FRAME_RATES))
    workers = None if workers is None else check_int("workers", workers, 1, MAX_WORKERS)
    with replaced(path) as file:
        scene = MotionScene(motion, unstiffened, view)
        count = max(round(scene.seconds * fps), 2)
        renderer = Renderer(scene, *size)
        frames, sample = (
            rendered(renderer, (k / (count - 1) * motion.t[-1] for k in numbers), workers)
            for numbers in (progress(count), (count - 1) * np.arange(SAMPLE) // (SAMPLE - 1))
        )
        write_film(file, frames, fps, sample)
