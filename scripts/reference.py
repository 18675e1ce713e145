"""The reference of the public Python names, a page for a browser:

    python3 scripts/reference.py [FOLDER]       by default build/reference, which is not committed

Like all scripts here it makes the environment of the tests if this Python has none of it. The
reference is made of the docstrings by pdoc. A warning of pdoc, as about an annotation that it
cannot read, is an error.
"""

import sys
import warnings
from pathlib import Path

import _script
from pdoc import render
from pdoc.doc import Module

import beamviz

FOLDER = _script.ROOT / "build" / "reference"


def write_reference(folder: Path) -> Path:
    """Write the page into a folder, made if needed; the file."""
    for name in beamviz.__all__:  # imported on first use, where pdoc does not look
        vars(beamviz)[name] = getattr(beamviz, name)
    render.configure(show_source=False, search=False)
    module = Module(beamviz)
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "beamviz.html"
    file.write_text(render.html_module(module, all_modules={"beamviz": module}), encoding="utf-8")
    return file


if __name__ == "__main__":
    parser = _script.Parser(__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=FOLDER)
    warnings.simplefilter("error")
    sys.stdout.write(f"{write_reference(parser.parse_args().folder)}\n")
