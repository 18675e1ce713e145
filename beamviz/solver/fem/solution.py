"""Solutions on uniform cubic elements."""

import time
from functools import partial

from beamviz.beam import Beam
from beamviz.solver.fem import elements
from beamviz.solver.hp.refinement import errors_against_reference
from beamviz.solver.problem import Problem
from beamviz.solver.solution import Equilibrium, Solution, Stats

ASSEMBLE = {
    "ancf": elements.split,
    "ancf-planar": elements.full,
    "linear": elements.linear,
}


def solve(beam: Beam, problem: Problem, start: float) -> Solution:
    """Equilibrium and modes of a beam on `problem.elements` elements; `start` is the clock
    (time.perf_counter) at the call."""
    assemble = ASSEMBLE[problem.method]
    found = elements.solve_elements(beam, problem.modes, problem, assemble, problem.elements)
    assembled = found.assembled
    return Solution(
        beam=beam,
        problem=problem,
        equilibrium=Equilibrium(
            found.omega_squared[0] >= 0, assembled.iterations, partial(elements.axial, found)
        ),
        stats=Stats(
            len(assembled.Ka) + len(assembled.Kb),
            time.perf_counter() - start,
            problem.method,
            len(assembled.nodes) - 1,
            3,
        ),
        omega_squared=found.omega_squared,
        estimate_errors=partial(
            errors_against_reference,
            beam,
            problem,
            found.omega_squared,
            found.bending_energy_fraction,
        ),
        bending_energy_fraction=found.bending_energy_fraction,
        fields=partial(elements.displacement, found),
    )
