"""Theme and style sheet of the page, and the style of its live charts."""

from html import escape

import numpy as np
from viser import ClientHandle, GuiApi, GuiUplotHandle, ViserServer, uplot

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


def add_plot(
    gui: GuiApi,
    data: tuple[np.ndarray, ...],
    styles: tuple[uplot.Series, ...],
    axes: tuple[uplot.Axis, ...],
    height: int,
    *,
    right: int = 12,
    visible: bool = True,
) -> GuiUplotHandle:
    """A chart without interaction, `height` [px] in all."""
    return gui.add_uplot(
        data,
        styles,
        scales=scales((0.0, 1.0), (0.0, 1.0)),
        axes=axes,
        legend={"show": False},
        cursor={"drag": {"x": False, "y": False}, "points": {"show": False}},
        padding=(ABOVE, right, 0, 0),
        height=height,
        visible=visible,
    )


def scales(x: tuple[float, float], y: tuple[float, float]) -> dict[str, uplot.Scale]:
    """The ranges of both axes; the automatic ones are wrong where values are missing."""
    return {"x": {"time": False, "range": x}, "y": {"range": y}}


def axes(along: str, across: str) -> tuple[uplot.Axis, ...]:
    """The two axes with their labels, of fixed size so that labels can be placed on lines."""
    return (
        {
            "label": along,
            "size": BELOW - 18,
            "labelSize": 18,
            "labelGap": 0,
            "gap": 3,
            "space": 45,
            "ticks": {"size": 5},
            **FONTS,
        },
        {
            "label": across,
            "size": LEFT - 14,
            "labelSize": 14,
            "labelGap": 0,
            "gap": 3,
            "space": 28,
            "ticks": {"size": 5},
            **FONTS,
        },
    )


def dot(fill: str, stroke: str, size: int) -> uplot.Series_Points:
    """A round mark."""
    return {"show": True, "fill": fill, "stroke": stroke, "size": size, "width": 1.5}


def apart(places: list[float], least: float) -> list[float]:
    """Ascending positions, moved up until their distances are at least `least`."""
    moved: list[float] = []
    for place in places:
        moved.append(max(place, moved[-1] + least) if moved else place)
    return moved
