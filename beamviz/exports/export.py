"""A scene as a file for others: a page, a model, numbers."""

from collections.abc import Callable
from pathlib import Path

from beamviz.exports.files import ending, replaced
from beamviz.exports.gltf_model import write_glb
from beamviz.exports.html_page import write_html
from beamviz.exports.solved_scene import Shot
from beamviz.output_numbers import write_csv, write_npz
from beamviz.scene import Scene

WRITERS: dict[str, Callable[[Path, Shot], None]] = {
    ".html": write_html,
    ".glb": write_glb,
    ".csv": lambda file, shot: write_csv(file, shot.solution),
    ".npz": lambda file, shot: write_npz(file, shot.solution),
}


def export(path: str | Path, scene: Scene) -> None:
    """Write a scene as .html (one page with film, chart and table that needs no network), .glb
    (an animated model), .csv or .npz (frequencies, shapes and equilibrium), by the ending.

    Raises InvalidInput, Unavailable, and what `solve` raises; the file is either complete or
    untouched.
    """
    path = Path(path)
    write = WRITERS[ending(path, tuple(WRITERS))]
    with replaced(path) as file:
        write(file, Shot.of(scene))
