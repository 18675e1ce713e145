"""Features of the page, one module each; here the two without a tab: presenter mode, in which
visitors see the presenter's scene, and dragging the mass along the beam with the pointer."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from viser import BatchedMeshHandle, SceneNodeDragEvent
from viser.transforms import SO3

from beamviz.drawing import BeamView
from beamviz.drawing.beam_mesh import to_hub_frame
from beamviz.drawing.modes import Clock
from beamviz.explorer.features.run_up import RunUpPlayback
from beamviz.explorer.jobs import Job
from beamviz.explorer.page.html import checkbox
from beamviz.explorer.state import State
from beamviz.explorer.visitor import Visitor

# Presenter mode

FOLLOW_LABEL = "follow the presenter"
FOLLOW_HINT = "Move any control to explore by yourself; tick this to come back"


class Presentation(NamedTuple):
    """What others can follow of a visitor: the state, the answers of the jobs, the open tab, and
    the clock of the scene with its run-up."""

    visitor: Visitor
    clock: Clock
    run_up: RunUpPlayback


class PresenterMode:
    """Keeps a visitor's page in line with the presenter's while they follow; nothing is computed
    for it then. presenter: gives what to follow, None while there is no presenter; tab: the one of
    the presenter."""

    def __init__(self, own: Presentation, presenter: Callable[[], Presentation | None]):
        self.own, self.presenter, self.tab = own, presenter, own.visitor.page.tab
        own.visitor.page.html("presenter", checkbox("following", FOLLOW_LABEL, FOLLOW_HINT))
        own.visitor.bind("following")

    @property
    def followed(self) -> Presentation | None:
        """What to follow now."""
        return self.presenter() if self.own.visitor.state.following else None

    @property
    def outdated(self) -> bool:
        """Whether the presenter has something new."""
        other = self.followed
        return other is not None and (
            other.visitor.page.tab != self.tab
            or self.followed_state(other) != self.own.visitor.state
            or any(theirs.answer is not mine.answer for theirs, mine in self.answered_jobs(other))
        )

    def followed_state(self, other: Presentation) -> State:
        """The state of the presenter, seen from one's own viewpoint."""
        return replace(other.visitor.state, camera=self.own.visitor.state.camera, following=True)

    def answered_jobs(self, other: Presentation) -> list[tuple[Job, Job]]:
        """The presenter's jobs that have an answer, each with one's own."""
        pairs = zip(other.visitor.jobs, self.own.visitor.jobs, strict=True)
        return [(theirs, mine) for theirs, mine in pairs if theirs.answer]

    def update(self) -> None:
        """Take over the state, the answers and the open tab of the presenter."""
        own, other = self.own, self.followed
        for job in own.visitor.jobs:
            job.following = other is not None
        if other is None:
            return
        with own.visitor.lock:
            for theirs, mine in self.answered_jobs(other):
                mine.adopt(theirs)
            own.run_up.request = other.run_up.request
            if (state := self.followed_state(other)) != own.visitor.state:
                own.visitor.follow(state)
        if other.visitor.page.tab != self.tab:
            self.tab = other.visitor.page.tab
            own.visitor.page.open(self.tab)

    def update_clock(self) -> None:
        """Show the same moment of the same vibration as the presenter."""
        clock = self.own.clock
        if other := self.followed:
            theirs = other.clock
            if len(clock.phases) == len(theirs.phases):
                clock.phases, clock.angle, clock.rate = theirs.phases, theirs.angle, theirs.rate
            self.own.run_up.phase = other.run_up.phase


# Dragging the mass

DIGITS = 3  # of beta: finer than a pointer
SETTLED = 0.002  # change of beta below which the mass is under the pointer
PARALLEL = 0.03  # sine of the angle between view and beam below which there is no position
TINY = 1e-300


class Sight(NamedTuple):
    """The line of sight from `eye` (3,) through `point` (3,) under the pointer, and the orientation
    of the hub at that moment."""

    eye: np.ndarray
    point: np.ndarray
    hub: SO3


