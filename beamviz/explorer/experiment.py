"""The motion in time that a visitor has chosen: how the beam starts, what turns the hub and happens
to the mass."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from operator import attrgetter
from typing import Any, NamedTuple, Self

from beamviz.beam import Beam
from beamviz.checks import check_choice, check_float
from beamviz.dynamics.drives import Hub, Ramp
from beamviz.errors import InvalidInput
from beamviz.explorer.declarations import Key, choice, number_key, switch_key
from beamviz.explorer.state import Slice, State
from beamviz.input_files import check_keys
from beamviz.lessons.model import Lesson
from beamviz.scene import check_bool, inline_toml

STOP = 0.1  # [T*] in which a hub stops dead


class SliderRange(NamedTuple):
    """The range of a number of an experiment."""

    limits: tuple[float, float]
    slider: tuple[float, float, float]  # its ends and its step


RANGES = {
    "pull": SliderRange((-50.0, 50.0), (-5.0, 5.0, 0.05)),
    "pull_at": SliderRange((0.05, 1.0), (0.05, 1.0, 0.001)),  # at the clamp a force moves nothing
    "B1": SliderRange((-0.5, 0.5), (-0.3, 0.3, 0.005)),
    "B2": SliderRange((-0.5, 0.5), (-0.3, 0.3, 0.005)),
    "B3": SliderRange((-0.5, 0.5), (-0.3, 0.3, 0.005)),
    "within": SliderRange((0.1, 60.0), (0.5, 30.0, 0.5)),
    "torque": SliderRange((-50.0, 50.0), (-5.0, 5.0, 0.05)),
    "inertia": SliderRange((0.01, 1000.0), (0.05, 5.0, 0.05)),
    "body_at": SliderRange((0.05, 60.0), (0.5, 30.0, 0.5)),
    "damping": SliderRange((0.0, 0.2), (0.0, 0.05, 0.001)),
    "until": SliderRange((0.5, 60.0), (2.0, 40.0, 1.0)),
}
START_MODES = ("B1", "B2", "B3")  # that a motion may start in
ALTERNATIVES = {
    "start": {
        "pulled": "is held at rest, then let go",
        "modes": "swings in its modes",
    },
    "hub": {
        "constant": "turns at its speed",
        "smooth": "speeds up from rest, smoothly",
        "linear": "speeds up from rest, evenly",
        "stop": "turns and stops dead",
        "torque": "turns and is driven by a torque",
    },
    "body": {
        "stays": "stays on the beam",
        "caught": "is caught",
        "dropped": "is dropped",
    },
}


@dataclass(frozen=True)
class Experiment:
    """A motion to compute, but for the beam. Raises InvalidInput."""

    start: str = "pulled"  # a key of ALTERNATIVES["start"]
    pull: float = 1.0  # force across the beam that holds it until t = 0 [E I / L^2]
    pull_at: float = 1.0  # the point x of the force
    B1: float = 0.1  # amplitude of the mode at the start [L]
    B2: float = 0.0
    B3: float = 0.0
    hub: str = "constant"  # a key of ALTERNATIVES["hub"]
    within: float = 10.0  # time in which the hub speeds up [T*]
    torque: float = 1.0  # on a free hub [E I / L]
    inertia: float = 0.5  # of a free hub [rho A L^3]
    body: str = "stays"  # a key of ALTERNATIVES["body"]: what happens to the mass
    body_at: float = 5.0  # when it happens [T*]
    damping: float = 0.005  # ratio, of all modes
    until: float = 20.0  # the end [T*]
    unstiffened: bool = False  # the theory without stiffening is computed beside it

    def __post_init__(self) -> None:
        for name, allowed in RANGES.items():
            object.__setattr__(self, name, check_float(name, getattr(self, name), *allowed.limits))
        for name, choices in ALTERNATIVES.items():
            check_choice(name, getattr(self, name), choices)
        check_bool("unstiffened", self.unstiffened)

    @classmethod
    def of(cls, values: Any) -> Self:
        """The experiment that a table of a link describes. Raises InvalidInput."""
        values = values if isinstance(values, Mapping) else {"": values}
        check_keys(values, tuple(cls.__dataclass_fields__), "motion")
        return cls(**values)

    @property
    def text(self) -> str:
        """The values that differ from the usual ones, as an inline table of TOML."""
        usual = asdict(PULLED)
        changes = {name: value for name, value in asdict(self).items() if value != usual[name]}
        return inline_toml(changes)

    def changed(self, name: str, value: Any) -> Self:
        """With one value as a browser sent it: numbers are clamped, an invalid one is ignored."""
        if name in RANGES and isinstance(value, int | float) and not isinstance(value, bool):
            low, high = RANGES[name].limits
            value = min(max(float(value), low), high)
        try:
            return replace(self, **{name: value})
        except InvalidInput:
            return self

    @property
    def ramps(self) -> bool:
        """Whether the hub speeds up."""
        return self.hub in ("smooth", "linear")

    @property
    def pulls(self) -> bool:
        """Whether a force holds the beam until it begins."""
        return self.start == "pulled" and self.pull != 0

    @property
    def modes(self) -> dict[str, float]:
        """Amplitudes of the modes that it starts in."""
        given = {name: float(getattr(self, name)) for name in START_MODES}
        in_modes = self.start == "modes"
        return {name: size for name, size in given.items() if size and in_modes}

    def speed(self, gamma: float) -> Ramp | Hub | None:
        """The argument `speed` of `motion`; None for a constant one."""
        if self.hub == "constant":
            return None
        if self.hub == "torque":
            return Hub(self.inertia, self.torque)
        if self.hub == "stop":
            return Ramp(to=0.0, within=STOP, shape="linear", start=gamma)
        return Ramp(to=gamma, within=self.within, shape=self.hub)

    @property
    def event(self) -> float:
        """The time after which nothing changes but by vibration."""
        ends = {"constant": 0.0, "stop": STOP, "torque": self.until if self.torque else 0.0}
        last = ends.get(self.hub, self.within)
        return last if self.body == "stays" else max(last, self.body_at)

    def last_beam(self, beam: Beam, gamma: float) -> Beam:
        """The beam as it is at the end, at the speed gamma: frequencies are the same in both
        directions. Raises InvalidInput for one that is too fast."""
        return beam.replace(gamma=abs(gamma), alpha=0.0 if self.body == "dropped" else beam.alpha)

    @property
    def arguments(self) -> dict[str, Any]:
        """The keywords of `motion` besides beam, speed and model."""
        moment = {"caught": "catch", "dropped": "drop"}.get(self.body)
        return {
            "until": self.until,
            "release": self.pull if self.pulls else 0.0,
            "release_at": self.pull_at,
            "start": self.modes,
            "damping": self.damping,
            **({moment: self.body_at} if moment else {}),
        }


PULLED = Experiment()  # as usual: pulled at the tip and let go


class Hold(NamedTuple):
    """The beam while the visitor pulls it."""

    at: float  # the point x that is pulled
    deflection: float  # of the point [L]
    held: bool = True  # by the pointer; False: the beam is released as soon as the force is known
    number: int = 0  # of the pull, different for each


@dataclass(frozen=True)
class MotionState(Slice):
    """The motion in time of a visitor."""

    experiment: Experiment = field(
        default=PULLED,
        metadata=choice(
            key=Key("motion", Experiment.of, attrgetter("text"), is_table=True), until=("opened",)
        ),
    )
    # The scene shows it.
    in_motion: bool = field(
        default=False, metadata=choice(key=switch_key("moving"), until=("scene", "modes"))
    )
    # At which the motion is paused, or from which it is to continue [T*]; None while it plays.
    moment: float | None = field(
        default=0.0,
        metadata=choice(
            key=number_key("moment", 0.0, RANGES["until"].limits[1]),
            undo="keeps",
            until=("scene",),
        ),
    )
    # Of the beam while it is pulled.
    hold: Hold | None = field(default=None, metadata=choice(undo="ends", led="ends"))

    @property
    def in_hand(self) -> bool:
        return self.hold is not None

    def at_home(self, opened: Self) -> Self:
        return replace(self, experiment=opened.experiment, in_motion=opened.in_motion)


def of_lesson(state: State, lesson: Lesson) -> State:
    """With the motion with which a lesson begins."""
    experiment = Experiment(**lesson.motion)
    return state.with_values(MotionState, experiment=experiment, in_motion=bool(lesson.motion))


def with_experiment(state: State, experiment: Experiment) -> State:
    """With a motion in time, from its beginning, in the scene; a mass that is caught or dropped is
    restored where there is none."""
    state = state.after("motion")
    if experiment.body != "stays" and not state.case.numbers["alpha"]:
        state = state.changed("alpha", state.last_alpha)
    state = state.changed("all_modes", False)
    return state.with_values(MotionState, experiment=experiment, in_motion=True, moment=0.0)


def with_hold(state: State, hold: Hold | None) -> State:
    """With the beam as it is pulled; None where it is not."""
    return state.with_values(MotionState, hold=hold)
