"""Marks for parts of a parametrised test."""

from typing import Any

import pytest


def slow(*values: Any) -> list[Any]:
    """Parameters of which the tests are marked slow."""
    return [pytest.param(value, marks=pytest.mark.slow) for value in values]
