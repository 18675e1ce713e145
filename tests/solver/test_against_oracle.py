"""The solver against the oracle on random beams: its errors are within those that it reports.

The solver makes an energy stationary, the oracle collocates the differential equations; they share
`Beam` alone. Each comparison allows the solver's reported error and the oracle's own
self-difference, and nothing else.
"""

from typing import Any

import numpy as np
import pytest
from oracle import QUICK, Truth, truth
from oracle.equilibrium import NoStateError

from beamviz import Beam, Solution, solve
from beamviz.errors import NoEquilibrium

BEAMS, LAWFUL, CORIOLIS = 180, 40, 20
MODES = 5


def random_beam(rng: np.random.Generator) -> Beam:
    """Anywhere in the accepted range; corners and the usual places more often than by chance."""
    mu = 10 ** rng.uniform(1, 4)
    fastest = min(200.0, 5 * mu)
    gamma = rng.choice([rng.uniform(0, fastest), 10 ** rng.uniform(-2, np.log10(fastest)), fastest])
    alpha = rng.choice([10 ** rng.uniform(-3, 2), rng.uniform(0, 3), 0.0], p=[0.6, 0.3, 0.1])
    beta = rng.choice([rng.uniform(), 1.0, 0.0], p=[0.75, 0.2, 0.05])
    delta = rng.choice([rng.uniform(0, 20), 10 ** rng.uniform(-3, 1), 0.0], p=[0.5, 0.25, 0.25])
    return Beam(alpha, beta, gamma, delta, mu)


def random_model(rng: np.random.Generator) -> dict[str, Any]:
    return {
        "curvature": str(rng.choice(["spatial", "material"])),
        "plane": str(rng.choice(["chordwise", "flapwise"])),
    }


def assert_agree(solution: Solution, expected: Truth, tolerance: float) -> None:
    """Within the reported errors, and these within the tolerance."""
    off = np.abs(solution.frequencies - expected.frequencies)
    assert np.all(off <= solution.errors + expected.differences)
    assert np.all(solution.errors <= tolerance * solution.frequencies)


@pytest.mark.parametrize("seed", range(BEAMS))
def test_random_beams(seed):
    """Green, both planes and curvatures, tolerances 1e-3 .. 1e-8: frequencies and families."""
    rng = np.random.default_rng([1, seed])
    beam, model, tolerance = random_beam(rng), random_model(rng), 10 ** rng.uniform(-8, -3)
    solution = solve(beam, MODES, tolerance=tolerance, **model)
    expected = truth(beam, MODES, resolutions=QUICK, **model)
    assert_agree(solution, expected, tolerance)
    apart = np.diff(expected.frequencies) > 2 * tolerance * expected.frequencies[1:]
    if np.all(apart):
        assert solution.families == expected.families


@pytest.mark.parametrize("seed", range(LAWFUL))
def test_random_beams_of_other_strain_laws(seed):
    """Biot and hencky: the same frequencies where there is an equilibrium, and none alike."""
    rng = np.random.default_rng([2, seed])
    beam, model = random_beam(rng), random_model(rng) | {"strain": ("biot", "hencky")[seed % 2]}
    beam = beam.replace(gamma=min(beam.gamma, rng.uniform(0, 1.6) * beam.mu))
    try:
        expected = truth(beam, MODES, resolutions=QUICK, **model)
    except NoStateError:
        with pytest.raises(NoEquilibrium) as refusal:
            solve(beam, MODES, **model)
        assert 0 < refusal.value.limit < beam.gamma
    else:
        assert_agree(solve(beam, MODES, **model), expected, 1e-6)


@pytest.mark.parametrize("seed", range(CORIOLIS))
def test_random_beams_with_coriolis(seed):
    """Stretching and bending coupled in the plane of rotation."""
    rng = np.random.default_rng([3, seed])
    beam, curvature = random_beam(rng), str(rng.choice(["spatial", "material"]))
    solution = solve(beam, MODES, curvature=curvature, coriolis=True)
    expected = truth(beam, MODES, curvature=curvature, coriolis=True, resolutions=QUICK)
    assert_agree(solution, expected, 1e-6)
