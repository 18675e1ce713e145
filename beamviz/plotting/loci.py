"""The loci chart as a picture: a Campbell diagram where the parameter is the speed."""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray

from beamviz.adjusting.goals import ClearGoal
from beamviz.beam import NUMBERS
from beamviz.errors import InvalidInput
from beamviz.frequency_loci import Loci
from beamviz.frequency_loci.branches import Branch
from beamviz.frequency_loci.events import EVENT_KINDS
from beamviz.frequency_loci.events.record import Event
from beamviz.frequency_loci.limits import Limit
from beamviz.measured import MeasuredFrequency, measured_frequencies, points_over
from beamviz.plotting import (
    CENTRED,
    COLOURS,
    FAINT,
    INK,
    KINDS,
    STYLE,
    axis_of,
    current_axes,
    new_figure,
)
from beamviz.plotting.labels import (
    HALO,
    OFFSET,
    EndLabel,
    LabelPlacer,
    draw_legend,
    label_line_ends,
)

WIDTH, HEIGHT = 7.6, 5.2  # [in]
LEFT, RIGHT, BOTTOM, TOP = 0.092, 0.925, 0.098, 0.845  # of it, the frame
MUTED, SHADOW = "#5A5A5A", "#EDEDED"
SHADES = 20  # of colour from one family to the other
FAMILIES = LinearSegmentedColormap.from_list(
    "families", [COLOURS["stretching"], "#8C7C86", COLOURS["bending"]]
)
MARK: dict[str, Any] = {"ms": 6, "mew": 1.1, "ls": ""}
GROWTH_HEIGHT, GROWTH_SHARE = 0.26, 0.72  # of the figure for growth rates; of it, their axes
LINE: dict[str, Any] = {"lw": 1.7, "zorder": 3}
SECOND: dict[str, Any] = {"color": "#B4B4B4", "lw": 1.3, "zorder": 2}
PER_REV: dict[str, Any] = {"color": FAINT, "lw": 0.8, "ls": (0, (5, 3)), "zorder": 1}
ALL_ALONG: dict[str, Any] = {"color": INK, "alpha": 0.18, "lw": 7, "zorder": 2}
ALL_ALONG |= {"solid_capstyle": "butt"}
ABOVE: dict[str, Any] = {"textcoords": "offset points", "ha": "center", "va": "bottom"}
ABOVE |= {"color": MUTED, "fontsize": 8}
MEASURED: dict[str, Any] = {"marker": "D", "ms": 4.5, "mfc": "white", "mec": INK, "mew": 1.1}
MEASURED |= {"ls": "", "color": INK, "zorder": 7}
BAND: dict[str, Any] = {"color": "#C0392B", "alpha": 0.16, "lw": 7, "solid_capstyle": "butt"}
BAND_FILL: dict[str, Any] = {"color": BAND["color"], "alpha": BAND["alpha"], "lw": 0, "zorder": 1}
MAX_LABELLED = 10  # crossings and veerings; more labels would hide the chart
START: dict[str, Any] = {"textcoords": "offset points", "va": "bottom", "weight": "bold"}
START |= {"path_effects": HALO, "zorder": 4}
ON_LIMIT: dict[str, Any] = {**CENTRED, "color": MUTED, "multialignment": "center", "clip_on": True}
WIDE = 0.28  # of the frame: a limit that is wider is labelled horizontally


