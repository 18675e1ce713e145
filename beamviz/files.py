"""Contents of files as text, files that are written completely or not at all, package files."""

import contextlib
import csv
import io
import json
import math
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import is_dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from beamviz.errors import InvalidInput, Unavailable

Files = dict[str, bytes]  # contents by name
unfinished: set[Path] = set()  # temporary files that are being written


def json_text(data: Any, indent: int | None = 2) -> str:
    """Any data of `plain` as JSON."""
    return json.dumps(plain(data), indent=indent, allow_nan=False, ensure_ascii=False)


def plain(value: Any) -> Any:
    """A value in the types of JSON: records as dicts, arrays as lists, NaN and infinity as None."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    elif is_dataclass(value) and not isinstance(value, type):
        value = vars(value)
    elif hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def csv_text(heading: Iterable[str], rows: Iterable[Iterable[Any]]) -> str:
    """A heading and rows as CSV, floats with all their digits, None as an empty cell."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heading)
    writer.writerows(rows)
    return text.getvalue()


def markdown_table(heading: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = (heading, ["---"] * len(heading), *rows)
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


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
    check_writable(path)
    part = temporary(path)
    unfinished.add(part)
    try:
        with failing_to_write(path):
            part.open("xb").close()
            yield part
            part.replace(path)
    finally:
        discard(part)


def discard(part: Path) -> None:
    """Delete a temporary file or folder, unless it was renamed or was never there."""
    if part.is_dir():
        shutil.rmtree(part, ignore_errors=True)
    else:
        with contextlib.suppress(OSError):
            part.unlink()
    unfinished.discard(part)


def discard_unfinished() -> None:
    """Delete all temporary files, before the process ends while they are being written."""
    for part in [*unfinished]:
        discard(part)


def check_writable(path: Path) -> None:
    """Raises Unavailable where a file cannot be written, before its contents are computed."""
    if path.is_dir():
        raise Unavailable(f"cannot write {path}: it is a folder")
    with failing_to_write(path):
        part = temporary(path)
        part.open("xb").close()
        part.unlink()


@contextlib.contextmanager
def failing_to_write(path: Path) -> Iterator[None]:
    """Within, failures to write a file are Unavailable, with the remedy."""
    try:
        yield
    except OSError as error:
        raise Unavailable(
            f"cannot write {path}: {error.strerror or error}; choose another place"
        ) from None


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
