"""The explorer as a server: a session for each visitor, one frame_loop for all of them."""

import contextlib
import gc
import queue
import secrets
import socket
import webbrowser
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from beamviz.drawing import camera
from beamviz.drawing.modes import Shapes
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.explorer.frames import FrameLoop
from beamviz.explorer.jobs import WorkerPool
from beamviz.explorer.page.style import theme
from beamviz.scene import Scene
from beamviz.server import run_server
from beamviz.server.access import (
    KEY_PARAMETER,
    LOOPBACK,
    MAX_VISITORS,
    Access,
    VisitorCount,
    public_url,
)
from beamviz.server.processes import listening_sockets, team, usual
from beamviz.server.viser_private import check_attributes
from beamviz.signals import handle_signals
from beamviz.solver import solve

SOLVERS = 2  # at once, for all visitors together
CHARTERS = 1  # as well, for their charts
KEY_BYTES = 16

Stopped = queue.SimpleQueue[int]  # the signals that have come
Served = Iterator[tuple[str, Callable[[], None]]]  # a URL, and what waits for the end


def serve(
    scene: Scene,
    host: str = "127.0.0.1",
    port: int = 8080,
    open_browser: bool = False,
    public: str = "",
    visitors: int = MAX_VISITORS,
    follow: bool = False,
    processes: int | None = None,
) -> None:
    """Serve the explorer, starting from `scene`, until Ctrl-C or SIGTERM.

    public: the URL under which a reverse proxy passes requests on;
    visitors: how many at once; follow: all see what a presenter does, whose link is printed as
    well; processes: how many share the visitors (see workers.usual). Prints one line with the URL
    when ready; where others than this machine can reach it, a key made for this run is part of
    it. Raises InvalidInput for a model that does not treat such a beam and Unavailable where the
    address cannot be had.
    """
    with contextlib.suppress(NoEquilibrium, NotConverged):  # the page shows these in words
        solve(scene.beam, **scene.options)
    public = public_url(public) if public else ""
    shared = bool(public) or host not in LOOPBACK
    key = secrets.token_urlsafe(KEY_BYTES) if shared else ""
    presenter = secrets.token_urlsafe(KEY_BYTES) if follow else ""
    access = {
        "visitor_key": key,
        "presenter_key": presenter,
        "public": public,
        "max_visitors": visitors,
    }
    count = usual(processes, shared=shared, follow=follow)
    gc.freeze()  # all that is loaded stays: no collection of garbage has to look through it again
    with stopping() as stopped:
        served = alone(scene, host, port, stopped, access)
        if count > 1:
            served = together(scene, host, port, stopped, access, count)
        with served as (url, wait):
            words = "whoever has this link can use it; " if key else ""
            print(f"beamviz is at {url} ({words}Ctrl-C ends it)", flush=True)
            if presenter:
                lead = f"{url.split('?')[0].rstrip('/')}/?{KEY_PARAMETER}={presenter}"
                print(f"the presenter's link, for nobody else: {lead}", flush=True)
            if open_browser:
                webbrowser.open(lead if presenter else url)
            wait()


@contextlib.contextmanager
def alone(scene: Scene, host: str, port: int, stopped: Stopped, access: dict[str, Any]) -> Served:
    """The explorer in this process."""
    with explorer(scene, host, port, **access) as url:
        yield url, partial(until_ended, stopped)


@contextlib.contextmanager
def together(
    scene: Scene,
    host: str,
    port: int,
    stopped: Stopped,
    access: dict[str, Any],
    processes: int,
) -> Served:
    """The explorer in several processes."""
    check_attributes()
    visitor_count = VisitorCount(processes)

    def run(number: int, listener: socket.socket, ready: Callable[[], None]) -> None:
        visitor_count.number = number
        with explorer(scene, host, visitor_count=visitor_count, listener=listener, **access):
            ready()
            until_ended(stopped)

    with listening_sockets(host, port) as lines, team(lines, visitor_count, run) as workers:
        url = Access(host, lines[0].getsockname()[1], **access).url
        yield url, lambda: workers.serve(lambda: not stopped.empty())


@contextlib.contextmanager
def explorer(
    scene: Scene,
    host: str = "127.0.0.1",
    port: int = 0,
    visitor_count: VisitorCount | None = None,
    listener: socket.socket | None = None,
    **access: Any,
) -> Iterator[str]:
    """A running explorer, by its URL, which holds the key if one is needed; visitor_count and
    listener: see run_server; access: keywords of Access."""
    visitor_count = visitor_count or VisitorCount()
    with (
        run_server(host, port, visitor_count=visitor_count, listener=listener, **access) as server,
        WorkerPool(SOLVERS, "solver") as pool,
        WorkerPool(CHARTERS, "charter") as charts,
    ):
        theme(server, dark=scene.view.dark)
        rest = Shapes.at_rest(scene.beam, scene.options["plane"])
        fitted = camera.fitted(rest, scene.view.rotating_frame, aspect=1.0)
        camera.place(server.initial_camera, scene.camera or fitted)
        entrance = Access(host, server.get_port(), **access)
        frame_loop = FrameLoop(server, scene, pool, charts, entrance, visitor_count)
        try:
            yield entrance.url
        finally:
            frame_loop.stop()


@contextlib.contextmanager
def stopping() -> Iterator[Stopped]:
    """Where Ctrl-C and SIGTERM are noted, instead of ending the process where it stands.

    A SimpleQueue, whose put may interrupt its own get; an Event is not made for that.
    """
    stopped: Stopped = queue.SimpleQueue()
    with handle_signals(lambda number, _: stopped.put(number)):
        yield stopped


def until_ended(stopped: Stopped) -> None:
    """Wait until an end is asked for."""
    while not ended(stopped):
        pass


def ended(stopped: Stopped) -> bool:
    """Whether an end was asked for, within a second: a signal just before an endless wait begins
    would only be noted when it ends."""
    try:
        stopped.get(timeout=1.0)
    except queue.Empty:
        return False
    return True
