"""Saving the scene to a file of the visitor's, and loading it from one."""

from viser import ClientHandle, GuiEvent

from beamviz.beam import MAX_TOML_BYTES
from beamviz.errors import InvalidInput
from beamviz.explorer.page.inputs import Listener
from beamviz.scene import SavedScene
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
            self.listener.load(SavedScene.from_bytes(file.content, file.name))
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
