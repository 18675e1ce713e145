"""A solution as a table for a terminal, JSON and CSV."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from beamviz.files import csv_text, json_text, plain
from beamviz.output import described_numbers, described_units, units_record
from beamviz.output.shape_polynomials import elastodyn_lines, shape_polynomials
from beamviz.solver.solution import GreatestStress, Solution
from beamviz.solver.stability import INSTABILITIES
from beamviz.tables import aligned_table, mode_columns, plural
from beamviz.units import BY_NAME, Units, usual_measure

EQUILIBRIUM_KEYS = (
    *("status", "buckled_chordwise", "shape", "iterations", "tip", "max_stretch"),
    *("root_force", "root_shear", "root_moment"),
)


def solution_json(solution: Solution, with_sensitivities: bool = False) -> str:
    """Beam, model, equilibrium, modes and statistics of a solution as JSON."""
    return json_text(solution_record(solution, with_sensitivities))


def solution_record(solution: Solution, with_sensitivities: bool) -> dict[str, Any]:
    """The record of the JSON."""
    state = solution.equilibrium
    data = {
        "beam": solution.beam.record,
        "model": solution.problem.model,
        "equilibrium": {key: getattr(state, key) for key in EQUILIBRIUM_KEYS}
        | loads_in_si(solution)
        | stress_record(state.greatest_stress),
        "modes": mode_records(solution, with_sensitivities),
        "stats": solution.stats,
    }
    if units := solution.beam.units:
        data["units"] = units_record(units)
        if properties := solution.beam.mass_properties:
            data["mass_properties"] = properties._asdict()
    return data


def json_with_polynomials(solution: Solution, with_sensitivities: bool) -> str:
    """The JSON with the shapes as polynomials."""
    polynomials = [each._asdict() for each in shape_polynomials(solution)]
    record = solution_record(solution, with_sensitivities)
    return json_text(record | {"shape_polynomials": polynomials})


def table_with_polynomials(solution: Solution, with_sensitivities: bool) -> str:
    """The table, and the shapes as lines of an ElastoDyn blade file."""
    polynomials = shape_polynomials(solution)
    errors = ", ".join(f"{each.label} {each.fit_error:.1g}" for each in polynomials)
    fit = f"Shapes as polynomials, 1 at the tip; greatest error of each: {errors}"
    lines = [solution_table(solution, with_sensitivities), "", fit, *elastodyn_lines(polynomials)]
    return "\n".join(lines)


def loads_in_si(solution: Solution) -> dict[str, float]:
    """The loads at the root in N and N m; {} where the mass of the beam is not known."""
    root, units = solution.equilibrium.root, solution.beam.units
    if units is None or units.force is None:
        return {}
    return {
        "root_force_newtons": units.newtons(root.axial),
        "root_shear_newtons": units.newtons(root.shear),
        "root_moment_newton_metres": units.newton_metres(root.moment),
    }


def stress_record(stress: GreatestStress | None) -> dict[str, float]:
    """The greatest stress [Pa], its place x / L and of a motion its time; {} where it is not
    known."""
    if stress is None:
        return {}
    time = {} if stress.t is None else {"max_stress_t": stress.t}
    return {"max_stress_pascals": stress.pascals, "max_stress_at": stress.at, **time}


def described_stress(stress: GreatestStress, units: Units | None = None) -> str:
    """The line of the greatest stress of a beam, and of its yield stress where it is known; of a
    motion with its time, in seconds in these units."""
    without = (
        "" if stress.with_bending else " without that of bending (section_height is not known)"
    )
    time, unit = (units.time, "s") if units else (1.0, "T*")
    when = "" if stress.t is None else f", t = {time * stress.t:.4g} {unit}"
    place = f"x/L = {stress.at:.4g}{when}"
    text = f"Stress       greatest {stress.pascals / 1e6:.5g} MPa at {place}{without}"
    if stress.yield_stress is None:
        return text
    above = "above" if stress.yields else "below"
    return f"{text}, {above} the yield stress of {stress.yield_stress / 1e6:.5g} MPa"


def mode_records(solution: Solution, with_sensitivities: bool = False) -> list[dict[str, Any]]:
    """Each mode under the keys of the JSON; growth rates, of either sign, where there is one."""
    values = solution.columns
    rows = zip(*map(plain, values.values()), strict=True)
    records = [dict(zip(values, row, strict=True)) for row in rows]
    for record in records:
        if not (record["frequency"] is None or record["growth_rate"]):
            del record["growth_rate"]
    for k, record in enumerate(records if with_sensitivities else ()):
        rates = solution.sensitivities.items()
        record["sensitivities"] = {number: plain(each[k]) for number, each in rates}
        if in_si := sensitivities_in_si(solution):
            record["sensitivities_hertz"] = {name: plain(each[k]) for name, each in in_si.items()}
    return records


def sensitivities_in_si(solution: Solution) -> dict[str, NDArray]:
    """The change (modes,) of each frequency [Hz] with each number that has a unit, by its name in
    this, as "kg" or "beta:mm"; {} of a beam whose size is not known."""
    units, in_si = solution.beam.units, dict[str, NDArray]()
    if units is None:
        return in_si
    for number, rates in solution.sensitivities.items():
        if measure := usual_measure(number, units):
            unit = measure.scale.unit
            name = unit if unit in BY_NAME else f"{number}:{unit}"
            in_si[name] = units.hertz(rates) / measure.factor
    return in_si


def solution_csv(solution: Solution, with_sensitivities: bool = False) -> str:
    """One line for each mode under the keys of the JSON; nodes are separated by spaces, and the
    sensitivity to alpha is `d_alpha`."""
    records, keys = mode_records(solution, with_sensitivities), [*solution.columns]
    for record in records:
        record["nodes"] = " ".join(map(repr, record["nodes"]))
        record |= {f"d_{name}": rate for name, rate in record.get("sensitivities", {}).items()}
    keys += [f"d_{name}" for name in solution.sensitivities] if with_sensitivities else []
    return csv_text(keys, ([record.get(key) for key in keys] for record in records))


def heading(solution: Solution) -> list[str]:
    """The lines that state the beam, its model and its equilibrium."""
    beam, state = solution.beam, solution.equilibrium
    lines = ["Beam         " + described_numbers(beam)]
    if units := beam.units:
        lines.append(f"{described_units(beam, units)}, {units.rpm(beam.gamma):.7g} rpm")
    (x, y), bent = state.tip, ", bent" if state.shape == "bent" else ""
    lines += [
        "Model        " + solution.problem.described,
        f"Equilibrium  {described_status(solution)}{bent},"
        f" tip at ({x:.7g}, {y:.7g}) L from the clamp, greatest stretch {state.max_stretch:.7g}",
    ]
    return lines + ([described_stress(state.greatest_stress)] if state.greatest_stress else [])


def solution_table(solution: Solution, with_sensitivities: bool = False) -> str:
    """The beam, its equilibrium and its modes, to be read in a terminal."""
    stats, modes = solution.stats, mode_columns(solution.columns, solution.beam.units)
    footer = (
        f"{solution.problem.method}: {plural(stats.elements, 'element')} of order {stats.order},"
        f" {stats.dof} unknowns, {1000 * stats.seconds:.3g} ms"
    )
    lines = [*heading(solution), "", *aligned_table(modes), ""]
    if with_sensitivities:
        title = "Sensitivities: change of the frequency [1/T*] with each number"
        rates = sensitivity_columns(solution, solution.sensitivities)
        lines += [title, "", *aligned_table(rates), ""]
        if in_si := sensitivities_in_si(solution):
            title = "Sensitivities: change of the frequency [Hz] with each number in its unit"
            lines += [title, "", *aligned_table(sensitivity_columns(solution, in_si)), ""]
    return "\n".join([*lines, footer])


def sensitivity_columns(solution: Solution, by_name: dict[str, NDArray]) -> dict[str, Any]:
    """A table of sensitivities as texts; those below the solver's rounding are 0."""
    columns: dict[str, Any] = {"mode": solution.columns["index"], "label": solution.labels}
    for name, rates in by_name.items():
        unit = " [1/deg]" if name in ("pitch", "twist") else ""
        cells = ["-" if rate != rate else f"{rate:.5g}" for rate in np.round(rates, 9) + 0.0]
        columns[f"{name}{unit}"] = cells
    return columns


def described_status(solution: Solution) -> str:
    """The status of the equilibrium in words."""
    state = solution.equilibrium
    if instability := INSTABILITIES.get(state.status):
        instant = " at this instant" if solution.beam.spin_up else ""
        return f"unstable ({instability}{instant})"
    if state.status == "stable" and state.buckled_chordwise:
        return "stable flapwise but buckled chordwise (unstable in the plane of rotation)"
    return state.status


SOLUTION_FORMATS = {"table": solution_table, "json": solution_json, "csv": solution_csv}
WITH_POLYNOMIALS = {"table": table_with_polynomials, "json": json_with_polynomials}
