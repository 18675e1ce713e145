"""Many neighbouring beams solved at once, as a sweep asks for them."""

import math
from collections.abc import Callable, Iterator
from functools import partial
from itertools import groupby, repeat
from operator import attrgetter

import numpy as np

from beamviz.beam import PARAMETERS, Beam
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.solver import eigen
from beamviz.solver.hp import matrices as hp
from beamviz.solver.hp.equilibrium import (
    MANY_PASSES,
    first_guess,
    hardly_stretches,
    newton_many,
    one_state,
)
from beamviz.solver.hp.mesh import Mesh, mesh, meshes
from beamviz.solver.hp.mesh_design import (
    MAX_UNKNOWNS,
    Positions,
    discretisation,
    more_digits,
    segments,
    unstretched,
)
from beamviz.solver.hp.modes import apart, coupled
from beamviz.solver.hp.refinement import StraightModes, coarse, excess
from beamviz.solver.problem import Problem

ATTEMPTS = 2  # what is left then needs care of its own
FEWER_DIGITS = 0.15
CHUNK = 32  # beams that share a mesh: it is as fine as the hardest of them needs

Discretisation = tuple[tuple[float, ...], tuple[int, ...]]  # breaks and orders
Discretised = Callable[[int], Discretisation | None]  # of the beam at a place

_numbers = attrgetter(*PARAMETERS)

# A sweep takes and frees arrays of about a megabyte. The C library of Linux gives these back to the
# system, and each of their pages is fetched anew at a fault, up to a fifth of a sweep's time. Once
# a larger block has been freed, it keeps what is smaller. This one is never touched.
np.empty(2**24, np.int8)


def solve_straight_many(
    beams: list[Beam], problem: Problem, extra_modes: int
) -> list[StraightModes | None]:
    """Many neighbouring beams at once, assembled together on meshes of the same orders; and
    `extra_modes` modes more, which need not meet the tolerance.

    None where the common orders do not meet the tolerance, or where a beam needs more care
    (near a limit, an inward beam with Coriolis forces): `solve_straight` answers for those.
    """
    found: list[StraightModes | None] = [None] * len(beams)
    modes, tolerance, beside = problem.modes, problem.tolerance, extra_modes
    table = np.array([_numbers(beam) for beam in beams]).reshape(-1, len(PARAMETERS))
    waiting = np.flatnonzero(_simple(hp.Numbers(*table.T), problem))
    digits = -math.log10(tolerance) - FEWER_DIGITS
    for _ in range(ATTEMPTS):
        left: dict[int, float] = {}  # place: by how much the tolerance is missed
        discretised = partial(_discretised, beams, modes, problem, digits)
        for places, points in _common_meshes(table, waiting, discretised):
            try:
                several = _solve_many_on(points, table[places], modes, beside, problem, tolerance)
            except np.linalg.LinAlgError:  # one of them buckles: each by itself
                continue
            for k, modes_of_one, over in zip(places.tolist(), *several, strict=True):
                if over <= 1:
                    found[k] = modes_of_one
                elif over < math.inf:
                    left[k] = over
        if not left:
            break
        waiting, digits = np.array(list(left)), digits + 0.7 + math.log10(max(left.values()))
    return found


def _common_meshes(
    table: np.ndarray, places: np.ndarray, discretised: Discretised
) -> Iterator[tuple[np.ndarray, Mesh]]:
    """The places of some beams to be solved together, and the mesh or the stack of meshes for it.
    A beam without equilibrium is left out, and one that buckles too finely: `solve_straight` says
    why."""
    alpha, beta, gamma, delta, mu = table[places].T
    if len(set(beta[alpha > 0].tolist())) <= 1:
        hardness = (gamma / mu) ** 2 * (1 + abs(delta)) * (1 + alpha)
        return _shared_meshes(places[hardness.argsort(kind="stable")], discretised)
    return _own_meshes(places[beta.argsort(kind="stable")], discretised)


def _shared_meshes(
    places: np.ndarray, discretised: Discretised
) -> Iterator[tuple[np.ndarray, Mesh]]:
    """A mesh for some beams with their mass at one place, gentle to hard: the hardest sets it."""
    groups: dict[Discretisation, list[np.ndarray]] = {}
    for chunk in _chunks(places):
        if found := discretised(chunk[-1]):
            groups.setdefault(found, []).append(chunk)
    for common, chunks in groups.items():
        yield np.concatenate(chunks), mesh(*common)


