"""Live pages in the cells of a notebook, and the notebook of the project, in a real kernel."""

import base64
import io
import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from live import server
from live.browser import READY, by_id, frame, page, says
from live.notebook import Kernel, frame_address, kernel, markup, texts
from PIL import Image

NOTEBOOK = Path(__file__).parents[1] / "assets" / "notebook.ipynb"
CELLS = [c for c in json.loads(NOTEBOOK.read_text())["cells"] if c["cell_type"] == "code"]


@pytest.fixture(scope="module")
def running(tmp_path_factory) -> Iterator[Kernel]:
    """A kernel for all tests of this file, which has imported beamviz."""
    with kernel(tmp_path_factory.mktemp("kernel")) as started:
        started.run("import beamviz\nfrom beamviz import Beam")
        yield started


@pytest.mark.slow
def test_two_pages_are_shown_read_moved_and_closed(running):
    """Each in the frame of its cell, in a page of another site. What its visitor does is read in
    Python, which moves the page; the other page stays. A frame that is opened again, also after all
    have left, shows what was left."""
    first = markup(running.run("view = beamviz.show(Beam(alpha=1, beta=0.5, gamma=5), height=200)"))
    solved = "other = beamviz.solve(Beam(gamma=2), coriolis=True).show(height=200)"
    second = markup(running.run(solved))
    url, another = frame_address(first), frame_address(second)
    gamma = by_id("gamma-field")
    with server.website(first + second) as site, page(site, 500, 460) as notebook:
        with frame(url) as shown, frame(another) as beside:
            shown.wait(f"{READY} && {gamma}.value === '5'")
            beside.wait(f"{READY} && {gamma}.value === '2'")
            shown.send("gamma", 12.5, until="location.search.includes('gamma=12.5')")
            assert running.printed("view.scene.beam.gamma") == "12.5"
            assert running.printed("other.scene.beam.gamma, other.scene.options['coriolis']") == (
                "2.0 True"
            )
            running.run("view.scene = view.scene.changed(gamma=3, mode=1, dark=True)")
            shown.wait(
                f"{gamma}.value === '3' && document.documentElement.dataset.theme === 'dark'"
            )
            assert running.printed("view.scene.beam.gamma, view.scene.view.shares") == "3.0 (1.0,)"
            assert beside.evaluate(f"{gamma}.value") == "2"
            shown.send("undo", None, until=f"{gamma}.value === '12.5'")
            assert not shown.problems + beside.problems
        notebook.call("Page.reload")
        with frame(url) as shown:
            shown.wait(f"{READY} && {gamma}.value === '12.5'")
            running.run("view.close()")
            shown.wait(says("connect"))
    port = int(url.split(":")[2].split("/")[0])
    with pytest.raises(ConnectionRefusedError):
        server.http_get(f"http://127.0.0.1:{port}")
    assert running.printed("view.scene.beam.gamma") == "12.5"
    assert server.http_get(another, path_of(another))[0] == 200


def path_of(url: str) -> str:
    return f"/{url.split('/', 3)[3]}"


def pictures(cell) -> list[bytes]:
    """The PNG files among the outputs of a cell."""
    data = (output.get("data", {}) for output in cell["outputs"])
    return [base64.b64decode(one["image/png"]) for one in data if "image/png" in one]


@pytest.mark.slow
def test_the_outputs_are_those_of_the_code(running):
    """Cell by cell: the text is the same, and each figure and each live page has a picture."""
    drawn = frames = 0
    for cell in CELLS:
        outputs = running.run("".join(cell["source"]))
        assert texts(outputs) == texts(cell["outputs"])
        frames += bool(frame_address(markup(outputs)))
        drawn += len(pictures({"outputs": outputs}))
        shown = [output for output in outputs if output["output_type"] == "display_data"]
        assert len(shown) == len(pictures(cell))
    assert (drawn, frames) == (4, 1)
    assert not list(running.folder.glob("*"))


def test_it_is_short_and_small():
    """At most 25 lines of code; pictures that can be seen, below 300 kB together."""
    lines = "".join("".join(cell["source"]) + "\n" for cell in CELLS).splitlines()
    assert sum(bool(line.strip()) for line in lines) <= 25
    files = [file for cell in CELLS for file in pictures(cell)]
    assert sum(map(len, files)) < 300_000
    for file in files:
        assert len(Image.open(io.BytesIO(file)).convert("RGB").getcolors(10**6)) > 9
