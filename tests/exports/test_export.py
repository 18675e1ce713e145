"""Exports, each opened by a reader of its kind: pages, models, numbers."""

import base64
import io
import itertools
import json
import math
import re
import socket
import struct
import sys
import threading
import zlib
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pandas
import pygltflib
import pytest
import trimesh
from helpers import slow
from live.browser import Page, page
from live.visitor import PAPER
from PIL import Image
from scipy.spatial.transform import Rotation

from beamviz.beam import Beam
from beamviz.chart_ranges import chart_range
from beamviz.drawing.beam_mesh import to_hub_frame
from beamviz.drawing.modes import displacement
from beamviz.drawing.scene_graph import SceneGraph
from beamviz.drawing.sizes import section_size, sections
from beamviz.drawing.text import error_digits, measure
from beamviz.dynamics import motion
from beamviz.errors import InvalidInput, Unavailable
from beamviz.exports import animate, export, screenshot
from beamviz.exports.html_page import player
from beamviz.exports.motion_files import animate_motion
from beamviz.exports.offline_data import OfflineSpeeds
from beamviz.exports.solved_scene import Loop, SolvedScene
from beamviz.scene import Scene
from beamviz.solver import solve
from beamviz.solver.problem import MAX_MODES
from beamviz.solver.solution import STATIONS

PITCHED = Beam(flap=0.25, pitch=30, gamma=5)
PATH: dict[str, Any] = {"plane": "both", "shares": [1.0, 0.5], "tip_path": True}
BLADE = Beam.from_si(  # with a jump, two bodies and a sprung root
    stations=[0, 4, 4, 10],
    mass_per_length=[100, 90, 50, 20],
    bending_stiffness=[8e5, 6e5, 2e5, 5e4],
    axial_stiffness=[4e8, 3.4e8, 2e8, 1e8],
    hub_radius=2,
    rotation_rpm=30,
    masses=[
        {"mass": 200, "position": 5, "inertia": [5, 20, 20]},
        {"mass": 50, "position": 10},
    ],
    root_stiffness=1e6,
)


def values(gltf: pygltflib.GLTF2, index: int) -> np.ndarray:
    """The numbers (n, k) of an accessor, within its limits."""
    accessor = gltf.accessors[index]
    view, blob = gltf.bufferViews[accessor.bufferView], gltf.binary_blob()
    kind = {5126: np.float32, 5125: np.uint32}[accessor.componentType]
    found = np.frombuffer(blob[view.byteOffset : view.byteOffset + view.byteLength], kind)
    found = found.reshape(accessor.count, {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor.type])
    assert found.min(axis=0) == pytest.approx(accessor.min)
    assert found.max(axis=0) == pytest.approx(accessor.max)
    return found


def by_name(entries: list, name: str):
    """The node or mesh of a name."""
    return next(entry for entry in entries if entry.name == name)


def read_csv(file: Path) -> dict[str, np.ndarray]:
    """The columns of a table by their heads, as pandas reads it."""
    table = pandas.read_csv(file, comment="#")
    return {name: table[name].to_numpy() for name in table}


def close(numbers: np.ndarray) -> Any:
    """These numbers, to what a reader may round."""
    return pytest.approx(numbers, rel=1e-14, abs=1e-300)


@pytest.fixture(scope="module", params=[False, True], ids=["plain", "coriolis"])
def model(request, tmp_path_factory) -> tuple[Path, pygltflib.GLTF2, SolvedScene]:
    """A model of modes 1 and 3 as a file, its content, and the solved scene that it shows."""
    scene = Scene.of(PAPER, coriolis=request.param, shares=[0.5, 0.0, 1.0], rotating_frame=False)
    path = tmp_path_factory.mktemp("models") / "beam.glb"
    export(path, scene)
    return path, pygltflib.GLTF2().load(path), SolvedScene(scene)


