"""Pages in a headless browser, driven through the DevTools protocol.

One browser serves the whole run; each process uses windows of its own, one after the other.
"""

import atexit
import contextlib
import itertools
import json
import os
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from live.chromium import find_browser, open_browser
from live.server import TIMEOUT, wait_until
from websockets.sync.client import connect
from websockets.sync.connection import Connection

NO_BROWSER = "no Chrome, Chromium or Edge found (set BEAMVIZ_BROWSER to one)"
PROFILE = "BEAMVIZ_TEST_BROWSER"  # environment variable: profile folder of the running browser
# Those that it acts on.
KEY_CODES = {"Tab": 9, "Enter": 13, "PageUp": 33, "End": 35, "ArrowLeft": 37, "ArrowRight": 39}
CONNECTION: dict[str, Any] = {"max_size": None, "ping_interval": None}
CONNECTION |= {"open_timeout": TIMEOUT, "close_timeout": 1}
SHIFT = 8  # a modifier of keys
LATE = 600  # [ms]
EMPTY_PAGE = "URL.createObjectURL(new Blob([''], {type: 'text/html'}))"
UNUSED: list[str] = []  # targets of the windows of this process in which no page is open
LEFT: dict[str, Any] = {"button": "left", "clickCount": 1}
Until = str | Callable[[], Any]  # an expression in the page, or a function
NODES = "window.__viserMutable?.nodeRefFromName"  # of the scene, by name
READY = "!!document.querySelector('#scene[data-ready] canvas')"
# Sends an invalid value, and is done once the server has corrected it.
CATCH_UP = """new Promise(done => {
  const apply = beamviz.apply;
  beamviz.apply = update => {
    apply(update);
    if ("film_length" in (update.values ?? {})) { beamviz.apply = apply; done(true); }
  };
  beamviz.send("film_length", "no"); })"""
# Until all that has come while it was slow is applied, what comes later waits for that.
SLOW_LINE = f"""{{ const apply = beamviz.apply;
  let last = Promise.resolve(), late = {LATE};
  beamviz.apply = update => {{
    const before = last, wait = new Promise(done => setTimeout(done, late));
    last = (async () => {{ await before; await wait; apply(update); }})();
  }};
  window.endSlowLine = async () => {{
    late = 0;
    for (let seen; seen !== last;) await (seen = last);
    beamviz.apply = apply; }}; }}"""
# Without a graphics card a frame of the scene takes a second of a processor.
DRAW_NOTHING = """for (const name of ["clear", "blitFramebuffer", "drawArrays", "drawElements",
  "drawArraysInstanced", "drawElementsInstanced"])
    WebGL2RenderingContext.prototype[name] = () => {};"""


