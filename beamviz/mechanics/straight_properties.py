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
from beamviz.space.grid import Mesh, inertia_of
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


# 7 % of a solve where only other numbers of the beam change; two as it may bend in both planes.
@lru_cache(maxsize=2)
def shared_properties(
    mesh: Mesh, alpha: tuple[float, ...], beta: tuple[float, ...], blade: Blade | None
) -> Properties:
    """The properties of beams with the same bodies."""
    return properties_of(mesh, np.array([alpha]), np.array([beta]), blade)


def properties_of(mesh: Mesh, alpha: NDArray, beta: NDArray, blade: Blade | None) -> Properties:
    """The properties with bodies of masses alpha at beta, each (1 or beams, bodies)."""
    points, weights = mesh.grid.points[..., None, :], mesh.grid.weights
    to_bodies = np.where(points < beta[..., None], weights[..., None, :], 0.0)
    carried = alpha[..., None] * to_bodies
    weights = np.atleast_2d(weights)
    if blade is None:
        mass, axial, (G, G1, g) = weights, weights, mesh.inertia
    else:
        x = np.atleast_2d(mesh.grid.points)
        mass, axial = weights * blade.at("mass", x), weights * blade.at("axial", x)
        G, G1, g = inertia_of(mesh, mass)
    g = g + carried.sum(axis=-2)
    at_ends = (g[..., None, :], 1.0 + (alpha * (beta > 0)).sum(axis=-1, keepdims=True))
    if blade is not None:
        at_ends = properties_at_ends(mesh, mass, g, (alpha, beta), blade)
    return Properties(
        axial=axial,
        mass=mass,
        G=G + carried.mT @ to_bodies,
        G1=G1 + np.vecmat(beta, carried),
        g=g,
        to_bodies=to_bodies,
        alpha=alpha,
        to_ends=at_ends[0],
        total=at_ends[1],
    )


def properties_at_ends(
    mesh: Mesh, mass: NDArray, g: NDArray, bodies: tuple[NDArray, NDArray], blade: Blade
) -> tuple[NDArray, NDArray]:
    """`to_ends` and `total` of a blade at the start of each piece, then at the end of each, with
    the bodies (alpha, beta) there outboard of the latter. What is integrated inboard of an end
    moves all mass outboard of it."""
    breaks = np.atleast_2d(mesh.grid.breaks)
    points, weights = (np.atleast_2d(row)[:, None] for row in (mesh.grid.points, mesh.grid.weights))
    starts, ends = breaks[:, :-1], breaks[:, 1:]
    at = np.concatenate((starts, ends), axis=-1)[..., None]  # (1 or beams, ends, 1)
    axial = np.concatenate((blade.at("axial", starts), blade.at("axial", ends, True)), axis=-1)
    alpha, beta = (row[..., None, :] for row in bodies)
    beyond = np.concatenate((beta > starts[..., None], beta >= ends[..., None]), axis=-2)
    total = ((points > at) * mass[..., None, :]).sum(axis=-1) + (beyond * alpha).sum(axis=-1)
    moments = np.where(points < at, weights * total[..., None], g[..., None, :])
    return moments / axial[..., None], total / axial
