"""The kinds of cells of the maps, and how each is drawn."""

from typing import NamedTuple

from beamviz.plotting import FAINT, INK


class Kind(NamedTuple):
    """A kind of cell, the colour and the hatch that it is drawn in, and the colour of its label."""

    name: str
    meaning: str
    face: str
    hatch: str = ""
    ink: str = INK


# Safe for the colour-blind and in grey: lightness falls, and hatches help.
RIGHT = Kind(
    "right", "right: within 0.001 of its own model's converged frequencies", "white", "", FAINT
)
INACCURATE = Kind("inaccurate", "inaccurate: a larger discretisation error", "#F7E98E")
OTHER_MODEL = Kind("other model", "its model is more than 1 % off the reference", "#A9D3F0")
TRULY_UNSTABLE = Kind("truly unstable", "truly unstable, and reported as such", "#C4C4C4", "////")
ROUNDING = Kind("rounding", "rounding error: twice as many terms do not help", "#6FBFA6", "....")
NOT_CONVERGED = Kind("did not converge", "did not converge", "#A0508A", "xxx", "white")
FALSELY_UNSTABLE = Kind(
    "falsely unstable", "falsely unstable: the beam is stable", "#C44601", "", "white"
)
NO_EQUILIBRIUM = Kind(
    "no equilibrium", "no equilibrium in its model, reported as such", "#2B2B2B", "", "white"
)
OUTSIDE = Kind("outside", "not accepted: γ above 5 μ", "#F0F0F0")

STRAIGHT = RIGHT._replace(name="straight", meaning="straight, and stable")
BENT = OTHER_MODEL._replace(name="bent", meaning="bent; the straight state is unstable")
SEVERAL = ROUNDING._replace(
    name="more than one", meaning="more than one stable state, mirror images apart"
)
NO_STATE = NO_EQUILIBRIUM._replace(name="no stable state", meaning="no stable state found")
