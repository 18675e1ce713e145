"""The panel of a real beam in SI units: presets, dimensions, section and material."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import cache, partial
from html import escape
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import MAX_GAMMA_OVER_MU, NUMBERS, PARAMETERS, Beam
from beamviz.blade import PROPERTY_LIMITS
from beamviz.checks import check_float, together
from beamviz.drawing.text import si_text
from beamviz.errors import InvalidInput
from beamviz.explorer import page
from beamviz.explorer.declarations import choice, name_key
from beamviz.explorer.feature import Feature
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.state import Case, Refused, Slice, State
from beamviz.explorer.visitor import Visitor
from beamviz.presets import PRESETS as BLADES
from beamviz.si import SI_REQUIRED, STRENGTH, PhysicalBeam
from beamviz.units import Units, display_unit

RPM = math.pi / 30  # [rad/s]
MAX_VALUE = 1e12  # in the unit of a field
MIN_VALUE = 1e-30  # in that unit: the second moment of a smaller section would be 0
DIGITS = 8
ROUNDING = 1e-9
PERCENT = "mass_percent"
OPTIONAL = ("hub_radius", "rotation_speed", "angular_acceleration", "mass", "yield_stress")

Pair = tuple[float, float]
Values = dict[str, float]


class SectionKind(NamedTuple):
    """A kind of cross-section with some dimensions, `sizes`.

    values: area, second moment of bending in the plane of rotation, and "flap_moment", that of
    bending out of it, of dimensions in SI; of: the dimensions of an area and the second moment in
    the plane (those of "own" of both moments), raises ValueError if there is no such section.
    """

    sizes: tuple[str, ...]
    values: Callable[..., Values]
    of: Callable[[float, float, float], tuple[float, ...]]


def own_section(area: float, second_moment: float, flap_moment: float = 0.0) -> Values:
    """flap_moment: by default the other one."""
    flap_moment = flap_moment or second_moment
    return {"area": area, "second_moment": second_moment, "flap_moment": flap_moment}


def on_edge(width: float, thickness: float) -> Values:
    """A rectangle with its thickness in the plane of rotation."""
    b, h = width, thickness
    return own_section(b * h, b * h**3 / 12, h * b**3 / 12) | {"section_height": h}


def flat(width: float, thickness: float) -> Values:
    """A rectangle with its width in the plane of rotation."""
    return on_edge(thickness, width)


def rectangle_sizes(area: float, moment: float, _: float) -> Pair:
    """Sizes of a rectangle out of and in the plane of rotation."""
    in_plane = math.sqrt(12 * moment / area)
    return area / in_plane, in_plane


def tube(diameter: float, wall: float) -> Values:
    """A tube; a rod for a wall of half the diameter."""
    area = math.pi * wall * (diameter - wall)
    section = own_section(area, area * (diameter**2 + (diameter - 2 * wall) ** 2) / 16)
    return section | {"section_height": diameter}


def tube_sizes(area: float, moment: float, _: float) -> Pair:
    """Outer diameter and wall of a tube."""
    outer, inner = (8 * moment / area + side * 2 * area / math.pi for side in (1, -1))
    diameter = math.sqrt(outer)
    hole = math.sqrt(max(inner, 0.0) if inner > -ROUNDING * outer else inner)
    return diameter, (diameter - hole) / 2


SECTIONS = {
    "rectangle": SectionKind(("width", "thickness"), on_edge, rectangle_sizes),
    "flat": SectionKind(
        ("width", "thickness"), flat, lambda *values: rectangle_sizes(*values)[::-1]
    ),
    "tube": SectionKind(("diameter", "wall"), tube, tube_sizes),
    "own": SectionKind(
        ("area", "second_moment", "flap_moment"), own_section, lambda *values: values
    ),
}
RECTANGLES = ("rectangle", "flat")
SAME = 1e-6  # relative difference of sections that are the same to the digits of a link
FIELDS = {  # their labels, their units, and the SI values of these
    "length": ("length L", "mm", 1e-3),
    "youngs_modulus": ("Young's modulus E", "GPa", 1e9),
    "density": ("density ρ", "kg/m³", 1.0),
    "yield_stress": ("yield stress", "MPa", 1e6),
    "hub_radius": ("hub radius a", "mm", 1e-3),
    "rotation_speed": ("rotation speed Ω", "rpm", RPM),
    "angular_acceleration": ("spin-up", "rad/s²", 1.0),
    "mass": ("mass m", "kg", 1.0),
    PERCENT: ("mass at", "% of L", 0.01),
    "width": ("width b", "mm", 1e-3),
    "thickness": ("thickness h", "mm", 1e-3),
    "diameter": ("outer diameter D", "mm", 1e-3),
    "wall": ("wall t", "mm", 1e-3),
    "area": ("area A", "mm²", 1e-6),
    "second_moment": ("I in plane", "mm⁴", 1e-12),
    "flap_moment": ("I out of plane", "mm⁴", 1e-12),
}
ALONG_BEAM = ("length", "hub_radius")  # fields in m for a long beam
THICK = {
    "area": "m²",
    "second_moment": "m⁴",
    "flap_moment": "m⁴",
}  # units of a section whose parts are far from its axis
FAR = 0.1  # [m] radius of gyration of such a section
ALONG = "along"  # the section varies along the span: see blade.py
OF_MATERIAL = (
    "youngs_modulus",
    "density",
    "yield_stress",
)  # fields; other numbers of FIELDS have sliders
SECTION_NAMES = {
    "rectangle": "rectangle b × h, on edge",
    "flat": "rectangle b × h, flat",
    "tube": "tube",
    "own": "own A and I",
    ALONG: "varies along the span",
}

LIES = {
    "rectangle": "On its edge: the thickness h lies in the plane of rotation, the width b along the"
    " axis.",
    "flat": "Flat: the width b lies in the plane of rotation, the thickness h along the axis.",
}

# Materials and presets

# Usual values. Yield stress: S235 (EN 10025-2), EN AW-6061-T6 (EN 1999-1-1), Ti-6Al-4V (ASTM B265);
# glass fibre breaks without yielding.
MATERIALS = {
    "steel": {"youngs_modulus": 210e9, "density": 7850.0, "yield_stress": 235e6},
    "aluminium": {"youngs_modulus": 70e9, "density": 2700.0, "yield_stress": 240e6},
    "titanium": {"youngs_modulus": 110e9, "density": 4500.0, "yield_stress": 828e6},
    "glass fibre": {"youngs_modulus": 30e9, "density": 1900.0},
}
MATERIAL_NAMES = {**{name: name for name in MATERIALS}, "own": "own E and ρ"}


def in_si(values: Values) -> Values:
    """Values, with a second moment out of the plane of rotation, as keywords of `Beam.from_si`."""
    values = dict(values)
    flap, moment = values.pop("flap_moment"), values["second_moment"]
    if not math.isclose(flap, moment, rel_tol=ROUNDING):
        values["flap_stiffness"] = values["youngs_modulus"] * flap
    return values


class RealBeam(NamedTuple):
    """A beam to start from: source, keywords of `Beam.from_si` and kind of cross-section."""

    name: str
    source: str
    values: dict[str, float]
    section: str = "own"

    @property
    def beam(self) -> Beam:
        return Beam.from_si(**self.values)


STEEL = MATERIALS["steel"] | {"rotation_speed": 300 * RPM}
STEEL_BEAM = RealBeam(
    "steel beam",
    "A bar of rectangular section, 1000 x 30 x 5 mm, on its edge, without a mass, on a shaft at 300"
    " rpm. Steel as usually taken: E = 210 GPa (the value of EN 1993-1-1), 7850 kg/m³.",
    in_si(STEEL | on_edge(30e-3, 5e-3) | {"length": 1.0}),
    "rectangle",
)
RULER = RealBeam(
    "steel ruler",
    "A laboratory rule of a common size, 300 x 25 x 1 mm, on its edge, with a clip of 10 g at its"
    " tip, on a turntable. Steel as usually taken: E = 210 GPa (the value of EN 1993-1-1), 7850"
    " kg/m³.",
    in_si(STEEL | on_edge(25e-3, 1e-3) | {"length": 0.3, "mass": 0.01, "mass_position": 0.3}),
    "rectangle",
)
ARM = RealBeam(
    "spin-up arm",
    "A manipulator arm: the spin-up manoeuvre after Simo & Vu-Quoc (J. Appl. Mech. 53, 1986),"
    " with the values that many papers repeat: EI = 14 kN m², EA = 28 MN, 1.2 kg/m, 10 m, up to"
    " 6 rad/s. With E = 70 GPa the section follows.",
    in_si(
        own_section(area=4e-4, second_moment=2e-7)
        | {"density": 3000.0, "youngs_modulus": 70e9, "length": 10.0, "rotation_speed": 6.0}
    ),
)
BLADE = RealBeam(
    "wind blade",
    "A wind turbine blade made uniform: length, mass, hub and rated speed of the NREL 5 MW"
    " reference turbine (Jonkman et al., NREL/TP-500-38060, 2009). A glass-fibre section"
    " (E = 30 GPa, 1900 kg/m³: typical values) as stiff as gives its first flapwise frequency,"
    " 0.67 Hz, at rest. A real one tapers and twists.",
    in_si(
        MATERIALS["glass fibre"]
        | own_section(area=17740.0 / (1900.0 * 61.5), second_moment=0.197)
        | {"length": 61.5, "hub_radius": 1.5, "rotation_speed": 12.1 * RPM}
    ),
)
PRESETS = {real.name: real for real in (STEEL_BEAM, RULER, ARM, BLADE)}

# Edits


def entries(beam: Beam, kind: str = "own") -> Values:
    """The values of the fields in SI: keywords of `Beam.from_si`, of which an unknown yield stress
    is 0, area and second moments, and the dimensions of a kind of section, if it is that of the
    beam; {} where its material is not known."""
    if "area" not in (si := beam.si):
        return {}
    values = {name: si[name] for name in (*FIELDS, *STRENGTH) if name in si}
    values = {"yield_stress": 0.0, **values, PERCENT: beam.beta}
    flap = si.get("flap_stiffness", si["youngs_modulus"] * si["second_moment"])
    values["flap_moment"] = flap / si["youngs_modulus"]
    return values | sizes_of(values, kind)


def sizes_of(values: Values, kind: str) -> Values:
    """The dimensions of a kind of section with some area and second moments; {} without one."""
    section, own = SECTIONS[kind], [values[name] for name in SECTIONS["own"].sizes]
    try:
        sizes = section.of(*own)
    except ValueError:  # no tube has this area and second moment
        return {}
    is_same = math.isclose(section.values(*sizes)["flap_moment"], own[-1], rel_tol=SAME)
    return dict(zip(section.sizes, sizes, strict=True)) if is_same else {}


def of_section(values: Values, section: SectionKind, sizes: Iterable[float]) -> Values:
    """Values with the area, the second moments and the height, if it has one, of a section."""
    others = {name: value for name, value in values.items() if name != "section_height"}
    return others | section.values(*sizes)


def kind_of(beam: Beam, chosen: str) -> str:
    """The kind of section to show of a beam whose material is known: that which was chosen, if the
    beam has it; else a rectangle, if it has one, whose width is not below its thickness."""
    values = entries(beam)
    if values and chosen in SECTIONS and sizes_of(values, chosen):
        return chosen
    if not (values and (sizes := sizes_of(values, "rectangle"))):
        return "own"
    return "rectangle" if sizes["width"] >= sizes["thickness"] else "flat"


def field_of(name: str, units: Units, slenderness: float) -> tuple[str, float]:
    """The label of a field, and the SI value of its unit: lengths along the beam and the mass as on
    the page."""
    label, unit, size = FIELDS[name]
    if name in ALONG_BEAM and (found := display_unit("beta", units)):
        unit, size = found.unit, units.length / found.factor
    elif name == "mass" and units.mass and (found := display_unit("alpha", units)):
        unit, size = found.unit, units.mass / found.factor
    elif name in THICK and units.length / slenderness >= FAR:
        unit, size = THICK[name], 1.0
    return f"{label} [{unit}]", size


def edited(beam: Beam, name: str, value: Any, chosen: str = "") -> Beam:
    """The beam with one field set, in the unit of the field; the others keep their values. chosen:
    as for `kind_of`, of whose section there are fields. Raises InvalidInput, which names the field,
    the value and the values allowed in its unit."""
    kind = kind_of(beam, chosen)
    values, section = entries(beam, kind), SECTIONS[kind]
    if name not in values:  # the beam or its section was changed meanwhile
        return beam
    assert beam.units
    label, factor = field_of(name, beam.units, beam.mu)
    low = -MAX_VALUE if name in ("hub_radius", "angular_acceleration") else 0.0
    number = check_float(label, value, low, 100.0 if name == PERCENT else MAX_VALUE)
    if number < MIN_VALUE and name not in (*OPTIONAL, PERCENT):
        raise InvalidInput(f"{label} = {number:g}: must be above {MIN_VALUE if number else 0:g}")
    values[name] = number * factor
    if "wall" in values and values["wall"] > (1 + ROUNDING) * values["diameter"] / 2:
        raise InvalidInput(f"{label} = {value:g}: the wall is at most half the diameter")
    if name in section.sizes:
        values = of_section(values, section, [values[size] for size in section.sizes])
    return built(values)


def built(values: Values) -> Beam:
    """The beam of values in SI. Raises InvalidInput, in the units of the fields."""
    slenderness = values["length"] * math.sqrt(values["area"] / values["second_moment"])
    low, high = PARAMETERS["mu"].limits
    number = f"L √(A / I) = {slenderness:.4g}"
    if slenderness < low:
        raise InvalidInput(
            f"the beam is too thick for its length ({number} must be at least {low:g}): make it"
            " longer or thinner"
        )
    if slenderness > high:
        raise InvalidInput(
            f"the beam is too thin for its length ({number} must be at most {high:g}): make it"
            " shorter or thicker"
        )
    ratio = values["flap_moment"] / values["second_moment"]
    low, high = PROPERTY_LIMITS
    if not low <= ratio <= high:
        raise InvalidInput(
            f"second moment out of the plane of rotation over that in it = {ratio:.4g}: must lie in"
            f" {low:g} .. {high:g}"
        )
    si = in_si({name: values[name] for name in (*SI_REQUIRED, "flap_moment")})
    si |= {name: values[name] for name in STRENGTH if values.get(name)}
    units = PhysicalBeam.of(si).units
    assert units.mass
    max_gamma = min(PARAMETERS["gamma"].limits[1], MAX_GAMMA_OVER_MU * slenderness)
    checks: list[Callable[[], float]] = []
    for name, unit, limits in (
        ("hub_radius", units.length, PARAMETERS["delta"].limits),
        ("rotation_speed", 1 / units.time, (0.0, max_gamma)),
        ("angular_acceleration", 1 / units.time**2, NUMBERS["spin_up"].limits),
        ("mass", units.mass, PARAMETERS["alpha"].limits),
    ):
        label, factor = field_of(name, units, slenderness)
        low, high = (limit * unit / factor for limit in limits)
        checks.append(partial(check_float, label, values[name] / factor, low, high))
        si[name] = values[name]
    together(checks)
    si["mass_position"] = values[PERCENT] * values["length"]
    return Beam.of_physical(PhysicalBeam.of(si))


def with_section(beam: Beam, kind: str, chosen: str = "") -> Beam:
    """The beam with another kind of section than that of before, see `kind_of`: a rectangle is
    turned; else one of the same area and second moment in the plane, or if there is none, of the
    same thickness."""
    before = kind_of(beam, chosen)
    values, section = entries(beam, before), SECTIONS[kind]
    if not values or kind == before:
        return beam
    if {kind, before} == {*RECTANGLES}:
        sizes: Iterable[float] = (values["width"], values["thickness"])
    elif same := sizes_of(values, kind):
        sizes = same.values()  # the same but for its height
    else:
        try:
            sizes = section.of(values["area"], values["second_moment"], values["flap_moment"])
        except ValueError:
            thickness = math.sqrt(12 * values["second_moment"] / values["area"])
            sizes = thickness, thickness / 10
    return built(of_section(values, section, sizes))


def with_material(beam: Beam, name: str) -> Beam:
    """The beam of another material, unless its section is not known."""
    values = entries(beam)
    return built(values | {"yield_stress": 0.0} | MATERIALS[name]) if values else beam


def material(beam: Beam) -> str:
    """The name of the material with the modulus and density of a beam, else "own"."""
    for name, values in MATERIALS.items():
        pairs = [(beam.si[key], values[key]) for key in ("youngs_modulus", "density")]
        if all(math.isclose(own, usual, rel_tol=1e-6) for own, usual in pairs):
            return name
    return "own"


# The panel


@dataclass(frozen=True)
class RealBeamState(Slice):
    """What the panel shows."""

    # The kind of section whose dimensions it shows; "" for that which the beam tells.
    section: str = field(
        default="", metadata=choice(key=name_key("section", SECTION_NAMES), until=("scene",))
    )


def with_sizes(kind: str) -> Callable[[State], State]:
    """The edit that shows the dimensions of a kind of section."""
    return lambda state: state.with_values(RealBeamState, section=kind)


class RealBeamPanel(Feature):
    """The panel, of which the tables of a blade take the place while the section is ALONG."""

    state = RealBeamState

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        sizes = (name for section in SECTIONS.values() for name in section.sizes)
        for name in dict.fromkeys(("length", *OF_MATERIAL, *sizes)):
            self.page.on(f"real.{name}", partial(self.edit, name), float)
        self.page.on("real.preset", self.choose, str)
        self.page.on("real.material", self.choose_material, str)
        self.page.on("real.section", self.choose_section, str)
        self.page.on(
            "dimensionless", lambda _: self.load("", lambda beam: beam.replace(units=None))
        )

    def content(self, snapshot: Snapshot) -> Content:
        state = snapshot.state
        section = state.slice(RealBeamState).section
        panel = panel_content(state.case, section, state.refused)
        return panel | presets_content(state.case)

    def edit(self, name: str, value: Any) -> None:

        def edit(beam: Beam) -> Beam:
            return edited(beam, name, value, self.visitor.state.slice(RealBeamState).section)

        self.load(f"real.{name}", edit, value)

    def choose(self, name: Any) -> None:
        """Show a preset; an unknown one changes nothing."""
        if real := PRESETS.get(name):
            load(self.visitor, "", lambda _: real.beam, then=with_sizes(real.section))

    def choose_material(self, name: Any) -> None:
        """Set the material; "own" keeps the values, of which the first is to be typed then."""
        if name == "own":
            self.page.focus(field_id("youngs_modulus"))
        elif name in MATERIALS:
            key = "real.material"
            self.load(key, lambda beam: with_material(beam, name))

    def choose_section(self, kind: Any) -> None:
        if kind == ALONG:
            self.visitor.change(with_sizes(ALONG))
        elif kind in SECTIONS:

            def edit(beam: Beam) -> Beam:
                return with_section(beam, kind, self.visitor.state.slice(RealBeamState).section)

            load(self.visitor, "real.section", edit, then=with_sizes(kind))

    def load(self, key: str, edit: Callable[[Beam], Beam], entry: Any = "") -> None:
        load(self.visitor, key, edit, entry)


def load(
    visitor: Visitor,
    key: str,
    edit: Callable[[Beam], Beam],
    entry: Any = "",
    then: Callable[[State], State] = lambda state: state,
) -> None:
    """Show another beam, made of that of the state, in the state `then(state)`, with the kind of
    section of before, in both planes where its section is turned; or refuse the entry of the field
    with this key."""
    with visitor.lock:
        state = visitor.state
        scene = replace(state, case=state.case.nearest).to_scene()
        try:
            beam = edit(scene.beam)
        except InvalidInput as error:
            refused = Refused(key, str(entry), str(error))
            visitor.change(lambda state: replace(state, refused=refused))
            return
        if beam == scene.beam:
            visitor.change(then)
        else:
            changed = replace(scene, beam=beam, camera=None)
            if beam.is_turned:
                changed = replace(changed, options={**changed.options, "plane": "both"})
            kept = with_sizes(state.slice(RealBeamState).section)
            visitor.change(lambda state: then(kept(state.loaded(changed))), loads=True)


def panel_content(case: Case, section: str, refused: Refused | None) -> Content:
    """The values of the beam, of the nearest one where a number is out of range; a refused entry
    with the reason."""
    beam = case.nearest_beam()
    if beam.physical and in_tables(beam, section):
        return page.html("real-beam", "")  # it has a panel of its own
    if beam.units is None or not entries(beam):
        return page.html("real-beam", invitation(beam))
    kind = kind_of(beam, section)
    content = page.html("real-beam", panel(kind, beam, refused))
    content |= page.value("real.section", kind) | page.value("real.material", material(beam))
    for name, number in entries(beam, kind).items():
        if name not in FIELDS:
            continue
        key = f"real.{name}"
        shown: Any = float(f"{number / field_of(name, beam.units, beam.mu)[1]:.{DIGITS}g}")
        if name == "yield_stress" and not number:
            shown = ""
        if refused and refused.key == key:
            shown = refused.entry
        content |= page.value(key, shown)
    return content


def in_tables(beam: Beam, section: str) -> bool:
    """Whether a beam with a size is described by the tables of a blade (blade.py), which take the
    place of this panel: where they are chosen, or the panel has not what it is."""
    assert beam.units
    return section == ALONG or not beam.is_prismatic or beam.units.youngs_modulus is None


@cache
def values_of_presets() -> dict[str, dict[str, Any]]:
    """The values of all presets in SI, by their names."""
    return {name: one.beam.si for presets in (PRESETS, BLADES) for name, one in presets.items()}


def preset_of(beam: Beam) -> str:
    """The name of the preset with the numbers of a beam, to the digits shown; "" for none."""
    own = beam.si

    def has(key: str, value: Any) -> bool:
        return np.shape(own[key]) == np.shape(value) and np.allclose(own[key], value, 1e-7, 0.0)

    for name, values in values_of_presets().items():
        if own.keys() == values.keys() and all(map(has, values.keys(), values.values())):
            return name
    return ""


def presets_content(case: Case) -> Content:
    """The preset that is marked as chosen."""
    chosen = preset_of(case.beam) if case.in_range else ""
    blade = chosen if chosen in BLADES else ""
    return page.value("real.preset", chosen) | page.value("blade.preset", blade)


CHOSEN = ("", "real.section", "real.material")  # that are no fields
BLADE_TITLES = {"": "a blade…"} | {name: blade.title for name, blade in BLADES.items()}
BUTTONS = "".join(
    page.button(name, data_set="real.preset", data_value=name, title=real.source)
    for name, real in PRESETS.items()
) + (
    '<select data-set="blade.preset" aria-label="blades to start from">'
    f"{page.options(BLADE_TITLES)}</select>"
)
OWN_BLADE = page.button("your blade", data_do="blade.begin")
# It takes any file, as blade files have all kinds of suffixes, and two at once: a main file and
# the file of sections that it names.
OPEN_FILE = (
    '<label class="button" for="blade-file">open a blade file</label>'
    '<input type="file" id="blade-file" class="hidden" data-do="blade.file" multiple>'
)
AS_AT_ROOT = page.button("uniform, as at the root", data_do="blade.uniform")


def invitation(beam: Beam) -> str:
    """The panel of a beam without a size: open for one that is not uniform, with what is not, as
    other panels had that before."""
    own = page.attributes(class_="real", open=not beam.is_uniform)
    structure = f"<p>This beam has: {escape(', '.join(beam.structure))}.</p>"
    structure += f'<div class="choices">{AS_AT_ROOT}</div>'
    return (
        f"<details{own}><summary>Real beam (m, kg, rpm, Hz)</summary>"
        f"{'' if beam.is_uniform else structure}"
        "<p>Numbers are dimensionless. For SI units, choose a real beam and set its dimensions:</p>"
        f'<div class="choices">{BUTTONS}{OWN_BLADE}{OPEN_FILE}</div>'
        "</details>"
    )


def field_id(name: str) -> str:
    return f"real.{name}-field"


def number_field(name: str, beam: Beam, refused: Refused | None) -> str:
    """A field, below it the reason why its last entry was refused."""
    assert beam.units
    key, label, reason = f"real.{name}", escape(field_of(name, beam.units, beam.mu)[0]), ""
    own: dict[str, Any] = {}
    if refused and refused.key == key:
        own = {"aria_invalid": True, "aria_describedby": "refused"}
        reason = f'<p id="refused" class="note" role="alert">{escape(refused.reason)}</p>'
    box = page.number_box(field_id(name), key, **own)
    return f'<div class="field"><label for="{field_id(name)}">{label}</label>{box}{reason}</div>'


def panel(kind: str, beam: Beam, refused: Refused | None = None) -> str:
    """The fields of a real beam."""
    units = beam.units
    assert units
    assert units.mass
    field = partial(number_field, beam=beam, refused=refused)
    return (
        '<details class="real" open><summary>Real beam</summary>'
        f'<div class="choices">{BUTTONS}{OWN_BLADE}{OPEN_FILE}'
        f"{page.button('dimensionless', data_do='dimensionless')}</div>"
        f"{field('length')}{page.select('real.section', 'section', SECTION_NAMES)}"
        f"{''.join(map(field, SECTIONS[kind].sizes))}"
        f"{page.select('real.material', 'material', MATERIAL_NAMES)}"
        f"{''.join(map(field, OF_MATERIAL))}"
        f"<p>{LIES.get(kind, '')}</p>"
        f"{page.note(refused.reason if refused and refused.key in CHOSEN else '')}"
        f"{''.join(map(page.note, beam.doubts))}"
        f"<p>γ = {beam.gamma:.4g}, μ = {beam.mu:.4g}, T* = {si_text(units.time, 's', 4)},"
        f" mass of the beam {si_text(units.mass, 'kg', 4)}</p></details>"
    )
