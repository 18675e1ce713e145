"""Motions of the experiment as background jobs compute them, why there is none, and what the scene
plays of them."""

import math
from typing import Any, NamedTuple, Self

import numpy as np

from beamviz.beam import Beam
from beamviz.drawing.modes import stations
from beamviz.drawing.motion import MotionShapes, dominant_frequency, drawn_beam
from beamviz.drawing.text import error_text
from beamviz.dynamics import Motion, motion
from beamviz.dynamics.linear import LinearMotion, motion_without_stiffening
from beamviz.dynamics.pull import PulledBeam, pulled
from beamviz.errors import BeamvizError, InvalidInput
from beamviz.explorer import page
from beamviz.explorer.clock import suitable_rate
from beamviz.explorer.experiment import Experiment
from beamviz.explorer.film import Film, HeldShapes, time_text
from beamviz.explorer.jobs import Answer
from beamviz.explorer.snapshot import Inputs
from beamviz.explorer.solutions import case_error
from beamviz.explorer.state import Case, State
from beamviz.solver import interruption, solve

JOB, PULL_JOB = "motion", "pull"
TOLERANCE = 1e-3  # [L] of the tip, half a pixel of a scene of 500 pixels
POINTS, MOST_POINTS = 40, 1601  # of the results, for each T* and in all
LONGEST = 40.0  # [s] on the screen
LINES = 5  # modes whose frequencies are in the spectrum
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
        return cls(case.beam, tuple((name, case.options[name]) for name in names), experiment)

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
                second = error_text(error, beam)
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
    """A computed motion, its spectrum, its greatest stress and the frequencies of the modes at its
    end, ready to be shown. second: that without stiffening, or the reason why there is none, ""
    where none is asked for; since: from when on [T*] the spectrum is taken; modes: label, family
    and frequency [1/T*] of each; film: what the scene plays."""

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
        self.spectrum, self.greatest_stress = found.spectrum(self.since), found.greatest_stress
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


def answer_of(inputs: Inputs) -> Answer[MotionRequest, Computed] | None:
    """The last motion; None before the first, and where the state describes none."""
    return inputs.job_answer(JOB) if wanted(inputs.state) else None


def is_before(inputs: Inputs) -> bool:
    """Whether the motion shown is not yet that of the state, which is being computed."""
    answer = answer_of(inputs)
    return answer is not None and answer.request != wanted(inputs.state)


class PullRequest(NamedTuple):
    """A beam that is held, and where. number: of the hold, as what was shown of an earlier one is
    not shown again."""

    beam: Beam
    options: tuple[tuple[str, Any], ...]
    at: float
    deflection: float
    number: int

    @classmethod
    def of(cls, state: State) -> Self:
        """That of a state in which the beam is held. Raises InvalidInput for a number out of
        range."""
        hold = state.hold
        assert hold
        options = tuple((name, state.case.options[name]) for name in MODEL)
        return cls(state.case.beam, options, hold.at, hold.deflection, hold.number)

    def is_of(self, state: State) -> bool:
        """Whether it is the beam of a state, and where it is held, by any distance."""
        if not state.hold:
            return False
        try:
            now = PullRequest.of(state)
        except InvalidInput:
            return False
        return now._replace(deflection=self.deflection) == self

    def pulled(self) -> PulledBeam:
        """The beam as it is held. Raises the errors of `pulled`."""
        return pulled(self.beam, self.deflection, self.at, **dict(self.options))


def film_reads(inputs: Inputs) -> tuple[Any, ...]:
    """The beam as it was held last since it was taken, and the last motion if the scene shows
    that."""
    state, held = inputs.state, inputs.job_answer(PULL_JOB)
    held = held if held and held.request.is_of(state) else None
    return held, (answer_of(inputs) if state.in_motion else None)


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


def played_reads(inputs: Inputs, film: Film, moment: float) -> tuple[Any, ...]:
    """What the picture of a motion at a moment [T*] depends on, besides that without it."""
    diverged = film.diverged is not None and moment >= film.diverged
    return inputs.state.view, inputs.scale, film.has_body(moment), diverged
