"""A scene in motion as a film: a seamless loop of whole periods."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np

from beamviz.beam import check_float, check_int
from beamviz.errors import InvalidInput
from beamviz.exports.encoders import ENCODERS
from beamviz.exports.loop import Loop, looped
from beamviz.exports.renderer import opaque, studio
from beamviz.exports.screenshot import PIXELS
from beamviz.exports.solved_scene import Direction, Shot
from beamviz.files import check_suffix, replaced
from beamviz.scene import Scene

FRAME_RATES = (5.0, 50.0)  # [1/s]; a GIF cannot be faster
MAX_FRAMES = 1000

Progress = Callable[[int], Iterable[int]]


def animate(
    path: str | Path,
    scene: Scene,
    width: int = 800,
    height: int = 450,
    fps: float = 25.0,
    periods: int | None = None,
    direction: Direction | None = None,
    zoom: float = 1.0,
    progress: Progress = range,
) -> Loop:
    """Write a scene as a film that ends where it began: .gif, .webp or .mp4, by its ending.

    fps: frames in a second, or nearly so (a GIF counts in hundredths of a second); periods: of the
    first mode shown, where the shortest film that closes is not wanted; direction, zoom: where to
    look from, in place of the camera of the scene; progress: counts the frames up to a number as
    they are drawn. Raises InvalidInput, Unavailable, and what `solve` raises; the file is either
    complete or untouched.
    """
    path = Path(path)
    encoder = ENCODERS[check_suffix(path, tuple(ENCODERS))]
    size = check_int("width", width, *PIXELS), check_int("height", height, *PIXELS)
    fps = encoder.rate(check_float("fps", fps, *FRAME_RATES))
    encoder.check(*size)
    periods = None if periods is None else check_int("periods", periods, 1, MAX_FRAMES)
    with replaced(path) as file:
        shot = Shot.of(scene, direction, zoom)
        loop = looped(shot, periods)
        count = round(loop.seconds * fps)
        if count > MAX_FRAMES:
            raise InvalidInput(
                f"the film has {count} frames: must be at most {MAX_FRAMES}; ask for fewer"
                " periods, a lower fps or a higher pace"
            )
        with studio(shot, *size) as picture:

            def frames(numbers: Iterable[int]) -> Iterator[np.ndarray]:
                for k in numbers:
                    yield opaque(picture(loop.moment(k / count)), scene.view)

            sample = frames(np.linspace(0, count, encoder.sample, endpoint=False).astype(int))
            encoder.write(file, frames(progress(count)), fps, list(sample))
    return loop