class Page:
    """A page, or the browser itself, driven through a DevTools connection; `problems` collects its
    console errors and uncaught exceptions, if their `domains` are given."""

    def __init__(self, socket: Connection, *domains: str):
        self.socket, self.numbers = socket, itertools.count(1)
        self.problems: list[str] = []
        for domain in domains:
            self.call(f"{domain}.enable")

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        """The result of one DevTools command; errors of the page that arrive before are noted."""
        number = next(self.numbers)
        self.socket.send(json.dumps({"id": number, "method": method, "params": params}))
        while True:
            message = json.loads(self.socket.recv(timeout=TIMEOUT))
            if message.get("id") == number:
                if "error" in message:
                    raise RuntimeError(f"{method}: {message['error']['message']}")
                return message["result"]
            kind, event = message.get("method"), message.get("params", {})
            if kind == "Runtime.exceptionThrown":
                self.problems.append(event["exceptionDetails"]["text"])
            elif kind == "Runtime.consoleAPICalled" and event["type"] in ("error", "assert"):
                self.problems.append(" ".join(str(a.get("value", a)) for a in event["args"]))
            elif kind == "Log.entryAdded" and event["entry"]["level"] == "error":
                self.problems.append(f"{event['entry']['text']} {event['entry'].get('url', '')}")

    def evaluate(self, script: str) -> Any:
        """The value of an expression in the page."""
        options = {"expression": script, "returnByValue": True, "awaitPromise": True}
        result = self.call("Runtime.evaluate", **options)
        if "exceptionDetails" in result:
            raise RuntimeError(result["exceptionDetails"]["exception"]["description"])
        return result["result"].get("value")

    def wait(self, until: Until, timeout: float = TIMEOUT) -> Any:
        """The value of an expression in the page, or of a function, as soon as it is true. An
        expression is not true yet if it reads what is not there, or the page is changing."""
        errors = [""]

        def value() -> Any:
            try:
                return self.evaluate(until)
            except RuntimeError as error:
                errors.append(str(error))

        try:
            return wait_until(until if callable(until) else value, timeout, f": {until}")
        except TimeoutError as late:
            late.add_note(errors[-1])
            raise

    def reload(self) -> None:
        """Load the page again; done once the former one is gone."""
        self.evaluate("window.former = true")
        self.call("Page.reload")
        self.wait("!window.former")

    def mouse(self, kind: str, x: float, y: float, buttons: int = 0) -> None:
        """A mouse event at a point of the page."""
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, buttons=buttons, **LEFT)

    def click(self, script: str, until: Until = "true") -> None:
        """Click in the middle of an element, given as an expression, and wait."""
        self.click_at(*self.middle(script))
        self.wait(until)

    def click_at(self, x: float, y: float) -> None:
        """Click at a point of the page."""
        self.mouse("mousePressed", x, y, 1)
        self.mouse("mouseReleased", x, y)

    def send(self, action: str, value: Any = None, until: Until = "true") -> None:
        """Send an action of the page, and wait."""
        self.evaluate(f"beamviz.send({json.dumps(action)}, {json.dumps(value)})")
        self.wait(until)

    def catch_up(self) -> None:
        """Wait until the server has handled all earlier actions, and the page shows what frames
        have shown until then."""
        self.evaluate(CATCH_UP)

    @contextlib.contextmanager
    def slow_line(self) -> Iterator[None]:
        """Meanwhile the page gets what the server sends LATE milliseconds later, in its order."""
        self.evaluate(SLOW_LINE)
        yield
        self.evaluate("window.endSlowLine()")

    def number(self, name: str) -> float:
        """A number of the beam in its field: what the server says."""
        return float(self.evaluate(f"{by_id(f'{name}-field')}.value"))

    def open_tab(self, name: str) -> None:
        """Open a tab."""
        self.evaluate(f"{by_id(f'to-{name}')}.click()")

    def _carry(
        self,
        move: Callable[[Sequence[float]], None],
        start: Sequence[float],
        end: Sequence[float],
        taken: Until,
        arrived: Until,
    ) -> None:
        """Move what is pressed from one point of the page to another, and wait as `drag`."""
        for k, point in enumerate(way(start, end)):
            move(point)
            self.next_frame()
            if k == 0:
                self.wait(taken)
        self.wait(arrived)

    def drag(
        self,
        start: Sequence[float],
        end: Sequence[float],
        taken: Until = "true",
        arrived: Until = "true",
    ) -> None:
        """Drag from one point of the page to another. taken: true as soon as something is dragged;
        arrived: once it is at the end, where it is let go then."""
        self.mouse("mouseMoved", *start)
        self.next_frame()
        self.mouse("mousePressed", *start, 1)
        self._carry(lambda point: self.mouse("mouseMoved", *point, 1), start, end, taken, arrived)
        self.mouse("mouseReleased", *end)

    def touch(self, kind: str, *points: Sequence[float]) -> None:
        """A touch event at points of the page; none at its end."""
        places = [{"x": x, "y": y} for x, y in points]
        self.call("Input.dispatchTouchEvent", type=kind, touchPoints=places)

    def swipe(
        self,
        start: Sequence[float],
        end: Sequence[float],
        taken: Until = "true",
        arrived: Until = "true",
    ) -> None:
        """Drag a finger from one point of the page to another, and wait as `drag`."""
        self.touch("touchStart", start)
        self.next_frame()
        self._carry(lambda point: self.touch("touchMove", point), start, end, taken, arrived)
        self.touch("touchEnd")

    def drag_along(self, script: str, *parts: float) -> None:
        """Drag along an element from one fraction of its width to another."""
        left, top, width, height = self.box(script)
        self.drag(*((left + width * part, top + height / 2) for part in parts))

    def key(self, name: str, until: Until = "true", *, modifiers: int = 0, frames: int = 0) -> None:
        """A key, held down for some frames of the page, and up, and wait; modifiers = 2: Ctrl."""
        code = f"{'Digit' if name.isdigit() else 'Key'}{name.upper()}" if len(name) == 1 else name
        text, number = "\r" if name == "Enter" else "", KEY_CODES.get(name, 0)
        key = {"key": name, "code": code, "text": text, "windowsVirtualKeyCode": number}
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, modifiers=modifiers, **key)
            self.next_frame(frames)
        self.wait(until)

    def resize(self, width: int, height: int, *, touch: bool = False) -> None:
        """Another size of the window; a touch screen if it is narrow."""
        touch |= width < 500
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": touch}
        self.call("Emulation.setDeviceMetricsOverride", **size)
        self.call("Emulation.setTouchEmulationEnabled", enabled=touch)
        self.wait(f"innerWidth === {width}")
        self.next_frame()

    def box(self, script: str, frames: int = 8) -> list[float]:
        """Left, top, width and height of an element in view, once at rest for some frames."""
        return self.wait(f"""(async () => {{
          const e = {script}, boxes = []; if (!e) return null;
          e.scrollIntoView({{block: 'center'}});
          for (let k = 0; k < {frames}; k++) {{
            await new Promise(requestAnimationFrame);
            const r = e.getBoundingClientRect(); boxes.push([r.left, r.top, r.width, r.height]); }}
          return boxes.every(box => `${{box}}` === `${{boxes[0]}}`) && boxes[0]; }})()""")

    def middle(self, script: str) -> tuple[float, float]:
        """The middle of an element."""
        left, top, width, height = self.box(script)
        return left + width / 2, top + height / 2

    def at_rest(self, place: Callable[[], list[float]]) -> list[float]:
        """A place in the page of the explorer, once it has been the same for ten frames, and one of
        the server, which may move the camera."""

        def found() -> list[float] | None:
            before = place()
            self.next_frame(10)
            self.catch_up()
            return before if place() == pytest.approx(before, abs=0.1) else None

        return wait_until(found)

    def next_frame(self, frames: int = 2) -> None:
        """Wait until the page has been drawn, `frames` times."""
        self.evaluate(f"""new Promise(done => {{ let left = {frames};
          (function next() {{ left-- ? requestAnimationFrame(next) : done(1) }})() }})""")


