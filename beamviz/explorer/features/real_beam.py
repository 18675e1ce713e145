"""Real beams in SI units: three presets with their sources, and the form for their values."""

import math
from dataclasses import dataclass, replace
from functools import partial
from html import escape
from typing import Any

from beamviz.beam import MAX_GAMMA_OVER_MU, PARAMETERS, SI_REQUIRED, Beam, check_float
from beamviz.errors import InvalidInput
from beamviz.explorer.page.html import BAD, small
from beamviz.explorer.visitor import Visitor, on_edit, show
from beamviz.scene import Scene

RPM = 0.10471975511965977  # [rad/s]


@dataclass(frozen=True)
class RealBeam:
    """A beam in SI units, the keywords of `Beam.from_si`; `plane` is where it vibrates first."""

    name: str
    source: str
    plane: str
    values: dict[str, float]

    @property
    def beam(self) -> Beam:
        """The beam."""
        return Beam.from_si(**self.values)


RULER = RealBeam(
    "steel ruler",
    "A laboratory rule of a common size, 300 x 25 x 1 mm, with a clip of 10 g at its tip, on a"
    " turntable. Steel as usually taken: E = 210 GPa (the value of EN 1993-1-1), 7850 kg/m³.",
    "chordwise",
    {
        "length": 0.3,
        "density": 7850.0,
        "area": 25e-3 * 1e-3,
        "second_moment": 25e-3 * 1e-9 / 12,
        "youngs_modulus": 210e9,
        "rotation_speed": 300 * RPM,
        "mass": 0.01,
        "mass_position": 0.3,
    },
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
REAL_BEAMS = (RULER, ARM, BLADE)

# For each keyword of `Beam.from_si`: its label, and the SI value of its unit.
FIELDS = {
    "length": ("length L [mm]", 1e-3),
    "area": ("section area A [mm²]", 1e-6),
    "second_moment": ("second moment I [mm⁴]", 1e-12),
    "youngs_modulus": ("Young's modulus E [GPa]", 1e9),
    "density": ("density ρ [kg/m³]", 1.0),
    "hub_radius": ("hub radius a [mm]", 1e-3),
    "rotation_speed": ("rotation speed Ω [rpm]", RPM),
    "mass": ("mass m [kg]", 1.0),
    "mass_position": ("mass at d [mm]", 1e-3),
}
MAX_VALUE = 1e12  # in the unit of a field
REAL_BEAM, DIMENSIONLESS = "real beam ...", "none"
PRESETS: dict[Any, RealBeam] = {real.name: real for real in REAL_BEAMS}


class RealBeamForm:
    """Buttons that open the form or return to dimensionless numbers, and the form, a modal window.

    texts: the entries by field.
    """

    def __init__(self, visitor: Visitor):
        self.visitor, self.gui = visitor, visitor.client.gui
        self.texts: dict[str, Any] = {}
        self.window: Any = None
        hint = "A real beam is shown in kg, mm, rpm and Hz"
        units = self.gui.add_button_group("units", (DIMENSIONLESS, REAL_BEAM), hint=hint)
        units.on_click(lambda event: self.choose(event.target.value))

    def choose(self, units: Any) -> None:
        """Open the form in place of an open one, or show the same beam without units."""
        if units == REAL_BEAM:
            with self.visitor.lock:
                self.close()
                self.open()
        elif units == DIMENSIONLESS and self.visitor.state.case.units:
            scene = current_scene(self.visitor)
            self.visitor.load(replace(scene, beam=scene.beam.replace(units=None)))

    def open(self) -> None:
        """Open the form with the first preset."""
        gui, self.window = self.gui, self.gui.add_modal("A real beam")
        with self.window:
            presets = gui.add_button_group("start from", tuple(PRESETS))  # a dropdown would open
            presets.on_click(lambda event: self.fill(event.target.value))
            self.source = gui.add_html("")
            self.fields = {name: gui.add_text(label, "") for name, (label, _) in FIELDS.items()}
            self.error = gui.add_html("")
            gui.add_button("Show this beam").on_click(lambda _: self.apply())
            gui.add_button("Cancel", color="gray").on_click(lambda _: self.close())
        for name, field in self.fields.items():
            on_edit(field, partial(self.texts.__setitem__, name))
        self.fill(REAL_BEAMS[0].name)

    def fill(self, name: Any) -> None:
        """Fill in a preset, one without a mass with the tip as its position; an unknown name
        changes nothing."""
        if name not in PRESETS:
            return
        real = PRESETS[name]
        self.plane = real.plane
        self.source.content = small(escape(real.source))
        defaults = {"hub_radius": 0.0, "mass": 0.0, "mass_position": real.values["length"]}
        for key, value in {**defaults, **real.values}.items():
            self.texts[key] = f"{value / FIELDS[key][1]:.10g}"
            show(self.fields[key], self.texts[key])
        self.error.content = ""

    def apply(self) -> None:
        """Show the beam entered, or say what is wrong with it."""
        try:
            beam = parse_beam(self.texts)
        except InvalidInput as error:
            message = f'<span style="color:{BAD}">{escape(str(error))}</span>'
            self.error.content = small(message, "alert")
            return
        scene = current_scene(self.visitor)
        options = {**scene.options, "plane": self.plane}
        self.visitor.load(replace(scene, beam=beam, options=options, camera=None))
        self.close()

    def close(self) -> None:
        """Close the window, if it is open."""
        if self.window and not self.window.closed:
            self.window.close()


def current_scene(visitor: Visitor) -> Scene:
    """The scene as it is; the default one where a number is out of range."""
    try:
        return visitor.to_scene()
    except InvalidInput:
        return Scene()


def parse_beam(texts: dict[str, Any]) -> Beam:
    """The beam of the entries. Raises InvalidInput, which names a field, its entry and the values
    allowed, in the unit of the field."""
    values = {}
    for name, (label, _) in FIELDS.items():
        try:
            values[name] = float(texts[name])
        except (TypeError, ValueError):
            entry = f"{label} = {texts[name]!r}"
            raise InvalidInput(f"{entry}: must be a number, as 12.5 or 2.1e5") from None
    for name in SI_REQUIRED:
        label = FIELDS[name][0]
        if check_float(label, values[name], 0.0, MAX_VALUE) == 0:
            raise InvalidInput(f"{label} = 0: must be above 0")
    si: dict[str, Any] = {name: value * FIELDS[name][1] for name, value in values.items()}
    slenderness = si["length"] * math.sqrt(si["area"] / si["second_moment"])
    low, high = PARAMETERS["mu"].limits
    if not low <= slenderness <= high:
        raise InvalidInput(f"L √(A / I) = {slenderness:.4g}: must lie in {low:g} .. {high:g}")
    for name, (low, high) in si_limits({name: si[name] for name in SI_REQUIRED}).items():
        label, unit = FIELDS[name]
        check_float(label, values[name], low / unit, high / unit)
    return Beam.from_si(**si)


def si_limits(required: dict[str, Any]) -> dict[str, tuple[float, float]]:
    """Limits, in SI, of the hub, the speed and the mass of a beam with these `required` values."""
    bare = Beam.from_si(**required)
    assert bare.units
    assert bare.units.mass
    length, mass, time = bare.units.length, bare.units.mass, bare.units.time
    low, high = PARAMETERS["delta"].limits
    max_gamma = min(PARAMETERS["gamma"].limits[1], MAX_GAMMA_OVER_MU * bare.mu)
    return {
        "hub_radius": (low * length, high * length),
        "rotation_speed": (0.0, max_gamma / time),
        "mass": (0.0, PARAMETERS["alpha"].limits[1] * mass),
        "mass_position": (0.0, length),
    }
