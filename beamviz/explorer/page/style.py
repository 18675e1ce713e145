"""Theme and style sheet of the page, and its live charts."""

import math
from collections.abc import Iterable, Mapping, Sequence
from html import escape

import numpy as np
from viser import ClientHandle, GuiApi, ViserServer, uplot

from beamviz.drawing.text import Measure
from beamviz.plotting import COLOURS as FAMILY_COLOURS
from beamviz.solver.solution import MIXED

BRAND = (32, 96, 150)
SHEET = '.mantine-Paper-root[style*="max-height: 60%"]'  # the controls on a phone
SECTION = '.mantine-Tabs-root[style*="border-top"]'  # results or lessons in it

# viser styles its elements in place, so these rules need !important. Grey text gets a contrast of
# more than 7 : 1 on either page. On a phone the sheet of controls stands below the scene rather
# than over it, as wide as the screen (what is in it is no table, which a chart would widen again
# and again), and results and lessons come before the controls. Six tabs fit in one row, and all
# digits in the field beside a slider. Until somebody moves the bar between them, results get more
# of the column than lessons, whose pages are short.
STYLE = f"""<style>
:root[data-mantine-color-scheme] {{ --mantine-color-dimmed: #4a5158; }}
:root[data-mantine-color-scheme="dark"] {{ --mantine-color-dimmed: #b9c0c7; }}
[data-mantine-color-scheme="dark"] [role="tab"][aria-selected="true"] {{
  color: var(--mantine-primary-color-4) !important;
}}
[data-mantine-color-scheme="dark"]
  :is(.uplot canvas, [data-labels], [aria-label="key"], [aria-label="this beam"],
    [aria-label^="shapes"]) {{
  filter: brightness(1.4);
}}
[data-mantine-color-scheme="dark"]
  :is([aria-label="this method"], [aria-label="time against error"]) {{
  filter: brightness(1.25);
}}
[role="tab"] {{ padding-inline: 6px !important; font-size: 13px !important; }}
p:has(> label) {{ letter-spacing: -.2px !important; }}
.mantine-Slider-root + .mantine-NumberInput-root,
.mantine-Slider-root + .mantine-NumberInput-root input {{ width: 4.5rem !important; }}
.mantine-Slider-markLabel {{ font-size: .7rem !important; transform: translateY(3px); }}
[style*="flex: 0.5 1 0px"]:first-child {{ flex-grow: .58 !important; }}
[style*="flex: 0.5 1 0px"]:last-child {{ flex-grow: .42 !important; }}
@media (max-width: 36em) {{
  div:has(> {SHEET}) {{ flex-direction: column; }}
  div:has(> {SHEET}) > div[style*="flex-grow"] {{ height: 0 !important; min-height: 0; }}
  {SHEET} {{
    position: relative !important;
    flex: none;
    width: 100% !important;
    max-height: 56% !important;
  }}
  {SHEET} div[style*="width: 20em"] {{ width: 100% !important; }}
  {SHEET} .mantine-ScrollArea-content {{ display: block !important; min-width: 0 !important; }}
  div:has(> div > {SECTION}) {{ display: flex; flex-direction: column; }}
  div:has(> {SECTION}) {{ order: -1; }}
}}
</style>"""


def add_style(gui: GuiApi) -> None:
    """Add the style sheet and the title to a page."""
    gui.add_html(STYLE + script_element("document.title = 'beamviz'"))


def theme(side: ClientHandle | ViserServer, *, dark: bool) -> None:
    """Set a dark or a light theme, without viser's own buttons."""
    side.gui.configure_theme(
        dark_mode=dark, show_logo=False, show_share_button=False, brand_color=BRAND
    )


def script_element(script: str) -> str:
    """An element that runs `script` when it is added: an image that cannot be loaded does, a
    script element in HTML that comes later does not."""
    return f'<img alt="" src="data:," style="display:none" onerror="{escape(script)}">'


# Live charts

COLOURS = {**FAMILY_COLOURS, MIXED: "#CC79A7"}
FAINT, MARK = "#9AA0A6", "#787E85"  # seen on light and dark pages
LEFT, ABOVE, BELOW = 54, 8, 44  # [px] of the margins; at the right each chart has its own
LINE: uplot.Series = {"points": {"show": False}, "pxAlign": False}
FONTS: uplot.Axis = {"font": "11px sans-serif", "labelFont": "12px sans-serif"}
Range = tuple[float, float]


