"""A meeting of two loci seen from near: without and with Coriolis forces, and the shapes there."""

import math
from dataclasses import dataclass
from html import escape
from typing import NamedTuple

import numpy as np
from viser import GuiApi, uplot

from beamviz.beam import PARAMETERS
from beamviz.display_units import Measure, frequencies, measure
from beamviz.explorer.features.loci_chart import FAMILIES, Question, filled, lanes, roomy
from beamviz.explorer.page.html import SMALL
from beamviz.explorer.page.style import COLOURS, FAINT, LINE, MARK, add_plot, axes, dot, scales
from beamviz.frequency_loci import Branch, Event, Loci, loci
from beamviz.solver.solution import Solution

WIDE, FINE = 40, 40  # points: even, so that no meeting is one of them
REACH = 0.2  # of the range of the chart, to both sides: where the other meeting is looked for
LEAST = 0.004  # of that range: the narrowest view is twice as wide
ROOM = 5.0  # times the distance at which the gap has doubled, or the shift by Coriolis forces
BESIDE = 1e-3  # of the view: so far from a crossing, where both are one, the shapes are taken
X = np.linspace(0.0, 1.0, 61)


@dataclass(frozen=True)
class Target:
    """A meeting of a chart to look at."""

    question: Question
    event: Event


class Motion(NamedTuple):
    """The shape of one mode at X (61,), largest displacement 1, and what share of the kinetic
    energy lies across the beam."""

    along: np.ndarray
    across: np.ndarray
    share: float


@dataclass(frozen=True)
class Pair:
    """Two loci around their meeting, without or with Coriolis forces.

    event: None where the two do not meet in this way; motions: for each of the two branches
    the shape before, at and after `at`.
    """

    coriolis: bool
    event: Event | None
    at: float
    values: np.ndarray
    branches: tuple[Branch, Branch]
    motions: tuple[tuple[Motion, Motion, Motion], ...]


@dataclass(frozen=True)
class Closeup:
    """Both pairs, or in `words` why there are none."""

    target: Target
    pairs: tuple[Pair, ...] = ()
    words: str = ""


def magnified(target: Target) -> Closeup:
    """The two loci of a meeting without and with Coriolis forces, over the same values."""
    question, event = target.question, target.event
    reach = REACH * (question.stop - question.start)
    wide = around(question, event.at, reach, WIDE)
    found = [chart(question, wide, coriolis) for coriolis in (False, True)]
    meetings = [same(one, event, reach) for one in found]
    centre, half = view(found, meetings, event, question)
    places = [one.at + (BESIDE * half if one.kind == "crossing" else 0) for one in meetings if one]
    values = np.union1d(around(question, centre, half, FINE), places)
    pairs = tuple(
        pair(chart(question, values, coriolis), meeting, event, centre)
        for coriolis, meeting in zip((False, True), meetings, strict=True)
    )
    return Closeup(target, pairs)


def around(question: Question, at: float, reach: float, count: int) -> np.ndarray:
    """Values (count,) to both sides of `at`, within what the number may be."""
    low, high = PARAMETERS[question.over].limits
    return np.linspace(max(at - reach, low), min(at + reach, high, question.stop), count)


def chart(question: Question, values: np.ndarray, coriolis: bool) -> Loci:
    """The loci over some values."""
    options = {**question.options, "coriolis": coriolis}
    return loci(question.beam, question.over, values, **options)


def same(found: Loci, event: Event, reach: float) -> Event | None:
    """The meeting of the same two branches nearest to one of another chart, within reach."""
    near = [e for e in found.events if {*e.branches} == {*event.branches}]
    near = [e for e in near if abs(e.at - event.at) <= reach]
    return min(near, key=lambda e: abs(e.at - event.at), default=None)


