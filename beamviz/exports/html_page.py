"""A scene as one HTML file that plays without a network, with its numbers and its loci."""

import math
import zlib
from base64 import b64encode
from collections.abc import Collection
from html import escape
from itertools import takewhile
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from beamviz.beam import Beam
from beamviz.chart_ranges import CHART_POINTS, chart_range
from beamviz.drawing import BeamScene, BeamView, camera, colours, row_title
from beamviz.drawing.beam_mesh import NORMALS, extents, resampled, to_hub_frame
from beamviz.drawing.modes import SampledModes, axial_strain, playback_rate
from beamviz.drawing.objects import RING, equilibrium_body
from beamviz.drawing.text import (
    described,
    error_digits,
    frequencies,
    growth,
    measure,
    mode_value,
    stability_warning,
)
from beamviz.errors import BeamvizError
from beamviz.exports.offline_data import OfflineScene, OfflineSpeeds
from beamviz.exports.solved_scene import SolvedScene
from beamviz.files import package_text, plain
from beamviz.frequency_loci import loci
from beamviz.frequency_loci.identity import identify_modes
from beamviz.plotting import STYLE, figure_bytes, new_figure
from beamviz.plotting.loci import Chart
from beamviz.scene import Scene, ViewOptions
from beamviz.server.viser_private import RecordedServer, ViserScene
from beamviz.solver import solve_many
from beamviz.solver.problem import MAX_MODES
from beamviz.solver.solution import Solution

TITLE, ROOT = "<title>Viser</title>", '<div id="root"></div>'  # of viser's page
POINTS = 72  # an inch, as SVG pictures have them
CHART_SIZE = (4.4, 3.6)  # [in], as wide as the panel, so that letters are of a size with its text
SPEEDS = 41  # solved over the range of the chart, besides that of the scene
EXTRA_MODES = 3  # solved for, since the order of modes changes with the speed
PALETTE = 256  # colours of the map
RESOLUTION = 1e-5  # of places, in lengths of the beam, and of strains
TIME = "T* = √(ρ A L⁴ / E I), the time unit of the beam"


def solution_table(
    solution: Solution, shown: Collection[str] = (), count: int | None = None
) -> str:
    """The `count` lowest modes (or all): number, label, kind, frequency, error. Those whose labels
    are `shown` are marked."""
    labels, mixtures = identify_modes(solution)
    units = solution.beam.units
    across = f'<span title="{TIME}">{frequencies(units).label}</span>'
    rows = ["<tr>" + "".join(f"<th>{head}</th>" for head in ("", "mode", "kind", across, "error"))]
    for k, (label, family) in enumerate(zip(labels[:count], solution.families, strict=False)):
        value, error = mode_value(solution, k)
        rate = float(solution.growth_rates[k])
        if rate > 0 and math.isfinite(solution.frequencies[k]):
            value += f", {growth(rate, units)}"
        cells = [f"{k + 1}", f"<b>{label}</b>", mixtures[k] or family, value, error_digits(error)]
        rows.append('<tr class="shown">' if solution.labels[k] in shown else "<tr>")
        rows += [f"<td>{cell}</td>" for cell in cells]
    return f'<table aria-label="modes">{"".join(rows)}</table>'


def write_html(file: Path, solved: SolvedScene) -> None:
    """viser's self-contained page with offline.js, which moves the beam, and a panel of numbers."""
    view, script = solved.scene.view, ""
    recorded = RecordedServer()
    fitted = camera.fitted(solved.shapes, view.rotating_frame, 1.0, solved.heights)
    camera.place(recorded.initial_camera, solved.scene.camera or fitted)
    beams = solved.draw(ViserScene(recorded.scene))
    beams.move(*solved.moment())
    if not solved.warning:
        data = speed_data(solved, beams)
        script = player("speeds", data, OfflineSpeeds, "exports/offline.js")
    beam, inner = solved.scene.beam, panel(solved)
    file.write_text(document(recorded, beam, inner, script, dark=view.dark), encoding="utf-8")


