"""The link a page was opened with: ?lesson=nodes, or ?alpha=1&gamma=10&mode=3.

A server is not told the query of the page that connects to it, so the page is asked.
"""

import secrets
import threading
import time
from collections.abc import Callable

from viser import ClientHandle

from beamviz.errors import InvalidInput
from beamviz.explorer.features.lessons import Guide
from beamviz.explorer.page.script import running
from beamviz.lessons import lesson
from beamviz.scene import Scene, parse_query
from beamviz.server.access import KEY_PARAMETER

PATIENCE = 20.0  # [s] for a page to answer
PAUSE = 0.2  # [s] between two questions
SHOWN = 12.0  # [s] that a message stays
# What others read from the same link: the access its key, viser's page its switches.
OTHERS = {KEY_PARAMETER, "websocket", "fixedDpr", "darkMode", "showStats", "logCamera"}
# The page knows the key under a longer name, which only viser needs to know.
NOTE = (
    "localStorage.setItem(Object.keys(localStorage).find(name => name.endsWith('{key}')),"
    " '?' + location.search)"
)


def follow(client: ClientHandle, guide: Guide, load: Callable[[Scene], None]) -> None:
    """Show what the visitor's link asks for, from a thread of its own."""

    def run() -> None:
        query = asked(client)
        try:
            arrive(query, guide, load)
        except InvalidInput as error:
            client.add_notification(
                "The link makes no sense", str(error), color="red", auto_close_seconds=SHOWN
            )

    threading.Thread(target=run, name="link", daemon=True).start()


def asked(client: ClientHandle) -> str:
    """The query of the visitor's link; "" where there is none, or no page that could tell."""
    key, end = secrets.token_hex(8), time.monotonic() + PATIENCE
    client.local_storage.set_item(key, "")
    note = client.gui.add_html(running(NOTE.format(key=key)))
    query = ""
    try:
        while not query and time.monotonic() < end:
            time.sleep(PAUSE)
            query = client.local_storage.get_item(key, timeout=PATIENCE) or ""
    except (RuntimeError, TimeoutError):  # gone, or a program without pages
        return ""
    client.local_storage.remove_item(key)
    note.remove()
    return query.lstrip("?")


def arrive(query: str, guide: Guide, load: Callable[[Scene], None]) -> None:
    """Open the lesson and load the scene of a query; InvalidInput where it makes no sense."""
    values = {key: value for key, value in parse_query(query).items() if key not in OTHERS}
    name = str(values.pop("lesson", ""))
    if not (name or values):
        return
    scene = lesson(name).scene if name else Scene()
    scene = scene.changed(**values)
    if name:
        guide.open(name)
    if values:
        load(scene)
