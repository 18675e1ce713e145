"""The answer around the scene: state of the equilibrium, table of modes, legend, running jobs."""

import math
from collections.abc import Collection, Sequence
from functools import lru_cache
from html import escape

import numpy as np

from beamviz.drawing import colours
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.text import (
    described,
    duration,
    error_digits,
    five_digits,
    frequencies,
    length_text,
    measure,
    rounded_to_error,
    significant,
    stress_text,
)
from beamviz.drawing.tip_path import has_path
from beamviz.explorer import page
from beamviz.explorer.computed_motion import can_move, is_before
from beamviz.explorer.declarations import Tab
from beamviz.explorer.experiment import MotionState
from beamviz.explorer.feature import Feature, cancelled, fading, lacking, progress
from beamviz.explorer.features.comparison import not_drawn
from beamviz.explorer.features.lesson_player import OwnLessonState
from beamviz.explorer.features.lessons import LessonState
from beamviz.explorer.features.loci_chart import LociTab
from beamviz.explorer.features.motion import modes_beside, phase_words, played_motion
from beamviz.explorer.features.run_up import RunUpState
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.solutions import SOLUTION, SolverAnswer
from beamviz.explorer.state import NO_COMPARISON, Case, State
from beamviz.explorer.view import Picture
from beamviz.frequency_loci.identity import identify_modes
from beamviz.lessons import NAMES
from beamviz.solver import Solution
from beamviz.units import Units

STRETCH_ROUNDING = 1e-9  # [%] rounding error of a stretch
NOTHING = 1e-8  # [beam lengths] a smaller displacement is rounding error
STRIP, INSET = 84, 4  # [px] length of the drawing of a beam with its nodes, and of its ends
NEUTRAL = "neutral"  # a mode that neither vibrates nor grows: at a limit of stability
FAMILY_NAMES = {"B": "bending", "S": "stretching", "F": "flap", "L": "lag"}  # by first letters
NO_MODES = '<p class="soft">No modes: this beam has no solution.</p>'
TIP_PATH = '<div class="tip-path">tip\'s path</div>'
RESPONSE = "Forced response. Click a mode to see its free vibration again."
IN_MOTION = "Motion in time, at its true size. " + page.button(
    "Back to the modes", data_do="motion.leave"
)
BUCKLED = "in the plane of rotation this straight beam has buckled: choose that plane to see it"
EARLIER_MOTION = "The motion before the last change: the new one is being computed."
EARLIER_PICTURE = "The beam before the last change: the new one is being computed."
HELD = "You hold the beam: let go, and its motion is computed."
LOCK_HINT = "Keep this time, so that a faster vibration looks faster; else it suits the motion"
UNIT_HINT = page.hint("the unit", "× 1/T*, the beam's own unit of time: T* = √(ρ A L⁴ / E I).")


class AnswerPanel(Feature):
    """What the page says of the beam shown, around the scene. With the case in which it opened it
    invites to drag something."""

    def content(self, snapshot: Snapshot) -> Content:
        faded = ("mode-rows", "equilibrium", "legend", "comparison", "method")
        return (
            answer_content(snapshot.answer, snapshot.picture, *motion_now(snapshot))
            | scene_content(snapshot.picture, snapshot.answer)
            | pace_content(snapshot)
            | self.caption_content(snapshot)
            | page.html("work", work(snapshot, self.visitor.tabs[snapshot.state.tab]))
            | fading(snapshot, [], *faded)
        )

    def caption_content(self, snapshot: Snapshot) -> Content:
        """The caption: a note about the picture, or until the first edit an invitation; after a
        scene was replaced, an offer to undo that."""
        state, replaced = snapshot.state, snapshot.state.replaced
        text = note(snapshot)
        runs_up = state.slice(RunUpState).run_speed is not None
        in_lesson = state.slice(OwnLessonState).shown_step is not None
        chosen = runs_up or in_lesson or state.comparison != NO_COMPARISON
        is_first = state.case == self.visitor.first.case and not (chosen or replaced)
        if is_first and not text:
            text = invitation(
                state.slice(LessonState).met, dragged(state), with_mass=has_mass(state.case)
            )
        undo = f"{escape(replaced)}{page.button('Undo', data_do='undo')}" if replaced else ""
        return page.html("scene-caption", text) | page.html("replaced", undo)


