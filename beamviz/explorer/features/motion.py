"""The tab Motion: the beam is pulled and let go, spun up or stopped, and the equation of motion is
integrated in time; the scene plays it, and the tab shows the tip over time and its spectrum."""

import contextlib
import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from functools import lru_cache, partial
from html import escape
from typing import Any, NamedTuple

from beamviz.beam import Beam
from beamviz.drawing.text import (
    Measure,
    duration,
    length_text,
    lengths,
    measure,
    si_measure,
    significant,
    times,
)
from beamviz.errors import InvalidInput
from beamviz.explorer import page
from beamviz.explorer.computed_motion import (
    JOB,
    PULL_JOB,
    Computed,
    MotionRequest,
    PullRequest,
    answer_of,
    film_of,
    is_before,
    obstacle_of,
)
from beamviz.explorer.declarations import Tab
from beamviz.explorer.experiment import (
    ALTERNATIVES,
    RANGES,
    START_MODES,
    STOP,
    Experiment,
    MotionState,
    with_experiment,
)
from beamviz.explorer.feature import Feature, fading, waiting
from beamviz.explorer.film import time_text
from beamviz.explorer.jobs import Answer
from beamviz.explorer.motion_charts import notes, spectrum_data, strip_data
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Inputs, Snapshot
from beamviz.explorer.state import Case, State
from beamviz.explorer.view import Picture, with_film
from beamviz.explorer.visitor import Visitor
from beamviz.scene import clip
from beamviz.units import Units

SAME_SPEED = 1e-3  # of speeds that show the same frequencies: relative, or [1/T*]
PAUSED_DIGITS = 4  # after the point, of the moment of a pause in the address
PULL_HINT = (
    "A force across the beam that holds it until the motion begins; then it is let go. A force of"
    " E I / L² bends a beam at rest by about a third of its length. Or drag the beam in the scene."
)
HINTS = {
    "start": "How the beam begins: held by a force until it is let go, or swinging in its modes",
    **{
        name: f"Amplitude of the mode {name} with which it begins, its largest displacement"
        for name in START_MODES
    },
    "pull": PULL_HINT,
    "pull_at": "Where it is pulled: 1 is the tip; near the clamp, at 0, it hardly moves",
    "hub": "How the speed of the hub changes; the speed itself is set beside the scene",
    "within": "How long it takes to reach the speed, which is set beside the scene, from rest",
    "torque": "Turns the hub, against the beam that drags on it. Negative: slows it down",
    "inertia": "Moment of inertia of the hub: a heavy one hardly feels the beam swing",
    "body": "What happens to the concentrated mass; it is caught without a blow",
    "body_at": "When the mass is caught or dropped",
    "damping": "How fast vibrations fade: damping ratio of every mode; 0 % never, 100 % at once",
    "until": "Until when the motion is computed",
}
NAMES = {
    "start": "the beam",
    **{name: f"amplitude of {name}" for name in START_MODES},
    "pull": "pull F",
    "pull_at": "pull at x / L",
    "hub": "the hub",
    "within": "in the time",
    "torque": "torque",
    "inertia": "inertia of the hub",
    "body": "the mass",
    "body_at": "at the time",
    "damping": "damping ζ [%]",
    "until": "length of the motion",
}
UNSTIFFENED_HINT = (
    "The classical linear theory, drawn pale beside the true motion. In it bending does not draw"
    " the tip inward, so that nothing stiffens a fast beam, and it flies apart"
)
PRESETS = {
    "pull": ("Pull and let go", Experiment()),
    "spin-up": (
        "Spin up",
        Experiment(pull=0.0, hub="smooth", until=15.0, unstiffened=True, damping=0.0),
    ),
    "stop": ("Stop dead", Experiment(pull=0.0, hub="stop", until=10.0)),
    "modes": ("Swing in a mode", Experiment(start="modes", until=10.0)),
    "torque": ("Turn by a torque", Experiment(pull=0.0, hub="torque", until=10.0)),
    "catch": ("Catch the mass", Experiment(body="caught")),
    "drop": ("Drop the mass", Experiment(body="dropped")),
}
PERCENT = 100.0
TIMES = ("within", "body_at", "until")
# Symbol, unit without and with a size known, and the powers of length and time in it beside mass.
LOADS = {
    "pull": ("F", "E I / L²", "N", (1, -2)),
    "torque": ("M", "E I / L", "N m", (2, -2)),
    "inertia": ("J", "ρ A L³", "kg m²", (2, 0)),
}


