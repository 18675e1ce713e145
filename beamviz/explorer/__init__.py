"""The explorer as a server, in one or several processes, and the frame loop, which draws its pages.

With many visitors the frame loop also runs their solves in batches. It is on the event loop:
threads that compete with it for the interpreter lock would take more time than the work itself.
"""

import asyncio
import gc
import os
import secrets
import time
import webbrowser
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import replace
from functools import partial
from typing import Any

from viser import ClientHandle, ViserServer

from beamviz.drawing import camera
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.explorer.features.lessons import draw_sketches
from beamviz.explorer.jobs import PATIENCE, Workers
from beamviz.explorer.page import choose_theme, insert_page
from beamviz.explorer.session import Session
from beamviz.explorer.state import State
from beamviz.explorer.visitor import Visitor
from beamviz.scene import Scene
from beamviz.server import run_server, self_test
from beamviz.server.access import KEY_PARAMETER, MAX_VISITORS, Access, public_url
from beamviz.server.log import RateLimitedLog
from beamviz.server.processes import ProcessPool, VisitorCount, listening_sockets, process_count
from beamviz.server.viser_private import OwnLoop, check_attributes, disconnect, handshake_request
from beamviz.signals import Terminated, terminate_on_signal
from beamviz.solver import solve

KEY_BYTES = 16
FRAMES = 25  # frames per second of one visitor
ALL_FRAMES = 800  # frames per second of all visitors of all processes together
FEWER_FRAMES = 12.8  # frames per second of one visitor while solves are waiting
CROWD = 8  # visitors from which on solves run in batches, and charts wait
BATCH = 4  # solves or frames between two exchanges of messages
LOOP_TURNS = 4  # iterations of the event loop in which a message is received or sent
SLEEP = 0.5  # [s] between two checks for a signal
STOP_TIMEOUT = 5.0  # [s] for the last frame

