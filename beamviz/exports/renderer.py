"""Pictures of a solved scene: what the page draws, rendered in numpy with the page's light.

A page is drawn by three.js; what it does to light is repeated here (Lambert's and a rough
specular reflection, the ACES tone curve), without a browser, a display or a graphics library.
"""

import math
from functools import lru_cache
from importlib.metadata import distribution

import numpy as np
from PIL import Image, ImageDraw, ImageFilter, ImageFont

from beamviz.drawing import camera, colours
from beamviz.drawing.objects import Caption
from beamviz.exports.geometry import Geometry, Triangles, geometry, linear
from beamviz.exports.rasteriser import (
    NEAR,
    SMALL,
    clipped,
    cover,
    draw,
    edges,
    samples,
)
from beamviz.exports.solved_scene import DrawnScene, Moment, SolvedScene
from beamviz.server.viser_private import VisibleNode, offline_scene

Box = tuple[int, int, int]  # of a text: left, right, top [pixels]
FINE, FAST = 8, 5  # samples of a pixel at an edge: in a picture, a film
SPECULAR = 0.04  # reflectance of a dielectric seen from the front
FULL_HEIGHT = 720  # [pixels] of a picture: lines are as much thinner as it is smaller
UP = np.array([0.0, 0.0, 1.0])
SHADOW_CELLS = 320  # of the larger side of a shadow
SHADOW_SAMPLES = 3
SHADOW_BLUR = 0.014  # [lengths of the beam] standard deviation
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