def slider_of(name: str) -> str:
    low, high, step = RANGES[name].slider
    factor = PERCENT if name == "damping" else 1.0
    ends = {"min": factor * low, "max": factor * high, "step": factor * step}
    return page.slider(f"motion.{name}", NAMES[name], HINTS[name], **ends)


def select_of(name: str) -> str:
    return page.select(f"motion.{name}", NAMES[name], ALTERNATIVES[name], HINTS[name])


TOOLS = page.group(
    "Experiments",
    *(
        page.button(name, data_set="experiment", data_value=key)
        for key, (name, _) in PRESETS.items()
    ),
    id="motion-presets",
    class_="row choices",
)
TOOLS += '<p id="motion-words" role="status"></p>'
TOOLS += page.group(
    "Play",
    page.button("Play from the start", data_do="motion.begin"),
    '<span id="motion-shown" class="soft"></span>',
    id="motion-play-row",
)
TOOLS += page.slider("moment", "time", "The moment that the scene shows", min=0, max=1, step=0.01)
MORE = select_of("start") + "".join(map(slider_of, ("pull", "pull_at", *START_MODES)))
MORE += select_of("hub") + "".join(map(slider_of, ("within", "torque", "inertia")))
MORE += select_of("body") + slider_of("body_at")
MORE += page.checkbox("motion.unstiffened", "theory without stiffening beside it", UNSTIFFENED_HINT)
MORE += "".join(map(slider_of, ("damping", "until")))
MOTION_KINDS = {
    ".gif": "film (GIF)",
    ".html": "page (HTML)",
    ".svg": "chart (SVG)",
    ".csv": "CSV",
    ".npz": "NPZ",
}
MORE += page.group(
    "Download the motion",
    '<span class="soft">download</span>',
    *(page.button(n, data_do="export_motion", data_value=key) for key, n in MOTION_KINDS.items()),
    id="motion-files",
)
MORE += (
    '<div id="motion-file-work" class="row" hidden><span id="motion-file-state"></span>'
    f"{page.button('Cancel', data_do='cancel_export')}</div>"
)
CHARTS = "motion-chart", "motion-spectrum"
FIGURES = "".join(f'<div id="{id}" class="chart" data-chart hidden></div>' for id in CHARTS)
CONTENT = (
    '<div class="chart-tab motion-tab"><div class="beside">'
    f'<div class="tools">{TOOLS}</div>'
    f'<div class="tools lists"><div id="motion-settings" class="tools">{MORE}</div>'
    '<div id="motion-list"></div></div></div>'
    f'{page.waiting_place("motion-wait")}<div class="charts">{FIGURES}</div></div>'
)