log = RateLimitedLog(__name__)


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

    Prints one line with the URL when ready, with a key for this run if other machines can reach it.

    public: the URL of a reverse proxy in front of the server; visitors: the maximum at once;
    follow: all visitors see the scene of a presenter, whose link is printed too; processes: the
    number that share the visitors (see `process_count`).

    Raises InvalidInput for a beam that the method cannot solve or a number of processes that is not
    possible, and Unavailable if the address is not available, if viser or websockets lack a
    required attribute, or if the self-test fails and other machines can reach the server.
    """
    with suppress(NoEquilibrium, NotConverged):  # the page explains these
        solve(scene.beam, **scene.options)
    public = public_url(public) if public else ""
    shared = Access(host, port, public=public).shared
    key = secrets.token_urlsafe(KEY_BYTES) if shared else ""
    presenter_key = secrets.token_urlsafe(KEY_BYTES) if follow else ""
    access: dict[str, Any] = {"visitor_key": key, "presenter_key": presenter_key, "public": public}
    access |= {"max_visitors": visitors}
    count = min(process_count(processes, shared=shared, follow=follow), visitors)
    gc.freeze()  # modules stay loaded: garbage collection need not examine them again
    with suppress(Terminated), terminate_on_signal(), ExitStack() as stack:
        if count > 1:
            url, run = stack.enter_context(several_processes(scene, host, port, count, **access))
        else:
            url, run = stack.enter_context(explorer(scene, host, port, **access)), wait_for_signal
        note = "whoever has this link can use it; " if key else ""
        print(f"beamviz is at {url} ({note}Ctrl-C ends it)", flush=True)
        link = f"{url.partition('/?')[0]}/?{KEY_PARAMETER}={presenter_key}"
        if follow:
            print(f"the presenter's link, to be kept private: {link}", flush=True)
        if open_browser:
            webbrowser.open(link if follow else url)
        run()


@contextmanager
def several_processes(
    scene: Scene, host: str, port: int, processes: int, **access: Any
) -> Iterator[tuple[str, Callable[[], None]]]:
    """The explorer in several processes: its URL, and a function that serves until a signal."""
    check_attributes()
    visitor_count, main_process = VisitorCount(processes), os.getpid()

    def run(number: int, listener: Any, ready: Callable[[], None]) -> None:
        visitor_count.process = number
        worker = explorer(scene, host, visitor_count=visitor_count, listener=listener, **access)
        with suppress(Terminated), worker:
            ready()
            wait_for_signal(main_process)

    sockets = listening_sockets(host, port)
    with sockets as listeners, closing(ProcessPool(listeners, visitor_count, run)) as pool:
        for worker in pool.workers:
            worker.wait()
        yield Access(host, listeners[0].getsockname()[1], **access).url, pool.serve


@contextmanager
def explorer(scene: Scene, host: str = "127.0.0.1", port: int = 0, **options: Any) -> Iterator[str]:
    """A running explorer: the URL for visitors, with any key; options: further fields of Access."""
    access = Access(host, port, **options)
    with run_server(access, insert_page) as server:
        access = replace(access, port=server.get_port())
        self_test(server, access)
        choose_theme(server, dark=scene.view.dark)
        camera.place(server.initial_camera, camera.initial(scene))
        frame_loop = FrameLoop(server, scene, access)
        try:
            yield access.url
        finally:
            frame_loop.stop()


def wait_for_signal(parent: int | None = None) -> None:
    """Wait until a signal raises Terminated, or the parent process of this number has ended. Python
    handles a signal that arrives just before a sleep only after that sleep, hence the short time.
    """
    while parent in (None, os.getppid()):
        time.sleep(SLEEP)


# The frame loop


async def exchange_messages() -> None:
    """Let the event loop receive and send."""
    for _ in range(LOOP_TURNS):
        await asyncio.sleep(0)


class FrameLoop:
    """Draws for all visitors; it sleeps while nothing moves.

    sessions: by client id; woken: ids of visitors whose page may be outdated, in order; drawn: time
    [s] of the end of the last round of frames; presenter: None while there is none.
    """

    def __init__(self, server: ViserServer, scene: Scene, access: Access):
        self.server, self.scene, self.access = server, scene, access
        self.loop, self.changed = server.get_event_loop(), asyncio.Event()
        self.own_loop = OwnLoop(self.loop)
        self.workers = Workers(lambda: len(self.sessions) >= CROWD, self.resume)
        self.opener = ThreadPoolExecutor(1, "opener")
        self.opener.submit(draw_sketches)  # before the first session, which shows them
        self.presenter: Visitor | None = None
        self.sessions: dict[int, Session] = {}
        self.woken: dict[int, None] = {}
        self.drawn = 0.0
        self.stopped = False
        self.running = asyncio.run_coroutine_threadsafe(self.run(), self.loop)
        server.on_client_connect(self.join)
        server.on_client_disconnect(self.left)

    async def join(self, client: ClientHandle) -> None:
        """Open a session for a new visitor on a thread of its own, while the others are drawn."""
        visitor = client.client_id
        presents = self.access.presents(handshake_request(self.server, visitor))
        follows = bool(self.access.presenter_key) and not presents
        with suppress(RuntimeError):  # stopped meanwhile
            opened = self.loop.run_in_executor(self.opener, self.session, client, follows)
            self.sessions[visitor] = session = await opened
            self.presenter = session.visitor if presents else self.presenter
            if self.stopped or visitor not in self.server.get_clients():
                self.leave(visitor)  # who has left while the session was built
            self.wake(visitor)

    def session(self, client: ClientHandle, follows: bool) -> Session:
        """A session for a new visitor, who may follow the presenter."""
        state = replace(State.of(self.scene), following=follows)
        wake = partial(self.wake, client.client_id)
        visitor = Visitor(client, state, self.workers, wake)
        return Session(visitor, (lambda: self.presenter) if follows else None)

    async def left(self, client: ClientHandle) -> None:
        self.leave(client.client_id)

    def leave(self, visitor: int) -> None:
        """Close the session of a visitor, by client id."""
        if session := self.sessions.pop(visitor, None):
            session.close()
            if session.visitor is self.presenter:
                self.wake(visitor)
                self.presenter = None

    def wake(self, visitor: int) -> None:
        """Draw for a visitor soon, and for the visitors who follow them."""
        self.woken[visitor] = None
        if self.presenter and visitor == self.presenter.client.client_id:
            for session in list(self.sessions.values()):
                if session.visitor.state.following:
                    session.visitor.wake()
        self.resume()

    def resume(self) -> None:
        """Wake the frame loop, from any thread."""
        with suppress(RuntimeError):  # the event loop is closed
            self.own_loop.call_soon_threadsafe(self.changed.set)

    def stop(self) -> None:
        self.stopped = True
        self.resume()
        wait([self.running], STOP_TIMEOUT)
        self.workers.close()
        self.opener.shutdown(cancel_futures=True)
        for visitor in list(self.sessions):
            self.leave(visitor)

    async def run(self) -> None:
        """Draw all moving scenes at a constant rate; in between, run solves and draw answers."""
        due = time.monotonic()
        while not self.stopped:
            await self.sleep(due)
            if time.monotonic() >= due:
                await self.draw_all(step := self.step)
                due = max(due + step, time.monotonic() + step / 5)
            try:
                for pool in (self.workers.background, self.workers.pool):
                    pool.replace()  # long work delays no other work
                self.workers.run_batch(BATCH)
            except Exception as error:  # the frame loop must continue
                log.error("solving", "a batch", error)
            self.draw_next()
            await exchange_messages()

    @property
    def step(self) -> float:
        """Time [s] from one round of frames to the next."""
        rate = FEWER_FRAMES if self.workers.waiting else FRAMES
        return max(1 / rate, self.access.visitor_count.total / ALL_FRAMES)

    async def sleep(self, due: float) -> None:
        """Wait until `due` [s] while a scene moves, else until something is outdated; while a job
        runs, at most PATIENCE, as the page shows its time."""
        if self.woken or self.workers.waiting or self.stopped:
            return
        self.changed.clear()
        sessions = self.sessions.values()
        busy = any(job.busy for session in sessions for job in session.visitor.jobs)
        wait_time = PATIENCE if busy else None
        if any(session.needs_tick for session in sessions):
            wait_time = due - time.monotonic()
        with suppress(TimeoutError):
            async with asyncio.timeout(wait_time):
                await self.changed.wait()

    async def draw_all(self, step: float) -> None:
        """Draw the next frame of all moving scenes, except those drawn a moment ago; while solves
        are waiting, except those updated since the last round."""
        before = self.drawn if self.workers.waiting else time.monotonic() - step / 2
        for k, (visitor, session) in enumerate(list(self.sessions.items())):
            if session.last_tick <= before and session.needs_tick:
                self.tick(visitor, session)
            if k % BATCH == BATCH - 1:
                await asyncio.sleep(0)
        self.drawn = time.monotonic()
        await exchange_messages()

    def draw_next(self) -> None:
        """Draw for the woken visitors who have waited longest, at most BATCH of them."""
        drawn = 0
        for visitor in list(self.woken):  # a copy: other threads add to it
            del self.woken[visitor]
            session = self.sessions.get(visitor)
            if session and session.outdated:
                self.tick(visitor, session)
                drawn += 1
            if drawn == BATCH:
                return

    def tick(self, visitor: int, session: Session) -> None:
        """Draw for one visitor. An error ends only this session; the page connects to a new one."""
        try:
            session.tick(time.monotonic())
        except Exception as error:
            log.error("drawing", f"visitor {visitor}, who is disconnected", error)
            self.leave(visitor)
            disconnect(self.server, visitor)
