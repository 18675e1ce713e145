"""Scenes and files: save and load a scene, open the scene of a link, export what is shown."""

import secrets
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from viser import ClientHandle, GuiEvent, NotificationHandle

from beamviz.beam import MAX_TOML_BYTES
from beamviz.errors import InvalidInput
from beamviz.explorer.export_jobs import ExportJob
from beamviz.explorer.features.lessons import Lessons
from beamviz.explorer.page.style import script_element
from beamviz.explorer.visitor import Visitor
from beamviz.exports.film import ENCODERS
from beamviz.lessons import lesson
from beamviz.scene import Scene, parse_query
from beamviz.server.access import KEY_PARAMETER
from beamviz.server.log import RateLimitedLog
from beamviz.server.viser_private import filter_uploads

log = RateLimitedLog(__name__)

# What a page may ask for, so that one solution takes 0.15 s at most; a chart takes 81 times that.
PAGE_LIMITS = {"elements": 200, "terms": 100}


def within_limits(scene: Scene) -> Scene:
    """A scene from a visitor's file or link. Raises InvalidInput if it is above PAGE_LIMITS."""
    for name, most in PAGE_LIMITS.items():
        value = scene.options.get(name) or 0
        if value > most:
            raise InvalidInput(
                f"{name} = {value}: a page solves with at most {most}; the command line takes more"
            )
    return scene


class SceneFiles:
    """Two buttons: save the scene as a TOML file, and load one."""

    def __init__(self, visitor: Visitor):
        self.visitor, gui = visitor, visitor.client.gui
        with gui.add_folder("Scene file", expand_by_default=False):
            save = gui.add_button("Save scene", hint="A small text file with all settings")
            hint = "A file from Save scene"
            load = gui.add_upload_button("Load scene", hint=hint, mime_type=".toml")
        save.on_click(lambda _: self.save())
        load.on_upload(self.load)
        filter_uploads(visitor.client, self.accepts)

    def save(self) -> None:
        """Send the scene as a file."""
        try:
            content = self.visitor.to_scene().to_toml().encode()
            self.visitor.client.send_file_download("scene.toml", content, save_immediately=True)
        except InvalidInput as error:
            self.visitor.notify("This scene cannot be saved", str(error))

    def load(self, event: GuiEvent) -> None:
        """Show the scene in a file; an invalid one changes nothing."""
        try:
            file = event.target.value
            self.visitor.load(within_limits(Scene.from_bytes(file.content, file.name)))
        except InvalidInput as error:
            self.visitor.notify("The scene was not loaded", str(error))

    def accepts(self, file: Any) -> bool:
        """Whether an announced upload is small enough for a scene."""
        small = file.part_count <= 1 and file.size_bytes <= MAX_TOML_BYTES
        if not small:
            words = f"{file.filename}: larger than {MAX_TOML_BYTES} bytes, not a file of beamviz"
            self.visitor.notify("The scene was not loaded", words)
        return small


# Downloads

SUFFIXES = {
    "picture (PNG)": ".png",
    "film (GIF)": ".gif",
    "film (WebP)": ".webp",
    "film (MP4)": ".mp4",
    "page that plays offline (HTML)": ".html",
    "3D model (GLB)": ".glb",
    "numbers (CSV)": ".csv",
    "numbers (NPZ)": ".npz",
}
LENGTHS = {"shortest loop": None, "1 period": 1, "2 periods": 2, "4 periods": 4}


