"""What a visitor's page may send: known messages with sensible fields, and not too many of them."""

import asyncio
import math
import time
from collections.abc import Awaitable, Callable
from typing import Any

import msgspec

from beamviz.server.viser_private import messages

MAX_BYTES = 64_000  # of one message
MAX_FILE_BYTES = 1_000_000_000  # that somebody may try to load; save_load.py takes small ones
MAX_PART_BYTES = 600_000  # of one that is part of a file: a page sends 512 kB of it at a time
MAX_TEXT = 1000
MAX_ITEMS = 64
MAX_SIZE = 1e6  # of a number that says where something is
MAX_PIXELS = 32768
RATE, BURST = 200, 400  # messages a second that pass as they come, and how many at once
PAUSE = 0.05  # [s] over which what comes faster is gathered

Kinds = dict[str, type]

SENT: Kinds = messages(
    "ViewerCameraMessage",
    "GuiUpdateMessage",
    "CommandTriggerMessage",
    "SceneNodeClickMessage",
    "SceneNodeDragMessage",
    "ScenePointerMessage",
    "TransformControlsUpdateMessage",
    "TransformControlsDragStartMessage",
    "TransformControlsDragEndMessage",
    "LocalStorageGetItemResponseMessage",
    "FileTransferStartUpload",
    "FileTransferPart",
)
PICTURES: Kinds = messages("GetRenderResponseMessage")
MAX_PICTURE_BYTES = 50_000_000


class Senseless(Exception):
    """A message that no page of ours sends."""


def checked(raw: bytes | str, kinds: Kinds = SENT) -> tuple[Any, ...]:
    """What a message is about: of two messages about the same, the later one counts.

    Raises Senseless for what is no message, or not of one of `kinds`.
    """
    try:
        message = msgspec.msgpack.decode(raw if isinstance(raw, bytes) else b"")
        kind = message.pop("type")
        fields: Any = msgspec.convert(message, kinds[kind])
    except (msgspec.MsgspecError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise Senseless(f"{type(error).__name__} {str(error)[:80]}".strip()) from None
    if len(raw) > MAX_BYTES and kind not in ("FileTransferPart", *PICTURES):
        raise Senseless(f"{kind} of {len(raw)} bytes")
    if unknown := set(message) - set(vars(fields)):
        raise Senseless(f"{kind} with {str(min(unknown))[:80]}")
    if kind == "GuiUpdateMessage":
        if set(fields.updates) != {"value"} or not plain(fields.updates["value"]):
            raise Senseless(f"a control cannot be set to {str(fields.updates)[:80]}")
        return (kind, fields.uuid)
    if kind == "FileTransferStartUpload" and 0 <= fields.size_bytes <= MAX_FILE_BYTES:
        del message["size_bytes"]  # no mistake, only too large for us
    if not all(map(small, message.values())):
        raise Senseless(f"{kind} with {str(message)[:80]}")
    if kind == "ViewerCameraMessage" and not (
        1 <= fields.image_width <= MAX_PIXELS and 1 <= fields.image_height <= MAX_PIXELS
    ):
        raise Senseless(f"a page of {fields.image_width} x {fields.image_height} pixels")
    return (kind, *(message[name] for name in ("uuid", "name", "request_uuid") if name in message))


def plain(value: Any) -> bool:
    """Whether a value is one that a control can have: a number, a word, or a few of them."""
    if isinstance(value, list):
        nested = any(isinstance(item, list) for item in value)
        return len(value) <= MAX_ITEMS and not nested and all(map(plain, value))
    if isinstance(value, str):
        return len(value) <= MAX_TEXT
    return isinstance(value, bool | int | float)


def small(value: Any) -> bool:
    """Whether a field is short, and every number in it finite and of a size to draw."""
    if isinstance(value, list):
        return len(value) <= MAX_ITEMS and all(map(small, value))
    if isinstance(value, str):
        return len(value) <= MAX_BYTES
    if isinstance(value, bool) or value is None:
        return True
    if isinstance(value, bytes):
        return True  # as long as the whole message may be
    return isinstance(value, int | float) and math.isfinite(value) and abs(value) <= MAX_SIZE


class Inbox:
    """One visitor's messages in order. Those that come too fast are gathered for a moment and
    only the last about each thing is kept, so a flood ends where it would have ended.

    Raises Senseless, and whatever `receive` raises.
    """

    def __init__(self, receive: Callable[[], Awaitable[bytes | str]], kinds: Kinds = SENT):
        self.receive, self.kinds = receive, kinds
        self.gathered: dict[tuple[Any, ...], bytes] = {}
        self.credit, self.seen = float(BURST), time.monotonic()

    async def next(self) -> bytes:
        """The next message."""
        while not self.gathered:
            key, raw = await self.one()
            if self.paid():
                return raw
            self.gathered[key] = raw
            await self.gather()
        return self.gathered.pop(next(iter(self.gathered)))

    async def one(self) -> tuple[tuple[Any, ...], bytes]:
        """A message as it comes, and what it is about."""
        raw = await self.receive()
        key = checked(raw, self.kinds)
        return key, raw if isinstance(raw, bytes) else b""

    async def gather(self) -> None:
        """Take in what comes during a moment."""
        end = asyncio.get_running_loop().time() + PAUSE
        try:
            async with asyncio.timeout_at(end):
                while True:
                    key, raw = await self.one()
                    self.gathered.pop(key, None)  # the order is that of the last ones
                    self.gathered[key] = raw
        except TimeoutError:
            return

    def paid(self) -> bool:
        """Whether one more message is within the rate; monotonic, so no clock can jump."""
        now = time.monotonic()
        self.credit = min(self.credit + (now - self.seen) * RATE, BURST)
        self.seen = now
        if self.credit < 1:
            return False
        self.credit -= 1
        return True