def test_a_model_swings_as_the_solution_does(model):
    """At each key of the animation, morph targets and weights put the beam's axis and the mass
    where the solution has them; the end is the beginning."""
    _, gltf, solved = model
    primitive = by_name(gltf.meshes, "beam").primitives[0]
    rest = values(gltf, primitive.attributes.POSITION)
    targets = [values(gltf, target["POSITION"]) for target in primitive.targets]
    (animation,) = gltf.animations
    samplers = {
        f"{gltf.nodes[c.target.node].name} {c.target.path}": animation.samplers[c.sampler]
        for c in animation.channels
    }
    swing = samplers.pop("beam weights")
    turns, masses, tilts = (
        values(gltf, samplers.pop(name).output)
        for name in ("wheel rotation", "mass translation", "mass rotation")
    )
    assert not samplers
    times = values(gltf, swing.input)[:, 0]
    weights = values(gltf, swing.output).reshape(len(times), len(targets))
    loop = Loop(solved, film=False)
    shapes = solved.draw(SceneGraph()).rows[0].shapes
    assert times[-1] == pytest.approx(loop.seconds)
    assert weights[-1] == pytest.approx(weights[0], abs=1e-6)
    assert weights.min() == 0  # Blender takes no other: the beam would swing to one side only
    assert weights.max() <= 1
    for k in range(0, len(times), 7):
        moment = loop.moment(times[k] / times[-1])
        moved = displacement(shapes, moment.phases, solved.drawn.amplitudes)
        axis = to_hub_frame(shapes, shapes.centreline + moved)[0]
        corners = rest + np.tensordot(weights[k], targets, 1)
        assert corners.reshape(-1, 4, 3).mean(axis=1) == pytest.approx(axis, abs=1e-5)
        assert masses[k] == pytest.approx(axis[shapes.mass], abs=1e-5)
        along = axis[shapes.mass + 1] - axis[shapes.mass]
        ahead = Rotation.from_quat(tilts[k]).apply([1, 0, 0])
        assert ahead == pytest.approx(along / np.linalg.norm(along), abs=0.02)
    assert np.linalg.norm(turns, axis=1) == pytest.approx(1)
    assert abs(turns[0] @ turns[-1]) == pytest.approx(1)


def test_a_model_keeps_the_rules_of_gltf(model):
    """What the specification asks of the container and its views. Trimesh reads hub, beam and mass;
    the beam is closed, faces outwards, and reaches from the clamp to its stretched tip."""
    path, gltf, solved = model
    blob = path.read_bytes()
    assert struct.unpack("<4sII", blob[:12]) == (b"glTF", 2, len(blob))
    assert gltf.buffers[0].byteLength == len(gltf.binary_blob())
    assert all(view.byteOffset % 4 == 0 for view in gltf.bufferViews)
    mesh = by_name(gltf.meshes, "beam")
    colours = values(gltf, mesh.primitives[0].attributes.COLOR_0)
    assert 0 <= colours.min() < colours.max() <= 1
    names = mesh.extras["targetNames"]
    assert names[:2] == ["B1", "B1-"]
    assert len(names) == len(mesh.weights) == len(mesh.primitives[0].targets)
    assert [material.name for material in gltf.materials] == ["hub", "beam", "mass"]
    for mesh in gltf.meshes:
        for primitive in mesh.primitives:
            indices = values(gltf, primitive.indices)
            assert indices.max() < gltf.accessors[primitive.attributes.POSITION].count
    read = trimesh.load(path).geometry
    assert set(read) == {"hub", "beam", "mass"}
    assert all(read[name].is_volume for name in ("beam", "mass"))
    length = solved.solution.equilibrium.tip[0]
    assert read["beam"].bounds[:, 0] == pytest.approx([0, length], rel=1e-5, abs=1e-6)
    assert read["beam"].volume == pytest.approx(length * math.prod(section_size(PAPER)), rel=1e-5)


def test_a_model_has_the_path_of_the_tip(tmp_path):
    """A line through the tip of the beam at each key of the animation."""
    scene = Scene.of(PITCHED, coriolis=True, **PATH)
    export(tmp_path / "a.glb", scene)
    gltf, solved = pygltflib.GLTF2().load(tmp_path / "a.glb"), SolvedScene(scene)
    (line,) = by_name(gltf.meshes, "tip's path").primitives
    assert line.mode == pygltflib.LINE_STRIP
    points, loop = values(gltf, line.attributes.POSITION), Loop(solved, film=False)
    beams = solved.draw(SceneGraph())
    for k in range(0, len(points), 5):
        solved.move(beams, loop.moment(k / (len(points) - 1)))
        assert points[k] == pytest.approx(beams.rows[0].line[-1], abs=1e-6)


