"""The explorer as a server, in one process or several: `serve` runs until it is interrupted."""

import contextlib
import gc
import queue
import secrets
import webbrowser
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

from beamviz.drawing import camera
from beamviz.drawing.modes import SampledModes
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.explorer.frames import FrameLoop
from beamviz.explorer.page import choose_theme, insert_page
from beamviz.scene import Scene
from beamviz.server import run_server, self_test
from beamviz.server.access import KEY_PARAMETER, MAX_VISITORS, Access, public_url
from beamviz.server.processes import ProcessPool, VisitorCount, listening_sockets, process_count
from beamviz.server.viser_private import check_attributes
from beamviz.signals import handle_signals
from beamviz.solver import solve

KEY_BYTES = 16

Signals = queue.SimpleQueue[int]  # the signals received


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

    Prints one line with the URL when ready. If other machines can reach the server, the URL has a
    key made for this run.

    public: the URL of a reverse proxy in front of the server; visitors: the maximum at once;
    follow: all visitors see the scene of a presenter, whose link is printed too; processes: the
    number that share the visitors (see `process_count`).

    Raises InvalidInput for a beam that the method cannot solve or a number of processes that is not
    possible, and Unavailable if the address is not available, if viser or websockets lack a
    required attribute, or if the self-test of the protection fails and other machines can reach the
    server.
    """
    with contextlib.suppress(NoEquilibrium, NotConverged):  # the page explains these
        solve(scene.beam, **scene.options)
    public = public_url(public) if public else ""
    shared = Access(host, port, public=public).shared
    key = secrets.token_urlsafe(KEY_BYTES) if shared else ""
    presenter_key = secrets.token_urlsafe(KEY_BYTES) if follow else ""
    access: dict[str, Any] = {"visitor_key": key, "presenter_key": presenter_key, "public": public}
    access |= {"max_visitors": visitors}
    count = min(process_count(processes, shared=shared, follow=follow), visitors)
    gc.freeze()  # modules stay loaded: garbage collection need not examine them again
    signals: Signals = queue.SimpleQueue()  # its put may interrupt its get, unlike that of an Event
    with handle_signals(lambda number, _: signals.put(number)), contextlib.ExitStack() as stack:
        wait: Callable[[], None]
        if count > 1:
            workers = several_processes(scene, host, port, signals, count, **access)
            url, wait = stack.enter_context(workers)
        else:
            url = stack.enter_context(explorer(scene, host, port, **access))
            wait = partial(wait_for_signal, signals)
        note = "whoever has this link can use it; " if key else ""
        print(f"beamviz is at {url} ({note}Ctrl-C ends it)", flush=True)
        link = f"{url.partition('/?')[0]}/?{KEY_PARAMETER}={presenter_key}"
        if follow:
            print(f"the presenter's link, to be kept private: {link}", flush=True)
        if open_browser:
            webbrowser.open(link if follow else url)
        wait()


@contextlib.contextmanager
def several_processes(
    scene: Scene, host: str, port: int, signals: Signals, processes: int, **access: Any
) -> Iterator[tuple[str, Callable[[], None]]]:
    """The explorer in several processes: its URL, and a function that serves until a signal."""
    check_attributes()
    visitor_count = VisitorCount(processes)

    def run(number: int, listener: Any, ready: Callable[[], None]) -> None:
        visitor_count.process = number
        with explorer(scene, host, visitor_count=visitor_count, listener=listener, **access):
            ready()
            wait_for_signal(signals)

    with (
        listening_sockets(host, port) as listeners,
        contextlib.closing(ProcessPool(listeners, visitor_count, run)) as pool,
    ):
        for worker in pool.workers:
            worker.wait()
        url = Access(host, listeners[0].getsockname()[1], **access).url
        yield url, lambda: pool.serve(lambda: not signals.empty())


@contextlib.contextmanager
def explorer(scene: Scene, host: str = "127.0.0.1", port: int = 0, **options: Any) -> Iterator[str]:
    """A running explorer: the URL for visitors, with their key if there is one; options: further
    fields of Access."""
    access = Access(host, port, **options)
    with run_server(access, insert_page) as server:
        access = replace(access, port=server.get_port())
        self_test(server, access)
        choose_theme(server, dark=scene.view.dark)
        rest = SampledModes.at_rest(scene.beam, scene.options["plane"])
        fitted = camera.fitted(rest, scene.view.rotating_frame, aspect=1.0)
        camera.place(server.initial_camera, scene.camera or fitted)
        frame_loop = FrameLoop(server, scene, access)
        try:
            yield access.url
        finally:
            frame_loop.stop()


def wait_for_signal(signals: Signals) -> None:
    """Wait until a signal is received. Python handles one that arrives just before a wait only
    after that wait, hence the timeout."""
    while True:
        with contextlib.suppress(queue.Empty):
            signals.get(timeout=1.0)
            return
