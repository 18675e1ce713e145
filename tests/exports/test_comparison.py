"""A second beam in what a scene is exported to: scene files, pictures, films, pages, models and
charts have it as the page does."""

import base64
import json
import math
import re
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pygltflib
import pytest
from helpers import slow
from live.browser import page
from live.visitor import PAPER

from beamviz import InvalidInput, Ramp, animate, export, loci, motion, screenshot, solve
from beamviz.chart_ranges import chart_range
from beamviz.drawing.beam_mesh import to_hub_frame
from beamviz.drawing.comparison import SPACING, number
from beamviz.drawing.scene_graph import SceneGraph
from beamviz.dynamics.linear import motion_without_stiffening
from beamviz.explorer.second_beam import second_of
from beamviz.explorer.state import COMPARISONS, State
from beamviz.exports.chart_files import export_chart
from beamviz.exports.motion_files import export_motion
from beamviz.exports.motion_scene import MotionScene
from beamviz.exports.solved_scene import Loop, SolvedScene
from beamviz.frequency_loci.identity import identify_modes
from beamviz.scene import GIVEN, Scene, Second

HEAVY = PAPER.replace(alpha=2)
TWICE = Second(HEAVY, {}, "twice the mass", choice="mass")
BEFORE = Second(PAPER.replace(beta=0.8, gamma=3), {"strain": "biot"}, "before")


def scene_with(second: Second, **values: Any) -> Scene:
    """The beam of the paper in mode 2, with a second one."""
    return replace(Scene.of(PAPER, **{"mode": 2} | values), second=second)


# Scene files


@pytest.mark.parametrize("second", [TWICE, BEFORE, Second(None, {"coriolis": True}, stacked=True)])
def test_a_scene_file_has_the_second_beam(second):
    """Its numbers, the model it has otherwise, its title and its place."""
    scene = scene_with(second)
    assert Scene.from_bytes(scene.to_toml().encode(), "saved") == scene


def test_a_second_beam_may_be_written_by_hand():
    """What is not said of it is as of the first one; a beam may be in SI."""
    text = "[beam]\ngamma = 7\n[second.model]\ncoriolis = true\n"
    scene = Scene.from_bytes(text.encode(), "own.toml")
    assert scene.second_scene.beam == scene.beam
    assert scene.second_scene.options == scene.options | {"coriolis": True}
    text = "[second.si]\nlength = 2\nmass_per_length = 3\nbending_stiffness = 2500\n"
    scene = Scene.from_bytes(f"{text}axial_stiffness = 8e7\n".encode(), "own.toml")
    assert scene.second_scene.beam.units.length == 2


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[second]\nchoice = 'none'", "choice = 'none'"),
        ("[second]\ncolour = 1", "unknown key 'colour'"),
        ("[second.beam]\nalpha = -1", "alpha = -1"),
        ("[second.beam]\nrho = 1", "unknown key 'rho'"),
        ("[second.model]\nstrain = 'none'", "strain = 'none'"),
        ("[second]\nmodel = 1", "second.model = 1"),
        ("[second]\nstacked = 1", "stacked = 1"),
        (f"[second]\ntitle = '{'a' * 101}'", "title ="),
    ],
)
def test_a_wrong_second_beam_is_named(text, words):
    with pytest.raises(InvalidInput, match=re.escape(words)):
        Scene.from_bytes(text.encode(), "own.toml")


@pytest.mark.parametrize("choice", COMPARISONS[1:])
@pytest.mark.parametrize("stacked", [False, True])
def test_the_page_saves_and_loads_its_comparison(choice, stacked):
    """Each choice comes back as that choice, a beam that was kept with its own numbers."""
    state = State.of(Scene.of(PAPER, mode=3)).keep().changed("alpha", 3.0)
    state = state.changed("stacked", stacked).changed("comparison", choice)
    saved = replace(state.to_scene(), second=second_of(state))
    loaded = State.of(Scene.from_bytes(saved.to_toml().encode(), "saved"))
    assert (loaded.comparison, loaded.stacked) == (choice, stacked)
    assert (loaded.kept.beam if loaded.kept else None) == (PAPER if choice == GIVEN else None)
    assert second_of(loaded) == saved.second
    if choice == "mass":
        assert saved.second_scene.beam.alpha == 6
    if choice == "coriolis":
        assert saved.second_scene.options["coriolis"]


