"""Answers to what a visitor wants: a solution with its shapes, or why there is none."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from beamviz.beam import Beam
from beamviz.drawing.modes import Shapes
from beamviz.errors import BeamvizError
from beamviz.explorer.jobs import Latest
from beamviz.explorer.request import Wanted
from beamviz.explorer.solve_queue import Turns
from beamviz.messages import refused, unstable
from beamviz.server.log import RateLimitedLog
from beamviz.solver import Solution, solve

QUICK = 0.02  # [s] of processor time

log = RateLimitedLog(__name__)


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
        log.error("solution", wanted, error)
        return Answer(wanted, beam, words="No solution", message=f"unexpected: {error}")


class Solver(Latest[Wanted, Answer]):
    """Solves the latest wish of one visitor."""

    wanted: Wanted

    def __init__(self, turns: Turns, wanted: Wanted, ready: Callable[[], None]):
        super().__init__(turns.pool, ready)
        self.turns = turns
        self.shapes: Shapes | None = None  # the last good ones
        self.known: dict[str, Any] | None = None  # the last keywords solved with, and
        self.took = math.inf  # [s] of processor time
        self.want(wanted)

    def line_up(self) -> None:
        """Have the latest wish answered."""
        self.turns.submit(self.work, self.quick)

    def quick(self) -> bool:
        """Whether that takes a moment, as far as is known from the last answer."""
        return self.took < QUICK and self.known == self.wanted.options

    def answered(self, wanted: Wanted) -> Answer:
        """Solve; shapes keep the signs of the last good ones."""
        start = time.thread_time()
        answer = answered(wanted, self.shapes)
        self.known, self.took = wanted.options, time.thread_time() - start
        self.shapes = answer.shapes if answer.shapes and not answer.words else self.shapes
        return answer
