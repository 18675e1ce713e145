"""Declared and observed rates of convergence, as data."""

import numpy as np
import pytest

from beamviz.beam import Beam
from beamviz.solver import solve
from beamviz.solver.hp.mesh import mesh
from beamviz.solver.hp.refinement import solve_on
from beamviz.solver.problem import Problem

SPATIAL_GREEN = Problem()

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
        found = solve_on(mesh(breaks, (order,) * (len(breaks) - 1)), beam, 5, SPATIAL_GREEN, 1e-6)
        errors.append(abs(np.sqrt(found.omega_squared[-1]) / exact.frequencies[-1] - 1))
    seen = np.array(errors) > 1e-11
    assert errors[-1] < 1e-9
    ratios = np.array(errors[:-1]) / np.maximum(errors[1:], 1e-12)
    assert np.all(ratios[seen[:-1]] > 5)
