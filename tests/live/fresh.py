"""What a visitor sees, in a form to compare: after any edits it must equal what one sees whose page
is opened fresh on the resulting address."""

import asyncio
import itertools
import json
import math
import re
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from functools import partial
from typing import Any, TypeVar
from urllib.parse import parse_qsl

import numpy as np
from live.server import CAMERA_MESSAGE, TIMEOUT, wait_until
from live.visitor import Visitor, visitor

from beamviz.explorer.feature import tabs
from beamviz.explorer.frame_loop import FrameLoop
from beamviz.explorer.links import PAGE
from beamviz.explorer.session import Session
from beamviz.explorer.state import State
from beamviz.scene import Camera, Scene

T = TypeVar("T")
Place = tuple[float, ...]
# Parts of the page that only one tab shows, by the beginnings of their ids.
INSIDE = {
    "loci-": "frequencies",
    "per-rev": "frequencies",
    "map-": "map",
    "veering-": "veering",
    "comparison": "compare",
    "loads-": "loads",
    "run-up-": "run-up",
    "motion-": "motion",
    "motion.": "motion",
    "moment": "motion",
    "experiment": "motion",
    "method": "methods",
    "timing": "methods",
    "adjust-": "adjust",
    "export-": "export",
}
HISTORY = "undo", "redo"  # keys of the buttons
PARTS = ("open", "captions", "met", "dark")  # of an update, besides those by id
INVITATION = "how does it vibrate"  # in the caption of the scene that a page opened with
LONG = 60.0  # [s] for what is computed on a machine however busy


class Guest:
    """A visitor together with their session, which tells when the page is at rest. size: width and
    height of the scene [px]."""

    size: tuple[int, int] = (CAMERA_MESSAGE["image_width"], CAMERA_MESSAGE["image_height"])

    def __init__(self, socket: Visitor, loop: FrameLoop):
        self.visitor, self.loop, self.tokens = socket, loop, itertools.count()
        self.id = max(loop.sessions)  # the last one
        self.session: Session = loop.sessions[self.id]

    @property
    def state(self) -> State:
        """The choices of the visitor."""
        return self.session.visitor.state

    def on_loop(self, function: Callable[[], T]) -> T:
        """The value of a function on the event loop, between two frames."""

        async def value() -> T:
            return function()

        return asyncio.run_coroutine_threadsafe(value(), self.loop.loop).result(TIMEOUT)

    def is_drawn(self) -> bool:
        """Whether a frame has shown all that has changed."""
        return not self.session.visitor.outdated

    def is_handled(self) -> bool:
        """Whether the server has handled all actions, and a frame has shown them."""
        text = self.session.visitor.page.bridge.value
        last = json.loads(text)[0] if text else 0
        return last == self.visitor.actions and self.is_drawn()

    def is_let_go(self) -> bool:
        """Whether all actions are handled, and neither a body nor the beam is in the hand."""
        return self.is_handled() and not self.state.in_hand

    def is_solved(self) -> bool:
        """Whether a frame has shown the modes of the beam as well."""
        solver, snapshot = self.session.visitor.solver, self.session.snapshot
        is_shown = solver.answer is snapshot.jobs[solver.name].answer
        return self.is_handled() and is_shown and not solver.busy

    def is_at_rest(self) -> bool:
        """Whether nothing is computed, moves or is in the hand, and the last frame shows all
        answers."""
        session = self.session
        answers = {key: job.answer for key, job in session.visitor.jobs.items()}
        seen = {key: status.answer for key, status in session.snapshot.jobs.items()}
        busy = session.is_busy or session.is_moving
        return self.is_let_go() and not busy and answers == seen

    def wait(self, condition: Callable[[], bool]) -> None:
        """Wait until a condition holds between two frames."""
        wait_until(lambda: self.on_loop(condition), LONG, f": {condition}")

    def settle(self) -> None:
        """Wait until the page is at rest, and receive all that was sent to it. It is drawn once
        more, as where a browser tells that its camera has been moved."""
        self.wait(self.is_at_rest)
        self.on_loop(self.session.visitor.wake)
        self.wait(self.is_at_rest)
        token = f"{id(self)} {next(self.tokens)}"
        self.on_loop(lambda: self.session.visitor.page.say(token))
        self.visitor.wait(lambda _: any(one["text"] == token for one in self.visitor.said))

    def drag(self, node: str, *points: tuple[float, float, float]) -> None:
        """Drag a node of the scene along points, the first of which takes it."""
        self.visitor.drag(node, *points)
        self.visitor.do("met", "")  # handled after the drag, and changes nothing

    def turn(self, angle: float, zoom: float) -> None:
        """Turn the view about a vertical axis [rad], and change its distance by a factor."""
        self.visitor.do("met", "")  # no view that was sent before comes after it
        position, look_at = turned(self.session.visitor.camera.present, angle, zoom)
        self.visitor.send(**CAMERA_MESSAGE | {"position": position, "look_at": look_at})
        self.visitor.camera = position
        self.visitor.do("met", "")  # handled after it, and changes nothing

    def resize(self, width: int, height: int) -> None:
        """Give the scene another size."""
        raise NotImplementedError

    def play(self, count: int) -> None:
        """Wait for some frames, if anything moves."""
        for _ in range(count):
            self.wait(partial(self.has_moved, self.session.last_tick))

    def has_moved(self, last_tick: float) -> bool:
        """Whether there has been a frame after the one of a time [s], or nothing moves."""
        return self.session.last_tick != last_tick or not self.session.is_moving

    def take_clock(self, other: "Guest") -> None:
        """Take the moment of another visitor, which no address has; a motion in time keeps its
        own."""
        mine, theirs = self.session.visitor, other.session.visitor.clock
        names = ("angle", "phases", "other_phases", "compared", "grown")
        found = {name: getattr(theirs, name) for name in names}

        def take() -> None:
            mine.clock = replace(mine.clock, **found)
            mine.wake()

        self.on_loop(take)


