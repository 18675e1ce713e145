"""Texts of the page as HTML: the state of the equilibrium, the legend and the pace."""

from html import escape

from beamviz.beam import Units
from beamviz.drawing import colours
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.text import duration, significant
from beamviz.errors import NoEquilibrium
from beamviz.explorer.jobs import SolverAnswer
from beamviz.exports.html_page import TIME

SMALL = "font-size:.8em;line-height:1.5;margin:.2em .75em .3em"
GOOD, AMBER, BAD = "#2b8a3e", "#b36b00", "#d9480f"
FADED = "opacity:.65"
ROUNDING = 1e-9  # [%]
NOTHING = 1e-8  # [lengths of the beam] a smaller displacement is none
MIN_HEIGHT = "4.25em"  # of three lines, so that nothing below moves when the text changes
PACE = f"font-size:.8em;margin:-.3em .75em .5em;{FADED}"


def small(content: str, role: str = "") -> str:
    """HTML in small letters, with the margins of the panels."""
    attribute = f' role="{role}"' if role else ""
    return f'<div{attribute} style="{SMALL}">{content}</div>'


def coloured(content: str, colour: str) -> str:
    """HTML in bold letters of a colour."""
    return f'<b style="color:{colour}">{content}</b>'


def equilibrium_state(answer: SolverAnswer) -> str:
    """The state of the equilibrium in up to three lines: stable, with a caution in amber where it
    is far from a real beam; or what is wrong."""
    if answer.shapes and not answer.warning:
        title, text, colour = "Stable equilibrium", stretch_text(answer.shapes), GOOD
        if answer.caution:
            text, colour = answer.caution, AMBER
    else:
        title, _, text = answer.warning.partition("\n")
        colour = BAD
        if answer.error and not isinstance(answer.error, NoEquilibrium):
            text = answer.message
    return (
        f'<div role="status" style="border-left:4px solid {colour};padding:.1em .6em;'
        f"min-height:{MIN_HEIGHT};margin:.2em .75em .5em;font-size:.85em;line-height:1.35"
        f'"><b>{escape(title)}</b>'
        + (f'<br><span style="{FADED}">{escape(text)}</span>' if text else "")
        + "</div>"
    )


def stretch_text(shapes: SampledModes) -> str:
    """How much the rotation stretches the beam, or where the tip of a bent one is."""
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


def faded(content: str) -> str:
    """Content that belongs to an earlier answer."""
    return f'<div style="opacity:.35">{content}</div>' if content else ""


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
        '<div aria-label="legend" style="font-size:.8em;margin:.2em .75em .6em">'
        f'<span style="{FADED}">{title}</span>'
        f'<div style="height:.7em;border-radius:3px;background:{colours.gradient(anchors)}"></div>'
        '<div style="display:flex;justify-content:space-between">'
        + "".join(f"<span>{end}</span>" for end in ends)
        + "</div></div>"
    )


def pace(rate: float, units: Units | None) -> str:
    """How much time [T*] passes in one second, `rate`, in the units of the beam."""
    if units:
        faster = rate * units.time
        slower = faster < 1
        ratio = f"{significant(1 / faster if slower else faster, 3)} times"
        much = f"{ratio} {'slower' if slower else 'faster'}"
        return f'<div style="{PACE}">one second here = {duration(rate, units)} ({much})</div>'
    return f'<div title="{TIME}" style="{PACE}">one second here = {duration(rate, None)}</div>'
