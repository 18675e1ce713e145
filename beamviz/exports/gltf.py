"""The vibrating beam as binary glTF 2.0: modes are morph targets, their motion an animation."""

import json
import math
import struct
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from beamviz import __version__
from beamviz.drawing import beam_mesh, colours
from beamviz.drawing.beam_mesh import subdivide
from beamviz.drawing.modes import displacement
from beamviz.drawing.objects import (
    HUB_HEIGHT,
    annulus,
    hub_radius,
    mass_radius,
    section_size,
    to_hub_frame,
)
from beamviz.exports.solved_scene import Loop, Moment, SolvedScene, find_loop

FLOAT, UNSIGNED = 5126, 5125
VERTICES, INDICES = 34962, 34963
KINDS = {(): "SCALAR", (3,): "VEC3", (4,): "VEC4"}
MAGIC, VERSION, JSON_CHUNK, BINARY_CHUNK = 0x46546C67, 2, 0x4E4F534A, 0x004E4942


class Gltf:
    """A glTF asset in the making; each `add` returns an index that others refer to."""

    def __init__(self, generator: str):
        self.data: dict[str, Any] = {"asset": {"version": "2.0", "generator": generator}}
        self.binary = bytearray()

    def add(self, what: str, entry: dict[str, Any]) -> int:
        """Another node, mesh, material ..."""
        entries = self.data.setdefault(what, [])
        entries.append(entry)
        return len(entries) - 1

    def array(self, values: np.ndarray, target: int | None = None) -> int:
        """An accessor of floats (n,) or (n, 3 or 4), or of indices (n,); `target` says for what."""
        whole = np.issubdtype(values.dtype, np.integer)
        values = np.ascontiguousarray(values, np.uint32 if whole else np.float32)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": values.nbytes}
        self.binary += values.tobytes()  # four bytes a number: always aligned
        entry = {
            "bufferView": self.add("bufferViews", view | ({"target": target} if target else {})),
            "componentType": UNSIGNED if whole else FLOAT,
            "count": len(values),
            "type": KINDS[values.shape[1:]],
            "min": np.atleast_1d(values.min(axis=0)).tolist(),
            "max": np.atleast_1d(values.max(axis=0)).tolist(),
        }
        return self.add("accessors", entry)

    def encoded(self) -> bytes:
        """The .glb file."""
        self.data["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.data, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        chunks = b"".join(
            struct.pack("<II", len(part), kind) + part
            for part, kind in ((text, JSON_CHUNK), (bytes(self.binary), BINARY_CHUNK))
        )
        return struct.pack("<III", MAGIC, VERSION, 12 + len(chunks)) + chunks


KEYS = 24  # of the animation, for each cycle of its fastest motion
Z_UP = [-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)]  # glTF has y up
Channel = tuple[int, str, np.ndarray]  # node, what of it, values (keys, ...)


def write_glb(file: Path, solved: SolvedScene) -> None:
    """Hub, beam and mass, in lengths of the beam. Who stands beside the hub sees it turn."""
    gltf = Gltf(f"beamviz {__version__}")
    rest = Moment(np.zeros(len(solved.shapes.modes)), 0.0)
    loop = None if solved.warning else find_loop(solved, ground=False)
    share = np.linspace(0.0, 1.0, key_count(loop) + 1) if loop else np.zeros(1)
    moments = [loop.moment(part) for part in share] if loop else [rest]
    swing = weights(solved, moments)
    hub = gltf.add("nodes", {"name": "hub", "mesh": add_hub(gltf, solved)})
    mesh = add_beam(gltf, solved, swing[0])
    beam = gltf.add("nodes", {"name": "beam", "mesh": mesh})
    parts, moving = [hub, beam], [(beam, "weights", swing.ravel())]
    if solved.scene.beam.alpha > 0:
        path = np.array([mass_position(solved, moment) for moment in moments])
        node = {"name": "mass", "mesh": add_mass(gltf, solved), "translation": path[0].tolist()}
        parts.append(gltf.add("nodes", node))
        moving.append((parts[-1], "translation", path))
    wheel = gltf.add("nodes", {"name": "wheel", "children": parts})
    if loop and loop.angle:
        turns = Rotation.from_euler("z", [[moment.angle] for moment in moments])
        moving.append((wheel, "rotation", turns.as_quat()))
    root = gltf.add("nodes", {"name": "beamviz", "children": [wheel], "rotation": Z_UP})
    gltf.data |= {"scene": 0, "scenes": [{"nodes": [root]}]}
    if loop:
        add_animation(gltf, loop.seconds * share, moving)
    file.write_bytes(gltf.encoded())


def key_count(loop: Loop) -> int:
    """How many steps the animation has."""
    farthest = max(np.abs(loop.phases).max(initial=0.0), abs(loop.angle))
    return KEYS * max(1, round(farthest / (2 * math.pi)))


def add_animation(gltf: Gltf, times: np.ndarray, moving: list[Channel]) -> None:
    """One animation of all channels at `times` (keys,) [s]."""
    at = gltf.array(times)
    samplers = [{"input": at, "output": gltf.array(values)} for _, _, values in moving]
    targets = [{"node": node, "path": path} for node, path, _ in moving]
    channels = [{"sampler": k, "target": target} for k, target in enumerate(targets)]
    gltf.add("animations", {"name": "vibration", "samplers": samplers, "channels": channels})


