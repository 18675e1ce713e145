"""Who may connect: each attack first on a plain viser server, then refused by the explorer."""

import socket
import sys
from collections.abc import Iterator

import pytest
from helpers import slow
from live import server
from live.browser import Page, frame, page
from live.visitor import PAPER, visitor
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from beamviz import explorer as app
from beamviz.errors import InvalidInput
from beamviz.explorer import explorer
from beamviz.scene import Scene
from beamviz.server import connection
from beamviz.server.access import Access, matches, public_url

KEY = "the-key-of-this-run"
SCENE = Scene(PAPER)
ABOVE = "/../../../../../../../../etc/passwd"
OTHER_FILES = (
    *("/nothing-here", "/assets/", "//etc/passwd", "/index.html/../..", ABOVE),
    *(ABOVE.replace("..", "%2e%2e"), "/..%5c..%5c..%5cetc%5cpasswd"),
)
EVIL = "evil.example"
REBOUND = (EVIL, f"127.0.0.1.{EVIL}:{{port}}", f"localhost.{EVIL}", "user@127.0.0.1:{port}")
REBOUND += ("127.0.0.1:{port}/x", "127.0.0.1:{port}port", "127.0.0.1:0")
FOREIGN: list[dict[str, str]] = [
    *({"Origin": origin} for origin in (f"http://{EVIL}", "null", "")),
    # DNS rebinding makes a foreign page same-origin; only the Host header shows it.
    *({"Host": name, "Origin": f"http://{name}"} for name in REBOUND),
]
NOT_UNICODE = "/?token=%ff%fe"


@pytest.fixture(scope="module", params=[1, *slow(2)], ids="{} processes".format)
def network(request, tmp_path_factory) -> Iterator[tuple[str, str]]:
    """An explorer that the network can reach: its address on this machine, and its key. In two
    processes, which get connections in turn, so that four reach both."""
    if request.param == 1:
        with explorer(SCENE, "0.0.0.0", visitor_key=KEY) as found:
            yield f"http://127.0.0.1:{found.split(':')[2].partition('/')[0]}", KEY
        return
    folder, options = tmp_path_factory.mktemp("network"), ("--host", "0.0.0.0")
    with server.ServeProcess(folder, *options, processes=2) as served:
        assert len(served.workers) == 2
        yield f"http://127.0.0.1:{served.port}", served.url.partition("?token=")[2]


def key_cookie(address: str, key: str) -> dict[str, str]:
    """The header with the cookie of a visitor who has the key."""
    return {"Cookie": f"beamviz-{address.rpartition(':')[2]}={key}"}


def statuses(url: str, path: str = "/", **headers: str) -> tuple[int, int]:
    """Those of a GET request and of a WebSocket's handshake; {port} in a header is the server's."""
    headers = {name: text.format(port=url.rpartition(":")[2]) for name, text in headers.items()}
    opened = server.handshake_status(url, path, additional_headers=headers)
    return server.http_get(url, path, **headers)[0], opened


@pytest.mark.parametrize("headers", FOREIGN, ids=str)
def test_a_foreign_page_gets_403(plain, url, network, headers):
    """Over WebSocket and over HTTP, also from a browser with the key; viser accepts any page."""
    assert statuses(server.url_of(plain), **headers) == (200, 101)
    assert statuses(url, **headers) == (403, 403)
    for _ in range(4):
        assert statuses(network[0], **headers | key_cookie(*network)) == (403, 403)


def test_our_own_page_is_answered_under_the_names_of_this_machine(plain, url):
    """A refusal names the address. Two hosts are refused: a proxy might read the other one."""
    assert b"does not answer to" in server.http_get(url, Host=EVIL)[2]
    assert server.http_get(url, Origin=url)[0] == 200
    local = url.replace("127.0.0.1", "localhost")
    with visitor(local, origin=local):
        pass
    assert server.http_get(server.url_of(plain), Host=EVIL, host="localhost")[0] == 200
    assert server.http_get(url, Host=url.removeprefix("http://"), host=EVIL)[0] == 403


@pytest.mark.parametrize(
    ("address", "answered", "refused"),
    [
        (("127.0.0.1", 8080), ("localhost:8080", "[::1]:9000"), ("192.168.1.5:8080",)),
        (("127.0.0.1", 80), ("localhost",), ()),
        (("0.0.0.0", 8080), ("192.168.1.5:8080", "localhost:9000"), ("evil.example:8080",)),
        (("192.168.1.5", 8080), ("192.168.1.5:8080", "localhost:9000"), ("192.168.1.6:8080",)),
    ],
)
def test_a_server_answers_to_its_own_names_only(address, answered, refused):
    """Loopback names, which a tunnel has with another port; numerical addresses on a network; the
    name of a proxy."""
    access = Access(*address)
    assert all(map(access.answers_to, answered))
    assert not any(map(access.answers_to, refused))
    behind = Access(*address, public="https://beams.example.org")
    assert behind.answers_to("beams.example.org")
    assert not behind.answers_to("example.org")


