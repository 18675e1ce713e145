"""Links: a page opens on the scene of its address, and the address follows the scene.

?lesson=nodes, ?alpha=1&gamma=10&mode=3, or both; ?compare=... and the keys of a scene.
"""

from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple
from urllib.parse import parse_qsl, urlencode

from beamviz.beam import check_int
from beamviz.errors import InvalidInput
from beamviz.explorer.features.comparison import SHORT
from beamviz.explorer.features.files import within_limits
from beamviz.explorer.features.lessons import STEPS, Lessons
from beamviz.explorer.state import State
from beamviz.explorer.visitor import Visitor
from beamviz.lessons import lesson
from beamviz.scene import Scene, check_choice, parse_query
from beamviz.server.access import KEY_PARAMETER

PERIOD = 0.5  # [s] between two changes of the address
# Parameters of the same link for others: the key of the server, the switches of viser's page.
RESERVED = {KEY_PARAMETER, "websocket", "fixedDpr", "darkMode", "showStats", "logCamera"}
OWN = ("dark", "playing")  # keys of a scene that are the visitor's own, and in no link


class Link(NamedTuple):
    """What a link leads to: a scene, a lesson ("" for none) with its step, from 0, and with what
    the beam is compared ("" for as before)."""

    scene: Scene
    lesson: str = ""
    step: int = 0
    comparison: str = ""


def parse_link(query: str) -> Link | None:
    """What a query leads to; None where it has no key of ours. Raises InvalidInput."""
    values = {key: value for key, value in parse_query(query).items() if key not in RESERVED}
    if not values:
        return None
    name, compare = str(values.pop("lesson", "")), values.pop("compare", None)
    step = check_int("step", values.pop("step", 1), 1, len(STEPS)) - 1
    choices = {short: choice for choice, short in SHORT.items()}
    comparison = "" if compare is None else choices[check_choice("compare", compare, choices)]
    base = lesson(name).scene if name else Scene()
    return Link(within_limits(Scene.from_query(values, base)), name, step, comparison)


class Links:
    """The address of one visitor's page. start: the state that needs no query."""

    def __init__(self, visitor: Visitor, lessons: Lessons):
        self.visitor, self.lessons = visitor, lessons
        self.start = visitor.state
        self.reserved: list[tuple[str, str]] | None = None  # None until the page has told them
        self.shown: State | None = None
        self.due = 0.0
        self.moved = False  # the viewpoint, since the address was shown
        self.opened = False  # what the address leads to, if anything, is in the state
        visitor.on("link", self.open)

    def open(self, query: Any) -> None:
        """Show the scene of the address, which the page tells as it begins."""
        text = query.lstrip("?") if isinstance(query, str) else ""
        self.reserved = [pair for pair in parse_qsl(text) if pair[0] in RESERVED]
        try:
            link = parse_link(text)
        except InvalidInput as error:
            self.visitor.notify("The link is not valid", str(error))
            link = None
        if link:
            self.visitor.background.submit(partial(self.show, link))
        self.opened = link is None
        self.visitor.wake()

    def show(self, link: Link) -> None:
        """Show what a link leads to."""
        visitor = self.visitor
        if link.lesson:
            self.lessons.begin(link.lesson, link.step, link.scene)
        else:
            visitor.load(link.scene.changed(dark=visitor.state.view.dark))
        if link.comparison:
            visitor.change(partial(replace, comparison=link.comparison))
        self.opened = True

    @property
    def outdated(self) -> bool:
        """Whether the state or the viewpoint is another one than that of the address."""
        return self.reserved is not None and (self.moved or self.visitor.state is not self.shown)

    def update(self, now: float) -> None:
        """Let the address follow, not too often [s]."""
        if self.reserved is None or now < self.due or not self.outdated:
            return
        self.due, self.shown, self.moved = now + PERIOD, self.visitor.state, False
        try:
            query = self.query(self.visitor.state)
        except InvalidInput:  # numbers that are no beam
            return
        pairs = urlencode(self.reserved)
        self.visitor.page.address("&".join(filter(None, (pairs, query))))

    def query(self, state: State) -> str:
        """The query of a link to a state; "" for the one the page begins with, and for that of a
        presenter."""
        scene = replace(state.to_scene(), camera=self.visitor.camera.chosen)
        first = replace(self.start, view=replace(self.start.view, **own(state)))
        same = scene == first.to_scene() and state.comparison == first.comparison
        if state.following or (same and not state.lesson):
            return ""
        pairs = {"lesson": state.lesson, "step": state.step + 1 if state.step else ""}
        pairs["compare"] = SHORT.get(state.comparison, "")
        base = lesson(state.lesson).scene if state.lesson else Scene()
        extra = urlencode({key: value for key, value in pairs.items() if value})
        found = "&".join(filter(None, (extra, scene.to_query(base, without=OWN))))
        return found or f"gamma={scene.beam.gamma!r}"  # the usual scene, where another begins


def own(state: State) -> dict[str, Any]:
    """The values of the view that are in no link."""
    return {name: getattr(state.view, name) for name in OWN}
