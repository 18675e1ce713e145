"""The default method: choice of the meshes and refinement to the tolerance.

Beams are solved in stacks that share a mesh, or at least the orders of their meshes; one beam is a
stack of one. Beams above the tolerance are solved again on finer meshes, first in stacks, then one
by one.
"""

import math
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from itertools import groupby
from operator import attrgetter, itemgetter
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import PARAMETERS, Beam
from beamviz.errors import BeamvizError, NoEquilibrium, NotConverged
from beamviz.solver.continuation import LIMIT_MARGIN
from beamviz.solver.hp import equilibrium, mesh_design
from beamviz.solver.hp.equilibrium import AxialState, BeamStack, State, is_small_strain
from beamviz.solver.hp.mesh import Mesh, make_mesh, make_meshes
from beamviz.solver.hp.mesh_design import (
    AT_END,
    MAX_UNKNOWNS,
    Elements,
    HalfWaves,
    Span,
    half_waves,
)
from beamviz.solver.hp.modes import StraightModes, lowest_modes
from beamviz.solver.problem import Problem

MAX_ATTEMPTS = 8  # for each beam
STACKED_ATTEMPTS = 2  # of them in stacks
CHUNK = 16  # beams that share a mesh, which is as fine as any of them needs
COMMON_CHUNK = 48  # beams on a common mesh, or with own breaks and common orders
COMMON_DIGITS = 0.2, 4.0  # added for a common mesh, so that no beam needs another: first and most
COMMON = -1  # key of the design of a common mesh
MORE_DIGITS = 0.7  # added for each further attempt, beyond those missed
GREATEST_ERROR = 0.01  # relative, of omega^2 near a limit where the tolerance cannot be met
STRETCH_SHARE = 1e-3  # accepted error of the stretch, relative to the tolerance

# A sweep allocates and frees arrays of about a megabyte. The C library of Linux returns them to the
# system, and the page faults of the next ones take up to a fifth of the time of a sweep. Once a
# larger block was freed, it keeps smaller ones. This block is never written to.
np.empty(2**24, np.int8)


class Design(NamedTuple):
    """What determines the mesh of a beam, and its first guess."""

    spans: list[Span]
    extra_digits: float  # beyond those of the tolerance
    start: State | None  # of Newton's method


@dataclass
class CommonMesh:
    """Orders of the meshes that all beams of a line in parameter space share, in several calls.

    beams: some of the line, from end to end. digits: added to what these need; more once a beam
    between them has missed the tolerance."""

    beams: tuple[Beam, ...]
    digits: float = COMMON_DIGITS[0]


Answer = StraightModes | BeamvizError


