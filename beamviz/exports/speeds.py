"""A scene solved at many speeds, as data from which the offline page draws it at any of them."""

import base64
from typing import Any

import numpy as np

from beamviz.drawing import BeamView, colours
from beamviz.drawing.beam_mesh import NORMALS, extents, resampled
from beamviz.drawing.modes import SampledModes, playback_rate
from beamviz.drawing.text import frequencies, measure
from beamviz.exports.solved_scene import DrawnScene, SolvedScene
from beamviz.frequency_loci.sweep import chart_range
from beamviz.solver import Solution, solve_many

SPEEDS = 61  # solved over the range of the chart, besides that of the scene
EXTRA_MODES = 3  # solved for, since the order of modes changes with the speed
PALETTE = 256  # colours of the map


def solved_speeds(solved: SolvedScene) -> list[Solution]:
    """The solutions at the speeds around that of the scene at which the modes shown vibrate, by
    ascending speed; in the state that the scene is in."""
    beam, (low, high) = solved.scene.beam, chart_range(solved.scene.beam, "gamma")
    wanted = {solved.solution.labels[k] for k in solved.shown}
    options = {**solved.scene.solver_options, "state": solved.solution.equilibrium.shape}
    options["modes"] += EXTRA_MODES
    usable: list[Solution] = []
    while len(usable) < SPEEDS and low < high:  # again where a part of the range has no solution
        speeds = np.union1d(np.linspace(low, high, SPEEDS), [beam.gamma])
        found = solve_many([beam.replace(gamma=float(speed)) for speed in speeds], **options)
        good = [
            isinstance(one, Solution)
            and one.equilibrium.status == "stable"
            and wanted <= set(one.labels)
            for one in found
        ]
        here = int(np.searchsorted(speeds, beam.gamma))
        first = max((k + 1 for k in range(here) if not good[k]), default=0)
        end = min((k for k in range(here + 1, len(good)) if not good[k]), default=len(good))
        usable = [one for one in found[first:end] if isinstance(one, Solution)]
        low, high = float(speeds[first]), float(speeds[end - 1])
    return usable or [solved.solution]


def speed_data(solved: SolvedScene, drawn: DrawnScene) -> dict[str, Any]:
    """What offline.js needs; shapes and frequencies of a mode are matched by its label."""
    beam, view = solved.scene.beam, solved.scene.view
    solutions = solved_speeds(solved)
    shapes: list[SampledModes] = []
    for one in solutions:
        shapes.append(SampledModes.sampled(one, shapes[-1] if shapes else None))
    speed, across = measure("gamma", beam.units), frequencies(beam.units)
    rows = drawn.rows.rows[: drawn.rows.count] if drawn.rows else [drawn.view]
    shown = [[k] for k in range(len(rows))] if drawn.rows else [solved.shown]
    rotor = not view.rotating_frame
    steps = np.linspace(0, colours.STEPS - 1, PALETTE).astype(int)
    return {
        "speeds": [one.beam.gamma for one in solutions],
        "start": beam.gamma,
        "speed": {"factor": speed.factor, "unit": speed.unit},
        "frequencies": {
            label: [
                dict(zip(one.labels, one.frequencies, strict=True)).get(label) for one in solutions
            ]
            for label in solved.solution.labels
        },
        "factor": across.factor,
        "rate": view.pace * playback_rate(solved.shapes.frequencies[solved.shown], beam.gamma),
        "turning": [row.rotor.name if rotor else row.surroundings.floor.name for row in rows],
        "direction": 1 if rotor else -1,
        "palette": colours.PALETTES[view.colouring][steps].ravel().tolist(),
        "strain": view.colouring == "axial strain",
        "captions": [one.data for one in drawn.captions],
        "beams": [beam_data(row, solved, shapes, k) for row, k in zip(rows, shown, strict=True)],
    }


def beam_data(
    row: BeamView, solved: SolvedScene, shapes: list[SampledModes], shown: list[int]
) -> dict[str, Any]:
    """One beam with the modes `shown` (0-based, at the speed of the scene). For each speed: its
    axis (n, 2), the strain of its pieces (n - 1,) and, at its amplitude, each mode, real and
    imaginary part (m, 2, n, 2)."""
    x, normal, view = row.shapes.x, NORMALS[row.shapes.plane], solved.scene.view
    amplitude = view.amplitude if solved.all_modes else solved.amplitudes[shown]
    labels = [solved.shapes.labels[k] for k in shown]
    at_speeds, modes = [resampled(one, x) for one in shapes], []
    for one in at_speeds:
        k = np.array([one.labels.index(label) for label in labels], int)
        fields = np.minimum(amplitude, one.limits[k])[:, None, None] * one.modes[k]
        modes.append(np.stack([fields.real, fields.imag], 1))
    marked = len(shown) == 1 and bool(row.nodes.collars.visible)
    return {
        "labels": labels,
        "names": {
            "pieces": row.beam.name,
            "ends": row.ends.name,
            "mass": row.mass.name if solved.scene.beam.alpha > 0 else None,
            "nodes": row.nodes.collars.name if marked else None,
            "rest": row.reference.equilibrium.name,
        },
        "x": x.tolist(),
        "axes": packed([one.centreline for one in at_speeds]),
        "strains": packed([one.strain for one in at_speeds]),
        "modes": packed(modes),
        "mass": row.shapes.mass,
        "delta": solved.scene.beam.delta,
        "normal": normal.tolist(),
        "thickness": row.section[0],
        "size": extents(row.section, normal).tolist(),
        "ring": np.array(row.nodes.collars.batched_scales)[0].tolist(),
        "bends": bool(shown and solved.solution.bending_energy_fraction[shown[0]] >= 0.5),
        "largest": colours.colour_range(row.shapes, view.colouring, solved.amplitudes),
        "straight": solved.solution.equilibrium.shape == "straight",
        "vertices": row.reference.equilibrium.vertices.ravel().tolist(),
    }


def packed(values: Any) -> str:
    """Numbers as 32-bit floats in base64."""
    return base64.b64encode(np.asarray(values, "<f4").tobytes()).decode()
