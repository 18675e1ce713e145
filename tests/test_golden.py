"""Answers of today beside converged ones of an earlier version: see `golden`."""

import pytest
from golden.answers import call_of, read
from golden.differences import rows_of


@pytest.mark.parametrize("case", read(), ids=lambda case: case["name"])
def test_an_answer_is_the_converged_one(case):
    """Frequencies, errors, labels, shapes, states, limits, events and motions, each within what is
    allowed."""
    beyond = [row for row in rows_of(case) if not row.ratio <= 1]
    assert not beyond, f"{call_of(case)}: {beyond}"
