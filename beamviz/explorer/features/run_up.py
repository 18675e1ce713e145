"""The tab Run-up: the speed rises from rest under a force that repeats k times per revolution, and
the scene shows the steady forced response at each speed."""

import math
from dataclasses import replace
from typing import NamedTuple, Self

import numpy as np
from viser import uplot

from beamviz.drawing.modes import SampledModes
from beamviz.drawing.text import Measure, frequencies, measure
from beamviz.errors import InvalidInput
from beamviz.explorer.features.loci_chart import PER_REV
from beamviz.explorer.jobs import Answer, Job, SolverAnswer
from beamviz.explorer.page.html import small
from beamviz.explorer.page.style import COLOURS, LINE, MARK, Plot, Range, dot, marks
from beamviz.explorer.state import Case, State
from beamviz.explorer.visitor import Feature, Visitor, on_press
from beamviz.exports.html_page import table
from beamviz.frequency_loci.forced_response import DAMPING, RunUp, response, run_up
from beamviz.frequency_loci.sweep import CHART_FILL, chart_range
from beamviz.scene import clip
from beamviz.server.viser_private import set_html
from beamviz.solver.solution import Solution

PER_SECOND = 6.0  # speeds of the run-up passed per second; they are dense near resonances
PEAK = 2.0  # largest displacement drawn, over the amplitude of the view


class RunUpRequest(NamedTuple):
    """A run-up to compute; the speed of the case is 0."""

    case: Case
    per_rev: int
    damping: float

    @classmethod
    def of(cls, state: State) -> Self:
        """The run-up of a state, whatever its speed."""
        return cls(state.case.changed("gamma", 0.0), state.force_per_rev, state.damping)

    def run_up(self) -> RunUp:
        """The run-up to the speed at which the loci chart would change its axis. Raises the errors
        of `forced_response.run_up`."""
        beam = self.case.beam()
        stop = CHART_FILL * chart_range(beam, "gamma")[1]
        return run_up(beam, self.per_rev, self.damping, stop, **self.case.options)


