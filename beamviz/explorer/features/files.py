"""Files: a scene is saved and loaded, and the tab Export writes it in formats of other programs, in
the background.
"""

import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from html import escape
from importlib.util import find_spec
from pathlib import Path
from threading import Thread
from typing import Any

from beamviz.beam import Beam
from beamviz.dynamics import Motion
from beamviz.dynamics.linear import LinearMotion
from beamviz.errors import Cancelled, InvalidInput, NoEquilibrium
from beamviz.explorer import page
from beamviz.explorer.computed_motion import JOB as MOTION
from beamviz.explorer.computed_motion import wanted
from beamviz.explorer.computed_veering import VeeringRequest
from beamviz.explorer.declarations import Tab, choice, name_key
from beamviz.explorer.feature import Feature
from beamviz.explorer.features.lesson_player import is_lesson_file, open_lesson_file
from beamviz.explorer.features.loci_chart import CHART_KINDS
from beamviz.explorer.features.motion import MOTION_KINDS
from beamviz.explorer.features.veering import JOB as VEERING
from beamviz.explorer.features.veering import VEERING_KINDS
from beamviz.explorer.jobs import Answer, Job
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.solutions import within_limits
from beamviz.explorer.state import Slice
from beamviz.explorer.veering_files import export_veering
from beamviz.explorer.visitor import Visitor
from beamviz.exports import FORMATS, animate, export
from beamviz.exports.chart_files import export_chart
from beamviz.exports.motion_files import animate_motion, export_motion
from beamviz.input_files import MAX_TOML_BYTES
from beamviz.scene import Scene
from beamviz.solver import interruption

POLL = 0.1  # [s] between checks of the files before one that waits
# By whether they are films, the files of all visitors in order; the first is being written.
QUEUES: dict[bool, list["File"]] = {True: [], False: []}
KINDS = {
    ".gif": ("Film (GIF)", "A seamless loop, for slides"),
    ".webp": ("Film (WebP)", "The same, smaller"),
    ".mp4": ("Film (MP4)", "The same, for video software"),
    ".html": ("Page (HTML)", "One file that plays offline, light or dark as this page is now"),
    ".glb": ("3D model (GLB)", "Animated, for 3D software"),
    ".csv": ("Modes (CSV)", "A table of frequencies and nodes, for spreadsheets"),
    ".shapes.csv": ("Shapes (CSV)", "Equilibrium, loads and mode shapes along the beam"),
    ".npz": ("Numbers (NPZ)", "All of these, for Python"),
    ".toml": ("Beam (TOML)", "A beam in SI units, which the command line and Python read"),
    ".stations.csv": ("Stations (CSV)", "The section along a beam in SI units"),
    ".dat": ("Mode shapes (DAT)", "As polynomials, for an ElastoDyn blade file"),
}
MORE = (".webp", ".glb", ".shapes.csv", ".npz", ".toml", ".stations.csv", ".dat")  # in a fold


@dataclass(eq=False)
class File:
    """A scene, its frequency chart, its veering or a motion in time, to be written as a file; film:
    keywords of `animate`, None for other files; unstiffened: the motion without stiffening beside
    it; is_chart: the chart."""

    scene: Scene
    name: str
    film: dict[str, Any] | None
    motion: Motion | None = None
    unstiffened: LinearMotion | None = None
    is_chart: bool = False
    veering: VeeringRequest | None = None

    @property
    def beam(self) -> Beam:
        return self.scene.beam

    def has_content_of(self, other: "File") -> bool:
        named = (self.name, self.film, self.scene) == (other.name, other.film, other.scene)
        return named and self.motion is other.motion and self.veering == other.veering


JOB = "file"
FILM_LENGTHS = {"shortest loop": None, "1 period": 1, "2 periods": 2, "4 periods": 4}


@dataclass(frozen=True)
class FileState(Slice):
    """How scenes are exported."""

    film_length: str = field(
        default="shortest loop",
        metadata=choice(values=FILM_LENGTHS, key=name_key("film", FILM_LENGTHS)),
    )


