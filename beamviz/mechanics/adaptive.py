"""The default method `auto`: as few unknowns as the tolerance asks for."""

import math
from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import NotConverged
from beamviz.mechanics import eigen, hp
from beamviz.mechanics.gyroscopic import gyroscopic
from beamviz.mechanics.hp import EPS
from beamviz.mechanics.layers import Positions, discretisation, segments, unstretched
from beamviz.mechanics.mesh import Mesh, mesh, meshes
from beamviz.mechanics.strain import Curvature, StrainLaw
from beamviz.mechanics.stretch import (
    State,
    equilibrium,
    first_guess,
    hardly_stretches,
    newton_many,
)

REFINEMENTS = 8
MAX_UNKNOWNS = 300  # of one family; beyond, the scene is too near an end of equilibrium
COARSE_ORDER = 6


Tension = Literal["equilibrium", "reference"]


class Physics(NamedTuple):
    """What is solved about a beam: its laws, its plane, whether Coriolis forces act, and whose
    tension stiffens it: that of the stretched equilibrium, or that of the rigid reference length
    (first-order coupling). Stiffening and softening are terms that can be left out."""

    law: StrainLaw
    curvature: Curvature
    chordwise: bool
    coriolis: bool
    tension: Tension = "equilibrium"
    stiffening: bool = True
    softening: bool = True

    @property
    def couples(self) -> bool:
        """Whether stretching and bending vibrate together, in a beam that turns."""
        return self.coriolis and self.chordwise


class StraightModes(NamedTuple):
    """The lowest modes of both families on the mesh that met the tolerance.

    Without Coriolis `picks` (modes,) orders the columns of kappa, then s, laid end to end; with
    it `picks` is None and column k of both, complex, is mode k.
    """

    mesh: Mesh
    f: np.ndarray  # (n,) stretch at the mesh points
    iterations: int
    kappa: np.ndarray  # (n, modes) slope of the rotation
    s: np.ndarray  # (n, modes) gradient along the beam
    picks: np.ndarray | None
    bending_fractions: np.ndarray  # (modes,) share of the kinetic energy; 0 or 1 where apart
    squares: np.ndarray  # (modes,) omega^2, ascending
    truncation: np.ndarray  # (modes,) error of omega^2 from the order of the mesh
    rounding: np.ndarray  # (modes,) error of omega^2 from rounding


def solve_straight(beam: Beam, modes: int, physics: Physics, tolerance: float) -> StraightModes:
    """Equilibrium and the lowest `modes` modes within the relative `tolerance`.

    Raises NoEquilibrium with the limit, NotConverged when refinement does not get there.
    """
    near, positions = None, unstretched(beam)
    if physics.tension == "equilibrium" and not hardly_stretches(beam):
        near, positions = _coarse(beam, physics.law)
    pulled = beam if physics.stiffening else beam.replace(gamma=0.0)  # no tension, no layers
    parts = segments(pulled, positions, physics.law)
    digits = -math.log10(tolerance)
    excess, tried = math.inf, 0
    for attempt in range(1, REFINEMENTS + 1):
        breaks, orders = discretisation(parts, beam.mu, modes, physics.curvature, digits)
        if sum(orders) > MAX_UNKNOWNS:
            break
        points = mesh(breaks, orders)
        found = solve_on(points, beam, modes, physics, tolerance, near)
        excess, tried = _excess(found, tolerance), len(points.points)
        if excess <= 1:
            return found
        near = points, found.f
        digits += 0.7 * attempt + math.log10(excess)
    if not tried:
        raise NotConverged(
            f"the straight beam buckles in too many half-waves to resolve: {sum(orders)} unknowns in"
            f" each family, at most {MAX_UNKNOWNS} are tried; ask for a lower gamma or a larger delta"
        )
    raise NotConverged(
        f"errors are still {excess:.1e} times the tolerance {tolerance:g} with {tried} unknowns in"
        " each family; ask for a larger tolerance or fewer modes"
    )


def _excess(found: StraightModes, tolerance: float) -> float:
    """The largest error in units of the one allowed. Rounding is allowed: no mesh mends it, and
    the reported error says it."""
    allowed = 2 * tolerance * abs(found.squares) + found.rounding
    return float((found.truncation / allowed).max())


def solve_on(
    points: Mesh,
    beam: Beam,
    modes: int,
    physics: Physics,
    tolerance: float,
    near: State | None = None,
) -> StraightModes:
    """Equilibrium and modes on one mesh; `near` is the equilibrium on another."""
    rho = hp.inertia(points, beam)
    if physics.tension == "equilibrium":
        f, iterations = equilibrium(points, rho, beam, physics.law, near)
    else:
        f, iterations = np.ones(len(points.weights)), 0
    forms = hp.forms(points, rho, beam, f, physics.law, physics.curvature, physics.stiffening)
    if physics.couples and beam.gamma:
        fields = _coupled(points, rho, f, beam.gamma, forms, modes, physics.softening, tolerance)
    else:
        shift = eigen.COMPRESSED if beam.delta < 0 else 0.0
        fields = _apart(points, f, beam.gamma**2, forms, modes, physics, shift)
    return StraightModes(points, f, iterations, *fields)


