"""The one file that reaches into viser; what runs by it is protected and sends cheaply.

A viser server here hears the network only through a guard, sends by a way of ours, opens no public
tunnel and keeps no file that was not asked for. All that needs attributes and modules which viser
calls private, and they change without notice: so it runs with the versions it was tested with, and
with no other. No other module touches them (tests/server/test_internals.py).
"""

import asyncio
import contextlib
import io
import threading
import warnings
from collections.abc import Awaitable, Callable, Iterable, Iterator
from typing import Any
from unittest import mock

import numpy as np
import viser
import websockets
import websockets.asyncio.server
from viser import _messages
from viser.infra import _infra
from viser.infra._async_message_buffer import AsyncMessageBuffer
from viser.infra._messages import Message, _prepare_for_serialization
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request

from beamviz.errors import Unavailable
from beamviz.server.log import RateLimitedLog
from beamviz.signals import defer_signals

TESTED = {"viser": "1.1.1", "websockets": "16.1"}  # what their versions begin with
PROTOCOL = f"viser-v{viser.__version__}"
INTERNAL_ERROR = 1011

log = RateLimitedLog(__name__)

Serve = Callable[..., Any]  # as websockets.asyncio.server.serve
Send = Callable[[ServerConnection, "Outbox"], Awaitable[None]]
Upload = _messages.FileTransferStartUpload


def check_attributes() -> None:
    """Raises Unavailable for versions that this was not tested with."""
    found = {"viser": viser.__version__, "websockets": websockets.__version__}
    for name, tested in TESTED.items():
        if not f"{found[name]}.".startswith(f"{tested}."):
            raise Unavailable(
                f"{name} {found[name]} is not one that the server's protection was tested with:"
                f" pip install '{name}=={tested}.*'"
            )


# The server


@contextlib.contextmanager
def running(host: str, port: int, serve: Serve, send: Send) -> Iterator[viser.ViserServer]:
    """A viser server, stopped on leaving: it hears the network through `serve` and sends to each
    visitor by `send`. Raises Unavailable for versions that this was not tested with."""
    check_attributes()
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection")  # who left mid-picture
    with contextlib.ExitStack() as stack:
        with defer_signals(), silence(), heard_through(serve):
            server = viser.ViserServer(host=host, port=port, verbose=False)
            stack.callback(stopped, server)
        with lean(send), mock.patch.object(server, "request_share_url", return_value=None):
            yield server  # otherwise any visitor could open a public tunnel by a message


@contextlib.contextmanager
def heard_through(serve: Serve) -> Iterator[None]:
    """What viser builds within hears the network through `serve` alone."""
    used = []

    def guarded(*given: Any, **options: Any) -> Any:
        used.append(True)
        asyncio.get_running_loop().set_exception_handler(told)
        return serve(*given, **options)

    with mock.patch.object(websockets.asyncio.server, "serve", guarded):
        yield
    if not used:
        raise Unavailable("viser did not build its server as expected: it would be unprotected")


def stopped(server: viser.ViserServer) -> None:
    """Stop a server."""
    with silence():
        server.stop()


@contextlib.contextmanager
def silence() -> Iterator[None]:
    """Keep viser's banners off stdout, which is for data."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield


# Visitors


def handshake_request(server: viser.ViserServer, visitor: int) -> Request | None:
    """The request that a visitor, by client id, came with; None for one who has left."""
    connection = server._websock_server._live_connections.get(visitor)
    return connection.request if connection else None


def disconnect(server: viser.ViserServer, visitor: int) -> None:
    """End the connection of a visitor, by client id."""
    connection = server._websock_server._live_connections.get(visitor)
    if connection:
        closing = connection.close(INTERNAL_ERROR, "something went wrong here")
        asyncio.run_coroutine_threadsafe(closing, server.get_event_loop())


def filter_uploads(client: viser.ClientHandle, welcome: Callable[[Upload], bool]) -> None:
    """Ask `welcome` about every file before viser hears of it, which would keep all parts of it in
    memory, as many as a visitor cares to announce. One that is not welcome is over at once, as far
    as the page knows."""
    line, take = client.gui._websock_interface, client.gui._handle_file_transfer_start

    def announced(visitor: Any, upload: Upload) -> None:
        if welcome(upload):
            take(visitor, upload)
            return
        size = upload.size_bytes
        line.queue_message(
            _messages.FileTransferPartAck(
                upload.source_component_uuid, upload.transfer_uuid, size, size
            )
        )

    line.unregister_handler(Upload, take)
    line.register_handler(Upload, announced)


def messages(*names: str) -> dict[str, type]:
    """Kinds of messages, by their names."""
    return {name: getattr(_messages, name) for name in names}


# What is sent


@contextlib.contextmanager
def lean(send: Send) -> Iterator[None]:
    """Within, `send` is what sends to connections that come, in place of viser's producer."""
    usual = _infra._message_producer

    async def produce(
        connection: ServerConnection, buffer: AsyncMessageBuffer, *given: Any, **options: Any
    ) -> None:
        if buffer.persistent_messages:  # what is sent to all, and kept for those who come later
            await usual(connection, buffer, *given, **options)
        else:
            await send(connection, Outbox(buffer))

    with mock.patch.object(_infra, "_message_producer", produce):
        yield


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


