"""The path of the tip: every point of it is one at which the tip has been or will be."""

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers import sampled

from beamviz.beam import Beam
from beamviz.drawing import BeamView
from beamviz.drawing.beam_mesh import DrawnBeam
from beamviz.drawing.motion import MotionShapes, drawn
from beamviz.drawing.scene_graph import SceneGraph
from beamviz.dynamics import motion
from beamviz.scene import ViewOptions

PITCHED = Beam(flap=0.25, pitch=30, gamma=5, delta=0.2)
VIEW = ViewOptions(tip_path=True)
PERIODS = 4  # of several modes


def shown(beam: Beam, shares: tuple[float, ...], view: ViewOptions = VIEW, **options) -> BeamView:
    """A beam in some modes."""
    scene = BeamView(SceneGraph())
    scene.show(DrawnBeam(sampled(beam, **options), replace(view, shares=shares)))
    return scene


def path(scene: BeamView) -> np.ndarray:
    """The points (n, 3) of the line drawn, which is in one piece."""
    ends = scene.tip_path.line.points
    assert (ends[1:, 0] == ends[:-1, 1]).all()
    return np.concatenate([ends[:1, 0], ends[:, 1]])


@pytest.mark.parametrize(
    ("beam", "plane", "shares"),
    [
        (PITCHED, "both", (1.0, 0.5)),
        (PITCHED, "both", (1.0, 0.0, 0.0, 0.0, 1.0)),
        (Beam(alpha=1, beta=0.5, gamma=5, mu=20), "chordwise", (1.0, 0.0, 1.0)),
    ],
)
@pytest.mark.parametrize("coriolis", [False, True])
def test_several_modes_have_been_at_each_point_of_their_path(beam, plane, shares, coriolis):
    """At its end now, and at the other points before, up to four periods of the slowest mode."""
    scene = shown(beam, shares, plane=plane, coriolis=coriolis)
    frequencies, now = scene.drawn.shapes.frequencies, np.linspace(0.4, 2.0, 5)
    scene.move(now, 0.0)
    points = path(scene)
    assert points[-1] == pytest.approx(scene.line[-1], abs=1e-12)
    rates = frequencies[np.flatnonzero(shares)]
    span = 2 * math.pi * min(PERIODS / rates.min(), 24 / rates.max())
    for k in range(0, len(points), 17):
        before = span * (1 - k / (len(points) - 1))
        scene.move(now - frequencies * before, 0.0)
        assert scene.line[-1] == pytest.approx(points[k], abs=1e-9)


def test_one_mode_has_a_line_or_with_coriolis_forces_an_ellipse_that_stays():
    """Closed, the same at each phase, through the tip; in one plane without Coriolis forces it is
    straight and of the amplitude drawn."""
    for coriolis, round_by in ((False, 0.0), (True, 0.01)):
        scene = shown(Beam(alpha=1, gamma=4.65), (0.0, 0.0, 0.0, 1.0), coriolis=coriolis)
        scene.move(np.full(5, 0.7), 0.0)
        points = path(scene)
        assert points[0] == pytest.approx(points[-1], abs=1e-9)
        widths = np.linalg.svd(points - points.mean(axis=0))[1] / math.sqrt(len(points) / 2)
        amplitude = np.linalg.norm(scene.drawn.shapes.modes[3, -1]) * scene.drawn.amplitudes[3]
        assert widths[0] == pytest.approx(amplitude, rel=0.05)
        assert widths[1] >= round_by * widths[0]
        assert coriolis or widths[1] < 1e-9
        for phase in (1.5, 4.0):
            scene.move(np.full(5, phase), 0.0)
            assert (path(scene) == points).all()
            away = np.linalg.norm(points - scene.line[-1], axis=1).min()
            assert away < 0.11 * amplitude  # half a piece


def test_a_motion_in_time_has_the_path_of_all_of_it():
    """As the solution has its tip."""
    moved = motion(Beam(gamma=3), 1.0, release=1.0, points=101)
    shapes, scene = MotionShapes(moved), BeamView(SceneGraph())
    scene.show(drawn(shapes.sampled, shapes.amplitudes, moved.beam, VIEW, 1000.0))
    assert path(scene)[:, :2] == pytest.approx(moved.tip, abs=1e-3)
    scene.move(shapes.phases(0.5), 0.0)
    assert path(scene)[50] == pytest.approx(scene.line[-1], abs=1e-9)


def test_there_is_none_where_nothing_is_to_be_seen():
    """Off as usual, of a beam that stands still, and of one that is unstable."""
    for scene in (
        shown(PITCHED, (1.0,), ViewOptions(), plane="both"),
        shown(PITCHED, (), plane="both"),
        shown(Beam(gamma=5, delta=-1), (1.0,)),
    ):
        scene.move(np.full(5, 0.3), 0.0)
        assert not scene.tip_path.line.visible
