"""The work of a task: every beam of a chunk, line by line. Along a line, which is one parameter,
some beams are solved, the others interpolated within known errors.

On the straight state omega^2 of the k-th mode of a family is an analytic function of each of the
five parameters. (With Coriolis forces the two families are one.) A line is cut into pieces; in each
it is a polynomial through beams near its Chebyshev points, checked at beams that it does not use.
A piece that fails is halved, until every beam of it is solved. The error of an interpolated omega^2
is that of the solver as the interpolation carries it on, plus SAFETY times the largest found by the
checks.

The interpolation of charts is another one: it chooses its nodes freely, in a variable in which the
frequencies are smooth, and locates what lies between them. Here the nodes are beams of the sweep,
whose outcomes are stored anyway, and thousands of lines share the weights of one grid.
"""

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import BeamvizError, NoEquilibrium
from beamviz.solver import Problem, solve_many
from beamviz.solver.hp.mesh import interpolation_matrix
from beamviz.solver.problem import OPTIONS
from beamviz.solver.solution import PURE, Solution
from beamviz.sweeps.store import ARRAYS, FAMILIES, STATUSES, Plan, Region, write_chunk

NODES, CHECKS = 17, (1, 6, 9, 14)  # beams of a piece: interpolated, and intervals with a check
SAFETY = 5.0
SHARE = 0.1  # of the tolerance: accepted error of the interpolation
LEAST_TOLERANCE = min(OPTIONS["tolerance"].limits or ())
NODE_SHARE = 0.4  # of the tolerance: that of the solver, which interpolation carries on up to twice
FRACTION = 2e-3  # the same of the share of the kinetic energy across the beam
DENSE = 2  # a piece has this many times the beams solved in it; smaller ones are solved
FEW = 0.1  # of a piece: beams that are solved because the interpolation leaves them open

SOLVED, UNSTABLE, NO_EQUILIBRIUM, NOT_CONVERGED = range(1, len(STATUSES))
Row = dict[str, np.ndarray]  # the arrays of some beams, of a line (beams, ...)
Piece = tuple[int, int]  # its first and its last beam


class Stencil(NamedTuple):
    """The beams solved in a piece, and the weights that interpolate the others."""

    nodes: np.ndarray  # (n,) beams that the polynomial passes through
    checks: np.ndarray  # (c,) further beams; none in a piece whose beams are all nodes
    weights: np.ndarray  # (beams of the piece, n)

    @property
    def solved(self) -> list[int]:
        return [*self.nodes.tolist(), *self.checks.tolist()]


class Grid:
    """The values of a parameter along a line, and their pieces; many lines have the same."""

    def __init__(self, values: np.ndarray):
        self.values = values
        self.stencil = cache(self._stencil)

    def _stencil(self, piece: Piece) -> Stencil:
        first, last = piece
        x = self.values[first : last + 1]
        nodes = self._nearest(x, np.arange(NODES))
        checks = np.setdiff1d(self._nearest(x, np.array(CHECKS) + 0.5), nodes)
        if len(x) < DENSE * (NODES + len(CHECKS)) or len(nodes) < NODES - 2 or len(checks) < 2:
            everything = np.arange(first, last + 1)
            return Stencil(everything, everything[:0], np.eye(len(x)))
        at = x[nodes]
        distances = (at[:, None] - at) * (4 / (at[-1] - at[0]))  # their products stay near 1
        barycentric = 1 / (distances + np.eye(len(at))).prod(axis=1)
        return Stencil(first + nodes, first + checks, interpolation_matrix(x, at, barycentric))

    @staticmethod
    def _nearest(x: np.ndarray, k: np.ndarray) -> np.ndarray:
        """The places in x nearest to Chebyshev points."""
        at = (x[0] + x[-1] - (x[-1] - x[0]) * np.cos(np.pi * k / (NODES - 1))) / 2
        return np.unique(abs(x[:, None] - at).argmin(axis=0))

    def halves(self, piece: Piece) -> list[Piece]:
        """A piece as two that share a beam."""
        first, last = piece
        middle = (self.values[first] + self.values[last]) / 2
        cut = int(np.searchsorted(self.values[first : last + 1], middle)) + first
        cut = min(max(cut, first + 1), last - 1)
        return [(first, cut), (cut, last)]


