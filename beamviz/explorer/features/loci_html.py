"""What there is to say of a loci chart, as HTML: names on its lines, a key, the meetings."""

import math
from html import escape

from beamviz.display_units import Measure, frequencies, measure
from beamviz.explorer.features.loci_chart import FAMILIES, PER_REV, Chart, Point, top
from beamviz.explorer.page.html import SMALL, table
from beamviz.explorer.page.plot_style import ABOVE, BELOW, COLOURS, FAINT, LEFT, apart
from beamviz.frequency_loci import Event, Loci
from beamviz.plotting.style import SYMBOLS

SIGNS = {"crossing": "○", "veering": "●"}
VERBS = {"crossing": "cross", "veering": "veer"}
MAX_MEETINGS = 8
LETTERS = 11  # [px]
HEIGHT, RIGHT = 210, 32  # [px] of the chart, and of its margin at the right
FRAME = (10.25, 8.25, 12)  # [px] around the chart: left, right, below


def shown(chart: Chart) -> tuple[Measure, Measure]:
    """How the number along the chart and the frequencies are shown."""
    units = chart.loci.units if chart.loci else chart.question.beam.units
    return measure(chart.question.over, units), frequencies(units)


def labels(found: Loci, per_rev: bool) -> str:
    """The names that modes have at the right end, put over the chart that stands above: where
    two loci have exchanged their shapes, they have exchanged their names."""
    high = top(found)
    ends = sorted(
        (float(solution.frequencies[k]), solution.labels[k], COLOURS[solution.families[k]])
        for branch in found.branches
        if (solution := branch.solutions[-1]) and (k := int(branch.mode_index[-1])) >= 0
        if math.isfinite(solution.frequencies[k])
    )
    places = apart([end for end, _, _ in ends], high * 13 / (HEIGHT - ABOVE - BELOW))
    names = [
        f'<b style="position:absolute;left:100%;margin-left:4px;color:{colour};'
        f'bottom:calc({100 * place / high:.2f}% - .65em)">{escape(label)}</b>'
        for place, (_, label, colour) in zip(places, ends, strict=True)
    ]
    if per_rev and found.over == "gamma":
        names += per_rev_labels(float(found.values[-1]), high)
    return (
        '<div aria-hidden="true" data-labels style="position:relative;height:0;'
        'pointer-events:none;font-size:11px;line-height:1.3">'
        f'<div style="position:absolute;left:{LEFT + FRAME[0]}px;right:{RIGHT + FRAME[1]}px;'
        f'bottom:{BELOW + FRAME[2]}px;height:{HEIGHT - ABOVE - BELOW}px">'
        + "".join(names)
        + "</div></div>"
    )


def per_rev_labels(stop: float, high: float) -> list[str]:
    """The names of the per-rev lines, near their upper ends; where they would touch, some."""
    names, below, height = [], -math.inf, HEIGHT - ABOVE - BELOW
    for k in PER_REV:
        x = min(0.97 * stop, 0.94 * high / k)
        right, up = x / stop, k * x / high
        crowded = right > 0.9 and (up - below) * height < LETTERS
        if not crowded:
            below = up
            names.append(
                f'<span style="position:absolute;color:#6b7177;left:{100 * right:.2f}%;'
                f'bottom:{100 * up:.2f}%;transform:translate(-110%,0)">{k}γ</span>'
            )
    return names


def key(chart: Chart, second: Chart | None) -> str:
    """What colours and marks mean."""
    if chart.loci is None:
        return ""
    seen = {str(family) for branch in chart.loci.branches for family in branch.family if family}
    parts = [f'<b style="color:{COLOURS[f]}">━</b> {f}' for f in FAMILIES if f in seen]
    if second:
        parts.append(f'<b style="color:{FAINT}">╍</b> compared with')
    kinds = {event.kind for event in chart.events}
    parts += [f"{SIGNS[kind]} {VERBS[kind]}" for kind in SIGNS if kind in kinds]
    return f'<div aria-label="key" style="{SMALL};opacity:.8">{" &ensp;".join(parts)}</div>'


def here(point: Point | None, along: Measure, across: Measure) -> str:
    """The modes of the beam of the scene: the upright line of the chart."""
    if point is None:
        return ""
    modes = " &ensp;".join(
        f'<span style="white-space:nowrap"><b style="color:{COLOURS[family]}">{label}</b>'
        f" {across.factor * frequency:.4g}</span>"
        for label, family, frequency in zip(*point.names, point.frequencies, strict=True)
        if math.isfinite(frequency)
    )
    value = along.text(point.value, 5)
    unit = f" {across.unit}" if across.unit else ""
    return (
        f'<div aria-label="this beam" style="{SMALL}">┊ this beam, {value}:<br>{modes}{unit}</div>'
    )


def meetings(chart: Chart, chosen: Event | None) -> str:
    """The table of the meetings."""
    warning = chart.loci.warning if chart.loci else ""
    if not chart.events:
        words = warning or ("" if chart.loci is None else "No two of these lines meet here.")
        return f'<div style="{SMALL}">{words}</div>' if words else ""
    along, across = shown(chart)
    heads = ("", "", "lines", f"at {along.head}", across.label, "least gap")
    rows = [row(k, event, along, across) for k, event in enumerate(chart.events[:MAX_MEETINGS])]
    marked = [k for k, event in enumerate(chart.events) if event == chosen]
    more = len(chart.events) - MAX_MEETINGS
    return (
        table("meetings", heads, rows, marked=marked)
        + (f'<div style="{SMALL}">and {more} more</div>' if more > 0 else "")
        + (f'<div style="{SMALL}">{warning}</div>' if warning else "")
    )


def row(k: int, event: Event, along: Measure, across: Measure) -> tuple[object, ...]:
    """One meeting."""
    a, b = event.branches
    gap = "0" if event.kind == "crossing" else f"{across.factor * event.gap:.3g}"
    return (
        k + 1,
        f"{SIGNS[event.kind]} {VERBS[event.kind]}",
        f"<b>{escape(a)}, {escape(b)}</b>",
        along.number(event.at, 4),
        across.number(event.frequency, 3),
        gap,
    )


def gaps(chart: Chart) -> str:
    """Why a line ends, or why there is none."""
    limits = chart.loci.limits if chart.loci else ()
    over = chart.question.over
    named = [limit.message.replace(f"{over} =", f"{SYMBOLS[over]} =") for limit in limits]
    words = [chart.words] if chart.words else named
    return "".join(f'<div role="note" style="{SMALL}"><b>Gap:</b> {escape(w)}</div>' for w in words)