def note(snapshot: Snapshot) -> str:
    """What the scene shows in place of modes, or leaves out; "" for all modes of the beam."""
    picture = snapshot.picture
    if snapshot.state.slice(MotionState).hold:
        return HELD
    if picture.film:
        return EARLIER_MOTION if is_before(snapshot) else IN_MOTION
    return RESPONSE if picture.force is not None else picture_note(snapshot)


def motion_now(snapshot: Snapshot) -> tuple[str, str, bool]:
    """What the motion that the scene plays is at this moment, "" where there is none; and of the
    modes `Modes`."""
    found, beam = played_motion(snapshot), snapshot.beam
    if found is None or beam is None:
        return "", "", True
    moment = snapshot.clock.moment
    return phase_words(found, moment), *modes_beside(found, moment, beam)


def answer_content(
    answer: SolverAnswer | None, picture: Picture, motion: str, beside: str, present: bool
) -> Content:
    """The state of the equilibrium, or the motion that is played, and the table of modes; nothing
    before the first answer. motion, beside, present: see `motion_now`."""
    solved = answer.result if answer else None
    rows = NO_MODES if answer else ""
    if solved and solved.solution:
        rows = mode_table(solved.solution, solved, picture.shown, beside, present=present)
    stopped = page.props("playing", disabled=solved is None)
    text = status(answer, motion, present=present) if answer else ""
    return stopped | page.html("mode-rows", rows) | page.html("equilibrium", text)


def scene_content(picture: Picture, answer: SolverAnswer | None) -> Content:
    """The legend; the colours have no scale where the beam is grey."""
    drawn, units = picture.drawn, picture.modes.beam.units
    text = TIP_PATH if has_path(drawn) else ""
    text += legend(drawn.view.colouring, picture.colour_ends, units)
    return page.html("legend", "" if drawn.warning or answer is None else text)


def pace_content(snapshot: Snapshot) -> Content:
    """The time [T*] that passes in a second, and a lock that keeps it whatever moves."""
    state, units = snapshot.state, snapshot.picture.modes.beam.units
    locked, rate = state.rate is not None, snapshot.rate * state.view.pace
    lock = page.button(
        "locked" if locked else "lock",
        data_do="rate",
        data_value=None if locked else float(f"{snapshot.rate:.6g}"),
        aria_pressed=locked,
        title=LOCK_HINT,
        class_="quiet",
    )
    return page.html("pace-text", f"<span>{pace(rate, units)}</span>{lock}")


def work(snapshot: Snapshot, tab: Tab) -> str:
    """The jobs that have been running for long, with a button that cancels them, but for one that
    the open tab waits for and tells of; or else those cancelled, with one that restarts them."""
    jobs = snapshot.jobs.values()
    if any(job.slow for job in jobs):
        told = lacking(snapshot, tab.waits_for)
        if slow := [job for job in jobs if job.slow and job is not told]:
            return progress(slow)
    return cancelled(jobs)


def picture_note(snapshot: Snapshot) -> str:
    """What the picture does not show of the numbers beside it, "" if it shows all."""
    answer, picture = snapshot.answer, snapshot.picture
    if answer is None:
        return ""
    if snapshot.lateness(SOLUTION):
        return EARLIER_PICTURE
    if answer.beam is None:
        numbers = escape(described(picture.modes.beam))
        return f"Drawn with the nearest values in range: {numbers}."
    if answer.result is None:
        return "Drawn unloaded, as it is before it rotates."
    if (growing := picture.hidden_growth) is None:
        return second_note(snapshot)
    show = page.button("Show it", data_do="only", data_value=growing)
    return f"The modes shown do not grow; another one does. {show}"


def second_note(snapshot: Snapshot) -> str:
    """Why the beam compared with is not in the picture; "" if it is, or there is none."""
    second = snapshot.second
    if second is None or snapshot.picture.second is not None:
        return ""
    return escape(not_drawn(second, all_modes=snapshot.state.view.all_modes))


