"""One visitor: the only store of their state, their controls and their background jobs.

A feature gets a `Visitor`: it edits the state by `change`, binds its controls to it, and computes
its results by a `job`. State is never read out of a control. Whatever changes calls `wake`, and the
next frame shows it.
"""

import contextlib
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from operator import attrgetter
from types import MappingProxyType
from typing import Any, NamedTuple

from viser import ClientHandle

from beamviz.drawing.camera import initial
from beamviz.errors import InvalidInput
from beamviz.explorer.camera import PageCamera, covered_below
from beamviz.explorer.clock import Clock
from beamviz.explorer.declarations import Choice, Tab
from beamviz.explorer.jobs import Answer, Callback, Job, JobStatus, Workers
from beamviz.explorer.page import Page
from beamviz.explorer.presenter import Votes, led_clock, led_inputs, led_state
from beamviz.explorer.second_beam import comparison_case, second_of
from beamviz.explorer.snapshot import Inputs, Snapshot
from beamviz.explorer.solutions import Cases, SolveJob, case_error
from beamviz.explorer.state import (
    CHOICES,
    SHARED,
    TERMS,
    VIEW_KEYS,
    History,
    Refused,
    State,
)
from beamviz.scene import Scene, ViewOptions

Edit = Callable[[State, Any], State]  # of a state, by the value of a control
ShownValue = Callable[[State], Any]  # what a control shows of the state


VIEW_TYPES = {key: type(getattr(ViewOptions, key)) for key in VIEW_KEYS if key != "shares"}
MODEL_TYPES: dict[str, type] = {**dict.fromkeys(CHOICES, str), **dict.fromkeys(TERMS, bool)}


class LinkFormat(NamedTuple):
    """How a scene, with the other choices about it, is written as the query of a link, without any
    lesson, and the state that a query describes, from a present one; it raises InvalidInput."""

    write: Callable[[State], str]
    read: Callable[[State, str], State]


