"""`beamviz serve` as a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent


class Explorer:
    """A running `beamviz serve`: its process, its URL, its folder for temporary files."""

    def __init__(self, folder: Path, *options: str, processes: int = 2):
        self.folder, self.processes = folder, processes
        command = ["serve", "--alpha", "1", "--beta", "0.5", "--gamma", "10", *options]
        self.process = subprocess.Popen(
            [sys.executable, "-m", "beamviz", *command, "--processes", str(processes)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": str(ROOT), "TMPDIR": str(folder)},
        )

    def __enter__(self) -> "Explorer":
        assert self.process.stdout
        line = self.process.stdout.readline()
        self.url = next(word for word in line.split() if word.startswith("http"))
        return self

    def __exit__(self, *_: object) -> None:
        with self.process:
            self.process.terminate()

    @property
    def workers(self) -> list[int]:
        """The processes it has started."""
        return children(self.process.pid)

    def end(self, number: int) -> tuple[int, str]:
        """Exit code and stderr after a signal."""
        self.process.send_signal(number)
        _, errors = self.process.communicate(timeout=20)
        return self.process.returncode, errors


def children(parent: int) -> list[int]:
    """The processes that one has started."""
    return [int(pid) for pid in Path(f"/proc/{parent}/task/{parent}/children").read_text().split()]