def turned(camera: Camera, angle: float, zoom: float) -> tuple[Place, Place]:
    """Position and target of a camera turned about a vertical axis [rad] through its target, at
    its distance times a factor; with the digits that an address has."""
    x, y, z = zoom * np.subtract(camera.position, camera.look_at)
    cosine, sine = math.cos(angle), math.sin(angle)
    away = np.array([cosine * x - sine * y, sine * x + cosine * y, z])
    position, look_at = np.round([camera.look_at + away, camera.look_at], 4).tolist()
    return tuple(position), tuple(look_at)


Opening = Callable[[], AbstractContextManager[Guest]]


@contextmanager
def opened(url: str, loop: FrameLoop) -> Iterator[Guest]:
    """A new visitor of a server, by its address and its frame loop."""
    with visitor(url) as fresh:
        yield Guest(fresh, loop)


def compare_with_fresh(guest: Guest, opening: Opening, start: Scene) -> list[str]:
    """Where the page of a visitor differs from one that is opened on its address. opening: opens a
    page of a server that begins with another scene; start: the scene that an empty address means to
    the visitor."""
    guest.wait(guest.is_let_go)
    told = guest.state
    if told.refused or told.replaced:  # which no address has, and any edit ends
        guest.visitor.do("forget_refused")
    if told.view.playing:
        guest.visitor.do("playing", False)
    guest.settle()
    seen, scene = page_of(guest.visitor), scene_of(guest.visitor)
    address = guest.visitor.parts["address"] or start.to_query(without=("dark", "playing"))
    with opening() as other:
        fresh = other.visitor
        if other.size != guest.size:
            other.resize(*guest.size)
        fresh.do("preferences", "still dark" if guest.visitor.parts["dark"] else "still")
        fresh.do("met", " ".join(guest.visitor.parts["met"]))
        fresh.do("link", f"?{address}")
        other.settle()
        other.take_clock(guest)
        other.settle()
        expected, drawn = page_of(fresh), scene_of(fresh)
    if not guest.visitor.parts["address"]:
        expected["address"] = seen["address"]
    if any(INVITATION in one["text scene-caption"] for one in (seen, expected)):
        expected["text scene-caption"] = seen["text scene-caption"]
    seen, expected = seen | history_shown(guest), expected | history_of(guest)
    found = [*differences(seen, expected, "page"), *differences(scene, drawn, "scene")]
    return found and [address, *found]


def history_shown(guest: Guest) -> dict[str, Any]:
    """Whether a visitor cannot undo or redo, as the page shows it."""
    return {f"props {key}.disabled": guest.visitor.props[key]["disabled"] for key in HISTORY}


def history_of(guest: Guest) -> dict[str, Any]:
    """Whether there is nothing to undo or to redo, which no address has."""
    history = guest.session.visitor.history
    steps = zip(HISTORY, (history.past, history.future), strict=True)
    return {f"props {key}.disabled": not past for key, past in steps}


def is_shown(id: str, tab: str) -> bool:
    """Whether an element is outside of the tabs, or in the open one."""
    return next((one == tab for start, one in INSIDE.items() if id.startswith(start)), True)


def page_of(guest: Visitor) -> dict[str, Any]:
    """What a visitor sees of the page: of parts that are on it, in the open tab or outside."""
    tab = guest.parts["open"]
    shown = [text for key, text in guest.texts.items() if is_shown(key, tab)]
    there = {*re.findall(r'(?:id|data-set)="([^"]+)"', "".join([*shown, tabs(PAGE)[tab].content]))}
    there |= {f"tab-{tab}"}
    props = {
        f"{key}.{name}": one
        for key, changes in guest.props.items()
        for name, one in changes.items()
        if key in there and key not in HISTORY
    }
    parts: dict[str, dict[str, Any]] = {
        "text": {key: re.sub(TIME, "", text) for key, text in guest.texts.items()},
        "value": {key: one for key, one in guest.values.items() if key != "following"},
        "chart": {
            key: untimed(one) if key == "timing-chart" else one
            for key, one in guest.charts.items()
            if not guest.props[key].get("hidden")
        },
        "props": props,
    }
    seen = {
        f"{kind} {key}": one
        for kind, content in parts.items()
        for key, one in content.items()
        if is_shown(key, tab) and (kind == "props" or key in there)
    }
    address = {key: numbers(one) for key, one in parse_qsl(guest.parts["address"])}
    return seen | {"address": address, **{key: guest.parts[key] for key in PARTS}}


