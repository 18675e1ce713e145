"""The oracle itself: values from elsewhere, the extremes, and the refusal of what is not resolved.

Published tables, closed forms and limits are held against the solver (tests/paper, tests/solver),
and the solver against the oracle (tests/solver/test_error_bars.py).
"""

import numpy as np
import pytest
from helpers import load_script

from beamviz.beam import Beam
from oracle import CURVATURE, FINE, Spectrum, truth
from oracle.eigen import UnresolvedError
from oracle.equilibrium import Resolution

validation = load_script("validation")


def numbers(table):
    """The rows of a table of the validation page, as numbers."""
    return [(beam, list(map(float, text.split()))) for beam, text in table.items()]


@pytest.mark.parametrize(("beam", "values"), numbers(validation.STRETCHED), ids=str)
def test_independent_values(beam, values):
    """Values computed independently of this project, to seven digits."""
    spectrum = Spectrum(beam, "green", "spatial", FINE[0])
    squares = [*spectrum.bending(4), spectrum.stretching(1)[0]]
    assert np.sqrt(squares) == pytest.approx(values, rel=1e-7)


@pytest.mark.parametrize(("beam", "values"), numbers(validation.STRETCHED_CORIOLIS), ids=str)
def test_independent_values_with_coriolis(beam, values):
    """The same with Coriolis forces."""
    found = truth(beam, len(values), coriolis=True).frequencies
    assert found == pytest.approx(values, rel=1e-7)


EXTREMES = [
    Beam(alpha=100, beta=1, gamma=200, delta=20, mu=40),
    Beam(alpha=100, beta=0.5, gamma=200, delta=20, mu=40),
    Beam(alpha=0, beta=1, gamma=200, delta=20, mu=40),
    Beam(alpha=0, beta=1, gamma=50, delta=20, mu=10),
    Beam(alpha=33, beta=0.57, gamma=124, delta=0, mu=25),
    Beam(alpha=100, beta=0.999, gamma=200, delta=0, mu=40),
    Beam(alpha=1, beta=0.001, gamma=200, delta=20, mu=10000),
]


@pytest.mark.slow
@pytest.mark.parametrize("curvature", CURVATURE)
@pytest.mark.parametrize("beam", EXTREMES, ids=str)
def test_extremes_are_resolved(beam, curvature):
    """Stretch up to 50, layers down to 1e-7, omega a thousandth of gamma: still 1e-9."""
    found = truth(beam, curvature=curvature)
    assert np.all(found.differences <= 1e-9 * found.frequencies)


def test_too_coarse_a_resolution_is_refused():
    """Two resolutions that disagree raise, they return nothing."""
    coarse = Resolution(4, 4.0, 20.0), Resolution(5, 4.0, 20.0)
    with pytest.raises(UnresolvedError):
        truth(Beam(alpha=1, beta=0.3, gamma=50, delta=1), resolutions=coarse)


@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize("beam", [Beam(0.7, 0.4, 2, -0.6, 40), Beam(0.7, 0.4, 9, -0.6, 40)])
def test_an_inward_beam_turns_into_an_outward_one(beam, coriolis):
    """All eigenvalues at once and the Arnoldi process for positive ones meet at delta = 0-."""
    inward, outward = (truth(beam.replace(delta=d), coriolis=coriolis) for d in (-1e-9, 0.0))
    assert inward.squares == pytest.approx(outward.squares, rel=1e-7)
