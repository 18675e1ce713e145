"""The default method `auto`: as few unknowns as the tolerance asks for."""

import math
from typing import Literal, NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import NotConverged
from beamviz.mechanics import eigen, hp
from beamviz.mechanics.gyroscopic import gyroscopic
from beamviz.mechanics.hp import EPS
from beamviz.mechanics.layers import Positions, discretisation, segments, unstretched
from beamviz.mechanics.mesh import Mesh, mesh
from beamviz.mechanics.strain import Curvature, StrainLaw
from beamviz.mechanics.stretch import equilibrium, first_guess, hardly_stretches, newton_many

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
    law = physics.law
    rigid = physics.tension != "equilibrium"
    hardly = rigid or hardly_stretches(beam)
    positions = unstretched(beam) if hardly else _coarse_positions(beam, law)
    parts = segments(beam, positions, law)
    digits = -math.log10(tolerance)
    excess, tried = math.inf, 0
    for attempt in range(1, REFINEMENTS + 1):
        breaks, orders = discretisation(parts, beam.mu, modes, physics.curvature, digits)
        if attempt > 1 and sum(orders) > MAX_UNKNOWNS:
            break
        points = mesh(breaks, orders)
        found = solve_on(points, beam, modes, physics)
        excess, tried = _excess(found, tolerance), len(points.points)
        if excess <= 1:
            return found
        digits += 0.7 * attempt + math.log10(excess)
    raise NotConverged(
        f"errors are still {excess:.1e} times the tolerance {tolerance:g} with {tried} unknowns in"
        " each family; ask for a larger tolerance or fewer modes"
    )


def _excess(found: StraightModes, tolerance: float) -> float:
    """The largest error in units of the one allowed. Rounding is allowed: no mesh mends it, and
    the reported error says it."""
    allowed = 2 * tolerance * abs(found.squares) + found.rounding
    return float((found.truncation / allowed).max())


def solve_on(points: Mesh, beam: Beam, modes: int, physics: Physics) -> StraightModes:
    """Equilibrium and modes on one mesh."""
    rho = hp.inertia(points, beam)
    if physics.tension == "equilibrium":
        f, iterations = equilibrium(points, rho, beam, physics.law)
    else:
        f, iterations = np.ones(len(points.weights)), 0
    forms = hp.forms(points, rho, beam, f, physics.law, physics.curvature, physics.stiffening)
    if physics.coriolis and physics.chordwise and beam.gamma:
        return _coupled(points, rho, f, iterations, beam, forms, modes, physics.softening)
    shift = eigen.COMPRESSED if beam.delta < 0 else 0.0
    return StraightModes(
        points, f, iterations, *_apart(points, f, beam.gamma**2, forms, modes, physics, shift)
    )


def _apart(
    points: Mesh,
    f: np.ndarray,
    softening: float | np.ndarray,
    forms: hp.Forms,
    modes: int,
    physics: Physics,
    shift: float,
) -> tuple[np.ndarray, ...]:
    """The fields of StraightModes from kappa on, of families that nothing couples.

    The softening is a multiple of M: it shifts every omega^2 and leaves the modes alone, so it
    is taken off here.
    """
    squares, v = eigen.lowest(forms.K, forms.M, modes, shift)
    share = hp.share_lost(hp.lost_to_order(points, forms, v), squares)
    softened = squares.copy()
    if physics.softening:
        softened[..., 0 if physics.chordwise else 1 :, :] -= softening
    both = (*squares.shape[:-2], 2 * modes)
    softened, squares, share = softened.reshape(both), squares.reshape(both), share.reshape(both)
    picks = softened.argsort(axis=-1)[..., :modes]
    places = picks if picks.ndim == 1 else (np.arange(len(picks))[:, None], picks)
    first = abs(squares.min(axis=-1, keepdims=True)) + shift
    truncation, rounding = hp.errors(points, f, squares[places], share[places], first)
    kappa, s = v[..., 0, :, :], v[..., 1, :, :]
    return kappa, s, picks, picks < modes, softened[places], truncation, rounding


