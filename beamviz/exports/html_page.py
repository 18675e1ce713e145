"""A scene as one HTML file that plays without a network, with its numbers and its loci."""

import math
import zlib
from base64 import b64encode
from collections.abc import Collection, Iterable
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from beamviz.beam import Beam
from beamviz.chart_ranges import chart_range
from beamviz.drawing import BeamScene, BeamView, camera, colours, row_title
from beamviz.drawing.beam_mesh import (
    NORMALS,
    extents,
    normals,
    piece_turns,
    resampled,
    rings,
    swept,
    to_hub_frame,
)
from beamviz.drawing.comparison import THIS, compared_rows
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
    strength_text,
)
from beamviz.drawing.tip_path import MOST, PERIODS, SAMPLES
from beamviz.errors import BeamvizError
from beamviz.exports.chart_files import SceneLoci
from beamviz.exports.offline_data import OfflineScene, OfflineSpeeds
from beamviz.exports.solved_scene import SolvedScene
from beamviz.files import package_text, plain
from beamviz.frequency_loci.events import EVENT_KINDS
from beamviz.frequency_loci.identity import identify_modes
from beamviz.plotting import STYLE, figure_bytes, new_figure
from beamviz.plotting.labels import HALO
from beamviz.plotting.loci import LociDrawing
from beamviz.scene import GIVEN, Scene, ViewOptions
from beamviz.server.viser_private import RecordedServer, ViserScene
from beamviz.solver import solve_many
from beamviz.solver.problem import MAX_MODES
from beamviz.solver.solution import Solution

TITLE, ROOT = "<title>Viser</title>", '<div id="root"></div>'  # of viser's page
POINTS = 72  # an inch, as SVG pictures have them
# A text in a corner of the chart.
IN_CORNER: dict[str, Any] = {"va": "top", "fontsize": 8, "color": "#5A5A5A", "path_effects": HALO}
CHART_SIZE = (4.4, 3.6)  # [in], as wide as the panel, so that letters are of a size with its text
SPEEDS = 41  # solved over the range of the chart, besides that of the scene
EXTRA_MODES = 3  # solved for, since the order of modes changes with the speed
PALETTE = 256  # colours of the map
SECOND_MODE = "second "  # before the label of a mode of the second beam
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
    # Its script moves no arrows.
    solved.drawn = replace(solved.drawn, view=replace(view, forces=False))
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
    scene = "server/webgl.js", "server/viser.js", "drawing/plain_scene.js", "drawing/captions.js"
    code = package_text(*scene, "exports/offline_beam.js", script)
    return (
        f'<script type="text/plain" id="{name}">{b64encode(packed).decode()}</script>'
        f"<script>{code}</script>"
    )


def document(recorded: RecordedServer, beam: Beam, inner: str, script: str, *, dark: bool) -> str:
    """The page with the scene recorded, a panel of numbers, and the elements that play it."""
    theme = f":root {{ color-scheme: {'dark' if dark else 'light'}; --scene:"
    theme += f" rgb{colours.BACKGROUND[dark]}; --letters: rgb{colours.LETTERS[dark]}; }}"
    scene = "server/viser.css", "drawing/captions.css", "drawing/plain_scene.css"
    style = theme + package_text(*scene, "exports/offline.css")
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
        f'<div id="numbers">{numbers(solved, solved.solution, solved.second)}</div>'
        + (f"<p>{escape(options)}</p>" if options else "")
        + ("" if solved.warning else controls("speed"))
        + chart(scene)
        + f"<details><summary>The scene as a file</summary><pre>{escape(scene.to_toml())}</pre>"
        "</details>"
    )


def numbers(solved: SolvedScene, solution: Solution, second: Solution | None = None) -> str:
    """What depends on the speed: the heading, a warning, the table of modes of a solution, and the
    frequencies of the second beam beside it."""
    shown = {solved.solution.labels[k] for k in solved.shown}
    warning = stability_warning(solution)
    return (
        f"<h1>{escape(described(solution.beam))}</h1>"
        + (f'<p class="wrong">{escape(warning)}</p>' if warning else "")
        + solution_table(solution, shown, len(solved.solution.labels))
        + strength(solution)
        + comparison(solved, solution, second)
    )


