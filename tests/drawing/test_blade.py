"""A blade in the scene: its sections, the bodies on it and the hinge at its root."""

import math
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from helpers import sampled
from hypothesis import given
from hypothesis import strategies as st

from beamviz.beam import PARAMETERS, Beam
from beamviz.blade import Blade, Mass
from beamviz.drawing import BeamView, beam_mesh, camera
from beamviz.drawing.beam_mesh import DrawnBeam, subdivide, to_hub_frame
from beamviz.drawing.modes import SampledModes, displacement
from beamviz.drawing.scene_graph import SceneGraph
from beamviz.drawing.sizes import (
    RELATIVE_SIZES,
    box_size,
    collar_size,
    local_section,
    section_size,
    sections,
)
from beamviz.scene import ViewOptions

HEIGHT, WIDTH = 0.5, 0.3
TAPER = Beam(blade=Blade.tapered(HEIGHT, WIDTH), gamma=3)
JUMP = Blade(*((0, 0.4, 0.4, 1), (1, 0.9, 0.5, 0.3), (1, 0.8, 0.2, 0.06), (1, 0.9, 0.5, 0.3)))
BODIES = (Mass(0.3, 0.5, (0.001, 0.004, 0.004)), Mass(0.1, 1.0))
STEPPED = Beam(blade=JUMP, masses=BODIES, alpha=0.2, beta=0.7, gamma=3, delta=0.2)


def show(beam: Beam, plane: str = "chordwise", **view: bool) -> BeamView:
    """A beam in mode 2 at its largest displacement."""
    drawn, shapes = BeamView(SceneGraph()), sampled(beam, plane=plane)
    drawn.show(DrawnBeam(shapes, replace(ViewOptions(), **view).only(1)))
    drawn.move(np.full(len(shapes.modes), math.pi / 2), 0.0)
    return drawn


def test_a_taper_as_stiff_in_both_planes_is_drawn_as_a_square():
    """Between that of its stiffness, h, and that of its area, sqrt(b h); neighbours differ by a
    pixel at most; at the root it looks as the uniform beam."""
    drawn = show(TAPER)
    thickness, breadth = section_size(Beam())
    assert thickness == breadth == pytest.approx(math.sqrt(12) / Beam().mu)
    x = (drawn.shapes.x[1:] + drawn.shapes.x[:-1]) / 2
    sizes = drawn.beam.batched_scales
    h, b = 1 - HEIGHT * x, 1 - WIDTH * x
    assert sizes[:, 1] == pytest.approx(thickness * np.sqrt(h * np.sqrt(b * h)), rel=1e-4)
    assert sizes[:, 2] == pytest.approx(sizes[:, 1], rel=1e-6)
    still = DrawnBeam(drawn.drawn.shapes, ViewOptions(shares=(0.0,)))  # of one colour
    steps = np.diff(sections(TAPER, "chordwise", subdivide(still).x).mean(axis=1), axis=0)
    assert np.abs(steps).max() * still.scale <= 1.1


@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
def test_with_two_bending_stiffnesses_both_sizes_are_known(plane):
    """A section of half the height in the plane of rotation over its width out of that plane: it is
    the same body in both planes, seen from the plane of motion."""
    y, z = 0.04 * np.array([1.0, 0.7]), 0.08 * np.array([1.0, 0.4])  # at the root and the tip
    area, bending, flap = y * z, z * y**3, y * z**3
    rows = (tuple((one / one[0]).tolist()) for one in (area, bending, area))
    blade = Blade((0, 1), *rows, flap=tuple((flap / bending[0]).tolist()))
    beam = Beam(blade=blade, mu=math.sqrt(12) / y[0])
    sizes = sections(beam, plane, np.array([0.0, 1.0]))[0]
    expected = np.stack([y, z] if plane == "chordwise" else [z, y], 1)
    assert sizes == pytest.approx(expected, rel=1e-6)


