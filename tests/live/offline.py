"""A visitor in the same process, without a connection: their frames, and the threads of their jobs,
run when a test says so.
"""

import json
import pickle
import random
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any, Self

import numpy as np
import pytest
from live.fresh import Guest, turned
from live.server import CAMERA_MESSAGE, MEANWHILE
from live.visitor import Visitor as Socket

from beamviz.drawing.scene_graph import SceneGraph
from beamviz.explorer import (
    computed_loci,
    computed_motion,
    jobs,
    links,
    page,
    session,
    solutions,
    visitor,
)
from beamviz.explorer.feature import first_state
from beamviz.explorer.features import map as map_tab
from beamviz.explorer.features import run_up
from beamviz.explorer.jobs import Callback
from beamviz.explorer.session import Session
from beamviz.explorer.state import State
from beamviz.explorer.visitor import Visitor
from beamviz.scene import Camera as Viewpoint
from beamviz.scene import Scene
from beamviz.server.viser_private import ViserScene

AT_ONCE = 0.6  # the part of the frames in which a job under way is completed
STEPS = (0.01, 0.04, 0.04, 0.3, 1.5)  # [s] from one frame to the next
IN_A_FRAME = 0.6  # the part of the steps of a drag that a frame shows before the next one
POSTPONED = 0.1  # the part of the frames that come late
STEP = 0.04  # [s] from one frame of a `Desk` to the next
PATIENT = 3  # frames that a `Local` visitor waits for without the charts
MOST = 500  # frames until a page is at rest


class Clock:
    """The time [s] of all visitors of this process, which each of their frames advances."""

    time = 1.0

    def monotonic(self) -> float:
        return self.time


CLOCK = Clock()


class Graph(SceneGraph):
    """A scene whose nodes take the handlers of drags; drags: those of each node, by its name."""

    def __init__(self) -> None:
        super().__init__()
        self.drags: dict[str, list[Callable[..., Any]]] = {}

    def add_batched_meshes_simple(self, name: str, *given: Any, **properties: Any) -> Any:
        node = super().add_batched_meshes_simple(name, *given, **properties)
        self.drags[name] = handlers = list[Callable[..., Any]]()
        node.on_drag, node.remove_drag_callback = handlers.append, handlers.remove
        node.on_click = lambda handler: None
        return node


class Camera:
    """The camera of a page, which is where it was placed last."""

    position: Any
    look_at: Any

    def __init__(self) -> None:
        for name in ("position", "look_at", "image_height", "image_width"):
            setattr(self, name, CAMERA_MESSAGE[name])
        self.aspect = CAMERA_MESSAGE["image_width"] / CAMERA_MESSAGE["image_height"]
        self.fov = 0.0

    def __setattr__(self, name: str, value: Any) -> None:
        """Points are arrays, as those of viser's camera."""
        is_point = name in ("position", "look_at")
        super().__setattr__(name, np.array(value, float) if is_point else value)

    def on_update(self, handler: Callable[..., Any]) -> None:
        """A test says itself that the camera was moved."""


class Control:
    """A control of viser, or a command; triggered: the handlers of a command."""

    def __init__(self) -> None:
        self.value, self.triggered = "", list[Callable[..., Any]]()
        self.on_update: Callable[..., Any] = lambda handler: None
        self.on_trigger = self.triggered.append


class Client:
    """What a session uses of a client of viser. scripts: called for what the page is sent;
    downloads: names and contents of files."""

    atomic = staticmethod(nullcontext)

    def __init__(self) -> None:
        self.scene, self.camera, self.scripts = Graph(), Camera(), list[Callable[[], str]]()
        self.commands, self.downloads = dict[str, Control](), dict[str, bytes]()
        self.gui = SimpleNamespace(
            add_text=lambda *given, **options: Control(),
            add_command=lambda name: self.commands.setdefault(name, Control()),
            configure_theme=lambda **options: None,
        )

    def send_file_download(self, name: str, content: bytes, *, save_immediately: bool) -> None:
        """Keep a file that is sent."""
        self.downloads[name] = content

    def flush(self) -> None:
        """All is received at once."""


