"""The state of one visitor: one frozen record that all controls show and each edit replaces.

Values from a browser are validated: an invalid one leaves the state unchanged, except for the
numbers of the beam, which are stored as sent and checked when the beam is solved.
"""

import contextlib
import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from operator import attrgetter
from typing import Any, NamedTuple, Self, TypeVar

import numpy as np

from beamviz.beam import MAX_GAMMA_OVER_MU, NUMBERS, PARAMETERS, Beam
from beamviz.blade import Blade, Mass
from beamviz.checks import check_float
from beamviz.errors import InvalidInput
from beamviz.explorer.declarations import (
    FIRST_TAB,
    SWITCH,
    Choice,
    Key,
    choice,
    choices_of,
    name_key,
    number_key,
    switch_key,
    whole_key,
)
from beamviz.explorer.experiment import PULLED, RANGES, Experiment
from beamviz.lessons import lesson
from beamviz.scene import (
    GIVEN,
    LINKED,
    MODES,
    PER_REV,
    SECOND_BEAMS,
    Camera,
    Scene,
    ViewOptions,
    check_per_rev,
)
from beamviz.solver.problem import CHOICES, METHODS, OPTIONS, supported_options
from beamviz.units import Units

# Terms of the equations, each on or off.
TERMS = tuple(name for name, option in OPTIONS.items() if option.kind is bool)
NO_COMPARISON, EARLIER = "nothing", GIVEN
COMPARISONS = (NO_COMPARISON, *SECOND_BEAMS)
# View options that neither undo nor a link changes, but for a link to a moment of a motion, which
# pauses it.
LASTING = ("playing", "dark")
STEPS = 200  # that can be undone
BETA_DIGITS = 3  # of a position in the hand: finer than a pointer
PAUSE = 1.0  # [s] after which another edit of the same values is another step
VIEW_KEYS = tuple(entry.name for entry in fields(ViewOptions))
# In a view that was turned to before them, beams would leave the picture.
REFITTED = ("plane", "rotating_frame", "all_modes", "stacked")
AXES = ("over", "across")  # of the map; no number is on both
RATES = (1e-6, 1e6)  # [T*] in a second on the screen
FOLLOWS = "auto"  # in links: the rate of a clock that is not locked
KEEPS, ENDS = choice(undo="keeps"), choice(undo="ends")  # of fields that no link has
T = TypeVar("T")


@dataclass(frozen=True)
class Case:
    """A beam and its model as entered: a number may be out of range."""

    numbers: dict[str, Any]
    # Keywords of `solve`; `modes` only in `State.shown_case`, as it depends on those shown.
    options: dict[str, Any]
    units: Units | None = None  # these four as in `Beam`
    blade: Blade | None = None
    masses: tuple[Mass, ...] = ()
    root: float = math.inf

    @classmethod
    def of(cls, scene: Scene) -> Self:
        beam = scene.beam
        numbers = {name: getattr(beam, name) for name in NUMBERS}
        options = dict(scene.options)
        return cls(numbers, options, beam.units, beam.blade, beam.masses, beam.root)

    @property
    def structure(self) -> dict[str, Any]:
        """What is no number of the beam, by name."""
        return {name: getattr(self, name) for name in ("units", "blade", "masses", "root")}

    @property
    def values(self) -> dict[str, Any]:
        """Numbers, keywords of `solve` and structure, by name."""
        return self.options | self.structure | self.numbers

    @cached_property
    def beam(self) -> Beam:
        """The beam. Raises InvalidInput, which names a number out of range."""
        return Beam(**self.numbers, **self.structure)

    @property
    def in_range(self) -> bool:
        """Whether all numbers of the beam are in range."""
        with contextlib.suppress(InvalidInput):
            return isinstance(self.beam, Beam)
        return False

    def nearest_beam(self) -> Beam:
        """The beam with each number that is out of range replaced by the nearest one allowed, by
        the default where it is no number."""
        if self.in_range:
            return self.beam
        numbers: dict[str, Any] = {}
        for name, parameter in NUMBERS.items():
            value = self.numbers[name]
            known = isinstance(value, int | float) and not math.isnan(value)
            low, high = parameter.limits
            numbers[name] = min(max(float(value), low), high) if known else getattr(Beam, name)
        numbers["gamma"] = min(numbers["gamma"], MAX_GAMMA_OVER_MU * numbers["mu"])
        return Beam(**numbers, **self.structure)

    @property
    def nearest(self) -> Self:
        """The nearest valid case: with its nearest beam, and options that its method takes."""
        beam = self.nearest_beam()
        numbers = {name: getattr(beam, name) for name in NUMBERS}
        return replace(self, numbers=numbers, options=supported_options(self.options))

    def changed(self, name: str, value: Any) -> Self:
        """With one number or keyword of `solve` changed; a spin-up replaces straight by stable."""
        if name in self.numbers:
            case = replace(self, numbers={**self.numbers, name: value})
            straight = name == "spin_up" and value and self.options["state"] == "straight"
            return case.with_options(state="stable") if straight else case
        if name in TERMS:
            return self.with_options(**{name: bool(value)})
        if name in CHOICES and value in CHOICES[name]:
            case = self.with_options(**{name: value})
            return case.with_resolution() if name == "method" else case
        return self

    def with_resolution(self) -> Self:
        """With the usual resolution where the method does not take the present one, which no
        control shows."""
        unsupported = METHODS[self.options["method"]].unsupported
        names = (name for name in unsupported if OPTIONS[name].resolution)
        return self.with_options(**{name: OPTIONS[name].default for name in names})

    def with_options(self, **options: Any) -> Self:
        return replace(self, options={**self.options, **options})


