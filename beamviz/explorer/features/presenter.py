"""Lecture mode: a visitor sees the presenter's scene, until they go exploring, and again after."""

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

from beamviz.drawing.modes import Clock
from beamviz.explorer.features.loci_tab import Charting
from beamviz.explorer.state import State
from beamviz.explorer.visitor import Visitor

LABEL = "follow the presenter"
FIRST = -1.0  # above all other controls


class Led(Protocol):
    """What a session has that another one can take over."""

    visitor: Visitor
    charting: Charting

    @property
    def clock(self) -> Clock:
        """The clock of its scene."""


class Presenter:
    """Keeps a session in line with its leader's while its visitor follows; nothing is solved for
    it then."""

    def __init__(self, session: Led, leader: Callable[[], Led | None]):
        self.session, self.leader = session, leader
        hint = "Move any control to explore by yourself; tick this to come back"
        gui, visitor = session.visitor.client.gui, session.visitor
        visitor.bind_key(gui.add_checkbox(LABEL, True, hint=hint, order=FIRST), "following")

    @property
    def led_by(self) -> Led | None:
        """Whom to follow now."""
        return self.leader() if self.session.visitor.state.following else None

    @property
    def behind(self) -> bool:
        """Whether the leader has gone on."""
        lead, session = self.led_by, self.session
        return lead is not None and (
            lead.visitor.solver.answer is not session.visitor.solver.answer
            or lead.visitor.state.view is not session.visitor.state.view
            or lead.charting.charts.answer is not session.charting.charts.answer
        )

    def step(self) -> None:
        """Take over the state and the answers of the leader."""
        lead, session = self.led_by, self.session
        if lead is None:
            return
        with session.visitor.lock:
            session.visitor.solver.adopt(lead.visitor.solver)
            session.charting.charts.adopt(lead.charting.charts)
            state = followed(session.visitor.state, lead.visitor.state)
            if state is not session.visitor.state:
                session.visitor.follow(state)

    def keep_time(self) -> None:
        """The same moment of the same vibration as the leader's."""
        if lead := self.led_by:
            clock, theirs = self.session.clock, lead.clock
            if len(clock.phases) == len(theirs.phases):
                clock.phases, clock.angle, clock.rate = theirs.phases, theirs.angle, theirs.rate


def followed(own: State, lead: State) -> State:
    """A follower's state with what the presenter shows; the same one where nothing differs."""
    names = ("scene", "case", "view", "over", "per_rev")
    if all(getattr(own, name) is getattr(lead, name) for name in names):
        return own
    return replace(own, **{name: getattr(lead, name) for name in names})