class Workers:
    """Jobs are run by the test: `submit` keeps them, or runs one at once if `chance` says so."""

    def __init__(self, chance: random.Random | None = None):
        self.chance, self.waiting = chance, list[Callback]()
        self.background = self.solvers = self

    def submit(self, work: Callback) -> None:
        if self.chance and self.chance.random() < AT_ONCE:
            work()
        else:
            self.waiting.append(work)

    def run(self) -> None:
        """Complete what was submitted."""
        works, self.waiting = self.waiting, []
        for work in works:
            work()


class Line:
    """A connection that nothing is sent through."""

    def send(self, message: bytes) -> None:
        """Do nothing."""


def run(steps: Coroutine[Any, Any, None]) -> None:
    """Run a handler of viser, which waits for nothing."""
    with pytest.raises(StopIteration):
        steps.send(None)


class Offline(Socket):
    """A visitor of a session in this process; scene: that which the server begins with."""

    def __init__(self, scene: Scene, workers: Any):
        super().__init__(Line())
        self.workers = workers
        self.client: Any = Client()
        state = first_state(scene, links.PAGE)
        opened = Visitor(self.client, state, workers, schedule=lambda: None)
        self.session = Session(opened, links.PAGE)

    def do(self, action: str, value: Any = None, until: Any = "") -> None:
        """Do an action of the page; its control shows the value."""
        own = self.session.visitor.page
        if action == "tab":
            self.parts["open"] = value
        elif action in self.values:
            self.values[action] = value
        self.actions += 1
        own.bridge.value = json.dumps([self.actions, action, value])
        run(own.received(SimpleNamespace(client_id=0)))

    def drag(
        self,
        node: str,
        *points: tuple[float, float, float],
        between: Callback = lambda: None,
    ) -> None:
        """Drag a node of the scene along points, the first of which takes it. between: called after
        each of them."""
        phases = ["start", *["update"] * (len(points) - 2), "end"]
        for phase, point in zip(phases, points, strict=True):
            event = SimpleNamespace(
                phase=phase,
                end_position=point,
                target=self.client.scene.nodes[node],
                instance_index=0,
            )
            for handler in [*self.client.scene.drags[node]]:
                run(handler(event))
            between()

    def receive(self, timeout: float = 0.0) -> list[dict[str, Any]]:
        """Take what was sent."""
        for script in self.client.scripts:
            self.apply_script(script())
        self.client.scripts.clear()
        self.nodes.clear()
        for name, node in self.client.scene.nodes.items():
            self.nodes[name] = {k: one for k, one in vars(node).items() if not callable(one)}
        view = self.client.camera
        self.camera = (*view.position.tolist(), *view.look_at.tolist())
        return []


class Pools:
    """Jobs that a waiting visitor runs: solves at once, charts once nothing else has helped."""

    def __init__(self) -> None:
        self.solvers, self.background = Workers(), Workers()


