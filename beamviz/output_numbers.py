"""The numbers of a solution as files for other programs: CSV and NPZ."""

import csv
import io
import json
import math
from pathlib import Path

import numpy as np

from beamviz.solver import Solution

STATIONS = 201  # along the beam, evenly; the mass is one more where it lies between them
COLUMNS = (
    *("mode", "label", "family", "frequency", "error", "growth_rate", "bending_fraction"),
    *("x", "position_x", "position_y", "stretch", "shape_x", "shape_y"),
)
QUADRATURE = ("shape_x_imag", "shape_y_imag")  # with Coriolis forces, what is a quarter period late


def write_csv(file: Path, solution: Solution) -> None:
    """One line for each mode and station, complete in itself; what is no number is left empty.

    Along and across the beam, lengths in L, frequencies in 1/T*; shapes have unit modal mass.
    """
    x, shapes = stations(solution), sampled(solution)
    gyroscopic = np.iscomplexobj(shapes)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*COLUMNS, *(QUADRATURE if gyroscopic else ())])
    state = np.column_stack([x, solution.equilibrium.position(x), solution.equilibrium.stretch(x)])
    for k, shape in enumerate(shapes):
        mode = [k + 1, solution.labels[k], solution.families[k]]
        mode += [plain(values[k]) for values in quantities(solution)]
        parts = [shape.real, shape.imag] if gyroscopic else [shape]
        for row in np.column_stack([state, *parts]):
            writer.writerow([*mode, *map(plain, row)])
    file.write_text(text.getvalue())


def write_npz(file: Path, solution: Solution) -> None:
    """The same as arrays: (modes,), (stations,), (stations, 2), (modes, stations, 2)."""
    x, beam = stations(solution), solution.beam
    frequency, error, growth_rate, bending_fraction = quantities(solution)
    with file.open("wb") as stream:  # given a path, numpy would add an ending
        np.savez_compressed(
            stream,
            beam=np.array(list(beam.numbers.values())),
            beam_names=np.array(list(beam.numbers)),
            units=np.array([beam.units.length, beam.units.time] if beam.units else []),
            model=np.array(json.dumps(solution.problem.model)),
            status=np.array(solution.equilibrium.status),
            labels=np.array(solution.labels),
            families=np.array(solution.families),
            frequencies=frequency,
            errors=error,
            growth_rates=growth_rate,
            bending_fractions=bending_fraction,
            x=x,
            position=solution.equilibrium.position(x),
            stretch=solution.equilibrium.stretch(x),
            shapes=sampled(solution),
        )


def stations(solution: Solution) -> np.ndarray:
    """Reference points (n,) along the beam."""
    return np.union1d(np.linspace(0.0, 1.0, STATIONS), [solution.beam.beta])


def sampled(solution: Solution) -> np.ndarray:
    """The shapes (modes, n, 2) at the stations."""
    return np.moveaxis(solution.displacement(stations(solution)), 2, 0)


def quantities(solution: Solution) -> tuple[np.ndarray, ...]:
    """Frequency, its error, growth rate and bending fraction of every mode, each (modes,)."""
    return (
        solution.frequencies,
        solution.errors,
        solution.growth_rates,
        solution.bending_energy_fraction,
    )


def plain(value: float) -> float | str:
    """A float with all its digits, or "" for what is none."""
    return float(value) if math.isfinite(value) else ""