class Files(Feature):
    """Buttons that save and load a scene, and the tab Export with the progress of its files."""

    style = "files.css"
    tab = Tab("Export", 10, "Scenes, pictures, films and numbers as files")
    state = FileState

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        self.buttons = export_tab()
        self.waiting: list[File] = []  # which the visitor wants after the one being written
        self.job: Job[File, bytes] = visitor.add_own_job(
            Job(JOB, self.write, lambda work: Thread(target=work, daemon=True).start(), self.finish)
        )
        self.page.on("save", lambda _: self.save())
        self.page.on("load", self.load, str, max_text=2 * MAX_TOML_BYTES)
        self.page.on("export", self.start, str)
        self.page.on("export_motion", self.start_motion, str)
        self.page.on("export_chart", self.start_chart, str)
        self.page.on("export_veering", self.start_veering, str)
        self.page.on("cancel_export", lambda _: self.job.cancel())

    def content(self, snapshot: Snapshot) -> Content:
        job = snapshot.jobs[JOB]
        return page.html("tab-export", self.buttons) | progress_content(
            busy=job.busy, note=job.note, done=job.done
        )

    def save(self) -> None:
        with self.visitor.reporting("This scene cannot be saved"):
            self.send("scene.toml", self.visitor.scene_to_save().to_toml().encode())

    def send(self, name: str, content: bytes) -> None:
        self.visitor.client.send_file_download(name, content, save_immediately=True)

    def load(self, file: Any) -> None:
        """Show the scene, or open the lesson, of a file: its name, and its contents from line 2 on;
        none if invalid."""
        name, _, content = str(file).partition("\n")
        if is_lesson_file(content):
            open_lesson_file(self.visitor, content.encode(errors="replace"), name)
            return
        with self.visitor.reporting("The scene was not loaded"):
            scene = within_limits(Scene.from_bytes(content.encode(errors="replace"), name))
            self.visitor.open(scene)

    def start(self, suffix: Any) -> None:
        """Export the scene."""
        if suffix not in tuple(KINDS):
            return
        periods = FILM_LENGTHS[self.visitor.state.slice(FileState).film_length]
        film = {"periods": periods} if suffix in FORMATS else None
        with self.visitor.reporting("Nothing to export"):
            self.begin(File(self.visitor.scene_to_save(), f"beam{suffix}", film))

    def start_motion(self, suffix: Any) -> None:
        """Export the motion in time."""
        answer = self.visitor.shown_answer(MOTION)
        computed = answer.result if answer else None
        if computed and computed.request != wanted(self.visitor.state):
            self.page.say("The motion is still being computed: download it after that.", error=True)
        elif suffix in MOTION_KINDS and computed:
            film: dict[str, Any] | None = {} if suffix in FORMATS else None
            scene = Scene(computed.beam, view=self.visitor.state.view)
            second = None if isinstance(computed.second, str) else computed.second
            self.begin(File(scene, f"motion{suffix}", film, computed.motion, second))

    def start_chart(self, suffix: Any) -> None:
        """Export the frequency chart."""
        if suffix in CHART_KINDS:
            with self.visitor.reporting("Nothing to export"):
                scene = self.visitor.scene_to_save()
                self.begin(File(scene, f"chart{suffix}", None, is_chart=True))

    def start_veering(self, suffix: Any) -> None:
        """Export the crossing or veering that is magnified."""
        answer = self.visitor.shown_answer(VEERING)
        if suffix in VEERING_KINDS and answer and answer.result:
            scene = self.visitor.scene_to_save()
            film: dict[str, Any] | None = {} if suffix in FORMATS else None
            self.begin(File(scene, f"veering{suffix}", film, veering=answer.request))

    def begin(self, file: File) -> None:
        """Write a file after those that the visitor waits for: in place of one of its name that has
        not begun. What is being written already is not begun again."""
        with self.job.lock:
            run = self.job.run
            if run is None:
                self.job.withdraw()
                self.job.request(file)
            elif not file.has_content_of(run.request):
                self.waiting = [one for one in self.waiting if one.name != file.name] + [file]
        self.visitor.wake()

    def write(self, file: File) -> bytes:
        """The content of a file, written after those before it."""
        queue = QUEUES[file.film is not None]
        queue.append(file)
        try:
            while ahead := queue.index(file):
                self.report(f"{file.name}: waits for {ahead} other{'s' if ahead > 1 else ''}")
                time.sleep(POLL)
            self.report(f"{file.name}: working")
            with tempfile.TemporaryDirectory(prefix="beamviz-") as folder:
                path = Path(folder) / file.name
                frames, view = partial(self.frames, file), file.scene.view
                beside: dict[str, Any] = {"view": view, "unstiffened": file.unstiffened}
                if file.motion and file.film is not None:
                    options: dict[str, Any] = {"workers": 1, **beside, **file.film}
                    animate_motion(path, file.motion, progress=frames, **options)
                elif file.motion:
                    export_motion(path, file.motion, **beside)
                elif file.veering:
                    export_veering(path, file.veering, frames)
                elif file.is_chart:
                    export_chart(path, file.scene)
                elif file.film is None:
                    export(path, file.scene)
                else:  # one thread, so that pages stay responsive
                    animate(path, file.scene, progress=frames, workers=1, **file.film)
                return path.read_bytes()
        finally:
            queue.remove(file)

    def frames(self, file: File, count: int) -> Iterator[int]:
        """The numbers of the frames of a film, reporting the progress. Raises Cancelled."""
        start = time.monotonic()
        for k in range(count):
            if k:
                left = (time.monotonic() - start) * (count - k) / k
                self.report(f"{file.name}: {100 * k / count:.0f} %, {left:.0f} s left", k / count)
            yield k

    def report(self, progress: str, done: float = 0.0) -> None:
        """Report the progress of a file. Raises Cancelled."""
        interruption.get()(done)
        if (run := self.job.run) and run.note != progress:
            run.note = progress
            self.visitor.wake()

    def finish(self) -> None:
        """Send the file that is complete, which is not kept, or say why there is none; then begin
        the next one."""
        self.visitor.wake()
        if (answer := self.job.taken()) is None:
            return
        self.tell(answer)
        with self.job.lock:
            if self.waiting and not self.job.busy:
                self.job.withdraw()
                self.job.request(self.waiting.pop(0))

    def tell(self, answer: Answer[File, bytes]) -> None:
        """Send a file, or say why there is none."""
        file, error, reason = answer.request, answer.error, answer.message
        if answer.result is not None:
            self.send(file.name, answer.result)
        if error is None or isinstance(error, Cancelled):
            self.page.say(f"{file.name}: {'cancelled' if error else 'done'}")
            return
        known = isinstance(error, InvalidInput | NoEquilibrium)
        self.page.say(f"{'Nothing to export' if known else 'The export failed'}: {reason}", True)


