"""Mode shapes of a blade as polynomials, as ElastoDyn reads them: of degree 2 to 6 in x / L, 1 at
the tip."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.errors import InvalidInput
from beamviz.solver.solution import Solution

POWERS = np.arange(2, 7)
POINTS = 201  # along the beam, equally spaced, that are fitted
# The shapes of an ElastoDyn blade file by the labels of their modes, in each plane of bending.
SHAPES = {
    "both": {"F1": "BldFl1Sh", "F2": "BldFl2Sh", "L1": "BldEdgSh"},
    "flapwise": {"B1": "BldFl1Sh", "B2": "BldFl2Sh"},
    "chordwise": {"B1": "BldEdgSh"},
}
DESCRIPTIONS = {
    "BldFl1Sh": "Flap mode 1",
    "BldFl2Sh": "Flap mode 2",
    "BldEdgSh": "Edge mode 1",
}


class ShapePolynomial(NamedTuple):
    """A mode shape as a polynomial."""

    label: str  # of the mode
    name: str  # of ElastoDyn
    coefficients: NDArray  # (5,) of (x / L)^2 .. (x / L)^6, of sum 1
    fit_error: float  # greatest difference from the shape, which is 1 at the tip


def shape_polynomials(solution: Solution) -> list[ShapePolynomial]:
    """The polynomials of the first two flap and the first edge shape, those that the solution has.
    Raises InvalidInput where it has none."""
    x, plane = np.linspace(0, 1, POINTS), solution.problem.plane
    polynomials = []
    for k, label in enumerate(solution.labels):
        name = SHAPES[plane].get(label)
        if name is None:
            continue
        component = 2 if plane == "both" and name != "BldEdgSh" else 1
        shape = solution.shape(k, x)[:, component].real
        polynomials.append(fitted(label, name, x, shape / shape[-1]))
    if not polynomials:
        wanted = ", ".join(SHAPES[plane])
        raise InvalidInput(
            f"modes = {solution.problem.modes}: none of {wanted}: ask for more modes"
        )
    return sorted(polynomials, key=lambda polynomial: list(DESCRIPTIONS).index(polynomial.name))


def fitted(label: str, name: str, x: NDArray, shape: NDArray) -> ShapePolynomial:
    """The polynomial nearest to a shape in the mean square that is 1 at the tip."""
    functions = x[:, None] ** POWERS
    last = functions[:, -1]
    others, *_ = np.linalg.lstsq(functions[:, :-1] - last[:, None], shape - last, rcond=None)
    coefficients = np.append(others, 1 - others.sum())
    return ShapePolynomial(
        label, name, coefficients, float(abs(functions @ coefficients - shape).max())
    )


def elastodyn_lines(polynomials: list[ShapePolynomial]) -> list[str]:
    """The section of mode shapes of an ElastoDyn blade file."""
    lines = ["---------------------- BLADE MODE SHAPES ---------------------------------------"]
    for polynomial in polynomials:
        for power, coefficient in zip(POWERS, polynomial.coefficients, strict=True):
            first = DESCRIPTIONS[polynomial.name] if power == POWERS[0] else " " * 11
            text = f"{first}, coeff of x^{power}"
            lines.append(f"{coefficient:12.6f}   {polynomial.name}({power}) - {text}")
    return lines
