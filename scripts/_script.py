"""What the scripts that measure share, imported before numpy: the environment of the tests, one
thread, the modules of the project and of its tests, and command lines with errors in one line."""

import argparse
import os
import subprocess
import sys
from collections.abc import Callable, Collection
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NoReturn

FOLDER = Path(__file__).resolve().parent
ROOT = FOLDER.parent
OF_THE_TESTS = ("mpmath", "pdoc", "viser")  # where these are, all is that the tests need


def use_environment() -> None:
    """Run a script again in the environment of the tests, made if needed, where this Python lacks
    what the scripts need."""
    script = Path(getattr(sys.modules["__main__"], "__file__", None) or "").resolve()
    if script.parent != FOLDER or all(map(find_spec, OF_THE_TESTS)):
        return
    from _environment import ensure

    command = [str(ensure("test")), str(script), *sys.argv[1:]]
    if os.name == "nt":  # there exec leaves the terminal before the script ends
        sys.exit(subprocess.run(command, check=False).returncode)
    os.execv(command[0], command)


use_environment()
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # a solve is measured, not its threads' waits
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]


def print_row(name: str, *cells: Any) -> None:
    """A line of a table: a name and its values or their headings, numbers to four digits."""
    texts = (f"{cell:.4g}" if isinstance(cell, float) else str(cell) for cell in cells)
    print(f"{name:40}" + "".join(f"{text:>14}" for text in texts), flush=True)


class Parser(argparse.ArgumentParser):
    """A parser whose help is the docstring of the script."""

    def __init__(self, text: str | None):
        super().__init__(description=text, formatter_class=argparse.RawTextHelpFormatter)

    def error(self, message: str) -> NoReturn:
        """End the script with one line, without the usage."""
        self.exit(2, f"{self.prog}: {message}\n")


def count(text: str) -> int:
    """The type of an argument that counts something."""
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text}: must be at least 1")
    return number


def one_of(names: Collection[str]) -> Callable[[str], str]:
    """The type of an argument that names one of some things. (`choices` of argparse refuses that an
    argument of any number is left out.)"""

    def named(text: str) -> str:
        if text not in names:
            raise argparse.ArgumentTypeError(f"{text}: must be one of {', '.join(names)}")
        return text

    return named