class Refused(NamedTuple):
    """An entry of a field that was refused."""

    key: str  # of the field
    entry: str  # the text typed
    reason: str


Ray = tuple[np.ndarray, np.ndarray]  # a line of sight in the hub's frame: the eye, another point


@dataclass(frozen=True, eq=False)
class Grip:
    """A body that the visitor drags. The beam's frame keeps its place in the scene meanwhile."""

    sight: Ray  # the line of sight that the body is moved to
    # Distance [L] along the beam from the centre of the body to the point where it was picked up.
    offset: float
    body: int | None = None  # index in `Beam.masses`; None for the concentrated mass
    held: bool = True  # by the pointer; False: the body is only moved under it once more

    def position(self, x: float) -> float:
        """The position, on the beam, of a body whose point in the hand is at the coordinate x."""
        return min(max(round(x - self.offset, BETA_DIGITS), 0.0), 1.0)

    def beta(self, case: Case) -> float | None:
        """The position of the body; None where the case does not have it any more."""
        if self.body is None:
            return case.numbers["beta"]
        return case.masses[self.body].beta if self.body < len(case.masses) else None


class Hold(NamedTuple):
    """The beam while the visitor pulls it."""

    at: float  # the point x that is pulled
    deflection: float  # of the point [L]
    held: bool = True  # by the pointer; False: the beam is released as soon as the force is known
    number: int = 0  # of the pull, different for each


def read_lesson(name: Any) -> str:
    return lesson(str(name)).name


def read_rate(rate: Any) -> float | None:
    return None if rate == FOLLOWS else check_float("rate", rate, *RATES)


def write_rate(rate: float | None) -> float | str:
    return rate or FOLLOWS


