"""What a feature is: a part of the page that is a function of a snapshot.

A feature is one file in `features`. It declares its tab, binds its controls and makes its jobs when
a visitor comes; `wanted` says what it needs of them for a snapshot; its parts say what the page
shows. Nothing else keeps a list of features, of tabs or of charts.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, ClassVar, NamedTuple

from beamviz.explorer.jobs import SOLUTION
from beamviz.explorer.page import Content, faded, names
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.visitor import Visitor


class Tab(NamedTuple):
    """A tab: its name, its place among the others, in ascending order, and its content (HTML),
    which a feature may replace by `html("tab-<key>", ...)`."""

    name: str
    place: int
    content: str = ""

    @property
    def key(self) -> str:
        """The key of the tab in links and in the ids of its elements."""
        return self.name.lower()


def tabs() -> dict[str, Tab]:
    """The tabs of all features by key, in their order."""
    found = (kind.tab for kind in Feature.__subclasses__() if kind.tab)
    return {tab.key: tab for tab in sorted(found, key=lambda tab: tab.place)}


def tab_named(key: str) -> str:
    """The tab of a key as the state has it: "" for the first."""
    return "" if key == next(iter(tabs())) else key


class Part(NamedTuple):
    """A part of the page. reads: returns what the part depends on, of a snapshot; shows: returns
    the contents of the page for these, and depends on nothing else; ids: of its elements and the
    keys of its controls. It is called again when one of the readings is another object, or, of the
    plain types, has another value."""

    reads: Callable[[Snapshot], tuple[Any, ...]]
    shows: Callable[..., Content]
    ids: Collection[str]

    def content(self, *reading: Any) -> Content:
        """The contents of the page for what was read. They name all elements of the part, also
        those that show nothing: what is not named would go on to show an earlier snapshot. Raises
        ValueError where one is missing."""
        content = self.shows(*reading)
        if missing := {*self.ids} - names(content):
            raise ValueError(f"{self.shows} says nothing of {', '.join(sorted(missing))}")
        return content


class Feature:
    """A part of the page and what belongs to it. `tab`: None for one around the scene."""

    tab: ClassVar[Tab | None] = None

    def __init__(self, visitor: Visitor):
        self.visitor, self.page = visitor, visitor.page

    def react(self, snapshot: Snapshot, elapsed: float) -> None:
        """Edit the state as an answer or time, `elapsed` [s] since the last frame, demands."""

    def notice(self, snapshot: Snapshot) -> None:
        """Keep in the state what a snapshot shows, in the frame that shows it: there may be no
        other."""

    def wanted(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """The requests whose answers the page needs for a snapshot, by the names of the jobs; None
        withdraws one. A job that is not named goes on with its latest request."""
        return {}

    @property
    def parts(self) -> Iterable[Part]:
        """The parts of the page."""
        return ()


def fading(jobs: Collection[str], *ids: str) -> Part:
    """The part that marks elements, by their ids, while they show what is not that of the numbers
    beside them: one of these jobs, or that of the modes, has not answered its latest request."""
    return Part(lambda s: (s.lateness(SOLUTION, *jobs),), lambda words: faded(words, *ids), ids)


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
        """Whether it was another one than this, which is kept instead."""
        before, self.reading = self.reading, reading
        return not same(before, reading)