# Pictures and films


def test_beams_above_each_other_count_their_periods():
    """From 0 at the start of a film, as many as it has of the mode, more of the lighter beam."""
    solved = SolvedScene(scene_with(replace(TWICE, stacked=True)))
    beams, film = solved.draw(SceneGraph()), Loop(solved, periods=4)
    solved.move(beams, film.moment(0.0))
    assert {"this beam", "twice the mass"} <= {caption.text for caption in beams.captions}
    solved.move(beams, film.moment(0.9999))
    ratio = solve(HEAVY).frequencies[1] / solved.solution.frequencies[1]
    texts = [caption.text for caption in beams.captions]
    assert "this beam: 3 periods of B2" in texts
    assert f"twice the mass: {int(4 * ratio)} periods of B2" in texts


@pytest.mark.parametrize("stacked", [False, True])
def test_a_picture_shows_both_beams(tmp_path, stacked):
    """At the same phase of their common mode, over each other or one above the other; beside all
    modes only the first one, as on the page."""
    scene = scene_with(replace(TWICE, stacked=stacked))
    solved = SolvedScene(scene)
    beams = solved.draw(SceneGraph())
    solved.move(beams, solved.moment(0.25))
    assert beams.second.frame.position[2] == (SPACING / 2 if stacked else 0)
    heavy = solve(HEAVY)
    shapes = beams.second.shapes
    shape = heavy.shape(1, shapes.x)
    moved = scene.view.amplitude * shape / np.linalg.norm(shape, axis=1).max()
    line, _ = to_hub_frame(shapes, shapes.centreline + moved)
    assert beams.second.line == pytest.approx(line, abs=2e-3)
    assert "twice the mass" in [caption.text for caption in beams.captions]
    paths = [tmp_path / f"{name}.png" for name in ("two", "one", "rows", "alone")]
    rows = scene.changed(all_modes=True)
    for path, one in zip(
        paths, (scene, replace(scene, second=None), rows, replace(rows, second=None)), strict=True
    ):
        screenshot(path, one, 160, 90)
    two, one, in_rows, alone = (path.read_bytes() for path in paths)
    assert two != one
    assert in_rows == alone


@pytest.mark.parametrize(
    ("alpha", "mode", "rotating_frame"),
    [(0.0, 1, False), (1.5, 2, False), (2.0, 2, True), (4.0, 1, True)],
)
def test_two_frequencies_stay_two_in_a_film(alpha, mode, rotating_frame):
    """Both modes make whole cycles, of different numbers, whose ratio is that of the frequencies to
    5 %, or to half of their difference; in at most 15 s."""
    second = Second(PAPER.replace(alpha=alpha), {}, "other")
    solved = SolvedScene(scene_with(second, mode=mode, rotating_frame=rotating_frame))
    loop = Loop(solved)
    (j,) = solved.pair.second.shown
    cycles = loop.phases[mode - 1] / math.tau, loop.other_phases[j] / math.tau
    assert cycles == pytest.approx(np.rint(cycles), abs=1e-9)
    assert round(cycles[0]) != round(cycles[1])
    ratio = solved.second.frequencies[j] / solved.solution.frequencies[mode - 1]
    assert cycles[1] / cycles[0] / ratio == pytest.approx(1, abs=min(0.05, abs(ratio - 1) / 2))
    assert loop.seconds <= 15
    assert loop.moment(0.0).other_phases == pytest.approx(solved.moment().other_phases)