def player(name: str, data: dict[str, Any], kind: type[OfflineScene], script: str) -> str:
    """The elements that play data of this kind, which the file `script` finds by their name. Raises
    msgspec.ValidationError if the data have not the declared types."""
    checked = msgspec.convert(plain(data), kind)
    packed = zlib.compress(msgspec.json.encode(checked))
    shared = "server/viser.js", "drawing/captions.js", "exports/offline_beam.js"
    code = package_text(*shared, script)
    return (
        f'<script type="text/plain" id="{name}">{b64encode(packed).decode()}</script>'
        f"<script>{code}</script>"
    )


def document(recorded: RecordedServer, beam: Beam, inner: str, script: str, *, dark: bool) -> str:
    """The page with the scene recorded, a panel of numbers, and the elements that play it."""
    theme = f":root {{ color-scheme: {'dark' if dark else 'light'}; --scene:"
    theme += f" rgb{colours.BACKGROUND[dark]}; --letters: rgb{colours.LETTERS[dark]}; }}"
    style = theme + package_text("server/viser.css", "drawing/captions.css", "exports/offline.css")
    kind = ' class="dark"' if dark else ""
    aside = f'<aside aria-label="numbers"{kind}>{inner}</aside>'
    elements = f'<style>{style}</style>{ROOT}{aside}<div id="caption-layer"></div>{script}'
    page = recorded.page(dark=dark)
    page = page.replace(TITLE, f"<title>beamviz: {escape(described(beam))}</title>")
    return page.replace(ROOT, elements)


def panel(solved: SolvedScene) -> str:
    """The beam, the options that differ from the defaults, its modes, loci and scene file."""
    scene, defaults = solved.scene, Scene().options
    options = ", ".join(
        f"{name} {'on' if value is True else 'off' if value is False else value}"
        for name, value in scene.options.items()
        if value != defaults[name]
    )
    return (
        f'<div id="numbers">{numbers(solved, solved.solution)}</div>'
        + (f"<p>{escape(options)}</p>" if options else "")
        + ("" if solved.warning else controls("speed"))
        + chart(scene)
        + f"<details><summary>The scene as a file</summary><pre>{escape(scene.to_toml())}</pre>"
        "</details>"
    )


def numbers(solved: SolvedScene, solution: Solution) -> str:
    """What depends on the speed: the heading, a warning and the table of modes of a solution."""
    shown = {solved.solution.labels[k] for k in solved.shown}
    warning = stability_warning(solution)
    return (
        f"<h1>{escape(described(solution.beam))}</h1>"
        + (f'<p class="wrong">{escape(warning)}</p>' if warning else "")
        + solution_table(solution, shown, len(solved.solution.labels))
    )


def chart(scene: Scene) -> str:
    """The loci (SVG) with per-rev lines and a line at the scene, or why there are none."""
    beam, over = scene.beam, scene.over
    multiples = scene.per_rev if over == "gamma" else ()
    try:
        values = np.linspace(*chart_range(beam, over), CHART_POINTS)
        most = max(multiples, default=0)
        tracked = loci(beam, over, values, per_rev=most, **scene.solver_options)
    except BeamvizError as error:
        return f'<p class="wrong">{escape(str(error))}</p>'
    with rc_context(STYLE):
        figure = new_figure(*CHART_SIZE, layout="constrained")
        axes = figure.add_subplot()
        drawn = Chart(tracked, axes, multiples)
        drawn.annotate(multiples)
        return figure_element(figure, axes, drawn.x(getattr(beam, over)), moves=over == "gamma")


def figure_element(figure: Figure, axes: Axes, x: float, *, moves: bool) -> str:
    """A chart as an element that a click, or the key Enter, enlarges, with a line across at x;
    moves: a script moves it, by the step of one unit of x that the element has as an attribute."""
    axes.axvline(x, color="0.5", lw=0.8, zorder=0, gid="marker")
    svg = figure_bytes(figure, "svg").decode().partition("<svg")[2]
    low, high = axes.get_xlim()
    step = POINTS * figure.get_figwidth() * axes.get_position().width / (high - low)
    moved = f' data-step="{step}"' if moves else ""
    enlarge = "this.classList.toggle('large')"
    by_key = "if (event.key === 'Enter') this.click()"
    own = f'tabindex="0" onclick="{enlarge}" onkeydown="{by_key}"{moved}'
    return f'<figure title="click, or press Enter, to enlarge" {own}><svg{svg}</figure>'


