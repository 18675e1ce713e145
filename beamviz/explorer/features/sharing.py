"""Sharing a scene: the link in the address of the page, files to save and load, and the tab Export,
whose files are written in the background.

A page opens with the scene of its address, and the address is updated with the scene. Examples:
?lesson=nodes, ?alpha=1&gamma=10&mode=3, or both, with other KEYS.
"""

import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from html import escape
from pathlib import Path
from threading import Thread
from typing import Any
from urllib.parse import parse_qsl, urlencode

from beamviz.beam import MAX_TOML_BYTES, check_float, check_int
from beamviz.drawing.text import error_summary
from beamviz.errors import Cancelled, InvalidInput, NoEquilibrium
from beamviz.explorer import page
from beamviz.explorer.features.lessons import STEPS, Lessons
from beamviz.explorer.jobs import Job
from beamviz.explorer.state import COMPARISONS, EARLIER, FILM_LENGTHS, TABS, History, State
from beamviz.explorer.visitor import Visitor
from beamviz.exports import FORMATS, animate, export
from beamviz.frequency_loci.forced_response import DAMPING
from beamviz.lessons import lesson
from beamviz.scene import PER_REV, Scene, check_bool, check_choice, parse_query
from beamviz.server.access import KEY_PARAMETER
from beamviz.solver import interruption

PERIOD = 0.5  # [s] between two changes of the address
# Parameters with another reader: the key of the server, and the options of viser's page.
RESERVED = {KEY_PARAMETER, "websocket", "fixedDpr", "darkMode", "showStats", "logCamera"}
OWN = ("dark", "playing")  # view options that are the visitor's preference, and in no link
# Keys of a link besides those of a scene: the field of the state, and the check of its value.
KEYS: dict[str, tuple[str, Callable[[Any], Any]]] = {
    "lesson": ("lesson", lambda name: lesson(str(name)).name),
    "step": ("step", lambda step: check_int("step", step, 1, len(STEPS)) - 1),
    "compare": ("comparison", lambda case: check_choice("compare", case, COMPARISONS[2:])),
    "stacked": ("stacked", partial(check_bool, "stacked")),
    "force": ("force_per_rev", lambda count: check_int("force", count, 1, max(PER_REV))),
    "damping": ("damping", lambda ratio: check_float("damping", ratio, *DAMPING)),
    "response": ("forced_response", partial(check_bool, "response")),
    "tab": ("tab", lambda name: check_choice("tab", name, TABS)),
}
# Maximum resolution for a page: one solve takes at most 0.15 s, a chart takes 81 solves.
PAGE_LIMITS = {"elements": 200, "terms": 100}


def within_limits(scene: Scene) -> Scene:
    """Return a scene from a file or link. Raises InvalidInput if it exceeds PAGE_LIMITS."""
    for name, most in PAGE_LIMITS.items():
        if (value := scene.options.get(name) or 0) > most:
            limit = f"a page solves with at most {most}; the command line takes more"
            raise InvalidInput(f"{name} = {value}: {limit}")
    return scene


def parse_link(query: str) -> tuple[Scene, dict[str, Any]] | None:
    """The scene and other values of the state in a query; None for no keys. Raises InvalidInput."""
    keys = {key: value for key, value in parse_query(query).items() if key not in RESERVED}
    if not keys:
        return None
    known = {key: KEYS[key] for key in KEYS if keys.get(key) is not None}
    values = {name: check(keys.pop(key)) for key, (name, check) in known.items()}
    base = lesson(values["lesson"]).scene if "lesson" in values else Scene()
    return within_limits(Scene.from_query(keys, base)), values


class Links:
    """The address of one visitor's page.

    start: the state without a query; reserved: the RESERVED parameters of the address, None before
    the page has sent it; shown: the state in the address; due: time [s] of the next change at the
    earliest; moved: the viewpoint has changed since; opened: the state has what the address says.
    """

    def __init__(self, visitor: Visitor, lessons: Lessons):
        self.visitor, self.lessons = visitor, lessons
        self.start = visitor.state
        self.reserved: list[tuple[str, str]] | None = None
        self.shown: State | None = None
        self.due, self.moved, self.opened = 0.0, False, False
        visitor.page.on("link", self.open)

    def open(self, query: Any) -> None:
        """Show the scene of the address, which the page sends when it starts."""
        text = query.lstrip("?") if isinstance(query, str) else ""
        self.reserved = [pair for pair in parse_qsl(text) if pair[0] in RESERVED]
        self.opened = True
        with self.visitor.reporting("The link is not valid"):
            if link := parse_link(text):
                self.opened = False
                self.visitor.background.submit(partial(self.show, *link))
        self.visitor.wake()

    def show(self, scene: Scene, values: dict[str, Any]) -> None:
        """Show the content of a link; there is nothing to undo."""
        visitor = self.visitor
        if "lesson" in values:
            self.lessons.begin(values["lesson"], scene)
        else:
            scene = scene.changed(dark=visitor.state.view.dark)
            visitor.load(scene, opened=scene)
        with visitor.lock:
            visitor.change(lambda state: replace(state, **values))
            visitor.history = History()
        self.opened = True

    @property
    def outdated(self) -> bool:
        """Whether the state or the viewpoint differs from that of the address."""
        changed = self.moved or self.shown is not self.visitor.state
        return self.reserved is not None and changed

    def update(self, now: float) -> None:
        """Update the address at the time `now` [s], at most once per PERIOD."""
        if self.reserved is None or now < self.due or not self.outdated:
            return
        self.shown = self.visitor.state
        self.due, self.moved = now + PERIOD, False
        try:
            query = self.query(self.visitor.state)
        except InvalidInput:  # a number is out of range
            return
        pairs = urlencode(self.reserved)
        self.visitor.page.send("&".join(filter(None, (pairs, query))), "address")

    def query(self, state: State) -> str:
        """The query of a link to a state; "" for that at the start, or of a presenter."""
        scene = replace(state.to_scene(), camera=self.visitor.camera.chosen)
        own = {name: getattr(state.view, name) for name in OWN}
        first = replace(self.start, view=replace(self.start.view, **own))
        pairs = extra_pairs(state)
        if state.following or (scene == first.to_scene() and pairs == extra_pairs(first)):
            return ""
        base = lesson(state.lesson).scene if state.lesson else Scene()
        found = "&".join(filter(None, (urlencode(pairs), scene.to_query(base, without=OWN))))
        return found or f"gamma={scene.beam.gamma!r}"  # the default scene, but not that at start


