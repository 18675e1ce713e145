"""The only module that uses undocumented parts of viser (see tests/server/test_protection.py); on
the page the only scripts that do are viser.js, with viser.css, and webgl.js, without which viser
fails in a browser that has no WebGL.

It builds a viser server whose connections all pass a guard and that opens no public tunnel, and it
sets single properties at a third of viser's cost. All attributes used are checked at the start
(`check_attributes`), so that any version of viser that has them is supported.
"""

import asyncio
import contextlib
import inspect
import io
import operator
import pkgutil
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import rich
import viser
import websockets
import websockets.asyncio.server
from websockets.http11 import Request

from beamviz.errors import Unavailable
from beamviz.server.log import RateLimitedLog
from beamviz.signals import defer_signals

PROTOCOL = f"viser-v{viser.__version__}"  # WebSocket subprotocol of viser's page
SUPPORTED = "pip install 'viser>=1.1,<1.2' 'websockets>=14.2,<17'"
INTERNAL_ERROR = 1011  # WebSocket close code
PACKED = {np.dtype(float): np.float32, np.dtype(int): np.uint32}  # types of arrays in messages

MESSAGES = (  # that the page sends
    "GuiUpdateMessage",
    "ViewerCameraMessage",
    "CommandTriggerMessage",
    "SceneNodeClickMessage",
    "SceneNodeDragMessage",
)
ATTRIBUTES = {  # by class, function or module: attributes, fields and arguments
    "websockets.asyncio.server:serve": "create_connection process_request process_response"
    " server_header",
    "viser:ViserServer": "request_share_url",
    "viser.infra:Message": "as_serializable_dict redundancy_key",
    "viser.infra:WebsockServer": "get_message_buffer queue_message",
    "viser.infra:WebsockMessageHandler": "get_message_serializer",
    "viser.infra:StateSerializer": "as_html",
    "viser._gui_handles:_GuiHandleState": "gui_api props sync_cb uuid value",
    "viser._scene_api:SceneApi": "_queue_scene_message",
    "viser._scene_handles:_SceneNodeHandleState": "api position props wxyz",
    "viser._messages:SetPositionMessage": "include_in_scene_serialization",
    "viser._messages": "RunJavascriptMessage SceneNodeUpdateMessage SetOrientationMessage"
    f" SetPositionMessage {' '.join(MESSAGES)}",
}
INSTANCE_ATTRIBUTES = ("_websock_server._live_connections", "gui._websock_interface")

messages: Any = getattr(viser, "_messages", None)
message_types = {name: getattr(messages, name, None) for name in MESSAGES}
log = RateLimitedLog(__name__)
building = threading.Lock()  # one server at a time: a module is changed for all threads


# Attributes


def check_attributes() -> None:
    """Raise Unavailable if viser or websockets lack an attribute used here."""
    for owner, names in ATTRIBUTES.items():
        try:
            resolved: Any = pkgutil.resolve_name(owner)
        except (ImportError, AttributeError):
            raise unsupported(owner) from None
        arguments = inspect.signature(resolved).parameters if callable(resolved) else ()
        known = {*dir(resolved), *arguments}
        for name in names.split():
            if name not in known:
                raise unsupported(f"{owner}.{name}")


def unsupported(attribute: str) -> Unavailable:
    """The error for a missing attribute, with the installed and the supported versions."""
    return Unavailable(
        f"viser {viser.__version__} with websockets {websockets.__version__} lacks"
        f" {attribute.replace(':', '.')}, which the server's protection needs: {SUPPORTED}"
    )


# The server


class TunnelFreeServer(viser.ViserServer):
    """A viser server without the public tunnel that any visitor could open by a message."""

    def request_share_url(self, verbose: bool = True) -> None:
        """Do nothing."""


@contextlib.contextmanager
def viser_server(host: str, port: int, serve: Callable[..., Any]) -> Iterator[viser.ViserServer]:
    """A viser server that accepts connections by `serve`, stopped on leaving. Raises Unavailable if
    viser or websockets lack an attribute used here, or if viser did not call `serve`."""
    check_attributes()
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection")  # visitor has left
    called = threading.Event()
    module = websockets.asyncio.server

    def guarded_serve(*args: Any, **options: Any) -> Any:
        called.set()
        asyncio.get_running_loop().set_exception_handler(log_callback_error)
        return serve(*args, **options)

    def stop() -> None:
        with without_banners():
            server.stop()

    with contextlib.ExitStack() as stack:
        with defer_signals(), without_banners(), building:
            original, module.serve = module.serve, guarded_serve  # type: ignore[misc,assignment]
            try:
                server = TunnelFreeServer(host=host, port=port, verbose=False)
            finally:
                module.serve = original  # type: ignore[misc]
            stack.callback(stop)
        if not called.is_set():
            raise Unavailable("viser did not build its server as expected: it would be unprotected")
        for path in INSTANCE_ATTRIBUTES:
            try:
                operator.attrgetter(path)(server)
            except AttributeError:
                raise unsupported(f"viser:ViserServer.{path}") from None
        yield server