def strength(solution: Solution) -> str:
    """The greatest stress (HTML) beside the yield stress; "" where it is not known or 0."""
    stress = solution.equilibrium.greatest_stress
    if stress is None or not stress.pascals:
        return ""
    kind = ' class="wrong"' if stress.yields else ""
    return f"<p{kind}>{escape(strength_text(stress, solution.beam.units))}</p>"


def comparison(solved: SolvedScene, solution: Solution, second: Solution | None) -> str:
    """A table (HTML) of the frequencies of both beams, or why there is no second one; "" where none
    is asked for."""
    given = solved.scene.second
    if given is None:
        return ""
    if second is None:
        reason = solved.second_error or "not stable at this speed"
        return f'<p class="wrong">{escape(f"{given.title}: {reason}")}</p>'
    unit = frequencies(solution.beam.units).label
    heads = "mode", f"{THIS}, {unit}", f"{given.title}, {unit}", "change"
    rows = compared_rows(solution, second)[: len(solved.solution.labels)]
    cells = (
        f"<td><b>{row[0]}</b></td>" + "".join(f"<td>{x}</td>" for x in row[1:]) for row in rows
    )
    head = "".join(f"<th>{escape(title)}</th>" for title in heads)
    body = "".join(f"<tr>{row}</tr>" for row in cells)
    return f'<table aria-label="comparison" class="compared"><tr>{head}</tr>{body}</table>'


def chart(scene: Scene) -> str:
    """The loci (SVG) with per-rev lines, those of a second beam and a line at the scene, or why
    there are none."""
    beam, over = scene.beam, scene.over
    multiples = scene.per_rev if over == "gamma" else ()
    try:
        computed = SceneLoci.of(scene)
    except BeamvizError as error:
        return f'<p class="wrong">{escape(str(error))}</p>'
    with rc_context(STYLE):
        figure = new_figure(*CHART_SIZE, layout="constrained")
        axes = figure.add_subplot()
        drawn = LociDrawing(computed.first, axes, multiples, computed.names)
        if computed.second:
            drawn.draw_second(computed.second)
            axes.text(0.02, 0.99, f"grey: {computed.title}", **IN_CORNER, transform=axes.transAxes)
        drawn.annotate(multiples)
        element = figure_element(figure, axes, drawn.x(getattr(beam, over)), moves=over == "gamma")
    return element + event_key(drawn)


def event_key(drawn: LociDrawing) -> str:
    """The signs of the events in the chart with their meaning (HTML); "" without any."""
    kinds = {event.kind for event in drawn.events if event.until is None}
    keys = [
        f'<span title="{escape(kind.meaning)}">{kind.sign} {kind.name}</span>'
        for kind in EVENT_KINDS.values()
        if kind.name in kinds
    ]
    return f'<p class="key">{", ".join(keys)}</p>' if keys else ""


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
    behaviour = f'tabindex="0" onclick="{enlarge}" onkeydown="{by_key}"{moved}'
    return f'<figure title="click, or press Enter, to enlarge" {behaviour}><svg{svg}</figure>'


class Speed(NamedTuple):
    """The solutions at one speed; second: of the second beam, None without one."""

    first: Solution
    second: Solution | None


def solved_speeds(solved: SolvedScene) -> list[Speed]:
    """The solutions at the speeds around that of the scene at which the modes shown vibrate, by
    ascending speed; in the state that the scene is in. A second beam that was given keeps its own
    speed."""
    beam, (low, high) = solved.scene.beam, chart_range(solved.scene.beam, "gamma")
    answers: list[Speed] = []
    while len(answers) < SPEEDS and low < high:  # again where a part of the range has no solution
        speeds = np.union1d(np.linspace(low, high, SPEEDS), [beam.gamma])
        first = solved_at(speeds, solved.scene, solved.solution, solved.shown)
        second = [solved.second] * len(speeds)
        if solved.second and not is_given(solved.scene):
            shown = solved.pair.second.shown if solved.pair else []
            second = solved_at(speeds, solved.scene.second_scene, solved.second, shown)
        pairs = list(zip(first, second, strict=True))
        here = int(np.searchsorted(speeds, beam.gamma))

        slower, faster = drawable(pairs[:here][::-1], solved), drawable(pairs[here:], solved)
        answers = [*slower[::-1], *faster]
        low, high = answers[0].first.beam.gamma, answers[-1].first.beam.gamma
    return answers


