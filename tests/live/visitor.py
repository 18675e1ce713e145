"""A visitor without a browser: a client of viser's protocol, for tests and timings."""

import contextlib
import json
import re
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from html import unescape
from typing import Any

import msgspec.msgpack
import numpy as np
import zstandard
from live.server import CAMERA_MESSAGE, ROOT, TIMEOUT, encoded, raw_socket
from websockets.sync.connection import Connection

from beamviz.beam import NUMBERS, Beam
from beamviz.drawing.text import five_digits, frequencies
from beamviz.solver import solve

PAGE = ROOT / "beamviz" / "explorer" / "page" / "page.html"
BEAM = "/scene/rotor/beam"
ALIGNMENT = 8  # [bytes] of arrays in a group of messages
PERIOD = 0.2  # [s] after which a condition is looked at again without a message
PAPER = Beam(alpha=1, beta=0.5, gamma=10)  # where visitors start
Condition = Callable[[list[dict[str, Any]]], Any]  # of the latest messages
Until = str | Condition


class Visitor:
    """The state that a browser would show.

    texts: HTML by element id; values, props: of controls, by key; charts: data by element id; said:
    messages, the latest last; parts: other parts of updates, as last sent; nodes: of the scene;
    owner: of its nodes, for viser;
    controls: ids of viser's controls by label; updated: their values by id; commands: ids by name;
    beam, options: of the last answer that was waited for, the keywords those of `solve`.
    """

    def __init__(self, socket: Connection):
        self.socket = socket
        self.beam, self.options = PAPER, dict[str, Any]()
        self.controls, self.commands = dict[str, str](), dict[str, str]()
        self.texts = {"page": PAGE.read_text()}
        self.updated, self.values, self.parts = (dict[str, Any]() for _ in range(3))
        properties = (defaultdict[str, dict[str, Any]](dict) for _ in range(3))
        self.props, self.charts, self.nodes = properties
        self.said: list[dict[str, Any]] = []
        self.actions = self.received = 0
        self.owner = ""
        self.camera: tuple[float, ...] = ()  # the position last sent
        self.send(**CAMERA_MESSAGE)

    def send(self, **message: Any) -> None:
        """Send one message."""
        self.socket.send(encoded(**message))

    def do(self, action: str, value: Any = None, until: Until = "") -> None:
        """Send an action, as the page does, and wait for words on the page, or a condition."""
        self.wait(lambda _: "bridge" in self.parts)
        self.actions += 1
        text = json.dumps([self.actions, action, value])
        self.send(type="GuiUpdateMessage", uuid=self.parts["bridge"], updates={"value": text})
        if action == "tab":
            self.parts["open"] = value  # as the page opens it
        if until:
            self.wait(until if callable(until) else lambda _: until in self.text)

    def choose(self, key: str, value: Any, until: Until = "") -> None:
        """Set the controls with a key, as soon as they exist, and wait as `do`."""
        self.wait(lambda _: key in self.values)
        self.do(key, value, until)

    def set(self, **values: Any) -> None:
        """Set several controls."""
        for key, value in values.items():
            self.choose(key, value)

    def edit(self, **edits: Any) -> None:
        """Set numbers of the beam and parts of the model, and wait for the answer."""
        self.set(**edits)
        numbers = {name: edits.pop(name) for name in NUMBERS if name in edits}
        self.shows(self.beam.replace(**numbers), **self.options | edits)

    def shows(self, beam: Beam, **options: Any) -> None:
        """Wait until the table of modes has the first frequency of a beam."""
        self.beam, self.options = beam, options
        found = frequency_text(beam, **options)
        self.wait(lambda _: found in self.texts["mode-rows"])

    def drag(self, node: str, *points: tuple[float, float, float]) -> None:
        """Drag a node of the scene along points, the first of which takes it."""
        phases = ["start", *["update"] * (len(points) - 2), "end"]
        for phase, point in zip(phases, points, strict=True):
            self.send(
                type="SceneNodeDragMessage",
                phase=phase,
                name=node,
                instance_index=0,
                start_position=points[0],
                start_screen_pos=(0.5, 0.5),
                end_position=point,
                end_screen_pos=(0.5, 0.5),
                button="left",
                modifier=None,
                owner=self.owner,
            )

    def press(self, key: str) -> None:
        """Press a key of the page, or run a command by its name."""
        tag = re.search(rf'<[^>]*data-key="{key.lower()}"[^>]*>', self.text)
        if tag is None:
            self.send(type="CommandTriggerMessage", uuid=self.commands[key])
            return
        values = dict(re.findall(r'(data-\w+)="([^"]*)"', tag[0]))
        value = json.loads(unescape(values.get("data-value", "null")))
        if name := values.get("data-set"):
            value = not self.values[name] if value is None else value
        self.do(name or values["data-do"], value)

    def wait(self, done: Condition, timeout: float = TIMEOUT) -> Any:
        """Receive messages until `done` of the latest ones, if any, is true; its value. It is not
        true yet if it reads a part of the page that has not arrived."""
        end = time.monotonic() + timeout
        latest: list[dict[str, Any]] = []
        while True:
            with contextlib.suppress(KeyError):
                if value := done(latest):
                    return value
            if time.monotonic() > end:
                raise TimeoutError("the explorer did not answer in time")
            latest = []
            with contextlib.suppress(TimeoutError):
                latest = self.receive(PERIOD)

    def receive(self, timeout: float) -> list[dict[str, Any]]:
        """The next group of messages, applied to the state; TimeoutError if none comes."""
        data = self.socket.recv(timeout=timeout)
        assert isinstance(data, bytes)
        self.received += len(data)
        size = int.from_bytes(data[8:16], "little")
        packed = zstandard.ZstdDecompressor().decompress(data[16 : 16 + size])
        group = msgspec.msgpack.decode(packed)
        arrays, at = list[bytes](), 16 + size
        for length in group["binaryBufferLengths"]:
            at += -at % ALIGNMENT
            arrays.append(data[at : at + length])
            at += length
        messages = group["messages"]
        for message in messages:
            self.apply(with_arrays(message, arrays))
        return messages

    def apply(self, message: dict[str, Any]) -> None:
        """Update the state by one message."""
        kind, props = message["type"], message.get("props", {})
        self.owner = message.get("owner") or self.owner
        if kind == "SceneNodeUpdateMessage":
            self.nodes[message["name"]].update(message["updates"])
        elif kind == "SetSceneNodeVisibilityMessage":
            self.nodes[message["name"]]["visible"] = message["visible"]
        elif kind in ("SetPositionMessage", "SetOrientationMessage"):
            pose = {key: message[key] for key in ("position", "wxyz") if key in message}
            self.nodes[message["name"]].update(pose)
        elif kind == "RunJavascriptMessage":
            self.apply_script(message["source"])
        elif kind == "GuiUpdateMessage":
            self.updated[message["uuid"]] = message["updates"].get("value")
        elif kind == "SetCameraPositionMessage":
            self.camera = tuple(message["position"])
        elif kind == "RegisterCommandMessage":
            self.commands[props["hotkey"] or props["label"]] = message["uuid"]
        elif kind.startswith("Gui") and "label" in props:
            self.controls[props["label"]] = message["uuid"]
        elif "name" in message and props:
            self.nodes[message["name"]].update(props)

    def apply_script(self, source: str) -> None:
        """Apply what beamviz.apply would show."""
        update = json.loads(source.removeprefix("beamviz.apply(").removesuffix(")"))
        self.texts |= update.pop("html", {})
        self.values |= update.pop("values", {})
        for id, data in update.pop("charts", {}).items():
            self.charts[id].update(data)
        for key, changes in update.pop("props", {}).items():
            self.props[key].update(changes)
        self.said += update.pop("say", [])
        self.parts |= update

    @property
    def text(self) -> str:
        """All texts of the page."""
        return " ".join(self.texts.values())

    def says(self, words: str) -> bool:
        """Wait until `words` are on the page."""
        return self.wait(lambda _: words in self.text)

    def forgets(self, words: str) -> None:
        """Wait until `words` are no longer on the page."""
        self.wait(lambda _: words not in self.text)


