"""Live pages in the cells of a notebook, and the notebook of the project, in a real kernel."""

import base64
import contextlib
import io
import json
import webbrowser
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from live import server
from live.browser import READY, by_id, frame, page, says
from live.notebook import Kernel, frame_address, kernel, markup, texts
from live.visitor import PAPER, visitor
from PIL import Image

import beamviz
from beamviz import InvalidInput, Scene, Unavailable, View, notebook, solve

NOTEBOOK = Path(__file__).parents[1] / "assets" / "notebook.ipynb"
CELLS = [c for c in json.loads(NOTEBOOK.read_text())["cells"] if c["cell_type"] == "code"]


@pytest.fixture(scope="module")
def end_of_kernel() -> Iterator[contextlib.ExitStack]:
    """What ends the kernel of this file when it is closed."""
    with contextlib.ExitStack() as end:
        yield end


@pytest.fixture(scope="module")
def running(tmp_path_factory, end_of_kernel) -> Kernel:
    """A kernel for all tests of this file, which has imported beamviz."""
    started = end_of_kernel.enter_context(kernel(tmp_path_factory.mktemp("kernel")))
    started.run("import beamviz\nfrom beamviz import Beam")
    return started


@pytest.fixture
def opened(monkeypatch) -> Iterator[list[str]]:
    """The addresses that a browser was told to open; the pages are closed at last."""
    addresses, views = list[str](), list[View]()

    class Watched(View):
        def __init__(self, *given: Any):
            super().__init__(*given)
            views.append(self)

    monkeypatch.setattr(notebook, "View", Watched)
    monkeypatch.setattr(webbrowser, "open", addresses.append)
    yield addresses
    for view in views:
        view.close()


def test_outside_a_notebook_the_browser_opens_the_page(opened, capsys):
    """Of a solution with its model, of a beam, of a scene; nothing is printed. Each has an address
    of its own, which its view shows."""
    solution = solve(PAPER, coriolis=True, method="ancf", elements=8, modes=3)
    scene = Scene.of(PAPER, mode=3, dark=True)
    views = [solution.show(), beamviz.show(PAPER), beamviz.show(scene), beamviz.show()]
    assert opened == [view.url for view in views]
    assert len({*opened}) == 4
    solved = views[0].scene
    assert solved.beam == PAPER
    assert {name: solved.options[name] for name in ("method", "coriolis", "elements")} == {
        "method": "ancf",
        "coriolis": True,
        "elements": 8,
    }
    assert [view.scene for view in views[1:]] == [Scene(PAPER), scene, Scene()]
    assert [view.url in repr(view) for view in views] == [True] * 4
    assert capsys.readouterr() == ("", "")


def test_the_scene_follows_the_visitor_and_moves_the_page(opened):
    """Also before the page is open, and after it was left, when a page that is opened again shows
    what was left, or what was set since."""
    view = beamviz.show(PAPER)
    view.scene = PAPER.replace(gamma=6)
    with visitor(view.url) as guest:
        guest.shows(PAPER.replace(gamma=6))
        guest.edit(gamma=7, coriolis=True)
        assert (view.scene.beam.gamma, view.scene.options["coriolis"]) == (7, True)
        view.scene = solve(PAPER.replace(gamma=8))
        guest.shows(PAPER.replace(gamma=8))
        guest.do("undo")
        guest.shows(PAPER.replace(gamma=7), coriolis=True)
        guest.set(gamma=1e9)
        server.wait_until(lambda: is_refused(view))
        guest.set(gamma=9)
        guest.shows(PAPER.replace(gamma=9), coriolis=True)
    assert view.scene.beam.gamma == 9
    with visitor(view.url) as guest:
        guest.shows(PAPER.replace(gamma=9), coriolis=True)
    view.scene = PAPER.replace(gamma=3)
    assert view.scene == Scene(PAPER.replace(gamma=3))
    with visitor(view.url) as guest:
        guest.shows(PAPER.replace(gamma=3))


def is_refused(view: View) -> bool:
    """Whether the page has a number out of range, which is named."""
    try:
        return view.scene is None
    except InvalidInput as error:
        return str(error).startswith("gamma = 1000000000: must")


