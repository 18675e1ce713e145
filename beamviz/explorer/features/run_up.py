"""The run-up in the page: the speed rises, and the beam shows how far the force drives it there."""

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any

import numpy as np

from beamviz.beam import Beam
from beamviz.drawing.modes import Shapes
from beamviz.errors import BeamvizError, InvalidInput
from beamviz.explorer.features.loci_chart import FULL, PER_REV, span
from beamviz.explorer.jobs import Latest, stale
from beamviz.explorer.request import Wanted
from beamviz.frequency_loci.forced_response import DAMPING, RunUp, response, run_up
from beamviz.server.log import RateLimitedLog
from beamviz.solver.solution import Solution
from beamviz.view_options import within

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
        damping = max(within(damping, DAMPING[1], self.damping), DAMPING[0])
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
