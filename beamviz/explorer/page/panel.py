"""The page around the scene, except the tabs: status, table of modes, controls, help."""

import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from beamviz.beam import Units
from beamviz.explorer.jobs import Job, SolverAnswer
from beamviz.explorer.page import html
from beamviz.explorer.page.controls import BeamControls
from beamviz.explorer.page.html import button, checkbox, hint, select, slider
from beamviz.explorer.page.modes import HEADING, mode_table
from beamviz.explorer.state import CHOICES, Case, State
from beamviz.explorer.visitor import Visitor
from beamviz.scene import COLOURINGS, MAX_AMPLITUDE, MAX_PACE, MAX_SHARES, MODES

PACE_HINT = "Speed of rotation and vibration on the screen, relative to a suitable one"
AMPLITUDE_HINT = "Largest displacement drawn, over the length of the beam"
MODEL = {
    "strain": "The relation of stretch and axial force; green is that of the paper",
    "curvature": "The measure of bending of a stretched beam; spatial is that of the paper",
    "state": "straight; bent: off its axis, as under spin-up; stable: straight if that is stable,"
    " else bent",
}
METHOD_HINT = "The method of solution; auto is exact to the error shown. It is chosen at the top."
PLANES = {"chordwise": "in plane (chordwise)", "flapwise": "out of plane (flapwise)"}
BOUND = ("playing", "pace", "amplitude", "rotating_frame", "all_modes", "plane", "method")
PICTURE = {
    "ghosts": ("undeformed beam", "The outline of the undeformed beam, and pale its equilibrium"),
    "nodes": ("nodes", "Points of the beam that a mode leaves at rest"),
    "thicken": ("draw thicker", "Draw a thin beam thicker than it is"),
}


# The fixed content of the page by element id: what Python's tables of choices and limits determine.
CONTENT = {
    "status": (
        '<select class="quiet" data-set="plane" aria-label="Plane of vibration">'
        f"{html.options(PLANES)}</select>"
        '<button type="button" class="quiet switch" data-set="coriolis" data-key="c"'
        ' title="Coriolis forces (C)">Coriolis</button>'
        '<select class="quiet" data-set="method" aria-label="Method">'
        f"{html.options(CHOICES['method'])}</select>"
        '<button type="button" class="quiet" id="units" data-point="real-beam">units</button>'
    ),
    "modes": HEADING,
    "motion": (
        slider("pace", "playback speed", PACE_HINT, min=0, max=MAX_PACE, step=0.05)
        + '<div id="pace-text" class="soft"></div>'
        + slider("amplitude", "amplitude", AMPLITUDE_HINT, min=0, max=MAX_AMPLITUDE, step=0.01)
    ),
    "picture": (
        select("colouring", "colour", COLOURINGS)
        + "".join(checkbox(key, label, text) for key, (label, text) in PICTURE.items())
        + button("Dark page", data_set="dark", data_key="d", title="Dark or light page (D)")
    ),
    "model": (
        "".join(select(name, name, CHOICES[name], text) for name, text in MODEL.items())
        + f'<p class="soft">Method {hint("the method", METHOD_HINT)}</p>'
    ),
}


def build(visitor: Visitor) -> None:
    """Fill the page of a visitor, except the tabs, and handle its actions."""
    page = visitor.page
    for id, content in CONTENT.items():
        page.html(id, content)
    BeamControls(visitor)
    for key in (*BOUND, *MODEL, *PICTURE, "colouring", "dark"):
        visitor.bind(key)
    for mode in range(MODES):
        edit = partial(State.share, mode=mode)
        visitor.bind(f"share-{mode}", edit, of="shares", shown=partial(share_of, mode))
    first = visitor.state.case
    visitor.render(
        "case",
        lambda case: page.html("scene-caption", invitation(case) if case is first else ""),
    )
    page.on("only", partial(show_alone, visitor))
    for action, act in {
        "undo": lambda: visitor.restore(visitor.history.undo),
        "redo": lambda: visitor.restore(visitor.history.redo),
        "reset": visitor.reset,
        "reset_view": visitor.reset_view,
        "cancel_jobs": visitor.cancel_jobs,
        "retry_jobs": visitor.retry_jobs,
    }.items():
        page.on(action, partial(without_value, act))


