"""Time against error on a blade, of `auto` and of pyBModes.

The twisted blade of the NREL 5 MW turbine at its rated speed, both planes, six modes. pyBModes has
elements of constant properties, so its frequencies move irregularly as its mesh is refined. Each
program is compared with its own limit, its finest resolution: the two limits differ by 4e-4, by
how each one reads a table between its stations.
"""

import math
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.plotting import STYLE, new_figure
from beamviz.presets import preset
from beamviz.solver import solve

PRESET, MODES = "nrel-5mw-twisted-blade", 6
PYBMODES = "pyBModes"
TOLERANCES, LIMIT_TOLERANCE = (1e-2, 1e-3, 1e-4, 1e-6, 1e-8), 1e-11
NODES, LIMIT_NODES = (25, 50, 100, 200, 400), 800
ROUNDING = 1e-12  # a smaller error is drawn as this
REPEATS = 5  # of which the fastest counts
LINES: dict[str, dict[str, Any]] = {
    "auto": {"color": "#0072B2", "lw": 2.4, "marker": "o"},
    PYBMODES: {"color": "#555555", "lw": 1.2, "marker": "s"},
}
MAIN_FILE = """\
------- ELASTODYN MAIN FILE ----------------------------------------------------
{title}
---------------------- TURBINE CONFIGURATION -----------------------------------
{tip:.10g} TipRad - tip [m]
{hub:.10g} HubRad - root [m]
0 PreCone(1) - [deg]
{rpm:.12g} RotSpeed - [rpm]
0 BlPitch(1) - [deg]
"{blade}" BldFile(1) - the blade
0 TipMass(1) - [kg]
"""
BLADE_FILE = """\
------- ELASTODYN BLADE FILE ---------------------------------------------------
{title}
---------------------- BLADE PARAMETERS ----------------------------------------
{count} NBlInpSt - stations
---------------------- BLADE ADJUSTMENT FACTORS --------------------------------
1 AdjBlMs - of the mass
1 AdjFlSt - of the flapwise stiffness
1 AdjEdSt - of the edgewise stiffness
---------------------- DISTRIBUTED BLADE PROPERTIES ----------------------------
BlFract StrcTwst BMassDen FlpStff EdgStff
(-) (deg) (kg/m) (Nm^2) (Nm^2)
{rows}
---------------------- BLADE MODE SHAPES ---------------------------------------
"""


class BladeRow(NamedTuple):
    """A solve of the blade: the error is the largest relative one of the frequencies."""

    name: str
    option: str
    resolution: float
    seconds: float  # of processor time
    error: float
    reason: str = ""  # why there is none


def measure() -> list[BladeRow]:
    """Rows of `auto` and of pyBModes; where that is not installed, a row that says so."""
    beam = preset(PRESET).beam
    rows = [*measured("auto", "tolerance", TOLERANCES, LIMIT_TOLERANCE, beamviz_solver(beam))]
    try:
        version("pybmodes")
    except PackageNotFoundError:
        reason = "not installed: pip install pybmodes"
        return [*rows, BladeRow(PYBMODES, "nodes", 0, math.nan, math.nan, reason)]
    with tempfile.TemporaryDirectory() as folder:
        main_file = write_elastodyn(beam, Path(folder), preset(PRESET).title)
        rows += measured(PYBMODES, "nodes", NODES, LIMIT_NODES, pybmodes_solver(main_file))
    return rows


def measured(
    name: str,
    option: str,
    resolutions: tuple[float, ...],
    limit: float,
    solver: Callable[[float], Callable[[], NDArray]],
) -> Iterator[BladeRow]:
    """A row for each resolution; limit: the resolution whose frequencies are taken as exact."""
    exact = solver(limit)()
    for resolution in resolutions:
        run, seconds = solver(resolution), math.inf
        for _ in range(REPEATS):
            begin = time.process_time()
            frequencies = run()
            seconds = min(seconds, time.process_time() - begin)
        error = float(np.abs(frequencies / exact - 1).max())
        yield BladeRow(name, option, resolution, seconds, error)


def beamviz_solver(beam: Beam) -> Callable[[float], Callable[[], NDArray]]:
    def solver(tolerance: float) -> Callable[[], NDArray]:
        options: dict[str, Any] = {"modes": MODES, "plane": "both", "tolerance": tolerance}
        return lambda: solve(beam, **options).frequencies

    return solver


def pybmodes_solver(main_file: Path) -> Callable[[float], Callable[[], NDArray]]:
    """pyBModes with the tables as they are, its meshes made before the clock starts."""
    RotatingBlade = import_module("pybmodes.models").RotatingBlade

    def solver(nodes: float) -> Callable[[], NDArray]:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its shapes are not for ElastoDyn
            blade = RotatingBlade.from_elastodyn(
                main_file, elastodyn_compatible=False, n_nodes=int(nodes)
            )
        return lambda: np.array(blade.run(MODES, check_model=False).frequencies[:MODES])

    return solver


def write_elastodyn(beam: Beam, folder: Path, title: str) -> Path:
    """Write a blade in SI as a main file and a blade file of ElastoDyn; the path of the first."""
    si: Any = beam.si
    names = ("stations", "twist", "mass_per_length", "flap_stiffness", "bending_stiffness")
    stations, *columns = (np.asarray(si[name]) for name in names)
    table = np.column_stack([stations / si["length"], *columns])
    rows = "\n".join(" ".join(f"{value:.10g}" for value in row) for row in table)
    blade = folder / "blade.dat"
    blade.write_text(BLADE_FILE.format(title=title, count=len(table), rows=rows))
    path, hub = folder / "main.dat", si["hub_radius"]
    rpm = si["rotation_speed"] * 30 / math.pi
    text = MAIN_FILE.format(title=title, tip=hub + si["length"], hub=hub, rpm=rpm, blade=blade.name)
    path.write_text(text)
    return path


def draw(rows: list[BladeRow]) -> Figure:
    """Processor time against error, a line for each program."""
    with rc_context(STYLE):
        figure = new_figure(5.4, 4.0, layout="constrained")
        axes = figure.subplots()
        for name, line in LINES.items():
            points = [
                (row.seconds, max(row.error, ROUNDING))
                for row in rows
                if row.name == name and not row.reason
            ]
            if points:
                seconds, errors = zip(*points, strict=True)
                axes.loglog(seconds, errors, label=name, ms=4, **line)
        axes.set(xlabel="processor time [s]", ylabel="largest relative error of six frequencies")
        axes.set_title("NREL 5 MW blade, twisted, 12.1 rpm", loc="left", size=10, weight="bold")
        axes.grid(color="#E6E6E6", lw=0.6)
        axes.legend(frameon=False)
    return figure


def summary(rows: list[BladeRow]) -> Iterator[str]:
    """A line for each program: the fastest solve within some errors, or why there is none."""
    yield "a twisted blade in both planes: time to a relative error [ms]"
    for name in LINES:
        own = [row for row in rows if row.name == name]
        if own[0].reason:
            yield f"{name:12}{own[0].reason}"
            continue
        cells = []
        for target in (1e-2, 1e-3, 1e-4):
            times = [row.seconds for row in own if row.error <= target]
            cells.append(f"{target:g}: {1000 * min(times):.3g}" if times else f"{target:g}: -")
        yield f"{name:12}{'   '.join(cells)}"
