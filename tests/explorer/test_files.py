"""Saving and loading a scene, and exports; and what is refused of them."""

import base64
import io
import json
import re
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from live.browser import READY, page, says
from live.server import last_until
from live.visitor import Visitor, catch_up, visitor
from PIL import Image, ImageSequence

from beamviz.beam import Beam
from beamviz.explorer import veering_files
from beamviz.explorer.features import files
from beamviz.explorer.features.loci_chart import CHART_KINDS
from beamviz.exports import animate
from beamviz.exports.solved_scene import Loop
from beamviz.input_files import MAX_TOML_BYTES
from beamviz.scene import Camera, Scene, Second
from beamviz.units import Units

FIRST = Scene.of(
    Beam(alpha=1, beta=0.5, gamma=10), mode=3, dark=True, over="mu", position=(1.0, -4.0, 2.0)
)
SLOW = Scene.of(method="linear", elements=1000).to_toml()  # which the command line takes


@pytest.fixture
def guest(connected) -> Any:
    """A visitor with a connection."""
    return connected


def small_film(path: Path, scene: Scene, **options: Any) -> Loop:
    """`animate` with few small frames."""
    return animate(path, scene, **options | {"width": 96, "height": 64, "fps": 5})


def upload(guest: Visitor, text: str) -> None:
    """Load a scene file, as a page does."""
    guest.do("load", f"scene.toml\n{text}")


def saved(guest: Visitor) -> Scene:
    """The scene of the file that the visitor gets."""
    guest.do("save")
    (part,) = heard(guest, "FileTransferPart")
    return Scene.from_bytes(part["content"], "saved")


def heard(guest: Visitor, *kinds: str) -> list[dict[str, Any]]:
    """Wait for the first message of each kind."""
    found: list[dict[str, Any]] = []
    guest.wait(lambda new: found.extend(new) or {*kinds} <= {one["type"] for one in found}, 180)
    return [next(one for one in found if one["type"] == kind) for kind in kinds]


def test_a_loaded_scene_is_shown(guest):
    """With its units, model, view and camera; saved it is equal, and later has present values."""
    beam = Beam(alpha=2, gamma=5, units=Units(length=1.0, time=0.01))
    changes = {"coriolis": True, "shares": [0.5, *5 * [0.0], 1.0], "over": "delta"}
    wanted = Scene(beam, camera=Camera((1.0, 2.0, 3.0))).changed(**changes, per_rev=(2, 3))
    upload(guest, wanted.to_toml())
    guest.shows(wanted.beam, **wanted.options)
    assert saved(guest) == wanted
    guest.choose("dark", True)
    guest.edit(strain="biot")
    assert saved(guest) == wanted.changed(strain="biot", dark=True)


BEGINNINGS = {".gif": b"GIF89a", ".webp": b"RIFF", ".html": b"<!", ".glb": b"glTF", ".npz": b"PK"}
BEGINNINGS |= {".csv": b"# beamviz", ".shapes.csv": b"# beamviz"}


@pytest.mark.parametrize(("kind", "begin"), BEGINNINGS.items())
def test_every_file_can_be_exported(guest, monkeypatch, kind, begin):
    """The button sends a complete file in the format of the command line."""
    monkeypatch.setattr(files, "animate", small_film)
    guest.do("export", kind)
    start, part = heard(guest, "FileTransferStartDownload", "FileTransferPart")
    assert start["filename"].startswith("beam.")
    assert part["content"][: len(begin)].lower() == begin.lower()
    if start["part_count"] == 1:
        assert len(part["content"]) == start["size_bytes"]


@pytest.mark.parametrize("kind", CHART_KINDS)
def test_the_chart_can_be_downloaded_with_the_second_beam(guest, kind):
    """As pictures and as a table, of the axis and the per-rev lines chosen."""
    guest.set(comparison="mass", over="alpha", gamma=4.0)
    guest.do("export_chart", kind)
    start, part = heard(guest, "FileTransferStartDownload", "FileTransferPart")
    assert start["filename"] == f"chart{kind}"
    if kind == ".png":
        assert part["content"].startswith(b"\x89PNG")
        return
    text = part["content"].decode()
    assert "twice the mass" in text
    assert ("mass ratio α" if kind == ".svg" else "\nalpha,B1,") in text


def test_the_opening_gap_is_a_page_that_moves_offline(guest, monkeypatch):
    """From a crossing without Coriolis forces to a veering with all of them, of two modes whose
    frequencies are those of the solver."""
    monkeypatch.setattr(veering_files, "STEPS", 2)
    guest.set(alpha=1.0, beta=1.0, gamma=4.5, coriolis=True, over="gamma")
    guest.do("tab", "veering")
    guest.says("they veer")
    guest.do("export_veering", ".html")
    start, part = heard(guest, "FileTransferStartDownload", "FileTransferPart")
    assert start["filename"] == "veering.html"
    text = part["content"].decode()
    assert "http" not in text.replace("http://www.w3.org", "")
    frames = json.loads(re.search(r"const frames = (.*);", text)[1])
    assert [told.partition(": ")[0] for told, _ in frames] == [
        "without Coriolis forces",
        "50 % of Coriolis",
        "with Coriolis forces",
    ]
    assert "they cross at γ = 4.4641" in frames[0][0]
    assert "gap 0.241" in frames[2][0]
    drawings = [base64.b64decode(source) for _, source in frames]
    assert all(b"<svg" in drawing for drawing in drawings)
    assert len({*drawings}) == 3


