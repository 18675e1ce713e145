"""Access to the server: addresses, origins, keys and the number of visitors."""

import contextlib
import hmac
import ipaddress
import re
import socket
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple
from urllib.parse import parse_qs, parse_qsl, urlencode, urlsplit

from websockets.http11 import Request

from beamviz.errors import InvalidInput
from beamviz.server.processes import Pipe, VisitorCount

LOOPBACK = ("127.0.0.1", "localhost", "::1")
ANY_ADDRESS = ("0.0.0.0", "::")
MAX_VISITORS = 60
KEY_PARAMETER = "token"  # of the query
KEY = re.compile(r"[\w-]{22,100}", re.ASCII)  # at least 128 bits where it is random
PLAIN = re.compile(r"(/[\w.~%@:+-]+)*/?", re.ASCII)  # a path that can be in a header as it is


class Refusal(NamedTuple):
    """A refused request: HTTP status, and title and text of its page."""

    status: int
    title: str
    text: str


@dataclass(frozen=True)
class Access:
    """The rules of a server bound to host:port; each check returns a Refusal, or None."""

    host: str = "127.0.0.1"
    port: int = 0
    visitor_key: str = ""  # that all visitors need; "": none
    presenter_key: str = ""  # "": no presenter
    public: str = ""  # the URL that a reverse proxy has for it, without a slash at its end
    # The page may be shown in a frame of a notebook; its key is a part of the path, as browsers
    # send no cookies of a frame.
    framed: bool = False
    max_visitors: int = MAX_VISITORS
    visitor_count: VisitorCount = field(default_factory=VisitorCount)  # of all processes
    listener: Pipe | None = None  # the source of the connections of a worker process

    @property
    def shared(self) -> bool:
        """Whether other machines can reach the server."""
        return bool(self.public) or self.host not in LOOPBACK

    @property
    def local_url(self) -> str:
        """The server's own URL, without a key."""
        name = network_address() if self.host in ANY_ADDRESS else self.host
        return f"http://{f'[{name}]' if ':' in name else name}:{self.port}"

    @property
    def url(self) -> str:
        """The link for visitors, with their key."""
        place = self.public or self.local_url
        if self.framed:
            return f"{place}/{self.visitor_key}/"
        return f"{place}/?{KEY_PARAMETER}={self.visitor_key}" if self.visitor_key else place

    @property
    def cookie(self) -> str:
        """The name of the cookie with the key. All ports of a host share their cookies, so it has
        the port; behind a reverse proxy it has not, as servers with one key may stand there."""
        return "beamviz" if self.public else f"beamviz-{self.port}"

    def refused(self, request: Request) -> Refusal | None:
        """Check the address, the origin and the key of a request."""
        host, origin = header(request, "Host"), header(request, "Origin")
        if not self.answers_to(host):
            remedy = (
                "give its address to beamviz.show as public_url"
                if self.framed
                else "start it with --public-url"
            )
            text = (
                f"This server does not answer to {host[:100]!r}. Use the link it printed when it"
                f" started; behind a reverse proxy, {remedy}."
            )
            return Refusal(403, "Wrong address", text)
        expected = f"{self.scheme(host)}://{host.lower()}"
        if "Origin" in request.headers and origin.lower() != expected:
            return Refusal(403, "Foreign origin", "A page of another site may not use this one.")
        keys = (self.visitor_key, self.presenter_key)
        if self.visitor_key and not matches(keys, self.key_of(request)):
            text = (
                "Ask the person who runs this page for its complete link, which ends in"
                f" ?{KEY_PARAMETER}= and a key."
            )
            if self.framed:
                text = "This page is that of another cell, or of another run: run the cell again."
            return Refusal(403, "A key is missing", text)
        return None

    def full(self, visitors: int) -> Refusal | None:
        """Check whether another visitor may connect."""
        if visitors < self.max_visitors:
            return None
        text = f"The limit here is {self.max_visitors} at once. This page tries again by itself."
        return Refusal(503, "Too many visitors", text)

    def answers_to(self, host: str) -> bool:
        """Whether a Host header names this server. Numerical addresses are accepted on a network:
        unlike names, they are safe against DNS rebinding. The port may be that of an SSH tunnel or
        of a container: what protects is the name, and that `Origin` agrees with it."""
        if self.is_public(host):
            return True
        name = host_name(host)
        if self.host in ANY_ADDRESS:
            return names_this_machine(name)
        return name in LOOPBACK or name == self.host.lower()

    def is_public(self, host: str) -> bool:
        """Whether a Host header names the reverse proxy."""
        return bool(self.public) and host.lower() == urlsplit(self.public).netloc

    def scheme(self, host: str) -> str:
        """The scheme of the page's URL: http, or that of the reverse proxy."""
        return urlsplit(self.public).scheme if self.is_public(host) else "http"

    @property
    def public_path(self) -> str:
        """The path under which a reverse proxy has the server, "" for that of its host."""
        return urlsplit(self.public).path

    def own_path(self, request: Request) -> str:
        """Path and query of a request without the path of the reverse proxy, which may have removed
        it already."""
        rest = request.path.removeprefix(self.public_path)
        if not rest or rest.startswith("?"):
            return f"/{rest}"
        return rest if rest.startswith("/") else request.path

    def for_viser(self, request: Request) -> Request:
        """A request without what viser's server does not know: the proxy's path and the key."""
        path = self.own_path(request)
        if self.framed:
            path = f"/{path.partition('?')[0].lstrip('/').partition('/')[2]}"
        return replace(request, path=path)

    def presents(self, request: Request | None) -> bool:
        """Whether a request, None after its visitor has left, has the presenter's key."""
        return request is not None and matches((self.presenter_key,), self.key_of(request))

    def key_of(self, request: Request) -> str:
        """The key in the query of a request, else in its cookie, else ""; in the path of a page in
        a frame."""
        if self.framed:
            return self.own_path(request).partition("?")[0].lstrip("/").partition("/")[0]
        if key := query_key(request):
            return key
        pairs = (pair.strip().partition("=") for pair in header(request, "Cookie").split(";"))
        return next((value for name, _, value in pairs if name == self.cookie), "")

    def key_cookie(self, request: Request) -> str:
        """The Set-Cookie header that stores the key of the query; "" without a valid key. Lax, not
        Strict, so that links in e-mails work, which redirect to the page without the key."""
        key, host = query_key(request), header(request, "Host")
        if self.framed or not matches((self.visitor_key, self.presenter_key), key):
            return ""
        # viser's page opens its WebSocket at the path without a slash at its end.
        path = (self.is_public(host) and self.public_path) or "/"
        secure = "; Secure" if self.scheme(host) == "https" else ""
        return f"{self.cookie}={key}; Path={path}; HttpOnly; SameSite=Lax{secure}"

    def without_key(self, request: Request) -> str:
        """The address of the page with the query of a request, without the key. That of a reverse
        proxy is complete: some proxies put their path in front of any other, some do not."""
        pairs = parse_qsl(urlsplit(request.path).query, keep_blank_values=True)
        rest = urlencode([(name, value) for name, value in pairs if name != KEY_PARAMETER])
        place = self.public if self.is_public(header(request, "Host")) else ""
        return f"{place}/?{rest}" if rest else f"{place}/"


