"""Declared and observed rates of convergence, as data."""

import numpy as np
import pytest

from beamviz.beam import Beam
from beamviz.solver import solve
from beamviz.solver.hp.equilibrium import AxialProblem, inertia, single
from beamviz.solver.hp.mesh import make_mesh
from beamviz.solver.hp.modes import lowest_modes
from beamviz.solver.problem import Problem

PROBLEM = Problem()

# beam, breaks of the mesh: error of the highest of five frequencies per two orders more.
AUTO_SCENES = [
    (Beam(), (0.0, 1.0)),
    (Beam(gamma=20), (0.0, 1.0)),
    (Beam(alpha=1, beta=0.5, gamma=10), (0.0, 0.5, 1.0)),
    (Beam(alpha=1, beta=0.3, gamma=30, delta=0.2), (0.0, 0.3, 1.0)),
]


@pytest.mark.parametrize(("beam", "breaks"), AUTO_SCENES)
def test_the_default_converges_exponentially(beam, breaks):
    """Each two orders more divide the error by at least 5, down to rounding; order 4 in h would
    soon fall short of that."""
    exact = solve(beam, tolerance=1e-12)
    errors = []
    for order in range(8, 22, 2):
        mesh = make_mesh(breaks, (order,) * (len(breaks) - 1))
        stack = single(beam)
        rho = inertia(mesh, stack)
        state = AxialProblem(mesh, rho, stack, PROBLEM.strain_law).solve()
        modes = lowest_modes(mesh, rho, state, stack, 5, PROBLEM)
        errors.append(abs(np.sqrt(modes.omega_squared[0, -1]) / exact.frequencies[-1] - 1))
    seen = np.array(errors) > 1e-11
    assert errors[-1] < 1e-9
    ratios = np.array(errors[:-1]) / np.maximum(errors[1:], 1e-12)
    assert np.all(ratios[seen[:-1]] > 5)
