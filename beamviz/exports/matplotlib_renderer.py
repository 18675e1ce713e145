"""The scene drawn by matplotlib, where no browser is found: the same view, back to front."""

import math

import numpy as np
import trimesh
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from beamviz.drawing import beam_mesh as tube
from beamviz.drawing import camera, colours, sizes
from beamviz.drawing.modes import displacement
from beamviz.drawing.objects import EDGES, HUB_HEIGHT, annulus, placed
from beamviz.drawing.subdivision import cut
from beamviz.exports.solved_scene import Moment, Shot

DPI = 100
NEAR = 0.3  # nothing nearer to the camera is drawn
REACH, CELL = 2.0, 0.5  # of the ground: how far it is drawn, distance of its lines
VISIBLE = 3.0  # nor what is so far from the clamp
SUN = np.array([-0.5, -1.0, 2.2]) / math.sqrt(0.25 + 1.0 + 4.84)
SHADOW = (0.86, 0.865, 0.875)


def drawn(shot: Shot, moment: Moment, width: int, height: int) -> np.ndarray:
    """The scene (height, width, 4) on a transparent ground."""
    figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI, facecolor="none")
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    tall = math.tan(camera.FIELD_OF_VIEW / 2)
    axes.set(xlim=(-tall * width / height, tall * width / height), ylim=(-tall, tall))
    axes.set_axis_off()
    solid = bodies(shot, moment, shot.scale(width, height))
    paint(axes, View(shot, moment, width / height), moment, *solid)
    if shot.words:
        letters = 14 * min(1.0, width / 640)  # the longest line takes four fifths of the picture
        figure.text(0.5, 0.8, shot.words, ha="center", fontsize=letters)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba()).copy()


