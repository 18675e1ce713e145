"""The command lines of the scripts: counts, durations, and errors in one line."""

import argparse
from typing import NoReturn


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


def duration(text: str) -> float:
    """The type of an argument that is a time [s]."""
    seconds = float(text)
    if not 0 < seconds < float("inf"):
        raise argparse.ArgumentTypeError(f"{text}: must be above 0, and finite")
    return seconds
