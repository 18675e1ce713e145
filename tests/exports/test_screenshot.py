"""Pictures in files: by a browser, by matplotlib, and what prevents either."""

import os
import stat
import time
from pathlib import Path
from typing import Any

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
UNSTABLE = Beam(gamma=5, delta=-1)


@pytest.fixture
def matplotlib_only(monkeypatch):
    """No browser."""
    monkeypatch.setenv("BEAMVIZ_BROWSER", "none")


def picture(path: Path, scene: Scene, width: int = 480, **options: Any) -> Path:
    """A picture in a file, and its path."""
    screenshot(path, scene, width=width, height=width * 9 // 16, **options)
    return path


def pixels(path: Path) -> np.ndarray:
    """The picture (h, w, 3 or 4) in a file, 0 .. 1."""
    return matplotlib.image.imread(path)


def differing(one: Path, other: Path) -> float:
    """Share of the pixels that differ visibly between two pictures."""
    return float((np.abs(pixels(one)[..., :3] - pixels(other)[..., :3]).max(axis=2) > 0.1).mean())


def coloured(path: Path) -> np.ndarray:
    """Which pixels have a colour of the beam: neither white nor grey."""
    return np.ptp(pixels(path)[..., :3], axis=2) > 0.25


@pytest.fixture(scope="module")
def rendered(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Mode 1, and mode 2 without background, by a browser."""
    folder = tmp_path_factory.mktemp("rendered")
    first = picture(folder / "a.png", Scene.of(PAPER, mode=1))
    return first, picture(folder / "b.png", Scene.of(PAPER, mode=2), transparent=True)


@browser
def test_a_browser_renders_the_picture(rendered):
    """Of the requested size, with a beam in it; modes differ; no other file is left. It has no
    alpha channel unless requested: clear in the corner and solid on the beam."""
    for path, channels in zip(rendered, (3, 4), strict=True):
        assert pixels(path).shape == (270, 480, channels)
        assert coloured(path).mean() > 0.02
    assert differing(*rendered) > 0.01
    assert sorted(path.name for path in rendered[0].parent.iterdir()) == ["a.png", "b.png"]
    alpha = pixels(rendered[1])[..., 3]
    assert alpha[:4, :4].max() < 0.5
    assert alpha.max() == 1


@browser
@pytest.mark.usefixtures("matplotlib_only")
def test_both_renderers_show_the_beam_in_the_same_place(rendered, tmp_path):
    """The coloured pixels of the browser's picture and of matplotlib's mostly coincide."""
    drawn = coloured(picture(tmp_path / "b.png", Scene.of(PAPER, mode=1)))
    one = coloured(rendered[0])
    assert (one & drawn).sum() > 0.8 * (one | drawn).sum()


@pytest.mark.usefixtures("matplotlib_only")
def test_matplotlib_draws_without_a_browser(tmp_path, capsys):
    """The same scene in the same pixels; only stderr has a note."""
    scene, phases = Scene.of(PAPER, mode=1), {"a": 0.25, "b": 0.75, "c": 0.25}
    first, later, again = (
        picture(tmp_path / f"{name}.png", scene, phase=phase) for name, phase in phases.items()
    )
    other = picture(tmp_path / "d.png", Scene.of(PAPER, mode=2))
    assert pixels(first).shape == (270, 480, 3)
    assert coloured(first).mean() > 0.02
    assert min(differing(first, other), differing(first, later)) > 0.01
    assert differing(first, again) == 0
    output = capsys.readouterr()
    assert output.out == ""
    assert "matplotlib" in output.err


@pytest.mark.usefixtures("matplotlib_only")
@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
@pytest.mark.parametrize("beam", [Beam(delta=-0.5), Beam(delta=3), Beam(mu=10), Beam(mu=10000)])
def test_every_kind_of_beam_can_be_drawn(beam, plane, tmp_path):
    """Inward, on a large hub, thick, thin."""
    path = picture(tmp_path / "a.png", Scene(beam, {"plane": plane}), 320)
    assert 0.01 < coloured(path).mean() < 0.5


def test_matplotlib_draws_an_opaque_beam():
    """Triangles leave no seams: but for its rim the beam is opaque."""
    solved = SolvedScene.of(Scene(Beam()))
    drawn = renderer.draw_with_matplotlib(solved, solved.moment(0.0), 640, 360).astype(int)
    beam = np.ptp(drawn[..., :3], axis=2) > 50
    assert (drawn[beam, 3] > 250).mean() > 0.9


@pytest.mark.usefixtures("matplotlib_only")
def test_an_unstable_beam_is_grey(tmp_path):
    """delta = -1, gamma = 5: drawn, without the colours of a vibration."""
    assert not coloured(picture(tmp_path / "a.png", Scene(UNSTABLE))).any()


@pytest.mark.parametrize("width", [160, 320, 1280])
def test_a_warning_fits_into_a_picture_of_any_size(width):
    """Its letters, the only black in it, are no wider than the picture."""
    solved = SolvedScene.of(Scene(UNSTABLE))
    drawn = renderer.draw_with_matplotlib(solved, solved.moment(0.0), width, width * 9 // 16)
    black = (drawn[..., :3].max(axis=2) < 90) & (drawn[..., 3] > 120)
    columns = np.flatnonzero(black.any(axis=0))
    assert 0.05 * width < columns[0] < columns[-1] < 0.95 * width


@pytest.mark.slow
@browser
def test_a_warning_fits_into_a_picture_by_a_browser(tmp_path):
    """It stands on a white ground, which covers a part of a dark picture and leaves its rim; in any
    font, as the height of its letters follows from their number."""
    white = pixels(picture(tmp_path / "a.png", Scene.of(UNSTABLE, dark=True)))[..., :3] > 0.8
    columns = np.flatnonzero(white.all(axis=2).any(axis=0))
    assert 0.02 < white.mean() < 0.2
    assert 0.05 * 480 < columns[0] < columns[-1] < 0.95 * 480


@pytest.mark.slow
@browser
def test_titles_of_all_modes_are_small_beside_the_beams(tmp_path):
    """Letters, the only black there is, take less than a hundredth of it, the beams more."""
    path = picture(tmp_path / "a.png", Scene.of(Beam(gamma=5), all_modes=True, ghosts=False))
    black = (pixels(path)[..., :3].max(axis=2) < 0.2).mean()
    assert 0 < black < 0.01 < coloured(path).mean()


@pytest.mark.parametrize(
    ("name", "width", "error", "message"),
    [
        ("missing/a.png", 480, Unavailable, r"cannot write .*missing/a\.png: No such file"),
        ("folder.png", 480, Unavailable, "it is a folder"),
        ("a.jpg", 480, InvalidInput, r"must end in \.png"),
        ("a.png", 5, InvalidInput, r"width = 5: must be a whole number in 64 \.\. 4096"),
    ],
)
def test_a_picture_that_cannot_be_written_is_not_solved(
    tmp_path, monkeypatch, name, width, error, message
):
    """A missing folder, a folder itself, a wrong suffix or size."""
    monkeypatch.setattr(exports, "SolvedScene", None)
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(error, match=message):
        picture(tmp_path / name, Scene(PAPER), width)


def test_a_failure_leaves_the_former_file(tmp_path):
    """And no other one."""
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


@pytest.mark.usefixtures("matplotlib_only")
def test_a_stretching_beam_stays_in_the_picture(tmp_path):
    """From above, a mass at the tip that swings along the beam is seen whole at its farthest."""
    above = {"direction": (0.0, 0.0, 1.0)}
    right = pixels(picture(tmp_path / "a.png", Scene.of(alpha=1, mode=3), 320, **above))[:, -3:]
    assert np.ptp(right, axis=2).max() < 0.1
    assert right.min() > 0.6