def test_what_cannot_be_shown_is_named(opened):
    """Without a server that is left behind, or a scene that is lost."""
    refused = {
        "a Beam, a Scene or a Solution": lambda: beamviz.show(3),  # type: ignore[arg-type]
        "height = 1: must": lambda: beamviz.show(PAPER, height=1),
        "public_url = x: must": lambda: beamviz.show(PAPER, public_url="x"),
        "no bent states": lambda: beamviz.show(Scene.of(PAPER, method="linear", state="bent")),
    }
    for words, show in refused.items():
        with pytest.raises(InvalidInput, match=words):
            show()
    view = beamviz.show(PAPER)
    assert opened == [view.url]
    with pytest.raises(InvalidInput, match="Scene"):
        view.scene = "a beam"
    view.close()
    view.close()
    assert view.scene == Scene(PAPER)
    with pytest.raises(Unavailable, match="closed"):
        view.scene = PAPER


@pytest.mark.slow
def test_the_outputs_are_those_of_the_code(running):
    """Cell by cell: the text is the same, and each figure and each live page has a picture. The
    first test of the kernel: no page of it is closed meanwhile."""
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


@pytest.mark.slow
def test_two_pages_are_shown_read_moved_and_closed(running):
    """Each in the frame of its cell, in a page of another site. What its visitor does is read in
    Python, which moves the page; the other page stays. Opened again, a page shows what was left."""
    first = markup(running.run("view = beamviz.show(Beam(alpha=1, beta=0.5, gamma=5), height=200)"))
    solved = "other = beamviz.solve(Beam(gamma=2), coriolis=True).show(height=200)"
    second = markup(running.run(solved))
    url, another = frame_address(first), frame_address(second)
    gamma = by_id("gamma-field")
    with (
        server.website(first + second) as site,
        page(site, 500, 460),
        frame(url) as shown,
        frame(another) as beside,
    ):
        shown.wait(f"{READY} && {gamma}.value === '5'")
        beside.wait(f"{READY} && {gamma}.value === '2'")
        shown.send("gamma", 12.5, until="location.search.includes('gamma=12.5')")
        assert running.printed("view.scene.beam.gamma") == "12.5"
        assert running.printed("other.scene.beam.gamma, other.scene.options['coriolis']") == (
            "2.0 True"
        )
        running.run("view.scene = view.scene.changed(gamma=3, mode=1, dark=True)")
        shown.wait(f"{gamma}.value === '3' && document.documentElement.dataset.theme === 'dark'")
        assert running.printed("view.scene.beam.gamma, view.scene.view.shares") == "3.0 (1.0,)"
        assert beside.evaluate(f"{gamma}.value") == "2"
        shown.send("undo", None, until=f"{gamma}.value === '12.5'")
        assert not shown.problems + beside.problems
    with page(url) as shown:
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
def test_a_page_ends_with_its_kernel_and_says_what_to_do(running, end_of_kernel):
    """As with a process that is killed, its port is free again. It is said in the frame that is
    open; and above the frame where the notebook is opened again, which says nothing of it while the
    kernel runs. The last test of the kernel."""
    told = "!!document.querySelector('object p').getClientRects().length"
    shown = markup(running.run("beamviz.show(height=300);"))
    url = frame_address(shown)
    with (
        server.website(f"<!doctype html>{shown}") as site,
        page(site, 600, 400) as opened,
        frame(url) as inside,
    ):
        inside.wait(READY)
        assert 'height="300"' in shown
        assert server.http_get(url, path_of(url))[0] == 200
        assert not inside.evaluate(says("run the cell again"))
        assert not opened.evaluate(told)
        end_of_kernel.close()
        with pytest.raises(ConnectionRefusedError):
            server.http_get(url, path_of(url))
        inside.wait(says("run the cell again"))
        opened.reload()
        opened.wait(told)


def test_its_pictures_are_small_and_not_blank():
    """Below 300 kB together."""
    files = [file for cell in CELLS for file in pictures(cell)]
    assert sum(map(len, files)) < 300_000
    for file in files:
        assert len(Image.open(io.BytesIO(file)).convert("RGB").getcolors(10**6)) > 9
