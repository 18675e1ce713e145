"""The vibrating beam as a glTF model: the modes are morph targets, their swing an animation."""

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from beamviz import __version__
from beamviz.drawing import beam_mesh as tube
from beamviz.drawing import colours, sizes
from beamviz.drawing.modes import displacement
from beamviz.drawing.objects import HUB_HEIGHT, annulus, placed
from beamviz.drawing.subdivision import cut
from beamviz.exports.gltf import INDICES, VERTICES, Gltf
from beamviz.exports.loop import Loop, looped
from beamviz.exports.solved_scene import Moment, Shot

KEYS = 24  # of the animation, for each cycle of its fastest motion
Z_UP = [-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)]  # glTF has y up
Channel = tuple[int, str, np.ndarray]  # node, what of it, values (keys, ...)


def write_glb(file: Path, shot: Shot) -> None:
    """Hub, beam and mass, in lengths of the beam. Who stands beside the hub sees it turn."""
    gltf = Gltf(f"beamviz {__version__}")
    rest = Moment(np.zeros(len(shot.shapes.modes)), 0.0)
    loop = None if shot.words else looped(shot, ground=False)
    share = np.linspace(0.0, 1.0, keys(loop) + 1) if loop else np.zeros(1)
    moments = [loop.moment(part) for part in share] if loop else [rest]
    swing = weights(shot, moments)
    hub = gltf.add("nodes", {"name": "hub", "mesh": hub_mesh(gltf, shot)})
    mesh = beam_mesh(gltf, shot, swing[0])
    beam = gltf.add("nodes", {"name": "beam", "mesh": mesh})
    parts, moving = [hub, beam], [(beam, "weights", swing.ravel())]
    if shot.scene.beam.alpha > 0:
        path = np.array([mass_at(shot, moment) for moment in moments])
        node = {"name": "mass", "mesh": mass_mesh(gltf, shot), "translation": path[0].tolist()}
        parts.append(gltf.add("nodes", node))
        moving.append((parts[-1], "translation", path))
    wheel = gltf.add("nodes", {"name": "wheel", "children": parts})
    if loop and loop.angle:
        turns = Rotation.from_euler("z", [[moment.angle] for moment in moments])
        moving.append((wheel, "rotation", turns.as_quat()))
    root = gltf.add("nodes", {"name": "beamviz", "children": [wheel], "rotation": Z_UP})
    gltf.data |= {"scene": 0, "scenes": [{"nodes": [root]}]}
    if loop:
        animate(gltf, loop.seconds * share, moving)
    file.write_bytes(gltf.encoded())


def keys(loop: Loop) -> int:
    """How many steps the animation has."""
    farthest = max(np.abs(loop.phases).max(initial=0.0), abs(loop.angle))
    return KEYS * max(1, round(farthest / (2 * math.pi)))


def animate(gltf: Gltf, times: np.ndarray, moving: list[Channel]) -> None:
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


def targets_of(shot: Shot) -> list[Target]:
    """The morph targets; with Coriolis forces a mode has two more, a quarter period apart."""
    quarters = [(0.25, ""), (0.75, "-")]
    if np.iscomplexobj(shot.shapes.modes):
        quarters += [(0.0, "'"), (0.5, "'-")]
    return [
        Target(shot.shapes.labels[k] + mark, k, part) for k in shot.shown for part, mark in quarters
    ]


def weights(shot: Shot, moments: list[Moment]) -> np.ndarray:
    """Weight (moments, targets) of each morph target, 0 .. 1."""
    values = [
        [math.cos(moment.phases[k] - 2 * math.pi * part) for moment in moments]
        for _, k, part in targets_of(shot)
    ]
    return np.maximum(np.array(values).reshape(-1, len(moments)).T, 0.0)