def show_alone(visitor: Visitor, mode: Any) -> None:
    """Show one mode (from 0) alone."""
    if isinstance(mode, int) and 0 <= mode < MAX_SHARES:
        visitor.change(partial(State.only, mode=mode))


def add_commands(visitor: Visitor) -> None:
    """Add the commands of the palette (Ctrl+K)."""
    edits = {
        "Play or pause": partial(toggled, "playing"),
        "Coriolis forces on or off": partial(toggled, "coriolis"),
        "Dark or light page": partial(toggled, "dark"),
        **{f"Show mode {k + 1} alone": partial(State.only, mode=k) for k in range(MODES)},
        "Rotating frame": partial(State.changed, name="rotating_frame", value=True),
        "Stationary frame": partial(State.changed, name="rotating_frame", value=False),
    }
    commands: dict[str, Callable[[], None]] = {
        **{name: partial(visitor.change, edit) for name, edit in edits.items()},
        "Reset the scene": visitor.reset,
        "Fit the view": visitor.reset_view,
    }
    for name, run in commands.items():
        visitor.client.gui.add_command(name).on_trigger(partial(without_value, run))


def show_answer(visitor: Visitor, solved: SolverAnswer | None, shown: list[int]) -> None:
    """Show the answer; if it has no solution, the faded modes of the last one `solved`."""
    page, answer = visitor.page, visitor.answer
    if answer:
        page.html("equilibrium", html.equilibrium_state(answer))
        page.html("mode-rows", mode_table(solved, shown) if solved and solved.solution else "")
        page.props("mode-rows", class_=None if answer.solution else "faded")


def show_picture(visitor: Visitor, largest: float, pace: float, units: Units | None) -> None:
    """Show the colour scale, unless the beam is grey, and the playback rate [T*/s]."""
    page, answer = visitor.page, visitor.answer
    legend = html.legend(visitor.state.view.colouring, largest, units)
    page.html("legend", "" if answer and answer.warning else legend)
    page.html("pace-text", html.pace(pace, units))


def work(jobs: Sequence[Job]) -> str:
    """The jobs that have been running for long, with a button that cancels them; or else those
    cancelled, with one that restarts them."""
    slow = [job for job in jobs if job.slow]
    if slow:
        names, seconds = names_of(slow), int(time.monotonic() - min(job.started for job in slow))
        percent = f" {100 * slow[0].done:.0f} %" if slow[0].done else ""
        state = f'computing: {names} <span aria-hidden="true">…{percent} {seconds} s</span>'
        return state + button("Cancel", data_do="cancel_jobs")
    if cancelled := [job for job in jobs if job.cancelled]:
        return f"cancelled: {names_of(cancelled)}" + button("Compute again", data_do="retry_jobs")
    return ""


def names_of(jobs: Sequence[Job]) -> str:
    """The names of jobs, with commas."""
    return ", ".join(job.name for job in jobs)


def invitation(case: Case) -> str:
    """What can be dragged; without a mass, the speed."""
    mass = "the mass along the beam, or " if case.numbers["alpha"] else ""
    return f"Drag {mass}the line of the speed in the chart below."


def share_of(mode: int, shares: Sequence[float]) -> float:
    """The contribution of one mode (0-based) to the motion."""
    return shares[mode] if mode < len(shares) else 0.0


def without_value(run: Callable[[], None], _: object) -> None:
    """Call `run`, as the handler of an action of the page or of an event of viser."""
    run()


def toggled(name: str, state: State) -> State:
    """With a switch toggled; a change of the equations keeps the case before for comparison."""
    state = state.keep_for_comparison() if name == "coriolis" else state
    return state.changed(name, not state.values[name])
