"""A beam pulled aside: the force across it that holds a point at a given deflection."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.checks import check_float, check_positive
from beamviz.dynamics.case import Case
from beamviz.dynamics.equation import Equation
from beamviz.dynamics.meshes import first_mesh, refined
from beamviz.dynamics.run import equation_of, start_solution
from beamviz.dynamics.start import NEWTON_STEPS, SMALLEST, equilibrium
from beamviz.errors import NotConverged

LARGEST_STEP = 1.0  # change of an unknown in one step of Newton's method
CONVERGED = 1e-9


class PulledBeam(NamedTuple):
    """force: across the unloaded beam [E I / L^2]; q: the unknowns (n,) of an equation."""

    force: float
    equation: Equation
    q: NDArray

    def position(self, x: NDArray) -> NDArray:
        """Position (len(x), 2) of the points x from the clamp."""
        (r,) = self.equation.unknowns.positions(self.q[None], x)
        return np.stack((r.real, r.imag), axis=1)


def pulled(beam: Beam, deflection: float, at: float = 1.0, **options: Any) -> PulledBeam:
    """The equilibrium of a beam of which the point `at` is held at a deflection [L] in the plane of
    rotation. options: strain, curvature and state as in `solve`. Raises InvalidInput, NoEquilibrium
    where there is none without a force, and NotConverged."""
    deflection = check_float("deflection", deflection)
    check_positive("at", at)  # the root does not move
    equation, q = at_rest(beam, at, tuple(sorted(options.items())))
    start, force = place(equation, q, at), 0.0
    reached, step = 0.0, 1.0
    while reached < 1:
        step = min(step, 1 - reached)
        target = start + (reached + step) * (deflection - start)
        found = held_at(equation, q, force, beam.gamma, at, target)
        if found is None:
            step /= 2
            if step < SMALLEST:
                raise NotConverged(
                    f"the beam was pulled aside by {start + reached * (deflection - start):.3g} L"
                    f" only, not by {deflection:.3g} L; pull it less"
                )
            continue
        (q, force), reached, step = found, reached + step, 1.5 * step
    return PulledBeam(force, equation, q)


@lru_cache(maxsize=8)
def at_rest(
    beam: Beam, at: float, options: tuple[tuple[str, Any], ...]
) -> tuple[Equation, NDArray]:
    """The equation of motion of a beam with a force at a point, and its equilibrium q (n,). It is
    kept, as a visitor who pulls a beam asks for one deflection after the other."""
    case = Case.of(beam=beam, until=1.0, release_at=at, **dict(options))
    elements = refined(first_mesh(beam, beam.gamma))
    equation = equation_of(case, elements, bool(beam.alpha))
    return equation, equilibrium(equation, start_solution(case))


def place(equation: Equation, q: NDArray, at: float) -> float:
    """The deflection of a point."""
    return float(equation.unknowns.positions(q[None], at)[0, 0].imag)


def held_at(
    equation: Equation, q: NDArray, force: float, gamma: float, at: float, target: float
) -> tuple[NDArray, float] | None:
    """q (n,) and the force with which the deflection y(q) is the target, by Newton's method; None
    where that does not converge:

        R(q) - force dy/dq = 0,    y(q) = target.
    """
    none, n = np.zeros((1, len(q))), len(q)
    J = np.zeros((n + 1, n + 1))
    try:
        for _ in range(2 * NEWTON_STEPS):
            equation.force = 1j * force
            R, K, _ = equation.balance(gamma, q)
            dy = equation.unknowns.state(q[None], none, none).derivatives().r_q[-1].imag
            J[:n, :n], J[:n, n], J[n, :n] = K, -dy, dy
            step = np.linalg.solve(J, np.append(R, place(equation, q, at) - target))
            q, force = q - step[:n], force - float(step[n])
            size = float(np.abs(step[:n]).max())
            if not size < LARGEST_STEP:
                return None
            if size < CONVERGED:
                return q, force
        return None
    finally:
        equation.force = 0.0
