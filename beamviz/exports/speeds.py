"""A scene solved at many speeds, as data from which the offline page draws it at any of them."""

from itertools import takewhile
from typing import Any

import numpy as np

from beamviz.drawing import BeamView, colours
from beamviz.drawing.beam_mesh import NORMALS, extents, resampled, to_hub_frame
from beamviz.drawing.modes import SampledModes, axial_strain, playback_rate
from beamviz.drawing.objects import equilibrium_body
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

    def usable(one: Any) -> bool:
        stable = isinstance(one, Solution) and one.equilibrium.status == "stable"
        return stable and wanted <= set(one.labels)

    found: list[Any] = []
    while len(found) < SPEEDS and low < high:  # again where a part of the range has no solution
        speeds = np.union1d(np.linspace(low, high, SPEEDS), [beam.gamma])
        found = solve_many([beam.replace(gamma=float(speed)) for speed in speeds], **options)
        here = int(np.searchsorted(speeds, beam.gamma))
        slower, faster = takewhile(usable, found[:here][::-1]), takewhile(usable, found[here:])
        found = [*[*slower][::-1], *faster]
        low, high = found[0].beam.gamma, found[-1].beam.gamma
    return found


def speed_data(solved: SolvedScene, beams: list[BeamView]) -> dict[str, Any]:
    """What offline.js needs; shapes and frequencies of a mode are matched by its label."""
    beam, view = solved.scene.beam, solved.scene.view
    solutions = solved_speeds(solved)
    shapes: list[SampledModes] = []
    for one in solutions:
        shapes.append(SampledModes.sampled(one, shapes[-1] if shapes else None))
    known = [dict(zip(one.labels, one.omega_squared.tolist(), strict=True)) for one in solutions]
    labels = solved.solution.labels
    speed = measure("gamma", beam.units)
    places = np.linspace(0, colours.STEPS - 1, PALETTE).astype(int)
    return {
        "speeds": [speed.factor * one.beam.gamma for one in solutions],
        "start": speed.factor * beam.gamma,
        "unit": speed.unit,
        "factors": {"speed": speed.factor, "frequency": frequencies(beam.units).factor},
        "labels": labels,
        "squares": [[at.get(label) for label in labels] for at in known],
        "resolution": RESOLUTION,
        "rate": view.pace * playback_rate(solved.shapes.frequencies[solved.shown], beam.gamma),
        "turning": ["floor", -1] if view.rotating_frame else ["rotor", 1],
        "palette": colours.PALETTES[view.colouring][places].ravel().tolist(),
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
    imaginary part of each mode; bodies (speeds, 3 v): vertices of the equilibrium; see `steps`.
    """
    normal, view = NORMALS[row.shapes.plane], solved.scene.view
    shown = np.flatnonzero(sizes).tolist()
    labels = [solved.shapes.labels[k] for k in shown]
    bends = bool(shown and solved.solution.bending_energy_fraction[shown[0]] >= 0.5)
    states, bodies = [], []
    for one in (resampled(shape, row.shapes.x) for shape in shapes):
        at = [one.labels.index(label) for label in labels]
        fields = np.minimum(sizes[shown], one.limits[at])[:, None, None] * one.modes[at]
        parts = np.stack([fields.real, fields.imag], 1).reshape(-1, len(one.x), 2)
        still, *moved = (state(one, part) for part in (np.zeros_like(one.centreline), *parts))
        states.append(np.concatenate([still, *(part - still for part in moved)]).ravel())
        bodies.append(equilibrium_body(one, row.section)[0].ravel())
    return {
        "root": row.frame.name,
        "labels": labels,
        "states": steps(states),
        "bodies": steps(bodies),
        "mass": row.shapes.mass,
        "normal": normal.tolist(),
        "thickness": row.section[0],
        "section": extents(row.section, normal)[1:].tolist(),
        "ring": np.array(row.nodes.collars.batched_scales)[0].tolist(),
        "component": (1 if row.shapes.plane == "chordwise" else 2) if bends else 0,
        "largest": colours.colour_range(row.shapes, view.colouring, sizes),
    }


def state(shapes: SampledModes, moved: np.ndarray) -> np.ndarray:
    """Points of the axis displaced by `moved` (n, 2) and the strain after each: (n, 4)."""
    points, _ = to_hub_frame(shapes, shapes.centreline + moved)
    return np.column_stack([points, np.append(axial_strain(shapes, moved), 0.0)])


def steps(rows: list[np.ndarray]) -> list[list[int]]:
    """Rows of numbers as multiples of RESOLUTION, each as the difference from the row before."""
    return np.diff(np.rint(np.divide(rows, RESOLUTION)).astype(int), axis=0, prepend=0).tolist()
