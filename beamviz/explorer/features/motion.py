"""The tab Motion: the beam is pulled and let go, spun up or stopped, and the equation of motion is
integrated in time; the scene plays it, and the tab shows the tip over time and its spectrum."""

import contextlib
import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from html import escape
from typing import Any, NamedTuple, Self

import numpy as np

from beamviz.beam import Beam
from beamviz.drawing.modes import stations
from beamviz.drawing.motion import MotionShapes, dominant_frequency, drawn_beam
from beamviz.drawing.text import (
    Measure,
    duration,
    frequencies,
    length_text,
    lengths,
    measure,
    si_measure,
    times,
)
from beamviz.dynamics import Motion, motion
from beamviz.dynamics.linear import LinearMotion, motion_without_stiffening
from beamviz.dynamics.pull import PulledBeam, pulled
from beamviz.errors import BeamvizError, InvalidInput
from beamviz.explorer import page
from beamviz.explorer.clock import suitable_rate
from beamviz.explorer.experiment import CHOICES, MODES, RANGES, STOP, Experiment
from beamviz.explorer.feature import Feature, Part, Tab, fading, waiting
from beamviz.explorer.film import Film, HeldShapes, time_text
from beamviz.explorer.jobs import Answer, case_error
from beamviz.explorer.page import Content, Data
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.state import Case, State
from beamviz.explorer.view import UNSTIFFENED
from beamviz.explorer.visitor import Visitor
from beamviz.scene import clip
from beamviz.solver import interruption, solve
from beamviz.units import Units

JOB, PULL_JOB = "motion", "pull"
TOLERANCE = 1e-3  # [L] of the tip, half a pixel of a scene of 500 pixels
POINTS, MOST_POINTS = 40, 1601  # of the results, for each T* and in all
LONGEST = 40.0  # [s] on the screen
LINES = 5  # modes whose frequencies are in the spectrum
WIDER = 1.1  # than to the highest frequency of a mode
PAUSED_DIGITS = 4  # after the point, of the moment of a pause in the address
DECADES = 4  # of amplitude in the spectrum
MODEL = ("strain", "curvature", "state")  # options of `solve` that a motion has too


class Obstacle(NamedTuple):
    """Why a motion cannot be computed, and a button (HTML) that removes the reason, if any.
    of_beam: the same is true of every experiment with this beam and model."""

    reason: str
    remedy: str = ""
    of_beam: bool = True


class MotionRequest(NamedTuple):
    """A motion to compute: its beam, options of `solve`, and the experiment."""

    beam: Beam
    options: tuple[tuple[str, Any], ...]
    experiment: Experiment

    @classmethod
    def of(cls, case: Case, experiment: Experiment) -> Self:
        """That of a case. Raises InvalidInput for a number out of range."""
        names = (*MODEL, "plane", "stiffening", "softening")
        return cls(case.beam(), tuple((name, case.options[name]) for name in names), experiment)

    @property
    def units(self) -> Units | None:
        """The size of the beam; None where it is not known."""
        return self.beam.units

    @property
    def obstacle(self) -> "Obstacle | None":
        """What a motion has not; None if it can be computed."""
        options, own, units = dict(self.options), self.experiment, self.beam.units
        if not self.beam.is_uniform:
            return Obstacle(
                "A motion in time is computed for a uniform clamped beam with at most one mass.",
                page.button("Make it uniform, as at the root", data_do="blade.uniform"),
            )
        if own.body != "stays" and own.body_at > own.until:
            return Obstacle(
                f"The mass is {own.body} at {time_text(own.body_at, units)}, after the end of the"
                f" motion at {time_text(own.until, units)}: make the motion longer, or choose an"
                " earlier time.",
                of_beam=False,
            )
        if options["plane"] != "chordwise":
            return Obstacle(
                "A motion in time is computed in the plane of rotation, and this beam vibrates out"
                " of it.",
                page.button("Vibrate in plane", data_set="plane", data_value="chordwise"),
            )
        for term in ("stiffening", "softening"):
            if not options[term]:
                return Obstacle(
                    "A motion in time has all effects of rotation; the theory without stiffening is"
                    " below.",
                    page.button(f"Switch {term} on", data_set=term, data_value=True),
                )
        if self.beam.spin_up:
            return Obstacle(
                "A motion in time has no constant spin-up: how the speed changes is chosen below.",
                page.button("Set the spin-up to 0", data_set="spin_up", data_value=0),
            )
        return None

    def computed(self) -> "Computed":
        """The motion. Raises the errors of `motion`, and Cancelled."""
        if obstacle := self.obstacle:
            raise InvalidInput(obstacle.reason)
        beam, own = self.beam, self.experiment
        options = {name: one for name, one in self.options if name in MODEL}
        given: dict[str, Any] = {
            **own.arguments,
            "speed": own.speed(beam.gamma),
            "tolerance": TOLERANCE,
            "points": min(math.ceil(POINTS * own.until) + 1, MOST_POINTS),
        }
        found = motion(beam, **given, **options, progress=Progress(own.until))
        second: LinearMotion | str = ""
        if own.unstiffened:
            try:
                second = motion_without_stiffening(beam, **given, progress=Progress(own.until))
            except BeamvizError as error:
                second = str(error)
        return Computed(self, found, second)


