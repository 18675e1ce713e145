"""A meeting of two loci seen from near: without and with Coriolis forces, and the shapes there."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from beamviz.beam import LIMITS
from beamviz.errors import BeamvizError
from beamviz.explorer.features.loci_chart import Question
from beamviz.explorer.jobs import Latest
from beamviz.frequency_loci import Branch, Event, Loci, loci
from beamviz.server.log import RateLimitedLog
from beamviz.solver.solution import Solution

WIDE, FINE = 40, 40  # points: even, so that no meeting is one of them
REACH = 0.2  # of the range of the chart, to both sides: where the other meeting is looked for
LEAST = 0.004  # of that range: the narrowest view is twice as wide
ROOM = 5.0  # times the distance at which the gap has doubled, or the shift by Coriolis forces
BESIDE = 1e-3  # of the view: so far from a crossing, where both are one, the shapes are taken
X = np.linspace(0.0, 1.0, 61)

log = RateLimitedLog(__name__)


@dataclass(frozen=True)
class Target:
    """A meeting of a chart to look at."""

    question: Question
    event: Event


class Motion(NamedTuple):
    """The shape of one mode at X (61,), largest displacement 1, and what share of the kinetic
    energy lies across the beam."""

    along: np.ndarray
    across: np.ndarray
    share: float


@dataclass(frozen=True)
class Pair:
    """Two loci around their meeting, without or with Coriolis forces.

    event: None where the two do not meet in this way; motions: for each of the two branches
    the shape before, at and after `at`.
    """

    coriolis: bool
    event: Event | None
    at: float
    values: np.ndarray
    branches: tuple[Branch, Branch]
    motions: tuple[tuple[Motion, Motion, Motion], ...]


@dataclass(frozen=True)
class Closeup:
    """Both pairs, or in `words` why there are none."""

    target: Target
    pairs: tuple[Pair, ...] = ()
    words: str = ""


class Closeups(Latest[Target, Closeup]):
    """The latest close-up of one visitor."""

    def answered(self, wanted: Target) -> Closeup:
        """Look at one meeting."""
        try:
            return Closeup(wanted, magnified(wanted))
        except BeamvizError as error:
            return Closeup(wanted, words=str(error))
        except Exception as error:  # a mistake of ours must not end a visitor's session
            log.error("close-up", wanted, error)
            return Closeup(wanted, words=f"unexpected: {error}")


def magnified(target: Target) -> tuple[Pair, ...]:
    """The two loci of a meeting without and with Coriolis forces, over the same values."""
    question, event = target.question, target.event
    reach = REACH * (question.stop - question.start)
    wide = around(question, event.at, reach, WIDE)
    found = [chart(question, wide, coriolis) for coriolis in (False, True)]
    meetings = [same(one, event, reach) for one in found]
    centre, half = view(found, meetings, event, question)
    places = [one.at + (BESIDE * half if one.kind == "crossing" else 0) for one in meetings if one]
    values = np.union1d(around(question, centre, half, FINE), places)
    return tuple(
        pair(chart(question, values, coriolis), meeting, event, centre)
        for coriolis, meeting in zip((False, True), meetings, strict=True)
    )


def around(question: Question, at: float, reach: float, count: int) -> np.ndarray:
    """Values (count,) to both sides of `at`, within what the number may be."""
    low, high = LIMITS[question.over]
    return np.linspace(max(at - reach, low), min(at + reach, high, question.stop), count)


def chart(question: Question, values: np.ndarray, coriolis: bool) -> Loci:
    """The loci over some values."""
    options = {**question.options, "coriolis": coriolis}
    return loci(question.beam, question.over, values, **options)


def same(found: Loci, event: Event, reach: float) -> Event | None:
    """The meeting of the same two branches nearest to one of another chart, within reach."""
    near = [e for e in found.events if {*e.branches} == {*event.branches}]
    near = [e for e in near if abs(e.at - event.at) <= reach]
    return min(near, key=lambda e: abs(e.at - event.at), default=None)


def view(
    found: list[Loci], meetings: list[Event | None], event: Event, question: Question
) -> tuple[float, float]:
    """The middle of the view and half its width: both meetings and the whole gap are in it."""
    at = [one.at for one in meetings if one] or [event.at]
    centre, extent = (min(at) + max(at)) / 2, max(at) - min(at)
    a, b = branches_of(found[0], event, centre)
    slope = abs(np.gradient(b.frequency - a.frequency, found[0].values))
    steepest = float(np.nanmax(slope)) if np.isfinite(slope).any() else 0.0
    gap = max((one.gap for one in meetings if one), default=0.0)
    spread = ROOM * gap / steepest if steepest else 0.0
    width = question.stop - question.start
    return centre, float(np.clip(max(extent, spread), LEAST * width, REACH * width))


def branches_of(found: Loci, event: Event, at: float) -> tuple[Branch, Branch]:
    """The two branches of an event in a chart; where labels differ, the two nearest to it."""
    by_label = {branch.label: branch for branch in found.branches}
    if all(label in by_label for label in event.branches):
        return by_label[event.branches[0]], by_label[event.branches[1]]
    k = int(np.argmin(abs(found.values - at)))
    distance = [abs(branch.frequency[k] - event.frequency) for branch in found.branches]
    first, second = np.argsort(np.nan_to_num(distance, nan=np.inf))[:2]
    return found.branches[first], found.branches[second]


def pair(found: Loci, meeting: Event | None, event: Event, centre: float) -> Pair:
    """Two loci with their shapes at the ends of the view and at their meeting."""
    at = meeting.at if meeting else centre
    branches = branches_of(found, meeting or event, at)
    k = int(np.argmin(abs(found.values - at)))
    motions = tuple(motions_of(branch, (0, k, len(found.values) - 1)) for branch in branches)
    return Pair(found.problem.coriolis, meeting, at, found.values, branches, motions)


def motions_of(branch: Branch, places: tuple[int, int, int]) -> tuple[Motion, Motion, Motion]:
    """The shapes of a branch at three values, their signs alike as far as they can be."""
    first, middle, last = (motion(branch, k) for k in places)
    return alike(first, middle), middle, alike(last, middle)


def motion(branch: Branch, k: int) -> Motion:
    """The shape of a branch at value number k; nan where it has none."""
    solution, place = branch.solutions[k], int(branch.mode_index[k])
    if solution is None or place < 0:
        return Motion(np.full(len(X), np.nan), np.full(len(X), np.nan), np.nan)
    along, across = components(solution, place)
    size = np.sqrt(along**2 + across**2).max()
    return Motion(along / size, across / size, float(solution.bending_energy_fraction[place]))


def components(solution: Solution, mode: int) -> tuple[np.ndarray, np.ndarray]:
    """The shape of a mode along and across the beam. With Coriolis forces the two are a quarter
    of a period apart: the shape is real along and imaginary across."""
    shape = solution.shape(mode, X)
    parts = shape.real + shape.imag
    return parts[:, 0], parts[:, 1]


def alike(one: Motion, other: Motion) -> Motion:
    """A shape with the sign that fits another."""
    overlap = one.along @ other.along + one.across @ other.across
    return one._replace(along=-one.along, across=-one.across) if overlap < 0 else one
