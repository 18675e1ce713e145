"""The methods that are compared, and the model that each approximates."""

from typing import Any, NamedTuple

from beamviz.solver.problem import CHOICES, Problem, parse_keywords
from beamviz.solver.problem import METHODS as SOLVER_METHODS

REFERENCE = Problem.strain  # the paper's model
RIGID, UNSTIFFENED = "rigid", "unstiffened"

# The options of `solve` for the converged frequencies of each model.
MODELS: dict[str, dict[str, Any]] = {strain: {"strain": strain} for strain in CHOICES["strain"]}
MODELS |= {RIGID: {"method": "foac"}, UNSTIFFENED: {"method": "zoac"}}


class ComparedMethod(NamedTuple):
    """A method of the comparison."""

    name: str
    options: dict[str, Any]  # of `solve`
    model: str  # a key of MODELS
    with_more_terms: dict[str, Any]  # the options for twice as many terms; {} without a series


def method(name: str, **options: Any) -> ComparedMethod:
    """A method at the resolution that `solve` uses by default, which its options name."""
    problem = parse_keywords(**options)
    options |= {key: problem.resolution for key in ("elements", "terms") if has(problem, key)}
    more = options | {"terms": 2 * options["terms"]} if "terms" in options else {}
    if not problem.stiffens:
        return ComparedMethod(name, options, UNSTIFFENED, more)
    return ComparedMethod(name, options, RIGID if problem.rigid_tension else problem.strain, more)


def has(problem: Any, option: str) -> bool:
    """Whether an option is the resolution of the method of a problem."""
    resolution = SOLVER_METHODS[problem.method].resolution
    return resolution is not None and resolution.option == option


METHODS = (
    method("auto"),
    *(method(f"auto, {law} strain", strain=law) for law in CHOICES["strain"] if law != REFERENCE),
    *(method(name, method=name) for name in SOLVER_METHODS if name != Problem.method),
)
