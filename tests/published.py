"""The published and independent values of the validation page, as numbers.

Lengths in L, frequencies in 1/T*; slenderness 70 where nothing else is said.
"""

from beamviz.paper import validation
from beamviz.paper.figures import FIGURES, LociFigure, last_digit


def numbers(text: str) -> list[float]:
    """Numbers separated by spaces."""
    return [float(word) for word in text.split()]


# gamma, omega 1 ..
UNIFORM_FLAPWISE = [(g, *numbers(text)) for g, text in validation.UNIFORM_FLAPWISE.items()]
TIP_MASS_FLAPWISE = [(g, *numbers(text)) for g, text in validation.TIP_MASS_FLAPWISE.items()]
RIGID_CORIOLIS = [(g, float(text)) for g, text in validation.RIGID_CORIOLIS.items()]
TIP_MASS_AT_REST = numbers(validation.TIP_MASS_AT_REST)

# alpha, beta, gamma, delta, bending 1..4, stretching 1; the same with Coriolis, omega 1 ..
INDEPENDENT = [
    (*beam, numbers(text)[:4], numbers(text)[4]) for beam, text in validation.STRETCHED.items()
]
INDEPENDENT_CORIOLIS = [
    (*beam, numbers(text)) for beam, text in validation.STRETCHED_CORIOLIS.items()
]

# strain, delta, largest gamma with an equilibrium (alpha 0), a unit of its last digit
LIMITS = [(*key, float(text), last_digit(text)) for key, text in validation.LIMITS.items()]

# parameter, beam, bending mode whose locus crosses the stretching one, curvature, place, last digit
CROSSINGS = [
    (figure.over, figure.beam, crossing.loci[0], curvature, float(text), last_digit(text))
    for figure in FIGURES.values()
    if isinstance(figure, LociFigure)
    for crossing in figure.crossings
    for curvature, text in (("material", crossing.material), ("spatial", crossing.spatial))
]
