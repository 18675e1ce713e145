"""The page: results over the scene on the left, controls docked on the right, keys."""

from collections.abc import Callable
from functools import partial
from html import escape
from typing import Any

from viser import GuiApi

from beamviz.beam import Units
from beamviz.explorer.jobs import SolverAnswer
from beamviz.explorer.page import html
from beamviz.explorer.page.controls import NumberControls, TermControls
from beamviz.explorer.page.style import add_style
from beamviz.explorer.state import CHOICES, State
from beamviz.explorer.visitor import Visitor, on_press
from beamviz.exports.html_page import solution_table
from beamviz.scene import COLOURINGS, MAX_AMPLITUDE, MAX_PACE, MODES
from beamviz.server.viser_private import set_html

MODEL = {
    "method": "How the equations are discretised and solved",
    "strain": "The law that relates stretch and force: green is the paper's",
    "curvature": "How bending is measured where the beam is stretched: spatial is the paper's",
    "plane": "chordwise: vibration in the plane of rotation; flapwise: out of it",
}
ALL = "all"
BEAM, VIEW = "beam", "view"
ROTATING, FIXED = "ride on the hub", "stand beside it"
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


class Panel:
    """The controls of one visitor and the tab of modes. results: the panel of results, for more
    tabs; beam_folder: the folder of the beam, for more controls."""

    def __init__(self, visitor: Visitor):
        self.visitor, gui = visitor, visitor.client.gui
        gui.set_panel_label("beamviz")
        gui.main_panel.dock_right()
        gui.main_panel.set_width(320)
        add_style(gui)
        self.results = gui.add_panel()
        with self.results.add_tab("Modes"):
            self.add_modes(gui)
        self.results.dock_left()
        self.results.set_width(370)
        self.beam_folder = gui.add_folder("Beam")
        with self.beam_folder:
            NumberControls(visitor)
        with gui.add_folder("Motion"):
            self.add_motion(gui)
        with gui.add_folder("Picture"):
            self.add_picture(gui)
        with gui.add_folder("Physical effects", expand_by_default=False):
            TermControls(visitor)
        with gui.add_folder("Model", expand_by_default=False):
            for name, hint in MODEL.items():
                visitor.bind_control_key(gui.add_dropdown(name, CHOICES[name], hint=hint), name)

    def add_modes(self, gui: GuiApi) -> None:
        """State of the equilibrium, table of modes, buttons to choose one, and the legend."""
        self.state, self.table = gui.add_html(""), gui.add_html("")
        numbers = [str(k + 1) for k in range(MODES)]
        pick = gui.add_button_group("show", [*numbers, ALL], hint="One mode alone, or all")
        self.legend = gui.add_html("")

        def picked(number: Any) -> None:
            if number == ALL:
                self.visitor.change(lambda state: state.changed("all_modes", True))
            elif number in numbers:
                self.visitor.change(lambda state: state.only(int(number) - 1))

        on_press(pick, picked)

    def add_motion(self, gui: GuiApi) -> None:
        """Clock, amplitude, mix of modes and frame of view."""
        bind = self.visitor.bind_control_key
        self.visitor.page.html("transport", html.PLAY)
        self.visitor.bind_key("playing")
        hint = "Speed of the one clock of rotation and vibration"
        bind(gui.add_slider("pace", 0.0, MAX_PACE, 0.05, 1.0, hint=hint), "pace")
        self.pace = gui.add_html("")
        hint = "Largest displacement drawn, over the length of the beam"
        bind(gui.add_slider("amplitude", 0.0, MAX_AMPLITUDE, 0.01, 0.0, hint=hint), "amplitude")
        with gui.add_folder("Mix several modes", expand_by_default=False):
            for mode in range(MODES):
                self.add_share(gui, mode)
        frame = gui.add_button_group("view", (ROTATING, FIXED))
        on_press(frame, lambda name: self.visitor.change(
            lambda state: state.changed("rotating_frame", name == ROTATING)
        ))  # fmt: skip

    def add_share(self, gui: GuiApi, mode: int) -> None:
        """The share of one mode (from 0) in the picture."""
        hint = f"Share of mode {mode + 1} in the picture"
        slider = gui.add_slider(f"mode {mode + 1}", 0.0, 1.0, 0.05, 0.0, hint=hint)

        def share(state: State) -> float:
            return state.view.shares[mode] if mode < len(state.view.shares) else 0.0

        self.visitor.bind_control(slider, share, lambda state, value: state.share(mode, value))

    def add_picture(self, gui: GuiApi) -> None:
        """What is drawn, and how."""
        bind = self.visitor.bind_control_key
        bind(gui.add_dropdown("colour", COLOURINGS), "colouring")
        hint = "Outline: undeformed. Pale: stretched by the rotation, not vibrating"
        bind(gui.add_checkbox("ghosts", True, hint=hint), "ghosts")
        bind(gui.add_checkbox("nodes", True, hint="Points that stay at rest in a mode"), "nodes")
        hint = "Draw a thin beam thicker than it is"
        bind(gui.add_checkbox("thicken", False, hint=hint), "thicken")
        bind(gui.add_checkbox("dark page", False), "dark")
        reset = gui.add_button_group("reset", (BEAM, VIEW), hint="Back to how it was at first")
        resets = {BEAM: self.visitor.reset, VIEW: self.visitor.reset_view}
        on_press(reset, lambda name: resets.get(name, lambda: None)())

    def add_commands(self) -> None:
        """Keys, commands of the palette (Ctrl+K), and the list of keys."""
        visitor = self.visitor
        self.add_switch("Pause or play", "P", "playing")
        for k in range(MODES):
            self.add_edit(f"Show mode {k + 1} alone", str(k + 1), partial(State.only, mode=k))
        self.add_command("Reset the beam", "R", visitor.reset)
        self.add_command("Reset the view", "V", visitor.reset_view)
        self.add_edit(ROTATING.capitalize(), "H", lambda s: s.changed("rotating_frame", True))
        self.add_edit(FIXED.capitalize(), "S", lambda s: s.changed("rotating_frame", False))
        self.add_switch("Coriolis forces on or off", "C", "coriolis")
        self.add_switch("Dark or light page", "D", "dark")
        with visitor.client.gui.add_folder("Keys", expand_by_default=False):
            visitor.client.gui.add_html(key_list())

    def add_switch(self, name: str, key: str, switch: str) -> None:
        """A command that switches something on or off."""

        def toggled(state: State) -> State:
            state = state.keep_for_comparison() if switch == "coriolis" else state
            return state.changed(switch, not state.value(switch))

        self.add_edit(name, key, toggled)

    def add_edit(self, name: str, key: str, edit: Callable[[State], State]) -> None:
        """A command that edits the state."""
        self.add_command(name, key, lambda: self.visitor.change(edit))

    def add_command(self, name: str, key: Any, run: Callable[[], Any]) -> None:
        """A command with a key."""
        self.visitor.client.gui.add_command(name, hotkey=key).on_trigger(lambda _: run())

    def show_answer(
        self, answer: SolverAnswer, solved: SolverAnswer | None, shown: list[int]
    ) -> None:
        """Show an answer; where it has no solution, that of the last `solved` one, faded."""
        set_html(self.state, html.equilibrium_state(answer))
        table = solution_table(solved.solution, shown) if solved and solved.solution else ""
        set_html(self.table, table if answer.solution else html.faded(table))

    def show_picture(self, largest: float, pace: float, units: Units | None) -> None:
        """Show the scale of the colours and the pace of the picture."""
        set_html(self.legend, html.legend(self.visitor.state.view.colouring, largest, units))
        set_html(self.pace, html.pace(pace, units))


def key_list() -> str:
    """The keys, as HTML."""
    rows = "".join(
        f'<tr><td style="padding-right:1em;white-space:nowrap"><b>{escape(key)}</b></td>'
        f"<td>{escape(command)}</td></tr>"
        for key, command in KEYS
    )
    return (
        '<table aria-label="keys" style="font-size:.85em;line-height:1.5;margin:0 .75em .5em">'
        f"{rows}</table>"
    )
