"""A visitor's session: in each frame one snapshot is taken, and page and scene show it.

A move of a slider becomes a picture at these stations:

1. `Page.received`: the page sends the value;
2. `Visitor.change`: the state is replaced;
3. `Visitor.wake`: the page is outdated, and drawn in the next frame;
4. `Job.request`: in that, the new case becomes the latest request of the solver job;
5. `Job.perform`: the case is solved, and its shapes are sampled: in the frame where that is quick,
   else by a worker thread;
6. `Visitor.next_inputs`: state, answers and clock of this frame, whose snapshot is taken;
7. `Session.tick`: page and scene show the snapshot; what differs from what was sent is sent.
"""

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from viser import CameraHandle

from beamviz.drawing.camera import place
from beamviz.errors import InvalidInput
from beamviz.explorer.camera import Transition, viewpoint
from beamviz.explorer.clock import Clock
from beamviz.explorer.feature import Feature, tabs
from beamviz.explorer.jobs import PENDING
from beamviz.explorer.presenter import led_clock
from beamviz.explorer.snapshot import Inputs, Snapshot
from beamviz.explorer.view import SceneView, fitted_clock, picture_of, with_second
from beamviz.explorer.visitor import Visitor
from beamviz.server.viser_private import ViserScene

F = TypeVar("F", bound=Feature)
LONGEST_STEP = 0.2  # [s] largest advance of the clock in a frame, also after a delay
REST = 0.25  # [s] since the last edit of a beam, before a busy server computes its charts


