"""In how many pieces a beam is drawn, and where it is cut: what the picture needs, and no more."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from beamviz.drawing import colours
from beamviz.drawing.modes import Shapes

COUNTS = (16, 32, 64, 128, 256)
DEVIATION = 0.2  # [pixels] a piece may pass the curve at, in the middle of the picture
STEP = 1 / 40  # of the colour map, the most that neighbouring pieces may differ
LONGEST = 1 / 4  # of the beam
LEAVE = 0.8  # a smaller count is taken where so much of it is enough: none flickers
SCALE = 1000.0  # [pixels] of a length of the beam, where nobody says


@dataclass(frozen=True)
class Seen:
    """What a picture shows of a beam: fields (k, n, 2) by which it swings, each at its farthest;
    scale: pixels that a length of the beam takes; colouring and largest: the value at the end of
    its colour map (infinite: all in one colour)."""

    fields: np.ndarray
    scale: float = SCALE
    colouring: str = "displacement"
    largest: float = np.inf

    @classmethod
    def of(
        cls, shapes: Shapes, amplitudes: np.ndarray, colouring: str, scale: float = SCALE
    ) -> Self:
        """The modes of `shapes`, for amplitudes (m,)."""
        sizes = np.minimum(amplitudes, shapes.limits)
        shown = sizes > 0
        largest = colours.colour_range(shapes, colouring, amplitudes)
        return cls(sizes[shown, None, None] * shapes.modes[shown], scale, colouring, largest)


def cut(shapes: Shapes, seen: Seen, before: int = 0) -> Shapes:
    """`shapes` at the ends of the pieces it is to be drawn in, one of them at the mass; `before`
    it was drawn in so many."""
    need = np.append(0.0, np.cumsum(density(shapes, seen) * np.diff(shapes.x)))
    mass = float(need[shapes.mass])
    parts = np.array([mass, need[-1] - mass])
    count = counted(int(np.ceil(parts).sum()), before)
    inner = round(count * mass / need[-1])
    least = np.ceil(parts) if np.ceil(parts).sum() <= count else parts > 0
    inner = int(np.clip(inner, least[0], count - least[1]))
    ends = np.append(
        np.linspace(0.0, mass, inner + 1)[:-1], np.linspace(mass, need[-1], count - inner + 1)
    )
    return resampled(shapes, np.interp(ends, need, shapes.x))


def counted(need: int, before: int) -> int:
    """The smallest count that is enough; the one `before` stays while it nearly is."""
    enough = next((count for count in COUNTS if count >= need), COUNTS[-1])
    return before if before > enough >= before / 2 and need > LEAVE * enough else enough


def density(shapes: Shapes, seen: Seen) -> np.ndarray:
    """Pieces (n - 1,) per length of the beam that a picture needs along it.

    A chord of length h passes a curve of curvature kappa at kappa h^2 / 8.
    """
    slope, bend = derivatives(shapes, np.concatenate([shapes.centreline[None], seen.fields]))
    chords = np.sqrt(curvature(slope, bend) * seen.scale / (8 * DEVIATION))
    return np.maximum(np.maximum(chords, tint(slope, bend, seen) / STEP), 1 / LONGEST)


def curvature(slope: np.ndarray, bend: np.ndarray) -> np.ndarray:
    """A bound (n - 1,) of the curvature of the swinging beam, from derivatives (1 + k, n - 1, 2) of
    its centreline and its fields: the second one along x, across the beam, and as much of that
    along it as its slope turns across."""
    along, steep = np.abs(bend[..., 0]).sum(axis=0), np.abs(slope[1:, :, 1]).sum(axis=0)
    stretch = np.maximum(np.abs(slope[0, :, 0]) - np.abs(slope[1:, :, 0]).sum(axis=0), 0.1)
    return np.abs(bend[..., 1]).sum(axis=0) + along * np.minimum(steep / stretch, 1.0)


def tint(slope: np.ndarray, bend: np.ndarray, seen: Seen) -> np.ndarray:
    """A bound (n - 1,) of how fast the place in the colour map changes along the beam, from the
    same."""
    if seen.colouring == "axial strain":
        return np.abs(bend[..., 0]).sum(axis=0) / (2 * seen.largest)
    along, across = np.abs(slope[1:, :, 0]), np.abs(slope[1:, :, 1])
    return np.hypot(along, across).sum(axis=0) / seen.largest


def derivatives(shapes: Shapes, fields: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First and second derivatives (k, n - 1, 2) of fields (k, n, 2) along x, between stations;
    across the mass, where the stretch may jump, there is no second one."""
    step = np.diff(shapes.x)
    slope = np.diff(fields, axis=1) / step[:, None]
    bend = np.zeros_like(fields)
    bend[:, 1:-1] = np.diff(slope, axis=1) / (step[1:] + step[:-1])[:, None] * 2
    bend[:, shapes.mass] = 0.0
    return slope, np.maximum(np.abs(bend[:, 1:]), np.abs(bend[:, :-1]))


def resampled(shapes: Shapes, x: np.ndarray) -> Shapes:
    """`shapes` at other stations x (j,), the strain of each piece being its mean there."""
    strain = np.append(0.0, np.cumsum(shapes.strain * np.diff(shapes.x)))
    return replace(
        shapes,
        x=x,
        centreline=between(shapes.x, shapes.centreline, x),
        strain=np.diff(np.interp(x, shapes.x, strain)) / np.diff(x),
        modes=between(shapes.x, shapes.modes, x),
    )


def between(known: np.ndarray, values: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Values (..., n, 2) at stations `known` (n,), at x (j,): (..., j, 2)."""
    k = np.searchsorted(known, x, side="right").clip(1, len(known) - 1) - 1
    share = ((x - known[k]) / (known[k + 1] - known[k]))[:, None]
    return (1 - share) * values[..., k, :] + share * values[..., k + 1, :]
