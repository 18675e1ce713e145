"""Exports for visitors in the background: films in one queue, other files in another."""

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
    """The status of an export. ahead: number of exports before it in the queue; done: rendered
    fraction of a film; seconds: estimated time [s] for the rest; message: of its failure."""

    state: Literal["waiting", "working", "done", "failed", "cancelled"]
    ahead: int = 0
    done: float = 0.0
    seconds: float = 0.0
    message: str = ""

    @property
    def text(self) -> str:
        """The status as text."""
        if self.state == "waiting":
            return f"waits for {self.ahead} other{'s' if self.ahead > 1 else ''}"
        if self.state == "working" and self.done:
            return f"{100 * self.done:.0f} %, {self.seconds:.0f} s left"
        return self.message or self.state


class ExportJob:
    """The export of a scene to a file with a suffix.

    report: called with the job at each change of `status`, from the thread of the export; options:
    keywords of `animate`; content: the bytes of the file once the state is "done".
    """

    def __init__(
        self, scene: Scene, suffix: str, report: Callable[["ExportJob"], None], **options: Any
    ):
        self.scene, self.suffix, self.report, self.options = scene, suffix, report, options
        self.status, self.content = Status("waiting"), b""
        self.stopped = threading.Event()

    def start(self) -> None:
        """Add the export to its queue, which all visitors share."""
        QUEUES[self.suffix in FORMATS].add(self)

    def cancel(self) -> None:
        """Stop the export and discard what it has written."""
        self.stopped.set()

    def show(self, status: Status) -> None:
        """Set and report the status."""
        self.status = status
        self.report(self)

    def run(self) -> None:
        """Write the file and report the outcome."""
        try:
            next(self.frames(1))
            self.show(Status("working"))
            self.content = self.exported()
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
        except Exception as error:  # which must not end the visitor's session
            log.error("file", self.suffix, error)
            message = "The export failed: an unexpected error, which the server has logged"
            status = Status("failed", message=message)
        self.show(status)

    def exported(self) -> bytes:
        """The content of the file."""
        with tempfile.TemporaryDirectory(prefix="beamviz-") as folder:
            path = Path(folder) / f"beam{self.suffix}"
            if self.suffix in FORMATS:  # one thread, so that pages stay responsive
                options = {"progress": self.frames, "workers": 1, **self.options}
                animate(path, self.scene, **options)
            else:
                export(path, self.scene)
            return path.read_bytes()

    def frames(self, count: int) -> Iterator[int]:
        """The numbers of the frames of a film, reporting progress. Raises Cancelled."""
        start = time.monotonic()
        for k in range(count):
            if self.stopped.is_set():
                raise Cancelled
            if k:
                left = (time.monotonic() - start) * (count - k) / k
                self.show(Status("working", done=k / count, seconds=left))
            yield k


class ExportQueue:
    """Runs exports in one thread, in order of submission."""

    def __init__(self) -> None:
        self.jobs: list[ExportJob] = []
        self.lock, self.pool = threading.Lock(), ThreadPoolExecutor(1, "export")

    def add(self, job: ExportJob) -> None:
        """Run a job after those before it."""
        with self.lock:
            self.jobs.append(job)
            ahead = len(self.jobs) - 1
        if ahead:
            job.show(Status("waiting", ahead))
        self.pool.submit(self.run, job)

    def run(self, job: ExportJob) -> None:
        """Run a job, then update the status of the others."""
        try:
            job.run()
        finally:
            with self.lock:
                self.jobs.remove(job)
                waiting = list(enumerate(self.jobs))[1:]
            for ahead, other in waiting:
                other.show(Status("waiting", ahead))


QUEUES = {films: ExportQueue() for films in (False, True)}
