"""Files made of a scene: pictures, films, a page that plays offline, a 3D model, numbers."""

import itertools
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from beamviz.checks import check_float, check_int
from beamviz.errors import InvalidInput, Unavailable
from beamviz.export_formats import EXPORT_FORMATS
from beamviz.exports.renderer import Renderer
from beamviz.exports.solved_scene import Direction, Loop, SolvedScene
from beamviz.files import check_suffix, replaced
from beamviz.installation import install_command
from beamviz.scene import Scene

# By suffix, the unit [ms] in which a format counts the duration of a frame, 0 for any.
FORMATS = {".gif": 10, ".webp": 1, ".mp4": 0}
BT709 = 1  # in the tables of H.264
PIXELS = (64, 4096)  # width and height of a picture
FRAME_RATES = (5.0, 50.0)  # [1/s]; the limit of GIF
MAX_FRAMES = 1000
MAX_WORKERS = 1024
SAMPLE = 6  # frames that the palette of a GIF is chosen from
PNG_LEVEL = 1  # of compression: half the time of the default, a third larger


def export(path: str | Path, scene: Scene) -> list[Path]:
    """Write a scene as a file of the format its suffix names.

    .html: one page with film, chart and table that needs no network; .glb: an animated 3D model;
    .csv: the modes, and in a second file, .shapes.csv, the equilibrium and the shapes along the
    beam (see `csv_tables`), or .stations.csv, the section of a beam in SI; .toml: that beam (see
    `beam_files`); .npz: all of this (see `field_arrays`).

    Returns the files written. Raises InvalidInput, Unavailable, and the errors of `solve`; each
    file is complete or untouched.
    """
    path = Path(path)
    suffix = check_suffix(path, tuple(EXPORT_FORMATS))
    with replaced(path) as file:
        further = EXPORT_FORMATS[suffix].write(path, file, scene)
    return [path, *further]


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
    width: int = 800,
    height: int = 450,
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
        solved.follow(loop)
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
    of a GIF is chosen from."""
    if file.suffix.lower() == ".mp4":
        write_mp4(file, frames, fps)
        return
    options: dict[str, Any] = {"quality": 85, "method": 3}
    if file.suffix.lower() == ".gif":
        from beamviz.exports.gif_palette import Palette

        frames = map(Palette(sample).indexed, frames)
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
