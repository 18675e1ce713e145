"""Pictures of the lessons as SVG: the mode of the scene, or the loci of the question."""

from functools import cache

import numpy as np

from beamviz.errors import BeamvizError
from beamviz.frequency_loci import loci
from beamviz.lessons import lesson
from beamviz.lessons.model import Lesson
from beamviz.solver import solve
from beamviz.solver.solution import MIXED

WIDTH, HEIGHT = 160, 90
CLAMP, LENGTH = 28, 112  # [px] position of the clamp, length of the beam
MARGIN = 8  # [px] around loci
AMPLITUDE = 0.17  # of the length
X = np.linspace(0.0, 1.0, 41)
TICKS = slice(0, None, 5)  # points of X with a cross-section
POINTS = 41  # of loci
LOCI = {  # lessons with a chart: start and stop of the axis, first and last mode
    "mode-shift": (0.6, 2.4, 3, 4),
    "crossing": (3.5, 6.0, 3, 4),
    "veering": (4.2, 5.1, 3, 4),
    "resonance": (0.0, 14.0, 1, 3),
    "paradox": (0.0, 3.5, 1, 1),
    "buckling": (0.0, 2.99, 1, 1),
}


@cache
def sketch(name: str) -> str:
    shown = lesson(name)
    try:
        drawn = chart(shown) if name in LOCI else mode(shown)
    except BeamvizError:  # of a scene without equilibrium
        drawn = ""
    return f'<svg class="sketch" viewBox="0 0 {WIDTH} {HEIGHT}" aria-hidden="true">{drawn}</svg>'


def mode(shown: Lesson) -> str:
    """The hub, the equilibrium, and the mode with the largest share."""
    scene = shown.scene
    beam, solution = scene.beam, solve(scene.beam, **scene.solver_options)
    k = int(np.argmax(scene.view.shares))
    shape = solution.shape(k, X).real
    c, s = np.cos(angle := solution.equilibrium.angle(X)), np.sin(angle)
    moved = np.column_stack([c * shape[:, 0] - s * shape[:, 1], s * shape[:, 0] + c * shape[:, 1]])
    rest = solution.equilibrium.position(X)
    points = rest + AMPLITUDE * moved / np.linalg.norm(moved, axis=1).max()
    family = solution.families[k]
    parts = [hub(beam.delta), line(rest, "rest"), line(points, family)]
    if family != "bending":
        normal = 0.05 * np.column_stack([-s, c])
        ticks = np.stack([points - normal, points + normal], axis=1)[TICKS]
        parts += [line(tick, family) for tick in ticks]
    if beam.alpha > 0:
        x, y = place(points[int(np.argmin(abs(X - beam.beta)))])
        parts.append(f'<circle class="mass" cx="{x:.1f}" cy="{y:.1f}" r="5"/>')
    return "".join(parts)


def hub(delta: float) -> str:
    """The axis with the hub around it, or the rim of a beam that points inward."""
    axis, middle = CLAMP - LENGTH * delta, HEIGHT / 2
    radius = max(LENGTH * abs(delta), 10)
    x = axis if delta else CLAMP - 4
    cross = f'<path class="hub" d="M{x - 4:.1f} {middle}h8m-4 -4v8"/>'
    return f'<circle class="hub" cx="{x:.1f}" cy="{middle}" r="{radius:.1f}"/>{cross}'


def chart(shown: Lesson) -> str:
    """Loci of some modes, in the colours of their families, with the multiples of the speed."""
    scene, (start, stop, first, last) = shown.scene, LOCI[shown.name]
    values = np.linspace(start, stop, POINTS)
    found = loci(scene.beam, scene.over, values, last + 1, **scene.options)
    numbers = np.array([branch.mode_index for branch in found.branches]) + 1
    inside = (first <= numbers) & (numbers <= last)
    frequency = np.where(inside, [branch.frequency for branch in found.branches], np.nan)
    low, high = 0.0 if first == 1 else np.nanmin(frequency), np.nanmax(frequency)

    def height(frequency: np.ndarray) -> np.ndarray:
        return HEIGHT - MARGIN - (HEIGHT - 2 * MARGIN) * (frequency - low) / (high - low)

    x = MARGIN + (WIDTH - 2 * MARGIN) * (values - start) / (stop - start)
    parts = [f'<path class="rest" d="M{MARGIN} {MARGIN}V{HEIGHT - MARGIN}H{WIDTH - MARGIN}"/>']
    multiples = (height(k * values) for k in scene.per_rev)
    parts += [path(x[y >= MARGIN], y[y >= MARGIN], "hub") for y in multiples]
    for branch, row in zip(found.branches, height(frequency), strict=True):
        family = np.array([one or MIXED for one in branch.family])
        for name in np.unique(family):
            here = (family == name) & np.isfinite(row)
            here |= np.r_[False, here[:-1]] & np.isfinite(row)  # without a gap to the next colour
            runs = np.split(np.arange(POINTS), np.flatnonzero(np.diff(here)) + 1)
            parts += [path(x[run], row[run], str(name)) for run in runs if here[run[0]]]
    return "".join(parts)


def place(points: np.ndarray) -> np.ndarray:
    """Positions (2, ...) [px] of points (..., 2) from the clamp in lengths of the beam."""
    return np.stack([CLAMP + LENGTH * points[..., 0], HEIGHT / 2 - LENGTH * points[..., 1]])


def line(points: np.ndarray, name: str) -> str:
    """A line through points (n, 2) in lengths of the beam."""
    x, y = place(points)
    return path(x, y, name)


def path(x: np.ndarray, y: np.ndarray, name: str) -> str:
    """A line of a CSS class through points [px]."""
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
    return f'<polyline class="{name}" points="{points}"/>'
