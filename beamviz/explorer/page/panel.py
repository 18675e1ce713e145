"""What surrounds the scene: status, table of modes, controls of motion, picture and model, keys."""

import time
from collections.abc import Callable, Sequence
from functools import partial
from html import escape
from typing import Any

from beamviz.beam import Units
from beamviz.explorer.jobs import Job, SolverAnswer
from beamviz.explorer.page import html
from beamviz.explorer.page.controls import NumberControls, TermControls
from beamviz.explorer.page.html import button, checkbox, hint, select, slider
from beamviz.explorer.page.modes import HEADING, mode_table
from beamviz.explorer.state import CHOICES, State
from beamviz.explorer.visitor import Visitor
from beamviz.scene import COLOURINGS, MAX_AMPLITUDE, MAX_PACE, MAX_SHARES, MODES

MODEL = {
    "strain": "The law that relates stretch and force: green is the paper's",
    "curvature": "How bending is measured where the beam is stretched: spatial is the paper's",
    "state": "straight; bent: the beam leaves its axis, as under spin-up; stable: straight where"
    " that is stable",
}
METHOD_HINT = "How the equations are discretised and solved. auto is exact to the error shown."
PLANES = {"chordwise": "in plane (chordwise)", "flapwise": "out of plane (flapwise)"}
VIEWS = {"ride on the hub": True, "stand beside it": False}
BOUND = ("playing", "pace", "amplitude", "rotating_frame", "all_modes", "plane", "method")
PICTURE = {
    "ghosts": ("undeformed outline", "Outline: undeformed. Pale: stretched, not vibrating"),
    "nodes": ("nodes", "Points that stay at rest in a mode"),
    "thicken": ("draw thicker", "Draw a thin beam thicker than it is"),
}
KEYS = (
    ("P", "play or pause"),
    (f"1 … {MODES}", "one mode alone"),
    ("N, B", "next and back in a lesson"),
    ("R", "reset the scene"),
    ("V", "fit the view"),
    ("H, S", "ride on the hub, stand beside it"),
    ("C", "Coriolis forces on or off"),
    ("D", "dark or light page"),
    ("Ctrl+Z, Ctrl+Shift+Z", "undo, redo"),
    ("Ctrl+K", "all commands, by name"),
    ("Ctrl +", "larger letters, for a projector"),
)
INVITATION = "Drag the mass along the beam, or the line of the speed in the chart below."
HELP = (
    "Drag the mass along the beam, or drag the scene to look from elsewhere; the wheel zooms.",
    "Tab moves from control to control; arrow keys move a slider, or turn the scene.",
)


class Panel:
    """The page of one visitor, but for the tabs."""

    def __init__(self, visitor: Visitor):
        self.visitor, page, self.work = visitor, visitor.page, ""
        for id, content in {
            "status": status(),
            "transport": transport(),
            "modes": HEADING,
            "motion": motion(),
            "picture": picture(),
            "model": model(),
            "keys": help_text(),
        }.items():
            page.html(id, content)
        NumberControls(visitor)
        TermControls(visitor)
        for key in (*BOUND, *MODEL, *PICTURE, "colouring", "dark"):
            visitor.bind(key)
        for mode in range(MODES):
            self.bind_share(mode)
        first = visitor.state.case
        visitor.render(
            "case", lambda case: page.html("scene-caption", INVITATION if case is first else "")
        )
        visitor.on("only", self.show_alone)
        visitor.on("undo", lambda _: visitor.undo())
        visitor.on("redo", lambda _: visitor.redo())
        visitor.on("reset", lambda _: visitor.reset())
        visitor.on("reset_view", lambda _: visitor.reset_view())
        visitor.on("cancel_jobs", lambda _: visitor.cancel_jobs())
        visitor.on("retry_jobs", lambda _: visitor.retry_jobs())

    def show_alone(self, mode: Any) -> None:
        """Show one mode (from 0) alone."""
        if isinstance(mode, int) and 0 <= mode < MAX_SHARES:
            self.visitor.change(partial(State.only, mode=mode))

    def bind_share(self, mode: int) -> None:
        """Bind the slider of one mode's (from 0) share in the motion."""

        def share(shares: tuple[float, ...]) -> float:
            return shares[mode] if mode < len(shares) else 0.0

        def edit(state: State, value: Any) -> State:
            return state.share(mode, value)

        self.visitor.bind(f"share-{mode}", edit, of="shares", shown=share)

    def add_commands(self) -> None:
        """The commands of the palette (Ctrl+K)."""
        visitor = self.visitor
        edits = {
            "Play or pause": partial(toggled, "playing"),
            "Coriolis forces on or off": partial(toggled, "coriolis"),
            "Dark or light page": partial(toggled, "dark"),
            **{f"Show mode {k + 1} alone": partial(State.only, mode=k) for k in range(MODES)},
            **{
                name.capitalize(): partial(State.changed, name="rotating_frame", value=value)
                for name, value in VIEWS.items()
            },
        }
        commands: dict[str, Callable[[], None]] = {
            name: partial(visitor.change, edit) for name, edit in edits.items()
        }
        commands |= {"Reset the scene": visitor.reset, "Fit the view": visitor.reset_view}
        for name, run in commands.items():
            visitor.client.gui.add_command(name).on_trigger(partial(ignoring_event, run))

    def show_answer(
        self, answer: SolverAnswer, solved: SolverAnswer | None, shown: list[int]
    ) -> None:
        """Show an answer; where it has no solution, that of the last `solved` one, faded."""
        page = self.visitor.page
        page.html("equilibrium", html.equilibrium_state(answer))
        page.html("mode-rows", mode_table(solved, shown) if solved and solved.solution else "")
        page.props("mode-rows", class_=None if answer.solution else "faded")

    @property
    def work_outdated(self) -> bool:
        """Whether what is at work is something else than the page says."""
        return work_text(self.visitor.jobs) != self.work

    def show_work(self) -> None:
        """Show the names of the jobs that have been at work for long."""
        self.work = work_text(self.visitor.jobs)
        self.visitor.page.html("work", self.work)

    def show_picture(self, largest: float, pace: float, units: Units | None) -> None:
        """Show the scale of the colours and the pace of the picture."""
        page = self.visitor.page
        page.html("legend", html.legend(self.visitor.state.view.colouring, largest, units))
        page.html("pace-text", html.pace(pace, units))


