"""The tab with the veering microscope: words, a small chart of both cases, and the shapes."""

import math
from html import escape

import numpy as np
from viser import GuiApi, uplot

from beamviz.display_units import Measure, frequencies, measure
from beamviz.explorer.features.loci_chart import FAMILIES, filled, lanes, roomy
from beamviz.explorer.features.veering import Closeup, Motion, Pair, X
from beamviz.explorer.page.html import SMALL
from beamviz.explorer.page.plot_style import COLOURS, FAINT, LINE, MARK, add_plot, axes, dot, scales

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
