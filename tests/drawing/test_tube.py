"""The beam as a swept body, as pieces, and the stations both are drawn at."""

from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from beamviz.beam import Beam
from beamviz.drawing import beam_mesh as tube
from beamviz.drawing import modes
from beamviz.drawing.modes import SampledModes
from beamviz.errors import NoEquilibrium
from beamviz.solver import solve


@given(st.floats(0.1, 2.0), st.floats(0.01, 0.2), st.sampled_from(["chordwise", "flapwise"]))
def test_the_swept_body_of_a_straight_beam_is_its_box(length, thickness, plane):
    """Closed, facing outwards, with the volume of the box."""
    x = np.linspace(0, length, 9)
    points, normal = tube.frame(np.stack([x, 0 * x], 1), plane)
    body = trimesh.Trimesh(*tube.swept(points, normal, thickness, 0.1), process=False)
    assert body.is_watertight
    assert body.is_winding_consistent
    assert body.volume == pytest.approx(length * thickness * 0.1, rel=1e-9)


def test_a_bent_body_stays_closed():
    """A section swept along two waves has no holes and keeps its volume to a per cent."""
    x = np.linspace(0, 1, 129)
    points, normal = tube.frame(np.stack([x, 0.1 * np.sin(2 * np.pi * x)], 1), "chordwise")
    length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    body = trimesh.Trimesh(*tube.swept(points, normal, 0.05, 0.08), process=False)
    assert body.is_watertight
    assert body.is_winding_consistent
    assert body.volume == pytest.approx(length * 0.05 * 0.08, rel=0.01)


@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
def test_pieces_follow_the_line_and_meet_outside_a_bend(plane):
    """Each piece runs along its part of the line; on an arc the outer edges touch."""
    angle = np.linspace(0, 1.5, 31)
    points, normal = tube.frame(np.stack([np.sin(angle), 1 - np.cos(angle)], 1), plane)
    centres, wxyz, lengths = tube.segments(points, normal, 0.1, 0.2)
    along = np.stack([rotated(q, [1, 0, 0]) for q in wxyz])
    across = np.stack([rotated(q, np.cross(normal, [1, 0, 0])) for q in wxyz])
    step = np.diff(points, axis=0)
    assert np.allclose(along, step / np.linalg.norm(step, axis=1, keepdims=True))
    outside = centres - 0.05 * across
    ends = outside + lengths[:, :1] / 2 * along
    starts = outside - lengths[:, :1] / 2 * along
    assert np.allclose(ends[1:-2], starts[2:-1], atol=1e-12)  # the first and last are cut square
    breadth = np.abs(normal).argmax()
    assert np.allclose(lengths[:, breadth], 0.2)
    assert np.allclose(np.delete(lengths, [0, breadth], axis=1), 0.1)


def rotated(wxyz: np.ndarray, vector: Any) -> np.ndarray:
    """A vector turned by a unit quaternion."""
    w, v = wxyz[0], wxyz[1:]
    return vector + 2 * np.cross(v, np.cross(v, vector) + w * np.asarray(vector))


@given(st.floats(0, 1), st.floats(0.005, 0.2))
def test_stations_follow_curvature_and_hold_the_mass(mass, layer):
    """They rise from 0 to 1, the mass, if not at an end, is one, and a bending layer gets more."""
    x = np.linspace(0, 1, 401)
    points = modes.stations(x, np.exp(-x / layer), mass)
    assert len(points) == modes.FINE + 1
    assert points[0] == 0
    assert points[-1] == 1
    assert (np.diff(points) > 0).all()
    assert np.abs(points - mass).min() < 1e-8
    assert (points < layer).sum() > 1.2 * layer * modes.FINE


@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
@given(
    alpha=st.floats(0, 100), beta=st.floats(0, 1), gamma=st.floats(0, 200), delta=st.floats(0, 5)
)
@settings(max_examples=30)
def test_nothing_is_seen_to_happen_between_stations(plane, alpha, beta, gamma, delta):
    """Even in the thin layers of the fastest beams, straight lines between stations are less than
    a fifth of a pixel off, where the beam takes 1000 and swings as far as it does at first."""
    beam = Beam(alpha, beta, gamma, delta, mu=200)
    try:
        solution = solve(beam, plane=plane)
    except NoEquilibrium:
        return
    shapes, x = SampledModes.sampled(solution), np.linspace(0, 1, 4001)
    bends = solution.bending_energy_fraction > 0.5
    exact, there = (solution.displacement(at)[:, 1, bends].T for at in (x, shapes.x))
    across = shapes.modes[bends, :, 1]
    far = np.abs(there).argmax(axis=1)[:, None]
    scale = np.take_along_axis(across, far, 1) / np.take_along_axis(there, far, 1)
    between = np.stack([np.interp(x, shapes.x, mode) for mode in across])
    off = np.abs(between - scale * exact).max(axis=1)
    assert (off * np.minimum(0.15, shapes.limits[bends]) < 2e-4).all()
