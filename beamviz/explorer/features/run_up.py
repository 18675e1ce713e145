"""The run-up in the page: the speed rises, and the beam shows how far the force drives it there."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from viser import uplot

from beamviz.beam import Beam
from beamviz.display_units import Measure, frequencies, measure
from beamviz.drawing.modes import Shapes
from beamviz.errors import InvalidInput
from beamviz.explorer.features.loci_chart import PER_REV
from beamviz.explorer.jobs import Answer, SolverAnswer
from beamviz.explorer.page.html import SMALL
from beamviz.explorer.page.style import COLOURS, LINE, MARK, add_plot, axes, dot
from beamviz.explorer.state import Case, State
from beamviz.explorer.visitor import Feature, Visitor, on_press
from beamviz.exports.html_tables import table
from beamviz.frequency_loci.chart_range import FULL, chart_range
from beamviz.frequency_loci.forced_response import DAMPING, RunUp, response, run_up
from beamviz.scene import clip
from beamviz.solver.solution import Solution

PER_SECOND = 6.0  # speeds of the run that are passed; they are close together near resonances
LARGEST = 2.0  # times the amplitude set for the picture: how far the highest peak is drawn


@dataclass(frozen=True)
class Ask:
    """A run-up to compute."""

    case: Case
    per_rev: int
    damping: float

    def computed(self) -> RunUp:
        """The run, as far as the loci chart keeps its axis."""
        beam = self.case.beam()
        stop = FULL * chart_range(beam, "gamma")[1]
        return run_up(beam, self.per_rev, self.damping, stop, **self.case.options)


class RunUpDemo(Feature):
    """The speed on its way up. The visitor starts and stops it; the frame loop advances it."""

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        self.runs = visitor.job("run-up", Ask.computed)
        self.asked: Ask | None = None
        self.place: float | None = None  # among the speeds of the run, None while it stands
        self.gamma: object = None  # the speed that was set last
        self.shares: tuple = ()  # of the modes in the picture, when the run-up began
        self.drawn: tuple = ()  # what the scene has taken up
        self.phase = 0.0  # [rad] of the force
        self.field: np.ndarray = np.zeros((0, 2))

    def add_tab(self) -> None:
        """Build the controls and the chart."""
        self.tab = RideTab(self.visitor, self.start_or_stop)

    def start_or_stop(self) -> None:
        """Start from rest, or stay at the speed that was reached; what is no beam is told by the
        table of modes."""
        if self.running:
            self.stop()
            return
        state = self.visitor.state
        try:
            state.case.beam()
        except InvalidInput:
            return
        self.asked = Ask(state.case, state.force_per_rev, state.damping)
        self.place, self.gamma = 0.0, state.case.numbers["gamma"]
        self.shares = state.view.shares
        self.visitor.change(
            lambda state: state.changed("all_modes", False).changed("per_rev", True)
        )
        self.runs.request(self.asked)

    def stop(self) -> None:
        """Stay at the speed that was reached."""
        self.place = None
        self.visitor.wake()

    # What the frame loop does.

    def step(self, elapsed: float) -> None:
        """Raise the speed, `elapsed` seconds later. Another speed stops the run-up; another beam,
        model or force ends it."""
        with self.visitor.lock:
            state, asked = self.visitor.state, self.asked
            if asked is None:
                return
            start = asked.case.numbers["gamma"]
            case = state.case.changed("gamma", start)
            if (case, state.force_per_rev, state.damping) != (
                asked.case, asked.per_rev, asked.damping
            ):  # fmt: skip
                self.place = self.asked = None
            elif state.case.numbers["gamma"] != self.gamma:
                self.place = None
            if state.view.shares != self.shares:
                self.shares = ()
            gamma = self.advance(elapsed) if self.running else None
            if gamma is not None:
                self.gamma = gamma
                self.visitor.follow(state.changed("gamma", gamma))

    @property
    def scene_outdated(self) -> bool:
        """Whether the scene has not taken up what came of the run."""
        return self.drawn != (self.found, self.running)

    @property
    def inputs(self) -> tuple:
        """What the tab depends on."""
        return self.found, self.running, self.visitor.answer

    def show(self) -> None:
        """Show the run, with the beam of the scene on it."""
        answer = self.visitor.answer
        self.tab.show(self.found, answer.beam if answer else None, running=self.running)

    @property
    def driven(self) -> bool:
        """Whether the picture shows a response: there is a run, and the first of it is taken up."""
        return self.shares != () and self.run is not None and self.field.size > 0

    @property
    def found(self) -> Answer[Ask, RunUp] | None:
        """What came of the run that was asked for."""
        answer = self.runs.answer
        return answer if answer and answer.request == self.asked else None

    @property
    def run(self) -> RunUp | None:
        """The run itself."""
        return self.found.result if self.found else None

    @property
    def running(self) -> bool:
        """Whether the speed is rising."""
        return self.place is not None and self.run is not None

    @property
    def per_rev(self) -> int:
        """Periods of the force in a revolution."""
        return self.asked.per_rev if self.asked else self.visitor.state.force_per_rev

    def take(self, answer: SolverAnswer | None, shapes: Shapes) -> None:
        """Take up what came of the run, and a solution on its way."""
        self.drawn = (self.found, self.running)
        if self.shares != () and answer and answer.solution:
            self.drive(answer.solution, shapes, self.visitor.state.view.amplitude)

    def advance(self, elapsed: float) -> float | None:
        """The speed gamma `elapsed` seconds later; None where the ride is over."""
        run, place = self.run, self.place
        if run is None or place is None:
            return None
        unsettled = np.flatnonzero(~np.isfinite(run.amplitudes))
        last = float(unsettled[0] - 1 if unsettled.size else len(run.speeds) - 1)
        at = min(place + PER_SECOND * elapsed, max(last, 0.0))
        self.place = at if at < last else None
        return float(np.interp(at, np.arange(len(run.speeds)), run.speeds))

    def drive(self, solution: Solution, shapes: Shapes, amplitude: float) -> None:
        """Take up a solution of the ride: how its points (n, 2) are to be drawn."""
        run = self.run
        if run is None:
            return
        field = response(solution, run.per_rev * solution.beam.gamma, run.damping, shapes.x)
        if not np.isfinite(field).all():  # unstable, as a beam may be before its run begins
            self.field = np.zeros((0, 2))
            return
        far = float(np.abs(field).max())
        share = min(far / max(float(np.nanmax(run.amplitudes)), 1e-300), 1.0)
        size = LARGEST * amplitude * np.sqrt(share) / max(far, 1e-300)
        self.field = field * size

    def largest(self, shapes: Shapes, colouring: str, amplitude: float) -> float:
        """The value at the end of the colour map."""
        if colouring == "displacement":
            return max(LARGEST * amplitude, 1e-9)
        strain = np.abs(np.diff(self.field[:, 0]) / np.diff(shapes.x))
        return max(float((np.abs(shapes.strain) + strain).max()), 1e-9)

    def displaced(self, time: float, gamma: float) -> np.ndarray:
        """Displacement (n, 2) `time` [T*] later."""
        self.phase = (self.phase + time * self.per_rev * gamma) % (2 * np.pi)
        return (self.field * np.exp(1j * self.phase)).real


HEIGHT = 190  # [px]
STYLES: tuple[uplot.Series, ...] = (
    {},
    {"stroke": COLOURS["bending"], "width": 2, **LINE},
    {"stroke": MARK, "width": 0, "points": dot("#ffffff", MARK, 7)},
    {"stroke": MARK, "width": 0, "points": dot("#D55E00", "#ffffff", 11)},
)
TIP = "tip, times at rest"
OFTEN = {f"{k} × per turn": k for k in PER_REV}
MOST = 1.5  # times the largest amplitude: the end of the axis
LEAST = 1e-4  # of the largest amplitude: what is smaller is below the axis
NOTE = (
    "A force acts on every gram of the beam, like its weight on a beam turning in a vertical plane;"
    " it comes back so often in each turn. The curve is the steady linear response of the tip at"
    " each speed, as if held until it has settled, every mode damped by the same ratio;"
    " 1 is the deflection at rest under the same force. In the picture small ones are enlarged"
    " (square root), and time slows near a resonance."
)


class RideTab:
    """Hands on the force and shows the run."""

    def __init__(self, visitor: Visitor, start_or_stop: Callable[[], None]):
        gui = visitor.client.gui
        force = gui.add_dropdown("force comes", tuple(OFTEN), hint="Along which line kγ to run up")
        visitor.bind(
            force,
            lambda state: next(k for k, v in OFTEN.items() if v == state.force_per_rev),
            lambda state, label: replace(
                state, force_per_rev=OFTEN.get(label, state.force_per_rev)
            ),
        )
        damping = gui.add_slider(
            "damping ζ [%]",
            100 * DAMPING[0],
            100 * DAMPING[1],
            0.1,
            100 * DAMPING[0],
            hint="Damping ratio of every mode: at 100 % a beam let go would just not swing",
        )
        visitor.bind(damping, lambda state: 100 * state.damping, damped)
        self.button = gui.add_button("Run up from rest")
        on_press(self.button, lambda _: start_or_stop())
        nothing = (np.array([0.0, 1.0]), np.ones(2), np.ones(2), np.ones(2))
        self.plot = add_plot(gui, nothing, STYLES, plain_axes(""), HEIGHT, visible=False)
        self.table = gui.add_html(f'<div style="{SMALL}">{NOTE}</div>')
        self.known: RunUp | None = None

    def show(self, found: Answer | None, beam: Beam | None, *, running: bool) -> None:
        """Show what came of a run, with the beam of the scene on it."""
        self.button.label = "Stop" if running else "Run up from rest"
        run: RunUp | None = found.result if found else None
        self.plot.visible = run is not None
        if run is None:
            self.known = None
            self.table.content = words(found)
            return
        along = measure("gamma", run.beam.units)
        if run is not self.known:
            self.known = run
            self.plot.axes = plain_axes(along.label)
            self.plot.scales = scales(run, along)
            self.table.content = met(run, along) + f'<div style="{SMALL}">{NOTE}</div>'
        self.plot.data = series(run, along, beam.gamma if beam else 0.0)


def plain_axes(label: str) -> tuple[uplot.Axis, ...]:
    """The axes; a logarithmic one would have nine lines to each power of ten."""
    x, y = axes(label, TIP)
    return x, {**y, "grid": {"show": False}, "ticks": {"show": False}}


def damped(state: State, percent: object) -> State:
    """With another damping ratio, in per cent."""
    ratio = percent / 100 if isinstance(percent, int | float) else percent
    return replace(state, damping=max(clip(ratio, DAMPING[1], state.damping), DAMPING[0]))


def words(found: Answer | None) -> str:
    """Why there is no run, or what one is."""
    return f'<div role="note" style="{SMALL}">{found.message if found else NOTE}</div>'


def scales(run: RunUp, along: Measure) -> dict[str, uplot.Scale]:
    """The ends of both axes; amplitudes on a logarithmic one."""
    known = run.amplitudes[np.isfinite(run.amplitudes)]
    low, high = (float(known.min()), float(known.max())) if known.size else (1.0, 1.0)
    ends = max(low, LEAST * high) / MOST, MOST * high
    return {
        "x": {"time": False, "range": (0.0, along.factor * float(run.speeds[-1]))},
        "y": {"distr": 3, "range": ends},
    }


def series(run: RunUp, along: Measure, gamma: float) -> tuple[np.ndarray, ...]:
    """Speeds, amplitudes, the marks of the resonances, and the mark of the beam."""
    here = float(np.interp(gamma, run.speeds, run.amplitudes))
    x = np.append(run.speeds, gamma)
    order = np.argsort(x, kind="stable")
    amplitudes = np.append(run.amplitudes, here)
    peaks, mark = np.full(len(x), np.nan), np.full(len(x), np.nan)
    for one in run.resonances:
        peaks[np.argmin(abs(run.speeds - one.at))] = run.peak(one)
    if gamma <= run.speeds[-1] * (1 + 1e-9):
        mark[-1] = here
    else:
        order = order[:-1]
    return (along.factor * x[order], amplitudes[order], peaks[order], mark[order])


def met(run: RunUp, along: Measure) -> str:
    """The resonances on the way."""
    if not run.resonances:
        return f'<div style="{SMALL}">No mode is met on this line up to here.</div>'
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