def solved_speeds(solved: SolvedScene) -> list[Solution]:
    """The solutions at the speeds around that of the scene at which the modes shown vibrate, by
    ascending speed; in the state that the scene is in."""
    beam, (low, high) = solved.scene.beam, chart_range(solved.scene.beam, "gamma")
    wanted = {solved.solution.labels[k] for k in solved.shown}
    options = {**solved.scene.solver_options, "state": solved.solution.equilibrium.shape}
    options["modes"] = min(options["modes"] + EXTRA_MODES, MAX_MODES)

    def usable(answer: Any) -> bool:
        vibrates = isinstance(answer, Solution) and answer.equilibrium.status != "unstable"
        return vibrates and wanted <= set(answer.labels)

    answers: list[Any] = []
    while len(answers) < SPEEDS and low < high:  # again where a part of the range has no solution
        speeds = np.union1d(np.linspace(low, high, SPEEDS), [beam.gamma])
        answers = solve_many([beam.replace(gamma=float(speed)) for speed in speeds], **options)
        here = int(np.searchsorted(speeds, beam.gamma))
        slower, faster = takewhile(usable, answers[:here][::-1]), takewhile(usable, answers[here:])
        answers = [*[*slower][::-1], *faster]
        low, high = answers[0].beam.gamma, answers[-1].beam.gamma
    # That of the scene is the one whose numbers pages and commands show: one of many that are
    # solved together has another mesh, and other errors.
    return [solved.solution if one.beam == beam else one for one in answers]


def speed_data(solved: SolvedScene, beams: BeamScene) -> dict[str, Any]:
    """What offline.js needs, for each solved speed; modes shown are matched by their labels.

    numbers: the texts of the panel; speeds: as displayed; captions: those that hold at each speed;
    body (3 v, speeds), faces (3 t,): vertices and triangles of the equilibrium; see `steps`.
    """
    beam, view = solved.scene.beam, solved.scene.view
    solutions = solved_speeds(solved)
    shapes: list[SampledModes] = []
    for solution in solutions:
        shapes.append(SampledModes.sampled(solution, shapes[-1] if shapes else None))
    labels = [solved.solution.labels[k] for k in solved.shown]
    speed = measure("gamma", beam.units)
    stations, section = beams.rows[0].shapes.x, beams.rows[0].section
    bodies = [equilibrium_body(resampled(shape, stations), section) for shape in shapes]
    gammas = [solution.beam.gamma for solution in solutions]
    return {
        "gammas": gammas,
        "start": gammas.index(beam.gamma),
        "speeds": [speed.text(gamma, 4) for gamma in gammas],
        "factor": speed.factor,
        "numbers": [numbers(solved, solution) for solution in solutions],
        "frequencies": {
            label: [frequency_of(solution, label) for solution in solutions] for label in labels
        },
        "resolution": RESOLUTION,
        "body": steps([vertices.ravel() for vertices, _ in bodies]),
        "faces": bodies[0][1].ravel().tolist(),
        "rate": view.pace * playback_rate(solved.shapes.frequencies[solved.shown], beam.gamma),
        "turning": ["floor", -1] if view.rotating_frame else ["rotor", 1],
        "palette": palette(view),
        "strain": view.colouring == "axial strain",
        "arrow": around.arrow.name
        if (around := beams.rows[0].surroundings) and around.alone
        else "",
        "captions": captions(solved, beams, solutions),
        "beams": [beam_data(row, solved, shapes) for row in beams.rows],
    }


def palette(view: ViewOptions) -> list[int]:
    """Red, green and blue of the colours of the map."""
    places = np.linspace(0, colours.STEPS - 1, PALETTE).astype(int)
    return colours.PALETTES[view.colouring][places].ravel().tolist()


def frequency_of(solution: Solution, label: str) -> float:
    """The frequency of a mode; 0 where it does not vibrate."""
    return float(np.nan_to_num(solution.frequencies[solution.labels.index(label)]))


def captions(
    solved: SolvedScene, beams: BeamScene, solutions: list[Solution]
) -> list[list[dict[str, str]]]:
    """The captions at each speed. At that of the scene they are those of the scene; at others the
    titles of rows, the speed and a warning, since nodes of the modes are elsewhere."""
    at_scene = [caption.data for caption in beams.captions]
    return [
        at_scene
        if solution.beam.gamma == solved.scene.beam.gamma
        else captions_elsewhere(solved, beams, solution)
        for solution in solutions
    ]


