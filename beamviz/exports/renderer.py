"""Pictures of a solved scene: what the page draws, rendered in numpy with the page's light.

A page is drawn by three.js; what it does to light is repeated here (Lambert's and a rough
specular reflection, the ACES tone curve), without a browser, a display or a graphics library.
"""

import math
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from beamviz.drawing import camera
from beamviz.drawing.objects import Caption
from beamviz.exports.floor import covered_by_disc, shadow
from beamviz.exports.geometry import Geometry, Triangles, geometry, linear
from beamviz.exports.rasteriser import NEAR, clipped, planes, rasterised
from beamviz.exports.solved_scene import DrawnScene, Moment, SolvedScene
from beamviz.server.viser_private import VisibleNode, offline_scene

LIGHT, DARK = (244, 246, 248), (15, 18, 20)  # backgrounds of the page, and its letters
Box = tuple[int, int, int]  # of a text: left, right, top [pixels]
INK = {False: (27, 32, 38), True: (233, 236, 239)}
FINE, FAST, TRANSLUCENT = 8, 5, 3  # samples of a pixel: in a picture, a film, a pale body
SPECULAR = 0.04  # reflectance of a dielectric seen from the front
FULL_HEIGHT = 720  # [pixels] of a picture: lines are as much thinner as it is smaller
SHIFTS, PART = 2 ** np.array([0, 16, 32, 48]), 4095  # of sums and colours in one float
SMALL = 1e-6  # in place of a divisor that may be 0
UP = np.array([0.0, 0.0, 1.0])
# Letters of a caption: [pixels], and of the width of the picture; the part of the width
# that a line may take; height [lengths of the beam] at most, for a title between two beams.
MAX_LETTERS, RELATIVE_LETTERS, RELATIVE_LINE, MAX_TITLE = 18, 0.026, 0.8, 0.065
CAPTION_OPACITY, CAPTION_PADDING = 0.78, 0.3  # of its ground; of a line's height, on each side
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
        view = solved.camera(width / height)
        self.eye = np.array(view.position)
        self.axes = camera.axes(np.subtract(view.position, view.look_at))
        self.distance = math.dist(view.position, view.look_at)
        self.focal = height / (2 * math.tan(camera.FIELD_OF_VIEW / 2))  # [pixels]
        self.background = np.array(DARK if solved.scene.view.dark else LIGHT) / 255
        self.scene = offline_scene()
        self.solved, self.drawn = (
            solved,
            DrawnScene(self.scene, solved, solved.scale(width, height)),
        )

    def draw(self, moment: Moment) -> Geometry:
        """The scene at a moment."""
        self.drawn.move(moment)
        return geometry(self.scene)

    def render(self, scene: Geometry, *, transparent: bool = False) -> np.ndarray:
        """The picture of a scene: (height, width, 3), or with transparency (height, width, 4),
        bytes."""
        # Colours times alpha, and alpha where the background is transparent.
        clear = np.zeros(4) if transparent else self.background
        picture = np.empty((self.height, self.width, len(clear)), np.float32)
        picture[:] = clear
        if scene.floor is not None:  # everything is above it
            self.add_floor(picture, scene.floor, scene)
        self.add_objects(picture, scene)
        boxes: list[Box] = []
        for caption in self.drawn.captions:
            self.add_caption(picture, caption, scene.points[caption.point.name], boxes)
        if transparent:
            picture[..., :3] /= np.maximum(picture[..., 3:], SMALL)
        picture *= 255
        picture += 0.5
        return picture.astype(np.uint8)

    def seen(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) in the axes of the camera: right, down, forward."""
        return (points - self.eye) @ self.axes

    def projected(self, seen: np.ndarray) -> np.ndarray:
        """Points (..., 3) in the axes of the camera as x, y [pixels] and the inverse distance."""
        inverse = 1 / seen[..., 2:]
        middle = [self.width / 2, self.height / 2]
        return np.concatenate([self.focal * seen[..., :2] * inverse + middle, inverse], -1)

    # Objects

    def add_objects(self, picture: np.ndarray, scene: Geometry) -> None:
        """Put bodies and lines over a picture, and then translucent bodies over those."""
        bodies = scene.triangles
        seen = self.seen(bodies.corners)
        across = np.cross(seen[:, 1] - seen[:, 0], seen[:, 2] - seen[:, 0])
        facing = (across * seen[:, 0]).sum(axis=1) < 0
        facing |= bodies.double
        places, colours, smooth = self.shaded(bodies.part(facing & (bodies.opacity == 1)), scene)
        thin = min(1.0, self.height / FULL_HEIGHT)
        strips = [self.strips(ends, colour, thin * width) for ends, colour, width in scene.lines]
        places = np.concatenate([places, *(strip for strip, _ in strips)])
        colours = np.concatenate([colours, *(colour for _, colour in strips)])
        smooth = np.append(smooth, np.zeros(len(places) - len(smooth), bool))
        nearest = np.zeros((self.height, self.samples, self.width), np.uint64)
        add_layer(picture, places, colours, smooth, 1.0, nearest)
        for opacity in np.unique(bodies.opacity[facing & (bodies.opacity < 1)]):
            pale = self.shaded(bodies.part(facing & (bodies.opacity == opacity)), scene)
            behind = nearest[:, :: math.ceil(self.samples / TRANSLUCENT)].copy()
            add_layer(picture, *pale, float(opacity), behind)

    def shaded(
        self, bodies: Triangles, scene: Geometry
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Triangles in the picture (t, 3, 3), their colours (t, 3, 3) in sRGB, and whether these
        differ at the corners (t,)."""
        normals, albedo = bodies.normals, bodies.albedo[:, None]
        behind = ((self.eye - bodies.corners) * normals).sum(axis=-1, keepdims=True) < 0
        normals = np.where(bodies.double[:, None, None] & behind, -normals, normals)
        colours = shades(self.eye, bodies.corners, normals, albedo, scene)
        seen, colours, origin = clipped(self.seen(bodies.corners), colours)
        return self.projected(seen), colours, bodies.smooth[origin]

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
        tone = toned(colour)
        return places, np.broadcast_to(tone, (len(places), 3, 3))

    def add_floor(self, picture: np.ndarray, floor: VisibleNode, scene: Geometry) -> None:
        """Put the top of a round floor over a picture, if it is seen, with the shadow on it."""
        centre = floor.position + floor.props.height / 2 * UP
        eye = self.eye - centre
        if eye[2] <= 0:
            return
        tone = shades(self.eye, centre, UP, linear(floor.props.color), scene)
        # A place (x, y) shows the point points @ (x, y, 1), homogeneous, from the centre.
        pixels = np.array([[1, 0, -self.width / 2], [0, 1, -self.height / 2], [0, 0, self.focal]])
        rays = self.axes @ pixels
        points = np.stack([*(eye[k] * rays[2] - eye[2] * rays[k] for k in (0, 1)), rays[2]])
        covered = covered_by_disc(points, floor.props.radius, self.width, self.height)[..., None]
        blend(picture, tone, covered)
        for box, darkness in shadow(scene, centre, points, self.width, self.height):
            picture[box][..., :3] -= floor.props.receive_shadow * darkness * covered[box] * tone

    # Captions

    def add_caption(
        self, picture: np.ndarray, caption: Caption, point: np.ndarray, boxes: list[Box]
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
        text = Image.new("L", (width, height))
        for k, words in enumerate(lines):
            at = (width / 2, k * line + ascent)
            ImageDraw.Draw(text).text(at, words, 255, face, anchor="ms")
        rows = slice(max(top, 0), max(top + height, 0))
        part = picture[rows, left : left + width]
        ink = np.asarray(text, np.float32)[max(-top, 0) :][: len(part), : part.shape[1], None] / 255
        letter = np.array(INK[self.solved.scene.view.dark]) / 255
        blend(part, self.background, CAPTION_OPACITY)
        blend(part, letter, ink)


@lru_cache(64)
def font(size: float) -> ImageFont.FreeTypeFont:
    """DejaVu Sans, which matplotlib brings along: the same letters on every machine."""
    found = find_spec("matplotlib")
    assert found
    assert found.origin
    file = Path(found.origin).parent / "mpl-data" / "fonts" / "ttf" / "DejaVuSans.ttf"
    return ImageFont.truetype(file, size, layout_engine=ImageFont.Layout.BASIC)


def blend(picture: np.ndarray, colour: np.ndarray, share: np.ndarray | float) -> None:
    """Put a colour (3,) over a picture (h, w, 3 or 4), with its share (h, w, 1) of each pixel."""
    picture += share * (np.append(colour, 1.0)[: picture.shape[2]].astype(np.float32) - picture)


def add_layer(
    picture: np.ndarray,
    places: np.ndarray,
    colours: np.ndarray,
    smooth: np.ndarray,
    opacity: float,
    nearest: np.ndarray,
) -> None:
    """Put triangles (t, 3, 3) over a picture, with colours (t, 3, 3) at their corners, in sRGB;
    smooth: whether these differ, (t,); nearest: what is nearest at each sample, changed here."""
    height, count, width = nearest.shape
    lines, line, column = rasterised(places, nearest)
    pixel, owner = (lines.row // count * width)[line] + column, lines.owner[line]
    curved = np.flatnonzero(smooth[owner])
    line, of = line[curved], owner[curved]
    x, y = column[curved] + lines.shift[line], (lines.row[line] + 0.5) / count
    constant, dx, dy = np.moveaxis(planes(places[..., :2], colours), 1, 0)
    weights = packed(colours.mean(axis=1))[owner]
    weights[curved] = packed(constant[of] + dx[of] * x[:, None] + dy[of] * y[:, None])
    sums = np.bincount(pixel, weights, height * width)
    where = np.flatnonzero(sums)
    added = unpacked(sums[where]) * np.float32(opacity / count)
    flat = picture.reshape(height * width, -1)
    flat[where] = flat[where] * (1 - added[:, 3:]) + added[:, : flat.shape[1]]


def packed(colours: np.ndarray) -> np.ndarray:
    """Colours (n, 3) and the number 1 as one number each (n,), of which up to 15 can be added."""
    whole = np.rint(colours.clip(0, 1) * PART).astype(np.int64)
    return (whole @ SHIFTS[:3] + SHIFTS[3]).astype(float)


def unpacked(sums: np.ndarray) -> np.ndarray:
    """The sums (n, 4) of colours and of ones."""
    whole = sums.astype(np.int64)[:, None] // SHIFTS % SHIFTS[1]
    return whole.astype(np.float32) / np.array([PART, PART, PART, 1], np.float32)


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