def has_mass(case: Case) -> bool:
    """Whether there is a body on the beam."""
    return bool(case.numbers["alpha"]) or bool(case.masses)


def dragged(state: State) -> str:
    """What a visitor is invited to drag: where a motion can begin the tip of the beam, else the
    mass, if any, or the speed, whose line is in the chart below or not."""
    if can_move(state) and not state.view.all_modes:
        return "the orange ball at the tip aside, and let it go"
    speed = (
        "the line of the speed in the chart below"
        if state.tab == LociTab.tab.key
        else "the slider of the speed"
    )
    return f"the mass along the beam, or {speed}" if has_mass(state.case) else speed


def invitation(met: frozenset[str], drag: str, *, with_mass: bool) -> str:
    """What this is, for a visitor who comes for the first time, and what to do: what to drag, and
    the first lesson whose challenge is not met."""
    mass = '<span class="wide">, with a mass on it</span>' if with_mass else ""
    lesson = ""
    if left := [name for name in NAMES if name not in met]:
        text = f"Start lesson {NAMES.index(left[0]) + 1}"
        lesson = page.button(text, data_do="lesson", data_value=left[0], class_="main")
    return (
        f'<span class="invitation">A beam on a turning hub{mass}: how does it vibrate, and what'
        " changes that?"
        f'<span class="more"><br>Drag {drag}.</span></span> {lesson}'
    )


# The scene: its legend and its pace


def legend(colouring: str, ends: Sequence[float], units: Units | None) -> str:
    """The colours of the beam, up to the strain or displacement at their end; of several beams,
    each of which has its own, from the least to the largest of these."""
    own = ", of each beam" if len(ends) > 1 else ""
    if colouring == "axial strain":
        most = " .. ".join(significant(end, 2) for end in ends)
        texts = (f"-{most} shorter", "0", f"longer +{most}")
        texts = ("shorter", f"0, at the ends {most}", "longer") if own else texts
        title = f"axial strain, as drawn{own}"
        return page.colour_scale(title, colours.DIVERGING, *texts) + stress_note(ends[-1], units)
    far = " .. ".join(length_text(end, units, 2) for end in ends)
    texts = ("0 at rest", "", far if ends[-1] > NOTHING else "")
    return page.colour_scale(f"displacement, as drawn{own}", colours.SEQUENTIAL, *texts)


def stress_note(strain: float, units: Units | None) -> str:
    """The stress of the largest axial strain that the colours stand for (HTML), beside the yield
    stress; "" where the material is not known."""
    if units is None or units.youngs_modulus is None:
        return ""
    stress, limit = units.youngs_modulus * strain, units.yield_stress
    text = f"axial stress ± {stress_text(float(f'{stress:.2g}'))}"  # in the digits of the strain
    if limit is None:
        return f'<div class="stress">{text}</div>'
    if stress > limit:
        return f'<div class="stress yields">{text}: yields at {stress_text(limit)}</div>'
    return f'<div class="stress">{text}, yields at {stress_text(limit)}</div>'


def pace(rate: float, units: Units | None) -> str:
    """The time [T*] that passes in one second on the screen, `rate`, in the units of the beam."""
    ratio = ""
    if units:
        faster = rate * units.time
        times = significant(1 / faster if 0 < faster < 1 else faster, 3)
        told = f"{times} times {'slower' if faster < 1 else 'faster'}"
        ratio = " (real time)" if times == "1" else f" ({told})"
    return f"one second on screen = {duration(rate, units)}{ratio}"


# The equilibrium


def status(answer: SolverAnswer, motion: str, *, present: bool) -> str:
    """The state of the equilibrium: stable, with any caution, or the warning; up to three lines.
    motion: that which the scene plays is told instead, with the state where that is `present`."""
    speed = ""
    if answer.beam and answer.beam.gamma:
        speed = measure("gamma", answer.beam.units).text(answer.beam.gamma, 4)
    if answer.result and not answer.warning:
        text = answer.caution or stretch_text(answer.result, speed)
        title, kind = "Stable equilibrium", "warn" if answer.caution else "good"
        if answer.solution and answer.solution.equilibrium.buckled_chordwise:
            title, kind, text = "Stable out of plane only", "bad", BUCKLED
    else:
        title, _, text = answer.warning.partition("\n")
        text = text if answer.message == answer.warning else answer.message
        kind = "bad"
    switch = state_switch(answer)
    if motion:
        text = {"good": f"about its {title.lower()}", "warn": text, "bad": title}[kind]
        title = motion
        if not present:
            text, kind, switch = "", "plays", ""
    line = f"<br>{escape(text)}" if text else ""
    return f'<p class="state {kind}"><b>{escape(title)}</b>{switch}{line}</p>'


