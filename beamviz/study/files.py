"""Files that are complete, or not there."""

import os
from pathlib import Path

Files = dict[str, bytes]  # contents by name


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
