"""Rules that notice a value in SI that is likely in another unit: possible, but seldom meant."""

import math
from collections.abc import Callable, Iterable
from typing import NamedTuple

from beamviz.si import PhysicalBeam


class Rule(NamedTuple):
    """A range outside which a quantity is seldom meant."""

    quantity: str
    unit: str
    of: Callable[[PhysicalBeam], Iterable[float]]  # its values, at each station or a single one
    least: float
    most: float
    below: str  # the likely mistake where it is too small
    above: str  # the likely mistake where it is too large
    reason: str  # source of the range


def tip_speed(beam: PhysicalBeam) -> Iterable[float]:
    return [beam.rotation_speed * max(abs(beam.hub_radius), abs(beam.hub_radius + beam.length))]


def stiff_rule(beam: PhysicalBeam) -> Iterable[float]:
    """EA / EI of a blade whose axial stiffness is one multiple of its bending stiffness at each
    station, and larger than that of any material."""
    ratios = quotients(beam.axial_stiffness, beam.bending_stiffness)
    speeds = quotients(beam.axial_stiffness, beam.mass_per_length)
    is_one = max(ratios) <= SAME * min(ratios)
    if beam.is_inextensible or beam.is_prismatic or not is_one or speeds[0] < FASTEST**2:
        return []
    return ratios[:1]


def bending_speed(beam: PhysicalBeam) -> Iterable[float]:
    """That of axial waves times the radius of gyration over the length, of a blade of 1 m."""
    if beam.is_prismatic or beam.length != 1:
        return []
    return (
        math.sqrt(ratio) for ratio in quotients(beam.bending_stiffness, beam.mass_per_length)[:1]
    )


def wave_speed(beam: PhysicalBeam) -> Iterable[float]:
    if beam.is_inextensible or any(ratio > MOST_RULE for ratio in stiff_rule(beam)):
        return []
    return map(math.sqrt, quotients(beam.axial_stiffness, beam.mass_per_length))


def thickness_ratios(beam: PhysicalBeam) -> Iterable[float]:
    """Thickness of a rectangle of the same stiffnesses, over the length."""
    has_fractions = any(speed > MOST_SPEED for speed in bending_speed(beam))
    if beam.is_inextensible or has_fractions or any(r > MOST_RULE for r in stiff_rule(beam)):
        return []
    thick = map(math.sqrt, quotients(beam.bending_stiffness, beam.axial_stiffness))
    return (math.sqrt(12) * radius / beam.length for radius in thick)


def flap_over_chordwise(beam: PhysicalBeam) -> Iterable[float]:
    return quotients(beam.flap_stiffness or (), beam.bending_stiffness)


def quotients(upper: Iterable[float], lower: Iterable[float]) -> list[float]:
    return [a / b for a, b in zip(upper, lower, strict=False)]


def mass_ratios(beam: PhysicalBeam) -> Iterable[float]:
    whole = beam.mass_per_length[0] * beam.length
    return [body / whole for body in (beam.mass, *(body.mass for body in beam.masses))]


def gyrations(beam: PhysicalBeam) -> Iterable[float]:
    """Radii of gyration of the bodies over the length."""
    return [
        math.sqrt(max(body.inertia) / body.mass) / beam.length
        for body in beam.masses
        if body.mass > 0
    ]


