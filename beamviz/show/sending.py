"""How messages leave for a visitor: viser's own way costs more than the picture that it sends.

In place of viser's producer (a task for each visitor that gathers messages and sends them), for
the time that a server of ours runs. What is sent is the same, byte for byte.
"""

import asyncio
import contextlib
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any
from unittest import mock

import msgspec.msgpack
import numpy as np
import zstandard
from viser import _messages
from viser.infra import _infra
from viser.infra._async_message_buffer import AsyncMessageBuffer
from viser.infra._messages import Message, _prepare_for_serialization
from websockets.asyncio.server import ServerConnection
from websockets.protocol import OPEN

ALIGNMENT = 8  # bytes


class Near:
    """An event loop as a thread sees it that may be its own: that one need not wake it."""

    def __init__(self, loop: asyncio.AbstractEventLoop):
        self.loop, self.thread = loop, threading.get_ident()

    def call_soon_threadsafe(self, callback: Callable[[], Any]) -> None:
        """Call soon, or here and now."""
        if threading.get_ident() == self.thread:
            callback()
        else:
            self.loop.call_soon_threadsafe(callback)


@contextlib.contextmanager
def lean() -> Iterator[None]:
    """Within, connections that come are served in this way."""
    usual = _infra._message_producer

    async def produce(
        connection: ServerConnection, buffer: AsyncMessageBuffer, *given: Any, **options: Any
    ) -> None:
        if buffer.persistent_messages:  # what is sent to all, and kept for those who come later
            await usual(connection, buffer, *given, **options)
        else:
            await send(connection, buffer)

    with mock.patch.object(_infra, "_message_producer", produce):
        yield


async def send(connection: ServerConnection, buffer: AsyncMessageBuffer) -> None:
    """Send what comes to a visitor's buffer, as long as they stay: at once after a pause or where
    it is flushed, else a window later."""
    buffer.event_loop = Near(asyncio.get_running_loop())  # type: ignore[assignment]
    compress = zstandard.ZstdCompressor(level=1).compress
    sent, last = -1, 0.0
    while not buffer.done:
        await buffer.message_event.wait()
        left = last + buffer.window_duration_sec - time.monotonic()
        if left > 0:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(left):
                    await buffer.flush_event.wait()
        buffer.flush_event.clear()
        buffer.message_event.clear()
        while window := gathered(buffer, sent):
            sent, messages = window
            last = time.monotonic()
            data = packed(messages, compress)
            if (
                connection.protocol.state is OPEN
                and not connection.transport.get_write_buffer_size()
            ):
                connection.protocol.send_binary(data)
                connection.send_data()
            else:  # wait until there is room, or end
                await connection.send(data)


def gathered(buffer: AsyncMessageBuffer, sent: int) -> tuple[int, list[Message]] | None:
    """The number of the last message taken out, and the messages after number `sent`, as many as
    go in one group; None where there are none, or they are not complete."""
    with buffer.buffer_lock:
        waiting = [k for k in buffer.message_from_id if k > sent][: buffer.max_window_size]
        if buffer.atomic_counter or not waiting:
            return None
        found = [buffer.pop_message_locked(k) for k in waiting]
    return waiting[-1], [message for message in found if message is not None]


def packed(messages: Sequence[Message], compress: Callable[[bytes], bytes]) -> bytes:
    """A group of messages as viser's page reads it: sizes, compressed text, then the arrays."""
    arrays: list[Any] = []
    text = msgspec.msgpack.encode(
        {
            "messages": [plain(message, arrays) for message in messages],
            "timestampSec": time.perf_counter(),
            "binaryBufferLengths": [array.nbytes for array in arrays],
        }
    )
    small = compress(text)
    parts: list[Any] = [len(text).to_bytes(8, "little"), len(small).to_bytes(8, "little"), small]
    size = 2 * ALIGNMENT + len(small)
    for array in arrays:
        parts += [bytes(-size % ALIGNMENT), array]
        size += -size % ALIGNMENT + array.nbytes
    return b"".join(parts)


def plain(message: Message, arrays: list[Any]) -> dict[str, Any]:
    """A message as a dictionary; its arrays go to `arrays`."""
    if type(message) is not _messages.SceneNodeUpdateMessage:
        return message.as_serializable_dict(arrays)
    updates = {name: lifted(value, arrays) for name, value in message.updates.items()}
    kind = "SceneNodeUpdateMessage"
    return {"name": message.name, "updates": updates, "owner": message.owner, "type": kind}


def lifted(value: Any, arrays: list[Any]) -> Any:
    """A value of a node; of an array, where it is to be found."""
    if isinstance(value, np.ndarray) and value.flags.c_contiguous:
        arrays.append(value.data)
        return {"__binary_index": len(arrays) - 1, "dtype": value.dtype.str}
    return _prepare_for_serialization(value, Any, arrays)
