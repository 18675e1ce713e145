"""The tab Run-up: the speed rises from rest under a force that repeats k times per revolution, and
the scene shows the steady forced response at each speed."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Self

import numpy as np

from beamviz.beam import Beam
from beamviz.chart_ranges import CHART_FILL, chart_range
from beamviz.drawing.beam_mesh import DrawnBeam
from beamviz.drawing.text import Measure, frequencies, measure
from beamviz.explorer import page
from beamviz.explorer.computed_loci import cursor
from beamviz.explorer.declarations import Tab, choice, number_key, switch_key, whole_key
from beamviz.explorer.feature import Feature, fading, waiting
from beamviz.explorer.jobs import Answer
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Inputs, Snapshot
from beamviz.explorer.solutions import SolverAnswer
from beamviz.explorer.state import Case, Slice, State
from beamviz.explorer.view import Picture
from beamviz.explorer.visitor import Visitor
from beamviz.frequency_loci.forced_response import DAMPING, RunUp, response, run_up
from beamviz.scene import PER_REV, ViewOptions, clip
from beamviz.solver.solution import Solution

PER_SECOND = 6.0  # speeds of the run-up shown per second; they are dense near resonances
CHANGED = ("scene", "force_per_rev", "damping")  # events that end the response
PEAK = 2.0  # largest displacement drawn, over the amplitude of the view


@dataclass(frozen=True)
class RunUpState(Slice):
    """The force, and the run-up."""

    # Periods of the force per revolution.
    force_per_rev: int = field(
        default=1, metadata=choice(values=PER_REV, key=whole_key("force", 1, max(PER_REV)))
    )
    # The damping ratio of every mode.
    damping: float = field(default=0.02, metadata=choice(key=number_key("damping", *DAMPING)))
    # The scene shows the response to the force.
    forced_response: bool = field(
        default=False,
        metadata=choice(
            key=switch_key("response"), until=(*CHANGED, "structure", "modes", "motion")
        ),
    )
    # The speed during a run-up, shown in place of the beam's; 0 until the run-up is computed, None
    # without one.
    run_speed: float | None = field(
        default=None, metadata=choice(undo="ends", until=(*CHANGED, "case", "motion"))
    )

    def shown(self, case: Case) -> Case:
        """During a run-up at the speed of that."""
        return case.changed("gamma", self.run_speed) if self.run_speed else case


class RunUpRequest(NamedTuple):
    """A run-up to compute, up to the speed `stop`; that of the case is 0."""

    case: Case
    per_rev: int
    damping: float
    stop: float

    @classmethod
    def of(cls, state: State) -> Self:
        """The run-up of a state. It depends on the speed of the state only by its end, beyond that
        speed, which changes rarely."""
        stop = CHART_FILL * chart_range(state.case.nearest_beam(), "gamma")[1]
        case, force = state.shown_case.changed("gamma", 0.0), state.slice(RunUpState)
        return cls(case, force.force_per_rev, force.damping, stop)

    @property
    def beam(self) -> Beam:
        return self.case.beam

    def run_up(self) -> RunUp:
        """The run-up to its end. Raises the errors of `forced_response.run_up`."""
        return run_up(self.beam, self.per_rev, self.damping, self.stop, **self.case.options)


JOB = "run-up"
SHOWN = "run-up-chart", "run-up-list"  # ids of the chart and of the resonances


def answer_of(inputs: Inputs) -> Answer[RunUpRequest, RunUp] | None:
    """The run-up of the present beam and force; None before it is computed."""
    answer = inputs.job_answer(JOB)
    return answer if answer and answer.request == RunUpRequest.of(inputs.state) else None


def response_drawn(
    run: RunUp, answer: SolverAnswer, view: ViewOptions, scale: float, frequency: float
) -> DrawnBeam | None:
    """The response at the speed of an answer, as the only mode of the beam, with the phase and the
    frequency [1/T*] of the force, and the colours of the whole run-up; scale: [pixels per beam
    length]. None without one."""
    if answer.solution is None:
        return None
    shapes = answer.shapes
    field = scaled_response(run, answer.solution, shapes.x, view.amplitude)
    if not field.size:
        return None
    size, unlimited = max(PEAK * view.amplitude, 1e-9), np.full(1, np.inf)
    modes, nodes = 1j * field[None] / size, [np.zeros(0)]
    moved = replace(
        shapes,
        modes=modes,
        limits=unlimited,
        nodes=nodes,
        largest=size,
        frequencies=np.full(1, frequency),
    )
    return DrawnBeam(moved, view, scale, np.full(1, size))


def started(state: State) -> State:
    """From rest, with the response to the force in the scene, and its line in the chart."""
    per_rev = tuple(sorted({*state.per_rev, state.slice(RunUpState).force_per_rev}))
    state = replace(state.after("modes").changed("all_modes", False), per_rev=per_rev)
    return state.with_values(RunUpState, forced_response=True, run_speed=0.0)


def next_speed(run: RunUp, speed: float, elapsed: float) -> float | None:
    """The speed after `elapsed` [s]; None after the last stable one."""
    stable = run.speeds[np.logical_and.accumulate(np.isfinite(run.amplitudes))]
    if not speed < max(stable, default=0.0):
        return None
    numbers = np.arange(len(stable))
    reached = float(np.interp(speed, stable, numbers)) + PER_SECOND * elapsed
    return float(np.interp(reached, numbers, stable))


def scaled_response(run: RunUp, solution: Solution, x: np.ndarray, amplitude: float) -> np.ndarray:
    """Response (n, 2) at coordinates x (n,), with the square root of its size as amplitude; (0, 2)
    for an unstable beam, as before the start of a run-up."""
    field = response(solution, run.per_rev * solution.beam.gamma, run.damping, x)
    if not np.isfinite(field).all():
        return np.zeros((0, 2))
    largest = float(np.abs(field).max())
    share = min(largest / max(float(np.nanmax(run.amplitudes)), 1e-300), 1.0)
    return field * (PEAK * amplitude * math.sqrt(share) / max(largest, 1e-300))


# The tab

AMPLITUDE = Measure("tip amplification", "tip")
ABOVE, BELOW = 1.5, 1e-4  # ends of the amplitude axis, over the largest amplitude
DAMPING_HELP = "Damping ratio of every mode; 100 % is critical damping"
NOTE = (
    "<p>A force distributed over the beam like its weight, with k periods per revolution. The curve"
    " is the steady linear response of the tip at each speed, with the same damping ratio for"
    " every mode; 1 is the deflection at rest under the same force. In the scene, small responses"
    " are enlarged (square root), and the speed increases slowly near a resonance. At the end the"
    " beam has its own speed again.</p>"
)
DAMPING_ENDS = [100 * end for end in DAMPING]
TOOLS = page.select("force_per_rev", "force", {k: f"{k} × per revolution" for k in PER_REV})
TOOLS += page.slider(
    "damping",
    "damping ζ [%]",
    DAMPING_HELP,
    min=DAMPING_ENDS[0],
    max=DAMPING_ENDS[1],
    step=0.1,
)
TOOLS += page.button("Run up from rest", id="run-up-button", class_="main", data_do="run_up")


class RunUpTab(Feature):
    """The force, the chart of amplitudes and the resonances; the speed of the beam as it rises."""

    tab = Tab(
        "Run-up",
        6,
        "The speed rises from rest under a periodic force, through the resonances",
        page.chart_tab(TOOLS, "run-up-chart", "run-up-list"),
        (JOB,),
        beside="Motion",
        view="run-up",
    )
    state = RunUpState

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        visitor.job(JOB, RunUpRequest.run_up)
        visitor.bind("damping", with_damping, damping_shown, float)
        self.page.on("run_up", lambda _: visitor.change(started_or_stopped))

    def react(self, snapshot: Snapshot, elapsed: float) -> None:
        """Increase the speed of a run-up after `elapsed` [s]."""
        speed, answer = snapshot.state.slice(RunUpState).run_speed, answer_of(snapshot)
        visitor = self.visitor
        if speed is None or answer is None:
            return
        with visitor.lock:
            if visitor.state.slice(RunUpState).run_speed == speed:
                reached = next_speed(answer.result, speed, elapsed) if answer.result else None
                visitor.set_state(visitor.state.with_values(RunUpState, run_speed=reached))

    def wanted(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """The run-up while the scene shows the response, or the tab is open."""
        state = snapshot.state
        is_shown = state.slice(RunUpState).forced_response or state.tab == self.tab.key
        return {JOB: RunUpRequest.of(state)} if is_shown else {}

    def picture(self, inputs: Inputs, picture: Picture) -> Picture:
        """The response, from the start until a mode is chosen."""
        state, answer, run = inputs.state, inputs.answer, answer_of(inputs)
        force = state.slice(RunUpState)
        if force.run_speed is not None:
            picture = replace(picture, plays=True)
        if not (force.forced_response and run and run.result and answer):
            return picture
        drawn, frequency = None, force.force_per_rev * answer.shapes.beam.gamma
        if not state.view.all_modes:
            drawn = response_drawn(run.result, answer, state.view, inputs.scale, frequency)
        return replace(picture, drawn=drawn, force=frequency) if drawn else picture

    def content(self, snapshot: Snapshot) -> Content:
        answer = answer_of(snapshot)
        running = snapshot.state.slice(RunUpState).run_speed is not None
        return (
            page.html("run-up-button", "Stop" if running else "Run up from rest")
            | chart_content(answer)
            | line_content(answer.result if answer else None, snapshot.entered_beam)
            | fading(snapshot, [JOB], *SHOWN)
            | waiting(snapshot, "run-up-chart-wait", self.tab)
        )


def started_or_stopped(state: State) -> State:
    """With a run-up from rest, or without the one under way; unchanged for a number out of range,
    of which there is none."""
    if state.slice(RunUpState).run_speed is not None:
        return state.with_values(RunUpState, run_speed=None)
    return started(state) if state.case.in_range else state


def chart_content(answer: Answer[RunUpRequest, RunUp] | None) -> Content:
    """The run-up, or the reason why there is none."""
    run = answer.result if answer else None
    content = page.props("run-up-chart", hidden=run is None)
    if run is None:
        reason = page.note(answer.message) if answer else ""
        return content | page.html("run-up-list", reason or NOTE)
    content |= page.chart("run-up-chart", run_data(run))
    return content | page.html("run-up-list", resonance_table(run) + NOTE)


def line_content(run: RunUp | None, beam: Beam | None) -> Content:
    """The speed of the beam, in the chart if there is one."""
    if run is None:
        return page.props("run-up-chart", hidden=True)
    line = cursor(beam, "gamma", measure("gamma", run.beam.units))
    return page.chart("run-up-chart", {"cursor": line})


def with_damping(state: State, percent: object) -> State:
    ratio = percent / 100 if isinstance(percent, int | float) else percent
    damping = max(clip(ratio, DAMPING[1], state.slice(RunUpState).damping), DAMPING[0])
    return state.with_values(RunUpState, damping=damping).after("damping")


def damping_shown(state: State) -> float:
    """The damping ratio [%], without rounding errors."""
    return round(100 * state.slice(RunUpState).damping, 6)


def run_data(run: RunUp) -> page.Data:
    """The chart: amplitudes over the speed, and the resonances."""
    axes = along, _ = measure("gamma", run.beam.units), AMPLITUDE
    known = run.amplitudes[np.isfinite(run.amplitudes)]
    low, high = (float(known.min()), float(known.max())) if known.size else (1.0, 1.0)
    runs, marks = [[0, len(run.speeds) - 1, "bending", ""]], []
    for one in run.resonances:
        times = f"{run.peak(one):.3g} times the deflection at rest"
        text = f"resonance of {one.branches[0]}: {along.text(one.at, 4)}, {times}"
        key, place = f"{one.branches[0]} {one.at:.4g}", (one.at, run.peak(one))
        action = {"action": "gamma", "value": float(along.factor * one.at)}
        marks.append(page.mark(key, "resonance", axes, place, text, **action))
    return {
        "name": "Response of the tip over the speed",
        "x": page.axis_data(along, (0.0, float(run.speeds[-1]))),
        "y": page.axis_data(AMPLITUDE, (max(low, BELOW * high) / ABOVE, ABOVE * high), log=True),
        "at": page.sent(along.factor * run.speeds),
        "lines": [{"label": "tip", "y": page.sent(run.amplitudes), "runs": runs}],
        "marks": marks,
        "keys": page.keys([], marks),
    }


def resonance_table(run: RunUp) -> str:
    """Speed, frequency and amplitude of the resonances, each with a button that sets the speed."""
    if not run.resonances:
        return "<p>No resonance in this range.</p>"
    along, across = measure("gamma", run.beam.units), frequencies(run.beam.units)
    heads = ("go to", f"at {along.head}", across.label, "tip moves")
    rows = []
    for one in run.resonances:
        speed = {"data_do": "gamma", "data_value": along.factor * one.at, "data_unit": along.unit}
        go_to = page.button(f"{page.sign('resonance')} {one.branches[0]}", class_="quiet", **speed)
        place = along.number(one.at), across.number(one.frequency)
        rows.append((go_to, *place, f"{run.peak(one):.3g} ×"))
    return page.table("resonances of the run-up", heads, rows)
