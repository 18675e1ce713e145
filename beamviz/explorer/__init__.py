"""The explorer as a server, in one or several processes."""

import ctypes
import gc
import secrets
import sys
import time
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from beamviz.drawing.camera import initial, place
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.explorer import links
from beamviz.explorer.feature import first_state, tabs, usual_state
from beamviz.explorer.first_picture import first_picture
from beamviz.explorer.frame_loop import FrameLoop
from beamviz.explorer.page import choose_theme, insert_page
from beamviz.explorer.state import State
from beamviz.lessons.lesson_file import OwnLesson
from beamviz.scene import Scene
from beamviz.server import run_server, self_test
from beamviz.server.access import KEY_PARAMETER, MAX_VISITORS, Access, key_of_file, public_url
from beamviz.server.processes import ProcessPool, VisitorCount, listening_sockets, process_count
from beamviz.server.viser_private import check_attributes
from beamviz.signals import Terminated
from beamviz.solver import solve

KEY_BYTES = 16
M_ARENA_MAX = -8  # parameter of glibc's mallopt
TRIM = 5.0  # [s] between two returns of freed memory
SLEEP = 0.5  # [s] between two checks for a signal


def serve(
    scene: Scene,
    host: str = "127.0.0.1",
    port: int = 8080,
    open_browser: bool = False,
    public: str = "",
    visitors: int = MAX_VISITORS,
    follow: bool = False,
    processes: int | None = None,
    key_file: Path | None = None,
    lesson_file: str | Path | None = None,
) -> None:
    """Serve the explorer, starting from `scene`, until an exception ends it: see
    `terminate_on_signal`.

    Prints one line with the URL when ready, with a key for this run if other machines can reach it.

    public: the URL of a reverse proxy in front of the server; visitors: the maximum at once;
    follow: all visitors see the scene of a presenter, whose link is printed too; processes: the
    number that share the visitors (see `process_count`); key_file: a file with the visitors' key,
    for several servers behind one address, instead of a key for this run; lesson_file: pages open
    within its lesson, and leave it to `scene`.

    Raises InvalidInput for a beam that the method cannot solve, a lesson that is not valid, a
    number of processes that is not possible or an invalid key, and Unavailable if the address is
    not available, if viser or websockets lack a required attribute, or if the self-test fails and
    other machines can reach the server.
    """
    check_scene(scene)
    lesson = OwnLesson.from_toml(lesson_file) if lesson_file else None
    if lesson:
        links.opened_lesson(usual_state(scene, links.PAGE), lesson, str(lesson_file))
    public = public_url(public) if public else ""
    shared = Access(host, port, public=public).shared
    key = secrets.token_urlsafe(KEY_BYTES) if shared else ""
    if key_file:
        key = key_of_file(key_file)
    presenter_key = secrets.token_urlsafe(KEY_BYTES) if follow else ""
    access: dict[str, Any] = {"visitor_key": key, "presenter_key": presenter_key, "public": public}
    access |= {"max_visitors": visitors}
    count = min(process_count(processes, shared=shared, follow=follow), visitors)
    share_arena()
    gc.freeze()  # modules stay loaded: garbage collection need not examine them again
    with ExitStack() as stack:
        if count > 1:
            url, run = stack.enter_context(
                several_processes(scene, lesson, host, port, count, **access)
            )
        else:
            served = explorer(scene, host, port, lesson, **access)
            url, run = stack.enter_context(served), wait_for_signal
        note = "whoever has this link can use it; " if key else ""
        print(f"beamviz is at {url} ({note}Ctrl-C ends it)", flush=True)
        link = f"{url.partition('/?')[0]}/?{KEY_PARAMETER}={presenter_key}"
        if follow:
            print(f"the presenter's link, to be kept private: {link}", flush=True)
        if open_browser:
            webbrowser.open(link if follow else url)
        run()


def share_arena() -> None:
    """Let all threads allocate from one arena of glibc: what one has freed, another takes. In five
    minutes of random use by one visitor the server then takes 160 MB instead of 250."""
    call_glibc("mallopt", M_ARENA_MAX, 1)


