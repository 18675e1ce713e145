"""A page in a headless Firefox, driven through WebDriver BiDi: no driver is needed."""

import contextlib
import itertools
import json
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from live.chromium import browser_process
from live.server import TIMEOUT, wait_until
from websockets.sync.client import connect
from websockets.sync.connection import Connection

# No start page, no updates, nothing sent home; a frame is drawn though no window is seen.
PREFERENCES = {
    "app.update.enabled": False,
    "browser.startup.homepage_override.mstone": "ignore",
    "datareporting.policy.dataSubmissionEnabled": False,
    "network.captive-portal-service.enabled": False,
    "network.connectivity-service.enabled": False,
    "services.settings.server": "data:,",
    "toolkit.telemetry.enabled": False,
}


class FirefoxPage:
    """The page of a Firefox; `problems` collects its console errors and uncaught exceptions."""

    def __init__(self, socket: Connection):
        self.socket, self.numbers = socket, itertools.count(1)
        self.problems: list[str] = []
        self.call("session.new", capabilities={})
        self.call("session.subscribe", events=["log.entryAdded"])
        self.context = self.call("browsingContext.getTree")["contexts"][0]["context"]

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        """The result of one command."""
        number = next(self.numbers)
        self.socket.send(json.dumps({"id": number, "method": method, "params": params}))
        while True:
            message = json.loads(self.socket.recv(timeout=TIMEOUT))
            if message.get("id") == number:
                if message["type"] == "error":
                    raise RuntimeError(f"{method}: {message['message']}")
                return message["result"]
            entry = message.get("params", {})
            if message.get("method") == "log.entryAdded" and entry["level"] == "error":
                self.problems.append(entry["text"])

    def open(self, url: str, width: int = 1440, height: int = 900) -> None:
        """Show a page in a window of this size."""
        size = {"width": width, "height": height}
        self.call("browsingContext.setViewport", context=self.context, viewport=size)
        self.call("browsingContext.navigate", context=self.context, url=url, wait="interactive")

    def evaluate(self, script: str) -> Any:
        """The value of an expression in the page."""
        options = {"target": {"context": self.context}, "awaitPromise": True}
        text = f"(async () => JSON.stringify(await ({script})) ?? 'null')()"
        result = self.call("script.evaluate", expression=text, **options)
        if result["type"] == "exception":
            raise RuntimeError(result["exceptionDetails"]["text"])
        return json.loads(result["result"]["value"])

    def wait(self, script: str) -> Any:
        """The value of an expression in the page as soon as it is true."""

        def value() -> Any:
            with contextlib.suppress(RuntimeError):  # it reads what is not there yet
                return self.evaluate(script)

        return wait_until(value, about=f": {script}")

    def key(self, key: str) -> None:
        """A key, down and up."""
        actions = [{"type": kind, "value": key} for kind in ("keyDown", "keyUp")]
        self.perform({"type": "key", "id": "keys", "actions": actions})

    def drag(self, *points: tuple[float, float]) -> None:
        """Drag from the first point of the page along the others."""
        ways = [
            {"type": "pointerMove", "x": round(x), "y": round(y), "duration": 100}
            for x, y in points
        ]
        pressed = {"type": "pointerDown", "button": 0}
        still = {"type": "pause", "duration": 300}
        actions = [ways[0], still, pressed, *ways[1:], still, {"type": "pointerUp", "button": 0}]
        self.perform({"type": "pointer", "id": "mouse", "actions": actions})

    def click(self, script: str) -> None:
        """Click in the middle of an element, given as an expression."""
        self.wait(f"!!({script})")
        box = self.evaluate(
            f"({script}).scrollIntoView({{block: 'nearest'}}), ({script}).getBoundingClientRect()"
        )
        self.drag((box["x"] + box["width"] / 2, box["y"] + box["height"] / 2))

    def perform(self, source: dict[str, Any]) -> None:
        """Actions of a keyboard or a mouse."""
        self.call("input.performActions", context=self.context, actions=[source])


@contextlib.contextmanager
def firefox(browser: str) -> Iterator[FirefoxPage]:
    """An empty page of a Firefox without a window, which is ended at last."""
    with tempfile.TemporaryDirectory(prefix="beamviz-", ignore_cleanup_errors=True) as profile:
        lines = [f'user_pref("{key}", {json.dumps(value)});' for key, value in PREFERENCES.items()]
        Path(profile, "user.js").write_text("\n".join(lines), encoding="utf-8")
        command = [browser, "--headless", "--no-remote", "--profile", profile]
        command += ["--remote-debugging-port=0", "about:blank"]
        with browser_process(command, {"HOME": profile, "TMPDIR": profile}):
            file = Path(profile, "WebDriverBiDiServer.json")
            wait_until(lambda: file.exists() and file.read_text().endswith("}"))
            address = json.loads(file.read_text())
            url = f"ws://{address['ws_host']}:{address['ws_port']}/session"
            options: dict[str, Any] = {"max_size": None, "ping_interval": None}
            with connect(url, open_timeout=TIMEOUT, close_timeout=1, **options) as socket:
                yield FirefoxPage(socket)