def captions_elsewhere(
    solved: SolvedScene, beams: BeamScene, solution: Solution
) -> list[dict[str, str]]:
    """The captions at another speed than that of the scene."""
    first, shown = beams.rows[0], []
    if solved.drawn.in_rows:
        measure = frequencies(solution.beam.units)
        for row, label in zip(beams.rows, solved.solution.labels, strict=True):
            text = row_title(label, frequency_of(solution, label), measure)
            shown.append({**row.title.data, "text": text})
    if first.surroundings and first.surroundings.alone and solution.beam.gamma > 0:
        text = first.surroundings.speed_text(solution.beam.gamma, solution.beam.units)
        shown.append({**first.surroundings.speed.data, "text": text})
    shown += [caption.data for row in beams.rows for caption in row.bodies.captions if caption.text]
    if warning := stability_warning(solution):
        shown.append({**first.warning.data, "text": warning})
    return shown


def beam_data(row: BeamView, solved: SolvedScene, shapes: list[SampledModes]) -> dict[str, Any]:
    """One beam with its modes.

    states (4 n (1 + 2 m), speeds): axis and strain (n, 4), and their change by the real and the
    imaginary part of each mode; see `steps`.
    """
    shown, sizes = row.drawn.shown, row.drawn.amplitudes
    labels = [solved.shapes.labels[k] for k in shown]
    bends = bool(shown and solved.solution.bending_energy_fraction[shown[0]] >= 0.5)
    states = []
    for shape in (resampled(shape, row.shapes.x) for shape in shapes):
        at = [shape.labels.index(label) for label in labels]
        fields = np.minimum(sizes[shown], shape.limits[at])[:, None, None] * shape.modes[at]
        parts = np.stack([fields.real, fields.imag], 1).reshape(-1, len(shape.x), 2)
        still, *moved = (state(shape, part) for part in (np.zeros_like(shape.centreline), *parts))
        states.append(np.concatenate([still, *(part - still for part in moved)]).ravel())
    return {
        **beam_record(row),
        "labels": labels,
        "states": steps(states),
        "ring": RING,
        "ring_colour": row.nodes.colour[0].tolist(),
        "component": (1 if row.shapes.plane == "chordwise" else 2) if bends else 0,
    }


def beam_record(row: BeamView) -> dict[str, Any]:
    """One beam, but for its motion; see offline_beam.js."""
    normal, section = NORMALS[row.shapes.plane], row.section.mean(axis=1)
    return {
        "root": row.frame.name,
        "bodies": {
            node.name: row.bodies.at[numbers].tolist()
            for node, numbers in zip(row.bodies.nodes, row.bodies.numbers, strict=True)
            if numbers
        },
        "labels_of_bodies": [
            {"name": caption.point.name, "station": int(at), "above": above.tolist()}
            for caption, at, above in zip(
                row.bodies.captions, row.bodies.at, row.bodies.above, strict=False
            )
            if caption.text
        ],
        "normal": normal.tolist(),
        "thicknesses": section[:, 0].tolist(),
        "sections": extents(section, normal)[:, 1:].tolist(),
        "capped": row.capped,
        "largest": row.drawn.largest,
    }


def state(shapes: SampledModes, moved: np.ndarray) -> np.ndarray:
    """Points of the axis displaced by `moved` (n, 2) and the strain after each: (n, 4)."""
    points, _ = to_hub_frame(shapes, shapes.centreline + moved)
    return np.column_stack([points, np.append(axial_strain(shapes, moved), 0.0)])


def steps(rows: ArrayLike) -> list[list[int]]:
    """Columns of numbers as second differences of multiples of RESOLUTION, which compress well."""
    multiples = np.rint(np.divide(rows, RESOLUTION)).astype(int)
    return np.diff(np.pad(multiples, [(2, 0), (0, 0)]), 2, axis=0).T.tolist()


def controls(name: str) -> str:
    """A button that plays and pauses, and a slider with the text of its value."""
    return (
        f'<p class="controls"><button id="play">Pause</button> <label for="{name}">{name}</label>'
        f' <input id="{name}" type="range"> <output id="{name}-shown" for="{name}"></output></p>'
    )
