"""The tangents of the equation of motion, by differences, in both kinds of unknowns."""

import numpy as np
import pytest

from beamviz import Beam
from beamviz.dynamics.elements import elements_between
from beamviz.dynamics.equation import Equation, HubEquation, Model
from beamviz.dynamics.meshes import cubic_mesh
from beamviz.solver.constitutive import CURVATURES, STRAIN_LAWS

BEAM = Beam(alpha=1.2, beta=0.4, delta=0.3, mu=20)
STEP = 1e-6


@pytest.mark.parametrize("cubic", [False, True])
@pytest.mark.parametrize("hub", [False, True])
@pytest.mark.parametrize(("strain", "curvature"), [("green", "spatial"), ("biot", "material")])
def test_tangents(cubic, hub, strain, curvature):
    model = Model(BEAM, STRAIN_LAWS[strain], CURVATURES[curvature], cubic)
    mesh = cubic_mesh(3) if cubic else elements_between((0.0, 0.4, 1.0), (4, 5))
    load = np.array([3.0]), np.array([0.7])
    made = HubEquation(mesh, model, 0.5, None) if hub else Equation(mesh, model, None)
    random = np.random.default_rng(0)
    none = np.zeros_like(mesh.points)
    start = np.append(made.unknowns.fitted(none, none + 1), [0.0] * hub)  # straight, unstretched
    state = [part + random.normal(size=len(start)) * 0.05 for part in (start, 0.0, 0.0)]
    if hub:
        state[1][-1] = 2.0  # the speed
    tangents = made.tangents(load, *(part[None] for part in state))
    for k, tangent in enumerate(tangents):
        columns = []
        for j in range(len(start)):
            shifted = []
            for sign in (1, -1):
                moved = [part.copy() for part in state]
                moved[k][j] += sign * STEP
                shifted.append(made.residual(load, *(part[None] for part in moved))[0])
            columns.append((shifted[0] - shifted[1]) / (2 * STEP))
        # Rounding errors of the differences are 1e-9 of the forces, the next terms less.
        differences = np.array(columns).T
        assert differences == pytest.approx(tangent, abs=1e-6 * abs(tangent).max())
