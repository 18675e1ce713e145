"""Files that are written completely or not at all, and the files of packages."""

import contextlib
import os
import tempfile
from collections.abc import Iterator, Sequence
from importlib import resources
from pathlib import Path

from beamviz.errors import InvalidInput, Unavailable

Files = dict[str, bytes]  # contents by name


def package_text(*paths: str) -> str:
    """The texts of files of this package, one after the other."""
    folder = resources.files("beamviz")
    return "".join(folder.joinpath(path).read_text(encoding="utf-8") for path in paths)


def check_suffix(path: str | Path, suffixes: Sequence[str]) -> str:
    """The suffix of a path in lower case, as ".png"; InvalidInput where it is not in `suffixes`."""
    suffix = Path(path).suffix.lower()
    if suffix not in suffixes:
        *others, last = suffixes
        choices = f"{', '.join(others)} or {last}" if others else last
        raise InvalidInput(f"{path}: must end in {choices}")
    return suffix


@contextlib.contextmanager
def replaced(path: str | Path) -> Iterator[Path]:
    """A temporary file beside `path`, of the same suffix, renamed to `path` once it is complete.

    Raises Unavailable where it cannot be written, at once or later (a full disk).
    """
    path = Path(path)
    if path.is_dir():
        raise Unavailable(f"cannot write {path}: it is a folder")
    part = temporary(path)
    try:
        part.open("xb").close()
        yield part
        part.replace(path)
    except OSError as error:
        raise Unavailable(
            f"cannot write {path}: {error.strerror or error}; choose another place"
        ) from None
    finally:
        with contextlib.suppress(OSError):  # it was renamed, or never there
            part.unlink()


def temporary(path: Path) -> Path:
    """The name of a hidden file of this process beside `path`."""
    return path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")


def make_folder(folder: Path) -> None:
    """Create a folder, unless it is there; Unavailable where it cannot be written to."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise Unavailable(
            f"cannot write to {folder}: {error.strerror or error}; name another folder"
        ) from None


def write_files(folder: Path, contents: Files) -> None:
    """Write files by name; each appears under its name only when all are complete."""
    with contextlib.ExitStack() as complete:
        for name, content in contents.items():
            complete.enter_context(replaced(folder / name)).write_bytes(content)
