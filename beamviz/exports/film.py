"""Encoders of films: GIF and WebP by Pillow, MP4 by ffmpeg."""

import contextlib
import itertools
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np
from PIL import Image

from beamviz.errors import InvalidInput, Unavailable
from beamviz.signals import defer_signals

NO_FFMPEG = (
    "no ffmpeg found, which MP4 needs: pip install imageio-ffmpeg (.webp and .gif need nothing)"
)
COMMON_COLOURS = 96  # of the 256 of a GIF, chosen by area
COARSE = 0xF8  # mask of a colour channel: smaller differences count as the same colour
Frames = Iterator[np.ndarray]  # each (height, width, 3), bytes


class Encoder(NamedTuple):
    """A film format.

    check(width, height): raises where the film cannot be written; write(file, frames, fps,
    sample): writes it; sample: number of frames, spread over the film, that `write` needs first;
    tick: unit [ms] in which the format counts the duration of a frame, 0 for any.
    """

    check: Callable[[int, int], None]
    write: Callable[[Path, Frames, float, list[np.ndarray]], None]
    sample: int = 0
    tick: int = 0

    def nearest_rate(self, fps: float) -> float:
        """The frame rate nearest to `fps` that the format can have."""
        if not self.tick:
            return fps
        return 1000 / (self.tick * round(1000 / fps / self.tick))


def write_gif(file: Path, frames: Frames, fps: float, sample: list[np.ndarray]) -> None:
    """A GIF with one palette for all frames, so that nothing flickers."""
    palette = gif_palette(np.concatenate(sample))
    pictures = (
        Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in frames
    )
    save_with_pillow(file, "GIF", pictures, fps, disposal=1)


def write_webp(file: Path, frames: Frames, fps: float, sample: list[np.ndarray]) -> None:
    """A WebP film in full colour."""
    save_with_pillow(file, "WEBP", map(Image.fromarray, frames), fps, quality=85, method=3)


def save_with_pillow(
    file: Path, kind: str, pictures: Iterator[Image.Image], fps: float, **options: int
) -> None:
    """Write pictures as one looping film."""
    duration = round(1000 / fps)  # [ms]
    next(pictures).save(
        file, kind, save_all=True, append_images=pictures, duration=duration, loop=0, **options
    )


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


def write_mp4(file: Path, frames: Frames, fps: float, sample: list[np.ndarray]) -> None:
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
    with tempfile.TemporaryFile() as errors, run_encoder(command, errors) as process:
        assert process.stdin
        with contextlib.suppress(BrokenPipeError), process.stdin as pipe:  # reported below
            for frame in itertools.chain([first], frames):
                pipe.write(frame.tobytes())
        if process.wait():
            errors.seek(0)
            lines = errors.read().decode(errors="replace").strip().splitlines()
            raise OSError(lines[-1] if lines else f"{command[0]} failed")


@contextlib.contextmanager
def run_encoder(command: list[str], errors: IO[bytes]) -> Iterator[subprocess.Popen]:
    """A program that reads its stdin; killed at the end if it still runs."""
    with defer_signals():
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=errors,
            start_new_session=True,  # Ctrl-C is handled by this process
        )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def check_mp4(width: int, height: int) -> None:
    """Unavailable without ffmpeg, InvalidInput for an odd size."""
    ffmpeg()
    for name, pixels in (("width", width), ("height", height)):
        if pixels % 2:
            raise InvalidInput(f"{name} = {pixels}: must be even for MP4")


def ffmpeg() -> str:
    """The path of ffmpeg: of imageio-ffmpeg, or of the system; else Unavailable."""
    with contextlib.suppress(ImportError, RuntimeError):
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    if found := shutil.which("ffmpeg"):
        return found
    raise Unavailable(NO_FFMPEG)


def accept_any_size(width: int, height: int) -> None:
    """Pillow takes every size."""


ENCODERS = {
    ".gif": Encoder(accept_any_size, write_gif, sample=6, tick=10),
    ".webp": Encoder(accept_any_size, write_webp, tick=1),
    ".mp4": Encoder(check_mp4, write_mp4),
}