def draw_chart(
    loci: Loci,
    per_rev: Sequence[int] = (),
    marker: float | None = None,
    second: Loci | None = None,
    second_title: str = "",
    names: "Names | None" = None,
    measured: Any = None,
    clear: ClearGoal | None = None,
) -> Figure:
    """The chart: loci in the colours of their families, events, limits, per-rev lines
    omega = k gamma for each k of `per_rev`, an upright line at the value `marker`, and behind them
    in grey the loci of a second beam over the same values; above them the parameters held fixed,
    the model, and the meaning of colours and marks; below them the growth rates where modes grow.
    names: those of the modes, by the labels of the branches, at a value; by default these
    labels. measured: frequencies to draw as points, a file or table as for `adjust`. clear: of loci
    over gamma, per-rev lines to shade with the margin in which no frequency is to be. Raises
    InvalidInput for measured frequencies that have no place in the chart."""
    points = measured_points(loci, measured)
    growing = [branch for branch in loci.branches if np.nan_to_num(branch.growth_rate).any()]
    bottom = BOTTOM + (GROWTH_HEIGHT if growing else 0.0)
    with rc_context(STYLE):
        figure = new_figure(WIDTH, HEIGHT)
        axes = figure.add_axes((LEFT, bottom, RIGHT - LEFT, TOP - bottom))
        chart = LociDrawing(loci, axes, per_rev, names)
        if second:
            chart.draw_second(second)
        chart.annotate(per_rev)
        chart.draw_measured(points)
        if clear:
            chart.draw_bands(clear)
        if growing:
            lower = figure.add_axes((LEFT, BOTTOM, RIGHT - LEFT, GROWTH_SHARE * GROWTH_HEIGHT))
            chart.draw_growth_rates(lower, growing)
        if marker is not None:
            axes.axvline(chart.x(marker), color="0.5", lw=0.8, zorder=0, gid="marker")
        held = loci.beam.described(name for name in loci.beam.numbers if name != loci.over)
        title = f"Loci over {NUMBERS[loci.over].symbol} at {held}".replace("-", "−")
        figure.text(0.012, 0.965, title, va="center", weight="bold")
        figure.text(0.012, 0.927, loci.problem.described, va="center", color=MUTED, fontsize=8)
        legend = _legend(chart, per_rev) | ({second_title: SECOND} if second else {})
        legend |= {"measured": MEASURED} if points else {}
        legend |= {f"to be kept free: {100 * clear.margin:.3g} %": BAND} if clear else {}
        draw_legend(figure, legend, 0.0085, 0.887)
    return figure


def plot_loci(loci: Loci, axes: Axes | None = None, measured: Any = None) -> Axes:
    """See Loci.plot."""
    points = measured_points(loci, measured)
    chart = LociDrawing(loci, axes or current_axes())
    chart.annotate()
    chart.draw_measured(points)
    return chart.axes


def measured_points(loci: Loci, measured: Any) -> list[tuple[float, MeasuredFrequency]]:
    """The measured frequencies at their values of the parameter, see `points_over`. Raises
    InvalidInput where none is in the chart."""
    if measured is None:
        return []
    points = points_over(loci.beam, loci.over, measured_frequencies(loci.beam, measured))
    if not any(loci.values[0] <= at <= loci.values[-1] for at, _ in points):
        raise InvalidInput(
            f"measured: no frequency is at the numbers of these loci, {loci.over} ="
            f" {loci.values[0]:g} .. {loci.values[-1]:g}"
        )
    return points


def has_points(loci: Loci, measured: Any) -> bool:
    """Whether some of the measured frequencies are in the chart."""
    try:
        return bool(measured_points(loci, measured or None))
    except InvalidInput:
        return False


Names = Callable[[float], Mapping[str, str]]  # value -> names of modes by labels of branches


