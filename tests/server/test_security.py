"""What a stranger may not do: each attack first on a bare viser server, then on the explorer."""

import logging
import socket
import sys
from collections.abc import Iterator
from typing import Any
from unittest import mock

import pytest
import websockets.exceptions
from live.server import (
    CAMERA_MESSAGE,
    FOREIGN_ORIGIN,
    close_code,
    encoded,
    http_get,
    missing_headers,
    plain_viser_server,
    raw_socket,
    url_of,
    wait_for_client,
    wait_until,
)
from live.visitor import BEAM, PAPER, beam_moved, visitor

from beamviz.errors import InvalidInput
from beamviz.explorer import app as server
from beamviz.explorer.app import explorer
from beamviz.scene import Scene
from beamviz.server import connection as guard
from beamviz.server import run_server
from beamviz.server import viser_private as hardening
from beamviz.server.access import Access, matches, public_url
from beamviz.server.connection import (
    MAX_BYTES,
    MAX_PART_BYTES,
    MESSAGES,
    InvalidMessage,
    validate,
)
from beamviz.server.viser_private import message_types

KEY = "the-key-of-this-run"
SCENE = Scene(PAPER)
VIOLATION, TOO_BIG = 1008, 1009


@pytest.fixture(autouse=True)
def fresh_log() -> None:
    """No line is left out because an earlier test has had it."""
    for module in (guard, hardening):
        module.log.reported.clear()


@pytest.fixture(scope="module")
def open_url() -> Iterator[str]:
    """An explorer that the network can reach, under an address of this machine."""
    with explorer(SCENE, "0.0.0.0", visitor_key=KEY) as found:
        yield f"http://127.0.0.1:{found.split(':')[2].split('/')[0]}"


def refused(url: str, **options: Any) -> bool:
    """Whether a WebSocket is turned away with 403."""
    with (
        pytest.raises(websockets.exceptions.InvalidStatus, match="403"),
        raw_socket(url, **options),
    ):
        pass
    return True


def unharmed(url: str) -> bool:
    """Whether a visitor is served."""
    with visitor(url) as guest:
        return BEAM in guest.nodes


# Origin and Host


def test_a_page_of_another_site_may_not_connect_nor_ask(url):
    """viser lets any page of the web in; here it gets 403, over WebSocket and over HTTP."""
    with (
        plain_viser_server() as viser_server,
        raw_socket(url_of(viser_server), origin=FOREIGN_ORIGIN) as line,
    ):
        line.send(encoded(**CAMERA_MESSAGE))
        wait_for_client(viser_server)
        assert http_get(url_of(viser_server), Origin=FOREIGN_ORIGIN)[0] == 200
    assert refused(url, origin=FOREIGN_ORIGIN)
    assert refused(url, origin="null")
    assert http_get(url, Origin=FOREIGN_ORIGIN)[0] == 403
    assert http_get(url, Origin=url)[0] == 200
    assert unharmed(url)


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example:{port}", "127.0.0.1:1"])
def test_a_name_made_to_point_here_is_not_answered(url, host):
    """DNS rebinding makes a foreign page same-origin; only the Host header gives it away."""
    with plain_viser_server() as viser_server:
        here = url_of(viser_server)
        name = host.format(port=viser_server.get_port())
        assert http_get(here, Host=name)[0] == 200
        with raw_socket(here, additional_headers={"Host": name}, origin=f"http://{name}"):
            pass
    name = host.format(port=url.split(":")[2])
    status, _, body = http_get(url, Host=name)
    assert (status, b"does not answer to" in body) == (403, True)
    assert refused(url, additional_headers={"Host": name}, origin=f"http://{name}")


def test_two_hosts_in_one_request_are_none(url):
    """What a proxy and a server could read differently is refused."""
    place = url.removeprefix("http://")
    with plain_viser_server() as viser_server:
        assert http_get(url_of(viser_server), Host="evil.example", host="localhost")[0] == 200
    assert http_get(url, Host=place, host="evil.example")[0] == 403


