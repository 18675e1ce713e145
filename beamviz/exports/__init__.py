"""Files made of a scene: pictures, films, a page that plays offline, a 3D model, numbers."""

import contextlib
import itertools
import json
import math
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from beamviz.beam import check_float, check_int
from beamviz.errors import InvalidInput, Unavailable
from beamviz.exports.gltf import write_glb
from beamviz.exports.html_page import write_html
from beamviz.exports.renderer import open_renderer, over_background
from beamviz.exports.solved_scene import Direction, Loop, SolvedScene, find_loop
from beamviz.files import check_suffix, replaced
from beamviz.output import csv_text, plain
from beamviz.scene import Scene
from beamviz.signals import defer_signals
from beamviz.solver import Solution

PIXELS = (64, 4096)  # width and height of a picture
FRAME_RATES = (5.0, 50.0)  # [1/s]; the limit of GIF
MAX_FRAMES = 1000
PALETTE_SAMPLE = 6  # frames that the palette of a GIF is chosen from
COMMON_COLOURS = 96  # of the 256 of a GIF, chosen by area
COARSE = 0xF8  # mask of a colour channel: smaller differences count as the same colour
STATIONS = 201  # equally spaced along the beam; the position of the mass is added to them
FIELD_COLUMNS = [
    *("mode", "label", "family", "frequency", "error", "growth_rate", "bending_fraction"),
    *("x", "position_x", "position_y", "stretch", "shape_x", "shape_y"),
]
IMAGINARY_COLUMNS = ["shape_x_imag", "shape_y_imag"]  # of complex modes, with Coriolis forces
Frames = Iterator[np.ndarray]  # each (height, width, 3), bytes


def export(path: str | Path, scene: Scene) -> None:
    """Write a scene as a file of the format its suffix names.

    .html: one page with film, chart and table that needs no network; .glb: an animated 3D model;
    .csv, .npz: frequencies, shapes and equilibrium (see `field_arrays`).

    Raises InvalidInput, Unavailable, and the errors of `solve`; the file is complete or untouched.
    """
    path = Path(path)
    write = WRITERS[check_suffix(path, tuple(WRITERS))]
    with replaced(path) as file:
        write(file, SolvedScene.of(scene))


def write_csv(file: Path, solved: SolvedScene) -> None:
    """Equilibrium and modes along the beam, one line for each mode and station; a number that is
    not finite is left empty."""
    solution = solved.solution
    arrays = field_arrays(solution)
    heading, shapes = FIELD_COLUMNS, [arrays["shapes"]]
    if np.iscomplexobj(shapes[0]):
        heading, shapes = FIELD_COLUMNS + IMAGINARY_COLUMNS, [shapes[0].real, shapes[0].imag]
    state = [arrays[key] for key in ("x", "position", "stretch")]
    modes = ("frequencies", "errors", "growth_rates", "bending_fractions")
    rows = (
        [k + 1, label, family, *plain([arrays[key][k] for key in modes]), *plain(row)]
        for k, (label, family) in enumerate(zip(solution.labels, solution.families, strict=True))
        for row in np.column_stack([*state, *(part[k] for part in shapes)])
    )
    file.write_text(csv_text(heading, rows))


def write_npz(file: Path, solved: SolvedScene) -> None:
    """Equilibrium and modes along the beam as arrays."""
    arrays: dict[str, Any] = field_arrays(solved.solution)
    with file.open("wb") as stream:  # given a path, numpy would add a suffix
        np.savez_compressed(stream, **arrays)


def field_arrays(solution: Solution) -> dict[str, np.ndarray]:
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
        "labels": np.array(solution.labels),
        "families": np.array(solution.families),
        "frequencies": solution.frequencies,
        "errors": solution.errors,
        "growth_rates": solution.growth_rates,
        "bending_fractions": solution.bending_energy_fraction,
        "x": x,
        "position": state.position(x),
        "stretch": state.stretch(x),
        "shapes": np.moveaxis(solution.displacement(x), 2, 0) + 0.0,  # -0.0 becomes 0.0
    }


