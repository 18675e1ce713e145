"""What a feature is: a part of the page that is a function of a snapshot.

A feature is one file in `features`. It declares its tab and its choices, binds its other controls
and makes its jobs when a visitor comes; `wanted` says what it needs of them for a snapshot; its
parts say what the page shows. Nothing else keeps a list of features, of tabs or of charts.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from functools import partial
from typing import Any, NamedTuple

from beamviz.explorer import page
from beamviz.explorer.declarations import Declared, Tab, tabs
from beamviz.explorer.jobs import JobStatus, percentage
from beamviz.explorer.page import Content, faded, names
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.solutions import SOLUTION
from beamviz.explorer.state import write_tab
from beamviz.explorer.visitor import Visitor


class Part(NamedTuple):
    """A part of the page: a function of its readings of a snapshot. The function is called again
    when one of the readings is another object, or, of the types PLAIN, has another value."""

    reads: Callable[[Snapshot], tuple[Any, ...]]  # the readings: all that the part depends on
    shows: Callable[..., Content]  # the contents of the page for the readings
    ids: Collection[str]  # of its elements, and the keys of its controls

    def content(self, *reading: Any) -> Content:
        """The contents of the page for what was read. They name all elements of the part, also
        those that show nothing: what is not named would go on to show an earlier snapshot. Raises
        ValueError where one is missing."""
        content = self.shows(*reading)
        if missing := {*self.ids} - names(content):
            raise ValueError(f"{self.shows} says nothing of {', '.join(sorted(missing))}")
        return content


class Feature(Declared):
    """A part of the page and what belongs to it: see `Declared` for its tab and its choices."""

    def __init__(self, visitor: Visitor):
        self.visitor, self.page = visitor, visitor.page
        for choice in self.choices:
            if choice.values:
                visitor.bind_choice(choice)

    def react(self, snapshot: Snapshot, elapsed: float) -> None:
        """Edit the state as a snapshot demands, in the frame that shows it, `elapsed` [s] after the
        one before: the next frame shows the edit."""

    def wanted(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """The requests whose answers the page needs for a snapshot, by the names of the jobs; None
        withdraws one, PENDING stands for one that follows from an answer to come. A job that is
        not named goes on with its latest request."""
        return {}

    @property
    def parts(self) -> Iterable[Part]:
        """The parts of the page."""
        return ()


def fading(jobs: Collection[str], *ids: str) -> Part:
    """The part that marks elements, by their ids, while they show what is not that of the numbers
    beside them: one of these jobs, or that of the modes, has not answered its latest request."""
    return Part(lambda s: (s.lateness(SOLUTION, *jobs),), lambda words: faded(words, *ids), ids)


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
    return text + (cancel if any(job.slow and not job.led for job in jobs) else "")


def cancelled(jobs: Iterable[JobStatus]) -> str:
    """What is said (HTML) of those jobs that were cancelled: their names, and a button that
    computes the visitor's own again; "" for none."""
    stopped = [job for job in jobs if job.cancelled]
    if not stopped:
        return ""
    text = f"cancelled: {', '.join(job.name for job in stopped)}"
    return text + ("" if all(job.led for job in stopped) else RETRY)


def waiting(id: str, tab: Tab) -> Part:
    """The part that says in an empty place of a tab, an element by its id, which of its jobs its
    first result waits for, or offers to compute it again."""
    return Part(lambda s: (lacking(s, tab.waits_for),), partial(waiting_content, id), (id,))


def told_elsewhere(snapshot: Snapshot) -> JobStatus | None:
    """The job that the open tab says it waits for."""
    return lacking(snapshot, tabs()[write_tab(snapshot.state.tab)].waits_for)


def lacking(snapshot: Snapshot, jobs: Iterable[str]) -> JobStatus | None:
    """The first of some jobs without a result; None where all have one."""
    return next((job for name in jobs if (job := snapshot.jobs[name]).result is None), None)


def waiting_content(id: str, job: JobStatus | None) -> Content:
    """What is said of a job without a result, in an element by its id."""
    if job is None or not (job.late or job.cancelled):
        return page.html(id, "")
    if job.late:
        return page.html(id, progress([job]))
    return page.html(id, cancelled([job]) if job.led else RETRY)


PLAIN = (str, int, float, bool, tuple, frozenset, type(None))


def same(before: tuple[Any, ...] | None, after: tuple[Any, ...]) -> bool:
    """Whether two readings of a part are the same."""
    if before is None or len(before) != len(after):
        return False
    for a, b in zip(before, after, strict=True):
        if a is not b and not (isinstance(a, PLAIN) and a == b):
            return False
    return True


class Memo:
    """The last value of a function and what it was computed from."""

    def __init__(self) -> None:
        self.reading: tuple[Any, ...] | None = None
        self.value: Any = None

    def __call__(self, function: Callable[..., Any], *reading: Any) -> Any:
        """`function(*reading)`, computed again only for another reading."""
        if not same(self.reading, reading):
            self.value, self.reading = function(*reading), reading
        return self.value


class Shown:
    """The reading that a part of the page or of the scene was shown for last."""

    def __init__(self) -> None:
        self.reading: tuple[Any, ...] | None = None

    def differs_from(self, *reading: Any) -> bool:
        """Whether the last reading differs from this one, which becomes the last."""
        before, self.reading = self.reading, reading
        return not same(before, reading)
