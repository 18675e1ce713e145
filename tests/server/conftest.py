"""Tests of the server need visitors with a connection."""

from typing import Any

import pytest


@pytest.fixture
def guest(connected) -> Any:
    """A new visitor of the explorer of the file."""
    return connected


@pytest.fixture
def session(served) -> Any:
    """The session of `guest`."""
    return served
