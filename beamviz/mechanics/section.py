"""The energy of a section and its derivatives (paper, eqs. 14-19).

With the stretch f = |r'| and the curvature kappa = theta' of the axis, the energy per reference
length is, in units of E I / L^2 of the root section,

    W(f, kappa) = mu^2 EA e(f)^2 / 2 + EI f^p kappa^2 / 2,

e the axial strain and p = 4 - 2 c by the power c of the curvature measure: its curvature is
kappa f^(2 - c). EI and EA are those of the section over those of the root. W_f is conjugate to the
stretch and W_kappa, the bending moment, to the rotation.
"""

from typing import NamedTuple

from numpy.typing import NDArray

from beamviz.solver.constitutive import StrainLaw


class Section(NamedTuple):
    """The law of the sections at n points of a beam. The arguments f and kappa of its functions
    are (..., n), and so are the results."""

    law: StrainLaw
    power: int  # p
    axial: NDArray  # mu^2 EA (n,)
    bending: NDArray  # EI (n,)

    def energy(self, f: NDArray, kappa: NDArray) -> NDArray:
        """W."""
        stretching = self.axial * self.law.strain(f) ** 2
        return (stretching + self.bending * self.power_of(f) * kappa**2) / 2

    def forces(self, f: NDArray, kappa: NDArray) -> tuple[NDArray, NDArray]:
        """W_f and W_kappa."""
        moment = self.bending * self.power_of(f) * kappa
        force = self.axial * self.law.force(f)
        if self.power:
            force = force + self.power / 2 * moment * kappa / f
        return force, moment

    def stiffness(self, f: NDArray, kappa: NDArray) -> tuple[NDArray, NDArray, NDArray]:
        """W_ff, W_fkappa and W_kappakappa."""
        p, bending = self.power, self.bending * self.power_of(f)
        mixed = p * bending * kappa / f
        along = self.axial * self.law.stiffness(f)
        if p:
            along = along + (p - 1) / 2 * mixed * kappa / f
        return along, mixed, bending

    def power_of(self, f: NDArray) -> NDArray:
        """f^p."""
        return (f * f) ** (self.power // 2)  # powers of -1 and 0 are fast

    def stiffness_at_constant_moment(self, f: NDArray, kappa: NDArray) -> NDArray:
        """The stiffness in f of deformations much shorter than the beam, which change f at a
        constant moment, so that kappa follows: W_ff - W_fkappa^2 / W_kappakappa."""
        along, mixed, bending = self.stiffness(f, kappa)
        return along - mixed**2 / bending
