"""A fixed sample of random inputs: each gives an answer or an error that names the input."""

import pytest
from fuzzing import CASES
from hypothesis import HealthCheck, example, given, settings

from beamviz.beam import Beam

EXAMPLES = {"Beam": 300, "TOML": 300, "solve": 60, "loci": 40, "loci, wild": 12}

# What once broke the rule.
HEAVY = Beam(alpha=4, gamma=37, delta=2.66, mu=115)
BUCKLED = Beam(alpha=100, beta=0.2, delta=-2, mu=10000)
FOUND = {
    "solve": [
        (Beam(alpha=83, beta=0.8125, gamma=25, mu=10), {}),
        (Beam(gamma=92, beta=0, delta=-2, mu=264), {"method": "ancf"}),
    ],
    "solve, odd keywords": [(Beam(mu=10), {"elements": "\n"})],
    "loci": [((HEAVY, "beta", (0.0, 1.0)), 5, 1, {"strain": "hencky"})],
    "loci, wild": [((BUCKLED, "gamma", (0.0, 200.0)), 5, 1, {})],
    "loci, odd ranges": [(Beam(mu=10), "alpha", 10**400)],
}


@pytest.mark.parametrize("name", CASES)
def test_every_input_has_an_outcome(name):
    """Those found, and a few more; scripts/fuzz.py draws many of the same kind."""
    check, strategies = CASES[name]
    quiet = [HealthCheck.too_slow, HealthCheck.data_too_large]
    drawn = settings(
        max_examples=EXAMPLES.get(name, 80), database=None, suppress_health_check=quiet
    )
    judged = given(*strategies)(check)
    for found in FOUND.get(name, ()):
        judged = example(*found)(judged)
    drawn(judged)()
