"""The surface of the beam, in as many pieces as the picture needs, and no more."""

import math
from typing import Any

import numpy as np
import pytest
from helpers import sampled
from hypothesis import example, given, settings
from hypothesis import strategies as st
from live.visitor import PAPER
from strategies import beams
from viser.transforms import SO3

from beamviz.beam import Beam
from beamviz.drawing import BeamView, beam_mesh, camera, colours
from beamviz.drawing.beam_mesh import DEFAULT_SCALE, DrawnBeam, segments, subdivide, to_hub_frame
from beamviz.drawing.modes import CLOSE, LAYER, SampledModes, displacement
from beamviz.drawing.scene_graph import SceneGraph
from beamviz.scene import COLOURINGS, ViewOptions
from beamviz.solver import solve

HEIGHT = 1080  # [pixels] of the picture
PHASES = np.linspace(0, math.pi, 7)[1:]
FINER = 12  # places on each piece that are looked at

BEAMS = beams(alpha=(0, 10), gamma=(0, 100), mu=(40, 300))
FASTEST = beams(alpha=(0, 10), gamma=(100, 200), mu=(80, 300))
mixes = st.lists(st.sampled_from([0.0, 0.5, 1.0]), min_size=5, max_size=5)


class Drawn:
    """A beam that moves in a picture, and how far its pieces are from the finer curve."""

    def __init__(self, beam: Beam, shares: Any, amplitude: float, colouring: str, **options: Any):
        self.solution = solve(beam, **options)
        self.shapes = SampledModes.sampled(self.solution)
        distance = float(np.linalg.norm(camera.viewpoint(self.shapes, True, 16 / 9)))
        view, scale = ViewOptions(colouring=colouring), camera.scale(distance, HEIGHT)
        self.seen = DrawnBeam(self.shapes, view, scale, amplitude * np.array(shares))
        self.pieces = subdivide(self.seen)

    def moved(self, shapes: SampledModes, phase: float) -> np.ndarray:
        """The displacement (n, 2), each mode at a phase of its own."""
        phases = phase * (1 + np.arange(len(shapes.modes)) % 3)
        return displacement(shapes, phases, self.seen.amplitudes)

    def deviation(self) -> float:
        """How far the solver's own curve gets from the pieces, relative to the bound."""
        count = len(self.pieces.strain)
        x = np.interp(np.arange(FINER * count + 1) / FINER, np.arange(count + 1), self.pieces.x)
        finer = SampledModes.sampled(self.solution, self.shapes, x)
        distances = []
        for phase in PHASES:
            ends, curve = (one.centreline + self.moved(one, phase) for one in (self.pieces, finer))
            away = curve[:-1].reshape(count, FINER, 2) - ends[:-1, None]
            step = np.diff(ends, axis=0)[:, None]
            cross = away[..., 0] * step[..., 1] - away[..., 1] * step[..., 0]
            distances.append(np.abs(cross) / np.linalg.norm(step, axis=2))
        return float(np.max(distances)) * self.seen.scale / beam_mesh.DEVIATION

    def steps(self) -> float:
        """The largest step of the colour map on one side of the mass, relative to the bound."""
        pieces = self.pieces
        places = [
            colours.scaled(pieces, self.seen.view.colouring, moved, self.seen.largest)
            for moved in (self.moved(pieces, phase) for phase in PHASES)
        ]
        assert np.abs(np.subtract(places, 0.5)).max() < 0.5 + 1e-6  # all are on the map
        steps = np.abs(np.diff(places))
        steps[:, pieces.mass - 1 : pieces.mass] = 0.0  # the stretch jumps at the mass
        return float(steps.max()) / beam_mesh.STEP


@pytest.mark.parametrize("options", [{}, {"coriolis": True}, {"plane": "flapwise"}], ids=str)
@settings(max_examples=10)
@given(BEAMS | FASTEST, mixes, st.floats(0, 0.4), st.sampled_from(COLOURINGS))
def test_pieces_deviate_little_from_the_curve(options, beam, shares, amplitude, colouring):
    """By at most a fifth of a pixel, also in the thin layers of the fastest beams, and neighbours
    by a sixtieth of the colour map."""
    drawn = Drawn(beam, shares, amplitude, colouring, **options)
    if len(drawn.pieces.strain) < beam_mesh.MAX_PIECES - 1:
        assert drawn.deviation() <= 2.0  # of a tenth: the curvature changes along a piece
        assert drawn.steps() <= 1.1


def test_half_as_many_pieces_are_not_enough():
    """For one mode at a time, one of the two bounds would not hold, apart from rounding up to whole
    pieces on both sides of the mass."""
    halved = []
    random = np.random.default_rng(1)
    for k in range(30):
        alpha, beta, gamma = random.uniform(0, 10), random.random(), random.uniform(0, 60)
        beam = Beam(alpha=alpha, beta=beta, gamma=gamma, mu=random.uniform(40, 300))
        drawn = Drawn(beam, np.eye(5)[k % 5], random.uniform(0.05, 0.4), COLOURINGS[k % 2])
        half = len(drawn.pieces.strain) // 2
        if half < 8:
            continue
        drawn.pieces = subdivide(drawn.seen, most=half)
        assert half - 1 <= len(drawn.pieces.strain) <= half
        halved.append(max(drawn.deviation(), drawn.steps()))
    assert len(halved) > 20
    assert min(halved) > 0.85
    assert np.mean(np.array(halved) > 1) > 0.9


