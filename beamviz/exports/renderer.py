"""Pictures of a solved scene: what the page draws, rendered in numpy with the page's light.

A page is drawn by three.js; what it does to light is repeated here (Lambert's and a rough
specular reflection, the ACES tone curve), without a browser, a display or a graphics library.
"""

import math
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from PIL import Image, ImageChops, ImageDraw, ImageFont

from beamviz.drawing import camera, colours
from beamviz.drawing.objects import Caption
from beamviz.exports.floor import covered_by_disc, shadow
from beamviz.exports.geometry import Geometry, Triangles, geometry, linear
from beamviz.exports.rasteriser import (
    CENTRE,
    NEAR,
    Cover,
    at_pixels,
    clipped,
    cover,
    sample_offsets,
    samples,
)
from beamviz.exports.solved_scene import DrawnScene, Moment, SolvedScene
from beamviz.server.viser_private import VisibleNode, offline_scene

Box = tuple[int, int, int]  # of a text: left, right, top [pixels]
FINE, FAST = 8, 5  # samples of a pixel at an edge: in a picture, a film
SPECULAR = 0.04  # reflectance of a dielectric seen from the front
FULL_HEIGHT = 720  # [pixels] of a picture: lines are as much thinner as it is smaller
CONTRAST = np.uint32(0xF8F8F8F8)  # bits of four bytes: of a difference that can be seen
SMALL = 1e-6  # in place of a divisor that may be 0
UP = np.array([0.0, 0.0, 1.0])
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
        self.solved, self.drawn = (
            solved,
            DrawnScene(self.scene, solved, solved.scale(width, height)),
        )

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
        bodies = scene.triangles
        seen = self.seen(bodies.corners)
        across = np.cross(seen[:, 1] - seen[:, 0], seen[:, 2] - seen[:, 0])
        facing = (across * seen[:, 0]).sum(axis=1) < 0
        places, colours = self.shaded(bodies.part(facing | bodies.double), scene)
        thin = min(1.0, self.height / FULL_HEIGHT)
        strips = [self.strips(ends, colour, thin * width) for ends, colour, width in scene.lines]
        solids = len(places)
        places = np.concatenate([places, *(strip for strip, _ in strips)])
        colours = np.concatenate([colours, *(colour for _, colour in strips)])
        covered = cover(places[..., :2], self.width, self.height)
        shown = np.zeros((self.height, self.width, 4), np.uint8)
        draw(shown, places, colours, covered, CENTRE)
        edge = edges(shown)
        lines = covered.part(covered.triangle >= solids)
        edge[lines.row, lines.column] = True  # they may be between the centres of pixels
        covered = covered.part(edge[covered.row, covered.column])
        draw(shown, places, colours, covered, sample_offsets(self.samples))
        picture.alpha_composite(Image.fromarray(shown))

    def shaded(self, bodies: Triangles, scene: Geometry) -> tuple[np.ndarray, np.ndarray]:
        """Triangles in the picture (t, 3, 3) and the colours (t, 3, 4) at their corners, in sRGB
        with opacity."""
        normals, albedo = bodies.normals, bodies.albedo[:, None]
        behind = ((self.eye - bodies.corners) * normals).sum(axis=-1, keepdims=True) < 0
        normals = np.where(bodies.double[:, None, None] & behind, -normals, normals)
        colours = shades(self.eye, bodies.corners, normals, albedo, scene)
        opacity = np.broadcast_to(bodies.opacity[:, None, None], (len(colours), 3, 1))
        colours = np.concatenate([colours, opacity], -1)
        seen, colours, _ = clipped(self.seen(bodies.corners), colours)
        return self.projected(seen), colours

    def strips(
        self, ends: np.ndarray, colour: np.ndarray, thickness: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Lines (n, 2, 3) as triangles (2 n, 3, 3) in the picture, `thickness` pixels wide, and
        their colours."""
        seen = self.seen(ends)
        seen = seen[seen[..., 2].max(axis=1) > NEAR]
        first, last = seen[:, :1], seen[:, 1:]
        share = (NEAR - seen[..., 2:]) / np.where(last == first, np.inf, last - first)[..., 2:]
        moved = first + share * (last - first)
        seen = self.projected(np.where(seen[..., 2:] > NEAR, seen, moved))
        along = seen[:, 1, :2] - seen[:, 0, :2]
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
        aside = np.stack([-along[:, 1], along[:, 0], 0 * along[:, 0]], 1) * thickness / 2
        a, b = seen[:, 0], seen[:, 1]
        quads = np.stack([a - aside, b - aside, b + aside, a + aside], 1)
        places = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        tone = np.append(toned(colour), 1.0)
        return places, np.broadcast_to(tone, (len(places), 3, 4))

    def add_floor(self, picture: Image.Image, floor: VisibleNode, scene: Geometry) -> None:
        """Put the top of a round floor over a picture, if it is seen, with the shadow on it."""
        centre = floor.position + floor.props.height / 2 * UP
        eye = self.eye - centre
        if eye[2] <= 0:
            return
        # A place (x, y) shows the point points @ (x, y, 1), homogeneous, from the centre.
        pixels = np.array([[1, 0, -self.width / 2], [0, 1, -self.height / 2], [0, 0, self.focal]])
        rays = self.axes @ pixels
        points = np.stack([*(eye[k] * rays[2] - eye[2] * rays[k] for k in (0, 1)), rays[2]])
        tone = shades(self.eye, centre, UP, linear(floor.props.color), scene)
        disc = Image.new("RGB", self.size, tuple(np.rint(255 * tone).astype(int).tolist()))
        disc.paste(0, mask=shadow(scene, centre, points, self.size, floor.props.receive_shadow))
        disc.putalpha(covered_by_disc(points, floor.props.radius, self.size))
        picture.alpha_composite(disc)

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
        hidden = min(max(-top, 0), height)
        picture.alpha_composite(ground, (left, max(top, 0)), (0, hidden))
        text = Image.new("L", (width, height))
        for k, words in enumerate(lines):
            at = (width / 2, k * line + ascent)
            ImageDraw.Draw(text).text(at, words, 255, face, anchor="ms")
        picture.paste(self.letters, (left, top), text)


@lru_cache(64)
def font(size: float) -> ImageFont.FreeTypeFont:
    """DejaVu Sans, which matplotlib brings along: the same letters on every machine."""
    found = find_spec("matplotlib")
    assert found
    assert found.origin
    file = Path(found.origin).parent / "mpl-data" / "fonts" / "ttf" / "DejaVuSans.ttf"
    return ImageFont.truetype(file, size, layout_engine=ImageFont.Layout.BASIC)


def draw(
    shown: np.ndarray, places: np.ndarray, colours: np.ndarray, covered: Cover, offsets: np.ndarray
) -> None:
    """Draw the pixels that triangles (t, 3, 3) cover, with colours (t, 3, 4) at their corners, into
    a picture (h, w, 4) in bytes; offsets: (s, 2) of the samples of each pixel."""
    height, width, _ = shown.shape
    pixel = covered.row * width + covered.column
    used = np.zeros(height * width, bool)
    used[pixel] = True
    where = np.flatnonzero(used)
    slots = np.zeros(height * width, np.int32)  # places of the pixels used in the arrays below
    slots[where] = np.arange(len(where))
    pair, number, depth = samples(places, covered, offsets)
    triangle = covered.triangle[pair]
    slot = number * len(where) + slots[pixel][pair]
    solid = (colours[:, 0, 3] == 1)[triangle]
    colour, dx, dy = at_pixels(places[..., :2], colours, covered)
    colour += (dx + dy) / 2
    opacity, colour[3] = colour[3].copy(), 1.0
    nearest = np.zeros(len(offsets) * len(where), np.float32)
    result = np.zeros((4, len(nearest)), np.float32)  # colours times opacity
    for part in (solid, ~solid):  # translucent ones over the others
        found = np.flatnonzero(part & (depth >= nearest[slot]))
        np.maximum.at(nearest, slot[found], depth[found])
        found = found[nearest[slot[found]] == depth[found]]
        of, at = pair[found], slot[found]
        alpha = opacity[of]
        for channel, value in zip(result, colour, strict=True):
            channel[at] = alpha * value[of] + (1 - alpha) * channel[at]
    mean = result.reshape(4, len(offsets), len(where)).mean(axis=1)
    mean[:3] /= np.maximum(mean[3], SMALL)
    shown.reshape(-1, 4)[where] = np.rint(255 * mean.clip(0, 1)).T


def edges(shown: np.ndarray) -> np.ndarray:
    """Where a picture (h, w, 4) in bytes differs visibly from a neighbouring pixel: (h, w)."""
    picture, found = Image.fromarray(shown), np.zeros(shown.shape[:2], bool)
    for axis, step in enumerate(((0, 1), (1, 0))):
        change = ImageChops.difference(picture, ImageChops.offset(picture, *step))
        differ = np.asarray(change).view(np.uint32)[..., 0] & CONTRAST > 0
        found |= differ | np.roll(differ, -1, axis)
    return found


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
