"""A sweep before anything is solved: its axes, what does not vary, and its chunks."""

import itertools
import math
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from beamviz.beam import NUMBERS, Beam
from beamviz.checks import full_text
from beamviz.errors import InvalidInput
from beamviz.frequency_loci.path import check_values
from beamviz.solver import METHODS, Problem, parse_keywords
from beamviz.units import Units, parse_over

MAX_AXES = 5
MAX_VALUES = 1_000_000  # of an axis
ROUNDING = 1e-9  # relative, of a value of an axis that is named again
# Beams of a chunk, at most and at least: one to five seconds of work where beams are solved in
# stacks, so that a cluster's scheduler keeps up and files are few; else 5 to 20 ms a beam. A small
# sweep has about CHUNKS of them, for all processes to have some.
STACKED = 1024, 16384
ONE_BY_ONE = 16, 256
CHUNKS = 32

Chunk = tuple[int, ...]  # its position along each axis, in chunks
Region = tuple[slice, ...]  # of the arrays


@dataclass(frozen=True)
class Plan:
    """Every combination of the values of some parameters of a beam. axes: the values (n,) by
    parameter, in the order of the dimensions. beam: holds the other numbers."""

    axes: dict[str, np.ndarray]
    beam: Beam
    problem: Problem

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return tuple(map(len, self.axes.values()))

    @property
    def size(self) -> int:
        """Number of beams."""
        return math.prod(self.shape)

    @cached_property
    def longest(self) -> int:
        """The axis with the most values."""
        return self.shape.index(max(self.shape))

    @cached_property
    def is_stacked(self) -> bool:
        """Whether `solve_many` solves beams in stacks, rather than one after the other."""
        spin_up = self.beam.spin_up or "spin_up" in self.axes
        hp = METHODS[self.problem.method].package == "hp"
        return hp and self.problem.state == "straight" and not spin_up

    @property
    def gains_by_stacks(self) -> bool:
        """Whether a beam of a stack takes less time than one alone; a blade takes the same."""
        return self.is_stacked and self.beam.blade is None

    @cached_property
    def chunk_shape(self) -> tuple[int, ...]:
        """Number of values of a chunk along each axis: whole lines along the longest axis where
        these are not too long, and neighbours. It follows from the arguments alone: what is solved
        together, hence every digit, must not depend on the machine."""
        least, most = STACKED if self.gains_by_stacks else ONE_BY_ONE
        left = min(most, max(self.size // CHUNKS, least))
        chunk = [1] * len(self.shape)
        names = list(self.axes)  # beams with their mass at one place are solved together
        others = sorted(range(len(names)), key=lambda axis: (names[axis] == "beta", -axis))
        for axis in (self.longest, *others):
            if chunk[axis] == 1:
                pieces = math.ceil(self.shape[axis] / max(left, 1))
                chunk[axis] = math.ceil(self.shape[axis] / pieces)
                left //= chunk[axis]
        return tuple(chunk)

    @cached_property
    def chunks(self) -> list[Chunk]:
        """All chunks."""
        counts = [math.ceil(n / c) for n, c in zip(self.shape, self.chunk_shape, strict=True)]
        return list(itertools.product(*map(range, counts)))

    def region(self, chunk: Chunk) -> Region:
        """The region of a chunk in the arrays."""
        ends = zip(chunk, self.chunk_shape, self.shape, strict=True)
        return tuple(slice(k * c, min((k + 1) * c, n)) for k, c, n in ends)

    def part(self, chunk: Chunk) -> "Plan":
        """The sweep over the values of a chunk."""
        axes = zip(self.axes.items(), self.region(chunk), strict=True)
        return replace(self, axes={name: values[region] for (name, values), region in axes})

    def beams(self) -> list[Beam]:
        """All beams, in the order of a flattened array of the sweep."""
        values = itertools.product(*(axis.tolist() for axis in self.axes.values()))
        return [self.beam.replace(**dict(zip(self.axes, row, strict=True))) for row in values]

    @property
    def arguments(self) -> dict[str, Any]:
        """The arguments of this sweep besides its axes, by name, in the types of JSON; units unless
        they vary, as over mu."""
        every = {"spin_up": 0.0, **self.beam.attributes}
        fixed = {name: value for name, value in every.items() if name not in self.axes}
        units = self.beam.units if "mu" not in self.axes else None
        return {**fixed, **self.problem.options, **(units.attributes if units else {})}


def make_plan(axes: Mapping[str, ArrayLike], beam: Beam, **options: Any) -> Plan:
    """The sweep of validated arguments; InvalidInput names what is wrong."""
    if not axes:
        raise InvalidInput(f"no axis is given: name one or more of {', '.join(NUMBERS)}")
    if len(axes) > MAX_AXES:
        raise InvalidInput(f"{len(axes)} axes, {', '.join(axes)}: must be at most {MAX_AXES}")
    values = {}
    for text, given in axes.items():
        name, factor = parse_over(text, beam.units)
        if name in values:
            raise InvalidInput(f"axis {text!r}: {name} is given twice")
        values[name] = check_values("axis", name, given, 1, MAX_VALUES, factor)
    extremes = {name: float(array[0 if name == "mu" else -1]) for name, array in values.items()}
    beam = beam.replace(**extremes)  # its units are kept; raises where gamma / mu is too large
    return Plan(values, beam, parse_keywords(**options))


def find_place(
    axes: Mapping[str, np.ndarray],
    over: Sequence[str],
    at: Mapping[str, float],
    units: Units | None = None,
) -> dict[str, int]:
    """The position on each axis of a sweep but those in `over`, by its value, which may be in a
    unit, as {"rpm": 300}, where the units of the beam are known; an axis of one value needs none.
    InvalidInput names what is wrong."""
    known = ", ".join(axes)
    named = ((*parse_over(text, units), value) for text, value in at.items())
    at = {name: value / factor for name, factor, value in named}
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
            near = full_text(float(values[k]))
            raise InvalidInput(f"at {name}={value:g}: not in this sweep; the nearest is {near}")
    return place


def axis_text(values: np.ndarray) -> str:
    """A short text of the values of an axis, which differs where they do."""
    texts = [full_text(value) for value in values.tolist()]
    if len(texts) <= 6:
        return ", ".join(texts)
    checksum = f"{zlib.crc32(values.tobytes()):08x}"
    return f"{texts[0]} .. {texts[-1]} ({len(texts)} values, checksum {checksum})"
