"""A scene solved at many speeds, as data from which the offline page draws it at any of them."""

from typing import Any

import numpy as np

from beamviz.drawing import BeamView, colours
from beamviz.drawing.beam_mesh import NORMALS, extents, resampled, to_hub_frame
from beamviz.drawing.modes import SampledModes, axial_strain, playback_rate
from beamviz.drawing.text import frequencies, measure
from beamviz.exports.solved_scene import SolvedScene
from beamviz.frequency_loci.sweep import chart_range
from beamviz.solver import MAX_MODES, Solution, solve_many

SPEEDS = 61  # solved over the range of the chart, besides that of the scene
EXTRA_MODES = 3  # solved for, since the order of modes changes with the speed
PALETTE = 256  # colours of the map
RESOLUTION = 1e-5  # of places, in lengths of the beam, and of strains


def solved_speeds(solved: SolvedScene) -> list[Solution]:
    """The solutions at the speeds around that of the scene at which the modes shown vibrate, by
    ascending speed; in the state that the scene is in."""
    beam, (low, high) = solved.scene.beam, chart_range(solved.scene.beam, "gamma")
    wanted = {solved.solution.labels[k] for k in solved.shown}
    options = {**solved.scene.solver_options, "state": solved.solution.equilibrium.shape}
    options["modes"] = min(options["modes"] + EXTRA_MODES, MAX_MODES)
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


def speed_data(solved: SolvedScene, beams: list[BeamView]) -> dict[str, Any]:
    """What offline.js needs; shapes and frequencies of a mode are matched by its label."""
    beam, view = solved.scene.beam, solved.scene.view
    solutions = solved_speeds(solved)
    shapes: list[SampledModes] = []
    for one in solutions:
        shapes.append(SampledModes.sampled(one, shapes[-1] if shapes else None))
    known = [dict(zip(one.labels, one.omega_squared.tolist(), strict=True)) for one in solutions]
    labels = solved.solution.labels
    speed, across = measure("gamma", beam.units), frequencies(beam.units)
    rotor = not view.rotating_frame
    steps = np.linspace(0, colours.STEPS - 1, PALETTE).astype(int)
    return {
        "speeds": [one.beam.gamma for one in solutions],
        "start": beam.gamma,
        "speed": {"factor": speed.factor, "unit": speed.unit},
        "labels": labels,
        "squares": [[at.get(label) for label in labels] for at in known],
        "resolution": RESOLUTION,
        "factor": across.factor,
        "rate": view.pace * playback_rate(solved.shapes.frequencies[solved.shown], beam.gamma),
        "turning": [(row.rotor if rotor else row.surroundings.floor).name for row in beams],
        "direction": 1 if rotor else -1,
        "palette": colours.PALETTES[view.colouring][steps].ravel().tolist(),
        "strain": view.colouring == "axial strain",
        "captions": [one.data for row in beams for one in row.captions],
        "beams": [
            beam_data(row, solved, shapes, sizes)
            for row, sizes in zip(beams, solved.rows, strict=True)
        ],
    }


def beam_data(
    row: BeamView, solved: SolvedScene, shapes: list[SampledModes], sizes: np.ndarray
) -> dict[str, Any]:
    """One beam with modes of amplitudes `sizes` (m,) at the speed of the scene.

    states (speeds, 4 n (1 + 2 m)): axis and strain (n, 4), and their change by the real and the
    imaginary part of each mode; integers, as multiples of RESOLUTION, each row the difference from
    that of the speed before.
    """
    normal, view = NORMALS[row.shapes.plane], solved.scene.view
    shown = np.flatnonzero(sizes).tolist()
    labels = [solved.shapes.labels[k] for k in shown]
    bends = bool(shown and solved.solution.bending_energy_fraction[shown[0]] >= 0.5)
    across = 1 if row.shapes.plane == "chordwise" else 2
    marked = len(shown) == 1 and bool(row.nodes.collars.visible)
    straight = solved.solution.equilibrium.shape == "straight"
    states = []
    for one in (resampled(shape, row.shapes.x) for shape in shapes):
        at = [one.labels.index(label) for label in labels]
        fields = np.minimum(sizes[shown], one.limits[at])[:, None, None] * one.modes[at]
        parts = np.stack([fields.real, fields.imag], 1).reshape(-1, len(one.x), 2)
        still, *moved = (state(one, part) for part in (np.zeros_like(one.centreline), *parts))
        states.append(np.concatenate([still, *(part - still for part in moved)]).ravel())
    return {
        "labels": labels,
        "names": {
            "pieces": row.beam.name,
            "ends": row.ends.name,
            "mass": row.mass.name if solved.scene.beam.alpha > 0 else None,
            "nodes": row.nodes.collars.name if marked else None,
            "rest": row.reference.equilibrium.name,
        },
        "stations": len(row.shapes.x),
        "states": np.diff(
            np.rint(np.divide(states, RESOLUTION)).astype(int), axis=0, prepend=0
        ).tolist(),
        "mass": row.shapes.mass,
        "normal": normal.tolist(),
        "thickness": row.section[0],
        "section": extents(row.section, normal)[1:].tolist(),
        "ring": np.array(row.nodes.collars.batched_scales)[0].tolist(),
        "component": across if bends else 0,
        "largest": colours.colour_range(row.shapes, view.colouring, sizes),
        "vertices": row.reference.equilibrium.vertices.ravel().tolist() if straight else None,
    }


def state(shapes: SampledModes, moved: np.ndarray) -> np.ndarray:
    """Points of the axis displaced by `moved` (n, 2) and the strain after each: (n, 4)."""
    points, _ = to_hub_frame(shapes, shapes.centreline + moved)
    return np.column_stack([points, np.append(axial_strain(shapes, moved), 0.0)])
