"""Corresponding modes of two solutions, and the names of modes, also where Coriolis forces mix
shapes."""

from itertools import combinations
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from scipy.optimize import linear_sum_assignment

from beamviz.beam import Beam
from beamviz.errors import BeamvizError
from beamviz.frequency_loci import Event, Loci
from beamviz.frequency_loci.events import EVENT_KINDS
from beamviz.frequency_loci.mode_vectors import gauss_points, mass_weighted
from beamviz.solver import solve
from beamviz.solver.problem import MAX_MODES
from beamviz.solver.solution import Solution, labels_of

LOST = 0.25  # MAC below which two modes do not correspond
EXTRA_MODES = 2  # solved for without Coriolis forces, where the order of modes may differ
MIN_SHARE = 0.1  # MAC from which a mode is a part of a mixture


class ModeMatch(NamedTuple):
    """Correspondence of the modes of two solutions."""

    partner: np.ndarray  # (m1,) mode of the second for each of the first, -1 where none corresponds
    mac: np.ndarray  # (m1, m2) mass-weighted modal assurance criterion, 0 .. 1


def match_modes(first: Solution, second: Solution) -> ModeMatch:
    """Match the modes of two solutions by the correlation of their mass-weighted shapes.

    The solutions may differ in beam, model and number of modes. The assignment maximises the sum of
    the MAC; pairs below LOST are dropped. Two modes that are mixtures of the same two shapes keep
    their order.
    """
    count = max(gauss_points([first]), gauss_points([second]))
    a, b = _vectors(first, count, second.beam), _vectors(second, count, first.beam)
    sizes = np.linalg.norm(a, axis=1)[:, None] * np.linalg.norm(b, axis=1)
    mac = (a @ b.T / sizes) ** 2
    partner = np.full(len(mac), -1)
    rows, columns = linear_sum_assignment(mac, maximize=True)
    alike = mac[rows, columns] >= LOST
    partner[rows[alike]] = columns[alike]
    for i, j in combinations(rows[alike], 2):  # mixtures of the same two keep their order
        k, l = partner[i], partner[j]
        if k > l and min(mac[i, l], mac[j, k]) >= LOST:
            partner[i], partner[j] = l, k
    return ModeMatch(partner, mac)


def _vectors(solution: Solution, count: int, other: Beam) -> np.ndarray:
    """The mass-weighted shapes (m, components) of a solution at `count` Gauss points, or more with
    a blade; as many for another beam."""
    squares, beam = solution.omega_squared, solution.beam
    beside = () if (beam.blade, beam.masses) == (other.blade, other.masses) else (other,)
    return mass_weighted([solution], squares[None], count, beside).reshape(len(squares), -1)


class ModeIdentity(NamedTuple):
    """What the modes of a solution are called. labels: one for each mode, all different; mixtures:
    "S1/B3 mixed 55:45" for a mode that is one, "" for any other."""

    labels: tuple[str, ...]
    mixtures: tuple[str, ...]

    @property
    def summary(self) -> str:
        """The mixtures in one line: "S1 and B3 mixed 55:45" for two modes that are mixtures of each
        other, "B4: B4/S2 mixed 80:20" for one whose other part is not among the modes."""
        mixtures = {
            label: mixture
            for label, mixture in zip(self.labels, self.mixtures, strict=True)
            if mixture
        }
        groups: dict[frozenset[str], list[str]] = {}  # labels by the modes they are mixtures of
        for label, mixture in mixtures.items():
            parts, _, _ = mixture.partition(" ")
            groups.setdefault(frozenset(parts.split("/")), []).append(label)
        texts = []
        for mixed, labels in groups.items():
            if mixed == set(labels):
                _, _, shares = mixtures[labels[0]].partition(" ")
                texts.append(f"{' and '.join(labels)} {shares}")
            else:
                texts += [f"{label}: {mixtures[label]}" for label in labels]
        return "; ".join(texts)


# Of solutions in use: that of a deflected blade holds ten megabytes.
IDENTITIES: WeakKeyDictionary[Solution, ModeIdentity] = WeakKeyDictionary()


