"""Many neighbouring beams solved at once, as a sweep asks for them."""

import math
from collections.abc import Iterator

import numpy as np

from beamviz.beam import Beam
from beamviz.mechanics import eigen, hp
from beamviz.mechanics.adaptive import StraightModes, excess
from beamviz.mechanics.layers import Positions, discretisation, segments, unstretched
from beamviz.mechanics.mesh import Mesh, mesh, meshes
from beamviz.mechanics.physics import Physics
from beamviz.mechanics.stretch import first_guess, hardly_stretches, newton_many
from beamviz.mechanics.vibration import apart, coupled

ATTEMPTS = 2  # what is left then needs care of its own


def solve_straight_many(
    beams: list[Beam], modes: int, physics: Physics, tolerance: float
) -> list[StraightModes | None]:
    """Many neighbouring beams at once, assembled together on meshes of the same orders.

    None where the common orders do not meet the tolerance, or where a beam needs more care
    (large stretch, an inward beam with Coriolis forces): `solve_straight` answers for those.
    """
    found: list[StraightModes | None] = [None] * len(beams)
    waiting = [k for k, beam in enumerate(beams) if _simple(beam, physics)]
    digits = -math.log10(tolerance)
    for _ in range(ATTEMPTS):
        left: dict[int, float] = {}  # place: by how much the tolerance is missed
        for places, points in _common_meshes(beams, waiting, modes, physics, digits):
            together = [beams[k] for k in places]
            try:
                several = _solve_many_on(points, together, modes, physics, tolerance)
            except np.linalg.LinAlgError:  # one of them buckles: each by itself
                continue
            for k, modes_of_one in zip(places, several, strict=True):
                if modes_of_one is None:
                    continue
                over = excess(modes_of_one, tolerance)
                if over <= 1:
                    found[k] = modes_of_one
                else:
                    left[k] = over
        if not left:
            break
        waiting, digits = list(left), digits + 0.7 + math.log10(max(left.values()))
    return found


def _common_meshes(
    beams: list[Beam], places: list[int], modes: int, physics: Physics, digits: float
) -> Iterator[tuple[list[int], Mesh]]:
    """The places of beams to be solved together, and the mesh or the stack of meshes for it.

    Where all have their mass at one place, the hardest sets the mesh. Where it moves, each has
    its own breaks, and those of the same orders go together.
    """
    positions = [unstretched(beams[k]) for k in places]

    def discretised(k: int, at: Positions) -> tuple[tuple[float, ...], tuple[int, ...]]:
        parts = segments(beams[k], at, physics.law)
        return discretisation(parts, beams[k].mu, modes, physics.curvature, digits)

    if len({at.ends for at in positions}) == 1:
        hardest = max(places, key=lambda k: _hardness(beams[k]))
        yield places, mesh(*discretised(hardest, positions[0]))
        return
    groups: dict[tuple[int, ...], list[tuple[int, tuple[float, ...]]]] = {}
    for k, at in zip(places, positions, strict=True):
        breaks, orders = discretised(k, at)
        groups.setdefault(orders, []).append((k, breaks))
    for orders, group in groups.items():
        members, breaks_of_all = zip(*group, strict=True)
        yield list(members), meshes(np.array(breaks_of_all), orders)


def _simple(beam: Beam, physics: Physics) -> bool:
    """Whether a beam can be solved together with others."""
    if physics.tension != "equilibrium" or not hardly_stretches(beam):
        return False
    return not physics.couples or (beam.gamma > 0 and beam.delta >= 0)


def _hardness(beam: Beam) -> float:
    """Roughly the greatest tension: the thinner the layers, the finer the mesh."""
    return beam.gamma**2 * (1 + abs(beam.delta)) * (1 + beam.alpha)


def _solve_many_on(
    points: Mesh, beams: list[Beam], modes: int, physics: Physics, tolerance: float
) -> list[StraightModes | None]:
    """Equilibrium and modes of many beams on one mesh, or on a mesh each; None where Newton did
    not converge."""
    table = np.array([tuple(beam.numbers.values()) for beam in beams])
    numbers = hp.Numbers(*table.T[:, :, None])
    rho = hp.inertia(points, numbers)
    load = (numbers.gamma / numbers.mu) ** 2
    guess = first_guess(points, rho, numbers.delta, physics.law, load)
    f, converged, iterations = newton_many(points, rho, numbers, physics.law, load, guess)
    forms = hp.forms(points, rho, numbers, f, physics.law, physics.curvature, physics.stiffening)
    gamma = numbers.gamma
    if physics.couples:
        vibration = coupled(points, rho, f, gamma, forms, modes, physics.softening, tolerance)
    else:
        shift = eigen.COMPRESSED if min(beam.delta for beam in beams) < 0 else 0.0
        vibration = apart(points, f, gamma[..., None] ** 2, forms, modes, physics, shift)
    mesh_of = [points] * len(beams) if points.breaks.ndim == 1 else points
    return [
        StraightModes(mesh_of[k], f[k], iterations, *vibration.of(k)) if converged[k] else None
        for k in range(len(beams))
    ]