def test_an_unstable_beam_is_a_still_model_and_has_growth_rates(tmp_path):
    """Grey, without an animation; in the table no frequency, but a growth rate."""
    for suffix in ("glb", "csv"):
        export(tmp_path / f"a.{suffix}", Scene.of(delta=-1, gamma=5))
    gltf = pygltflib.GLTF2().load(tmp_path / "a.glb")
    assert not gltf.animations
    colours = values(gltf, by_name(gltf.meshes, "beam").primitives[0].attributes.COLOR_0)
    assert np.ptp(colours, axis=0) == pytest.approx(0)
    table = read_csv(tmp_path / "a.csv")
    assert np.isnan(table["frequency [1/T*]"][0])
    assert table["growth rate [1/T*]"][0] > 0


@pytest.mark.parametrize("coriolis", [False, True])
def test_csv_and_npz_hold_the_solution(tmp_path, coriolis):
    """Read by pandas and numpy, both are what `solve` says, to the last digit. A table has a line
    for each mode, the other for each place along the beam; both state the beam and the model."""
    scene = Scene.of(PAPER.replace(beta=0.503), coriolis=coriolis)
    solution = solve(scene.beam, coriolis=coriolis)
    export(tmp_path / "a.npz", scene)
    files = export(tmp_path / "a.csv", scene)
    assert files == [tmp_path / "a.csv", tmp_path / "a.shapes.csv"]
    modes, along = map(read_csv, files)
    for file in files:
        stated = [line for line in file.read_text().splitlines() if line.startswith("# ")]
        assert any("alpha 1, beta 0.503, gamma 10, delta 0, mu 70" in line for line in stated)
        assert any("Coriolis" in line and "green strain" in line for line in stated)
    arrays = np.load(tmp_path / "a.npz", allow_pickle=False)
    x = arrays["x"]
    assert len(x) == STATIONS + 1  # the mass lies between two of the stations
    assert modes["label"].tolist() == [*solution.labels]
    assert modes["frequency [1/T*]"] == close(solution.frequencies)
    assert along["x [L]"] == close(x)
    assert along["stretch"] == close(solution.equilibrium.stretch(x))
    for k, label in enumerate(solution.labels):
        shape = solution.shape(k, x)
        for name, column in zip(("along", "across"), shape.T, strict=True):
            assert along[f"{label} {name}"] == close(column.real)
            assert not coriolis or along[f"{label} {name}, imaginary"] == close(column.imag)
        assert (arrays["shapes"][k] == shape).all()
    assert (arrays["frequencies"] == solution.frequencies).all()
    assert (arrays["position"] == solution.equilibrium.position(x)).all()
    assert tuple(arrays["labels"]) == solution.labels
    assert dict(zip(arrays["beam_names"], arrays["beam"], strict=True)) == scene.beam.numbers


def test_exports_of_a_real_beam_are_in_si(tmp_path):
    """Beside the numbers without dimension: Hz, and places in m; a model is in metres."""
    beam = Beam.from_si(
        length=2.0,
        density=7850.0,
        area=4e-4,
        second_moment=1.2e-8,
        youngs_modulus=2.1e11,
        section_height=0.02,
        rotation_rpm=300.0,
    )
    for ending in ("csv", "npz", "glb"):
        export(tmp_path / f"a.{ending}", Scene(beam))
    hertz = beam.units.hertz(solve(beam).frequencies)
    arrays = np.load(tmp_path / "a.npz", allow_pickle=False)
    assert (arrays["frequencies_hertz"] == hertz).all()
    assert (arrays["x_m"] == 2 * arrays["x"]).all()
    assert (arrays["position_m"] == 2 * arrays["position"]).all()
    assert Beam.from_si(**json.loads(str(arrays["si"]))) == beam
    modes, along = read_csv(tmp_path / "a.csv"), read_csv(tmp_path / "a.shapes.csv")
    assert modes["frequency [Hz]"] == close(hertz)
    assert modes["frequency [rad/s]"] == pytest.approx(2 * math.pi * hertz)
    inward = solve(Beam(gamma=5, delta=-1, units=beam.units))
    export(tmp_path / "inward.csv", Scene(inward.beam))
    grows = read_csv(tmp_path / "inward.csv")["growth rate [1/s]"]
    assert grows[0] == pytest.approx(inward.growth_rates[0] / beam.units.time)
    assert along["position along [m]"] == close(2 * along["position along [L]"])
    newtons = beam.units.newtons(solve(beam).equilibrium.force(along["x [L]"]))
    assert newtons.max() > 1
    assert along["force [N]"] == pytest.approx(newtons)
    assert along["axial stress [Pa]"] == pytest.approx(newtons / 4e-4)
    assert (along["bending stress [Pa]"] == 0).all()
    assert arrays["force_newtons"] == pytest.approx(beam.units.newtons(arrays["force"]))
    assert arrays["axial_stress_pascals"] == pytest.approx(newtons / 4e-4)
    assert "length = 2, density = 7850," in (tmp_path / "a.csv").read_text()
    extent = np.ptp(trimesh.load(tmp_path / "a.glb").bounds, axis=0)
    assert extent.max() == pytest.approx(2.0, rel=0.1)  # with a part of the hub


