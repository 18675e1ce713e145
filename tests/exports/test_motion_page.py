"""The exported page of a motion in time: what it holds, and that it plays from the disk."""

import base64
import json
import re
import zlib
from pathlib import Path

import numpy as np
import pytest
from live.browser import Page, by_id, page

from beamviz import Beam, Ramp, motion
from beamviz.drawing.scene_graph import SceneGraph
from beamviz.dynamics import Motion
from beamviz.explorer.features.real_beam import PRESETS
from beamviz.exports.motion_files import export_motion
from beamviz.exports.motion_page import LONGEST, motion_page
from beamviz.exports.motion_scene import MotionScene
from beamviz.scene import ViewOptions

BEAM = Beam(alpha=1, beta=0.5)
DROPPED = 1.5


@pytest.fixture(scope="module")
def moved() -> Motion:
    """A beam that is let go and spun up, and loses its mass."""
    return motion(BEAM, 3, speed=Ramp(4, 2), release=1, drop=DROPPED, tolerance=1e-3)


@pytest.fixture(scope="module")
def document(tmp_path_factory, moved) -> Path:
    path = tmp_path_factory.mktemp("pages") / "motion.html"
    export_motion(path, moved)
    return path


def data_of(document: Path) -> dict:
    """What the script of a page plays."""
    (found,) = re.findall(
        '<script type="text/plain" id="motion">(.*?)</script>', document.read_text()
    )
    return json.loads(zlib.decompress(base64.b64decode(found)))


def test_it_needs_nothing_but_itself(document):
    """In less than 3 MB, with the words, the chart and the numbers; nothing is loaded."""
    text = document.read_text()
    panel = text[text.index("<aside") :]
    assert document.stat().st_size < 3e6
    for words in ("let go", "dropped at 1.5", "<svg", "gamma", 'id="marker"'):
        assert words in panel
    assert not re.findall(r'<(?:script|link|img|iframe)[^>]+(?:src|href)="(?!data:)', text)


def test_a_real_beam_is_described_in_its_units():
    """In its heading and its words; the error of the tip too."""
    arm = PRESETS["spin-up arm"].beam.replace(alpha=1)
    panel = motion_page(motion(arm, 1, release=0.5, drop=0.5, tolerance=1e-3)).partition("<aside")[
        2
    ]
    words = panel[: panel.index("<svg")]
    assert "<h1>mass 12 kg, position 10 m, speed 57.2958 rpm, hub 0 m" in words
    assert f"a force of {0.5 * arm.units.force:.0f} N at the tip" in words
    assert f"dropped at {500 * arm.units.time:.0f} ms" in words
    assert not re.search(r"E I|\d L\b|T\*", words)
    assert re.search(r"The tip is known to \d+(\.\d+)? (mm|µm)\.", panel)


def test_it_holds_the_motion(document, moved):
    """The axis of the beam at every instant as a sum of few shapes, to 2e-4 L in the mean and 5e-3
    where fast vibrations are; and the tip to its digits."""
    data = data_of(document)
    (beam,) = data["beams"]
    fields, parts = (
        data["resolution"] * np.cumsum(np.cumsum(beam[name], axis=1), axis=1)
        for name in ("fields", "parts")
    )
    t = np.array(data["readings"][0]["values"])
    assert (t[0], t[-1]) == (0, 3)
    assert len(t) >= len(moved.t)
    axis = (fields[0] + parts.T @ fields[1:]).reshape(len(t), -1, 4)
    x = fields[0].reshape(-1, 4)[:, 0]  # of the unloaded beam: its stations
    position = moved.position(t, np.clip(x, 0, 1))
    off = axis[..., :2] - position
    assert np.sqrt((off**2).mean()) < 3e-4
    assert abs(off).max() < 5e-3
    assert data["readings"][1]["values"] == pytest.approx(position[:, -1, 1])
    there = np.array(data["with_mass"])
    assert there.tolist() == (t < DROPPED).tolist()
    assert data["until"] / data["rate"] <= LONGEST


@pytest.mark.parametrize(
    ("events", "moments"),
    [
        ({}, {0.0: True, 3.0: True}),
        ({"catch": 1.0}, {0.5: False, 1.0: True, 2.0: True}),
        ({"drop": 1.0}, {0.5: True, 1.0: False}),
        ({"catch": 1.0, "drop": 2.0}, {0.5: False, 1.5: True, 2.5: False}),
        ({"drop": 1.0, "catch": 2.0}, {0.5: True, 1.5: False, 2.5: True}),
    ],
)
def test_when_the_mass_is_there(events, moments):
    found = motion(Beam(alpha=1, gamma=1), 3, tolerance=1e-2, points=3, **events)
    assert {t: found.has_mass(t) for t in moments} == moments


