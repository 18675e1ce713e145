"""Texts and controls of the page as HTML: the equilibrium, the table of modes, sliders, tables."""

import json
import math
from collections.abc import Collection, Iterable, Mapping
from functools import lru_cache
from html import escape
from typing import Any

import numpy as np

from beamviz.beam import Units
from beamviz.drawing import colours
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.text import duration, frequencies, mode_value, significant
from beamviz.explorer.jobs import SolverAnswer
from beamviz.frequency_loci.identity import identify_modes
from beamviz.solver import Solution

ROUNDING = 1e-9  # [%] rounding error of a stretch
NOTHING = 1e-8  # [beam lengths] a smaller displacement is rounding error

# Controls


def attributes(**values: Any) -> str:
    """Attributes as HTML: aria_label= becomes aria-label, disabled=True has no value, None and
    False are left out, data_value= and values other than strings become JSON."""
    parts = []
    for name, value in values.items():
        name = name.strip("_").replace("_", "-")
        is_state = name.startswith(("aria-", "data-"))
        if value is None or (value is False and not is_state):
            continue
        if value is True and not is_state:
            parts.append(f" {name}")
        else:
            text = value if isinstance(value, str) and name != "data-value" else json.dumps(value)
            parts.append(f' {name}="{escape(text)}"')
    return "".join(parts)


def button(label: str, **values: Any) -> str:
    """A button: data_do= names its action or data_set= the value that it sets, to data_value=."""
    return f'<button type="button"{attributes(**values)}>{escape(label)}</button>'


def hint(name: str, text: str) -> str:
    """A question mark that opens an explanation of `name`; "" without one."""
    if not text:
        return ""
    key = "hint-" + "".join(c if c.isalnum() else "-" for c in name)
    mark = button("?", class_="hint", popovertarget=key, aria_label=f"About {name}")
    return f'{mark}<span popover id="{key}">{escape(text)}</span>'


def slider(key: str, label: str, help: str = "", **values: Any) -> str:
    """A slider with its label and a number field; values: min=, max=, step= of the slider."""
    box = attributes(id=f"{key}-field", data_set=key, aria_label=label, step="any")
    return (
        f'<div class="field" id="{key}-row"><span class="name">'
        f'<label for="{key}-slider" id="{key}-label">'
        f"{escape(label)}</label>{hint(label, help)}</span>"
        f'<input type="number"{box}><input type="range" id="{key}-slider"'
        f"{attributes(data_set=key, **values)}></div>"
    )


def checkbox(key: str, label: str, help: str = "") -> str:
    return (
        f'<div class="row"><label class="check"><input type="checkbox"{attributes(data_set=key)}>'
        f"{escape(label)}</label>{hint(label, help)}</div>"
    )


def options(choices: Iterable[str] | Mapping[Any, str]) -> str:
    """Options of a select element; choices: the values, or labels by value."""
    labels = choices.items() if isinstance(choices, Mapping) else ((one, one) for one in choices)
    return "".join(
        f"<option{attributes(value=value)}>{escape(one)}</option>" for value, one in labels
    )


def select(
    key: str, label: str, choices: Iterable[str] | Mapping[Any, str], help: str = "", id: str = ""
) -> str:
    """A select element with its label; choices: see `options`."""
    id = id or f"{key}-select"
    return (
        f'<div class="field"><span class="name"><label for="{id}">{escape(label)}</label>'
        f"{hint(label, help)}</span>"
        f'<select id="{id}" data-set="{key}">{options(choices)}</select></div>'
    )


def group(name: str, *parts: str) -> str:
    """A row of controls (HTML) with the accessible name `name`."""
    return f'<div class="row" role="group"{attributes(aria_label=name)}>{"".join(parts)}</div>'


# Texts


def note(text: str) -> str:
    """A paragraph about a missing or incomplete result; "" for no text."""
    return f'<p class="note">{escape(text)}</p>' if text else ""


