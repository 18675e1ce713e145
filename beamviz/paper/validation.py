"""The validation page: every claim of accuracy, found again, with the test that holds it.

python -m beamviz.paper.validation > assets/validation.md
"""

from typing import NamedTuple

from beamviz.paper.claims import Claim, Source
from beamviz.paper.markdown import lines
from beamviz.paper.sources import SOURCES
from beamviz.paper.values import decimals

COMMAND = "python -m beamviz.paper.validation > assets/validation.md"
FILE = "tests/test_validation.py"
HEADING = ("case", "quantity", "reference", "found", "off by", "allowed", "test")
WHAT = (
    "Every claim of accuracy this program makes, row by row: a reference, published or computed"
    " independently of this program, and what this program finds, with one digit more. Frequencies"
    " are in units of 1/T* unless another unit is named. *Off by* and *allowed* count units of the"
    " last digit of the reference; of several numbers in a row the one farthest off counts."
)
HOW = (
    f"Each row is held by the test in its last column, of `{FILE}`; the tests named below a table"
    f" hold more than its rows. The page is written by `{COMMAND}`; a test fails where it is not up"
    " to date, and another where a test it names does not exist."
)


class Found(NamedTuple):
    """The values of a claim as shown, and how far off they are."""

    shown: tuple[str, ...]
    off: float  # units of the last digit published


def found(claim: Claim) -> Found:
    """What this program finds for a claim, rounded to one digit more than is published."""
    values = claim.find()
    shown = tuple(
        f"{value:.{decimals(text) + 1}f}"
        for text, value in zip(claim.reference, values, strict=True)
    )
    off = (
        abs(float(ours) - float(text)) * 10 ** decimals(text)
        for text, ours in zip(claim.reference, shown, strict=True)
    )
    return Found(shown, round(max(off), 1))


def page() -> str:
    """The whole page, in markdown."""
    parts = ["# Validation", WHAT, HOW]
    for source in SOURCES:
        parts += [f"## {source.title}", source.origin, "\n".join(_table(source)), *_more(source)]
    return "\n\n".join(parts) + "\n"


def _table(source: Source) -> list[str]:
    return lines(HEADING, [_row(claim) for claim in source.claims])


def _row(claim: Claim) -> list[str]:
    shown, off = found(claim)
    allowed = f"{claim.digits:g}" + (f" ({claim.reason})" if claim.reason else "")
    reference = ", ".join(claim.reference)
    test = f"`test_claim[{claim.name}]`"
    return [claim.case, claim.quantity, reference, ", ".join(shown), f"{off:.1f}", allowed, test]


def _more(source: Source) -> list[str]:
    """The tests that hold more than the rows."""
    return ["Also held by " + ", ".join(f"`{test}`" for test in source.tests) + "."]


if __name__ == "__main__":
    print(page(), end="")