TIME = r"[\d.]+(?:e[-+]\d+)? ms"  # of a solve, which differs each time


def untimed(chart: dict[str, Any]) -> dict[str, Any]:
    """The chart of methods without times: the errors of each."""
    lines = [{key: one for key, one in line.items() if key != "at"} for line in chart["lines"]]
    marks = [{"key": one["key"], "y": one["y"]} for one in chart["marks"]]
    return {"lines": lines, "marks": marks, "y": chart["y"]}


def numbers(text: str) -> float | str:
    """A number, with what rounding leaves of it in SI units and back, or another text."""
    try:
        return float(text)
    except ValueError:
        return text


def scene_of(guest: Visitor) -> dict[str, Any]:
    """The visible nodes of the scene with their properties and places; of the points of captions
    those that have a text; and the place of the camera."""
    return {"camera": list(guest.camera)} | visible_nodes(guest)


def visible_nodes(guest: Visitor) -> dict[str, Any]:
    """The visible nodes of the scene with their properties and places."""
    texts = {caption["name"] for caption in guest.parts["captions"]}
    hidden = {name for name, node in guest.nodes.items() if node.get("visible") is False}
    nodes: dict[str, Any] = {}
    for name, node in guest.nodes.items():
        parents = [name[:k] for k, sign in enumerate(name) if sign == "/" and k] + [name]
        is_caption = re.search(
            r"/(node \d+|body \d+|warning|title|speed|tension text|hint \w+)$", name
        )
        if not hidden & {*parents} and (name in texts or not is_caption):
            at_origin = {"position": (0.0, 0.0, 0.0), "wxyz": (1.0, 0.0, 0.0, 0.0)}
            nodes[name] = at_origin | {key: one for key, one in node.items() if key != "visible"}
    return nodes


def is_records(content: Any) -> bool:
    """Whether it is a list of objects."""
    return isinstance(content, list) and all(isinstance(one, dict) for one in content)


def differences(first: Any, second: Any, path: str = "") -> Iterator[str]:
    """Where two contents differ, numbers by more than rounding."""
    if isinstance(first, dict) and isinstance(second, dict):
        for key in first.keys() | second.keys():
            yield from differences(first.get(key), second.get(key), f"{path}/{key}")
    elif is_records(first) and is_records(second) and len(first) == len(second):
        for k, pair in enumerate(zip(first, second, strict=True)):
            yield from differences(*pair, f"{path}/{k}")
    elif isinstance(first, np.ndarray) and isinstance(second, np.ndarray):
        if first.shape != second.shape or not np.allclose(first, second, 1e-5, 1e-6, True):
            yield f"{path}: {str(first)[:200]} != {str(second)[:200]}"
    elif isinstance(first, SEVERAL) and isinstance(second, int | SEVERAL):
        try:
            close = np.allclose(
                np.array(first, float), np.array(second, float), 1e-5, 1e-6, equal_nan=True
            )
        except (ValueError, TypeError):  # not numbers, or not as many
            close = list(first) == list(second)
        if not close:
            yield f"{path}: {str(first)[:200]} != {str(second)[:200]}"
    elif isinstance(first, str) and isinstance(second, str):
        texts, others = (re.split(NUMBER, re.sub(ERROR, "", one)) for one in (first, second))
        if len(texts) != len(others) or texts[::2] != others[::2]:
            yield f"{path}: {changed_part(first, second)}"
        else:
            pairs = zip(texts[1::2], others[1::2], strict=True)
            if any(abs(float(a) - float(b)) > 1.01 * last_digit(a) for a, b in pairs):
                yield f"{path}: {changed_part(first, second)}"
    elif first != second:
        yield f"{path}: {str(first)[:300]} != {str(second)[:300]}"


SEVERAL = float | list | tuple | np.ndarray
NUMBER = r"(\d+\.?\d*(?:e[-+]?\d+)?)"
ERROR = r"± [\d.e-]+"  # estimated, of the size of rounding


def last_digit(text: str) -> float:
    """One unit of the last digit of a number, at most the sixth: what rounding changes of a tie."""
    mantissa, _, exponent = text.partition("e")
    unit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    return max(unit, 1e-6 * abs(float(text)))


def changed_part(first: str, second: str) -> str:
    """Two texts from a little before the first character that differs."""
    same = itertools.takewhile(lambda pair: pair[0] == pair[1], zip(first, second, strict=False))
    start = max(len([*same]) - 60, 0)
    return f"…{first[start : start + 300]} != …{second[start : start + 300]}"
