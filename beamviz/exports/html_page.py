"""A scene as one HTML file that plays without a network, with its numbers and its loci."""

import json
import zlib
from base64 import b64encode
from html import escape
from importlib.resources import files
from pathlib import Path

import numpy as np

from beamviz.drawing import camera, colours
from beamviz.drawing.objects import captions_file
from beamviz.drawing.text import frequencies, mode_value
from beamviz.errors import BeamvizError
from beamviz.exports.solved_scene import SolvedScene
from beamviz.exports.speeds import speed_data
from beamviz.frequency_loci import loci
from beamviz.frequency_loci.identity import identify_modes
from beamviz.frequency_loci.sweep import CHART_POINTS, chart_range
from beamviz.plotting import figure_bytes
from beamviz.plotting.loci import draw_chart
from beamviz.scene import Scene
from beamviz.server import run_server
from beamviz.solver import Solution

TITLE, ROOT = "<title>Viser</title>", '<div id="root"></div>'  # of viser's page
POINTS = 72  # an inch, as SVG pictures have them
TIME = "T* = √(ρ A L⁴ / E I), the time unit of the beam"


def solution_table(solution: Solution, shown: list[int]) -> str:
    """The modes: number, label, kind, frequency, error; the ones shown are marked."""
    labels, mixtures = identify_modes(solution)
    across = f'<span title="{TIME}">{frequencies(solution.beam.units).label}</span>'
    rows = ["<tr>" + "".join(f"<th>{head}</th>" for head in ("", "mode", "kind", across, "error"))]
    for k, (label, family) in enumerate(zip(labels, solution.families, strict=True)):
        value, error = mode_value(solution, k)
        cells = [f"{k + 1}", f"<b>{label}</b>", mixtures[k] or family, value, f"{error:.0e}"]
        rows.append('<tr class="shown">' if k in shown else "<tr>")
        rows += [f"<td>{cell}</td>" for cell in cells]
    return f'<table aria-label="modes">{"".join(rows)}</table>'


def write_html(file: Path, solved: SolvedScene) -> None:
    """viser's self-contained page with a script that moves the beam at any speed (offline.js), and
    a panel with the numbers."""
    view, beam, player = solved.scene.view, solved.scene.beam, ""
    with run_server() as server:
        fitted = camera.fitted(solved.shapes, view.rotating_frame, 1.0, solved.heights)
        camera.place(server.initial_camera, solved.scene.camera or fitted)
        beams = solved.draw(server.scene)
        solved.move(beams, solved.moment())
        page = server.get_scene_serializer().as_html(dark_mode=view.dark)
    if not solved.warning:
        data = zlib.compress(json.dumps(speed_data(solved, beams)).encode())
        script = files("beamviz.exports").joinpath("offline.js").read_text(encoding="utf-8")
        player = f'<script type="text/plain" id="speeds">{b64encode(data).decode()}</script>'
        player += f"<script>{captions_file('.js')}{script}</script>"
    theme = f":root {{ color-scheme: {'dark' if view.dark else 'light'}; --scene:"
    theme += f" rgb{colours.BACKGROUND[view.dark]}; --letters: rgb{colours.LETTERS[view.dark]}; }}"
    page = page.replace(TITLE, f"<title>beamviz: {beam.described(beam.numbers)}</title>")
    elements = (
        f"<style>{theme}{captions_file('.css')}{STYLE}</style>{ROOT}"
        f'<aside aria-label="numbers">{panel(solved)}</aside><div id="caption-layer"></div>{player}'
    )
    file.write_text(page.replace(ROOT, elements), encoding="utf-8")


