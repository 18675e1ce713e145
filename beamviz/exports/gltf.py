"""The vibrating beam as binary glTF 2.0: modes are morph targets, their motion an animation."""

import json
import math
import struct
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from beamviz.drawing import OPACITY, BeamView, beam_mesh, colours
from beamviz.drawing.beam_mesh import to_hub_frame
from beamviz.drawing.comparison import SPACING
from beamviz.drawing.scene_graph import SceneGraph
from beamviz.drawing.surroundings import hub_body, hub_radius
from beamviz.drawing.tip_path import tip_points
from beamviz.exports.solved_scene import Loop, Moment, SolvedScene
from beamviz.version import __version__

FLOAT, UNSIGNED, LINE_STRIP = 5126, 5125, 3
KEYS = 24  # of the animation, for each cycle of its fastest motion
Z_UP = [-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)]  # glTF has y up
Channel = tuple[int, str, np.ndarray]  # of an animation: node, its property, and the values


class Gltf:
    """A glTF asset under construction; each `add` returns an index that others refer to."""

    def __init__(self) -> None:
        asset = {"version": "2.0", "generator": f"beamviz {__version__}"}
        self.data: dict[str, Any] = {"asset": asset}
        self.binary = bytearray()

    def add(self, kind: str, **entry: Any) -> int:
        """Add an entry to the list `kind`: nodes, meshes, materials ..."""
        entries = self.data.setdefault(kind, [])
        entries.append(entry)
        return len(entries) - 1

    def array(self, values: Any) -> int:
        """An accessor of floats (n,) or (n, 3 or 4), or of indices (n,)."""
        integer = np.issubdtype(np.asarray(values).dtype, np.integer)
        values = np.ascontiguousarray(values, np.uint32 if integer else np.float32)
        part = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": values.nbytes}
        self.binary += values.tobytes()  # four bytes a number: always aligned
        return self.add(
            "accessors",
            bufferView=self.add("bufferViews", **part),
            componentType=UNSIGNED if integer else FLOAT,
            count=len(values),
            type="SCALAR" if values.ndim == 1 else f"VEC{values.shape[1]}",
            min=np.atleast_1d(values.min(axis=0)).tolist(),
            max=np.atleast_1d(values.max(axis=0)).tolist(),
        )

    def encoded(self) -> bytes:
        """The .glb file."""
        self.data["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.data, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        parts = (text, b"JSON"), (bytes(self.binary), b"BIN\0")
        chunks = b"".join(struct.pack("<I4s", len(part), kind) + part for part, kind in parts)
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks

    def node(
        self,
        name: str,
        vertices: Any,
        faces: Any,
        colour: colours.RGB,
        opacity: float = 1.0,
        **values: Any,
    ) -> int:
        """A node with a mesh of one colour, seen from both sides; without normals a viewer draws
        its faces flat. values: of the node."""
        factor = [*colours.linear(colour).tolist(), opacity]
        matt = {"baseColorFactor": factor, "metallicFactor": 0.0, "roughnessFactor": 0.6}
        surface = {"name": name, "pbrMetallicRoughness": matt, "doubleSided": True}
        surface |= {"alphaMode": "BLEND"} if opacity < 1 else {}
        primitive = {
            "attributes": {"POSITION": self.array(vertices)},
            "indices": self.array(np.ravel(faces)),
            "material": self.add("materials", **surface),
        }
        mesh = self.add("meshes", name=name, primitives=[primitive])
        return self.add("nodes", name=name, mesh=mesh, **values)

    def line(self, name: str, points: np.ndarray, colour: colours.RGB) -> int:
        """A node with a line through points (n, 3)."""
        matt = {"baseColorFactor": [*colours.linear(colour).tolist(), 1.0], "metallicFactor": 0.0}
        primitive = {
            "mode": LINE_STRIP,
            "attributes": {"POSITION": self.array(points)},
            "material": self.add("materials", name=name, pbrMetallicRoughness=matt),
        }
        mesh = self.add("meshes", name=name, primitives=[primitive])
        return self.add("nodes", name=name, mesh=mesh)


def write_glb(file: Path, solved: SolvedScene) -> None:
    """Hub, beam and bodies, and those of a second beam, in metres for a beam in SI, else in lengths
    of the beam; outside the rotating frame they rotate."""
    gltf, beam = Gltf(), solved.scene.beam
    loop = None if solved.warning else Loop(solved, film=False)
    times, moments = np.zeros(1), [still(solved)]
    if loop:
        farthest = max(np.abs(loop.phases).max(initial=0.0), abs(loop.angle))
        parts = np.linspace(0.0, 1.0, KEYS * max(1, round(farthest / (2 * math.pi))) + 1)
        times, moments = loop.seconds * parts, [loop.moment(part) for part in parts]
    drawn = BeamView(SceneGraph())
    drawn.show(solved.drawn)
    phases = np.array([moment.phases for moment in moments])
    nodes, channels = add_all(gltf, drawn, solved.shown, phases)
    if solved.pair:
        stacked = solved.scene.second is not None and solved.scene.second.stacked
        other = BeamView(SceneGraph(), overlay=not stacked)
        other.show(solved.pair.second)
        phases = np.array([moment.other_phases for moment in moments])
        second, more = add_all(gltf, other, solved.pair.second.shown, phases, "second ")
        above = SPACING if stacked else 0.0
        nodes.append(gltf.add("nodes", name="second", children=second, translation=[0, 0, above]))
        channels += more
    wheel = gltf.add("nodes", name="wheel", children=nodes)
    if loop and loop.angle:
        rotations = Rotation.from_euler("z", [[moment.angle] for moment in moments])
        channels.append((wheel, "rotation", rotations.as_quat()))
    metres = {"scale": [beam.units.length] * 3} if beam.units else {}
    root = gltf.add("nodes", name="beamviz", children=[wheel], rotation=Z_UP, **metres)
    gltf.data |= {"scene": 0, "scenes": [{"nodes": [root]}]}
    if loop:
        at = gltf.array(times)
        samplers = [{"input": at, "output": gltf.array(values)} for _, _, values in channels]
        paths = [{"node": node, "path": path} for node, path, _ in channels]
        entries = [{"sampler": k, "target": path} for k, path in enumerate(paths)]
        gltf.add("animations", name="vibration", samplers=samplers, channels=entries)
    file.write_bytes(gltf.encoded())


def still(solved: SolvedScene) -> Moment:
    """The moment at which no mode has a displacement."""
    second = len(solved.pair.second.shapes.modes) if solved.pair else 0
    return Moment(np.zeros(len(solved.shapes.modes)), 0.0, np.zeros(second))


def add_all(
    gltf: Gltf, drawn: BeamView, shown: list[int], phases: np.ndarray, prefix: str = ""
) -> tuple[list[int], list[Channel]]:
    """Add a beam with its bodies, and unless it is drawn over another one its hub and joint; their
    nodes and channels. shown: the modes that it moves in; phases: (t, modes); prefix: of names."""
    beam, nodes, channels = drawn.drawn.shapes.beam, list[int](), list[Channel]()
    if not drawn.overlay:
        hub = hub_body(hub_radius(beam), inward=beam.delta < 0)
        nodes.append(gltf.node(f"{prefix}hub", hub.vertices, hub.faces, colours.HUB))
    swing = add_beam(gltf, drawn, shown, phases, f"{prefix}beam")
    nodes.append(swing[0])
    channels += [swing] if shown else []
    if drawn.joint:
        for part in drawn.joint.nodes:
            name = prefix + part.name.rpartition("/")[2]
            nodes.append(gltf.node(name, part.vertices, part.faces, part.color))
    if drawn.tip_path.is_shown:
        points = tip_points(drawn.shapes, phases, drawn.drawn.amplitudes)
        nodes.append(gltf.line(f"{prefix}tip's path", points, drawn.tip_path.colour))
    if drawn.bodies.shown:
        body_channels = add_bodies(gltf, drawn, phases, f"{prefix}mass")
        nodes += dict.fromkeys(node for node, *_ in body_channels)
        channels += body_channels
    return nodes, channels


def add_bodies(gltf: Gltf, drawn: BeamView, phases: np.ndarray, name: str) -> list[Channel]:
    """Add the bodies on the beam, which move with it."""
    paths: list[tuple[np.ndarray, np.ndarray]] = []
    for moment in phases:
        drawn.move(moment, 0.0)
        paths.append(drawn.bodies.places())
    positions, wxyzs = (np.array(path) for path in zip(*paths, strict=True))
    channels: list[Channel] = []
    colour, opacity = (colours.BEFORE, OPACITY) if drawn.overlay else (colours.MASS, 1.0)
    for k, (node, size) in enumerate(drawn.bodies.meshes()):
        turned = np.roll(wxyzs[:, k], -1, axis=1)  # glTF has xyzw
        place = {"translation": positions[0, k].tolist(), "rotation": turned[0].tolist()}
        label = name if len(drawn.bodies.shown) == 1 else f"{name} {k + 1}"
        added = gltf.node(label, node.vertices * size, node.faces, colour, opacity, **place)
        channels += [(added, "translation", positions[:, k]), (added, "rotation", turned)]
    return channels


def add_beam(
    gltf: Gltf, drawn: BeamView, shown: list[int], phases: np.ndarray, name: str
) -> Channel:
    """Add the beam in equilibrium, coloured by the amplitude of each section, or pale where it is
    drawn over another one; phases: (t, modes).

    Morph targets are the beam at parts of the cycle of each mode shown. Programs as Blender take no
    weight below 0, so a mode has two, half a period apart; with Coriolis forces four.
    """
    shapes, parts = drawn.shapes, [(0.25, ""), (0.75, "-")]
    if np.iscomplexobj(shapes.modes):
        parts += [(0.0, "'"), (0.5, "'-")]
    fields = drawn.drawn.amplitudes[:, None, None] * shapes.modes
    targets = [(k, 2 * math.pi * part, mark) for k in shown for part, mark in parts]

    def surface(moved: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
        return beam_mesh.swept(*to_hub_frame(shapes, shapes.centreline + moved), drawn.section)

    still, faces = surface(0.0)
    pale = (colours.BEFORE, OPACITY) if drawn.overlay else ((255, 255, 255), 1.0)
    node = gltf.node(name, still, faces, *pale)
    mesh = gltf.data["meshes"][-1]
    (primitive,) = mesh["primitives"]
    if not drawn.overlay:
        swings = np.linalg.norm(fields, axis=(0, 2))
        colour = np.tile(colours.GREYED, (len(swings), 1))
        if not drawn.drawn.warning:
            colour = colours.mapped(swings / max(swings.max(), 1e-9), colours.SEQUENTIAL)
        point, _ = beam_mesh.rings(len(colour), drawn.section)
        linear = np.repeat(colours.linear(colour)[point], 4, axis=0)
        primitive["attributes"]["COLOR_0"] = gltf.array(linear)
    weights = np.cos(phases[:, [k for k, *_ in targets]] - [at for _, at, _ in targets]).clip(0.0)
    if targets:
        moved = [surface((np.exp(1j * at) * fields[k]).imag)[0] for k, at, _ in targets]
        primitive["targets"] = [{"POSITION": gltf.array(place - still)} for place in moved]
        mesh["weights"] = weights[0].tolist()
        mesh["extras"] = {"targetNames": [shapes.labels[k] + mark for k, _, mark in targets]}
    return node, "weights", weights.ravel()