def _coupled(
    points: Mesh,
    rho: hp.Inertia,
    f: np.ndarray,
    iterations: int,
    beam: Beam,
    forms: hp.Forms,
    modes: int,
    softening: bool,
) -> StraightModes:
    """Both families at once, coupled by Coriolis forces.

    With T(omega) = K - omega^2 M + 2 gamma omega S, an error e of a shape z moves omega^2 by
    e'T e 2 omega / |z' T' z|, and |z' T' z| = omega + z' K z / omega.
    """
    gamma = beam.gamma
    Kb, Ka = forms.K - gamma**2 * forms.M if softening else forms.K
    Fb, Fa = hp.displacements(points, rho, f)
    squares, s, kappa = gyroscopic(Ka, Fa, Kb, Fb, gamma, modes)
    size = abs(squares) + gamma**2
    share = hp.share_lost(hp.lost_to_order(points, forms, np.stack((kappa, s))), size).sum(axis=0)
    stored = hp.energy(Ka, s) + hp.energy(Kb, kappa)
    share *= 2 * abs(squares) / (abs(squares) + abs(stored))
    fractions = (abs(Fb @ kappa) ** 2).sum(axis=0)
    # The singular values of the coupled problem are 1 / omega: their roots of omega^2 round.
    first = np.sqrt(size * max(abs(squares[0]), EPS * gamma**2))
    truncation, rounding = hp.errors(points, f, size, share, first)
    return StraightModes(
        points, f, iterations, kappa, s, None, fractions, squares, truncation, rounding
    )


def _coarse_positions(beam: Beam, law: StrainLaw) -> Positions:
    """The positions of a beam that stretches, from a coarse equilibrium."""
    ends = unstretched(beam).ends
    points = mesh(ends, (COARSE_ORDER,) * (len(ends) - 1))
    f, _ = equilibrium(points, hp.inertia(points, beam), beam, law)
    weighted = (points.weights * (points.J @ f)).reshape(-1, COARSE_ORDER).sum(axis=1)
    u = points.from_clamp(np.array(ends)) @ f
    return Positions(ends, tuple(u.tolist()), tuple((weighted / np.diff(ends)).tolist()))


def solve_straight_many(
    beams: list[Beam], modes: int, physics: Physics, tolerance: float
) -> list[StraightModes | None]:
    """Many neighbouring beams at once, assembled together on meshes of one shape.

    The hardest beam sets the mesh. None where the common mesh does not meet the tolerance, or
    where a beam needs more care (large stretch, Coriolis, a mass that moves): `solve_straight`
    answers for those.
    """
    found: list[StraightModes | None] = [None] * len(beams)
    candidates = [k for k, beam in enumerate(beams) if hardly_stretches(beam)]
    coupled = physics.coriolis and physics.chordwise
    if not candidates or coupled or physics.tension != "equilibrium":
        return found
    hardest = max((beams[k] for k in candidates), key=_hardness)
    positions = unstretched(hardest)
    places = [k for k in candidates if unstretched(beams[k]).ends == positions.ends]
    together = [beams[k] for k in places]
    parts = segments(hardest, positions, physics.law)
    digits = -math.log10(tolerance)
    points = mesh(*discretisation(parts, hardest.mu, modes, physics.curvature, digits))
    for k, modes_of_one in zip(
        places, _solve_many_on(points, together, modes, physics), strict=True
    ):
        if modes_of_one is not None and _excess(modes_of_one, tolerance) <= 1:
            found[k] = modes_of_one
    return found


def _hardness(beam: Beam) -> float:
    """Roughly the greatest tension: the thinner the layers, the finer the mesh."""
    return beam.gamma**2 * (1 + abs(beam.delta)) * (1 + beam.alpha)


def _solve_many_on(
    points: Mesh, beams: list[Beam], modes: int, physics: Physics
) -> list[StraightModes | None]:
    """Equilibrium and modes of many beams on one mesh; None where Newton did not converge."""
    table = np.array([tuple(beam.numbers.values()) for beam in beams])
    numbers = hp.Numbers(*table.T[:, :, None])
    rho = hp.inertia(points, numbers)
    load = (numbers.gamma / numbers.mu) ** 2
    guess = first_guess(points, rho, numbers.delta, physics.law, load)
    f, converged, iterations = newton_many(points, rho, numbers, physics.law, load, guess)
    shift = eigen.COMPRESSED if min(beam.delta for beam in beams) < 0 else 0.0
    forms = hp.forms(points, rho, numbers, f, physics.law, physics.curvature, physics.stiffening)
    softening = numbers.gamma[..., None] ** 2
    apart = _apart(points, f, softening, forms, modes, physics, shift)
    fields = zip(f, *apart, converged, strict=True)
    return [StraightModes(points, f, iterations, *rest) if ok else None for f, *rest, ok in fields]
