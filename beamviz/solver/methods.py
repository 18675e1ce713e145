"""Every method, as a row of one table."""

from functools import partial

from beamviz.errors import InvalidInput
from beamviz.solver.hp.fields import hp_solution
from beamviz.solver.problem import CORIOLIS, ELEMENTS, SWITCHES, TERMS, Method, Task
from beamviz.solver.solution import Solution

# What `auto` does without is loaded when it is asked for: a command starts sooner.


def _split_elements(task: Task) -> Solution:
    from beamviz.solver.fem import elements
    from beamviz.solver.fem import solution as element_solution

    return element_solution.element_solution(elements.split, task)


def _planar_elements(task: Task) -> Solution:
    from beamviz.solver.fem import elements
    from beamviz.solver.fem import solution as element_solution

    return element_solution.element_solution(elements.full, task)


def _linear_elements(task: Task) -> Solution:
    from beamviz.solver.fem import elements
    from beamviz.solver.fem import solution as element_solution

    return element_solution.element_solution(elements.linear, task, tension="reference")


def _assumed_modes(task: Task) -> Solution:
    from beamviz.solver.series import solution as series_solution

    return series_solution.assumed_modes_solution(task)


def _power_series(task: Task) -> Solution:
    from beamviz.solver.series import solution as series_solution

    return series_solution.power_series_solution(task)


def _chebyshev(task: Task) -> Solution:
    from beamviz.solver.series import solution as series_solution

    return series_solution.chebyshev_solution(task)


METHODS = {
    row.name: row
    for row in (
        Method(
            "auto",
            "this program: high-order elements in gradient and curvature, split at the mass",
            "always, unless another method is what you study: fastest to any accuracy",
            hp_solution,
            refuses=(ELEMENTS, TERMS),
        ),
        Method(
            "ancf",
            "the paper's cubic elements (2017), stretching and bending solved apart",
            "to see the paper's own numbers; 20 elements are the paper's",
            _split_elements,
            refuses=(TERMS, SWITCHES),
        ),
        Method(
            "ancf-planar",
            "the paper's cubic elements through the full planar tangent (eqs. 40-48)",
            "to check ancf: the same answer with all unknowns at once",
            _planar_elements,
            refuses=(TERMS, SWITCHES),
        ),
        Method(
            "linear",
            "linear finite elements with prestress and spin softening, as general codes do it",
            "to see what a linear prestressed analysis says; its limit is foac's",
            _linear_elements,
            refuses=(TERMS, SWITCHES),
        ),
        Method(
            "foac",
            "first-order coupling: tension of the rigid reference length (Hong et al.; Yoo & Shin)",
            "to see the classical model of slender rotating beams, right while f is near 1",
            partial(hp_solution, tension="reference"),
            refuses=(ELEMENTS, TERMS),
        ),
        Method(
            "zoac",
            "no coupling: the linear model without stiffening, the paradox of Kane et al. (1987)",
            "to see it fail: it falsely loses stability at gamma = 3.516",
            partial(hp_solution, tension="reference", stiffening=False),
            refuses=(ELEMENTS, TERMS),
        ),
        Method(
            "assumed-modes",
            "modes of the beam at rest as a basis, rigid tension (Yoo & Shin 1998)",
            "to see how the classical papers computed: few terms, 3 to 6 digits at low speed",
            _assumed_modes,
            refuses=(ELEMENTS, SWITCHES),
        ),
        Method(
            "power-series",
            "Frobenius series from the clamp, rigid tension (Wright et al. 1982)",
            "to check foac at low speed: exact there, without a digit left at high speed",
            _power_series,
            refuses=(ELEMENTS, CORIOLIS, SWITCHES),
        ),
        Method(
            "chebyshev",
            "Chebyshev collocation of the differential equations (El-Gendi 1969; Greengard 1991)",
            "to check auto by other equations; wasteful where layers are thin",
            _chebyshev,
            refuses=(ELEMENTS, CORIOLIS, SWITCHES),
        ),
    )
}


def check(task: Task) -> None:
    """InvalidInput where the task asks for what its method does not treat."""
    for feature in METHODS[task.model.method].refuses:
        if feature.asked(task):
            able = [row.name for row in METHODS.values() if feature not in row.refuses]
            raise InvalidInput(
                f"{feature.value(task)}: method {task.model.method} takes no {feature.noun};"
                f" methods that do: {', '.join(able)}"
            )
