"""A motion in time as a table for a terminal, JSON and CSV."""

from typing import Any

from numpy.typing import NDArray

from beamviz.dynamics import Motion
from beamviz.files import csv_text, json_text
from beamviz.output import described_numbers, described_units, units_record
from beamviz.output.solution import described_stress, stress_record
from beamviz.tables import aligned_table, plural


def motion_json(motion: Motion) -> str:
    """Beam, model, drive, the motion of the tip, its error and statistics as JSON."""
    data: dict[str, Any] = {
        "beam": motion.beam.record,
        "model": motion.model,
        "drive": motion.drive.record,
        "start": motion.start,
        "release": motion.release,
        "release_at": motion.release_at,
        "catch": motion.catch,
        "drop": motion.drop,
        "t": motion.t,
        "gamma": motion.gamma,
        "angle": motion.angle,
        "tip": motion.tip,
        "energy": motion.energy,
        "error": motion.error,
        **stress_record(motion.greatest_stress),
        "stats": motion.stats,
    }
    if units := motion.beam.units:
        data["units"] = units_record(units)
        data["si"] = si_columns(motion)
    return json_text(data)


def motion_csv(motion: Motion) -> str:
    """One line for each time: speed, angle of the hub, position of the tip, energy; for a beam in
    SI in these units, too."""
    columns = motion.columns
    if motion.beam.units:
        columns = {**si_columns(motion), **columns}
    return csv_text(columns, zip(*(column.tolist() for column in columns.values()), strict=True))


def si_columns(motion: Motion) -> dict[str, NDArray]:
    """The motion over time of a beam in SI (n,) each; the energy where the mass is known."""
    units = motion.beam.units
    assert units
    columns = {
        "seconds": motion.t * units.time,
        "rpm": units.rpm(motion.gamma),
        "tip_x_m": motion.tip[:, 0] * units.length,
        "tip_y_m": motion.tip[:, 1] * units.length,
    }
    if units.force is not None:
        columns["energy_J"] = motion.energy * units.force * units.length
    return columns


def described_drive(motion: Motion) -> str:
    """How the hub is driven; of a beam in SI with its first and its last speed, too."""
    text, units = motion.drive.described, motion.beam.units
    if units is None:
        return text
    first, last = units.rpm(motion.gamma[[0, -1]])
    speeds = f"{first:.6g} rpm" if first == last else f"{first:.6g} to {last:.6g} rpm"
    return f"{text}: {speeds}"


def described_tip(motion: Motion) -> str:
    """The error and the ends of the deflection of the tip, in metres for a beam in SI."""
    units = motion.beam.units
    length, unit = (units.length, " m") if units else (1.0, "")
    error = f"{length * motion.error:.1g} {'m' if units else 'L'}"
    least, greatest = length * motion.tip[:, 1].min(), length * motion.tip[:, 1].max()
    return f"within {error}; least deflection {least:.6g}{unit}, greatest {greatest:.6g}{unit}"


def motion_table(motion: Motion) -> str:
    """The beam, its drive and the motion at some times, to be read in a terminal."""
    beam, stats = motion.beam, motion.stats
    heading = ["Beam         " + described_numbers(beam)]
    if beam.units:
        heading.append(described_units(beam, beam.units))
    model = motion.model
    heading += [
        f"Model        {model['strain']} strain, {model['curvature']} curvature, chordwise with"
        f" Coriolis, damping {model['damping']:g}",
        f"Drive        {described_drive(motion)}",
        f"Tip          {described_tip(motion)}",
        *([described_stress(stress, beam.units)] if (stress := motion.greatest_stress) else []),
    ]
    footer = (
        f"{model['method']}, {model['integrator']}: {plural(stats.elements, 'element')} of order"
        f" {stats.order}, {stats.dof} unknowns, {plural(stats.steps, 'step')},"
        f" {1000 * stats.seconds:.3g} ms"
    )
    return "\n".join([*heading, "", *aligned_table(motion.table), "", footer])


MOTION_FORMATS = {"table": motion_table, "json": motion_json, "csv": motion_csv}
