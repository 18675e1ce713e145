"""The log has one clear line for each kind of mistake, whatever a visitor does."""

import logging

import pytest

from beamviz.server import log as log_module
from beamviz.server.log import MOST, QUIET, RateLimitedLog


@pytest.fixture
def clock(monkeypatch) -> list[float]:
    """The time [s], to be set."""
    now = [1000.0]
    monkeypatch.setattr(log_module.time, "monotonic", lambda: now[0])
    return now


def test_a_flood_of_mistakes_is_one_line_and_a_count(clock, caplog):
    """Other visitors and other mistakes have lines of their own; after a while it comes again."""
    book = RateLimitedLog("a test")
    for _ in range(5000):
        book.warn("visitor 1", "ValueError", "ignored: rubber")
    book.warn("visitor 1", "TypeError", "ignored: []")
    book.warn("visitor 2", "ValueError", "ignored: rubber")
    clock[0] += QUIET
    book.warn("visitor 1", "ValueError", "ignored: gum")
    assert [record.getMessage() for record in caplog.records] == [
        "visitor 1: ignored: rubber",
        "visitor 1: ignored: []",
        "visitor 2: ignored: rubber",
        "visitor 1: ignored: gum (4999 more like this since the last line)",
    ]


def test_a_line_is_one_line(caplog):
    """Whatever a stranger wrote into it."""
    RateLimitedLog("a test").warn("visitor 1", "text", "ignored: two\nlines\r\nof it")
    assert [record.getMessage() for record in caplog.records] == [
        "visitor 1: ignored: two lines of it"
    ]


def test_visitors_without_end_do_not_fill_the_memory():
    """Their mistakes are forgotten, at worst to be said once more."""
    book = RateLimitedLog("a test that says nothing")
    book.logger.disabled = True
    for k in range(3 * MOST):
        book.warn(f"visitor {k}", "text", "ignored")
    assert len(book.reported) <= MOST


def test_where_a_mistake_of_ours_is_only_who_asks_is_told(caplog):
    """One line for who runs a server; the traceback on the level DEBUG."""
    book, error = RateLimitedLog("a test"), ZeroDivisionError("division by zero")
    with caplog.at_level(logging.INFO, "a test"):
        book.error("chart", "a beam", error)
    (record,) = caplog.records
    assert record.getMessage() == (
        "chart: failed for a beam: ZeroDivisionError('division by zero')"
    )
    with caplog.at_level(logging.DEBUG, "a test"):
        book.error("chart", "a beam", error)
    assert caplog.records[-1].exc_info
