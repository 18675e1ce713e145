"""Pictures and films: pictures as stored ones look, on any machine; films decoded, not blank, and
ending where they began. `python tests/exports/test_pictures.py` makes the stored pictures anew:
look at each before it is committed."""

import contextlib
import math
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import numpy as np
import pytest
from fontTools.ttLib import TTFont
from helpers import slow
from hypothesis import given, settings
from hypothesis import strategies as st
from live.visitor import PAPER
from matplotlib import get_data_path
from PIL import Image, ImageCms, ImageSequence

from beamviz.beam import Beam
from beamviz.blade import Blade, Mass
from beamviz.drawing import colours
from beamviz.errors import InvalidInput
from beamviz.exports import Renderer, animate, screenshot
from beamviz.exports.solved_scene import Loop, SolvedScene
from beamviz.scene import Scene

REFERENCES = Path(__file__).with_name("references")
BLOCK = 5  # [pixels] over which a difference is averaged: edges of samples may move by rounding
SIZE = (480, 270)
BODIES = (Mass(0.3, 0.5, (0.001, 0.004, 0.004)), Mass(0.1, 1.0))
STEPPED = Beam(
    blade=Blade((0, 0.4, 0.4, 1), (1, 0.9, 0.5, 0.3), (1, 0.8, 0.2, 0.06), (1, 0.9, 0.5, 0.3)),
    masses=BODIES,
    root=2.0,
    gamma=3,
    delta=0.2,
)
FLAT = Beam(flap=0.25, pitch=30, gamma=5)
PROFILES = [ImageCms.createProfile(name) for name in ("sRGB", "LAB")]
TO_LAB = ImageCms.buildTransform(*PROFILES, "RGB", "LAB")
SCENES = {
    "mass": Scene.of(PAPER, mode=2),
    "bent": Scene.of(Beam(gamma=4, delta=-1), state="bent", mode=1, dark=True),
    "unstable": Scene.of(Beam(alpha=0.3, gamma=5, delta=-1), rotating_frame=False),
    "all modes": Scene.of(Beam(gamma=5), all_modes=True, colouring="axial strain"),
    "flapwise": Scene.of(Beam(alpha=1, gamma=4, delta=0.3), plane="flapwise", mode=1, thicken=True),
    "outside": Scene.of(Beam(gamma=2, delta=0.5), mode=1, rotating_frame=False),
    "blade": Scene.of(STEPPED, mode=2),
    "hinge": Scene.of(Beam(blade=Blade.tapered(0.5, 0.3), root=0.0, gamma=3, delta=0.15), mode=1),
    "both planes": Scene.of(FLAT, plane="both", shares=[1.0, 1.0], coriolis=True, tip_path=True),
    "still": Scene.of(Beam(delta=-0.3), shares=[0.0], ghosts=False, rotating_frame=False),
}
PHASE = 0.33  # the hub has turned, and the displacement is not the largest
ALIKE = 3.0  # difference of pictures that look the same
MASS = SCENES["mass"]


def rendered(scene: Scene, size: tuple[int, int] = SIZE, **options: bool) -> np.ndarray:
    """A picture (h, w, 3 or 4), bytes."""
    solved = SolvedScene(scene)
    return np.asarray(Renderer(solved, *size).picture(solved.moment(PHASE), **options))


def stored(name: str) -> np.ndarray:
    """The stored picture (h, w, 3) of a scene, bytes."""
    return np.asarray(Image.open(REFERENCES / f"{name}.png"))


def difference(one: np.ndarray, other: np.ndarray) -> float:
    """The largest difference of two pictures (h, w, 3) in CIELAB, averaged over blocks: 2 can just
    be seen."""
    height, width = one.shape[0] // BLOCK * BLOCK, one.shape[1] // BLOCK * BLOCK
    shape = height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3
    means = [lab(p[:height, :width]).reshape(shape).mean(axis=(1, 3)) for p in (one, other)]
    return float(np.linalg.norm(means[0] - means[1], axis=-1).max())


def lab(picture: np.ndarray) -> np.ndarray:
    """sRGB bytes (h, w, 3) in CIELAB."""
    found = np.asarray(ImageCms.applyTransform(Image.fromarray(picture), TO_LAB))
    return np.concatenate([found[..., :1] / 2.55, found[..., 1:].view(np.int8)], axis=-1)


def coloured(picture: np.ndarray) -> np.ndarray:
    """Which pixels have a colour of the beam: neither white nor grey."""
    return np.ptp(picture[..., :3].astype(int), axis=2) > 64


@pytest.mark.parametrize("name", SCENES)
def test_a_picture_looks_as_it_did(name):
    """Beam, mass, nodes, hub, arrow, shadow, ground, labels and light, in light and dark: inward on
    a ring, grey below a warning, out of the plane of rotation, on a hub that has turned, with the
    path of the tip, and at rest without an arrow."""
    assert difference(rendered(SCENES[name]), stored(name)) < ALIKE


