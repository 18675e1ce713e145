"""A path: solutions along one parameter of a beam, and their modes by family."""

import itertools
import math
from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import NUMBERS, Beam, rounded_into
from beamviz.checks import check_float, full_text
from beamviz.errors import BeamvizError, InvalidInput, NoEquilibrium, did_you_mean
from beamviz.frequency_loci.mode_vectors import ModeVectors, Outcome, gauss_points, mode_vectors
from beamviz.solver import solve_many
from beamviz.solver.problem import Problem
from beamviz.solver.solution import Solution, frequencies_of, omega_squared_of, read_only

EXTRA_MODES = 2  # solved for beyond those requested, as they may become one of the lowest
# More of these in space, where there are as many again, which may cross before.
MORE_IN_SPACE = 2


def check_values(
    argument: str, over: str, values: Any, least: int, most: int, factor: float = 1.0
) -> NDArray:
    """The values of a parameter, an iterable too, as a read-only array (n,); InvalidInput unless
    they are least .. most ascending numbers within its limits. argument: where the parameter was
    named; factor: by which the values are larger, as they are in a unit."""
    if over not in NUMBERS:
        hint = did_you_mean(over, NUMBERS)
        raise InvalidInput(f"{argument} {over!r}: must be one of {', '.join(NUMBERS)}{hint}")
    if isinstance(values, Iterator):
        values = [*itertools.islice(values, most + 1)]  # it may be endless
    try:
        array = np.atleast_1d(np.array(values, float)) / factor + 0.0  # -0.0 becomes 0.0
    except (TypeError, ValueError, OverflowError):
        raise InvalidInput(f"values of {over}: must be numbers") from None
    if array.ndim != 1 or not least <= len(array) <= most:
        count = len(array) if array.ndim == 1 else f"an array of {array.ndim} dimensions"
        raise InvalidInput(f"values of {over}: must be {least} .. {most} numbers, not {count}")
    low, high = NUMBERS[over].limits
    if factor != 1:  # by rounding, an end given in a unit may lie just outside the limits
        array[[0, -1]] = [rounded_into(end, low, high) for end in array[[0, -1]].tolist()]
    for value in array if not np.isfinite(array).all() else array[[0, -1]]:
        check_float(over, float(value), low, high)
    falls = np.flatnonzero(np.diff(array) <= 0)
    if len(falls):
        first, second = map(full_text, array[falls[0] : falls[0] + 2].tolist())
        raise InvalidInput(f"values of {over}: must ascend, but {second} follows {first}")
    return read_only(array)


class PathModes(NamedTuple):
    """Modes at values of a parameter by family, bending first; or all modes as one family. In space
    they are one, though modes of planes that do not couple may cross."""

    at: NDArray  # (values,) ascending
    s: NDArray  # (values, families, k) growth rate + i frequency; nan where not solved for
    bending: NDArray  # (values, families, k) share of the kinetic energy across the beam
    in_plane: NDArray | None = None  # (values, families, k) share of it in the plane of rotation

    @property
    def omega_squared(self) -> NDArray:
        """omega^2 (values, families, k); of a mode without a frequency minus its squared growth
        rate."""
        return omega_squared_of(self.s)

    @property
    def frequencies(self) -> NDArray:
        """Frequencies (values, families, k); nan where a mode has none."""
        return frequencies_of(self.s)

    @property
    def rank(self) -> NDArray:
        """Index (values, families, k) of each mode by frequency among all; those not solved for
        come last."""
        squares = self.omega_squared
        flat = squares.reshape(len(squares), math.prod(squares.shape[1:]))
        order = flat.argsort(axis=1, kind="stable")
        return order.argsort(axis=1, kind="stable").reshape(squares.shape)

    @property
    def known(self) -> NDArray:
        """Whether each mode (values, families, k) was solved for."""
        return np.isfinite(self.s)