@pytest.mark.parametrize(
    ("access", "host", "answered"),
    [
        (Access("127.0.0.1", 8080), "localhost:8080", True),
        (Access("127.0.0.1", 8080), "[::1]:8080", True),
        (Access("127.0.0.1", 80), "localhost", True),
        (Access("127.0.0.1", 8080), "localhost", False),
        (Access("127.0.0.1", 8080), "192.168.1.5:8080", False),
        (Access("127.0.0.1", 8080), "user@127.0.0.1:8080", False),
        (Access("127.0.0.1", 8080), "127.0.0.1:8080/x", False),
        (Access("127.0.0.1", 8080), "127.0.0.1:80port", False),
        (Access("0.0.0.0", 8080), "192.168.1.5:8080", True),
        (Access("0.0.0.0", 8080), "evil.example:8080", False),
        (Access("192.168.1.5", 8080), "192.168.1.5:8080", True),
        (Access("192.168.1.5", 8080), "localhost:8080", False),
        (Access("127.0.0.1", 8080, public="https://beams.example.org"), "beams.example.org", True),
        (Access("127.0.0.1", 8080, public="https://beams.example.org"), "example.org", False),
    ],
)
def test_a_server_answers_to_its_own_names_only(access, host, answered):
    """Loopback names on loopback, addresses made of digits on a network, a proxy's own name."""
    assert access.answers_to(host) is answered


def test_behind_a_proxy_the_origin_is_the_proxys():
    """https there, http here; the cookie is for https alone."""
    access = Access(
        "127.0.0.1", 8080, visitor_key=KEY, public=public_url("https://Beams.example.org/")
    )
    headers = {"host": "beams.example.org", "cookie": f"beamviz-8080={KEY}"}
    assert access.url == f"https://beams.example.org/?token={KEY}"
    assert access.refused(headers | {"origin": "https://beams.example.org"}, "/") is None
    assert access.refused(headers | {"origin": "http://beams.example.org"}, "/")
    assert access.key_cookie(headers, f"/?token={KEY}").endswith("; Secure")


@pytest.mark.parametrize("text", ["beams.example.org", "ftp://x", "https://", "https://x/path"])
def test_a_public_url_that_is_none_is_named(text):
    """InvalidInput says what was given and what is needed."""
    with pytest.raises(InvalidInput, match=r"public-url = .*must be a scheme and a host"):
        public_url(text)


@pytest.mark.skipif(sys.platform != "linux", reason="needs a second address of its own")
def test_only_this_machine_can_connect_unless_others_are_let_in(url):
    """viser listens to all the network, at every address of the machine."""
    with (
        plain_viser_server("0.0.0.0") as viser_server,
        socket.create_connection(("127.0.0.2", viser_server.get_port()), timeout=10),
    ):
        pass
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.2", int(url.rsplit(":", 1)[1])), timeout=10)


# The key


def test_on_a_network_nobody_comes_in_without_the_key(open_url):
    """viser's default is to listen to all, and to let all in."""
    with plain_viser_server("0.0.0.0") as viser_server:
        assert http_get(url_of(viser_server))[0] == 200
        with raw_socket(url_of(viser_server)):
            pass
    for path in ("/", "/?token=", "/?token=wrong", f"/?token={KEY}x", "/?token=%ff%fe"):
        status, _, body = http_get(open_url, path)
        assert (status, b"viser" in body) == (403, False)
        assert refused(open_url, path=path)
    assert refused(open_url, additional_headers={"Cookie": "beamviz=1; x"})


def test_the_key_becomes_a_cookie_and_leaves_the_address(open_url):
    """A projector shows the address; a script on the page cannot read the cookie."""
    status, headers, _ = http_get(open_url, f"/?token={KEY}")
    assert (status, headers["Location"]) == (303, "/")
    cookie, _, rules = headers["Set-Cookie"].partition(";")
    assert {"HttpOnly", "SameSite=Lax"} <= set(rules.replace(" ", "").split(";"))
    assert http_get(open_url, Cookie=cookie)[0] == 200
    assert http_get(open_url, Cookie=f"other=1; {cookie}; more=2")[0] == 200
    with visitor(open_url, additional_headers={"Cookie": cookie}) as guest:
        assert BEAM in guest.nodes
    assert unharmed(f"{open_url}/?token={KEY}")
    _, headers, _ = http_get(open_url, f"/?lesson=nodes&token={KEY}&dark=true")
    assert headers["Location"] == "/?lesson=nodes&dark=true"


def test_keys_are_compared_in_constant_time():
    """Every key is compared, whole, also after one has matched."""
    with mock.patch("hmac.compare_digest", side_effect=[True, False]) as compared:
        assert matches((KEY, "another"), KEY)
    assert compared.call_count == 2


