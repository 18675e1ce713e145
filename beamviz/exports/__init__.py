"""Files made of a scene: pictures, films, a page that plays offline, a 3D model, numbers."""

import itertools
import json
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from beamviz.beam import Beam
from beamviz.checks import check_float, check_int
from beamviz.errors import InvalidInput, Unavailable
from beamviz.exports.renderer import Renderer
from beamviz.exports.solved_scene import Direction, Loop, SolvedScene
from beamviz.files import check_suffix, csv_text, plain, replaced
from beamviz.installation import install_command
from beamviz.scene import Scene
from beamviz.solver.solution import Solution
from beamviz.units import Units

SUFFIXES = (".html", ".glb", ".csv", ".npz")  # of exports
# By suffix, the unit [ms] in which a format counts the duration of a frame, 0 for any.
FORMATS = {".gif": 10, ".webp": 1, ".mp4": 0}
BT709 = 1  # in the tables of H.264
PIXELS = (64, 4096)  # width and height of a picture
FRAME_RATES = (5.0, 50.0)  # [1/s]; the limit of GIF
MAX_FRAMES = 1000
MAX_WORKERS = 1024
SAMPLE = 6  # frames that the palette of a GIF is chosen from
PNG_LEVEL = 1  # of compression: half the time of the default, a third larger
MODE_ARRAYS = ("labels", "families", "frequencies", "errors", "growth_rates")
LOADS = ("force", "shear", "moment")  # along the beam
MODE_COLUMNS = ("label", "family", "frequency", "error", "growth_rate", "bending_fraction")


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
    """Equilibrium and modes, one line for each mode and station; empty where not finite."""
    modes, line = solution.columns, solution.along_beam
    (x, y), (u, w) = line["position"].T, np.moveaxis(line["shape"], 2, 0)
    columns = {"mode": modes["index"][:, None]}
    columns |= {key: np.array(modes[key])[:, None] for key in MODE_COLUMNS}
    columns |= {"x": line["x"], "position_x": x, "position_y": y}
    columns |= {name: line[name] for name in ("stretch", *LOADS)}
    if units := solution.beam.units:
        columns |= {name: np.array(modes[name])[:, None] for name in ("hertz", "rad_per_s")}
        places = {"x_m": line["x"], "position_x_m": x, "position_y_m": y}
        columns |= {name: units.length * place for name, place in places.items()}
        columns |= loads_in_si(units, line)
    columns |= {"shape_x": u.real, "shape_y": w.real}
    if np.iscomplexobj(u):  # with Coriolis forces
        columns |= {"shape_x_imag": u.imag, "shape_y_imag": w.imag}
    full = (plain(np.broadcast_to(column, u.shape).ravel()) for column in columns.values())
    file.write_text(csv_text(columns, zip(*full, strict=True)), encoding="utf-8")


def field_arrays(solution: Solution) -> dict[str, Any]:
    """Everything in a solution as arrays: (modes,), and along the beam (stations,), position
    (stations, 2), shapes (modes, stations, 2); lengths in L, unit modal mass."""
    beam, line = solution.beam, solution.along_beam
    shapes = line.pop("shape")
    return {
        "beam": np.array(list(beam.numbers.values())),
        "beam_names": np.array(list(beam.numbers)),
        "structure": np.array(json.dumps(structure_record(beam))),
        "units": np.array([beam.units.length, beam.units.time] if beam.units else []),
        "model": np.array(json.dumps(solution.problem.model)),
        "status": np.array(solution.equilibrium.status),
        **{key: np.array(getattr(solution, key)) for key in MODE_ARRAYS},
        "bending_fractions": solution.bending_energy_fraction,
        **line,
        "shapes": shapes,
        **si_arrays(solution, line),
    }


def si_arrays(solution: Solution, line: dict[str, Any]) -> dict[str, Any]:
    """Of a beam in SI: frequencies in Hz, places [m], and its keywords of `Beam.from_si` as JSON
    where its mass is known; line: of `Solution.along_beam`."""
    units = solution.beam.units
    if units is None:
        return {}
    return {
        "frequencies_hertz": units.hertz(solution.frequencies),
        "x_m": units.length * line["x"],
        "position_m": units.length * line["position"],
        **loads_in_si(units, line),
        "si": np.array(json.dumps(solution.beam.si)),
    }


