"""Pictures of a solved scene: what the page draws, rendered in numpy with the page's light.

What three.js does to light on a page is repeated here (Lambert's and a rough specular reflection,
the ACES tone curve) without a browser or a graphics library: the same picture on every machine.
"""

import math
import threading
from functools import lru_cache
from importlib.metadata import distribution
from typing import Any

import numpy as np
import trimesh
from PIL import Image, ImageDraw, ImageFilter, ImageFont

from beamviz.drawing import camera, colours
from beamviz.drawing.colours import linear
from beamviz.drawing.scene_graph import Node, PlacedNode, SceneGraph, rotations
from beamviz.drawing.surroundings import GROUND_LIGHT, LIGHTS, SKY
from beamviz.exports.solved_scene import DrawableScene

SAMPLES = 8  # of a pixel at an edge
SPECULAR = 0.04  # reflectance of a dielectric seen from the front
FULL_HEIGHT = 720  # [pixels] of a picture: lines are as much thinner as it is smaller
UP = np.array([0.0, 0.0, 1.0])
TOWARDS = trimesh.unitize([place for place, _ in LIGHTS.values()])  # (lights, 3)
INTENSITIES = [intensity for _, intensity in LIGHTS.values()]
SUN = TOWARDS[0]  # the light that casts shadows
AMBIENT = SKY * (1 + linear(GROUND_LIGHT)) / 2  # at a point: half from above, half from below
SHADOW_BLUR = 0.014  # [lengths of the beam] standard deviation
CYLINDER = np.array(trimesh.creation.cylinder(1.0, 1.0, sections=160).triangles)  # looks round
# Letters of a caption: [pixels], and of the width of the picture; the part of the width
# that a line may take; height [lengths of the beam] at most, for a title between two beams.
MAX_LETTERS, RELATIVE_LETTERS, RELATIVE_LINE, MAX_TITLE = 18, 0.026, 0.8, 0.065
CAPTION_ALPHA, CAPTION_PADDING = 199, 0.3  # of its ground; of a line's height, on each side
# The ACES tone curve as in three.js: to its colour space and back.
TO_ACES = np.array(
    [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]]
)
FROM_ACES = np.array(
    [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]]
)
EXPOSURE = 1 / 0.6
NEAR = 0.02  # distance from the camera up to which a triangle may be anywhere in the picture
STRIDE = 0.381966  # of the offsets of samples, the golden section: neighbours differ by much
SLACK = 1e-4  # [pixels]: no sample on the edge between two triangles is in neither
CONTRAST = np.uint32(0xF8F8F8F8)  # bits of four bytes whose difference can be seen
SMALL = 1e-6  # in place of a divisor that may be 0


class Geometry:
    """All that a page would show of a scene now. Colours are linear light.

    corners: of triangles (t, 3, 3); normals: outwards (t, 3); colours: (t, 4), with opacity;
    casts: whether each casts a shadow (t,); lines: ends (n, 2, 3), colour (3,) and thickness
    [pixels]; points: of frames, by name; floor: the cylinder whose top is not among the triangles.
    """

    def __init__(self, scene: SceneGraph):
        self.lines: list[tuple[np.ndarray, np.ndarray, float]] = []
        self.points: dict[str, np.ndarray] = {}
        self.floor: PlacedNode | None = None
        parts = []
        for placed in scene.visible():
            node, rotation, position = placed
            if node.kind == "frame":
                self.points[node.name] = position
                continue
            if node.kind == "lines":
                ends = node.points @ rotation.T + position
                self.lines.append((ends, linear(node.colors), node.thickness))
                continue
            if node.kind == "light":  # see LIGHTS
                continue
            if node.kind == "instances":
                corners, colour = instances(node)
                if node.side == "double":
                    corners = np.concatenate([corners, corners[:, ::-1]])
                    colour = np.concatenate([colour, colour])
            elif node.kind == "mesh":
                corners, colour = node.vertices[node.faces], linear(node.color)
                if node.side == "double":
                    corners = np.concatenate([corners, corners[:, ::-1]])
            else:
                corners = CYLINDER * [node.radius, node.radius, node.height]
                colour = linear(node.color)
                if node.receive_shadow:
                    self.floor, corners = placed, corners[corners[..., 2].min(axis=1) < 0]
            rgba = np.full((len(corners), 4), 1.0 if node.opacity is None else node.opacity)
            rgba[:, :3] = colour
            casts = np.full(len(corners), node.cast_shadow)
            parts.append((corners @ rotation.T + position, rgba, casts))
        self.corners, self.colours, self.casts = map(np.concatenate, zip(*parts, strict=True))
        self.normals = trimesh.unitize(trimesh.triangles.cross(self.corners))