def way(start: Sequence[float], end: Sequence[float]) -> list[tuple[float, float]]:
    """Ten points from one to another, without the first."""
    (x, y), (to_x, to_y) = start, end
    return [(x + k / 10 * (to_x - x), y + k / 10 * (to_y - y)) for k in range(1, 11)]


def are_apart(boxes: Sequence[dict[str, float]]) -> bool:
    """Whether no box covers another, by more than a pixel at its edge."""
    return all(
        min(one["right"], other["right"]) <= max(one["left"], other["left"])
        or min(one["bottom"], other["bottom"]) <= max(one["top"], other["top"]) + 1
        for one, other in itertools.combinations(boxes, 2)
    )


def says(words: str) -> str:
    """An expression: whether these words are on the page."""
    return f"document.body?.innerText.includes({words!r})"


def by_id(id: str) -> str:
    """The element with this id."""
    return f"document.getElementById('{id}')"


def element(selector: str, text: str) -> str:
    """The first element of a kind that has exactly this text."""
    every = f"[...document.querySelectorAll('{selector}')]"
    return f"{every}.find(e => e.innerText.trim() === '{text}')"


def button(text: str) -> str:
    """A button, by its text."""
    return element("button", text)


def tab(name: str) -> str:
    """A tab, by its name."""
    return element("[role=tab]", name)