@pytest.mark.parametrize(("host", "public"), [("0.0.0.0", ""), ("127.0.0.1", "https://x.example")])
def test_a_server_that_others_can_reach_makes_a_key_and_says_so(host, public, capsys, monkeypatch):
    """A new one each time, 128 bits; on loopback there is none."""
    monkeypatch.setattr(server, "has_come", lambda _: True)
    for _ in range(2):
        server.serve(SCENE, host=host, port=0, public=public, processes=1)
    server.serve(SCENE, port=0)
    first, second, local = capsys.readouterr().out.splitlines()
    keys = [line.partition("?token=")[2].split()[0] for line in (first, second)]
    assert keys[0] != keys[1]
    assert min(map(len, keys)) >= 22
    assert "whoever has this link can use it" in first
    assert "token" not in local


# Messages


def test_no_visitor_can_open_a_public_tunnel(url):
    """viser opens one for a single message, with its button hidden or not."""
    with mock.patch("viser._viser.ViserTunnel") as tunnel:
        tunnel.return_value.get_status.return_value = "connected"
        with plain_viser_server() as viser_server, raw_socket(url_of(viser_server)) as line:
            viser_server.gui.configure_theme(show_share_button=False)
            line.send(encoded(type="ShareUrlRequest"))
            wait_until(lambda: tunnel.called)
            tunnel.return_value.on_connect.call_args[0][0](1)  # lets viser's thread go
        tunnel.reset_mock()
        assert close_code(url, encoded(type="ShareUrlRequest")) == VIOLATION
        with run_server() as ours:
            assert ours.request_share_url() is None
        assert not tunnel.called


def test_a_visitor_cannot_reach_into_the_server(url):
    """viser sets whatever attribute of a control a message names."""
    with plain_viser_server() as viser_server, raw_socket(url_of(viser_server)) as line:
        slider = viser_server.gui.add_slider("x", 0.0, 1.0, 0.1, 0.5)
        reach = {"removed": True, "update_cb": [], "min": 7}
        updates = {name: value for name, value in reach.items() if hasattr(slider._impl, name)}
        line.send(encoded(type="GuiUpdateMessage", uuid=slider._impl.uuid, updates=updates))
        wait_until(lambda: slider._impl.removed)
    for updates in ({"update_cb": []}, {"value": 1, "removed": True}, {}):
        assert (
            close_code(url, encoded(type="GuiUpdateMessage", uuid="x", updates=updates))
            == VIOLATION
        )


def test_a_visitor_cannot_speak_to_the_others_through_the_server(url):
    """viser passes "form" messages on to all, and keeps them for those who come later."""
    message = encoded(type="GuiFormDirtyMessage", uuid="x" * 100)
    with plain_viser_server() as viser_server, raw_socket(url_of(viser_server)) as line:
        buffer = viser_server._websock_server._broadcast_buffer.message_from_id
        before = len(buffer)
        line.send(message)
        wait_until(lambda: len(buffer) > before)
    assert close_code(url, message) == VIOLATION


def test_a_visitor_cannot_fill_the_memory_with_a_file(url):
    """viser takes files for any control, without a limit."""
    start = {"source_component_uuid": "", "transfer_uuid": "t", "filename": "f", "mime_type": "x"}
    start |= {"type": "FileTransferStartUpload", "part_count": 1000, "size_bytes": 10**12}
    with plain_viser_server() as viser_server, raw_socket(url_of(viser_server)) as line:
        slider = viser_server.gui.add_slider("x", 0.0, 1.0, 0.1, 0.5)
        line.send(encoded(**start | {"source_component_uuid": slider._impl.uuid}))
        wait_until(lambda: viser_server.gui._current_file_upload_states)
    assert close_code(url, encoded(**start)) == VIOLATION


def test_a_message_has_a_largest_size(url):
    """viser reads up to 50 MB; nothing a page sends comes near our limit."""
    huge = encoded(type="GuiUpdateMessage", uuid="x", updates={"value": "x" * MAX_BYTES})
    with plain_viser_server() as viser_server, raw_socket(url_of(viser_server)) as line:
        line.send(encoded(**CAMERA_MESSAGE))
        wait_for_client(viser_server)
        line.send(huge)
        line.ping().wait(5)
        assert viser_server.get_clients()
    assert close_code(url, huge) == VIOLATION
    part = {"source_component_uuid": "", "transfer_uuid": "t", "part_index": 0}
    part |= {"type": "FileTransferPart", "content": b"x" * MAX_PART_BYTES}
    assert close_code(url, encoded(**part)) == TOO_BIG


