"""Files: save and load a scene, and the tab Export, whose files are written in the background."""

import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from html import escape
from pathlib import Path
from typing import Any

from beamviz.beam import MAX_TOML_BYTES
from beamviz.drawing.text import error_summary
from beamviz.errors import BeamvizError, Cancelled, InvalidInput, NoEquilibrium
from beamviz.explorer.features.links import within_limits
from beamviz.explorer.page.html import button, select
from beamviz.explorer.visitor import Visitor
from beamviz.exports import animate, export
from beamviz.exports.film import FORMATS
from beamviz.scene import Scene
from beamviz.server.log import RateLimitedLog

log = RateLimitedLog(__name__)


class ExportJob:
    """The export of a scene to a file with a suffix.

    report: called with the job at each change of its state, from the thread of the export; options:
    keywords of `animate`. state: "waiting", "working", "done", "failed" or "cancelled"; text: the
    state in words; done: the fraction rendered of a film; content: the bytes of a complete file.
    """

    def __init__(
        self, scene: Scene, suffix: str, report: Callable[["ExportJob"], None], **options: Any
    ):
        self.scene, self.suffix, self.report, self.options = scene, suffix, report, options
        self.state, self.text, self.done = "waiting", "waiting", 0.0
        self.content, self.stopped = b"", False

    def start(self) -> None:
        """Write the file after those before it: films in one thread, other files in another."""
        pool, jobs = QUEUES[self.suffix in FORMATS]
        jobs.append(self)
        if ahead := len(jobs) - 1:
            self.wait(ahead)
        pool.submit(self.run, jobs)

    def wait(self, ahead: int) -> None:
        """Report the number of exports before it."""
        self.show("waiting", f"waits for {ahead} other{'s' if ahead > 1 else ''}")

    def cancel(self) -> None:
        """Stop the export and discard what it has written."""
        self.stopped = True

    def show(self, state: str, text: str = "", done: float = 0.0) -> None:
        """Set and report the state."""
        self.state, self.text, self.done = state, text or state, done
        self.report(self)

    def run(self, jobs: list["ExportJob"]) -> None:
        """Write the file, report the outcome, and update the others that wait."""
        try:
            next(self.frames(1))
            self.show("working")
            self.content = self.written()
            self.show("done")
        except Cancelled:
            self.show("cancelled")
        except (InvalidInput, NoEquilibrium) as error:
            known = isinstance(error, NoEquilibrium)
            reason = error_summary(error, self.scene.beam) if known else error
            self.show("failed", f"Nothing to export: {reason}")
        except BeamvizError as error:
            self.show("failed", f"The export failed: {error}")
        except Exception as error:  # which must not end the visitor's session
            log.error("file", self.suffix, error)
            unexpected = "an unexpected error, which the server has logged"
            self.show("failed", f"The export failed: {unexpected}")
        finally:
            jobs.remove(self)
            for ahead, other in enumerate(jobs[1:], 1):
                other.wait(ahead)

    def written(self) -> bytes:
        """The content of the file."""
        with tempfile.TemporaryDirectory(prefix="beamviz-") as folder:
            path = Path(folder) / f"beam{self.suffix}"
            if self.suffix in FORMATS:  # one thread, so that pages stay responsive
                animate(path, self.scene, progress=self.frames, workers=1, **self.options)
            else:
                export(path, self.scene)
            return path.read_bytes()

    def frames(self, count: int) -> Iterator[int]:
        """The numbers of the frames of a film, reporting progress. Raises Cancelled."""
        start = time.monotonic()
        for k in range(count):
            if self.stopped:
                raise Cancelled
            if k:
                left = (time.monotonic() - start) * (count - k) / k
                self.show("working", f"{100 * k / count:.0f} %, {left:.0f} s left", k / count)
            yield k


# The threads of films and of other files, shared by all visitors, with their jobs in order.
QUEUES: dict[bool, tuple[ThreadPoolExecutor, list[ExportJob]]] = {
    films: (ThreadPoolExecutor(1, "export"), []) for films in (False, True)
}
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


class Files:
    """Buttons that save and load a scene; the tab Export: a button for each file format, the
    progress, and a button that cancels."""

    def __init__(self, visitor: Visitor):
        self.visitor, self.page = visitor, visitor.page
        self.job: ExportJob | None = None
        self.length = next(iter(LENGTHS))
        self.page.html("tab-export", export_tab())
        self.page.value("film_length", self.length)
        visitor.page.on("save", lambda _: self.save())
        visitor.page.on("load", self.load, max_text=2 * MAX_TOML_BYTES)
        visitor.page.on("export", self.start)
        visitor.page.on("cancel_export", lambda _: self.close())
        visitor.page.on("film_length", self.choose_length)

    def save(self) -> None:
        """Send the scene as a file."""
        try:
            self.send("scene.toml", self.visitor.to_scene().to_toml().encode())
        except InvalidInput as error:
            self.visitor.notify("This scene cannot be saved", str(error))

    def send(self, name: str, content: bytes) -> None:
        """Send a file."""
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

    def choose_length(self, length: Any) -> None:
        """Choose the length of films."""
        self.length = length if length in tuple(LENGTHS) else self.length
        self.page.value("film_length", self.length)

    def close(self) -> None:
        """Cancel the running export."""
        if self.job:
            self.job.cancel()

    def start(self, suffix: Any) -> None:
        """Export the scene, in place of the visitor's running export."""
        if suffix not in tuple(KINDS):
            return
        self.close()
        try:
            scene = self.visitor.to_scene()
        except InvalidInput as error:
            self.visitor.notify("Nothing to export", str(error))
            return
        options: dict[str, Any] = {"periods": LENGTHS[self.length]} if suffix in FORMATS else {}
        if suffix == ".gif":  # the largest files
            options |= GIF_SIZE
        self.job = ExportJob(scene, suffix, self.show, **options)
        self.job.start()

    def show(self, job: ExportJob) -> None:
        """Show the progress of an export; send the file when it is complete."""
        if job is not self.job:
            return
        name = f"beam{job.suffix}"
        self.page.html("export-state", escape(f"{name}: {job.text}"))
        self.page.props("export-progress", value=job.done or None)
        self.page.props("export-work", hidden=job.state not in ("waiting", "working"))
        if job.state == "done" and not job.stopped:
            self.send(name, job.content)
        if job.state == "failed":
            self.page.say(job.text, error=True)
        elif job.state in ("done", "cancelled"):
            self.page.say(f"{name}: {job.state}")


def export_tab() -> str:
    """Buttons for all file formats, and for scene files."""
    files = "".join(
        f'<div class="file">{button(name, data_do="export", data_value=suffix)}'
        f'<span class="soft">{escape(text)}</span></div>'
        for suffix, (name, text) in KINDS.items()
    )
    return (
        '<div id="export-work" class="row" hidden><span id="export-state"></span>'
        '<progress id="export-progress" aria-label="Progress of the export"></progress>'
        f"{button('Cancel', data_do='cancel_export')}</div>"
        f'<div class="files"><div class="file">{button("Picture (PNG)", id="save-picture")}'
        f'<span class="soft">The scene as you see it</span></div>{files}'
        f'<div class="file">{button("Save the scene", data_do="save")}'
        '<span class="soft">All settings, as a small text file (TOML)</span></div>'
        '<div class="file"><label class="button" for="scene-file">Load a scene</label>'
        '<input type="file" id="scene-file" class="hidden" accept=".toml">'
        '<span class="soft">A file from Save the scene</span></div>'
        f'<div class="file">{select("film_length", "length of a film", LENGTHS.keys())}</div></div>'
    )
