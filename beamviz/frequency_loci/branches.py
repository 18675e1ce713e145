"""The loci between two limits of equilibrium, the labels of their branches, and the branches."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.frequency_loci.avoided_crossings import AvoidedCrossing, avoided_crossings
from beamviz.frequency_loci.path import ParameterPath
from beamviz.frequency_loci.tracking import Track
from beamviz.solver.solution import (
    Solution,
    family_of,
    frequencies_of,
    kinds_of,
    omega_squared_of,
    read_only,
)

Place = tuple[int, int]  # of a mode: its family and its index in it


class Exchange(NamedTuple):
    """A crossing of two modes of one family, lower and upper."""

    lower: Place
    upper: Place
    at: float
    frequency: float
    modes: tuple[int, int]  # their indices by frequency


@dataclass(frozen=True, eq=False, repr=False)
class Branch:
    """One mode along a path, with one label; its family may change. Arrays have one entry per value
    and are read-only. Where the branch is not among the requested modes, mode_index is -1, family
    None, and the others are nan."""

    label: str
    mode_index: NDArray  # (values,) index of the mode in each solution
    s: NDArray  # (values,) growth rate + i frequency
    bending_fraction: NDArray  # (values,) share of the kinetic energy across the beam
    solutions: tuple[Solution | None, ...]  # (values,) None where there is none
    # (values,) share of the kinetic energy in the plane of rotation; None where it bends in one
    # plane
    in_plane_fraction: NDArray | None = None

    @cached_property
    def frequency(self) -> NDArray:
        """Frequencies (values,) in units of 1/T*; nan also where a mode has none."""
        return read_only(frequencies_of(self.s))

    @cached_property
    def growth_rate(self) -> NDArray:
        """Growth rates (values,) in units of 1/T*, negative where the mode decays."""
        return read_only(self.s.real.copy())

    @cached_property
    def omega_squared(self) -> NDArray:
        """omega^2 (values,); of a mode without a frequency minus its squared growth rate."""
        return read_only(omega_squared_of(self.s))

    @cached_property
    def error(self) -> NDArray:
        """Estimated absolute errors (values,) of frequency or growth rate."""
        error = np.full(len(self.s), math.nan)
        for i, (solution, k) in enumerate(zip(self.solutions, self.mode_index, strict=True)):
            if solution is not None and k >= 0:
                error[i] = solution.errors[k]
        return read_only(error)

    @cached_property
    def family(self) -> tuple[str | None, ...]:
        """Family per value: "bending", "stretching" or "mixed"."""
        return tuple(
            None if math.isnan(share) else family_of(share)
            for share in self.bending_fraction.tolist()
        )

    @cached_property
    def kinds(self) -> tuple[str | None, ...]:
        """The first letter of the label that the mode has by its own shares, per value: in one
        plane B or S, or M of a mixed mode; in space F, L or S."""
        if self.in_plane_fraction is None:
            return tuple(None if name is None else name[0].upper() for name in self.family)
        letters = kinds_of(self.bending_fraction.tolist(), self.in_plane_fraction.tolist())
        pairs = zip(letters, self.mode_index.tolist(), strict=True)
        return tuple(letter if index >= 0 else None for letter, index in pairs)

    def __repr__(self) -> str:
        present = int((self.mode_index >= 0).sum())
        return f"Branch({self.label!r}, at {present} of {len(self.mode_index)} values)"


@dataclass(frozen=True, eq=False)
class LabelledTrack:
    """The branches of a track: their numbers, their labels, and where they cross or avoid to.

    The number of a branch is that of its mode by family at the lowest value, family x k + index
    with k modes in each family. Modes of one family that cross exchange their numbers there.
    """

    track: Track

    @cached_property
    def _searches(self) -> tuple[list[AvoidedCrossing], list[tuple[float, float]]]:
        """The avoided crossings located, and the intervals of those that were not."""
        return avoided_crossings(self.track)

    @property
    def avoided_crossings(self) -> list[AvoidedCrossing]:
        """The small least gaps of neighbours of a family."""
        return self._searches[0]

    @property
    def unlocated(self) -> list[tuple[float, float]]:
        """The intervals with a least gap that could not be located."""
        return self._searches[1]

    @cached_property
    def exchanges(self) -> list[Exchange]:
        """The crossings of modes of one family, by ascending value."""
        crossed = [
            Exchange(
                lower=(pair.family, pair.k),
                upper=(pair.family, pair.k + 1),
                at=pair.least.at,
                frequency=pair.least.frequency,
                modes=pair.least.ranks,
            )
            for pair in self.avoided_crossings
            if pair.least.gap == 0
        ]
        return sorted(crossed, key=lambda exchange: exchange.at)

    def numbers(self, values: NDArray) -> NDArray:
        """The number (n, families * k) of the branch of each mode, by family, at values (n,)."""
        _, families, count = self.track.modes.s.shape
        numbers = np.tile(np.arange(families * count), (len(values), 1))
        if families == 2:  # uncoupled: the order within a family is what labels count
            return numbers
        for exchange in self.exchanges:
            pair = np.array([exchange.lower[1], exchange.upper[1]])
            beyond = values > exchange.at
            numbers[np.ix_(beyond, pair)] = numbers[np.ix_(beyond, pair[::-1])]
        return numbers

    @cached_property
    def labels(self) -> dict[int, str]:
        """The labels of the branches by their numbers: B or S and the number in the family. The
        family of coupled modes is that at the first value, or at the first with a straight state.
        """
        track = self.track
        _, families, count = track.modes.s.shape
        if families == 2:
            return {
                family * count + k: f"{letter}{k + 1}"
                for family, letter in enumerate("BS")
                for k in range(count)
            }
        solutions = track.path.solve(track.values)
        first = next(
            (
                k
                for k, solution in enumerate(solutions)
                if isinstance(solution, Solution) and solution.equilibrium.shape == "straight"
            ),
            0,
        )
        numbers = self.numbers(track.values[[first]])[0].tolist()
        reference = solutions[first]
        assert isinstance(reference, Solution)
        return dict(zip(numbers, reference.labels, strict=False))

    @cached_property
    def shown(self) -> list[int]:
        """The numbers of the branches that are among the requested modes anywhere, by their first
        appearance."""
        modes = self.track.modes
        rank = modes.rank.reshape(len(modes.at), -1)
        inside = (rank < self.track.path.problem.modes) & modes.known.reshape(rank.shape)
        numbers = self.numbers(modes.at)
        # By value, then by frequency; rank.size stands for never.
        order = np.where(inside, rank + rank.shape[1] * np.arange(len(rank))[:, None], rank.size)
        first = np.full(rank.shape[1], rank.size)
        np.minimum.at(first, numbers, order)
        by_appearance = first.argsort(kind="stable").tolist()
        return [n for n in by_appearance if first[n] < rank.size and n in self.labels]

    def labels_of(self, places: Iterable[Place], at: float) -> tuple[str, ...]:
        """The labels of the branches of some modes just before a value."""
        count = self.track.modes.s.shape[2]
        (numbers,) = self.numbers(np.array([np.nextafter(at, -np.inf)])).tolist()
        numbers_of_places = (numbers[family * count + k] for family, k in places)
        return tuple(self.labels.get(number, f"{number + 1}") for number in numbers_of_places)


def branches_at(
    path: ParameterPath, values: NDArray, parts: Sequence[LabelledTrack]
) -> tuple[Branch, ...]:
    """The branches at some values. Parts of a branch with the same label are joined."""
    modes, count = path.modes(values), path.problem.modes
    n = len(values)
    rank = np.where(modes.known, modes.rank, count).reshape(n, -1)
    s, bending = modes.s.reshape(n, -1), modes.bending.reshape(n, -1)
    in_plane = np.full_like(bending, math.nan)
    if modes.in_plane is not None:
        in_plane = modes.in_plane.reshape(n, -1)
    columns: dict[str, tuple[NDArray, NDArray, NDArray, NDArray]] = {}
    exists = np.zeros(n, bool)
    for part in parts:
        here = np.flatnonzero((values >= part.track.low) & (values <= part.track.high))
        exists[here] = modes.known[here].any(axis=(1, 2))
        mode_of_branch = part.numbers(values[here]).argsort(axis=1)  # the inverse permutation
        for number in part.shown:
            mode = mode_of_branch[:, number]
            index = rank[here, mode]
            inside = index < count
            rows, mode = here[inside], mode[inside]
            index_of, s_of, bending_of, in_plane_of = columns.setdefault(
                part.labels[number], _absent(n)
            )
            index_of[rows] = index[inside]
            s_of[rows] = s[rows, mode]
            bending_of[rows] = bending[rows, mode]
            in_plane_of[rows] = in_plane[rows, mode]
    if not exists.any():
        return ()
    outcomes = path.solve(values)
    solutions = tuple(
        outcome if isinstance(outcome, Solution) and known else None
        for outcome, known in zip(outcomes, exists.tolist(), strict=True)
    )
    return tuple(
        Branch(
            label,
            read_only(index),
            read_only(s),
            read_only(bending),
            solutions,
            None if modes.in_plane is None else read_only(in_plane),
        )
        for label, (index, s, bending, in_plane) in columns.items()
    )


def _absent(n: int) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    """mode_index, s and the shares of the energy (n,) of a branch that is nowhere."""
    s = np.full(n, complex(math.nan, math.nan))
    return np.full(n, -1), s, np.full(n, math.nan), np.full(n, math.nan)