def extra_pairs(state: State) -> dict[str, Any]:
    """The keys and values of a link that are not those of the scene."""
    values = {key: getattr(state, name) for key, (name, _) in KEYS.items()}
    values = {key: one for key, one in values.items() if one != getattr(State, KEYS[key][0])}
    if "step" in values:
        values["step"] += 1
    if state.comparison == EARLIER:  # a link has no case that is kept
        del values["compare"]
    return {key: "true" if one is True else one for key, one in values.items()}


# Files

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


@dataclass(eq=False)
class File:
    """A scene to be written as a file; film: keywords of `animate`, None for other files."""

    scene: Scene
    name: str
    film: dict[str, Any] | None


class Files:
    """Buttons that save and load a scene, and the tab Export with the progress of its files."""

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

    def save(self) -> None:
        with self.visitor.reporting("This scene cannot be saved"):
            self.send("scene.toml", self.visitor.to_scene().to_toml().encode())

    def send(self, name: str, content: bytes) -> None:
        self.visitor.client.send_file_download(name, content, save_immediately=True)

    def load(self, file: Any) -> None:
        """Show the scene of a file: its name, and its contents from line 2 on; none if invalid."""
        name, _, content = str(file).partition("\n")
        with self.visitor.reporting("The scene was not loaded"):
            scene = within_limits(Scene.from_bytes(content.encode(errors="replace"), name))
            self.visitor.background.submit(partial(self.visitor.load, scene, opened=scene))

    def start(self, suffix: Any) -> None:
        """Export the scene, in place of the visitor's running export."""
        if suffix not in tuple(KINDS):
            return
        size = {"width": 480, "height": 270} if suffix == ".gif" else {}  # the largest files
        periods = FILM_LENGTHS[self.visitor.state.film_length]
        film = {"periods": periods, **size} if suffix in FORMATS else None
        with self.visitor.reporting("Nothing to export"):
            file = File(self.visitor.to_scene(), f"beam{suffix}", film)
            self.job.withdraw()
            self.job.request(file)

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
        file, error, reason = answer.request, answer.error, answer.message
        if answer.result is not None:
            self.send(file.name, answer.result)
        if error is None or isinstance(error, Cancelled):
            self.page.say(f"{file.name}: {'cancelled' if error else 'done'}")
            return
        if isinstance(error, NoEquilibrium):
            reason = error_summary(error, file.scene.beam)
        known = isinstance(error, InvalidInput | NoEquilibrium)
        self.page.say(f"{'Nothing to export' if known else 'The export failed'}: {reason}", True)


def export_tab() -> str:
    """Buttons for all file formats, and for scene files."""
    length = page.select("film_length", "length of a film", tuple(FILM_LENGTHS))
    files = ""
    for suffix, (name, text) in KINDS.items():
        export_button = page.button(name, data_do="export", data_value=suffix)
        files += f'<div class="file">{export_button}<span class="soft">{escape(text)}</span></div>'
    return (
        f'<div class="files"><div class="file">{page.button("Picture (PNG)", id="save-picture")}'
        f'<span class="soft">The scene as you see it</span></div>{files}'
        f'<div class="file">{page.button("Save the scene", data_do="save")}'
        '<span class="soft">All settings, as a small text file (TOML)</span></div>'
        '<div class="file"><label class="button" for="scene-file">Load a scene</label>'
        '<input type="file" id="scene-file" class="hidden" accept=".toml">'
        '<span class="soft">A file from Save the scene</span></div>'
        f'<div class="file">{length}</div></div>'
        '<div id="export-work" class="row" hidden><span id="export-state"></span>'
        '<progress id="export-progress" aria-label="Progress of the export"></progress>'
        f"{page.button('Cancel', data_do='cancel_export')}</div>"
    )
