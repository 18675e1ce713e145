"""The loci between two limits of a sweep, the labels of their branches, and the branches."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from beamviz.errors import NotConverged
from beamviz.frequency_loci.axis import Axis
from beamviz.frequency_loci.crossings import Event, locate_events
from beamviz.frequency_loci.curves import Curves
from beamviz.frequency_loci.interpolation import first_values, interpolate, unresolved
from beamviz.frequency_loci.limits import LimitSearch
from beamviz.frequency_loci.sweep import Sweep, frequency_rank
from beamviz.solver.solution import Solution, family_of, read_only

ABSENT = np.array([-1.0, *4 * [np.nan]])[:, None, None]  # of a branch: mode_index, then Piece.at
SHORTEST = 1e-6  # of a sweep: a shorter part between two limits is not interpolated


class Solutions(Sequence[Any]):
    """The Solution, or None, at each value of a sweep, solved on access; at once in a loop."""

    def __init__(self, sweep: Sweep, values: np.ndarray, exists: np.ndarray):
        self._sweep, self._values, self._exists = sweep, values, exists

    def __len__(self) -> int:
        return len(self._values)

    def __getitem__(self, k: Any) -> Any:
        if isinstance(k, slice):
            return [self[i] for i in range(*k.indices(len(self)))]
        return self._sweep.solve(self._values[[k]])[0] if self._exists[k] else None

    def __iter__(self) -> Iterator[Solution | None]:
        self._sweep.solve(self._values[self._exists])
        return (self[k] for k in range(len(self)))


@dataclass(frozen=True, eq=False, repr=False)
class Branch:
    """One mode along a sweep, with one label; its family may change. Arrays have one entry per
    value and are read-only. Where the branch is not among the requested modes, mode_index is -1,
    family None, and the others are nan."""

    label: str
    mode_index: np.ndarray  # (values,) index of the mode in each solution
    omega_squared: np.ndarray  # (values,) negative where unstable
    solver_error: np.ndarray  # (values,) of omega^2, absolute; nan where it takes a solve
    bending_fraction: np.ndarray  # (values,) share of the kinetic energy across the beam
    interpolation_error: np.ndarray  # (values,) of omega^2, in addition
    solutions: Solutions  # (values,) None where there is none

    @cached_property
    def frequency(self) -> np.ndarray:
        """Frequencies (values,) in units of 1/T*; nan also where unstable."""
        return read_only(np.sqrt(np.where(self.omega_squared >= 0, self.omega_squared, np.nan)))

    @cached_property
    def growth_rate(self) -> np.ndarray:
        """Growth rates (values,) in units of 1/T*; 0 where stable."""
        return read_only(np.sqrt(np.maximum(-self.omega_squared, 0.0)))

    @cached_property
    def error(self) -> np.ndarray:
        """Estimated absolute errors (values,) of frequency or growth rate."""
        size, solver = abs(self.omega_squared), self.solver_error
        if np.isnan(solver[self.mode_index >= 0]).any():
            solver = np.full(len(size), np.nan)
            for i, (solution, k) in enumerate(zip(self.solutions, self.mode_index, strict=True)):
                if solution is not None and k >= 0:
                    solver[i] = solution.omega_squared_errors[k]
        error = solver + self.interpolation_error
        return read_only(error / (np.sqrt(size) + np.sqrt(np.maximum(size - error, 0.0))))

    @cached_property
    def family(self) -> tuple[str | None, ...]:
        """Family per value: "bending", "stretching" or "mixed"."""
        return tuple(
            None if math.isnan(x) else family_of(x) for x in self.bending_fraction.tolist()
        )

    def __repr__(self) -> str:
        present = int((self.mode_index >= 0).sum())
        return f"Branch({self.label!r}, at {present} of {len(self.mode_index)} values)"


@dataclass(frozen=True)
class Part:
    """The loci between two limits. Branches are numbered as their modes by family. Coupled modes
    may still cross, where their coupling vanishes (Perkins & Mote 1986); the branches exchange
    their modes there."""

    curves: Curves
    events: tuple[Event, ...]
    labels: dict[int, str]  # of the branches among the requested modes somewhere

    @property
    def labelled_events(self) -> Iterator[Event]:
        """The events between labelled branches, with their labels."""
        count = self.curves.squares.shape[2]
        before = self.numbers(np.array([np.nextafter(event.at, -np.inf) for event in self.events]))
        for event, numbers in zip(self.events, before.tolist(), strict=True):
            a, b = (self.labels.get(numbers[f * count + k]) for f, k in event.branches)
            if a and b:
                yield replace(event, branches=(a, b))

    def numbers(self, p: np.ndarray) -> np.ndarray:
        """The number (n, families * k) of the branch of each mode, by family, at values (n,)."""
        _, families, count = self.curves.squares.shape
        numbers = np.tile(np.arange(families * count), (len(p), 1))
        for event in self.events if families == 1 else ():
            if event.kind == "crossing":
                (_, i), (_, j) = event.branches
                beyond = p > event.at
                numbers[np.ix_(beyond, [i, j])] = numbers[np.ix_(beyond, [j, i])]
        return numbers


def trace(sweep: Sweep, values: np.ndarray, search: LimitSearch) -> list[Part]:
    """The loci between the first and the last of some values, with their events."""
    low, high = values[[0, -1]].tolist()
    axis = sweep.axis(low, high)
    sweep.solve(np.append(first_values(sweep, axis), [low, high]) if sweep.straight else values)
    if any(isinstance(outcome, NotConverged) for outcome in sweep.outcomes.values()):
        sweep.solve(values)  # convergence may vary from value to value
    parts = []
    for axis in search.axes():
        curves = _curves(sweep, axis, values)
        search.find_instabilities(curves)
        part = Part(curves, tuple(locate_events(curves, sweep)), {})
        parts.append(replace(part, labels=_labels(part, sweep)))
    return parts


def _curves(sweep: Sweep, axis: Axis, values: np.ndarray) -> Curves:
    """The loci on an axis, with solves at the values where the interpolation does not converge."""
    if sweep.straight and axis.high - axis.low > SHORTEST * np.ptp(values):
        pieces = interpolate(sweep, axis)
    else:
        pieces = [unresolved(axis, sweep.spectra(values))]
    curves = Curves(axis, pieces, np.empty(0), np.empty((0, *pieces[0].spectra.squares.shape[1:])))
    sweep.solve(values[curves.uncertain(values)])
    solved = np.array(sorted(sweep.outcomes))
    solved = solved[curves.uncertain(solved)]
    squares = sweep.spectra(solved).squares
    exists = np.isfinite(squares).any(axis=(1, 2))
    return replace(curves, solved=solved[exists], squares=squares[exists])


def _labels(part: Part, sweep: Sweep) -> dict[int, str]:
    """The labels of the branches that are among the requested modes anywhere, by first appearance:
    B or S and the number in the family. The family of coupled modes is that at the first value,
    or at the first with a straight state."""
    table = part.curves.table
    _, families, count = table.squares.shape
    rank = table.rank.reshape(len(table.at), -1)
    numbers = part.numbers(table.at)
    inside = (rank < sweep.modes) & np.isfinite(table.squares).reshape(rank.shape)
    order = np.where(inside, rank + rank.shape[1] * np.arange(len(rank))[:, None], rank.size)
    first = np.full(families * count, rank.size)
    np.minimum.at(first, numbers, order)
    found = [n for n in first.argsort(kind="stable").tolist() if first[n] < rank.size]
    if families == 2:
        return {n: f"{'BS'[n // count]}{n % count + 1}" for n in found}
    outcomes = sweep.solve(table.at[:1] if sweep.straight else table.at)
    solutions = [(k, one) for k, one in enumerate(outcomes) if isinstance(one, Solution)]
    straight = [(k, one) for k, one in solutions if one.equilibrium.shape == "straight"]
    for k, solution in (straight or solutions)[:1]:
        labels = dict(zip(numbers[k].tolist(), solution.labels, strict=False))
        return {n: labels[n] for n in found if n in labels}
    return {}


def branches_of(sweep: Sweep, values: np.ndarray, parts: Sequence[Part]) -> tuple[Branch, ...]:
    """The branches at some values. Parts of a branch with the same label are joined."""
    columns: dict[str, np.ndarray] = {}  # mode_index, then Piece.at: (5, values)
    exists = np.zeros(len(values), bool)
    for part in parts:
        axis = part.curves.axis
        here = np.flatnonzero((values >= axis.low) & (values <= axis.high))
        found, numbers = _values(sweep, values[here], part.curves), part.numbers(values[here])
        known = np.isfinite(found[0])
        exists[here] = known.any(axis=(1, 2))
        rank = np.where(known, frequency_rank(found[0]), sweep.modes)
        table = np.stack((rank, *found)).reshape(5, *numbers.shape)
        order = numbers.argsort(axis=1)[:, list(part.labels)]  # (here, labels)
        chosen = table[:, np.arange(len(here))[:, None], order]
        rows = np.tile(ABSENT, (len(values), len(part.labels)))
        rows[:, here] = np.where(chosen[0] < sweep.modes, chosen, ABSENT)
        for label, own in zip(part.labels.values(), np.moveaxis(rows, 2, 0).copy(), strict=True):
            columns[label] = np.where(own[0] >= 0, own, columns.get(label, own))
    if not exists.any():
        return ()
    solutions = Solutions(replace(sweep, outcomes={}), values, exists)
    return tuple(
        Branch(label, read_only(index.astype(int)), squares, solver, bending, error, solutions)
        for label, (index, squares, solver, bending, error) in zip(
            columns, map(read_only, columns.values()), strict=True
        )
    )


def _values(sweep: Sweep, values: np.ndarray, curves: Curves) -> np.ndarray:
    """`Curves.at` for some values, by solves where they are not interpolated."""
    found = curves.at(values, sweep.modes)
    low, high = curves.axis.ends
    solved = curves.uncertain(values) | (values < low) | (values > high)
    if solved.any():
        found[:3, solved] = sweep.spectra(values[solved])
        found[3, solved] = 0.0
    return found