def work_text(jobs: Sequence[Job]) -> str:
    """What has been at work for how long, with a button that cancels; or what was cancelled."""
    slow, cancelled = ([one for one in jobs if getattr(one, key)] for key in ("slow", "cancelled"))
    if slow:
        seconds = int(time.monotonic() - min(job.started for job in slow))
        percent = "".join(f" {100 * job.done:.0f} %" for job in slow[:1] if job.done)
        state = (
            f'computing: {names_of(slow)} <span aria-hidden="true">…{percent} {seconds} s</span>'
        )
        return state + button("Cancel", data_do="cancel_jobs")
    if cancelled:
        return f"cancelled: {names_of(cancelled)}" + button("Compute again", data_do="retry_jobs")
    return ""


def names_of(jobs: Sequence[Job]) -> str:
    """The names of jobs, in words."""
    return ", ".join(job.name for job in jobs)


def toggled(name: str, state: State) -> State:
    """With a switch turned; how the beam was before a change of its equations is kept."""
    state = state.keep_for_comparison() if name == "coriolis" else state
    return state.changed(name, not state.value(name))


def ignoring_event(run: Callable[[], None], _: object) -> None:
    """Run what needs no event of viser."""
    run()


def status() -> str:
    """The model and the units in words that are switches."""
    planes = "".join(
        f"<option{html.attributes(value=value)}>{escape(name)}</option>"
        for value, name in PLANES.items()
    )
    methods = "".join(f"<option>{escape(name)}</option>" for name in CHOICES["method"])
    return (
        f'<select class="quiet" data-set="plane" aria-label="Plane of vibration">{planes}</select>'
        + button(
            "Coriolis", data_set="coriolis", data_key="c", class_="quiet switch",
            title="Coriolis forces (C)",
        )
        + f'<select class="quiet" data-set="method" aria-label="Method">{methods}</select>'
        + button("units", data_point="real-beam", id="units", class_="quiet")
    )  # fmt: skip


def transport() -> str:
    """Play, frame of view and view, over the scene."""
    views = "".join(
        button(
            name,
            data_set="rotating_frame",
            data_value=value,
            data_key="h" if value else "s",
            class_="quiet",
        )
        for name, value in VIEWS.items()
    )
    play = button(
        "", data_set="playing", data_key="p", id="play", title="Play or pause (P)",
        aria_label="Play",
    )  # fmt: skip
    fit = button(
        "fit", data_do="reset_view", data_key="v", class_="quiet", title="Fit the view (V)"
    )
    return f'{play}<span role="group" aria-label="View">{views}</span>{fit}'


def motion() -> str:
    """Clock and amplitude."""
    pace = "Speed of the one clock of rotation and vibration"
    amplitude = "Largest displacement drawn, over the length of the beam"
    return (
        slider("pace", "slow motion", pace, min=0, max=MAX_PACE, step=0.05)
        + '<div id="pace-text" class="soft"></div>'
        + slider("amplitude", "amplitude", amplitude, min=0, max=MAX_AMPLITUDE, step=0.01)
    )


def picture() -> str:
    """What is drawn, and how."""
    boxes = (checkbox(key, label, text) for key, (label, text) in PICTURE.items())
    dark = button("Dark page", data_set="dark", data_key="d", title="Dark or light page (D)")
    return select("colouring", "colour", COLOURINGS) + "".join(boxes) + dark


def model() -> str:
    """The strain law, the curvature and the state."""
    lists = (select(name, name, CHOICES[name], text) for name, text in MODEL.items())
    return "".join(lists) + f'<p class="soft">Method {hint("the method", METHOD_HINT)}</p>'


def help_text() -> str:
    """How to use the page, and its keys."""
    rows = "".join(
        f"<tr><td><kbd>{escape(key)}</kbd></td><td>{escape(command)}</td></tr>"
        for key, command in KEYS
    )
    texts = "".join(f"<p>{escape(text)}</p>" for text in HELP)
    return f'{texts}<table aria-label="keys">{rows}</table>'