def solve_lines(lines: list["Line"]) -> None:
    """Solve or interpolate all beams: the first line alone, and the others in its final pieces."""
    for line in lines:
        line.find_limit()
    whole = [(0, len(lines[0].grid.values) - 1)]
    pieces = _fill(lines[:1], whole)
    _fill(lines[1:], pieces)


def _fill(lines: list["Line"], pieces: list[Piece]) -> list[Piece]:
    """Solve or interpolate all beams of some pieces; the pieces that they were divided into."""
    work = [(line, piece) for line in lines for piece in line.within_limit(pieces)]
    done: list[Piece] = []
    while work:
        _solve([(line, k) for line, piece in work for k in line.grid.stencil(piece).solved])
        found = [(line, piece, line.interpolate(piece)) for line, piece in work]
        _solve([(line, k) for line, _, open_beams in found for k in open_beams or ()])
        done += [piece for _, piece, open_beams in found if open_beams is not None]
        failed = [(line, piece) for line, piece, open_beams in found if open_beams is None]
        work = [(line, half) for line, piece in failed for half in line.grid.halves(piece)]
    return sorted(done)


def _solve(wanted: Iterable[tuple["Line", int]]) -> None:
    """Solve beams of lines that are not solved yet, together those that share their meshes."""
    groups: dict[Any, dict[tuple[int, int], tuple[Line, int, Beam]]] = {}
    for line, k in wanted:
        if k not in line.answers:
            key = id(line) if line.over == "beta" else line.beam.beta
            groups.setdefault(key, {})[id(line), k] = line, k, line.beam_at(k)
    for group in groups.values():
        lines, places, beams = zip(*group.values(), strict=True)
        answers = lines[0].solve_many(beams)
        for line, k, answer in zip(lines, places, answers, strict=True):
            line.keep(k, answer)


