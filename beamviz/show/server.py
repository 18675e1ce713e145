"""The explorer as a server: a session for each visitor, one animator for all of them."""

import contextlib
import queue
import secrets
import threading
import time
import webbrowser
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

from viser import ClientHandle, ViserServer

from beamviz.ending import handled
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.mechanics.solve import solve
from beamviz.scene_file import SavedScene
from beamviz.show import camera
from beamviz.show.door import LOOPBACK, PARAMETER, VISITORS, Door, public_url
from beamviz.show.hardening import dismiss, presents
from beamviz.show.hosting import hosted
from beamviz.show.journal import Journal
from beamviz.show.motion import Shapes
from beamviz.show.session import Session, theme
from beamviz.show.viewing import LIFT, lifted, place

FRAMES = 25  # a second, for one visitor
ALL_FRAMES = 800  # a second, for all visitors together
NOBODY = -1
CROWD = 8  # visitors; from here on, charts wait until a slider rests
SOLVERS = 2  # threads, for all visitors together
CHARTERS = 1  # as well, for their charts
KEY_BYTES = 16

journal = Journal(__name__)


def serve(
    scene: SavedScene,
    host: str = "127.0.0.1",
    port: int = 8080,
    open_browser: bool = False,
    public: str = "",
    visitors: int = VISITORS,
    follow: bool = False,
) -> None:
    """Serve the explorer, starting from `scene`, until Ctrl-C or SIGTERM.

    public: the URL under which a reverse proxy passes requests on;
    visitors: how many at once; follow: all see what a presenter does, whose link is printed as
    well. Prints one line with the URL when ready; where others than this
    machine can reach it, a key made for this run is part of it. Raises InvalidInput for a
    model that does not treat such a beam and Unavailable where the address cannot be had.
    """
    with contextlib.suppress(NoEquilibrium, NotConverged):  # the page shows these in words
        solve(scene.beam, **scene.options)
    public = public_url(public) if public else ""
    key = secrets.token_urlsafe(KEY_BYTES) if public or host not in LOOPBACK else ""
    presenter = secrets.token_urlsafe(KEY_BYTES) if follow else ""
    door = {"visitor": key, "presenter": presenter, "public": public, "room": visitors}
    with stopping() as stopped, explorer(scene, host, port, **door) as url:
        words = "whoever has this link can use it; " if key else ""
        print(f"beamviz is at {url} ({words}Ctrl-C ends it)", flush=True)
        if presenter:
            lead = f"{url.split('?')[0].rstrip('/')}/?{PARAMETER}={presenter}"
            print(f"the presenter's link, for nobody else: {lead}", flush=True)
        if open_browser:
            webbrowser.open(lead if presenter else url)
        while not ended(stopped):
            pass


@contextlib.contextmanager
def explorer(
    scene: SavedScene, host: str = "127.0.0.1", port: int = 0, **door: Any
) -> Iterator[str]:
    """A running explorer, by its URL, which holds the key if one is needed; door: keywords of
    Door."""
    with (
        hosted(host, port, **door) as server,
        ThreadPoolExecutor(SOLVERS, "solver") as pool,
        ThreadPoolExecutor(CHARTERS, "charter") as charts,
    ):
        theme(server, dark=scene.look.dark)
        rest = Shapes.at_rest(scene.beam, scene.options["plane"])
        fitted = lifted(camera.viewpoint(rest, scene.look.riding, aspect=1.0, lift=LIFT))
        place(server.initial_camera, scene.camera or fitted)
        entrance = Door(host, server.get_port(), **door)
        animator = Animator(server, scene, pool, charts, entrance)
        try:
            yield entrance.url
        finally:
            animator.stop()


@contextlib.contextmanager
def stopping() -> Iterator[queue.SimpleQueue[int]]:
    """Where Ctrl-C and SIGTERM are noted, instead of ending the process where it stands.

    A SimpleQueue, whose put may interrupt its own get; an Event is not made for that.
    """
    stopped: queue.SimpleQueue[int] = queue.SimpleQueue()
    with handled(lambda number, _: stopped.put(number)):
        yield stopped


