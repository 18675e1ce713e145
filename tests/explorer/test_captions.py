"""Texts over the picture, in a real browser."""

import pytest
from live.browser import page

from beamviz.beam import Beam
from beamviz.explorer.app import explorer
from beamviz.scene import Scene, ViewOptions

BOXES = """[...document.querySelectorAll("#caption-layer > span:not([hidden])")].map(e =>
  ({text: e.innerText, size: parseFloat(getComputedStyle(e).fontSize),
    ...e.getBoundingClientRect().toJSON()}))"""


@pytest.mark.browser
def test_captions_are_legible_and_keep_apart():
    """The three nodes of the fourth bending mode and the speed, on a desk and on a phone: at least
    14 pixels high, inside the page, and none covers another."""
    scene = Scene(Beam(gamma=2), view=ViewOptions(playing=False).only(4))
    with explorer(scene) as url, page(url, 1280, 720) as shown:
        for width, height in ((1280, 720), (390, 844)):
            shown.resize(width, height)
            shown.wait("document.querySelectorAll('#caption-layer > span').length === 4")
            shown.next_frame(10)
            boxes = shown.evaluate(BOXES)
            assert sum("node at" in box["text"] for box in boxes) == 3
            assert all(box["size"] >= 14 for box in boxes)
            assert all(0 <= box["left"] < box["right"] <= width for box in boxes)
            for k, one in enumerate(boxes):
                for other in boxes[:k]:
                    beside = one["right"] <= other["left"] or other["right"] <= one["left"]
                    assert beside or abs(one["top"] - other["top"]) >= one["height"] - 1
        assert not shown.problems
