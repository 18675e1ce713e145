"""The same blade as text in the formats of the field, as their programs read it."""

from collections.abc import Sequence
from typing import NamedTuple


class Sections(NamedTuple):
    """A blade of 4 stations, in SI and degrees."""

    length: float = 40.0
    hub_radius: float = 1.5
    stations: Sequence[float] = (0.0, 10.0, 25.0, 40.0)
    mass: Sequence[float] = (600.0, 350.0, 180.0, 20.0)
    edge: Sequence[float] = (9e9, 5e9, 1.5e9, 3e7)
    flap: Sequence[float] = (9e9, 2e9, 2e8, 1e6)
    axial: Sequence[float] = (9e9, 5e9, 2e9, 2e8)
    twist: Sequence[float] = (12.0, 9.0, 3.0, 0.0)

    @property
    def fractions(self) -> list[float]:
        return [x / self.length for x in self.stations]


BLADE = Sections()
KEYWORDS = {
    "length": BLADE.length,
    "stations": BLADE.stations,
    "mass_per_length": BLADE.mass,
    "bending_stiffness": BLADE.edge,
    "flap_stiffness": BLADE.flap,
    "twist": BLADE.twist,
}


def rows(*columns: Sequence[float], separator: str = "  ") -> str:
    return "\n".join(separator.join(map(repr, row)) for row in zip(*columns, strict=True))


def elastodyn(blade: Sections = BLADE, mass_factor: float = 2.0) -> str:
    table = rows(
        *(blade.fractions, blade.twist, [m / mass_factor for m in blade.mass]),
        *(blade.flap, blade.edge),
    )
    return f"""\
------- ELASTODYN V1.00.* INDIVIDUAL BLADE INPUT FILE --------------------------
A blade of four stations
---------------------- BLADE PARAMETERS ----------------------------------------
          {len(blade.mass)}   NBlInpSt    - Number of blade input stations (-)
   0.477465   BldFlDmp(1) - Blade flap mode #1 structural damping in percent of critical (%)
---------------------- BLADE ADJUSTMENT FACTORS --------------------------------
          {mass_factor}   AdjBlMs     - Factor to adjust blade mass density (-)
          1   AdjFlSt     - Factor to adjust blade flap stiffness (-)
          1   AdjEdSt     - Factor to adjust blade edge stiffness (-)
---------------------- DISTRIBUTED BLADE PROPERTIES ----------------------------
    BlFract      StrcTwst       BMassDen        FlpStff        EdgStff
      (-)         (deg)          (kg/m)         (Nm^2)         (Nm^2)
{table}
---------------------- BLADE MODE SHAPES ---------------------------------------
     0.0622   BldFl1Sh(2) - Flap mode 1, coeff of x^2
"""


def elastodyn_main(blade_file: str, blade: Sections = BLADE) -> str:
    return f"""\
------- ELASTODYN v1.03.* INPUT FILE -------------------------------------------
          1   BlPitch(1)  - Blade 1 initial pitch (degrees)
       12.1   RotSpeed    - Initial or fixed rotor speed (rpm)
          3   NumBl       - Number of blades (-)
       {blade.length + blade.hub_radius}   TipRad      - Rotor apex to the tip (meters)
       {blade.hub_radius}   HubRad      - Rotor apex to the root (meters)
       -2.5   PreCone(1)  - Blade 1 cone angle (degrees)
          0   TipMass(1)  - Tip-brake mass, blade 1 (kg)
"{blade_file}"    BldFile(1)  - Name of file containing properties for blade 1 (quoted string)
"""