@dataclass(frozen=True)
class State:
    """All choices of a visitor, by subject; those of a single feature are in `chosen`. A field with
    metadata is a `Choice`, which says what undo and links do with it."""

    # The beam and the view

    opened: Scene  # by the page, a link or a file; a reset returns to it
    case: Case
    # Of the scene that was opened: `experiment` and `in_motion`.
    opened_motion: tuple[Experiment, bool] = (PULLED, False)
    last_alpha: float = field(default=1.0, metadata=KEEPS)  # of the last beam that had a mass
    view: ViewOptions = field(default_factory=ViewOptions)
    camera: Camera | None = None  # a fixed viewpoint; None to fit the beam into the page
    # The viewpoint to which the visitor has turned the view since then; None where they have not.
    turned: Camera | None = field(default=None, metadata=KEEPS)

    # Lessons

    lesson: str = field(default="", metadata=choice(key=Key("lesson", read_lesson)))  # "" for none
    # The state before the first of the lessons, to which leaving them returns.
    before_lesson: "State | None" = None
    met: frozenset[str] = field(default=frozenset(), metadata=KEEPS)  # whose challenge is met

    # Charts

    over: str = field(default="gamma", metadata=choice(values=PARAMETERS))  # abscissa, also of maps
    # The ordinate of the map.
    across: str = field(
        default="alpha", metadata=choice(values=PARAMETERS, key=name_key("across", PARAMETERS))
    )
    per_rev: tuple[int, ...] = ()  # multiples of the speed in the loci chart

    # The second beam

    comparison: str = field(
        default=NO_COMPARISON,
        metadata=choice(values=COMPARISONS, key=name_key("compare", COMPARISONS[1:])),
    )
    kept: Case | None = None  # to be compared with
    kept_by_edit: bool = False  # by an edit, not by the visitor
    # It is drawn above the first one, not overlaid.
    stacked: bool = field(default=False, metadata=choice(values=SWITCH, key=switch_key("stacked")))

    # The run-up

    # Periods of the force per revolution.
    force_per_rev: int = field(
        default=1, metadata=choice(values=PER_REV, key=whole_key("force", 1, max(PER_REV)))
    )
    # The scene shows the response to the force.
    forced_response: bool = field(default=False, metadata=choice(key=switch_key("response")))
    # The speed during a run-up, shown in place of the beam's; 0 until the run-up is computed, None
    # without one. An edit of the beam ends it.
    run_speed: float | None = field(default=None, metadata=ENDS)

    # The motion in time

    experiment: Experiment = field(
        default=PULLED,
        metadata=choice(key=Key("motion", Experiment.of, attrgetter("text"), is_table=True)),
    )
    # The scene shows it.
    in_motion: bool = field(default=False, metadata=choice(key=switch_key("moving")))
    # At which the motion is paused, or from which it is to continue [T*]; None while it plays.
    moment: float | None = field(
        default=0.0,
        metadata=choice(key=number_key("moment", 0.0, RANGES["until"].limits[1]), undo="keeps"),
    )
    # Time [T*] that passes in a second on the screen, if locked; None: chosen for what is shown.
    rate: float | None = field(
        default=None, metadata=choice(key=Key("rate", read_rate, write_rate))
    )

    # Tabs and lectures

    # The open tab; links check whether there is one of this key.
    tab: str = field(default=FIRST_TAB, metadata=choice(key=Key("tab", str), undo="keeps"))
    # The tab that a presenter had open last, "" for none; the visitor may have opened another one
    # since.
    presented_tab: str = field(default="", metadata=KEEPS)
    # A presenter is followed.
    following: bool = field(default=False, metadata=choice(values=SWITCH, undo="ends"))

    # In the hand

    grip: Grip | None = field(default=None, metadata=ENDS)  # of a body that is dragged
    hold: Hold | None = field(default=None, metadata=ENDS)  # of the beam while it is pulled

    # What the page says of the last edit

    refused: Refused | None = field(default=None, metadata=ENDS)  # the last refused entry
    replaced: str = field(default="", metadata=ENDS)  # notice that the visitor's scene is replaced

    # The visitor's browser

    still: bool = field(default=False, metadata=KEEPS)  # its system prefers reduced motion
    # Parameters of the address with other readers; None until the page has sent its address.
    reserved: tuple[tuple[str, str], ...] | None = field(default=None, metadata=KEEPS)

    # Choices of single features that are not as usual, see `State.__getitem__`.
    chosen: Mapping[Choice[Any], Any] = field(default_factory=dict)

    @classmethod
    def of(cls, scene: Scene) -> Self:
        """The state of a scene, with all other choices as usual."""
        return cls(scene, Case.of(scene)).loaded(scene)

    def loaded(self, scene: Scene) -> Self:
        """With another scene, and its second beam; without one, and without the case kept for
        comparison. With reduced motion it moves only if the last one did."""
        second, kept, stacked = scene.second, None, self.stacked
        comparison = NO_COMPARISON if self.comparison == EARLIER else self.comparison
        if second:
            comparison, stacked = second.choice, second.stacked
            kept = Case.of(scene.second_scene) if comparison == EARLIER else None
        view = replace(scene.view, playing=self.view.playing) if self.still else scene.view
        state = replace(
            self.ended("scene").without_run_up().with_viewpoint(scene.camera),
            case=Case.of(scene),
            view=view,
            per_rev=scene.per_rev,
            comparison=comparison,
            stacked=stacked,
            kept=kept,
            kept_by_edit=False,
            in_motion=False,
            moment=0.0,
            rate=None,
            refused=None,
        )
        return state.changed("over", scene.over).with_mass_kept()

    def with_viewpoint(self, camera: Camera | None) -> Self:
        """Looking from a viewpoint, None to fit the beam into the page, wherever the visitor has
        turned the view to."""
        return replace(self, camera=camera, turned=None, grip=None)

    @property
    def viewpoint(self) -> Camera | None:
        """The viewpoint; None where the beam is fitted into the page."""
        return self.turned or self.camera

    @property
    def outside(self) -> "State":
        """The state without lessons: that before them while one is open."""
        return self.before_lesson or self

    def restored(self, step: Self) -> Self:
        """An earlier or later state, in which what is no choice about the scene is as it is now,
        and nothing is under way."""
        lasting = {name: getattr(self.view, name) for name in LASTING}
        kept = {key: getattr(self, key) for key, choice in SHARED.items() if choice.undo == "keeps"}
        ended = {key: choice.usual for key, choice in SHARED.items() if choice.undo == "ends"}
        chosen = {key: value for key, value in step.chosen.items() if key.undo == "changes"}
        chosen |= {key: value for key, value in self.chosen.items() if key.undo == "keeps"}
        view = replace(step.view, **lasting)
        return replace(step, view=view, chosen=chosen, **kept, **ended)

    def __getitem__(self, choice: Choice[T]) -> T:
        """The value of a choice, of the state or of a feature."""
        if choice.name in SHARED:
            return getattr(self, choice.name)
        return self.chosen.get(choice, choice.usual)

    def with_choice(self, choice: Choice[T], value: T) -> Self:
        """With another value of a choice, of the state or of a feature. A number that is chosen for
        both axes of the map takes the place of the other one."""
        if choice.name in SHARED:
            values: dict[str, Any] = {choice.name: value}
            state = replace(self, **values)
            if state.over != state.across:
                return state
            (other,) = {*AXES} - {choice.name}
            return replace(state, **{other: getattr(self, choice.name)})
        chosen = {other: kept for other, kept in self.chosen.items() if other is not choice}
        return replace(self, chosen=chosen if value == choice.usual else chosen | {choice: value})

    def ended(self, name: str) -> Self:
        """Without the choices of features that last until this value changes."""
        chosen = {key: value for key, value in self.chosen.items() if name not in key.until}
        return replace(self, chosen=chosen)

    @property
    def shown_case(self) -> Case:
        """The case to show: during a run-up with the speed of that."""
        case = self.case.changed("gamma", self.run_speed) if self.run_speed else self.case
        return case.with_options(modes=max(MODES, len(self.view.shares)))

    def to_scene(self) -> Scene:
        """The scene. Raises InvalidInput for a number out of range."""
        options = {name: self.case.options[name] for name in LINKED["model"]}
        return Scene(self.case.beam, options, self.view, self.viewpoint, self.over, self.per_rev)

    @property
    def values(self) -> dict[str, Any]:
        """Fields, view options, keywords of `solve`, the numbers and the structure of the beam, by
        name; choices of features are not among them."""
        return vars(self) | vars(self.view) | self.case.values

    def with_fields(self, **values: Any) -> Self:
        """With other values of fields; the state itself where it has them."""
        return replace(self, **values) if different(values, vars(self)) else self

    def changed(self, name: str, value: Any) -> Self:
        """With the value of that name as a browser sent it. The beam is fitted into the page again
        where it would leave the picture; a switched term keeps the case before for comparison."""
        fitted = self.with_viewpoint(None) if name in REFITTED else self
        if name in VIEW_KEYS:
            view = fitted.view.changed(name, value)
            if name == "all_modes" and view.all_modes:  # from outside, captions would cover beams
                view = replace(view, rotating_frame=True)
            return replace(fitted, view=view)
        if name == "per_rev":
            with contextlib.suppress(InvalidInput):
                return replace(fitted, per_rev=check_per_rev(value))
            return fitted
        if name in SHARED:
            choice = SHARED[name]
            state = fitted.with_choice(choice, choice.picked(value, fitted[choice])).ended(name)
            if name == "comparison":
                return replace(state, kept_by_edit=False)
            return state.without_run_up() if name == "force_per_rev" else state
        if (case := self.case.changed(name, value)) is self.case:
            return self
        kept = fitted.keep_for_comparison() if name in TERMS else fitted
        state = replace(kept, case=case, run_speed=None)
        return (state if name == "gamma" else state.without_run_up()).with_mass_kept()

    def with_body_at(self, body: int, beta: float) -> Self:
        """With a body of `Beam.masses` moved."""
        masses = list(self.case.masses)
        masses[body] = replace(masses[body], beta=beta)
        case = replace(self.case, masses=tuple(masses))
        return replace(self, case=case).without_run_up()

    def with_mass_kept(self) -> Self:
        """Remembering the mass, for the switch that removes and restores it."""
        alpha = self.case.numbers["alpha"]
        known = isinstance(alpha, int | float) and 0 < alpha <= NUMBERS["alpha"].limits[1]
        return self.with_fields(last_alpha=float(alpha)) if known else self

    def without_run_up(self) -> Self:
        """With the beam at its own speed, and without the response to a force: after an edit that
        changes that."""
        return self.with_fields(forced_response=False, run_speed=None)

    def without_motion(self) -> Self:
        """With modes in the scene, not the response to a force or a motion in time."""
        return replace(self, forced_response=False, in_motion=False)

    def with_experiment(self, experiment: Experiment) -> Self:
        """With a motion in time, from its beginning, in the scene; a mass that is caught or dropped
        is restored where there is none."""
        state = self.without_run_up()
        alpha = state.case.numbers["alpha"]
        if experiment.body != "stays" and not alpha:
            state = state.changed("alpha", state.last_alpha)
        state = state.changed("all_modes", False)
        return replace(state, experiment=experiment, in_motion=True, moment=0.0)

    def share(self, value: Any, mode: int) -> Self:
        return replace(self.without_motion(), view=self.view.share(mode, value))

    def only(self, *modes: int) -> Self:
        """With these modes (from 0) in equal shares; the table keeps more modes than usual."""
        usual, known = max(modes) + 1, len(self.view.shares)
        count = known if known > max(usual, MODES) else usual
        shares = tuple(float(k in modes) for k in range(count))
        view = replace(self.view, shares=shares, all_modes=False)
        return replace(self.without_motion(), view=view)

    def differences(self, other: Self) -> set[str]:
        """The names of the values that differ from those of another state and that undo changes."""
        differing = different(vars(self), vars(other))
        if "view" in differing:
            differing |= different(vars(self.view), vars(other.view))
        if "case" in differing:
            differing |= different(self.case.values, other.case.values)
        of_features = {
            choice.name
            for choice in {*self.chosen, *other.chosen}
            if choice.undo == "changes" and self[choice] != other[choice]
        }
        unchanged = {name for name, choice in SHARED.items() if choice.undo != "changes"}
        return differing - {"case", "view", "chosen", *LASTING} - unchanged | of_features

    def keep(self) -> Self:
        """Keep the case, to compare later ones with, unless it has a number out of range."""
        if not self.case.in_range:
            return self
        return replace(self, kept=self.case, comparison=EARLIER, kept_by_edit=False)

    def keep_for_comparison(self) -> Self:
        """Keep the case before an edit, unless the visitor chose what it is compared with."""
        if self.comparison == EARLIER and not self.kept_by_edit:
            return self if self.kept else self.keep()
        if self.comparison not in (NO_COMPARISON, EARLIER) or not self.case.in_range:
            return self
        return replace(self.keep(), kept_by_edit=True)

    def without_edit_kept(self) -> Self:
        """Without the case that an edit has kept: with one that the visitor has chosen, if any."""
        ended: dict[str, Any] = {"kept": None, "comparison": NO_COMPARISON, "kept_by_edit": False}
        return replace(self, **ended) if self.kept_by_edit else self


