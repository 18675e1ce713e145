"""A fixed sample of random inputs: each gives an answer or an error that names the input."""

import pytest
from fuzzing import CASES
from hypothesis import HealthCheck, example, given, settings

from beamviz.beam import Beam

# Inputs that once failed.
BUCKLED = Beam(alpha=100, beta=0.2, delta=-2, mu=10000)
FAILED = {
    "Beam": [({"alpha": 0.0, "beta": 0.0, "gamma": 0.0, "delta": 0.0, "mu": 10**400},)],
    "solve": [
        (Beam(alpha=83, beta=0.8125, gamma=25, mu=10), {}),
        (Beam(gamma=92, beta=0, delta=-2, mu=264), {"method": "ancf"}),
        (Beam(gamma=1e-155, delta=1), {"strain": "hencky"}),
    ],
    "solve, odd keywords": [(Beam(mu=10), {"elements": "\n"})],
    "loci": [
        ((Beam(alpha=50, beta=0.5, gamma=10, mu=85), "delta", (-2.0, 6.0)), 2, 3, {}),
    ],
    "loci, wild": [((BUCKLED, "gamma", (0.0, 200.0)), 5, 1, {})],
    "loci, odd ranges": [(Beam(mu=10), "alpha", 10**400)],
}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * (name == "loci, wild")) for name in CASES],
)
def test_every_input_has_an_outcome(name):
    """Those that once failed and a few more; scripts/fuzz.py draws many of the same kind."""
    case, quiet = CASES[name], [HealthCheck.too_slow, HealthCheck.data_too_large]
    checked = given(*case.strategies)(case.check)
    for inputs in FAILED.get(name, ()):
        checked = example(*inputs)(checked)
    drawn = settings(max_examples=case.examples, database=None, suppress_health_check=quiet)
    drawn(checked)()
