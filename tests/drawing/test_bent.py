"""A bent beam in the picture: its axis, its modes in the axes of the hub, and the camera."""

import numpy as np
import pytest

from beamviz import Beam, solve
from beamviz.drawing import camera
from beamviz.drawing.modes import SampledModes

BEAM = Beam(delta=-1, gamma=4)


@pytest.fixture(scope="module")
def shapes() -> SampledModes:
    """The bent beam, sampled."""
    return SampledModes.sampled(solve(BEAM, state="bent"))


def test_the_axis_is_that_of_the_bent_state(shapes):
    """It ends at the tip; a straight beam lies on the x axis."""
    assert shapes.centreline[-1] == pytest.approx([-0.018520, 0.858465], abs=1e-5)
    assert not SampledModes.sampled(solve(BEAM)).centreline[:, 1].any()


def test_bending_is_normal_to_the_bent_axis(shapes):
    """A mode of a slender beam moves each point across the axis there, not along it."""
    slender = SampledModes.sampled(solve(BEAM.replace(mu=1e4), state="bent"))
    step = np.diff(slender.centreline, axis=0)
    strain = (np.diff(slender.modes[1], axis=0) * step).sum(axis=1) / (step**2).sum(axis=1)
    assert abs(strain).max() < 1e-3  # the length of the axis does not change
    assert abs(slender.modes[1]).max() == pytest.approx(1, rel=0.3)


@pytest.mark.parametrize("aspect", [0.6, 1.0, 1.8])
def test_all_of_it_is_in_the_picture(shapes, aspect):
    """Every point of the axis is inside the camera's field of view."""
    view = camera.fitted(shapes, True, aspect)
    position = np.array(view.position)
    frame = camera.axes(position - view.look_at)
    points = np.pad(shapes.centreline, ((0, 0), (0, 1))) + [BEAM.delta, 0, 0]
    seen = (points - camera.target(shapes, True) - position) @ frame
    half = np.tan(camera.FIELD_OF_VIEW / 2)
    assert (abs(seen[:, 0]) < half * aspect * seen[:, 2]).all()
    assert (abs(seen[:, 1]) < half * seen[:, 2]).all()
