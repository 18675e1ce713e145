"""Mass and stiffness of straight beams on a mesh.

rho A, E I and E A are relative to those of the root section. A body on the beam has a mass alpha
and principal moments of inertia; those turn with the section that carries it.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.blade import Blade, Mass
from beamviz.space.grid import Mesh
from beamviz.space.spans import AnyBeam, numbers_of


class BeamStack(NamedTuple):
    """The parameters of a stack of beams with the same blade, masses and root: each (beams, 1), and
    those of all bodies (beams, bodies), or (1, bodies) where all beams have the same."""

    alpha: NDArray
    beta: NDArray
    gamma: NDArray
    delta: NDArray
    mu: NDArray
    rotating: bool  # whether all have a speed
    inward: bool  # whether any points inward
    blade: Blade | None
    masses: tuple[Mass, ...]  # the bodies but the first, which may have no mass
    root: float

    @property
    def hinged(self) -> bool:
        """Whether the angle at the root is free, or held by a spring."""
        return self.root < np.inf

    @property
    def has_inertia(self) -> bool:
        """Whether a body has rotary inertia."""
        return any(any(mass.inertia) for mass in self.masses)


def stack_of(beams: Sequence[AnyBeam]) -> BeamStack:
    """The parameters of some beams."""
    alpha, beta, gamma, delta, mu = np.array([numbers_of(beam) for beam in beams]).T[..., None]
    if len({(beam.alpha, beam.beta) for beam in beams}) == 1:
        alpha, beta = alpha[:1], beta[:1]
    rotating = all(beam.gamma for beam in beams)
    inward = any(beam.delta < 0 for beam in beams)
    masses = beams[0].masses
    if masses:
        more = np.array([(mass.alpha, mass.beta) for mass in masses]).T
        alpha, beta = (
            np.hstack((column, np.tile(row, (len(column), 1))))
            for column, row in zip((alpha, beta), more, strict=True)
        )
    blade, root = beams[0].blade, beams[0].root
    return BeamStack(alpha, beta, gamma, delta, mu, rotating, inward, blade, masses, root)


class Properties(NamedTuple):
    """Mass and stiffness of a stack of beams on a mesh. The line density is rho(x) with a Dirac
    function alpha at each body; its inertia is in terms of the gradient of the displacement. The
    leading axis is 1 where all beams share the array."""

    bending: NDArray  # (1 or beams, n) weights of the mesh times E I in the plane of rotation
    flap: NDArray  # (1 or beams, n) and out of it
    axial: NDArray  # (1 or beams, n) weights times E A
    mass: NDArray  # (1 or beams, n) weights times rho, without the bodies
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
    if len(beams.alpha) == 1 and mesh.is_small:
        alpha, beta = tuple(beams.alpha[0].tolist()), tuple(beams.beta[0].tolist())
        return shared_properties(mesh, alpha, beta, beams.blade)
    return properties_of(mesh, beams.alpha, beams.beta, beams.blade)


# 7 % of a solve where only other numbers of the beam change.
@lru_cache(maxsize=1)
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
        G, G1, g = mesh.inertia
        g = g + moment
        return Properties(
            bending=weights,
            flap=weights,
            axial=weights,
            mass=weights,
            G=G + carried.mT @ to_bodies,
            G1=G1 + np.vecmat(beta, carried),
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
        mass=mass,
        G=G,
        G1=G.sum(axis=-1),
        g=np.vecmat(mass, mesh.J) + moment,
        to_bodies=to_bodies,
        alpha=alpha,
        to_ends=(distributed @ mesh.J + concentrated @ to_bodies) / axial[..., None],
        total=total / axial,
    )
