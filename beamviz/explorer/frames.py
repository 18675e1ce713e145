"""What draws for all visitors of a process, and answers them in turn where they are many.

It runs on the event loop that sends and receives, not beside it: threads that compete for the
interpreter cost more than the work itself as soon as visitors are many.
"""

import asyncio
import contextlib
import threading
import time
from concurrent.futures import ThreadPoolExecutor, wait
from functools import partial

from viser import ClientHandle, ViserServer

from beamviz.explorer.features import Presentation
from beamviz.explorer.jobs import SolveQueue, WorkerPool
from beamviz.explorer.session import Session
from beamviz.scene import Scene
from beamviz.server.access import Access, VisitorCount
from beamviz.server.connection import is_presenter
from beamviz.server.log import RateLimitedLog
from beamviz.server.viser_private import disconnect, handshake_request

FRAMES = 25  # a second, for one visitor
ALL_FRAMES = 800  # a second, for all visitors of all processes together
FEWER_FRAMES = 12.8  # for one visitor, where some wait for answers
CROWD = 8  # visitors; from here on they are answered in turn, and charts wait for a rest
BATCH = 4  # answers or pictures in a row, which costs less; then messages come and go
HOPS = 4  # of the event loop that a message takes to come in, or to go out
PATIENCE = 5.0  # [s] for a picture to be finished when all ends

log = RateLimitedLog(__name__)


async def exchange_messages() -> None:
    """Let messages come and go."""
    for _ in range(HOPS):
        await asyncio.sleep(0)


class FrameLoop:
    """Draws for all visitors; it sleeps while nothing moves."""

    def __init__(
        self,
        server: ViserServer,
        scene: Scene,
        pool: WorkerPool,
        background: WorkerPool,
        access: Access,
        visitor_count: VisitorCount,
    ):
        self.server, self.scene, self.background, self.access = server, scene, background, access
        self.visitor_count = visitor_count
        self.loop, self.changed = server.get_event_loop(), asyncio.Event()
        self.thread: threading.Thread | None = None
        self.queue = SolveQueue(pool, self.crowded, self.rouse)
        self.opener = ThreadPoolExecutor(1, "opener")
        self.leader: int | None = None  # the presenter of a lecture
        self.sessions: dict[int, Session] = {}
        self.woken: dict[int, None] = {}  # those who wait to be drawn for, in order
        self.drawn: set[int] = set()  # who has had a picture since the last round
        self.stopped = False
        self.running = asyncio.run_coroutine_threadsafe(self.run(), self.loop)
        server.on_client_connect(self.join)
        server.on_client_disconnect(self.left)

    async def join(self, client: ClientHandle) -> None:
        """Open a session for a new visitor, beside the pictures of the others."""
        visitor = client.client_id
        request = handshake_request(self.server, visitor)
        leading = self.access.presenter_key and is_presenter(self.access, request)
        with contextlib.suppress(RuntimeError):  # all has ended meanwhile
            opened = self.opener.submit(self.opened, client, leader=not leading)
            session = await asyncio.wrap_future(opened)
            self.sessions[visitor] = session
            self.leader = visitor if leading else self.leader
            if self.stopped or visitor not in self.server.get_clients():
                self.leave(visitor)  # gone again while the session was built
            self.wake(visitor)

    def opened(self, client: ClientHandle, *, leader: bool) -> Session:
        """A session, with a leader where there is a lecture."""
        return Session(
            client,
            self.scene,
            self.queue,
            self.background,
            partial(self.wake, client.client_id),
            self.crowded,
            self.leading if self.access.presenter_key and leader else None,
        )

    def leading(self) -> Presentation | None:
        """What to follow of the presenter, while there is one."""
        session = None if self.leader is None else self.sessions.get(self.leader)
        return session.presentation if session else None

    def crowded(self) -> bool:
        """Whether visitors are many."""
        return len(self.sessions) >= CROWD

    async def left(self, client: ClientHandle) -> None:
        """Close the session of a visitor who has gone."""
        self.leave(client.client_id)

    def leave(self, visitor: int) -> None:
        """Close the session of a visitor, by client id."""
        session = self.sessions.pop(visitor, None)
        if session:
            session.close()

    def wake(self, visitor: int) -> None:
        """Draw what is new for a visitor, soon."""
        self.woken[visitor] = None
        if visitor == self.leader:
            self.woken.update(dict.fromkeys(list(self.sessions)))
        self.rouse()

    def rouse(self) -> None:
        """End the sleep, from any thread."""
        if threading.current_thread() is self.thread:
            self.changed.set()
        else:
            with contextlib.suppress(RuntimeError):  # all has ended
                self.loop.call_soon_threadsafe(self.changed.set)

    def stop(self) -> None:
        """End all sessions."""
        self.stopped = True
        self.rouse()
        wait([self.running], PATIENCE)
        self.queue.close()
        self.opener.shutdown(cancel_futures=True)
        for visitor in list(self.sessions):
            self.leave(visitor)

    async def run(self) -> None:
        """Draw steadily for those whose picture moves; in between, whatever is new, in order."""
        self.thread, due = threading.current_thread(), time.monotonic()
        while not self.stopped:
            await self.sleep(due)
            if time.monotonic() >= due:
                step = self.step
                await self.draw_all(step)
                due = max(due + step, time.monotonic() + step / 5)
            try:
                self.queue.run_batch(BATCH)
            except Exception as error:  # nobody else's picture must stop for it
                log.error("answering", "visitors in a crowd", error)
            self.draw_next()
            await exchange_messages()

    @property
    def step(self) -> float:
        """Time [s] from one round of pictures to the next."""
        rate = FEWER_FRAMES if self.queue.waiting else FRAMES
        return max(1 / rate, self.visitor_count.total / ALL_FRAMES)

    async def sleep(self, due: float) -> None:
        """Wait until `due`, or as long as nothing moves, or until something is new."""
        if self.woken or self.queue.waiting or self.stopped:
            return
        self.changed.clear()
        moving = any(session.needs_tick for session in self.sessions.values())
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(due - time.monotonic() if moving else None):
                await self.changed.wait()

    async def draw_all(self, step: float) -> None:
        """The next picture of everybody whose picture moves, unless they have had one but a moment
        ago; where there is little time, unless they have had one, with an answer, since the last
        round."""
        scarce, had = bool(self.queue.waiting), self.drawn
        self.drawn = set()
        for k, (visitor, session) in enumerate(list(self.sessions.items())):
            late = visitor not in had if scarce else time.monotonic() - session.last_tick > step / 2
            if late and session.needs_tick:
                self.tick(visitor, session)
            if k % BATCH == BATCH - 1:
                await asyncio.sleep(0)
        await exchange_messages()

    def draw_next(self) -> None:
        """What is new for those who have waited longest."""
        drawn = 0
        for visitor in list(self.woken):  # at once: other threads wake more
            del self.woken[visitor]
            session = self.sessions.get(visitor)
            if session and session.outdated:
                self.tick(visitor, session)
                self.drawn.add(visitor)
                drawn += 1
            if drawn == BATCH:
                return

    def tick(self, visitor: int, session: Session) -> None:
        """Draw for one visitor; a mistake there must not stop the others' pictures."""
        try:
            session.tick(time.monotonic())
        except Exception as error:
            log.error("drawing", f"visitor {visitor}, who is sent off", error)
            self.leave(visitor)
            disconnect(self.server, visitor)  # their page connects again, to a new session