def panel(solved: SolvedScene) -> str:
    """The beam and the options that differ from the defaults, its modes as a table, the loci
    around it and the scene file."""
    scene, defaults = solved.scene, Scene().options
    options = ", ".join(
        f"{name} {'on' if value is True else 'off' if value is False else value}"
        for name, value in scene.options.items()
        if value != defaults[name]
    )
    return (
        f"<h1>{scene.beam.described(scene.beam.numbers)}</h1>"
        + (f"<p>{escape(options)}</p>" if options else "")
        + (f"<p class=wrong>{escape(solved.warning)}</p>" if solved.warning else CONTROLS)
        + solution_table(solved.solution, solved.shown)
        + chart(scene)
        + f"<details><summary>The scene as a file</summary><pre>{escape(scene.to_toml())}</pre>"
        "</details>"
    )


def chart(scene: Scene) -> str:
    """The loci around the scene as an SVG picture with a line at the scene, or why there are
    none."""
    try:
        values = np.linspace(*chart_range(scene.beam, scene.over), CHART_POINTS)
        found = loci(scene.beam, scene.over, values, **scene.solver_options)
    except BeamvizError as error:
        return f"<p class=wrong>{escape(str(error))}</p>"
    figure = draw_chart(found, marker=getattr(scene.beam, scene.over))
    svg = figure_bytes(figure, "svg").decode().partition("<svg")[2]
    axes, enlarge = figure.axes[0], "this.classList.toggle('large')"
    low, high = axes.get_xlim()
    step = POINTS * figure.get_figwidth() * axes.get_position().width / (high - low)
    moved = f' data-step="{step}"' if scene.over == "gamma" else ""  # of the line at the scene
    return f'<figure title="click to enlarge" onclick="{enlarge}"{moved}><svg{svg}</figure>'


CONTROLS = (
    '<p class="controls"><button id="play">Pause</button> <label for="speed">speed</label>'
    ' <input id="speed" type="range"> <output id="speed-shown" for="speed"></output></p>'
)
STYLE = """
.mantine-Notifications-root, #root button { display: none; }
#root { position: fixed !important; inset: 0 440px 0 0; width: auto !important;
        height: auto !important; background: var(--scene); }
#root div:has(canvas[data-engine]) { background: none !important; }
aside { position: fixed; inset: 0 0 0 auto; width: 440px; box-sizing: border-box; overflow: auto;
        padding: 1.2em 1.4em; font: 16px/1.45 system-ui, sans-serif; color: light-dark(#222, #ddd);
        background: light-dark(#fff, #1a1a1a); border-left: 1px solid light-dark(#ddd, #333); }
aside h1 { font-size: 1.05em; margin: 0 0 .6em; }
aside figure { margin: 1em 0; padding: .3em; border-radius: 6px; cursor: zoom-in;
               background: #fff; }
aside svg { width: 100%; height: auto; display: block; }
aside figure.large { position: fixed; inset: 3vh 3vw; margin: 0; padding: 2vh 2vw; z-index: 9;
                     cursor: zoom-out; box-shadow: 0 0 2em #0006; }
aside figure.large svg { height: 100%; }
aside table { width: 100%; border-collapse: collapse; font-size: .8em; line-height: 1.6;
              font-variant-numeric: tabular-nums; text-align: right; }
aside th { font-weight: 500; vertical-align: bottom; opacity: .65; line-height: 1.3; }
aside .shown { background: rgba(204, 60, 140, .14); }
aside .controls { display: flex; gap: .6em; align-items: center;
                  font-variant-numeric: tabular-nums; }
aside .controls input { flex: 1; min-width: 0; }
aside .controls output { min-width: 5.5em; text-align: right; }
aside .controls button { font: inherit; min-width: 4.5em; padding: .3em .6em; cursor: pointer; }
#caption-layer { position: fixed; inset: 0 440px 0 0; font: 15px/1.4 system-ui, sans-serif;
                 color: var(--letters); }
aside .wrong { border-left: 4px solid #d9480f; padding-left: .6em; white-space: pre-line; }
aside summary { cursor: pointer; opacity: .7; } aside pre { font-size: .75em; overflow: auto; }
@media (max-width: 900px) {
  #root, #caption-layer { inset: 0 0 45vh 0; }
  aside { inset: 55vh 0 0 0; width: auto; border: 0; border-top: 1px solid #ddd; }
}
"""
