"""The surface of the beam, the pieces it is drawn in, and the stations of both."""

from typing import Any

import numpy as np
import pytest
import trimesh
from drawing.shapes import BEAMS
from hypothesis import given
from hypothesis import strategies as st
from viser.transforms import SO3

from beamviz.beam import Beam
from beamviz.drawing.beam_mesh import segments, swept, to_hub_frame
from beamviz.drawing.modes import LAYER, STATIONS, SampledModes

PLANES = pytest.mark.parametrize("plane", ["chordwise", "flapwise"])


def line(x: Any, y: Any, plane: str) -> tuple[np.ndarray, np.ndarray]:
    """A line in the plane of motion as points in space, and the normal of the plane."""
    return to_hub_frame(SampledModes.at_rest(Beam(), plane), np.stack([x, y], 1))


@PLANES
@given(st.floats(0.1, 2.0), st.floats(0.01, 0.2), st.floats(0, 0.1))
def test_the_surface_is_closed_and_has_the_volume_of_the_beam(plane, length, thickness, wave):
    """It faces outwards; the volume is that of the box, to a per cent where the beam is bent."""
    x = np.linspace(0, length, 129)
    points, normal = line(x, wave * length * np.sin(2 * np.pi * x / length), plane)
    arc = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    body = trimesh.Trimesh(*swept(points, normal, (thickness, 0.1)), process=False)
    assert body.is_watertight
    assert body.is_winding_consistent
    assert body.volume == pytest.approx(arc * thickness * 0.1, rel=0.01 if wave else 1e-9)


@PLANES
def test_pieces_follow_the_line_and_meet_outside_a_bend(plane):
    """Each piece is parallel to its part of the line; on an arc the outer edges touch."""
    angle = np.linspace(0, 1.5, 31)
    points, normal = line(np.sin(angle), 1 - np.cos(angle), plane)
    centres, wxyz, sizes = segments(points, normal, (0.1, 0.2))
    rotation = SO3(wxyz).as_matrix()
    along, across = rotation @ [1, 0, 0], rotation @ np.cross(normal, [1, 0, 0])
    step = np.diff(points, axis=0)
    assert np.allclose(along, step / np.linalg.norm(step, axis=1, keepdims=True))
    outside = centres - 0.05 * across
    ends, starts = (outside + side * sizes[:, :1] / 2 * along for side in (1, -1))
    assert np.allclose(ends[1:-2], starts[2:-1], atol=1e-12)  # the first and last are cut square
    breadth = np.abs(normal).argmax()
    assert np.allclose(sizes[:, breadth], 0.2)
    assert np.allclose(np.delete(sizes, [0, breadth], axis=1), 0.1)


@given(BEAMS)
def test_stations_are_dense_in_boundary_layers_and_hold_the_mass(beam):
    """They increase from 0 to 1, the mass is at one, and the layer at the clamp has more."""
    shapes = SampledModes.at_rest(beam, "chordwise")
    assert shapes.x[[0, -1]].tolist() == [0, 1]
    assert len(shapes.x) == STATIONS
    assert (np.diff(shapes.x) > 0).all()
    assert shapes.x[shapes.mass] == pytest.approx(beam.beta, abs=1e-8)
    assert (shapes.x < LAYER).sum() > 1.2 * LAYER * STATIONS
