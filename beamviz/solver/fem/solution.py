"""Solutions on uniform cubic elements."""

import time
from functools import partial

from beamviz.solver.error_estimates import differences
from beamviz.solver.fem import elements
from beamviz.solver.physics import Tension
from beamviz.solver.problem import Task
from beamviz.solver.solution import Equilibrium, Solution, Stats, status


def element_solution(
    assemble: elements.Assemble, task: Task, tension: Tension = "equilibrium"
) -> Solution:
    """The scene on as many elements as the task names."""
    physics = task.physics._replace(tension=tension)
    found = elements.solve_elements(task.beam, task.modes, physics, assemble, task.elements)
    assembled = found.assembled
    return Solution(
        beam=task.beam,
        model=task.model,
        equilibrium=Equilibrium(
            status(found.squares), assembled.iterations, partial(elements.axial, found)
        ),
        stats=Stats(
            len(assembled.Ka) + len(assembled.Kb),
            time.perf_counter() - task.start,
            task.model.method,
            len(assembled.nodes) - 1,
            3,
        ),
        squares=found.squares,
        estimate=partial(differences, task.beam, physics, found.squares, found.bending_fractions),
        bending_fractions=found.bending_fractions,
        displacement=partial(elements.displacement, found),
    )