def header(request: Request, name: str) -> str:
    """A header of a request, "" without one; repeated ones are joined: no check accepts them."""
    return ", ".join(request.headers.get_all(name))


def query_key(request: Request) -> str:
    return parse_qs(urlsplit(request.path).query).get(KEY_PARAMETER, [""])[0]


def key_of_file(path: Path) -> str:
    """The key in a file, by which servers behind one address let the same visitors in. Raises
    InvalidInput for a file that cannot be read or for a key that could be guessed or is no part of
    a URL as it is."""
    try:
        key = path.read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not a text"
        raise InvalidInput(f"key-file = {path}: cannot be read ({reason})") from None
    if not KEY.fullmatch(key):
        raise InvalidInput(
            f"key-file = {path}: must contain one key of 22 to 100 letters, digits, - and _;"
            " make one with: openssl rand -hex 16"
        )
    return key


def matches(keys: tuple[str, ...], given: str) -> bool:
    """Whether `given` is one of the nonempty `keys`, in a time that does not depend on them."""
    encoded = given.encode(errors="replace")
    matched = [hmac.compare_digest(key.encode(), encoded) for key in keys if key]
    return any(matched)


def host_name(host: str) -> str:
    """The name in a Host header; "" if it is malformed."""
    with contextlib.suppress(ValueError):
        parts = urlsplit(f"//{host}")
        if parts.netloc == host and "@" not in host and parts.port != 0:
            return parts.hostname or ""
    return ""


def network_address() -> str:
    """The address of this machine on its network, found without sending anything."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # an address reserved for documentation
        except OSError:
            return "localhost"
        return str(probe.getsockname()[0])


def names_this_machine(name: str) -> bool:
    """Whether a name, in lower case, is a name of this machine or any address."""
    with contextlib.suppress(ValueError):
        return bool(ipaddress.ip_address(name))
    machine = socket.gethostname().lower()
    return name in ("localhost", machine, f"{machine}.local", machine.partition(".")[0])


def public_url(text: str, name: str = "public-url") -> str:
    """The URL of a reverse proxy, without a slash at its end: a scheme, a host, and the path under
    which it has the server, if any. Raises InvalidInput for anything else, with the name."""
    parts = urlsplit(text)
    known = parts.scheme.lower() in ("http", "https") and PLAIN.fullmatch(parts.path)
    if not (known and parts.netloc) or "@" in parts.netloc or parts.query or parts.fragment:
        raise InvalidInput(
            f"{name} = {text}: must be a scheme, a host and the path there, if any,"
            " like https://beams.example.org or https://example.org/beams/"
        )
    return f"{parts.scheme}://{parts.netloc}".lower() + parts.path.rstrip("/")
