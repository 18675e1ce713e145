"""Connections that say nothing, that never read, or that find no room."""

import socket
import struct

import pytest
import websockets.exceptions
from live.server import CAMERA_MESSAGE, encoded, http_get, raw_socket, wait_until
from live.visitor import BEAM, PAPER, frequency_text, visitor

from beamviz.explorer.app import explorer
from beamviz.scene import Scene
from beamviz.server import connection as guard
from beamviz.server import viser_private as hardening

SCENE = Scene(PAPER)


def test_half_open_sockets_are_given_up(monkeypatch):
    """Connections without a request, with half of one, and with silence after it."""
    monkeypatch.setattr(guard, "TIMEOUT", 0.5)
    with explorer(SCENE) as found, visitor(found) as guest:
        port = int(found.rsplit(":", 1)[1])
        silent = [socket.create_connection(("127.0.0.1", port)) for _ in range(30)]
        for line in silent[:15]:
            line.sendall(b"GET / HTTP/1.1\r\nHost: ")
        guest.choose("speed γ", 12.0)
        guest.says(frequency_text(PAPER.replace(gamma=12)))
        for line in silent:
            line.settimeout(10)
            while line.recv(1000):
                pass
            line.close()


def test_a_visitor_who_never_reads_is_given_up(monkeypatch, frame_loops):
    """A page that was put to sleep stops answering pings; memory must not wait for it."""
    monkeypatch.setattr(guard, "TIMEOUT", 0.5)
    with explorer(SCENE) as found, visitor(found) as guest, socket.socket() as deaf:
        deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        deaf.connect(("127.0.0.1", int(found.rsplit(":", 1)[1])))
        deaf.sendall(handshake(found))
        deaf.sendall(framed(encoded(**CAMERA_MESSAGE)))
        sessions = frame_loops[-1].sessions
        wait_until(lambda: len(sessions) == 2)
        wait_until(lambda: guest.receive(5) and len(sessions) == 1, timeout=20)


def handshake(url: str) -> bytes:
    """The request that opens a WebSocket."""
    lines = (
        "GET / HTTP/1.1",
        f"Host: {url.removeprefix('http://')}",
        "Upgrade: websocket",
        "Connection: Upgrade",
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
        "Sec-WebSocket-Version: 13",
        f"Sec-WebSocket-Protocol: {hardening.PROTOCOL}",
    )
    return "\r\n".join([*lines, "", ""]).encode()


def framed(message: bytes) -> bytes:
    """A binary frame, masked with zeros."""
    return b"\x82" + bytes([0x80 | 126]) + struct.pack(">H", len(message)) + bytes(4) + message


def test_a_full_room_says_so_and_lets_the_next_one_in():
    """Two may be there; the third page is told to wait, and comes in when one has left."""
    with explorer(SCENE, max_visitors=2) as found:
        with visitor(found), visitor(found):
            status, headers, body = http_get(found)
            assert (status, headers["Retry-After"]) == (503, "10")
            assert b"Too many visitors" in body
            assert b'http-equiv="refresh"' in body
            with pytest.raises(websockets.exceptions.InvalidStatus, match="503"), raw_socket(found):
                pass
        wait_until(lambda: http_get(found)[0] == 200)
        with visitor(found) as guest:
            assert BEAM in guest.nodes