def test_a_model_of_a_blade_is_in_metres(tmp_path):
    """Closed, of the volume of its sections, and each body at its place on the still beam."""
    scene = Scene.of(BLADE, shares=[0.0], rotating_frame=False)
    export(tmp_path / "a.glb", scene)
    gltf = pygltflib.GLTF2().load(tmp_path / "a.glb")
    length = BLADE.units.length
    root = gltf.nodes[gltf.scenes[0].nodes[0]]
    assert root.scale == [length] * 3
    up = Rotation.from_quat(root.rotation).apply([0, 0, 1])  # of our scenes; glTF's is y
    assert up == pytest.approx([0, 1, 0], abs=1e-6)
    read = trimesh.load(tmp_path / "a.glb").geometry
    assert set(read) == {"hub", "beam", "mass 1", "mass 2", "fork", "pin", "spring"}
    assert read["beam"].is_volume
    attributes = by_name(gltf.meshes, "beam").primitives[0].attributes
    colours, corners = (values(gltf, k) for k in (attributes.COLOR_0, attributes.POSITION))
    assert len(colours) == len(corners)
    x = np.linspace(0, 1, 2001)  # 0.4, where the section jumps, is one of them
    areas = sections(BLADE, "chordwise", x).prod(axis=2).mean(axis=1)
    stretched = solve(BLADE).equilibrium.stretch((x[1:] + x[:-1]) / 2)
    volume = (areas * stretched * np.diff(x)).sum()
    assert read["beam"].volume == pytest.approx(volume, rel=2e-3)
    for k, body in enumerate(BLADE.masses, 1):
        place = length * (BLADE.delta + solve(BLADE).equilibrium.position([body.beta])[0, 0])
        assert length * by_name(gltf.nodes, f"mass {k}").translation[0] == pytest.approx(place)
        assert place == pytest.approx(length * (BLADE.delta + body.beta), rel=0.01)


@pytest.fixture(scope="module")
def document(tmp_path_factory) -> Path:
    """A page of a short film."""
    path = tmp_path_factory.mktemp("pages") / "beam.html"
    export(path, Scene.of(PAPER, mode=2, pace=2.0, per_rev=[1, 3]))
    return path


def speeds_of(document: Path) -> dict[str, Any]:
    """What the script of a page plays."""
    (packed,) = re.findall('id="speeds">(.*?)</script>', document.read_text())
    return json.loads(zlib.decompress(base64.b64decode(packed)))


def test_a_page_needs_nothing_but_itself(document):
    """The table, the chart and the scene are in it; nothing is loaded from elsewhere."""
    text = document.read_text()
    head = text[text.index("<aside") :]
    solution = solve(PAPER)
    for k, label in enumerate(solution.labels):
        assert f"<b>{label}</b>" in head
        assert f"<td>{solution.frequencies[k]:.6f}</td>" in head
    assert re.findall(r"<!-- (\d)× -->", head) == ["1", "3"]  # lines in the chart
    assert "gamma = 10.0" in head
    assert "<title>beamviz: α = 1, β = 0.5, γ = 10, δ = 0, μ = 70</title>" in text
    assert not re.findall(r'<(?:script|link|img|iframe)[^>]+(?:src|href)="(?!data:)', text)


def test_a_page_has_the_frequencies_at_another_speed(document):
    """Of the modes it shows, by which the beam moves, and of all in its table, as `solve` has them
    there. At the speed of the scene also the errors are those that `solve` and the page have."""
    data = speeds_of(document)
    for k in (0, 7, len(data["gammas"]) - 1):
        there = solve(PAPER.replace(gamma=data["gammas"][k]))
        assert abs(data["gammas"][k] - PAPER.gamma) > 1
        assert data["frequencies"]["B2"][k] == pytest.approx(there.frequencies[1], rel=1e-6)
        shown = re.findall(r"<td>(\d+\.\d+)</td>", data["numbers"][k])
        assert [float(text) for text in shown] == pytest.approx(there.frequencies, rel=1e-5)
    errors = re.findall(r"<td>(\de-\d+)</td>", data["numbers"][data["start"]])
    assert errors == [error_digits(error) for error in solve(PAPER).errors]


