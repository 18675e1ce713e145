"""The distribution of this program, and the command that installs one of its extras.

The distribution is not called `beamviz`: on PyPI that is another program. The command is for the
Python that runs this. In a folder of the source it installs this folder again, with the extra;
elsewhere the libraries themselves.
"""

import re
import sys
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

DISTRIBUTION = "rotating-beam-explorer"
SOURCE = Path(__file__).resolve().parents[1]  # the folder of the source, where there is one


def install_command(extra: str, missing: str) -> str:
    """The command line that installs an extra; missing: the library of it that is not there."""
    pip = f"{quoted(sys.executable)} -m pip install"
    if is_source(SOURCE):
        return f'{pip} -e "{SOURCE}[{extra}]"'
    needed = sorted({*libraries(extra)}) or [missing]
    return " ".join([pip, *map(quoted, needed)])


def is_source(folder: Path) -> bool:
    """Whether a folder is one of this source that pip can install with an extra, which takes no
    brackets in its path."""
    project = folder / "pyproject.toml"
    named = project.is_file() and f'\nname = "{DISTRIBUTION}"' in project.read_text("utf-8")
    return named and not {"[", "]"} & {*str(folder)}


def libraries(extra: str) -> Iterator[str]:
    """The requirements of an extra of the installed distribution, as "zarr<4,>=3.1.2"."""
    try:
        lines = metadata.requires(DISTRIBUTION) or []
    except metadata.PackageNotFoundError:
        return
    for line in lines:
        requirement, _, marker = line.partition(";")
        if not re.search(f"""extra == ['"]{extra}['"]""", marker):
            continue
        extras = re.fullmatch(rf"{DISTRIBUTION}\[(.*)\]", requirement.strip())
        for inner in extras[1].split(",") if extras else ():
            yield from libraries(inner)
        if not extras:
            yield requirement.strip()


def quoted(word: str) -> str:
    """A word of a command line, in quotes where a shell needs them."""
    return word if re.fullmatch(r"[\w./:\\=~-]+", word) else f'"{word}"'
