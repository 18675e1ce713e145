"""The notebook runs as it stands, and shows what it prints and draws."""

import base64
import io
import json
from pathlib import Path

import matplotlib
import pytest
from matplotlib import pyplot
from PIL import Image

NOTEBOOK = Path(__file__).parents[1] / "assets" / "notebook.ipynb"
CELLS = [c for c in json.loads(NOTEBOOK.read_text())["cells"] if c["cell_type"] == "code"]


def pictures(cell):
    """The PNG files among the outputs of a cell."""
    data = (output.get("data", {}) for output in cell["outputs"])
    return [base64.b64decode(one["image/png"]) for one in data if "image/png" in one]


@pytest.mark.slow
def test_the_outputs_are_those_of_the_code(tmp_path, monkeypatch, capsys):
    """Cell by cell in one namespace: the text is the same, each figure has a picture."""
    monkeypatch.chdir(tmp_path)
    matplotlib.use("agg")
    namespace: dict[str, object] = {}
    drawn = 0
    for cell in CELLS:
        exec(compile("".join(cell["source"]), NOTEBOOK.name, "exec"), namespace)
        shown = ("".join(output.get("text", "")) for output in cell["outputs"])
        assert capsys.readouterr().out == "".join(shown)
        assert len(pyplot.get_fignums()) == len(pictures(cell))
        drawn += len(pictures(cell))
        pyplot.close("all")
    assert drawn == 4
    assert not list(tmp_path.iterdir())


def test_it_is_short_and_small():
    """At most 25 lines of code; pictures that can be seen, below 300 kB together."""
    lines = "".join("".join(cell["source"]) + "\n" for cell in CELLS).splitlines()
    assert sum(bool(line.strip()) for line in lines) <= 25
    files = [file for cell in CELLS for file in pictures(cell)]
    assert sum(map(len, files)) < 300_000
    for file in files:
        assert len(Image.open(io.BytesIO(file)).convert("RGB").getcolors(10**6)) > 9