class Plot:
    """A chart without interaction, whose lines have their styles in groups.

    styles: of the groups, in order of drawing; height, right [px]: of the chart and of its right
    margin; log: the y axis is logarithmic. room: lines per group that the page knows styles for;
    it is doubled where they do not suffice, as the page builds the chart anew for other styles.
    """

    def __init__(
        self,
        gui: GuiApi,
        styles: Mapping[str, uplot.Series],
        height: int,
        *,
        right: int = 12,
        log: bool = False,
        visible: bool = True,
    ):
        self.styles, self.log, self.room = styles, log, dict.fromkeys(styles, 1)
        self.frame: tuple[object, ...] = ()  # what the axes are drawn for
        self.handle = gui.add_uplot(
            (np.array([0.0, 1.0]), *np.full((len(styles), 2), math.nan)),
            self.series,
            scales={"x": {"time": False, "range": (0.0, 1.0)}, "y": {"range": (0.0, 1.0)}},
            axes=(axis("", BELOW, 18, 45), axis("", LEFT, 14, 28)),
            legend={"show": False},
            cursor={"drag": {"x": False, "y": False}, "points": {"show": False}},
            padding=(ABOVE, right, 0, 0),
            height=height,
            visible=visible,
        )

    @property
    def series(self) -> tuple[uplot.Series, ...]:
        """The style of each array."""
        return ({}, *(self.styles[group] for group, room in self.room.items() for _ in range(room)))

    def show(
        self,
        x: np.ndarray,
        lines: Mapping[str, Sequence[np.ndarray]],
        measures: tuple[Measure, Measure],
        x_range: Range,
        y_range: Range,
    ) -> None:
        """Draw lines (n,) by group over ascending x (n,), nan where there is nothing, with the
        labels and in the units of the measures."""
        along, across = measures
        if self.frame != (measures, x_range, y_range):
            self.frame = measures, x_range, y_range
            y_axis: uplot.Axis = axis(across.label, LEFT, 14, 28)
            y_scale: uplot.Scale = {"range": scaled(across.factor, y_range)}
            if self.log:  # without nine grid lines per decade
                y_axis = {**y_axis, "grid": {"show": False}, "ticks": {"show": False}}
                y_scale = {**y_scale, "distr": 3}
            x_scale: uplot.Scale = {"time": False, "range": scaled(along.factor, x_range)}
            self.handle.scales = {"x": x_scale, "y": y_scale}
            self.handle.axes = axis(along.label, BELOW, 18, 45), y_axis
        nothing, arrays, before = np.full(len(x), math.nan), [], self.room
        self.room = {
            group: max(room, power_of_two(len(lines.get(group, ()))))
            for group, room in before.items()
        }
        for group, room in self.room.items():
            own = [across.factor * line for line in lines.get(group, ())]
            arrays += [*own, *[nothing] * (room - len(own))]
        self.handle.data = (along.factor * x, *arrays)
        if self.room != before:
            self.handle.series = self.series


def scaled(factor: float, ends: Range) -> Range:
    """A range in other units."""
    return float(factor * ends[0]), float(factor * ends[1])


def power_of_two(count: int) -> int:
    """The smallest power of two that is at least `count`, and at least 1."""
    return 1 << max(count - 1, 0).bit_length()


def axis(label: str, size: int, label_size: int, space: int) -> uplot.Axis:
    """An axis of fixed size [px], so that labels can be placed on lines."""
    return {
        "label": label,
        "size": size - label_size,
        "labelSize": label_size,
        "labelGap": 0,
        "gap": 3,
        "space": space,
        "ticks": {"size": 5},
        **FONTS,
    }


def marks(x: np.ndarray, points: Iterable[tuple[float, float]]) -> np.ndarray:
    """An array (n,) with the second number of each point at the first one in x (n,), nan
    elsewhere."""
    y = np.full(len(x), math.nan)
    for at, value in points:
        y[np.searchsorted(x, at)] = value
    return y


def dot(fill: str, stroke: str, size: int) -> uplot.Series:
    """Round marks instead of a line."""
    point: uplot.Series_Points = {
        "show": True, "fill": fill, "stroke": stroke, "size": size, "width": 1.5
    }  # fmt: skip
    return {"stroke": MARK, "width": 0, "points": point}


def apart(places: list[float], least: float) -> list[float]:
    """Ascending positions, moved up until their distances are at least `least`."""
    moved: list[float] = []
    for place in places:
        moved.append(max(place, moved[-1] + least) if moved else place)
    return moved