class MassDrag:
    """Turns drags of the mass into values of beta; time and the scene stand still meanwhile.

    offset: from the centre of the mass to where it was picked up; sight: where the mass is to be,
    None once the shape of the beam with its mass there has been drawn; case: with the mass there.
    """

    def __init__(self, visitor: Visitor, view: BeamView):
        self.visitor, self.view = visitor, view
        self.offset, self.case = 0.0, visitor.state.case
        self.sight: Sight | None = None
        view.mass.on_drag(self.dragged)
        view.mass.on_click(self.clicked)  # for the outline under the pointer

    async def clicked(self, event: object) -> None:
        """A click without a drag changes nothing."""

    async def dragged(self, event: SceneNodeDragEvent[BatchedMeshHandle]) -> None:
        """Take a step of a drag; on the event loop, so that steps come in order."""
        visitor = self.visitor
        if event.phase == "end":
            visitor.dragging = False
            visitor.wake()
            return
        sight = self.look(np.asarray(event.end_position, float))
        x = self.place(sight)
        if x is None:
            return
        begins = not visitor.dragging
        if begins:
            self.offset = x - self.view.shapes.beam.beta
            self.view.held = visitor.dragging = True
        self.sight = sight
        self.move(x, begins=begins)

    def move(self, x: float, *, begins: bool) -> None:
        """Move the mass to where it was picked up at the reference coordinate x."""
        beta = min(max(round(x - self.offset, DIGITS), 0.0), 1.0)

        def moved(state: State) -> State:
            return (state.keep_for_comparison() if begins else state).changed("beta", beta)

        self.visitor.change(moved)
        self.case = self.visitor.state.case

    @property
    def outdated(self) -> bool:
        """Whether the mass was let go, and the scene is still held."""
        return self.sight is not None and not self.visitor.dragging

    def update(self) -> None:
        """Bring the mass under the pointer again where the beam has taken another shape since,
        unless something else was edited; then let the scene go."""
        visitor, case = self.visitor, self.visitor.state.case
        if self.sight is None:
            return
        if case is self.case:
            if visitor.answer is None or visitor.answer.request != case:
                return
            x = self.place(self.sight)
            if x is not None and abs(x - self.offset - case.numbers["beta"]) > SETTLED:
                self.move(x, begins=False)
                return
        if not visitor.dragging:
            self.sight, self.view.held = None, False
            before = np.array(self.view.frame.position)
            self.view.choose_frame(self.view.share)
            visitor.camera.follow(self.view.frame.position - before, self.view.share)

    def look(self, point: np.ndarray) -> Sight:
        """The line of sight through a point (3,), now."""
        eye = np.asarray(self.visitor.client.camera.position)
        return Sight(eye, point, SO3(np.array(self.view.rotor.wxyz)))

    def place(self, sight: Sight) -> float | None:
        """The reference coordinate of the place on the beam, straight or bent, that is nearest to a
        line of sight; None where that is not defined."""
        view = self.view
        points, _ = to_hub_frame(view.shapes, view.shapes.centreline)
        turned = np.asarray(view.frame.position) + sight.hub.apply(points)
        return nearest(turned, view.shapes.x, sight.eye, sight.point)


def nearest(points: np.ndarray, x: np.ndarray, eye: np.ndarray, at: np.ndarray) -> float | None:
    """The coordinate, x (n,) at `points` (n, 3), of the place of a line that is nearest to the line
    of sight from `eye` through `at`; None where it is seen end on or the numbers are not finite."""
    sight = at - eye
    length = float(np.linalg.norm(sight))
    if not (np.isfinite(length) and length > 0):
        return None
    sight = sight / length
    seen = points - eye
    seen = seen - np.outer(seen @ sight, sight)  # as the line of sight sees the points
    steps = np.diff(seen, axis=0)
    sizes = (steps**2).sum(axis=1)
    if np.sqrt(sizes).sum() < PARALLEL * np.linalg.norm(np.diff(points, axis=0), axis=1).sum():
        return None
    share = np.clip(-(seen[:-1] * steps).sum(axis=1) / np.maximum(sizes, TINY), 0.0, 1.0)
    k = int(np.argmin(((seen[:-1] + share[:, None] * steps) ** 2).sum(axis=1)))
    return float(x[k] + share[k] * (x[k + 1] - x[k]))
