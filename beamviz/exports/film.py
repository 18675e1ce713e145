"""Films: frames rendered on all processors, and written as GIF, WebP or MP4."""

import contextlib
import itertools
import os
import shutil
import subprocess
import tempfile
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from PIL import Image

from beamviz.errors import InvalidInput, Unavailable
from beamviz.exports.renderer import Renderer
from beamviz.exports.solved_scene import Moment
from beamviz.signals import defer_signals

PALETTE_SAMPLE = 6  # frames that the palette of a GIF is chosen from
COMMON_COLOURS = 96  # of the 256 of a GIF, chosen by area
COARSE = 3  # bits of a colour channel that do not count as another colour


class Frames:
    """The frames of a film, in RGB, rendered as they are needed."""

    def __init__(
        self,
        renderer: Renderer,
        moments: Sequence[Moment],
        progress: Callable[[int], Iterable[int]] = range,
        workers: int | None = None,
    ):
        self.renderer, self.moments, self.progress = renderer, moments, progress
        self.workers = workers or os.cpu_count() or 1

    def __iter__(self) -> Iterator[Image.Image]:
        return self.rendered(self.progress(len(self.moments)))

    def sample(self, count: int) -> list[Image.Image]:
        """`count` of them, evenly spread."""
        return list(self.rendered(np.linspace(0, len(self.moments), count, endpoint=False)))

    def rendered(self, numbers: Iterable[float]) -> Iterator[Image.Image]:
        """The frames of these numbers; as many as there are workers are in work."""
        with ThreadPoolExecutor(self.workers) as pool:
            ahead: deque = deque()
            for k in numbers:
                scene = self.renderer.draw(self.moments[int(k)])
                ahead.append(pool.submit(self.renderer.render, scene))
                if len(ahead) > self.workers:
                    yield ahead.popleft().result()
            yield from (frame.result() for frame in ahead)


def check_format(suffix: str, size: tuple[int, int], fps: float) -> float:
    """The nearest frame rate that a format has. Raises InvalidInput where it does not have films
    of that size, and Unavailable without its encoder."""
    if suffix == ".mp4":
        ffmpeg()
        for name, pixels in zip(("width", "height"), size, strict=True):
            if pixels % 2:
                raise InvalidInput(f"{name} = {pixels}: must be even for MP4")
    tick = ENCODERS[suffix].tick
    return 1000 / (tick * round(1000 / fps / tick)) if tick else fps


def write_with_pillow(file: Path, frames: Frames, fps: float) -> None:
    """A looping GIF, with one palette for all frames so that nothing flickers, or WebP."""
    pictures = iter(frames)
    options: dict[str, Any] = {"duration": round(1000 / fps), "loop": 0}
    if file.suffix.lower() == ".gif":
        palette = gif_palette(np.concatenate([*map(np.asarray, frames.sample(PALETTE_SAMPLE))]))
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
    coarse = (picture >> COARSE).astype(int) @ [1 << 16, 1 << 8, 1]
    codes, counts = np.unique(coarse, return_counts=True)
    distinct = (codes[:, None] >> [16, 8, 0] << COARSE).astype(np.uint8)[None]
    commonest = picture[coarse == codes[counts.argmax()]]
    entries: list[int] = np.median(commonest, axis=0).astype(int).tolist()
    for pixels, count in ((picture, COMMON_COLOURS), (distinct, 255 - COMMON_COLOURS)):
        reduced = Image.fromarray(pixels).quantize(count, dither=Image.Dither.NONE)
        entries += (reduced.getpalette() or [])[: 3 * count]
    palette = Image.new("P", (1, 1))
    palette.putpalette(entries)
    return palette


def write_mp4(file: Path, frames: Frames, fps: float) -> None:
    """H.264 in the pixel format and colour space that every player supports."""
    rendered = iter(frames)
    first = next(rendered)
    size = f"{first.width}x{first.height}"
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
                for frame in itertools.chain([first], rendered):
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


class Encoder(NamedTuple):
    """How a film is written; tick: the unit [ms] in which the format counts the duration of a
    frame, 0 for any."""

    write: Callable[[Path, Frames, float], None]
    tick: int


ENCODERS = {
    ".gif": Encoder(write_with_pillow, 10),
    ".webp": Encoder(write_with_pillow, 1),
    ".mp4": Encoder(write_mp4, 0),
}
