"""Mass and stiffness of straight beams: on a mesh, and of the spans between its discontinuities.

rho A, E I and E A are relative to those of the root section. A body on the beam has a mass alpha
and principal moments of inertia; those turn with the section that carries it.
"""

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from beamviz.beam import PARAMETERS, Beam
from beamviz.blade import MAX_DEGREE, Blade, Mass
from beamviz.solver.hp.mesh import Mesh

AT_END = 1e-13  # distance to the clamp or the tip, by rounding, of a mass that is taken to be there
SAMPLES = 9  # of a span, besides its ends, at which its least stiffness is sought
LEAST = 0.9  # of the least sample of a polynomial, which may fall below it between two samples

numbers_of = attrgetter(*PARAMETERS)


class Numbers(NamedTuple):
    """The numbers of a straight beam, and its properties where it is not uniform."""

    alpha: float
    beta: float
    gamma: float
    delta: float
    mu: float
    blade: Blade | None = None
    masses: tuple[Mass, ...] = ()
    root: float = np.inf


AnyBeam = Beam | Numbers


def is_uniform(beam: AnyBeam) -> bool:
    """Whether it has one section, at most one concentrated mass, and a clamp."""
    return beam.blade is None and not beam.masses and beam.root == np.inf


class BeamStack(NamedTuple):
    """The parameters of a stack of beams with the same blade, masses and root: each (beams, 1), and
    those of all bodies (beams, bodies), or (1, bodies) where all beams have the same."""

    alpha: NDArray
    beta: NDArray
    gamma: NDArray
    delta: NDArray
    mu: NDArray
    turning: bool  # whether all have a speed
    inward: bool  # whether any points inward
    blade: Blade | None
    masses: tuple[Mass, ...]  # the bodies but the first, which may have no mass
    root: float

    @property
    def hinged(self) -> bool:
        """Whether the angle at the root is free, or held by a spring."""
        return self.root < np.inf


def stack_of(beams: Sequence[AnyBeam]) -> BeamStack:
    """The parameters of some beams."""
    alpha, beta, gamma, delta, mu = np.array([numbers_of(beam) for beam in beams]).T[..., None]
    if len({(beam.alpha, beam.beta) for beam in beams}) == 1:
        alpha, beta = alpha[:1], beta[:1]
    turning = all(beam.gamma for beam in beams)
    inward = any(beam.delta < 0 for beam in beams)
    masses = beams[0].masses
    if masses:
        more = np.array([(mass.alpha, mass.beta) for mass in masses]).T
        alpha, beta = (
            np.hstack((column, np.tile(row, (len(column), 1))))
            for column, row in zip((alpha, beta), more, strict=True)
        )
    blade, root = beams[0].blade, beams[0].root
    return BeamStack(alpha, beta, gamma, delta, mu, turning, inward, blade, masses, root)


class Properties(NamedTuple):
    """Mass and stiffness of a stack of beams on a mesh. The line density is rho(x) with a Dirac
    function alpha at each body; its inertia is in terms of the gradient of the displacement. The
    leading axis is 1 where all beams share the array."""

    bending: NDArray  # (1 or beams, n) weights of the mesh times E I in the plane of rotation
    flap: NDArray  # (1 or beams, n) and out of it
    axial: NDArray  # (1 or beams, n) weights times E A
    rooted: NDArray  # (1 or beams, n, n) root of rho times integration: without the bodies
    G: NDArray  # (1 or beams, n, n) mass matrix J' rho J
    G1: NDArray  # (1 or beams, n) G applied to the stretch of a beam at rest
    g: NDArray  # (1 or beams, n) static moment J' rho 1
    to_bodies: NDArray  # (1 or beams, bodies, n) integrates from the clamp to each body
    alpha: NDArray  # (1 or beams, bodies)
    # Ends of elements at which the axial force over E A may be greatest: the clamp, of a blade all.
    to_ends: NDArray  # (1 or beams, ends, n) int rho u outboard of the end, over E A there
    total: NDArray  # (1 or beams, ends) mass outboard of it, over E A there