def _own_meshes(places: np.ndarray, discretised: Discretised) -> Iterator[tuple[np.ndarray, Mesh]]:
    """A stack of meshes for beams in the order of their masses: each has its own breaks, between
    which neighbours share their orders."""
    for chunk in _chunks(places):
        found = ((k, own) for k in chunk.tolist() if (own := discretised(k)))
        for _, group in groupby(found, key=lambda pair: len(pair[1][1])):
            members, sizes = zip(*group, strict=True)
            breaks, orders = zip(*sizes, strict=True)
            common = tuple(map(max, zip(*orders, strict=True)))
            yield np.array(members), meshes(np.array(breaks), common)


def _discretised(
    beams: list[Beam], modes: int, problem: Problem, digits: float, place: int
) -> Discretisation | None:
    """The breaks and orders a beam needs; None where it has no equilibrium or buckles too
    finely."""
    beam = beams[place]
    try:
        positions = _positions(beam, problem)
    except (NoEquilibrium, NotConverged):
        return None
    parts = segments(beam, positions, problem.strain_law)
    digits += more_digits(beam, positions, parts, problem)
    breaks, orders = discretisation(parts, beam.mu, modes, problem.curvature_measure, digits)
    return (breaks, orders) if sum(orders) <= MAX_UNKNOWNS else None


def _chunks(places: np.ndarray) -> list[np.ndarray]:
    """Places in their order, at most CHUNK at a time."""
    return np.array_split(places, math.ceil(len(places) / CHUNK)) if len(places) else []


def _positions(beam: Beam, problem: Problem) -> Positions:
    """Where the beam is in equilibrium, roughly."""
    return unstretched(beam) if hardly_stretches(beam) else coarse(beam, problem.strain_law)[1]


def _simple(beams: hp.Numbers, problem: Problem) -> np.ndarray:
    """Which beams can be solved together with others."""
    if problem.rigid_tension:
        return np.zeros(len(beams.delta), bool)
    simple = hardly_stretches(beams) | one_state(beams, problem.strain_law)
    return simple & (beams.gamma > 0) & (beams.delta >= 0) if problem.gyroscopic else simple


def _shared(numbers: hp.Numbers) -> hp.Numbers:
    """The numbers of one beam where all carry the same mass, for an inertia that serves all."""
    alpha, beta = numbers.alpha, numbers.beta
    same = (alpha == alpha[0]).all() and (beta == beta[0]).all()
    return hp.Numbers(*(number[:1] for number in numbers)) if same else numbers


def _solve_many_on(
    points: Mesh, table: np.ndarray, modes: int, beside: int, problem: Problem, tolerance: float
) -> tuple[list[StraightModes], list[float]]:
    """Equilibrium and modes of many beams, the rows of a table (beams, 5), on one mesh or on a
    mesh each; and by how much each misses the tolerance, infinite where Newton did not converge or
    a limit may be near."""
    count = modes + beside
    numbers = hp.Numbers(*table.T[:, :, None])
    rho = hp.inertia(points, _shared(numbers) if points.breaks.ndim == 1 else numbers)
    load = (numbers.gamma / numbers.mu) ** 2
    law = problem.strain_law
    passes = 2 if hardly_stretches(numbers).all() else MANY_PASSES
    guess = first_guess(points, rho, numbers, law.stretch, passes)
    stretch, sound = newton_many(points, rho, numbers, law, load, guess)
    f, gamma, iterations = stretch.f, numbers.gamma, stretch.iterations
    forms = hp.forms(points, rho, numbers, f, law, problem.curvature_measure, problem.stiffens)
    if problem.gyroscopic:
        vibration = coupled(points, rho, stretch, gamma, forms, count, problem.softening, tolerance)
    else:
        shift = eigen.COMPRESSED if table[:, 3].min() < 0 else 0.0
        vibration = apart(points, stretch, gamma[..., None] ** 2, forms, count, problem, shift)
    together = StraightModes(points.grid, f, iterations, *vibration)
    over = np.where(sound, excess(together, tolerance, modes), math.inf)
    fields = (repeat(None) if field is None else field for field in vibration)
    grid = points.grid
    grids = repeat(grid) if grid.breaks.ndim == 1 else map(grid.__getitem__, range(len(f)))
    each = zip(grids, f, repeat(iterations), *fields)  # some of these never end
    return list(map(StraightModes._make, each)), over.tolist()
