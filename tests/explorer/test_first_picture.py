"""What a page shows until its scene has come: a picture of it, or none of any."""

import base64
import io
import re

import numpy as np
import pytest
from live.browser import page
from PIL import Image

from beamviz.beam import Beam
from beamviz.explorer import opening_picture
from beamviz.explorer.first_picture import SIZE, OpeningScene, first_picture
from beamviz.exports.renderer import Renderer
from beamviz.lessons import LESSONS
from beamviz.scene import Scene
from beamviz.server.access import Access

FIRST = Scene(Beam(alpha=1, beta=0.5, gamma=10))
NO_SESSION = "window.Worker = class { addEventListener() {} postMessage() {} terminate() {} }"
VISIBLE = """[...document.querySelectorAll('#first-picture > *')]
  .filter(e => e.checkVisibility()).map(e => e.className.baseVal ?? (e.className || e.localName))"""


def pictures(html: str) -> list[Image.Image]:
    """The pictures in a first picture."""
    found = re.findall(r"base64,([^\"]+)", html)
    return [Image.open(io.BytesIO(base64.b64decode(data))) for data in found]


def test_the_first_picture_is_that_of_the_scene():
    """Light and dark; what differs is the compression."""
    for shown, dark in zip(pictures(first_picture(FIRST)), (False, True), strict=True):
        solved = OpeningScene(FIRST.changed(dark=dark))
        drawn = Renderer(solved, *SIZE).picture(solved.moment())
        assert np.abs(np.subtract(shown.convert("RGB"), drawn, dtype=float)).mean() < 3


@pytest.mark.parametrize(
    ("scene", "options"),
    [
        (Scene(Beam(delta=-1.5, gamma=30)), {}),  # without an equilibrium
        (LESSONS[0].scene, {}),
        (FIRST, {"presenter_key": "secret"}),
        (FIRST, {"framed": True}),
    ],
)
def test_nothing_is_shown_that_the_page_may_not_open_with(scene, options):
    """No beam, and that it is loading."""
    html = opening_picture(scene, Access("127.0.0.1", 8080, **options))
    assert not pictures(html)
    assert "<svg" in html
    assert "Loading" in html


@pytest.mark.parametrize(("query", "seen"), [("", ["light", "p"]), ("/?alpha=2", ["", "p"])])
def test_a_page_shows_it_at_once(url, query, seen):
    """Before it has a session; one with a link has no picture of another scene."""
    with page(url + query, 1440, 900, script=NO_SESSION) as shown:
        shown.wait("!!document.querySelector('#first-picture')")
        shown.wait("window.beamviz !== undefined || typeof beamviz === 'object'")
        assert shown.evaluate(VISIBLE) == seen


@pytest.mark.slow
def test_it_goes_as_the_scene_comes(shown):
    """The live scene is not seen through it."""
    shown.wait("!!document.querySelector('#scene[data-ready]')")
    assert shown.evaluate(VISIBLE) == []