@given(st.floats(1e-4, 1e4), st.floats(1e-4, 1e4))
def test_the_tip_of_any_taper_is_visible(bending, axial):
    """Its sizes are neither too small nor too large."""
    blade = Blade((0, 1), (1, 1), (1, bending), (1, axial))
    ((root, tip),) = sections(Beam(blade=blade), "chordwise", np.array([0.0, 1.0]))
    assert (root * RELATIVE_SIZES[0] <= tip).all()
    assert (tip <= root * RELATIVE_SIZES[1]).all()


def test_a_jump_is_a_step():
    """Where the section jumps, pieces of both sections meet, and the wider one is closed. The
    surface of the overlay and of models has two rings there, and the volume of both parts."""
    drawn = show(STEPPED)
    k = drawn.shapes.station(0.4)
    assert drawn.shapes.x[k] == 0.4
    before, after = drawn.beam.batched_scales[[k - 1, k], 1]
    inside, outside = (JUMP.at("bending", 0.4, side) for side in (1, 0))
    assert before / after == pytest.approx((inside / outside) ** 0.25, rel=0.02)  # of a square
    assert before > 1.3 * after
    closed = drawn.ends.batched_positions
    assert np.linalg.norm(closed - drawn.beam.batched_positions[k - 1], axis=1).min() == 0

    x = np.linspace(0, 1, 6)  # 0.4 is one of them
    points, normal = to_hub_frame(drawn.shapes, np.stack([x, 0 * x], 1))
    sizes = sections(STEPPED, "chordwise", x)
    surface = trimesh.Trimesh(*beam_mesh.swept(points, normal, sizes), process=False)
    assert surface.is_volume
    assert len(surface.vertices) == 4 * (len(x) + 1)
    (a, b), (c, d) = sizes[:, 0].T, sizes[:, 1].T  # of a truncated wedge, Simpson's rule holds
    areas = a * b + (a + c) * (b + d) + c * d
    assert surface.volume == pytest.approx((areas * np.diff(x)).sum() / 6, rel=1e-9)


def test_the_undeformed_blade_has_the_edges_of_a_step():
    """Of a uniform beam the twelve edges of a box, of one that jumps those of two, once where they
    meet."""
    for blade, lines in ((None, 12), (JUMP, 4 * 3 + 4 * 4)):
        x = np.array([0.0, 0.4, 1.0] if blade else [0.0, 1.0])
        points, normal = to_hub_frame(sampled(Beam()), np.stack([x, 0 * x], 1))
        sizes = sections(Beam(blade=blade), "chordwise", x)
        edges = beam_mesh.outline(points, normal, sizes)
        assert len(edges) == lines
        assert (np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1) > 1e-4).all()


def test_each_body_is_where_the_beam_is():
    """In motion, with its orientation, and with a label of its mass above it; those with inertia
    are boxes, the others collars."""
    drawn = show(STEPPED)
    shapes = drawn.shapes
    moved = displacement(shapes, np.full(5, math.pi / 2), drawn.drawn.amplitudes)
    points, _ = to_hub_frame(shapes, shapes.centreline + moved)
    at = [int(np.argmin(np.abs(shapes.x - body.beta))) for body in drawn.bodies.shown]
    assert [body.beta for body in drawn.bodies.shown] == [0.7, 0.5, 1.0]
    assert shapes.x[at].tolist() == [0.7, 0.5, 1.0]
    assert drawn.bodies.collars.batched_positions == pytest.approx(points[[at[0], at[2]]])
    assert drawn.bodies.boxes.batched_positions == pytest.approx(points[[at[1]]])
    numbers = [
        drawn.bodies.number(node, k)
        for node, k in ((drawn.bodies.boxes, 0), (drawn.bodies.collars, 1), (drawn.bodies.boxes, 1))
    ]
    assert numbers == [1, 2, None]
    labels = [caption for caption in drawn.captions if caption.text.startswith("α")]
    assert [caption.text for caption in labels] == ["α = 0.2", "α = 0.3", "α = 0.1"]
    for caption, k in zip(labels, at, strict=True):
        assert caption.point.position[:2] == pytest.approx(points[k, :2])
        assert caption.point.position[2] > points[k, 2] + 0.03