def view(
    found: list[Loci], meetings: list[Event | None], event: Event, question: Question
) -> tuple[float, float]:
    """The middle of the view and half its width: both meetings and the whole gap are in it."""
    at = [one.at for one in meetings if one] or [event.at]
    centre, extent = (min(at) + max(at)) / 2, max(at) - min(at)
    a, b = branches_of(found[0], event, centre)
    slope = abs(np.gradient(b.frequency - a.frequency, found[0].values))
    steepest = float(np.nanmax(slope)) if np.isfinite(slope).any() else 0.0
    gap = max((one.gap for one in meetings if one), default=0.0)
    spread = ROOM * gap / steepest if steepest else 0.0
    width = question.stop - question.start
    return centre, float(np.clip(max(extent, spread), LEAST * width, REACH * width))


def branches_of(found: Loci, event: Event, at: float) -> tuple[Branch, Branch]:
    """The two branches of an event in a chart; where labels differ, the two nearest to it."""
    by_label = {branch.label: branch for branch in found.branches}
    if all(label in by_label for label in event.branches):
        return by_label[event.branches[0]], by_label[event.branches[1]]
    k = int(np.argmin(abs(found.values - at)))
    distance = [abs(branch.frequency[k] - event.frequency) for branch in found.branches]
    first, second = np.argsort(np.nan_to_num(distance, nan=np.inf))[:2]
    return found.branches[first], found.branches[second]


def pair(found: Loci, meeting: Event | None, event: Event, centre: float) -> Pair:
    """Two loci with their shapes at the ends of the view and at their meeting."""
    at = meeting.at if meeting else centre
    branches = branches_of(found, meeting or event, at)
    k = int(np.argmin(abs(found.values - at)))
    motions = tuple(motions_of(branch, (0, k, len(found.values) - 1)) for branch in branches)
    return Pair(found.problem.coriolis, meeting, at, found.values, branches, motions)


def motions_of(branch: Branch, places: tuple[int, int, int]) -> tuple[Motion, Motion, Motion]:
    """The shapes of a branch at three values, their signs alike as far as they can be."""
    first, middle, last = (motion(branch, k) for k in places)
    return alike(first, middle), middle, alike(last, middle)


def motion(branch: Branch, k: int) -> Motion:
    """The shape of a branch at value number k; nan where it has none."""
    solution, place = branch.solutions[k], int(branch.mode_index[k])
    if solution is None or place < 0:
        return Motion(np.full(len(X), np.nan), np.full(len(X), np.nan), np.nan)
    along, across = components(solution, place)
    size = np.sqrt(along**2 + across**2).max()
    return Motion(along / size, across / size, float(solution.bending_energy_fraction[place]))


def components(solution: Solution, mode: int) -> tuple[np.ndarray, np.ndarray]:
    """The shape of a mode along and across the beam. With Coriolis forces the two are a quarter
    of a period apart: the shape is real along and imaginary across."""
    shape = solution.shape(mode, X)
    parts = shape.real + shape.imag
    return parts[:, 0], parts[:, 1]


def alike(one: Motion, other: Motion) -> Motion:
    """A shape with the sign that fits another."""
    overlap = one.along @ other.along + one.across @ other.across
    return one._replace(along=-one.along, across=-one.across) if overlap < 0 else one


HEIGHT = 175  # [px]
LANES = 4  # lines of one family there is room for at first
INVITATION = "Choose a meeting in the tab Loci: here you see it from near."
WIDTH, TALL = 96, 30  # of the picture of a shape [px]
KEY = (
    f'<div style="{SMALL};opacity:.8">How the points of the beam move: '
    f'<b style="color:{COLOURS["bending"]}">━</b> across it (bending), '
    f'<b style="color:{COLOURS["stretching"]}">━</b> along it (stretching).</div>'
)


