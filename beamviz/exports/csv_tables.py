"""The numbers of a solution as two CSV tables: its modes, and its equilibrium and shapes along the
beam.

Lines that begin with # state the beam, its model and its equilibrium; a table follows with one line
of heads, each with its unit in brackets: `pandas.read_csv(file, comment="#")`.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from beamviz.exports.arrays import stress_along
from beamviz.files import Files, csv_text, plain
from beamviz.output.solution import heading
from beamviz.solver.solution import Solution
from beamviz.version import __version__

SHAPES = ".shapes.csv"  # the end of the name of the second table
COMPONENTS = "along", "across"  # of positions and shapes
COMPONENTS_IN_SPACE = "along", "in plane", "out of plane"  # of shapes
STRESSES = {
    "axial_stress_pascals": "axial stress [Pa]",
    "bending_stress_pascals": "bending stress [Pa]",
}
LOADS = {"force": "EI/L^2", "shear": "EI/L^2", "moment": "EI/L"}  # of the section at the root


def csv_tables(path: Path, solution: Solution) -> Files:
    """The contents of the tables by their names: of both, or of the shapes alone where `path` is
    named so."""
    if path.name.lower().endswith(SHAPES):
        return {path.name: shape_table(solution)}
    second = path.with_suffix(SHAPES).name
    return {path.name: mode_table(solution, second), second: shape_table(solution)}


def mode_table(solution: Solution, second: str) -> bytes:
    """One line for each mode; `second`: the name of the other table."""
    modes, units = solution.columns, solution.beam.units
    per_time = {
        "frequency": modes["frequency"],
        "error": modes["error"],
        "growth rate": modes["growth_rate"],
    }
    columns = {"mode": modes["index"], "label": modes["label"], "family": modes["family"]}
    columns |= {f"{name} [1/T*]": values for name, values in per_time.items()}
    if units:
        columns["frequency [Hz]"] = units.hertz(modes["frequency"])
        columns["error [Hz]"] = units.hertz(modes["error"])
        columns["frequency [rad/s]"] = units.angular_frequency(modes["frequency"])
        columns["growth rate [1/s]"] = units.angular_frequency(modes["growth_rate"])
    columns["bending fraction"] = modes["bending_fraction"]
    if "in_plane_fraction" in modes:
        columns["fraction in the plane of rotation"] = modes["in_plane_fraction"]
    columns["nodes [x/L]"] = [" ".join(map(repr, at.tolist())) for at in modes["nodes"]]
    return table(solution, f"Shapes and equilibrium along the beam: {second}", columns)


def shape_table(solution: Solution) -> bytes:
    """One line for each place along the beam: the equilibrium, the loads, and the shape of each
    mode, of unit modal mass; with Coriolis forces also its imaginary part."""
    line, units = solution.along_beam, solution.beam.units
    columns: dict[str, Any] = {"x [L]": line["x"]}
    for name, values in zip(COMPONENTS, line["position"].T, strict=True):
        columns[f"position {name} [L]"] = values
    columns["stretch"] = line["stretch"]
    columns |= {f"{name} [{unit}]": line[name] for name, unit in LOADS.items()}
    if units:
        columns["x [m]"] = units.length * line["x"]
        for name, values in zip(COMPONENTS, line["position"].T, strict=True):
            columns[f"position {name} [m]"] = units.length * values
        if units.force is not None:
            columns["force [N]"] = units.newtons(line["force"])
            columns["shear [N]"] = units.newtons(line["shear"])
            columns["moment [N m]"] = units.newton_metres(line["moment"])
        stress = stress_along(solution, line["x"])
        columns |= {STRESSES[name]: values for name, values in stress.items()}
    for label, shape in zip(solution.labels, line["shape"], strict=True):
        components = COMPONENTS if shape.shape[1] == 2 else COMPONENTS_IN_SPACE
        for name, values in zip(components, shape.T, strict=True):
            columns[f"{label} {name}"] = values.real
            if np.iscomplexobj(values):
                columns[f"{label} {name}, imaginary"] = values.imag
    return table(solution, "Shapes have unit modal mass, in units of 1/sqrt(rho A L)", columns)


def table(solution: Solution, note: str, columns: Mapping[str, Any]) -> bytes:
    """A table below what it is of; empty where a number is not finite."""
    lines = [f"beamviz {__version__}", *heading(solution), note]
    if numbers := {k: v for k, v in solution.beam.si.items() if isinstance(v, float)}:
        given = ", ".join(f"{name} = {value:.12g}" for name, value in numbers.items())
        lines.insert(2, f"In SI        {given}")
    rows = zip(*(plain(values) for values in columns.values()), strict=True)
    comments = "".join(f"# {line}\n" for line in lines)
    return (comments + csv_text(columns, rows)).encode()
