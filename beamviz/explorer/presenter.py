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

import threading
from collections import Counter
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from operator import attrgetter
from types import MappingProxyType

from beamviz.explorer.clock import Clock
from beamviz.explorer.snapshot import Inputs, Snapshot
from beamviz.explorer.state import State

MOST_VOTERS, MOST_VOTES = 1000, 200  # votes of one voter


class Votes:
    """What the visitors of a lecture have chosen, in memory until the server ends. Who loses the
    connection, as a phone that is locked, and comes back is the same voter. Where there is no more
    room, the vote replaces the voter who voted longest ago, or the oldest vote of the same voter.

    changed: called after each vote; present: the number of visitors there, besides presenters.
    """

    def __init__(self, changed: Callable[[], None] = lambda: None):
        self.changed, self.present = changed, 0
        self.lock = threading.Lock()
        # The answers by voter and question, and how many have chosen each, by question; the latest
        # are the last.
        self.of_voters: dict[str, dict[str, int]] = {}
        self.counted: dict[str, Counter[int]] = {}

    def cast(self, voter: str, question: str, answer: int) -> None:
        """Take the answer (from 0) of a voter to a question, in place of an earlier one."""
        with self.lock:
            votes = self.of_voters[voter] = self.of_voters.pop(voter, {})
            if question in votes:
                self.count(question, votes.pop(question), -1)
            votes[question] = answer
            self.count(question, answer, 1)
            if len(votes) > MOST_VOTES:
                oldest = next(iter(votes))
                self.count(oldest, votes.pop(oldest), -1)
            if len(self.of_voters) > MOST_VOTERS:
                self.remove(next(iter(self.of_voters)))
        self.changed()

    def remove(self, voter: str) -> None:
        """Remove the votes of a voter."""
        for question, answer in self.of_voters.pop(voter).items():
            self.count(question, answer, -1)

    def count(self, question: str, answer: int, by: int) -> None:
        """Count an answer once more (1), or once less (-1). Snapshots have the counter before."""
        counter = Counter(self.counted.pop(question, ()))
        counter[answer] += by
        if counter := +counter:
            self.counted[question] = counter

    @property
    def counts(self) -> Mapping[str, Mapping[int, int]]:
        """How many have chosen each answer, by question, at this moment."""
        with self.lock:
            return MappingProxyType(dict(self.counted))


def led_state(own: State, led: State) -> State:
    """The state of a visitor who follows a presenter in another state."""
    tab = own.tab if own.presented_tab == led.tab else led.tab
    same_frame = own.view.rotating_frame == led.view.rotating_frame
    turned = own.turned if same_frame else None
    shown = own.under(led, attrgetter("led"))
    slices = {kind: record.led(led.slice(kind)) for kind, record in shown.slices.items()}
    return replace(shown, slices=slices, turned=turned, tab=tab, presented_tab=led.tab)


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
