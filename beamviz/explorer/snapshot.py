"""The snapshot of one frame: everything that a page shows is a function of it."""

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, Self

from beamviz.beam import Beam
from beamviz.drawing.modes import SampledModes
from beamviz.errors import InvalidInput
from beamviz.explorer.clock import Clock
from beamviz.explorer.film import Film
from beamviz.explorer.jobs import Answer, JobStatus, percentage
from beamviz.explorer.second_beam import ComparisonCase, comparison_case
from beamviz.explorer.solutions import SolverAnswer
from beamviz.explorer.state import Case, State
from beamviz.explorer.view import Picture


@dataclass(frozen=True, eq=False)
class Inputs:
    """What a snapshot is made of: state, answers and clock of a visitor at one moment."""

    state: State
    answer: SolverAnswer | None  # to the latest case solved; None before the first
    second: SolverAnswer | None  # to `comparison`, solved with it
    comparison: ComparisonCase
    jobs: Mapping[str, JobStatus]  # background jobs, by name
    clock: Clock  # the moment of the motion
    aspect: float  # width over height of the scene in the page
    covered: float  # fraction of half the height of the scene that the page covers below
    scale: float  # of the picture [pixels per beam length]
    undo: bool  # there is a step to undo
    redo: bool
    is_led: bool = False  # all but viewpoint and tab are those of a presenter
    # Of a presenter: how many visitors have chosen each answer, by question, and are there.
    votes: Mapping[str, Mapping[int, int]] = field(default_factory=dict)
    audience: int = 0

    @property
    def beam(self) -> Beam | None:
        """The beam of the answer; None before the first, and where a number is out of range."""
        return self.answer.beam if self.answer else None

    @property
    def entered_beam(self) -> Beam | None:
        """The beam with the numbers that were entered, also before it is solved; None where one of
        them is out of range. Charts have their handle at it, which sets these numbers, too."""
        with contextlib.suppress(InvalidInput):
            return self.state.shown_case.beam
        return None

    @property
    def drawn_case(self) -> Case | None:
        """The case of the beam in the scene: that of the answer, or the nearest one where a number
        is out of range; None before the first answer."""
        if self.answer is None:
            return None
        return self.answer.request if self.beam else self.answer.request.nearest

    @property
    def solved(self) -> SampledModes | None:
        """The modes of the answer; None where it has no solution."""
        return self.answer.result if self.answer else None

    @property
    def settled(self) -> bool:
        """Whether the answers are those to the case of the state and the one compared with."""
        case = self.state.shown_case
        return (
            self.answer is not None
            and self.answer.request == case
            and self.comparison == comparison_case(self.state, case)
        )

    def job_answer(self, name: str) -> Answer[Any, Any] | None:
        """The last answer of a job."""
        return self.jobs[name].answer


@dataclass(frozen=True, eq=False, kw_only=True)
class Snapshot(Inputs):
    """One moment of a visitor's session."""

    picture: Picture  # what the scene shows of it

    @classmethod
    def of(cls, inputs: Inputs, picture: Picture) -> Self:
        """The snapshot of a visitor's inputs, of which the scene shows a picture."""
        return cls(
            **{entry.name: getattr(inputs, entry.name) for entry in fields(Inputs)}, picture=picture
        )

    def lateness(self, *names: str) -> str:
        """What to say of what these jobs have computed while that is for numbers before those
        shown, with the fraction of the new result; "" else."""
        late = [self.jobs[name] for name in names if self.jobs[name].late]
        return f"outdated: computing …{percentage(late)}" if late else ""

    @property
    def film(self) -> Film | None:
        """The computed motion that the scene plays, if any."""
        return self.picture.film

    @property
    def is_moving(self) -> bool:
        """Whether the clock goes on: there are modes, and nothing is in a hand."""
        view, plays = self.state.view, self.picture.plays
        if plays is None:
            plays = view.playing and view.pace > 0
        return plays and self.solved is not None

    @cached_property
    def rate(self) -> float:
        """The time [T*] per second on the screen, before the visitor's own factor."""
        return self.state.rate or self.picture.rate