class Local(Offline):
    """A visitor in this process who is used as one with a connection: frames are drawn while it
    waits, at a constant rate, each with the answers to what the one before has requested. A chart
    that nothing waits for is not computed."""

    def __init__(self, scene: Scene):
        super().__init__(scene, Pools())
        self.waited = 0  # frames since the last action
        self.parts["bridge"] = "bridge"
        self.commands = {name: name for name in self.client.commands}
        self.beam = scene.beam
        self.wait(lambda _: self.texts["equilibrium"])

    def do(self, action: str, value: Any = None, until: Any = "") -> None:
        """Do an action of the page, and wait as a visitor with a connection does."""
        self.actions += 1
        text = json.dumps([self.actions, action, value])
        self.send(type="GuiUpdateMessage", uuid="bridge", updates={"value": text})
        if action == "tab":
            self.parts["open"] = value
        if until:
            self.wait(until if callable(until) else lambda _: until in self.text)

    def send(self, **message: Any) -> None:
        """Hand a message over to what viser calls for it."""
        kind, self.waited = message["type"], 0
        if kind == "GuiUpdateMessage":
            own = self.session.visitor.page
            own.bridge.value = message["updates"]["value"]
            run(own.received(SimpleNamespace(client_id=0)))
        elif kind == "CommandTriggerMessage":
            for handler in self.client.commands[message["uuid"]].triggered:
                handler(None)
        elif kind == "ViewerCameraMessage" and hasattr(self, "session"):
            view = self.client.camera
            view.position, view.look_at = message["position"], message["look_at"]
            view.image_width, view.image_height = message["image_width"], message["image_height"]
            view.aspect = view.image_width / view.image_height
            run(self.session.camera_moved(None))

    def receive(self, timeout: float = 0.0) -> list[dict[str, Any]]:
        """Draw the next frame, as the frame loop does, and take what was sent."""
        session = self.session
        CLOCK.time += STEP
        self.waited += 1
        self.workers.solvers.run()
        if self.waited > PATIENT:
            self.workers.background.run()
        before = self.client.camera.position
        if session.visitor.outdated or session.is_busy or session.page_moves:
            session.tick(CLOCK.time)
        elif session.is_moving:
            session.move(CLOCK.time)
        super().receive()
        position = self.client.camera.position
        self.camera = (*position.tolist(),)
        if position is not before:
            run(session.camera_moved(None))
        return []


@contextmanager
def local(scene: Scene) -> Iterator[Local]:
    """A visitor of a server that begins with a scene, in this process."""
    with offline():
        guest = Local(scene)
        MEANWHILE.append(guest.receive)
        try:
            yield guest
        finally:
            MEANWHILE.remove(guest.receive)


class OfflineGuest(Guest):
    """A visitor in this process, whose frames come when they are waited for.

    start: the scene of the server.
    """

    def __init__(self, start: Scene, seed: int = 0):
        self.chance = random.Random(seed)
        self.workers = Workers(self.chance)
        self.visitor = Offline(start, self.workers)
        self.session = self.visitor.session
        self.frame()

    @classmethod
    @contextmanager
    def opened(cls, start: Scene) -> Iterator[Self]:
        """A new visitor of a server that begins with a scene."""
        yield cls(start)

    def on_loop(self, function: Callable[[], Any]) -> Any:
        return function()

    def drag(self, node: str, *points: tuple[float, float, float]) -> None:
        """Drag a node of the scene along points, of which frames show some."""
        self.visitor.drag(node, *points, between=self.frame_or_none)

    def frame_or_none(self) -> None:
        if self.chance.random() < IN_A_FRAME:
            self.frame()

    def turn(self, angle: float, zoom: float) -> None:
        """Turn the view about a vertical axis [rad], and change its distance by a factor."""
        camera = self.visitor.client.camera
        camera.position, camera.look_at = turned(self.session.visitor.camera.present, angle, zoom)
        run(self.session.camera_moved(None))

    def resize(self, width: int, height: int) -> None:
        """Give the scene another size, which a browser tells as it does a turn."""
        camera, self.size = self.visitor.client.camera, (width, height)
        camera.image_width, camera.image_height, camera.aspect = width, height, width / height
        run(self.session.camera_moved(None))

    def is_drawn(self) -> bool:
        """Whether a frame has shown all that has changed."""
        return not self.session.visitor.outdated

    def wait(self, condition: Callable[[], bool]) -> None:
        """Draw frames until a condition holds."""
        for _ in range(MOST):
            self.visitor.receive()
            if condition():
                return
            self.frame()
        raise TimeoutError(f"{condition} after {MOST} frames")

    def frame(self) -> None:
        """Draw a frame, as the frame loop does, after some of the jobs under way."""
        chance, own = self.chance, self.session
        CLOCK.time += chance.choice(STEPS)
        now = CLOCK.time
        if chance.random() < AT_ONCE:
            self.workers.run()
        is_full = own.visitor.outdated or own.is_busy or own.page_moves
        if not (is_full or own.is_moving):
            return
        before = self.visitor.camera
        if is_full:
            own.tick(now, postpones=chance.random() < POSTPONED)
        else:
            own.move(now)
        self.visitor.receive()
        if self.visitor.camera != before:  # as the browser tells
            run(own.camera_moved(None))

    def settle(self) -> None:
        """Wait until the page is at rest."""
        self.wait(self.is_at_rest)


