"""Files: save and load a scene, and the tab Export, whose files are written in the background."""

import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from html import escape
from pathlib import Path
from threading import Thread
from typing import Any

from beamviz.beam import MAX_TOML_BYTES
from beamviz.drawing.text import error_summary
from beamviz.errors import Cancelled, InvalidInput, NoEquilibrium
from beamviz.explorer.features.links import within_limits
from beamviz.explorer.jobs import Job
from beamviz.explorer.page.html import button, select
from beamviz.explorer.visitor import Visitor
from beamviz.exports import FORMATS, animate, export
from beamviz.scene import Scene
from beamviz.solver import interruption

POLL = 0.1  # [s] between checks of the files before one that waits
# By whether they are films, the files of all visitors in order; the first is being written.
QUEUES: dict[bool, list["File"]] = {True: [], False: []}
KINDS = {
    ".gif": ("Film (GIF)", "A seamless loop, for slides"),
    ".webp": ("Film (WebP)", "The same, smaller"),
    ".mp4": ("Film (MP4)", "The same, for video software"),
    ".html": ("Page (HTML)", "Scene, chart and table in one file that plays offline"),
    ".glb": ("3D model (GLB)", "Animated, for 3D software"),
    ".csv": ("Numbers (CSV)", "Frequencies, shapes and equilibrium, for spreadsheets"),
    ".npz": ("Numbers (NPZ)", "The same, for Python"),
}
GIF_SIZE = {"width": 480, "height": 270}
LENGTHS = {"shortest loop": None, "1 period": 1, "2 periods": 2, "4 periods": 4}


@dataclass(eq=False)
class File:
    """A scene to be written as a file; film: keywords of `animate`, None for other files."""

    scene: Scene
    name: str
    film: dict[str, Any] | None


class Files:
    """Buttons that save and load a scene; the tab Export: a button for each file format, the
    progress, and a button that cancels."""

    def __init__(self, visitor: Visitor):
        self.visitor, self.page = visitor, visitor.page
        self.job: Job[File, bytes] = Job(
            "file", self.write, lambda work: Thread(target=work, daemon=True).start(), self.finish
        )
        self.page.html("tab-export", export_tab())
        visitor.page.on("save", lambda _: self.save())
        visitor.page.on("load", self.load, max_text=2 * MAX_TOML_BYTES)
        visitor.page.on("export", self.start)
        visitor.page.on("cancel_export", lambda _: self.job.cancel())
        visitor.bind("film_length", choices=LENGTHS)

    def save(self) -> None:
        try:
            self.send("scene.toml", self.visitor.to_scene().to_toml().encode())
        except InvalidInput as error:
            self.visitor.notify("This scene cannot be saved", str(error))

    def send(self, name: str, content: bytes) -> None:
        self.visitor.client.send_file_download(name, content, save_immediately=True)

    def load(self, file: Any) -> None:
        """Show the scene of a file, given as its name and, from the second line on, its contents;
        an invalid file changes nothing."""
        name, _, content = str(file).partition("\n")
        try:
            scene = within_limits(Scene.from_bytes(content.encode(errors="replace"), name))
        except InvalidInput as error:
            self.visitor.notify("The scene was not loaded", str(error))
        else:
            self.visitor.background.submit(partial(self.visitor.load, scene, opened=scene))

    def start(self, suffix: Any) -> None:
        """Export the scene, in place of the visitor's running export."""
        if suffix not in tuple(KINDS):
            return
        try:
            scene = self.visitor.to_scene()
        except InvalidInput as error:
            self.visitor.notify("Nothing to export", str(error))
            return
        size = GIF_SIZE if suffix == ".gif" else {}  # the largest files
        periods = LENGTHS[self.visitor.state.film_length]
        film = {"periods": periods, **size} if suffix in FORMATS else None
        self.job.withdraw()
        self.job.request(File(scene, f"beam{suffix}", film))

    def write(self, file: File) -> bytes:
        """The content of a file, written after those before it."""
        queue = QUEUES[file.film is not None]
        queue.append(file)
        try:
            while ahead := queue.index(file):
                self.show(file, f"waits for {ahead} other{'s' if ahead > 1 else ''}")
                time.sleep(POLL)
            self.show(file, "working")
            with tempfile.TemporaryDirectory(prefix="beamviz-") as folder:
                path = Path(folder) / file.name
                if file.film is None:
                    export(path, file.scene)
                else:  # one thread, so that pages stay responsive
                    frames = partial(self.frames, file)
                    animate(path, file.scene, progress=frames, workers=1, **file.film)
                return path.read_bytes()
        finally:
            queue.remove(file)

    def frames(self, file: File, count: int) -> Iterator[int]:
        """The numbers of the frames of a film, showing the progress. Raises Cancelled."""
        start = time.monotonic()
        for k in range(count):
            if k:
                left = (time.monotonic() - start) * (count - k) / k
                self.show(file, f"{100 * k / count:.0f} %, {left:.0f} s left", k / count)
            yield k

    def show(self, file: File, progress: str, done: float = 0.0) -> None:
        """Show the progress of a file. Raises Cancelled."""
        interruption.get()(done)
        self.page.html("export-state", escape(f"{file.name}: {progress}"))
        self.page.props("export-progress", value=done or None)
        self.page.props("export-work", hidden=False)

    def finish(self) -> None:
        """Send the file that is complete, or say why there is none."""
        self.page.props("export-work", hidden=True)
        if (answer := self.job.answer) is None:
            return
        file, error = answer.request, answer.error
        if answer.result is not None:
            self.send(file.name, answer.result)
            self.page.say(f"{file.name}: done")
        elif isinstance(error, NoEquilibrium):
            self.visitor.notify("Nothing to export", error_summary(error, file.scene.beam))
        elif isinstance(error, Cancelled):
            self.page.say(f"{file.name}: cancelled")
        else:
            known = isinstance(error, InvalidInput)
            self.visitor.notify("Nothing to export" if known else "The export failed", str(error))


def export_tab() -> str:
    """Buttons for all file formats, and for scene files."""
    files = "".join(
        f'<div class="file">{button(name, data_do="export", data_value=suffix)}'
        f'<span class="soft">{escape(text)}</span></div>'
        for suffix, (name, text) in KINDS.items()
    )
    return (
        f'<div class="files"><div class="file">{button("Picture (PNG)", id="save-picture")}'
        f'<span class="soft">The scene as you see it</span></div>{files}'
        f'<div class="file">{button("Save the scene", data_do="save")}'
        '<span class="soft">All settings, as a small text file (TOML)</span></div>'
        '<div class="file"><label class="button" for="scene-file">Load a scene</label>'
        '<input type="file" id="scene-file" class="hidden" accept=".toml">'
        '<span class="soft">A file from Save the scene</span></div>'
        f'<div class="file">{select("film_length", "length of a film", LENGTHS.keys())}</div></div>'
        '<div id="export-work" class="row" hidden><span id="export-state"></span>'
        '<progress id="export-progress" aria-label="Progress of the export"></progress>'
        f"{button('Cancel', data_do='cancel_export')}</div>"
    )
