"""The tab Run-up: the speed rises from rest under a force that repeats k times per revolution, and
the scene shows the steady forced response at each speed."""

import contextlib
import math
from dataclasses import replace
from typing import NamedTuple, Self

import numpy as np

from beamviz.chart_ranges import CHART_FILL, chart_range
from beamviz.drawing.beam_mesh import DrawnBeam
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.text import Measure, frequencies, measure
from beamviz.errors import InvalidInput
from beamviz.explorer import page
from beamviz.explorer.features.loci_chart import cursor
from beamviz.explorer.jobs import Answer, Job
from beamviz.explorer.state import Case, State
from beamviz.explorer.visitor import Feature, Visitor
from beamviz.frequency_loci.forced_response import DAMPING, RunUp, response, run_up
from beamviz.scene import PER_REV, clip
from beamviz.solver.solution import Solution

PER_SECOND = 6.0  # speeds of the run-up shown per second; they are dense near resonances
PEAK = 2.0  # largest displacement drawn, over the amplitude of the view


class RunUpRequest(NamedTuple):
    """A run-up to compute; the speed of the case is 0."""

    case: Case
    per_rev: int
    damping: float

    @classmethod
    def of(cls, state: State) -> Self:
        """The run-up of a state, which does not depend on its speed."""
        return cls(state.case.changed("gamma", 0.0), state.force_per_rev, state.damping)

    def run_up(self) -> RunUp:
        """The run-up to the end of the chart. Raises the errors of `forced_response.run_up`."""
        beam = self.case.beam()
        stop = CHART_FILL * chart_range(beam, "gamma")[1]
        return run_up(beam, self.per_rev, self.damping, stop, **self.case.options)


class RunUpPlayback:
    """The run-up in the scene: `step` increases the speed, `drawn` is the response at that speed.

    field: complex displacement (n, 2) [beam lengths] drawn.
    """

    def __init__(self, visitor: Visitor):
        self.visitor = visitor
        self.job: Job[RunUpRequest, RunUp] = visitor.job("run-up", RunUpRequest.run_up)
        self.field: np.ndarray = np.zeros((0, 2))

    @property
    def answer(self) -> Answer[RunUpRequest, RunUp] | None:
        """The answer for the present beam and force; None before it."""
        answer = self.job.answer
        return answer if answer and answer.request == RunUpRequest.of(self.visitor.state) else None

    @property
    def run(self) -> RunUp | None:
        return self.answer.result if self.answer else None

    @property
    def running(self) -> bool:
        return self.visitor.state.run_speed is not None and self.run is not None

    def start_or_stop(self) -> None:
        """Start from rest, or stop; nothing for a number out of range."""
        if self.running:
            self.show_speed(None)
            return
        with contextlib.suppress(InvalidInput):
            self.visitor.state.case.beam()
            self.visitor.change(started)

    def step(self, elapsed: float) -> None:
        """Request the run-up if the scene shows it; increase its speed after `elapsed` [s]."""
        with self.visitor.lock:
            state, run = self.visitor.state, self.run
            if state.forced_response:
                self.job.request(RunUpRequest.of(state))
            if self.answer and state.run_speed is not None and not state.following:
                self.show_speed(next_speed(run, state.run_speed, elapsed) if run else None)

    def show_speed(self, speed: float | None) -> None:
        """Show the beam at a speed of the run-up, or None: end it, at the beam's own speed."""
        self.visitor.set_state(replace(self.visitor.state, run_speed=speed))

    def drawn(self, shapes: SampledModes, scale: float) -> DrawnBeam | None:
        """The response as the only mode of the beam, with the phase of the force; scale: [pixels
        per beam length]. None unless the scene shows it: from the start until a mode is chosen."""
        answer, state, run = self.visitor.answer, self.visitor.state, self.run
        if run is None or not state.forced_response or state.view.all_modes:
            return None
        if answer and answer.solution:
            self.field = scaled_response(run, answer.solution, shapes.x, state.view.amplitude)
        if not self.field.size:
            return None
        size, unlimited = max(PEAK * state.view.amplitude, 1e-9), np.full(1, np.inf)
        modes, nodes = 1j * self.field[None] / size, [np.zeros(0)]
        moved = replace(shapes, modes=modes, limits=unlimited, nodes=nodes)
        return DrawnBeam(moved, state.view, scale, np.full(1, size))