@pytest.mark.slow
def test_a_film_is_of_both_beams(tmp_path):
    """It is another one than that of the first beam alone, and names what it has changed."""
    options: dict[str, Any] = {"width": 96, "height": 64, "fps": 5.0}
    loop = animate(tmp_path / "two.webp", scene_with(TWICE), **options)
    animate(tmp_path / "one.webp", Scene.of(PAPER, mode=2), **options)
    assert (tmp_path / "two.webp").read_bytes() != (tmp_path / "one.webp").read_bytes()
    assert "B2 of 'twice the mass'" in loop.note


# Pages


def data_of(path: Path, name: str = "speeds") -> dict[str, Any]:
    """What the script of a page plays."""
    (found,) = re.findall(f'id="{name}">(.*?)</script>', path.read_text())
    return json.loads(zlib.decompress(base64.b64decode(found)))


@pytest.mark.parametrize("second", [TWICE, replace(BEFORE, stacked=True), *slow(BEFORE)])
def test_a_page_has_the_second_beam_at_any_speed(tmp_path, second):
    """Its axis and the frequency it moves with are those of a solution there, or for a beam that
    was kept of that; the table has both frequencies, and the chart both loci."""
    export(tmp_path / "a.html", scene := scene_with(second))
    data, other = data_of(tmp_path / "a.html"), scene.second_scene
    _, beam = data["beams"]
    assert (beam["surface"] is None) is second.stacked
    for k in (3, len(data["gammas"]) - 4):
        speed = {} if second.choice == GIVEN else {"gamma": data["gammas"][k]}
        there = solve(other.beam.replace(**speed), **other.solver_options)
        (mode,) = beam["modes"]
        label = mode.removeprefix("second ")
        frequency = there.frequencies[there.labels.index(label)]
        assert data["frequencies"][mode][k] == pytest.approx(frequency, rel=1e-5)
        states = data["resolution"] * np.cumsum(np.cumsum(beam["states"], axis=1), axis=1).T
        axis = states[k].reshape(3, -1, 4)[0]
        tip = there.equilibrium.tip[0] + other.beam.delta
        assert axis[-1, 0] == pytest.approx(tip, abs=2e-5)
        cells = re.findall(r"<td>([^<]*)</td>", data["numbers"][k].partition("compared")[2])
        assert number(frequency) in cells
    text = (tmp_path / "a.html").read_text()
    assert text.count("stroke: #b4b4b4") == 5  # in the chart
    titles = [[one["text"] for one in at] for at in data["captions"]]
    assert all(second.title in at for at in titles)


@pytest.mark.parametrize(
    ("second", "words"),
    [
        (Second(PAPER.replace(gamma=60), {"strain": "hencky"}, "fast"), "fast: No equilibrium"),
        *slow(
            (Second(PAPER.replace(delta=-1, gamma=10), {}, "inward", choice="mass"), "inward: not")
        ),
    ],
)
def test_a_page_says_why_there_is_no_second_beam(tmp_path, second, words):
    """That has no equilibrium, or no stable one at some speed; the first one is played."""
    export(tmp_path / "a.html", scene_with(second))
    data = data_of(tmp_path / "a.html")
    assert len(data["beams"]) == 1
    assert any(f'<p class="wrong">{words}' in text for text in data["numbers"])