class Outbox:
    """What waits to be sent to one visitor; come, urgent: set when there is more, and when that is
    not to wait."""

    def __init__(self, buffer: AsyncMessageBuffer):
        buffer.event_loop = Near(asyncio.get_running_loop())  # type: ignore[assignment]
        self.buffer, self.sent = buffer, -1
        self.come, self.urgent = buffer.message_event, buffer.flush_event

    @property
    def over(self) -> bool:
        """Whether the visitor has left."""
        return self.buffer.done

    def taken(self) -> tuple[list[dict[str, Any]], list[memoryview]]:
        """Messages as dictionaries, as many as go in one group, and the arrays they refer to;
        none while a picture is not complete."""
        buffer = self.buffer
        with buffer.buffer_lock:
            if buffer.atomic_counter:
                return [], []
            waiting = [k for k in buffer.message_from_id if k > self.sent]
            waiting = waiting[: buffer.max_window_size]
            found = [buffer.pop_message_locked(k) for k in waiting]
        self.sent = waiting[-1] if waiting else self.sent
        arrays: list[memoryview] = []
        return [plain(message, arrays) for message in found if message is not None], arrays


def plain(message: Message, arrays: list[memoryview]) -> dict[str, Any]:
    """A message as a dictionary; its arrays go to `arrays`."""
    if type(message) is not _messages.SceneNodeUpdateMessage:
        return message.as_serializable_dict(arrays)
    updates = {name: lifted(value, arrays) for name, value in message.updates.items()}
    kind = "SceneNodeUpdateMessage"
    return {"name": message.name, "updates": updates, "owner": message.owner, "type": kind}


def lifted(value: Any, arrays: list[memoryview]) -> Any:
    """A value of a node; of an array, where it is to be found."""
    if isinstance(value, np.ndarray) and value.flags.c_contiguous:
        arrays.append(value.data)
        return {"__binary_index": len(arrays) - 1, "dtype": value.dtype.str}
    return _prepare_for_serialization(value, Any, arrays)


# Properties, assigned without viser's own checks, copies and callbacks


def set_properties(node: viser.SceneNodeHandle, properties: dict[str, np.ndarray]) -> None:
    """Assign several properties of a node in one message, unread and unchecked: a third of the
    cost, where every visitor's beam is assigned 25 times a second."""
    for name, value in properties.items():
        setattr(node._impl.props, name, value)
    message = _messages.SceneNodeUpdateMessage(node.name, dict(properties))
    node._impl.api._queue_scene_message(message)


def set_orientation(node: viser.SceneNodeHandle, wxyz: tuple[float, float, float, float]) -> None:
    """Turn a node in the same way, unless it stands so already."""
    if node._impl.wxyz.tolist() != list(wxyz):
        node._impl.wxyz[:] = wxyz
        node._impl.api._queue_scene_message(_messages.SetOrientationMessage(node.name, wxyz))


def set_position(node: viser.SceneNodeHandle, position: Iterable[float]) -> None:
    """Move a node in the same way, unless it is there already."""
    place: Any = tuple(map(float, position))
    if tuple(node._impl.position.tolist()) != place:
        node._impl.position[:] = place
        node._impl.api._queue_scene_message(_messages.SetPositionMessage(node.name, place))


def set_html(text: viser.GuiHtmlHandle, content: str) -> None:
    """Write a text in the same way, unless it says so already."""
    state: Any = text._impl
    if state.props.content != content:
        state.props.content = content
        state.gui_api._websock_interface.queue_message(
            _messages.GuiUpdateMessage(state.uuid, {"content": content})
        )


def stop_sync(control: viser.GuiInputHandle) -> None:
    """Spare a control the messages to other visitors about each change: it is one visitor's."""
    control._impl.sync_cb = None


def set_value(control: viser.GuiInputHandle, value: Any) -> None:
    """Show a value in a control without calling back who listens to it: asynchronous listeners
    cost more than the rest of an edit, and what the program sets is none of their business."""
    state = control._impl
    value = type(state.value)(value)
    if state.value != value:
        state.gui_api._websock_interface.queue_message(
            _messages.GuiUpdateMessage(state.uuid, {"value": value})
        )
        state.value = value


# What goes wrong


def told(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    """A line for a message that viser could not make sense of."""
    error = context.get("exception")
    frame = error.__traceback__.tb_frame if error and error.__traceback__ else None
    visitor = frame.f_locals.get("client_id") if frame else None  # of viser's callback
    words = f"a message was ignored: {error or context['message']}"
    log.warn(f"visitor {visitor}", type(error).__name__, words)
