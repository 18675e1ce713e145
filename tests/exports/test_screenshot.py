"""Pictures in files: by a browser, by matplotlib, and what stands in the way of either."""

import os
import stat
import time
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from live.visitor import PAPER

from beamviz import exports
from beamviz.beam import Beam
from beamviz.errors import InvalidInput, NoEquilibrium, Unavailable
from beamviz.exports import renderer, screenshot
from beamviz.exports.solved_scene import SolvedScene
from beamviz.scene import Scene

browser = pytest.mark.browser


def pixels(path: Path) -> np.ndarray:
    """The picture (h, w, 3 or 4) in a file, 0 .. 1."""
    return matplotlib.image.imread(path)


def differing(one: Path, other: Path) -> float:
    """Share of the pixels that differ visibly between two pictures."""
    return float((np.abs(pixels(one)[..., :3] - pixels(other)[..., :3]).max(axis=2) > 0.1).mean())


def blue_to_yellow(path: Path) -> float:
    """Share of the picture in colours of the beam: neither white nor grey."""
    colour = pixels(path)[..., :3]
    return float((np.ptp(colour, axis=2) > 0.25).mean())


@pytest.fixture(scope="module")
def photographs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Mode 1, and mode 2 without background, as a browser takes them."""
    folder = tmp_path_factory.mktemp("photographs")
    first, second = folder / "a.png", folder / "b.png"
    screenshot(first, Scene.of(PAPER, mode=1), width=480, height=270)
    screenshot(second, Scene.of(PAPER, mode=2), width=480, height=270, transparent=True)
    return first, second


@browser
def test_a_browser_takes_the_picture(photographs):
    """Asked size, a beam in it, modes differ, nothing else is left in the folder."""
    first, second = photographs
    for path in photographs:
        assert pixels(path).shape[:2] == (270, 480)
        assert blue_to_yellow(path) > 0.02
    assert differing(first, second) > 0.01
    assert sorted(path.name for path in first.parent.iterdir()) == ["a.png", "b.png"]


@browser
def test_a_picture_is_opaque_unless_asked_otherwise(photographs):
    """No alpha channel at all; else clear in the corner and solid on the beam."""
    first, second = map(pixels, photographs)
    assert first.shape[2] == 3
    assert second.shape[2] == 4
    assert second[:4, :4, 3].max() < 0.5
    assert second[..., 3].max() == 1


@browser
def test_both_ways_show_the_beam_in_the_same_place(photographs, tmp_path, monkeypatch):
    """The coloured pixels of the browser's picture and of matplotlib's mostly coincide."""
    monkeypatch.setenv("BEAMVIZ_BROWSER", "none")
    drawing = tmp_path / "b.png"
    screenshot(drawing, Scene.of(PAPER, mode=1), width=480, height=270)
    one, other = (np.ptp(pixels(p)[..., :3], axis=2) > 0.25 for p in (photographs[0], drawing))
    assert (one & other).sum() > 0.8 * (one | other).sum()


def test_matplotlib_draws_where_there_is_no_browser(tmp_path, monkeypatch, capsys):
    """The same scene, said on stderr and nowhere else."""
    monkeypatch.setenv("BEAMVIZ_BROWSER", "none")
    first, second, later, again = (tmp_path / f"{name}.png" for name in "abcd")
    screenshot(first, Scene.of(PAPER, mode=1), width=480, height=270)
    screenshot(second, Scene.of(PAPER, mode=2), width=480, height=270)
    screenshot(later, Scene.of(PAPER, mode=1), width=480, height=270, phase=0.75)
    screenshot(again, Scene.of(PAPER, mode=1), width=480, height=270)
    assert pixels(first).shape == (270, 480, 3)
    assert blue_to_yellow(first) > 0.02
    assert differing(first, second) > 0.01
    assert differing(first, later) > 0.01
    assert differing(first, again) == 0
    told = capsys.readouterr()
    assert told.out == ""
    assert "matplotlib" in told.err


@pytest.mark.parametrize("beam", [Beam(delta=-0.5), Beam(delta=3), Beam(mu=10), Beam(mu=10000)])
def test_every_kind_of_beam_can_be_drawn(beam, tmp_path, monkeypatch):
    """Inward, on a large hub, thick, thin."""
    monkeypatch.setenv("BEAMVIZ_BROWSER", "none")
    for plane in ("chordwise", "flapwise"):
        screenshot(tmp_path / "a.png", Scene(beam, {"plane": plane}), width=320, height=180)
        assert 0.01 < blue_to_yellow(tmp_path / "a.png") < 0.5


def test_matplotlib_draws_a_beam_one_cannot_see_through():
    """Triangles leave no seams: but for its rim the beam is opaque."""
    solved = SolvedScene.of(Scene(Beam()))
    drawn = renderer.draw_with_matplotlib(solved, solved.moment(0.0), 640, 360).astype(int)
    beam = np.ptp(drawn[..., :3], axis=2) > 50
    assert (drawn[beam, 3] > 250).mean() > 0.9


def test_an_unstable_beam_is_grey(tmp_path, monkeypatch):
    """delta = -1, gamma = 5: drawn, without the colours of a vibration."""
    monkeypatch.setenv("BEAMVIZ_BROWSER", "none")
    screenshot(tmp_path / "a.png", Scene(Beam(gamma=5, delta=-1)), width=480, height=270)
    assert blue_to_yellow(tmp_path / "a.png") == 0


@pytest.mark.parametrize("width", [160, 320, 1280])
def test_words_fit_into_a_picture_of_any_size(width):
    """Their letters, the only black in it, are no wider than the picture."""
    solved = SolvedScene.of(Scene(Beam(gamma=5, delta=-1)))
    drawn = renderer.draw_with_matplotlib(solved, solved.moment(0.0), width, width * 9 // 16)
    black = (drawn[..., :3].max(axis=2) < 90) & (drawn[..., 3] > 120)
    columns = np.flatnonzero(black.any(axis=0))
    assert 0.05 * width < columns[0] < columns[-1] < 0.95 * width


@pytest.mark.slow
@browser
def test_words_fit_into_a_picture_by_a_browser(tmp_path):
    """They stand on a white ground, which covers a part of a dark picture and leaves its rim."""
    scene = Scene.of(Beam(gamma=5, delta=-1), dark=True)
    screenshot(tmp_path / "a.png", scene, width=480, height=270)
    white = pixels(tmp_path / "a.png")[..., :3].min(axis=2) > 0.8
    columns = np.flatnonzero(white.any(axis=0))
    assert 0.02 < white.mean() < 0.2
    assert 0.05 * 480 < columns[0] < columns[-1] < 0.95 * 480


@pytest.mark.slow
@browser
def test_titles_of_all_modes_are_small_beside_the_beams(tmp_path):
    """Letters, the only black there is, take less than a hundredth of it, the beams more."""
    scene = Scene.of(Beam(gamma=5), all_modes=True, ghosts=False)
    screenshot(tmp_path / "a.png", scene, width=480, height=270)
    black = (pixels(tmp_path / "a.png")[..., :3].max(axis=2) < 0.2).mean()
    assert 0 < black < 0.01 < blue_to_yellow(tmp_path / "a.png")


def test_a_path_that_cannot_be_written_is_said_before_any_work(tmp_path, monkeypatch):
    """A missing folder, a folder itself, a wrong ending: no solve is tried."""
    monkeypatch.setattr(exports, "SolvedScene", None)
    with pytest.raises(Unavailable, match=r"cannot write .*missing/a\.png: No such file"):
        screenshot(tmp_path / "missing" / "a.png", Scene(PAPER))
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(Unavailable, match="it is a folder"):
        screenshot(tmp_path / "folder.png", Scene(PAPER))
    with pytest.raises(InvalidInput, match=r"must end in \.png"):
        screenshot(tmp_path / "a.jpg", Scene(PAPER))
    with pytest.raises(InvalidInput, match=r"width = 5: must be a whole number in 64 \.\. 4096"):
        screenshot(tmp_path / "a.png", Scene(PAPER), width=5)


def test_no_half_file_is_left_by_a_failure(tmp_path):
    """What was there before is untouched, and nothing is added."""
    path = tmp_path / "a.png"
    path.write_bytes(b"before")
    with pytest.raises(NoEquilibrium):
        screenshot(path, Scene(Beam(mu=10, gamma=20), {"strain": "biot"}))
    assert path.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(os.name != "posix", reason="the stand-in browser is a shell script")
def test_a_browser_that_hangs_is_given_up(tmp_path, monkeypatch):
    """Past the deadline: Unavailable with the remedy, the browser ended, no file."""
    stand_in = tmp_path / "browser"
    stand_in.write_text(f"#!/bin/sh\necho $$ > {tmp_path}/pid\nexec sleep 1000\n")
    stand_in.chmod(stand_in.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("BEAMVIZ_BROWSER", str(stand_in))
    monkeypatch.setattr(renderer, "TIMEOUT", 1.0)
    start = time.monotonic()
    with pytest.raises(Unavailable, match="BEAMVIZ_BROWSER"):
        screenshot(tmp_path / "a.png", Scene(PAPER))
    assert time.monotonic() - start < 15
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)
    assert not (tmp_path / "a.png").exists()


def test_a_stretching_beam_stays_in_the_picture(tmp_path, monkeypatch):
    """From above, a mass at the tip that swings along the beam is seen whole at its farthest."""
    monkeypatch.setenv("BEAMVIZ_BROWSER", "none")
    scene = Scene.of(alpha=1, mode=3)
    path = tmp_path / "a.png"
    screenshot(path, scene, width=320, height=180, direction=(0.0, 0.0, 1.0))
    right = pixels(path)[:, -3:]
    assert np.ptp(right, axis=2).max() < 0.1
    assert right.min() > 0.6
