"""The numbers of a solution as arrays, for NPZ files and tables."""

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.solver.solution import Solution
from beamviz.units import Units

MODE_ARRAYS = ("labels", "families", "frequencies", "errors", "growth_rates")


def field_arrays(solution: Solution) -> dict[str, Any]:
    """Everything in a solution as arrays: (modes,), and along the beam (stations,), position
    (stations, 2), shapes (modes, stations, 2); lengths in L, unit modal mass."""
    beam, line = solution.beam, solution.along_beam
    shapes, in_plane = line.pop("shape"), {}
    if solution.in_plane_fraction is not None:
        in_plane["in_plane_fractions"] = solution.in_plane_fraction
    return {
        "beam": np.array(list(beam.numbers.values())),
        "beam_names": np.array(list(beam.numbers)),
        "structure": np.array(json.dumps(structure_record(beam))),
        "units": np.array([beam.units.length, beam.units.time] if beam.units else []),
        "model": np.array(json.dumps(solution.problem.model)),
        "status": np.array(solution.equilibrium.status),
        **{key: np.array(getattr(solution, key)) for key in MODE_ARRAYS},
        "bending_fractions": solution.bending_energy_fraction,
        **in_plane,
        **line,
        "shapes": shapes,
        **si_arrays(solution, line),
    }


def si_arrays(solution: Solution, line: dict[str, Any]) -> dict[str, Any]:
    """Of a beam in SI: frequencies in Hz, places [m], and its keywords of `Beam.from_si` as JSON
    where its mass is known; line: of `Solution.along_beam`."""
    units = solution.beam.units
    if units is None:
        return {}
    return {
        "frequencies_hertz": units.hertz(solution.frequencies),
        "x_m": units.length * line["x"],
        "position_m": units.length * line["position"],
        **loads_in_si(units, line),
        **stress_along(solution, line["x"]),
        "si": np.array(json.dumps(solution.beam.si)),
    }


def loads_in_si(units: Units, line: dict[str, Any]) -> dict[str, Any]:
    """The loads along the beam [N, N m] where its mass is known; line: of `Solution.along_beam`."""
    if units.force is None:
        return {}
    return {
        "force_newtons": units.newtons(line["force"]),
        "shear_newtons": units.newtons(line["shear"]),
        "moment_newton_metres": units.newton_metres(line["moment"]),
    }


def stress_along(solution: Solution, x: NDArray) -> dict[str, Any]:
    """The stress along the beam [Pa] where its material is known, and of bending the height of its
    section."""
    if solution.equilibrium.greatest_stress is None:
        return {}
    stress = solution.equilibrium.stress(x)
    known = {} if stress.bending is None else {"bending_stress_pascals": stress.bending}
    return {"axial_stress_pascals": stress.axial} | known


def structure_record(beam: Beam) -> dict[str, Any]:
    """The blade, masses and root of a beam that is not uniform, else {}."""
    return {name: value for name, value in beam.record.items() if name not in beam.numbers}
