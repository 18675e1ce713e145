"""The state of one visitor: one frozen record that all controls show and each edit replaces.

Values from a browser are validated: an invalid one leaves the state unchanged, except for the
numbers of the beam, which are stored as sent and checked when the beam is solved.
"""

import contextlib
import math
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from operator import attrgetter
from typing import Any, NamedTuple, Self, TypeVar

import numpy as np

from beamviz.beam import MAX_GAMMA_OVER_MU, NUMBERS, Beam
from beamviz.blade import Blade, Mass
from beamviz.chart_ranges import CHART_AXES, chart_axes
from beamviz.checks import check_float
from beamviz.errors import InvalidInput
from beamviz.explorer.declarations import (
    SWITCH,
    Choice,
    Effect,
    Key,
    choice,
    choices_of,
    name_key,
    switch_key,
    under,
    usual_after,
)
from beamviz.scene import (
    GIVEN,
    LINKED,
    MODES,
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
PAUSE = 1.0  # [s] after which another edit of the same values is another step
VIEW_KEYS = tuple(entry.name for entry in fields(ViewOptions))
# In a view that was turned to before them, beams would leave the picture.
REFITTED = ("plane", "rotating_frame", "all_modes", "stacked")
RATES = (1e-6, 1e6)  # [T*] in a second on the screen
FOLLOWS = "auto"  # in links: the rate of a clock that is not locked
KEEPS = choice(undo="keeps")  # of fields that no link has
T = TypeVar("T")
S = TypeVar("S", bound="Slice")


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
    def axes(self) -> tuple[str, ...]:
        """The numbers over which loci of the beam are charted."""
        return chart_axes(self.options["plane"], is_blade=self.blade is not None)

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
            case = case.with_height_of(self) if name == "mu" else case
            straight = name == "spin_up" and value and self.options["state"] == "straight"
            return case.with_options(state="stable") if straight else case
        if name in TERMS:
            return self.with_options(**{name: bool(value)})
        if name in CHOICES and value in CHOICES[name]:
            case = self.with_options(**{name: value})
            return case.with_resolution() if name == "method" else case
        return self

    def with_height_of(self, before: Self) -> Self:
        """With a section of the same shape as before a change of mu: its height follows its radius
        of gyration L / mu."""
        units = self.units
        if units is None or units.section_height is None or not (self.in_range and before.in_range):
            return self
        height = units.section_height * before.numbers["mu"] / self.numbers["mu"]
        return replace(self, units=replace(units, section_height=height))

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


def read_rate(rate: Any) -> float | None:
    return None if rate == FOLLOWS else check_float("rate", rate, *RATES)


def write_rate(rate: float | None) -> float | str:
    return rate or FOLLOWS


@dataclass(frozen=True)
class Slice:
    """The part of a state that belongs to one feature. Each field has a default; one with the
    metadata of `choice` is a choice."""

    @property
    def in_hand(self) -> bool:
        """Whether the visitor holds something of the scene: its edits are one step to undo."""
        return False

    def shown(self, case: Case) -> Case:
        """What the scene shows in place of a case."""
        return case

    def at_home(self, opened: Self) -> Self:
        """After a reset; opened: as it was when the scene was opened."""
        return self

    def led(self, presenter: Self) -> Self:
        """This part of a visitor who follows a presenter, with what is taken of that of the
        presenter besides single choices."""
        return self

    def saved(self, scene: Scene) -> Scene:
        """A scene with what its file keeps of this part."""
        return scene

    def loaded(self, scene: Scene) -> Self:
        """After another scene is loaded, with what its file keeps of this part."""
        return self

    def settled(self, before: "State", state: "State") -> "State":
        """A state of which this is a part, after an edit of a choice of any record; before: the
        state before the edit."""
        return state


@dataclass(frozen=True)
class State:
    """All choices of a visitor, by subject. A field with metadata is a `Choice`, which says what
    undo, links, presenters and events do with it."""

    # The beam and the view

    opened: Scene  # by the page, a link, a file or a lesson; a reset returns to it
    case: Case
    # The parts of features when the scene was opened.
    opened_slices: Mapping[type[Slice], Slice] = field(default_factory=dict)
    last_alpha: float = field(default=1.0, metadata=KEEPS)  # of the last beam that had a mass
    view: ViewOptions = field(default_factory=ViewOptions)
    # A fixed viewpoint; None to fit the beam into the page.
    camera: Camera | None = field(default=None, metadata=choice(led="keeps"))
    # The viewpoint to which the visitor has turned the view since then; None where they have not.
    turned: Camera | None = field(default=None, metadata=KEEPS)
    # Time [T*] that passes in a second on the screen, if locked; None: chosen for what is shown.
    rate: float | None = field(
        default=None, metadata=choice(key=Key("rate", read_rate, write_rate), until=("scene",))
    )

    # Charts

    over: str = field(default="gamma", metadata=choice(values=CHART_AXES))  # abscissa, also of maps
    per_rev: tuple[int, ...] = ()  # multiples of the speed in the loci chart

    # The second beam

    comparison: str = field(
        default=NO_COMPARISON,
        metadata=choice(values=COMPARISONS, key=name_key("compare", COMPARISONS[1:])),
    )
    kept: Case | None = None  # to be compared with
    # By an edit, not by the visitor.
    kept_by_edit: bool = field(default=False, metadata=choice(until=("scene", "comparison")))
    # It is drawn above the first one, not overlaid.
    stacked: bool = field(default=False, metadata=choice(values=SWITCH, key=switch_key("stacked")))

    # Tabs and lectures

    # The key of the open tab.
    tab: str = field(default="", metadata=choice(key=Key("tab", str), undo="keeps"))
    # The tab that a presenter had open last, "" for none; the visitor may have opened another one
    # since.
    presented_tab: str = field(default="", metadata=KEEPS)
    # A presenter is followed.
    following: bool = field(default=False, metadata=choice(values=SWITCH, undo="ends", led="keeps"))

    # What the page says of the last edit

    # The last refused entry.
    refused: Refused | None = field(default=None, metadata=choice(undo="ends", until=("scene",)))
    # Notice that the visitor's scene is replaced.
    replaced: str = field(default="", metadata=choice(undo="ends", led="ends"))

    # The visitor's browser

    # Its system prefers reduced motion.
    still: bool = field(default=False, metadata=choice(undo="keeps", led="keeps"))
    # Parameters of the address with other readers; None until the page has sent its address.
    reserved: tuple[tuple[str, str], ...] | None = field(
        default=None, metadata=choice(undo="keeps", led="keeps")
    )

    slices: Mapping[type[Slice], Slice] = field(default_factory=dict)  # of features, see `slice`

    @classmethod
    def of(cls, scene: Scene, slices: Iterable[type[Slice]] = ()) -> "State":
        """The state of a scene, with the parts of features of these types, and all other choices,
        as usual."""
        usual = {kind: kind() for kind in slices}
        return cls(scene, Case.of(scene), opened_slices=usual, slices=usual).loaded(scene)

    # The parts of features

    def slice(self, kind: type[S]) -> S:
        """The part of this type."""
        found = self.slices.get(kind)
        return found if isinstance(found, kind) else kind()

    def with_slice(self, record: Slice) -> "State":
        """With another part of the type of this one."""
        return replace(self, slices={**self.slices, type(record): record})

    def with_values(self, kind: type[Slice], **values: Any) -> "State":
        """With other values in the part of this type; the state itself where it has them."""
        record = self.slice(kind)
        return (
            self.with_slice(replace(record, **values)) if different(values, vars(record)) else self
        )

    def __getitem__(self, choice: Choice[T]) -> T:
        """The value of a choice."""
        value: T = getattr(self.record(choice), choice.name)
        return value

    def record(self, choice: Choice[Any]) -> "State | Slice":
        """The record that a choice is a field of."""
        return self if choice.record is State else self.slice(choice.record)

    def with_choice(self, choice: Choice[T], value: T) -> "State":
        """With another value of a choice, of the state or of a feature."""
        values: dict[str, Any] = {choice.name: value}
        is_core = choice.record is State
        state: State = (
            replace(self, **values) if is_core else self.with_values(choice.record, **values)
        )
        return state.settled_after(self)

    def settled_after(self, before: "State") -> "State":
        """After an edit of the state `before`: an axis of charts that the beam has not is as
        usual, and the parts of features settle what depends on others."""
        state = self if self.over in self.case.axes else replace(self, over=State.over)
        for record in state.slices.values():
            state = record.settled(before, state)
        return state

    def picked(self, choice: Choice[T], value: object) -> "State":
        """With the value of a choice that a control sent."""
        state = self.with_choice(choice, choice.picked(value, self[choice]))
        return state.after(choice.name)

    def after(self, event: str) -> "State":
        """With those choices as usual that last until an event: one of EVENTS, or a change of the
        choice of this name."""
        state = self.with_fields(**usual_after(State, event))
        changed = {
            kind: replace(record, **usual)
            for kind, record in self.slices.items()
            if different(usual := usual_after(kind, event), vars(record))
        }
        return replace(state, slices={**self.slices, **changed}) if changed else state

    # Scenes

    def loaded(self, scene: Scene) -> "State":
        """With another scene, and its second beam; without one, and without the case kept for
        comparison. With reduced motion it moves only if the last one did."""
        second, kept, stacked = scene.second, None, self.stacked
        comparison = NO_COMPARISON if self.comparison == EARLIER else self.comparison
        if second:
            comparison, stacked = second.choice, second.stacked
            kept = Case.of(scene.second_scene) if comparison == EARLIER else None
        view = replace(scene.view, playing=self.view.playing) if self.still else scene.view
        state = replace(
            self.after("scene").with_viewpoint(scene.camera),
            case=Case.of(scene),
            view=view,
            per_rev=scene.per_rev,
            comparison=comparison,
            stacked=stacked,
            kept=kept,
        )
        state = state.changed("over", scene.over).with_mass_kept()
        slices = {kind: record.loaded(scene) for kind, record in state.slices.items()}
        return replace(state, slices=slices)

    def at_home(self, scene: Scene) -> "State":
        """With this as the state to which a reset returns; scene: its scene."""
        return replace(self, opened=scene, opened_slices=self.slices)

    @property
    def as_opened(self) -> "State":
        """With the scene that was opened, for a reset."""
        home = self.opened.changed(**{name: getattr(self.view, name) for name in LASTING})
        state = replace(self.loaded(home), rate=self.rate)
        for kind, opened in self.opened_slices.items():
            state = state.with_slice(state.slice(kind).at_home(opened))
        return state

    def with_viewpoint(self, camera: Camera | None) -> "State":
        """Looking from a viewpoint, None to fit the beam into the page, wherever the visitor has
        turned the view to."""
        return replace(self.after("viewpoint"), camera=camera, turned=None)

    @property
    def viewpoint(self) -> Camera | None:
        """The viewpoint; None where the beam is fitted into the page."""
        return self.turned or self.camera

    def restored(self, step: "State") -> "State":
        """An earlier or later state, in which what is no choice about the scene is as it is now,
        and nothing is under way."""
        lasting = {name: getattr(self.view, name) for name in LASTING}
        state = self.under(step, attrgetter("undo"))
        return replace(state, view=replace(step.view, **lasting))

    def under(self, other: "State", effect: Callable[[Choice[Any]], Effect]) -> "State":
        """Another state, but for the choices to which that does something else; effect: what it
        does to a choice."""
        slices = {
            kind: under(self.slice(kind), other.slice(kind), effect)
            for kind in (*self.slices, *other.slices)
        }
        return replace(under(self, other, effect), slices=slices)

    @property
    def in_hand(self) -> bool:
        """Whether the visitor holds something of the scene."""
        return any(record.in_hand for record in self.slices.values())

    @property
    def shown_case(self) -> Case:
        """The case to show, with the modes to show."""
        case = self.case
        for record in self.slices.values():
            case = record.shown(case)
        return case.with_options(modes=max(MODES, len(self.view.shares)))

    def to_scene(self) -> Scene:
        """The scene. Raises InvalidInput for a number out of range."""
        options = {name: self.case.options[name] for name in LINKED["model"]}
        scene = Scene(self.case.beam, options, self.view, self.viewpoint, self.over, self.per_rev)
        for record in self.slices.values():
            scene = record.saved(scene)
        return scene

    @property
    def values(self) -> dict[str, Any]:
        """Fields, view options, keywords of `solve`, the numbers and the structure of the beam, by
        name; choices of features are not among them."""
        return vars(self) | vars(self.view) | self.case.values

    def with_fields(self, **values: Any) -> "State":
        """With other values of fields; the state itself where it has them."""
        return replace(self, **values) if different(values, vars(self)) else self

    def changed(self, name: str, value: Any) -> "State":
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
            return fitted.picked(SHARED[name], value)
        if (case := self.case.changed(name, value)) is self.case:
            return self
        kept = fitted.keep_for_comparison() if name in TERMS else fitted
        state = replace(kept, case=case).after("case")
        state = state if name == "gamma" else state.after("structure")
        return state.with_mass_kept().settled_after(self)

    def with_body_at(self, body: int, beta: float) -> "State":
        """With a body of `Beam.masses` moved."""
        masses = list(self.case.masses)
        masses[body] = replace(masses[body], beta=beta)
        state = replace(self, case=replace(self.case, masses=tuple(masses)))
        return state.after("case").after("structure")

    def with_mass_kept(self) -> "State":
        """Remembering the mass, for the switch that removes and restores it."""
        alpha = self.case.numbers["alpha"]
        known = isinstance(alpha, int | float) and 0 < alpha <= NUMBERS["alpha"].limits[1]
        return self.with_fields(last_alpha=float(alpha)) if known else self

    def share(self, value: Any, mode: int) -> "State":
        return replace(self.after("modes"), view=self.view.share(mode, value))

    def only(self, *modes: int) -> "State":
        """With these modes (from 0) in equal shares; the table keeps more modes than usual."""
        usual, known = max(modes) + 1, len(self.view.shares)
        count = known if known > max(usual, MODES) else usual
        shares = tuple(float(k in modes) for k in range(count))
        view = replace(self.view, shares=shares, all_modes=False)
        return replace(self.after("modes"), view=view)

    def differences(self, other: "State") -> set[str]:
        """The names of the values that differ from those of another state and that undo changes."""
        differing = changes(self, other)
        if "view" in differing:
            differing |= different(vars(self.view), vars(other.view))
        if "case" in differing:
            differing |= different(self.case.values, other.case.values)
        for kind in (*self.slices, *other.slices):
            differing |= changes(self.slice(kind), other.slice(kind))
        return differing - {"case", "view", "slices", *LASTING}

    def keep(self) -> "State":
        """Keep the case, to compare later ones with, unless it has a number out of range."""
        if not self.case.in_range:
            return self
        return replace(self, kept=self.case, comparison=EARLIER, kept_by_edit=False)

    def keep_for_comparison(self) -> "State":
        """Keep the case before an edit, unless the visitor chose what it is compared with."""
        if self.comparison == EARLIER and not self.kept_by_edit:
            return self if self.kept else self.keep()
        if self.comparison not in (NO_COMPARISON, EARLIER) or not self.case.in_range:
            return self
        return replace(self.keep(), kept_by_edit=True)

    def without_edit_kept(self) -> "State":
        """Without the case that an edit has kept: with one that the visitor has chosen, if any."""
        ended: dict[str, Any] = {"kept": None, "comparison": NO_COMPARISON, "kept_by_edit": False}
        return replace(self, **ended) if self.kept_by_edit else self


def different(some: Mapping[str, Any], others: Mapping[str, Any]) -> set[str]:
    """The names of `some` values that differ from those of the same names."""
    return {
        name for name, value in some.items() if value is not others[name] and value != others[name]
    }


def changes(record: "State | Slice", other: "State | Slice") -> set[str]:
    """The names of the fields that differ from those of another record and that undo changes."""
    choices = choices_of(type(record)).values()
    unchanged = {choice.name for choice in choices if choice.undo != "changes"}
    return different(vars(record), vars(other)) - unchanged


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
        if after.in_hand and not before.in_hand:
            self.time = -math.inf  # what is done with what is in the hand is another step
        names, returns = after.differences(before), after.following and not before.following
        if not (names or returns):
            return
        loaded = loaded or returns
        goes_on = names <= self.edited or self.edited <= {"comparison", "kept", "kept_by_edit"}
        in_hand = before.in_hand and self.time > -math.inf
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