def test_behind_a_proxy_the_origin_is_the_proxys():
    """https there, http here; the cookie is for https only. An invalid public URL is named."""
    port, public = server.free_port(), public_url("https://Beams.example.org/")
    own, host = f"http://127.0.0.1:{port}", {"Host": "beams.example.org"}
    with explorer(SCENE, port=port, visitor_key=KEY, public=public) as found:
        assert found == f"https://beams.example.org/?token={KEY}"
        cookie = server.http_get(own, f"/?token={KEY}", **host)[1]["Set-Cookie"]
        assert cookie.endswith("; Secure")
        for scheme, status in (("https", 200), ("http", 403)):
            headers = {"Origin": f"{scheme}://beams.example.org", "Cookie": cookie}
            assert server.http_get(own, **host, **headers)[0] == status
    wrong = (
        "beams.example.org",
        "ftp://x",
        "https://",
        "https://x/?a",
        "https://me@x",
        "https:///a",
    )
    for text in (*wrong, "https://x/a;b", "https://x/a b", "https://x//a", "https://x/ä"):
        with pytest.raises(InvalidInput, match=r"public-url = .*must be a scheme, a host"):
            public_url(text)


@pytest.mark.parametrize("before", ["", "/user/Me/proxy/8080"], ids=["removed", "passed on"])
def test_behind_a_proxy_under_a_path_all_stays_under_it(before):
    """Whether the proxy removes its path from what it passes on or not. viser's page opens its
    WebSocket without a slash at the end; the server's own address works beside it."""
    port, public = server.free_port(), public_url("https://hub.example.org/user/Me/proxy/8080/")
    own, host = f"http://127.0.0.1:{port}", {"Host": "hub.example.org"}
    with explorer(SCENE, port=port, visitor_key=KEY, public=public) as found:
        assert found == f"https://hub.example.org/user/Me/proxy/8080/?token={KEY}"
        status, headers, _ = server.http_get(own, f"{before}/?token={KEY}&gamma=3", **host)
        assert (status, headers["Location"]) == (303, f"{public}/?gamma=3")
        cookie, *rules = headers["Set-Cookie"].split("; ")
        assert "Path=/user/Me/proxy/8080" in rules
        sent = {**host, "Origin": "https://hub.example.org", "Cookie": cookie}
        assert server.http_get(own, f"{before}/?gamma=3", **sent)[0] == 200
        assert server.http_get(own, f"{before}/nothing", **sent)[0] == 404
        assert server.http_get(own, f"{before}/", **host)[0] == 403
        del sent["Host"]  # which websockets' client takes from the address
        with socket.create_connection(("127.0.0.1", port)) as line:
            asked = {"sock": line, "additional_headers": sent}
            assert server.handshake_status("http://hub.example.org", before, **asked) == 101
        status, headers, _ = server.http_get(own, f"/?token={KEY}")
        assert (headers["Location"], "Path=/;" in headers["Set-Cookie"]) == ("/", True)


@pytest.mark.skipif(sys.platform != "linux", reason="needs a second address of its own")
def test_only_this_machine_can_connect_by_default(url):
    """viser listens at all addresses of the machine."""
    with server.plain_viser_server("0.0.0.0") as viser_server:
        assert server.http_get(f"http://127.0.0.2:{viser_server.get_port()}")[0] == 200
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.2", int(url.rsplit(":", 1)[1])), timeout=server.TIMEOUT)


def test_on_a_network_the_key_is_required(plain, network):
    """viser accepts all by default. Every answer has the security headers, and who has the key can
    send no other messages."""
    address, key = network
    cookie = key_cookie(address, key)
    assert statuses(server.url_of(plain)) == (200, 101)
    for path, headers, answers in (
        ("/", cookie, (200, 101)),
        (f"/?token={key}", {}, (303, 101)),
        (ABOVE, cookie, (404, 101)),
        ("/", {"Cookie": "beamviz=1; x"}, (403, 403)),
        *((path, {}, (403, 403)) for path in ("/", "/?token=", f"/?token={key}x", NOT_UNICODE)),
    ):
        for _ in range(4):
            assert statuses(address, path, **headers) == answers
        _, shown, body = server.http_get(address, path, **headers)
        assert not server.missing_headers(shown)
        assert (b"viser" in body) == (answers[0] == 200)
    tunnel = server.encoded(type="ShareUrlRequest")
    for _ in range(4):
        assert server.close_code(address, tunnel, additional_headers=cookie) == 1008
    assert matches((KEY, "another"), KEY)
    assert matches(("another", KEY), KEY)
    assert not matches(("another",), KEY)


