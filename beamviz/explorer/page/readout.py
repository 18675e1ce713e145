"""What the panel tells: the state, the table of modes and the legend, as HTML."""

import math
from html import escape

from beamviz.beam import Units
from beamviz.display_units import frequencies
from beamviz.display_units import significant as digits
from beamviz.drawing import colours
from beamviz.drawing.modes import Shapes
from beamviz.explorer.page import html as tables
from beamviz.explorer.solver_job import Answer
from beamviz.messages import duration
from beamviz.solver import Solution

GOOD, BAD = "#2b8a3e", "#d9480f"
FADED = "opacity:.65"
ROUNDING = 1e-9  # [%]
NOTHING = 1e-8  # [lengths of the beam] a smaller displacement is none
LINES = "4.25em"  # room for three, so that nothing below moves when there are more than two
PACE = f"font-size:.8em;margin:-.3em .75em .5em;{FADED}"
TIME = "T* = √(ρ A L⁴ / E I), the time unit of the beam"


def state(answer: Answer) -> str:
    """One or two lines: all is well, or what is wrong in full."""
    if answer.shapes and not answer.words:
        title, text, colour = "Stable equilibrium", wellbeing(answer.shapes), GOOD
    else:
        title, _, rest = answer.words.partition("\n")
        text, colour = rest if answer.message == answer.words else answer.message, BAD
    return (
        f'<div role="status" style="border-left:4px solid {colour};padding:.1em .6em;'
        f"min-height:{LINES};margin:.2em .75em .5em;font-size:.85em;line-height:1.35"
        f'"><b>{escape(title)}</b>'
        + (f'<br><span style="{FADED}">{escape(text)}</span>' if text else "")
        + "</div>"
    )


def wellbeing(shapes: Shapes) -> str:
    """What the rotation does to the beam."""
    beam, change = shapes.beam, 100 * (shapes.centreline[-1, 0] - 1)
    if beam.gamma == 0:
        return "at rest: no rotation"
    if abs(change) < ROUNDING:
        return "in this model the rotation does not stretch the beam"
    turning = f"{beam.units.rpm(beam.gamma):.4g} rpm; " if beam.units else ""
    longer = "longer" if change > 0 else "shorter"
    far = f" ({abs(change) / 100 * 1000 * beam.units.length:.2g} mm)" if beam.units else ""
    return f"{turning}the rotation makes the beam {digits(abs(change), 2)} % {longer}{far}"


def faded(content: str) -> str:
    """Content that no longer holds."""
    return f'<div style="opacity:.35">{content}</div>' if content else ""


def table(solution: Solution, shown: list[int]) -> str:
    """The modes: number, label, kind, frequency, error; the ones shown are marked."""
    across = frequencies(solution.beam.units)
    heads = ["", "mode", "kind", f'<span title="{TIME}">{across.label}</span>', "error"]
    rows = [row(solution, k) for k in range(len(solution.labels))]
    return tables.table("modes", heads, rows, marked=shown)


def row(solution: Solution, k: int) -> list[str]:
    """One mode of the table, in the units of its beam."""
    cells = [str(k + 1), f"<b>{solution.labels[k]}</b>", solution.families[k]]
    units = solution.beam.units
    if math.isfinite(solution.frequencies[k]):
        factor = frequencies(units).factor
        error = factor * solution.errors[k]
        cells += [significant(factor * solution.frequencies[k], error), f"{error:.0e}"]
    else:
        second, unit = (units.time, "s") if units else (1.0, "T*")
        rate = f"{solution.growth_rates[k] / second:.4g} t/{unit}"
        grows = f'grows e<sup style="line-height:0">{rate}</sup>'
        cells += [grows, f"{solution.errors[k] / second:.0e}"]
    return cells


def significant(value: float, error: float) -> str:
    """`value` with the decimals its error leaves, at most six."""
    decimals = 6 if error <= 0 else min(max(-math.ceil(math.log10(2 * error)), 0), 6)
    return f"{value:.{decimals}f}"


def legend(name: str, largest: float, units: Units | None) -> str:
    """The colour map `name` with the values at its ends."""
    anchors: tuple[colours.RGB, ...]
    if name == "axial strain":
        ends = (f"\u2212{largest:.2g} shorter", "0", f"longer +{largest:.2g}")
        anchors, title = colours.DIVERGING, "axial strain, as drawn"
    else:
        far = f"{digits(1000 * largest * units.length, 2)} mm" if units else f"{largest:.2g} L"
        ends = ("0 at rest", "", far if largest > NOTHING else "")
        anchors, title = colours.SEQUENTIAL, "displacement, as drawn"
    return (
        '<div aria-label="legend" style="font-size:.8em;margin:.2em .75em .6em">'
        f'<span style="{FADED}">{title}</span>'
        f'<div style="height:.7em;border-radius:3px;background:{colours.gradient(anchors)}"></div>'
        '<div style="display:flex;justify-content:space-between">'
        + "".join(f"<span>{end}</span>" for end in ends)
        + "</div></div>"
    )


def pace(rate: float, units: Units | None) -> str:
    """How slow the clock is."""
    if units:
        faster = rate * units.time
        much = (
            f"{digits(1 / faster, 3)} times slower"
            if faster < 1
            else f"{digits(faster, 3)} times faster"
        )
        text = f"one second here = {duration(rate, units)} ({much})"
        return f'<div style="{PACE}">{text}</div>'
    return f'<div title="{TIME}" style="{PACE}">one second here = {duration(rate, None)}</div>'