def chart_tab(tools: str, chart: str, *lists: str, hidden: bool = True) -> str:
    """The skeleton of a tab: its controls (HTML), and by their ids its chart and its lists."""
    parts = "".join(f'<div id="{id}"></div>' for id in lists)
    return (
        f'<div class="chart-tab"><div class="tools">{tools}</div>'
        f'<div id="{chart}" class="chart" data-chart{" hidden" if hidden else ""}></div>'
        f'<div class="lists">{parts}</div></div>'
    )


def table(
    name: str, heads: Iterable[str], rows: Iterable[Iterable[str]], caption: str = "", **values: str
) -> str:
    """A table of cells (HTML) with the accessible name `name` and a caption (HTML)."""
    title = f"<caption>{caption}</caption>" if caption else ""
    head = "".join(f'<th scope="col">{one}</th>' for one in heads)
    body = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
    return (
        f"<table{attributes(aria_label=name, **values)}>{title}<thead><tr>{head}</tr></thead>"
        f"<tbody>{body}</tbody></table>"
    )


def colour_scale(title: str, anchors: tuple[colours.RGB, ...], *ends: str) -> str:
    """A colour map with its title and the values at its ends."""
    values = "".join(f"<span>{end}</span>" for end in ends)
    return (
        f'<span>{escape(title)}</span><div class="colours"'
        f' style="background:{colours.gradient(anchors)}"></div><div class="ends">{values}</div>'
    )


def legend(colouring: str, largest: float, units: Units | None) -> str:
    """The colours of the beam, up to the strain or displacement `largest`."""
    if colouring == "axial strain":
        ends = (f"\u2212{largest:.2g} shorter", "0", f"longer +{largest:.2g}")
        return colour_scale("axial strain, as drawn", colours.DIVERGING, *ends)
    far = f"{significant(1000 * largest * units.length, 2)} mm" if units else f"{largest:.2g} L"
    ends = ("0 at rest", "", far if largest > NOTHING else "")
    return colour_scale("displacement, as drawn", colours.SEQUENTIAL, *ends)


def pace(rate: float, units: Units | None) -> str:
    """The time [T*] that passes in one second on the screen, `rate`, in the units of the beam."""
    ratio = ""
    if units:
        faster = rate * units.time
        times = significant(1 / faster if 0 < faster < 1 else faster, 3)
        ratio = f" ({times} times {'slower' if faster < 1 else 'faster'})"
    return f"one second on screen = {duration(rate, units)}{ratio}"


# The equilibrium


def equilibrium_state(answer: SolverAnswer) -> str:
    """The state of the equilibrium in up to three lines: stable, with a caution if no real beam has
    it; or the warning."""
    if answer.shapes and not answer.warning:
        title, kind = "Stable equilibrium", "warn" if answer.caution else "good"
        text = answer.caution or stretch_text(answer.shapes)
    else:
        title, _, text = answer.warning.partition("\n")
        text = text if answer.message == answer.warning else answer.message
        kind = "bad"
    line = f"<br>{escape(text)}" if text else ""
    return f'<p class="state {kind}"><b>{escape(title)}</b>{state_switch(answer)}{line}</p>'


def state_switch(answer: SolverAnswer) -> str:
    """A button that replaces an unstable straight state by the stable one, or a bent one."""
    options, solution = answer.request.options, answer.solution
    if solution is None or solution.beam.spin_up:
        return ""
    if options["state"] == "straight" and solution.equilibrium.status == "unstable":
        return button("Show the stable state", data_set="state", data_value="stable")
    if solution.equilibrium.shape == "bent":
        return button("Show the straight state", data_set="state", data_value="straight")
    return ""


def stretch_text(shapes: SampledModes) -> str:
    """The elongation of the beam by rotation; for a bent beam the position of its tip."""
    beam, (x, y) = shapes.beam, shapes.centreline[-1]
    if shapes.centreline[:, 1].any():
        return f"bent: the tip is at ({x:.3f}, {y:.3f}) L from the clamp"
    change = 100 * (x - 1)
    if beam.gamma == 0:
        return "at rest: no rotation"
    if abs(change) < ROUNDING:
        return "in this model the rotation does not stretch the beam"
    speed = f"{beam.units.rpm(beam.gamma):.4g} rpm; " if beam.units else ""
    longer = "longer" if change > 0 else "shorter"
    length = f" ({abs(change) / 100 * 1000 * beam.units.length:.2g} mm)" if beam.units else ""
    return f"{speed}the rotation makes the beam {significant(abs(change), 2)} % {longer}{length}"


