"""The page of one visitor: updates to it, and actions from it.

The page is HTML of our own around viser's scene (page.html, page.css, page.js). The server sends
scripts `beamviz.apply({...})` with the changes; the page sends actions as JSON [number, action,
value] through one hidden text control of viser, the bridge.
"""

import json
import threading
from collections.abc import Callable, Iterable
from importlib.resources import files
from typing import Any

from viser import ClientHandle, GuiEvent, ViserServer

from beamviz.drawing.objects import Caption, captions_script
from beamviz.server.log import RateLimitedLog
from beamviz.server.viser_private import private_control, run_script

ROOT = '<div id="root"></div>'  # of viser's page
STYLES = ("page.css", "chart.css")
SCRIPTS = ("page.js", "figure.js", "chart.js", "map.js")
FIRST_TAB = "tab-frequencies"
MERGED = ("props", "charts")  # parts whose entries are dictionaries, to be merged
MAX_DIGITS = 15  # of an integer; one with more becomes a float
MAX_TEXT = 1000  # characters of a value

Handler = Callable[[Any], None]

log = RateLimitedLog(__name__)


def insert_page(viser_page: str) -> str:
    """viser's page with our elements around its scene, our style and our scripts."""
    texts = {
        name: files("beamviz.explorer.page").joinpath(name).read_text(encoding="utf-8")
        for name in ("page.html", *STYLES, *SCRIPTS)
    }
    style, script = ("".join(texts[name] for name in names) for names in (STYLES, SCRIPTS))
    script += captions_script()
    elements = f"<style>{style}</style>{texts['page.html']}<script>{script}</script>"
    return viser_page.replace(ROOT, elements).replace("<title>Viser<", "<title>beamviz<")


def choose_theme(side: ClientHandle | ViserServer, *, dark: bool) -> None:
    """Set viser's dark or light theme, without its own buttons."""
    side.gui.configure_theme(dark_mode=dark, show_logo=False, show_share_button=False)


class Page:
    """Sends changes to the page, all those between two messages at once, and calls the handlers of
    its actions.

    tab: the element id of the open tab.
    """

    def __init__(self, client: ClientHandle):
        self.client, self.lock = client, threading.Lock()
        self.handlers: dict[str, tuple[Handler, int]] = {}  # with the maximum length of the value
        self.sent: dict[tuple[str, str], Any] = {}  # content of the page, by part and name
        self.waiting: dict[str, Any] = {}
        self.tab = FIRST_TAB
        self.bridge = client.gui.add_text("bridge", "", visible=False)
        self.bridge.on_update(self.received)
        self.send("bridge", private_control(self.bridge))

    # To the page

    def html(self, id: str, content: str) -> None:
        """Show HTML in the element with this id. Text in it must be escaped."""
        self.send_changed("html", id, content)

    def value(self, key: str, value: Any) -> None:
        """Show a value in all controls with data-set="key"."""
        self.send_changed("values", key, value)

    def props(self, key: str, **attributes: Any) -> None:
        """Set attributes (aria_label= for aria-label) of the elements with data-set="key" and of
        the element with the id `key`; False or None removes an attribute."""
        named = {name.strip("_").replace("_", "-"): value for name, value in attributes.items()}
        self.send_entries("props", key, named)

    def chart(self, id: str, data: dict[str, Any]) -> None:
        """Draw a chart in the element with this id (chart.js)."""
        self.send_entries("charts", id, data)

    def captions(self, captions: Iterable[Caption]) -> None:
        """Write texts over the scene, each at the point of its node (captions.js)."""
        self.send_changed("captions", "scene", [one.data for one in captions])

    def ready(self) -> None:
        """Request the preferences and the address of the page: all actions have handlers."""
        self.send("ready", True)

    def open(self, tab: str) -> None:
        """Open a tab, by its element id."""
        self.tab = tab
        self.send("open", tab)

    def point(self, *keys: str) -> None:
        """Highlight controls, by their keys or ids, and open the sections that contain them."""
        self.send("point", keys)

    def address(self, query: str) -> None:
        """Set the query in the address of the page."""
        self.send("address", query)

    def theme(self, *, dark: bool) -> None:
        """Choose dark or light colours for the page and for viser's scene."""
        choose_theme(self.client, dark=dark)
        self.send("dark", dark)

    def say(self, text: str, error: bool = False) -> None:
        """Announce a text to screen readers; an error is also shown for some seconds."""
        with self.lock:
            said = [*self.waiting.get("say", ()), {"text": text, "error": error}]
        self.send("say", said)

    def send_changed(self, part: str, name: str, content: Any) -> None:
        """Send an entry of a part if it differs from the last one sent."""
        if self.sent.get((part, name), self) != content:
            self.sent[part, name] = content
            self.send(part, name, content)

    def send_entries(self, part: str, name: str, entries: dict[str, Any]) -> None:
        """Send the items of an entry of a part that differ from those last sent."""
        known = self.sent.setdefault((part, name), {})
        if changed := {key: one for key, one in entries.items() if known.get(key) != one}:
            known |= changed
            self.send(part, name, changed)

    def send(self, part: str, *entry: Any) -> None:
        """Queue a part for the page: its content, or the name and the content of one entry."""
        with self.lock:
            queued = bool(self.waiting)
            if len(entry) == 1:
                (self.waiting[part],) = entry
            else:
                name, content = entry
                entries = self.waiting.setdefault(part, {})
                merged = part in MERGED and name in entries
                entries[name] = {**entries[name], **content} if merged else content
        if not queued:
            run_script(self.client, self.script)

    def script(self) -> str:
        """The script with all queued changes."""
        with self.lock:
            waiting, self.waiting = self.waiting, {}
        return f"beamviz.apply({json.dumps(waiting)})"

    # From the page

    def on(self, action: str, handler: Handler, max_text: int = MAX_TEXT) -> None:
        """Call `handler` with the value of each action of this name, in order, on the event loop,
        so it must be quick; a value of more than `max_text` characters is ignored."""
        self.handlers[action] = handler, max_text

    async def received(self, event: GuiEvent) -> None:
        """Call the handler of an action; ignore an invalid one."""
        try:
            _, action, value = ACTIONS.decode(self.bridge.value)
            handler, max_text = self.handlers[action]
            if isinstance(value, list | dict) or len(str(value)) > max_text:
                raise ValueError(f"{action} with {str(value)[:40]}")
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            visitor = f"visitor {event.client_id}"
            log.warn(visitor, "action", f"an unknown action was ignored: {str(error)[:80]}")
            return
        self.sent.pop(("values", action), None)  # the page shows what the visitor chose
        handler(value)


def whole_number(digits: str) -> float:
    """An integer; a float if it has more than MAX_DIGITS digits."""
    return int(digits) if len(digits) <= MAX_DIGITS else float(digits)


ACTIONS = json.JSONDecoder(parse_int=whole_number)
