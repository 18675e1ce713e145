"""Presenter mode, in which visitors see the presenter's scene."""

from collections.abc import Callable
from dataclasses import replace

from beamviz.explorer import page
from beamviz.explorer.visitor import Feature, Visitor

FOLLOW_LABEL = "follow the presenter"
FOLLOW_HINT = "Any control switches this off: you explore by yourself. Tick it to follow again"


class PresenterMode(Feature):
    """Shows a visitor the presenter's page while they follow; nothing is computed for it then.

    presenter: returns the presenter, None while there is none; itself None without a lecture; tab:
    the one that the presenter had open last, while visitors may open another.
    """

    def __init__(self, visitor: Visitor, presenter: Callable[[], Visitor | None] | None):
        super().__init__(visitor)
        self.presenter, self.tab = presenter, visitor.state.tab
        if presenter:
            self.page.html("presenter", page.checkbox("following", FOLLOW_LABEL, FOLLOW_HINT))
            visitor.bind("following")

    @property
    def followed(self) -> Visitor | None:
        """The presenter, while they are followed."""
        return self.presenter() if self.presenter and self.visitor.state.following else None

    @property
    def inputs(self) -> tuple[object, ...]:
        other = self.followed
        return (other.state, *(job.answer for job in other.jobs)) if other else ()

    def show(self) -> None:
        """Copy the answers and the state of the presenter, without the viewpoint."""
        own, other = self.visitor, self.followed
        for k, job in enumerate(own.jobs):
            job.follow(other.jobs[k] if other else None)
        if other is None:
            return
        with own.lock:
            state = replace(other.state, camera=own.state.camera, following=True)
            if self.tab == state.tab:
                state = replace(state, tab=own.state.tab)
            self.tab = other.state.tab
            if state != own.state:
                own.set_state(state)

    def update_clock(self) -> None:
        if (other := self.followed) and len(self.visitor.clock.phases) == len(other.clock.phases):
            clock, theirs = self.visitor.clock, other.clock
            clock.phases, clock.angle, clock.rate = theirs.phases, theirs.angle, theirs.rate
