"""The run-up in the page: the speed rises, and the beam shows how far the force drives it there."""

import threading
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any

import numpy as np
from viser import GuiApi, uplot

from beamviz.beam import Beam
from beamviz.display_units import Measure, frequencies, measure
from beamviz.drawing.modes import Shapes
from beamviz.errors import BeamvizError, InvalidInput
from beamviz.explorer.features.loci_chart import FULL, PER_REV, span
from beamviz.explorer.jobs import Latest, stale
from beamviz.explorer.page.html import SMALL, table
from beamviz.explorer.page.inputs import Listener, heard
from beamviz.explorer.page.plot_style import COLOURS, LINE, MARK, add_plot, axes, dot
from beamviz.explorer.request import Wanted
from beamviz.frequency_loci.forced_response import DAMPING, RunUp, response, run_up
from beamviz.scene import clip
from beamviz.server.log import RateLimitedLog
from beamviz.solver.solution import Solution

PER_SECOND = 6.0  # speeds of the run that are passed; they are close together near resonances
LARGEST = 2.0  # times the amplitude set for the picture: how far the highest peak is drawn
USUAL_DAMPING = 0.02

log = RateLimitedLog(__name__)


@dataclass(frozen=True)
class Ask:
    """A run that is wanted."""

    beam: Beam
    options: dict[str, Any]
    per_rev: int
    damping: float

    def computed(self) -> RunUp:
        """The run, as far as the loci chart keeps its axis."""
        stop = FULL * span(self.beam, "gamma")[1]
        return run_up(self.beam, self.per_rev, self.damping, stop, **self.options)


@dataclass(frozen=True)
class Run:
    """What came of it: the run, or in `words` why there is none."""

    ask: Ask
    run: RunUp | None = None
    words: str = ""


class Runs(Latest[Ask, Run]):
    """The latest run of one visitor."""

    def answered(self, wanted: Ask) -> Run:
        """Compute a run."""
        try:
            return Run(wanted, wanted.computed())
        except BeamvizError as error:
            return Run(wanted, words=str(error))
        except Exception as error:  # a mistake of ours must not end a visitor's session
            log.error("run-up", wanted, error)
            return Run(wanted, words=f"unexpected: {error}")


class Ride:
    """The speed on its way up. Callbacks choose, start and stop; the animator advances."""

    def __init__(self, pool: Executor, wake: Callable[[], None]):
        self.runs, self.wake = Runs(pool, wake), wake
        self.per_rev, self.damping = 1, USUAL_DAMPING
        self.asked: Ask | None = None
        self.place: float | None = None  # among the speeds of the run, None while it stands
        self.shown = False  # the picture shows the response, not a mode
        self.drawn: tuple = ()
        self.phase = 0.0  # [rad] of the force
        self.field: np.ndarray = np.zeros((0, 2))

    # What the visitor chooses, from any thread.

    def choose(self, per_rev: int) -> None:
        """How often the force comes in a turn."""
        if per_rev in PER_REV:
            self.per_rev = per_rev
            self.forget()

    def damp(self, damping: Any) -> None:
        """Another damping ratio."""
        damping = max(clip(damping, DAMPING[1], self.damping), DAMPING[0])
        if damping != self.damping:
            self.damping = damping
            self.forget()

    def start(self, wanted: Wanted) -> None:
        """Ride from rest; what is no beam is told by the table of modes."""
        try:
            beam = wanted.beam()
        except InvalidInput:
            return
        self.asked = Ask(beam, wanted.options, self.per_rev, self.damping)
        self.place, self.shown = 0.0, True
        self.runs.want(self.asked)

    def stop(self) -> None:
        """Stay at the speed that was reached."""
        if self.place is not None:
            self.place = None
            self.wake()

    def forget(self) -> None:
        """The run does not hold any more."""
        if self.asked is not None:
            self.place = self.asked = None
            self.wake()

    # What the animator does.

    @property
    def fresh(self) -> bool:
        """Whether something waits to be drawn."""
        return stale(self.drawn, self.state)

    @property
    def state(self) -> tuple:
        """What the tab depends on."""
        return self.found, self.riding

    @property
    def driven(self) -> bool:
        """Whether the picture shows a response: there is a run, and the first of it is taken up."""
        return self.shown and self.run is not None and self.field.size > 0

    @property
    def found(self) -> Run | None:
        """What came of the run that was asked for."""
        answer = self.runs.answer
        return answer if answer and answer.ask is self.asked else None

    @property
    def run(self) -> RunUp | None:
        """The run itself."""
        return self.found.run if self.found else None

    @property
    def riding(self) -> bool:
        """Whether the speed is rising."""
        return self.place is not None and self.run is not None

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

    def close(self) -> None:
        """Nothing more is computed."""
        self.runs.close()


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

    def __init__(self, gui: GuiApi, lock: threading.RLock, listener: Listener):
        ride = listener.ride
        force = gui.add_dropdown("force comes", tuple(OFTEN), hint="Along which line kγ to ride")
        heard(force, lock, lambda label: ride.choose(OFTEN.get(label, 0)))
        damping = gui.add_slider(
            "damping ζ [%]",
            100 * DAMPING[0],
            100 * DAMPING[1],
            0.1,
            100 * ride.damping,
            hint="Damping ratio of every mode: at 100 % a beam let go would just not swing",
        )
        heard(damping, lock, lambda value: ride.damp(percent(value)))
        self.button = gui.add_button("Run up from rest")
        self.button.on_click(lambda _: listener.run_up())
        nothing = (np.array([0.0, 1.0]), np.ones(2), np.ones(2), np.ones(2))
        self.plot = add_plot(gui, nothing, STYLES, plain_axes(""), HEIGHT, visible=False)
        self.table = gui.add_html(f'<div style="{SMALL}">{NOTE}</div>')
        self.known: RunUp | None = None

    def show(self, ride: Ride, gamma: float) -> None:
        """Show the run, with the beam of the scene at its speed gamma on it."""
        self.button.label = "Stop" if ride.riding else "Run up from rest"
        run = ride.run
        self.plot.visible = run is not None
        if run is None:
            self.known = None
            self.table.content = words(ride.found)
            return
        along = measure("gamma", run.beam.units)
        if run is not self.known:
            self.known = run
            self.plot.axes = plain_axes(along.label)
            self.plot.scales = scales(run, along)
            self.table.content = met(run, along) + f'<div style="{SMALL}">{NOTE}</div>'
        self.plot.data = series(run, along, gamma)


def plain_axes(label: str) -> tuple[uplot.Axis, ...]:
    """The axes; a logarithmic one would have nine lines to each power of ten."""
    x, y = axes(label, TIP)
    return x, {**y, "grid": {"show": False}, "ticks": {"show": False}}


def percent(value: object) -> object:
    """A per cent as a share; what is no number stays what it is."""
    return value / 100 if isinstance(value, int | float) else value


def words(found: Run | None) -> str:
    """Why there is no run, or what one is."""
    return f'<div role="note" style="{SMALL}">{found.words if found else NOTE}</div>'


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
