"""Small files that describe a beam or a scene: their text, and TOML."""

import contextlib
import re
import tomllib
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from beamviz.errors import InvalidInput, did_you_mean

MAX_TOML_BYTES = 64_000


def read_small(path: str | Path, most: int = MAX_TOML_BYTES) -> bytes:
    """The start of a file, a byte more than the most it may have; InvalidInput if unreadable."""
    try:
        with Path(path).open("rb") as file:
            return file.read(most + 1)
    except (OSError, ValueError) as error:  # ValueError: of a null character in the name
        raise InvalidInput(f"{path}: {getattr(error, 'strerror', None) or error}") from None


def decoded(text: bytes, name: str, kind: str, most: int = MAX_TOML_BYTES) -> str:
    """The text of a file called `name`; InvalidInput if it is too large or not in UTF-8."""
    if len(text) > most:
        raise InvalidInput(f"{name}: larger than {most} bytes, not a file of beamviz")
    try:
        return text.decode("utf-8-sig")  # some editors write a byte-order mark
    except ValueError as error:
        raise InvalidInput(f"{name}: not a {kind} file ({error})") from None


def parse_toml(text: bytes, name: str) -> dict[str, Any]:
    """The contents of a TOML file called `name`; InvalidInput if it is too large or not TOML."""
    try:
        return tomllib.loads(decoded(text, name, "TOML"))
    except (ValueError, RecursionError) as error:
        if isinstance(error, InvalidInput):
            raise
        raise InvalidInput(f"{name}: not a TOML file ({error})") from None


@contextlib.contextmanager
def errors_of_file(name: str, units: Mapping[str, str] | None = None) -> Iterator[None]:
    """Within, the errors of values name the file they are from, and the units of their keys."""
    known = units or {}

    def with_unit(key: re.Match[str]) -> str:
        return f"{key[0]} [{known[key[0]]}]" if key[0] in known else key[0]

    try:
        yield
    except InvalidInput as error:
        message = error.args[0].removeprefix(f"{name}: ")
        text = re.sub(r"(?:(?<=^)|(?<=[:;] ))[a-z_]+(?= = )", with_unit, message)
        raise InvalidInput(f"{name}: {text}", error.use) from None


def check_keys(data: Collection[str], keys: Collection[str], source: str) -> None:
    """InvalidInput for the first key of `data` that is not among `keys`."""
    unknown = sorted(set(data) - set(keys))
    if unknown:
        hint = did_you_mean(unknown[0], keys)
        raise InvalidInput(f"{source}: unknown key {unknown[0]!r}; known: {', '.join(keys)}{hint}")