@pytest.mark.parametrize(
    "message",
    [
        "text instead of bytes",
        b"",
        b"\xc1",
        b"\x81" * 5000,  # nested deeper than anyone can count
        encoded(no="type"),
        encoded(type=["GuiUpdateMessage"]),
        encoded(type="Message"),
        encoded(type="SetPositionMessage", name="/stage", position=(0, 0, 0)),
        encoded(type="GuiRemoveMessage", uuid="x"),
        encoded(type="ViewerCameraMessage"),
        encoded(**CAMERA_MESSAGE | {"fov": float("nan")}),
        encoded(**CAMERA_MESSAGE | {"position": (1e300, 0.0, 0.0)}),
        encoded(**CAMERA_MESSAGE | {"image_height": 0}),
        encoded(**CAMERA_MESSAGE | {"image_width": -5}),
        encoded(**CAMERA_MESSAGE | {"look_at": (0.0, 0.0)}),
        encoded(**CAMERA_MESSAGE | {"excluded_self_client": 1}),
        encoded(type="GuiUpdateMessage", uuid=5, updates={"value": 1}),
        encoded(type="GuiUpdateMessage", uuid="x", updates={"value": None}),
        encoded(type="GuiUpdateMessage", uuid="x", updates={"value": {"a": 1}}),
        encoded(type="GuiUpdateMessage", uuid="x", updates={"value": [[[1]]]}),
        encoded(type="GuiUpdateMessage", uuid="x", updates={"value": "x" * 2000}),
        encoded(type="GuiUpdateMessage", uuid="x", updates={"value": [1] * 100}),
    ],
)  # fmt: skip
def test_what_is_no_message_of_ours_is_refused(message):
    """Each of these is rejected before viser sees it."""
    with pytest.raises(InvalidMessage):
        validate(message, message_types(*MESSAGES))


def test_an_invalid_message_ends_its_sender_and_nobody_else(url, caplog):
    """One line in the log says whom and why; another visitor does not notice."""
    with visitor(url) as other, caplog.at_level(logging.WARNING):
        for _ in range(3):
            assert close_code(url, b"\xc1") == VIOLATION
        lines = [record.getMessage() for record in caplog.records if "closed" in record.message]
        assert len(lines) == 1
        assert "127.0.0.1: closed for an invalid message" in lines[0]
        other.choose("speed γ", 11.0)
        other.wait(lambda latest: beam_moved(latest))


# Answers


def test_every_answer_ties_the_pages_hands(url):
    """No frames, no guessing of types, no referrer, no talking to others; and no version."""
    with plain_viser_server() as viser_server:
        assert "Content-Security-Policy" in missing_headers(http_get(url_of(viser_server))[1])
        assert "websockets" in http_get(url_of(viser_server))[1]["Server"]
    for path in ("/", "/nothing-here"):
        assert not missing_headers(http_get(url, path)[1])


@pytest.mark.parametrize(
    "path",
    [
        "/../../../../../../../../etc/passwd",
        "/%2e%2e/%2e%2e/%2e%2e/%2e%2e/%2e%2e/%2e%2e/%2e%2e/etc/passwd",
        "/..%5c..%5c..%5cetc%5cpasswd",
        "//etc/passwd",
        "/assets/",
        "/index.html/../..",
    ],
)
def test_no_other_file_is_served_and_no_folder_listed(url, path):
    """viser sees to this by itself; here it is watched."""
    with plain_viser_server() as viser_server:
        assert http_get(url_of(viser_server), path)[0] == 404
    assert http_get(url, path)[0] == 404


def test_a_page_of_another_version_is_told_so(url, capsys):
    """viser prints a line on stdout for each; here it gets an answer, and no visit."""
    with pytest.raises(websockets.exceptions.InvalidStatus, match="400"):
        websockets.sync.client.connect(
            url.replace("http", "ws"), subprotocols=["viser-v0.1"], open_timeout=10
        )
    assert capsys.readouterr().out == ""