WRITERS: dict[str, Callable[[Path, SolvedScene], None]] = {
    ".html": write_html,
    ".glb": write_glb,
    ".csv": write_csv,
    ".npz": write_npz,
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
    path = Path(path)
    check_suffix(path, [".png"])
    size = check_int("width", width, *PIXELS), check_int("height", height, *PIXELS)
    if not math.isfinite(phase):
        raise InvalidInput(f"phase = {phase}: must be finite")
    with replaced(path) as file:
        solved = SolvedScene.of(scene, direction, zoom)
        with open_renderer(solved, *size, supersampling=2) as render:
            picture = render(solved.moment(solved.time(phase)))
        if not transparent:
            picture = over_background(picture, scene.view)
        Image.fromarray(picture).save(file, "PNG")


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
) -> Loop:
    """Write a scene as a seamless film: .gif, .webp or .mp4, by the suffix.

    fps: frames per second, 5 .. 50 (a GIF rounds to hundredths of a second per frame); periods: of
    the first mode shown, by default as few as make a seamless loop; progress: yields the numbers
    0 .. n - 1 of n frames as they are rendered; width, height, direction, zoom: as in `screenshot`.

    Raises InvalidInput, Unavailable, and the errors of `solve`; the file is complete or untouched.
    """
    path = Path(path)
    suffix = check_suffix(path, tuple(ENCODERS))
    write, tick = ENCODERS[suffix]
    size = check_int("width", width, *PIXELS), check_int("height", height, *PIXELS)
    fps = check_float("fps", fps, *FRAME_RATES)
    if tick:
        fps = 1000 / (tick * round(1000 / fps / tick))
    if suffix == ".mp4":
        ffmpeg()  # raises Unavailable
        for name, pixels in zip(("width", "height"), size, strict=True):
            if pixels % 2:
                raise InvalidInput(f"{name} = {pixels}: must be even for MP4")
    periods = None if periods is None else check_int("periods", periods, 1, MAX_FRAMES)
    with replaced(path) as file:
        solved = SolvedScene.of(scene, direction, zoom)
        loop = find_loop(solved, periods)
        count = round(loop.seconds * fps)
        if count > MAX_FRAMES:
            raise InvalidInput(
                f"the film has {count} frames: must be at most {MAX_FRAMES}; ask for fewer"
                " periods, a lower fps or a higher pace"
            )
        with open_renderer(solved, *size) as render:

            def frames(numbers: Iterable[int]) -> Iterator[np.ndarray]:
                for k in numbers:
                    yield over_background(render(loop.moment(k / count)), scene.view)

            sample = np.linspace(0, count, PALETTE_SAMPLE, endpoint=False).astype(int)
            write(file, frames(progress(count)), fps, frames(sample))
    return loop


def write_with_pillow(file: Path, frames: Frames, fps: float, sample: Frames) -> None:
    """A looping GIF, with one palette for all frames so that nothing flickers, or WebP."""
    pictures: Iterator[Image.Image] = map(Image.fromarray, frames)
    options: dict[str, Any] = {"duration": round(1000 / fps), "loop": 0}
    if file.suffix.lower() == ".gif":
        palette = gif_palette(np.concatenate(list(sample)))
        pictures = (
            picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures
        )
        options |= {"disposal": 1}
    else:
        options |= {"quality": 85, "method": 3}
    next(pictures).save(file, save_all=True, append_images=pictures, **options)


def gif_palette(picture: np.ndarray) -> Image.Image:
    """256 colours for a picture (h, w, 3): the background exactly, some by the area they cover, the
    others by the distinct colours, or the ground would leave none for the beam."""
    distinct = np.unique(picture.reshape(-1, 3) & COARSE, axis=0)[None]
    colours, counts = np.unique(picture.reshape(-1, 3), axis=0, return_counts=True)
    entries: list[int] = colours[counts.argmax()].tolist()
    for pixels, count in ((picture, COMMON_COLOURS), (distinct, 255 - COMMON_COLOURS)):
        reduced = Image.fromarray(pixels).quantize(count, dither=Image.Dither.NONE)
        entries += (reduced.getpalette() or [])[: 3 * count]
    palette = Image.new("P", (1, 1))
    palette.putpalette(entries)
    return palette


def write_mp4(file: Path, frames: Frames, fps: float, sample: Frames) -> None:
    """H.264 in the pixel format and colour space that every player supports."""
    first = next(frames)
    size = f"{first.shape[1]}x{first.shape[0]}"
    source = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size, "-r", f"{fps:g}", "-i", "-"]
    tags = ("-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709")
    command = [
        *(ffmpeg(), "-v", "error", "-y", *source),
        *("-vf", "scale=out_color_matrix=bt709", "-c:v", "libx264", "-crf", "16"),
        *("-pix_fmt", "yuv420p", *tags, "-movflags", "+faststart", "-f", "mp4", str(file)),
    ]
    with tempfile.TemporaryFile() as errors:
        with defer_signals():
            process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=errors,
                start_new_session=True,  # Ctrl-C is handled by this process
            )
        try:
            assert process.stdin
            with contextlib.suppress(BrokenPipeError), process.stdin as pipe:  # reported below
                for frame in itertools.chain([first], frames):
                    pipe.write(frame.tobytes())
            failed = process.wait()
        finally:
            process.kill()
            process.wait()
        if failed:
            errors.seek(0)
            lines = errors.read().decode(errors="replace").strip().splitlines()
            raise OSError(lines[-1] if lines else f"{command[0]} failed")


def ffmpeg() -> str:
    """The path of ffmpeg: of imageio-ffmpeg, or of the system; else Unavailable."""
    with contextlib.suppress(ImportError, RuntimeError):
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    if found := shutil.which("ffmpeg"):
        return found
    raise Unavailable(
        "no ffmpeg found, which MP4 needs: pip install imageio-ffmpeg (.webp and .gif need nothing)"
    )


# How a film is written: (file, frames, frames per second, sample of the frames); and the unit [ms]
# in which the format counts the duration of a frame, 0 for any.
Encoder = Callable[[Path, Frames, float, Frames], None]
ENCODERS: dict[str, tuple[Encoder, int]] = {
    ".gif": (write_with_pillow, 10),
    ".webp": (write_with_pillow, 1),
    ".mp4": (write_mp4, 0),
}
