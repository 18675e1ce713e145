"""Stress along a beam of a known material at its equilibrium.

    sigma = N / A +- M h / (2 I)

N / A is the axial force over the unstretched area; the second term is that of bending in the
outermost fibres, at half the height h of the section from its axis. With the loads in units of
E I / L^2 and E I / L the stress is E (N / mu^2 +- M h / (2 L)).
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.errors import InvalidInput
from beamviz.si import MATERIAL
from beamviz.solver.loads import Loads
from beamviz.units import Units

POINTS = 101  # at which the greatest stress is looked for, besides the bodies


class Stress(NamedTuple):
    """Stress [Pa] at points (k,) of a beam, or at one. bending: None where it is not known, as the
    height of the section is not."""

    axial: Any  # (k,) tension positive
    bending: Any  # (k,) in the outermost fibres, of either sign

    @property
    def greatest(self) -> Any:
        """The greatest over the section, tension or compression (k,); of the axial force alone
        where that of bending is not known."""
        return abs(self.axial) + (0.0 if self.bending is None else self.bending)


@dataclass(frozen=True)
class GreatestStress:
    """The greatest stress of a beam [Pa], the place x / L where it is, and of a motion the time
    [T*] when. with_bending: False where that of bending is not known; yield_stress: [Pa], None
    where it is not known."""

    pascals: float
    at: float
    with_bending: bool
    yield_stress: float | None
    t: float | None = None

    @property
    def yields(self) -> bool:
        """Whether it is above the yield stress, beyond which a deformation remains."""
        return self.yield_stress is not None and self.pascals > self.yield_stress


def stress(loads: Loads, x: NDArray) -> Stress:
    """The stress at x (k,), at a body on the side of the root. Raises InvalidInput where the
    material of the beam is not known."""
    units = loads.beam.units
    if units is None or units.youngs_modulus is None:
        raise InvalidInput(
            "the stress is that of a uniform beam of a known material: give it by"
            f" {', '.join(MATERIAL)}"
        )
    at, E, height = loads.at(x), units.youngs_modulus, units.section_height
    bending = E * np.abs(at.moment) * height / (2 * units.length) if height else None
    if height is None and not at.moment.any():
        bending = np.zeros(len(x))
    return Stress(E * at.axial / loads.beam.mu**2, bending)


def stress_of_deformation(units: Units, stretch: NDArray, curvature: NDArray) -> Stress | None:
    """The stress of small strains: of a stretch, and of a curvature [1/L], of any shape. None where
    the material is not known."""
    E, height = units.youngs_modulus, units.section_height
    if E is None:
        return None
    bending = E * np.abs(curvature) * height / (2 * units.length) if height else None
    return Stress(E * (stretch - 1), bending)


def greatest_stress(loads: Loads) -> GreatestStress | None:
    """The greatest stress along a beam; None where its material is not known."""
    beam = loads.beam
    if beam.units is None or beam.units.youngs_modulus is None:
        return None
    bodies = np.array([body.beta for body in beam.bodies if body.beta < 1])
    x = np.union1d(np.linspace(0, 1, POINTS), [*bodies, *np.nextafter(bodies, 1)])
    if beam.delta >= 0 and not loads.at(np.zeros(1)).moment[0]:
        x = np.zeros(1)  # all the mass of a straight beam that points outward pulls at its root
    stresses = stress(loads, x)
    k = int(np.argmax(stresses.greatest))
    known = stresses.bending is not None
    return GreatestStress(float(stresses.greatest[k]), float(x[k]), known, beam.units.yield_stress)
