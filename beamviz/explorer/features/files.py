"""Files: save and load a scene, and the tab Export."""

from functools import partial
from html import escape
from typing import Any

from beamviz.beam import MAX_TOML_BYTES
from beamviz.errors import InvalidInput
from beamviz.explorer.export_jobs import ExportJob
from beamviz.explorer.page.html import button, select
from beamviz.explorer.visitor import Visitor
from beamviz.exports.film import FORMATS
from beamviz.scene import Scene
from beamviz.server.log import RateLimitedLog

log = RateLimitedLog(__name__)

# Maximum resolution for a page: one solve takes at most 0.15 s, a chart takes 81 solves.
PAGE_LIMITS = {"elements": 200, "terms": 100}


def within_limits(scene: Scene) -> Scene:
    """Return a scene from a file or link. Raises InvalidInput if it exceeds PAGE_LIMITS."""
    for name, most in PAGE_LIMITS.items():
        value = scene.options.get(name) or 0
        if value > most:
            raise InvalidInput(
                f"{name} = {value}: a page solves with at most {most}; the command line takes more"
            )
    return scene


class SceneFiles:
    """Saves the scene to a TOML file and loads one."""

    def __init__(self, visitor: Visitor):
        self.visitor = visitor
        visitor.page.on("save", lambda _: self.save())
        visitor.page.on("load", self.load, max_text=2 * MAX_TOML_BYTES)

    def save(self) -> None:
        """Send the scene as a file."""
        try:
            content = self.visitor.to_scene().to_toml().encode()
            self.visitor.client.send_file_download("scene.toml", content, save_immediately=True)
        except InvalidInput as error:
            self.visitor.notify("This scene cannot be saved", str(error))

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


# Downloads

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


class Downloads:
    """The tab Export: a button for each file format, the progress, and a button that cancels."""

    def __init__(self, visitor: Visitor):
        self.visitor, self.page = visitor, visitor.page
        self.job: ExportJob | None = None
        self.length = next(iter(LENGTHS))
        self.page.html("tab-export", export_tab())
        self.page.value("film_length", self.length)
        visitor.page.on("export", self.start)
        visitor.page.on("cancel_export", lambda _: self.close())
        visitor.page.on("film_length", self.choose_length)

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
        state, name = job.status.state, f"beam{job.suffix}"
        working = state in ("waiting", "working")
        self.page.html("export-state", escape(f"{name}: {job.status.text}"))
        self.page.props("export-progress", value=job.status.done or None)
        self.page.props("export-work", hidden=not working)
        if state == "done" and not job.stopped.is_set():
            self.visitor.client.send_file_download(name, job.content, save_immediately=True)
        elif state == "failed":
            title, _, message = job.status.message.partition(": ")
            self.visitor.notify(title, message)
        if state in ("done", "cancelled"):
            self.page.say(f"{name}: {state}")


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