@pytest.mark.parametrize(
    "changes",
    [
        {"mode": 1},
        {"alpha": 1.1},
        {"beta": 0.49},
        {"nodes": False},
        {"forces": True},
        {"dark": True},
    ]
    + slow({"mu": 60}, {"colouring": "axial strain"}, {"ghosts": False}, {"tip_path": True})
    + slow({"thicken": True, "mu": 100}),
    ids=str,
)
def test_another_beam_mass_colour_or_label_looks_different(changes):
    """The measure tells a mass larger by a tenth, a node that is not labelled."""
    assert difference(rendered(MASS.changed(**changes)), stored("mass")) > 2 * ALIKE


@pytest.mark.parametrize(
    ("beam", "plane"),
    [
        *((Beam(delta=-0.5), "chordwise"), (Beam(delta=3), "flapwise")),
        *((Beam(mu=10), "flapwise"), (Beam(mu=10000), "chordwise")),
    ],
)
def test_every_kind_of_beam_can_be_drawn(beam, plane):
    """Inward, on a large hub, thick, thin."""
    assert 0.01 < coloured(rendered(Scene(beam, {"plane": plane}), (320, 180))).mean() < 0.5


def test_phase_and_direction_change_the_picture(tmp_path):
    """Half a period later the beam is on the other side; a repetition looks the same. A camera can
    be below the ground, inside the scene, or far away."""
    pictures = []
    for options in ({}, {}, {"phase": 0.75}, {"direction": (0.0, 0.0, 1.0)}, {"zoom": 2.0}):
        screenshot(tmp_path / "a.png", MASS, *SIZE, **options)
        pictures.append(np.asarray(Image.open(tmp_path / "a.png")))
    first, again, *others = pictures
    assert difference(first, again) < 0.1 * ALIKE
    assert min(difference(first, other) for other in others) > 2 * ALIKE
    assert list(tmp_path.iterdir()) == [tmp_path / "a.png"]
    for camera in ((0.0, 0.0, -4.0), (0.1, -0.3, 0.1), (0.0, -100.0, 0.0)):
        assert np.ptp(rendered(MASS.changed(position=camera), (320, 180))) > 60


def test_a_transparent_picture_is_the_same_over_the_background():
    """Clear in the corner, solid on the beam."""
    clear = rendered(MASS, transparent=True)
    assert clear.shape == (*SIZE[::-1], 4)
    assert clear[:4, -4:, 3].max() < 128
    assert clear[..., 3].max() == 255
    alpha = clear[..., 3:] / 255
    over = clear[..., :3] * alpha + np.array(colours.BACKGROUND[0]) * (1 - alpha)
    assert difference(np.rint(over).astype(np.uint8), stored("mass")) < ALIKE