class Line:
    """The lowest modes of the beams of a line, as far as they are known. answers: of the beams
    solved; where there is a Solution or None, the rows of omega_squared, errors (of omega_squared)
    and bending_energy_fraction (beams, modes) are known."""

    def __init__(self, beam: Beam, over: str, grid: Grid, problem: Problem):
        self.beam, self.over, self.grid, self.problem = beam, over, grid, problem
        count, modes = len(grid.values), problem.modes
        self.coupled = problem.gyroscopic and self.beam_at(count - 1).gamma > 0
        self.answers: dict[int, Solution | BeamvizError] = {}
        self.omega_squared, self.errors, self.bending_energy_fraction = np.full(
            (3, count, modes), np.nan
        )
        # omega^2 and errors by family (with Coriolis forces in one, and the fractions as the
        # second), twice as many as asked for: so the next mode of a family is known
        self.families = np.full((2, count, 2, 2 * modes), np.nan)

    def beam_at(self, k: int) -> Beam:
        return self.beam.replace(**{self.over: float(self.grid.values[k])})

    def solve_many(self, beams: Sequence[Beam]) -> list[Solution | BeamvizError]:
        """Their modes, twice as many as requested, to a smaller tolerance."""
        tolerance = max(NODE_SHARE * self.problem.tolerance, LEAST_TOLERANCE)
        options = self.problem.options | {"tolerance": tolerance}
        return solve_many(beams, extra_modes=self.problem.modes, **options)

    def find_limit(self) -> None:
        """If the highest speed has no equilibrium, no beam beyond the limit has one."""
        bounded = self.problem.strain != "green" or self.beam.delta < 0
        if self.over == "gamma" and bounded:
            (answer,) = self.solve_many([self.beam_at(len(self.grid.values) - 1)])
            if isinstance(answer, NoEquilibrium):
                beyond = np.flatnonzero(self.grid.values > answer.limit)
                self.answers |= dict.fromkeys(beyond.tolist(), answer)

    def within_limit(self, pieces: list[Piece]) -> list[Piece]:
        """Pieces up to the limit of equilibrium."""
        last = len(self.grid.values) - 1 - len(self.answers)
        cut = [(a, min(b, last)) for a, b in pieces if a < last]
        return [*cut[:-1], (cut[-1][0], last)] if cut else [(0, 0)] * (last == 0)

    def keep(self, k: int, answer: Solution | BeamvizError) -> None:
        """Store the answer of a beam."""
        self.answers[k] = answer
        if not isinstance(answer, Solution):
            return
        modes, fraction = self.problem.modes, answer.bending_energy_fraction
        numbers = np.array([answer.omega_squared, answer.omega_squared_errors])
        self.omega_squared[k], self.errors[k] = numbers[:, :modes]
        self.bending_energy_fraction[k] = fraction[:modes]
        if self.coupled:
            self.families[:, k, 0, : len(fraction)] = numbers
            self.families[:, k, 1, : len(fraction)] = fraction, np.zeros_like(fraction)
        else:
            for family, own in enumerate((fraction >= 0.5, fraction < 0.5)):
                self.families[:, k, family, : own.sum()] = numbers[:, own]

    def interpolate(self, piece: Piece) -> list[int] | None:
        """Interpolate in a piece: the beams to be solved nevertheless; None where it fails."""
        nodes, checks, weights = stencil = self.grid.stencil(piece)
        if not len(checks):
            return []
        solved = stencil.solved
        if not all(isinstance(self.answers[k], Solution) for k in solved):
            return None
        known = self.families[0][solved]  # (solved, 2, columns)
        complete = np.isfinite(known).all(axis=0)
        values = np.tensordot(weights, np.where(complete, known[: len(nodes)], np.nan), 1)
        error = abs(values[checks - piece[0]] - known[len(nodes) :]).max(axis=0) * SAFETY
        solver_error = np.tensordot(abs(weights), self.families[1][nodes], 1)
        determined, order = self._determined(values, error, solver_error, known)
        places = np.arange(piece[0], piece[1] + 1)
        if (~determined).sum() > FEW * len(places):
            return None
        determined &= [k not in self.answers for k in places.tolist()]
        rows = places[determined]
        flat = values.reshape(len(values), -1)[determined]
        errors = (error + solver_error).reshape(len(values), -1)[determined]
        order = order[determined]
        self.omega_squared[rows] = np.take_along_axis(flat, order, 1)
        self.errors[rows] = np.take_along_axis(errors, order, 1)
        columns = values.shape[2]
        if self.coupled:
            self.bending_energy_fraction[rows] = np.take_along_axis(flat, order + columns, 1)
        else:
            self.bending_energy_fraction[rows] = order < columns
        return [k for k in places[~determined].tolist() if k not in self.answers]

    def _determined(
        self, values: np.ndarray, error: np.ndarray, solver_error: np.ndarray, known: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Which beams of a piece are known well enough by interpolated values, and the columns
        (beams, modes) of their lowest modes.

        The lowest modes are known if each is, if none is missed (a family that ends below the
        highest of them could have another one there) and if each is certainly stable or unstable.
        """
        accurate = error <= SHARE * 2 * self.problem.tolerance * abs(values)
        certain = accurate & (abs(values) > error + solver_error)
        if self.coupled:  # the second "family" is that of the fractions
            certain &= (error[1] <= FRACTION) | ~np.isfinite(values)
            arrays = values, certain, solver_error, known
            values, certain, solver_error, known = (array[:, :1] for array in arrays)
            error = error[:1]
        flat = values.reshape(len(values), -1)
        order = flat.argsort(axis=1)[:, : self.problem.modes]
        # One of the lowest modes here may be beyond those asked for at the beams solved.
        wrong = (solver_error > 2 * self.problem.tolerance * abs(values)).reshape(flat.shape)
        inaccurate = np.take_along_axis(wrong, order, 1).any(axis=1)
        highest = np.take_along_axis(flat, order[:, -1:], 1)[:, :, None]
        determined = ~((values - error - solver_error <= highest) & ~certain).any(axis=(1, 2))
        # The next mode of a family lies above those interpolated and, as at the beams solved, above
        # its lowest one there that is not: known at some of them, at others beyond all known.
        beyond = np.where(np.isnan(known), np.nanmax(known, axis=(1, 2), keepdims=True), known)
        open_modes = np.where(np.isfinite(values[0]), np.inf, beyond)
        ends = np.fmax(np.fmax.reduce(values, axis=2), open_modes.min(axis=(0, 2)))
        return determined & ~inaccurate & (highest[:, :, 0] <= ends).all(axis=1), order


def solve_and_write(path: Path, region: Region, part: Plan) -> None:
    """Solve the part of a sweep that is a chunk of its store, and write it."""
    write_chunk(path, region, solve_chunk(part))


def solve_in_memory(plan: Plan, report: Callable[[float], None]) -> Row:
    """The arrays of a small sweep, without a store. report: called with the share that is done,
    before each chunk; what it raises ends the sweep."""
    arrays = empty_arrays(plan)
    for k, task in enumerate(plan.tasks):
        report(k / len(plan.tasks))
        for name, part in solve_chunk(plan.part(task)).items():
            arrays[name][plan.region(task)] = part
    return arrays


def empty_arrays(plan: Plan) -> Row:
    """The arrays of a sweep, without results."""
    return {
        name: np.full(plan.shape + (plan.problem.modes,) * len(extra), empty, kind)
        for name, (kind, extra, empty, _) in ARRAYS.items()
    }


def solve_chunk(plan: Plan) -> Row:
    """The arrays of a sweep that is solved as one chunk."""
    arrays = empty_arrays(plan)
    values = {name: array.tolist() for name, array in plan.axes.items()}
    over = list(plan.axes)[plan.line]
    along = values.pop(over)
    places = itertools.product(*map(range, map(len, values.values())))
    grid = Grid(np.array(along))
    lines: list[Line] = []
    rows: list[Row] = []
    for place, numbers in zip(places, itertools.product(*values.values()), strict=True):
        own = dict(zip(values, numbers, strict=True), **{over: along[0]})
        lines.append(Line(plan.beam.replace(**own), over, grid, plan.problem))
        here: tuple[Any, ...] = (*place[: plan.line], slice(None), *place[plan.line :])
        rows.append({name: array[here] for name, array in arrays.items()})
    if plan.smooth:
        solve_lines(lines)
    for line, row in zip(lines, rows, strict=True):
        if plan.smooth:
            fill_known(row, line)
            errors = {k: one for k, one in line.answers.items() if isinstance(one, BeamvizError)}
            fill_answers(row, errors)
        else:
            beams = map(line.beam_at, range(len(along)))
            fill_answers(row, dict(enumerate(solve_many(beams, **plan.problem.options))))
    return arrays


def fill_known(row: Row, line: Line) -> None:
    """The numbers of a line that is known by omega^2."""
    squares, errors, fraction = line.omega_squared, line.errors, line.bending_energy_fraction
    root = np.sqrt(abs(squares))
    stable = squares >= 0
    row["frequency"][:] = np.where(stable, root, np.nan)
    row["growth_rate"][:] = np.where(stable, 0.0, root)
    row["error"][:] = errors / (root + np.sqrt(np.maximum(abs(squares) - errors, 0.0)))
    row["family"][:] = np.where(fraction >= PURE, 0, np.where(fraction <= 1 - PURE, 1, 2))
    row["status"][:] = np.where(stable[:, 0], SOLVED, UNSTABLE)


def fill_answers(row: Row, answers: Mapping[int, Solution | BeamvizError]) -> None:
    """The numbers of beams by what `solve_many` answers."""
    for k, answer in answers.items():
        if isinstance(answer, Solution):
            row["status"][k] = SOLVED if answer.equilibrium.stable else UNSTABLE
            row["frequency"][k] = answer.frequencies
            row["growth_rate"][k] = answer.growth_rates
            row["error"][k] = answer.errors
            row["family"][k] = [FAMILIES.index(family) for family in answer.families]
            continue
        for name, (_, _, empty, _) in ARRAYS.items():
            row[name][k] = empty
        row["status"][k] = NOT_CONVERGED
        if isinstance(answer, NoEquilibrium):
            row["status"][k], row["limit"][k] = NO_EQUILIBRIUM, answer.limit