class RunUpPlayback:
    """The run-up in the scene: `step` raises the speed of the state, `take` prepares the response
    at that speed for drawing.

    run: None without one for the present beam and force; running: the speed is rising; driven: the
    scene shows the response; field (n, 2): complex displacement in beam lengths as drawn.
    """

    def __init__(self, visitor: Visitor):
        self.visitor = visitor
        self.job: Job[RunUpRequest, RunUp] = visitor.job("run-up", RunUpRequest.run_up)
        self.request: RunUpRequest | None = None
        self.position: float | None = None  # index among the speeds of the run, while it runs
        self.gamma = self.initial = 0.0  # the speed set last, and the one before the run-up
        self.drawn: tuple[object, ...] = ()
        self.phase = 0.0  # [rad] of the force
        self.field: np.ndarray = np.zeros((0, 2))

    @property
    def answer(self) -> Answer[RunUpRequest, RunUp] | None:
        """The answer to the request."""
        answer = self.job.answer
        return answer if answer and answer.request is self.request else None

    @property
    def run(self) -> RunUp | None:
        """The run-up."""
        return self.answer.result if self.answer else None

    @property
    def running(self) -> bool:
        """Whether the speed is rising."""
        return self.position is not None and self.run is not None

    @property
    def driven(self) -> bool:
        """Whether the scene shows the response: from the first speed until a mode is chosen."""
        return self.visitor.state.forced_response and self.run is not None and self.field.size > 0

    @property
    def inputs(self) -> tuple[object, ...]:
        """What the scene and the tab depend on."""
        return self.answer, self.running, self.visitor.state.forced_response

    @property
    def outdated(self) -> bool:
        """Whether the scene has yet to take up a change."""
        return any(a is not b for a, b in zip(self.inputs, self.drawn or (0, 0, 0), strict=True))

    def start_or_stop(self) -> None:
        """Start from rest, or stop and restore the speed; a beam without a solution stays."""
        state = self.visitor.state
        if self.running:
            self.stop()
            return
        try:
            state.case.beam()
        except InvalidInput:
            return
        request = RunUpRequest.of(state)
        self.request = self.job.latest if self.job.latest == request else request
        self.gamma = self.initial = state.case.numbers["gamma"]
        self.position = 0.0
        self.visitor.change(
            lambda state: replace(
                state.changed("all_modes", False), per_rev=True, forced_response=True
            )
        )
        self.job.request(request)

    def stop(self) -> None:
        """Stop, and restore the speed from before the run-up."""
        self.position = None
        self.visitor.change(lambda state: state.changed("gamma", self.initial))

    def step(self, elapsed: float) -> None:
        """Raise the speed, `elapsed` seconds later. A visitor who sets the speed stops the run-up
        there; another beam, model or force ends it."""
        with self.visitor.lock:
            state = self.visitor.state
            if self.request is None:
                return
            if RunUpRequest.of(state) != self.request:
                self.position = self.request = None
            elif state.case.numbers["gamma"] != self.gamma:
                self.position = None
            elif self.running:
                self.advance(elapsed)

    def advance(self, elapsed: float) -> None:
        """Set the next speed; after the last stable one, the speed from before the run-up."""
        assert self.run
        assert self.position is not None
        unstable = np.flatnonzero(~np.isfinite(self.run.amplitudes))
        last = max(float(unstable[0] if unstable.size else len(self.run.speeds)) - 1, 0.0)
        if self.position >= last:
            self.stop()
            return
        self.position = min(self.position + PER_SECOND * elapsed, last)
        indices = np.arange(len(self.run.speeds))
        self.gamma = float(np.interp(self.position, indices, self.run.speeds))
        self.visitor.change(lambda state: state.changed("gamma", self.gamma))

    def take(self, answer: SolverAnswer | None, shapes: SampledModes) -> None:
        """Take up a change, and the answer at the present speed."""
        self.drawn = self.inputs
        if self.visitor.state.forced_response and self.run and answer and answer.solution:
            amplitude = self.visitor.state.view.amplitude
            self.field = scaled_response(self.run, answer.solution, shapes, amplitude)

    def frequency(self, gamma: float) -> float:
        """Frequency [1/T*] of the force at a speed."""
        return (self.run.per_rev if self.run else 0) * gamma

    def displacement(self, time: float, gamma: float) -> np.ndarray:
        """Displacement (n, 2) `time` [T*] later."""
        self.phase = (self.phase + time * self.frequency(gamma)) % (2 * np.pi)
        return (self.field * np.exp(1j * self.phase)).real

    def colour_range(self, shapes: SampledModes, colouring: str, amplitude: float) -> float:
        """Value at the end of the colour map."""
        if colouring == "displacement":
            return max(PEAK * amplitude, 1e-9)
        strain = np.abs(np.diff(self.field[:, 0]) / np.diff(shapes.x))
        return max(float((np.abs(shapes.strain) + strain).max()), 1e-9)


def scaled_response(
    run: RunUp, solution: Solution, shapes: SampledModes, amplitude: float
) -> np.ndarray:
    """Response (n, 2) at the stations of the shapes, drawn in the square root of its size; empty
    where the beam is unstable, as it may be before a run-up begins."""
    field = response(solution, run.per_rev * solution.beam.gamma, run.damping, shapes.x)
    if not np.isfinite(field).all():
        return np.zeros((0, 2))
    largest = float(np.abs(field).max())
    share = min(largest / max(float(np.nanmax(run.amplitudes)), 1e-300), 1.0)
    return field * (PEAK * amplitude * math.sqrt(share) / max(largest, 1e-300))


# The tab

HEIGHT = 190  # [px] of the chart
STYLES: dict[str, uplot.Series] = {
    "amplitude": {"stroke": COLOURS["bending"], "width": 2, **LINE},
    "resonances": dot("#ffffff", MARK, 7),
    "beam": dot("#D55E00", "#ffffff", 11),
}
AMPLITUDE = Measure("tip, times at rest", "")
START = "Run up from rest"
FORCES = {f"{k} × per revolution": k for k in PER_REV}
ABOVE, BELOW = 1.5, 1e-4  # ends of the amplitude axis, over the largest amplitude
NOTE = (
    "A force spread over the beam like its weight, repeating k times per revolution. The curve is"
    " the steady linear response of the tip at each speed, with the same damping ratio for every"
    " mode; 1 is the deflection at rest under the same force. In the picture, small responses are"
    " enlarged (square root), and the speed rises slowly near a resonance."
)


