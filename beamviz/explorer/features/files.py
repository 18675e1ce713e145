"""Saving the scene to a file of the visitor's, and loading it from one."""

import secrets
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from viser import ClientHandle, GuiEvent

from beamviz.beam import MAX_TOML_BYTES
from beamviz.errors import BeamvizError, InvalidInput
from beamviz.explorer.features.lessons import Lessons
from beamviz.explorer.page.style import script_element
from beamviz.explorer.visitor import Visitor
from beamviz.exports.export import export
from beamviz.exports.film import animate
from beamviz.exports.screenshot import screenshot
from beamviz.lessons import lesson
from beamviz.scene import Scene, parse_query
from beamviz.server.access import KEY_PARAMETER
from beamviz.server.log import RateLimitedLog
from beamviz.server.viser_private import filter_uploads

NAME = "scene.toml"


class SceneFiles:
    """Two buttons: the scene as a TOML file, and a scene from one."""

    def __init__(self, visitor: Visitor):
        self.visitor, client = visitor, visitor.client
        with client.gui.add_folder("Scene file", expand_by_default=False):
            save = client.gui.add_button("Save scene", hint="A small text file: all that is set")
            load = client.gui.add_upload_button(
                "Load scene", hint="A file from Save scene", mime_type=".toml"
            )
        save.on_click(lambda _: self.save())
        load.on_upload(self.load)
        filter_uploads(client, self.welcome)

    def save(self) -> None:
        """Send the scene as a file."""
        try:
            text = self.visitor.to_scene().to_toml()
        except InvalidInput as error:
            self.visitor.notify("This scene cannot be saved", str(error))
        else:
            self.visitor.client.send_file_download(NAME, text.encode(), save_immediately=True)

    def load(self, event: GuiEvent) -> None:
        """Take up the scene in a file; one that is none changes nothing and says why."""
        file = event.target.value
        try:
            self.visitor.load(Scene.from_bytes(file.content, file.name))
        except InvalidInput as error:
            self.visitor.notify("The scene stays as it is", str(error))

    def welcome(self, file: Any) -> bool:
        """Whether a file that is about to come is as small as a scene; else it is turned down."""
        small = file.part_count <= 1 and file.size_bytes <= MAX_TOML_BYTES
        if not small:
            words = f"{file.filename}: larger than {MAX_TOML_BYTES} bytes, not a file of beamviz"
            self.visitor.notify("The scene stays as it is", words)
        return small


FILES = {
    "picture (PNG)": "png",
    "film (GIF)": "gif",
    "film (MP4)": "mp4",
    "page that plays offline (HTML)": "html",
    "3D model (GLB)": "glb",
    "numbers (CSV)": "csv",
    "numbers (NPZ)": "npz",
}
MAKING = threading.BoundedSemaphore(1)  # one file at a time for all visitors of a process

log = RateLimitedLog(__name__)


class Abandoned(Exception):
    """The visitor has left."""


class Downloads:
    """A choice of files, and a button that makes one."""

    def __init__(self, visitor: Visitor):
        self.visitor, self.client, self.gone = visitor, visitor.client, False
        client = visitor.client
        with client.gui.add_folder("Take away", expand_by_default=False):
            self.kind = client.gui.add_dropdown("file", tuple(FILES))
            button = client.gui.add_button("Make and download", hint="Of what you see now")
        button.on_click(lambda _: self.take())

    def close(self) -> None:
        """Stop working for who has left."""
        self.gone = True

    def take(self) -> None:
        """Begin to make the file that is chosen, in a thread of its own."""
        ending = FILES.get(self.kind.value)
        if ending is None:
            return
        if not MAKING.acquire(blocking=False):
            self.visitor.notify(
                "One file at a time", "Another one is being made: try again in a moment."
            )
            return
        threading.Thread(target=self.make, args=(ending,), name="take away").start()

    def make(self, ending: str) -> None:
        """Make the file and send it, or say why not."""
        note = self.client.add_notification(f"Making beam.{ending}", "", loading=True)
        try:
            content = made(ending, self.visitor.to_scene(), self.counted)
            if not self.gone:
                name = f"beam.{ending}"
                self.client.send_file_download(name, content, save_immediately=True)
        except Abandoned:
            return
        except InvalidInput as error:
            self.visitor.notify("Nothing to export", str(error))
        except BeamvizError as error:
            self.visitor.notify("It could not be made", str(error))
        except Exception as error:  # a mistake of ours must not end a visitor's session
            log.error("file", ending, error)
            self.visitor.notify(
                "It could not be made", "an unexpected error, which the server has noted"
            )
        finally:
            MAKING.release()
            note.remove()

    def counted(self, count: int) -> Iterator[int]:
        """The frames up to a number, as long as somebody waits for them."""
        for k in range(count):
            if self.gone:
                raise Abandoned
            yield k


def made(ending: str, scene: Scene, counted: Callable[[int], Iterator[int]]) -> bytes:
    """What a file of this ending holds."""
    with tempfile.TemporaryDirectory(prefix="beamviz-") as folder:
        path = Path(folder) / f"beam.{ending}"
        if ending == "png":
            screenshot(path, scene)
        elif ending in ("gif", "mp4"):
            animate(path, scene, progress=counted)
        else:
            export(path, scene)
        return path.read_bytes()


# Links: ?lesson=nodes, or ?alpha=1&gamma=10&mode=3. A server is not told the query of the page that
# connects to it, so the page is asked.

PAGE_TIMEOUT = 20.0  # [s] for a page to answer
PAUSE = 0.2  # [s] between two questions
# What others read from the same link: the access its key, viser's page its switches.
OTHERS = {KEY_PARAMETER, "websocket", "fixedDpr", "darkMode", "showStats", "logCamera"}
# The page knows the key under a longer name, which only viser needs to know.
NOTE = (
    "localStorage.setItem(Object.keys(localStorage).find(name => name.endsWith('{key}')),"
    " '?' + location.search)"
)


def open_link(visitor: Visitor, lessons: Lessons) -> None:
    """Show what the visitor's link asks for, from a thread of its own."""

    def run() -> None:
        query = asked(visitor.client)
        try:
            arrive(query, visitor, lessons)
        except InvalidInput as error:
            visitor.notify("The link is not valid", str(error))

    threading.Thread(target=run, name="link", daemon=True).start()


def asked(client: ClientHandle) -> str:
    """The query of the visitor's link; "" where there is none, or no page that could tell."""
    key, end = secrets.token_hex(8), time.monotonic() + PAGE_TIMEOUT
    client.local_storage.set_item(key, "")
    note = client.gui.add_html(script_element(NOTE.format(key=key)))
    query = ""
    try:
        while not query and time.monotonic() < end:
            time.sleep(PAUSE)
            query = client.local_storage.get_item(key, timeout=PAGE_TIMEOUT) or ""
    except (RuntimeError, TimeoutError):  # gone, or a program without pages
        return ""
    client.local_storage.remove_item(key)
    note.remove()
    return query.lstrip("?")


def arrive(query: str, visitor: Visitor, lessons: Lessons) -> None:
    """Open the lesson and load the scene of a query; InvalidInput where it is not valid."""
    values = {key: value for key, value in parse_query(query).items() if key not in OTHERS}
    name = str(values.pop("lesson", ""))
    if not (name or values):
        return
    scene = lesson(name).scene if name else Scene()
    scene = scene.changed(**values)
    if name:
        lessons.open(name)
    if values:
        visitor.load(scene)