def different(some: Mapping[str, Any], others: Mapping[str, Any]) -> set[str]:
    """The names of `some` values that differ from those of the same names."""
    return {
        name for name, value in some.items() if value is not others[name] and value != others[name]
    }


SHARED = choices_of(State)  # that are fields of the state, by name


class History:
    """The states for undo and redo. Edits of the same values in quick succession, as by a slider,
    are one step, and so are all of a body while it is in the hand; loading a scene, or the return
    to a presenter, always is a step. undo, redo: return the state to show instead."""

    def __init__(self) -> None:
        self.past: deque[State] = deque(maxlen=STEPS)
        self.future: deque[State] = deque(maxlen=STEPS)
        self.undo = partial(self.move, self.past, self.future)
        self.redo = partial(self.move, self.future, self.past)
        self.edited: set[str] = set()  # names of the values edited last
        self.time = -math.inf  # [s] of the last edit

    def record(self, before: State, after: State, time: float, *, loaded: bool = False) -> None:
        """Record an edit at a time [s]; loaded: another scene, which is a step of its own."""
        if after.grip and not before.grip:
            self.time = -math.inf  # what is done with the body in the hand is another step
        names, returns = after.differences(before), after.following and not before.following
        if not (names or returns):
            return
        loaded = loaded or returns
        goes_on = names <= self.edited or self.edited <= {"comparison", "kept", "kept_by_edit"}
        in_hand = before.grip is not None and self.time > -math.inf
        paused = time - self.time > PAUSE and not in_hand
        if not goes_on or loaded or paused:
            self.past.append(before)
        self.edited = {"another scene"} if loaded else names
        self.future.clear()
        self.time = time

    def move(self, source: deque[State], target: deque[State], state: State) -> State:
        """The last state of `source`, `state` if there is none; stores `state` in `target`."""
        if not source:
            return state
        target.append(state)
        self.time = -math.inf
        return state.restored(source.pop())
