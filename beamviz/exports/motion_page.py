"""A motion in time as one HTML file that plays without a network, with its chart and numbers."""

from html import escape
from typing import Any

import numpy as np
from matplotlib import rc_context
from numpy.typing import NDArray

from beamviz.drawing import BeamScene, BeamView, camera
from beamviz.drawing.beam_mesh import to_hub_frame
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.motion import MotionShapes
from beamviz.drawing.text import described, duration, length_text, si_text, strength_text
from beamviz.dynamics import Motion
from beamviz.dynamics.linear import LinearMotion
from beamviz.exports.html_page import (
    RESOLUTION,
    beam_record,
    controls,
    document,
    figure_element,
    palette,
    player,
    steps,
)
from beamviz.exports.motion_scene import USUAL_VIEW, MotionScene, beside
from beamviz.exports.offline_data import OfflineMotion
from beamviz.plotting import STYLE, axis_of
from beamviz.plotting.motion import draw_motion, scales_of
from beamviz.scene import ViewOptions
from beamviz.server.viser_private import RecordedServer, ViserScene
from beamviz.tables import html_table, significant_decimals

CHART_SIZE = 4.4, 4.8  # [in], as wide as the panel
LONGEST = 40.0  # [s] on the screen


def motion_page(
    motion: Motion, unstiffened: LinearMotion | None = None, view: ViewOptions = USUAL_VIEW
) -> str:
    """viser's self-contained page with offline_motion.js, which plays the motion, and a panel.
    unstiffened: the motion without stiffening, drawn over it."""
    scene, recorded = MotionScene(motion, unstiffened, view), RecordedServer()
    camera.place(recorded.initial_camera, scene.camera(1.0))
    beams = scene.draw(ViserScene(recorded.scene))
    scene.move(beams, 0.0)
    values = readings(motion, scene.shapes.t)
    data = motion_data(scene, beams, values)
    script = player("motion", data, OfflineMotion, "exports/offline_motion.js")
    inner = panel(motion, values, unstiffened)
    return document(recorded, motion.beam, inner, script, dark=view.dark)


def panel(
    motion: Motion, values: list[dict[str, Any]], unstiffened: LinearMotion | None = None
) -> str:
    """The beam and what happens to it, the present moment, the chart and a table of moments."""
    beam = motion.beam
    rows = "".join(
        f'<tr><th scope="row">{escape(value["label"])}</th><td id="reading-{k}"></td>'
        f"<td>{escape(value['unit'])}</td></tr>"
        for k, value in enumerate(values[1:], 1)
    )
    known, stress = length_text(motion.error, beam.units, 1), motion.greatest_stress
    return (
        f"<h1>{escape(described(beam))}</h1><p>{escape(what_happens(motion))}</p>"
        + controls("time")
        + f'<table class="readings" aria-label="this moment">{rows}</table>'
        + chart(motion, unstiffened)
        + f"<p>The tip is known to {known}.</p>"
        + (f"<p>{escape(strength_text(stress, beam.units))}</p>" if stress else "")
        + f"<details><summary>Numbers</summary>{html_table('', motion.table)}</details>"
    )


def what_happens(motion: Motion) -> str:
    """The motion in words."""
    units = motion.beam.units
    parts = [motion.drive.described]
    if motion.release:
        where = "the tip" if motion.release_at == 1 else length_text(motion.release_at, units, 3)
        force = f"{motion.release:g} E I / L²"
        if units and units.force:
            force = si_text(motion.release * units.force, "N", 3)
        parts.append(f"held by a force of {force} at {where}, let go")
    sizes = {mode: length_text(size, units, 3) for mode, size in motion.start.items()}
    parts += [f"started with {size} of {mode}" for mode, size in sizes.items()]
    for event, time in (("caught", motion.catch), ("dropped", motion.drop)):
        if time is not None:
            parts.append(f"the mass is {event} at {duration(time, units)}")
    if damping := motion.model["damping"]:
        parts.append(f"damping {100 * damping:g} %")
    text = "; ".join(parts)
    return f"{text[0].upper()}{text[1:]}."


