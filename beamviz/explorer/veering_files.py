"""The magnified veering as a file: a film in which what couples the two modes goes from none to the
whole and back, or a page without a network on which a slider does."""

import io
import json
from base64 import b64encode
from collections.abc import Callable, Iterable, Iterator
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from PIL import Image

from beamviz.errors import InvalidInput
from beamviz.explorer.computed_veering import (
    LociPair,
    ModeShape,
    Pairs,
    VeeringRequest,
    X,
    coupling_text,
    ends_of,
    outcome,
    parts_of,
    styles_of_components,
)
from beamviz.exports import FORMATS, write_film
from beamviz.files import check_suffix, replaced
from beamviz.plotting import COLOURS, FAINT, INK, KINDS, STYLE, figure_bytes, new_figure

STEPS = 20  # from no coupling to the whole
HELD = 8  # frames for which a film stays at either end
FRAME_RATE = 12.5  # [1/s]
WIDTH, HEIGHT = 8.0, 4.5  # [in]
PIXELS = 100  # of an inch of a film
STYLES = COLOURS | dict(KINDS.values()) | {"mixed": "#A3447E"}  # of lines
WHERE = "before", "at the event", "after"  # there are the shapes
PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<meta name="viewport" content="width=device-width">
<style>
body {{ margin: 16px auto; max-width: 1000px; padding: 0 12px; font: 16px system-ui, sans-serif;
  color: #222; background: #fff; }}
img {{ display: block; width: 100%; }}
label {{ display: flex; gap: 12px; align-items: center; }}
input {{ flex: 1; min-height: 44px; }}
</style></head><body>
<img id="picture" alt="">
<label>coupling <input id="part" type="range" min="0" max="{last}" value="{start}"></label>
<p id="told" role="status"></p>
<script>
const frames = {frames};
const [picture, part, told] = ["picture", "part", "told"].map(id => document.getElementById(id));
const show = () => {{
  const [text, source] = frames[part.value];
  picture.src = "data:image/svg+xml;base64," + source;
  picture.alt = told.textContent = part.ariaValueText = text;
}};
part.addEventListener("input", show);
show();
</script></body></html>
"""


def export_veering(
    path: Path, request: VeeringRequest, progress: Callable[[int], Iterable[int]] = range
) -> None:
    """Write the loci of a request from no coupling to the whole one as .html, a page, or as a film
    in one of FORMATS. progress: as in `beamviz.animate`. Raises InvalidInput where nothing couples
    them, and the errors of `loci`; the file is complete or untouched."""
    suffix = check_suffix(path, (".html", *FORMATS))
    if not request.couples:
        raise InvalidInput("the two modes are not coupled in this plane, or by this method")
    with replaced(path) as file:
        pairs = request.opening(STEPS)
        if suffix == ".html":
            file.write_text(page_of(request, pairs, progress), encoding="utf-8")
            return
        there = [0] * HELD + [*range(STEPS + 1)] + [STEPS] * HELD
        pictures = [picture(figure_of(request, pairs, k)) for k in progress(STEPS + 1)]
        order = [*there, *range(STEPS - 1, 0, -1)]
        frames: Iterator[Image.Image] = (pictures[k] for k in order)
        write_film(file, frames, FRAME_RATE, pictures[::5])


def page_of(request: VeeringRequest, pairs: Pairs, progress: Callable[[int], Iterable[int]]) -> str:
    """The page, which begins with the coupling of the beam."""
    frames = []
    for k in progress(len(pairs)):
        source = b64encode(figure_bytes(figure_of(request, pairs, k), "svg")).decode()
        frames.append((told(request, pairs[k]), source))
    nearest = np.argmin([abs(pair.coupling - request.coupling) for pair in pairs])
    title = escape(f"{' and '.join(request.event.branches)}: beamviz")
    return PAGE.format(
        title=title, last=len(pairs) - 1, start=int(nearest), frames=json.dumps(frames)
    )


def told(request: VeeringRequest, pair: LociPair) -> str:
    """The coupling and what the two loci do with it."""
    return f"{coupling_text(pair.coupling, request)}: {outcome(pair, request)}"


def picture(figure: Figure) -> Image.Image:
    """A frame of a film."""
    buffer = io.BytesIO()
    with rc_context(STYLE):
        figure.savefig(buffer, format="png", dpi=PIXELS)
    return Image.open(buffer).convert("RGB")


def figure_of(request: VeeringRequest, pairs: Pairs, k: int) -> Figure:
    """The loci of pair k over those without the coupling, and the shapes beside them."""
    pair, (along, across) = pairs[k], request.chart.measures
    with rc_context(STYLE):
        figure = new_figure(WIDTH, HEIGHT)
        text = told(request, pair).partition(": ")
        figure.text(0.02, 0.94, text[0], weight="bold", size=11, va="center")
        figure.text(0.02, 0.88, text[2], va="center")
        axes = figure.add_axes((0.09, 0.13, 0.46, 0.67))
        axes.set(xlabel=along.label, ylabel=across.label)
        axes.set_ylim(*(across.factor * end for end in ends_of(pairs)))
        axes.margins(x=0)
        for line in pairs[0].lines:
            frequency = across.factor * line.frequency
            axes.plot(along.factor * pairs[0].values, frequency, color=FAINT, lw=0.8, ls="--")
        for line in pair.lines:
            for first, last, family, _ in line.runs:
                part = slice(first, last + 1)
                x, y = along.factor * pair.values[part], across.factor * line.frequency[part]
                axes.plot(x, y, color=STYLES[family], lw=2)
        if pair.event and pair.event.kind == "veering":
            at, gap = along.factor * pair.event.at, across.factor * np.array(pair.gap)
            axes.plot([at, at], gap, color=INK, lw=1.2, marker="_", zorder=4)
        draw_shapes(figure, request, pair)
    return figure


def draw_shapes(figure: Figure, request: VeeringRequest, pair: LociPair) -> None:
    """The shapes of the upper and of the lower branch, with their shares as bars and in percent."""
    for row, k in enumerate(pair.upper_first):
        for column, shape in enumerate(pair.shapes[k]):
            left, bottom = 0.6 + 0.135 * column, 0.52 - 0.37 * row
            axes = figure.add_axes((left, bottom, 0.115, 0.2))
            draw_shape(axes, shape, request)
            if not row:
                axes.set_title(WHERE[column], size=8)


def draw_shape(axes: Any, shape: ModeShape, request: VeeringRequest) -> None:
    """A shape along the beam, and below it the shares of its energy."""
    axes.set(xlim=(0, 1), ylim=(-2.1, 1.1), xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_visible(False)
    if shape.mode < 0:
        return
    components = shape.displacement.T
    names = styles_of_components(in_space=len(components) == 3)
    axes.plot([0, 1], [0, 0], color=FAINT, lw=0.6)
    for name, component in zip(names, components, strict=True):
        axes.plot(X, component, color=STYLES[name], lw=1.5)
    parts, start = parts_of(shape, request), 0.0
    for name, share in parts.items():
        axes.barh(-1.5, share, left=start, height=0.22, color=STYLES[name])
        start += share
    name, share = max(parts.items(), key=lambda part: part[1])
    axes.text(0.5, -2.1, f"{100 * share:.0f} % {name}", size=7, ha="center", color=INK)