def properties_on(mesh: Mesh, beams: BeamStack) -> Properties:
    """The properties of beams whose bodies sit on breaks of the mesh."""
    if len(beams.alpha) == 1:
        alpha, beta = tuple(beams.alpha[0].tolist()), tuple(beams.beta[0].tolist())
        return shared_properties(mesh, alpha, beta, beams.blade)
    return properties_of(mesh, beams.alpha, beams.beta, beams.blade)


@lru_cache(maxsize=4)  # 7 % of a solve where only other numbers of the beam change
def shared_properties(
    mesh: Mesh, alpha: tuple[float, ...], beta: tuple[float, ...], blade: Blade | None
) -> Properties:
    """The properties of beams with the same bodies."""
    return properties_of(mesh, np.array([alpha]), np.array([beta]), blade)


def properties_of(mesh: Mesh, alpha: NDArray, beta: NDArray, blade: Blade | None) -> Properties:
    """The properties with bodies of masses alpha at beta, each (1 or beams, bodies)."""
    inboard = mesh.points[..., None, :] < beta[..., None]
    to_bodies = np.where(inboard, mesh.weights[..., None, :], 0.0)
    carried = alpha[..., None] * to_bodies
    moment = carried.sum(axis=-2)
    weights = np.atleast_2d(mesh.weights)
    if blade is None:
        g = mesh.g + moment
        return Properties(
            bending=weights,
            flap=weights,
            axial=weights,
            rooted=mesh.rooted,
            G=mesh.G + carried.mT @ to_bodies,
            G1=mesh.G1 + np.vecmat(beta, carried),
            g=g,
            to_bodies=to_bodies,
            alpha=alpha,
            to_ends=g[..., None, :],
            total=1.0 + (alpha * (beta > 0)).sum(axis=-1, keepdims=True),
        )
    mass = weights * blade.at("mass", np.atleast_2d(mesh.points))
    rooted = np.sqrt(mass)[..., None] * mesh.J
    G = rooted.mT @ rooted + carried.mT @ to_bodies
    # The start of each element, then the end of each, with the bodies there outboard of the latter.
    starts, ends = np.atleast_2d(mesh.breaks)[:, :-1], np.atleast_2d(mesh.breaks)[:, 1:]
    points, bodies = np.atleast_2d(mesh.points)[:, None, :], beta[..., None, :]
    at = np.concatenate((starts, ends), axis=-1)[..., None]  # (1 or beams, ends, 1)
    axial = np.concatenate((blade.at("axial", starts), blade.at("axial", ends, True)), axis=-1)
    beyond = np.concatenate((bodies > starts[..., None], bodies >= ends[..., None]), axis=-2)
    distributed, concentrated = (points > at) * mass[..., None, :], beyond * alpha[..., None, :]
    total = distributed.sum(axis=-1) + concentrated.sum(axis=-1)
    return Properties(
        bending=weights * blade.at("bending", np.atleast_2d(mesh.points)),
        flap=weights * blade.at("flap", np.atleast_2d(mesh.points)),
        axial=weights * blade.at("axial", np.atleast_2d(mesh.points)),
        rooted=rooted,
        G=G,
        G1=G.sum(axis=-1),
        g=np.vecmat(mass, mesh.J) + moment,
        to_bodies=to_bodies,
        alpha=alpha,
        to_ends=(distributed @ mesh.J + concentrated @ to_bodies) / axial[..., None],
        total=total / axial,
    )


class Positions(NamedTuple):
    """Positions u of an equilibrium, measured from the clamp, and the mass of the spans."""

    ends: tuple[float, ...]  # x of the ends of the spans
    u: tuple[float, ...]  # at the ends
    means: tuple[float, ...]  # of u in each span, by mass
    masses: tuple[float, ...]  # of each span


class SpanProperties(NamedTuple):
    """Properties of a span between two discontinuities."""

    x: NDArray  # (k,) Gauss points
    weights: NDArray  # (k,)
    mass: NDArray  # (k,) rho A at the points
    bending: NDArray  # (k,) E I
    axial: NDArray  # (k,) E A
    bending_at_ends: tuple[float, float]
    axial_at_ends: tuple[float, float]
    mass_at_ends: tuple[float, float]
    least_axial: float


