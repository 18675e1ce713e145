"""Motions of the experiment as background jobs compute them, why there is none, and what the scene
plays of them."""

import math
from typing import Any, NamedTuple, Self

import numpy as np

from beamviz.beam import Beam
from beamviz.drawing.modes import stations
from beamviz.drawing.motion import MotionShapes, dominant_frequency, drawn_beam
from beamviz.drawing.text import error_text, length_text
from beamviz.dynamics import Motion, motion
from beamviz.dynamics.linear import LinearMotion, motion_without_stiffening
from beamviz.dynamics.pull import PulledBeam, pulled
from beamviz.errors import BeamvizError, InvalidInput
from beamviz.explorer import page
from beamviz.explorer.clock import suitable_rate
from beamviz.explorer.experiment import Experiment, MotionState
from beamviz.explorer.film import Film, HeldShapes, time_text
from beamviz.explorer.jobs import Answer
from beamviz.explorer.snapshot import Inputs
from beamviz.explorer.solutions import case_error
from beamviz.explorer.state import Case, State
from beamviz.solver import interruption, solve

JOB, PULL_JOB = "motion", "pull"
# Deflection [L] by the theory of small ones from which a force folds the soft tip of a blade, whose
# fast vibration after the release is not resolved then; and that by the force offered instead.
FOLDED, SAFE = 0.5, 0.07
TOLERANCE = 1e-3  # [L] of the tip, half a pixel of a scene of 500 pixels
POINTS, MOST_POINTS = 40, 1601  # of the results, for each T* and in all
LONGEST = 40.0  # [s] on the screen
LINES = 5  # modes whose frequencies are in the spectrum
MODEL = ("strain", "curvature", "state")  # options of `solve` that a motion has too


class Obstacle(NamedTuple):
    """Why a motion cannot be computed."""

    reason: str
    remedy: str = ""  # a button (HTML) that removes the reason, if any
    of_beam: bool = True  # no experiment with this beam and model can be computed


class MotionRequest(NamedTuple):
    """A motion to compute: its beam, options of `solve`, and the experiment."""

    beam: Beam
    options: tuple[tuple[str, Any], ...]
    experiment: Experiment

    @classmethod
    def of(cls, case: Case, experiment: Experiment) -> Self:
        """The request for a case. Raises InvalidInput for a number out of range."""
        names = (*MODEL, "plane", "stiffening", "softening")
        return cls(case.beam, tuple((name, case.options[name]) for name in names), experiment)

    @property
    def obstacle(self) -> "Obstacle | None":
        """The first reason why this motion cannot be computed; None if it can."""
        options, experiment, units = dict(self.options), self.experiment, self.beam.units
        if experiment.body != "stays" and experiment.body_at > experiment.until:
            return Obstacle(
                f"The mass is {experiment.body} at {time_text(experiment.body_at, units)}, after"
                f" the end of the motion at {time_text(experiment.until, units)}: make the motion"
                " longer, or choose an earlier time.",
                of_beam=False,
            )
        if options["plane"] != "chordwise":
            return Obstacle(
                "A motion in time is computed in the plane of rotation alone, and this beam is"
                " shown out of it.",
                page.button("Vibrate in plane", data_set="plane", data_value="chordwise"),
            )
        for term in ("stiffening", "softening"):
            if not options[term]:
                return Obstacle(
                    "A motion in time has all effects of rotation; the theory without stiffening is"
                    " below.",
                    page.button(f"Switch {term} on", data_set=term, data_value=True),
                )
        if experiment.start == "pulled" and self.bearable_force is not None:
            deflection = length_text(abs(self.deflection(experiment.pull)), units, 2)
            return Obstacle(
                "This force would fold the blade at its soft end: the theory of small deflections"
                f" gives a deflection of {deflection} there.",
                page.button("Pull it less", data_do="motion.less"),
                of_beam=False,
            )
        if self.beam.spin_up:
            return Obstacle(
                "A motion in time has no constant spin-up: how the speed changes is chosen below.",
                page.button("Set the spin-up to 0", data_set="spin_up", data_value=0),
            )
        return None

    @property
    def bearable_force(self) -> float | None:
        """A force that bends a blade by SAFE, where that of the experiment would fold it; else
        None."""
        deflection = self.deflection(self.experiment.pull)
        if self.beam.is_prismatic or abs(deflection) < FOLDED:
            return None
        return float(f"{self.experiment.pull * SAFE / abs(deflection):.2g}")

    def deflection(self, force: float) -> float:
        """The deflection [L] of the point that a force [E I / L^2] pulls, of the beam at rest,
        by the theory of small ones: force times int (at - x)^2 / EI dx."""
        blade, at = self.beam.blade, self.experiment.pull_at
        if blade is None:
            return force * at**3 / 3
        breaks = np.array([x for x in blade.breaks if x < at] + [at])
        xi, w = np.polynomial.legendre.leggauss(8)
        half = np.diff(breaks)[:, None] / 2
        x = breaks[:-1, None] + half * (xi + 1)
        return float(force * (half * w * (at - x) ** 2 / blade.at("bending", x)).sum())

    def computed(self) -> "Computed":
        """The motion. Raises the errors of `motion`, and Cancelled."""
        if obstacle := self.obstacle:
            raise InvalidInput(obstacle.reason)
        beam, experiment = self.beam, self.experiment
        options = {name: value for name, value in self.options if name in MODEL}
        given: dict[str, Any] = {
            **experiment.arguments,
            "speed": experiment.speed(beam.gamma),
            "tolerance": TOLERANCE,
            "points": min(math.ceil(POINTS * experiment.until) + 1, MOST_POINTS),
        }
        result = motion(beam, **given, **options, progress=MotionProgress(experiment.until))
        second: LinearMotion | str = ""
        if experiment.unstiffened:
            try:
                progress = MotionProgress(experiment.until)
                second = motion_without_stiffening(beam, **given, progress=progress)
            except BeamvizError as error:
                second = error_text(error, beam)
        return Computed(self, result, second)