class Renderer:
    """Pictures of a solved scene of `width` by `height` pixels.

    `draw` takes the scene at a moment, `render` makes the picture of it; only the former is bound
    to one thread.
    """

    def __init__(self, solved: SolvedScene, width: int, height: int, samples: int = FINE):
        self.width, self.height, self.samples = width, height, samples
        self.size = width, height
        view = solved.camera(width / height)
        self.eye = np.array(view.position)
        self.axes = camera.axes(np.subtract(view.position, view.look_at))
        self.distance = math.dist(view.position, view.look_at)
        self.focal = height / (2 * math.tan(camera.FIELD_OF_VIEW / 2))  # [pixels]
        dark = solved.scene.view.dark
        self.background, self.letters = colours.BACKGROUND[dark], colours.LETTERS[dark]
        self.scene = offline_scene()
        self.drawn = DrawnScene(self.scene, solved, camera.scale(self.distance, height))

    def draw(self, moment: Moment) -> Geometry:
        """The scene at a moment."""
        self.drawn.move(moment)
        return geometry(self.scene)

    def render(self, scene: Geometry, *, transparent: bool = False) -> Image.Image:
        """The picture of a scene in RGB, or with transparency in RGBA."""
        picture = Image.new("RGBA", self.size, (*self.background, 0 if transparent else 255))
        if scene.floor is not None:  # everything is above it
            self.add_floor(picture, scene.floor, scene)
        self.add_objects(picture, scene)
        boxes: list[Box] = []
        for caption in self.drawn.captions:
            self.add_caption(picture, caption, scene.points[caption.point.name], boxes)
        return picture if transparent else picture.convert("RGB")

    def seen(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) in the axes of the camera: right, down, forward."""
        return (points - self.eye) @ self.axes

    def projected(self, seen: np.ndarray) -> np.ndarray:
        """Points (..., 3) in the axes of the camera as x, y [pixels] and the inverse distance."""
        inverse = 1 / seen[..., 2:]
        middle = [self.width / 2, self.height / 2]
        return np.concatenate([self.focal * seen[..., :2] * inverse + middle, inverse], -1)

    # Objects

    def add_objects(self, picture: Image.Image, scene: Geometry) -> None:
        """Put bodies and lines over a picture, antialiased where neighbouring pixels differ."""
        thin = min(1.0, self.height / FULL_HEIGHT)
        parts = [self.bodies(scene)]
        parts += [self.strips(ends, colour, thin * width) for ends, colour, width in scene.lines]
        places, colours = (np.concatenate(part) for part in zip(*parts, strict=True))
        covered = cover(places[..., :2], self.width, self.height)
        shown = np.zeros((self.height, self.width, 4), np.uint8)
        draw(shown, places, colours, covered, 1)
        edge = edges(shown)
        lines = covered[0] >= len(parts[0][0])
        edge[covered[1, lines], covered[2, lines]] = True  # they may be between pixels' centres
        draw(shown, places, colours, covered[:, edge[*covered[1:]]], self.samples)
        picture.alpha_composite(Image.fromarray(shown))

    def bodies(self, scene: Geometry) -> tuple[np.ndarray, np.ndarray]:
        """The triangles that are seen, in the picture (t, 3, 3), and the colours (t, 3, 4) at their
        corners, in sRGB with opacity."""
        seen = self.seen(scene.triangles.corners)
        across = np.cross(seen[:, 1] - seen[:, 0], seen[:, 2] - seen[:, 0])
        shown = ((across * seen[:, 0]).sum(axis=1) < 0) | scene.triangles.double
        bodies = Triangles(*(values[shown] for values in scene.triangles))
        behind = ((self.eye - bodies.corners) * bodies.normals).sum(axis=-1, keepdims=True) < 0
        normals = bodies.normals * np.where(bodies.double[:, None, None] & behind, -1, 1)
        light = shades(self.eye, bodies.corners, normals, bodies.albedo[:, None], scene)
        opacity = np.broadcast_to(bodies.opacity[:, None, None], (len(light), 3, 1))
        parts = clipped(np.concatenate([seen[shown], light, opacity], -1))
        return self.projected(parts[..., :3]), parts[..., 3:]

    def strips(
        self, ends: np.ndarray, colour: np.ndarray, thickness: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Lines (n, 2, 3) as triangles (2 n, 3, 3) in the picture, `thickness` pixels wide, and
        their colours (2 n, 3, 4)."""
        seen = self.seen(ends)
        seen = seen[seen[..., 2].max(axis=1) > NEAR]
        along = seen[:, 1:] - seen[:, :1]
        share = (NEAR - seen[..., 2:]) / np.where(along == 0, np.inf, along)[..., 2:]
        seen = self.projected(np.where(seen[..., 2:] > NEAR, seen, seen[:, :1] + share * along))
        along = seen[:, 1, :2] - seen[:, 0, :2]
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
        aside = np.stack([-along[:, 1], along[:, 0], 0 * along[:, 0]], 1) * thickness / 2
        a, b = seen[:, 0], seen[:, 1]
        quads = np.stack([a - aside, b - aside, b + aside, a + aside], 1)
        places = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        return places, np.broadcast_to(np.append(toned(colour), 1.0), (len(places), 3, 4))

    # Floor

    def add_floor(self, picture: Image.Image, floor: VisibleNode, scene: Geometry) -> None:
        """Put the top of a round floor over a picture, if it is seen, with the shadow on it."""
        centre = floor.position + floor.props.height / 2 * UP
        eye = self.eye - centre
        if eye[2] <= 0:
            return
        # A place (x, y) shows the point points @ (x, y, 1), homogeneous, from the centre; the last
        # of its coordinates is negative below the horizon.
        pixels = np.array([[1, 0, -self.width / 2], [0, 1, -self.height / 2], [0, 0, self.focal]])
        rays = self.axes @ pixels
        points = np.stack([*(eye[k] * rays[2] - eye[2] * rays[k] for k in (0, 1)), rays[2]])
        tone = shades(self.eye, centre, UP, linear(floor.props.color), scene)
        tones = np.outer([1.0, 1 - floor.props.receive_shadow], 255 * tone)
        lit, dark = map(tuple, np.rint(tones).astype(int).tolist())
        disc = Image.new("RGB", self.size, lit)
        if scene.sun is not None:
            disc.paste(dark, mask=self.shadow(scene.triangles, scene.sun, centre, points))
        disc.putalpha(self.disc(points, floor.props.radius))
        picture.alpha_composite(disc)

    def disc(self, points: np.ndarray, radius: float) -> Image.Image:
        """The share of each pixel that a disc around the origin covers, in bytes: by the distance
        from its edge, a conic in the picture."""
        x, y = (np.arange(count, dtype=np.float32) + 0.5 for count in self.size)
        y = y[:, None]
        conic = (points.T * [-1, -1, radius**2]) @ points
        dx, dy, constant = (a * x + (b * y + c) for a, b, c in conic.astype(np.float32))
        share = 0.5 + (x * dx + y * dy + constant) / (2 * np.sqrt(dx * dx + dy * dy))
        below = points[2, 0] * x + (points[2, 1] * y + points[2, 2]) < 0
        return Image.fromarray((255 * share.clip(0, 1) * below).astype(np.uint8))

    def shadow(
        self, bodies: Triangles, sun: np.ndarray, centre: np.ndarray, points: np.ndarray
    ) -> Image.Image:
        """The soft shadow on the level of `centre` (3,), in bytes."""
        lit = bodies.casts & ((bodies.normals @ sun).mean(axis=1) > 0)
        corners = bodies.corners[lit] - centre
        fallen = (corners - corners[..., 2:] / sun[2] * sun)[..., :2]
        corner = fallen.min(axis=(0, 1)) - 4 * SHADOW_BLUR
        extent = fallen.max(axis=(0, 1)) + 4 * SHADOW_BLUR - corner
        cell = float(extent.max()) / SHADOW_CELLS
        columns, rows = (extent / cell).astype(int) + 2
        placed = np.insert((fallen - corner) / cell, 2, 1.0, axis=2)
        touched = cover(placed[..., :2], columns, rows)
        pair, number, _ = samples(placed, touched, SHADOW_SAMPLES)
        covered = np.zeros((SHADOW_SAMPLES, rows, columns), np.float32)
        covered[number, *touched[1:, pair]] = 255
        means = Image.fromarray(covered.mean(axis=0).astype(np.uint8))
        soft = means.filter(ImageFilter.GaussianBlur(SHADOW_BLUR / cell))
        matrix = np.array([[1, 0, -corner[0]], [0, 1, -corner[1]], [0, 0, cell]]) @ points
        data = (matrix / matrix[2, 2]).ravel()[:8].tolist()
        method = Image.Transform.PERSPECTIVE, data, Image.Resampling.BILINEAR
        return soft.transform(self.size, *method)

    # Captions

    def add_caption(
        self, picture: Image.Image, caption: Caption, point: np.ndarray, boxes: list[Box]
    ) -> None:
        """Write a text over a picture, below the ones before that it would cover, as the page does
        (captions.js)."""
        place = self.seen(point)
        if place[2] <= NEAR:
            return
        lines = caption.text.split("\n")
        widest = max(map(font(100.0).getlength, lines)) / 100
        letters = min(MAX_LETTERS, RELATIVE_LETTERS * self.width)
        letters = min(letters, RELATIVE_LINE * self.width / widest)
        face = font(max(min(letters, MAX_TITLE * self.focal / self.distance), 1.0))
        ascent, descent = face.getmetrics()
        line = ascent + descent
        width = math.ceil(max(map(face.getlength, lines)) + 2 * CAPTION_PADDING * line)
        height = len(lines) * line
        x, y, _ = self.projected(place)
        left = max(min(round(x - width / 2), self.width - width), 0)
        top = round(y - {"top": 0.0, "bottom": 1.0}.get(caption.anchor, 0.5) * height)
        for box in boxes:
            beside = left > box[1] or box[0] > left + width
            top = box[2] + height if not beside and abs(top - box[2]) < height else top
        boxes.append((left, left + width, top))
        ground = Image.new("RGBA", (width, height), (*self.background, CAPTION_ALPHA))
        picture.alpha_composite(ground, (left, max(top, 0)), (0, min(max(-top, 0), height)))
        for k, words in enumerate(lines):
            at = (left + width / 2, top + k * line + ascent)
            ImageDraw.Draw(picture).text(at, words, self.letters, face, anchor="ms")


