"""A fixed sample of random inputs: each gives an answer or an error that names the input."""

import pytest
from fuzzing import CASES
from hypothesis import HealthCheck, given, settings

EXAMPLES = {"Beam": 300, "TOML": 300, "solve": 60, "loci": 40, "loci, wild": 12}


@pytest.mark.parametrize("name", CASES)
def test_every_input_has_an_outcome(name):
    """scripts/fuzz.py draws many more of the same kind."""
    check, strategies = CASES[name]
    quiet = [HealthCheck.too_slow, HealthCheck.data_too_large]
    drawn = settings(
        max_examples=EXAMPLES.get(name, 80), database=None, suppress_health_check=quiet
    )
    drawn(given(*strategies)(check))()