def test_a_page_of_a_real_beam_has_its_stress(tmp_path):
    """At each speed: above the yield stress as a warning. rho Omega^2 L^2 / 2 = 61 MPa at 2000 rpm
    of a bar of 0.6 m, and with the square of the speed."""
    bar = {"length": 0.6, "density": 7850.0, "area": 5e-4, "second_moment": 4.2e-9}
    bar |= {"youngs_modulus": 210e9, "yield_stress": 50e6, "rotation_rpm": 1000.0}
    export(tmp_path / "a.html", Scene(beam := Beam.from_si(**bar)))
    data = speeds_of(tmp_path / "a.html")
    for gamma, text in zip(data["gammas"], data["numbers"], strict=True):
        pascals = 7850 * (gamma / beam.units.time) ** 2 * 0.6**2 / 2
        assert ('<p class="wrong">Greatest stress' in text) is (pascals > 50e6)
        if gamma:
            (found,) = re.findall(r"Greatest stress: ([\d.]+) MPa", text)
            assert float(found) == pytest.approx(pascals / 1e6, rel=0.01)


@pytest.mark.parametrize("wrong", [{"gammas": ["0"]}, {"beams": [{}]}, {"speed": 1.0}], ids=str)
def test_a_page_is_given_what_its_script_takes(document, wrong):
    """Data that are not declared, or not in this form, are in no page."""
    (packed,) = re.findall('id="speeds">(.*?)</script>', document.read_text())
    data = json.loads(zlib.decompress(base64.b64decode(packed)))
    assert packed in player("speeds", data, OfflineSpeeds, "exports/offline.js")
    with pytest.raises(msgspec.ValidationError):
        player("speeds", data | wrong, OfflineSpeeds, "exports/offline.js")


def test_a_page_plays_from_the_disk_without_a_network(document):
    """In a browser that is offline the beam moves, and the page complains of nothing."""
    beam = "window.__viserMutable?.nodeRefFromName?.['/scene/rotor/beam']"
    place = f"""(() => {{ let mesh; {beam}?.traverse(n => {{
        const data = n.matricesTexture?._data;  // pieces that are not seen have no size
        if (data && Math.hypot(...data.slice(4, 7)) > 1e-5) mesh = data; }});
      return mesh ? Array.from(mesh.slice(160, 176)).join() : ''; }})()"""
    with page("about:blank", 400, 300) as shown:
        shown.call("Network.enable")
        none = dict.fromkeys(("latency", "downloadThroughput", "uploadThroughput"), 0)
        shown.call("Network.emulateNetworkConditions", offline=True, **none)
        shown.call("Page.navigate", url=document.as_uri())
        first = shown.wait(place, 120)
        shown.wait(f"{place} !== {first!r}", 60)
        assert shown.evaluate("document.querySelector('aside').innerText").count("bending") == 4
        assert shown.problems == []


def test_the_colours_of_a_page_end_at_the_largest_displacement(tmp_path):
    """At full swing the tip has the last colour of the scale, a few pieces beside it nearly that,
    and no others."""
    export(tmp_path / "a.html", Scene.of(PAPER, mode=1))
    colours = """(() => { let mesh;
      window.__viserMutable?.nodeRefFromName?.['/scene/rotor/beam']?.traverse(n => {
        const data = n.matricesTexture?._data;
        if (data && Math.hypot(...data.slice(4, 7)) > 1e-5) mesh = n; });
      const data = mesh?.colorsTexture?._data;
      return data && Array.from(data.slice(0, 4 * mesh.instancesCount)); })()"""
    with page("about:blank", 400, 300) as shown:
        still = [{"name": "prefers-reduced-motion", "value": "reduce"}]
        shown.call("Emulation.setEmulatedMedia", features=still)
        shown.call("Page.navigate", url=(tmp_path / "a.html").as_uri())
        shown.wait(f"({colours})?.length > 40", 60)
        shown.next_frame(5)
        pieces = np.reshape(shown.evaluate(colours), (-1, 4))[:, :3]
    as_the_tip = np.abs(pieces - pieces[-1]).max(axis=1) < 1e-3
    assert as_the_tip.mean() < 0.15
    assert len(np.unique(pieces.round(4), axis=0)) > 10