def start_browser() -> None:
    """Start the browser of this run, which ends with this process; without one, skip the test."""
    if PROFILE in os.environ:
        return
    browser = find_browser() or pytest.skip(NO_BROWSER)
    stack = contextlib.ExitStack()
    os.environ[PROFILE] = str(stack.enter_context(open_browser(browser, "about:blank")))
    atexit.register(stack.close)


def devtools() -> tuple[str, str]:
    """The DevTools addresses of the browser of this run: of all its pages, of itself."""
    start_browser()
    file = Path(os.environ[PROFILE]) / "DevToolsActivePort"
    wait_until(lambda: file.exists() and len(file.read_text().splitlines()) == 2)
    port, path = file.read_text().splitlines()
    return f"ws://127.0.0.1:{port}/devtools/page", f"ws://127.0.0.1:{port}{path}"


@contextlib.contextmanager
def frame(url: str) -> Iterator[Page]:
    """The page of `url` in a frame of a page of another site, which is open; its canvas stays empty
    from now on."""
    pages, _ = devtools()

    def found() -> str | None:
        every = the_browser().call("Target.getTargets")["targetInfos"]
        frames = (one for one in every if one["type"] == "iframe")
        pages = (one for one in frames if one["url"].partition("?")[0] == url)
        return next((one["targetId"] for one in pages), None)

    target = wait_until(found)
    with connect(f"{pages}/{target}", **CONNECTION) as socket:
        inner = Page(socket, "Runtime", "Log", "Page")
        inner.evaluate(DRAW_NOTHING)
        yield inner


@cache
def the_browser() -> Page:
    """The browser of this run itself; what is opened through it ends with this process."""
    _, itself = devtools()
    stack = contextlib.ExitStack()
    atexit.register(stack.close)
    return Page(stack.enter_context(connect(itself, **CONNECTION)))


def new_window() -> str:
    """The target of a new window with a storage of its own."""
    browser = the_browser()
    context = browser.call("Target.createBrowserContext", disposeOnDetach=True)
    made = browser.call("Target.createTarget", url="about:blank", newWindow=True, **context)
    return made["targetId"]


@contextlib.contextmanager
def page(
    url: str, width: int = 1280, height: int = 720, *, is_drawn: bool = False, script: str = ""
) -> Iterator[Page]:
    """A page of this size that has started to load `url`, watched from its first moment. Only if
    `is_drawn` the scene is seen; else it is there and moves, but its canvas stays empty. The script
    is run before those of the page.

    Its window is kept for the next page of this process: what its site has loaded once is not
    compiled again.
    """
    pages, _ = devtools()
    target = UNUSED.pop() if UNUSED else new_window()
    is_kept = False
    try:
        with connect(f"{pages}/{target}", **CONNECTION) as socket:
            shown = Page(socket, "Runtime", "Log", "Page")
            size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
            shown.call("Emulation.setDeviceMetricsOverride", **size)
            shown.call("Emulation.setFocusEmulationEnabled", enabled=True)  # never throttled
            first = script if is_drawn else DRAW_NOTHING + script
            shown.call("Page.addScriptToEvaluateOnNewDocument", source=first)
            shown.call("Page.navigate", url=url)
            yield shown
            is_kept = leave(shown)
    finally:
        if is_kept:
            UNUSED.append(target)
        else:
            the_browser().call("Target.closeTarget", targetId=target)


def leave(shown: Page) -> bool:
    """Leave the page of a server for an empty one of its site, with nothing stored and no way back;
    whether that is possible."""
    origin = shown.evaluate("location.origin")
    if not origin.startswith("http"):
        return False
    shown.evaluate(f"location.replace({EMPTY_PAGE})")
    shown.wait("location.protocol === 'blob:'")
    stored = "cookies,local_storage,indexeddb,cache_storage,service_workers"
    shown.call("Storage.clearDataForOrigin", origin=origin, storageTypes=stored)
    shown.call("Page.resetNavigationHistory")
    shown.call("Log.clear")
    return True
