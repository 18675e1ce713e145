"""Files made for visitors in the background: films one after the other, other files at once."""

import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Literal, NamedTuple

from beamviz.drawing.text import error_summary
from beamviz.errors import BeamvizError, Cancelled, InvalidInput, NoEquilibrium
from beamviz.exports import animate, export
from beamviz.exports.film import FORMATS
from beamviz.scene import Scene
from beamviz.server.log import RateLimitedLog

log = RateLimitedLog(__name__)


class Status(NamedTuple):
    """What becomes of a file. ahead: files that are made before it; done: the part of a film that
    is rendered, seconds: that the rest will take; message: why it failed."""

    state: Literal["waiting", "working", "done", "failed", "cancelled"]
    ahead: int = 0
    done: float = 0.0
    seconds: float = 0.0
    message: str = ""

    @property
    def text(self) -> str:
        """The status in words."""
        if self.state == "waiting":
            return f"waits for {self.ahead} other{'s' if self.ahead > 1 else ''}"
        if self.state == "working" and self.done:
            return f"{100 * self.done:.0f} %, {self.seconds:.0f} s left"
        return self.message or self.state


class ExportJob:
    """One file of a scene, of the kind that `suffix` names; options: of `animate`;
    report: called with the job on each change of its status, from the thread that makes the file.
    `content` is the file once its state is "done"."""

    def __init__(
        self, scene: Scene, suffix: str, report: Callable[["ExportJob"], None], **options: Any
    ):
        self.scene, self.suffix, self.report, self.options = scene, suffix, report, options
        self.status, self.content = Status("waiting"), b""
        self.stopped = threading.Event()

    def start(self) -> None:
        """Make the file in the background: films of all visitors one after the other."""
        QUEUES[self.suffix in FORMATS].add(self)

    def cancel(self) -> None:
        """Do not make the file; what has been made of it is discarded."""
        self.stopped.set()

    def show(self, status: Status) -> None:
        """Report a status."""
        self.status = status
        self.report(self)

    def run(self) -> None:
        """Make the file and report how that went."""
        try:
            next(self.frames(1))
            self.show(Status("working"))
            self.content = self.made()
            status = Status("done")
        except Cancelled:
            status = Status("cancelled")
        except InvalidInput as error:
            status = Status("failed", message=f"Nothing to export: {error}")
        except NoEquilibrium as error:
            reason = error_summary(error, self.scene.beam)
            status = Status("failed", message=f"Nothing to export: {reason}")
        except BeamvizError as error:
            status = Status("failed", message=f"The export failed: {error}")
        except Exception as error:  # a mistake of ours must not end a visitor's session
            log.error("file", self.suffix, error)
            message = "The export failed: an unexpected error, which the server has noted"
            status = Status("failed", message=message)
        self.show(status)

    def made(self) -> bytes:
        """The content of the file."""
        with tempfile.TemporaryDirectory(prefix="beamviz-") as folder:
            path = Path(folder) / f"beam{self.suffix}"
            if self.suffix in FORMATS:  # one thread: the others are for the pages
                options = {"progress": self.frames, "workers": 1, **self.options}
                animate(path, self.scene, **options)
            else:
                export(path, self.scene)
            return path.read_bytes()

    def frames(self, count: int) -> Iterator[int]:
        """The frames of a film, each reported. Raises Cancelled."""
        start = time.monotonic()
        for k in range(count):
            if self.stopped.is_set():
                raise Cancelled
            if k:
                left = (time.monotonic() - start) * (count - k) / k
                self.show(Status("working", done=k / count, seconds=left))
            yield k


class ExportQueue:
    """Makes files in one thread, in the order of their jobs."""

    def __init__(self) -> None:
        self.jobs: list[ExportJob] = []
        self.lock, self.pool = threading.Lock(), ThreadPoolExecutor(1, "export")

    def add(self, job: ExportJob) -> None:
        """Make the file of a job after those of the jobs before it."""
        with self.lock:
            self.jobs.append(job)
            ahead = len(self.jobs) - 1
        if ahead:
            job.show(Status("waiting", ahead))
        self.pool.submit(self.run, job)

    def run(self, job: ExportJob) -> None:
        """Make one file, then tell the others how many are before them."""
        try:
            job.run()
        finally:
            with self.lock:
                self.jobs.remove(job)
                waiting = list(enumerate(self.jobs))[1:]
            for ahead, other in waiting:
                other.show(Status("waiting", ahead))


QUEUES = {films: ExportQueue() for films in (False, True)}
