"""The explorer as a server: a session for each visitor, one animator for all of them."""

import contextlib
import queue
import secrets
import webbrowser
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from beamviz.ending import handled
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.mechanics.solve import solve
from beamviz.scene_file import SavedScene
from beamviz.show import camera
from beamviz.show.animator import Animator
from beamviz.show.door import LOOPBACK, PARAMETER, VISITORS, Door, public_url
from beamviz.show.hosting import hosted
from beamviz.show.motion import Shapes
from beamviz.show.session import theme
from beamviz.show.viewing import LIFT, lifted, place

SOLVERS = 2  # threads, for all visitors together
CHARTERS = 1  # as well, for their charts
KEY_BYTES = 16


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