def ends_of_spans(beam: AnyBeam) -> tuple[float, ...]:
    """x of the clamp, of what is not smooth between clamp and tip (bodies, ends of the segments of
    a blade), and of the tip."""
    if is_uniform(beam):
        inside = beam.alpha > 0 and AT_END < beam.beta < 1 - AT_END
        return (0.0, beam.beta, 1.0) if inside else (0.0, 1.0)
    bodies = [beam.beta] * (beam.alpha > 0) + [mass.beta for mass in beam.masses]
    ends = [0.0]
    for x in sorted({*bodies, *(beam.blade.breaks if beam.blade else ())}):
        if ends[-1] + AT_END < x < 1 - AT_END:
            ends.append(x)
    return (*ends, 1.0)


def unstretched_positions(beam: AnyBeam) -> Positions:
    """The positions of an unstretched beam, u = x."""
    ends = ends_of_spans(beam)
    if beam.blade is None:
        means, masses = zip(*(((a + b) / 2, b - a) for a, b in pairwise(ends)), strict=True)
        return Positions(ends, ends, means, masses)
    spans = properties_of_spans(beam.blade, ends, "bending")
    masses = tuple(float(span.weights @ span.mass) for span in spans)
    moments = (float(span.weights @ (span.mass * span.x)) for span in spans)
    means = tuple(moment / mass for moment, mass in zip(moments, masses, strict=True))
    return Positions(ends, ends, means, masses)


@lru_cache(maxsize=64)
def properties_of_spans(
    blade: Blade, ends: tuple[float, ...], bending: str
) -> tuple[SpanProperties, ...]:
    """The properties of the spans of a blade. bending: "bending" or "flap"."""
    xi, weights = legendre.leggauss(MAX_DEGREE // 2 + 2)  # exact for the static moment
    spans = []
    for start, stop in pairwise(ends):
        x, w = start + (stop - start) * (xi + 1) / 2, (stop - start) / 2 * weights
        mass, EI, EA = (blade.at(name, x) for name in ("mass", bending, "axial"))
        at_ends = {
            name: (float(blade.at(name, start)), float(blade.at(name, stop, inboard=True)))
            for name in (bending, "axial", "mass")
        }
        inside = blade.at("axial", np.linspace(start, stop, SAMPLES + 2)[1:-1]).min()
        least = min(*at_ends["axial"], float(inside)) * (1.0 if blade.degree == 1 else LEAST)
        spans.append(
            SpanProperties(
                x=x,
                weights=w,
                mass=mass,
                bending=EI,
                axial=EA,
                bending_at_ends=at_ends[bending],
                axial_at_ends=at_ends["axial"],
                mass_at_ends=at_ends["mass"],
                least_axial=least,
            )
        )
    return tuple(spans)


def greatest_force(beam: AnyBeam) -> float:
    """An upper bound of the axial force of the unstretched beam over E A, in units of gamma^2."""
    hub = abs(beam.delta)
    if beam.blade is None:
        moment = 0.5 + hub + beam.alpha * (beam.beta + hub)
        return moment + sum(mass.alpha * (mass.beta + hub) for mass in beam.masses)
    ends, _, means, masses = unstretched_positions(beam)
    spans = properties_of_spans(beam.blade, ends, "bending")
    bodies = [(beam.alpha, beam.beta), *((mass.alpha, mass.beta) for mass in beam.masses)]
    greatest, moment = 0.0, 0.0
    for k in range(len(spans) - 1, -1, -1):  # from the tip
        start, stop = ends[k], ends[k + 1]
        moment += masses[k] * (means[k] + hub)
        moment += sum(
            alpha * (beta + hub)
            for alpha, beta in bodies
            if start + AT_END < beta <= stop + AT_END and alpha
        )
        greatest = max(greatest, moment / spans[k].least_axial)
    return greatest
