"""Films: decoded, not blank, ending where they began; and what prevents one."""

import contextlib
import math
import os
import re
import subprocess
import sys
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from helpers import slow
from hypothesis import given, settings
from hypothesis import strategies as st
from live.visitor import PAPER
from PIL import Image, ImageSequence

from beamviz.errors import InvalidInput
from beamviz.exports import animate
from beamviz.exports.renderer import Renderer
from beamviz.exports.solved_scene import Loop, SolvedScene
from beamviz.scene import Scene

SMALL = {"width": 192, "height": 108, "fps": 6.25}


def decoded(path: Path) -> np.ndarray:
    """The frames (n, height, width, 3) of a film."""
    if path.suffix == ".mp4":
        raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
        command = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-i", str(path), *raw]
        done = subprocess.run(command, capture_output=True, check=True)
        return np.frombuffer(done.stdout, np.uint8).reshape(-1, SMALL["height"], SMALL["width"], 3)
    with Image.open(path) as picture:
        return np.array([np.asarray(f.convert("RGB")) for f in ImageSequence.Iterator(picture)])


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """Mean difference of two frames."""
    return float(np.abs(one.astype(float) - other.astype(float)).mean())


@pytest.mark.parametrize("kind", ["webp", *slow("gif", "mp4")])
def test_a_film_shows_a_beam_that_swings_and_closes(tmp_path, kind):
    """As many frames as said, coloured; the step back to the start is one like the others."""
    path = tmp_path / f"film.{kind}"
    loop = animate(path, Scene.of(mode=2), **SMALL)
    frames = decoded(path)
    assert frames.shape == (round(SMALL["fps"] * loop.seconds), 108, 192, 3)
    assert (np.ptp(frames, axis=3) > 60).mean() > 0.01
    steps = [apart(a, b) for a, b in zip(frames, np.roll(frames, -1, axis=0), strict=True)]
    assert min(steps) > 0
    assert steps[-1] <= 1.5 * max(steps[:-1])
    assert max(apart(frames[0], frame) for frame in frames) > 2 * max(steps) / 1.5
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "fps", "duration"),
    [("gif", 8, 120), ("gif", 25, 40), ("gif", 40, 20), ("webp", 30, 33)],
)
def test_every_frame_is_shown_equally_long(tmp_path, kind, fps, duration):
    """Where a format cannot have this frame rate it has the nearest one [ms] and the frames for
    that, so that the pace stays. The film is repeated for ever."""
    path = tmp_path / f"film.{kind}"
    loop = animate(path, Scene.of(mode=2, pace=4.0), width=64, height=64, fps=fps)
    with Image.open(path) as opened:
        assert opened.info["loop"] == 0
        shown = [frame.info["duration"] for frame in ImageSequence.all_frames(opened)]
    # Equal frames that follow each other are stored as one, shown for longer.
    assert sum(shown) == duration * round(1000 * loop.seconds / duration)
    assert set(shown) <= {duration, 2 * duration}


@pytest.mark.slow
@given(
    st.sampled_from([0.0, 1.0, 7.3, 30.0]),
    st.booleans(),
    st.sampled_from([(1.0,), (0.0, 1.0), (0.5, 0.5), (0.2, 0.0, 1.0, 0.3)]),
    st.floats(0, 3),
)
@settings(max_examples=12, deadline=None)
def test_after_the_last_frame_comes_the_first(gamma, rotating_frame, shares, alpha):
    """Every motion ends on a whole cycle, and the picture at the end is the one at the start."""
    beam = PAPER.replace(alpha=alpha, gamma=gamma)
    solved = SolvedScene(Scene.of(beam, rotating_frame=rotating_frame, shares=shares))
    loop = Loop(solved)
    turns = loop.phases[solved.shown] / (2 * math.pi)
    assert turns == pytest.approx(np.rint(turns), abs=1e-9)
    assert turns[0] == loop.periods
    renderer = Renderer(solved, 128, 72)
    first, last = (renderer.picture(loop.moment(share)) for share in (0.0, 1.0))
    assert np.abs(np.asarray(first, int) - np.asarray(last, int)).max() <= 3
    for name, change in loop.changes.items():
        assert abs(change) <= 1
        assert (name in loop.note) == (abs(change) > 5e-4)


@pytest.mark.parametrize(
    ("scene", "options", "message"),
    [
        ({"shares": [0.0]}, {}, "nothing moves"),
        ({"pace": 0.0}, {}, "pace = 0"),
        ({"delta": -1, "gamma": 5, "mode": 1}, {}, "mode = 1: B1 does not vibrate but"),
        ({}, {"periods": 900}, "must be at most 1000"),
    ],
)
def test_impossible_films_are_reported(tmp_path, scene, options, message):
    """Nothing moves, no pace, a mode that grows, too many frames."""
    with pytest.raises(InvalidInput, match=message):
        animate(tmp_path / "a.gif", Scene.of(**scene), **(SMALL | options))
    assert list(tmp_path.iterdir()) == []


def test_one_mode_alone_runs_at_its_own_pace():
    """Nothing has to be changed, one period is enough; more on request. A model, which has no
    ground, rotates only outside the rotating frame."""
    solved = SolvedScene(Scene.of(mode=1))
    alone = Loop(solved)
    assert (alone.note, alone.periods) == ("", 1)
    assert Loop(solved, 3).seconds == pytest.approx(3 * alone.seconds)
    for rotating_frame in (True, False):
        scene = Scene.of(PAPER, mode=2, rotating_frame=rotating_frame)
        angle = Loop(SolvedScene(scene), film=False).angle
        assert angle % (2 * math.pi) == pytest.approx(0)
        assert (angle == 0) is rotating_frame


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="a terminal of its own")
def test_progress_is_shown_where_somebody_watches(tmp_path):
    """On a terminal a bar counts the frames up to all of them, with the time left."""
    screen, terminal = os.openpty()
    command = [sys.executable, "-m", "beamviz", "animate", str(tmp_path / "film.gif")]
    small = ["--width", "64", "--height", "64", "--periods", "3"]  # seconds: for the time left
    process = subprocess.Popen([*command, *small], stderr=terminal)
    os.close(terminal)
    seen = b""
    with process, contextlib.suppress(OSError):  # a terminal without a program reads as an error
        while part := os.read(screen, 4096):
            seen += part
    os.close(screen)
    assert process.returncode == 0
    assert re.search(rb"frames.*  \d\d:\d\d:\d\d.*100%", seen, re.DOTALL)