@dataclass
class ParameterPath:
    """A beam with one free parameter, and the outcome at each value solved so far."""

    beam: Beam
    over: str
    problem: Problem
    outcomes: dict[float, Outcome] = field(default_factory=dict)

    @cached_property
    def is_straight(self) -> bool:
        """Whether the state sought is the straight one at every value."""
        return self.problem.state == "straight" and self.over != "spin_up" and not self.beam.spin_up

    @cached_property
    def is_coupled(self) -> bool:
        """Whether bending and stretching couple; else the families are independent."""
        turns = self.over == "gamma" or self.beam.gamma > 0
        gyroscopic = self.problem.gyroscopic and turns
        return not self.is_straight or gyroscopic or self.problem.in_space

    @cached_property
    def extra_modes(self) -> int:
        """Number of modes solved for beyond those requested: EXTRA_MODES, or all that the method
        has. Raises InvalidInput where it has fewer modes than requested."""
        return self.problem.available(EXTRA_MODES + MORE_IN_SPACE * self.problem.in_space)

    @cached_property
    def followed_modes(self) -> int:
        """Number of the lowest modes whose crossings are located, so that they keep their labels:
        those requested, and in space those that may become one of them."""
        more = max(self.extra_modes - 1, 0) if self.problem.in_space else 0
        return self.problem.modes + more

    def at(self, value: float) -> Beam:
        """The beam with this value of the free parameter."""
        return self.beam.replace(**{self.over: float(value)})

    def solve(self, values: NDArray) -> list[Outcome]:
        """The Solution, or NoEquilibrium or NotConverged, at each of the values (n,), with extra
        modes; those not solved before are solved in one batch."""
        new = sorted(set(values.tolist()) - self.outcomes.keys())
        if self.loads_more and len(new) > 1:
            new = self._left_below_limit(new)
        if new:
            self._solve(new)
        return [self.outcomes[value] for value in values.tolist()]

    def _solve(self, values: list[float]) -> None:
        """Solve at values in one batch."""
        beams = [self.at(value) for value in values]
        outcomes = solve_many(beams, extra_modes=self.extra_modes, **self.problem.options)
        self.outcomes.update(zip(values, outcomes, strict=True))

    def _left_below_limit(self, values: list[float]) -> list[float]:
        """Of ascending values those left to solve once the last is solved. Where it has no
        equilibrium, neither has any value beyond the first without one, and its error is theirs."""
        last = values[-1]
        self._solve([last])
        error = self.outcomes[last]
        if isinstance(error, NoEquilibrium):
            first = bisect_left(values, True, key=partial(self._is_beyond, error))
            for value in values[first:]:
                self.outcomes.setdefault(value, error)
        return [value for value in values if value not in self.outcomes]

    @cached_property
    def loads_more(self) -> bool:
        """Whether the load grows with the parameter: the centrifugal force with the speed, and with
        the mass where it pulls the beam outward."""
        return self.over == "gamma" or (
            self.over == "alpha" and self.is_straight and self.beam.delta >= 0
        )

    def _is_beyond(self, error: NoEquilibrium, value: float) -> bool:
        """Whether no equilibrium exists at a value, where `error` is that at a greater one; of
        speeds it names the limit."""
        if self.over == "gamma":
            return value > error.limit
        return isinstance(self.solve(np.array([value]))[0], NoEquilibrium)

    def buckles_between(self, low: float, high: float) -> bool:
        """Whether the state is straight at one of two values and bent at the other."""
        ends = self.solve(np.array([low, high]))
        return len({each.equilibrium.shape for each in ends if isinstance(each, Solution)}) == 2

    def modes(self, values: NDArray) -> PathModes:
        """The modes at values (n,), ascending or not; nan without a solution."""
        outcomes, count = self.solve(values), self.problem.modes + self.extra_modes
        solved = [isinstance(outcome, Solution) for outcome in outcomes]
        solutions = [outcome for outcome in outcomes if isinstance(outcome, Solution)]
        s = np.full((len(values), count), complex(math.nan, math.nan))
        bending = np.full(s.shape, math.nan)
        if solutions:
            s[solved] = [solution.s for solution in solutions]
            bending[solved] = [solution.bending_energy_fraction for solution in solutions]
        if self.problem.in_space:
            in_plane = np.full(s.shape, math.nan)
            if solutions:
                in_plane[solved] = [solution.in_plane_fraction for solution in solutions]
            return PathModes(values, s[:, None], bending[:, None], in_plane[:, None])
        if self.is_coupled:
            return PathModes(values, s[:, None], bending[:, None])
        return PathModes(values, *_by_family(s, bending))

    def vectors(self, values: NDArray) -> ModeVectors:
        """The mode vectors at those of the ascending values that have a solution."""
        return mode_vectors(values, self.solve(values), self.gauss_points)

    @cached_property
    def gauss_points(self) -> int:
        """Number of Gauss points of the mode vectors, by the values solved first."""
        return gauss_points(
            [outcome for outcome in self.outcomes.values() if isinstance(outcome, Solution)]
        )


def _by_family(s: NDArray, bending: NDArray) -> tuple[NDArray, NDArray]:
    """s and shares of the energy (values, modes) of uncoupled modes by family (values, 2, modes),
    bending first."""
    in_families = np.full((len(s), 2, s.shape[1]), complex(math.nan, math.nan))
    shares = np.full(in_families.shape, math.nan)
    for family, members in enumerate((bending >= 0.5, bending < 0.5)):
        row, mode = members.nonzero()
        place = (members.cumsum(axis=1) - 1)[row, mode]
        in_families[row, family, place] = s[row, mode]
        shares[row, family, place] = bending[row, mode]
    return in_families, shares


def first_error(outcomes: list[Outcome]) -> BeamvizError:
    """The first of the errors among some outcomes."""
    return next(outcome for outcome in outcomes if isinstance(outcome, BeamvizError))
