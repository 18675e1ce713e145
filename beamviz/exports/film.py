"""Films: frames rendered on all processors, and written as GIF, WebP or MP4."""

import contextlib
import itertools
import os
import shutil
import subprocess
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from beamviz.errors import InvalidInput, Unavailable
from beamviz.exports.renderer import Renderer
from beamviz.exports.solved_scene import Moment
from beamviz.signals import defer_signals

# By suffix, the unit [ms] in which a format counts the duration of a frame, 0 for any.
FORMATS = {".gif": 10, ".webp": 1, ".mp4": 0}


def rendered(
    renderer: Renderer, moments: Iterator[Moment], workers: int | None = None
) -> Iterator[Image.Image]:
    """The frames of a film, in RGB, rendered by some workers (threads, by default one for each
    processor)."""
    workers = workers or os.cpu_count() or 1
    with ThreadPoolExecutor(workers) as pool:
        while together := list(itertools.islice(moments, workers)):
            yield from pool.map(renderer.picture, together)


def check_format(suffix: str, size: tuple[int, int], fps: float) -> float:
    """The nearest frame rate that a format has. Raises InvalidInput where it does not have films
    of that size, and Unavailable without its encoder."""
    if suffix == ".mp4":
        ffmpeg()
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
        palette = together.quantize(
            method=Image.Quantize.FASTOCTREE
        )  # keeps colours of small areas
        frames = (frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames)
        options = {"disposal": 1}
    options |= {"duration": round(1000 / fps), "loop": 0}
    next(frames).save(file, save_all=True, append_images=frames, **options)


def write_mp4(file: Path, frames: Iterator[Image.Image], fps: float) -> None:
    """H.264 in the pixel format and colour space that every player supports."""
    first = next(frames)
    size = f"{first.width}x{first.height}"
    source = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size, "-r", f"{fps:g}", "-i", "-"]
    tags = ("-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709")
    command = [
        *(ffmpeg(), "-v", "error", "-y", *source),
        *("-vf", "scale=out_color_matrix=bt709", "-c:v", "libx264", "-crf", "16"),
        *("-pix_fmt", "yuv420p", *tags, "-movflags", "+faststart", "-f", "mp4", str(file)),
    ]
    pipes: Any = dict.fromkeys(("stdin", "stderr"), subprocess.PIPE)
    with defer_signals():  # a new session: Ctrl-C is handled by this process
        process = subprocess.Popen(command, start_new_session=True, **pipes)
    assert process.stdin
    with process:
        try:
            with contextlib.suppress(BrokenPipeError):  # reported below
                for frame in itertools.chain([first], frames):
                    process.stdin.write(frame.tobytes())
            errors = process.communicate()[1].decode(errors="replace").strip()
        finally:
            process.kill()
    if process.returncode:
        raise OSError(errors.splitlines()[-1] if errors else f"{command[0]} failed")


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