@pytest.mark.slow
@pytest.mark.parametrize("second", [TWICE, replace(BEFORE, stacked=True)])
def test_a_page_draws_the_second_beam_as_a_picture_does(tmp_path, second):
    """The script puts it where the renderer has it, before it is played; and it then moves. The
    browser complains of nothing."""
    export(tmp_path / "a.html", scene := scene_with(second))
    solved = SolvedScene(scene)
    beams = solved.draw(SceneGraph())
    solved.move(beams, solved.moment(0.25))
    root = beams.second.frame.name
    node = f"window.__viserMutable?.nodeRefFromName?.['{root}/rotor/{{}}']"
    body, mass = node.format("body"), node.format("mass")
    corners = f"""(() => {{ let found; {body}?.traverse(n => {{
        found ??= n.geometry?.attributes?.position?.array; }});
      return found && Array.from(found); }})()"""
    places = f"""(() => {{ let found; {mass}?.traverse(n => {{
        found ??= n.matricesTexture?._data; }});
      return found && Array.from(found.slice(0, 16)); }})()"""
    shown_part = places if second.stacked else corners
    with page("about:blank", 500, 400) as shown:
        still = [{"name": "prefers-reduced-motion", "value": "reduce"}]
        shown.call("Emulation.setEmulatedMedia", features=still)
        shown.call("Page.navigate", url=(tmp_path / "a.html").as_uri())
        if second.stacked:
            place = beams.second.line[beams.second.bodies.at[0]]
            shown.wait(lambda: close(shown.evaluate(places), place), 120)
        else:
            drawn = np.unique(beams.second.body.vertices, axis=0)

            def alike() -> bool:
                found = np.array(shown.evaluate(corners) or [], float).reshape(-1, 3)
                if not len(found):
                    return False
                far = np.abs(found[:, None] - drawn).max(axis=2).min(axis=0)
                return len(found) >= len(drawn) and far.max() < 1e-3

            shown.wait(alike, 120)
        before = shown.evaluate(shown_part)
        shown.evaluate("document.getElementById('play').click()")
        shown.wait(lambda: shown.evaluate(shown_part) != before)
        assert shown.problems == []


def close(matrix: list[float] | None, place: np.ndarray) -> bool:
    """Whether the matrix of a node has it at a place."""
    return matrix is not None and np.allclose(matrix[12:15], place, atol=1e-3)


# Models, charts


@pytest.mark.parametrize("stacked", [False, True])
def test_a_model_has_both_beams(tmp_path, stacked):
    """The second one swings by its own morph targets, with its mass at its place; drawn over the
    first it is translucent, above it has a hub."""
    export(tmp_path / "a.glb", scene_with(replace(BEFORE, stacked=stacked)))
    gltf = pygltflib.GLTF2().load(tmp_path / "a.glb")
    nodes = {node.name: node for node in gltf.nodes}
    assert ("second hub" in nodes) is stacked
    assert nodes["second"].translation == [0, 0, SPACING if stacked else 0]
    mesh = gltf.meshes[nodes["second beam"].mesh]
    assert mesh.extras["targetNames"] == ["B1", "B1-"] or mesh.extras["targetNames"] == [
        "B2",
        "B2-",
    ]
    surface = gltf.materials[mesh.primitives[0].material]
    assert (surface.alphaMode == "BLEND") is not stacked
    place = solve(BEFORE.beam, strain="biot").equilibrium.position([0.8])[0]
    assert nodes["second mass"].translation[0] == pytest.approx(place[0], abs=0.05)
    (animation,) = gltf.animations
    moved = {gltf.nodes[channel.target.node].name for channel in animation.channels}
    assert {"beam", "mass", "second beam", "second mass"} <= moved


def chart_of(tmp_path: Path, scene: Scene, suffix: str) -> str:
    """The text of the chart of a scene."""
    export_chart(tmp_path / f"chart{suffix}", scene)
    return (tmp_path / f"chart{suffix}").read_text()


def test_a_chart_is_a_table_of_both_beams(tmp_path):
    """Of the range of the page, with events, model and beam in comments; read by pandas."""
    scene = scene_with(TWICE, per_rev=[1, 2])
    text = chart_of(tmp_path, scene, ".csv")
    table = pandas.read_csv(tmp_path / "chart.csv", comment="#")
    assert (table["gamma"].iloc[0], table["gamma"].iloc[-1]) == chart_range(PAPER, "gamma")
    for prefix, beam in (("", PAPER), ("twice the mass: ", HEAVY)):
        found = loci(beam, "gamma", table["gamma"].to_numpy())
        for branch in found.branches:
            column = table[f"{prefix}{branch.label}"]
            assert column.to_numpy() == pytest.approx(branch.frequency, rel=1e-6)
    comments = [line for line in text.splitlines() if line.startswith("#")]
    assert any("alpha 1, beta 0.5, delta 0, mu 70" in line for line in comments)
    assert any("crossing" in line and "9.373" in line for line in comments)
    assert any("resonance 2x" in line for line in comments)


