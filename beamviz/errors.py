"""Exceptions: invalid input, no equilibrium, no convergence, something outside unavailable."""

import contextlib
from collections.abc import Collection, Iterator, Mapping
from typing import Any, TypeVar

E = TypeVar("E", bound=BaseException)


class BeamvizError(Exception):
    """Base class of the errors of this package."""

    kind = "error"


class InvalidInput(BeamvizError, ValueError):
    """Invalid input; the message names it, its value and the values allowed.

    use: options, and values of them, that a message advises. It is in the syntax of Python; the
    command line writes it in its own (`advice`).
    """

    kind = "invalid-input"

    def __init__(self, message: str, use: Mapping[str, Collection[str]] | None = None):
        super().__init__(message)
        self.use = use or {}

    def __str__(self) -> str:
        return super().__str__() + self.advice("{}={!r}")

    def advice(self, form: str) -> str:
        """The options that the message advises, each in a form of its name and its value."""
        texts = [form.format(name, value) for name, values in self.use.items() for value in values]
        return f"; use {' or '.join(texts)}" if texts else ""

    @property
    def for_command_line(self) -> str:
        """The message with options as the command line has them."""
        return super().__str__() + self.advice("--{} {}").replace("_", "-")


class ImplausibleInput(UserWarning):
    """A warning: a value in SI is possible, but likely in another unit; the message names which."""


class LeftOut(UserWarning):
    """A warning: a file has what the model leaves out; the message says what."""


class NoEquilibrium(BeamvizError):
    """No equilibrium; `limit`: the largest gamma with one, nan if unknown or not the reason."""

    kind = "no-equilibrium"

    def __init__(self, message: str, limit: float):
        super().__init__(message)
        self.limit = limit

    def __reduce__(self) -> tuple[type, tuple[str, float]]:  # for pickling
        return type(self), (str(self), self.limit)


class NoAnswer(BeamvizError):
    """No beam meets the goal of `adjust`; `best`: the `Adjusted` beam that comes nearest to it."""

    kind = "no-answer"

    def __init__(self, message: str, best: Any = None):
        super().__init__(message)
        self.best = best

    def __reduce__(self) -> tuple[type, tuple[str, Any]]:  # for pickling
        return type(self), (str(self), self.best)


class NotConverged(BeamvizError):
    """The solver did not converge; the message names what was tried."""

    kind = "not-converged"


class Unavailable(BeamvizError):
    """A port, a browser, a program or a path is missing or cannot be used."""

    kind = "unavailable"


class Cancelled(Exception):
    """A calculation was cancelled. Not a BeamvizError, which a solver may take for an outcome."""

    kind = "cancelled"


def to_keep(error: E) -> E:
    """An error that is kept as an answer: without the frames in which it, and those that it
    followed, were raised. Their matrices would be kept as well: of a deflected blade several
    megabytes for each error."""
    raised: BaseException | None = error
    while raised is not None:
        raised.__traceback__ = None
        raised = raised.__context__
    return error


def unknown_keyword(
    kind: str,
    name: str,
    known: Collection[str],
    synonyms: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
) -> InvalidInput:
    """The error of a mistyped keyword: it names the nearest one, or all where none is near.

    synonyms: known keywords by other names for them; units: of known keywords.
    """
    others, units = synonyms or {}, units or {}
    near = nearest(name, [*known, *others])
    meant = others.get(near, near)
    unit = f" [{units[meant]}]" if meant in units else ""
    hint = f"did you mean {meant!r}{unit}?" if near else f"known: {', '.join(known)}"
    return InvalidInput(f"unknown {kind} {name!r}: {hint}")


def nearest(name: str, known: Collection[str]) -> str:
    """The known name nearest to a mistyped one; "" where none is near. One with another number is
    another thing: fig13 is not near fig3."""
    import difflib

    def number(text: str) -> str:
        return "".join(filter(str.isdigit, text))

    by_lower = {word.lower(): word for word in known if number(word) in ("", number(name))}
    near = difflib.get_close_matches(name.lower(), by_lower, n=1, cutoff=0.6)
    return by_lower[near[0]] if near else ""


def did_you_mean(name: object, known: Collection[str]) -> str:
    """The end of a message about a mistyped name, "" where no known one is near."""
    near = nearest(name, known) if isinstance(name, str) else ""
    return f"; did you mean {near!r}?" if near else ""


@contextlib.contextmanager
def requires(extra: str) -> Iterator[None]:
    """Around imports of an optional extra: Unavailable with the command that installs it where it
    is not."""
    try:
        yield
    except ImportError as error:
        from beamviz.installation import install_command

        command = install_command(extra, str(error.name))
        raise Unavailable(f"this needs {error.name}: {command} ({error})") from None
