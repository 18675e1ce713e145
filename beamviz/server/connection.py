"""Checks of a connection before viser handles it: access, security headers, messages."""

import asyncio
import contextlib
import gzip
import html
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import msgspec
from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from beamviz.server.access import Access, Refusal, header
from beamviz.server.log import RateLimitedLog
from beamviz.server.viser_private import PROTOCOL, message_types

POLICY_VIOLATION, TRY_AGAIN_LATER = 1008, 1013  # WebSocket close codes
TIMEOUT = 10.0  # [s] for a request, and for the answer to a ping
RETRY = 10  # [s] after which a page refused for lack of capacity tries again

CONTROL = "GuiUpdateMessage"
MAX_BYTES = 150_000  # of a message: the largest has the text of a scene file
MAX_ITEMS = 64  # of a list
MAX_TEXT = 1000  # characters of a field
MAX_NUMBER = 1e6  # of a coordinate
MAX_PIXELS = 32768  # of a page's width or height
RATE, BURST = 200, 400  # token bucket: messages per second, and its size
PAUSE = 0.05  # [s] during which messages above this rate are coalesced

# The page is one file with inline script and style, and its WebAssembly code needs eval. It is
# protected by the addresses that it may connect to: see `Guard.add_headers`.
CONTENT_POLICY = {
    "default-src": "'none'",
    "script-src": "'self' 'unsafe-inline' 'unsafe-eval' blob: data:",
    "worker-src": "'self' blob: data:",
    "style-src": "'self' 'unsafe-inline'",
    "img-src": "'self' blob: data:",
    "font-src": "'self' data:",
    "base-uri": "'none'",
    "form-action": "'none'",
    "frame-ancestors": "'none'",
}
# Pages that may show a page of a notebook: those of this machine, of the same origin behind a
# proxy, and of Visual Studio Code.
NOTEBOOKS = (
    "'self' http://localhost:* https://localhost:* http://127.0.0.1:* https://127.0.0.1:*"
    " vscode-webview: vscode-file:"
)
HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=(), usb=()",
    "Cache-Control": "no-store",
}
SIGN_OF_LIFE = "alive.svg"  # an empty picture, which a notebook loads beside the frame of a page
EMPTY_PICTURE = b'<svg xmlns="http://www.w3.org/2000/svg"/>'
REFUSAL_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8">{retry}
<meta name="viewport" content="width=device-width"><title>beamviz: {title}</title>
<style>
body {{ font: 17px/1.5 system-ui, sans-serif; margin: 18vh auto; max-width: 28em; padding: 0 1em;
       color-scheme: light dark; }}