def bmodes(blade: Sections = BLADE) -> str:
    zeros = [0.0] * len(blade.mass)
    inertia, torsion = [1.0] * len(zeros), [1e7] * len(zeros)
    table = rows(
        *(blade.fractions, blade.twist, blade.twist, blade.mass, inertia, inertia),
        *(blade.flap, blade.edge, torsion, blade.axial, [0.25, 0.0, 0.0, 0.0], zeros, zeros),
    )
    return f"""\
Blade section properties
{len(zeros)}        n_secs:     number of blade sections at which properties are specified (-)

sec_loc str_tw tw_iner mass_den flp_iner edge_iner flp_stff edge_stff tor_stff axial_stff cg_offst \
sc_offst tc_offst
(-) (deg) (deg) (kg/m) (kg-m) (kg-m) (Nm^2) (Nm^2) (Nm^2) (N) (m) (m) (m)
{table}
"""


def bmodes_main(sections: str, blade: Sections = BLADE) -> str:
    return f"""\
======================   BModes v1.03 Main Input File  ==================
A blade of four stations

--------- General parameters -----------------------------------------------------
1         beam_type   1: blade, 2: tower (-)
12.0      romg:       rotor speed (rpm)
2.0       romg_mult:  rotor speed muliplicative factor (-)
{blade.length + blade.hub_radius}   radius:     rotor tip radius measured along coned blade axis (m)
{blade.hub_radius}      hub_rad:    hub radius measured along coned blade axis (m)
0.        precone:    built-in precone angle (deg)
3.0       bl_thp:     blade pitch setting (deg)
40.       tip_mass    blade-tip or tower-top mass (kg)
0.        cm_loc      tip-mass c.m. offset (m)
10.0      ixx_tip     blade lag mass moment of inertia (kg-m^2)
1.75      iyy_tip     blade flap mass moment of inertia (kg-m^2)
2.5       izz_tip     torsion mass moment of inertia (kg-m^2)
'{sections}' sec_props_file   name of beam section properties file (-)
1.5       sec_mass_mult:   mass density multiplier (-)
1.0       axial_stff_mult: axial stiffness multiplier (-)
"""


def hawc2(blade: Sections = BLADE) -> str:
    zeros, modulus = [0.0] * len(blade.mass), [1e10] * len(blade.mass)

    def over_modulus(values: Sequence[float]) -> list[float]:
        return [value / modulus[0] for value in values]

    def table(mass: Sequence[float]) -> str:
        shear = over_modulus(blade.axial)
        return rows(
            *(blade.stations, mass, [0.3, *zeros[1:]], zeros, zeros, zeros, zeros, zeros),
            *(modulus, modulus),
            *(
                over_modulus(blade.flap),
                over_modulus(blade.edge),
                shear,
                zeros,
                zeros,
                over_modulus(blade.axial),
            ),
            *(blade.twist, zeros, zeros),
        )

    count = len(zeros)
    return (
        f"1 number of sets\n#1 blade\nr m x_cg ...\n$1 {count} flexible\n{table(blade.mass)}\n"
        f"$2 {count} heavy\n{table([2 * m for m in blade.mass])}\n"
    )


def flex(blade: Sections = BLADE) -> str:
    zeros = [0.0] * len(blade.mass)
    table = rows(
        blade.stations, blade.flap, blade.edge, blade.mass, blade.twist, zeros, zeros, zeros
    )
    return f"V000 A blade of four stations\n{len(zeros)} stations\n{table}\n0.0 cone\n"


def delimited(separator: str, comma: bool = False, blade: Sections = BLADE) -> str:
    """In inches and pounds, with the units in a row of their own."""
    inch, pound, force = 0.0254, 0.45359237, 4.4482216152605
    names = ["x", "m", "EI_lag", "EI_flap", "twist"]
    units = ["in", "lb/in", "lb in^2", "lb-in^2", "deg"]
    table = rows(
        [x / inch for x in blade.stations],
        [m * inch / pound for m in blade.mass],
        [EI / force / inch**2 for EI in blade.edge],
        [EI / force / inch**2 for EI in blade.flap],
        blade.twist,
        separator=separator,
    )
    lines = [
        separator.join(names),
        separator.join(units),
        table.replace(".", "," if comma else "."),
    ]
    return "\n".join(lines)
