"""The default method on as few unknowns as the tolerance asks for: meshes, attempts, refinement.

Beams are solved in stacks that share a mesh, or at least the orders of their meshes; one beam is a
stack of one. A stack is refined as a whole, then its remaining beams one by one.
"""

import math
from bisect import bisect
from collections.abc import Sequence
from functools import lru_cache
from itertools import accumulate, count, groupby, pairwise
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import PARAMETERS, Beam
from beamviz.errors import BeamvizError, NoEquilibrium, NotConverged
from beamviz.solver.constitutive import StrainLaw
from beamviz.solver.continuation import LIMIT_MARGIN
from beamviz.solver.hp.equilibrium import (
    AxialProblem,
    AxialState,
    BeamStack,
    State,
    has_unique_equilibrium,
    inertia,
    is_small_strain,
    limit_error,
    single,
)
from beamviz.solver.hp.mesh import Mesh, make_mesh, make_meshes
from beamviz.solver.hp.mesh_design import (
    AT_END,
    MAX_UNKNOWNS,
    BreaksAndOrders,
    Positions,
    Span,
    choose_mesh,
    extra_digits,
    find_spans,
    half_waves,
    unstretched_positions,
)
from beamviz.solver.hp.modes import StraightModes, lowest_modes
from beamviz.solver.problem import Problem

REFINEMENTS = 8  # attempts at a beam
STACKED = 2  # of them in stacks: the beams left then need care of their own
CHUNK = 32  # beams that share a mesh: it is as fine as the hardest of them needs
OWN_CHUNK, FINER = 48, 1.5  # beams with meshes of their own, that share orders; how much finer
FEWEST = 6  # beams that get a coarser mesh
SPARED = 1.5e5  # cubes of unknowns that it spares in all: another stack takes as long
DESIGNED = 8  # one in so many meshes is designed where only the place of the mass changes
FEWER_DIGITS = 0.15  # asked of a shared mesh: most of its beams need less than the hardest
COMMON = -1  # place of the design of a mesh for all beams between some
COMMON_DIGITS = 0.5  # more of it, so that none needs another
MORE_DIGITS = 0.7  # for each further attempt, beyond those the last one missed
GREATEST_ERROR = 0.01  # relative, of omega^2 near a limit where the tolerance cannot be met
COARSE_ORDER, COARSE_ERROR = 6, 1e-6  # of the equilibrium that a mesh is designed from
STRETCH_SHARE = 1e-3  # of the tolerance: an error of the stretch that is accepted

_numbers = attrgetter(*PARAMETERS)

# A sweep takes and frees arrays of about a megabyte. The C library of Linux gives these back to the
# system, and each of their pages is fetched anew at a fault, up to a fifth of a sweep's time. Once
# a larger block has been freed, it keeps what is smaller. This one is never touched.
np.empty(2**24, np.int8)


class Design(NamedTuple):
    """What the mesh of a beam follows from: its spans, the digits it needs beyond those asked for,
    and a state to start from."""

    spans: list[Span]
    extra_digits: float
    start: State | None


Answer = StraightModes | BeamvizError


def solve_straight(
    beams: Sequence[Beam], problem: Problem, extra_modes: int = 0, mesh_of: Sequence[Beam] = ()
) -> list[Answer]:
    """Equilibrium and modes of each beam within the tolerance, or NoEquilibrium or NotConverged in
    its place; and `extra_modes` more modes, which need not meet the tolerance. mesh_of: see
    `solve_many`."""
    refinement = Refinement(beams, problem, extra_modes, mesh_of)
    while refinement.waiting:
        for places, mesh in refinement.next_stacks():
            refinement.solve_stack(places, mesh)
    return refinement.answers