def count(beam: Beam, mode: int, amplitude: float = 0.15, scale: float = DEFAULT_SCALE) -> int:
    """Pieces of one mode (0: none)."""
    sizes = amplitude * np.eye(6)[mode][1:]
    return len(subdivide(DrawnBeam(sampled(beam), ViewOptions(), scale, sizes)).strain)


def test_pieces_are_as_many_as_the_picture_needs():
    """More for a higher mode and at a larger scale, but never above the bound that keeps a page
    fast."""
    counts = [count(PAPER, mode) for mode in (0, 1, 2, 4)]  # none, B1, B2, B3
    assert counts == sorted(counts)
    assert count(PAPER, 5, 0.4) <= beam_mesh.MAX_PIECES
    assert count(Beam(), 2, scale=20 * DEFAULT_SCALE) > count(Beam(), 2)


@settings(max_examples=25)
@given(BEAMS, st.integers(0, 4))
@example(PAPER.replace(beta=1e-4), 1)
@example(PAPER.replace(beta=0.9999), 1)
@example(Beam(beta=0.9999885559, mu=40), 0)
def test_the_mass_lies_where_two_pieces_meet(beam, mode):
    """Where it is drawn, and the stretch is discontinuous; also next to an end. The strain of a
    piece is its relative elongation in the equilibrium, which is straight. Stations of the shapes,
    too, hold the mass, and are dense in the boundary layer at the clamp."""
    drawn = Drawn(beam, np.eye(5)[mode], 0.15, "axial strain")
    shapes, pieces = drawn.shapes, drawn.pieces
    for places in (shapes, pieces):
        assert places.x[[0, -1]].tolist() == [0.0, 1.0]
        assert (np.diff(places.x) > 0).all()
        assert places.x[places.mass] == pytest.approx(beam.beta, abs=CLOSE)
    assert (shapes.x < LAYER).mean() > 1.2 * LAYER
    assert not shapes.centreline[:, 1].any()
    lengths = np.diff(pieces.x)
    longer = np.diff(pieces.centreline[:, 0]) / lengths - 1
    # Of a difference of two positions near 1 of the solver.
    rounding = 16 * np.finfo(float).eps / lengths
    assert (abs(pieces.strain - longer) <= 1e-3 * abs(longer).max() + rounding).all()


@pytest.mark.parametrize("colouring", COLOURINGS)
def test_pieces_do_not_depend_on_rounding(colouring):
    """A beam in SI units gets other last digits when it is saved and opened: its pieces end at the
    same places, also those of strains that are as small as their own rounding errors."""
    chance = np.random.default_rng(0)
    for _ in range(6):
        numbers = {"alpha": 0.7, "beta": 0.002, "gamma": chance.uniform(1e-3, 1e-2), "delta": 1e-3}
        ends = []
        for digit in (0, 3e-16):
            beam = Beam(**{k: (1 + digit * chance.integers(-2, 3)) * v for k, v in numbers.items()})
            shapes = SampledModes.sampled(solve(beam, plane="flapwise"))
            view = ViewOptions(colouring=colouring, shares=(1.0, 1.0))
            ends.append(subdivide(DrawnBeam(shapes, view)).x)
        assert np.abs(ends[1] - ends[0]).max() < 1e-6


def test_an_overlay_has_faces_for_its_vertices():
    """When the number of pieces changes, both ways. It turns with the hub of the other beam. It has
    fewer pieces than that, as all are of one colour."""
    shapes, overlay = sampled(PAPER), BeamView(SceneGraph(), overlay=True)
    for mode in (0, 4, 0, 1):
        overlay.show(DrawnBeam(shapes, ViewOptions(rotating_frame=mode == 0).only(mode)))
        overlay.move(np.full(5, math.pi / 2), 1.0)
        assert np.allclose([*overlay.rotor.wxyz, *overlay.frame.position], [1, *[0] * 6])
        assert len(overlay.body.vertices) == 4 * len(overlay.shapes.x)
        assert overlay.body.faces.max() + 1 == len(overlay.body.vertices)
        assert 2 * len(overlay.shapes.x) < len(subdivide(overlay.drawn).x)


@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
def test_pieces_follow_the_line_and_meet_outside_a_bend(plane):
    """Each piece is parallel to its part of the line; on an arc the outer edges touch."""
    angle = np.linspace(0, 1.5, 31)
    line = np.stack([np.sin(angle), 1 - np.cos(angle)], 1)
    points, normal = to_hub_frame(SampledModes.at_rest(Beam(), plane), line)
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