def test_a_film_has_the_mass_and_the_speed_of_its_moment(moved):
    """The mass until it is dropped, the speed by the arrow, and the tip where the motion has it."""
    scene = MotionScene(moved)
    beams = scene.draw(SceneGraph())
    for t in (0.5, 2.5, 1.0):  # a film may be drawn in any order
        scene.move(beams, t)
        (row,) = beams.rows
        assert bool(row.bodies.shown) is (t < DROPPED)
        gamma = float(np.interp(t, moved.t, moved.gamma))
        assert any(f"= {gamma:.4g}" in caption.text for caption in beams.captions)
        (tip,) = moved.position([t], [1.0])[:, 0]
        assert row.line[-1, :2] == pytest.approx(tip, abs=5e-3)  # a sum of few shapes


def test_a_page_of_a_dark_page_is_dark(document):
    still = motion(BEAM, 0.1, points=3, tolerance=1e-2)
    assert "color-scheme: dark" in motion_page(still, view=ViewOptions(dark=True))
    assert "color-scheme: light" in document.read_text()


def tip_of(shown: Page) -> float:
    """The deflection of the tip that a page tells."""
    return float(shown.evaluate(f"{by_id('reading-1')}.innerText"))


def test_it_plays_from_the_disk_without_a_network(document, moved):
    """It plays by itself, pauses, and shows any moment: its numbers, its place in the chart, and
    the beam with or without the mass. Without complaints of the page."""
    with page("about:blank", 900, 600) as shown:
        shown.call("Network.enable")
        none = dict.fromkeys(("latency", "downloadThroughput", "uploadThroughput"), 0)
        shown.call("Network.emulateNetworkConditions", offline=True, **none)
        shown.call("Page.navigate", url=document.as_uri())
        slider, mass = (
            by_id("time"),
            "window.__viserMutable?.nodeRefFromName?.['/scene/rotor/mass']",
        )
        playing = f"(v => v > 0.02 && v < 1)(+{slider}.value)"  # 50 before the script has run
        shown.wait(f"{mass} && {playing}", 120)
        shown.click(by_id("play"), until=f"{by_id('play')}.innerText === 'Play'")
        stopped = float(shown.evaluate(f"+{slider}.value"))
        shown.next_frame(5)
        assert float(shown.evaluate(f"+{slider}.value")) == stopped
        steps = len(data_of(document)["readings"][0]["values"]) - 1
        for about, there in ((0.25, True), (0.75, False)):
            share = (round(about * steps) + 0.5) / steps  # between two samples
            shown.evaluate(f"{slider}.value = {share}; {slider}.dispatchEvent(new Event('input'))")
            shown.wait(f"{mass}.visible === {json.dumps(there)}")
            (tip,) = moved.position([3 * share], [1.0])[:, 0, 1]
            # Linear between the samples, and rounded.
            assert tip_of(shown) == pytest.approx(tip, abs=2e-3)
            left = f"{by_id('marker')}.getBoundingClientRect().left"
            frame = f"{by_id('patch_2')}.getBoundingClientRect()"
            place = shown.evaluate(f"({left} - {frame}.left) / {frame}.width")
            assert place == pytest.approx(share, abs=0.02)
        beam = "window.__viserMutable.nodeRefFromName['/scene/rotor/beam']"
        last = f"""(() => {{ let mesh; {beam}.traverse(n => {{
            const data = n.matricesTexture?._data;
            if (data && Math.hypot(...data.slice(4, 7)) > 1e-5) mesh = data; }});
          return mesh && Array.from(mesh.slice(0, 16)).join(); }})()"""
        before = shown.wait(last)
        shown.click(by_id("play"), until=f"{by_id('play')}.innerText === 'Pause'")
        shown.wait(f"{last} !== {before!r}")
        assert shown.problems == []


@pytest.mark.slow
def test_reduced_motion_begins_paused(document):
    """At the start, until it is played."""
    with page("about:blank", 900, 600) as shown:
        still = [{"name": "prefers-reduced-motion", "value": "reduce"}]
        shown.call("Emulation.setEmulatedMedia", features=still)
        shown.call("Page.navigate", url=document.as_uri())
        shown.wait(f"{by_id('play')}?.innerText === 'Play'", 120)
        shown.next_frame(5)
        assert float(shown.evaluate(f"+{by_id('time')}.value")) == 0
        assert shown.problems == []
