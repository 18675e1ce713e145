"""What a visitor who follows a presenter shows: the presenter's last snapshot, but for what is the
visitor's own.

* State: each choice says in its declaration (`led`) whether it is the presenter's, the visitor's
  own, or none; the viewpoint is the visitor's own as long as the frame of reference is the same,
  the tab until the presenter opens another one.
* Answers: those of the presenter; nothing is computed. Jobs that the visitor begins themselves, as
  a file that is written, go on; they can be cancelled, not those of the presenter.
* Clock: that of the presenter.

The other way only votes go: what the visitors have chosen of the answers to a question, for the
presenter to count.

An edit ends it (`Visitor.change`). Who presents is known to the frame loop.
"""

from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from operator import attrgetter
from types import MappingProxyType

from beamviz.explorer.clock import Clock
from beamviz.explorer.snapshot import Inputs, Snapshot
from beamviz.explorer.state import State

MOST_VOTERS, MOST_VOTES = 1000, 100  # votes of one voter


class Votes:
    """What the visitors of a lecture have chosen, in memory until the server ends. Who loses the
    connection, as a phone that is locked, and comes back is the same voter.

    changed: called after each vote; present: the number of visitors there, besides presenters.
    """

    def __init__(self, changed: Callable[[], None] = lambda: None):
        self.changed, self.present = changed, 0
        self.of_voters: dict[str, dict[str, int]] = {}  # by voter and question

    def cast(self, voter: str, question: str, answer: int) -> None:
        """Take the answer (from 0) of a voter to a question, in place of an earlier one."""
        if len(self.of_voters) < MOST_VOTERS or voter in self.of_voters:
            own = self.of_voters.setdefault(voter, {})
            if len(own) < MOST_VOTES or question in own:
                own[question] = answer
                self.changed()

    @property
    def counts(self) -> Mapping[str, Counter[int]]:
        """How many have chosen each answer, by question."""
        counted = defaultdict[str, Counter[int]](Counter)
        for own in self.of_voters.values():
            for question, answer in own.items():
                counted[question][answer] += 1
        return MappingProxyType(counted)


def led_state(own: State, led: State) -> State:
    """The state of a visitor who follows a presenter in another state."""
    tab = own.tab if own.presented_tab == led.tab else led.tab
    same_frame = own.view.rotating_frame == led.view.rotating_frame
    turned = own.turned if same_frame else None
    shown = own.under(led, attrgetter("led"))
    return replace(shown, turned=turned, tab=tab, presented_tab=led.tab)


def led_clock(own: Clock, led: Clock) -> Clock:
    """The clock of the visitor: only a change of their own view goes on."""
    return replace(led, transition=own.transition)


def led_inputs(own: Inputs, led: Snapshot, own_jobs: Collection[str]) -> Inputs:
    """The inputs of the visitor, with the presenter's answers; own_jobs: the names of the jobs that
    the visitor begins."""
    jobs = {name: job._replace(is_own=False) for name, job in led.jobs.items()}
    jobs |= {name: own.jobs[name] for name in own_jobs}
    return replace(
        own,
        answer=led.answer,
        second=led.second,
        comparison=led.comparison,
        jobs=MappingProxyType(jobs),
        is_led=True,
    )