def drawable(
    pairs: Iterable[tuple[Solution | None, Solution | None]], solved: SolvedScene
) -> list[Speed]:
    """The speeds up to the first one at which a beam in the picture has no solution."""
    speeds = []
    for first, second in pairs:
        if first is None or (second is None and solved.pair):
            break
        speeds.append(Speed(first, second))
    return speeds


def is_given(scene: Scene) -> bool:
    """Whether the second beam of a scene stays as it is when the first one changes."""
    return scene.second is not None and scene.second.choice == GIVEN


def solved_at(
    speeds: np.ndarray, scene: Scene, solution: Solution, shown: Collection[int]
) -> list[Solution | None]:
    """The solutions of the beam of a scene at some speeds, in the state of its solution; None where
    one of the modes shown does not vibrate. At the speed of the scene it is that solution, whose
    numbers pages and commands show: one of many that are solved together has another mesh, and
    other errors."""
    wanted = {solution.labels[k] for k in shown}
    options = {**scene.solver_options, "state": solution.equilibrium.shape}
    options["modes"] = min(options["modes"] + EXTRA_MODES, MAX_MODES)
    beams = [scene.beam.replace(gamma=float(speed)) for speed in speeds]

    def usable(answer: Any) -> Solution | None:
        if not isinstance(answer, Solution) or answer.equilibrium.status == "unstable":
            return None
        return answer if wanted <= set(answer.labels) else None

    return [
        solution if beam == scene.beam else usable(answer)
        for beam, answer in zip(beams, solve_many(beams, **options), strict=True)
    ]


def speed_data(solved: SolvedScene, beams: BeamScene) -> dict[str, Any]:
    """What offline.js needs, for each solved speed; modes shown are matched by their labels.

    numbers: the texts of the panel; speeds: as displayed; captions: those that hold at each speed;
    equilibria: of the first beam, and of a second one that is not drawn over it.
    """
    beam, view = solved.scene.beam, solved.scene.view
    answers = solved_speeds(solved)
    solutions = [answer.first for answer in answers]
    shapes = sampled_at(solutions)
    speed = measure("gamma", beam.units)
    gammas = [solution.beam.gamma for solution in solutions]
    rows = [beam_data(row, shapes) for row in beams.rows]
    labels = [solved.solution.labels[k] for k in solved.shown]
    rates = {label: [frequency_of(answer, label) for answer in solutions] for label in labels}
    equilibria = [equilibrium_data(beams.rows[0], shapes)]
    if beams.second:
        others = [answer.second for answer in answers if answer.second]
        other_shapes = sampled_at(others)
        data = beam_data(beams.second, other_shapes)
        renamed = {SECOND_MODE + name: name for name in data["modes"]}
        rates |= {
            key: [frequency_of(answer, name) for answer in others] for key, name in renamed.items()
        }
        if not beams.second.overlay:
            equilibria.append(equilibrium_data(beams.second, other_shapes))
        at = -1 if beams.second.overlay else 1
        rows.append({**data, "modes": [*renamed], "equilibrium": at})
    return {
        "gammas": gammas,
        "start": gammas.index(beam.gamma),
        "speeds": [speed.text(gamma, 4) for gamma in gammas],
        "factor": speed.factor,
        "numbers": [numbers(solved, answer.first, answer.second) for answer in answers],
        "frequencies": rates,
        "resolution": RESOLUTION,
        "equilibria": equilibria,
        "rate": view.pace * playback_rate(solved.shapes.frequencies[solved.shown], beam.gamma),
        "turning": ["floor", -1] if view.rotating_frame else ["rotor", 1],
        "palette": palette(view),
        "strain": view.colouring == "axial strain",
        "arrow": around.arrow.name
        if (around := beams.rows[0].surroundings) and around.alone
        else "",
        "captions": captions(solved, beams, solutions),
        "beams": rows,
    }


