"""The tangents of the equation of motion, by differences, in both kinds of unknowns."""

import numpy as np
import pytest

from beamviz import Beam, Hub
from beamviz.blade import Blade, Mass
from beamviz.dynamics.equation import HubEquation
from beamviz.dynamics.initial_value import equation_of
from beamviz.dynamics.meshes import with_orders
from beamviz.dynamics.problem import MotionProblem

UNIFORM = Beam(alpha=1.2, beta=0.4, delta=0.3, mu=20)
# Two bodies that turn, a spring at the root, and properties that jump inside an element.
BLADE = Beam(
    alpha=0.3,
    beta=0.4,
    delta=0.3,
    mu=20,
    root=2.0,
    masses=(Mass(0.2, 0.7, (0.05, 0.08, 0.1)), Mass(0.1, 1.0, (0, 0, 0.02))),
    blade=Blade((0, 0.2, 0.2, 1), (1, 0.9, 0.6, 0.3), (1, 0.7, 0.4, 0.1), (1, 0.9, 0.7, 0.5)),
)
POINTS = BLADE.replace(root=np.inf, masses=(Mass(0.2, 0.7), Mass(0.1, 1.0)))
STEP = 1e-6
SPEED = (np.array([0.0, 1.0]), np.array([3.0, 3.7]))


def random_state(size: int) -> list[np.ndarray]:
    """Unknowns near the straight, unstretched beam, velocities and accelerations."""
    return list(np.random.default_rng(0).normal(size=(3, size)) * 0.05)


@pytest.mark.parametrize("hub", [False, True])
@pytest.mark.parametrize(("strain", "curvature"), [("green", "spatial"), ("biot", "material")])
@pytest.mark.parametrize(
    ("beam", "method"),
    [(UNIFORM, "auto"), (UNIFORM, "ancf"), (POINTS, "ancf"), (BLADE, "auto")],
    ids=["uniform", "cubic", "cubic blade", "blade"],
)
def test_tangents(beam: Beam, method: str, hub: bool, strain: str, curvature: str):
    theory = {"strain": strain, "curvature": curvature, "method": method}
    problem = MotionProblem(beam=beam, until=1.0, speed=Hub(0.5) if hub else SPEED, **theory)
    mesh = 3 if method == "ancf" else with_orders([0.0, 0.4, 0.7, 1.0], [6, 5, 5])
    equation = equation_of(problem, mesh, with_mass=True)
    model = equation.beam
    none = np.zeros(len(model.points))
    state = random_state(model.size + hub)
    state[0][: model.size] += model.nearest(none + 1, none)
    if isinstance(equation, HubEquation):
        state[1][-1] = 2.0  # the speed
    load = equation.load(np.array([0.5]))
    tangents = equation.tangents(load, *(part[None] for part in state))
    for k, tangent in enumerate(tangents):
        columns = []
        for j in range(len(state[0])):
            shifted = []
            for sign in (1, -1):
                moved = [part.copy() for part in state]
                moved[k][j] += sign * STEP
                shifted.append(equation.residual(load, *(part[None] for part in moved))[0])
            columns.append((shifted[0] - shifted[1]) / (2 * STEP))
        # Rounding errors of the differences are 1e-9 of the forces, the next terms less.
        differences = np.array(columns).T
        assert differences == pytest.approx(tangent, abs=1e-6 * abs(tangent).max())