def progress_content(*, busy: bool, note: str, done: float) -> Content:
    """The progress, and a button that cancels it, while a file is being written."""
    content = page.props("export-work", hidden=not busy)
    content |= page.props("export-progress", value=done or None)
    for tab in ("motion", "chart", "veering"):
        content |= page.props(f"{tab}-file-work", hidden=not busy)
        content |= page.html(f"{tab}-file-state", escape(note))
    return content | page.html("export-state", escape(note))


def export_tab() -> str:
    """Buttons for all file formats, those for few readers in a fold, and for scene files."""
    length = page.select("film_length", "length of a film", tuple(FILM_LENGTHS))
    charts = "".join(
        page.button(name, data_do="export_chart", data_value=key)
        for key, name in CHART_KINDS.items()
    )
    load = (
        '<label class="button" for="scene-file">Load a scene</label>'
        '<input type="file" id="scene-file" class="hidden" data-do="load" accept=".toml">'
    )
    first = (
        file_entry(page.button("Picture (PNG)", id="save-picture"), "The scene as you see it"),
        *(export_entry(suffix) for suffix in KINDS if suffix not in MORE),
        file_entry(
            f'<span class="row">{charts}</span>', "The frequency chart: two pictures, its numbers"
        ),
        file_entry(
            page.button("Save the scene", data_do="save"),
            "All settings, as a small text file (TOML)",
        ),
        file_entry(load, "A file from Save the scene"),
        f'<div class="file">{length}</div>',
    )
    more = "".join(export_entry(suffix) for suffix in MORE)
    return (
        f'<div class="files">{"".join(first)}</div>'
        '<details class="more-files"><summary>More formats</summary>'
        f'<div class="files">{more}</div></details>'
        '<div id="export-work" class="row" hidden><span id="export-state"></span>'
        '<progress id="export-progress" aria-label="Progress of the export"></progress>'
        f"{page.button('Cancel', data_do='cancel_export')}</div>"
    )


def file_entry(control: str, text: str) -> str:
    """A control that writes or reads a file, and what for."""
    return f'<div class="file">{control}<span class="soft">{escape(text)}</span></div>'


def export_entry(suffix: str) -> str:
    """The button that exports the scene in a format."""
    name, text = KINDS[suffix]
    missing = suffix == ".mp4" and find_spec("av") is None
    text = "Needs the package PyAV (pip install av)" if missing else text
    return file_entry(
        page.button(name, data_do="export", data_value=suffix, disabled=missing), text
    )