class Session:
    """The page and the scene of one visitor. Callbacks change their state; `tick`, for the frame
    loop, shows it: nothing is remembered of earlier snapshots but what the browser was sent.

    snapshot: that of the last frame; last_tick: its time [s]; last_shown: the time of the last one
    that took a snapshot; last_edit: that of the last one with another beam; postponed: what the
    page needs of the jobs is left to a later frame.
    """

    def __init__(self, visitor: Visitor, features: Iterable[type[Feature]]):
        self.visitor = visitor
        self.last_tick = self.last_shown = self.last_edit = 0.0
        visitor.tabs = tabs(features)
        self.features = [kind(visitor) for kind in features]
        self.postponed = False
        self.view = SceneView(ViserScene(visitor.client.scene), visitor.client.camera)
        for feature in self.features:
            feature.add_to(self.view)
        self.snapshot = self.with_picture(visitor.next_inputs())
        visitor.clock = self.snapshot.clock
        visitor.client.camera.on_update(self.camera_moved)
        visitor.page.send(True, "ready")  # all actions have handlers

    def feature(self, kind: type[F]) -> F:
        """The feature of a kind."""
        return next(feature for feature in self.features if isinstance(feature, kind))

    async def camera_moved(self, _: CameraHandle) -> None:
        """Take over where the visitor has turned the view to, and draw again, as the picture has
        another scale. While a viewpoint that was asked for since the last frame, also by a change
        of the frame of reference, has not arrived at the page, nothing is taken over. One that is
        too far away is left again in the next frame, for that of before, which is theirs though the
        server has set it."""
        visitor, shown = self.visitor, self.snapshot.state
        with visitor.lock:
            state = visitor.state
            changes = state.view.rotating_frame != shown.view.rotating_frame
            is_asked = state.turned is None and (changes or state.viewpoint != shown.viewpoint)
            is_theirs = state.turned is not None and visitor.camera.is_at(state.turned)
            if not (is_asked or is_theirs or visitor.clock.transition):
                with suppress(InvalidInput):
                    visitor.set_state(state.with_fields(turned=visitor.camera.turned))
        visitor.wake()

    def with_picture(self, inputs: Inputs) -> Snapshot:
        """The snapshot of a visitor's inputs: with what the scene shows of them, and the moment of
        that."""
        state, clock = inputs.state, inputs.clock
        picture = picture_of(inputs.answer or state.case, state.view, inputs.scale)
        for feature in self.features:
            picture = feature.picture(inputs, picture)
        picture = with_second(picture, state, inputs.second, inputs.comparison)
        if not inputs.is_led:  # the clock of the presenter has their film
            clock = clock.with_film(picture.film, picture.moment)
        return Snapshot.of(replace(inputs, clock=fitted_clock(clock, picture)), picture)

    @property
    def is_moving(self) -> bool:
        """Whether there is something to do in the next frame."""
        is_eased = self.visitor.clock.transition is not None
        return self.snapshot.is_moving or is_eased or self.postponed

    @property
    def page_moves(self) -> bool:
        """Whether the page moves as well, so that the next frame takes a snapshot: it shows the
        moment of a motion in time, or waits for what was postponed."""
        return self.postponed or (self.snapshot.is_moving and self.snapshot.film is not None)

    @property
    def is_busy(self) -> bool:
        """Whether a job is running, whose time the page shows."""
        return any(job.busy for job in self.visitor.jobs.values())

    def tick(self, now: float, *, postpones: bool = False) -> None:
        """Draw the frame of the time `now` [s]. postpones: the server is busy, and what the page
        needs of the jobs is only requested for a beam that has been the same for the time REST."""
        visitor, before = self.visitor, self.snapshot
        elapsed = min(now - self.last_shown, LONGEST_STEP)
        self.last_shown = now
        visitor.clock = self.advanced_clock(now)
        inputs = visitor.next_inputs()
        if inputs.state.still and not before.state.still:  # the page has moved until it was known
            inputs = replace(inputs, clock=inputs.clock.begun_again())
        self.snapshot = snapshot = self.with_picture(inputs)
        if not snapshot.is_led:
            for feature in self.features:
                feature.react(snapshot, elapsed)
        with visitor.client.atomic():
            self.show_scene(snapshot)
            if snapshot.state.case is not before.state.case:
                self.last_edit = now
            self.postponed = postpones and now < self.last_edit + REST
            self.show_page(snapshot)
            if not snapshot.is_led:
                self.request(snapshot)
            visitor.page.show_again()
        visitor.client.flush()

    def move(self, now: float) -> None:
        """Draw the moment of the time `now` [s] of what the last frame shows."""
        visitor = self.visitor
        self.snapshot = replace(self.snapshot, clock=self.advanced_clock(now))
        with visitor.client.atomic():
            self.draw(self.snapshot, self.snapshot.clock)
        visitor.client.flush()

    def advanced_clock(self, now: float) -> Clock:
        """The clock at the time `now` [s] of what the last frame shows; that of the presenter while
        the visitor follows one."""
        elapsed = min(now - self.last_tick, LONGEST_STEP)
        self.last_tick = now
        snapshot, clock = self.snapshot, self.visitor.clock
        if clock.transition:
            clock = replace(clock, transition=clock.transition.advanced(elapsed, clock.angle))
        if snapshot.is_led and (led := self.visitor.followed):
            return fitted_clock(led_clock(clock, led.clock), snapshot.picture)
        if not snapshot.is_moving:
            return clock
        time, picture = elapsed * snapshot.rate * snapshot.state.view.pace, snapshot.picture
        if film := picture.film:
            return clock.at(film.advanced(clock.moment, time))
        second = picture.second.shapes if picture.second else None
        return clock.advanced(time, picture.modes, second)

    def show_page(self, snapshot: Snapshot) -> None:
        """Show what the features have to say."""
        page = self.visitor.page
        for feature in self.features:
            page.show(feature.content(snapshot))

    def request(self, snapshot: Snapshot) -> None:
        """Request what the page needs of the background jobs; where that is postponed, let them
        expect it."""
        wanted: dict[str, Any] = {}
        for feature in self.features:
            wanted |= feature.wanted(snapshot)
        for name, job in self.visitor.jobs.items():
            request = wanted.get(name)
            if name not in wanted:
                job.settle()
            elif request is None:
                job.withdraw()
            elif request is PENDING or (self.postponed and not job.knows(request)):
                job.expect()
            else:
                job.request(request)
            if snapshot.jobs[name].late and not job.status.late:
                self.visitor.wake()  # to take back what the page says of it

    def show_scene(self, snapshot: Snapshot) -> None:
        """Draw the picture of a snapshot, and place the camera."""
        picture, clock = snapshot.picture, snapshot.clock
        moved = self.view.show(picture)
        if not picture.held:
            clock = replace(clock, transition=self.look(snapshot, moved))
        self.draw(snapshot, clock)

    def draw(self, snapshot: Snapshot, clock: Clock) -> None:
        """Draw a moment of a snapshot."""
        picture = snapshot.picture
        self.visitor.clock = clock
        if clock.transition and not picture.held:
            place(self.visitor.camera.view, clock.transition.camera)
        self.view.move(picture, clock)
        for feature in self.features:
            feature.move(snapshot)
        captions: list[dict[str, Any]] = [caption.data for caption in self.view.captions]
        captions += [hint.data | {"hint": True} for hint in self.view.hints if hint.text]
        self.visitor.page.show({("captions",): captions})

    def look(self, snapshot: Snapshot, moved: np.ndarray) -> Transition | None:
        """Place the camera for a snapshot. moved: how far the beam's frame was (3,) as the mass was
        released, which the view follows. Returns the transition under way."""
        camera, state, picture = self.visitor.camera, snapshot.state, snapshot.picture
        frame = state.view.rotating_frame
        shapes = picture.modes, frame, snapshot.aspect, tuple(picture.heights), snapshot.covered
        wanted = state.viewpoint or viewpoint(*shapes)
        transition, eased = snapshot.clock.transition, not state.still
        if moved.any() and eased:
            transition = camera.followed(moved, wanted, float(frame))
        return camera.look(wanted, frame, transition, eased=eased)

    def close(self) -> None:
        """Cancel everything that is being computed."""
        self.visitor.close()