@pytest.mark.parametrize("width", [160, 320, 1280])
def test_a_warning_fits_into_a_picture_of_any_size(width):
    """Its light letters cover a part of a dark picture and leave its rim."""
    scene = SCENES["unstable"].changed(dark=True)
    white = (rendered(scene, (width, width * 9 // 16)) > 210).all(axis=2)
    columns = np.flatnonzero(white.any(axis=0))
    assert 0.001 < white.mean() < 0.2
    assert 0.02 * width < columns[0] < columns[-1] < 0.98 * width
    assert coloured(rendered(scene)).mean() < 0.001


def test_a_stretching_beam_stays_in_the_picture():
    """From above, a mass at the tip that swings along the beam is seen whole at its farthest."""
    solved = SolvedScene(Scene.of(alpha=1, mode=3), direction=(0.0, 0.0, 1.0))
    renderer = Renderer(solved, 320, 180)
    right = np.asarray(renderer.picture(solved.moment()))[:, -3:]
    assert np.ptp(right.astype(int), axis=2).max() < 25
    assert right.min() > 150


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="a search path of one folder")
def test_a_bare_machine_with_other_fonts_is_enough(tmp_path):
    """Without a browser or a display, in a process of its own, and where the fonts of the machine
    have the names of those used but other letters: the same picture, no word."""
    fonts = tmp_path / ".local/share/fonts"  # where Pillow, matplotlib and fontconfig look
    fonts.mkdir(parents=True)
    other = TTFont(get_data_path() + "/fonts/ttf/cmr10.ttf")
    for name_id in (1, 4, 6, 16):
        other["name"].setName("DejaVu Sans", name_id, 3, 1, 0x409)
    other.save(fonts / "DejaVuSans.ttf")
    (tmp_path / "fonts.conf").write_text(f"<fontconfig><dir>{fonts}</dir></fontconfig>")
    bare = {"PATH": str(tmp_path), "HOME": str(tmp_path), "PYTHONPATH": os.pathsep.join(sys.path)}
    bare |= {"FONTCONFIG_FILE": str(tmp_path / "fonts.conf"), "MPLCONFIGDIR": str(tmp_path)}
    numbers = {"alpha": 1, "beta": 0.5, "gamma": 10, "width": 480, "height": 270, "phase": PHASE}
    command = [sys.executable, "-m", "beamviz", "screenshot", str(tmp_path / "a.png")]
    command += [f"--{name}={value}" for name, value in numbers.items()]
    done = subprocess.run(command, env=bare, cwd=fonts, capture_output=True, check=True)
    assert (done.stdout, done.stderr) == (b"", b"")
    assert difference(np.asarray(Image.open(tmp_path / "a.png")), rendered(MASS)) < 0.1 * ALIKE


# Films


SMALL = {"width": 192, "height": 108, "fps": 6.25}


def decoded(path: Path) -> np.ndarray:
    """The frames (n, height, width, 3) of a film."""
    if path.suffix == ".mp4":
        command = f"-v error -i {path} -f rawvideo -pix_fmt rgb24 -".split()
        done = subprocess.check_output([imageio_ffmpeg.get_ffmpeg_exe(), *command])
        return np.frombuffer(done, np.uint8).reshape(-1, 108, 192, 3)
    with Image.open(path) as picture:
        return np.array([np.asarray(f.convert("RGB")) for f in ImageSequence.Iterator(picture)])


@pytest.mark.parametrize("kind", ["webp", *slow("gif", "mp4")])
def test_a_film_shows_a_beam_that_swings_and_closes(tmp_path, kind):
    """As many frames as said, coloured; the step back to the start is one like the others."""
    path = tmp_path / f"film.{kind}"
    loop = animate(path, Scene.of(mode=2), **SMALL)
    frames = decoded(path)
    assert frames.shape == (round(SMALL["fps"] * loop.seconds), 108, 192, 3)
    assert (np.ptp(frames, axis=3) > 60).mean() > 0.01
    moved, nexts = frames.astype(float), np.roll(frames, -1, axis=0)
    steps, ways = (np.abs(moved - one).mean(axis=(1, 2, 3)) for one in (nexts, frames[0]))
    assert steps.min() > 0
    assert steps[-1] <= 1.5 * steps[:-1].max()
    assert ways.max() > 2 * steps.max() / 1.5
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("dark", [False, *slow(True)])
def test_the_shadow_of_a_gif_has_no_steps(tmp_path, dark):
    """Where shades change little by little, each pixel has its shade to two levels of 255 in the
    mean, although there are 256 colours in all."""
    scene = Scene.of(mode=2, gamma=5, alpha=1, beta=0.5, rotating_frame=False, dark=dark)
    options: dict[str, Any] = {"width": 320, "height": 180, "fps": 5.0}
    loop = animate(tmp_path / "a.gif", scene, **options)
    shown = decoded(tmp_path / "a.gif").astype(int)
    solved = SolvedScene(scene)
    renderer, errors = Renderer(solved, 320, 180), []
    for k in range(0, len(shown), 4):
        true = np.asarray(renderer.picture(loop.moment(k / len(shown))), int)
        step = np.abs(np.diff(true, axis=1)).max(axis=2)
        soft = (step > 0) & (step <= 6)
        assert soft.sum() > 300
        errors.append(np.sqrt(((shown[k] - true)[:, 1:][soft] ** 2).mean()))
    assert np.mean(errors) < 2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "fps", "duration"),
    [("gif", 8, 120), ("gif", 40, 20), ("webp", 30, 33)],
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
@settings(max_examples=6)
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


@pytest.mark.parametrize("rotating_frame", [False, True])
def test_the_hub_of_a_film_turns_at_its_speed(rotating_frame):
    """Beside the mode shown, but for the change that closes the film; or the ground does."""
    solved = SolvedScene(Scene.of(PAPER, mode=2, rotating_frame=rotating_frame))
    loop = Loop(solved)
    ratio = PAPER.gamma / solved.solution.frequencies[1] * (1 + loop.changes["rotation"])
    assert loop.angle / loop.phases[1] == pytest.approx(ratio)


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="a terminal of its own")
def test_progress_is_shown_where_somebody_watches(tmp_path):
    """On a terminal a bar counts the frames up to all of them, with the time left."""
    screen, terminal = os.openpty()
    command = [sys.executable, "-m", "beamviz", "animate", str(tmp_path / "film.gif")]
    small = ["--width", "64", "--height", "64", "--periods", "2"]  # seconds: for the time left
    process = subprocess.Popen([*command, *small], stderr=terminal)
    os.close(terminal)
    seen = b""
    with process, contextlib.suppress(OSError):  # a terminal without a program reads as an error
        while part := os.read(screen, 4096):
            seen += part
    os.close(screen)
    assert process.returncode == 0
    assert re.search(rb"frames.*  \d\d:\d\d:\d\d.*100%", seen, re.DOTALL)


if __name__ == "__main__":
    for name, scene in SCENES.items():
        Image.fromarray(rendered(scene)).save(REFERENCES / f"{name}.png", optimize=True)
