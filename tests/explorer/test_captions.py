"""Texts over the picture, in a real browser."""

import json

import pytest
from live.browser import page

from beamviz.beam import Beam
from beamviz.explorer.app import explorer
from beamviz.scene import Scene, ViewOptions

pytestmark = pytest.mark.browser

BOXES = """JSON.stringify([...document.querySelectorAll("#caption-layer > span:not([hidden])")].map(
  e => ({text: e.innerText, size: parseFloat(getComputedStyle(e).fontSize),
         ...e.getBoundingClientRect().toJSON()})))"""


@pytest.mark.parametrize(("width", "height"), [(1280, 720), (390, 844)])
def test_captions_are_legible_and_keep_apart(width, height):
    """The three nodes of the fourth bending mode and the speed: at least 14 pixels high, inside the
    page, and none covers another."""
    scene = Scene(Beam(gamma=2), view=ViewOptions(playing=False).only(4))
    with explorer(scene) as url, page(url, width, height) as window:
        window.wait("document.querySelectorAll('#caption-layer > span').length === 4")
        window.next_frame(10)
        boxes = json.loads(window.evaluate(BOXES))
        assert sum("node at" in box["text"] for box in boxes) == 3
        assert all(box["size"] >= 14 and 0 <= box["left"] < box["right"] <= width for box in boxes)
        for k, one in enumerate(boxes):
            for other in boxes[:k]:
                beside = one["right"] <= other["left"] or other["right"] <= one["left"]
                assert beside or abs(one["top"] - other["top"]) >= one["height"] - 1
        assert not window.problems