SAME = 1 + 1e-4  # largest over smallest ratio that is meant to be one number
FASTEST = 20e3  # [m/s] of axial waves
MOST_RULE = 1e4  # [1/m^2] EA / EI: of a blade with parts 1 cm from its axis throughout
MOST_SPEED = 1000.0  # [m/s]
RULES = (
    Rule(
        *("sqrt(EI / (mass per length)) over the length", "m/s", bending_speed, 0.0, MOST_SPEED),
        below="",
        above="positions as fractions of the span, not in m?",
        reason="5000 m/s in most materials times a radius of gyration of 1/5 of the length, more"
        " than that of a beam; that of the NREL 5 MW blade is 84 m/s, at a length of 1 m 5200.",
    ),
    Rule(
        *("EA over EI at each station", "1/m^2", stiff_rule, 0.0, MOST_RULE),
        below="",
        above="an axial stiffness by rule, as 10^6 EI in files of BModes? Without one the beam is"
        " inextensible, which is meant by it.",
        reason="Blades have 0.3 to 300; steel 5 mm thick has 480000, but not along a taper.",
    ),
    Rule(
        *("length", "m", lambda beam: [beam.length], 1e-5, 300.0),
        below="a length in km?",
        above="a length in mm, not m?",
        reason="Microbeams are 50 um long and more; the longest blades 150 m, masts 200 m.",
    ),
    Rule(
        *("density", "kg/m^3", lambda beam: [beam.density] if beam.density else [], 20.0, 25e3),
        below="a density in g/cm^3 or t/m^3, not kg/m^3?",
        above="a density in g/m^3, not kg/m^3?",
        reason="Foams have 20 and more, osmium 22600; metals in g/cm^3 are below 20.",
    ),
    Rule(
        *("Young's modulus", "Pa"),
        lambda beam: [beam.youngs_modulus] if beam.youngs_modulus else [],
        *(4e5, 1.5e12),
        below="a modulus in GPa or MPa (N/mm^2), not Pa?",
        above="a modulus a thousand times too large?",
        reason="Soft rubber has 5e5, diamond 1.2e12; steel in MPa is 2.1e5.",
    ),
    Rule(
        *("speed of axial waves sqrt(EA / (mass per length))", "m/s", wave_speed, 200.0, FASTEST),
        below="Young's modulus in GPa or MPa, the axial stiffness in kN or MN, or the mass of a"
        " unit of length in g/m?",
        above="a density in g/cm^3 or t/m^3, or the mass of a unit of length in t/m?",
        reason="LDPE has 450, diamond 18000; steel with EA in kN 160. Only rubber has 50.",
    ),
    Rule(
        *("thickness sqrt(12 EI / EA) over length", "", thickness_ratios, 1e-3, 0.25),
        below="a length in mm, or the bending stiffness in kN m^2?",
        above="sizes of the section in mm, the bending stiffness in N mm^2, or the axial stiffness"
        " in kN or MN?",
        reason="A laboratory rule of steel has 1/300; thicker than 1/4 it is hardly a beam.",
    ),
    Rule(
        *("flapwise over chordwise bending stiffness", "", flap_over_chordwise, 1e-4, 1e3),
        below="one of the bending stiffnesses in another unit?",
        above="one of the bending stiffnesses in another unit?",
        reason="A flat bar of 40 to 1 has 6e-4 or 1600, and blades 0.02 to 2.",
    ),
    Rule(
        *("speed of the tip", "m/s", tip_speed, 0.0, 600.0),
        below="",
        above="a rotation speed in rpm, not rad/s, or as gamma, which is Omega T*?",
        reason="Fans of engines reach 450 m/s; flywheels of fibre more. 12.1 rpm as rad/s: 760.",
    ),
    Rule(
        *("mass over that of the beam", "", mass_ratios, 0.0, 20.0),
        below="",
        above="a mass in g, not kg?",
        reason="A body of more than 20 beams is an oscillator on a massless beam.",
    ),
    Rule(
        *("radius of gyration of a body over the length", "", gyrations, 0.0, 1.0),
        below="",
        above="an inertia in kg mm^2 or g mm^2, not kg m^2?",
        reason="A body larger than its beam is seldom meant.",
    ),
)


def doubts(beam: PhysicalBeam) -> tuple[str, ...]:
    """A sentence for each rule that a beam does not keep."""
    return tuple(filter(None, (doubt(rule, beam) for rule in RULES)))


def doubt(rule: Rule, beam: PhysicalBeam) -> str:
    """The value of a rule's quantity outside its range, with the likely mistake; "" inside."""
    outside = [value for value in rule.of(beam) if not rule.least <= value <= rule.most]
    if not outside:
        return ""
    unit = f" {rule.unit}" if rule.unit else ""
    usual = f"{rule.least:g} .. {rule.most:g}" if rule.least else f"up to {rule.most:g}"
    mistake = rule.below if outside[0] < rule.least else rule.above
    return f"{rule.quantity} = {outside[0]:.4g}{unit}, usually {usual}{unit}: {mistake}"
