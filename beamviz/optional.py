"""Packages that only some features need."""

from importlib import import_module
from typing import Any

from beamviz.errors import Unavailable


def optional(package: str, extra: str) -> Any:
    """A package of an optional extra; Unavailable names the extra where it is not installed."""
    try:
        return import_module(package)
    except ImportError as error:
        raise Unavailable(
            f"this needs {package}: pip install 'beamviz[{extra}]' ({error})"
        ) from None
