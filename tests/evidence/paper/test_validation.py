"""The validation page: every row holds, names a test that exists, and the page is current."""

import re
from functools import cache
from pathlib import Path

import pytest
from helpers import load_script

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "assets" / "validation.md"
validation = load_script("validation")
validation.Claim.check = cache(validation.Claim.check)  # a row and the page compute it once
CLAIMS = [claim for source in validation.SOURCES for claim in source.claims]


@pytest.mark.parametrize("claim", CLAIMS, ids=[claim.name for claim in CLAIMS])
def test_claim(claim):
    """As close to the reference as allowed; more than a unit of the last digit has a reason."""
    digits, reason = claim.tolerance
    assert claim.check()[1] <= digits
    assert digits <= 1 or reason


def test_the_page_is_current():
    """The page says what the program finds today."""
    assert PAGE.read_text(encoding="utf-8") == validation.page(), f"run {validation.COMMAND}"


def test_the_tests_named_exist():
    """Of each row and of each source, in their files; every tolerance belongs to a row."""
    text = PAGE.read_text(encoding="utf-8")
    names = [claim.name for claim in CLAIMS]
    assert re.findall(r"\| `test_claim\[(.+?)\]` \|", text) == names
    assert len(set(names)) == len(names)
    assert set(validation.LOOSE) <= set(names)
    tests = [test for source in validation.SOURCES for test in source.tests]
    assert re.findall(r"`(tests/\w+/test_\w+\.py::\w+)`", text) == tests
    for test in tests:
        file, _, name = test.partition("::")
        assert f"\ndef {name}(" in (ROOT / file).read_text(), test


def test_tables_are_well_formed():
    """Every row of a table has as many cells as its heading."""
    for table in re.findall(r"(?:^\|.*\|\n)+", PAGE.read_text(encoding="utf-8"), re.MULTILINE):
        assert len({line.count("|") for line in table.splitlines()}) == 1
