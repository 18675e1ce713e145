"""Films: frames rendered on all processors, and written as GIF, WebP or MP4."""

import itertools
import os
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from beamviz.errors import InvalidInput, Unavailable
from beamviz.exports.renderer import Renderer
from beamviz.exports.solved_scene import Moment

# By suffix, the unit [ms] in which a format counts the duration of a frame, 0 for any.
FORMATS = {".gif": 10, ".webp": 1, ".mp4": 0}
BT709 = 1  # in the tables of H.264


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
        if find_spec("av") is None:
            raise Unavailable("MP4 needs PyAV: pip install av (.webp and .gif need nothing)")
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
