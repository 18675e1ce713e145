"""How messages leave for a visitor: viser's own way costs more than the picture that it sends.

What is sent is the same, byte for byte.
"""

import asyncio
import contextlib
import time
from collections.abc import Callable, Sequence
from typing import Any

import msgspec.msgpack
import zstandard
from websockets.asyncio.server import ServerConnection
from websockets.protocol import OPEN

from beamviz.server.viser_private import Outbox

ALIGNMENT = 8  # bytes
PAUSE = 0.08  # [s] between two groups, unless the second is urgent


async def send(connection: ServerConnection, outbox: Outbox) -> None:
    """Send what comes to a visitor's outbox, as long as they stay: pictures at once, and with them
    all that has gathered in between, which waits for the next one, but not for long."""
    compress = zstandard.ZstdCompressor(level=1).compress
    last = 0.0
    while not outbox.over:
        await outbox.come.wait()
        left = last + PAUSE - time.monotonic()
        if left > 0 and not outbox.urgent.is_set():
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(left):
                    await outbox.urgent.wait()
        outbox.urgent.clear()
        outbox.come.clear()
        while (taken := outbox.taken())[0]:
            last = time.monotonic()
            await put(connection, packed(*taken, compress))


async def put(connection: ServerConnection, data: bytes) -> None:
    """Send some data: at once where there is room, else wait for it, or end."""
    if connection.protocol.state is OPEN and not connection.transport.get_write_buffer_size():
        connection.protocol.send_binary(data)
        connection.send_data()
    else:
        await connection.send(data)


def packed(
    messages: Sequence[dict[str, Any]],
    arrays: Sequence[memoryview],
    compress: Callable[[bytes], bytes],
) -> bytes:
    """A group of messages as viser's page reads it: sizes, compressed text, then the arrays."""
    text = msgspec.msgpack.encode(
        {
            "messages": messages,
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
