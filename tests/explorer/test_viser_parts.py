"""What our pages use of viser's page is there, or they say what is not."""

import pytest
from live.browser import READY, by_id, page

from beamviz.exports import export
from beamviz.scene import Scene

LACKS = f"{by_id('viser-lacks')}?.textContent"
WITHOUT_A_PART = """Object.defineProperty(window, "__viserMutable", {
  set(viewer) { window.whole = viewer; }, configurable: true,
  get() { return window.whole && { ...window.whole, requestRender: undefined }; } })"""
OTHER_MESSAGES = """window.Worker = class extends Worker {
  addEventListener(kind, listener) { super.addEventListener("error", listener); } }"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "told"),
    [(WITHOUT_A_PART, "requestRender"), (OTHER_MESSAGES, "message of a connection")],
)
def test_a_page_says_what_another_viser_lacks(url, change, told):
    """Visibly and in the console, in place of a scene that does not move for no reason."""
    with page(url, script=change) as shown:
        assert told in shown.wait(LACKS)
        assert shown.evaluate(f"{by_id('viser-lacks')}.checkVisibility()")
        assert [one for one in shown.problems if told in one]


def test_the_supported_viser_lacks_nothing(url):
    """Neither on the page of the explorer, nor on an exported one."""
    with page(url) as shown:
        shown.wait(READY)
        assert not shown.evaluate(f"!!{by_id('viser-lacks')}")
        assert shown.problems == []


@pytest.mark.slow
def test_an_exported_page_says_it_too(tmp_path):
    """It looks for the parts by itself, as no server tells it when they should be there."""
    export(file := tmp_path / "beam.html", Scene())
    with page(file.as_uri(), script=WITHOUT_A_PART) as shown:
        assert "requestRender" in shown.wait(LACKS)
