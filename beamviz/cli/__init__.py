"""The command line: data on stdout, messages on stderr, one exit code for each kind of failure."""

import contextlib
import json
import os
import re
import sys
import warnings
from collections.abc import Iterator
from itertools import pairwise
from typing import Any, TextIO

from beamviz.errors import (
    BeamvizError,
    ImplausibleInput,
    InvalidInput,
    LeftOut,
    NoAnswer,
    NoEquilibrium,
    NotConverged,
    nearest,
)
from beamviz.files import discard_unfinished, plain
from beamviz.signals import Terminated, terminate_on_signal

EXIT_CODES = {InvalidInput: 2, NoEquilibrium: 3, NoAnswer: 3, NotConverged: 4}
OTHER_FAILURE = 1


def main(arguments: list[str] | None = None) -> int:
    """Run a command line and return its exit code: 0 done, 1 any other failure, 2 invalid input, 3
    no equilibrium or no beam that meets a goal, 4 not converged, 130 interrupted, 143 terminated.

    arguments: by default those of this process, which a signal then ends within two seconds.
    """
    given = sys.argv[1:] if arguments is None else arguments
    for name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ[name] = "1"  # small matrices: more threads only wait for each other
    code = 0
    try:
        with terminate_on_signal(discard_unfinished if arguments is None else None):
            code = run(given or ["--help"])
            print(end="", flush=True)
    except Terminated as end:
        end.tell()
        return end.code
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or its last flush fails
        if isinstance(error, BrokenPipeError):  # a reader that leaves early has what it wants
            return code
        print(f"beamviz: {error}", file=sys.stderr)
        return OTHER_FAILURE
    return code


def run(arguments: list[str]) -> int:
    """Run a command and return its exit code; OSError passes, every other failure is reported."""
    import typer

    from beamviz.cli.commands import app

    try:
        with warnings_as_lines():
            return app(arguments, prog_name="beamviz", standalone_mode=False) or 0
    except BeamvizError as error:
        code = EXIT_CODES.get(type(error), OTHER_FAILURE)
        details: dict[str, Any] = {}
        if isinstance(error, NoEquilibrium):
            details = {"limit": error.limit}
        elif isinstance(error, NoAnswer) and error.best is not None:
            details = {"best": error.best.free}
        message = error.for_command_line if isinstance(error, InvalidInput) else str(error)
        return report(code, error.kind, message, arguments, **details)
    except typer.TyperException as error:
        return report(error.exit_code, InvalidInput.kind, message_of(error), arguments)
    except OSError:
        raise
    except SystemExit as end:
        if isinstance(end.__context__, BrokenPipeError):  # typer and rich exit where a pipe breaks
            raise end.__context__ from None
        return int(end.code or 0)  # of --show-completion
    except Exception as error:
        message = f"unexpected {type(error).__name__}: {error}"
        return report(OTHER_FAILURE, "internal", message, arguments)


def message_of(error: Any) -> str:
    """The message of a typer.TyperException; for a mistyped choice with the nearest one."""
    message = error.format_message()
    if match := re.search("'([^']*)' is not one of (.*)[.]$", message):
        near = nearest(match[1], re.findall("'(.*?)'", match[2]))
        message += f" Did you mean {near!r}?" if near else ""
    return message


@contextlib.contextmanager
def warnings_as_lines() -> Iterator[None]:
    """Within, a warning of an implausible value, or of what is left out, is one line on stderr."""
    with warnings.catch_warnings():
        for shown in (ImplausibleInput, LeftOut):
            warnings.simplefilter("always", shown)
        show = warnings.showwarning

        def show_line(
            message: Warning | str,
            category: type[Warning],
            filename: str,
            lineno: int,
            file: TextIO | None = None,
            line: str | None = None,
        ) -> None:
            if issubclass(category, (ImplausibleInput, LeftOut)):
                print(f"beamviz: warning: {message}", file=sys.stderr)
            else:
                show(message, category, filename, lineno, file, line)

        warnings.showwarning = show_line
        yield


def report(code: int, kind: str, message: str, arguments: list[str], **details: Any) -> int:
    """Report a failure: one line on stderr, and JSON on stdout with --format json."""
    line = " ".join(message.split())
    print(f"beamviz: {line}", file=sys.stderr)
    if "--format=json" in arguments or ("--format", "json") in pairwise(arguments):
        error = {"kind": kind, "message": line, **details}
        print(json.dumps({"error": plain(error)}))  # in ASCII, whatever the encoding of stdout
    return code