def test_one_mass_of_a_uniform_beam_has_no_label():
    """As the page says its number in many places."""
    assert not [c for c in show(Beam(alpha=1, beta=0.5)).captions if c.text.startswith("α")]


def test_a_box_is_that_of_its_inertia_and_encloses_the_beam():
    """A solid box gives its inertia, and the inertia the box."""
    a, b, c, m = 0.2, 0.12, 0.15, 0.7
    inertia = tuple(m / 12 * (p * p + q * q) for p, q in ((b, c), (a, c), (a, b)))
    assert box_size(Beam(), Mass(m, 0.5, inertia)) == pytest.approx((a, b, c))
    thin = box_size(Beam(), Mass(m, 0.5, (0.0, 0.0, 1e-6)))
    assert (np.array(thin[1:]) > section_size(Beam())).all()


def test_a_collar_fits_the_section_at_its_place():
    """Its volume is that of its mass at the density of the root section; it encloses the beam."""
    for beta in (0.0, 0.4, 1.0):
        body = Mass(0.1, beta)
        section = local_section(STEPPED, body)
        length, radius = collar_size(STEPPED, body)
        inside = math.prod(section)
        volume = 0.1 * math.prod(section_size(STEPPED))
        assert length * (math.pi * radius**2 - inside) == pytest.approx(volume)
        assert radius > math.hypot(*section) / 2


@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
@pytest.mark.parametrize(
    ("root", "shown"), [(math.inf, []), (0.0, ["fork", "pin"]), (2.0, ["fork", "pin", "spring"])]
)
def test_a_root_that_is_not_clamped_is_a_hinge(root, shown, plane):
    """A pin and a fork at the end of the beam, with a spring if there is one; the pin is parallel
    to the normal of the plane of motion, and seen above a hub that the beam begins in."""
    for delta in (0.0, 0.3):
        drawn = show(Beam(root=root, gamma=3, delta=delta), plane)
        nodes = drawn.joint.nodes
        assert [node.name.rpartition("/")[2] for node in nodes] == shown
        if not shown:
            continue
        low, high = nodes[1].vertices.min(axis=0), nodes[1].vertices.max(axis=0)
        assert (low[0] + high[0]) / 2 == pytest.approx(delta, abs=1e-9)
        along = 2 if plane == "chordwise" else 1
        assert np.argmax(high - low) == along
        if delta == 0:
            reach = 0.07 if along == 2 else 0.05  # half the height of the hub, its radius
            assert max(high[along], -low[along]) > reach


def test_all_bodies_are_in_the_picture():
    """A large one at the tip too."""
    beam = Beam(masses=(Mass(1.0, 1.0, (0.0, 0.0, 0.1)),))
    left, right = camera.span(SampledModes.at_rest(beam, "chordwise"))
    assert right > 1.1
    assert left < 0


def test_pieces_end_at_bodies_and_jumps():
    """With few and with many pieces, also next to each other and at the ends."""
    masses = tuple(Mass(0.1, beta) for beta in (0.0, 0.3, 0.3 + 1e-5, 0.4, 1.0))
    beam = Beam(blade=JUMP, masses=masses)
    drawn = DrawnBeam(sampled(beam), ViewOptions().only(0))
    for most in (20, beam_mesh.MAX_PIECES):
        pieces = subdivide(drawn, most=most)
        assert len(pieces.strain) <= most
        assert (np.diff(pieces.x) > 0).all()
        for body in masses:
            assert np.abs(pieces.x - body.beta).min() == 0


def test_pieces_are_closed_at_the_ends_and_where_the_section_jumps():
    """There one would look into them."""
    for blade in (None, TAPER.blade, JUMP):
        drawn = show(Beam(blade=blade))
        last, k = len(drawn.shapes.strain) - 1, drawn.shapes.station(0.4)
        assert drawn.capped == ([0, k - 1, k, last] if blade is JUMP else [0, last])


def test_the_size_of_an_inextensible_beam_is_a_usual_one():
    """Its axial stiffness says nothing of its section."""
    inextensible = Beam(mu=PARAMETERS["mu"].limits[1])
    assert section_size(inextensible) == section_size(Beam(mu=100))