def _apart(
    points: Mesh,
    f: np.ndarray,
    softening: float | np.ndarray,
    forms: hp.Forms,
    modes: int,
    physics: Physics,
    shift: float,
) -> tuple[np.ndarray | None, ...]:
    """The fields of StraightModes from kappa on, of families that nothing couples.

    The softening is a multiple of M: it shifts every omega^2 and leaves the modes alone, so it
    is taken off here.
    """
    squares, v, added = eigen.lowest(forms.K, forms.M, modes, shift)
    share = hp.share_lost(hp.lost_to_order(points, forms, v), squares)
    size = squares + added  # of what was solved: rounding falls on the high ones
    rounding = hp.rounding(size, size / size[..., :1])
    softened = squares.copy()
    if physics.softening:
        softened[..., 0 if physics.chordwise else 1 :, :] -= softening
    both = (*squares.shape[:-2], 2 * modes)
    picks = softened.reshape(both).argsort(axis=-1)[..., :modes]
    places = picks if picks.ndim == 1 else (np.arange(len(picks))[:, None], picks)
    softened, squares, share, rounding = (
        each.reshape(both)[places] for each in (softened, squares, share, rounding)
    )
    truncation = hp.truncation(points, f, squares, share)
    fractions = (picks < modes).astype(float)
    return v[..., 0, :, :], v[..., 1, :, :], picks, fractions, softened, truncation, rounding


def _coupled(
    points: Mesh,
    rho: hp.Inertia,
    f: np.ndarray,
    gamma: float | np.ndarray,
    forms: hp.Forms,
    modes: int,
    softening: bool,
    tolerance: float,
) -> tuple[np.ndarray | None, ...]:
    """The fields of StraightModes from kappa on, of both families coupled by Coriolis forces;
    for a stack of beams gamma is (beams, 1).

    With T(omega) = K - omega^2 M + 2 gamma omega S, an error e of a shape z moves omega^2 by
    e'T e 2 omega / |z' T' z|, and |z' T' z| = omega + z' K z / omega.
    """
    speed = np.asarray(gamma)[..., None]
    K = forms.K - speed[..., None] ** 2 * forms.M if softening else forms.K
    F = hp.displacements(points, rho, f)
    families = (each for k in (1, 0) for each in (K[..., k, :, :], F[..., k, :, :]))
    most = tolerance / (10 * hp.ROUNDING_FACTOR * EPS)
    squares, s, kappa, times = gyroscopic(*families, speed, modes, most)
    size = abs(squares) + gamma**2
    v = np.stack((kappa, s), axis=-3)
    share = hp.share_lost(hp.lost_to_order(points, forms, v), size[..., None, :]).sum(axis=-2)
    stored = (v.conj() * (K @ v)).sum(axis=(-3, -2)).real
    share *= 2 * abs(squares) / (abs(squares) + abs(stored))
    fractions = (abs(F[..., 0, :, :] @ kappa) ** 2).sum(axis=-2)
    truncation = hp.truncation(points, f, size, share)
    return kappa, s, None, fractions, squares, truncation, hp.rounding(size, times)


def _coarse(beam: Beam, law: StrainLaw) -> tuple[State, Positions]:
    """The equilibrium of a beam that stretches on a coarse mesh, and the positions it gives."""
    ends = unstretched(beam).ends
    points = mesh(ends, (COARSE_ORDER,) * (len(ends) - 1))
    f, _ = equilibrium(points, hp.inertia(points, beam), beam, law)
    weighted = (points.weights * (points.J @ f)).reshape(-1, COARSE_ORDER).sum(axis=1)
    u = points.from_clamp(np.array(ends)) @ f
    means = weighted / np.diff(ends)
    return (points, f), Positions(ends, tuple(u.tolist()), tuple(means.tolist()))


def solve_straight_many(
    beams: list[Beam], modes: int, physics: Physics, tolerance: float
) -> list[StraightModes | None]:
    """Many neighbouring beams at once, assembled together on meshes of the same orders.

    None where the common orders do not meet the tolerance, or where a beam needs more care
    (large stretch, an inward beam with Coriolis forces): `solve_straight` answers for those.
    """
    found: list[StraightModes | None] = [None] * len(beams)
    for places, points in _common_meshes(beams, modes, physics, tolerance):
        together = [beams[k] for k in places]
        try:
            several = _solve_many_on(points, together, modes, physics, tolerance)
        except np.linalg.LinAlgError:  # one of them buckles: each by itself
            continue
        for k, modes_of_one in zip(places, several, strict=True):
            if modes_of_one is not None and _excess(modes_of_one, tolerance) <= 1:
                found[k] = modes_of_one
    return found


def _common_meshes(
    beams: list[Beam], modes: int, physics: Physics, tolerance: float
) -> Iterator[tuple[list[int], Mesh]]:
    """Places of beams that can be solved together, and the mesh or the stack of meshes for it.

    Where all have their mass at one place, the hardest sets the mesh. Where it moves, each has
    its own breaks, and those of the same orders go together.
    """
    places = [k for k, beam in enumerate(beams) if _simple(beam, physics)]
    positions = [unstretched(beams[k]) for k in places]
    digits = -math.log10(tolerance)

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
        fields = _coupled(points, rho, f, gamma, forms, modes, physics.softening, tolerance)
    else:
        shift = eigen.COMPRESSED if min(beam.delta for beam in beams) < 0 else 0.0
        fields = _apart(points, f, gamma[..., None] ** 2, forms, modes, physics, shift)
    return [
        StraightModes(
            points if points.breaks.ndim == 1 else points[k],
            f[k],
            iterations,
            *(None if field is None else field[k] for field in fields),
        )
        if converged[k]
        else None
        for k in range(len(beams))
    ]
