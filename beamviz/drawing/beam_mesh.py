"""The surface of the beam, and its subdivision into as many pieces as the picture needs."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from beamviz.drawing.forces import ForceSource, ModeForces
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.sizes import section_size, sections, turns
from beamviz.scene import ViewOptions

# Of the planes of motion; in both planes that of a section which is not turned.
NORMALS = {
    "chordwise": np.array([0.0, 0.0, 1.0]),
    "flapwise": np.array([0.0, -1.0, 0.0]),
    "both": np.array([0.0, 0.0, 1.0]),
}
MAX_WEDGE = math.tan(0.5)  # of a bend by 1 rad
ROUNDED_TURN = 1e-300  # in place of the sine 0 of an angle: its axis is 0 then
# Thickness in the plane of motion and breadth along its normal: of all pieces (2,), or at the start
# and the end of each (n - 1, 2, 2).
Section = tuple[float, float] | NDArray


def to_hub_frame(shapes: SampledModes, centreline: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) in the hub's frame of a line (n, c) measured from the clamp, and the normal
    (3,) of the plane of motion, or that of the breadth of each section (n, 3) of an undeformed beam
    where they are turned. Across the beam is y in the plane of rotation and z out of it."""
    points = np.zeros((len(centreline), 3))
    points[:, 0] = centreline[:, 0]
    if shapes.plane == "both":
        points[:, 1:] = centreline[:, 1:]
    else:
        points[:, 1 if shapes.plane == "chordwise" else 2] = centreline[:, 1]
    points[:, 0] += shapes.beam.delta
    return points, normals(shapes, shapes.x)


def normals(shapes: SampledModes, x: np.ndarray) -> np.ndarray:
    """The normal (3,) of the plane of motion, or of the breadth of each section (n, 3) at x (n,) of
    an undeformed beam where they are turned."""
    turn = turns(shapes.beam, x) if shapes.plane == "both" else np.zeros(0)
    if not turn.any():
        return NORMALS[shapes.plane]
    return np.stack([0 * turn, -np.sin(turn), np.cos(turn)], 1)


def extents(section: Section, normal: np.ndarray) -> np.ndarray:
    """Sizes (..., 3) of sections (..., 2) of a straight beam; 0 along the beam."""
    across, sizes = np.array([0.0, normal[2], normal[1]]), np.asarray(section)
    return sizes[..., :1] * np.abs(across) + sizes[..., 1:] * np.abs(normal)


def rings(count: int, section: Section) -> tuple[NDArray, NDArray]:
    """The sections (r, 2) that a surface through `count` points is made of, and the point of each
    (r,): one at each point, two where the section jumps."""
    sizes = np.broadcast_to(section, (count - 1, 2, 2)).reshape(-1, 2)
    point = np.repeat(np.arange(count), 2)[1:-1]
    differ = (np.diff(point) > 0) | (np.diff(sizes, axis=0) != 0).any(axis=1)
    kept = np.append(True, differ)
    return point[kept], sizes[kept]


