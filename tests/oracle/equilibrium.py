"""Equilibrium of the straight beam and a mesh that resolves it, for the oracle."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.integrate import OdeSolution, solve_ivp
from scipy.special import lambertw

from beamviz.beam import Beam
from beamviz.solver.constitutive import STRAIN_LAWS
from oracle import properties
from oracle.collocation import Mesh, refined_mesh
from oracle.eigen import UnresolvedError, factorised

LONGEST = 0.15  # element
WAVES = 2.0  # local lengths of a compressed beam in an element, in units of Resolution.layers
Piece = tuple[float, float, OdeSolution]  # from, to, (X, N, ..)(x)


class NoStateError(Exception):
    """No equilibrium on the branch that starts at rest."""


@dataclass(frozen=True)
class Resolution:
    """p Chebyshev points in each element; an element is at most `ratio` times as long as its
    distance to the nearest special point, or `layers` local lengths, whichever is more."""

    points: int
    ratio: float
    layers: float


@dataclass(frozen=True)
class Law:
    """n(f), n'(f) and f(n) of a strain law: nan beyond the end of the branch that starts at rest.
    hardens: whether n' grows in tension."""

    force: Callable
    stiffness: Callable
    stretch: Callable
    hardens: bool


def _green_stretch(n: np.ndarray) -> np.ndarray:
    z = 3 * np.sqrt(3) * n  # f^3 - f = 2 n by Viete's formulas
    z = np.where(z > -1, z, np.nan)
    angle = np.arccos(np.clip(z, -1, 1)) / 3
    f = 2 / np.sqrt(3) * np.where(z < 1, np.cos(angle), np.cosh(np.arccosh(np.maximum(z, 1)) / 3))
    return f - ((f * f - 1) * f / 2 - n) / ((3 * f * f - 1) / 2)  # one step of Newton's


CIRCLE = np.exp(2j * np.pi * np.arange(24) / 24)
RADIUS = 0.25  # of the circle about f on which the strain is evaluated, over f