class Progress:
    """Tells how far a motion is, which is computed several times, with finer steps: the part done
    grows with each of them."""

    def __init__(self, until: float):
        self.until, self.runs, self.last = until, 0, 0.0

    def __call__(self, t: float) -> None:
        """Raises Cancelled."""
        self.runs += t < self.last
        self.last = t
        interruption.get()(1 - 0.5 ** (self.runs + t / self.until))


class Computed:
    """A computed motion, its spectrum and the frequencies of the modes at its end, ready to be
    shown. second: that without stiffening, or the reason why there is none, "" where none is asked
    for."""

    def __init__(self, request: MotionRequest, found: Motion, second: LinearMotion | str):
        self.request, self.motion, self.second = request, found, second
        self.beam, self.experiment = request.beam, request.experiment
        shapes = MotionShapes(found)
        other = None if isinstance(second, str) else MotionShapes(second)
        units = self.beam.units
        rate = suitable_rate(dominant_frequency(found), float(abs(found.gamma).max()), units)
        rate = max(rate, float(found.t[-1]) / LONGEST)
        self.film = Film(drawn_beam(found), shapes, other, rate, found.has_mass)
        self.since = self.experiment.event if self.experiment.event < 0.7 * found.t[-1] else 0.0
        self.spectrum = found.spectrum(self.since)
        options = {name: one for name, one in request.options if name in MODEL}
        try:
            last = self.experiment.last_beam(self.beam, float(found.gamma[-1]))
            modes = solve(last, modes=LINES, coriolis=True, **options)
            known = np.isfinite(modes.frequencies)
            self.modes = [
                (modes.labels[k], modes.families[k], float(modes.frequencies[k]))
                for k in np.flatnonzero(known)
            ]
        except BeamvizError:
            self.modes = []
        self.units = units


def wanted(state: State) -> MotionRequest | None:
    """The motion that a state describes; None where there is an obstacle."""
    if obstacle_of(state.case, state.experiment):
        return None
    return MotionRequest.of(state.case, state.experiment)


def obstacle_of(case: Case, experiment: Experiment) -> Obstacle | None:
    """Why a case has no motion; None if that can be computed."""
    try:
        return MotionRequest.of(case, experiment).obstacle
    except InvalidInput as error:
        return Obstacle(f"There is no motion: {case_error(str(error), case)}.")


def can_move(state: State) -> bool:
    """Whether some experiment with the beam and the model of a state has a motion."""
    obstacle = obstacle_of(state.case, state.experiment)
    return obstacle is None or not obstacle.of_beam


def answer_of(snapshot: Snapshot) -> Answer[MotionRequest, Computed] | None:
    """The last motion; None before the first, and where the state describes none."""
    return snapshot.job_answer(JOB) if wanted(snapshot.state) else None


def is_before(snapshot: Snapshot) -> bool:
    """Whether the motion shown is not yet that of the state, which is being computed."""
    answer = answer_of(snapshot)
    return answer is not None and answer.request != wanted(snapshot.state)


class PullRequest(NamedTuple):
    """A beam that is held, and where."""

    beam: Beam
    options: tuple[tuple[str, Any], ...]
    at: float
    deflection: float

    @classmethod
    def of(cls, state: State) -> Self:
        """That of a state in which the beam is held. Raises InvalidInput for a number out of
        range."""
        assert state.hold
        options = tuple((name, state.case.options[name]) for name in MODEL)
        return cls(state.case.beam(), options, state.hold.at, state.hold.deflection)

    @property
    def units(self) -> Units | None:
        """The size of the beam; None where it is not known."""
        return self.beam.units

    def pulled(self) -> PulledBeam:
        """The beam as it is held. Raises the errors of `pulled`."""
        return pulled(self.beam, self.deflection, self.at, **dict(self.options))