def swept(
    points: np.ndarray, normal: np.ndarray, section: Section
) -> tuple[np.ndarray, np.ndarray]:
    """The closed surface of a rectangular section swept along `points` (n, 3).

    normal: of the breadth of the undeformed beam along x, (3,) or of each section (n, 3).
    Returns vertices (4 r, 3) of its r `rings` and triangles (8 r - 4, 3), facing outwards.
    """
    tangents = np.gradient(points, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    point, sizes = rings(len(points), section)
    points, tangents = points[point], tangents[point]
    up = bent(normal if normal.ndim == 1 else normal[point], tangents)
    side = np.cross(up, tangents) * sizes[:, :1] / 2
    up = up * sizes[:, 1:] / 2
    corners = np.stack(
        [points + side + up, points - side + up, points - side - up, points + side - up], 1
    )
    ring = np.arange(4)
    first = 4 * np.arange(len(points) - 1)[:, None] + ring  # (n - 1, 4)
    second = 4 * np.arange(len(points) - 1)[:, None] + np.roll(ring, -1)
    walls = np.stack([first, second, second + 4, first, second + 4, first + 4], -1)
    last = 4 * (len(points) - 1)
    caps = [(0, 2, 1), (0, 3, 2), (last, last + 1, last + 2), (last, last + 2, last + 3)]
    return corners.reshape(-1, 3), np.concatenate([walls.reshape(-1, 3), caps])


def outline(points: np.ndarray, normal: np.ndarray, section: Section) -> NDArray:
    """The edges (e, 2, 3) of the surface of `swept`: along the beam, and around its ends and the
    steps where the section jumps."""
    corners = swept(points, normal, section)[0].reshape(-1, 4, 3)
    point, _ = rings(len(points), section)
    step = np.append(point[1:] == point[:-1], False)
    around = corners[step | np.roll(step, 1) | np.isin(point, [0, len(points) - 1])]
    along = np.stack([corners[:-1], corners[1:]], 2)
    across = np.stack([around, np.roll(around, -1, axis=1)], 2)
    return np.concatenate([along.reshape(-1, 2, 3), across.reshape(-1, 2, 3)])


def segments(
    points: np.ndarray, normal: np.ndarray, section: Section
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The surface of `swept` as n - 1 transformed unit boxes, which may differ in colour; each has
    the mean of the sections at its ends, and the mean of their angles.

    Returns centres (n - 1, 3), orientations wxyz (n - 1, 4) and sizes (n - 1, 3). Each box is
    extended to close the wedge to its neighbours on the outside of a bend.
    """
    section = np.asarray(section)
    section = section.mean(axis=1) if section.ndim == 3 else section[None]
    steps = points[1:] - points[:-1]
    lengths = np.linalg.norm(steps, axis=1)
    tangents = steps / lengths[:, None]
    turn = piece_turns(normal, len(tangents))
    plane_normal = normal if normal.ndim == 1 else NORMALS["both"]
    sizes = np.empty((len(tangents), 3))
    sizes[:] = extents(section, plane_normal)
    # The sides of a box along its y and its z, which a bend about one axis moves the ends of.
    upright = bent(np.stack([0 * turn, -np.sin(turn), np.cos(turn)], 1), tangents)  # z of the box
    level = np.cross(upright, tangents)
    wedge = np.zeros(points.shape)  # about its axis
    wedge[1:-1] = wedges(tangents)
    sides = [
        np.abs((wedge[:-1] * side).sum(1)) + np.abs((wedge[1:] * side).sum(1))
        for side in (upright, level)
    ]
    sizes[:, 0] = lengths + (sizes[:, 1] * sides[0] + sizes[:, 2] * sides[1]) / 2
    return (points[:-1] + points[1:]) / 2, orientations(tangents, turn, plane_normal), sizes


def piece_turns(normal: np.ndarray, count: int) -> np.ndarray:
    """The angles (n - 1,) [rad] by which `count` pieces are turned about the axis of the beam, the
    mean of those of the normals (n, 3) at their ends; 0 of a single normal (3,)."""
    if normal.ndim == 1:
        return np.zeros(count)
    angles = np.unwrap(np.arctan2(-normal[:, 1], normal[:, 2]))
    return (angles[1:] + angles[:-1]) / 2


def bent(normal: np.ndarray, tangents: np.ndarray) -> np.ndarray:
    """Normals (n, 3) of a straight beam along x, rotated with it to the direction of `tangents`
    (n, 3) without torsion: about the axis w = (1, 0, 0) x tangent, by Rodrigues' formula."""
    axis = np.stack([0 * tangents[:, 0], -tangents[:, 2], tangents[:, 1]], 1)
    once = np.cross(axis, normal)
    return normal + once + np.cross(axis, once) / np.maximum(1 + tangents[:, :1], ROUNDED_TURN)


def wedges(tangents: np.ndarray) -> np.ndarray:
    """The tangents of half the angles between pieces, bounded where the beam is folded, along the
    axes of these angles (n - 2, 3)."""
    axis = np.cross(tangents[:-1], tangents[1:])
    sine = np.linalg.norm(axis, axis=1)
    half = np.arctan2(sine, (tangents[:-1] * tangents[1:]).sum(axis=1)) / 2
    size = np.minimum(np.abs(np.tan(half)), MAX_WEDGE)
    return axis * (size / np.maximum(sine, ROUNDED_TURN))[:, None]


def orientations(tangents: np.ndarray, turn: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """The quaternions wxyz (n, 4) of a turn (n,) about x and then a rotation to `tangents` without
    torsion, of a piece that is folded back about `normal`."""
    _, y, z = tangents.T
    sine = np.hypot(y, z)
    axis = np.where(sine > 0, np.stack([-z, y]) / np.maximum(sine, ROUNDED_TURN), normal[1:, None])
    half = np.arctan2(sine, tangents[:, 0]) / 2
    w, (y, z) = np.cos(half), np.sin(half) * axis
    c, s = np.cos(turn / 2), np.sin(turn / 2)
    return np.stack([w * c, w * s, y * c + z * s, z * c - y * s], 1)


MAX_PIECES = 256
DEVIATION = 0.1  # [pixels] of a piece from a curve of the same curvature, in mid-picture
STEP = 1 / 60  # largest difference of neighbouring pieces on the colour map
STEP_OF_SECTION = 1.0  # [pixels] largest difference of their thickness or breadth
# Least ends of the colour map. Differences of shapes have a rounding error of 1e-11 in the strain,
# by which pieces move less than 1e-6 beam lengths with this end, and up to 2e-3 with 1e-9.
LEAST_STRAIN = 1e-6
LEAST_DISPLACEMENT = 1e-9  # [beam lengths]
LONGEST = 1 / 4  # [beam lengths] longest piece
ROUNDING = 1e-6  # of a number of pieces: it is whole where the colours run through all their map
DEFAULT_SCALE = 1000.0  # [pixels per beam length]


@dataclass(frozen=True)
class DrawnBeam:
    """The data that the drawing of a beam depends on."""

    shapes: SampledModes
    view: ViewOptions
    scale: float = DEFAULT_SCALE  # [pixels per beam length]
    sizes: np.ndarray | None = None  # (m,) amplitudes of its modes, None for those of `view`
    warning: str = ""  # a text above the beam, which is grey then
    note: str = ""  # a text above a beam that vibrates
    title: str = ""  # a text beside the clamp
    # (m,) of the phases of its modes, in proportion; None for their frequencies.
    rates: np.ndarray | None = None
    forces_of_motion: ForceSource | None = None  # of one in time

    @cached_property
    def forces(self) -> ForceSource | None:
        """The forces to draw on it; None where the view has none, and where they are not known."""
        if not self.view.forces or self.in_rows:
            return None
        if self.forces_of_motion or self.shapes.solution is None:
            return self.forces_of_motion
        return ModeForces(self.shapes, self.amplitudes)

    @cached_property
    def amplitudes(self) -> np.ndarray:
        """Amplitudes (m,) of the modes [beam lengths], at most their limits."""
        shares = [*self.view.shares, *[0.0] * len(self.shapes.modes)][: len(self.shapes.modes)]
        sizes = self.view.amplitude * np.array(shares) if self.sizes is None else self.sizes
        return np.minimum(sizes, self.shapes.limits)

    @cached_property
    def largest(self) -> float:
        """The end of the colour map, not 0: the largest displacement or |axial strain| over time,
        as all modes are at their largest together at some time."""
        if self.view.colouring == "axial strain":
            largest = (np.abs(self.shapes.strain) + self.amplitudes @ self.shapes.strains).max()
            return max(float(largest), LEAST_STRAIN)
        if (largest := self.shapes.largest) is None:
            components = np.tensordot(self.amplitudes, np.abs(self.shapes.modes), 1)  # (n, c)
            largest = float(np.linalg.norm(components, axis=1).max(initial=0.0))
        return max(largest, LEAST_DISPLACEMENT)

    @property
    def shown(self) -> list[int]:
        """The modes (0-based) that it moves in."""
        return np.flatnonzero(self.amplitudes).tolist()

    @property
    def in_rows(self) -> bool:
        """Whether each mode is drawn in a row of its own: not for an unstable beam."""
        return self.view.all_modes and len(self.shapes.modes) > 0 and not self.warning


def subdivide(
    drawn: DrawnBeam, *, one_colour: bool = False, most: int = MAX_PIECES
) -> SampledModes:
    """The shapes sampled at the ends of the pieces that the beam is drawn in, of which one is at
    the mass, at each body and where the section jumps, with the mean strain of each piece.
    one_colour: the pieces do not differ in colour; most: number of pieces."""
    shapes, x = drawn.shapes, drawn.shapes.x
    pieces = required_density(drawn, one_colour=one_colour) * np.diff(x)
    need = np.append(0.0, np.cumsum(pieces))  # from the clamp
    fixed = need[[0, *shapes.breaks, -1]]
    scale = min(1.0, (most - len(shapes.breaks)) / need[-1])
    parts = [
        np.linspace(
            start,
            stop,
            max(math.ceil(scale * (stop - start) - ROUNDING), int(stop > start)),
            endpoint=False,
        )
        for start, stop in pairwise(fixed)
    ]
    ends = np.concatenate([*parts, need[-1:]])
    return resampled(shapes, np.interp(ends, need, x))


def resampled(shapes: SampledModes, x: np.ndarray) -> SampledModes:
    """`shapes` at stations x (j,), with the mean strain between them."""
    known = shapes.x
    strain = np.append(0.0, np.cumsum(shapes.strain * np.diff(known)))  # integral from the clamp
    fields = np.concatenate([shapes.centreline[None], shapes.modes])
    fields = make_interp_spline(known, fields, k=1, axis=1)(x)
    return replace(
        shapes,
        x=x,
        centreline=fields[0].real,
        strain=np.diff(np.interp(x, known, strain)) / np.diff(x),
        modes=fields[1:],
    )


def required_density(drawn: DrawnBeam, *, one_colour: bool) -> np.ndarray:
    """Required pieces per beam length (n - 1,) between stations: by the curvature of the moving
    beam (a chord of length h deviates from a curve of curvature kappa by kappa h^2 / 8), by the
    change of colour along x, unless it has one colour, both as bounds over time, and by that of the
    section."""
    shapes, shown = drawn.shapes, drawn.shown
    moving = drawn.amplitudes[shown, None, None] * shapes.modes[shown]
    fields = np.concatenate([shapes.centreline[None], moving])
    slope, bend = derivatives(shapes, fields)
    along, across = np.abs(slope[1:, :, 0]), np.linalg.norm(slope[1:, :, 1:], axis=2)
    axial = bend[..., 0].sum(axis=0)
    stretch = np.maximum(np.abs(slope[0, :, 0]) - along.sum(axis=0), 0.1)
    steep = np.minimum(across.sum(axis=0) / stretch, 1.0)
    curvature = np.linalg.norm(bend[..., 1:], axis=2).sum(axis=0) + axial * steep
    if drawn.view.colouring == "axial strain":
        colour = axial / (2 * drawn.largest)
    else:
        colour = np.hypot(along, across).sum(axis=0) / drawn.largest
    density = np.maximum(np.sqrt(curvature * drawn.scale / (8 * DEVIATION)), 1 / LONGEST)
    if shapes.beam.blade:
        sizes = sections(shapes.beam, shapes.plane, shapes.x, drawn.view.thicken)
        change = np.abs(sizes[:, 1] - sizes[:, 0]).max(axis=1) / np.diff(shapes.x)
        density = np.maximum(density, change * drawn.scale / STEP_OF_SECTION)
    if shapes.plane == "both":
        radius = np.linalg.norm(section_size(shapes.beam, drawn.view.thicken)) / 2
        rate = np.abs(np.diff(turns(shapes.beam, shapes.x))) / np.diff(shapes.x)
        density = np.maximum(density, radius * rate * drawn.scale / STEP_OF_SECTION)
    return density if one_colour else np.maximum(density, colour / STEP)


def derivatives(shapes: SampledModes, fields: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First derivative (k, n - 1, c) of fields (k, n, c) along x, between stations, and the size of
    the second one, taken as 0 where the stretch may jump."""
    step = (shapes.x[1:] - shapes.x[:-1])[:, None]
    slope = (fields[:, 1:] - fields[:, :-1]) / step
    bend = np.zeros(fields.shape)
    bend[:, 1:-1] = np.abs(slope[:, 1:] - slope[:, :-1]) / (step[1:] + step[:-1]) * 2
    bend[:, shapes.breaks] = 0.0
    return slope, np.maximum(bend[:, 1:], bend[:, :-1])
