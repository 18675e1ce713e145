"""Declared and observed rates of convergence, as data."""

import numpy as np
import pytest

from beamviz.beam import Beam
from beamviz.solver import solve
from beamviz.solver.hp.mesh import mesh
from beamviz.solver.hp.refinement import solve_on
from beamviz.solver.problem import Problem

SPATIAL_GREEN = Problem()

# beam, mode (from 0), declared order in the element length h of the frequency's error.
# With an interior mass at speed the stretch jumps inside the space of shared gradients: order 1.
ANCF_RATES = [
    (Beam(), 1, 4),
    (Beam(gamma=10), 2, 4),
    (Beam(alpha=1, gamma=10), 1, 4),
    (Beam(alpha=1, gamma=10, delta=1), 1, 4),
    (Beam(alpha=1, beta=0.5, gamma=10), 2, 1),
    (Beam(alpha=2, beta=0.25, gamma=20), 3, 1),
]


@pytest.mark.parametrize(("beam", "mode", "declared"), ANCF_RATES)
def test_the_papers_elements_converge_as_declared(beam, mode, declared):
    """The error halves declared times when the elements do."""
    exact = solve(beam, tolerance=1e-11)
    sizes = (20, 40, 80)
    errors = []
    for elements in sizes:
        solution = solve(beam, method="ancf", elements=elements)
        assert solution.labels[mode] == exact.labels[mode]
        errors.append(abs(solution.frequencies[mode] - exact.frequencies[mode]))
    observed = np.log2(np.array(errors[:-1]) / errors[1:])
    assert observed == pytest.approx(declared, abs=0.25)


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


def test_a_gradient_shared_across_the_mass_costs_three_digits():
    """The paper's 10, 20 and 40 elements against 76.86327 (physics.md 3.3), first order."""
    beam = Beam(alpha=1, beta=0.5, gamma=10)
    values = [solve(beam, method="ancf", elements=n).frequencies[2] for n in (10, 20, 40)]
    assert values == pytest.approx([77.0053, 76.9343, 76.8988], abs=5e-5)
    assert solve(beam).frequencies[2] == pytest.approx(76.86327, abs=5e-6)