class MotionProgress:
    """Reports the progress of a motion to its job. It is computed an unknown number of times, with
    ever finer steps; the fraction done after n of them is taken to be 1 - 1 / 2^n."""

    def __init__(self, until: float):
        self.until, self.runs, self.last = until, 0, 0.0

    def __call__(self, t: float) -> None:
        """Raises Cancelled."""
        self.runs += t < self.last
        self.last = t
        interruption.get()(1 - 0.5 ** (self.runs + t / self.until))


class Computed:
    """A computed motion, its spectrum, its greatest stress and the frequencies of the modes at its
    end.

    second: the motion without stiffening, or the reason why there is none, "" where none is asked
    for; since: the time [T*] from which on the spectrum is taken; modes: label, family and
    frequency [1/T*] of each; film: what the scene plays.
    """

    def __init__(self, request: MotionRequest, result: Motion, second: LinearMotion | str):
        self.request, self.motion, self.second = request, result, second
        self.beam, self.experiment = request.beam, request.experiment
        shapes = MotionShapes(result)
        other = None if isinstance(second, str) else MotionShapes(second)
        units = self.beam.units
        rate = suitable_rate(dominant_frequency(result), float(abs(result.gamma).max()), units)
        rate = max(rate, float(result.t[-1]) / LONGEST)
        self.film = Film(drawn_beam(result), shapes, other, rate, result.has_mass)
        self.since = self.experiment.event if self.experiment.event < 0.7 * result.t[-1] else 0.0
        self.spectrum, self.greatest_stress = result.spectrum(self.since), result.greatest_stress
        options = {name: value for name, value in request.options if name in MODEL}
        try:
            last = self.experiment.last_beam(self.beam, float(result.gamma[-1]))
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
    experiment = state.slice(MotionState).experiment
    if obstacle_of(state.case, experiment):
        return None
    return MotionRequest.of(state.case, experiment)


def obstacle_of(case: Case, experiment: Experiment) -> Obstacle | None:
    """Why a case has no motion; None if that can be computed."""
    try:
        return MotionRequest.of(case, experiment).obstacle
    except InvalidInput as error:
        return Obstacle(f"There is no motion: {case_error(str(error), case)}.")


def can_move(state: State) -> bool:
    """Whether some experiment with the beam and the model of a state has a motion."""
    obstacle = obstacle_of(state.case, state.slice(MotionState).experiment)
    return obstacle is None or not obstacle.of_beam


def answer_of(inputs: Inputs) -> Answer[MotionRequest, Computed] | None:
    """The last motion; None before the first, and where the state describes none."""
    return inputs.job_answer(JOB) if wanted(inputs.state) else None


def is_before(inputs: Inputs) -> bool:
    """Whether the motion shown is not yet that of the state, which is being computed."""
    answer = answer_of(inputs)
    return answer is not None and answer.request != wanted(inputs.state)


class PullRequest(NamedTuple):
    """A beam that the visitor pulls, and how."""

    beam: Beam
    options: tuple[tuple[str, Any], ...]  # of `pulled`
    at: float  # the point x that is pulled
    deflection: float  # of the point [L]
    number: int  # of the pull: an answer to an earlier one is not shown again

    @classmethod
    def of(cls, state: State) -> Self:
        """The request for a state in which the beam is pulled. Raises InvalidInput for a number out
        of range."""
        hold = state.slice(MotionState).hold
        assert hold
        options = tuple((name, state.case.options[name]) for name in MODEL)
        return cls(state.case.beam, options, hold.at, hold.deflection, hold.number)

    def is_of(self, state: State) -> bool:
        """Whether it is the beam of a state, and where it is held, by any distance."""
        if not state.slice(MotionState).hold:
            return False
        try:
            now = PullRequest.of(state)
        except InvalidInput:
            return False
        return now._replace(deflection=self.deflection) == self

    def pulled(self) -> PulledBeam:
        """The beam as it is held. Raises the errors of `pulled`."""
        return pulled(self.beam, self.deflection, self.at, **dict(self.options))


def film_of(inputs: Inputs) -> Film | None:
    """What the scene plays instead of modes: the beam as it was held last since it was taken, or
    the last motion if the scene shows that."""
    state, held = inputs.state, inputs.job_answer(PULL_JOB)
    if held and held.result and held.request.is_of(state):
        beam = held.request.beam
        x = stations(beam.beta if beam.alpha else 1.0)
        shapes = HeldShapes(beam, x, held.result.position(x))
        return Film(beam, shapes, None, 1.0, lambda _: True)
    answer = answer_of(inputs) if state.slice(MotionState).in_motion else None
    return answer.result.film if answer and answer.result else None