p {{ opacity: .75 }} h1 {{ font-size: 1.5em; border-left: 5px solid #206096; padding-left: .6em }}
</style></head><body><h1>{title}</h1><p>{text}</p></body></html>
"""

log = RateLimitedLog(__name__)

Handler = Callable[[ServerConnection], Awaitable[None]]
Insert = Callable[[str], str]  # inserts elements into the HTML of viser's page
Key = tuple[Any, ...]  # identifies what a message sets: a later one with the same key replaces it


# Message validation


class InvalidMessage(Exception):
    """A message that the page does not send."""


class ControlValue(msgspec.Struct, forbid_unknown_fields=True):
    """The property of a control that a page may set."""

    value: str


class ControlUpdate(msgspec.Struct, forbid_unknown_fields=True):
    """A GuiUpdateMessage; viser itself would accept any attribute of the control."""

    uuid: str
    updates: ControlValue


def validate(raw: bytes | str) -> Key:
    """Check a message and return its key.

    Raises InvalidMessage for one that the page does not send, unknown fields, values out of range.
    """
    try:
        message = msgspec.msgpack.decode(raw if isinstance(raw, bytes) else b"")
        kind = message.pop("type")
        expected: Any = ControlUpdate if kind == CONTROL else message_types[kind]
        fields: Any = msgspec.convert(message, expected)
    except (msgspec.MsgspecError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InvalidMessage(f"{type(error).__name__} {str(error)[:80]}".strip()) from None
    if kind == CONTROL:
        return (kind, fields.uuid)
    if unknown := set(message) - set(vars(fields)):
        raise InvalidMessage(f"{kind} with {str(min(unknown))[:80]}")
    if not all(map(is_field_value, message.values())):
        raise InvalidMessage(f"{kind} with {str(message)[:80]}")
    if kind == "ViewerCameraMessage" and not (
        1 <= fields.image_width <= MAX_PIXELS and 1 <= fields.image_height <= MAX_PIXELS
    ):
        raise InvalidMessage(f"a page of {fields.image_width} x {fields.image_height} pixels")
    return (kind, *(message[name] for name in ("uuid", "name", "request_uuid") if name in message))


def is_field_value(value: Any) -> bool:
    """Whether a field may have this value: short, with finite numbers up to MAX_NUMBER."""
    if isinstance(value, list):
        return len(value) <= MAX_ITEMS and all(map(is_field_value, value))
    if isinstance(value, str):
        return len(value) <= MAX_TEXT
    return value is None or (isinstance(value, int | float) and abs(value) <= MAX_NUMBER)


class Connection(ServerConnection):
    """A visitor's connection: an invalid message closes it; messages above the rate limit are
    coalesced into the last one of each key."""

    def __init__(self, *args: Any, **options: Any):
        super().__init__(*args, **options)
        self.coalesced: dict[Key, bytes] = {}
        self.credit, self.updated = float(BURST), time.monotonic()

    async def recv(self, decode: bool | None = None) -> bytes:  # type: ignore[override]
        """The next valid message. Raises ConnectionClosed."""
        try:
            while not self.coalesced:
                key, raw = await self.receive_valid()
                if self.has_credit():
                    return raw
                await self.coalesce(key, raw)
        except InvalidMessage as error:
            log.warn(peer(self), "invalid message", f"closed for an invalid message: {error}")
            await self.close(POLICY_VIOLATION, "invalid message")
            raise self.protocol.close_exc from None
        return self.coalesced.pop(next(iter(self.coalesced)))

    async def receive_valid(self) -> tuple[Key, Any]:
        raw = await super().recv()
        return validate(raw), raw

    async def coalesce(self, key: Key, raw: bytes) -> None:
        """Receive for PAUSE seconds, keeping the last message of each key in order of arrival."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(PAUSE):
                while True:
                    self.coalesced.pop(key, None)
                    self.coalesced[key] = raw
                    key, raw = await self.receive_valid()

    def has_credit(self) -> bool:
        """Take a token from the token bucket; False if it is empty."""
        now = time.monotonic()
        self.credit = min(self.credit + (now - self.updated) * RATE, BURST)
        self.updated = now
        if self.credit < 1:
            return False
        self.credit -= 1
        return True


# Requests


@dataclass(frozen=True)
class Guard:
    """Checks every request and message before viser's server handles it.

    access: the rules; insert: changes the HTML of viser's page.
    """

    access: Access
    insert: Insert

    def serve(self, handler: Handler, *address: Any, **options: Any) -> Any:
        """Replacement for `websockets.asyncio.server.serve`."""
        page = options["process_request"]
        options |= {
            "process_request": lambda connection, request: self.answer(connection, request, page),
            "process_response": self.add_headers,
            "create_connection": Connection,
            "max_size": MAX_BYTES,
            "server_header": None,
            **dict.fromkeys(("open_timeout", "ping_interval", "ping_timeout"), TIMEOUT),
            "close_timeout": 2.0,
        }
        if self.access.listener:
            address, options = (), options | {"sock": self.access.listener}
        return serve(lambda connection: self.visit(connection, handler), *address, **options)

    def answer(
        self, connection: ServerConnection, request: Request, page: Callable[..., Response | None]
    ) -> Response | None:
        """Refuse a request, or pass it on to viser's `page` (None: the WebSocket may open)."""
        upgrade = header(request, "Upgrade").lower() == "websocket"
        if refusal := self.access.refused(request):
            title = refusal.title.lower()
            log.warn(peer(connection), title, f"refused: {title}")
        elif self.access.framed and request.path.endswith(f"/{SIGN_OF_LIFE}"):
            return reply(200, "OK", EMPTY_PICTURE, {"Content-Type": "image/svg+xml"})
        elif upgrade and header(request, "Sec-WebSocket-Protocol") != PROTOCOL:
            refusal = Refusal(400, "An old page", "Reload it.")
        elif not self.access.presents(request):
            refusal = self.access.full(self.access.visitor_count.total)
        if refusal:
            return refusal_page(refusal)
        if not upgrade and (cookie := self.access.key_cookie(request)):
            headers = {"Location": self.access.without_key(request), "Set-Cookie": cookie}
            return reply(303, "See Other", b"", headers)
        response = page(connection, self.access.for_viser(request))
        kind = response.headers.get("Content-Type", "") if response else ""
        if response and response.status_code == 200 and kind.startswith("text/html"):
            headers = dict(response.headers.raw_items())
            zipped = response.headers.get("Content-Encoding") == "gzip"
            body = changed_page(bytes(response.body), self.insert, zipped)
            return reply(200, "OK", body, headers)
        return response

    def add_headers(
        self, connection: ServerConnection, request: Request, response: Response
    ) -> Response:
        """Add the security headers; the page may connect to this server only, and one that belongs
        to a notebook be shown in it."""
        host, headers, policy = request.headers.get_all("Host")[:1], dict(HEADERS), CONTENT_POLICY
        if response.status_code < 400:
            connect = " ".join(["'self'", "blob:", "data:", *(f"ws://{h} wss://{h}" for h in host)])
            policy = policy | {"connect-src": connect}
            if self.access.framed:
                policy = policy | {"frame-ancestors": NOTEBOOKS}
                del headers["X-Frame-Options"]  # which has no list
        for name, value in headers.items():
            response.headers[name] = value
        response.headers["Content-Security-Policy"] = "; ".join(map(" ".join, policy.items()))
        return response

    async def visit(self, connection: ServerConnection, handler: Handler) -> None:
        """Serve and count a visitor, unless the limit has been reached since the request."""
        count, visitors = self.access.visitor_count, 1 - self.access.presents(connection.request)
        count.add(visitors)
        try:
            if visitors and self.access.full(count.total - 1):
                await connection.close(TRY_AGAIN_LATER, "too many visitors")
                return
            with contextlib.suppress(ConnectionClosed):  # visitors leave at any time
                await handler(connection)
        finally:
            count.add(-visitors)


@lru_cache(2)
def changed_page(body: bytes, insert: Insert, zipped: bool) -> bytes:
    """viser's page after `insert`, compressed as before."""
    changed = insert((gzip.decompress(body) if zipped else body).decode()).encode()
    return gzip.compress(changed) if zipped else changed


def refusal_page(refusal: Refusal) -> Response:
    """The page of a refusal, which is reloaded after RETRY if there were too many visitors."""
    retry = f'<meta http-equiv="refresh" content="{RETRY}">' if refusal.status == 503 else ""
    title, text = html.escape(refusal.title), html.escape(refusal.text)
    body = REFUSAL_PAGE.format(retry=retry, title=title, text=text)
    headers = {"Content-Type": "text/html; charset=utf-8"}
    headers |= {"Retry-After": str(RETRY)} if retry else {}
    return reply(refusal.status, refusal.title, body.encode(), headers)


def reply(status: int, reason: str, body: bytes, headers: dict[str, str]) -> Response:
    """A complete response, after which the connection is closed."""
    closing = {"Content-Length": str(len(body)), "Connection": "close"}
    return Response(status, reason, Headers({**headers, **closing}), body)


def peer(connection: ServerConnection) -> str:
    address = connection.remote_address
    return str(address[0]) if address else "a visitor who has left"