def state_switch(answer: SolverAnswer) -> str:
    """A button that replaces an unstable straight state by the stable one, or a bent one, or one
    plane by both where a turned section couples them."""
    options, solution = answer.request.options, answer.solution
    if answer.beam and answer.beam.is_turned and options["plane"] != "both":
        return page.button("Both planes", data_set="plane", data_value="both")
    if solution is None or solution.beam.spin_up:
        return ""
    if options["state"] == "straight" and solution.equilibrium.status == "unstable":
        return page.button("Show the stable state", data_set="state", data_value="stable")
    if solution.equilibrium.shape == "bent":
        return page.button("Show the straight state", data_set="state", data_value="straight")
    return ""


def stretch_text(shapes: SampledModes, speed: str) -> str:
    """The elongation of the beam by rotation, of a real beam with its speed, if that is given; for
    a bent beam the position of its tip."""
    beam, (x, y) = shapes.beam, shapes.centreline[-1, :2]
    if shapes.centreline[:, 1].any():
        if beam.units is None:
            return f"bent: the tip is at ({x:.3f}, {y:.3f}) L from the clamp"
        along, aside = (length_text(float(place), beam.units, 3) for place in (x, y))
        return f"bent: the tip is {along} along and {aside} across from the clamp"
    change = 100 * (x - 1)
    if beam.gamma == 0:
        return "at rest: no rotation"
    if abs(change) < STRETCH_ROUNDING:
        return "in this model the rotation does not stretch the beam"
    at_speed = f"{speed}; " if beam.units and speed else ""
    longer = "longer" if change > 0 else "shorter"
    length = f" ({length_text(abs(change) / 100, beam.units, 2)})" if beam.units else ""
    return f"{at_speed}the rotation makes the beam {significant(abs(change), 2)} % {longer}{length}"


# The table of modes: a click on a row shows one mode alone, its slider mixes it with others


def mode_table(
    solution: Solution, shapes: SampledModes, shown: Collection[int], beside: str, *, present: bool
) -> str:
    """The table of the modes of a solution; those `shown` (0-based) are marked. beside: what they
    are those of, beside a motion; it is pale where they are not of its `present` moment."""
    units, modes = solution.beam.units, identify_modes(solution)
    shares, motions = shares_of_motion(solution), [""] * len(solution.s)
    if solution.in_plane_fraction is not None:
        motions = [f" of its {MOTIONS[k]}" for k in solution.larger_component]
    unit = "" if units else UNIT_HINT
    error = '<small class="all-digits">± error</small>'
    heads = ("mode", f"{frequencies(units).label} {unit}{error}", "amount")
    rows = "".join(
        f'<tr data-do="only" data-value="{k}" data-row="{label}"'
        f"{' class=shown' if k in shown else ''}>"
        f"<td>{mode_button(k, label, style_of(label, solution.families[k]), k in shown, shares[k])}"
        f"{strip(shapes.nodes[k], motions[k])}</td>"
        f"{numbers(solution, k)}<td>{amount(k, label)}</td></tr>"
        for k, label in enumerate(modes.labels)
    )
    head = f"<thead><tr><th>{'</th><th>'.join(heads)}</th></tr></thead>"
    own = page.attributes(aria_label="modes", class_=None if present else "pale")
    table = f"<table{own}>{head}<tbody>{rows}</tbody></table>"
    note = " ".join(text for text in (beside, modes.summary) if text)
    return f"{table}<p{page.attributes(class_='note-below', title=note or None)}>{escape(note)}</p>"


MOTIONS = "stretching", "lag", "flap"  # the components of a displacement in both planes