def loads_in_si(units: Units, line: dict[str, Any]) -> dict[str, Any]:
    """The loads along the beam [N, N m] where its mass is known; line: of `Solution.along_beam`."""
    if units.force is None:
        return {}
    return {
        "force_newtons": units.newtons(line["force"]),
        "shear_newtons": units.newtons(line["shear"]),
        "moment_newton_metres": units.newton_metres(line["moment"]),
    }


def structure_record(beam: Beam) -> dict[str, Any]:
    """The blade, masses and root of a beam that is not uniform, else {}."""
    return {name: value for name, value in beam.record.items() if name not in beam.numbers}


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
    0 .. n - 1 of n frames as they are rendered, and ends the film by an exception; workers:
    threads, by default one for each processor; width, height, direction, zoom: as in `screenshot`.

    Raises InvalidInput, Unavailable, and the errors of `solve`; the file is complete or untouched.
    """
    suffix = check_suffix(path, tuple(FORMATS))
    size = check_int("width", width, *PIXELS), check_int("height", height, *PIXELS)
    fps = check_format(suffix, size, check_float("fps", fps, *FRAME_RATES))
    periods = None if periods is None else check_int("periods", periods, 1, MAX_FRAMES)
    workers = None if workers is None else check_int("workers", workers, 1, MAX_WORKERS)
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


def rendered(
    renderer: Renderer, moments: Iterator[Any], workers: int | None
) -> Iterator[Image.Image]:
    """The frames of a film, in RGB, rendered in some threads, by default one for each processor."""
    threads = workers or os.cpu_count() or 1
    with ThreadPoolExecutor(threads) as pool:
        while together := list(itertools.islice(moments, threads)):
            yield from pool.map(renderer.picture, together)


def check_format(suffix: str, size: tuple[int, int], fps: float) -> float:
    """The nearest frame rate that a format has. Raises InvalidInput where it does not have films
    of that size, and Unavailable without its encoder."""
    if suffix == ".mp4":
        if find_spec("av") is None:
            command = install_command("film", "av")
            raise Unavailable(f"MP4 needs PyAV: {command} (.webp and .gif need nothing)")
        for name, pixels in zip(("width", "height"), size, strict=True):
            if pixels % 2:
                raise InvalidInput(f"{name} = {pixels}: must be even for MP4")
    tick = FORMATS[suffix]
    return 1000 / (tick * round(1000 / fps / tick)) if tick else fps


def write_film(
    file: Path, frames: Iterator[Image.Image], fps: float, sample: Iterable[Image.Image]
) -> None:
    """Write a looping film in the format of the suffix of a file; sample: frames that the palette
    of a GIF is chosen from, one for all frames so that nothing flickers."""
    if file.suffix.lower() == ".mp4":
        write_mp4(file, frames, fps)
        return
    options: dict[str, Any] = {"quality": 85, "method": 3}
    if file.suffix.lower() == ".gif":
        together = Image.fromarray(np.concatenate([*map(np.asarray, sample)]))
        # This method keeps the colours of small areas.
        palette = together.quantize(method=Image.Quantize.FASTOCTREE)
        frames = (frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames)
        options = {"disposal": 1}
    options |= {"duration": round(1000 / fps), "loop": 0}
    next(frames).save(file, save_all=True, append_images=frames, **options)


def write_mp4(file: Path, frames: Iterator[Image.Image], fps: float) -> None:
    """H.264 in the pixel format and colour space that every player supports."""
    import av

    first = next(frames)
    with av.open(str(file), "w", "mp4", {"movflags": "+faststart"}) as film:
        stream: Any = film.add_stream("libx264", Fraction(fps).limit_denominator(1000))
        stream.width, stream.height, stream.pix_fmt = *first.size, "yuv420p"
        stream.options, context = {"crf": "16"}, stream.codec_context
        context.colorspace = context.color_primaries = context.color_trc = BT709
        for frame in itertools.chain([first], frames):
            picture = av.VideoFrame.from_image(frame)
            film.mux(stream.encode(picture.reformat(format="yuv420p", dst_colorspace="ITU709")))
        film.mux(stream.encode())