class MotionTab(Feature):
    """The experiment, its charts, and the moment that the scene plays."""

    style = "motion.css"
    tab = Tab(
        "Motion",
        7,
        "Motion in time: pull the beam and let go, spin it up, stop it",
        CONTENT,
        (JOB,),
        view="in time",
    )
    state = MotionState

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        visitor.job(JOB, MotionRequest.computed)
        visitor.job(PULL_JOB, PullRequest.pulled)
        takes = {
            **dict.fromkeys(RANGES, float),
            **dict.fromkeys(ALTERNATIVES, str),
            "unstiffened": bool,
        }
        for name, kind in takes.items():
            self.page.on(f"motion.{name}", partial(self.edit, name), kind)
        self.page.on("experiment", self.begin, str)
        self.page.on("moment", self.go_to, float)
        self.page.on("motion.begin", lambda _: visitor.change(from_start))
        self.page.on("motion.less", lambda _: visitor.change(pulled_less))
        self.page.on("motion.leave", lambda _: visitor.change(lambda now: now.after("modes")))

    def edit(self, name: str, value: Any) -> None:
        """Set a value of the experiment, as displayed; instead of a number out of range the
        nearest one, which is said."""
        visitor = self.visitor
        with visitor.lock:
            if name in RANGES:
                shown, entered = display(name, visitor.state.case.units), value
                value = shown.plain(entered)
                ends = RANGES[name].limits
                if isinstance(value, float | int) and not ends[0] <= value <= ends[1]:
                    low, high = (significant(shown.factor * end, 6) for end in ends)
                    reason = f"{shown.label} = {entered:g}: must lie in {low} .. {high}"
                    self.page.say(f"{reason}; the nearest of these is taken", error=True)
            visitor.change(partial(with_value, name=name, value=value))

    def begin(self, name: Any) -> None:
        """Begin a motion, which plays unless the visitor prefers reduced motion."""
        if name in PRESETS:
            own = PRESETS[name][1]
            self.visitor.change(lambda state: begun(state, own))

    def go_to(self, value: Any) -> None:
        """Show another moment of the motion."""
        visitor = self.visitor
        with visitor.lock:
            moment = times(visitor.state.case.units).plain(value)
            moment = clip(moment, RANGES["until"].limits[1], visitor.clock.moment)
            visitor.change(
                lambda state: state.with_values(MotionState, moment=moment, in_motion=True)
            )

    @classmethod
    def linked(cls, state: State, names: Collection[str]) -> State:
        """Paused at the moment at which the sender of a link has stopped the motion."""
        stopped = "moment" in names and state.slice(MotionState).moment
        return state.changed("playing", False) if stopped else state

    def picture(self, inputs: Inputs, picture: Picture) -> Picture:
        """The motion in place of modes; the clock stops while the beam is in the hand."""
        state = inputs.state
        motion = state.slice(MotionState)
        if motion.hold:
            picture = replace(picture, plays=False)
        film = film_of(inputs)
        if film is None:
            return picture
        moment = inputs.clock.with_film(film, motion.moment).moment
        picture = with_film(picture, film, state.view, inputs.scale, moment)
        return replace(picture, moment=motion.moment)

    def react(self, snapshot: Snapshot, elapsed: float) -> None:
        """Keep the moment at which the motion was paused; one that goes on is at none."""
        before, playing = snapshot.state.slice(MotionState).moment, snapshot.state.view.playing
        if (film := snapshot.film) and playing != (before is None):
            shown = min(snapshot.clock.moment, film.until)  # the end is shown for a while
            moment = None if playing else round(shown, PAUSED_DIGITS)
            self.visitor.update(lambda now: with_moment(now, before, moment))

    def wanted(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """The motion while the scene shows it, or the tab is open; the pull of a beam in a hand."""
        state, motion = snapshot.state, snapshot.state.slice(MotionState)
        is_shown = motion.in_motion or motion.hold or state.tab == self.tab.key
        with contextlib.suppress(InvalidInput):  # the page says which number is out of range
            if motion.hold:
                return {PULL_JOB: PullRequest.of(state)}
            if is_shown:
                return {JOB: MotionRequest.of(state.case, motion.experiment)}
        return {JOB: None}

    def content(self, snapshot: Snapshot) -> Content:
        state, answer = snapshot.state, answer_of(snapshot)
        motion = state.slice(MotionState)
        return (
            values_content(motion.experiment, state.case.units)
            | words_content(motion.experiment, state.case, reason_of(snapshot))
            | chart_content(answer)
            | notes_content(answer, is_before(snapshot))
            | moment_content(answer, moment_of(snapshot))
            | preset_content(motion)
            | page.html("motion-shown", shown_instead(snapshot))
            | fading(snapshot, [JOB], *CHARTS, "motion-list")
            | waiting(snapshot, "motion-wait", self.tab)
        )


def shown_instead(snapshot: Snapshot) -> str:
    """What the scene shows in place of the motion; "" where it shows that, or there is none."""
    answer, motion = answer_of(snapshot), snapshot.state.slice(MotionState)
    if answer is None or answer.result is None or motion.in_motion or motion.hold:
        return ""
    instead = "natural modes" if snapshot.picture.force is None else "the response to the force"
    return f"until then the scene shows {instead}"


def with_moment(state: State, before: float | None, moment: float | None) -> State:
    """At a moment, unless the motion was moved to another one than that before."""
    same = state.slice(MotionState).moment == before
    return state.with_values(MotionState, moment=moment) if same else state


def with_value(state: State, name: str, value: Any) -> State:
    """With a motion in time of which one value differs."""
    return with_experiment(state, state.slice(MotionState).experiment.changed(name, value))


def pulled_less(state: State) -> State:
    """The edit that pulls a blade with a force that does not fold it."""
    experiment = state.slice(MotionState).experiment
    force = MotionRequest.of(state.case, experiment).bearable_force
    if force is None:  # it was pulled less meanwhile
        return state
    return with_value(state, "pull", force)


def begun(state: State, experiment: Experiment) -> State:
    state = with_experiment(state, experiment)
    return state if state.still else state.changed("playing", True)


def from_start(state: State) -> State:
    """The motion is played from its beginning: also where it is paused, or motion is reduced, as a
    visitor has asked for it."""
    return with_experiment(state, state.slice(MotionState).experiment).changed("playing", True)


def reason_of(snapshot: Snapshot) -> str:
    """Why there is no motion; "" while that is not known."""
    answer = answer_of(snapshot)
    known = answer is not None and answer.result is None and not answer.cancelled
    known = known and not is_before(snapshot)
    return answer.message if answer and known else ""


def played_motion(snapshot: Snapshot) -> Computed | None:
    """The computed motion that the scene plays; None for a beam in a hand, and for modes."""
    answer = answer_of(snapshot)
    found = answer.result if answer else None
    return found if found and snapshot.film is found.film else None


def phase_words(found: Computed, moment: float) -> str:
    """What a motion is at a moment, in words that change only where that does."""
    own, gamma = found.experiment, found.beam.gamma
    speed = measure("gamma", found.units).text(gamma, 4)
    text = f"The hub turns at {speed}" if gamma else "The hub rests"
    if own.hub == "torque":
        torque = display("torque", found.units).text(own.torque, 3)
        text = f"The hub turns freely, under a torque of {torque}"
    elif own.hub == "stop" and gamma:
        text = "The hub stops" if moment < STOP else "The hub has stopped"
    elif own.ramps and gamma and moment < own.within:
        text = f"The hub speeds up to {speed}"
    if own.body != "stays":
        text += f", mass {'on' if found.film.has_body(moment) else 'off'} the beam"
    return text


class ModesBeside(NamedTuple):
    """What the modes beside a motion are those of, in words of always the same length, and whether
    they are those of this moment. With a constant hub and mass the words are ""."""

    words: str
    are_present: bool


def modes_beside(found: Computed, moment: float, beam: Beam) -> ModesBeside:
    """Those of a beam. Frequencies are the same in both directions of rotation."""
    own, has_mass = found.experiment, found.film.has_body(moment)
    speed = abs(found.film.shapes.gamma(moment))
    same_speed = abs(speed - beam.gamma) <= SAME_SPEED * max(beam.gamma, 1.0)
    same_mass = bool(beam.alpha) == has_mass
    shown = f"at {measure('gamma', beam.units).text(beam.gamma, 4)}"
    mass = "with the mass" if beam.alpha else "without the mass"
    no = "" if same_speed and same_mass else "not "
    words = ""
    if own.hub != "constant" and own.body != "stays":
        words = f"Modes {shown} {mass}: {no}as now."
    elif own.hub != "constant":
        words = f"Modes {shown}: {no}the speed now."
    elif own.body != "stays":
        words = f"Modes {mass}: {no}as now."
    return ModesBeside(words, not no)


def moment_of(snapshot: Snapshot) -> float | None:
    """The moment that the scene shows; None where it shows no motion."""
    return snapshot.clock.moment if snapshot.film else None


# Displayed values

VALUES = tuple(f"motion.{name}" for name in (*RANGES, *ALTERNATIVES, "unstiffened"))
PLAYED = *CHARTS, "moment-row", "moment-slider", "moment-label", "motion-files"
WORDS = "motion-words", "motion-play-row", "motion-presets", "motion-settings"


def display(name: str, units: Units | None) -> Measure:
    """The display of a number of the experiment."""
    label = NAMES.get(name, name)
    if name in TIMES:
        own = times(units)
        return own._replace(label=f"{label} [{own.unit or 'T*'}]")
    if name == "damping":
        return Measure(label, "ζ", "%", PERCENT)
    if name in START_MODES:
        return lengths(label, "y", units)
    if name in LOADS and units and units.mass:
        symbol, _, quantity, powers = LOADS[name]
        one = units.mass * units.length ** powers[0] * units.time ** powers[1]
        return si_measure(label, symbol, quantity, one)
    if name in LOADS:
        symbol, dimensionless, *_ = LOADS[name]
        return Measure(f"{label} [{dimensionless}]", symbol)
    return Measure(label, "")


def values_content(experiment: Experiment, units: Units | None) -> Content:
    """The values of the controls, their units and ranges; those without effect are hidden."""
    content = Content()
    for name, own in RANGES.items():
        shown, key = display(name, units), f"motion.{name}"
        low, high, step = own.slider
        if name != "damping":
            low, high, step = shown.range(low, high, step, own.limits)
        else:
            low, high, step = (PERCENT * one for one in own.slider)
        limits = {"min": low, "max": high, "step": step}
        content |= page.props(f"{key}-slider", **limits)
        content |= page.html(f"{key}-label", escape(shown.label))
        content |= page.props(f"{key}-field", aria_label=shown.label)
        content |= page.props(key, data_unit=shown.unit)
        content |= page.value(key, float(f"{shown.factor * getattr(experiment, name):.6g}"))
    for name in (*ALTERNATIVES, "unstiffened"):
        content |= page.value(f"motion.{name}", getattr(experiment, name))
    in_modes = experiment.start == "modes"
    hidden = {
        "within": not experiment.ramps,
        "torque": experiment.hub != "torque",
        "inertia": experiment.hub != "torque",
        "pull": in_modes,
        "pull_at": not experiment.pulls,
        **dict.fromkeys(START_MODES, not in_modes),
        "body_at": experiment.body == "stays",
    }
    for name, is_hidden in hidden.items():
        content |= page.props(f"motion.{name}-row", hidden=is_hidden)
    return content


def words_content(experiment: Experiment, case: Case, reason: str) -> Content:
    """The experiment in a sentence, or the reason why it has no motion, with the controls that have
    an effect then."""
    obstacle = obstacle_of(case, experiment)
    words = escape(reason or in_words(experiment, case))
    if obstacle:
        words = f"{escape(obstacle.reason)} {obstacle.remedy}"
    of_beam = obstacle is not None and obstacle.of_beam
    content = page.html("motion-words", words)
    content |= page.props("motion-play-row", hidden=bool(obstacle or reason))
    for id in ("motion-presets", "motion-settings"):
        content |= page.props(id, hidden=of_beam)
    return content


def in_words(experiment: Experiment, case: Case) -> str:
    """What happens."""
    units, gamma = case.units, case.numbers["gamma"]
    known = isinstance(gamma, int | float) and math.isfinite(gamma)
    speed = measure("gamma", units).text(gamma, 4) if known else "its speed"
    if experiment.ramps:
        parts = [
            f"the hub speeds up from rest to {speed} within {duration(experiment.within, units)}"
        ]
    elif experiment.hub == "stop":
        parts = [f"the hub turns at {speed} and stops within {duration(STOP, units)}"]
    elif experiment.hub == "torque":
        torque = display("torque", units).text(experiment.torque, 3)
        first = "rests at first" if gamma == 0 else f"turns at {speed} at first"
        parts = [f"the hub {first}, and then turns freely under a torque of {torque}"]
    else:
        parts = ["the hub rests" if gamma == 0 else f"the hub turns at {speed}"]
    if experiment.modes:
        sizes = experiment.modes.items()
        swings = [f"{length_text(size, units, 3)} in {name}" for name, size in sizes]
        parts.append(f"the beam swings with {' and '.join(swings)}")
    if experiment.pulls:
        place = length_text(experiment.pull_at, units, 3)
        where = "at its tip" if experiment.pull_at == 1 else f"at {place}"
        parts.append(f"the beam is pulled {where} and let go")
    if experiment.body != "stays":
        at = time_text(experiment.body_at, units)
        parts.append(f"the mass is {experiment.body} at {at}")
    text = "; ".join(parts)
    if known and (experiment.ramps or experiment.hub == "stop") and gamma == 0:
        text += ". The speed is 0, so the hub rests: raise it"
    return f"{text[0].upper()}{text[1:]}."


# The charts


@lru_cache(16)  # for several visitors: 1 ms of each frame of a motion that plays
def chart_content(answer: Answer[MotionRequest, Computed] | None) -> Content:
    """The charts of a motion, or the reason why there is none."""
    found = answer.result if answer else None
    content = Content()
    for id in CHARTS:
        content |= page.props(id, hidden=found is None)
    for id in ("moment-row", "motion-files"):
        content |= page.props(id, hidden=found is None)
    if found is None:
        content |= page.props("moment-slider", min=0, max=1, step=0.01)
        return content | page.html("moment-label", "time")
    content |= page.chart(CHARTS[0], strip_data(found)) | page.chart(
        CHARTS[1], spectrum_data(found)
    )
    shown = times(found.units)
    low, high, step = 0.0, shown.factor * found.film.until, shown.factor * found.film.until / 1000
    content |= page.props("moment-slider", min=low, max=high, step=float(f"{step:.3g}"))
    return content | page.html("moment-label", escape(shown.label))


@lru_cache(16)
def notes_content(answer: Answer[MotionRequest, Computed] | None, before: bool) -> Content:
    """What the charts show, in words; before: the motion is that before the last change."""
    found = answer.result if answer else None
    return page.html("motion-list", notes(found, before) if found else "")


def moment_content(answer: Answer[MotionRequest, Computed] | None, moment: float | None) -> Content:
    """The line of the moment in the chart, which has none while the scene shows no motion, and its
    slider."""
    if answer is None or answer.result is None:
        return page.value("moment", 0.0)
    found = answer.result
    shown = times(found.units).factor * min(moment or 0.0, found.film.until)
    line = None if moment is None else {"action": "moment", "x": float(shown)}
    return page.chart(CHARTS[0], {"cursor": line}) | page.value("moment", float(f"{shown:.4g}"))


def preset_content(motion: MotionState) -> Content:
    """The preset of the motion that the scene shows, "" for none: one that is only prepared is not
    marked, as it does not play."""
    known = (key for key, (_, own) in PRESETS.items() if own == motion.experiment)
    return page.value("experiment", next(known, "") if motion.in_motion else "")