def shares_of_motion(solution: Solution) -> list[str]:
    """The shares of each mode's kinetic energy by component, as "62 % flap, 38 % lag"; "" where the
    beam bends in one plane."""
    in_plane, across = solution.in_plane_fraction, solution.bending_energy_fraction
    if in_plane is None:
        return [""] * len(across)
    shares = 100 * np.array([1 - across, in_plane - (1 - across), 1 - in_plane])  # (3, modes)
    texts = []
    for column in shares.T:
        order = [k for k in np.argsort(-column) if column[k] >= 0.5]
        texts.append(", ".join(f"{column[k]:.0f} % {MOTIONS[k]}" for k in order))
    return texts


def style_of(label: str, family: str) -> str:
    """The style of a mode of this label: its family, in place of bending flap or lag."""
    return FAMILY_NAMES[label[0]] if family == "bending" else family


@lru_cache(256)
def mode_button(k: int, label: str, family: str, shown: bool, shares: str) -> str:
    """The button that shows mode k (0-based) alone, in the colour of its family; its title has the
    shares of its motion."""
    own = {"data_do": "only", "data_value": k, "data_key": str(k + 1) if k < 9 else None}
    own |= {"class_": f"mode {family}", "type": "button", "aria_pressed": shown}
    own |= {"title": shares or None}
    name = f"<b>{plain_name(label)}</b><span>{escape(label)}</span>"
    return f"<button{page.attributes(**own)}>{name}</button>"


def plain_name(label: str) -> str:
    """The name of a mode for readers who do not know its label: "2nd bending" for B2."""
    family, number = FAMILY_NAMES[label[0]], label[1:]
    ending = {"1": "st", "2": "nd", "3": "rd"}.get(number, "th")
    return f"{number}{ending} {family}"


def numbers(solution: Solution, k: int) -> str:
    """The cell of a mode's frequency, and of its growth rate if it grows, with their estimated
    error."""
    units, found = solution.beam.units, ""
    frequency, rate = float(solution.frequencies[k]), float(solution.growth_rates[k])
    error = float(solution.errors[k])
    if math.isfinite(frequency):
        found = rounded(frequency, error, frequencies(units).factor)
    if rate > error:  # else it is none, to the digits known
        per_time, unit = (1 / units.time, "/s") if units else (1.0, "")
        found += rounded(rate, error, per_time, unit, "growth")
    return f"<td>{found or NEUTRAL}</td>"


def rounded(value: float, error: float, factor: float, unit: str = "", name: str = "") -> str:
    """A value, both it and its error times `factor`, with a unit, and a name below: in five digits,
    and to its error with that below, of which the page shows one."""
    value, error = factor * value, factor * error
    kind = ' class="grows"' if name else ""
    small = f"<small>{name}</small>" if name else ""
    brief = f"{five_digits(value, error)}{unit}{small}"
    named = f"{name} " if name else ""
    full = f"{rounded_to_error(value, error)}{unit}<small>{named}± {error_digits(error)}</small>"
    return (
        f'<div{kind}><span class="few-digits">{brief}</span>'
        f'<span class="all-digits">{full}</span></div>'
    )


def strip(nodes: np.ndarray, motion: str) -> str:
    """A drawing of the beam as a line with its nodes, those of a component of its motion where it
    bends in both planes."""
    places = ", ".join(significant(float(x), 3) for x in nodes)
    dots = "".join(
        f'<circle cx="{INSET + (STRIP - 2 * INSET) * x:.1f}" cy="8" r="3"/>' for x in nodes
    )
    name = f"nodes{motion} at {places}" if places else f"no nodes{motion}"
    return (
        f'<svg class="strip" role="img" width="{STRIP}" height="16" aria-label="{name}">'
        f"<title>{name}</title>"
        f'<path d="M{INSET} 3v10M{INSET} 8H{STRIP - INSET}"/>{dots}</svg>'
    )


@lru_cache(256)
def amount(k: int, label: str) -> str:
    """The slider of a mode's contribution to the motion."""
    key, name = f"share-{k}", f"Amount of {label}"
    values = page.attributes(data_set=key, id=key, min=0, max=1, step=0.05, aria_label=name)
    return f'<input type="range"{values}>'
