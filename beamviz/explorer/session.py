"""A visitor's session: the scene, the page and the features, drawn by the frame loop.

A move of a slider becomes a picture at these stations:

1. `Page.received`: the page sends the value;
2. `Visitor.change`: the state is replaced;
3. `Job.request`: the new case becomes the latest request of the solver job;
4. `Workers.solve`: it waits for a worker thread, or for a batch;
5. `Job.run`: the case is solved, and its shapes are sampled;
6. `FrameLoop.wake`: the page of the visitor is marked as outdated;
7. `Session.tick`: the frame loop draws the answer;
8. `SceneView.show` and `move`: the picture, the controls and the texts of the page.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from viser import CameraHandle

from beamviz.drawing import BeamScene, stacked_heights
from beamviz.drawing.beam_mesh import DrawnBeam
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.objects import Caption
from beamviz.explorer.features.comparison import THIS, Comparison, ComparisonTab
from beamviz.explorer.features.controls import Controls, MassDrag
from beamviz.explorer.features.lessons import Lessons
from beamviz.explorer.features.loci_chart import LociTab
from beamviz.explorer.features.map import MapTab
from beamviz.explorer.features.method_timing import MethodTimingTab
from beamviz.explorer.features.real_beam import RealBeamPanel
from beamviz.explorer.features.run_up import RESPONSE, RunUpPlayback, RunUpTab
from beamviz.explorer.features.sharing import Files, Links
from beamviz.explorer.features.veering import VeeringTab
from beamviz.explorer.page import checkbox, panel
from beamviz.explorer.visitor import Feature, Visitor
from beamviz.scene import Scene
from beamviz.server.viser_private import ViserScene

LONGEST_STEP = 0.2  # [s] largest advance of the clock in a frame, also after a delay
REST = 0.3  # [s] that a slider is at rest before the charts are updated, with many visitors
ZOOMED = 1.25  # ratio of scales from which on the beam is subdivided again
FOLLOW_HINT = "Any control switches this off: you explore by yourself. Tick it to follow again"


class SceneView(Feature):
    """The 3D view of a visitor: the beam, or all its modes in rows, and the beam compared with, on
    one clock. `show` draws the state and the answer, `move` advances the time.

    beam: the single one; shapes: the modes drawn; drawn: the beam that moves in these modes, or, if
    `driven`, by a force; shown_modes: those (from 0) in the picture; solved, stable: the modes of
    the last solution, and of the last stable one, of this scene.
    """

    def __init__(self, visitor: Visitor, comparison: Comparison, run_up: RunUpPlayback):
        super().__init__(visitor)
        self.camera, self.clock, self.state = visitor.camera, visitor.clock, visitor.state
        self.comparison, self.run_up = comparison, run_up
        self.scene = BeamScene(ViserScene(visitor.client.scene))
        self.beam = self.scene.view(0)
        scene = visitor.state.scene
        self.open(scene)
        self.shapes = SampledModes.at_rest(scene.beam, scene.options["plane"])
        self.drawn = DrawnBeam(self.shapes, scene.view)

    def open(self, scene: Scene) -> None:
        """Begin with a scene that was loaded, which is not solved yet."""
        self.opened = scene
        self.solved: SampledModes | None = None
        self.stable: SampledModes | None = None
        self.is_pending = True  # no answer to this scene has come
        self.choose_pace = True

    @property
    def has_moved(self) -> bool:
        """Whether a viewpoint is requested, or the scale needs another subdivision of the beam."""
        if self.camera.requested:
            return True
        ratio = self.camera.scale / self.drawn.scale
        return not (self.camera.change or 1 / ZOOMED < ratio < ZOOMED)

    def show(self) -> None:
        """Draw the state and the latest answer. For an unstable beam, or an error, draw the last
        stable shapes of the scene, or else the unloaded beam. Unless it is the answer to the case
        of the state, camera and playback rate are chosen again at the next answer."""
        visitor = self.visitor
        with visitor.lock:
            state, visitor.answer = visitor.state, visitor.solver.answer
        answer = visitor.answer
        settled = answer is not None and answer.request == state.shown_case
        if state.scene is not self.opened:
            self.open(state.scene)
        before, after, self.state = self.state.view, state.view, state
        if (after.shares, after.all_modes) != (before.shares, before.all_modes):
            self.choose_pace = True
        self.is_pending = self.is_pending and not settled
        if answer and not self.is_pending:
            self.solved = answer.result or self.solved
            self.stable = self.stable if answer.warning else answer.result or self.stable
            beam, plane = answer.beam or self.opened.beam, answer.request.options["plane"]
            self.shapes = self.stable or SampledModes.at_rest(beam, plane)
        frequencies = self.choose_modes()
        self.clock.fit(frequencies, self.shapes.beam.gamma, keep=not self.choose_pace)
        self.choose_pace = self.choose_pace and not settled
        self.draw(settled=settled)

    def choose_modes(self) -> np.ndarray:
        """Choose the modes drawn, none while a force drives the beam. Returns the frequencies."""
        view, shapes, scale = self.state.view, self.shapes, self.camera.scale
        response = self.run_up.drawn(shapes, scale)
        self.drawn, self.shown_modes = response or DrawnBeam(shapes, view, scale), []
        self.driven = response is not None
        if self.driven:
            return np.array([self.state.force_per_rev * shapes.beam.gamma])
        self.shown_modes = list(range(len(shapes.modes))) if view.all_modes else self.drawn.shown
        return shapes.frequencies[self.shown_modes]

    def draw(self, *, settled: bool) -> None:
        """Draw the beam, or all its modes, and the beam compared with."""
        self.comparison.draw(self.drawn, self.clock, driven=self.driven)
        heights = self.comparison.heights
        self.beam.height = heights[0]
        title = THIS if len(heights) > 1 else ""
        self.scene.show(replace(self.drawn, warning=self.warning, title=title))
        if self.scene.rows != [self.beam]:
            heights = stacked_heights(len(self.scene.rows))
        self.camera.given = self.state.camera
        if not self.beam.fixed:
            frame = self.state.view.rotating_frame
            self.camera.look_at(self.shapes, frame, heights, settled=settled)

    def move(self, time: float) -> None:
        """Draw the moment of the clock, `time` [T*] after the last one."""
        angle, change = self.clock.angle, self.camera.change
        if change:
            angle = change.angle
            self.scene.choose_frame(change.rotating_share)
        force = np.array([self.state.force_per_rev * self.clock.angle])
        self.scene.move(force if self.driven else self.clock.phases, angle)
        self.comparison.move(time, change)

    @property
    def captions(self) -> list[Caption]:
        """The texts that the page writes over the scene. The warning is not one of them, as it is
        above the scene, nor is the speed while the beam of an earlier answer is drawn."""
        answer, hidden = self.visitor.answer, [self.beam.warning]
        if self.beam.surroundings and answer and answer.beam != self.shapes.beam:
            hidden.append(self.beam.surroundings.speed)
        captions = [*self.scene.captions, *self.comparison.captions]
        return [caption for caption in captions if caption not in hidden]

    @property
    def warning(self) -> str:
        return self.visitor.answer.warning if self.visitor.answer else ""

    @property
    def pace(self) -> float:
        """Time [T*] that passes in one second."""
        return self.clock.rate * self.state.view.pace


class Session:
    """The page of one visitor. Callbacks change their state; `tick`, for the frame loop, draws it.

    presenter: returns the presenter of a lecture, None while there is none; itself None without a
    lecture; presented_tab: the one that the presenter had open last, while visitors may open
    another; last_tick: time [s] of the last frame; version: of the visitor, in the last frame;
    features, charts: the parts of the page, of which with many visitors the charts follow only when
    a slider is at rest; charts_due: time [s] when they follow; charts_outdated: they are to follow.
    """

    def __init__(self, visitor: Visitor, presenter: Callable[[], Visitor | None] | None):
        self.visitor, self.last_tick, self.charts_due = visitor, 0.0, 0.0
        self.presenter, self.presented_tab = presenter, visitor.state.tab
        self.version: object = None
        self.charts_outdated = False
        self.comparison, self.run_up = Comparison(visitor), RunUpPlayback(visitor)
        loci, lessons = LociTab(visitor, self.comparison), Lessons(visitor)
        panels = Controls(visitor), RealBeamPanel(visitor), ComparisonTab(visitor, self.comparison)
        self.features: Sequence[Feature] = (*panels, RunUpTab(visitor, self.run_up), lessons)
        others = VeeringTab(visitor, loci), MethodTimingTab(visitor), MapTab(visitor)
        self.charts: Sequence[Feature] = (loci, *others)
        self.files = Files(visitor)
        self.view = SceneView(visitor, self.comparison, self.run_up)
        self.mass_drag = MassDrag(visitor, self.view.beam)
        if presenter:
            follow = checkbox("following", "follow the presenter", FOLLOW_HINT)
            visitor.page.html("presenter", follow)
            visitor.bind("following")
        visitor.page.on("preferences", self.take_preferences)
        visitor.client.camera.on_update(self.camera_moved)
        self.links = Links(visitor, lessons)
        visitor.page.send(True, "ready")  # all actions have handlers

    async def camera_moved(self, _: CameraHandle) -> None:
        """Fit the beam again if the aspect ratio of the page has changed."""
        camera = self.visitor.camera
        if camera.reshaped:
            camera.set_viewpoint(None)
        camera.requested |= camera.outdated
        self.links.moved = True
        if self.view.has_moved:
            self.visitor.wake()

    def take_preferences(self, preferences: Any) -> None:
        """Apply the preferences of the visitor's system: "dark" (the theme, unless the first scene
        is dark) and "still" (reduced motion: paused, without transitions of the view)."""
        visitor, words = self.visitor, str(preferences).split()
        visitor.still = "still" in words
        visitor.camera.eased = not visitor.still
        with visitor.lock:
            state = visitor.state
            if visitor.still:
                state = state.changed("playing", False)
            if not self.links.start.view.dark:
                state = state.changed("dark", "dark" in words)
            visitor.set_state(state)

    @property
    def followed(self) -> Visitor | None:
        """The presenter, while the visitor follows them."""
        return self.presenter() if self.presenter and self.visitor.state.following else None

    def follow(self) -> None:
        """Use the presenter's answers and state, not the viewpoint; nothing is computed then."""
        own, other = self.visitor, self.followed
        for k, job in enumerate(own.jobs):
            job.follow(other.jobs[k] if other else None)
        if other is None:
            return
        with own.lock:
            tab, self.presented_tab = self.presented_tab, other.state.tab
            tab = own.state.tab if tab == other.state.tab else other.state.tab
            state = replace(other.state, camera=own.state.camera, tab=tab, following=True)
            if state != own.state:
                own.set_state(state)

    @property
    def is_moving(self) -> bool:
        view = self.view.state.view
        playing = view.playing and view.pace > 0
        return (playing or self.run_up.running) and not (self.view.warning or self.visitor.dragging)

    @property
    def needs_tick(self) -> bool:
        visitor = self.visitor
        moving = self.is_moving or visitor.camera.change is not None
        return moving or self.charts_outdated or self.has_changed or self.links.outdated

    @property
    def outdated(self) -> bool:
        """Whether to draw before the next round of frames; a case being solved is drawn soon."""
        return self.has_changed and not self.visitor.solver.busy

    @property
    def has_changed(self) -> bool:
        """Whether a part of the page is outdated."""
        visitor = self.visitor
        is_current = visitor.page.sent.get(("html", "work")) == panel.work(visitor.jobs)
        return visitor.version is not self.version or self.view.has_moved or not is_current

    def tick(self, now: float) -> None:
        """Draw the frame of the time `now` [s]."""
        visitor, view = self.visitor, self.view
        elapsed, self.last_tick = min(now - self.last_tick, LONGEST_STEP), now
        if outdated := self.has_changed:
            self.follow()
        self.run_up.step(elapsed)
        before, self.version = self.version, visitor.version
        outdated = outdated or before is not self.version
        with visitor.client.atomic():
            change = visitor.camera.change
            jobs = visitor.solver, self.comparison.job, self.run_up.job
            changed = view.redraws(visitor.state, *(job.answer for job in jobs))
            if changed or view.has_moved:
                self.draw()
                self.charts_due = now + (REST if visitor.workers.crowded() else 0.0)
            time = elapsed * view.pace if self.is_moving else 0.0
            view.clock.advance(time, view.shapes.frequencies, view.shapes.beam.gamma)
            self.mass_drag.update()
            is_under_way = visitor.camera.change is change  # since an earlier frame
            visitor.camera.step(elapsed if is_under_way else 0.0, view.clock.angle)
            if (other := self.followed) and len(other.clock.phases) == len(view.clock.phases):
                vars(view.clock).update(vars(other.clock))
            view.move(time)
            if outdated:
                visitor.show_controls()
                for feature in self.features:
                    feature.show()
            self.links.update(now)
            visitor.page.html("work", panel.work(visitor.jobs))
            answer = visitor.answer
            if self.links.opened and answer and answer.request == visitor.state.case:
                visitor.page.props("scene", data_ready="")  # it is hidden at first
        visitor.client.flush()
        self.charts_outdated |= outdated
        if self.charts_outdated:
            self.show_charts(now)

    def draw(self) -> None:
        """Draw the latest answer and state; the colours have no scale where the beam is grey. The
        caption is an invitation until the first edit."""
        page, view, case = self.visitor.page, self.view, self.visitor.state.case
        view.show()
        page.send_changed([caption.data for caption in view.captions], "captions")
        page.props("playing", disabled=bool(view.warning))
        panel.show_answer(self.visitor, view.solved, view.shown_modes)
        units = view.shapes.beam.units
        legend = panel.legend(view.state.view.colouring, view.drawn.largest, units)
        page.html("legend", "" if view.warning else legend)
        page.html("pace-text", panel.pace(view.pace, units))
        invitation = panel.invitation(case) if case is self.links.start.case else ""
        page.html("scene-caption", RESPONSE if view.driven else invitation)

    def show_charts(self, now: float) -> None:
        """Show the charts, with many visitors only if the slider is at rest."""
        visitor = self.visitor
        if now >= self.charts_due and not (visitor.solver.busy and visitor.workers.crowded()):
            self.charts_outdated = False
            for chart in self.charts:
                chart.show()

    def close(self) -> None:
        """Cancel the export and close all jobs."""
        for job in (self.files.job, *self.visitor.jobs):
            job.close()
