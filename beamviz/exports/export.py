"""A scene as a file for others: a page, a model, numbers."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from beamviz.exports.gltf_model import write_glb
from beamviz.exports.html_page import write_html
from beamviz.exports.solved_scene import Shot
from beamviz.files import check_suffix, replaced
from beamviz.output import field_arrays, fields_csv
from beamviz.scene import Scene


def write_csv(file: Path, shot: Shot) -> None:
    """The fields of every mode along the beam."""
    file.write_text(fields_csv(shot.solution))


def write_npz(file: Path, shot: Shot) -> None:
    """The same as arrays."""
    arrays: dict[str, Any] = field_arrays(shot.solution)
    with file.open("wb") as stream:  # given a path, numpy would add a suffix
        np.savez_compressed(stream, **arrays)


WRITERS: dict[str, Callable[[Path, Shot], None]] = {
    ".html": write_html,
    ".glb": write_glb,
    ".csv": write_csv,
    ".npz": write_npz,
}


def export(path: str | Path, scene: Scene) -> None:
    """Write a scene as .html (one page with film, chart and table that needs no network), .glb
    (an animated model), .csv or .npz (frequencies, shapes and equilibrium), by the ending.

    Raises InvalidInput, Unavailable, and what `solve` raises; the file is either complete or
    untouched.
    """
    path = Path(path)
    write = WRITERS[check_suffix(path, tuple(WRITERS))]
    with replaced(path) as file:
        write(file, Shot.of(scene))
