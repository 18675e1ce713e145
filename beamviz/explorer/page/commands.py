"""Keys and the command palette (Ctrl+K): everything one does often, without the mouse."""

from collections.abc import Callable
from functools import partial
from html import escape
from typing import Any

from viser import GuiApi

from beamviz.explorer.features.lessons import Guide
from beamviz.explorer.page.panel import BESIDE, RIDING, Panel
from beamviz.explorer.request import MODES
from beamviz.lessons import LESSONS

KEYS = (
    ("P", "pause or play"),
    (f"1 … {MODES}", "one mode alone"),
    ("N, B", "next and back in a lesson"),
    ("R", "reset the beam"),
    ("V", "reset the view"),
    ("H, S", "ride on the hub, stand beside it"),
    ("C", "Coriolis forces on or off"),
    ("D", "dark or light page"),
    ("Ctrl+K", "all commands, by name"),
    ("Ctrl +", "larger letters, for a projector"),
)


class Commands:
    """The commands of one visitor."""

    def __init__(self, gui: GuiApi, panel: Panel, guide: Guide):
        self.gui, self.panel = gui, panel
        listener = panel.listener
        self.add("Pause or play", "P", partial(self.toggle, "playing"))
        for k in range(MODES):
            self.add(f"Show mode {k + 1} alone", str(k + 1), partial(listener.only, k))
        self.add("Lesson: next page", "N", partial(guide.step, 1))
        self.add("Lesson: previous page", "B", partial(guide.step, -1))
        self.add("Reset the beam", "R", guide.reset)
        self.add("Reset the view", "V", listener.reset_view)
        self.add(RIDING.capitalize(), "H", partial(listener.see, "rotating_frame", True))
        self.add(BESIDE.capitalize(), "S", partial(listener.see, "rotating_frame", False))
        self.add("Coriolis forces on or off", "C", self.toggle_coriolis)
        self.add("Dark or light page", "D", partial(self.toggle, "dark"))
        with gui.add_folder("Keys", expand_by_default=False):
            gui.add_html(help_text())
        for lesson in LESSONS:
            self.add(f"Lesson: {lesson.title}", None, partial(guide.open, lesson.name))

    def add(self, name: str, key: Any, run: Callable[[], Any]) -> None:
        """A command, with or without a key."""
        self.gui.add_command(name, hotkey=key).on_trigger(lambda _: run())

    def toggle(self, name: str) -> None:
        """Change a box of the picture, and hand it on as if it had been clicked."""
        with self.panel.lock:
            box: Any = self.panel.choices[name]
            box.value = not box.value
            self.panel.listener.see(name, box.value)

    def toggle_coriolis(self) -> None:
        """The box follows when the beam has been solved."""
        terms = self.panel.terms
        terms.switch("coriolis", not terms.boxes["coriolis"].value)


def help_text() -> str:
    """The keys, as HTML."""
    rows = "".join(
        f'<tr><td style="padding-right:1em;white-space:nowrap"><b>{escape(key)}</b></td>'
        f"<td>{escape(what)}</td></tr>"
        for key, what in KEYS
    )
    return (
        '<table aria-label="keys" style="font-size:.85em;line-height:1.5;margin:0 .75em .5em">'
        f"{rows}</table>"
    )
