"""The beam whose frequencies fit measured ones best: nonlinear least squares.

Minimises sum_i ((omega_i(u) - m_i) / sigma_i)^2 over u in 0 .. 1 by scipy's trust-region method,
from several starts, the best of a random pool. The frequencies of all measured speeds and of all
changes of a Jacobian are solved in one stack. Frequencies without a label belong to the modes of
the assignment of least cost at each speed, which is repeated until it does not change.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.adjusting.free_numbers import BeamFamily
from beamviz.adjusting.result import Adjusted, Match
from beamviz.beam import Beam
from beamviz.errors import InvalidInput, NoAnswer
from beamviz.measured import MeasuredFrequency
from beamviz.solver import solve_many
from beamviz.solver.problem import MAX_MODES
from beamviz.solver.solution import Solution

POOL = 64  # random places for each free number
STARTS, MORE_STARTS = 6, 3  # the best of them with different assignments, and of the others
SEED = 1
STEP = 1e-4  # in u, of the central differences of the Jacobian
TOLERANCE = 1e-9  # of the solutions: a step divides their errors by it
ASSIGNMENTS = 6  # repeated until they do not change
ABSENT = 100.0  # times the measured frequency: that of a mode which the beam does not have
SINGULAR = 1e-6  # of the singular values of the Jacobian, relative to the greatest
SHARE = 0.1  # of a singular direction, from which it leaves a number undetermined
DISTINCT = 0.02  # distance in u of two fits
AS_GOOD = 4.0  # increase of chi^2, two standard deviations of one number
MET = 1e-4  # relative distance of a target
AT_BOUND = 1e-6  # distance in u

Labels = tuple[str, ...]


class LocalFit(NamedTuple):
    """A local minimum: place (free,), labels of the modes, sum of squares and Jacobian (rows,
    free)."""

    u: NDArray
    labels: Labels
    chi_squared: float
    jacobian: NDArray


@dataclass
class FrequencyFit:
    """Measured frequencies, and the beams whose frequencies are compared with them."""

    family: BeamFamily
    rows: list[MeasuredFrequency]
    options: dict[str, Any]
    solves: int = 0
    settings: list[tuple[tuple[str, float], ...]] = field(init=False)
    row_setting: list[int] = field(init=False)
    measured: NDArray = field(init=False)  # (rows,)
    sigma: NDArray = field(init=False)  # (rows,) of a residual of 1

    def __post_init__(self) -> None:
        self.settings = sorted({row.numbers for row in self.rows})
        self.row_setting = [self.settings.index(row.numbers) for row in self.rows]
        self.measured = np.array([row.frequency for row in self.rows])
        errors = np.array([row.error for row in self.rows])
        self.sigma = np.where(np.isnan(errors), self.measured, errors)

    @property
    def has_errors(self) -> bool:
        """Whether the errors of the measured frequencies are known."""
        return not math.isnan(self.rows[0].error)

    def labelled_frequencies(self, places: Sequence[NDArray]) -> list[list[dict[str, float]]]:
        """The frequencies, in 1/T* of the given beam, by label, at each place u (free,) and each
        setting; {} without a solution."""
        beams, where = [], []
        table: list[list[dict[str, float]]] = [[{} for _ in self.settings] for _ in places]
        for k, u in enumerate(places):
            for j, numbers in enumerate(self.settings):
                try:
                    beams.append(self.family.at(u, **dict(numbers)))
                except InvalidInput:  # as too high a speed for mu
                    continue
                where.append((k, j))
        self.solves += len(beams)
        for (k, j), answer in zip(where, solve_many(beams, **self.options), strict=True):
            if isinstance(answer, Solution):
                frequencies = answer.frequencies / self.family.time_ratio(places[k])
                table[k][j] = dict(zip(answer.labels, frequencies.tolist(), strict=True))
        return table

    def assigned(self, by_setting: list[dict[str, float]]) -> Labels:
        """The label of the mode of each row: the given one, else that of the assignment of least
        cost among those left; "" where there are too few modes."""
        from scipy.optimize import linear_sum_assignment

        labels = [row.mode for row in self.rows]
        for j, frequencies in enumerate(by_setting):
            here = [i for i, setting in enumerate(self.row_setting) if setting == j]
            taken = {labels[i] for i in here}
            rows = [i for i in here if not labels[i]]
            modes = [m for m, f in frequencies.items() if m not in taken and math.isfinite(f)]
            values = np.array([frequencies[mode] for mode in modes])
            cost = abs(self.measured[rows][:, None] - values) / self.sigma[rows][:, None]
            for row, mode in zip(*linear_sum_assignment(cost), strict=True):
                labels[rows[row]] = modes[mode]
        return tuple(labels)

    def predicted(self, by_setting: list[dict[str, float]], labels: Labels) -> NDArray:
        """The frequencies (rows,) of modes; nan where the beam has none."""
        rows = zip(self.row_setting, labels, strict=True)
        return np.array([by_setting[setting].get(label, math.nan) for setting, label in rows])

    def residuals(self, by_setting: list[dict[str, float]], labels: Labels) -> NDArray:
        """The residuals (rows,), large where the beam has no such mode."""
        predicted = self.predicted(by_setting, labels)
        absent = ABSENT * self.measured
        return (np.where(np.isnan(predicted), absent, predicted) - self.measured) / self.sigma

    def matches(self, by_setting: list[dict[str, float]], labels: Labels) -> tuple[Match, ...]:
        """Each measured frequency with that of its mode."""
        predicted = self.predicted(by_setting, labels)
        residuals = (predicted - self.measured) / self.sigma
        return tuple(
            Match(label, dict(row.numbers), row.frequency, float(f), row.error, float(residual))
            for row, label, f, residual in zip(self.rows, labels, predicted, residuals, strict=True)
        )

    def residuals_at(self, u: NDArray, labels: Labels) -> NDArray:
        return self.residuals(self.labelled_frequencies([u])[0], labels)

    def jacobian_at(self, u: NDArray, labels: Labels) -> NDArray:
        """The derivative (rows, free) of the residuals, by differences within the bounds."""
        lower, upper = np.maximum(u - STEP, 0.0), np.minimum(u + STEP, 1.0)
        places = []
        for k in range(len(u)):
            for end in (lower, upper):
                places.append(u.copy())
                places[-1][k] = end[k]
        values = [self.residuals(each, labels) for each in self.labelled_frequencies(places)]
        return (np.array(values[1::2]) - values[::2]).T / (upper - lower)

    def local_fit(self, start: NDArray) -> LocalFit:
        """The minimum that is reached from a start."""
        from scipy.optimize import least_squares

        u, labels = start, self.assigned(self.labelled_frequencies([start])[0])
        for _ in range(ASSIGNMENTS):
            result = least_squares(
                self.residuals_at,
                u,
                self.jacobian_at,
                bounds=(0.0, 1.0),
                args=(labels,),
                xtol=1e-10,
                ftol=1e-12,
                max_nfev=60,
            )
            u, before = at_near_bounds(result.x), labels
            labels = self.assigned(self.labelled_frequencies([u])[0])
            if labels == before:
                break
        residuals = self.residuals_at(u, labels)
        return LocalFit(u, labels, float(residuals @ residuals), self.jacobian_at(u, labels))

    def starts(self) -> list[NDArray]:
        """The given beam, and the places of a random pool that fit best: first each with another
        assignment of the frequencies to modes, as a local fit seldom leaves its own."""
        count = len(self.family.free)
        pool = np.random.default_rng(SEED).random((POOL * count, count))
        table = self.labelled_frequencies(list(pool))
        assignments = [self.assigned(by_setting) for by_setting in table]
        pairs = zip(table, assignments, strict=True)
        sums = [np.sum(self.residuals(*pair) ** 2) for pair in pairs]
        order = np.argsort(sums, kind="stable").tolist()
        seen: dict[Labels, int] = {}
        for k in order:
            seen.setdefault(assignments[k], k)
        distinct = [*seen.values()][:STARTS]
        others = [k for k in order if k not in distinct][:MORE_STARTS]
        return [self.family.start, *pool[distinct], *pool[others]]

    def local_fits(self) -> list[LocalFit]:
        """The minima reached from the starts, the best first."""
        fits = [self.local_fit(start) for start in self.starts()]
        return sorted(fits, key=lambda fit: fit.chi_squared)


def at_near_bounds(u: NDArray) -> NDArray:
    """The place (free,), at a bound where it is near: the method stays inside of them."""
    return np.where(u < AT_BOUND, 0.0, np.where(u > 1 - AT_BOUND, 1.0, u))


def modes_needed(rows: Sequence[MeasuredFrequency], in_space: bool) -> int:
    """The number of modes among which those of the measured frequencies are."""
    most = max((int(row.mode[1:]) for row in rows if row.mode), default=0)
    settings = [row.numbers for row in rows]
    together = max(settings.count(numbers) for numbers in settings)
    return min(MAX_MODES, max(5, (1 + in_space) * most + 3, together + 2))


class Comparison(NamedTuple):
    """Measured frequencies of a beam: the match of each, and the labels of the modes that it may be
    matched to, in the order of their frequencies."""

    matches: tuple[Match, ...]
    choices: tuple[tuple[str, ...], ...]


def compared(beam: Beam, rows: list[MeasuredFrequency], options: dict[str, Any]) -> Comparison:
    """A beam compared with measured frequencies, each with that of the mode to which the beam
    itself would be fitted. options: as for `solve`. Raises InvalidInput."""
    in_space = options.get("plane") == "both"
    check_labels(rows, in_space)
    solved = {"modes": modes_needed(rows, in_space), **options}
    fit = FrequencyFit(BeamFamily(beam, ()), rows, solved)
    (by_setting,) = fit.labelled_frequencies([np.empty(0)])
    choices = tuple(tuple(by_setting[setting]) for setting in fit.row_setting)
    return Comparison(fit.matches(by_setting, fit.assigned(by_setting)), choices)


def fitted(
    family: BeamFamily, rows: list[MeasuredFrequency], options: dict[str, Any], goal: str
) -> Adjusted:
    """The beam that fits best. Raises NoAnswer where no beam has the target frequencies."""
    fixed = {number for row in rows for number, _ in row.numbers}
    for free in family.free:
        if free.number in fixed:
            raise InvalidInput(f"free {free.name}: the measured data give its values")
    check_labels(rows, options.get("plane") == "both")
    solved = {**options, "tolerance": min(TOLERANCE, options.get("tolerance", 1.0))}
    needed = modes_needed(rows, options.get("plane") == "both")
    solved.setdefault("modes", needed)
    fit = FrequencyFit(family, rows, solved)
    fits = fit.local_fits()
    best, others = fits[0], fits[1:]
    if goal == "targets":  # of those that meet them the nearest to the given beam
        near = [each for each in fits if is_met(fit, each)]
        best = min(near, key=lambda each: np.linalg.norm(each.u - family.start), default=best)
    answer = described(fit, best, others, options, goal)
    if not all(match.mode and math.isfinite(match.predicted) for match in answer.matches):
        raise NoAnswer("no beam in the bounds has a mode for each frequency", answer)
    if goal == "targets" and not is_met(fit, best):
        worst = max(answer.matches, key=lambda match: abs(match.residual))
        values = ", ".join(f"{name} = {value:.5g}" for name, value in answer.free.items())
        raise NoAnswer(
            f"no beam in the bounds has these frequencies: nearest is {values}, where"
            f" {worst.mode} is {worst.predicted:.5g}/T*, not {worst.measured:.5g}/T*; free another"
            " number or widen the bounds",
            answer,
        )
    return answer


def check_labels(rows: Sequence[MeasuredFrequency], in_space: bool) -> None:
    """InvalidInput for a label that modes in one plane, or in both, do not have."""
    kinds = "FLS" if in_space else "BS"
    for row in rows:
        if row.mode and row.mode[0] not in kinds:
            planes = "both planes are F, L and S" if in_space else "one plane are B and S"
            raise InvalidInput(f"mode {row.mode}: the labels of modes in {planes}")


def is_met(fit: FrequencyFit, local: LocalFit) -> bool:
    """Whether the residuals, which are relative, are those of a target that is met."""
    return bool(abs(fit.residuals_at(local.u, local.labels)).max() < MET)


def described(
    fit: FrequencyFit,
    best: LocalFit,
    others: list[LocalFit],
    options: dict[str, Any],
    goal: str,
) -> Adjusted:
    """The result of the best fit, with its errors and the other fits that are as good."""
    family, free = fit.family, fit.family.free
    matches = fit.matches(fit.labelled_frequencies([best.u])[0], best.labels)
    variance = residual_variance(fit, best)
    deviations, correlations = standard_deviations(best.jacobian, variance)
    undetermined = tuple(
        number.name for number, each in zip(free, deviations, strict=True) if each > 1
    )
    errors = {
        number.name: number.slope(u) * number.unit * float(each)
        for number, u, each in zip(free, best.u, deviations, strict=True)
    }
    alternatives: list[NDArray] = []
    limit = best.chi_squared + AS_GOOD * (variance if math.isfinite(variance) else 1e-9)
    for each in others:
        known = [best.u, *alternatives]
        distances = [np.abs(each.u - u).max() for u in known]
        if each.chi_squared <= limit and min(distances) > DISTINCT:
            alternatives.append(each.u)
    return Adjusted(
        beam=family.at(best.u),
        goal=goal,
        free=family.values(best.u),
        bounds={each.name: (each.low * each.unit, each.high * each.unit) for each in free},
        options=options,
        units=family.beam.units,
        errors=errors,
        correlations=correlations,
        matches=matches,
        undetermined=undetermined,
        at_bounds=at_bounds(family, best.u),
        alternatives=tuple(family.values(u) for u in alternatives),
        solves=fit.solves,
    )


def at_bounds(family: BeamFamily, u: NDArray) -> tuple[str, ...]:
    """The free numbers at one of their bounds."""
    places = zip(family.free, u, strict=True)
    return tuple(free.name for free, each in places if min(each, 1 - each) < AT_BOUND)


def residual_variance(fit: FrequencyFit, best: LocalFit) -> float:
    """The variance of the residuals: 1 where the errors are known; else that of the fit, nan where
    there are no more frequencies than free numbers."""
    if fit.has_errors:
        return 1.0
    more = len(fit.rows) - len(best.u)
    return best.chi_squared / more if more > 0 else math.nan


def standard_deviations(jacobian: NDArray, variance: float) -> tuple[NDArray, NDArray]:
    """The standard deviations (free,) of u and the correlations (free, free), from (J' J)^-1;
    infinite, and nan, of numbers in a direction that J does not determine."""
    count = jacobian.shape[1]
    _, singular, directions = np.linalg.svd(jacobian, full_matrices=True)  # directions (free, free)
    values = np.zeros(count)
    values[: len(singular)] = singular
    known = values > SINGULAR * max(values.max(), 1e-300)
    rows = directions[known] / values[known, None]
    covariance = rows.T @ rows
    lost = (abs(directions[~known]) > SHARE).any(axis=0)
    deviations = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore", divide="ignore"):
        correlations = covariance / np.outer(deviations, deviations)
    correlations[lost] = correlations[:, lost] = np.nan
    deviations = np.where(lost, np.inf, deviations * math.sqrt(variance))
    return deviations, correlations
