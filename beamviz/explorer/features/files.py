"""Saving the scene to a file of the visitor's, and loading it from one."""

import tempfile
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

from viser import ClientHandle, GuiEvent

from beamviz.beam import MAX_TOML_BYTES
from beamviz.errors import BeamvizError, InvalidInput
from beamviz.explorer.page.inputs import Listener
from beamviz.exports.export import export
from beamviz.exports.film import animate
from beamviz.exports.screenshot import screenshot
from beamviz.scene import Scene
from beamviz.server.log import RateLimitedLog
from beamviz.server.viser_private import Upload, filter_uploads

NAME = "scene.toml"
PATIENCE = 12.0  # [s] that a message stays


class SaveLoad:
    """Two buttons: the scene as a TOML file, and a scene from one."""

    def __init__(self, client: ClientHandle, listener: Listener):
        self.client, self.listener = client, listener
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
            text = self.listener.saved().to_toml()
        except InvalidInput as error:
            self.refuse("This scene cannot be saved", str(error))
        else:
            self.client.send_file_download(NAME, text.encode(), save_immediately=True)

    def load(self, event: GuiEvent) -> None:
        """Take up the scene in a file; one that is none changes nothing and says why."""
        file = event.target.value
        try:
            self.listener.load(Scene.from_bytes(file.content, file.name))
        except InvalidInput as error:
            self.refuse("The scene stays as it is", str(error))

    def refuse(self, title: str, words: str) -> None:
        """Tell the visitor what went wrong."""
        self.client.add_notification(title, words, color="red", auto_close_seconds=PATIENCE)

    def welcome(self, file: Upload) -> bool:
        """Whether a file that is about to come is as small as a scene; else it is turned down."""
        small = file.part_count <= 1 and file.size_bytes <= MAX_TOML_BYTES
        if not small:
            words = f"{file.filename}: larger than {MAX_TOML_BYTES} bytes, not a file of beamviz"
            self.refuse("The scene stays as it is", words)
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
PATIENCE = 12.0  # [s] that a message stays
MAKING = threading.BoundedSemaphore(1)  # one file at a time, of all visitors

log = RateLimitedLog(__name__)


class Abandoned(Exception):
    """The visitor has left."""


class TakeAway:
    """A choice of files, and a button that makes one."""

    def __init__(self, client: ClientHandle, listener: Listener):
        self.client, self.listener, self.gone = client, listener, False
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
            self.say("One file at a time", "Another one is being made: try again in a moment.")
            return
        threading.Thread(target=self.make, args=(ending,), name="take away").start()

    def make(self, ending: str) -> None:
        """Make the file and send it, or say why not."""
        note = self.client.add_notification(f"Making beam.{ending}", "", loading=True)
        try:
            content = made(ending, self.listener.saved(), self.counted)
            if not self.gone:
                name = f"beam.{ending}"
                self.client.send_file_download(name, content, save_immediately=True)
        except Abandoned:
            return
        except InvalidInput as error:
            self.say("There is nothing to make of this", str(error))
        except BeamvizError as error:
            self.say("It could not be made", str(error))
        except Exception as error:  # a mistake of ours must not end a visitor's session
            log.error("file", ending, error)
            self.say("It could not be made", "an unexpected error, which the server has noted")
        finally:
            MAKING.release()
            note.remove()

    def counted(self, count: int) -> Iterator[int]:
        """The frames up to a number, as long as somebody waits for them."""
        for k in range(count):
            if self.gone:
                raise Abandoned
            yield k

    def say(self, title: str, words: str) -> None:
        """Tell the visitor."""
        self.client.add_notification(title, words, color="red", auto_close_seconds=PATIENCE)


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
