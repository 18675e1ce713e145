"""The state of one visitor: one frozen record that all controls show and each edit replaces.

Values from a browser are validated: an invalid one leaves the state unchanged, except for the
numbers of the beam, which are stored as sent and checked when the beam is solved.
"""

import contextlib
from collections import deque
from collections.abc import Collection
from dataclasses import dataclass, field, fields, replace
from functools import partial
from math import inf
from typing import Any, Self

from beamviz.beam import NUMBERS, PARAMETERS, Beam, Units
from beamviz.errors import InvalidInput
from beamviz.scene import LINKED, MODES, PER_REV, Camera, Scene, ViewOptions, check_per_rev
from beamviz.solver.problem import CHOICES, OPTIONS

# Terms of the equations, each on or off.
TERMS = tuple(name for name, option in OPTIONS.items() if option.kind is bool)
NO_COMPARISON, EARLIER = "nothing", "earlier"
COMPARISONS = (NO_COMPARISON, EARLIER, "ancf", "coriolis", "mass", "effects")
TABS = ("frequencies", "map", "veering", "compare", "run-up", "methods", "lessons", "export")
FILM_LENGTHS = {"shortest loop": None, "1 period": 1, "2 periods": 2, "4 periods": 4}
LASTING = ("playing", "dark")  # view options that undo and redo leave unchanged
STEPS = 200  # that can be undone
PAUSE = 1.0  # [s] after which another edit of the same values is another step
VIEW_KEYS = tuple(entry.name for entry in fields(ViewOptions))
AXES = ("over", "across")  # of the map; no number is on both
FIELDS: dict[str, Collection[Any]] = {  # of the state: the values that controls choose from
    "tab": TABS,
    **dict.fromkeys(AXES, tuple(PARAMETERS)),
    "mapped": ("gap", *range(1, MODES + 1)),
    "comparison": COMPARISONS,
    "film_length": FILM_LENGTHS,
    "force_per_rev": PER_REV,
    **dict.fromkeys(("stacked", "time_methods", "following"), (False, True)),
}


@dataclass(frozen=True)
class Case:
    """The numbers of a beam as entered, which may be out of range, and the keywords of `solve`."""

    numbers: dict[str, Any]
    options: dict[str, Any]
    units: Units | None = None

    @classmethod
    def of(cls, scene: Scene) -> Self:
        numbers = {name: getattr(scene.beam, name) for name in NUMBERS}
        return cls(numbers, scene.solver_options, scene.beam.units)

    def beam(self) -> Beam:
        """The beam. Raises InvalidInput, which names a number out of range."""
        return Beam(**self.numbers, units=self.units)

    def changed(self, name: str, value: Any) -> Self:
        """With one number or keyword of `solve` changed; a spin-up replaces straight by stable."""
        if name in self.numbers:
            case = replace(self, numbers={**self.numbers, name: value})
            straight = name == "spin_up" and value and self.options["state"] == "straight"
            return case.with_options(state="stable") if straight else case
        if name in TERMS:
            return self.with_options(**{name: bool(value)})
        if name in CHOICES and value in CHOICES[name]:
            return self.with_options(**{name: value})
        return self

    def with_options(self, **options: Any) -> Self:
        return replace(self, options={**self.options, **options})