def test_the_key_moves_from_the_address_to_a_cookie(network):
    """So that a projector does not show it, and scripts cannot read it."""
    address, key = network
    status, headers, _ = server.http_get(address, f"/?token={key}")
    assert (status, headers["Location"]) == (303, "/")
    cookie, _, rules = headers["Set-Cookie"].partition(";")
    assert {"HttpOnly", "SameSite=Lax"} <= set(rules.replace(" ", "").split(";"))
    assert server.http_get(address, Cookie=cookie)[0] == 200
    assert server.http_get(address, Cookie=f"other=1; {cookie}; more=2")[0] == 200
    for link, sent in ((address, {"Cookie": cookie}), (f"{address}/?token={key}", {})):
        with visitor(link, additional_headers=sent):
            pass
    _, headers, _ = server.http_get(address, f"/?lesson=nodes&token={key}&dark=true")
    assert headers["Location"] == "/?lesson=nodes&dark=true"


@pytest.mark.parametrize(
    ("host", "public"),
    [("0.0.0.0", ""), *slow(("127.0.0.1", "https://x.example/a/b"))],
)
def test_a_shared_server_prints_a_new_key(host, public, capsys, monkeypatch):
    """Of 128 bits, and another for the presenter of a lecture; on loopback there is none."""
    monkeypatch.setattr(app, "wait_for_signal", lambda: None)
    app.serve(SCENE, host=host, port=0, public=public, processes=1)
    app.serve(SCENE, host=host, port=0, public=public, follow=True)
    app.serve(SCENE, port=0)
    first, second, presenter, local = capsys.readouterr().out.splitlines()
    keys = {line.partition("?token=")[2].split()[0] for line in (first, second, presenter)}
    assert len(keys) == 3
    assert min(map(len, keys)) >= 22
    assert "whoever has this link can use it" in first
    assert presenter.startswith("the presenter's link")
    assert f"{public}/?token=" in presenter
    assert "token" not in local


def test_every_response_has_the_security_headers(plain, url, capsys):
    """No frames, no MIME sniffing, no referrer, no other connections, no version; also where no
    file is served and no folder listed, as viser ensures itself. A page of another version, for
    each of which viser prints a line on stdout, gets an answer."""
    headers = server.http_get(server.url_of(plain))[1]
    assert "Content-Security-Policy" in server.missing_headers(headers)
    assert "websockets" in headers["Server"]
    assert not server.missing_headers(server.http_get(url)[1])
    for path in OTHER_FILES:
        status, headers, _ = server.http_get(url, path)
        assert (path, status, server.missing_headers(headers)) == (path, 404, set())
    with pytest.raises(InvalidStatus, match="400"):
        connect(url.replace("http", "ws"), subprotocols=["viser-v0.1"], open_timeout=server.TIMEOUT)
    assert capsys.readouterr().out == ""


@pytest.mark.slow
def test_half_open_sockets_are_closed(monkeypatch):
    """Connections without a request, or with half of one; a visitor is served meanwhile."""
    monkeypatch.setattr(connection, "TIMEOUT", 3.0)  # that the visitor needs for a ping at most
    with explorer(SCENE) as found, visitor(found) as guest:
        port = int(found.rsplit(":", 1)[1])
        silent = [socket.create_connection(("127.0.0.1", port)) for _ in range(30)]
        for line in silent[:15]:
            line.sendall(b"GET / HTTP/1.1\r\nHost: ")
        guest.edit(gamma=12.0)
        for line in silent:
            with line:
                line.settimeout(server.TIMEOUT)
                while line.recv(1000):
                    pass


@pytest.mark.slow
def test_a_visitor_who_does_not_read_is_disconnected(monkeypatch):
    """A page of a sleeping machine answers no pings, and must not fill the memory."""
    monkeypatch.setattr(connection, "TIMEOUT", 0.5)
    unread = {"max_queue": 1, "ping_interval": None, "close_timeout": 0.1}  # pauses after a message
    with explorer(SCENE, max_visitors=1) as found, server.raw_socket(found, **unread) as deaf:
        deaf.send(server.encoded(**server.CAMERA_MESSAGE))
        assert server.http_get(found)[0] == 503
        server.wait_until(lambda: server.http_get(found)[0] == 200)