class LociDrawing:
    """Loci on axes, which are in SI where the beam has units; resonances with the multiples
    `per_rev` of the speed alone; names: see `draw_chart`."""

    def __init__(
        self, loci: Loci, axes: Axes, per_rev: Sequence[int] = (), names: Names | None = None
    ):
        self.loci, self.axes = loci, axes
        labels = {branch.label: branch.label for branch in loci.branches}
        self.first, self.last = (
            {**labels, **(names(float(end)) if names else {})} for end in loci.values[[0, -1]]
        )
        events = loci.events
        self.events = [event for event in events if not event.per_rev or event.per_rev in per_rev]
        self.along, self.across = (axis_of(name, loci.units) for name in (loci.over, "frequency"))
        self.x, self.y = self.along.convert, self.across.convert
        for branch in loci.branches:
            self.draw_branch(axes, loci, branch)
        highest = float(axes.dataLim.y1)
        top = 1.05 * highest if math.isfinite(highest) and highest > 0 else 1.0  # no mode vibrates
        axes.set(xlim=self.x(loci.values[[0, -1]]), ylim=(0, top))
        axes.set(xlabel=self.along.label, ylabel=self.across.label)
        axes.locator_params(nbins=10, steps=(1, 2, 5, 10))

    def draw_growth_rates(self, axes: Axes, branches: Sequence[Branch]) -> None:
        """The growth rates of some branches, on axes below those of the frequencies."""
        values = self.loci.values
        for branch in branches:
            rate = self.y(branch.growth_rate) if self.loci.units is None else branch.growth_rate
            colour = tuple(np.nanmean(colours_of(branch), axis=0))
            axes.plot(self.x(values), rate, color=colour, **LINE)
            last = int(np.flatnonzero(np.isfinite(rate))[-1])
            text = f"{branch.label} {rate[last]:+.3g}".replace("-", "−")
            axes.annotate(text, (self.x(values[last]), rate[last]), (3, 0), **OFFSET, fontsize=8)
        axes.axhline(0.0, color=FAINT, lw=0.8, zorder=1)
        axes.set(xlim=self.axes.get_xlim(), xlabel=self.axes.get_xlabel(), ylabel="growth [1/T*]")
        axes.locator_params(nbins=4)
        self.axes.set(xlabel="")
        self.axes.tick_params(labelbottom=False)

    def annotate(self, per_rev: Sequence[int] = ()) -> None:
        """Draw limits, per-rev lines, marks and labels."""
        for limit in self.loci.limits:
            self.draw_limit(limit)
        self.label_ends(self.draw_per_rev_lines(per_rev))
        for event in self.events:
            place = self.x(event.at), self.y(event.frequency)
            if event.until is None:
                self.axes.plot(*place, **_mark(event), zorder=5 if event.per_rev else 6)
            else:
                end = self.x(event.until), self.y(event.frequency_until)
                self.axes.plot(*zip(place, end, strict=True), **ALL_ALONG)
        self.label_starts()
        self.label_events()

    def text(self, value: float) -> str:
        """A value of x as text."""
        return self.along.place(value).replace("-", "−")

    def draw_branch(self, axes: Axes, loci: Loci, branch: Branch, **style: Any) -> None:
        """One locus, through its frequencies at events; its colour changes from one family to the
        other where the mode does. loci: of the branch, these or others over the same values."""
        known = np.isfinite(branch.bending_fraction)
        if not known.any():
            return
        points = [(e.at, y) for e in loci.events for y in _through(e, branch.label)]
        places, heights = np.array(points).reshape(-1, 2).T
        x = np.concatenate((loci.values, places))
        y = np.concatenate((branch.frequency, heights))
        order = x.argsort(kind="stable")
        x, y = x[order], y[order]
        shares = shares_of(branch)
        shades = [np.interp(x, loci.values[known], share[known]) for share in shares.T]
        shade = np.round(np.column_stack(shades) * SHADES)
        changes = (np.diff(shade, axis=0, prepend=-1) != 0).any(axis=1)
        starts = np.flatnonzero(changes).tolist()
        for start, stop in zip(starts, [*starts[1:], len(x)], strict=True):
            piece = slice(start, stop + 1)  # a point more, so that the colours join
            colour = tuple(colours_of_shares(shade[start] / SHADES))
            axes.plot(self.x(x[piece]), self.y(y[piece]), color=colour, **{**LINE, **style})

    def draw_measured(self, points: Sequence[tuple[float, MeasuredFrequency]]) -> None:
        """Measured frequencies, with bars of one standard deviation where it is known, inside the
        range of the chart."""
        if not points:
            return
        limits = self.axes.get_xlim(), self.axes.get_ylim()
        x = self.x(np.array([at for at, _ in points]))
        y = self.y(np.array([row.frequency for _, row in points]))
        errors = self.y(np.array([row.error for _, row in points]))
        known = None if np.isnan(errors).any() else errors
        drawn = self.axes.errorbar(x, y, known, capsize=2.5, elinewidth=1.1, **MEASURED)
        drawn[0].set_gid("measured")
        self.axes.set(xlim=limits[0], ylim=(0, max(limits[1][1], 1.05 * float(y.max()))))

    def draw_bands(self, clear: ClearGoal) -> None:
        """The bands around per-rev lines in which no frequency is to be."""
        limits = self.axes.get_xlim(), self.axes.get_ylim()
        for line in clear.lines:
            speeds, corners = clear.band(line)
            self.axes.fill(self.x(speeds), self.y(corners), gid=f"band {line}", **BAND_FILL)
        self.axes.set(xlim=limits[0], ylim=limits[1])

    def draw_second(self, loci: Loci) -> None:
        """The loci of a second beam, behind those of the first."""
        for branch in loci.branches:
            self.axes.plot(self.x(loci.values), self.y(branch.frequency), **SECOND)

    def draw_limit(self, limit: Limit) -> None:
        """Shade and label a range without an equilibrium, or without a stable one."""
        axes, (first, last) = self.axes, self.loci.values[[0, -1]]
        ends = self.x(limit.start), self.x(limit.stop)
        axes.axvspan(*ends, color=SHADOW, lw=0, zorder=0)
        for edge in {limit.start, limit.stop} - {first, last}:
            axes.plot([self.x(edge)] * 2, axes.get_ylim(), color=FAINT, lw=1, zorder=1)
        if limit.stop == last and limit.start > first:
            where = f"beyond {self.text(limit.start)}"
        elif limit.start == first and limit.stop < last:
            where = f"below {self.text(limit.stop)}"
        else:
            where = f"from {self.text(limit.start)} to {self.text(limit.stop)}"
        k = int(abs(self.loci.values - (limit.start + limit.stop) / 2).argmin())
        heights = [self.y(branch.frequency[k]) for branch in self.loci.branches]
        lines = np.array([0.0, *sorted(filter(math.isfinite, heights)), axes.get_ylim()[1]])
        widest = int(np.diff(lines).argmax())
        middle = sum(ends) / 2, lines[widest : widest + 2].mean()
        rotation = 0 if limit.stop - limit.start > WIDE * (last - first) else 90
        text = f"{limit.name}\n{where}"
        axes.text(*middle, text, rotation=rotation, **ON_LIMIT)

    def draw_per_rev_lines(self, multiples: Sequence[int]) -> list[EndLabel]:
        """Per-rev lines, labelled where they leave the frame at its top; the labels of others."""
        top, (first, last) = self.axes.get_ylim()[1], self.loci.values[[0, -1]]
        ends = []
        for k in multiples:
            rate = k * self.y(1.0)
            end = min(last, top / rate)
            if end <= first:
                continue
            x = self.x(np.array([first, end]))
            self.axes.plot(x, [rate * first, rate * end], **PER_REV)
            if end == last:
                ends.append((rate * end, f"{k}×", MUTED, "normal"))
            else:
                self.axes.annotate(f"{k}×", (x[1], top), (0, 2), **ABOVE)
        return ends

    def label_ends(self, others: Sequence[EndLabel] = ()) -> None:
        """Labels of the branches, and of other lines, that reach the right end."""
        branches = [
            (
                self.y(branch.frequency[-1]),
                self.last[branch.label],
                tuple(colours_of(branch)[-1]),
                "bold",
            )
            for branch in self.loci.branches
            if math.isfinite(branch.frequency[-1])
        ]
        label_line_ends(self.axes, [*branches, *others])

    def label_events(self) -> None:
        """Labels of the events that are no resonances, unless there are too many."""
        placer = LabelPlacer(self.axes)
        events = [event for event in self.events if not event.per_rev]
        for event in events if len(events) <= MAX_LABELLED else ():
            lines = [event.kind, self.text(event.at)]
            lines += [f"gap {self.across.gap(event.gap)}"] if event.gap else []
            placer.annotate("\n".join(lines), self.x(event.at), self.y(event.frequency))

    def label_starts(self) -> None:
        """Labels at the left ends of the branches that end inside the frame or change their
        family, so that their right end does not tell them."""
        for branch in self.loci.branches:
            present = np.flatnonzero(np.isfinite(branch.frequency))
            if not len(present):
                continue
            first, last = present[[0, -1]]
            if last == len(branch.frequency) - 1 and branch.kinds[first] == branch.kinds[last]:
                continue
            place = self.x(self.loci.values[first]), self.y(branch.frequency[first])
            colour = tuple(colours_of(branch)[first])
            name = self.first[branch.label] if first == 0 else branch.label
            self.axes.annotate(name, place, (4, 2), color=colour, **START)


