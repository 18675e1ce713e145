"""The forces drawn on a beam, against integrals and balances that their arrows know nothing of."""

import numpy as np
import pytest
from helpers import sampled, slow
from scipy.integrate import quad

from beamviz import Beam, Hub, Ramp, motion
from beamviz.blade import Blade, Mass
from beamviz.drawing import BeamView
from beamviz.drawing.beam_mesh import DrawnBeam
from beamviz.drawing.forces import (
    CORIOLIS,
    EULER,
    PIECES,
    PULL,
    SOFTENING,
    ModeForces,
    MotionForces,
)
from beamviz.drawing.modes import stations
from beamviz.drawing.scene_graph import SceneGraph
from beamviz.exports.motion_scene import MotionScene
from beamviz.scene import ViewOptions

TAPERED = Beam(gamma=8, blade=Blade.tapered(0.5), masses=(Mass(0.3, 0.4), Mass(0.5, 1.0)))
HEAVY = Beam(alpha=1, beta=0.5, gamma=5, delta=0.2)
ON = {"coriolis": True}
SHOWN = ViewOptions(shares=(1.0, 1.0), forces=True)


def forces_of(beam: Beam, view: ViewOptions = SHOWN, **options) -> ModeForces:
    source = DrawnBeam(sampled(beam, **options), view).forces
    assert isinstance(source, ModeForces)
    return source


@pytest.mark.parametrize(
    "beam", [HEAVY, TAPERED, Beam(alpha=0.5, beta=1.0, gamma=2, delta=-0.6)], ids=str
)
def test_what_pulls_further_out_is_the_tension(beam):
    """At each end of a piece, also where it presses: the sum of the arrows at rest, the band, and
    an integral of rho gamma^2 (x + u + delta)."""
    shapes = sampled(beam)
    source = ModeForces(shapes, np.zeros(len(shapes.modes)))
    at_rest = source.at(np.zeros(len(shapes.modes)))
    pull, position = at_rest.on_pieces[PULL].real, shapes.solution.equilibrium.position

    def load(x: float) -> float:
        rho = 1.0 if beam.blade is None else float(beam.blade.at("mass", x))
        return beam.gamma**2 * rho * (position([x])[0, 0] + beam.delta)

    for edge in np.arange(PIECES) / PIECES:
        bodies = [body for body in beam.bodies if body.beta >= edge]
        expected = quad(load, edge, 1, limit=200, points=[0.4, 0.5])[0] if edge < 0.4 else None
        if expected is None:
            expected = quad(load, edge, 1, limit=200)[0]
        for body in bodies:
            expected += body.alpha * beam.gamma**2 * (position([body.beta])[0, 0] + beam.delta)
        outboard = pull[source.pieces.x >= edge].sum()
        banded = np.interp(edge, source.band, at_rest.tension)
        assert outboard == pytest.approx(expected, rel=1e-5, abs=1e-5)
        assert banded == pytest.approx(expected, rel=1e-5, abs=1e-5)


@pytest.mark.parametrize(
    ("options", "kinds"),
    [
        (ON, [PULL, SOFTENING, CORIOLIS]),
        ({}, [PULL, SOFTENING]),
        (ON | {"stiffening": False}, [SOFTENING, CORIOLIS]),
        (ON | {"softening": False}, [PULL, CORIOLIS]),
        (ON | {"plane": "flapwise"}, [PULL]),
        (ON | {"plane": "both"}, [PULL, SOFTENING, CORIOLIS]),
    ],
    ids=str,
)
def test_a_term_that_is_switched_off_has_no_arrows(options, kinds):
    source = forces_of(HEAVY, **options)
    assert source.largest.keys() == {*kinds}
    assert bool(source.greatest_tension) == (PULL in kinds)


def test_a_beam_at_rest_has_no_forces_and_one_that_spins_up_an_euler_force():
    still = forces_of(HEAVY.replace(gamma=0))
    assert not still.largest
    assert not still.greatest_tension
    spinning = forces_of(HEAVY.replace(spin_up=3.0), state="stable")
    assert EULER in spinning.largest


def test_forces_of_modes_stay_within_what_the_legend_says():
    source = forces_of(HEAVY, **ON)
    for phase in np.linspace(0, 7, 30):
        now = source.at(np.full(len(source.amplitudes), phase) * [1, 2, 3, 5, 7])
        for kind, largest in source.largest.items():
            assert np.abs(now.on_pieces[kind]).max() <= max(largest) * (1 + 1e-9)