def test_beyond_the_limit_a_page_waits_and_tries_again():
    """Of two; the third page is served when one visitor has left."""
    with explorer(SCENE, max_visitors=2) as found:
        with visitor(found), visitor(found):
            status, headers, body = server.http_get(found)
            assert (status, headers["Retry-After"]) == (503, "10")
            assert b"Too many visitors" in body
            assert b'http-equiv="refresh"' in body
            assert server.handshake_status(found) == 503
        server.wait_until(lambda: server.http_get(found)[0] == 200)
        with visitor(found):
            pass


def test_a_page_in_a_notebook_needs_the_key_in_its_path():
    """Nowhere else, as browsers send no cookies of a frame. Pages of this machine may show it in a
    frame, no refusal, and no page of another server of ours."""
    with explorer(SCENE, visitor_key=KEY, framed=True) as found:
        own = found.removesuffix(f"/{KEY}/")
        assert statuses(own, f"/{KEY}/") == statuses(own, f"/{KEY}?gamma=1/2") == (200, 101)
        assert statuses(own, f"/{KEY}/", Origin=f"http://{EVIL}") == (403, 403)
        assert statuses(own, f"/{KEY}/index.html/x")[0] == 404
        for path in ("/", f"/?token={KEY}", f"/{KEY}x/", f"/x/{KEY}/", f"//x/{KEY}"):
            assert statuses(own, path, **key_cookie(own, KEY)) == (403, 403)
            headers = server.http_get(own, path)[1]
            assert not server.missing_headers(headers)
        headers = server.http_get(own, f"/{KEY}/")[1]
        assert "X-Frame-Options" not in headers
        assert "Set-Cookie" not in headers
        rules = headers["Content-Security-Policy"].split("; ")
        (ancestors,) = [rule for rule in rules if rule.startswith("frame-ancestors ")]
        assert "http://localhost:*" in ancestors.split()
        assert not {"*", "http:", "https:", "data:"} & set(ancestors.split())


# A real browser

SHOWN = "window.__viserMutable && document.querySelectorAll('canvas').length > 0"


@pytest.fixture(scope="module")
def foreign() -> Iterator[Page]:
    """A browser on viser's own page, of another origin with the same cookies: they know no port."""
    with server.plain_viser_server() as site, page(server.url_of(site)) as shown:
        shown.wait(SHOWN)
        yield shown


def opens(shown: Page, url: str) -> bool:
    """Whether a script of the page can open a WebSocket to `url`."""
    return shown.evaluate(f"""new Promise(done => {{
        try {{
            const socket = new WebSocket('{url.replace("http", "ws")}', ['{server.PROTOCOL}']);
            socket.onopen = () => done(true);
            socket.onerror = () => done(false);
        }} catch (error) {{ done(false); }}
    }})""")


def test_a_foreign_page_can_neither_control_a_session_nor_put_it_in_a_frame(foreign, plain, url):
    """With a bare viser server it can; a frame under its own buttons would steal clicks."""
    for site, is_open in ((server.url_of(plain), True), (url, False)):
        assert opens(foreign, site) == is_open
        foreign.evaluate(f"""(() => {{
            const frame = document.createElement('iframe');
            frame.onload = () => {{ frame.name = 'loaded'; }};
            frame.src = '{site}/';
            document.body.replaceChildren(frame);
        }})()""")
        foreign.wait("document.querySelector('iframe').name === 'loaded'")
        (child,) = foreign.call("Page.getFrameTree")["frameTree"]["childFrames"]
        assert child["frame"]["url"].startswith(site) == is_open
        assert ("unreachableUrl" not in child["frame"]) == is_open


@pytest.mark.slow
def test_neither_a_foreign_page_nor_our_own_can_use_the_server_of_the_other(foreign, plain):
    """The browser has the key of a visitor, but does not send it for a foreign page; a script that
    is injected into our page cannot send data to another server."""
    with explorer(SCENE, visitor_key=KEY) as found, page(found) as shown:
        own = found.split("?")[0]
        shown.wait(SHOWN)
        assert shown.evaluate("[location.href, document.cookie]") == [own, ""]
        assert opens(shown, own)
        assert opens(foreign, server.url_of(plain))  # whose page is viser's own
        assert not opens(shown, server.url_of(plain))
        address = foreign.evaluate("location.href")
        shown.call("Page.navigate", url=address)
        shown.wait(f"location.href === '{address}' && {SHOWN}")
        assert not opens(shown, own)


@pytest.mark.slow
def test_only_pages_of_this_machine_show_a_page_in_a_notebook():
    """Another page cannot, even with the key."""
    with explorer(SCENE, visitor_key=KEY, framed=True) as found:
        markup = f"<iframe src='{found}'></iframe>"
        with server.website(markup) as site, page(site), frame(found) as shown:
            shown.wait(SHOWN)
        with page(f"data:text/html,{markup}"), frame(found) as shown:
            shown.wait("location.protocol === 'chrome-error:'")