@contextlib.contextmanager
def without_banners() -> Iterator[None]:
    """Context in which viser prints nothing: stdout is for data, and in a notebook its banners
    would be an output of the cell."""
    console = rich.get_console()
    with contextlib.redirect_stdout(io.StringIO()):
        before, console.quiet = console.quiet, True
        try:
            yield
        finally:
            console.quiet = before


def log_callback_error(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    """Event loop exception handler: one line for a message that viser could not process."""
    error = context.get("exception")
    frame = error.__traceback__.tb_frame if error and error.__traceback__ else None
    visitor = frame.f_locals.get("client_id") if frame else None  # of viser's callback
    text = f"a message was ignored: {error or context['message']}"
    log.warn(f"visitor {visitor}", type(error).__name__, text)


# A scene without a server


class MessageRecorder(viser.infra.WebsockMessageHandler):
    """Takes the messages of a scene as a server does, for its recording alone."""

    def get_message_buffer(self) -> Any:
        """What would send them."""
        return SimpleNamespace(push=lambda message: None)


class RecordedServer(viser.ViserServer):
    """A scene that is recorded as a page of its own: no port, no thread and no visitor."""

    def __init__(self) -> None:
        check_attributes()
        self._websock_server: Any = MessageRecorder()
        self._scene_lifecycle_lock = threading.RLock()
        self._recording = self._websock_server.get_message_serializer(
            lambda message: message.include_in_scene_serialization
        )
        self._initial_camera = viser.InitialCameraConfig(self._websock_server.queue_message)
        unused: Any = None
        self.scene = viser.SceneApi(self, unused, unused)
        self.scene.set_up_direction("+z")

    def page(self, *, dark: bool) -> str:
        """The HTML of viser's page with all that was drawn."""
        return self._recording.as_html(dark_mode=dark)


# Visitors


def handshake_request(server: viser.ViserServer, client_id: int) -> Request | None:
    """The request that opened a visitor's connection; None if they have left."""
    connection = server._websock_server._live_connections.get(client_id)
    return connection.request if connection else None


def disconnect(server: viser.ViserServer, client_id: int) -> None:
    """Close a visitor's connection because of an internal error."""
    if connection := server._websock_server._live_connections.get(client_id):
        closing = connection.close(INTERNAL_ERROR, "internal error")
        asyncio.run_coroutine_threadsafe(closing, server.get_event_loop())


# Properties, without viser's checks, copies and callbacks


class PageScript(getattr(messages, "RunJavascriptMessage", object)):  # type: ignore[misc]
    """A RunJavascriptMessage whose source is called when it is sent: one in the queue suffices."""

    def redundancy_key(self) -> str:
        """The key by which a later message replaces this one in the queue."""
        return "page script"

    def as_serializable_dict(self, binary_buffers: list[memoryview]) -> dict[str, Any]:
        return {"source": self.source(), "type": "RunJavascriptMessage"}


def run_script(client: viser.ClientHandle, source: Callable[[], str]) -> None:
    """Run a script in a visitor's page; source: returns it when the message is sent."""
    client.gui._websock_interface.queue_message(PageScript(source))


def private_control(control: viser.GuiInputHandle) -> str:
    """The id of a control in messages, which are not sent to other visitors any more."""
    control._impl.sync_cb = None
    return str(control._impl.uuid)


class ViserScene:
    """A scene of viser, whose nodes change at less cost than by viser's own properties."""

    def __init__(self, scene: viser.SceneApi):
        self.add_frame = scene.add_frame
        self.add_mesh_simple = scene.add_mesh_simple
        self.add_batched_meshes_simple = scene.add_batched_meshes_simple
        self.add_cylinder = scene.add_cylinder
        self.add_line_segments = scene.add_line_segments
        self.add_light_hemisphere = scene.add_light_hemisphere
        self.add_light_directional = scene.add_light_directional
        self.configure_environment_map = scene.configure_environment_map
        self.configure_default_lights = scene.configure_default_lights
        self.set_properties, self.set_pose = set_properties, set_pose


def set_properties(node: viser.SceneNodeHandle, **properties: np.ndarray) -> None:
    """Set several properties of a node in one message: by viser, a frame takes 80 % longer."""
    for name, array in properties.items():
        properties[name] = array.astype(PACKED.get(array.dtype, array.dtype), copy=False)
        setattr(node._impl.props, name, properties[name])
    update = messages.SceneNodeUpdateMessage(node.name, properties)
    node._impl.api._queue_scene_message(update)


def set_pose(node: viser.SceneNodeHandle, **pose: Iterable[float]) -> None:
    """Set the position (3,) of a node, its orientation wxyz (4,) or both, where they change: by
    viser, a frame takes 30 % longer."""
    changes = {"position": messages.SetPositionMessage, "wxyz": messages.SetOrientationMessage}
    for name, value in pose.items():
        state, numbers = getattr(node._impl, name), tuple(map(float, value))
        if tuple(state.tolist()) != numbers:
            state[:] = numbers
            node._impl.api._queue_scene_message(changes[name](node.name, numbers))