def choose_speed(shown: Page, gamma: float) -> None:
    """Move the slider of a page to the solved speed nearest to gamma."""
    low, high = chart_range(PAPER, "gamma")
    share = (gamma - low) / (high - low)
    slider = "const s = document.getElementById('speed')"
    move = f"s.value = Math.round({share} * s.max); s.dispatchEvent(new Event('input'))"
    shown.evaluate(f"(() => {{ {slider}; {move}; }})()")


@pytest.mark.slow
def test_a_page_follows_its_speed_past_a_crossing(tmp_path):
    """B3 and S1 cross at 9.37. The heading, the order of the modes, their frequencies and errors
    are those of a solution at the new speed; the line of the chart is there; and the arrow, which
    a beam at rest does not have, turns with the hub."""
    export(tmp_path / "a.html", Scene.of(PAPER.replace(gamma=0), mode=3))
    arrow = "window.__viserMutable?.nodeRefFromName?.['/scene/arrow']"
    cells = "[...document.querySelectorAll('aside tr')].slice(1).map(row => row.innerText)"
    with page((tmp_path / "a.html").as_uri(), 900, 500) as shown:
        shown.wait(f"{arrow} && {arrow}.visible === false", 120)
        choose_speed(shown, 19)
        there = solve(PAPER.replace(gamma=19))
        assert there.labels.index("S1") < there.labels.index("B3")
        rows = [row.split() for row in shown.evaluate(cells)]
        assert [row[1] for row in rows] == list(there.labels)
        frequencies = [float(row[3]) for row in rows]
        assert frequencies == pytest.approx(there.frequencies, abs=1e-6)
        assert all(float(row[4]) < 1e-5 for row in rows)
        assert "γ = 19" in shown.evaluate("document.querySelector('aside h1').innerText")
        shown.wait(f"{arrow}.visible")
        left = "document.getElementById('marker').getBoundingClientRect().left"
        frame = "document.getElementById('patch_2').getBoundingClientRect()"
        share = shown.evaluate(f"({left} - {frame}.left) / {frame}.width")
        low, high = chart_range(PAPER, "gamma")
        assert share == pytest.approx((19 - low) / (high - low), abs=0.02)
        assert shown.problems == []


@pytest.mark.slow
def test_the_path_of_the_tip_on_a_page_is_that_of_a_picture(tmp_path):
    """Also at another speed, of two modes that have begun at their largest displacement."""
    export(tmp_path / "a.html", scene := Scene.of(PITCHED, **PATH))
    line = "window.__viserMutable?.nodeRefFromName?.['/scene/rotor/tip_path']"
    ends = f"""(() => {{ let found; {line}?.traverse(n => {{
        found ??= n.geometry?.attributes?.instanceStart?.data?.array; }});
      return found && Array.from(found); }})()"""
    gamma = speeds_of(tmp_path / "a.html")["gammas"][-3]
    solved = SolvedScene(scene.changed(gamma=gamma))
    beams, paths = solved.draw(SceneGraph()), []
    for first, second in itertools.product((1, -1), repeat=2):  # the sign of a shape is arbitrary
        phases = math.pi / 2 * np.array([first, second, 1, 1, 1])
        solved.move(beams, solved.moment()._replace(phases=phases))
        paths.append(beams.rows[0].tip_path.line.points.ravel())
    with page("about:blank", 500, 400) as shown:
        still = [{"name": "prefers-reduced-motion", "value": "reduce"}]
        shown.call("Emulation.setEmulatedMedia", features=still)
        shown.call("Page.navigate", url=(tmp_path / "a.html").as_uri())
        shown.wait(ends, 120)
        move = "s.value = s.max - 2; s.dispatchEvent(new Event('input'))"
        shown.evaluate(f"(s => {{ {move}; }})(document.getElementById('speed'))")

        def alike() -> bool:
            found = np.array(shown.evaluate(ends))
            same = [one for one in paths if len(one) == len(found)]
            return any(np.abs(one - found).max() < 1e-3 for one in same)

        shown.wait(alike)
        assert shown.problems == []


