"""The log has one line for each kind of error, whatever a visitor does."""

import logging
from unittest import mock

from beamviz.server.log import INTERVAL, MAX_KINDS, RateLimitedLog


def test_repeated_errors_are_one_line_and_a_count(monkeypatch, caplog):
    """Other visitors and other errors have lines of their own; after a while there is another line.
    A text with line breaks is one line. The memory is limited: errors are forgotten, so that some
    lines are written again."""
    clock = mock.Mock(return_value=1000.0)
    monkeypatch.setattr("beamviz.server.log.time.monotonic", clock)
    log = RateLimitedLog("a test")
    for _ in range(5000):
        log.warn("visitor 1", "ValueError", "ignored: rubber")
    log.warn("visitor 1", "TypeError", "ignored: two\nlines\r\nof it")
    log.warn("visitor 2", "ValueError", "ignored: rubber")
    clock.return_value += INTERVAL
    log.warn("visitor 1", "ValueError", "ignored: gum")
    assert [record.getMessage() for record in caplog.records] == [
        "visitor 1: ignored: rubber",
        "visitor 1: ignored: two lines of it",
        "visitor 2: ignored: rubber",
        "visitor 1: ignored: gum (4999 more like this since the last line)",
    ]
    with log.muted():
        for k in range(3 * MAX_KINDS):
            log.warn(f"visitor {k}", "text", "ignored")
    assert len(log.reported) <= MAX_KINDS


def test_an_internal_error_is_one_line_with_its_traceback_at_level_debug(caplog):
    """At other levels only the line."""
    log = RateLimitedLog("a test")
    for level in (logging.INFO, logging.DEBUG):
        with caplog.at_level(level, "a test"):
            log.error("chart", "a beam", ZeroDivisionError("by zero"))
    line, traceback = caplog.records
    assert line.getMessage() == "chart: failed for a beam: ZeroDivisionError('by zero')"
    assert traceback.exc_info