class RunUpTab(Feature):
    """The force, the chart of amplitudes and the resonances."""

    def __init__(self, visitor: Visitor, playback: RunUpPlayback):
        super().__init__(visitor)
        self.playback, gui = playback, visitor.client.gui
        force = gui.add_dropdown("force", tuple(FORCES), hint="It excites along the line ω = kγ")
        visitor.bind_control(
            force,
            lambda state: next(name for name, k in FORCES.items() if k == state.force_per_rev),
            lambda state, name: replace(state, force_per_rev=FORCES.get(name, state.force_per_rev)),
        )
        low, high = (100 * end for end in DAMPING)
        hint = "Damping ratio of every mode; 100 % is critical damping"
        damping = gui.add_slider("damping ζ [%]", low, high, 0.1, low, hint=hint)
        visitor.bind_control(damping, lambda state: 100 * state.damping, with_damping)
        hint = "The speed rises through the resonances, then returns to what it was"
        self.button = gui.add_button(START, hint=hint)
        on_press(self.button, lambda _: playback.start_or_stop())
        self.plot = Plot(gui, STYLES, HEIGHT, log=True, visible=False)
        self.texts = gui.add_html(small(NOTE))

    @property
    def inputs(self) -> tuple[object, ...]:
        """The run-up, and the beam on it."""
        return *self.playback.inputs, self.visitor.answer

    def show(self) -> None:
        """Show the run-up with the beam on it, or why there is none."""
        playback, run, answer = self.playback, self.playback.run, self.visitor.answer
        self.button.label = "Stop" if playback.running else START
        self.plot.handle.visible = run is not None
        if run is None:
            set_html(
                self.texts, small(playback.answer.message if playback.answer else NOTE, "note")
            )
            return
        along = measure("gamma", run.beam.units)
        gamma = answer.beam.gamma if answer and answer.beam else 0.0
        ranges = (0.0, float(run.speeds[-1])), amplitude_range(run)
        self.plot.show(*run_lines(run, gamma), (along, AMPLITUDE), *ranges)
        set_html(self.texts, resonance_table(run, along) + small(NOTE))


def with_damping(state: State, percent: object) -> State:
    """With another damping ratio [%]."""
    ratio = percent / 100 if isinstance(percent, int | float) else percent
    return replace(state, damping=max(clip(ratio, DAMPING[1], state.damping), DAMPING[0]))


def amplitude_range(run: RunUp) -> Range:
    """Ends of the logarithmic axis of amplitudes."""
    known = run.amplitudes[np.isfinite(run.amplitudes)]
    low, high = (float(known.min()), float(known.max())) if known.size else (1.0, 1.0)
    return max(low, BELOW * high) / ABOVE, ABOVE * high


def run_lines(run: RunUp, gamma: float) -> tuple[np.ndarray, dict[str, list[np.ndarray]]]:
    """Speeds (n,) and the lines by the groups of STYLES: amplitudes, resonances, the beam at a
    speed."""
    own = [gamma] if gamma <= run.speeds[-1] else []
    x = np.union1d(run.speeds, own)
    amplitudes = np.interp(x, run.speeds, run.amplitudes)
    peaks = [(run.speeds[np.argmin(abs(run.speeds - r.at))], run.peak(r)) for r in run.resonances]
    beam = [(at, float(np.interp(at, x, amplitudes))) for at in own]
    return x, {
        "amplitude": [amplitudes],
        "resonances": [marks(x, peaks)],
        "beam": [marks(x, beam)],
    }


def resonance_table(run: RunUp, along: Measure) -> str:
    """Speed, frequency and amplitude of the resonances."""
    if not run.resonances:
        return small("No resonance in this range.")
    across = frequencies(run.beam.units)
    heads = ("mode", f"at {along.head}", across.label, "tip moves")
    rows = [
        (
            f"<b>{one.branch}</b>",
            along.number(one.at, 4),
            across.number(one.frequency, 3),
            f"{run.peak(one):.3g} ×",
        )
        for one in run.resonances
    ]
    return table("run-up", heads, rows)