def started(state: State) -> State:
    """From rest, with the response to the force in the scene, and its line in the chart."""
    per_rev = tuple(sorted({*state.per_rev, state.force_per_rev}))
    state = state.changed("all_modes", False)
    return replace(state, per_rev=per_rev, forced_response=True, run_speed=0.0)


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
RESPONSE = "Forced response. Click a mode to see its free vibration again."
DAMPING_HELP = "Damping ratio of every mode; 100 % is critical damping"
NOTE = (
    "<p>A force distributed over the beam like its weight, with k periods per revolution. The curve"
    " is the steady linear response of the tip at each speed, with the same damping ratio for"
    " every mode; 1 is the deflection at rest under the same force. In the scene, small responses"
    " are enlarged (square root), and the speed increases slowly near a resonance. At the end the"
    " beam has its own speed again.</p>"
)


class RunUpTab(Feature):
    """The force, the chart of amplitudes and the resonances."""

    def __init__(self, visitor: Visitor, playback: RunUpPlayback):
        super().__init__(visitor)
        self.playback = playback
        low, high = (100 * end for end in DAMPING)
        tools = page.select("force_per_rev", "force", {k: f"{k} × per revolution" for k in PER_REV})
        tools += page.slider("damping", "damping ζ [%]", DAMPING_HELP, min=low, max=high, step=0.1)
        tools += page.button("", id="run-up-button", class_="main", data_do="run_up")
        self.page.html("tab-run-up", page.chart_tab(tools, "run-up-chart", "run-up-list"))
        visitor.bind("damping", with_damping, lambda values: round(100 * values["damping"], 6))
        self.page.on("run_up", lambda _: playback.start_or_stop())

    def show(self) -> None:
        """Show the run-up with the speed of the beam, or the reason why there is none."""
        playback, run = self.playback, self.playback.run
        self.page.html("run-up-button", "Stop" if playback.running else "Run up from rest")
        self.page.props("run-up-chart", hidden=run is None)
        if run:
            line = cursor(self.visitor.answer, "gamma", measure("gamma", run.beam.units))
            self.page.chart("run-up-chart", {"cursor": line})
        if self.redraws(playback.answer) and run:
            self.page.chart("run-up-chart", run_data(run))
            self.page.html("run-up-list", resonance_table(run) + NOTE)
        elif not run:
            reason = page.note(playback.answer.message) if playback.answer else ""
            self.page.html("run-up-list", reason or NOTE)


def with_damping(state: State, percent: object) -> State:
    ratio = percent / 100 if isinstance(percent, int | float) else percent
    damping = max(clip(ratio, DAMPING[1], state.damping), DAMPING[0])
    return replace(state.without_run_up(), damping=damping)


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
        action = {"action": "gamma", "value": along.factor * one.at}
        marks.append(page.mark(key, "resonance", axes, place, text, **action))
    return {
        "name": "Response of the tip over the speed",
        "x": page.axis_data(along, (0.0, float(run.speeds[-1]))),
        "y": page.axis_data(AMPLITUDE, (max(low, BELOW * high) / ABOVE, ABOVE * high), log=True),
        "at": page.sent(along.factor * run.speeds),
        "lines": [{"label": "tip", "y": page.sent(run.amplitudes), "runs": runs}],
        "marks": marks,
    }


def resonance_table(run: RunUp) -> str:
    """Speed, frequency and amplitude of the resonances, each with a button that sets the speed."""
    if not run.resonances:
        return "<p>No resonance in this range.</p>"
    along, across = measure("gamma", run.beam.units), frequencies(run.beam.units)
    heads = ("go to", f"at {along.head}", across.label, "tip moves")
    rows = []
    for one in run.resonances:
        speed = {"data_set": "gamma", "data_value": along.factor * one.at}
        go_to = page.button(f"◆ {one.branches[0]}", class_="quiet", **speed)
        place = along.number(one.at, 4), across.number(one.frequency, 3)
        rows.append((go_to, *place, f"{run.peak(one):.3g} ×"))
    return page.table("resonances of the run-up", heads, rows)
