"""Presenter mode: a visitor sees the presenter's scene until they edit it, and can return to it."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from beamviz.drawing.modes import Clock
from beamviz.explorer.jobs import Job
from beamviz.explorer.visitor import Visitor

LABEL = "follow the presenter"
FIRST = -1.0  # above all other controls
FIELDS = ("scene", "case", "view", "over", "per_rev")  # of the state, which follow


class Presentation(NamedTuple):
    """What others can follow of a visitor: the state and the solution, the loci charts and the
    clock of the scene."""

    visitor: Visitor
    charts: Job
    clock: Clock


class PresenterMode:
    """Keeps a visitor's page in line with the presenter's while they follow; nothing is solved for
    it then. presenter: gives what to follow, None while there is no presenter."""

    def __init__(self, own: Presentation, presenter: Callable[[], Presentation | None]):
        self.own, self.presenter = own, presenter
        hint = "Move any control to explore by yourself; tick this to come back"
        box = own.visitor.client.gui.add_checkbox(LABEL, True, hint=hint, order=FIRST)
        own.visitor.bind_key(box, "following")

    @property
    def followed(self) -> Presentation | None:
        """What to follow now."""
        return self.presenter() if self.own.visitor.state.following else None

    @property
    def outdated(self) -> bool:
        """Whether the presenter has something new."""
        own, other = self.own, self.followed
        return other is not None and (
            other.visitor.solver.answer is not own.visitor.solver.answer
            or other.visitor.state.view is not own.visitor.state.view
            or other.charts.answer is not own.charts.answer
        )

    def update(self) -> None:
        """Take over the state and the answers of the presenter."""
        own, other = self.own, self.followed
        if other is None:
            return
        with own.visitor.lock:
            own.visitor.solver.adopt(other.visitor.solver)
            own.charts.adopt(other.charts)
            state, theirs = own.visitor.state, other.visitor.state
            changes = {name: getattr(theirs, name) for name in FIELDS}
            if any(getattr(state, name) is not value for name, value in changes.items()):
                own.visitor.follow(replace(state, **changes))

    def update_clock(self) -> None:
        """Show the same moment of the same vibration as the presenter."""
        clock = self.own.clock
        if other := self.followed:
            theirs = other.clock
            if len(clock.phases) == len(theirs.phases):
                clock.phases, clock.angle, clock.rate = theirs.phases, theirs.angle, theirs.rate
