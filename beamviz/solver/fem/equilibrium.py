"""Equilibria of the planar beam: the straight one under growing load, or a bent one nearby.

The straight state is the paper's (eq. 40). An inward beam (delta < 0) buckles out of it, and then
the full tangent finds the bent state that is stable.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.solver.continuation import Root, continue_load, newton
from beamviz.solver.fem import ancf, assembly
from beamviz.solver.fem.hermite import coordinates
from beamviz.solver.fem.inertia import lever_arm
from beamviz.solver.fem.planar import CLAMPED, Model, across, along, modes

CARRIED = 0.5  # the share of the force at the end of a law that must really be in the beam
LAW_END = 0.1  # in stretch: a limit this close to the end of a force law is put down to it
MAX_STEP = 0.2  # of a coordinate in one bent Newton step: positions in L, slopes in radians
BENT_ITERATIONS = 200
SHIFTS = (0.0, *(4.0**k for k in range(30)))


@dataclass(frozen=True)
class Equilibrium:
    """q where the residual vanishes, whether its tangent is positive definite, and the work."""

    q: NDArray
    stable: bool
    iterations: int
    steps: int


def straight_equilibrium(model: Model) -> Equilibrium:
    """The straight state, followed by Newton-Raphson from rest to the beam's gamma.

    Its residual across the beam is exactly zero and its tangent couples nothing along to
    anything across, so only the even coordinates move. It may be unstable (delta < 0).
    Raises NoEquilibrium with the limit in gamma, or NotConverged.
    """

    def solve_at(load: float, guess: NDArray) -> Root | None:
        def increment(q: NDArray) -> NDArray:
            dq = np.zeros_like(q)
            L = assembly.cholesky(along(model.tangent(q, load)))
            dq[::2] = -assembly.solve(L, model.residual(q, load)[::2])
            return dq

        root = newton(increment, guess)
        return root if root is not None and straight_margin(model, load, root.state) > 0 else None

    def margin(load: float, q: NDArray) -> float:
        return straight_margin(model, load, q)

    load = model.beam.gamma**2
    path = continue_load(solve_at, model.unstressed, load, margin)
    if path.limit is not None:
        raise no_equilibrium(model, path.limit, path.state)
    stable = assembly.positive_definite(across(model.tangent(path.state, load)))
    if not stable and model.beam.delta >= 0:
        raise overshoot(model, load, path.state)  # no beam that points outward can buckle
    return Equilibrium(path.state, stable, path.iterations, path.steps)


def straight_margin(model: Model, load: float, q: NDArray) -> float:
    """How far a straight state is from its end: 1 at rest, falling to 0 there.

    The least of the stretch, the slope n' of the force law and the static stiffness of the tip.
    """
    f = model.slopes(q)[:, 0]
    if f.min() <= 0:
        return 0.0
    return min(f.min(), model.material.law.stiffness(f).min(), tip_stiffness(model, load, q))


def tip_stiffness(model: Model, load: float, q: NDArray) -> float:
    """Force along the beam per displacement of the tip, divided by its value EA / L at rest;
    0 where the tangent is not positive definite."""
    unit = np.zeros(len(q) // 2)
    unit[-2] = 1
    try:
        L = assembly.cholesky(along(model.tangent(q, load)))
    except np.linalg.LinAlgError:
        return 0.0
    return 1 / (assembly.solve(L, unit)[-2] * model.beam.mu**2)


def carried(model: Model, load: float, q: NDArray) -> NDArray:
    """Axial force / mu^2 at each node that balances the load outboard of it: (n + 1,).

    It depends on positions only, so it stays right where the stretch of the elements does not.
    """
    arm = lever_arm(coordinates(q), model.beam.delta)
    parts = load * (model.C @ arm[..., None])[..., 0]
    outward = parts[:, 0] + parts[:, 4]
    return np.append(np.cumsum(outward[::-1])[::-1], 0.0) / model.beam.mu**2


def no_equilibrium(model: Model, limit: float, q: NDArray) -> NoEquilibrium | NotConverged:
    """The error that names the limit of a path (a load gamma^2) and what ends there."""
    law, gamma = model.material.law, math.sqrt(limit)
    f, n = model.slopes(q)[:, 0], carried(model, limit, q)
    reason = "the stiffness of the beam along itself falls to zero there"
    ends = ((law.min_stretch, f.min(), n.min()), (law.max_stretch, f.max(), n.max()))
    for end, f_reached, n_carried in ends:
        if abs(f_reached - end) >= LAW_END:
            continue
        if abs(n_carried) >= CARRIED * abs(law.force(f_reached)):
            reason = f"the {law.name} force law ends there, at a stretch of {end:.4g}"
        elif straight_margin(model, limit, q) < tip_stiffness(model, limit, q):
            return overshoot(model, limit, q)
    return NoEquilibrium(f"no equilibrium beyond gamma = {gamma:.9g}: {reason}", gamma)


def overshoot(model: Model, load: float, q: NDArray) -> NotConverged:
    """The error for a stretch that the elements have and the beam has not."""
    f = model.slopes(q)[:, 0]
    return NotConverged(
        f"at gamma = {math.sqrt(load):.6g} the stretch of the elements ranges over"
        f" {f.min():.3g} .. {f.max():.3g}, more than the force in the beam can do: neighbours share"
        " one gradient at the mass, where the stretch jumps. This is a limit of the method, not of"
        " the beam: method auto has none"
    )


def leaning(model: Model, q: NDArray, angle: float) -> NDArray:
    """A straight state q pushed along its lowest bending mode, its tip turned by `angle` [rad]:
    a start for `bent_equilibrium` that picks the side."""
    _, shapes = modes(model, q, len(q))
    bending = shapes[:, np.any(shapes[1::2], axis=0)][:, 0]
    return q + angle / bending[-1] * bending


def bent_equilibrium(model: Model, start: NDArray) -> Equilibrium:
    """A stable state near `start`, bent or straight, by Newton-Raphson on the full tangent.

    Its prestress is iterated beside q, each from the linearised other (mixed integration
    points; Magisano, Leonetti & Garcea 2017): a slender beam then turns in steps of MAX_STEP
    instead of 1 / mu. Where the tangent is not positive definite a multiple of M is added, which
    turns the step downhill. Raises NotConverged.
    """
    load = model.beam.gamma**2
    law, size = model.material.law, len(start)
    M = assembly.held(model.mass, CLAMPED)

    def increment(state: NDArray) -> NDArray:
        q, e = state[:size], state[size:].reshape(model.elements.weights.shape)
        L = shifted_factor(model.tangent(q, load, e), M)
        dq = -assembly.solve(L, model.residual(q, load))
        s, ds = (ancf.strain_state(model.elements, coordinates(v)) for v in (q, dq))
        f = ancf.stretch(s)
        df = np.sum(s[..., :2] * ds[..., :2], axis=-1) / f
        de = law.strain(f) + law.first(f) * df - e
        return min(1.0, MAX_STEP / np.abs(dq).max()) * np.concatenate((dq, de.ravel()))

    e = law.strain(ancf.stretch(ancf.strain_state(model.elements, coordinates(start))))
    root = newton(increment, np.concatenate((start, e.ravel())), BENT_ITERATIONS)
    if root is None or not admissible(model, load, root.state[:size]):
        raise NotConverged(
            f"no stable bent state was found at gamma = {model.beam.gamma:.6g} from this start:"
            " one closer to it may help, as may elements neither longer than the bend nor shorter"
            " than the beam is thick"
        )
    return Equilibrium(root.state[:size], True, root.iterations, 1)


def admissible(model: Model, load: float, q: NDArray) -> bool:
    """Whether a state is stable and not folded: r' turns by less than 90 degrees from one
    Gauss point to the next, and leaves the clamp forward."""
    slopes = model.slopes(q)
    forward = slopes[0, 0] > 0 and np.all(np.sum(slopes[1:] * slopes[:-1], axis=1) > 0)
    return bool(forward) and assembly.positive_definite(model.tangent(q, load))


def shifted_factor(K: NDArray, M: NDArray) -> NDArray:
    """The Cholesky factor of K + shift M (lower bands), for the least of SHIFTS that has one."""
    for shift in SHIFTS:
        try:
            return assembly.cholesky(K + shift * M)
        except np.linalg.LinAlgError:
            continue
    raise np.linalg.LinAlgError(f"no shift up to {SHIFTS[-1]:.3g} makes K positive definite")
