"""Exceptions: invalid input, no equilibrium, no convergence, something outside unavailable."""

from collections.abc import Collection
from importlib import import_module
from typing import Any


class BeamvizError(Exception):
    """Base class of the errors of this package."""

    kind = "error"


class InvalidInput(BeamvizError, ValueError):
    """Invalid input; the message names it, its value and the values allowed."""

    kind = "invalid-input"


class NoEquilibrium(BeamvizError):
    """No equilibrium; `limit`: the largest gamma with one, nan if unknown or not the reason."""

    kind = "no-equilibrium"

    def __init__(self, message: str, limit: float):
        super().__init__(message)
        self.limit = limit

    def __reduce__(self) -> tuple[type, tuple[str, float]]:  # for pickling
        return type(self), (str(self), self.limit)


class NotConverged(BeamvizError):
    """The solver did not converge; the message names what was tried."""

    kind = "not-converged"


class Unavailable(BeamvizError):
    """A port, a browser, a program or a path is missing or cannot be used."""

    kind = "unavailable"


class Cancelled(Exception):
    """A calculation was cancelled. Not a BeamvizError, which a solver may take for an outcome."""

    kind = "cancelled"


def unknown_keyword(kind: str, name: str, known: Collection[str]) -> InvalidInput:
    """The error of a mistyped keyword: it names the nearest one, or all where none is near."""
    import difflib

    near = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    hint = f"did you mean {near[0]!r}?" if near else f"known: {', '.join(known)}"
    return InvalidInput(f"unknown {kind} {name!r}: {hint}")


def optional(package: str, extra: str) -> Any:
    """A package of an optional extra; Unavailable names the extra where it is not installed."""
    try:
        return import_module(package)
    except ImportError as error:
        raise Unavailable(
            f"this needs {package}: pip install 'beamviz[{extra}]' ({error})"
        ) from None
