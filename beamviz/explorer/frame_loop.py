"""The frame loop, which draws the pages of all visitors of a process, on the event loop.

At a constant rate it draws another moment of every scene that moves. Everything that changes a page
wakes its visitor, and the next round shows it.
"""

import asyncio
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import replace

from viser import ClientHandle, ViserServer

from beamviz.errors import InvalidInput
from beamviz.explorer.feature import Feature, first_state
from beamviz.explorer.jobs import LATE, Workers
from beamviz.explorer.presenter import Votes
from beamviz.explorer.session import Session
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.state import State
from beamviz.explorer.visitor import Visitor
from beamviz.scene import Scene
from beamviz.server.access import Access
from beamviz.server.log import RateLimitedLog
from beamviz.server.viser_private import disconnect, handshake_request

FRAMES = 25  # frames per second of one visitor
ALL_FRAMES = 800  # frames per second of all visitors of all processes together
BREAK = 0.2  # of the time that a round took to show edits, before the next one
PROGRESS = 1.25 * LATE  # [s] between frames of a page that shows how a job goes on
GROUP = 4  # frames between two exchanges of messages
LOOP_TURNS = 4  # iterations of the event loop in which a message is received or sent
STOP_TIMEOUT = 5.0  # [s] for the last frame

log = RateLimitedLog(__name__)


async def exchange_messages() -> None:
    """Let the event loop receive and send."""
    for _ in range(LOOP_TURNS):
        await asyncio.sleep(0)