@dataclass(frozen=True)
class State:
    """All choices of a visitor.

    scene: the one loaded last; opened: the one that the page, a link or a file opened; camera: a
    fixed viewpoint, None to fit the beam into the page; tab: the open one; over: the abscissa of
    the loci chart and the map; across, mapped: the ordinate and the quantity of the map, "gap" or
    the number of a mode; per_rev: multiples of the speed in the chart; comparison: the kind of
    second beam; kept: the case kept for it; stacked: it is drawn above the first, not overlaid;
    force_per_rev, damping: periods of the force per revolution and damping ratio of the run-up;
    forced_response: the scene shows the response to that force; run_speed: the speed during a
    run-up, 0 until that is computed, in place of the beam's own, of which an edit ends it;
    time_methods: the tab Methods times all methods; film_length: of exported films; section: the
    sizes that the panel of a real beam shows; lesson, step: the open one, "" for none, and its step
    (from 0); following: a presenter is followed.
    """

    scene: Scene
    opened: Scene
    case: Case
    view: ViewOptions = field(default_factory=ViewOptions)
    camera: Camera | None = None
    tab: str = TABS[0]
    over: str = "gamma"
    across: str = "alpha"
    mapped: str | int = "gap"
    per_rev: tuple[int, ...] = ()
    comparison: str = NO_COMPARISON
    kept: Case | None = None
    stacked: bool = False
    force_per_rev: int = 1
    damping: float = 0.02
    forced_response: bool = False
    run_speed: float | None = None
    time_methods: bool = False
    film_length: str = "shortest loop"
    section: str = "rectangle"
    lesson: str = ""
    step: int = 0
    following: bool = False

    @classmethod
    def of(cls, scene: Scene) -> Self:
        """The state in which a page opens on a scene."""
        return cls(scene, scene, Case.of(scene)).loaded(scene)

    def loaded(self, scene: Scene) -> Self:
        """With another scene, and without the case kept for comparison."""
        comparison = NO_COMPARISON if self.comparison == EARLIER else self.comparison
        state = replace(self, scene=scene, case=Case.of(scene), comparison=comparison, kept=None)
        state = replace(state, view=scene.view, camera=scene.camera, per_rev=scene.per_rev)
        return state.changed("over", scene.over).without_run_up()

    @property
    def shown_case(self) -> Case:
        """The case to show: during a run-up with the speed of that."""
        return self.case.changed("gamma", self.run_speed) if self.run_speed else self.case

    def to_scene(self) -> Scene:
        """The scene. Raises InvalidInput for a number out of range."""
        options = {name: self.case.options[name] for name in LINKED["model"]}
        return Scene(self.case.beam(), options, self.view, self.camera, self.over, self.per_rev)

    @property
    def values(self) -> dict[str, Any]:
        """Fields, view options, keywords of `solve` and the numbers of the beam, by name."""
        return vars(self) | vars(self.view) | self.case.options | self.case.numbers

    def changed(self, name: str, value: Any) -> Self:
        """With the value of that name as a browser sent it. A fixed viewpoint is dropped where the
        beam would leave the picture; a switched term keeps the case before for comparison."""
        camera = None if name in ("plane", "rotating_frame", "all_modes") else self.camera
        if name in VIEW_KEYS:
            view = self.view.changed(name, value)
            if name == "all_modes" and view.all_modes:  # from outside, captions would cover beams
                view = replace(view, rotating_frame=True)
            return replace(self, view=view, camera=camera)
        if name == "per_rev":
            with contextlib.suppress(InvalidInput):
                return replace(self, per_rev=check_per_rev(value))
            return self
        if name in FIELDS:
            choices = {str(one): one for one in FIELDS[name]}
            state = replace(self, **{name: choices.get(str(value), getattr(self, name))})
            if state.over == state.across:
                (other,) = {*AXES} - {name}
                state = replace(state, **{other: getattr(self, name)})
            return state.without_run_up() if name == "force_per_rev" else state
        kept = self.keep_for_comparison() if name in TERMS else self
        state = replace(kept, case=self.case.changed(name, value), camera=camera, run_speed=None)
        return state if name == "gamma" else state.without_run_up()

    def without_run_up(self) -> Self:
        """After an edit that changes the response."""
        return replace(self, forced_response=False, run_speed=None)

    def share(self, value: Any, mode: int) -> Self:
        return replace(self, view=self.view.share(mode, value), forced_response=False)

    def only(self, mode: int) -> Self:
        return replace(self, view=self.view.only(mode), forced_response=False)

    def differences(self, other: Self) -> set[str]:
        """The names of the values that differ from those of another state and that undo changes."""
        theirs = other.values
        differing = {
            name
            for name, one in self.values.items()
            if one is not theirs[name] and one != theirs[name]
        }
        return differing - {"case", "view", "run_speed", "tab", *LASTING}

    def keep(self) -> Self:
        """Keep the case, to compare later ones with."""
        return replace(self, kept=self.case, comparison=EARLIER)

    def keep_for_comparison(self) -> Self:
        """Keep the case unless it is compared with something else."""
        return self.keep() if self.comparison in (NO_COMPARISON, EARLIER) else self


class History:
    """The states for undo and redo. Edits of the same values in quick succession, as by a drag, are
    one step; loading a scene always is a step. undo, redo: return the state to show instead."""

    def __init__(self) -> None:
        self.past: deque[State] = deque(maxlen=STEPS)
        self.future: deque[State] = deque(maxlen=STEPS)
        self.undo = partial(self.move, self.past, self.future)
        self.redo = partial(self.move, self.future, self.past)
        self.edited: set[str] = set()  # names of the values edited last
        self.time = -inf  # [s] of the last edit

    def record(self, before: State, after: State, time: float) -> None:
        """Record an edit at a time [s]."""
        names = after.differences(before)
        if not names:
            return
        goes_on = names <= self.edited or self.edited <= {"comparison", "kept"}
        if not goes_on or time - self.time > PAUSE:
            self.past.append(before)
        self.edited = {"another scene"} if "scene" in names else names
        self.future.clear()
        self.time = time

    def move(self, source: deque[State], target: deque[State], state: State) -> State:
        """The last state of `source`, `state` if there is none; stores `state` in `target`."""
        if not source:
            return state
        target.append(state)
        self.time = -inf
        found = source.pop()
        lasting = {name: getattr(state.view, name) for name in LASTING}
        view = replace(found.view, **lasting)
        return replace(found, view=view, tab=state.tab, following=False, run_speed=None)
