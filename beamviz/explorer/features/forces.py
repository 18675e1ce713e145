"""The legend of the forces in the scene: what the band and the arrows of each colour are, and how
large the greatest of them is. In a motion in time there is a bar of the energies, too."""

from functools import lru_cache
from html import escape

import numpy as np

from beamviz.drawing import colours
from beamviz.drawing.forces import CORIOLIS, EULER, PULL, SOFTENING, ForceSource
from beamviz.drawing.text import energy_text, force_text, significant
from beamviz.dynamics import Motion
from beamviz.explorer import page
from beamviz.explorer.feature import Feature
from beamviz.explorer.features.motion import played_motion
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.state import Case
from beamviz.units import Units

ROWS, BAR = "forces-rows", "energy-bar"  # ids of places over the scene, which `page.html` has
WORDS = {  # of each kind: its name, and what it does
    PULL: ("pull outward", "makes the tension"),
    SOFTENING: ("pull aside", "helps it to bend: softens"),
    CORIOLIS: ("Coriolis", "turns aside what moves"),
    EULER: ("Euler", "acts against a change of the speed"),
}
TENSION = "tension", "holds it straight: stiffens"
COMPRESSION = "compression", "helps it to buckle"
PRESSES = "presses the beam on its hub"
AT_REST = "At rest: nothing pulls on the beam."
IN_ROWS = "Forces are drawn on a beam alone, not on all modes."
HELD = "Forces are drawn when you let go."
NO_STIFFENING = "Stiffening is off: no tension, and no pull that makes it."
NO_SOFTENING = "Spin softening is off: no pull aside."
UNIT = "Forces in E I / L²"
SEEN = 0.02  # of the height of the band: a lower one is not told
LEAST_DRIFT = 1e-3  # [%] of the sum of the energies
NO_ENERGY = 1e-9  # [E I / L] of which no drift is told


class ForcesLegend(Feature):
    """Said while the scene shows forces; the switch itself is in Picture, as that of nodes."""

    style = "forces.css"

    def content(self, snapshot: Snapshot) -> Content:
        if not snapshot.state.view.forces:
            return page.html(ROWS, "") | page.html(BAR, "")
        return page.html(ROWS, legend(snapshot)) | page.html(BAR, energy_bar(snapshot))


def legend(snapshot: Snapshot) -> str:
    """The rows (HTML), or why there are no forces."""
    picture, answer = snapshot.picture, snapshot.answer
    if picture.drawn.in_rows:
        return f"<p>{IN_ROWS}</p>"
    source = picture.drawn.forces
    if source is None:
        return f"<p>{HELD}</p>" if picture.film else ""
    beam = picture.modes.beam
    notes = []
    if answer and not picture.film:
        notes = left_out(answer.request, beam.gamma)
    rows = rows_of(source, beam.units)
    if not (rows or notes):
        return f"<p>{AT_REST}</p>"
    if rows and (beam.units is None or beam.units.force is None):
        notes.append(UNIT)
    return "".join(rows) + "".join(f"<p>{note}</p>" for note in notes)


def rows_of(source: ForceSource, units: Units | None) -> list[str]:
    """A row for the band and for each kind of arrows that there is."""
    rows, (least, most) = list[str](), source.tensions
    seen = SEEN * source.greatest_tension
    if most > seen:
        rows.append(row("▬", colours.TENSION, *TENSION, greatest(most, units)))
    if -least > seen:
        rows.append(row("▬", colours.COMPRESSION, *COMPRESSION, greatest(-least, units)))
    for kind, sizes in source.largest.items():
        name, does = WORDS[kind]
        if kind == PULL and -least > most:
            does = PRESSES
        rows.append(row("➞", colours.FORCES[kind], name, does, greatest(max(sizes), units)))
    return rows


def greatest(force: float, units: Units | None) -> str:
    """A greatest force, without the unit that is told once for all."""
    return f"≤ {force_text(force, units).removesuffix(' E I / L²')}"


def row(sign: str, colour: colours.RGB, name: str, does: str, most: str) -> str:
    """A sign in its colour, what it is, what that does, and its greatest value."""
    swatch = f'<i style="color:rgb{colour}" aria-hidden="true">{sign}</i>'
    return f"<div>{swatch}<b>{name}</b> <span>{does}</span> <small>{escape(most)}</small></div>"


def left_out(case: Case, gamma: float) -> list[str]:
    """What the model of a case leaves out while the beam turns."""
    if not gamma:
        return []
    notes = [] if case.options["stiffening"] else [NO_STIFFENING]
    chordwise = case.options["plane"] != "flapwise"
    return notes if case.options["softening"] or not chordwise else [*notes, NO_SOFTENING]


# The energies


@lru_cache(16)
def energies_of(motion: Motion) -> np.ndarray:
    """The energies (3, n) over the times of a motion, in the order of `colours.ENERGIES`, none
    below 0: the centrifugal one is 0 where the masses are as far out as they get."""
    kinetic, strain, centrifugal = motion.energies
    squared = np.maximum(motion.gamma**2, 1e-300)
    moment = -2 * centrifugal / squared  # of inertia about the axis, with the body on the beam
    farthest = np.zeros(len(moment))
    on_beam = np.array([motion.has_mass(float(t)) for t in motion.t])
    for which in (on_beam, ~on_beam):
        farthest[which] = moment[which].max(initial=0.0)
    return np.stack([kinetic, strain, motion.gamma**2 * (farthest - moment) / 2])


def energy_bar(snapshot: Snapshot) -> str:
    """The energies at the moment of the motion that the scene plays (HTML), as parts of a bar whose
    end is their greatest sum, with a mark at the sum at the start; "" without a motion."""
    found = played_motion(snapshot)
    if found is None:
        return ""
    motion = found.motion
    over_time = energies_of(motion)
    sums = over_time.sum(axis=0)
    now = [np.interp(snapshot.clock.moment, motion.t, row) for row in over_time]
    most = max(float(sums.max()), NO_ENERGY)
    parts = zip(colours.ENERGIES.items(), now, strict=True)
    bar, keys = "", ""
    for (name, colour), energy in parts:
        bar += f'<i style="width:{100 * energy / most:.1f}%;background:rgb{colour}"></i>'
        keys += f'<span><i style="background:rgb{colour}"></i>{name}</span>'
    start = f'<b style="left:{100 * sums[0] / most:.1f}%"></b>'
    text = f"energy {energy_text(sum(now), found.units)}{drift(sums[0], sum(now))}"
    return (
        f'<div>{escape(text)}</div><div class="energy" aria-hidden="true">{bar}{start}</div>'
        f'<div class="keys">{keys}</div>'
    )


def drift(first: float, now: float) -> str:
    """How much a sum differs from that at the start."""
    if first < NO_ENERGY:
        return ""
    change = 100 * (now / first - 1)
    if abs(change) < LEAST_DRIFT:
        return ", as at the start"
    return f", {'+' if change > 0 else '−'}{significant(abs(change), 2)} % since the start"
