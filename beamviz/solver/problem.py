"""What a method is: a way to solve, its source, when to choose it, and what it does not treat."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from beamviz.beam import Beam
from beamviz.solver.physics import Physics
from beamviz.solver.solution import Model, Solution

TOLERANCE = 1e-6  # relative error of each frequency, where none is asked for


class Task(NamedTuple):
    """What is asked of a method."""

    beam: Beam
    model: Model
    physics: Physics
    modes: int
    tolerance: float
    elements: int | None
    terms: int | None
    start: float  # clock at the call


class Feature(NamedTuple):
    """Something a task may ask for that not every method treats."""

    noun: str
    asked: Callable[[Task], bool]
    value: Callable[[Task], str]  # what the task gave, in words


ELEMENTS = Feature(
    "number of elements",
    lambda task: task.elements is not None,
    lambda task: f"elements = {task.elements!r}",
)
TERMS = Feature(
    "number of terms",
    lambda task: task.terms is not None,
    lambda task: f"terms = {task.terms!r}",
)
CORIOLIS = Feature(
    "Coriolis forces",
    lambda task: task.physics.coriolis and task.physics.chordwise,
    lambda task: "coriolis = True",
)


SWITCHES = Feature(
    "switched-off term",
    lambda task: not (task.physics.stiffening and task.physics.softening),
    lambda task: f"{'softening' if task.physics.stiffening else 'stiffening'} = False",
)


@dataclass(frozen=True)
class Method:
    """A way to solve: its name, where it comes from, when to choose it, what it does not treat."""

    name: str
    source: str
    choose: str
    solve: Callable[[Task], Solution]
    refuses: tuple[Feature, ...]
