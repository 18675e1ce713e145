"""Frames into files: GIF and WebP by Pillow, MP4 by ffmpeg."""

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
GROUND, COARSE = 96, 0xF8  # colours of a GIF for what fills the picture; what tells others apart
Frames = Iterator[np.ndarray]  # each (height, width, 3)


class Encoder(NamedTuple):
    """check(width, height) says beforehand what stands in the way; write(file, frames, fps, sample)
    writes; sample: how many frames, spread over the film, it wants to see first; tick [ms]: what
    the file counts the time of a frame in, 0 where it can be anything."""

    check: Callable[[int, int], None]
    write: Callable[[Path, Frames, float, list[np.ndarray]], None]
    sample: int = 0
    tick: int = 0

    def rate(self, fps: float) -> float:
        """The frames in a second, nearly `fps`, that the file can have."""
        if not self.tick:
            return fps
        return 1000 / (self.tick * round(1000 / fps / self.tick))


def write_gif(file: Path, frames: Frames, fps: float, sample: list[np.ndarray]) -> None:
    """One palette for all frames, made from a sample, so that nothing flickers."""
    palette = palette_of(np.concatenate(sample))
    pictures = (
        Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in frames
    )
    duration = round(1000 / fps)  # [ms]
    next(pictures).save(
        file, "GIF", save_all=True, append_images=pictures, duration=duration, loop=0, disposal=1
    )


def palette_of(picture: np.ndarray) -> Image.Image:
    """256 colours for a picture (h, w, 3): the one of the background as it is, a part by how many
    pixels have them, the others by what colours there are at all, or the ground would leave none
    for the beam."""
    every = np.unique(picture.reshape(-1, 3) & COARSE, axis=0)[None]
    each, times = np.unique(picture.reshape(-1, 3), axis=0, return_counts=True)
    colours: list[int] = each[times.argmax()].tolist()
    for pixels, count in ((picture, GROUND), (every, 255 - GROUND)):
        reduced = Image.fromarray(pixels).quantize(count, dither=Image.Dither.NONE)
        colours += (reduced.getpalette() or [])[: 3 * count]
    palette = Image.new("P", (1, 1))
    palette.putpalette(colours)
    return palette


def write_webp(file: Path, frames: Frames, fps: float, sample: list[np.ndarray]) -> None:
    """Full colour."""
    pictures = map(Image.fromarray, frames)
    next(pictures).save(
        file,
        "WEBP",
        save_all=True,
        append_images=pictures,
        duration=round(1000 / fps),
        loop=0,
        quality=85,
        method=3,
    )


def write_mp4(file: Path, frames: Frames, fps: float, sample: list[np.ndarray]) -> None:
    """H.264 in the colours that every player understands."""
    first = next(frames)
    size = f"{first.shape[1]}x{first.shape[0]}"
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size, "-r", f"{fps:g}", "-i", "-"]
    colours = [f"-{name}" for name in ("colorspace", "color_primaries", "color_trc")]
    tagged = [word for name in colours for word in (name, "bt709")]
    command = [
        *(ffmpeg(), "-v", "error", "-y", *raw),
        *("-vf", "scale=out_color_matrix=bt709", "-c:v", "libx264", "-crf", "16"),
        *("-pix_fmt", "yuv420p", *tagged, "-movflags", "+faststart", "-f", "mp4", str(file)),
    ]
    with tempfile.TemporaryFile() as said, running(command, said) as process:
        assert process.stdin
        with contextlib.suppress(BrokenPipeError), process.stdin as pipe:  # it says why it ended
            for frame in itertools.chain([first], frames):
                pipe.write(frame.tobytes())
        if process.wait():
            said.seek(0)
            words = said.read().decode(errors="replace").strip().splitlines()
            raise OSError(words[-1] if words else f"{command[0]} failed")


@contextlib.contextmanager
def running(command: list[str], said: IO[bytes]) -> Iterator[subprocess.Popen]:
    """A program that is fed through its stdin and ended on leaving; it complains into `said`."""
    with defer_signals():
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=said,
            start_new_session=True,  # Ctrl-C is for us
        )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def check_mp4(width: int, height: int) -> None:
    """An encoder is there, and the size is one it takes."""
    ffmpeg()
    for name, pixels in (("width", width), ("height", height)):
        if pixels % 2:
            raise InvalidInput(f"{name} = {pixels}: must be even for MP4")


def ffmpeg() -> str:
    """The program: the one that imageio-ffmpeg brings, or the system's; else Unavailable."""
    with contextlib.suppress(ImportError, RuntimeError):
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    if found := shutil.which("ffmpeg"):
        return found
    raise Unavailable(NO_FFMPEG)


def check_nothing(width: int, height: int) -> None:
    """Pillow takes every size."""


ENCODERS = {
    ".gif": Encoder(check_nothing, write_gif, sample=6, tick=10),
    ".webp": Encoder(check_nothing, write_webp, tick=1),
    ".mp4": Encoder(check_mp4, write_mp4),
}