def readings(motion: Motion, t: NDArray) -> list[dict[str, Any]]:
    """The numbers over time (n,) that the panel shows, the first of which is the time, beside its
    slider."""
    scales, speed = scales_of(motion.beam.units), axis_of("gamma", motion.beam.units)
    tip = scales.length * motion.position(t, [1.0])[:, 0]
    decimals = significant_decimals(scales.length * motion.error)
    gamma = speed.convert(np.interp(t, motion.t, motion.gamma))
    rows = [
        ("time t", scales.seconds, scales.time * t, 3),
        ("deflection of the tip", scales.metres, tip[:, 1], decimals),
        ("tip along the beam", scales.metres, tip[:, 0], decimals),
        (speed.label, "", gamma, 3),
    ]
    return [
        {"label": label, "unit": unit, "values": column.tolist(), "decimals": places}
        for label, unit, column, places in rows
    ]


def chart(motion: Motion, unstiffened: LinearMotion | None) -> str:
    """The tip over time, with a line at the present moment, and its spectrum."""
    with rc_context(STYLE):
        columns = motion.t, motion.tip[:, 1], motion.gamma, motion.spectrum()
        figure = draw_motion(*columns, motion.beam.units, CHART_SIZE, beside(unstiffened))
        return figure_element(figure, figure.axes[0], 0.0, moves=True)


def motion_data(
    scene: MotionScene, beams: BeamScene, values: list[dict[str, Any]]
) -> dict[str, Any]:
    """What offline_motion.js needs: the shapes of the beam, and everything over time at equal
    intervals (n,). fields: points of the unloaded beam, and their change by each shape (4 j,), see
    `steps`; parts: the sizes of the shapes over time."""
    motion, (row,), t = scene.motion, beams.rows, scene.shapes.t
    moved = [moved_beam(row, scene.shapes, t)]
    if beams.second and scene.second:
        moved.append(moved_beam(beams.second, scene.second, t))
    speeds, speed = [], row.surroundings.speed if row.surroundings else None
    if row.surroundings and speed and speed.text:
        gamma = np.interp(t, motion.t, motion.gamma).tolist()
        speeds = [row.surroundings.speed_text(value, motion.beam.units) for value in gamma]
    return {
        "until": float(t[-1]),
        "rate": max(scene.rate, float(t[-1]) / LONGEST),
        "resolution": RESOLUTION,
        "turning": ["floor", -1],
        "palette": palette(scene.scene.view),
        "strain": False,
        "angle": np.interp(t, motion.t, motion.angle).tolist(),
        "with_mass": [motion.has_mass(float(time)) for time in t],
        "readings": values,
        "captions": [caption.data for caption in beams.captions],
        "speed": speed.point.name if speed and speeds else "",
        "speeds": speeds,
        "of_mass": [caption.point.name for caption in row.bodies.captions if caption.text],
        "beams": moved,
    }


def moved_beam(row: BeamView, shapes: MotionShapes, t: NDArray) -> dict[str, Any]:
    """A beam with its shapes, and their sizes at times (n,); where the motion has ended, those at
    its end."""
    still = points_of(row.shapes, np.zeros_like(row.shapes.centreline))
    fields = [still, *(points_of(row.shapes, mode) - still for mode in row.shapes.modes)]
    parts = [np.interp(t, shapes.t, column) for column in shapes.parts.T]
    return beam_record(row) | {
        "fields": steps(np.transpose(fields)),
        "parts": steps(np.transpose(parts)),
    }


def points_of(shapes: SampledModes, moved: NDArray) -> NDArray:
    """Points of the axis displaced by `moved` (j, 2), each with a strain of 0: (4 j,)."""
    points, _ = to_hub_frame(shapes, shapes.centreline + moved)
    return np.column_stack([points, np.zeros(len(points))]).ravel()
