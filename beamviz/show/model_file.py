"""The vibrating beam as a glTF model: the modes are morph targets, their swing an animation."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from beamviz import __version__
from beamviz.show import colours, sizes, tube
from beamviz.show.gltf import INDICES, VERTICES, Gltf
from beamviz.show.loop import Loop, looped
from beamviz.show.motion import displacement
from beamviz.show.pieces import cut
from beamviz.show.shot import Moment, Shot
from beamviz.show.stage import HUB_HEIGHT, annulus, placed

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


def parts_of_modes(shot: Shot) -> list[tuple[int, complex]]:
    """Mode and factor of each morph target: with Coriolis forces a mode has two, a quarter period
    apart."""
    factors = (1.0, 1j) if np.iscomplexobj(shot.shapes.modes) else (1.0,)
    return [(k, factor) for k in shot.shown for factor in factors]


def weights(shot: Shot, moments: list[Moment]) -> np.ndarray:
    """Weight (moments, targets) of each morph target."""
    values = [
        [math.sin(m.phases[k]) if factor == 1 else math.cos(m.phases[k]) for m in moments]
        for k, factor in parts_of_modes(shot)
    ]
    return np.array(values).reshape(-1, len(moments)).T


def beam_mesh(gltf: Gltf, shot: Shot, start: np.ndarray) -> int:
    """The beam at its equilibrium, coloured by how far each place of it swings."""
    shapes, look = cut(shot.shapes, shot.seen()), shot.scene.look
    section = sizes.section(shapes.beam, look.thicken)

    def surface(moved: np.ndarray) -> np.ndarray:
        return tube.swept(*placed(shapes, shapes.centreline + moved), *section)[0]

    still = surface(np.zeros_like(shapes.centreline))
    _, faces = tube.swept(*placed(shapes, shapes.centreline), *section)
    swings, targets = np.zeros(len(shapes.x)), []
    for k, factor in parts_of_modes(shot):
        alone = np.where(np.arange(len(shapes.modes)) == k, shot.amplitudes, 0.0)
        phases = np.full(len(shapes.modes), math.pi / 2 if factor == 1 else 0.0)
        moved = displacement(shapes, phases, alone)
        swings = np.hypot(swings, np.linalg.norm(moved, axis=1))
        targets.append({"POSITION": gltf.array(surface(moved) - still, VERTICES)})
    colour = np.tile(np.array(colours.GREYED) / 255, (len(swings), 1))
    if not shot.words:
        colour = colours.mapped(swings / max(swings.max(), 1e-9), colours.SEQUENTIAL)
    primitive = {
        "attributes": {
            "POSITION": gltf.array(still, VERTICES),
            "COLOR_0": gltf.array(np.repeat(colours.linear(colour), 4, axis=0), VERTICES),
        },
        "indices": gltf.array(faces.ravel(), INDICES),
        "material": material(gltf, (255, 255, 255)),
    }
    mesh: dict[str, Any] = {"name": "beam", "primitives": [primitive]}
    if targets:
        primitive["targets"] = targets
        names = [shapes.labels[k] + ("" if f == 1 else "'") for k, f in parts_of_modes(shot)]
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
    radius = sizes.mass_radius(shot.scene.beam, shot.scene.look.thicken)
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
        "material": material(gltf, colour),
    }
    return gltf.add("meshes", {"name": name, "primitives": [primitive]})


def material(gltf: Gltf, colour: colours.RGB) -> int:
    """A matt one, seen from both sides."""
    factor = [*colours.linear(np.array(colour) / 255).tolist(), 1.0]
    matt = {"baseColorFactor": factor, "metallicFactor": 0.0, "roughnessFactor": 0.6}
    return gltf.add("materials", {"pbrMetallicRoughness": matt, "doubleSided": True})
