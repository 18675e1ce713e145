"""A real browser that shows a page of another site, which tries to use the explorer behind it."""

from collections.abc import Iterator

import pytest
from live.browser import Page, page
from live.server import PROTOCOL, plain_viser_server, url_of

from beamviz.beam import Beam
from beamviz.explorer import explorer
from beamviz.scene import Scene

KEY = "the-key-of-this-run"
SHOWN = "window.__viserMutable && document.querySelectorAll('canvas').length > 0"


@pytest.fixture(scope="module")
def foreign() -> Iterator[Page]:
    """A browser on viser's own page, of another origin with the same cookies: they know no port."""
    with plain_viser_server() as site, page(url_of(site)) as shown:
        shown.wait(SHOWN)
        yield shown


def opens(shown: Page, url: str) -> bool:
    """Whether a script of the page can open a WebSocket to `url`."""
    return shown.evaluate(f"""new Promise(done => {{
        try {{
            const socket = new WebSocket('{url.replace("http", "ws")}', ['{PROTOCOL}']);
            socket.onopen = () => done(true);
            socket.onerror = () => done(false);
        }} catch (error) {{ done(false); }}
    }})""")


def framed(shown: Page, url: str) -> bool:
    """Whether the page can show `url` in a frame, under whatever it draws over it."""
    shown.evaluate(f"""(() => {{
        const frame = document.createElement('iframe');
        frame.onload = () => {{ frame.name = 'loaded'; }};
        frame.src = '{url}';
        document.body.replaceChildren(frame);
    }})()""")
    shown.wait("document.querySelector('iframe').name === 'loaded'")
    tree = shown.call("Page.getFrameTree")["frameTree"]
    return any(
        "unreachableUrl" not in child["frame"] and child["frame"]["url"].startswith(url)
        for child in tree.get("childFrames", [])
    )


def test_a_foreign_page_can_neither_control_a_session_nor_put_it_in_a_frame(foreign, plain, url):
    """With a bare viser server it can, being open in the same browser; a frame under its own
    buttons would steal clicks."""
    for server, is_open in ((url_of(plain), True), (url, False)):
        assert opens(foreign, server) == is_open
        assert framed(foreign, f"{server}/") == is_open


@pytest.mark.slow
def test_neither_a_foreign_page_nor_our_own_can_use_the_server_of_the_other(foreign, plain):
    """The browser has the key of a visitor, but does not send it for a foreign page; a script that
    is injected into our page cannot send data to another server."""
    with explorer(Scene(Beam()), visitor_key=KEY) as found, page(found) as shown:
        own = found.split("?")[0]
        shown.wait(SHOWN)
        assert shown.evaluate("[location.href, document.cookie]") == [own, ""]
        assert opens(shown, own)
        assert opens(foreign, url_of(plain))  # whose page is viser's own
        assert not opens(shown, url_of(plain))
        address = foreign.evaluate("location.href")
        shown.call("Page.navigate", url=address)
        shown.wait(f"location.href === '{address}' && {SHOWN}")
        assert not opens(shown, own)
