"""Who may come in: addresses answered to, pages allowed to connect, keys, and how many visitors."""

import hmac
import ipaddress
import mmap
import socket
from collections.abc import Mapping
from dataclasses import dataclass
from urllib.parse import parse_qs, parse_qsl, urlencode, urlsplit

from beamviz.errors import InvalidInput

LOOPBACK = ("127.0.0.1", "localhost", "::1")
ANY_ADDRESS = ("0.0.0.0", "::")
HTTP_PORT = 80
MAX_VISITORS = 60
KEY_PARAMETER = "token"
ITEM = 8  # bytes of a count


@dataclass(frozen=True)
class Refusal:
    """Why a request is turned away, in words for people."""

    status: int
    title: str
    words: str


@dataclass(frozen=True)
class Access:
    """What a server bound to host:port answers to; each check returns a Refusal, or None.

    visitor_key: the key that every visitor needs ("": none); presenter_key: the key of who leads
    ("": nobody does); public: the URL under which a reverse proxy passes requests on.
    """

    host: str
    port: int
    visitor_key: str = ""
    presenter_key: str = ""
    public: str = ""
    max_visitors: int = MAX_VISITORS

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys that open this access; with none, it is open to whoever reaches it."""
        return (
            tuple(key for key in (self.visitor_key, self.presenter_key) if key)
            if self.visitor_key
            else ()
        )

    @property
    def url(self) -> str:
        """The link that visitors need."""
        name = reachable() if self.host in ANY_ADDRESS else self.host
        here = f"http://{f'[{name}]' if ':' in name else name}:{self.port}"
        return (self.public or here) + (
            f"/?{KEY_PARAMETER}={self.visitor_key}" if self.visitor_key else ""
        )

    @property
    def cookie(self) -> str:
        """The cookie that keeps a key; cookies know no ports, so its name does."""
        return f"beamviz-{self.port}"

    def refused(self, headers: Mapping[str, str], path: str) -> Refusal | None:
        """Why a request is turned away, from its headers (names in lower case) and path."""
        host = headers.get("host", "")
        if not self.answers_to(host):
            return Refusal(403, "Wrong address", self.wrong_address(host))
        origin = headers.get("origin")
        if origin is not None and origin.lower() != f"{self.scheme(host)}://{host.lower()}":
            return Refusal(403, "Not from here", "A page of another site may not use this one.")
        if self.keys and not self.holds(self.keys, given(headers, path, self.cookie)):
            return Refusal(403, "A key is missing", "Ask who runs this page for its complete link,"
                           f" which ends in ?{KEY_PARAMETER}= and a key.")  # fmt: skip
        return None

    def full(self, visitors: int) -> Refusal | None:
        """Whether one more is too many."""
        if visitors < self.max_visitors:
            return None
        words = f"The limit here is {self.max_visitors} at once. This page tries again by itself."
        return Refusal(503, "The room is full", words)

    def answers_to(self, host: str) -> bool:
        """Whether a Host header names this server. A name that somebody made point here (DNS
        rebinding) does not; an address made of digits cannot be such a name."""
        if self.public and host.lower() == urlsplit(self.public).netloc:
            return True
        name, port = split(host)
        if port != self.port:
            return False
        if self.host in LOOPBACK:
            return name in LOOPBACK
        if self.host in ANY_ADDRESS:
            return is_address(name) or name in own_names()
        return name == self.host.lower()

    def scheme(self, host: str) -> str:
        """http, or what the reverse proxy speaks."""
        public = urlsplit(self.public)
        return public.scheme if host.lower() == public.netloc else "http"

    def wrong_address(self, host: str) -> str:
        """What to do about a Host header that is not ours."""
        return (
            f"This server does not answer to {host[:100]!r}. Use the link it printed when it"
            " started; behind a reverse proxy, start it with --public-url."
        )

    def presents(self, headers: Mapping[str, str], path: str) -> bool:
        """Whether a request that came in holds the presenter's key."""
        key = given(headers, path, self.cookie)
        return bool(self.presenter_key) and self.holds((self.presenter_key,), key)

    def kept(self, headers: Mapping[str, str], path: str) -> str:
        """The Set-Cookie header for a key given in the path, "" where none was.

        Lax, not Strict: a link in a mail must work, and it leads back here without the key.
        """
        parts = urlsplit(path)
        key = parse_qs(parts.query).get(KEY_PARAMETER, [""])[0]
        if not self.holds((self.visitor_key, self.presenter_key), key):
            return ""
        secure = "; Secure" if self.scheme(headers.get("host", "")) == "https" else ""
        return f"{self.cookie}={key}; Path=/; HttpOnly; SameSite=Lax{secure}"

    def holds(self, keys: tuple[str, ...], key: str) -> bool:
        """Whether `key` is one of `keys`, in a time that says nothing about them."""
        given = key.encode(errors="replace")
        matches = [hmac.compare_digest(known.encode(), given) for known in keys if known]
        return any(matches)


def without_key(path: str) -> str:
    """Where a link with a key leads once the key is kept: the page, with the rest of its query."""
    pairs = parse_qsl(urlsplit(path).query, keep_blank_values=True)
    rest = urlencode([(name, value) for name, value in pairs if name != KEY_PARAMETER])
    return f"/?{rest}" if rest else "/"


def given(headers: Mapping[str, str], path: str, cookie: str) -> str:
    """The key in a request: in its path, else in its cookie, else ""."""
    if keys := parse_qs(urlsplit(path).query).get(KEY_PARAMETER):
        return keys[0]
    pairs = (pair.strip().partition("=") for pair in headers.get("cookie", "").split(";"))
    return next((value for name, _, value in pairs if name == cookie), "")


def split(host: str) -> tuple[str, int | None]:
    """Name and port of a Host header; no port where it makes no sense."""
    try:
        parts = urlsplit(f"//{host}")
        if parts.netloc != host or "@" in host:
            return "", None
        return (parts.hostname or ""), (parts.port or HTTP_PORT)
    except ValueError:
        return "", None


def is_address(name: str) -> bool:
    """Whether a host is an address made of digits."""
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def reachable() -> str:
    """This machine's address on its network, as the system would choose it; nothing is sent."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # an address kept for documentation
        except OSError:
            return "localhost"
        return str(probe.getsockname()[0])


def own_names() -> set[str]:
    """The names of this machine on its own network."""
    name = socket.gethostname().lower()
    return {"localhost", name, f"{name}.local", name.partition(".")[0]}


def public_url(text: str) -> str:
    """The URL of a reverse proxy, checked: a scheme and a host, nothing else."""
    parts = urlsplit(text.lower())
    if parts.scheme not in ("http", "https") or not parts.netloc or parts.path.strip("/"):
        raise InvalidInput(
            f"public-url = {text}: must be a scheme and a host, like https://beams.example.org"
        )
    return f"{parts.scheme}://{parts.netloc}"


class VisitorCount:
    """A count for each process, in memory they share: each changes its own, all see the total."""

    def __init__(self, processes: int = 1):
        self.counts = memoryview(mmap.mmap(-1, ITEM * processes)).cast("q")
        self.number = 0  # of this process

    @property
    def total(self) -> int:
        """Visitors in all processes."""
        return sum(self.counts)

    def enter(self) -> None:
        """One more has come to this process."""
        self.counts[self.number] += 1

    def leave(self) -> None:
        """One has gone."""
        self.counts[self.number] -= 1
