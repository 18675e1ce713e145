"""Lecture mode: a visitor sees the presenter's scene, until they go exploring, and again after."""

import contextlib
import threading
from collections.abc import Callable
from typing import Any, Protocol

from viser import GuiApi

from beamviz.drawing.modes import Clock
from beamviz.errors import InvalidInput
from beamviz.explorer.features.loci_tab import Charting
from beamviz.explorer.page.inputs import assign, heard
from beamviz.explorer.page.panel import Panel
from beamviz.explorer.solver_job import Solver
from beamviz.scene import Scene, ViewOptions

LABEL = "follow the presenter"
FIRST = -1.0  # above all other controls


class Led(Protocol):
    """What a session has that another one can take over."""

    solver: Solver
    charting: Charting
    panel: Panel
    view: ViewOptions
    clock: Clock
    lock: threading.RLock
    wake: Callable[[], None]

    def saved(self) -> Scene:
        """All that is set."""


Leader = Callable[[], Led | None]


class Following:
    """Keeps one session in line with its leader's while `on`; nothing is solved for it then."""

    def __init__(self, session: Led, gui: GuiApi, leader: Leader):
        self.session, self.leader, self.on = session, leader, True
        self.put: tuple[Any, ...] = ()  # what the controls were last put to
        hint = "Move any control to explore by yourself; tick this to come back"
        self.box = gui.add_checkbox(LABEL, True, hint=hint, order=FIRST)
        heard(self.box, threading.RLock(), self.turn)

    @property
    def led_by(self) -> Led | None:
        """Whom to follow now."""
        return self.leader() if self.on else None

    @property
    def behind(self) -> bool:
        """Whether the leader has gone on."""
        lead, session = self.led_by, self.session
        return lead is not None and (
            lead.solver.answer is not session.solver.answer
            or lead.view is not session.view
            or lead.charting.charts.answer is not session.charting.charts.answer
        )

    def turn(self, on: bool) -> None:
        """Follow, or explore from where the presenter is."""
        if on:
            self.on = True
            self.session.wake()
        else:
            self.explore()

    def explore(self) -> None:
        """No longer follow; what was still on its way is solved here."""
        if not self.on:
            return
        self.on = False
        assign(self.box, False)
        solver = self.session.solver
        if solver.answer is None or solver.answer.wanted is not solver.wanted:
            solver.want(solver.wanted)

    def step(self) -> None:
        """Take over what the leader wants and has, and how it looks."""
        lead, session = self.led_by, self.session
        if lead is None:
            return
        with session.panel.lock, session.lock:
            session.solver.adopt(lead.solver)
            session.charting.take(lead.charting.over, lead.charting.per_rev)
            session.charting.charts.adopt(lead.charting.charts)
            session.view = lead.view
            self.show(lead)

    def show(self, lead: Led) -> None:
        """Put the controls where the leader's are, if they have moved."""
        state = (lead.solver.wanted, lead.view, lead.charting.over, lead.charting.per_rev)
        if state != self.put:
            self.put = state
            with contextlib.suppress(InvalidInput):  # numbers that are no beam stay unshown
                self.session.panel.put(lead.saved())

    def keep_time(self) -> None:
        """The same moment of the same vibration as the leader's."""
        if lead := self.led_by:
            clock, theirs = self.session.clock, lead.clock
            if len(clock.phases) == len(theirs.phases):
                clock.phases, clock.angle, clock.rate = theirs.phases, theirs.angle, theirs.rate
