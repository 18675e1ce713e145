"""A sweep as data: its axes, the numbers and options that do not vary, and its chunks."""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from beamviz.beam import NUMBERS, Beam, exact_text
from beamviz.errors import InvalidInput
from beamviz.frequency_loci.sweep import check_values
from beamviz.solver import METHODS, Problem, parse_keywords

MAX_AXES = 5
MAX_VALUES = 1_000_000  # of an axis
ROUNDING = 1e-9  # relative, of a value of an axis that is named again
# Beams of a chunk: about a second of work, so that a cluster's scheduler keeps up, and few enough
# files. A small sweep has about TASKS of them, for all processes to have some.
FAST, COUPLED, SLOW = 16384, 4096, 256
LEAST, LEAST_SLOW = 1024, 16
TASKS = 32

Task = tuple[int, ...]  # a chunk, by its position along each axis


@dataclass(frozen=True)
class Plan:
    """Every combination of the values of some parameters of a beam. axes: the values (n,) by
    parameter, in the order of the dimensions. beam: holds the other numbers."""

    axes: dict[str, np.ndarray]
    beam: Beam
    problem: Problem

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Numbers of values."""
        return tuple(map(len, self.axes.values()))

    @cached_property
    def line(self) -> int:
        """The axis along which beams are solved together: the longest."""
        return self.shape.index(max(self.shape))

    @cached_property
    def smooth(self) -> bool:
        """Whether omega^2 of each mode is a smooth function of the parameters."""
        hp = METHODS[self.problem.method].package == "hp"
        spin_up = self.beam.spin_up or "spin_up" in self.axes
        return hp and self.problem.state == "straight" and not spin_up

    @cached_property
    def chunk(self) -> tuple[int, ...]:
        """Numbers of values of a chunk: whole lines, if they are not too long, and neighbours. They
        follow from the arguments alone: what is solved together, hence every digit, must not depend
        on the machine."""
        most, least = COUPLED if self.problem.gyroscopic else FAST, LEAST
        if not self.smooth:
            most, least = SLOW, LEAST_SLOW
        left = min(most, max(math.prod(self.shape) // TASKS, least))
        chunk = [1] * len(self.shape)
        names = list(self.axes)  # beams with their mass at one place share their meshes
        others = sorted(range(len(names)), key=lambda axis: (names[axis] == "beta", -axis))
        for axis in (self.line, *others):
            if chunk[axis] == 1:
                pieces = math.ceil(self.shape[axis] / max(left, 1))
                chunk[axis] = math.ceil(self.shape[axis] / pieces)
                left //= chunk[axis]
        return tuple(chunk)

    @cached_property
    def tasks(self) -> list[Task]:
        counts = [math.ceil(n / c) for n, c in zip(self.shape, self.chunk, strict=True)]
        return list(itertools.product(*map(range, counts)))

    def region(self, task: Task) -> tuple[slice, ...]:
        """The region of a chunk in the arrays."""
        ends = zip(task, self.chunk, self.shape, strict=True)
        return tuple(slice(k * c, min((k + 1) * c, n)) for k, c, n in ends)

    def beams_of(self, task: Task) -> int:
        """The number of beams of a chunk."""
        return math.prod(part.stop - part.start for part in self.region(task))

    @property
    def arguments(self) -> dict[str, Any]:
        """The arguments of this sweep besides its axes, by name, in the types of JSON; units unless
        they vary, as over mu."""
        fixed = {name: getattr(self.beam, name) for name in NUMBERS if name not in self.axes}
        units = self.beam.units if "mu" not in self.axes else None
        return {**fixed, **self.problem.options, **(units.attributes if units else {})}


def make_plan(axes: Mapping[str, ArrayLike], beam: Beam, **options: Any) -> Plan:
    """The sweep of validated arguments; InvalidInput names what is wrong."""
    if not axes:
        raise InvalidInput(f"no axis is given: name one or more of {', '.join(NUMBERS)}")
    if len(axes) > MAX_AXES:
        raise InvalidInput(f"{len(axes)} axes, {', '.join(axes)}: must be at most {MAX_AXES}")
    values = {
        name: check_values("axis", name, given, 1, MAX_VALUES) for name, given in axes.items()
    }
    extremes = {name: float(array[0 if name == "mu" else -1]) for name, array in values.items()}
    beam = beam.replace(**extremes)  # its units are kept; raises where gamma / mu is too large
    return Plan(values, beam, parse_keywords(**options))


def find_place(
    axes: Mapping[str, np.ndarray], over: Sequence[str], at: Mapping[str, float]
) -> dict[str, int]:
    """The position on each axis of a sweep but those in `over`, by its value; an axis of one value
    needs none. InvalidInput names what is wrong."""
    known = ", ".join(axes)
    for name in over:
        if name not in axes or len(axes[name]) < 2:
            fault = "has one value in" if name in axes else "is no axis of"
            raise InvalidInput(f"over {name}: {name} {fault} this sweep, which is over {known}")
    for name, value in at.items():
        if name not in axes or name in over:
            fault = "varies" if name in over else f"is no axis of this sweep, which is over {known}"
            raise InvalidInput(f"at {name}={value:g}: {name} {fault}")
    place = {}
    for name in (name for name in axes if name not in over):
        values = axes[name]
        if name not in at and len(values) > 1:
            ends = f"{values[0]:g} .. {values[-1]:g}"
            raise InvalidInput(f"at: {name} is missing, one of its {len(values)} values {ends}")
        value = at.get(name, values[0])
        place[name] = k = int(abs(values - value).argmin())
        if not abs(values[k] - value) <= ROUNDING * abs(value):
            near = exact_text(float(values[k]))
            raise InvalidInput(f"at {name}={value:g}: not in this sweep; the nearest is {near}")
    return place
