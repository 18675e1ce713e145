"""What a feature is: a part of the page that is a function of a snapshot.

A feature is one file in `features`. It declares its tab and its part of the state, binds its other
controls and makes its jobs when a visitor comes; `wanted` says what it needs of them for a
snapshot, and `content` what the page shows. It is an entry of FEATURES (`features/__init__.py`);
nothing else keeps a list of features, of tabs or of charts.
"""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from typing import Any, ClassVar

from beamviz.explorer import page
from beamviz.explorer.declarations import Choice, Tab, choices_of
from beamviz.explorer.jobs import JobStatus, percentage
from beamviz.explorer.page import Content, faded
from beamviz.explorer.snapshot import Inputs, Snapshot
from beamviz.explorer.solutions import SOLUTION
from beamviz.explorer.state import Slice, State
from beamviz.explorer.view import Picture, SceneView
from beamviz.explorer.visitor import Visitor
from beamviz.scene import Scene


class Feature:
    """A part of the page and what belongs to it."""

    tab: ClassVar[Tab | None] = None  # None for a feature around the scene
    style: ClassVar[str] = ""  # name of its file of CSS, in the folder `features`
    state: ClassVar[type[Slice] | None] = None  # its part of the visitor's state

    def __init__(self, visitor: Visitor):
        self.visitor, self.page = visitor, visitor.page
        for choice in self.choices():
            if choice.values:
                visitor.bind_choice(choice)

    @classmethod
    def choices(cls) -> Collection[Choice[Any]]:
        """The choices that belong to the feature alone."""
        return choices_of(cls.state).values() if cls.state else ()

    @classmethod
    def prepare(cls) -> None:
        """Compute what takes some time and all visitors share, before the first one comes."""

    @classmethod
    def begun(cls, state: State) -> State:
        """The state in which a page opens, which the features before it have begun."""
        return state

    @classmethod
    def linked(cls, state: State, names: Collection[str]) -> State:
        """The state that a link describes by the choices of these names, which it has."""
        return state

    def react(self, snapshot: Snapshot, elapsed: float) -> None:
        """Edit the state as a snapshot demands, in the frame that shows it, `elapsed` [s] after the
        one before: the next frame shows the edit. It is not called for a snapshot of a presenter,
        whose features edit theirs."""

    def wanted(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """The requests whose answers the page needs for a snapshot, by the names of the jobs; None
        withdraws one, PENDING stands for one that follows from an answer to come. A job that is
        not named goes on with its latest request."""
        return {}

    def picture(self, inputs: Inputs, picture: Picture) -> Picture:
        """What the scene shows: that of the features before it, or another picture."""
        return picture

    def add_to(self, view: SceneView) -> None:
        """Add objects to the scene of the visitor who comes, and take what is dragged there."""

    def move(self, snapshot: Snapshot) -> None:
        """Move these objects to a moment of a snapshot, whose beam is drawn."""

    def content(self, snapshot: Snapshot) -> Content:
        """What the page shows of a snapshot. It names all elements of the feature, also those that
        show nothing: what is not named goes on to show an earlier snapshot."""
        return {}


def tabs(features: Iterable[type[Feature]]) -> dict[str, Tab]:
    """The tabs of features by key, in their order."""
    declared = (kind.tab for kind in features if kind.tab)
    return {tab.key: tab for tab in sorted(declared, key=lambda tab: tab.place)}


def first_tab(features: Iterable[type[Feature]]) -> str:
    """The key of the tab that is open at first; "" without tabs."""
    return next(iter(tabs(features)), "")


def usual_state(scene: Scene, features: Iterable[type[Feature]]) -> State:
    """The state of a scene, with all other choices of these features as usual."""
    kinds = tuple(features)
    state = State.of(scene, (kind.state for kind in kinds if kind.state))
    return replace(state, tab=first_tab(kinds))


def first_state(scene: Scene, features: Iterable[type[Feature]]) -> State:
    """The state in which a page with these features opens on a scene."""
    features = tuple(features)
    state = usual_state(scene, features)
    for kind in features:
        state = kind.begun(state)
    return state


def fading(snapshot: Snapshot, jobs: Collection[str], *ids: str) -> Content:
    """Marks elements, by their ids, while they show what is not that of the numbers beside them:
    one of these jobs, or that of the modes, has not answered its latest request."""
    return faded(snapshot.lateness(SOLUTION, *jobs), *ids)


RETRY = page.button("Compute again", data_do="retry_jobs")


def progress(jobs: Collection[JobStatus]) -> str:
    """What is said (HTML) of jobs that are running: their names, the fraction computed, and after a
    while the time and a button that cancels the visitor's own; "" for none."""
    if not jobs:
        return ""
    told = ", ".join(job.name for job in jobs)
    seconds = max(job.seconds for job in jobs)
    time = f" {seconds} s" if seconds else ""
    text = f'computing: {told} <span aria-hidden="true">…{percentage(jobs)}{time}</span>'
    cancel = page.button("Cancel", data_do="cancel_jobs")
    return text + (cancel if any(job.slow and job.is_own for job in jobs) else "")


def cancelled(jobs: Iterable[JobStatus]) -> str:
    """What is said (HTML) of those jobs that were cancelled: their names, and a button that
    computes the visitor's own again; "" for none."""
    stopped = [job for job in jobs if job.cancelled]
    if not stopped:
        return ""
    text = f"cancelled: {', '.join(job.name for job in stopped)}"
    return text + (RETRY if any(job.is_own for job in stopped) else "")


def waiting(snapshot: Snapshot, id: str, tab: Tab) -> Content:
    """Says in an empty place of a tab, an element by its id, which of its jobs its first result
    waits for, or offers to compute it again."""
    return waiting_content(id, lacking(snapshot, tab.waits_for))


def lacking(snapshot: Snapshot, jobs: Iterable[str]) -> JobStatus | None:
    """The first of some jobs without a result; None where all have one."""
    return next((job for name in jobs if (job := snapshot.jobs[name]).result is None), None)


def waiting_content(id: str, job: JobStatus | None) -> Content:
    """What is said of a job without a result, in an element by its id."""
    if job is None or not (job.late or job.cancelled):
        return page.html(id, "")
    if job.late:
        return page.html(id, progress([job]))
    return page.html(id, RETRY if job.is_own else cancelled([job]))
