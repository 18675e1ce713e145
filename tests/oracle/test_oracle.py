"""The oracle itself: the extremes, and the refusal of what is not resolved.

Independent values, published tables, closed forms and limits are held against the solver
(tests/evidence/paper, tests/solver), and the solver against the oracle
(tests/solver/test_error_bars.py).
"""

import numpy as np
import pytest

from beamviz.beam import Beam
from oracle import truth
from oracle.eigen import UnresolvedError
from oracle.equilibrium import Resolution


@pytest.mark.slow
@pytest.mark.parametrize(
    ("beam", "curvature"),
    [
        (Beam(alpha=100, beta=0.5, gamma=200, delta=20, mu=40), "material"),
        (Beam(alpha=0, beta=1, gamma=50, delta=20, mu=10), "spatial"),
        (Beam(alpha=100, beta=0.999, gamma=200, delta=0, mu=40), "spatial"),
        (Beam(alpha=1, beta=0.001, gamma=200, delta=20, mu=10000), "material"),
    ],
)
def test_extremes_are_resolved(beam, curvature):
    """Stretch up to 50, layers down to 1e-7, omega a thousandth of gamma: still 1e-9."""
    found = truth(beam, curvature=curvature)
    assert np.all(found.differences <= 1e-9 * found.frequencies)


def test_too_coarse_a_resolution_is_refused():
    """Two resolutions that disagree raise, they return nothing."""
    coarse = Resolution(4, 4.0, 20.0), Resolution(5, 4.0, 20.0)
    with pytest.raises(UnresolvedError):
        truth(Beam(alpha=1, beta=0.3, gamma=50, delta=1), resolutions=coarse)