def instances(node: Node) -> tuple[np.ndarray, np.ndarray]:
    """The triangles of all instances, and their colours."""
    axes = rotations(node.batched_wxyzs)
    sized = node.vertices[node.faces].reshape(-1, 3) * node.batched_scales[:, None]
    corners = sized @ axes.mT + node.batched_positions[:, None]
    colour = np.repeat(node.batched_colors / 255, len(node.faces), axis=0)
    return corners.reshape(-1, 3, 3), colour


class Renderer:
    """Pictures of a solved scene of `width` by `height` pixels, in any thread."""

    def __init__(self, solved: DrawableScene, width: int, height: int):
        self.solved = solved
        self.width, self.height = self.size = width, height
        view = solved.camera(width / height)
        self.eye = np.array(view.position)
        axes = camera.axes(np.subtract(view.position, view.look_at))
        self.distance = math.dist(view.position, view.look_at)
        self.focal = height / (2 * math.tan(camera.FIELD_OF_VIEW / 2))  # [pixels]
        # From the eye to a point, times this: x w, y w and w, see `samples`.
        to_pixels = [[self.focal, 0, 0], [0, self.focal, 0], [width / 2, height / 2, 1]]
        self.projection = axes @ to_pixels
        dark = solved.scene.view.dark
        self.background, self.letters = colours.BACKGROUND[dark], colours.LETTERS[dark]
        self.scene, self.lock = SceneGraph(), threading.Lock()
        self.beams = solved.draw(self.scene, camera.scale(self.distance, height))

    def picture(self, moment: Any, *, transparent: bool = False) -> Image.Image:
        """The picture at a moment in RGB, or with transparency in RGBA."""
        with self.lock:
            self.solved.move(self.beams, moment)
            scene = Geometry(self.scene)
        picture = Image.new("RGBA", self.size, (*self.background, 0 if transparent else 255))
        if scene.floor is not None:  # everything is above it
            self.add_floor(picture, scene.floor, scene)
        self.add_objects(picture, scene)
        picture.alpha_composite(self.captions(scene))
        return picture if transparent else picture.convert("RGB")

    def projected(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) in homogeneous coordinates of the picture: x w, y w, w."""
        return (points - self.eye) @ self.projection

    # Objects

    def add_objects(self, picture: Image.Image, scene: Geometry) -> None:
        """Put bodies and lines over a picture, antialiased where neighbouring pixels differ."""
        seen = ((self.eye - scene.corners[:, 0]) * scene.normals).sum(axis=1) > 0
        corners, rgba = scene.corners[seen], scene.colours[seen]
        light = shades(self.eye, corners.mean(axis=1), scene.normals[seen], rgba[:, :3])
        rgba[:, :3] = rgba[:, 3:] * light
        thin = min(1.0, self.height / FULL_HEIGHT)
        strips, wider = (
            [line_triangles(self.projected(e), thin * width + k) for e, _, width in scene.lines]
            for k in (0, 1)
        )
        tints = [np.tile([*toned(c), 1.0], (2 * len(e), 1)) for e, c, _ in scene.lines]
        corners = np.concatenate([self.projected(corners), *strips])
        rgba = np.concatenate([rgba, *tints], dtype=np.float32)
        shown = np.zeros((self.height, self.width, 4), np.uint8)
        pixels = np.ones(shown.shape[:2], bool)
        draw(shown, pixels, corners, rgba, 1)
        differ = edges(shown)
        for strip in wider:  # a line may be between the centres of pixels
            differ.ravel()[samples(strip, pixels, 1)[1]] = True
        draw(shown, differ, corners, rgba, SAMPLES)
        picture.alpha_composite(Image.fromarray(shown))

    # Floor

    def add_floor(self, picture: Image.Image, floor: PlacedNode, scene: Geometry) -> None:
        """Put the top of a round floor over a picture, if it is seen, with the shadow on it."""
        centre = floor.position + floor.node.height / 2 * UP
        if self.eye[2] <= centre[2]:
            return
        # A place (x, y) shows the point points @ (x, y, 1), homogeneous, from the centre; the last
        # of its coordinates is positive below the horizon.
        points = np.linalg.inv([*self.projection[:2], self.projected(centre)]).T
        tone = np.rint(255 * shades(self.eye, centre, UP, linear(floor.node.color)))
        disc = Image.new("RGB", self.size, tuple(tone.astype(int).tolist()))
        bodies = scene.corners[scene.casts & (scene.normals @ SUN > 0)]
        disc.paste("black", mask=self.shadow(bodies, centre[2], floor.node.receive_shadow))
        disc.putalpha(self.disc(points, floor.node.radius))
        picture.alpha_composite(disc)

    def disc(self, points: np.ndarray, radius: float) -> Image.Image:
        """The share of each pixel that a disc around the origin covers, in bytes: by the distance
        from its edge, a conic in the picture."""
        x, y = (np.arange(count, dtype=np.float32) + 0.5 for count in self.size)
        u, v, w = (a * x + (b * y[:, None] + c) for a, b, c in points.astype(np.float32))
        inside = (radius * w) ** 2 - u * u - v * v
        share = 0.5 + inside / np.hypot(*np.gradient(inside))
        return Image.fromarray((255 * share.clip(0, 1) * (w > 0)).astype(np.uint8))

    def shadow(self, bodies: np.ndarray, height: float, darkness: float) -> Image.Image:
        """The soft shadow of triangles (t, 3, 3) on a level, in bytes up to 255 `darkness`."""
        fallen = bodies - (bodies[..., 2:] - height) / SUN[2] * SUN
        covered = np.zeros(self.size[::-1], np.uint8)
        covered.ravel()[samples(self.projected(fallen), covered == 0, 1)[1]] = round(255 * darkness)
        blur = SHADOW_BLUR * self.focal / self.distance
        slope = abs(self.eye[2] - height) / self.distance
        return Image.fromarray(covered).filter(ImageFilter.GaussianBlur((blur, blur * slope)))

    # Captions

    def captions(self, scene: Geometry) -> Image.Image:
        """The texts, each below the ones before that it would cover, as in captions.js."""
        layer = Image.new("RGBA", self.size)
        paper, placed = ImageDraw.Draw(layer), list[tuple[int, ...]]()
        title = MAX_TITLE * self.focal / self.distance if len(self.beams.rows) > 1 else math.inf
        letters = min(MAX_LETTERS, RELATIVE_LETTERS * self.width, title)
        for caption in self.beams.captions:
            x, y, distance = self.projected(scene.points[caption.point.name])
            if distance <= NEAR:
                continue
            lines = caption.text.split("\n")
            widest = max(map(font(100.0).getlength, lines)) / 100
            face = font(max(min(letters, RELATIVE_LINE * self.width / widest), 1.0))
            line = sum(face.getmetrics())
            width = math.ceil(max(map(face.getlength, lines)) + 2 * CAPTION_PADDING * line)
            before = (1.0 if caption.anchor == "right" else 0.5) * width  # left of the point
            left = max(min(round(x / distance - before), self.width - width), 0)
            height, right = len(lines) * line, left + width
            above = {"top": 0.0, "bottom": 1.0}.get(caption.anchor, 0.5) * height
            top = round(y / distance - above)
            for start, stop, upper, lower in placed:
                if left <= stop and start <= right and upper < top + height and top < lower:
                    top = lower
            placed.append((left, right, top, top + height))
            ground = (*self.background, CAPTION_ALPHA)
            paper.rectangle((left, top, right - 1, top + height - 1), ground)
            at, descent = (left + width / 2, top), face.getmetrics()[1]
            paper.text(at, caption.text, self.letters, face, "ma", descent, "center")
        return layer


@lru_cache(64)
def font(size: float) -> ImageFont.FreeTypeFont:
    """DejaVu Sans as shipped with matplotlib: the same text on every machine."""
    file = distribution("matplotlib").locate_file("matplotlib/mpl-data/fonts/ttf/DejaVuSans.ttf")
    return ImageFont.truetype(str(file), size, layout_engine=ImageFont.Layout.BASIC)


def line_triangles(ends: np.ndarray, thickness: float) -> np.ndarray:
    """Lines (n, 2, 3), in homogeneous coordinates, as triangles (2 n, 3, 3) of a width [pixels]."""
    normal = trimesh.unitize(np.cross(ends[:, 0], ends[:, 1]) * [1, 1, 0])
    aside = thickness / 2 * normal[:, None] * ends[..., 2:]
    quads = np.concatenate([ends - aside, (ends + aside)[:, ::-1]], 1)
    return quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)


def shades(
    eye: np.ndarray, points: np.ndarray, normals: np.ndarray, albedo: np.ndarray
) -> np.ndarray:
    """Colours (..., 3) in sRGB of points on surfaces with unit normals and albedo (..., 3), by
    Lambert's reflection and that of a surface as rough as can be, as in three.js."""
    towards = eye - points
    towards = towards / np.linalg.norm(towards, axis=-1, keepdims=True)
    facing = np.abs((normals * towards).sum(axis=-1, keepdims=True))
    incident = np.maximum(normals @ TOWARDS.T, 0.0)  # (..., lights)
    half = towards[..., None, :] + TOWARDS
    half /= np.maximum(np.linalg.norm(half, axis=-1, keepdims=True), SMALL)
    fresnel = SPECULAR + (1 - SPECULAR) * (1 - (half * TOWARDS).sum(axis=-1).clip(0, 1)) ** 5
    specular = fresnel / (2 * np.maximum(incident + facing, SMALL))
    power = incident * INTENSITIES / math.pi
    light = albedo * (AMBIENT / math.pi + power.sum(axis=-1, keepdims=True))
    light += (power * specular).sum(axis=-1, keepdims=True)
    return toned(light)