def sampled_at(solutions: list[Solution]) -> list[SampledModes]:
    """The modes of a beam at several speeds, with the same signs."""
    shapes: list[SampledModes] = []
    for solution in solutions:
        shapes.append(SampledModes.sampled(solution, shapes[-1] if shapes else None))
    return shapes


def equilibrium_data(row: BeamView, shapes: list[SampledModes]) -> dict[str, Any]:
    """The body at rest of a beam at several speeds."""
    bodies = [equilibrium_body(resampled(shape, row.shapes.x), row.section) for shape in shapes]
    vertices = steps([vertices.ravel() for vertices, _ in bodies])
    return {"vertices": vertices, "faces": bodies[0][1].ravel().tolist()}


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
    if beams.second:
        titled = (beams.second, *beams.rows)
        shown += [row.title.data for row in titled if row.title.text]
    if warning := stability_warning(solution):
        shown.append({**first.warning.data, "text": warning})
    return shown


def beam_data(row: BeamView, shapes: list[SampledModes]) -> dict[str, Any]:
    """One beam with its modes, of which those that it moves in are found by their labels.

    states (4 n (1 + 2 m), speeds): axis and strain (n, 4), and their change by the real and the
    imaginary part of each mode; see `steps`.
    """
    shown, sizes, drawn = row.drawn.shown, row.drawn.amplitudes, row.drawn.shapes
    labels = [drawn.labels[k] for k in shown]
    component = 0
    if shown and drawn.solution:
        larger = int(drawn.solution.larger_component[shown[0]])
        component = 2 if larger and drawn.plane == "flapwise" else larger
    states = []
    for shape in (resampled(shape, row.shapes.x) for shape in shapes):
        at = [shape.labels.index(label) for label in labels]
        fields = np.minimum(sizes[shown], shape.limits[at])[:, None, None] * shape.modes[at]
        parts = np.stack([fields.real, fields.imag], 1).reshape(-1, *shape.centreline.shape)
        still, *moved = (state(shape, part) for part in (np.zeros_like(shape.centreline), *parts))
        states.append(np.concatenate([still, *(part - still for part in moved)]).ravel())
    return {
        **beam_record(row),
        "modes": labels,
        "equilibrium": 0,
        "states": steps(states),
        "ring": RING,
        "ring_colour": row.nodes.colour[0].tolist(),
        "component": component,
        "path": (PERIODS, MOST, SAMPLES) if row.tip_path.is_shown else None,
    }


def beam_record(row: BeamView) -> dict[str, Any]:
    """One beam, but for its motion; see offline_beam.js."""
    shapes, section = row.shapes, row.section.mean(axis=1)
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
        "turns": piece_turns(normals(shapes, shapes.x), len(section)).tolist(),
        "sections": extents(section, NORMALS[shapes.plane])[:, 1:].tolist(),
        "capped": row.capped,
        "largest": row.drawn.largest,
        "surface": surface(row) if row.overlay else None,
    }


def surface(row: BeamView) -> dict[str, Any]:
    """The surface of a beam that is drawn in one piece, as `swept` makes it."""
    count, normal = len(row.shapes.x), normals(row.shapes, row.shapes.x)
    point, sizes = rings(count, row.section)
    _, faces = swept(np.linspace([0.0, 0, 0], [1, 0, 0], count), normal, row.section)
    numbers = [(at, *size) for at, size in zip(point.tolist(), sizes.tolist(), strict=True)]
    across = np.broadcast_to(normal, (count, 3))[point]
    return {"rings": numbers, "normals": across.tolist(), "faces": faces.ravel().tolist()}


def state(shapes: SampledModes, moved: np.ndarray) -> np.ndarray:
    """Points of the axis displaced by `moved` (n, c) and the strain after each: (n, 4)."""
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
