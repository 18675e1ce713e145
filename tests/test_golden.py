"""Answers of today beside converged ones of an earlier version: see `golden`."""

import pytest
from golden.answers import Record, call_of, read
from golden.differences import rows_of
from helpers import slow

EVERY = 3  # one in so many of a kind, and all short motions, are for every test run
LONG = {  # more than a tenth of a second
    *(f"deflected {k}" for k in (1, 5, 7, 9, 13)),
    *(f"deflected blades {k}" for k in (5, 8, 11, 23, 32, 35, 38, 41)),
    *("deflected blades, soft, 3 modes", "deflected blades, dip, 3 modes", "limits 14"),
    *(f"motion, {name}" for name in ("catch", "buckled", "modes", "drop", "hub")),
}


def by_speed() -> tuple[list[Record], list[Record]]:
    """The cases for every test run, and the others."""
    quick, others, counts = list[Record](), list[Record](), dict[str, int]()
    for case in read():
        kind = case["kind"]
        place = counts[kind] = counts.get(kind, -1) + 1
        is_quick = case["name"] not in LONG and (kind == "motions" or place % EVERY == 0)
        (quick if is_quick else others).append(case)
    return quick, others


QUICK, OTHERS = by_speed()


@pytest.mark.parametrize("case", [*QUICK, *slow(*OTHERS)], ids=lambda case: case["name"])
def test_an_answer_is_the_converged_one(case):
    """Frequencies, errors, labels, shapes, states, limits, events and motions, each within what is
    allowed."""
    beyond = [row for row in rows_of(case) if not row.ratio <= 1]
    assert not beyond, f"{call_of(case)}: {beyond}"