# The table of modes: a click on a row shows one mode alone, its slider mixes it with others

STRIP, INSET = 42, 4  # [px] length of the drawing of a beam with its nodes, and of its ends
MODES_HINT = (
    "The shapes of free vibration, each with its own frequency. Click one to see it alone; the"
    " sliders mix several. B: bending, S: stretching. The errors are estimates of the numerical"
    " error."
)
HEADING = (
    f'<div class="row"><h2>Natural modes</h2>{hint("natural modes", MODES_HINT)}'
    '<span class="space"></span>'
    f"{button('All', data_set='all_modes', aria_label='All modes, one above the other')}</div>"
    '<div id="mode-rows"></div>'
)
NO_MODES = '<p class="soft">No modes: this beam has no solution.</p>'
UNIT_HINT = hint("the unit", "× 1/T*, the beam's own unit of time: T* = √(ρ A L⁴ / E I).")


def mode_table(solution: Solution, shapes: SampledModes, shown: Collection[int]) -> str:
    """The table of the modes of a solution; those `shown` (0-based) are marked."""
    units, modes = solution.beam.units, identify_modes(solution)
    unit = "" if units else UNIT_HINT
    heads = ("mode", f"{frequencies(units).label} {unit}", "± error", "nodes", "amount")
    rows = "".join(
        f'<tr data-do="only" data-value="{k}"{" class=shown" if k in shown else ""}>'
        f"<td>{mode_button(k, label, solution.families[k], k in shown)}</td>"
        f"{numbers(solution, k, strip(shapes.nodes[k]))}<td>{amount(k, label)}</td></tr>"
        for k, label in enumerate(modes.labels)
    )
    return (
        '<table aria-label="modes"><thead><tr>'
        + "".join(f"<th>{head}</th>" for head in heads)
        + f'</tr></thead><tbody>{rows}</tbody></table><p class="soft">{escape(modes.summary)}</p>'
    )


@lru_cache(256)
def mode_button(k: int, label: str, family: str, shown: bool) -> str:
    """The button that shows mode k (0-based) alone, in the colour of its family."""
    return button(
        label, data_do="only", data_value=k, data_key=str(k + 1) if k < 9 else None,
        class_=f"mode {family}", aria_label=f"{label}, {family}", aria_pressed=shown,
    )  # fmt: skip


def numbers(solution: Solution, k: int, nodes: str) -> str:
    """The cells of a mode's frequency, its estimated error and its nodes, or of its growth rate."""
    value, error = mode_value(solution, k)
    if not math.isfinite(solution.frequencies[k]):
        return f'<td colspan="3">{escape(value)}</td>'
    digits = f"{error:.0e}".replace("e-0", "e-")
    return f"<td>{value}</td><td>{digits}</td><td>{nodes}</td>"


def strip(nodes: np.ndarray) -> str:
    """A drawing of the beam as a line with its nodes."""
    places = ", ".join(significant(float(x), 3) for x in nodes)
    dots = "".join(
        f'<circle cx="{INSET + (STRIP - 2 * INSET) * x:.1f}" cy="8" r="3"/>' for x in nodes
    )
    name = f"nodes at {places}" if places else "no nodes"
    return (
        f'<svg class="strip" role="img" width="{STRIP}" height="16" aria-label="{name}">'
        f"<title>{name}</title>"
        f'<path d="M{INSET} 3v10M{INSET} 8H{STRIP - INSET}"/>{dots}</svg>'
    )


@lru_cache(256)
def amount(k: int, label: str) -> str:
    """The slider of a mode's contribution to the motion."""
    key, name = f"share-{k}", f"Amount of {label}"
    values = attributes(data_set=key, id=key, min=0, max=1, step=0.05, aria_label=name)
    return f'<input type="range"{values}>'
