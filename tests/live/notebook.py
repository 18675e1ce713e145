"""A real Jupyter kernel, whose cells show live pages.

Jupyter's packages are imported where a kernel is used: they are a third of what tests import.
"""

import contextlib
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from live.server import ROOT

if TYPE_CHECKING:
    from nbclient import NotebookClient

FRAME = re.compile(r'<iframe src="([^"]+)"')
DIRECTORIES = ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR", "IPYTHONDIR")


def jupyter_environment(folder: Path) -> dict[str, str]:
    """Environment variables of a Jupyter program without the settings of the user, that finds this
    beamviz."""
    return {**os.environ, **dict.fromkeys(DIRECTORIES, str(folder)), "PYTHONPATH": str(ROOT)}


class Kernel:
    """A running kernel; `run` runs a cell in its folder."""

    def __init__(self, client: "NotebookClient", folder: Path):
        self.client, self.folder = client, folder

    def run(self, code: str) -> list[dict[str, Any]]:
        """The outputs of a cell with this code. Raises CellExecutionError."""
        import nbformat

        cells = self.client.nb.cells
        cells.append(nbformat.v4.new_code_cell(code))
        return self.client.execute_cell(cells[-1], len(cells) - 1).outputs

    def printed(self, expression: str) -> str:
        """What printing an expression prints."""
        return texts(self.run(f"print({expression})")).rstrip("\n")


def texts(outputs: list[dict[str, Any]]) -> str:
    """The printed text among the outputs of a cell."""
    return "".join("".join(output.get("text", "")) for output in outputs)


def markup(outputs: list[dict[str, Any]]) -> str:
    """The HTML among the outputs of a cell."""
    return "".join(output.get("data", {}).get("text/html", "") for output in outputs)


def frame_address(shown: str) -> str:
    """The address of the frame in the HTML of a cell; "" without one."""
    found = FRAME.search(shown)
    return found[1] if found else ""


@contextlib.contextmanager
def kernel(folder: Path) -> Iterator[Kernel]:
    """A new kernel that works in a new folder inside this one, ended at last."""
    import nbformat
    from nbclient import NotebookClient

    work = folder / "work"
    work.mkdir()
    client = NotebookClient(
        nbformat.v4.new_notebook(), resources={"metadata": {"path": str(work)}}, timeout=300
    )
    with client.setup_kernel(env=jupyter_environment(folder), cwd=str(work)):
        yield Kernel(client, work)
