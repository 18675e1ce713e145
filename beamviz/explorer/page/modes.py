"""The table of modes: a click on a row shows one mode alone, its slider mixes it with others."""

import math
from collections.abc import Collection
from functools import lru_cache
from html import escape

import numpy as np

from beamviz.drawing.text import frequencies, mode_value, significant
from beamviz.explorer.jobs import SolverAnswer
from beamviz.explorer.page.html import attributes, button, hint
from beamviz.frequency_loci.identity import identify_modes
from beamviz.solver import Solution

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
SHOWN = ' class="shown"'
UNIT_HINT = hint("the unit", "× 1/T*, the beam's own unit of time: T* = √(ρ A L⁴ / E I).")


def mode_table(answer: SolverAnswer, shown: Collection[int]) -> str:
    """The table of the modes of an answer with a solution; those `shown` (0-based) are marked."""
    solution = answer.solution
    assert solution
    across = frequencies(solution.beam.units)
    unit = "" if solution.beam.units else UNIT_HINT
    heads = ("mode", f"{across.label} {unit}", "± error", "nodes", "amount")
    modes = identify_modes(solution)
    labels = modes.labels
    nodes = answer.shapes.nodes if answer.shapes else ()
    rows = "".join(
        f'<tr data-do="only" data-value="{k}"{SHOWN if k in shown else ""}>'
        f"<td>{mode_button(k, labels[k], solution.families[k], k in shown)}</td>"
        f"{numbers(solution, k, strip(nodes[k]) if k < len(nodes) else '')}"
        f"<td>{amount(k, labels[k])}</td></tr>"
        for k in range(len(labels))
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
    key = f"share-{k}"
    values = attributes(
        data_set=key, id=key, min=0, max=1, step=0.05, aria_label=f"Amount of {label}"
    )
    return f'<input type="range"{values}>'
