"""Mass of a beam along its span: its total, centre and moments."""

from typing import NamedTuple

from beamviz.blade import Blade
from beamviz.units import Units


class MassProperties(NamedTuple):
    """Of the beam itself in SI, without the bodies on it. Moments of inertia are those of a line of
    mass, about an axis across the beam."""

    mass: float  # [kg]
    centre: float  # [m] from the root
    first_moment_about_root: float  # [kg m]
    second_moment_about_root: float  # [kg m^2]
    first_moment_about_axis: float  # [kg m] about the axis of rotation
    second_moment_about_axis: float  # [kg m^2]


def moments_of_mass(blade: Blade | None) -> tuple[float, float, float]:
    """int m x^k dx for k = 0, 1, 2, over rho A L^(k + 1) of the root section: exact."""
    if blade is None:
        return 1.0, 1 / 2, 1 / 3
    from numpy.polynomial import Polynomial

    moments = []
    for k in range(3):
        total = 0.0
        for segment in blade.segments:
            length = segment.stop - segment.start
            x = Polynomial([segment.start, length])  # of the place in the segment, 0 .. 1
            total += length * float((segment.polynomials["mass"] * x**k).integ()(1.0))
        moments.append(total)
    m, first, second = moments
    return m, first, second


def mass_properties(blade: Blade | None, units: Units, delta: float) -> MassProperties | None:
    """Those of a beam whose root has the radius delta L; None where its mass is not known."""
    if units.mass is None:
        return None
    L, hub = units.length, delta * units.length
    m, first, second = moments_of_mass(blade)
    mass = m * units.mass
    first_moment, second_moment = first * units.mass * L, second * units.mass * L**2
    return MassProperties(
        mass=mass,
        centre=first_moment / mass,
        first_moment_about_root=first_moment,
        second_moment_about_root=second_moment,
        first_moment_about_axis=first_moment + mass * hub,
        second_moment_about_axis=second_moment + 2 * hub * first_moment + mass * hub**2,
    )