class Refinement:
    """The state of a refinement. A beam is referred to by its index in `beams`.

    count: number of modes. answers: of each beam. waiting: the beams without one, and the digits
    that their attempts have added. alone: beams that are not stacked. in_common: beams solved on
    the common mesh, if any. near_limit: error ratios and modes of the attempts at beams near their
    limit of equilibrium.
    """

    def __init__(
        self, beams: Sequence[Beam], problem: Problem, count: int, common: CommonMesh | None
    ):
        self.beams, self.problem, self.count, self.common = beams, problem, count, common
        self.answers: list[Any] = [None] * len(beams)
        self.designs: dict[int, Design] = {}
        self.near_limit: dict[int, list[tuple[float, Any]]] = {}
        self.waiting = dict.fromkeys(range(len(beams)), 0.0)
        self.alone = set(self.waiting)
        self.in_common: set[int] = set()
        self.attempt = 0
        if len(beams) > 1:
            self.numbers = np.array(list(map(attrgetter(*PARAMETERS), beams)))  # (beams, 5)
            stack, law = self._stack(list(self.waiting)), problem.strain_law
            stackable = is_small_strain(stack) | equilibrium.has_unique_equilibrium(stack, law)
            if problem.gyroscopic:
                stackable &= stack.gamma > 0
            if not problem.rigid_tension:
                self.alone -= set(stackable.nonzero()[0].tolist())

    def _stack(self, indices: list[int]) -> BeamStack:
        """The parameters of several beams."""
        alpha, beta, gamma, delta, mu = self.numbers[indices].T[:, :, None]
        return BeamStack(alpha, beta, gamma, delta, mu, len(indices), bool((delta >= 0).all()))

    def next_stacks(self) -> list[tuple[list[int], Mesh]]:
        """The stacks of the next attempt at all waiting beams: indices of the beams, and their mesh
        or stack of meshes. Beams are given up after MAX_ATTEMPTS."""
        self.attempt += 1
        if self.attempt > STACKED_ATTEMPTS:
            self.alone.update(self.waiting)
        if self.attempt > MAX_ATTEMPTS:
            for index in list(self.waiting):
                self._give_up(index, f"errors exceed the tolerance after {MAX_ATTEMPTS} attempts")
        stacks: list[tuple[list[int], Mesh]] = []
        left = set(self.waiting)
        if self.common and len(self.beams) > 1:
            new = [index for index, digits in self.waiting.items() if not digits]
            stacks = self._on_common_mesh(self.common, new) if new else []
            self.in_common.update(*(indices for indices, _ in stacks))
            left.difference_update(self.in_common.intersection(new))
        if stacked := sorted(left - self.alone):
            shared = self._same_position(stacked)
            chunks = self._chunks(stacked, shared, CHUNK if shared else COMMON_CHUNK)
            stacks += self._on_one_mesh(chunks) if shared else self._on_own_meshes(chunks)
        for index in sorted(left & self.alone):
            if found := self._mesh([index]):
                stacks.append(([index], make_mesh(*found)))
        return stacks

    def _same_position(self, indices: list[int]) -> bool:
        """Whether masses, and so the breaks there, have the same position."""
        alpha, beta, *_ = self.numbers[indices].T
        return len(set(beta[alpha > 0].tolist())) <= 1

    def _chunks(self, indices: list[int], shared: bool, most: int) -> list[list[int]]:
        """Beams by ascending load, or by the position of their masses, in stacks."""
        alpha, beta, gamma, delta, mu = self.numbers[indices].T
        load = (gamma / mu) ** 2 * (1 + abs(delta)) * (1 + alpha)
        order = np.array(indices)[(load if shared else beta).argsort(kind="stable")]
        pieces = -(-len(order) // most)
        return [chunk.tolist() for chunk in np.array_split(order, pieces)]

    def refines(self, common_mesh: CommonMesh) -> bool:
        """Whether a beam has missed the tolerance on the common mesh, which is refined then. All
        beams are to be solved again: their spectra are smooth only with equal orders."""
        missed = max((self.waiting[k] for k in self.in_common & self.waiting.keys()), default=0.0)
        if not missed or common_mesh.digits + missed > COMMON_DIGITS[1]:
            return False
        common_mesh.digits += missed
        return True

    def _on_common_mesh(
        self, common_mesh: CommonMesh, indices: list[int]
    ) -> list[tuple[list[int], Mesh]]:
        """Meshes of the same orders for all beams, as fine as any beam of the common mesh needs,
        with a break at the mass. Empty if one needs more breaks."""
        shared = self._same_position(indices)
        beams, digits = common_mesh.beams, common_mesh.digits
        common, extra = common_orders(beams, digits, self.problem, shared)
        self.designs[COMMON] = Design([], extra, None)
        stacked = [index for index in indices if index not in self.alone]
        chunks = self._chunks(stacked, shared, COMMON_CHUNK) if stacked else []
        chunks += [[index] for index in indices if index in self.alone]
        if shared:
            breaks = max(common, key=lambda breaks: common[breaks][0].sum(), default=())
            if not breaks or common[breaks][0].sum() > MAX_UNKNOWNS:
                return []
            mesh = make_mesh(breaks, *_tuples(common[breaks]))
            return [(chunk, mesh) for chunk in chunks]
        if not (common.keys() <= {1, 2} and 2 in common):
            return []
        both = np.maximum(common[2], common.get(1, 0))

        def elements(beta: float) -> Elements:
            if AT_END < beta < 1 - AT_END:
                return Elements((0.0, beta, 1.0), *_tuples(both))
            return Elements((0.0, 1.0), *_tuples(both[:, 1:] if beta <= AT_END else both[:, :1]))

        every = ([(k, elements(self.numbers[k, 1].item())) for k in chunk] for chunk in chunks)
        return [stack for chunk in every for stack in _stacks_of_own_meshes(chunk)]

    def _on_one_mesh(self, chunks: list[list[int]]) -> list[tuple[list[int], Mesh]]:
        """Meshes for beams by ascending load, their masses at the same position: the last beam of a
        chunk determines the mesh."""
        groups: dict[Elements, list[int]] = {}
        for chunk in chunks:
            for count in range(len(chunk), 0, -1):
                if found := self._mesh(chunk[:count]):
                    groups.setdefault(found, []).extend(chunk[:count])
                    break
        return [(indices, make_mesh(*common)) for common, indices in groups.items()]

    def _on_own_meshes(self, chunks: list[list[int]]) -> list[tuple[list[int], Mesh]]:
        """Stacks of meshes for beams by ascending position of the mass: each beam has its own
        breaks, neighbours have the same orders."""
        every = ([(k, own) for k in chunk if (own := self._mesh([k]))] for chunk in chunks)
        return [stack for chunk in every for stack in _stacks_of_own_meshes(chunk)]

    def _mesh(self, indices: list[int]) -> Elements | None:
        """The mesh for some beams that the last of them needs; None where that has an error now, or
        is to be solved alone."""
        index, problem = indices[-1], self.problem
        try:
            if index not in self.designs:
                self.designs[index] = design(self.beams[index], problem)
        except (NoEquilibrium, NotConverged) as error:
            self._fail(index, error)
            return None
        spans, extra, _ = self.designs[index]
        digits = extra - math.log10(problem.tolerance) + max(map(self.waiting.__getitem__, indices))
        mu = self.beams[index].mu
        waves = half_waves(mu, problem.modes)
        found = mesh_design.choose_mesh(spans, mu, waves, problem, digits)
        unknowns = sum(found.orders)
        if unknowns <= MAX_UNKNOWNS:
            return found
        if index not in self.alone:
            self.alone.add(index)
        else:
            self._give_up(index, f"{unknowns} unknowns needed in a family, at most {MAX_UNKNOWNS}")
        return None

    def solve_stack(self, indices: list[int], mesh: Mesh) -> None:
        """Solve beams on a mesh or a stack of meshes: those within the tolerance have an answer
        then, the others more digits for the next attempt."""
        one, problem = len(indices) == 1, self.problem
        beams = equilibrium.single(self.beams[indices[0]]) if one else self._stack(indices)
        designs = list(filter(None, map(self.designs.get, indices))) or [self.designs[COMMON]]
        _, extra, start = max(designs, key=attrgetter("extra_digits"))
        axial = equilibrium.axial_problem(mesh, beams, problem.strain_law)
        try:
            if problem.rigid_tension:
                state = AxialState(np.ones((1, mesh.weights.shape[-1])), 0, 0.0)
            else:
                accept_error = STRETCH_SHARE * problem.tolerance / 10**extra
                state = axial.solve(start if one else None, accept_error)
            modes = lowest_modes(axial, state, self.count, problem)
        except (NoEquilibrium, NotConverged, np.linalg.LinAlgError) as error:
            if not one:  # an unstable beam among them
                self.alone.update(indices)
            elif isinstance(error, BeamvizError):
                self._fail(indices[0], error)
            else:
                raise
            return
        # Rounding error is exempt: refinement cannot reduce it, and the reported error contains it.
        allowed = 2 * problem.tolerance * abs(modes.omega_squared) + modes.rounding
        ratios = (modes.truncation / allowed)[:, : problem.modes]
        ratios = np.maximum.reduce(ratios, axis=-1).tolist()
        modes.omega_squared.setflags(write=False)
        modes.bending_energy_fraction.setflags(write=False)
        for index, ratio, answer in zip(indices, ratios, modes.of_each_beam(), strict=False):
            if ratio == math.inf:  # no equilibrium was found
                self.alone.add(index)
                continue
            if ratio <= 1:
                self._answer(index, answer)
                continue
            self.waiting[index] += MORE_DIGITS * self.attempt + math.log10(ratio)
            if one:
                if index in self.designs:
                    self.designs[index] = self.designs[index]._replace(start=(mesh, state.f))
                if state.margin is not None and state.margin[0] < LIMIT_MARGIN:
                    self.near_limit.setdefault(index, []).append((ratio, answer))

    def _answer(self, index: int, answer: Answer) -> None:
        self.answers[index] = answer
        del self.waiting[index]
        self.alone.discard(index)

    def _fail(self, index: int, error: BeamvizError) -> None:
        """Answer with an error; beyond a limit of equilibrium or near it with that of the limit."""
        beam, problem = self.beams[index], self.problem
        with suppress(NotConverged):
            if not problem.rigid_tension:
                error = equilibrium.limit_error(beam, problem.strain_law) or error
        self._answer(index, error)

    def _give_up(self, index: int, reason: str) -> None:
        """Answer with an error that names a remedy; near a limit with the best attempt, as the
        rounding error of the stretch is large there on any mesh."""
        ratio, answer = min(self.near_limit.get(index, [(math.inf, None)]), key=itemgetter(0))
        if ratio * self.problem.tolerance < GREATEST_ERROR:
            return self._answer(index, answer)
        remedy = "a larger tolerance or fewer modes"
        if self.beams[index].delta < 0:
            reason += ": the straight beam buckles in many half-waves"
            remedy = "a lower gamma or a larger delta"
        return self._fail(index, NotConverged(f"{reason}; ask for {remedy}"))


@lru_cache(maxsize=8)
def common_orders(
    beams: tuple[Beam, ...], added: float, problem: Problem, by_breaks: bool
) -> tuple[dict[Any, np.ndarray], float]:
    """The greatest orders (2, elements), across and along the beam, of the meshes of some beams by
    their breaks, or by the number of elements, and the greatest number of extra digits, of those
    that have an equilibrium."""
    waves = [half_waves(beam.mu, problem.modes) for beam in beams]
    most_waves = HalfWaves(*map(max, zip(*waves, strict=True)))
    common: dict[Any, np.ndarray] = {}
    greatest = 0.0
    for beam in beams:
        try:
            spans, extra, _ = design(beam, problem)
        except (NoEquilibrium, NotConverged):
            continue
        greatest = max(greatest, extra)
        digits = extra - math.log10(problem.tolerance) + added
        breaks, *orders = mesh_design.choose_mesh(
            spans,
            beam.mu,
            most_waves,
            problem,
            digits,
            same_breaks=not by_breaks,  # layers move with the mass
        )
        kind = breaks if by_breaks else len(breaks) - 1
        common[kind] = np.maximum(orders, common.get(kind, 0))
    return common, greatest


def _stacks_of_own_meshes(own: list[tuple[int, Elements]]) -> list[tuple[list[int], Mesh]]:
    """Stacks of neighbours with as many elements, whose orders are the greatest of any of them."""
    stacks = []
    for _, group in groupby(own, key=lambda pair: len(pair[1].orders)):
        indices, meshes = zip(*group, strict=True)
        breaks, orders, axial_orders = map(np.array, zip(*meshes, strict=True))
        common = _tuples((orders.max(axis=0), axial_orders.max(axis=0)))
        one = len(indices) == 1
        mesh = make_mesh(meshes[0].breaks, *common) if one else make_meshes(breaks, *common)
        stacks.append((list(indices), mesh))
    return stacks


def _tuples(orders: Iterable[np.ndarray]) -> tuple[tuple[int, ...], ...]:
    """Orders of elements as arguments of `make_mesh`."""
    return tuple(tuple(each.tolist()) for each in orders)


def design(beam: Beam, problem: Problem) -> Design:
    """What determines the mesh of a beam. Raises NoEquilibrium with the limit."""
    start, positions = None, mesh_design.unstretched_positions(beam)
    if not (problem.rigid_tension or is_small_strain(beam)):
        start, positions = equilibrium.coarse_equilibrium(beam, problem.strain_law)
    loaded = beam if problem.stiffens else beam.replace(gamma=0.0)  # no tension, no layers
    spans = mesh_design.find_spans(loaded, positions, problem.strain_law)
    return Design(spans, mesh_design.extra_digits(beam, positions, spans, problem), start)
