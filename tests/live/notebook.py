"""A real Jupyter kernel, whose cells show live pages."""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import nbformat
from live.server import ROOT
from nbclient import NotebookClient

DIRECTORIES = ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR", "IPYTHONDIR")


def jupyter_environment(folder: Path) -> dict[str, str]:
    """Environment variables of a Jupyter program without the settings of the user, that finds this
    beamviz."""
    return {**os.environ, **dict.fromkeys(DIRECTORIES, str(folder)), "PYTHONPATH": str(ROOT)}


class Kernel:
    """A running kernel; `run` runs a cell in it."""

    def __init__(self, client: NotebookClient):
        self.client = client

    def run(self, code: str) -> list[dict[str, Any]]:
        """The outputs of a cell with this code. Raises CellExecutionError."""
        cells = self.client.nb.cells
        cells.append(nbformat.v4.new_code_cell(code))
        return self.client.execute_cell(cells[-1], len(cells) - 1).outputs

    def printed(self, expression: str) -> str:
        """What printing an expression prints."""
        return texts(self.run(f"print({expression})")).rstrip("\n")


def texts(outputs: list[dict[str, Any]]) -> str:
    """The printed text among the outputs of a cell."""
    return "".join(output.get("text", "") for output in outputs)


def markup(outputs: list[dict[str, Any]]) -> str:
    """The HTML among the outputs of a cell."""
    return "".join(output.get("data", {}).get("text/html", "") for output in outputs)


@contextlib.contextmanager
def kernel(folder: Path) -> Iterator[Kernel]:
    """A new kernel that works in a folder, ended at last."""
    client = NotebookClient(
        nbformat.v4.new_notebook(), resources={"metadata": {"path": str(folder)}}, timeout=300
    )
    with client.setup_kernel(env=jupyter_environment(folder), cwd=str(folder)):
        yield Kernel(client)