def derivatives(strain: Callable, f: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """e, e' and e'' at f by Cauchy's integrals about it: to rounding for an analytic strain whose
    nearest singularity is at 0."""
    f = np.asarray(f, float)
    r = RADIUS * f
    values = strain(f[..., None] + r[..., None] * CIRCLE)
    first, second = (
        (values * CIRCLE**-order).mean(axis=-1).real * factor / r**order
        for order, factor in ((1, 1), (2, 2))
    )
    return strain(f + 0j).real, first, second


def law_of_energy(strain: Callable) -> Law:
    """The law of the energy mu^2 e(f)^2 / 2: n = e e', n' = e'^2 + e e'', and f(n) on the branch
    through f = 1 on which n grows."""

    def force(f: np.ndarray) -> np.ndarray:
        e, slope, _ = derivatives(strain, f)
        return e * slope

    def stiffness(f: np.ndarray) -> np.ndarray:
        e, slope, bend = derivatives(strain, f)
        return slope**2 + e * bend

    f = np.geomspace(1e-3, 1e3, 6001)  # 1 is in the middle
    grows = stiffness(f) > 0
    middle = len(f) // 2
    above, below = np.flatnonzero(~grows[middle:]), np.flatnonzero(~grows[:middle])
    last = middle + above[0] if len(above) else len(f)
    branch = f[(below[-1] + 1 if len(below) else 0) : last]
    forces = force(branch)

    def stretch(n: np.ndarray) -> np.ndarray:
        n = np.asarray(n, float)
        f = np.exp(np.interp(n, forces, np.log(branch)))
        for _ in range(5):  # of Newton's method
            f = np.clip(f - (force(f) - n) / stiffness(f), branch[0], branch[-1])
        return np.where((forces[0] <= n) & (n <= forces[-1]), f, np.nan)

    hardens = bool((np.diff(stiffness(np.geomspace(1, 100, 50))) > 1e-9).all())
    return Law(force, stiffness, stretch, hardens)


BY_HAND = {
    "green": Law(
        force=lambda f: (f * f - 1) * f / 2,
        stiffness=lambda f: (3 * f * f - 1) / 2,
        stretch=_green_stretch,  # down to 1 / sqrt(3)
        hardens=True,
    ),
    "biot": Law(
        force=lambda f: f - 1,
        stiffness=lambda f: 1 + 0 * f,
        stretch=lambda n: 1 + n,  # ends at f = 0, which `shoot` watches: the line may be extended
        hardens=False,
    ),
    "hencky": Law(
        force=lambda f: np.log(f) / f,
        stiffness=lambda f: (1 - np.log(f)) / (f * f),
        stretch=lambda n: np.where(n < np.exp(-1), np.exp(-lambertw(-n).real), np.nan),
        hardens=False,
    ),
}
# Of a law without formulas by hand, those that follow from its energy.
LAWS = {name: BY_HAND.get(name) or law_of_energy(law.strain) for name, law in STRAIN_LAWS.items()}


def stretch(strain: str, n: np.ndarray) -> np.ndarray:
    """f from n(f)."""
    return LAWS[strain].stretch(n)


@lru_cache(maxsize=1)
def shoot(beam: Beam, strain: str) -> tuple[Piece, ...]:
    """A first equilibrium: from the tip inward, with the tip's place by Newton's method."""
    ends = properties.ends(beam)[::-1]

    def slope(x, y, right):  # X, N and their derivatives with respect to the tip's place
        rho, axial = (properties.at(beam, name, x, x == right) for name in ("mass", "axial"))
        f = stretch(strain, y[1] / (beam.mu**2 * axial))
        if np.isnan(f):
            raise NoStateError(f"{beam.numbers}: no stretch bears a force of {y[1]:g}")
        stiffness = beam.mu**2 * axial * LAWS[strain].stiffness(f)
        load = beam.gamma**2 * rho
        return [f, -load * y[0], y[3] / stiffness, -load * y[2]]

    def march(tip: float) -> tuple[Piece, ...]:
        y, pieces = np.array([tip, 0.0, 1.0, 0.0]), []
        for right, left in pairwise(ends):
            for body in beam.bodies:
                if right == body.beta:
                    y[[1, 3]] += body.alpha * beam.gamma**2 * y[[0, 2]]
            run = solve_ivp(
                slope,
                (right, left),
                y,
                "DOP853",
                rtol=1e-8,
                atol=1e-11,
                dense_output=True,
                args=(right,),
            )
            if not (run.success and np.all(run.y[2] > 0)):
                raise NoStateError(f"{beam.numbers}: none with its tip at {tip:g}")
            y = run.y[:, -1].copy()
            pieces.append((left, right, run.sol))
        return tuple(pieces[::-1])

    pieces = newton_tip(march, beam, strain)
    x = np.array([np.linspace(left, right, 99) for left, right, _ in pieces])
    last = np.arange(99) == 98
    forces = np.array([run(row)[1] for row, (_, _, run) in zip(x, pieces, strict=True)])
    axial = properties.at(beam, "axial", x, last)
    if not np.all(stretch(strain, forces / (beam.mu**2 * axial)) > 0):
        raise NoStateError(f"{beam.numbers}: compressed to nothing")
    return pieces


def newton_tip(march: Callable, beam: Beam, strain: str) -> tuple[Piece, ...]:
    """Newton's method from the side where it is monotonic.

    The clamp's place is a convex function of the tip's for green (hardening), linear for biot,
    concave for hencky (softening), wherever it grows with the tip's: where the state is stable.
    """
    tip = 1 + beam.delta
    if LAWS[strain].hardens:  # beyond the equilibrium
        tip = first_tip(march, max(tip, 0.1) * 1.5 ** np.arange(50), beam.delta)
    elif beam.delta < 0:  # it softens: stiffer in compression
        tip = first_tip(march, tip - np.array([0.0, *(0.1 * 2.0 ** np.arange(8))]), -np.inf)
    for _ in range(100):
        pieces = march(tip)
        clamp, _, derivative, _ = pieces[0][2](0.0)
        step = (beam.delta - clamp) / derivative
        if abs(step) < 1e-6 * max(1.0, abs(tip)):
            return pieces
        tip += step
    raise UnresolvedError(f"{beam.numbers}: no equilibrium by shooting")


def first_tip(march: Callable, tips: np.ndarray, least: float) -> float:
    """The first place of the tip with a stable state whose clamp is at `least` or further out."""
    for tip in tips:
        try:
            if march(tip)[0][2](0.0)[0] >= least:
                return float(tip)
        except NoStateError:
            pass
    raise NoStateError(f"none with its tip at {tips[0]:g} .. {tips[-1]:g}")


def resolving_mesh(
    beam: Beam,
    strain: str,
    c: int,
    level: Resolution,
    pieces: tuple[Piece, ...],
    bending: str = "bending",
) -> Mesh:
    """Elements halved until they resolve the local lengths of a first equilibrium."""

    def longest(x: float, h: float, distance: float) -> float:
        (solution,) = (run for left, right, run in pieces if left <= x + h / 2 <= right)
        inside = x + h * np.linspace(1e-9, 1 - 1e-9, 9)
        state = solution(inside)
        waves, change = properties.reduced(beam, inside, bending)
        lengths = local_length(state, beam, strain, c, inside, bending)
        shortest = level.layers * np.min(lengths)
        most = (
            LONGEST * min(1.0, waves) if np.min(state[1]) > -1 else min(LONGEST, WAVES * shortest)
        )
        return min(most, level.layers * change, max(level.ratio * distance, shortest))

    ends = [0.0] + [right for _, right, _ in pieces]
    return refined_mesh(ends, beam, level.points, longest)


def local_length(
    state: np.ndarray, beam: Beam, strain: str, c: int, x: np.ndarray, bending: str
) -> np.ndarray:
    """The shorter of the bending layer sqrt(EI / (N f^(1 + 2c))) and the stretch's f / |f'|, at x.

    In compression that layer is a wave, of the same length over 2 pi, and all along the beam.
    """
    X, N = state[:2]
    rho, axial, EI = (properties.at(beam, name, x) for name in ("mass", "axial", bending))
    f = stretch(strain, N / (beam.mu**2 * axial))
    layer = 1 / np.sqrt(abs(N) * f ** (1 + 2 * c) / EI + 1)
    stiffness = beam.mu**2 * axial * LAWS[strain].stiffness(f)
    growth = f * stiffness / (beam.gamma**2 * rho * abs(X) + 1e-30)
    return np.minimum(layer, growth)


def equilibrium(mesh: Mesh, beam: Beam, strain: str, pieces: tuple[Piece, ...]) -> np.ndarray:
    """All X and N (n,), by Newton's method on the collocated equations."""
    x = np.append(np.column_stack([mesh.lefts, mesh.x]), 1.0)
    y = np.empty((len(x), 2))  # X, N
    for left, right, solution in pieces:
        here = (x >= left) & (x <= right)
        y[here] = solution(x[here])[:2].T
    y[-1, 1] = 0.0
    y = y.ravel()
    load = mesh.mass(2, {(1, 0): -(beam.gamma**2)})
    linear = mesh.differences(2) - load
    stretching = mesh.integral(2, {(0, 0): np.ones_like(mesh.x)})
    clamp = np.zeros_like(y)
    clamp[0] = beam.delta
    axial = beam.mu**2 * properties.at(beam, "axial", mesh.x)
    for _ in range(10):
        f = stretch(strain, mesh.at_points(y, 2)[..., 1] / axial)
        rate = np.zeros_like(y)
        mesh.at_points(rate, 2)[..., 0] = f
        residual = linear @ y - stretching @ rate - clamp
        compliance = 1 / (axial * LAWS[strain].stiffness(f))
        step = factorised(linear - mesh.integral(2, {(0, 1): compliance}))(residual)
        y = y - step
        if np.all(np.abs(step).reshape(-1, 2) <= 1e-12 * np.max(np.abs(y.reshape(-1, 2)), axis=0)):
            return y
    raise UnresolvedError(f"{beam.numbers}: the equilibrium does not settle")
