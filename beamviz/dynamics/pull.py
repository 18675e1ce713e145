"""A beam pulled aside: the force across it that holds a point at a given deflection."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.checks import check_float, check_positive
from beamviz.dynamics.equation import AnyBeam
from beamviz.dynamics.initial_value import beam_of, start_solution
from beamviz.dynamics.meshes import first_mesh, refined
from beamviz.dynamics.problem import MotionProblem
from beamviz.dynamics.start import equilibrium, held_aside


class PulledBeam(NamedTuple):
    """A beam of which a point is held aside."""

    force: float  # across the unloaded beam [E I / L^2]
    beam: AnyBeam
    q: NDArray  # (n,) unknowns

    def position(self, x: NDArray) -> NDArray:
        """Position (len(x), 2) of the points x from the clamp."""
        r = self.beam.state(self.q).positions(x)
        return np.stack((r.real, r.imag), axis=1)


def pulled(beam: Beam, deflection: float, at: float = 1.0, **options: Any) -> PulledBeam:
    """The equilibrium of a beam of which the point `at` is held at a deflection [L] in the plane of
    rotation. options: strain, curvature and state as in `solve`. Raises InvalidInput, NoEquilibrium
    where there is none without a force, and NotConverged."""
    deflection = check_float("deflection", deflection)
    check_positive("at", at)  # the root does not move
    model, q = at_rest(beam, at, tuple(sorted(options.items())))
    q, force = held_aside(model, q, beam.gamma, deflection)
    return PulledBeam(force, model, q)


@lru_cache(maxsize=8)
def at_rest(beam: Beam, at: float, options: tuple[tuple[str, Any], ...]) -> tuple[AnyBeam, NDArray]:
    """A beam with a force at a point, and its equilibrium q (n,) without it. It is kept, as a
    visitor who pulls a beam asks for many deflections in a row."""
    problem = MotionProblem.of(beam=beam, until=1.0, release_at=at, **dict(options))
    model = beam_of(problem, refined(first_mesh(beam, problem.statics)), bool(beam.alpha))
    return model, equilibrium(model, start_solution(problem))
