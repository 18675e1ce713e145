"""The solutions of a visitor's cases, as the scene draws them."""

import math
import time
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from beamviz.drawing.modes import SampledModes
from beamviz.drawing.text import (
    error_summary,
    in_words,
    out_of_range,
    stability_warning,
    stretch_caution,
    yield_caution,
)
from beamviz.errors import BeamvizError, Cancelled, InvalidInput, NoEquilibrium, to_keep
from beamviz.explorer.jobs import Answer, Callback, Computation, Job, Workers
from beamviz.explorer.second_beam import ComparisonCase
from beamviz.explorer.state import Case
from beamviz.scene import Scene
from beamviz.solver import Solution, solve

SOLUTION = "solution"  # name of the job
QUICK = 0.02  # [s] processor time of a solve that is done in the frame
LONGEST = 0.1  # [s] that it may take there


# Maximum resolution for a page: one solve takes at most 0.15 s, a chart takes 81 solves.
PAGE_LIMITS = {"elements": 200, "terms": 100}


def within_limits(scene: Scene) -> Scene:
    """Return a scene from a file or link. Raises InvalidInput if it exceeds PAGE_LIMITS."""
    options = [scene.options, scene.second_scene.options]
    for name, most in PAGE_LIMITS.items():
        if (value := max(one.get(name) or 0 for one in options)) > most:
            limit = f"a page solves with at most {most}; the command line takes more"
            raise InvalidInput(f"{name} = {value}: {limit}")
    return scene


@dataclass(frozen=True, eq=False)
class SolverAnswer(Answer[Case, SampledModes]):
    """The answer to a case: its modes as the scene draws them, or the error."""

    @property
    def solution(self) -> Solution | None:
        return self.result.solution if self.result else None

    @cached_property
    def shapes(self) -> SampledModes:
        """The modes, or without a solution the unloaded beam of the case, or the nearest to it."""
        return self.result or SampledModes.at_rest(
            self.beam or self.request.nearest_beam(), self.request.options["plane"]
        )

    @cached_property
    def warning(self) -> str:
        """The reason why no beam is at rest here, in short lines; "" for a stable equilibrium."""
        if self.error:
            return error_summary(self.error, self.beam)
        return stability_warning(self.solution) if self.solution else ""

    @cached_property
    def caution(self) -> str:
        """The reason why no real beam has this stable equilibrium, or would return from it to its
        shape; "" where one may."""
        if self.solution is None or self.warning:
            return ""
        return stretch_caution(self.solution) or yield_caution(self.solution)

    @property
    def message(self) -> str:
        """The full text of the warning or the error; "" for a stable equilibrium."""
        known = self.error is None or isinstance(self.error, NoEquilibrium)
        return self.warning if known else case_error(str(self.error), self.request)


def case_error(text: str, case: Case) -> str:
    """An error of a case in the words of the page; all numbers out of range in their own units."""
    return out_of_range(case.numbers, case.units) or in_words(text, case.units)


class Cases(NamedTuple):
    """A case to solve, and what to compare it with."""

    case: Case
    comparison: ComparisonCase = ComparisonCase()


class Solved(NamedTuple):
    """The answers to two cases, so that a picture never shows beams of different moments."""

    answer: SolverAnswer
    second: SolverAnswer | None


class SolveJob(Job[Cases, Solved]):
    """Solves the latest case of one visitor, and the one that it is compared with.

    seconds: the processor time of the last solve, infinite where that took too long for a frame.
    """

    def __init__(self, workers: Workers, ready: Callback):
        super().__init__(SOLUTION, self.solved, self.do, ready)
        self.on_thread = workers.solvers.submit
        self.seconds = math.inf

    @property
    def is_quick(self) -> bool:
        """Whether a solve is likely to be quick, as the last one was."""
        return self.seconds < QUICK

    def do(self, work: Callback) -> None:
        """Do the work at once, in the frame that requests it, if it is likely to be quick: to hand
        it to a worker thread, and to wait for that, takes half as long again. Else a thread does
        it, and no frame waits for it."""
        if self.is_quick:
            work()
        else:
            self.on_thread(work)

    def check(self, run: Computation[Cases], done: float | None = None) -> None:
        """Raise Cancelled also in a frame, after the time LONGEST: then a thread begins again."""
        if self.is_quick and time.monotonic() > run.started + LONGEST:
            self.seconds = math.inf
            raise Cancelled
        super().check(run, done)

    def solved(self, cases: Cases) -> Solved:
        """The answers, of which the last ones are used again: many cases are compared with one, and
        one with many. Raises Cancelled."""
        start = time.thread_time()
        last = (self.answer.result if self.answer else None) or (None, None)
        first, second = last
        case, other = cases.case, cases.comparison.case
        if first is None or first.request != case:
            first = solver_answer(case)
        if other and (second is None or second.request != other):
            second = solver_answer(other)
        if (first, second) != last:
            self.seconds = time.thread_time() - start
        return Solved(first, second if other else None)

    @property
    def compared(self) -> tuple[SolverAnswer | None, SolverAnswer | None, ComparisonCase]:
        """The latest answers, or the reason why there are none, and what was compared with."""
        if (answer := self.answer) is None:
            return None, None, ComparisonCase()
        comparison = answer.request.comparison
        if answer.result is None:
            return SolverAnswer(answer.request.case, error=answer.error), None, comparison
        return *answer.result, comparison


def solver_answer(case: Case) -> SolverAnswer:
    """The answer to a case. Raises Cancelled."""
    try:
        return SolverAnswer(case, SampledModes.sampled(solve(case.beam, **case.options)))
    except BeamvizError as error:
        return SolverAnswer(case, error=to_keep(error))
