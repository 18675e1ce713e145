"""The beam nearest to a given one that has no frequency near a per-rev line in a range of speeds.

The ratio r = omega / (k gamma) of the n-th frequency and the line k falls with the speed, as
omega^2 / gamma^2 = K / gamma^2 + S does, so that over the range A .. B

    margin = min over modes and lines of max(r(B) - 1, 1 - r(A)),

positive where no mode meets a line. It is taken as the least and the greatest ratio at a few speeds
and checked at many at the end. scipy's differential evolution, whose population is solved in one
stack, minimises the distance from the given beam where the margin suffices, and else what is
missing of it, so that without an answer it ends at the best margin that there is.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beamviz.adjusting.fit import at_bounds
from beamviz.adjusting.free_numbers import BeamFamily
from beamviz.adjusting.goals import ClearGoal
from beamviz.adjusting.result import Adjusted, HeldMargin
from beamviz.errors import InvalidInput, NoAnswer
from beamviz.solver import solve_many
from beamviz.solver.problem import MAX_MODES
from beamviz.solver.solution import Solution

SEARCHES, GAIN = 4, 1e-3  # at most, and the gain of cost below which they end
SPEEDS, CHECKED_SPEEDS = (3, 9, 33), 65  # in turn, until the check at many confirms the answer
SAMPLES = 8  # powers of 2 of places for a free number, from which the population starts
BEYOND = 0.1  # the bounds lie this far inside the sequence, so that some places are on them
POPULATION, GENERATIONS = 12, 60  # for each free number; the search ends sooner where it converges
LACK = 10.0  # added to a lack of margin: more than every distance
NO_BEAM = -10.0  # margin of a beam without a stable equilibrium
ROUNDING = 1e-6  # of a margin
MORE_MODES = 2  # beyond those that reach the highest line for the given beam


@dataclass
class ClearSearch:
    """The beams whose margins are compared."""

    family: BeamFamily
    goal: ClearGoal
    options: dict[str, Any]
    speeds: NDArray  # (speeds,) of the given beam
    solves: int = 0

    def held_margins(self, places: Sequence[NDArray]) -> list[HeldMargin]:
        """The least margin of the beam at each place u (free,)."""
        beams, where = [], []
        outcomes: list[list[Solution | None]] = [[None] * len(self.speeds) for _ in places]
        for k, u in enumerate(places):
            for j, speed in enumerate(self.speeds.tolist()):
                try:
                    beams.append(self.family.at(u, speed))
                except InvalidInput:  # as too high a speed for mu
                    continue
                where.append((k, j))
        self.solves += len(beams)
        for (k, j), answer in zip(where, solve_many(beams, **self.options), strict=True):
            outcomes[k][j] = answer if isinstance(answer, Solution) else None
        return [self.held_margin(u, each) for u, each in zip(places, outcomes, strict=True)]

    def held_margin(self, u: NDArray, outcomes: Sequence[Solution | None]) -> HeldMargin:
        """The least margin of the solutions of a beam at the speeds."""
        for speed, each in zip(self.speeds.tolist(), outcomes, strict=True):
            if each is None or not each.equilibrium.stable:
                return HeldMargin(-math.inf, "", 0, speed, math.nan)
        solutions = [each for each in outcomes if each is not None]
        frequencies = np.array([each.frequencies for each in solutions])  # (speeds, modes)
        frequencies /= self.family.time_ratio(u)
        lines = np.array(self.goal.lines)[:, None, None] * self.speeds[:, None]
        ratio = frequencies / lines  # (lines, speeds, modes)
        margins = np.maximum(ratio.min(axis=1) - 1, 1 - ratio.max(axis=1))  # (lines, modes)
        line, mode = np.unravel_index(int(margins.argmin()), margins.shape)
        above = ratio[line, :, mode].min() - 1 >= 1 - ratio[line, :, mode].max()
        place = int((ratio.argmin if above else ratio.argmax)(axis=1)[line, mode])
        return HeldMargin(
            float(margins[line, mode]),
            solutions[place].labels[mode],
            self.goal.lines[line],
            float(self.speeds[place]),
            float(frequencies[place, mode]),
        )

    def costs(self, places: NDArray) -> NDArray:
        """The distance (k,) of each place (free, k) from the given beam where the margin suffices,
        else LACK and what is missing of it."""
        margins = np.array([held.margin for held in self.held_margins([*places.T])])
        lack = self.goal.margin - np.maximum(margins, NO_BEAM)
        return np.where(lack > ROUNDING / 10, LACK + lack, self.distances(places.T))

    def distances(self, places: NDArray) -> NDArray:
        """The distances (k,) in u of places (k, free) from the given beam."""
        return np.linalg.norm(places - self.family.start, axis=1) / math.sqrt(places.shape[1])

    def best(self) -> NDArray:
        """The place (free,) of least cost. Each search but the first is in the box around the given
        beam that may have a nearer answer, which it samples more densely."""
        start = self.family.start
        best, least = start, float(self.costs(start[:, None])[0])
        for seed in range(SEARCHES if least > 0 else 0):
            radius = min(least, 1.0) * math.sqrt(len(start))
            box = np.clip([start - radius, start + radius], 0.0, 1.0)
            place = self.best_in(box, best, seed)
            cost = float(self.costs(place[:, None])[0])
            gain, best, least = least - cost, place, cost
            if seed and gain < GAIN:
                break
        return self.with_unchanged_numbers(best, least)

    def with_unchanged_numbers(self, u: NDArray, cost: float) -> NDArray:
        """The place (free,) with each number at its start, or else at its near bound, where this
        costs no more: the search ends only near to these."""
        for k, start in enumerate(self.family.start):
            for value in (start, round(u[k])):
                changed = u.copy()
                changed[k] = value
                less = float(self.costs(changed[:, None])[0])
                if less <= cost:
                    u, cost = changed, less
                    break
        return u

    def best_in(self, box: NDArray, known: NDArray, seed: int) -> NDArray:
        """The place (free,) of least cost in a box (2, free). known: a place in it."""
        from scipy.optimize import differential_evolution
        from scipy.stats import qmc

        low, high = box
        count = len(low)
        sobol = qmc.Sobol(count, seed=seed).random_base2(SAMPLES + math.ceil(math.log2(count)))
        inside = np.clip((1 + 2 * BEYOND) * sobol - BEYOND, 0.0, 1.0)
        sample = np.vstack((known, low + (high - low) * inside))
        ranked = sample[np.argsort(self.costs(sample.T), kind="stable")]
        result = differential_evolution(
            self.costs,
            [*zip(low, high, strict=True)],
            init=ranked[: POPULATION * count],
            maxiter=GENERATIONS,
            tol=1e-4,
            atol=1e-6,
            polish=False,
            vectorized=True,
            updating="deferred",
            rng=np.random.default_rng(seed),
        )
        return result.x


def cleared(family: BeamFamily, goal: ClearGoal, options: dict[str, Any]) -> Adjusted:
    """The nearest beam that keeps the margin. Raises NoAnswer, with the best margin and what holds
    it, where there is none."""
    free = family.free
    for each in free:
        if each.number == "gamma":
            raise InvalidInput(f"free {each.name}: `between` gives the range of the speed")
    u, held, solves = searched_with_enough_modes(family, goal, options)
    answer = Adjusted(
        beam=family.at(u),
        goal="clear",
        free=family.values(u),
        bounds={each.name: (each.low * each.unit, each.high * each.unit) for each in free},
        options=options,
        units=family.beam.units,
        errors={},
        correlations=np.full((len(free), len(free)), np.nan),
        at_bounds=at_bounds(family, u),
        held=held,
        solves=solves,
    )
    if held.margin < goal.margin - ROUNDING:
        raise NoAnswer(no_answer_text(answer, held, goal), answer)
    return answer


def searched_with_enough_modes(
    family: BeamFamily, goal: ClearGoal, options: dict[str, Any]
) -> tuple[NDArray, HeldMargin, int]:
    """`searched` with the modes asked for, else with all that reach the highest line: the answer
    may have more of them than the given beam."""
    if "modes" in options:
        return searched(family, goal, options)
    modes, solves = min(MAX_MODES, modes_below(family, family.start, goal, options) + MORE_MODES), 0
    while True:
        u, held, more = searched(family, goal, {**options, "modes": modes})
        solves += more
        below = modes_below(family, u, goal, options)
        if below >= MAX_MODES:
            raise InvalidInput(
                f"clear: {MAX_MODES} modes and more lie below the line {max(goal.lines)} per"
                f" revolution at gamma = {goal.high:g}, of which {MAX_MODES} are computed: give"
                " fewer lines or a lower speed, or the number of modes that count"
            )
        needed = below + 1
        if needed <= modes:
            return u, held, solves
        modes = needed


def searched(
    family: BeamFamily, goal: ClearGoal, options: dict[str, Any]
) -> tuple[NDArray, HeldMargin, int]:
    """The place (free,) of the nearest beam that keeps the margin, or of the best margin, its
    margin at many speeds, and the number of solves."""
    solves, checked = 0, np.linspace(goal.low, goal.high, CHECKED_SPEEDS)
    for count in SPEEDS:
        search = ClearSearch(family, goal, options, np.linspace(goal.low, goal.high, count))
        u = search.best()
        check = ClearSearch(family, goal, options, checked)
        (held,) = check.held_margins([u])
        (coarse,) = search.held_margins([u])
        solves += search.solves + check.solves
        if held.margin >= goal.margin - ROUNDING or coarse.margin < goal.margin - ROUNDING:
            break  # it keeps the margin, or none does at these few speeds already
    return u, held, solves


def no_answer_text(answer: Adjusted, held: HeldMargin, goal: ClearGoal) -> str:
    """The message where no beam keeps the margin."""
    if not math.isfinite(held.margin):
        return f"no beam in the bounds has a stable equilibrium up to gamma = {goal.high:g}"
    values = ", ".join(f"{name} = {value:.5g}" for name, value in answer.free.items())
    text = (
        f"no beam in the bounds keeps a margin of {100 * goal.margin:g} %: the best, at {values},"
    )
    mode = f"{held.mode} and the line {held.per_rev} per revolution at gamma = {held.speed:.5g}"
    if held.margin < 0:
        return f"{text} has a resonance of {mode}"
    return f"{text} has {100 * held.margin:.3g} %, held by {mode}"


def modes_below(family: BeamFamily, u: NDArray, goal: ClearGoal, options: dict[str, Any]) -> int:
    """The number of modes of the beam at u (free,) below the highest line and its margin at the
    highest speed; 3 without a solution."""
    highest = max(goal.lines) * goal.high * (1 + goal.margin) * family.time_ratio(u)
    try:
        beam = family.at(u, goal.high)
    except InvalidInput:
        return 3
    (answer,) = solve_many([beam], **{**options, "modes": MAX_MODES})
    if not isinstance(answer, Solution):
        return 3
    return int((np.nan_to_num(answer.frequencies) < highest).sum())
