"""Files that are complete, or not there."""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from beamviz.errors import Unavailable

Files = dict[str, bytes]  # contents by name


@contextlib.contextmanager
def writing_to(folder: Path) -> Iterator[None]:
    """Within, there is this folder; Unavailable, with the remedy, where it cannot be written to."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        raise Unavailable(
            f"cannot write to {folder}: {error.strerror or error}; name another folder"
        ) from None


def write(folder: Path, contents: Files) -> None:
    """Write files that belong together; each gets its name only when all are complete."""
    parts = {name: folder / f".{name}.{os.getpid()}.part" for name in contents}
    try:
        for name, part in parts.items():
            part.write_bytes(contents[name])
        for name, part in parts.items():
            part.replace(folder / name)
    finally:
        for part in parts.values():
            part.unlink(missing_ok=True)
