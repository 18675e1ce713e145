"""The log has one line for each kind of error, whatever a visitor does."""

import logging

import pytest

from beamviz.server import log as log_module
from beamviz.server.log import INTERVAL, MAX_KINDS, RateLimitedLog


@pytest.fixture
def clock(monkeypatch) -> list[float]:
    """The time [s], to be set."""
    now = [1000.0]
    monkeypatch.setattr(log_module.time, "monotonic", lambda: now[0])
    return now


def test_repeated_errors_are_one_line_and_a_count(clock, caplog):
    """Other visitors and other errors have lines of their own; after a while there is another line.
    A text with line breaks is one line."""
    log = RateLimitedLog("a test")
    for _ in range(5000):
        log.warn("visitor 1", "ValueError", "ignored: rubber")
    log.warn("visitor 1", "TypeError", "ignored: two\nlines\r\nof it")
    log.warn("visitor 2", "ValueError", "ignored: rubber")
    clock[0] += INTERVAL
    log.warn("visitor 1", "ValueError", "ignored: gum")
    assert [record.getMessage() for record in caplog.records] == [
        "visitor 1: ignored: rubber",
        "visitor 1: ignored: two lines of it",
        "visitor 2: ignored: rubber",
        "visitor 1: ignored: gum (4999 more like this since the last line)",
    ]


def test_the_memory_of_the_log_is_limited():
    """Errors are forgotten, so that some lines are written again."""
    log = RateLimitedLog("a silent test")
    with log.muted():
        for k in range(3 * MAX_KINDS):
            log.warn(f"visitor {k}", "text", "ignored")
    assert len(log.reported) <= MAX_KINDS


def test_an_internal_error_is_one_line_with_its_traceback_at_level_debug(caplog):
    """At other levels only the line."""
    log, error = RateLimitedLog("a test"), ZeroDivisionError("division by zero")
    with caplog.at_level(logging.INFO, "a test"):
        log.error("chart", "a beam", error)
    (record,) = caplog.records
    assert record.getMessage() == "chart: failed for a beam: ZeroDivisionError('division by zero')"
    with caplog.at_level(logging.DEBUG, "a test"):
        log.error("chart", "a beam", error)
    assert caplog.records[-1].exc_info
