"""Real beams to start from, with their sources, and materials."""

from dataclasses import dataclass

from beamviz.beam import Beam

RPM = 0.10471975511965977  # [rad/s]


@dataclass(frozen=True)
class RealBeam:
    """A beam in SI units, the keywords of `Beam.from_si`; plane: where it vibrates first; section:
    the kind of its cross-section."""

    name: str
    source: str
    plane: str
    values: dict[str, float]
    section: str = "own"

    @property
    def beam(self) -> Beam:
        return Beam.from_si(**self.values)


def rectangle(breadth: float, thickness: float) -> dict[str, float]:
    """Area and second moment of a rectangular section, from its sides [m]."""
    return {"area": breadth * thickness, "second_moment": breadth * thickness**3 / 12}


MATERIALS = {  # usual values
    "steel": {"youngs_modulus": 210e9, "density": 7850.0},
    "aluminium": {"youngs_modulus": 70e9, "density": 2700.0},
    "titanium": {"youngs_modulus": 110e9, "density": 4500.0},
    "glass fibre": {"youngs_modulus": 30e9, "density": 1900.0},
}
STEEL_BEAM = RealBeam(
    "steel beam",
    "A bar of rectangular section, 1000 x 30 x 5 mm, without a mass, on a shaft at 300 rpm. Steel"
    " as usually taken: E = 210 GPa (the value of EN 1993-1-1), 7850 kg/m³.",
    "chordwise",
    {**MATERIALS["steel"], **rectangle(30e-3, 5e-3), "length": 1.0, "rotation_speed": 300 * RPM},
    "rectangle",
)
RULER = RealBeam(
    "steel ruler",
    "A laboratory rule of a common size, 300 x 25 x 1 mm, with a clip of 10 g at its tip, on a"
    " turntable. Steel as usually taken: E = 210 GPa (the value of EN 1993-1-1), 7850 kg/m³.",
    "chordwise",
    {
        **MATERIALS["steel"],
        **rectangle(25e-3, 1e-3),
        "length": 0.3,
        "rotation_speed": 300 * RPM,
        "mass": 0.01,
        "mass_position": 0.3,
    },
    "rectangle",
)
ARM = RealBeam(
    "spin-up arm",
    "A manipulator arm: the spin-up manoeuvre after Simo & Vu-Quoc (J. Appl. Mech. 53, 1986),"
    " with the values that many papers repeat: EI = 14 kN m², EA = 28 MN, 1.2 kg/m, 10 m, up to"
    " 6 rad/s. With E = 70 GPa the section follows.",
    "chordwise",
    {
        "length": 10.0,
        "density": 3000.0,
        "area": 4e-4,
        "second_moment": 2e-7,
        "youngs_modulus": 70e9,
        "rotation_speed": 6.0,
    },
)
BLADE = RealBeam(
    "wind blade",
    "A wind turbine blade made uniform: length, mass, hub and rated speed of the NREL 5 MW"
    " reference turbine (Jonkman et al., NREL/TP-500-38060, 2009). A glass-fibre section"
    " (E = 30 GPa, 1900 kg/m³: typical values) as stiff as gives its first flapwise frequency,"
    " 0.67 Hz, at rest. A real one tapers and twists.",
    "flapwise",
    {
        "length": 61.5,
        "density": 1900.0,
        "area": 17740.0 / (1900.0 * 61.5),
        "second_moment": 0.197,
        "youngs_modulus": 30e9,
        "hub_radius": 1.5,
        "rotation_speed": 12.1 * RPM,
    },
)
REAL_BEAMS = (STEEL_BEAM, RULER, ARM, BLADE)
