"""What every connection passes: the access, the headers that tie a page's hands, the inbox."""

import contextlib
import html
import socket
from collections.abc import Awaitable, Callable
from typing import Any

from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from beamviz.server.access import Access, Refusal, VisitorCount, without_key
from beamviz.server.log import RateLimitedLog
from beamviz.server.messages import (
    MAX_PART_BYTES,
    MAX_PICTURE_BYTES,
    PICTURES,
    SENT,
    Inbox,
    Kinds,
    Senseless,
)
from beamviz.server.viser_private import PROTOCOL

POLICY_VIOLATION, TRY_AGAIN_LATER = 1008, 1013
PATIENCE = 10.0  # [s] for a request to come, and for a silent visitor to answer a ping
RETRY = 10  # [s] until a page that was turned away for want of room tries again

# The page is one file: its script and style stand in it, its pictures are made by it, and the
# glue of its compiled parts is made by eval. What counts is whom it may talk to: see `finish`.
CONTENT = {
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
HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=(), usb=()",
    "Cache-Control": "no-store",
}

log = RateLimitedLog(__name__)

Handler = Callable[[ServerConnection], Awaitable[None]]


class Connection(ServerConnection):
    """A visitor's connection; what makes no sense ends it."""

    kinds: Kinds = SENT
    inbox: Inbox | None = None

    async def recv(self, decode: bool | None = None) -> bytes:  # type: ignore[override]
        """The next message that makes sense."""
        self.inbox = self.inbox or Inbox(super().recv, self.kinds)
        try:
            return await self.inbox.next()
        except Senseless as error:
            words = f"sent off, for a message that makes no sense: {error}"
            log.warn(peer(self), "senseless", words)
            await self.close(POLICY_VIOLATION, "a message that makes no sense")
            raise self.protocol.close_exc from None


class Photographer(Connection):
    """A browser of our own, which sends pictures."""

    kinds: Kinds = SENT | PICTURES


class Guard:
    """Stands between viser's server and the network: a access, whom it has let in, whether pictures
    may come in as well, and what connections come from if not from the network itself."""

    def __init__(
        self,
        access: Access,
        visitor_count: VisitorCount,
        pictures: bool = False,
        listener: socket.socket | None = None,
    ):
        self.access, self.visitor_count = access, visitor_count
        self.pictures, self.listener = pictures, listener

    def serve(self, handler: Handler, *place: Any, **options: Any) -> Any:
        """In place of `websockets.asyncio.server.serve`."""
        page = options["process_request"]
        options |= {
            "process_request": lambda connection, request: self.answer(connection, request, page),
            "process_response": self.finish,
            "create_connection": Photographer if self.pictures else Connection,
            "max_size": MAX_PICTURE_BYTES if self.pictures else MAX_PART_BYTES,
            "server_header": None,
            "open_timeout": PATIENCE,
            "ping_interval": PATIENCE,
            "ping_timeout": PATIENCE,
            "close_timeout": 2.0,
        }
        if self.listener:
            place, options = (), options | {"sock": self.listener}
        return serve(lambda connection: self.visit(connection, handler), *place, **options)

    def answer(
        self, connection: ServerConnection, request: Request, page: Callable[..., Response | None]
    ) -> Response | None:
        """Turn a request away, or let viser answer it (None: a WebSocket may open)."""
        headers = read(request)
        if refusal := self.access.refused(headers, request.path):
            title = refusal.title.lower()
            log.warn(peer(connection), title, f"turned away: {title}")
            return turned_away(refusal)
        opening = headers.get("upgrade", "").lower() == "websocket"
        if opening and headers.get("sec-websocket-protocol") != PROTOCOL:
            return turned_away(Refusal(400, "An old page", "Reload it."))
        if not self.access.presents(headers, request.path) and (
            refusal := self.access.full(self.visitor_count.total)
        ):
            return turned_away(refusal)
        if not opening and (cookie := self.access.kept(headers, request.path)):
            headers = {"Location": without_key(request.path), "Set-Cookie": cookie}
            return reply(303, "See Other", b"", headers)
        return page(connection, request)

    def finish(
        self, connection: ServerConnection, request: Request, response: Response
    ) -> Response:
        """Add the security headers; only this server may be connected to from its page."""
        host = request.headers.get_all("Host")[:1]
        connect = " ".join(["'self'", "blob:", "data:", *(f"ws://{h} wss://{h}" for h in host)])
        policy = CONTENT | ({"connect-src": connect} if response.status_code < 400 else {})
        for name, value in HEADERS.items():
            response.headers[name] = value
        response.headers["Content-Security-Policy"] = "; ".join(map(" ".join, policy.items()))
        return response

    async def visit(self, connection: ServerConnection, handler: Handler) -> None:
        """Let a visitor in for as long as they stay, unless others were faster."""
        request = connection.request
        assert request
        if presents(self.access, request):
            await served(connection, handler)
            return
        self.visitor_count.enter()
        try:
            if self.access.full(self.visitor_count.total - 1):
                await connection.close(TRY_AGAIN_LATER, "the room is full")
            else:
                await served(connection, handler)
        finally:
            self.visitor_count.leave()


async def served(connection: ServerConnection, handler: Handler) -> None:
    """What viser does for a visitor, who may leave at any time."""
    with contextlib.suppress(ConnectionClosed):
        await handler(connection)


def presents(access: Access, request: Request | None) -> bool:
    """Whether who came with a request holds the presenter's key."""
    return request is not None and access.presents(read(request), request.path)


def read(request: Request) -> dict[str, str]:
    """The headers, names in lower case; what was given twice makes no sense afterwards."""
    names = {name.lower() for name in request.headers}
    return {name: ", ".join(request.headers.get_all(name)) for name in names}


def turned_away(refusal: Refusal) -> Response:
    """A refusal as a small page; for want of room, it tries again by itself."""
    retry = f'<meta http-equiv="refresh" content="{RETRY}">' if refusal.status == 503 else ""
    body = PAGE.format(
        retry=retry, title=html.escape(refusal.title), words=html.escape(refusal.words)
    )
    headers = {"Content-Type": "text/html; charset=utf-8"}
    if retry:
        headers["Retry-After"] = str(RETRY)
    return reply(refusal.status, refusal.title, body.encode(), headers)


def reply(status: int, reason: str, body: bytes, headers: dict[str, str]) -> Response:
    """A whole answer, after which the connection ends."""
    closing = {"Content-Length": str(len(body)), "Connection": "close"}
    return Response(status, reason, Headers({**headers, **closing}), body)


PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8">{retry}
<meta name="viewport" content="width=device-width"><title>beamviz: {title}</title>
<style>
body {{ font: 17px/1.5 system-ui, sans-serif; margin: 18vh auto; max-width: 28em; padding: 0 1em;
       color-scheme: light dark; }}
p {{ opacity: .75 }} h1 {{ font-size: 1.5em; border-left: 5px solid #206096; padding-left: .6em }}
</style></head><body><h1>{title}</h1><p>{words}</p></body></html>
"""


def peer(connection: ServerConnection) -> str:
    """Who is at the other end."""
    address = connection.remote_address
    return str(address[0]) if address else "a visitor who has left"