@pytest.mark.slow
@pytest.mark.parametrize("dark", [False, True])
def test_the_chart_of_a_page_can_be_read(tmp_path, dark):
    """In light and dark: its letters are as high as those of the table or nearly, and differ from
    the ground. It is enlarged by a key, and made small again, as by a click. On a phone the edge of
    a dark panel is dark, as it is beside the scene."""
    export(tmp_path / "a.html", Scene.of(PAPER, mode=2, dark=dark))
    ground = "getComputedStyle(document.querySelector('aside')).backgroundColor"
    label = "document.querySelector('aside svg #text_1').getBoundingClientRect().height"
    with page((tmp_path / "a.html").as_uri(), 1280, 720) as shown:
        shown.wait("!!document.querySelector('aside svg')", 60)
        assert shown.evaluate(label) > 8  # [px] of a digit, which has two thirds of a line
        channels = re.findall(r"\d+", shown.evaluate(ground))
        assert (int(channels[0]) < 60) is dark
        left, top, width, height = shown.box("document.querySelector('aside svg')")
        clip = {"x": left, "y": top, "width": width, "height": height, "scale": 1}
        taken = shown.call("Page.captureScreenshot", clip=clip)["data"]
        figure = "document.querySelector('aside figure')"
        before = shown.box(figure)
        shown.evaluate(f"{figure}.focus()")
        shown.key("Enter")
        assert shown.box(figure)[2] > 2 * before[2]
        shown.key("Enter")
        assert shown.box(figure)[2] == before[2]
        shown.resize(390, 844)
        edge = shown.evaluate("getComputedStyle(document.querySelector('aside')).borderTopColor")
        assert (max(map(int, re.findall(r"\d+", edge)[:3])) < 100) is dark
    grey = np.asarray(Image.open(io.BytesIO(base64.b64decode(taken))).convert("L"), int)
    paper = int(np.median(grey))
    assert (paper < 60) is dark
    assert (abs(grey - paper) > 128).mean() > 0.003  # letters and axes


def test_an_export_of_a_page_opens_no_port(tmp_path, monkeypatch):
    """Nor starts a thread that outlives it: the page is recorded without a server."""

    def refuse(*_):
        raise AssertionError("a port was opened")

    monkeypatch.setattr(socket.socket, "bind", refuse)
    threads = set(threading.enumerate())
    export(tmp_path / "a.html", Scene())
    assert set(threading.enumerate()) <= threads


@pytest.mark.slow
def test_all_modes_are_in_the_picture_of_a_page(tmp_path):
    """The title of each row is in the scene, beside or above the numbers, wide or on a phone."""
    export(tmp_path / "a.html", Scene.of(PAPER, all_modes=True))
    titles = "[...document.querySelectorAll('#caption-layer > span')]"
    box = "(({left, top, right, bottom}) => [left, top, right, bottom])"
    boxes = f"{titles}.map(title => {box}(title.getBoundingClientRect()))"
    scene = "document.querySelector('#root canvas').getBoundingClientRect()"
    panel = "document.querySelector('aside').getBoundingClientRect()"

    def fits() -> bool:
        left, top, right, bottom = np.array(shown.evaluate(boxes)).T
        width, height = shown.evaluate(f"(r => [r.width, r.height])({scene})")
        aside = shown.evaluate(f"{box}({panel})")
        is_beside = width <= aside[0] or height <= aside[1] + 1
        is_wide = 0 <= min(left) <= max(right) <= width
        return is_beside and is_wide and 0 < min(top) <= max(bottom) <= height

    with page((tmp_path / "a.html").as_uri(), 1280, 720) as shown:
        for size in ((1280, 720), (390, 844)):
            shown.resize(*size)
            shown.wait(f"(t => t[4] && t[4][1] - t[0][1] > 0.2 * innerHeight)({boxes})")  # placed
            shown.wait(fits)


SCENES = {
    "two modes": Scene.of(PAPER, shares=[0.5, 0.0, 1.0]),
    "spin-up": Scene.of(PAPER, mode=4, coriolis=True, spin_up=2, state="stable"),
    "bent": Scene.of(gamma=4, delta=-1, state="bent", mode=1),
    "blade": Scene.of(BLADE, mode=2),
    "end": Scene.of(delta=-1, gamma=1, mode=1, all_modes=True, colouring="axial strain"),
    "twenty modes": Scene.of(gamma=3, coriolis=True, shares=[1.0] * MAX_MODES),
}


