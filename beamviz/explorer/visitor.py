"""One visitor: their state, the controls that show and edit it, and their background jobs.

A feature gets a `Visitor`: it reads `state`, edits it by `change`, binds its controls to it, and
computes its results by a `job`. State is never read out of a control. What changes calls `wake`;
then each `Feature` shows its part of the page.
"""

import contextlib
import operator
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from viser import ClientHandle

from beamviz.drawing.camera import PageCamera, initial
from beamviz.drawing.modes import Clock
from beamviz.errors import InvalidInput
from beamviz.explorer.jobs import Callback, Job, SolveJob, SolverAnswer, Workers
from beamviz.explorer.page import Page
from beamviz.explorer.state import CHOICES, FIELDS, TERMS, VIEW_KEYS, History, State
from beamviz.lessons import lesson
from beamviz.scene import Scene
from beamviz.server.viser_private import group_messages

Edit = Callable[[State, Any], State]  # of a state, by the value of a control
Shown = Callable[[Mapping[str, Any]], Any]  # what a control shows of the values of the state


class Visitor:
    """The single store of one visitor's state.

    client: their viser client; page: the HTML around the scene; state: all their choices, replaced
    by each edit; version: another object after each change; schedule: tells of a change to the
    frame loop; solver: the job that solves the case of the state; answer: the answer that the page
    shows; controls: what those of each key show; clock: of the scene; dragging: the mass is being
    dragged, and the clock is stopped; still: their system prefers reduced motion.
    """

    def __init__(self, client: ClientHandle, state: State, workers: Workers, schedule: Callback):
        self.client, self.schedule, self.page = client, schedule, Page(client)
        group_messages(client)
        self.state, self.version = state, object()
        self.history = History()
        self.workers, self.background = workers, workers.background
        self.lock = threading.RLock()
        self.camera = PageCamera(client.camera, initial(state.scene))
        self.camera.set_viewpoint(state.camera)
        self.controls: dict[str, Shown] = {}
        self.jobs: list[Job] = []
        self.answer: SolverAnswer | None = None
        self.clock, self.dragging, self.still = Clock(), False, False
        self.solver = self.solve_job()
        self.solver.request(state.case)
        self.page.on("tab", self.open_tab)
        for key in (*VIEW_KEYS, *CHOICES, *TERMS, *FIELDS.keys() - {"tab", "following"}):
            self.bind(key)

    def wake(self) -> None:
        """Show the page again soon, as something has changed; from any thread."""
        self.version = object()
        self.schedule()

    # State

    def change(self, edit: Callable[[State], State]) -> None:
        """Replace the state by `edit(state)`, from any thread; this ends presenter mode."""
        with self.lock:
            state = edit(self.state)
            if state.following and self.state.following:
                state = replace(state, following=False)
            self.history.record(self.state, state, time.monotonic())
            self.set_state(state)

    def restore(self, step: Callable[[State], State]) -> None:
        """Undo or redo a step of the history, with its scene and its fixed viewpoint."""
        with self.lock:
            before = self.state
            self.set_state(step(before))
            if self.state.scene is not before.scene or self.state.camera != before.camera:
                self.camera.set_viewpoint(self.state.camera)

    def set_state(self, state: State) -> None:
        """Set the state, without a step in the history, and solve its case."""
        with self.lock:
            self.state = state
            if not state.following:
                for job in self.jobs:
                    job.following = False
                self.solver.request(state.shown_case)
        self.wake()

    def load(self, scene: Scene, **values: Any) -> None:
        """Show another scene, with other values of the state by field name. With reduced motion it
        only moves if the last one did."""
        with self.lock:
            if self.still:
                scene = scene.changed(playing=self.state.view.playing)
            self.change(lambda state: replace(state.loaded(scene), **values))
            self.camera.set_viewpoint(scene.camera)

    def reset(self) -> None:
        """Show the scene of the open lesson, or else the one that was opened; keep the theme."""
        state = self.state
        home = lesson(state.lesson).scene if state.lesson else state.opened
        self.load(home.changed(dark=state.view.dark))

    def reset_view(self) -> None:
        with self.lock:
            self.change(lambda state: replace(state, camera=None))
            self.camera.set_viewpoint(None)

    def to_scene(self) -> Scene:
        """The scene with the present viewpoint. Raises InvalidInput for a number out of range."""
        return replace(self.state.to_scene(), camera=self.camera.chosen)

    def open_tab(self, tab: Any) -> None:
        """Store the open tab, which is no edit: it ends no presenter mode and cannot be undone."""
        with self.lock:
            self.page.sent["open",] = tab
            self.set_state(self.state.changed("tab", tab))

    # Controls

    def bind(self, key: str, edit: Edit | None = None, shown: Shown | None = None) -> None:
        """Bind the controls with data-set="key": they show `shown(values)` of the values of the
        state by name, by default that of the name `key`; an edit replaces the state by
        `edit(state, value)`, by default `state.changed(key, value)`."""
        edit = edit or (lambda state, value: state.changed(key, value))
        self.page.on(key, lambda value: self.change(lambda state: edit(state, value)))
        self.controls[key] = shown or operator.itemgetter(key)

    def show_controls(self) -> None:
        """Show the state in all bound controls, the tab and the theme."""
        state = self.state
        values = state.values
        for key, shown in self.controls.items():
            self.page.value(key, shown(values))
        self.page.send_changed(state.tab, "open")
        self.page.theme(dark=state.view.dark)
        self.page.props("undo", disabled=not self.history.past)
        self.page.props("redo", disabled=not self.history.future)

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
        self.jobs.append(Job(name, compute, self.background.submit, self.wake))
        return self.jobs[-1]

    def solve_job(self) -> SolveJob:
        """A new job that solves cases, closed when the visitor leaves."""
        self.jobs.append(job := SolveJob(self.workers, self.wake))
        return job

    def cancel_jobs(self) -> None:
        """Cancel the jobs that have been running for long."""
        for job in self.jobs:
            if job.slow:
                job.cancel()

    def retry_jobs(self) -> None:
        for job in self.jobs:
            job.retry()
        self.wake()


class Feature:
    """A part of the page. `show`, defined by subclasses, is called whenever something has changed;
    what takes time it draws only `if self.redraws(...)`."""

    drawn_from: tuple[object, ...] = ()

    def __init__(self, visitor: Visitor):
        self.visitor, self.page = visitor, visitor.page

    def show(self) -> None:
        """Request what the page needs for the state, and show the last results."""
        raise NotImplementedError

    def redraws(self, *drawn_from: object) -> bool:
        """Whether one of these is another object than at the last call."""
        before, self.drawn_from = self.drawn_from, drawn_from
        return len(before) != len(drawn_from) or any(map(operator.is_not, before, drawn_from))

    def fade(self, job: Job, *parts: str) -> None:
        """Mark elements, by their ids, while their job has no answer to the latest request."""
        for id in parts:
            self.page.props(id, data_outdated="" if job.slow or job.cancelled else None)