def return_memory() -> None:
    """Return freed memory within the arena to the system, which glibc only does at its end: charts
    of a long blade leave a hundred megabytes. It takes 3 to 30 ms."""
    call_glibc("malloc_trim", 0)


def call_glibc(function: str, *arguments: int) -> None:
    """Call a function of glibc; nothing where there is another C library."""
    if sys.platform == "linux":
        with suppress(OSError, AttributeError):
            getattr(ctypes.CDLL(None), function)(*arguments)


def check_scene(scene: Scene) -> None:
    """Raise InvalidInput for a beam that the method cannot solve."""
    with suppress(NoEquilibrium, NotConverged):  # the page explains these
        solve(scene.beam, **scene.options)


@contextmanager
def several_processes(
    scene: Scene, lesson: OwnLesson | None, host: str, port: int, processes: int, **access: Any
) -> Iterator[tuple[str, Callable[[], None]]]:
    """The explorer in several processes: its URL, and a function that serves until a signal."""
    check_attributes()
    visitor_count = VisitorCount(processes)

    def run(number: int, listener: Any, ready: Callable[[], None]) -> None:
        visitor_count.process = number
        of_worker = {"visitor_count": visitor_count, "listener": listener}
        worker = explorer(scene, host, lesson=lesson, **of_worker, **access)
        with suppress(Terminated), worker:
            ready()
            wait_for_signal()

    sockets = listening_sockets(host, port)
    with sockets as listeners, closing(ProcessPool(listeners, visitor_count, run)) as pool:
        for worker in pool.workers:
            worker.wait()
        yield Access(host, listeners[0].getsockname()[1], **access).url, pool.serve


@contextmanager
def explorer(
    scene: Scene,
    host: str = "127.0.0.1",
    port: int = 0,
    lesson: OwnLesson | None = None,
    **options: Any,
) -> Iterator[str]:
    """A running explorer: the URL for visitors, with any key; lesson: in which pages open; options:
    further fields of Access."""
    with run_explorer(scene, Access(host, port, **options), lesson) as (url, _):
        yield url


@contextmanager
def run_explorer(
    scene: Scene, access: Access, lesson: OwnLesson | None = None
) -> Iterator[tuple[str, FrameLoop]]:
    """A running explorer: the URL for visitors, and its frame loop; lesson: in which pages open."""
    begin = partial(links.opened_lesson, lesson=lesson, name="--lesson") if lesson else same
    styles = [kind.style for kind in links.PAGE if kind.style]
    first_picture = opening_picture(scene, access, begin)
    insert = partial(insert_page, tabs=tabs(links.PAGE), styles=styles, first_picture=first_picture)
    with run_server(access, insert) as server:
        access = replace(access, port=server.get_port())
        self_test(server, access)
        choose_theme(server, dark=scene.view.dark)
        place(server.initial_camera, initial(scene))
        frame_loop = FrameLoop(server, scene, access, links.PAGE, begin)
        try:
            yield access.url, frame_loop
        finally:
            frame_loop.stop()


def same(state: State) -> State:
    return state


def opening_picture(scene: Scene, access: Access, begin: Callable[[State], State] = same) -> str:
    """The first picture of pages, of no scene in particular where they may open on another one
    (that of a presenter, or a later one of a notebook) or where a feature or a lesson begins."""
    begins = begin(first_state(scene, links.PAGE)) != usual_state(scene, links.PAGE)
    is_known = not (access.presenter_key or access.framed or begins)
    return first_picture(scene if is_known else None)


def wait_for_signal() -> None:
    """Wait until a signal raises Terminated, and return freed memory meanwhile. Python handles a
    signal that arrives just before a sleep only after that sleep, hence the short time.
    """
    trimmed = time.monotonic()
    while True:
        time.sleep(SLEEP)
        if time.monotonic() > trimmed + TRIM:
            return_memory()
            trimmed = time.monotonic()
