"""The map of failures: does a method solve a beam correctly?

Two errors are told apart. Discretisation error: the distance of a method from the converged
frequencies of its own model. Model error: the distance of these from the reference, the paper's
model (green strain, spatial curvature) as `auto` solves it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from beamviz.beam import MAX_GAMMA_OVER_MU, Beam
from beamviz.errors import NoEquilibrium
from beamviz.evidence.failure_maps.kinds import (
    FALSELY_UNSTABLE,
    INACCURATE,
    NO_EQUILIBRIUM,
    NOT_CONVERGED,
    OTHER_MODEL,
    OUTSIDE,
    RIGHT,
    ROUNDING,
    TRULY_UNSTABLE,
)
from beamviz.evidence.failure_maps.lines import (
    Cell,
    MethodLine,
    answer_of,
    is_unstable,
    onset,
    subdivided,
)
from beamviz.evidence.failure_maps.methods import METHODS, MODELS, REFERENCE, ComparedMethod
from beamviz.solver import Answer, Solution

MODES = 5  # compared
CONVERGED = {"modes": 10, "tolerance": 1e-8}  # of a model; the modes compared may be higher ones
ACCURATE = 1e-3  # largest relative discretisation error of a correct method
FAITHFUL = 1e-2  # largest relative model error of a correct method
HELPFUL = 0.75  # share of an error: twice as many terms help if they leave less (first order: 0.5)
TRUE_LOSS = 0.95  # of the reference's buckling speed: a model that buckles later is right


@dataclass
class Models:
    """The converged answers of models for a beam: each is solved once, for the first method that is
    compared with it."""

    beam: Beam
    answers: dict[str, Answer] = field(default_factory=dict)  # by the name of the model

    def __getitem__(self, name: str) -> Answer:
        if name not in self.answers:
            self.answers[name] = answer_of(self.beam, **CONVERGED, **MODELS[name])
        return self.answers[name]


def method_lines(beam: Beam, gammas: np.ndarray) -> list[MethodLine]:
    """The line of each method: its verdicts on the beam at ascending speeds."""
    accepted = gammas[gammas <= MAX_GAMMA_OVER_MU * beam.mu].tolist()
    outside = [Cell(OUTSIDE, solved=False)] * (len(gammas) - len(accepted))
    models = [Models(beam.replace(gamma=gamma)) for gamma in accepted]
    cells = [line_cells(method, models) for method in METHODS]
    onsets = {name: first_onset(name, models) for name in MODELS}
    buckling = onsets[REFERENCE]
    lines = []
    for method, verdicts in zip(METHODS, cells, strict=True):
        limit = float(np.fmin.reduce([cell.limit for cell in verdicts]))
        loss = onsets[method.model]
        loss = np.nan if loss >= TRUE_LOSS * buckling else loss
        lines.append(MethodLine(verdicts + outside, limit, buckling, loss))
    return lines


def line_cells(method: ComparedMethod, models: Sequence[Models]) -> list[Cell]:
    """The verdicts on one method for beams, of which only some are solved."""
    return subdivided(len(models), lambda k: verdict(method, models[k]))


def first_onset(name: str, models: Sequence[Models]) -> float:
    """The speed at which a beam becomes unstable in a model, among those at which it was solved;
    nan if it is stable at all of them."""
    stable = 0.0
    for beam, answer in ((each.beam, each.answers.get(name)) for each in models):
        if answer and is_unstable(answer):
            return onset(beam, stable, beam.gamma, **MODELS[name])
        if isinstance(answer, Solution):
            stable = beam.gamma
    return np.nan


def verdict(method: ComparedMethod, models: Models) -> Cell:
    """The verdict on one method for the beam of the models."""
    beam, converged, reference = models.beam, models[method.model], models[REFERENCE]
    cell = judge(answer_of(beam, modes=MODES, **method.options), converged, reference)
    if method.with_more_terms and cell.kind in (INACCURATE, NOT_CONVERGED):
        more = answer_of(beam, modes=MODES, **method.with_more_terms)
        if not improved(cell, judge(more, converged, reference)):
            return cell._replace(kind=ROUNDING)
    return cell


def improved(before: Cell, after: Cell) -> bool:
    """Whether more terms brought a method closer to its own model."""
    if after.kind == NOT_CONVERGED:
        return False
    if before.kind == NOT_CONVERGED:
        return after.kind != INACCURATE
    return not after.discretisation > HELPFUL * before.discretisation


def judge(answer: Answer, converged: Answer, reference: Answer) -> Cell:
    """The verdict on an answer, from the converged ones of its model and of the reference."""
    if isinstance(answer, NoEquilibrium) and isinstance(converged, NoEquilibrium):
        return Cell(NO_EQUILIBRIUM, message=str(answer), limit=answer.limit)
    if not isinstance(answer, Solution):
        return Cell(NOT_CONVERGED, message=str(answer))
    labels = answer.labels
    errors = distance(answer, converged, labels), distance(converged, reference, labels)
    if not answer.equilibrium.stable and isinstance(reference, Solution):
        return Cell(FALSELY_UNSTABLE if reference.equilibrium.stable else TRULY_UNSTABLE, *errors)
    inaccurate, unfaithful = errors[0] / ACCURATE, errors[1] / FAITHFUL
    if max(inaccurate, unfaithful) <= 1:
        return Cell(RIGHT, *errors)
    return Cell(INACCURATE if inaccurate > unfaithful else OTHER_MODEL, *errors)


def distance(answer: Answer, other: Answer, labels: tuple[str, ...]) -> float:
    """The largest relative difference in frequency (or rate of growth) of the modes with these
    labels; infinite where only one has the mode, or only one is stable."""
    if not (isinstance(answer, Solution) and isinstance(other, Solution)):
        return np.inf
    squares = [dict(zip(each.labels, each.omega_squared, strict=True)) for each in (answer, other)]
    first, second = (np.array([each.get(label, np.nan) for label in labels]) for each in squares)
    if not np.all(first * second > 0):
        return np.inf
    return float(abs(np.sqrt(first / second) - 1).max())
