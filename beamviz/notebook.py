"""The live page in a cell of a notebook: `show` opens it, its `View` reads and moves it.

Each page has a server of its own in this process, on a free port of this machine, and a key in its
address. The server ends with the process, or by `View.close`.
"""

import atexit
import html
import secrets
import sys
import webbrowser
from contextlib import ExitStack
from typing import Any

from beamviz.beam import Beam
from beamviz.checks import check_int
from beamviz.errors import InvalidInput, Unavailable
from beamviz.explorer import KEY_BYTES, check_scene, run_explorer
from beamviz.scene import LINKED, Scene
from beamviz.server.access import Access, public_url
from beamviz.server.connection import SIGN_OF_LIFE
from beamviz.server.processes import listening_sockets
from beamviz.solver.solution import Solution

HOST = "127.0.0.1"
PORT = "{port}"  # stands for the port in the address of a proxy
HEIGHTS = 200, 4000
# A browser shows the text in place of an object that it cannot load: where the server is no more,
# above the frame, which is empty then; and where a notebook forbids objects.
FRAME = (
    '<object data="{url}{sign}" type="image/svg+xml" width="0" height="0" style="display: block">'
    "<p>No page below? It has ended with its kernel: run the cell again.</p></object>"
    '<iframe src="{url}" title="beamviz" width="100%" height="{height}" style="border: 0"'
    ' allow="clipboard-write; fullscreen"></iframe>'
)


class View:
    """A live page that `beamviz.show` has opened.

    url: its address, with its key. Whoever has it can use the page, on this machine or through the
    proxy.
    """

    def __init__(self, scene: Scene, public: str = ""):
        check_scene(scene)
        with listening_sockets(HOST, 0) as (listener, *_):
            port = listener.getsockname()[1]
        public = public and public_url(public.replace(PORT, str(port)), "public_url")
        key = secrets.token_urlsafe(KEY_BYTES)
        self._servers = ExitStack()
        running = run_explorer(scene, Access(HOST, port, key, public=public, framed=True))
        self.url, self._pages = self._servers.enter_context(running)
        atexit.register(self.close)

    @property
    def scene(self) -> Scene:
        """The scene as the visitor has it now, or left it. A scene, a beam or a solution that it is
        set to is shown by the page, where the visitor can undo that.

        Raises InvalidInput while a number on the page is out of range, and for a scene that its
        method cannot solve; Unavailable where a page that was closed is to show one.
        """
        return self._pages.scene

    @scene.setter
    def scene(self, shown: Scene | Beam | Solution) -> None:
        scene = scene_of(shown)
        check_scene(scene)
        if self._pages.stopped:
            raise Unavailable("this page is closed: beamviz.show opens another")
        self._pages.show(scene)

    def close(self) -> None:
        """End the server of the page; the frame then says that it is not connected."""
        atexit.unregister(self.close)
        self._servers.close()

    def __repr__(self) -> str:
        return f"<View {'closed' if self._pages.stopped else f'at {self.url}'}>"


def show(
    shown: Scene | Beam | Solution | None = None, *, height: int = 640, public_url: str = ""
) -> View:
    """Open the live page of a beam, a solution or a scene: in a notebook in its cell, elsewhere in
    the browser. It ends with this process, or by `close` of the View that is returned, whose
    `scene` reads and moves it.

    height: of the frame in the cell [pixels], 200 .. 4000; public_url: its address where the
    browser is on another machine, behind a proxy of the notebook's own address; {port} in it stands
    for the port, as in "https://hub.example.org/user/me/proxy/{port}/" of jupyter-server-proxy.

    Raises InvalidInput for a value out of range and a scene that its method cannot solve, and
    Unavailable if there is no server.
    """
    height = check_int("height", height, *HEIGHTS)
    view = View(scene_of(shown), public_url)
    if not displayed(FRAME.format(url=html.escape(view.url), sign=SIGN_OF_LIFE, height=height)):
        webbrowser.open(view.url)
    return view


def scene_of(shown: Any) -> Scene:
    """The scene of what `show` takes. Raises InvalidInput for anything else."""
    if shown is None:
        return Scene()
    if isinstance(shown, Scene):
        return shown
    if isinstance(shown, Beam):
        return Scene(shown)
    if isinstance(shown, Solution):
        return Scene(shown.beam, {name: getattr(shown.problem, name) for name in LINKED["model"]})
    kind = type(shown).__name__
    raise InvalidInput(f"a page shows a Beam, a Scene or a Solution, and no {kind}")


def displayed(markup: str) -> bool:
    """Display HTML in the cell of a notebook that runs this; False outside a notebook."""
    python = sys.modules.get("IPython")
    shell = python.get_ipython() if python else None
    if getattr(shell, "kernel", None) is None:
        return False
    display: Any = sys.modules["IPython.display"].display
    display({"text/html": markup, "text/plain": "the live page of beamviz"}, raw=True)
    return True
