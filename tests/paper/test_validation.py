"""The validation page: every row holds, names a test that exists, and the page is current."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from beamviz.paper.validation import COMMAND, FILE, SOURCES, page

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "assets" / "validation.md"
CLAIMS = [claim for source in SOURCES for claim in source.claims]


@pytest.fixture(scope="module")
def tests_named():
    """Every test the page names."""
    text = PAGE.read_text(encoding="utf-8")
    rows = [f"{FILE}::{name}" for name in re.findall(r"\| `(test_\w+\[.+?\])` \|", text)]
    return rows, re.findall(r"`(tests/\w+/test_\w+\.py::\w+)`", text)


@pytest.mark.parametrize("claim", CLAIMS, ids=[claim.name for claim in CLAIMS])
def test_claim(claim):
    """The values computed are as close to the reference as the row allows."""
    _, off = claim.check()
    assert off <= claim.digits


def test_every_tolerance_above_a_digit_has_a_reason():
    """A loose row says why it is loose."""
    assert [claim.name for claim in CLAIMS if claim.digits > 1 and not claim.reason] == []


def test_the_page_is_current():
    """The page says what the program finds today."""
    assert PAGE.read_text(encoding="utf-8") == page(), f"run {COMMAND}"


def test_every_row_names_a_test_that_exists(tests_named):
    """pytest knows every test the page names, and every row of the page names one."""
    rows, others = tests_named
    assert len(rows) == len(CLAIMS)
    assert len(others) == sum(len(source.tests) for source in SOURCES)
    files = sorted({test.partition("::")[0] for test in (*rows, *others)})
    known = collected(files)
    assert set(rows) <= known
    assert set(others) <= {test.partition("[")[0] for test in known}


def collected(files: list[str]) -> set[str]:
    """The names of all tests in some files."""
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "--collect-only", "-q", *files],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    return set(done.stdout.splitlines())


def test_rows_have_names_of_their_own():
    """No two rows share a test."""
    names = [claim.name for claim in CLAIMS]
    assert len(set(names)) == len(names)


def test_tables_are_well_formed():
    """Every row of a table has as many cells as its heading."""
    for table in re.findall(r"(?:^\|.*\|\n)+", PAGE.read_text(encoding="utf-8"), re.MULTILINE):
        assert len({line.count("|") for line in table.splitlines()}) == 1
