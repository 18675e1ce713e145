"""Files that are either complete or not there."""

import contextlib
import os
from collections.abc import Iterator, Sequence
from pathlib import Path

from beamviz.errors import InvalidInput, Unavailable


def ending(path: Path, endings: Sequence[str]) -> str:
    """The ending of a path, ".png" say; InvalidInput where it is none of `endings`."""
    if path.suffix.lower() not in endings:
        *others, last = endings
        listed = f"{', '.join(others)} or {last}" if others else last
        raise InvalidInput(f"{path}: must end in {listed}")
    return path.suffix.lower()


@contextlib.contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """A temporary file beside `path`, with its ending, that takes its place once it is complete.

    Raises Unavailable where it cannot be written, be it at once or after a while (a full disk).
    """
    if path.is_dir():
        raise Unavailable(f"cannot write {path}: it is a folder")
    part = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    try:
        part.open("xb").close()
        yield part
        part.replace(path)
    except OSError as error:
        raise Unavailable(
            f"cannot write {path}: {error.strerror or error}; choose another place"
        ) from None
    finally:
        with contextlib.suppress(OSError):  # where it could not be written, it is not
            part.unlink()