def film_reads(snapshot: Snapshot) -> tuple[Any, ...]:
    """The beam while it is held, and the last motion if the scene shows it."""
    state = snapshot.state
    held = snapshot.job_answer(PULL_JOB) if state.hold else None
    return held, (answer_of(snapshot) if state.in_motion else None)


def film_of(
    held: Answer[PullRequest, PulledBeam] | None, answer: Answer[MotionRequest, Computed] | None
) -> Film | None:
    """What the scene plays instead of modes."""
    if held and held.result:
        beam = held.request.beam
        x = stations(beam.beta if beam.alpha else 1.0)
        shapes = HeldShapes(beam, x, held.result.position(x))
        return Film(beam, shapes, None, 1.0, lambda _: True)
    return answer.result.film if answer and answer.result else None


def played_reads(snapshot: Snapshot, film: Film) -> tuple[Any, ...]:
    """What the picture of a motion depends on, besides that without it."""
    moment = snapshot.clock.moment
    diverged = film.diverged is not None and moment >= film.diverged
    return snapshot.state.view, snapshot.scale, film.has_body(moment), diverged


# The tab

PULL_HINT = (
    "A force across the beam that holds it until the motion begins; then it is let go. A force of"
    " E I / L² bends a beam at rest by about a third of its length. Or drag the beam in the scene."
)
HINTS = {
    "start": "How the beam begins: held by a force until it is let go, or swinging in its modes",
    **{
        name: f"Amplitude of the mode {name} with which it begins, its largest displacement"
        for name in MODES
    },
    "pull": PULL_HINT,
    "pull_at": "Where it is pulled: 0 is the clamp, 1 the tip",
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
    **{name: f"amplitude of {name}" for name in MODES},
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
    return page.select(f"motion.{name}", NAMES[name], CHOICES[name], HINTS[name])


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
    page.button("Play", id="motion-play", data_do="motion.play"),
    page.button("From the start", data_do="moment", data_value=0),
    id="motion-play-row",
)
TOOLS += page.slider("moment", "time", "The moment that the scene shows", min=0, max=1, step=0.01)
MORE = select_of("start") + "".join(map(slider_of, ("pull", "pull_at", *MODES)))
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

    tab = Tab("Motion", 7, CONTENT)

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        visitor.job(JOB, MotionRequest.computed)
        visitor.job(PULL_JOB, PullRequest.pulled)
        for name in (*RANGES, *CHOICES, "unstiffened"):
            self.page.on(f"motion.{name}", partial(self.edit, name))
        self.page.on("experiment", self.begin)
        self.page.on("moment", self.go_to)
        self.page.on("motion.play", self.play)

    def edit(self, name: str, value: Any) -> None:
        """Set a value of the experiment, as displayed."""
        if name in RANGES:
            value = display(name, self.visitor.state.case.units).plain(value)
        self.visitor.change(
            lambda state: state.with_experiment(state.experiment.changed(name, value))
        )

    def begin(self, name: Any) -> None:
        """Begin a motion, which plays unless the visitor prefers reduced motion."""
        if name in PRESETS:
            own = PRESETS[name][1]
            self.visitor.change(lambda state: begun(state, own))

    def play(self, _: Any) -> None:
        """Show the motion and play it, or pause it."""
        self.visitor.change(played)

    def go_to(self, value: Any) -> None:
        """Show another moment of the motion."""
        visitor = self.visitor
        with visitor.lock:
            moment = times(visitor.state.case.units).plain(value)
            moment = clip(moment, RANGES["until"].limits[1], visitor.state.moment)
            visitor.change(lambda state: replace(state.at_moment(moment), in_motion=True))

    def react(self, snapshot: Snapshot, elapsed: float) -> None:
        """Keep the moment at which the motion was paused."""
        state, visitor = snapshot.state, self.visitor
        if snapshot.is_led or state.view.playing or state.hold or snapshot.film is None:
            return
        with visitor.lock:
            clock = visitor.clock
            shown = clock.film is snapshot.film and visitor.state is state
            if shown and clock.moment != state.moment:
                visitor.set_state(state.at_moment(round(clock.moment, PAUSED_DIGITS)))

    def wanted(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """The motion while the scene shows it, or the tab is open; the pull of a beam in a hand."""
        state = snapshot.state
        is_shown = state.in_motion or state.hold or state.tab == self.tab.key
        with contextlib.suppress(InvalidInput):  # the page says which number is out of range
            if state.hold:
                return {PULL_JOB: PullRequest.of(state)}
            if is_shown:
                return {JOB: MotionRequest.of(state.case, state.experiment)}
        return {JOB: None}

    @property
    def parts(self) -> Iterable[Part]:
        return (
            Part(lambda s: (s.state.experiment, s.state.case.units), values_content),
            Part(lambda s: (s.state.experiment, s.state.case, reason_of(s)), words_content),
            Part(lambda s: (answer_of(s),), chart_content),
            Part(lambda s: (answer_of(s), is_before(s)), notes_content),
            Part(lambda s: (answer_of(s), moment_of(s)), moment_content),
            Part(lambda s: (s.state.in_motion and s.state.view.playing,), play_content),
            fading([JOB], *CHARTS, "motion-list"),
            waiting("motion-wait", JOB),
        )


def begun(state: State, experiment: Experiment) -> State:
    state = state.with_experiment(experiment)
    return state if state.still else state.changed("playing", True)


def played(state: State) -> State:
    """The motion goes on, or is paused; it begins where the scene shows modes."""
    if state.in_motion:
        return state.changed("playing", not state.view.playing)
    return state.with_experiment(state.experiment).changed("playing", True)


def reason_of(snapshot: Snapshot) -> str:
    """Why there is no motion."""
    answer = answer_of(snapshot)
    known = answer is not None and answer.result is None and not answer.cancelled
    return answer.message if answer and known else ""


def moment_of(snapshot: Snapshot) -> float | None:
    """The moment that the scene shows; None where it shows no motion."""
    return snapshot.clock.moment if snapshot.film else None


# Displayed values


def display(name: str, units: Units | None) -> Measure:
    """The display of a number of the experiment."""
    label = NAMES.get(name, name)
    if name in TIMES:
        own = times(units)
        return own._replace(label=f"{label} [{own.unit or 'T*'}]")
    if name == "damping":
        return Measure(label, "ζ", "%", PERCENT)
    if name in MODES:
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
        limits = {"min": low, "max": high, "step": step, "data_unit": shown.unit}
        content |= page.props(f"{key}-slider", **limits)
        content |= page.html(f"{key}-label", escape(shown.label))
        content |= page.props(f"{key}-field", aria_label=shown.label)
        content |= page.value(key, float(f"{shown.factor * getattr(experiment, name):.6g}"))
    for name in (*CHOICES, "unstiffened"):
        content |= page.value(f"motion.{name}", getattr(experiment, name))
    preset = next((key for key, (_, one) in PRESETS.items() if one == experiment), "")
    content |= page.value("experiment", preset)
    in_modes = experiment.start == "modes"
    hidden = {
        "within": not experiment.ramps,
        "torque": experiment.hub != "torque",
        "inertia": experiment.hub != "torque",
        "pull": in_modes,
        "pull_at": not experiment.pulls,
        **dict.fromkeys(MODES, not in_modes),
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


def chart_content(answer: Answer[MotionRequest, Computed] | None) -> Content:
    """The charts of a motion, or the reason why there is none."""
    found = answer.result if answer else None
    content = Content()
    for id in CHARTS:
        content |= page.props(id, hidden=found is None)
    for id in ("moment-row", "motion-files"):
        content |= page.props(id, hidden=found is None)
    if found is None:
        return content
    content |= page.chart(CHARTS[0], strip_data(found)) | page.chart(
        CHARTS[1], spectrum_data(found)
    )
    shown = times(found.units)
    low, high, step = 0.0, shown.factor * found.film.until, shown.factor * found.film.until / 1000
    content |= page.props("moment-slider", min=low, max=high, step=float(f"{step:.3g}"))
    return content | page.html("moment-label", escape(shown.label))


def notes_content(answer: Answer[MotionRequest, Computed] | None, before: bool) -> Content:
    """What the charts show, in words; before: the motion is that before the last change."""
    found = answer.result if answer else None
    return page.html("motion-list", notes(found, before) if found else "")


def moment_content(answer: Answer[MotionRequest, Computed] | None, moment: float | None) -> Content:
    """The line of the moment in the chart, and its slider."""
    if answer is None or answer.result is None:
        return page.value("moment", 0.0)
    found = answer.result
    shown = times(found.units).factor * min(moment or 0.0, found.film.until)
    content = page.chart(CHARTS[0], {"cursor": {"action": "moment", "x": float(shown)}})
    return content | page.value("moment", float(f"{shown:.4g}"))


def play_content(playing: bool) -> Content:
    return page.html("motion-play", "Pause" if playing else "Play")


def strip_data(found: Computed) -> Data:
    """The deflection of the tip over time."""
    along, tip = times(found.units), found.motion.tip[:, 1]
    across = lengths("deflection of the tip", "y", found.units)
    low, high = min(float(tip.min()), 0.0), max(float(tip.max()), 0.0)
    low, high = (low, high) if high > low else (-1e-3, 1e-3)
    margin = (0.6 if not isinstance(found.second, str) else 0.08) * (high - low)
    lines: list[Data] = [
        {
            "label": "tip",
            "y": page.sent(across.factor * tip),
            "runs": [[0, len(tip) - 1, "bending", "tip"]],
        }
    ]
    gaps = []
    if not isinstance(found.second, str):
        other = found.second.tip[:, 1]
        lines.append(
            {
                "label": "",
                "second": True,
                "at": page.sent(along.factor * found.second.t),
                "y": page.sent(across.factor * other),
                "runs": [[0, len(other) - 1, "stretching", UNSTIFFENED]],
            }
        )
        if found.film.diverged is not None:
            ends = along.factor * found.film.diverged, along.factor * found.film.until
            gaps.append([*map(float, ends), f"{UNSTIFFENED}: diverged"])
    return {
        "name": "Deflection of the tip over time",
        "x": page.axis_data(along, (0.0, found.film.until)),
        "y": page.axis_data(across, (low - margin, high + margin)),
        "at": page.sent(along.factor * found.motion.t),
        "lines": lines,
        "gaps": gaps,
        "keys": [
            {"style": "line bending", "text": "tip"},
            *([{"style": "line second", "text": UNSTIFFENED}] if len(lines) > 1 else []),
        ],
    }


def spectrum_data(found: Computed) -> Data:
    """The spectrum of the deflection of the tip, with the frequencies of the modes as lines."""
    along, across = frequencies(found.units), lengths("amplitude", "a", found.units)
    frequency, amplitude = found.spectrum
    highest = max((one for _, _, one in found.modes), default=float(frequency[-1]))
    inside = (frequency > 0) & (frequency <= WIDER * highest)
    frequency, amplitude = frequency[inside], amplitude[inside]
    top = float(amplitude.max(initial=0.0)) or 1.0
    ends = top / 10**DECADES, 3 * top
    lines = [
        {
            "label": label,
            "at": page.sent(along.factor * np.array([one, one * (1 + 1e-9)])),
            "y": page.sent(across.factor * np.array([ends[0], 10 * ends[1]])),
            "runs": [[0, 1, f"{family} dashed", label]],
        }
        for label, family, one in found.modes
    ]
    amplitude = np.maximum(amplitude, 0.1 * ends[0])
    lines.append(
        {
            "label": "",
            "y": page.sent(across.factor * amplitude),
            "runs": [[0, len(amplitude) - 1, "resonance", "tip"]],
        }
    )
    return {
        "name": "Spectrum of the motion of the tip",
        "x": page.frequency_axis(along, (0.0, WIDER * highest)),
        "y": page.axis_data(across, ends, log=True),
        "at": page.sent(along.factor * frequency),
        "lines": lines,
        "keys": [
            {"style": "line resonance", "text": "spectrum"},
            {"style": "line dashed", "text": "modes"},
        ],
    }


def notes(found: Computed, before: bool) -> str:
    """What the charts show, in words; before: the motion is that before the last change."""
    units = found.units
    far, error = (
        length_text(float(length), units, digits)
        for length, digits in ((abs(found.motion.tip[:, 1]).max(), 4), (found.motion.error, 1))
    )
    tip = "Before the last change the tip was" if before else "The tip is"
    text = f"<p>{tip} at most {far} aside, known to {error}.</p>"
    if isinstance(found.second, str):
        text += page.note(found.second)
    elif found.film.diverged is not None:
        text += page.note(
            f"The theory without stiffening diverges: at {time_text(found.film.diverged, units)}"
            " its tip is displaced by the length of the beam. The beam itself goes on."
        )
    else:
        text += "<p>The theory without stiffening does not diverge in this time.</p>"
    own = found.experiment
    if found.since:
        text += f"<p>The spectrum is that of the motion after {time_text(found.since, units)}"
        text += ", with the frequencies that the beam has then.</p>"
    elif own.hub == "torque" and own.event:
        text += "<p>The frequencies are those at the speed that is reached in the end.</p>"
    elif own.event:
        text += "<p>The frequencies are those at the end; make the motion longer to see them.</p>"
    return text