class FrameLoop:
    """Draws for all visitors; it sleeps while nothing moves.

    sessions: by client id; last: the one that left last, in a notebook; opening: the scene of new
    ones; begin: what their first state becomes; later: ids of those who were woken by their own
    frame: what that has changed is shown by the next one, not by one in between; presenter: the
    session that was opened last with the presenter's key, None without one; votes: of the lecture;
    postpones: the last round that showed edits took longer than a frame may, so charts wait until
    the beam rests.
    """

    def __init__(
        self,
        server: ViserServer,
        scene: Scene,
        access: Access,
        features: tuple[type[Feature], ...],
        begin: Callable[[State], State],
    ):
        self.server, self.opening, self.access, self.features = server, scene, access, features
        self.begin = begin
        self.loop, self.changed = server.get_event_loop(), asyncio.Event()
        self.workers = Workers()
        self.opener = ThreadPoolExecutor(1, "opener")
        for kind in features:  # before the first session
            self.opener.submit(kind.prepare)
        self.presenter: Session | None = None
        self.votes = Votes(self.wake_presenter)
        self.sessions: dict[int, Session] = {}
        self.last: Session | None = None
        self.later: set[int] = set()
        self.stopped = self.postpones = False
        self.running = asyncio.run_coroutine_threadsafe(self.run(), self.loop)
        server.on_client_connect(self.join)
        server.on_client_disconnect(self.left)

    async def join(self, client: ClientHandle) -> None:
        """Open a session for a new visitor on the thread `opener`, while the others are drawn."""
        client_id = client.client_id
        presents = self.access.presents(handshake_request(self.server, client_id))
        follows = bool(self.access.presenter_key) and not presents
        opening = self.opening
        try:
            building = self.loop.run_in_executor(
                self.opener, self.session, client, follows, presents
            )
            session = await building
        except Exception as error:
            if not self.stopped:  # else no session is built any more
                self.fail("opening", client_id, error)
            return
        self.sessions[client_id] = session
        if self.opening is not opening:  # shown while the session was built
            session.visitor.open(self.opening)
        self.presenter = session if presents else self.presenter
        self.count_audience()
        if self.stopped or client_id not in self.server.get_clients():
            self.leave(client_id)  # who has left while the session was built
        session.visitor.wake()
        self.resume()  # it may have been woken before it was among the sessions

    def session(self, client: ClientHandle, follows: bool, presents: bool) -> Session:
        """A session for a new visitor, who may follow the presenter, or is that."""
        state = self.begin(first_state(self.first_scene(), self.features))
        state = replace(state, following=follows)
        presenter = self.presented if follows else None
        led = presenter, presents, self.votes
        visitor = Visitor(client, state, self.workers, self.resume, *led)
        return Session(visitor, self.features)

    def first_scene(self) -> Scene:
        """The scene of a new visitor; in a notebook, where they are one person, that of the last
        one."""
        if self.access.framed:
            with suppress(InvalidInput):
                return self.scene
        return self.opening

    @property
    def scene(self) -> Scene:
        """The scene of the visitor who came last, also after all have left. Raises InvalidInput for
        a number out of range on their page."""
        sessions = list(self.sessions.values())
        session = sessions[-1] if sessions else self.last
        return session.visitor.state.to_scene() if session else self.opening

    def show(self, scene: Scene) -> None:
        """Show a scene to all visitors, from any thread, and to those who come later."""
        self.opening, self.last = scene, None
        for session in list(self.sessions.values()):
            session.visitor.open(scene)

    def presented(self) -> Snapshot | None:
        """The last snapshot of the presenter."""
        return self.presenter.snapshot if self.presenter else None

    async def left(self, client: ClientHandle) -> None:
        self.leave(client.client_id)

    def leave(self, client_id: int) -> None:
        """Close the session of a visitor."""
        if session := self.sessions.pop(client_id, None):
            session.close()
            self.last = session if self.access.framed else None
            self.count_audience()
            if session is self.presenter:
                others = [other for other in self.sessions.values() if other.visitor.presents]
                self.presenter = others[-1] if others else None
                self.wake_followers()

    def count_audience(self) -> None:
        """Count the visitors who do not present, for the presenter."""
        sessions = list(self.sessions.values())
        self.votes.present = sum(not session.visitor.presents for session in sessions)
        self.wake_presenter()

    def wake_presenter(self) -> None:
        """Draw for the presenter, if there is one."""
        if self.presenter:
            self.presenter.visitor.wake()

    def wake_followers(self) -> None:
        """Draw for the visitors who follow the presenter."""
        for session in list(self.sessions.values()):
            if session.visitor.state.following:
                session.visitor.wake()

    def resume(self) -> None:
        """Look at once whether a page is outdated; from any thread."""
        with suppress(RuntimeError):  # the event loop is closed
            self.loop.call_soon_threadsafe(self.changed.set)

    def stop(self) -> None:
        self.stopped = True
        self.resume()
        wait([self.running], STOP_TIMEOUT)
        self.workers.close()
        self.opener.shutdown(cancel_futures=True)
        for client_id in list(self.sessions):
            self.leave(client_id)

    async def run(self) -> None:
        """Draw round after round. A round that shows edits and answers may take long, with many
        visitors: for a time in proportion after it, scenes only move."""
        due = full = frame = time.monotonic()
        while not self.stopped:
            await self.sleep(due, full)
            now = time.monotonic()
            is_due, shows = now >= due, now >= full
            if is_due:
                frame = now
                self.later.clear()
            outdated = self.outdated(now, frame) if shows else set[int]()
            await self.draw(outdated, all_moving=is_due)
            end = time.monotonic()
            if outdated:
                self.postpones, full = end - now > self.step, end + BREAK * (end - now)
            if is_due:
                due = max(due + self.step, end - self.step)
            await exchange_messages()

    def outdated(self, now: float, frame: float) -> set[int]:
        """The client ids of visitors whose page may be outdated at the time `now` [s]: of those
        woken, of those whose page shows how a job goes on, and of those whose page moves and is
        that of before the last frame of the scenes that move, which was due at the time `frame`
        [s]: rounds that show edits may leave no time between them at which one is due."""
        since = now - PROGRESS
        return self.woken | {
            client_id
            for client_id, session in self.sessions.items()
            if (session.is_busy and session.last_shown < since)
            or (session.page_moves and session.last_shown < frame)
        }

    @property
    def woken(self) -> set[int]:
        """The client ids of visitors who are to be drawn before the next frame of the scenes that
        move."""
        outdated = {
            client_id for client_id, session in self.sessions.items() if session.visitor.outdated
        }
        return outdated - self.later

    @property
    def step(self) -> float:
        """Time [s] from one frame of a moving scene to the next."""
        return max(1 / FRAMES, self.access.visitor_count.total / ALL_FRAMES)

    async def sleep(self, due: float, full: float) -> None:
        """Wait until `due` [s] while a scene moves, until `full` [s] while a visitor is woken, else
        until one is; while a job runs, at most PROGRESS, as the page shows it."""
        if self.stopped:
            return
        self.changed.clear()
        now, times = time.monotonic(), list[float]()
        if self.woken:
            times.append(full - now)
        if self.later or any(session.is_moving for session in self.sessions.values()):
            times.append(due - now)
        if any(session.is_busy for session in self.sessions.values()):
            times.append(PROGRESS)
        if times and min(times) <= 0:
            return
        with suppress(TimeoutError):
            async with asyncio.timeout(min(times, default=None)):
                await self.changed.wait()

    async def draw(self, outdated: set[int], *, all_moving: bool) -> None:
        """Draw a frame for each visitor whose client id is among the `outdated`, and a moment for
        each other one whose scene moves if `all_moving`. The presenter comes first: others follow.
        """
        sessions = sorted(self.sessions.items(), key=lambda item: item[1] is not self.presenter)
        for k, (client_id, session) in enumerate(sessions):
            if client_id in outdated:
                self.tick(client_id, session)
                if session is self.presenter:
                    self.wake_followers()
            elif all_moving and session.is_moving and session.last_shown:  # else it is new
                self.tick(client_id, session, only_moves=True)
            if k % GROUP == GROUP - 1:
                await exchange_messages()

    def tick(self, client_id: int, session: Session, *, only_moves: bool = False) -> None:
        """Draw for one visitor. An error ends only this session; the page connects to a new one."""
        try:
            if only_moves:
                session.move(time.monotonic())
                return
            session.tick(time.monotonic(), postpones=self.postpones)
            if session.is_moving and session.visitor.outdated:
                self.later.add(client_id)
        except Exception as error:
            self.fail("drawing", client_id, error)

    def fail(self, work: str, client_id: int, error: Exception) -> None:
        """End the session of a visitor because of an error, and disconnect them."""
        log.error(work, f"visitor {client_id}, who is disconnected", error)
        self.leave(client_id)
        disconnect(self.server, client_id)
