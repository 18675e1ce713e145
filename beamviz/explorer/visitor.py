"""One visitor: their state, the controls that show and edit it, and their background jobs.

A feature gets a `Visitor`: it reads `state`, edits it by `change`, binds its controls to it, and
computes its results by a `job`. State is never read out of a control.
"""

import operator
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from viser import ClientHandle

from beamviz.drawing.camera import PageCamera
from beamviz.drawing.modes import Clock
from beamviz.explorer.jobs import Job, SolveJob, SolverAnswer, Workers
from beamviz.explorer.page import Page
from beamviz.explorer.state import CHOICES, FIELDS, TERMS, VIEW_KEYS, History, State
from beamviz.scene import Scene
from beamviz.server.viser_private import group_messages


class Visitor:
    """The single store of one visitor's state.

    client: their viser client; page: the HTML around the scene; state: all their choices, replaced
    by each edit; shown: the state that the controls show; solver: the job that solves the case of
    the state; answer: the answer that the scene shows; chart_answer: the one that the charts show,
    which with many visitors are updated only when a slider is at rest; wake: tells the frame loop
    that something has changed; clock: of the scene; dragging: the mass is being dragged, and the
    clock is stopped.
    """

    def __init__(
        self, client: ClientHandle, state: State, workers: Workers, wake: Callable[[], None]
    ):
        self.client, self.wake, self.page = client, wake, Page(client)
        group_messages(client)
        self.state = self.shown = state
        self.history = History()
        self.workers, self.background = workers, workers.background
        self.lock, self.camera = threading.RLock(), PageCamera(client.camera)
        self.camera.set_viewpoint(state.camera)
        self.renderers: list[tuple[str, Callable[[Any], None]]] = []  # of the values by name
        self.jobs: list[Job] = []
        self.answer: SolverAnswer | None = None
        self.chart_answer: SolverAnswer | None = None
        self.clock, self.dragging = Clock(), False
        self.solver = self.solve_job()
        self.solver.request(state.case)
        self.page.on("tab", self.open_tab)
        self.render("tab", self.page.open)
        for key in (*VIEW_KEYS, *CHOICES, *TERMS, *FIELDS.keys() - {"tab", "following"}):
            self.bind(key)

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
        """Show another scene, with other values of the state by field name."""
        with self.lock:
            self.change(lambda state: replace(state.loaded(scene), **values))
            self.camera.set_viewpoint(scene.camera)

    def reset(self) -> None:
        """Show the scene of the open lesson, or else the one that was opened; keep the theme."""
        state = self.state
        self.load(state.home.changed(dark=state.view.dark))

    def reset_view(self) -> None:
        """Fit the beam into the page."""
        with self.lock:
            self.change(lambda state: replace(state, camera=None))
            self.camera.set_viewpoint(None)

    def to_scene(self) -> Scene:
        """The scene with the present viewpoint. Raises InvalidInput for a number out of range."""
        return replace(self.state.to_scene(), camera=self.camera.chosen)

    def open_tab(self, tab: Any) -> None:
        """Store the tab that the visitor has opened, which is no edit: it ends no presenter mode
        and cannot be undone."""
        with self.lock:
            self.page.sent["open",] = tab
            self.set_state(self.state.changed("tab", tab))

    # Controls

    def bind(
        self,
        key: str,
        edit: Callable[[State, Any], State] | None = None,
        of: str | None = None,
        shown: Callable[[Any], Any] = lambda value: value,
    ) -> None:
        """Bind the controls with data-set="key" to the value of the state named `of` (by default
        `key`): they show `shown(value)`, and an edit replaces the state by `edit(state, value)`, by
        default `state.changed(key, value)`."""
        name = of or key

        def edited(value: Any) -> None:
            self.change(lambda state: edit(state, value) if edit else state.changed(key, value))
            show(self.state.values[name])  # which may differ from what the visitor set

        def show(value: Any) -> None:
            self.page.value(key, shown(value))

        self.page.on(key, edited)
        self.render(name, show)

    def render(self, name: str, show: Callable[[Any], None]) -> None:
        """Call `show` with the value of this name (see `State.values`), now and in each frame in
        which it is another object."""
        with self.lock:
            self.renderers.append((name, show))
            show(self.shown.values[name])

    def update_controls(self) -> None:
        """Show the state in the controls whose value has changed since the last frame."""
        with self.lock:
            if self.state is not self.shown:
                before, now = self.shown.values, self.state.values
                self.shown = self.state
                for name, show in self.renderers:
                    if now[name] is not before[name]:
                        show(now[name])
                self.page.props("undo", disabled=not self.history.past)
                self.page.props("redo", disabled=not self.history.future)

    def command(self, name: str, run: Callable[[], None]) -> None:
        """Add a command to the palette (Ctrl+K)."""
        self.client.gui.add_command(name).on_trigger(lambda _: run())

    def notify(self, title: str, message: str) -> None:
        """Show an error message for some seconds."""
        self.page.say(f"{title}: {message}", error=True)

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
        """Restart the cancelled jobs."""
        for job in self.jobs:
            job.retry()
        self.wake()


class Feature:
    """A part of the page that is updated when its `inputs` change, objects compared by identity.
    Subclasses define `inputs`, and `show`, which updates the page.

    drawn_from: what the chart of the feature was drawn from.
    """

    shown: tuple[object, ...] = ()
    drawn_from: tuple[object, ...] = ()

    def __init__(self, visitor: Visitor):
        self.visitor, self.page = visitor, visitor.page

    @property
    def inputs(self) -> tuple[object, ...]:
        raise NotImplementedError

    def show(self) -> None:
        raise NotImplementedError

    @property
    def outdated(self) -> bool:
        """Whether an input is another object than at the last update."""
        inputs = self.inputs
        return len(inputs) != len(self.shown) or any(map(operator.is_not, inputs, self.shown))

    def update(self) -> None:
        self.shown = self.inputs
        self.show()

    def redraws(self, *drawn: object) -> bool:
        """Whether the chart has to be drawn again, from other objects than the last time."""
        before, self.drawn_from = self.drawn_from, drawn
        return drawn != before

    def fade(self, job: Job, *parts: str) -> None:
        """Mark a chart and its lists, by their element ids, while their job has no answer to the
        latest request."""
        for id in parts:
            self.page.props(id, data_outdated="" if job.slow or job.cancelled else None)
