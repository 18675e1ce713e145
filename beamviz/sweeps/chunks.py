"""The work of a task: every beam of a chunk, line by line."""

import itertools
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from beamviz.errors import BeamvizError, NoEquilibrium
from beamviz.solver import Solution, solve_many
from beamviz.solver.solution import PURE
from beamviz.sweeps.lines import Grid, Line, solve_lines
from beamviz.sweeps.plan import Plan, Task
from beamviz.sweeps.store import ARRAYS, FAMILIES, STATUSES, stored_plan, write_chunk

SOLVED, UNSTABLE, NO_EQUILIBRIUM, NOT_CONVERGED = range(1, len(STATUSES))
Row = dict[str, np.ndarray]  # the arrays of some beams, of a line (beams, ...)


def solve_and_write(path: Path, task: Task) -> None:
    """Solve a chunk of a store and write it."""
    plan = stored_plan(path)
    write_chunk(path, plan, task, solve_chunk(plan, task))


def solve_in_memory(plan: Plan, report: Callable[[float], None]) -> Row:
    """The arrays of a small sweep, without a store. report: called with the share that is done,
    before each chunk; what it raises ends the sweep."""
    arrays = empty_arrays(plan, plan.shape)
    for k, task in enumerate(plan.tasks):
        report(k / len(plan.tasks))
        for name, part in solve_chunk(plan, task).items():
            arrays[name][plan.region(task)] = part
    return arrays


def empty_arrays(plan: Plan, shape: tuple[int, ...]) -> Row:
    """Arrays of as many beams, without results."""
    return {
        name: np.full(shape + (plan.problem.modes,) * len(extra), empty, kind)
        for name, (kind, extra, empty, _) in ARRAYS.items()
    }


def solve_chunk(plan: Plan, task: Task) -> dict[str, np.ndarray]:
    """The arrays of a chunk."""
    parts = plan.region(task)
    arrays = empty_arrays(plan, tuple(part.stop - part.start for part in parts))
    values = {n: a[part].tolist() for (n, a), part in zip(plan.axes.items(), parts, strict=True)}
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
            fill_answers(row, dict(enumerate(solve_many(line.beams, **plan.problem.options))))
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