@pytest.mark.parametrize(
    "name", ["two modes", *slow("spin-up", "bent", "blade", "end", "twenty modes")]
)
def test_a_page_has_the_beam_at_many_speeds(tmp_path, name):
    """41 solved speeds or more with all shapes, in less than 3 MB; at each the frequency, the axis
    and the numbers of the panel are those of a solution there."""
    export(tmp_path / "a.html", scene := SCENES[name])
    assert (tmp_path / "a.html").stat().st_size < 3e6
    text = (tmp_path / "a.html").read_text()
    (found,) = re.findall('<script type="text/plain" id="speeds">(.*?)</script>', text)
    data = json.loads(zlib.decompress(base64.b64decode(found)))
    gammas = np.array(data["gammas"])
    assert len(gammas) >= 41
    assert gammas[data["start"]] == scene.beam.gamma
    middle = len(gammas) // 2
    beam = scene.beam.replace(gamma=float(gammas[middle]))
    there = solve(beam, **{**scene.solver_options, "modes": MAX_MODES})
    assert measure("gamma", beam.units).text(beam.gamma, 6) in data["numbers"][middle]
    drawn = SolvedScene(scene).draw(SceneGraph()).rows
    for one, row in zip(data["beams"], drawn, strict=True):
        along = [row.shapes.x[k] for at in one["bodies"].values() for k in at]
        assert sorted(along) == pytest.approx([body.beta for body in beam.bodies])
        sizes = sections(beam, row.shapes.plane, row.shapes.x).mean(axis=1)
        assert one["sections"] == pytest.approx(sizes)  # chordwise
        states = data["resolution"] * np.cumsum(np.cumsum(one["states"], axis=1), axis=1).T
        axis = states.reshape(len(gammas), -1, len(row.shapes.x), 4)[middle, 0, :, :3]
        expected, _ = to_hub_frame(row.shapes, there.equilibrium.position(row.shapes.x))
        assert axis == pytest.approx(expected, abs=2e-4)
        for label in one["modes"]:
            expected = there.frequencies[there.labels.index(label)]
            assert data["frequencies"][label][middle] == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize(
    ("write", "name", "options", "message"),
    [
        (export, "missing/a.csv", {}, r"cannot write .*a\.csv: No such file.*; choose another"),
        (screenshot, "folder.png", {}, "it is a folder"),
        (export, "a.odt", {}, r"must end in \.html, \.glb, "),
        (screenshot, "a.jpg", {}, r"must end in \.png"),
        (animate, "a.avi", {}, r"must end in \.gif, \.webp or \.mp4"),
        (screenshot, "a.png", {"width": 5}, r"width = 5: must be a whole number in 64 \.\. 4096"),
        (animate, "a.mp4", {"width": 65}, "width = 65: must be even for MP4"),
        (animate, "a.mp4", {}, "MP4 needs PyAV: .* -m pip install"),
    ],
)
def test_what_cannot_be_written_is_not_solved(tmp_path, monkeypatch, write, name, options, message):
    """A missing folder, a folder itself, a wrong suffix or size, a missing encoder, each with the
    remedy; no file is left. The beam has no equilibrium, which would be told if it were solved."""
    if "PyAV" in message:
        monkeypatch.setitem(sys.modules, "av", None)
    (tmp_path / "folder.png").mkdir()
    beyond = Scene.of(gamma=100, strain="hencky")
    with pytest.raises((InvalidInput, Unavailable), match=message):
        write(tmp_path / name, beyond, **options)
    assert list(tmp_path.iterdir()) == [tmp_path / "folder.png"]


@pytest.mark.parametrize("direction", [(1, 2), (0, 0, 0), "abc", (0, 0, math.nan), 3])
def test_a_wrong_direction_is_named(tmp_path, direction):
    with pytest.raises(InvalidInput):
        screenshot(tmp_path / "a.png", Scene.of(PAPER), 64, 64, direction=direction)


def test_a_direction_may_be_an_array(tmp_path):
    for name, direction in (("tuple", (0.0, -1.0, 0.5)), ("array", np.array([0.0, -1.0, 0.5]))):
        screenshot(tmp_path / f"{name}.png", Scene.of(PAPER), 64, 64, direction=direction)
    assert (tmp_path / "tuple.png").read_bytes() == (tmp_path / "array.png").read_bytes()


def test_a_wrong_number_of_threads_is_named(tmp_path):
    moved = motion(Beam(), 0.1, points=2)
    for workers in (0, -1, 1.5):
        with pytest.raises(InvalidInput, match="workers"):
            animate(tmp_path / "a.gif", Scene.of(PAPER), 64, 64, workers=workers)
        with pytest.raises(InvalidInput, match="workers"):
            animate_motion(tmp_path / "a.gif", moved, 64, 64, workers=workers)
    assert not list(tmp_path.iterdir())