class Desk:
    """A page whose frames come when the test says so, one after the other, and which reports its
    camera then too: viser's is where the page was placed or reported last."""

    def __init__(self, scene: Scene):
        self.guest = OfflineGuest(scene)
        self.guest.visitor.do("tab", "export")
        self.guest.visitor.do("link", "")
        self.guest.settle()
        self.session, self.visitor = self.guest.session, self.guest.session.visitor

    @property
    def state(self) -> State:
        return self.visitor.state

    @property
    def camera(self) -> Viewpoint:
        """Where the page is, or is on its way to."""
        return self.visitor.camera.present

    @property
    def address(self) -> str:
        self.guest.visitor.receive()
        return self.guest.visitor.parts["address"]

    def do(self, action: str, value: Any = None) -> None:
        self.guest.visitor.do(action, value)

    def edit(self, name: str, value: Any) -> None:
        """Another value, whose answer comes in the frame after the next."""
        self.do(name, value)
        self.frame(2)

    def report(self, camera: Viewpoint) -> None:
        """The page tells its camera."""
        view = self.visitor.client.camera
        view.position, view.look_at = camera.position, camera.look_at
        run(self.session.camera_moved(None))

    def turn(self, angle: float = 0.5) -> Viewpoint:
        """The visitor turns the view."""
        camera = Viewpoint(*turned(self.camera, angle, 1.1))
        self.report(camera)
        return camera

    def frame(self, count: int = 1) -> None:
        """The next frames, which take a snapshot."""
        for _ in range(count):
            CLOCK.time += STEP
            self.guest.workers.run()
            self.session.tick(CLOCK.time)

    def moment(self) -> None:
        """A frame that shows another moment of the last snapshot."""
        CLOCK.time += STEP
        self.session.move(CLOCK.time)


def lecture(presenter: Desk, follower: Desk) -> Callable[..., None]:
    """Let one page follow another; returns a function that draws the next frames of both."""
    follower.visitor.presenter = lambda: presenter.session.snapshot
    follower.visitor.update(lambda state: replace(state, following=True))

    def both(count: int = 1) -> None:
        for _ in range(count):
            presenter.frame()
            follower.frame()

    return both


@contextmanager
def offline() -> Iterator[None]:
    """Context in which sessions may be without a connection, and the time is that of the test. What
    charts and motions are made of is computed once for all of them."""

    run_script, private_control, scene_of = page.run_script, page.private_control, ViserScene

    def send(client: Any, source: Callable[[], str]) -> None:
        if isinstance(client, Client):
            client.scripts.append(source)
        else:
            run_script(client, source)

    def private(control: Any) -> str:
        return "bridge" if isinstance(control, Control) else private_control(control)

    def scene(made: Any) -> Any:
        return made if isinstance(made, Graph) else scene_of(made)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(page, "run_script", send)
        patch.setattr(page, "private_control", private)
        patch.setattr(session, "ViserScene", scene)
        patch.setattr(solutions, "QUICK", 0.0)  # `Workers` say when a solve is done
        patch.setattr(jobs, "time", CLOCK)
        patch.setattr(visitor, "time", CLOCK)
        for module, name in COMPUTED:
            patch.setattr(module, name, partial(once, getattr(module, name)))
        yield


COMPUTED = (
    *((computed_loci, "loci"), (computed_motion, "motion")),
    *((map_tab, "solve_in_memory"), (run_up, "run_up")),
)
RESULTS: dict[tuple[Any, bytes], Any] = {}  # by function and arguments


def once(compute: Callable[..., Any], *given: Any, **options: Any) -> Any:
    """The result of a function, computed once for the same arguments."""
    try:
        key = compute, pickle.dumps((given, options))
    except (TypeError, AttributeError, pickle.PicklingError):  # there are functions among them
        return compute(*given, **options)
    if key not in RESULTS:
        RESULTS[key] = compute(*given, **options)
    return RESULTS[key]
