"""The formats that `export` writes a scene in, as a table; each writer imports what it needs.

A new format is a record here: `export`, the command line and its help have it from EXPORT_FORMATS.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

# path: of the file once it is complete; file: to write to until then; scene: a Scene. Returns the
# further files that were written.
Writer = Callable[[Path, Path, Any], list[Path]]


class ExportFormat(NamedTuple):
    """A format of a scene in a file."""

    suffix: str
    text: str  # what it is, for the help
    write: Writer


def write_html(path: Path, file: Path, scene: Any) -> list[Path]:
    from beamviz.exports import html_page
    from beamviz.exports.solved_scene import SolvedScene

    html_page.write_html(file, SolvedScene(scene))
    return []


def write_glb(path: Path, file: Path, scene: Any) -> list[Path]:
    from beamviz.exports import gltf
    from beamviz.exports.solved_scene import SolvedScene

    gltf.write_glb(file, SolvedScene(scene))
    return []


def write_csv(path: Path, file: Path, scene: Any) -> list[Path]:
    from beamviz.exports import beam_files
    from beamviz.exports.csv_tables import csv_tables
    from beamviz.files import write_files
    from beamviz.solver import solve

    if path.name.lower().endswith(beam_files.STATIONS):
        file.write_text(beam_files.stations_csv(scene.beam))
        return []
    solution = solve(scene.beam, **scene.solver_options)
    (_, content), *others = csv_tables(path, solution).items()
    write_files(path.parent, dict(others))
    file.write_bytes(content)
    return [path.with_name(name) for name, _ in others]


def write_toml(path: Path, file: Path, scene: Any) -> list[Path]:
    from beamviz.exports.beam_files import beam_toml

    file.write_text(beam_toml(scene.beam))
    return []


def write_npz(path: Path, file: Path, scene: Any) -> list[Path]:
    import numpy as np

    from beamviz.exports.arrays import field_arrays
    from beamviz.solver import solve

    solution = solve(scene.beam, **scene.solver_options)
    with file.open("wb") as stream:  # given a path, numpy would add a suffix
        np.savez_compressed(stream, **field_arrays(solution))
    return []


def write_dat(path: Path, file: Path, scene: Any) -> list[Path]:
    from beamviz.output.shape_polynomials import elastodyn_lines, shape_polynomials
    from beamviz.solver import solve

    solution = solve(scene.beam, **scene.solver_options)
    file.write_text("\n".join(elastodyn_lines(shape_polynomials(solution))) + "\n")
    return []


CSV_TEXT = (
    "the modes, and in a second file equilibrium and shapes; the stations of a beam in SI where the"
    " name ends with .stations.csv"
)
EXPORT_FORMATS = {
    row.suffix: row
    for row in (
        ExportFormat(".html", "a page with film, chart and table, without a network", write_html),
        ExportFormat(".glb", "an animated 3D model", write_glb),
        ExportFormat(".csv", CSV_TEXT, write_csv),
        ExportFormat(".toml", "a beam in SI, which --si reads", write_toml),
        ExportFormat(".npz", "the same as arrays", write_npz),
        ExportFormat(".dat", "the mode shapes of an ElastoDyn blade file", write_dat),
    )
}