class Visitor:
    """A visitor's session without its pictures.

    client: their viser client; page: the HTML around the scene; first: the state in which the page
    opened; state: all their choices, replaced by each edit; outdated: something has changed since
    the last snapshot; schedule: tells the frame loop so; presenter: returns the presenter's last
    snapshot, None while there is none; may_follow, presents: another visitor, or this one, may
    present; votes: those of the lecture; solver: the job that solves the case of the state;
    own_jobs: names of those that the visitor begins; shown: the status of each job in the last
    snapshot; clock: of the scene; controls: what those of each key show; tabs: of the page, by key;
    links: writes and reads the links of the page.
    """

    links: LinkFormat  # of the feature that has the address

    def __init__(
        self,
        client: ClientHandle,
        state: State,
        workers: Workers,
        schedule: Callback,
        presenter: Callable[[], Snapshot | None] | None = None,
        presents: bool = False,
        votes: Votes | None = None,
    ):
        self.client, self.page = client, Page(client, self.wake)
        self.outdated, self.schedule = True, schedule
        self.presenter = presenter or (lambda: None)
        self.may_follow, self.presents = presenter is not None, presents
        self.votes = votes or Votes()
        self.first = self.state = state
        self.history, self.clock = History(), Clock()
        self.workers = workers
        self.lock = threading.RLock()
        self.camera = PageCamera(client.camera, initial(state.to_scene()))
        self.tabs: Mapping[str, Tab] = {}
        self.controls: dict[str, ShownValue] = {}
        self.jobs: dict[str, Job] = {}
        self.own_jobs: set[str] = set()
        self.shown: Mapping[str, JobStatus] = {}
        self.solver = SolveJob(workers, self.wake)
        self.add_job(self.solver)
        self.set_state(state)
        self.bind_usual()

    # State

    def change(
        self, edit: Callable[[State], State], *, loads: bool = False, replaced: str = ""
    ) -> None:
        """Replace the state by `edit(state)`, from any thread. This ends following a presenter, and
        what was said of a replaced scene; with another case also what was said of a refused entry.
        loads: the edit is a step to undo of its own; replaced: what to say if it replaces a scene
        that the visitor has made."""
        with self.lock:
            before = self.state
            state = edit(before)
            replaces = replaced and self.history.past and state.differences(before)
            state = state.with_fields(
                replaced=replaced if replaces else "",
                following=state.following and not before.following,
                refused=refused_after(before, state),
            )
            self.history.record(before, state, time.monotonic(), loaded=loads)
            self.set_state(state)

    def restore(self, step: Callable[[State], State]) -> None:
        """Undo or redo a step of the history, with its fixed viewpoint, also where the visitor has
        turned the view in another frame."""
        with self.lock:
            before, state = self.state, step(self.state)
            stays = state.opened is before.opened and state.camera == before.camera
            if not stays or state.view.rotating_frame != before.view.rotating_frame:
                state = state.with_viewpoint(state.camera)
            self.set_state(state)

    def update(self, edit: Callable[[State], State]) -> None:
        """Replace the state by `edit(state)`, from any thread, without a step in the history: it is
        no edit of the scene."""
        with self.lock:
            self.set_state(edit(self.state))

    def set_state(self, state: State) -> None:
        self.state = state
        self.wake()

    def open(self, scene: Scene) -> None:
        """Show a scene from outside, to which a reset returns."""
        self.change(lambda state: state.loaded(scene).after("opened").at_home(scene), loads=True)

    def reset(self) -> None:
        """Show the scene that was opened; keep the theme, and a pause."""
        self.change(lambda state: state.as_opened, loads=True, replaced="The scene is reset.")

    def scene_to_save(self) -> Scene:
        """The scene with the second beam. Raises InvalidInput for a number out of range, in the
        words of the page."""
        try:
            scene = self.state.to_scene()
        except InvalidInput as error:
            raise InvalidInput(case_error(str(error), self.state.case)) from error
        return replace(scene, second=second_of(self.state))

    def wake(self) -> None:
        """Take a snapshot soon, as something has changed; from any thread."""
        if not self.outdated:
            self.outdated = True
            self.schedule()

    # Snapshots

    def next_inputs(self) -> Inputs:
        """The inputs of the next frame, in which a quick solve is done; those of a presenter whom
        the visitor follows."""
        with self.lock:
            led = self.followed
            if led is None:
                case = self.state.shown_case
                self.solver.request(Cases(case, comparison_case(self.state, case)))
            self.outdated = False  # what changes from here on is for the next snapshot
            if led:
                self.state = led_state(self.state, led.state)
                self.clock = led_clock(self.clock, led.clock)
            inputs = self.inputs()
        inputs = led_inputs(inputs, led, self.own_jobs) if led else inputs
        self.shown = inputs.jobs
        return inputs

    @property
    def followed(self) -> Snapshot | None:
        """The last snapshot of the presenter whom the visitor follows, None without one."""
        return self.presenter() if self.state.following else None

    def inputs(self) -> Inputs:
        """The inputs of this moment."""
        with self.lock:
            state, view = self.state, self.client.camera
            answer, second, comparison = self.solver.compared
            return Inputs(
                state=state,
                answer=answer,
                second=second,
                comparison=comparison,
                jobs=MappingProxyType({name: job.status for name, job in self.jobs.items()}),
                clock=self.clock,
                aspect=view.aspect,
                covered=covered_below(view.image_width, view.image_height),
                scale=self.camera.scale,
                undo=bool(self.history.past),
                redo=bool(self.history.future),
                votes=self.votes.counts if self.presents else {},
                audience=self.votes.present,
            )

    # Controls

    def bind(self, key: str, edit: Edit, shown: ShownValue, takes: Any) -> None:
        """Bind the controls with data-set="key": they show `shown(state)`; an edit, with a value of
        the type `takes`, replaces the state by `edit(state, value)`."""
        self.page.on(key, lambda value: self.change(lambda state: edit(state, value)), takes)
        self.controls[key] = shown

    def bind_usual(self) -> None:
        """Bind the controls of view, model and the choices that features share."""
        for name, takes in VIEW_TYPES.items():
            self.bind(name, partial(changed, name), attrgetter(f"view.{name}"), takes)
        for name, takes in MODEL_TYPES.items():
            self.bind(name, partial(changed, name), partial(option_of, name), takes)
        for name, choice in SHARED.items():
            if choice.values and (name != "following" or self.may_follow):
                self.bind(name, partial(changed, name), attrgetter(name), choice.sent)

    def bind_choice(self, choice: Choice[Any]) -> None:
        """Bind the controls of a choice of a feature, which are those of one of its values."""

        def edit(state: State, value: Any) -> State:
            return state.picked(choice, value)

        self.bind(choice.name, edit, lambda state: state[choice], choice.sent)

    def command(self, name: str, run: Callback) -> None:
        """Add a command to the palette (Ctrl+K)."""
        self.client.gui.add_command(name).on_trigger(lambda _: run())

    @contextlib.contextmanager
    def reporting(self, title: str) -> Iterator[None]:
        """Context in which an InvalidInput is shown to the visitor, under a title."""
        try:
            yield
        except InvalidInput as error:
            self.page.say(f"{title}: {error}", error=True)

    # Jobs

    def job(self, name: str, compute: Callable[[Any], Any]) -> Job:
        """A new background job of this visitor (see `Job`), closed when they leave."""
        return self.add_job(Job(name, compute, self.workers.background.submit, self.wake))

    def add_own_job(self, job: Job) -> Job:
        """Add a job that the visitor begins, not the page for what it shows: also while they follow
        a presenter, the page shows how it goes on."""
        self.own_jobs.add(job.name)
        return self.add_job(job)

    def add_job(self, job: Job) -> Job:
        self.jobs[job.name] = job
        return job

    def shown_answer(self, name: str) -> Answer[Any, Any] | None:
        """The answer of a job that the page shows, which may be a presenter's; None without one. A
        click in a chart or a map refers to it."""
        status = self.shown.get(name)
        return status.answer if status else None

    def cancel_jobs(self) -> None:
        """Cancel the jobs that have been running for long."""
        for job in self.jobs.values():
            if job.status.slow:
                job.cancel()

    def retry_jobs(self) -> None:
        for job in self.jobs.values():
            job.retry()
        self.wake()

    def close(self) -> None:
        """Close all jobs."""
        for job in self.jobs.values():
            job.close()


def refused_after(before: State, after: State) -> Refused | None:
    """The entry that is refused after an edit: an earlier one only while case and choices stay."""
    stays = after.case is before.case and after.slices == before.slices
    return after.refused if stays or after.refused is not before.refused else None


def changed(name: str, state: State, value: Any) -> State:
    return state.changed(name, value)


def option_of(name: str, state: State) -> Any:
    return state.case.options[name]