@pytest.mark.parametrize("speed", [Ramp(4.0, within=2.0), *slow(Hub(2.0, torque=3.0))], ids=repr)
def test_in_a_motion_all_forces_balance_the_tension_at_the_root(speed):
    """Along the beam, where the clamp takes nothing else: the sum of what is drawn, less the mass
    times the acceleration in the hub's frame, by differences of the velocity."""
    beam = Beam(alpha=0.5, beta=0.7, gamma=2.0, delta=0.1)
    result = motion(beam, 2.0, speed=speed, release=1.0, curvature="material", tolerance=1e-5)
    source, step = MotionForces(result, stations(0.7)), 1e-5
    for t in (0.3, 0.9, 1.7):
        now = source.at(t)
        total = sum(values.sum() for values in now.on_pieces.values())
        _, momentum, _, _ = source.state(np.array([t - step, t + step]))
        force = total - np.diff(momentum.sum(axis=1))[0] / (2 * step)
        # Of the stretching vibration, a few steps a period, accelerations are known to a percent.
        assert force.real == pytest.approx(now.tension[0], abs=0.02 * max(abs(now.tension)))
        gamma = result.speed([t - step, t + step])[0]
        assert result.speed([t])[1][0] == pytest.approx(np.diff(gamma)[0] / (2 * step), rel=1e-3)
        assert {CORIOLIS, EULER} <= source.largest.keys()


def test_arrows_are_as_long_as_their_forces_and_the_band_as_high():
    """In the scene, and none where the view has none, or where each mode has its row."""
    graph = SceneGraph()
    view = BeamView(graph)
    shapes = sampled(HEAVY)
    view.show(DrawnBeam(shapes, ViewOptions()))
    before = set(graph.nodes)
    view.show(drawn := DrawnBeam(shapes, SHOWN))
    view.move(phases := np.full(len(shapes.modes), 1.2), 0.0)
    shafts, heads = (graph.nodes[f"/scene/rotor/force {part}"] for part in ("shafts", "heads"))
    lengths = shafts.batched_scales[:, 0] + heads.batched_scales[:, 0]
    now = drawn.forces.at(phases).on_pieces
    assert now.keys() >= drawn.forces.largest.keys()
    for row, kind in zip(lengths.reshape(2, -1), (PULL, SOFTENING), strict=True):
        np.testing.assert_allclose(row / row[0], abs(now[kind]) / abs(now[kind][0]), rtol=1e-6)
    heights = graph.nodes["/scene/rotor/tension"].batched_scales[:, 2]
    tension = drawn.forces.tension
    assert heights[0] / heights[-5] == pytest.approx(
        (tension[0] + tension[1]) / (tension[-6] + tension[-5]), rel=1e-9
    )
    assert "tension at the root" in {caption.text.partition(" 3")[0] for caption in view.captions}
    view.show(DrawnBeam(shapes, ViewOptions()))
    assert not any(
        graph.nodes[name].visible for name in set(graph.nodes) - before if "text" not in name
    )
    assert not any("tension" in caption.text for caption in view.captions)
    assert DrawnBeam(shapes, ViewOptions(forces=True, all_modes=True)).forces is None


@pytest.mark.parametrize(
    ("beam", "options"),
    [
        (Beam(gamma=5, blade=TAPERED.blade, masses=TAPERED.masses, root=0.0), {}),
        (Beam(gamma=4, delta=-1), {"state": "straight"}),  # which has buckled
        (Beam(gamma=4, delta=-1), {"state": "stable"}),
        (Beam(gamma=5, masses=(Mass(1.0, 0.0), Mass(0.0, 0.5, (0.1, 0.1, 0.1)))), {}),
        (Beam(gamma=5, pitch=30, flap=4), {"plane": "both"}),
        (Beam(gamma=0), {}),
        (Beam(gamma=3, mu=1e6), {}),
    ],
    ids=str,
)
def test_every_kind_of_beam_is_drawn_with_finite_forces(beam, options):
    """Also a body at the clamp, and one without mass."""
    shapes = sampled(beam, **options)
    graph = SceneGraph()
    view = BeamView(graph)
    view.show(DrawnBeam(shapes, SHOWN))
    view.move(np.ones(len(shapes.modes)), 0.5)
    for node in graph.nodes.values():
        for name in ("batched_positions", "batched_wxyzs", "batched_scales"):
            assert np.isfinite(getattr(node, name, 0.0)).all(), (node.name, name)


def test_a_film_of_a_motion_has_the_forces_of_each_moment():
    """As the page draws them, of a beam that drops its body."""
    moved = motion(Beam(alpha=1, gamma=4), 1.0, release=1.0, drop=0.5)
    scene, graph = MotionScene(moved, view=ViewOptions(forces=True)), SceneGraph()
    beams = scene.draw(graph)
    heads = []
    for moment in (0.25, 0.75):
        scene.move(beams, moment)
        heads.append(graph.nodes["/scene/rotor/force heads"].batched_scales[:, 0].reshape(-1, 9))
    assert (heads[0][:, -1] > 0).any()
    assert not heads[1][:, -1].any()
    assert MotionScene(moved).draw(SceneGraph()).rows[0].forces is None