def ended(stopped: queue.SimpleQueue[int]) -> bool:
    """Whether an end was asked for, within a second: a signal just before an endless wait begins
    would only be noted when it ends."""
    try:
        stopped.get(timeout=1.0)
    except queue.Empty:
        return False
    return True


class Animator:
    """The one thread that draws for all visitors; it sleeps while nothing moves."""

    def __init__(
        self,
        server: ViserServer,
        scene: SavedScene,
        pool: ThreadPoolExecutor,
        charts: ThreadPoolExecutor,
        door: Door,
    ):
        self.server, self.scene, self.pool, self.charts = server, scene, pool, charts
        self.door = door
        self.leader: int | None = None  # the presenter of a lecture
        self.sessions: dict[int, Session] = {}
        self.changed = threading.Condition()
        self.woken: set[int] = set()
        self.stopped = False
        self.thread = threading.Thread(target=self.run, name="animator", daemon=True)
        self.thread.start()
        server.on_client_connect(self.join)
        server.on_client_disconnect(lambda client: self.leave(client.client_id))

    def join(self, client: ClientHandle) -> None:
        """Open a session for a new visitor."""
        wake = partial(self.wake, client.client_id)
        leading = self.door.presenter and presents(self.door, self.server, client.client_id)
        leader = self.leading if self.door.presenter and not leading else None
        session = Session(client, self.scene, self.pool, self.charts, wake, self.crowded, leader)
        with self.changed:
            self.sessions[client.client_id] = session
            self.leader = client.client_id if leading else self.leader
        if self.stopped or client.client_id not in self.server.get_clients():
            self.leave(client.client_id)  # gone again while the session was built
        self.wake(client.client_id)

    def leading(self) -> Session | None:
        """The session of the presenter, while there is one."""
        return None if self.leader is None else self.sessions.get(self.leader)

    def crowded(self) -> bool:
        """Whether visitors are many."""
        return len(self.sessions) >= CROWD

    def leave(self, visitor: int) -> None:
        """Close the session of a visitor, by client id."""
        with self.changed:
            session = self.sessions.pop(visitor, None)
        if session:
            session.close()

    def wake(self, visitor: int) -> None:
        """Draw what is new for a visitor, now."""
        with self.changed:
            self.woken.add(visitor)
            if visitor == self.leader:
                self.woken.update(self.sessions)
            self.changed.notify()

    def stop(self) -> None:
        """End the thread and all sessions."""
        self.stopped = True
        self.wake(NOBODY)
        self.thread.join()
        for visitor in list(self.sessions):
            self.leave(visitor)

    def run(self) -> None:
        """Draw steadily for those whose picture moves, and at once what is new."""
        due = time.monotonic()
        while not self.stopped:
            woken = self.sleep(due)
            now = time.monotonic()
            frame = now >= due
            for visitor, session in list(self.sessions.items()):
                if (frame and session.ticking) or (visitor in woken and session.fresh):
                    self.tick(visitor, session, now)
            if frame:
                step = 1 / min(FRAMES, ALL_FRAMES / max(len(self.sessions), 1))
                due = max(due + step, time.monotonic() + step / 5)

    def sleep(self, due: float) -> set[int]:
        """Wait until `due`, or as long as nothing moves, or until woken; for whom."""
        with self.changed:
            if not self.woken:
                moving = any(session.ticking for session in self.sessions.values())
                self.changed.wait(max(due - time.monotonic(), 0.0) if moving else None)
            woken, self.woken = self.woken, set()
        return woken

    def tick(self, visitor: int, session: Session, now: float) -> None:
        """Draw for one visitor; a mistake there must not stop the others' pictures."""
        try:
            session.tick(now)
        except Exception as error:
            journal.failed("drawing", f"visitor {visitor}, who is sent off", error)
            self.leave(visitor)
            dismiss(self.server, visitor)  # their page connects again, to a new session
