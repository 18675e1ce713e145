"""The legend of the forces in the scene: what the band and the arrows of each colour are, and how
large the greatest of them is."""

from html import escape

from beamviz.drawing import colours
from beamviz.drawing.forces import CORIOLIS, EULER, PULL, SOFTENING, ForceSource
from beamviz.drawing.text import force_text
from beamviz.explorer import page
from beamviz.explorer.feature import Feature
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.state import Case
from beamviz.units import Units

LEGEND = "forces-legend"  # id of its place over the scene, which `page.html` has
WORDS = {  # of each kind: its name, and what it does
    PULL: ("pull outward", "makes the tension"),
    SOFTENING: ("pull aside", "drives the swing further: softens"),
    CORIOLIS: ("Coriolis", "pushes aside what moves in the turning frame"),
    EULER: ("Euler", "holds back while the hub speeds up"),
}
TENSION = "tension", "pulls the beam straight: stiffens"
COMPRESSION = "compression", "pushes the beam aside"
AT_REST = "At rest: nothing pulls on the beam."
IN_ROWS = "Forces are drawn on a beam alone, not on all modes."
HELD = "Forces are drawn when you let go."
NO_STIFFENING = "Stiffening is off: no tension, and no pull that makes it."
NO_SOFTENING = "Spin softening is off: no pull aside."


class ForcesLegend(Feature):
    """Said while the scene shows forces; the switch itself is in Picture, as that of nodes."""

    style = "forces.css"

    def content(self, snapshot: Snapshot) -> Content:
        return page.html(LEGEND, legend(snapshot) if snapshot.state.view.forces else "")


def legend(snapshot: Snapshot) -> str:
    """The rows (HTML), or why there are no forces."""
    picture, answer = snapshot.picture, snapshot.answer
    if picture.drawn.in_rows:
        return f"<p>{IN_ROWS}</p>"
    source = picture.drawn.forces
    if source is None:
        return f"<p>{HELD}</p>" if picture.film else ""
    units = picture.modes.beam.units
    notes = []
    if answer and not picture.film:
        notes = left_out(answer.request, picture.modes.beam.gamma)
    rows = rows_of(source, units)
    if not (rows or notes):
        return f"<p>{AT_REST}</p>"
    return "".join(rows) + "".join(f"<p>{note}</p>" for note in notes)


def rows_of(source: ForceSource, units: Units | None) -> list[str]:
    """A row for the band and for each kind of arrows that there is."""
    rows = []
    if source.greatest_tension:
        pressed = source.at_root is not None and source.at_root < 0
        words, colour = (
            (COMPRESSION, colours.COMPRESSION) if pressed else (TENSION, colours.TENSION)
        )
        rows.append(row("▬", colour, *words, force_text(source.greatest_tension, units)))
    for kind, sizes in source.largest.items():
        rows.append(row("➞", colours.FORCES[kind], *WORDS[kind], force_text(max(sizes), units)))
    return rows


def row(sign: str, colour: colours.RGB, name: str, does: str, most: str) -> str:
    """A sign in its colour, what it is, what that does, and its greatest value."""
    swatch = f'<i style="color:rgb{colour}" aria-hidden="true">{sign}</i>'
    most = f"<small>≤ {escape(most)}</small>"
    return f"<div>{swatch}<b>{name}</b> <span>{does}</span> {most}</div>"


def left_out(case: Case, gamma: float) -> list[str]:
    """What the model of a case leaves out while the beam turns."""
    if not gamma:
        return []
    notes = [] if case.options["stiffening"] else [NO_STIFFENING]
    chordwise = case.options["plane"] != "flapwise"
    return notes if case.options["softening"] or not chordwise else [*notes, NO_SOFTENING]
