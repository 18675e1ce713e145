"""How long the steps of an integration are."""

import numpy as np
import pytest

from beamviz.dynamics.controllers import AdaptiveSteps
from beamviz.dynamics.newton_step import Step

TOLERANCE = 1e-4
NONE = np.zeros(0)


def step(error: float) -> Step:
    """A step of four stages with an error [L]."""
    return Step(0.1, NONE, NONE, np.zeros((4, 0)), NONE, NONE, error)


@pytest.mark.parametrize(("excess", "taken"), [(0.1, True), (1.5, True), (10.0, False)])
def test_a_step_that_is_much_worse_than_the_tolerance_is_tried_again_shorter(excess, taken):
    """The next one is shorter wherever the error is above the tolerance."""
    steps = AdaptiveSteps(TOLERANCE)
    assert steps.takes(0.1, step(excess * TOLERANCE)) is taken
    assert (steps.length(0.0) < 0.1) is (excess > 1)


def test_a_step_that_fails_is_tried_again_shorter_and_the_next_ones_grow_slowly():
    """Where Newton's method has failed with a length it would fail again."""
    steps = AdaptiveSteps(TOLERANCE)
    assert not steps.takes(0.1, None)
    assert steps.length(0.0) == pytest.approx(0.05)
    assert steps.takes(0.05, step(1e-3 * TOLERANCE))
    assert 0.05 <= steps.length(0.05) < 0.06