class Refinement:
    """The progress of a refinement: answers, and what the beams still waiting are tried with.

    waiting: place of each beam without an answer, with the digits that its attempts have added;
    alone: places of beams that are solved by themselves; near_limit: the best attempt at beams near
    their limit of equilibrium, with its error ratio; round: number of the attempt.
    """

    def __init__(
        self, beams: Sequence[Beam], problem: Problem, extra_modes: int, mesh_of: Sequence[Beam]
    ):
        self.beams, self.problem, self.mesh_of = beams, problem, mesh_of
        self.count = problem.modes + extra_modes
        self.answers: list[Any] = [None] * len(beams)
        self.designs: dict[int, Design] = {}
        self.near_limit: dict[int, tuple[float, StraightModes]] = {}
        self.waiting = dict.fromkeys(range(len(beams)), 0.0)
        self.alone = set(self.waiting)
        self.round = 0
        if len(beams) > 1:
            self.numbers = np.array([_numbers(beam) for beam in beams])  # (beams, 5)
            alpha, beta, gamma, delta, mu = self.numbers.T
            stack = BeamStack(alpha, beta, gamma, delta, mu, len(beams), False)
            stackable = is_small_strain(stack) | has_unique_equilibrium(stack, problem.strain_law)
            if problem.gyroscopic:
                stackable &= (gamma > 0) & (delta >= 0)
            if not problem.rigid_tension:
                self.alone -= set(stackable.nonzero()[0].tolist())

    def next_stacks(self) -> list[tuple[list[int], Mesh]]:
        """The next attempt at all waiting beams: the places of those to solve together, and the
        mesh or the stack of meshes for them. Gives up after REFINEMENTS attempts."""
        self.round += 1
        if self.round > STACKED:
            self.alone.update(self.waiting)
        if self.round > REFINEMENTS:
            for place in list(self.waiting):
                self._give_up(
                    place, f"its errors are above the tolerance after {REFINEMENTS} refinements"
                )
        stacks: list[tuple[list[int], Mesh]] = []
        if len(self.alone) < len(self.waiting):
            together = np.array([place for place in self.waiting if place not in self.alone])
            alpha, beta, gamma, delta, mu = self.numbers[together].T
            shared = len(set(beta[alpha > 0].tolist())) <= 1  # breaks at the mass, if at all
            hardness = (gamma / mu) ** 2 * (1 + abs(delta)) * (1 + alpha) if shared else beta
            order = together[hardness.argsort(kind="stable")]
            chunk = CHUNK if shared else OWN_CHUNK
            chunks = [chunk.tolist() for chunk in np.array_split(order, -(-len(order) // chunk))]
            if self.mesh_of and self.round == 1:
                stacks = self._on_common_mesh(chunks, shared)
            if not stacks:
                stacks = self._on_one_mesh(chunks) if shared else self._on_own_meshes(chunks)
        for place in sorted(self.alone):
            if found := self._mesh([place]):
                stacks.append(([place], make_mesh(*found)))
        return stacks

    def _on_common_mesh(
        self, chunks: list[list[int]], shared: bool
    ) -> list[tuple[list[int], Mesh]]:
        """Meshes of the same orders for all beams between those of `mesh_of`, as fine as any of
        these needs, with a break at the mass. None if one needs more breaks."""
        common, extra = _common_orders(tuple(self.mesh_of), self.problem, shared)
        self.designs[COMMON] = Design([], extra, None)
        stacks: list[tuple[list[int], Mesh]] = []
        if shared:
            breaks, orders = max(common.items(), key=lambda item: sum(item[1]), default=((), ()))
            if 0 < sum(orders) <= MAX_UNKNOWNS:
                stacks = [(chunk, make_mesh(breaks, orders)) for chunk in chunks]
        elif common.keys() <= {1, 2} and 2 in common:
            first, second = (max((order, *common.get(1, ()))) for order in common[2])
            for own in map(np.array, chunks):
                beta = self.numbers[own, 1]
                ends = beta <= AT_END, beta >= 1 - AT_END
                for where, order in zip(ends, (second, first), strict=True):
                    stacks.append((own[where].tolist(), make_mesh((0.0, 1.0), (order,))))
                inner = own[~ends[0] & ~ends[1]].tolist()
                breaks = np.pad(self.numbers[inner, 1:2], ((0, 0), (1, 1)), constant_values=(0, 1))
                stacks.append((inner, make_meshes(breaks, (first, second))))
            stacks = [stack for stack in stacks if stack[0]]
        return stacks

    def _on_one_mesh(self, chunks: list[list[int]]) -> list[tuple[list[int], Mesh]]:
        """A mesh for beams with their mass at one place, gentle to hard: the hardest sets it, and
        the gentle half has one of its own where that is much coarser."""
        groups: dict[BreaksAndOrders, list[int]] = {}
        while chunks:
            chunk = chunks.pop()
            gentle = chunk[: len(chunk) // 2]
            if not (found := self._mesh(chunk)):
                chunks += [chunk[:-1]] if chunk[:-1] else []
            elif len(gentle) < FEWEST or sum(found[1]) ** 3 * len(gentle) <= SPARED:
                groups.setdefault(found, []).extend(chunk)
            elif not (coarser := self._mesh(gentle)):
                chunks.append([place for place in chunk if place != gentle[-1]])
            elif (sum(found[1]) ** 3 - sum(coarser[1]) ** 3) * len(gentle) > SPARED:
                chunks += [gentle, chunk[len(gentle) :]]
            else:
                groups.setdefault(found, []).extend(chunk)
        return [(places, make_mesh(*common)) for common, places in groups.items()]

    def _on_own_meshes(self, chunks: list[list[int]]) -> list[tuple[list[int], Mesh]]:
        """A stack of meshes for beams in the order of their masses: each has its own breaks,
        between which neighbours share their orders."""
        stacks = []
        for chunk in chunks:
            found = self._own_meshes(chunk)
            groups = [list(own) for _, own in groupby(found, key=lambda pair: len(pair[1][1]))]
            while groups:
                group = groups.pop()
                places, meshes = zip(*group, strict=True)
                breaks, orders = zip(*meshes, strict=True)
                common = tuple(map(max, zip(*orders, strict=True)))
                if sum(common) * len(group) > FINER * sum(map(sum, orders)):
                    half = len(group) // 2
                    groups += [group[:half], group[half:]]
                elif len(places) == 1:
                    stacks.append((list(places), make_mesh(*meshes[0])))
                else:
                    stacks.append((list(places), make_meshes(np.array(breaks), common)))
        return stacks

    def _own_meshes(self, chunk: list[int]) -> list[tuple[int, BreaksAndOrders]]:
        """The mesh of each beam that has one. Of beams that differ in the place of the mass alone
        a few are designed: between two meshes of as many elements the breaks move with the mass."""
        alpha, beta, *others = self.numbers[chunk].T
        step = DESIGNED if not np.ptp((alpha, *others), axis=1).any() else 1
        corners = sorted({*range(0, len(chunk), step), len(chunk) - 1})
        found = {k: own for k in corners if (own := self._mesh([chunk[k]]))}
        kinds = {k: (len(own[0]), bisect(own[0], beta[k] - AT_END)) for k, own in found.items()}
        for i, j in pairwise(corners):
            if kinds.get(i) == kinds.get(j) is not None:
                (low, orders), (high, others_orders) = found[i], found[j]
                common = tuple(map(max, zip(orders, others_orders, strict=True)))
                shares = (beta[i + 1 : j] - beta[i]) / (beta[j] - beta[i])
                rows = np.outer(1 - shares, low) + np.outer(shares, high)
                found |= {k: (tuple(row), common) for k, row in enumerate(rows.tolist(), i + 1)}
            else:
                found |= {k: own for k in range(i + 1, j) if (own := self._mesh([chunk[k]]))}
        return [(chunk[k], found[k]) for k in sorted(found)]

    def _mesh(self, places: list[int]) -> BreaksAndOrders | None:
        """A mesh for some beams, the last of them the hardest; None where that has an answer now,
        an error, or is to be solved alone."""
        place, problem = places[-1], self.problem
        try:
            if place not in self.designs:
                self.designs[place] = design(self.beams[place], problem)
        except (NoEquilibrium, NotConverged) as error:
            self._answer(place, error)
            return None
        spans, extra, _ = self.designs[place]
        digits = extra - math.log10(problem.tolerance) + max(map(self.waiting.__getitem__, places))
        if place not in self.alone:
            digits -= FEWER_DIGITS
        mu, measure = self.beams[place].mu, problem.curvature_measure
        found = choose_mesh(spans, mu, problem.modes, measure, digits)
        unknowns = sum(found[1])
        if unknowns <= MAX_UNKNOWNS:
            return found
        if place not in self.alone:
            self.alone.add(place)
        else:
            self._give_up(place, f"it takes {unknowns} unknowns")
        return None

    def solve_stack(self, places: list[int], mesh: Mesh) -> None:
        """Solve beams on a mesh or a stack of meshes: those within the tolerance get an answer,
        the others more digits for the next attempt."""
        one, problem = len(places) == 1, self.problem
        if one:
            beams = single(self.beams[places[0]])
            _, extra, start = self.designs.get(places[0]) or self.designs[COMMON]
        else:
            alpha, beta, gamma, delta, mu = self.numbers[places].T[:, :, None]
            outward = bool((delta >= 0).all())
            beams = BeamStack(alpha, beta, gamma, delta, mu, len(places), outward)
            designs = [self.designs[place] for place in places if place in self.designs]
            others = designs or self.designs.values()  # between two that are designed
            extra, start = max(design.extra_digits for design in others), None
        try:
            rho = inertia(mesh, beams)
            if problem.rigid_tension:
                state = AxialState(np.ones((1, mesh.weights.shape[-1])), 0, 0.0)
            else:
                accept_error = STRETCH_SHARE * problem.tolerance / 10**extra
                axial = AxialProblem(mesh, rho, beams, problem.strain_law)
                state = axial.solve(start, accept_error)
            modes = lowest_modes(mesh, rho, state, beams, self.count, problem)
        except (NoEquilibrium, NotConverged, np.linalg.LinAlgError) as error:
            if not one:  # one of them buckles: each by itself
                self.alone.update(places)
            elif isinstance(error, BeamvizError):
                self._answer(places[0], error)
            else:
                raise
            return
        # Rounding error is exempt: refinement cannot reduce it, and the reported error contains it.
        allowed = 2 * problem.tolerance * abs(modes.omega_squared) + modes.rounding
        ratios = (modes.truncation / allowed)[:, : problem.modes]
        ratios = np.maximum.reduce(ratios, axis=-1).tolist()
        modes.omega_squared.setflags(write=False)
        modes.bending_energy_fraction.setflags(write=False)
        for place, ratio, answer in zip(places, ratios, modes.of_each_beam(), strict=False):
            if ratio == math.inf:  # no equilibrium was found
                self.alone.add(place)
                continue
            if ratio <= 1:
                self._answer(place, answer)
                continue
            self.waiting[place] += MORE_DIGITS * self.round + math.log10(ratio)
            if one:
                if place in self.designs:
                    self.designs[place] = self.designs[place]._replace(start=(mesh, state.f))
                best = self.near_limit[place][0] if place in self.near_limit else math.inf
                if state.margin is not None and state.margin[0] < LIMIT_MARGIN and ratio < best:
                    self.near_limit[place] = ratio, answer

    def _answer(self, place: int, answer: Answer) -> None:
        self.answers[place] = answer
        del self.waiting[place]
        self.alone.discard(place)

    def _give_up(self, place: int, reason: str) -> None:
        """Answer a beam that cannot be resolved by an error that names a remedy. Near a limit the
        best attempt is the answer: there the stretch rounds more than any mesh can make up for."""
        beam, problem = self.beams[place], self.problem
        ratio, answer = self.near_limit.get(place, (math.inf, None))
        if answer and ratio * problem.tolerance < GREATEST_ERROR:
            return self._answer(place, answer)
        if not problem.rigid_tension and not (problem.strain_law.hardens and beam.delta >= 0):
            try:
                if near := limit_error(beam, problem.strain_law):
                    return self._answer(place, near)
            except NotConverged:  # no limit was found
                pass
        cause, remedy = "", "a larger tolerance or fewer modes"
        if beam.delta < 0:
            cause = ": the straight beam buckles in many half-waves"
            remedy = "a lower gamma or a larger delta"
        error = (
            f"{reason}, at most {MAX_UNKNOWNS} in each family are tried{cause}; ask for {remedy}"
        )
        return self._answer(place, NotConverged(error))


@lru_cache(maxsize=8)
def _common_orders(
    beams: tuple[Beam, ...], problem: Problem, by_breaks: bool
) -> tuple[dict[Any, tuple[int, ...]], float]:
    """The greatest orders of the meshes of some beams by their breaks, or by the number of
    elements, and the greatest number of digits that one needs beyond those asked for. None where
    one of them has no equilibrium."""
    waves = max(half_waves(beam.mu, problem.modes) for beam in beams)
    common: dict[Any, tuple[int, ...]] = {}
    greatest = 0.0
    for beam in beams:
        try:
            spans, extra, _ = design(beam, problem)
        except (NoEquilibrium, NotConverged):
            return {}, 0.0
        greatest = max(greatest, extra)
        modes = next(m for m in count(problem.modes) if half_waves(beam.mu, m) >= waves)
        digits = extra - math.log10(problem.tolerance) + COMMON_DIGITS
        breaks, orders = choose_mesh(spans, beam.mu, modes, problem.curvature_measure, digits)
        kind = breaks if by_breaks else len(orders)
        common[kind] = tuple(map(max, zip(orders, common.get(kind, orders), strict=True)))
    return common, greatest


def design(beam: Beam, problem: Problem) -> Design:
    """What the mesh of a beam follows from. Raises NoEquilibrium with the limit."""
    start, positions = None, unstretched_positions(beam)
    if not (problem.rigid_tension or is_small_strain(beam)):
        start, positions = coarse_equilibrium(beam, problem.strain_law)
    loaded = beam if problem.stiffens else beam.replace(gamma=0.0)  # no tension, no layers
    spans = find_spans(loaded, positions, problem.strain_law)
    return Design(spans, extra_digits(beam, positions, spans, problem), start)


def coarse_equilibrium(beam: Beam, law: StrainLaw) -> tuple[State, Positions]:
    """The equilibrium of a beam of large strain on a coarse mesh, and the positions it gives."""
    ends = unstretched_positions(beam).ends
    mesh = make_mesh(ends, (COARSE_ORDER,) * (len(ends) - 1))
    stack = single(beam)
    problem = AxialProblem(mesh, inertia(mesh, stack), stack, law)
    load = (beam.gamma / beam.mu) ** 2
    # Where there is an equilibrium for sure, within a percent is near enough.
    guess = problem.first_guess(load, None, 0.0)[0] if law.hardens and beam.delta >= 0 else None
    state = problem.solve(accept_error=COARSE_ERROR).f if guess is None else guess
    f = state[0]
    values = mesh.weights * np.array((f, mesh.J @ f))
    parts = values.reshape(2, -1, COARSE_ORDER).sum(axis=2)  # integrals of f and u over each part
    u = accumulate(parts[0].tolist(), initial=0.0)
    means = parts[1] / (mesh.breaks[1:] - mesh.breaks[:-1])
    return (mesh, state), Positions(ends, tuple(u), tuple(means.tolist()))