def shares_of(branch: Branch) -> NDArray:
    """What the colour of a branch depends on: the share (values, 1) of its kinetic energy across
    the beam, in space (values, 2) also that in the plane of rotation."""
    shares = [branch.bending_fraction]
    if branch.in_plane_fraction is not None:
        shares.append(branch.in_plane_fraction)
    return np.column_stack(shares)


def colours_of_shares(shares: NDArray) -> NDArray:
    """The colours (..., 3) of `shares_of` (..., 1 or 2): in space the mean of those of flap, lag
    and stretching by share."""
    bending = shares[..., 0]
    if shares.shape[-1] == 1:
        return np.asarray(FAMILIES(bending))[..., :3]
    out_of_plane = 1 - shares[..., 1]
    parts = {"F": out_of_plane, "L": bending - out_of_plane, "S": 1 - bending}
    mixed = sum(share[..., None] * np.array(to_rgb(KINDS[k][1])) for k, share in parts.items())
    return np.clip(mixed, 0.0, 1.0)


def colours_of(branch: Branch) -> NDArray:
    """The colours (values, 3) of a branch."""
    return colours_of_shares(shares_of(branch))


def _through(event: Event, label: str) -> list[float]:
    """The frequencies of a branch at an event, in the order of the line that is drawn through them;
    none where they are not known, nan where the line is interrupted."""
    pairs = zip(event.branches, event.frequencies, strict=True)
    frequencies = [math.nan if name != label or y is None else y for name, y in pairs]
    if EVENT_KINDS[event.kind].jumps:
        before, after = frequencies
        return [before, math.nan, after]
    return [y for y in frequencies if math.isfinite(y)]


