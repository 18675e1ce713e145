"""Answers to what visitors want: the latest wish of each, on a few threads shared by all."""

import logging
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from beamviz.beam import Beam
from beamviz.errors import BeamvizError
from beamviz.mechanics.solve import Solution, solve
from beamviz.show.controls import Wanted
from beamviz.show.motion import Shapes
from beamviz.show.words import refused, unstable

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Answer:
    """What came of a wish: a solution with its shapes, or why not.

    `words` fit where the beam was (empty: all is well), `message` says it in full.
    """

    wanted: Wanted
    beam: Beam | None = None
    solution: Solution | None = None
    shapes: Shapes | None = None
    words: str = ""
    message: str = ""


def answered(wanted: Wanted, previous: Shapes | None) -> Answer:
    """Solve what is wanted; shapes keep the signs of the `previous` ones."""
    beam = None
    try:
        beam = wanted.beam()
        solution = solve(beam, **wanted.options)
        words = unstable(solution)
        return Answer(wanted, beam, solution, Shapes.sampled(solution, previous), words, words)
    except BeamvizError as error:
        return Answer(wanted, beam, words=refused(error, beam), message=str(error))
    except Exception as error:  # a mistake of ours must not end a visitor's session
        log.exception("solving %s failed", wanted)
        return Answer(wanted, beam, words="No solution", message=f"unexpected: {error}")


class Solver:
    """Solves the latest wish of one visitor; wishes that came in between are skipped."""

    def __init__(self, pool: ThreadPoolExecutor, wanted: Wanted, ready: Callable[[], None]):
        self.lock = threading.RLock()
        self.pool, self.wanted, self.ready = pool, wanted, ready
        self.answer: Answer | None = None
        self.shapes: Shapes | None = None  # the last good ones
        self.busy = self.closed = False
        self.want(wanted)

    def want(self, wanted: Wanted) -> None:
        """Ask for an answer to `wanted`, soon, in place of any earlier wish."""
        with self.lock:
            self.wanted = wanted
            if not (self.busy or self.closed):
                self.busy = True
                self.pool.submit(self.work)

    def work(self) -> None:
        """Answer one wish, and line up again if there is another by then."""
        answer = answered(self.wanted, self.shapes)
        with self.lock:
            self.answer = answer
            self.shapes = answer.shapes if answer.shapes and not answer.words else self.shapes
            self.busy = self.wanted is not answer.wanted and not self.closed
            if self.busy:
                self.pool.submit(self.work)
        self.ready()

    def close(self) -> None:
        """No more answers."""
        with self.lock:
            self.closed = True
