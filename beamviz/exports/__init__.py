"""Files made of a scene: pictures, films, a page that plays offline, a 3D model, numbers."""

import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from beamviz.beam import check_float, check_int
from beamviz.errors import InvalidInput
from beamviz.exports.film import FORMATS, check_format, rendered, write_film
from beamviz.exports.renderer import Renderer
from beamviz.exports.solved_scene import Direction, Loop, SolvedScene
from beamviz.files import check_suffix, replaced
from beamviz.scene import Scene
from beamviz.solver import Solution

SUFFIXES = (".html", ".glb", ".csv", ".npz")  # of exports
PIXELS = (64, 4096)  # width and height of a picture
FRAME_RATES = (5.0, 50.0)  # [1/s]; the limit of GIF
MAX_FRAMES = 1000
SAMPLE = 6  # frames that the palette of a GIF is chosen from
PNG_LEVEL = 1  # of compression: half the time of the default, a third larger
STATIONS = 201  # equally spaced along the beam; the position of the mass is added to them
MODE_ARRAYS = ("labels", "families", "frequencies", "errors", "growth_rates")
FIELD_COLUMNS = [
    *("mode", "label", "family", "frequency", "error", "growth_rate", "bending_fraction"),
    *("x", "position_x", "position_y", "stretch", "shape_x", "shape_y"),
]
IMAGINARY_COLUMNS = ["shape_x_imag", "shape_y_imag"]  # of complex modes, with Coriolis forces


def export(path: str | Path, scene: Scene) -> None:
    """Write a scene as a file of the format its suffix names.

    .html: one page with film, chart and table that needs no network; .glb: an animated 3D model;
    .csv, .npz: frequencies, shapes and equilibrium (see `field_arrays`).

    Raises InvalidInput, Unavailable, and the errors of `solve`; the file is complete or untouched.
    """
    suffix = check_suffix(path, SUFFIXES)
    with replaced(path) as file:
        solved = SolvedScene(scene)
        if suffix in (".html", ".glb"):
            from beamviz.exports import gltf, html_page

            write = {".html": html_page.write_html, ".glb": gltf.write_glb}[suffix]
            write(file, solved)
        elif suffix == ".csv":
            write_csv(file, solved.solution)
        else:
            with file.open("wb") as stream:  # given a path, numpy would add a suffix
                np.savez_compressed(stream, **field_arrays(solved.solution))


def write_csv(file: Path, solution: Solution) -> None:
    """Equilibrium and modes along the beam, one line for each mode and station; a number that is
    not finite is left empty."""
    from beamviz.output import csv_text, plain

    arrays, heading = field_arrays(solution), FIELD_COLUMNS
    state = [arrays[key] for key in ("x", "position", "stretch")]
    modes = [arrays[key] for key in (*MODE_ARRAYS, "bending_fractions", "shapes")]
    if np.iscomplexobj(modes[-1]):
        heading = heading + IMAGINARY_COLUMNS
        modes[-1] = np.dstack([modes[-1].real, modes[-1].imag])
    rows = (
        [k, *plain(mode), *plain(row)]
        for k, (*mode, shape) in enumerate(zip(*modes, strict=True), 1)
        for row in np.column_stack([*state, shape])
    )
    file.write_text(csv_text(heading, rows), encoding="utf-8")


def field_arrays(solution: Solution) -> dict[str, Any]:
    """Everything in a solution as arrays: (modes,), and along the beam (stations,), position
    (stations, 2), shapes (modes, stations, 2); lengths in L, unit modal mass."""
    beam, state = solution.beam, solution.equilibrium
    x = np.union1d(np.linspace(0.0, 1.0, STATIONS), [beam.beta])
    return {
        "beam": np.array(list(beam.numbers.values())),
        "beam_names": np.array(list(beam.numbers)),
        "units": np.array([beam.units.length, beam.units.time] if beam.units else []),
        "model": np.array(json.dumps(solution.problem.model)),
        "status": np.array(state.status),
        **{key: np.array(getattr(solution, key)) for key in MODE_ARRAYS},
        "bending_fractions": solution.bending_energy_fraction,
        "x": x,
        "position": state.position(x),
        "stretch": state.stretch(x),
        "shapes": np.moveaxis(solution.displacement(x), 2, 0) + 0.0,  # -0.0 becomes 0.0
    }


def screenshot(
    path: str | Path,
    scene: Scene,
    width: int = 1280,
    height: int = 720,
    phase: float = 0.25,
    transparent: bool = False,
    direction: Direction | None = None,
    zoom: float = 1.0,
) -> None:
    """Write a scene as a PNG of `width` by `height` pixels, each 64 .. 4096.

    phase: of the first mode shown, in periods; 0.25 is its largest displacement. direction: from
    the middle of the scene to the camera, in place of the scene's camera; zoom: 0.1 .. 100.

    Raises InvalidInput, Unavailable, and the errors of `solve`; the file is complete or untouched.
    """
    check_suffix(path, [".png"])
    size = check_int("width", width, *PIXELS), check_int("height", height, *PIXELS)
    phase = check_float("phase", phase)
    with replaced(path) as file:
        solved = SolvedScene(scene, direction, zoom)
        picture = Renderer(solved, *size).picture(solved.moment(phase), transparent=transparent)
        picture.save(file, "PNG", compress_level=PNG_LEVEL)


def animate(
    path: str | Path,
    scene: Scene,
    width: int = 640,
    height: int = 360,
    fps: float = 25.0,
    periods: int | None = None,
    direction: Direction | None = None,
    zoom: float = 1.0,
    progress: Callable[[int], Iterable[int]] = range,
    workers: int | None = None,
) -> Loop:
    """Write a scene as a seamless film: .gif, .webp or .mp4, by the suffix.

    fps: frames per second, 5 .. 50 (a GIF rounds to hundredths of a second per frame); periods: of
    the first mode shown, by default as few as make a seamless loop; progress: yields the numbers
    0 .. n - 1 of n frames as they are rendered, and ends the film by an exception; workers: threads
    that render, by default one for each processor; width, height, direction, zoom: as in
    `screenshot`.

    Raises InvalidInput, Unavailable, and the errors of `solve`; the file is complete or untouched.
    """
    suffix = check_suffix(path, tuple(FORMATS))
    size = check_int("width", width, *PIXELS), check_int("height", height, *PIXELS)
    fps = check_format(suffix, size, check_float("fps", fps, *FRAME_RATES))
    periods = None if periods is None else check_int("periods", periods, 1, MAX_FRAMES)
    with replaced(path) as file:
        solved = SolvedScene(scene, direction, zoom)
        loop = Loop(solved, periods)
        count = round(loop.seconds * fps)
        if count > MAX_FRAMES:
            raise InvalidInput(
                f"the film has {count} frames: must be at most {MAX_FRAMES}; ask for fewer"
                " periods, a lower fps or a higher pace"
            )
        renderer = Renderer(solved, *size)
        frames, sample = (
            rendered(renderer, (loop.moment(k / count) for k in numbers), workers)
            for numbers in (progress(count), count * np.arange(SAMPLE) // SAMPLE)
        )
        write_film(file, frames, fps, sample)
    return loop
