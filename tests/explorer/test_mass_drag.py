"""Dragging the mass: the position under the pointer, and the beam before as an overlay."""

import contextlib
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from live.browser import NODES, Page, by_id, field, says
from live.visitor import PAPER, frequency_text

from beamviz.beam import Beam
from beamviz.drawing import BeamView
from beamviz.drawing.beam_mesh import DrawnBeam, to_hub_frame
from beamviz.drawing.modes import SampledModes
from beamviz.explorer.features.comparison import number
from beamviz.explorer.features.controls import MassDrag, nearest
from beamviz.scene import Scene, ViewOptions
from beamviz.server import run_server
from beamviz.solver import solve

BENT = Beam(alpha=0.2, beta=0.6, gamma=4, delta=-1)


def test_no_point_without_a_line_of_sight():
    """For a line seen end on, a line of sight of length 0, or nan."""
    line, x, origin = np.array([[0.0, 0, 0], [1.0, 0, 0]]), np.array([0.0, 1.0]), np.zeros(3)
    assert nearest(line, x, np.array([-3.0, 0, 0]), origin) is None
    assert nearest(line, x, origin, origin) is None
    assert nearest(line, x, np.array([0.0, -3.0, 1.0]), np.full(3, np.nan)) is None


@pytest.mark.parametrize("rotating_frame", [True, False])
@pytest.mark.parametrize(
    ("beam", "state"),
    [(PAPER.replace(delta=0.5, gamma=40), "straight"), (BENT, "stable")],
    ids=["straight", "bent"],
)
def test_a_point_of_the_beam_gives_its_coordinate(beam, state, rotating_frame):
    """In both frames, rotated, stretched or bent: the reference coordinate."""
    shapes = SampledModes.sampled(solve(beam, state=state))
    assert shapes.centreline[:, 1].any() == (state == "stable")
    with run_server() as server:
        view = BeamView(server.scene)
        view.show(DrawnBeam.of(shapes, ViewOptions(rotating_frame=rotating_frame)))
        view.move(np.zeros(5), angle=0.7)
        client = SimpleNamespace(camera=SimpleNamespace(position=np.array([0.3, -3.0, 2.0])))
        guest: Any = SimpleNamespace(client=client, state=SimpleNamespace(case=None))
        drag, turn = MassDrag(guest, view), 0.0 if rotating_frame else 0.7
        points, _ = to_hub_frame(shapes, shapes.centreline)
        c, s = math.cos(turn), math.sin(turn)
        turned = points @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        for k in (60, 250, 500):
            sight = drag.line_of_sight(np.array(view.frame.position) + turned[k])
            assert drag.nearest_coordinate(sight) == pytest.approx(shapes.x[k], abs=1e-3)


# By a mouse, on the page

# What viser's own page complains about when a body of the scene is dragged.
KNOWN = "Unable to preventDefault inside passive event listener invocation."


def on_screen(shown: Page, x: float, y: float) -> list[float]:
    """Where a point of the plane of rotation, in the frame of the hub, is on the page."""
    return shown.evaluate(f"""(() => {{
      const {{ camera, canvas }} = window.__viserMutable, wheel = {NODES}['/scene/rotor'];
      const place = wheel.position.clone().set({x}, {y}, 0);
      const at = wheel.localToWorld(place).project(camera), r = canvas.getBoundingClientRect();
      return [r.left + r.width * (1 + at.x) / 2, r.top + r.height * (1 - at.y) / 2];
    }})()""")


def move(shown: Page, start: list[float], end: list[float]) -> None:
    """Drag from one point of the page to another."""
    shown.mouse("mouseMoved", *start)
    shown.next_frame()
    shown.mouse("mousePressed", *start, 1)
    for place in np.linspace(start, end, 11)[1:].tolist():
        shown.mouse("mouseMoved", *place, 1)
        shown.next_frame()
    shown.mouse("mouseReleased", *end)


@pytest.mark.parametrize(
    ("beam", "state", "end"),
    [(Beam(alpha=1, beta=0.5, gamma=3), "straight", 0.95), (BENT, "stable", 0.8)],
    ids=["straight", "bent"],
)
def test_the_mass_is_dragged_by_a_mouse(shown, beam, state, end):
    """Along a beam, straight or bent, towards the tip: beta is where the drag ended, to a
    hundredth, also if the shape of the beam changes. The beam before is drawn pale, with its
    frequencies beside the new ones."""
    scene = Scene.of(beam, state=state, shares=[1.0], amplitude=0.0, playing=False)
    shown.send("load", f"beam.toml\n{scene.to_toml()}")
    shown.wait(f"{NODES}?.['/scene/rotor/mass'] && {says(frequency_text(beam, state=state))}")

    def place(x: float) -> list[float]:
        solution = solve(beam.replace(beta=x), state=state)
        along, across = solution.equilibrium.position([x])[0]
        return on_screen(shown, beam.delta + along, across)

    position = f"parseFloat({field('position β')}.value)"

    def stays(x: float) -> str:
        there = f"Math.abs({position} - {x}) < 0.01"
        return f"{there} && new Promise(done => setTimeout(() => done({there}), 1000))"

    for _ in range(4):  # a busy machine may see the pointer go by, or let go on the way
        shown.send("beta", beam.beta)
        shown.wait(stays(beam.beta))
        move(shown, place(beam.beta), place(end))
        with contextlib.suppress(TimeoutError):
            shown.wait(stays(end), timeout=10)
            break
    assert shown.evaluate(stays(end))
    shown.wait(f"{NODES}['/scene/rotor/overlay']?.visible === true")
    after = float(shown.evaluate(position))
    omegas = [solve(beam.replace(beta=x), state=state).frequencies[0] for x in (beam.beta, after)]
    for words in ("before, ω", *map(number, omegas)):
        shown.wait(f"{by_id('comparison')}.textContent.includes('{words}')")
    assert [problem for problem in shown.problems if KNOWN not in problem] == []