class MicroscopeTab:
    """Shows one close-up."""

    def __init__(self, gui: GuiApi):
        self.room = LANES
        self.words = gui.add_html(f'<div style="{SMALL}">{INVITATION}</div>')
        nothing = (np.array([0.0, 1.0]), *[np.full(2, np.nan)] * (len(styles(LANES)) - 1))
        self.plot = add_plot(gui, nothing, styles(LANES), axes("", ""), HEIGHT, visible=False)
        self.shapes = gui.add_html("")

    def show(self, closeup: Closeup | None, *, lost: bool) -> None:
        """Draw a close-up, or invite to choose one; `lost`: the two do not meet any more."""
        pairs = closeup.pairs if closeup else ()
        self.plot.visible = bool(pairs) and not lost
        self.words.content = words(closeup, lost=lost)
        drawn = "".join(shapes(pair) for pair in pairs)
        self.shapes.content = drawn + KEY if drawn and not lost else ""
        if closeup and pairs and not lost:
            along, across = shown(closeup)
            low, high = (float(along.factor * pairs[0].values[end]) for end in (0, -1))
            heights = tuple(across.factor * end for end in extent(pairs))
            self.plot.axes = axes(along.label, across.label)
            self.plot.scales = scales((low, high), (heights[0], heights[1]))
            room = self.room
            for pair in pairs:
                self.room = roomy(self.room, lanes(pair.branches))
            x, *lines = series(pairs, self.room)
            self.plot.data = (along.factor * x, *(across.factor * line for line in lines))
            if room != self.room:
                self.plot.series = styles(self.room)


def extent(pairs: tuple[Pair, ...]) -> tuple[float, float]:
    """Where the axis of frequency begins and ends, with some room."""
    values = np.concatenate([branch.frequency for pair in pairs for branch in pair.branches])
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    room = 0.06 * (high - low)
    return low - room, high + room


def styles(room: int) -> tuple[uplot.Series, ...]:
    """How the arrays of `series` are drawn: without Coriolis thin and dashed, with it thick."""
    lines: list[uplot.Series] = [{}]
    for family in FAMILIES:
        dashed: uplot.Series = {"width": 1.25, "dash": (5, 4)}
        lines += [{"stroke": COLOURS[family], **LINE, **dashed}] * room
    for family in FAMILIES:
        lines += [{"stroke": COLOURS[family], "width": 2.5, **LINE}] * room
    lines.append({"stroke": MARK, "width": 1.5, **LINE})
    return (*lines, {"stroke": MARK, "width": 0, "points": dot("#ffffff", MARK, 7)})


def series(pairs: tuple[Pair, ...], room: int) -> tuple[np.ndarray, ...]:
    """Both pairs as arrays (n,) over common values: x, `room` lines of each family without and with
    Coriolis forces,
    the least gap as an upright line, and the crossings."""
    x = pairs[0].values
    veering = next((pair for pair in reversed(pairs) if kind(pair) == "veering"), None)
    doubled = np.insert(x, np.searchsorted(x, veering.at), veering.at) if veering else x
    keep = np.searchsorted(x, doubled)
    lines = [row[keep] for pair in pairs for row in filled(lanes(pair.branches), room, len(x))]
    gap, crossings = np.full(len(doubled), np.nan), np.full(len(doubled), np.nan)
    if veering:
        k = int(np.searchsorted(doubled, veering.at))
        gap[k : k + 2] = [branch.frequency[keep[k]] for branch in veering.branches]
    for pair in pairs:
        if pair.event and pair.event.kind == "crossing":
            crossings[np.searchsorted(doubled, pair.at)] = pair.event.frequency
    return (doubled, *lines, gap, crossings)


def kind(pair: Pair) -> str:
    """crossing, veering, or "" where the two do not meet."""
    return pair.event.kind if pair.event else ""


