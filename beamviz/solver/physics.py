"""What is solved about a beam."""

from typing import Literal, NamedTuple

from beamviz.solver.constitutive import Curvature, StrainLaw

Tension = Literal["equilibrium", "reference"]


class Physics(NamedTuple):
    """What is solved about a beam: its laws, its plane, whether Coriolis forces act, and whose
    tension stiffens it: that of the stretched equilibrium, or that of the rigid reference length
    (first-order coupling). Stiffening and softening are terms that can be left out."""

    law: StrainLaw
    curvature: Curvature
    chordwise: bool
    coriolis: bool
    tension: Tension = "equilibrium"
    stiffening: bool = True
    softening: bool = True

    @property
    def couples(self) -> bool:
        """Whether stretching and bending vibrate together, in a beam that turns."""
        return self.coriolis and self.chordwise
