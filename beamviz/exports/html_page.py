"""A scene as one HTML file that plays without a network: the film in 3D, its loci, its modes."""

import io
import re
from html import escape
from pathlib import Path

from matplotlib import rc_context

from beamviz.beam import PARAMETERS
from beamviz.drawing import camera
from beamviz.errors import BeamvizError
from beamviz.exports.html_tables import solution_table
from beamviz.exports.loop import looped
from beamviz.exports.renderer import Set
from beamviz.exports.solved_scene import Moment, Shot
from beamviz.frequency_loci import Loci
from beamviz.frequency_loci.chart_range import loci_around
from beamviz.plotting.loci import draw_chart
from beamviz.plotting.style import STYLE as CHART_STYLE
from beamviz.scene import Scene
from beamviz.server import run_server

FRAME_RATE = 30.0  # [1/s]
MAX_FRAMES = 360


def write_html(file: Path, shot: Shot) -> None:
    """The page of viser, which holds all it needs, with the recorded film and a panel of ours."""
    view = shot.scene.view
    with run_server() as server:
        aside = panel(shot)
        fitted = camera.fitted(shot.shapes, view.rotating_frame, 1.0)
        camera.place(server.initial_camera, shot.scene.camera or fitted)
        stage, recorder = Set(server.scene, shot), server.get_scene_serializer()
        for moment, seconds in moments(shot):
            stage.move(moment)
            recorder.insert_sleep(seconds)
        page = recorder.as_html(dark_mode=view.dark)
    head, body = page.index("</head>"), page.rindex("</body>")
    mode = "dark" if view.dark else "light"
    title = f"<title>beamviz: {escape(heading(shot.scene))}</title>"
    top = re.sub("<title>.*?</title>", title, page[:head])  # of two, browsers take the first
    file.write_text(
        f"{top}<style>{STYLE}</style>{page[head:body]}"
        f'<aside class="{mode}" aria-label="numbers">{aside}</aside>{page[body:]}'
    )


def moments(shot: Shot) -> list[tuple[Moment, float]]:
    """The film with the seconds that each of its moments stays."""
    if shot.words:
        return [(shot.moment(0.0), 1.0)]
    loop = looped(shot)
    count = min(round(loop.seconds * FRAME_RATE), MAX_FRAMES)
    return [(loop.moment(k / count), loop.seconds / count) for k in range(count)]


def panel(shot: Shot) -> str:
    """What is seen, its modes as a table, and the loci around it."""
    scene = shot.scene
    words = f"<p class=wrong>{escape(shot.words)}</p>" if shot.words else ""
    model = ", ".join(f"{key} {value}" for key, value in unusual(scene).items())
    return (
        f"<h1>{escape(heading(scene))}</h1>"
        + (f"<p>{escape(model)}</p>" if model else "")
        + words
        + solution_table(shot.solution, shot.shown)
        + chart(scene)
        + f"<details><summary>The scene as a file</summary><pre>{escape(scene.to_toml())}</pre>"
        "</details>"
    )


def heading(scene: Scene) -> str:
    """The five numbers."""
    return ", ".join(
        f"{PARAMETERS[name].symbol} = {x:.6g}" for name, x in scene.beam.numbers.items()
    )


def unusual(scene: Scene) -> dict[str, object]:
    """The choices of the model that are not as usual."""
    usual = Scene().options
    return {
        name: "on" if value is True else "off" if value is False else value
        for name, value in scene.options.items()
        if value != usual[name]
    }


def chart(scene: Scene) -> str:
    """The loci around the scene as an SVG picture, or why there are none."""
    try:
        loci = loci_around(scene.beam, scene.over, **scene.solver_options)
    except BeamvizError as error:
        return f"<p class=wrong>{escape(str(error))}</p>"
    enlarge = "this.classList.toggle('large')"
    return f'<figure title="click to enlarge" onclick="{enlarge}">{svg(loci, scene)}</figure>'


def svg(loci: Loci, scene: Scene) -> str:
    """A loci chart as an element of a page, an upright line where the scene is."""
    text = io.StringIO()
    with rc_context(CHART_STYLE):
        figure = draw_chart(loci, marker=getattr(scene.beam, scene.over))
        figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()[text.getvalue().index("<svg") :]


STYLE = """
#root { position: fixed !important; inset: 0 440px 0 0; width: auto !important; }
aside { position: fixed; inset: 0 0 0 auto; width: 440px; box-sizing: border-box; overflow: auto;
        padding: 1.2em 1.4em; font: 16px/1.45 system-ui, sans-serif; background: #fff;
        color: #222; border-left: 1px solid #ddd; }
aside.dark { background: #1a1a1a; color: #ddd; border-color: #333; }
aside h1 { font-size: 1.05em; margin: 0 0 .6em; }
aside figure { margin: 1em 0; } aside svg { width: 100%; height: auto; display: block; }
aside figure { cursor: zoom-in; background: #fff; }
aside figure.large { position: fixed; inset: 3vh 3vw; margin: 0; padding: 2vh 2vw; z-index: 9;
                     cursor: zoom-out; box-shadow: 0 0 2em #0006; }
aside figure.large svg { height: 100%; }
aside.dark figure { border-radius: 6px; padding: .3em; }
aside table { width: 100% !important; margin: 0 !important; }
aside .wrong { border-left: 4px solid #d9480f; padding-left: .6em; white-space: pre-line; }
aside summary { cursor: pointer; opacity: .7; } aside pre { font-size: .75em; overflow: auto; }
@media (max-width: 900px) {
  #root { inset: 0 0 45vh 0; }
  aside { inset: 55vh 0 0 0; width: auto; border: 0; border-top: 1px solid #ddd; }
}
"""
