"""A browser without WebGL shows all of the page, and the scene in a plain canvas."""

import base64
import io
from collections.abc import Iterator

import numpy as np
import pytest
from live.axe import load_axe, violations
from live.browser import NODES, Page, by_id, page
from live.server import wait_until
from PIL import Image

from beamviz.beam import Beam
from beamviz.drawing import surroundings
from beamviz.explorer.first_picture import OpeningScene
from beamviz.exports import export
from beamviz.exports.renderer import Renderer
from beamviz.files import package_text
from beamviz.scene import Scene

NO_WEBGL = """{ const { prototype } = HTMLCanvasElement, usual = prototype.getContext;
  prototype.getContext = function (kind, ...options) {
    return /webgl/.test(kind) ? null : usual.call(this, kind, ...options); }; }"""
CANVAS = "document.querySelector('#plain-scene canvas')"
SHOWN = f"!!document.querySelector('#scene[data-ready]') && {CANVAS}.dataset.pictures > 0"
REASON = "document.querySelector('#plain-scene p')"
FIRST = Scene.of(Beam(alpha=1, beta=0.5, gamma=10), playing=False)
VISIBLE = 40  # of 255: a difference of colours; edges are not antialiased in the same way
SAME = 0.005  # of the pixels of a picture; measured: 0.0009, at edges


class WithoutShadow(Renderer):
    """The server's pictures with what the plain canvas has."""

    def shadow(self, *_: object) -> Image.Image:
        return Image.new("L", self.size)

    def captions(self, _: object) -> Image.Image:
        return Image.new("RGBA", self.size)


@pytest.fixture(scope="module")
def school(url) -> Iterator[Page]:
    """A page in a browser without WebGL, once it has drawn the scene."""
    with page(url, 1440, 900, script=NO_WEBGL) as shown:
        shown.wait(SHOWN)
        yield shown


def picture(shown: Page) -> Image.Image:
    """What the canvas shows, in the pixels of the page, over the colour of the scene."""
    shown.catch_up()
    shown.next_frame(10)
    data = shown.evaluate(f"{CANVAS}.toDataURL().split(',')[1]")
    drawn = Image.open(io.BytesIO(base64.b64decode(data))).convert("RGBA")
    size = shown.evaluate(f"[{CANVAS}.clientWidth, {CANVAS}.clientHeight]")
    over = Image.new("RGBA", drawn.size, (244, 246, 248, 255))
    over.alpha_composite(drawn)
    return over.convert("RGB").resize(tuple(size), Image.Resampling.BOX)


def different(one: Image.Image, other: Image.Image) -> float:
    """The fraction of pixels of different colours."""
    difference = np.abs(np.subtract(one, other, dtype=float))
    return float((difference.max(axis=2) > VISIBLE).mean())


@pytest.mark.slow
def test_the_plain_picture_is_that_of_the_server(school):
    """Of all modes of the same beam, which have no handles, from the same viewpoint, in the same
    colours, and again after an edit."""
    school.send("all_modes", True)
    rows = FIRST.changed(all_modes=True)
    moment = OpeningScene(rows).moment()
    for beta in (0.5, 0.8):
        school.send("beta", beta)
        wait_until(lambda beta=beta: school.number("beta") == beta)
        scene = OpeningScene(rows.changed(beta=beta))
        expected = WithoutShadow(scene, *picture(school).size).picture(moment)
        # A slow machine rests between two pictures, as long as one has taken.
        wait_until(lambda there=expected: different(picture(school), there) < SAME)
    drawn = picture(school)
    before = OpeningScene(rows)
    assert different(drawn, WithoutShadow(before, *drawn.size).picture(moment)) > SAME
    school.send("all_modes", False)


def test_all_else_works_and_the_reason_is_said(school):
    """Numbers, chart, motion, a body that is dragged, and nothing in the console."""
    assert "no WebGL" in school.evaluate(f"{REASON}.textContent")
    assert school.evaluate(f"{REASON}.checkVisibility()")
    assert not school.evaluate(f"{by_id('first-picture')}.checkVisibility()")
    school.wait("document.querySelectorAll('#mode-rows [data-row]').length === 5")
    school.wait("!!document.querySelector('#tab-frequencies svg')")
    before = school.evaluate(f"Number({CANVAS}.dataset.pictures)")
    school.send("playing", True)
    school.wait(f"{CANVAS}.dataset.pictures > {before + 10}")
    school.send("playing", False)
    school.catch_up()
    school.send("reset", None, until=f"{by_id('beta-field')}.value === '0.5'")
    school.catch_up()
    mass, target = (school.at_rest(lambda x=x: place(school, x)) for x in (0.5, 0.8))  # on the page
    school.drag(mass, target, arrived=lambda: abs(school.number("beta") - 0.8) < 0.03)
    assert school.problems == []


@pytest.mark.slow
def test_axe_finds_nothing_serious(school):
    """On the page without WebGL."""
    load_axe(school)
    assert violations(school) == []


def place(shown: Page, x: float) -> list[float]:
    """Where a point of the undeformed beam is on the page."""
    return shown.evaluate(f"""(() => {{
      const {{ camera, canvas }} = window.__viserMutable, wheel = {NODES}['/scene/rotor'];
      const at = wheel.localToWorld(wheel.position.clone().set({x}, 0, 0)).project(camera);
      const r = canvas.getBoundingClientRect();
      return [r.left + r.width * (1 + at.x) / 2, r.top + r.height * (1 - at.y) / 2]; }})()""")


def test_with_webgl_there_is_no_plain_picture(shown):
    """And its reason is not said."""
    shown.wait("!!document.querySelector('#scene[data-ready]')")
    assert not shown.evaluate(f"!!{by_id('plain-scene')}")


@pytest.mark.slow
def test_an_exported_page_is_drawn_too(tmp_path):
    """From the disk, with the reason."""
    export(file := tmp_path / "beam.html", FIRST)
    with page(file.as_uri(), script=NO_WEBGL) as shown:
        shown.wait(f"{CANVAS}?.dataset.pictures > 3")
        assert shown.evaluate(f"{REASON}.checkVisibility()")
        assert shown.problems == []


@pytest.mark.slow
def test_the_light_is_that_of_the_scene():
    """The plain canvas has the directions and intensities of the lights as numbers of its own."""
    script = package_text("drawing/plain_scene.js")
    for place, power in surroundings.LIGHTS.values():
        x, y, z = (f"{number:g}" for number in place)
        assert f"{{ to: [{x}, {y}, {z}], power: {power:g} }}" in script
    assert f"{list(surroundings.GROUND_LIGHT)}.map" in script
    assert f"({surroundings.SKY:g} *" in script