def test_a_chart_is_a_picture_of_both_beams(tmp_path):
    """With the loci of both, their names, per-rev lines and a line at the beam."""
    scene = scene_with(TWICE, per_rev=[3])
    text = chart_of(tmp_path, scene, ".svg")
    alone = chart_of(tmp_path, replace(scene, second=None), ".svg")
    for words in ("B4", "S1", "3×", "bending", "crossing"):
        assert f"<!-- {words} -->" in text
    assert ("<!-- twice the mass -->" in text, "<!-- twice the mass -->" in alone) == (True, False)
    assert text.count('id="marker"') == 1
    assert text.count("stroke: #b4b4b4") - alone.count("stroke: #b4b4b4") == 6  # and in the legend
    export_chart(tmp_path / "chart.png", scene)
    assert (tmp_path / "chart.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(InvalidInput, match="must end in"):
        export_chart(tmp_path / "chart.gif", scene)


def test_the_lines_of_a_chart_have_the_names_of_the_page(tmp_path):
    """At their ends those of the shapes there: beyond its veering with S1 the higher one is B3,
    though its branch is the one that is S1 at rest."""
    text = chart_of(tmp_path, Scene.of(PAPER, coriolis=True), ".svg")
    found = re.findall(r"<!-- ([SB]\d) -->.{0,200}?translate\([\d.]+ ([\d.]+)\)", text, re.DOTALL)
    heights = {name: float(y) for name, y in found}  # from above
    solution = solve(PAPER.replace(gamma=20), coriolis=True)
    assert sorted(heights, key=heights.get, reverse=True) == [*identify_modes(solution).labels]


# Motions in time


@pytest.mark.slow
def test_files_of_a_motion_have_the_theory_without_stiffening(tmp_path):
    """In a film and a page as a second beam that is where the theory has it, until it diverges; in
    the chart as a second line."""
    given: dict[str, Any] = {"speed": Ramp(6, 6), "tolerance": 1e-2}
    true, linear = motion(PAPER, 4, **given), motion_without_stiffening(PAPER, 4, **given)
    assert linear.t[-1] < 4
    scene = MotionScene(true, linear)
    beams = scene.draw(SceneGraph())
    for t in (1.0, 2.0, 4.0):
        scene.move(beams, t)
        (tip,) = linear.position([min(t, linear.t[-1])], [1.0])[:, 0]
        assert beams.second.line[-1, :2] == pytest.approx(tip, abs=5e-3)
    assert "without stiffening (diverges)" in [caption.text for caption in beams.captions]
    export_motion(tmp_path / "a.html", true, unstiffened=linear)
    data = data_of(tmp_path / "a.html", "motion")
    _, beam = data["beams"]
    fields, parts = (
        data["resolution"] * np.cumsum(np.cumsum(beam[name], axis=1), axis=1)
        for name in ("fields", "parts")
    )
    k = len(parts[0]) // 3
    t = data["readings"][0]["values"][k]
    axis = (fields[0] + parts.T[k] @ fields[1:]).reshape(-1, 4)
    assert axis[-1, :2] == pytest.approx(linear.position([t], [1.0])[0, 0], abs=5e-3)
    for name, second in (("two", linear), ("one", None)):
        export_motion(tmp_path / f"{name}.svg", true, unstiffened=second)
    two, one = ((tmp_path / f"{name}.svg").read_text() for name in ("two", "one"))
    assert ("without stiffening" in two, "without stiffening" in one) == (True, False)