def _mark(event: Event) -> dict[str, Any]:
    """The style of the mark of an event."""
    kind = EVENT_KINDS[event.kind]
    fill, edge = (INK, "white") if kind.filled else ("white", INK)
    return {**MARK, "marker": kind.marker, "mfc": fill, "mec": edge}


def _legend(chart: LociDrawing, per_rev: Sequence[int]) -> dict[str, dict[str, Any]]:
    """The styles of lines and marks, of those drawn, by their meaning."""
    kinds_drawn = {kind for branch in chart.loci.branches for kind in branch.kinds}
    if chart.loci.problem.in_space:
        colours: dict[str, Any] = {
            name: colour for kind, (name, colour) in KINDS.items() if kind in kinds_drawn
        }
    else:
        shares = {"bending": 1.0, "mixed": 0.5, "stretching": 0.0}
        colours = {n: FAMILIES(share) for n, share in shares.items() if n[0].upper() in kinds_drawn}
    lines: dict[str, dict[str, Any]] = {name: {"color": c, **LINE} for name, c in colours.items()}
    at_points = {event.kind: event for event in chart.events if event.until is None}
    counts = Counter(event.kind for event in chart.events if event.until is None)
    for name, event in at_points.items():
        many = counts.total() > MAX_LABELLED
        lines[EVENT_KINDS[name].counted(counts[name]) if many else name] = _mark(event)
    if any(event.until is not None for event in chart.events):
        lines["locus on a per-rev line: resonance"] = ALL_ALONG
    if per_rev:
        lines["per-rev line, k × speed"] = PER_REV
    return lines