class View:
    """Perspective projection from where a shot is seen at a moment."""

    def __init__(self, shot: Shot, moment: Moment, aspect: float):
        self.shot, seen = shot, shot.camera(aspect)
        target = camera.target(shot.shapes, shot.scene.view.rotating_frame)
        self.position = np.array(seen.position) + target
        self.axes = camera.axes(np.subtract(seen.position, seen.look_at))
        self.wheel = Rotation.from_euler(
            "z", 0.0 if shot.scene.view.rotating_frame else moment.angle
        ).as_matrix()

    def depth(self, points: np.ndarray) -> np.ndarray:
        """Distance (...) in front of the camera of points (..., 3)."""
        return (points - self.position) @ self.axes[:, 2]

    def project(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) in the picture, (..., 2)."""
        return ((points - self.position) @ self.axes[:, :2] * [1, -1]) / self.depth(points)[
            ..., None
        ]


def paint(
    axes: Axes, view: View, moment: Moment, triangles: np.ndarray, colour: np.ndarray
) -> None:
    """Ground, shadow and outline, then triangles (n, 3, 3) in colours (n, 3), far ones first."""
    shot, beam = view.shot, view.shot.scene.beam
    triangles = triangles @ view.wheel.T
    ahead = (view.depth(triangles) > NEAR).all(axis=1)
    triangles, colour = triangles[ahead], colour[ahead]
    low = sizes.ground(beam)
    middle = camera.target(shot.shapes, shot.scene.view.rotating_frame)[:2]
    ground = grid(middle, low, -moment.angle if shot.scene.view.rotating_frame else 0.0)
    ground = ground[(view.depth(ground) > NEAR).all(axis=1)]
    axes.add_collection(thin(view.project(ground), 0.4, zorder=0))
    fallen = triangles - (triangles[..., 2:] - low) / SUN[2] * SUN
    fallen = fallen[(view.depth(fallen) > NEAR).all(axis=1)]
    axes.add_collection(
        PolyCollection(list(view.project(fallen)), facecolors=[SHADOW], edgecolors=[SHADOW])
    )
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    lit = np.clip(colour * (0.78 + 0.25 * normals @ SUN)[:, None], 0, 1)
    order = np.argsort(-view.depth(triangles.mean(axis=1)))
    order = order[((view.position - triangles[order, 0]) * normals[order]).sum(axis=1) > 0]
    axes.add_collection(
        PolyCollection(
            list(view.project(triangles[order])),
            facecolors=lit[order],
            edgecolors=lit[order],
            linewidths=1.0,  # less leaves seams between triangles that one can see through
        )
    )
    if shot.scene.view.ghosts:
        section = np.array([1.0, *sizes.section(beam, shot.scene.view.thicken)])
        if shot.shapes.plane == "flapwise":
            section = section[[0, 2, 1]]
        outline = (EDGES * section + [beam.delta + 0.5, 0.0, 0.0]) @ view.wheel.T
        axes.add_collection(thin(view.project(outline), 0.7, zorder=2))


def thin(lines: np.ndarray, alpha: float, zorder: float) -> LineCollection:
    """Thin grey lines (n, 2, 2)."""
    return LineCollection(
        list(lines),
        linewidths=0.6,
        colors=[np.array(colours.GRID) / 255],
        alpha=alpha,
        zorder=zorder,
    )


def grid(middle: np.ndarray, low: float, angle: float) -> np.ndarray:
    """Pieces (n, 2, 3) of the lines of the ground around `middle` (2,), at height `low`: a lattice
    around the axis, turned by angle [rad]."""
    lines = []
    for turned in (angle, angle + math.pi / 2):
        along, across = (
            np.array([math.cos(a), math.sin(a)]) for a in (turned, turned + math.pi / 2)
        )
        first, last = (math.ceil((middle @ across + side * REACH) / CELL) for side in (-1, 1))
        for k in range(first, last):
            reach = math.sqrt(REACH**2 - (k * CELL - middle @ across) ** 2)
            at = middle @ along + reach * np.linspace(-1, 1, 17)[:, None]
            points = np.insert(at * along + k * CELL * across, 2, low, axis=1)
            lines.append(np.stack([points[:-1], points[1:]], 1))
    return np.concatenate(lines)


def bodies(shot: Shot, moment: Moment, scale: float) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (n, 3, 3) of hub, beam and mass, and their colours (n, 3); a length of the beam
    takes `scale` pixels."""
    shapes, view = cut(shot.shapes, shot.seen(scale)), shot.scene.view
    moved = displacement(shapes, moment.phases, shot.amplitudes)
    points, normal = placed(shapes, shapes.centreline + moved)
    vertices, triangles = tube.swept(points, normal, *sizes.section(shapes.beam, view.thicken))
    along = colours.along(shapes, view.colouring, moved, shot.amplitudes)
    if shot.words:
        along = np.tile(np.array(colours.GREYED) / 255, (len(along), 1))
    painted = np.concatenate([np.repeat(along, 8, axis=0), np.repeat(along[[0, -1]], 2, axis=0)])
    parts = [(vertices[triangles], painted)]
    radius = sizes.hub_radius(shapes.beam)
    hoop = annulus(radius)
    hub = hoop.vertices[hoop.faces] if shapes.beam.delta < 0 else drum(radius)
    parts.append((hub, np.tile(np.array(colours.HUB) / 255, (len(hub), 1))))
    if shapes.beam.alpha > 0:
        ball = trimesh.creation.icosphere(
            subdivisions=3, radius=sizes.mass_radius(shapes.beam, view.thicken)
        )
        mass = (ball.vertices + points[shapes.mass])[ball.faces]
        parts.append((mass, np.tile(np.array(colours.MASS) / 255, (len(mass), 1))))
    return np.concatenate([a for a, _ in parts]), np.concatenate([b for _, b in parts])


def drum(radius: float) -> np.ndarray:
    """Triangles (n, 3, 3) of the part of a drum around the clamp that a picture can hold: small
    ones, since one that reaches behind the camera cannot be projected."""
    r = np.append(np.linspace(max(radius - VISIBLE, 0.0), radius, 15), radius)
    z = np.append(np.full(15, HUB_HEIGHT / 2), -HUB_HEIGHT / 2)
    turn = min(math.pi, VISIBLE / radius) * np.linspace(-1, 1, 121)[:, None]
    grid = np.stack([r * np.cos(turn), r * np.sin(turn), np.broadcast_to(z, (121, 16))], -1)
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    return np.concatenate([np.stack(part, 2).reshape(-1, 3, 3) for part in ((a, b, c), (a, c, d))])