def with_arrays(content: Any, arrays: list[bytes]) -> Any:
    """A message with the numbers of its arrays, which are sent behind all messages."""
    if isinstance(content, dict) and "__binary_index" in content:
        return np.frombuffer(arrays[content["__binary_index"]], content["dtype"]).tolist()
    if isinstance(content, dict):
        return {key: with_arrays(one, arrays) for key, one in content.items()}
    return content


def beam_moved(messages: list[dict[str, Any]]) -> bool:
    """Whether a group of messages moves the beam."""
    moved = [message.get("name", "") for message in messages if "updates" in message]
    return any(name.startswith(BEAM) for name in moved)


def catch_up(guest: Visitor) -> None:
    """Send an invalid value, and wait until the server has corrected it: by then it has handled all
    earlier actions, and all that its frames have shown has arrived. A visitor who follows a
    presenter ends that by it."""
    guest.wait(lambda _: guest.values.pop("film_length", None))
    guest.do("film_length", "no", until=lambda _: "film_length" in guest.values)


def pause(guest: Visitor) -> None:
    """Stop the animation and receive the messages that were already sent."""
    guest.choose("playing", False)
    catch_up(guest)


@contextlib.contextmanager
def visitor(url: str, **options: Any) -> Iterator[Visitor]:
    """A connected visitor with the first answer: its table of modes, and its scene."""
    base, mark, query = url.partition("/?")
    with raw_socket(base, mark + query, **options) as socket:
        guest = Visitor(socket)
        guest.wait(lambda _: guest.texts["equilibrium"] and BEAM in guest.nodes)
        yield guest


def frequency_text(beam: Beam, mode: int = 0, **options: Any) -> str:
    """A frequency in the five digits of the table of modes, in hertz for a beam with units."""
    solution, factor = solve(beam, **options), frequencies(beam.units).factor
    return five_digits(factor * solution.frequencies[mode], factor * solution.errors[mode])
