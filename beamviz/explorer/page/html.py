"""Texts of the page as HTML: the state of the equilibrium, the legend and the pace."""

import json
from collections.abc import Iterable, Mapping
from html import escape
from typing import Any

from beamviz.beam import Units
from beamviz.drawing import colours
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.text import duration, significant
from beamviz.explorer.jobs import SolverAnswer

ROUNDING = 1e-9  # [%] rounding error of a stretch
NOTHING = 1e-8  # [beam lengths] a smaller displacement is rounding error


def equilibrium_state(answer: SolverAnswer) -> str:
    """The state of the equilibrium in up to three lines: stable, with a caution if no real beam has
    it; or the warning."""
    if answer.shapes and not answer.warning:
        title, text, kind = "Stable equilibrium", stretch_text(answer.shapes), "good"
        if answer.caution:
            text, kind = answer.caution, "warn"
    else:
        title, _, text = answer.warning.partition("\n")
        kind = "bad"
        if answer.message != answer.warning:
            text = answer.message
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


def legend(name: str, largest: float, units: Units | None) -> str:
    """The colour map `name` with the values at its ends."""
    anchors: tuple[colours.RGB, ...]
    if name == "axial strain":
        ends = (f"\u2212{largest:.2g} shorter", "0", f"longer +{largest:.2g}")
        anchors, title = colours.DIVERGING, "axial strain, as drawn"
    else:
        far = f"{significant(1000 * largest * units.length, 2)} mm" if units else f"{largest:.2g} L"
        ends = ("0 at rest", "", far if largest > NOTHING else "")
        anchors, title = colours.SEQUENTIAL, "displacement, as drawn"
    return (
        f'<span>{title}</span><div class="colours" style="background:{colours.gradient(anchors)}">'
        '</div><div class="ends">' + "".join(f"<span>{end}</span>" for end in ends) + "</div>"
    )


def pace(rate: float, units: Units | None) -> str:
    """The time [T*] that passes in one second on the screen, `rate`, in the units of the beam."""
    ratio = ""
    if units:
        faster = rate * units.time
        times = significant(1 / faster if 0 < faster < 1 else faster, 3)
        ratio = f" ({times} times {'slower' if faster < 1 else 'faster'})"
    return f"one second on screen = {duration(rate, units)}{ratio}"


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
    about = attributes(popovertarget=key, aria_label=f"About {name}")
    return (
        f'<button type="button" class="hint"{about}>?</button>'
        f'<span popover id="{key}">{escape(text)}</span>'
    )


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
    """A checkbox with its label."""
    return (
        f'<div class="row"><label class="check"><input type="checkbox"{attributes(data_set=key)}>'
        f"{escape(label)}</label>{hint(label, help)}</div>"
    )


def options(choices: Iterable[str] | Mapping[str, str]) -> str:
    """Options of a select element; choices: the values, or labels by value."""
    labels = choices if isinstance(choices, Mapping) else {one: one for one in choices}
    return "".join(
        f"<option{attributes(value=value)}>{escape(one)}</option>" for value, one in labels.items()
    )


def select(
    key: str, label: str, choices: Iterable[str] | Mapping[str, str], help: str = "", id: str = ""
) -> str:
    """A select element with its label; choices: see `options`."""
    id = id or f"{key}-select"
    return (
        f'<div class="field"><span class="name"><label for="{id}">{escape(label)}</label>'
        f"{hint(label, help)}</span>"
        f'<select id="{id}" data-set="{key}">{options(choices)}</select></div>'
    )


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
    name: str, heads: Iterable[str], rows: Iterable[Iterable[object]], caption: str = ""
) -> str:
    """A table of cells (HTML) with the accessible name `name`."""
    title = f"<caption>{escape(caption)}</caption>" if caption else ""
    head = "".join(f'<th scope="col">{escape(one)}</th>' for one in heads)
    body = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
    return (
        f"<table{attributes(aria_label=name)}>{title}<thead><tr>{head}</tr></thead>"
        f"<tbody>{body}</tbody></table>"
    )
