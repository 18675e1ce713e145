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


def test_a_foreign_page_cannot_control_a_session(foreign, plain, url):
    """With a bare viser server it can: any page that is open in the same browser."""
    assert opens(foreign, url_of(plain))
    assert not opens(foreign, url)


@pytest.mark.slow
def test_a_foreign_page_cannot_use_the_cookie_of_a_visitor(foreign):
    """The browser has the key, but does not send it for that page."""
    with explorer(Scene(Beam()), visitor_key=KEY) as found, page(found) as shown:
        shown.wait(SHOWN)
        assert shown.evaluate("location.href") == found.split("?")[0]
        assert shown.evaluate("document.cookie") == ""
        assert opens(shown, found.split("?")[0])
        address = foreign.evaluate("location.href")
        shown.call("Page.navigate", url=address)
        shown.wait(f"location.href === '{address}' && {SHOWN}")
        assert not opens(shown, found.split("?")[0])


def test_a_foreign_page_cannot_put_the_explorer_in_a_frame(foreign, plain, url):
    """A frame under a foreign page's own buttons would steal clicks."""
    assert framed(foreign, url_of(plain) + "/")
    assert not framed(foreign, url + "/")


@pytest.mark.slow
def test_our_own_page_cannot_connect_to_other_servers(foreign, plain, url):
    """An injected script could not send data anywhere."""
    assert opens(foreign, url_of(plain))  # whose page is viser's own
    with page(url) as shown:
        shown.wait(SHOWN)
        assert opens(shown, url)
        assert not opens(shown, url_of(plain))