def beam_mesh(gltf: Gltf, shot: Shot, start: np.ndarray) -> int:
    """The beam at its equilibrium, coloured by how far each place of it swings."""
    shapes, view = cut(shot.shapes, shot.seen()), shot.scene.view
    section = sizes.section(shapes.beam, view.thicken)

    def surface(moved: np.ndarray) -> np.ndarray:
        return tube.swept(*placed(shapes, shapes.centreline + moved), *section)[0]

    still = surface(np.zeros_like(shapes.centreline))
    _, faces = tube.swept(*placed(shapes, shapes.centreline), *section)
    swings, morphs, targets = np.zeros(len(shapes.x)), [], targets_of(shot)
    for _, k, part in targets:
        alone = np.where(np.arange(len(shapes.modes)) == k, shot.amplitudes, 0.0)
        moved = displacement(shapes, np.full(len(shapes.modes), 2 * math.pi * part), alone)
        if part < 0.5:
            swings = np.hypot(swings, np.linalg.norm(moved, axis=1))
        morphs.append({"POSITION": gltf.array(surface(moved) - still, VERTICES)})
    colour = np.tile(np.array(colours.GREYED) / 255, (len(swings), 1))
    if not shot.words:
        colour = colours.mapped(swings / max(swings.max(), 1e-9), colours.SEQUENTIAL)
    primitive = {
        "attributes": {
            "POSITION": gltf.array(still, VERTICES),
            "COLOR_0": gltf.array(np.repeat(colours.linear(colour), 4, axis=0), VERTICES),
        },
        "indices": gltf.array(faces.ravel(), INDICES),
        "material": material(gltf, "beam", (255, 255, 255)),
    }
    mesh: dict[str, Any] = {"name": "beam", "primitives": [primitive]}
    if targets:
        primitive["targets"] = morphs
        names = [target.name for target in targets]
        mesh |= {"weights": start.tolist(), "extras": {"targetNames": names}}
    return gltf.add("meshes", mesh)


def hub_mesh(gltf: Gltf, shot: Shot) -> int:
    """The drum, or the hoop of an inward beam."""
    beam = shot.scene.beam
    radius = sizes.hub_radius(beam)
    drum = trimesh.creation.cylinder(radius, HUB_HEIGHT, sections=96)
    return solid(gltf, "hub", annulus(radius) if beam.delta < 0 else drum, colours.HUB)


def mass_mesh(gltf: Gltf, shot: Shot) -> int:
    """The concentrated mass, around the origin."""
    radius = sizes.mass_radius(shot.scene.beam, shot.scene.view.thicken)
    ball = trimesh.creation.icosphere(subdivisions=3, radius=radius)
    return solid(gltf, "mass", ball, colours.MASS, smooth=True)


def mass_at(shot: Shot, moment: Moment) -> np.ndarray:
    """Where the mass is, (3,)."""
    moved = displacement(shot.shapes, moment.phases, shot.amplitudes)
    return placed(shot.shapes, shot.shapes.centreline + moved)[0][shot.shapes.mass]


def solid(
    gltf: Gltf, name: str, body: trimesh.Trimesh, colour: colours.RGB, *, smooth: bool = False
) -> int:
    """A mesh of one colour; without normals a viewer draws its faces flat."""
    attributes = {"POSITION": gltf.array(body.vertices, VERTICES)}
    if smooth:
        attributes["NORMAL"] = gltf.array(body.vertex_normals, VERTICES)
    primitive = {
        "attributes": attributes,
        "indices": gltf.array(body.faces.ravel(), INDICES),
        "material": material(gltf, name, colour),
    }
    return gltf.add("meshes", {"name": name, "primitives": [primitive]})


def material(gltf: Gltf, name: str, colour: colours.RGB) -> int:
    """A matt one, seen from both sides."""
    factor = [*colours.linear(np.array(colour) / 255).tolist(), 1.0]
    matt = {"baseColorFactor": factor, "metallicFactor": 0.0, "roughnessFactor": 0.6}
    entry = {"name": name, "pbrMetallicRoughness": matt, "doubleSided": True}
    return gltf.add("materials", entry)