def words(closeup: Closeup | None, *, lost: bool) -> str:
    """What is seen, in a sentence for each case."""
    if closeup is None:
        return f'<div style="{SMALL}">{INVITATION}</div>'
    a, b = (escape(label) for label in closeup.target.event.branches)
    if lost or closeup.words:
        text = escape(closeup.words) or f"{a} and {b} no longer meet on the chart. {INVITATION}"
        return f'<div role="note" style="{SMALL}">{text}</div>'
    rows = "".join(f"<li>{sentence(pair, *shown(closeup))}</li>" for pair in closeup.pairs)
    return (
        f'<div aria-label="microscope" style="{SMALL}"><b>{a} and {b}</b>'
        f'<ul style="margin:.1em 0;padding-left:1.2em">{rows}</ul></div>'
    )


def shown(closeup: Closeup) -> tuple[Measure, Measure]:
    """How the number along the chart and the frequencies are shown."""
    question = closeup.target.question
    units = None if question.over == "mu" else question.beam.units
    return measure(question.over, units), frequencies(units)


def sentence(pair: Pair, along: Measure, across: Measure) -> str:
    """Crossing or veering, and by how much."""
    case = "<b>Coriolis on</b> (thick): " if pair.coriolis else "<b>Coriolis off</b> (dashed): "
    if pair.event is None:
        return case + "they do not come close enough to count as a meeting."
    value = along.number(pair.at, 3)
    at = f"at {value} {along.unit}" if along.unit else f"at {along.symbol} {value}"
    if pair.event.kind == "crossing":
        return f"{case}they cross {at}; nothing couples them (gap 0)."
    gap = f"{across.factor * pair.event.gap:.3g} {across.unit}".strip()
    return f"{case}they veer: least gap {gap} {at}; {exchange(pair)}."


def exchange(pair: Pair) -> str:
    """Whether the shapes change places along the loci."""
    first, _, last = pair.motions[0]
    changed = abs(last.share - first.share)
    if not math.isfinite(changed) or changed < 0.1:
        return "each keeps its kind of motion"
    return "they exchange their shapes" if changed > 0.5 else "they exchange part of their shapes"


def shapes(pair: Pair) -> str:
    """The two loci of a pair, upper one first: their shapes before, at and after."""
    order = sorted((0, 1), key=lambda k: -float(np.nan_to_num(pair.branches[k].frequency[0])))
    rows = "".join(
        f"<tr><td><b>{escape(pair.branches[k].label)}</b></td>"
        + "".join(f"<td>{drawing(motion)}</td>" for motion in pair.motions[k])
        + "</tr>"
        for k in order
    )
    case = "on" if pair.coriolis else "off"
    heads = "".join(
        f'<th style="font-weight:500">{head}</th>' for head in ("before", "at", "after")
    )
    return (
        f'<table aria-label="shapes, Coriolis {case}" style="width:calc(100% - 1.5em);'
        "margin:.2em .75em;font-size:.75em;text-align:center;border-collapse:collapse;"
        f'line-height:1.2"><tr style="opacity:.65"><th style="text-align:left;font-weight:500">'
        f"{case}</th>{heads}</tr>{rows}</table>"
    )


def drawing(motion: Motion) -> str:
    """One shape: how far each point of the beam moves along it and across it."""
    if not math.isfinite(motion.share):
        return "–"
    lines = "".join(
        f'<polyline points="{points(part)}" fill="none" stroke="{COLOURS[family]}" '
        f'stroke-width="{2 if family == larger(motion) else 1}"/>'
        for family, part in (("stretching", motion.along), ("bending", motion.across))
    )
    return (
        f'<svg width="{WIDTH}" height="{TALL}" role="img">'
        f'<path d="M0 {TALL / 2}H{WIDTH}" stroke="{FAINT}" stroke-width=".5"/>{lines}</svg>'
        f"<br>{100 * max(motion.share, 1 - motion.share):.0f} % {larger(motion)}"
    )


def larger(motion: Motion) -> str:
    """What the motion mostly is."""
    return "bending" if motion.share >= 0.5 else "stretching"


def points(part: np.ndarray) -> str:
    """A curve as points of an SVG."""
    y = TALL / 2 * (1 - 0.9 * part)
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(WIDTH * X, y, strict=True))
