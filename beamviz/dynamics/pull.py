"""A beam pulled aside: the force across it that holds a point at a given deflection."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.dynamics.case import Case
from beamviz.dynamics.elements import PositionElements
from beamviz.dynamics.equation import Equation
from beamviz.dynamics.meshes import first_mesh, refined
from beamviz.dynamics.run import equation_of, start_solution
from beamviz.dynamics.start import CONVERGED, NEWTON_STEPS, SMALLEST, across, equilibrium
from beamviz.errors import NotConverged

LARGEST_STEP = 0.5  # change of q in one step of Newton's method [L]


class PulledBeam(NamedTuple):
    """force: across the beam [E I / L^2]; q: (n,) its positions on the elements."""

    force: float
    elements: PositionElements
    q: NDArray

    def position(self, x: NDArray) -> NDArray:
        """Position (len(x), 2) of the points x from the clamp."""
        full = np.zeros(2 * self.elements.count)
        full[self.elements.free] = self.q
        return self.elements.at(x) @ full.reshape(2, -1).T


def pulled(beam: Beam, deflection: float, at: float = 1.0, **options: Any) -> PulledBeam:
    """The equilibrium of a beam of which the point `at` is held at a deflection [L] in the plane of
    rotation. options: strain, curvature and state as in `solve`. Raises InvalidInput, NoEquilibrium
    where there is none without a force, and NotConverged."""
    equation, q = at_rest(beam, tuple(sorted(options.items())))
    load = across(equation, at)
    start, force = float(load @ q), 0.0
    reached, step = 0.0, 1.0
    while reached < 1:
        step = min(step, 1 - reached)
        target = start + (reached + step) * (deflection - start)
        found = held_at(equation, q, force, beam.gamma, load, target)
        if found is None:
            step /= 2
            if step < SMALLEST:
                raise NotConverged(
                    f"the beam was pulled aside by {start + reached * (deflection - start):.3g} L"
                    f" only, not by {deflection:.3g} L; pull it less"
                )
            continue
        (q, force), reached, step = found, reached + step, 1.5 * step
    return PulledBeam(force, equation.elements, q)


@lru_cache(maxsize=8)
def at_rest(beam: Beam, options: tuple[tuple[str, Any], ...]) -> tuple[Equation, NDArray]:
    """The equation of motion of a beam, and its equilibrium q (n,)."""
    case = Case.of(beam=beam, until=1.0, **dict(options))
    elements = refined(first_mesh(beam, beam.gamma))
    equation = equation_of(case, elements, bool(beam.alpha), None)
    return equation, equilibrium(equation, start_solution(case))


def held_at(
    equation: Equation, q: NDArray, force: float, gamma: float, load: NDArray, target: float
) -> tuple[NDArray, float] | None:
    """q (n,) and the force with load @ q = target, by Newton's method; None where that does not
    converge:

        R(q) - force load = 0,    load q = target.
    """
    speed, still, n = np.array([gamma]), np.zeros((1, equation.size)), equation.size
    K = np.zeros((n + 1, n + 1))
    K[:n, n], K[n, :n] = -load, load
    for _ in range(2 * NEWTON_STEPS):
        R = equation.forces(speed, 0 * speed, q[None], still)[0] - force * load
        K[:n, :n] = equation.stiffness(speed, 0 * speed, q[None])[0]
        step = np.linalg.solve(K, np.append(R, load @ q - target))
        q, force = q - step[:n], force - float(step[n])
        size = float(np.abs(step[:n]).max())
        if not size < LARGEST_STEP:
            return None
        if size < 100 * CONVERGED:
            return q, force
    return None