def toned(light: np.ndarray) -> np.ndarray:
    """Linear light (..., 3) as three.js shows it: the ACES tone curve, then sRGB."""
    v = np.asarray(light) * EXPOSURE @ TO_ACES.T
    curve = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081)
    shown = (curve @ FROM_ACES.T).clip(0, 1)
    return np.where(shown <= 0.0031308, 12.92 * shown, 1.055 * shown ** (1 / 2.4) - 0.055)


# Triangles. Corners are homogeneous, (x w, y w, w) at the place x, y [pixels] and the distance w:
# triangles that reach behind the camera need no clipping. A pixel has `count` samples, one in each
# of as many rows, at different x (N rooks): edges are as smooth as on a grid of count x count.


def samples(
    corners: np.ndarray, drawn: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The samples of the pixels `drawn` (h, w) that are in triangles (t, 3, 3): the triangle, the
    place in an array (pixels drawn, count), and 1 / w of each."""
    (height, width), (a, b, c) = drawn.shape, corners.transpose(1, 2, 0)
    # Functions of (x, y, 1) that are 0 on an edge, and 1 / w at the opposite corner: (3, 3, t).
    edges = np.stack([np.cross(*pair, axis=0) for pair in ((b, c), (c, a), (a, b))], 1)
    volume = (a * edges[:, 0]).sum(axis=0)
    seen = np.flatnonzero(np.abs(volume) > 1e-12)
    edges, w = edges[..., seen] / volume[seen], corners[seen, :, 2].T
    y = count * corners[seen, :, 1].T / w - 0.5
    anywhere = w.min(axis=0) < NEAR
    rows = np.where(anywhere, 0, y.min(axis=0)), np.where(anywhere, count * height, y.max(axis=0))
    top, end = bounded(rows, count * height)
    face, row = ranges(top, end)
    slope, rise, constant = edges
    with np.errstate(divide="ignore", invalid="ignore"):  # x of each edge in the first row
        edge = np.array([-(constant + rise * (top + 0.5) / count), -rise / count]) / slope
    down, ends = (row - top[face]).astype(np.float32), []
    for side in (1, -1):  # left and right ends of rows
        none = np.array([-side * np.inf, 0.0])[:, None, None]
        limits = side * np.where(side * slope > 0, edge, none)
        first, step = np.take(limits.astype(np.float32), face, axis=2)
        ends.append(side * (first + step * down).max(axis=0))
    order = np.argsort(np.arange(count) * STRIDE % 1)
    offset = ((order + 0.5) / count).astype(np.float32)[row % count]
    start, stop = bounded((ends[0] - offset - SLACK, ends[1] - offset + SLACK), width)
    places = np.insert(drawn.cumsum(dtype=np.int32), 0, 0)
    first = row // count * width
    line, place = ranges(places[first + start], places[first + stop])
    row = row[line]
    x = np.flatnonzero(drawn)[place] % width + offset[line]
    face = face[line]
    slope, rise, constant = np.take(edges.sum(axis=1), face, axis=1)
    depth = slope * x + rise * ((row + 0.5) / count) + constant
    return seen[face], place * count + row % count, depth.astype(np.float32)


def bounded(ends: tuple[np.ndarray, np.ndarray], size: int) -> tuple[np.ndarray, np.ndarray]:
    """Start and stop of the whole numbers between two ends, of those in 0 .. size - 1."""
    start, last = np.ceil(ends[0]).clip(0, size), np.floor(ends[1]).clip(-1, size - 1)
    return start.astype(np.int32), np.maximum(last + 1, start).astype(np.int32)


def ranges(start: np.ndarray, stop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The integers of n ranges start .. stop - 1, one after the other, preceded by their ranges."""
    lengths = stop - start
    owner = np.repeat(np.arange(len(start), dtype=np.int32), lengths)
    shift = (start - np.cumsum(lengths) + lengths).astype(np.int32)
    return owner, np.arange(len(owner), dtype=np.int32) + shift[owner]


def draw(
    shown: np.ndarray, pixels: np.ndarray, corners: np.ndarray, rgba: np.ndarray, count: int
) -> None:
    """Draw some `pixels` (h, w) of a picture (h, w, 4) in bytes, of triangles (t, 3, 3) with
    rgba (t, 4), multiplied by their opacity, and `count` samples of each pixel."""
    triangle, slot, depth = samples(corners, pixels, count)
    solid = (rgba[:, 3] == 1)[triangle]
    nearest = np.zeros(count * np.count_nonzero(pixels), np.float32)
    result = np.zeros((len(nearest), 4), np.float32)
    for part in (solid, ~solid):  # translucent ones over the others
        front = np.flatnonzero(part & (depth >= nearest[slot]))
        np.maximum.at(nearest, slot[front], depth[front])
        front = front[nearest[slot[front]] == depth[front]]
        at, colour = slot[front], np.take(rgba, triangle[front], axis=0)
        result[at] = colour if part is solid else colour + (1 - colour[:, 3:]) * result[at]
    touched = np.flatnonzero(nearest.reshape(-1, count).any(axis=1))
    mean = result.reshape(-1, count, 4)[touched].mean(axis=1)
    mean[:, :3] /= np.maximum(mean[:, 3:], SMALL)
    shown.reshape(-1, 4)[np.flatnonzero(pixels)[touched]] = np.rint(255 * mean)


def edges(shown: np.ndarray) -> np.ndarray:
    """Where a picture (h, w, 4) in bytes differs visibly from a neighbouring pixel: (h, w)."""
    visible, edge = shown.view(np.uint32)[..., 0] & CONTRAST, np.zeros(shown.shape[:2], bool)
    for axis in (0, 1):
        differ = visible != np.roll(visible, 1, axis)
        edge |= differ | np.roll(differ, -1, axis)
    return edge