def identify_modes(solution: Solution) -> ModeIdentity:
    """The names of the modes of a solution, which are found once for each."""
    if solution not in IDENTITIES:
        IDENTITIES[solution] = _identified(solution)
    return IDENTITIES[solution]


def _identified(solution: Solution) -> ModeIdentity:
    """The names of the modes of a solution.

    Without Coriolis forces they are those of `solution.labels`: stretching and bending are
    uncoupled, and the order within a family never changes. With them a mode has the name of the
    corresponding mode of the same beam without them, and where it is a mixture of several modes,
    their shares. So the name follows the shape through a veering.
    """
    labels, problem = solution.labels, solution.problem
    pure = ModeIdentity(labels, ("",) * len(labels))
    if not (problem.gyroscopic and solution.beam.gamma) or solution.equilibrium.shape == "bent":
        return pure
    extra = min(len(labels) + EXTRA_MODES, MAX_MODES) - problem.modes
    modes = problem.modes + problem.available(extra)
    try:
        uncoupled = solve(solution.beam, **problem.options | {"coriolis": False, "modes": modes})
    except BeamvizError:
        return pure
    partner, mac = match_modes(solution, uncoupled)
    names = [uncoupled.labels[k] if k >= 0 else "" for k in partner]
    for k, label in enumerate(labels):
        if not names[k]:  # no corresponding mode: the first free name of its family
            free = (f"{label[0]}{number}" for number in range(1, MAX_MODES + 1))
            names[k] = next(name for name in free if name not in names)
    return ModeIdentity(tuple(names), tuple(_mixture(row, uncoupled.labels) for row in mac))


def _mixture(mac: np.ndarray, labels: tuple[str, ...]) -> str:
    """The modes (m,) that a shape is a mixture of, by descending share; "" for a single mode."""
    parts = [k for k in np.argsort(-mac) if mac[k] >= MIN_SHARE]
    if len(parts) < 2:
        return ""
    shares = np.round(100 * mac[parts] / mac[parts].sum())
    return f"{'/'.join(labels[k] for k in parts)} mixed {':'.join(f'{x:.0f}' for x in shares)}"


def names_of_branches(loci: Loci, value: float) -> dict[str, str]:
    """The names of the modes by branch label, at the value of the sweep nearest to `value`. Two
    branches that veer keep their labels and exchange their shapes, so the names of their modes. A
    solve is needed with Coriolis forces, and where the branches lack a lower mode."""
    k = int(np.argmin(abs(loci.values - value)))
    branches = {int(branch.mode_index[k]): branch for branch in loci.branches}  # by mode
    branches.pop(-1, None)  # not among the modes there
    if not loci.problem.gyroscopic and max(branches, default=0) < len(branches):
        every = [branches[mode] for mode in range(len(branches))]
        in_plane = None
        if loci.problem.in_space:
            in_plane = [row[k] for each in every if (row := each.in_plane_fraction) is not None]
        labels = labels_of([branch.bending_fraction[k] for branch in every], in_plane)
    else:
        solution = next((branch.solutions[k] for branch in branches.values()), None)
        labels = identify_modes(solution).labels if solution else ()
    return {branch.label: labels[mode] for mode, branch in branches.items()}


def names_of_event(loci: Loci, event: Event) -> tuple[str, ...]:
    """The names of the modes of an event, at the value of the sweep nearest to it: of two that
    meet there the second may be the next one above those asked for. An event of the
    equilibria is of the lowest modes of two states, whose names are those of its branches."""
    if not EVENT_KINDS[event.kind].of_single_state:
        return event.branches
    k = int(np.argmin(abs(loci.values - event.at)))
    branches = [branch for branch in loci.branches if branch.label in event.branches]
    modes = [int(branch.mode_index[k]) for branch in branches if branch.mode_index[k] >= 0]
    solution = branches[0].solutions[k] if modes else None
    if solution is None:
        return event.branches
    if len(modes) < len(set(event.branches)):
        modes.append(max(modes) + 1)
    labels = identify_modes(solution).labels
    return tuple(labels[mode] for mode in modes if mode < len(labels))