@lru_cache(64)
def font(size: float) -> ImageFont.FreeTypeFont:
    """DejaVu Sans as shipped with matplotlib: the same text on every machine."""
    file = distribution("matplotlib").locate_file("matplotlib/mpl-data/fonts/ttf/DejaVuSans.ttf")
    return ImageFont.truetype(str(file), size, layout_engine=ImageFont.Layout.BASIC)


def shades(
    eye: np.ndarray, points: np.ndarray, normals: np.ndarray, albedo: np.ndarray, scene: Geometry
) -> np.ndarray:
    """Colours (..., 3) in sRGB of points on surfaces with unit normals and albedo (..., 3), by
    Lambert's reflection and that of a surface as rough as can be, as in three.js."""
    towards = eye - points
    towards = towards / np.linalg.norm(towards, axis=-1, keepdims=True)
    facing = np.abs((normals * towards).sum(axis=-1, keepdims=True))
    light = albedo / math.pi * scene.ambient
    for direction, colour in scene.lights:
        incident = np.maximum(normals @ direction, 0.0)[..., None]
        half = towards + direction
        half = half / np.maximum(np.linalg.norm(half, axis=-1, keepdims=True), SMALL)
        grazing = 1 - (half @ direction)[..., None].clip(0, 1)
        fresnel = SPECULAR + (1 - SPECULAR) * grazing**5
        specular = fresnel / (2 * np.maximum(incident + facing, SMALL))
        light = light + incident * colour / math.pi * (albedo + specular)
    return toned(light)


def toned(light: np.ndarray) -> np.ndarray:
    """Linear light (..., 3) as three.js shows it: the ACES tone curve, then sRGB."""
    v = np.asarray(light) * EXPOSURE @ TO_ACES.T
    curve = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081)
    shown = (curve @ FROM_ACES.T).clip(0, 1)
    return np.where(shown <= 0.0031308, 12.92 * shown, 1.055 * shown ** (1 / 2.4) - 0.055)