class Downloads:
    """A choice of files, a button that makes one of what is shown, and one that cancels it."""

    def __init__(self, visitor: Visitor):
        self.visitor = visitor
        self.job: ExportJob | None = None
        gui = visitor.client.gui
        with gui.add_folder("Export", expand_by_default=False):
            self.kind = gui.add_dropdown("file", tuple(SUFFIXES))
            self.length = gui.add_dropdown("length of a film", tuple(LENGTHS))
            make = gui.add_button("Make and download", hint="Of what you see now")
            self.cancel = gui.add_button("Cancel", disabled=True)
        make.on_click(lambda _: self.start())
        self.cancel.on_click(lambda _: self.close())

    def close(self) -> None:
        """Make no file any more."""
        if self.job:
            self.job.cancel()

    def start(self) -> None:
        """Make the chosen file, in place of the one that is being made for this visitor."""
        suffix, periods = SUFFIXES.get(self.kind.value), LENGTHS.get(self.length.value)
        if not suffix:
            return
        self.close()
        try:
            scene = self.visitor.to_scene()
        except InvalidInput as error:
            self.visitor.notify("Nothing to export", str(error))
            return
        title = f"Making beam{suffix}"
        note = self.visitor.client.add_notification(title, "", loading=True)
        options = {"periods": periods} if suffix in ENCODERS else {}
        self.job = ExportJob(scene, suffix, partial(self.show, note), **options)
        self.cancel.disabled = False
        self.job.start()

    def show(self, note: NotificationHandle, job: ExportJob) -> None:
        """Tell the visitor how the file is getting on, and send it."""
        state = job.status.state
        if state in ("waiting", "working"):
            note.body = job.status.text
            return
        note.remove()
        self.cancel.disabled = self.job in (job, None)
        if state == "done" and not job.stopped.is_set():
            name = f"beam{job.suffix}"
            self.visitor.client.send_file_download(name, job.content, save_immediately=True)
        elif state == "failed":
            title, _, message = job.status.message.partition(": ")
            self.visitor.notify(title, message)


# Links: ?lesson=nodes, or ?alpha=1&gamma=10&mode=3. A server is not told the query of the page that
# connects to it, so the page is asked, by way of its local storage.

PAGE_TIMEOUT = 20.0  # [s] for a page to answer
POLL_INTERVAL = 0.2  # [s]
# Parameters of the same link for others: the key of the server, the switches of viser's page.
RESERVED = {KEY_PARAMETER, "websocket", "fixedDpr", "darkMode", "showStats", "logCamera"}
# The page prefixes the keys of its local storage; only viser needs to know how.
STORE_QUERY = (
    "localStorage.setItem(Object.keys(localStorage).find(name => name.endsWith('{key}')),"
    " '?' + location.search)"
)


def open_link(visitor: Visitor, lessons: Lessons) -> None:
    """Show the scene of the visitor's link, from a thread of its own."""

    def run() -> None:
        query = page_query(visitor.client)
        try:
            open_query(query, visitor.load, lessons.open)
        except InvalidInput as error:
            visitor.notify("The link is not valid", str(error))

    threading.Thread(target=run, name="link", daemon=True).start()


def page_query(client: ClientHandle) -> str:
    """The query of the page's address; "" without one, and for a program without pages."""
    key, end = secrets.token_hex(8), time.monotonic() + PAGE_TIMEOUT
    client.local_storage.set_item(key, "")
    element = client.gui.add_html(script_element(STORE_QUERY.format(key=key)))
    query = ""
    try:
        while not query and time.monotonic() < end:
            time.sleep(POLL_INTERVAL)
            query = client.local_storage.get_item(key, timeout=PAGE_TIMEOUT) or ""
    except (RuntimeError, TimeoutError):
        return ""
    client.local_storage.remove_item(key)
    element.remove()
    return query.lstrip("?")


def open_query(
    query: str, load: Callable[[Scene], None], open_lesson: Callable[[str], None]
) -> None:
    """Open the lesson and load the scene of a query. Raises InvalidInput."""
    values = {key: value for key, value in parse_query(query).items() if key not in RESERVED}
    name = str(values.pop("lesson", ""))
    if not (name or values):
        return
    scene = lesson(name).scene if name else Scene()
    scene = within_limits(scene.changed(**values))
    if name:
        open_lesson(name)
    if values:
        load(scene)