@pytest.mark.slow
def test_the_opening_gap_is_a_film(guest):
    """It begins and ends without the coupling, and has all of it in the middle."""
    guest.set(alpha=1.0, beta=1.0, gamma=4.5, coriolis=True, over="gamma")
    guest.do("tab", "veering")
    guest.says("they veer")
    guest.do("export_veering", ".webp")
    start, part = heard(guest, "FileTransferStartDownload", "FileTransferPart")
    assert start["filename"] == "veering.webp"
    with Image.open(io.BytesIO(part["content"])) as film:
        first, *others = (frame.convert("L") for frame in ImageSequence.Iterator(film))
        changes = [np.abs(np.subtract(frame, first, dtype=int)).mean() for frame in others]
    assert 0.4 < np.argmax(changes) / len(changes) < 0.8
    assert max(changes[0], changes[-1]) < 0.8 * max(changes)


def test_an_export_has_the_second_beam(guest):
    """The beam that the page shows beside the first, in a page and in a scene file."""
    guest.set(comparison="mass", stacked=True)
    guest.says("twice the mass")
    assert saved(guest).second == Second(
        FIRST.beam.replace(alpha=2), {}, "twice the mass", True, "mass"
    )
    guest.do("export", ".html")
    (part,) = heard(guest, "FileTransferPart")
    assert "twice the mass" in part["content"].decode(errors="replace")


@pytest.mark.slow
def test_a_film_has_the_length_chosen_and_needs_motion(guest, monkeypatch):
    """Two periods have more frames than one. The message on a film without motion says so."""
    monkeypatch.setattr(files, "animate", small_film)
    frames = []
    for length in ("1 period", "2 periods"):
        guest.choose("film_length", length)
        guest.do("export", ".webp")
        (part,) = heard(guest, "FileTransferPart")
        frames.append(Image.open(io.BytesIO(part["content"])).n_frames)
    assert frames[1] > 1.5 * frames[0]
    still = Scene.of(shares=[0.0])
    upload(guest, still.to_toml())
    guest.shows(still.beam)
    guest.do("export", ".gif")
    guest.wait(lambda _: any("nothing moves" in one["text"] for one in guest.said))


def test_films_wait_for_each_other_and_tables_for_none(url, guest, monkeypatch):
    """A film shows its progress, and a button that cancels it. A second film waits for one other, a
    table for none; the cancelled film sends nothing, and the second one is sent then."""

    def film(path: Path, scene: Scene, **options: Any) -> Loop:
        return (animate if path.suffix == ".gif" else small_film)(path, scene, **options)

    monkeypatch.setattr(files, "animate", film)
    guest.do("export", ".gif", until=lambda _: guest.props["export-progress"].get("value"))
    assert " s left" in guest.texts["export-state"]
    assert guest.props["export-work"]["hidden"] is False
    with visitor(url) as second, visitor(url) as third:
        second.do("export", ".webp", until="waits for 1 other")
        third.do("export", ".csv")
        assert heard(third, "FileTransferPart")[0]["content"].startswith(b"# beamviz")
        guest.do("cancel_export", until=lambda _: guest.props["export-work"]["hidden"])
        assert heard(second, "FileTransferPart")[0]["content"][8:12] == b"WEBP"
        second.wait(lambda _: second.said and second.props["export-work"]["hidden"])
    assert guest.said == [{"text": "beam.gif: cancelled", "error": False}]
    assert not any(files.QUEUES.values())


def test_files_wait_for_the_one_that_is_written(guest, monkeypatch):
    """None is lost by the next one, nor begun again by a second click; one that is cancelled makes
    room for them."""
    release = threading.Event()
    last = {name: lambda *given, **options: last_until(release) for name in ("animate", "export")}
    for name, content in last.items():
        monkeypatch.setattr(files, name, content)
    guest.do("export", ".gif", until="beam.gif: working")
    for kind in (".gif", ".csv", ".webp", ".csv"):
        guest.do("export", kind)
    catch_up(guest)
    for name in ("gif", "webp", "csv"):
        guest.wait(lambda _, name=name: f"beam.{name}: working" in guest.texts["export-state"])
        guest.do("cancel_export")
    guest.wait(lambda _: guest.props["export-work"]["hidden"])
    release.set()
    told = [one["text"] for one in guest.said]
    assert told == [f"beam.{name}: cancelled" for name in ("gif", "webp", "csv")]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("[beam]\nalpha = -1\n", "scene.toml: alpha = −1: must lie in 0 .. 100"),
        ('"' * (MAX_TOML_BYTES + 1), "scene.toml: larger than 64000 bytes"),
        (SLOW, "elements = 1000: a page solves with at most 200"),
    ],
    ids=["no beam", "too large", "too slow"],
)
def test_an_invalid_file_changes_nothing(guest, text, reason):
    """The visitor reads why; the scene is unchanged."""
    upload(guest, text)
    guest.wait(lambda _: guest.said)
    assert reason in guest.said[-1]["text"]
    assert saved(guest) == FIRST


@pytest.mark.slow
def test_a_file_chosen_in_the_page_is_loaded(url, tmp_path):
    """With characters that JSON and UTF-8 encode; one too large is named, with the limit."""
    file = tmp_path / "beam.toml"
    with page(url) as live:
        live.wait(f"{READY} && {says('1st bending')}")
        root = live.call("DOM.getDocument")["root"]["nodeId"]
        chosen = live.call("DOM.querySelector", nodeId=root, selector="#scene-file")
        for text, shown in (
            ('# "γ" \\ ω\n[beam]\ngamma = 33.125\n', "byId('gamma-field').value == 33.125"),
            ("#" * (MAX_TOML_BYTES + 1), says("beam.toml: larger than 64000 bytes")),
        ):
            file.write_text(text, encoding="utf-8")
            live.call("DOM.setFileInputFiles", files=[str(file)], **chosen)
            live.wait(shown.replace("byId", "document.getElementById"))