class Target(NamedTuple):
    """A morph target: one side of the swing of a mode (from 0). Programs as Blender take no weight
    below 0, so a mode has two: there and back."""

    name: str
    mode: int
    part: float  # the cycle of the mode at which the beam looks like that


def targets_of(solved: SolvedScene) -> list[Target]:
    """The morph targets; with Coriolis forces a mode has two more, a quarter period apart."""
    quarters = [(0.25, ""), (0.75, "-")]
    if np.iscomplexobj(solved.shapes.modes):
        quarters += [(0.0, "'"), (0.5, "'-")]
    return [
        Target(solved.shapes.labels[k] + mark, k, part)
        for k in solved.shown
        for part, mark in quarters
    ]


def weights(solved: SolvedScene, moments: list[Moment]) -> np.ndarray:
    """Weight (moments, targets) of each morph target, 0 .. 1."""
    values = [
        [math.cos(moment.phases[k] - 2 * math.pi * part) for moment in moments]
        for _, k, part in targets_of(solved)
    ]
    return np.maximum(np.array(values).reshape(-1, len(moments)).T, 0.0)


def add_beam(gltf: Gltf, solved: SolvedScene, start: np.ndarray) -> int:
    """The beam at its equilibrium, coloured by how far each place of it swings."""
    shapes, view = subdivide(solved.shapes, solved.motion()), solved.scene.view
    section = section_size(shapes.beam, view.thicken)

    def surface(moved: np.ndarray) -> np.ndarray:
        return beam_mesh.swept(*to_hub_frame(shapes, shapes.centreline + moved), *section)[0]

    still = surface(np.zeros_like(shapes.centreline))
    _, faces = beam_mesh.swept(*to_hub_frame(shapes, shapes.centreline), *section)
    swings, morphs, targets = np.zeros(len(shapes.x)), [], targets_of(solved)
    for _, k, part in targets:
        alone = np.where(np.arange(len(shapes.modes)) == k, solved.amplitudes, 0.0)
        moved = displacement(shapes, np.full(len(shapes.modes), 2 * math.pi * part), alone)
        if part < 0.5:
            swings = np.hypot(swings, np.linalg.norm(moved, axis=1))
        morphs.append({"POSITION": gltf.array(surface(moved) - still, VERTICES)})
    colour = np.tile(np.array(colours.GREYED) / 255, (len(swings), 1))
    if not solved.warning:
        colour = colours.mapped(swings / max(swings.max(), 1e-9), colours.SEQUENTIAL)
    primitive = {
        "attributes": {
            "POSITION": gltf.array(still, VERTICES),
            "COLOR_0": gltf.array(np.repeat(colours.linear(colour), 4, axis=0), VERTICES),
        },
        "indices": gltf.array(faces.ravel(), INDICES),
        "material": add_material(gltf, "beam", (255, 255, 255)),
    }
    mesh: dict[str, Any] = {"name": "beam", "primitives": [primitive]}
    if targets:
        primitive["targets"] = morphs
        names = [target.name for target in targets]
        mesh |= {"weights": start.tolist(), "extras": {"targetNames": names}}
    return gltf.add("meshes", mesh)


def add_hub(gltf: Gltf, solved: SolvedScene) -> int:
    """The drum, or the hoop of an inward beam."""
    beam = solved.scene.beam
    radius = hub_radius(beam)
    drum = trimesh.creation.cylinder(radius, HUB_HEIGHT, sections=96)
    return add_solid(gltf, "hub", annulus(radius) if beam.delta < 0 else drum, colours.HUB)


def add_mass(gltf: Gltf, solved: SolvedScene) -> int:
    """The concentrated mass, around the origin."""
    radius = mass_radius(solved.scene.beam, solved.scene.view.thicken)
    ball = trimesh.creation.icosphere(subdivisions=3, radius=radius)
    return add_solid(gltf, "mass", ball, colours.MASS, smooth=True)


def mass_position(solved: SolvedScene, moment: Moment) -> np.ndarray:
    """Where the mass is, (3,)."""
    moved = displacement(solved.shapes, moment.phases, solved.amplitudes)
    return to_hub_frame(solved.shapes, solved.shapes.centreline + moved)[0][solved.shapes.mass]


def add_solid(
    gltf: Gltf, name: str, body: trimesh.Trimesh, colour: colours.RGB, *, smooth: bool = False
) -> int:
    """A mesh of one colour; without normals a viewer draws its faces flat."""
    attributes = {"POSITION": gltf.array(body.vertices, VERTICES)}
    if smooth:
        attributes["NORMAL"] = gltf.array(body.vertex_normals, VERTICES)
    primitive = {
        "attributes": attributes,
        "indices": gltf.array(body.faces.ravel(), INDICES),
        "material": add_material(gltf, name, colour),
    }
    return gltf.add("meshes", {"name": name, "primitives": [primitive]})


def add_material(gltf: Gltf, name: str, colour: colours.RGB) -> int:
    """A matt one, seen from both sides."""
    factor = [*colours.linear(np.array(colour) / 255).tolist(), 1.0]
    matt = {"baseColorFactor": factor, "metallicFactor": 0.0, "roughnessFactor": 0.6}
    entry = {"name": name, "pbrMetallicRoughness": matt, "doubleSided": True}
    return gltf.add("materials", entry)
