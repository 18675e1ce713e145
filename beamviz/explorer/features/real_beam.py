"""A window to enter a real beam: one of three to start from, its sizes, and what is wrong."""

import math
from dataclasses import replace
from html import escape
from typing import Any

from viser import GuiInputHandle

from beamviz.beam import MAX_GAMMA_OVER_MU, PARAMETERS, SI_REQUIRED, Beam, check_float
from beamviz.errors import InvalidInput
from beamviz.explorer.visitor import Visitor
from beamviz.explorer.visitor import show as assign
from beamviz.presets import REAL_BEAMS, RPM, RealBeam
from beamviz.scene import Scene

# For each keyword of `Beam.from_si`: its label, and one of its units in SI.
FIELDS = {
    "length": ("length L [mm]", 1e-3),
    "area": ("section area A [mm²]", 1e-6),
    "second_moment": ("second moment I [mm⁴]", 1e-12),
    "youngs_modulus": ("Young's modulus E [GPa]", 1e9),
    "density": ("density ρ [kg/m³]", 1.0),
    "hub_radius": ("hub radius a [mm]", 1e-3),
    "rotation_speed": ("turns Ω [rpm]", RPM),
    "mass": ("mass m [kg]", 1.0),
    "mass_position": ("mass at d [mm]", 1e-3),
}
LARGEST = 1e12  # in the unit of a field
OPEN, PLAIN = "real beam ...", "none"
SMALL = "font-size:.8em;line-height:1.45;margin:.2em .75em .4em"


class RealBeams:
    """Enter a real beam, and leave its units again."""

    def __init__(self, visitor: Visitor):
        self.visitor, gui = visitor, visitor.client.gui
        units = gui.add_button_group(
            "units", (PLAIN, OPEN), hint="A real beam is shown in kg, mm, rpm and Hz"
        )
        units.on_click(lambda event: self.choose(event.target.value))
        self.form: Form | None = None

    def choose(self, units: Any) -> None:
        """Without units, or those of a real beam."""
        if units == PLAIN:
            self.leave()
        elif units == OPEN:
            self.open()

    def open(self) -> None:
        """The window, in place of one that is open."""
        with self.visitor.lock:
            if self.form:
                self.form.close()
            self.form = Form(self.visitor)

    def leave(self) -> None:
        """The same beam without units."""
        scene = current(self.visitor)
        if scene.beam.units:
            self.visitor.load(replace(scene, beam=scene.beam.replace(units=None)))


class Form:
    """The window."""

    def __init__(self, visitor: Visitor):
        self.visitor, self.plane = visitor, REAL_BEAMS[0].plane
        gui = visitor.client.gui
        self.window = gui.add_modal("A real beam")
        with self.window:
            names = tuple(one.name for one in REAL_BEAMS)
            start = gui.add_button_group("start from", names)  # a list would open by itself
            start.on_click(lambda event: self.start(event.target.value))
            self.source = gui.add_html("")
            self.fields: dict[str, GuiInputHandle[str]] = {
                name: gui.add_text(label, "") for name, (label, _) in FIELDS.items()
            }
            self.trouble = gui.add_html("")
            gui.add_button("Show this beam").on_click(lambda _: self.apply())
            gui.add_button("Cancel", color="gray").on_click(lambda _: self.close())
        self.fill(REAL_BEAMS[0])

    def start(self, name: Any) -> None:
        """Another beam to start from."""
        for one in REAL_BEAMS:
            if one.name == name:
                self.fill(one)

    def fill(self, real: RealBeam) -> None:
        """Put a beam into the fields; its mass is at the tip where it has none."""
        self.plane = real.plane
        self.source.content = f'<div style="{SMALL};opacity:.8">{escape(real.source)}</div>'
        values = {"hub_radius": 0.0, "mass": 0.0, "mass_position": real.values["length"]}
        values |= real.values
        for name, (_, unit) in FIELDS.items():
            assign(self.fields[name], f"{values[name] / unit:.10g}")
        self.trouble.content = ""

    def apply(self) -> None:
        """Show the beam in the fields, or say what is wrong with it."""
        try:
            beam = made({name: box.value for name, box in self.fields.items()})
        except InvalidInput as error:
            self.trouble.content = (
                f'<div role="alert" style="{SMALL};color:#d9480f">{escape(str(error))}</div>'
            )
            return
        scene = current(self.visitor)
        options = {**scene.options, "plane": self.plane}
        self.visitor.load(replace(scene, beam=beam, options=options, camera=None))
        self.close()

    def close(self) -> None:
        """Take the window away."""
        if not self.window.closed:
            self.window.close()


def current(visitor: Visitor) -> Scene:
    """The scene as it is; the usual one where what is set is none."""
    try:
        return visitor.to_scene()
    except InvalidInput:
        return Scene()


def made(texts: dict[str, Any]) -> Beam:
    """The beam of the fields; InvalidInput names a field, in its own unit, and what is allowed."""
    values: dict[str, Any] = read(texts)
    for name in SI_REQUIRED:
        if check_float(FIELDS[name][0], number(FIELDS[name][0], texts[name]), 0.0, LARGEST) == 0:
            raise InvalidInput(f"{FIELDS[name][0]} = 0: must be above 0")
    slenderness = values["length"] * math.sqrt(values["area"] / values["second_moment"])
    low, high = PARAMETERS["mu"].limits
    if not low <= slenderness <= high:
        raise InvalidInput(f"L √(A / I) = {slenderness:.4g}: must lie in {low:g} .. {high:g}")
    bare = Beam.from_si(**{name: values[name] for name in SI_REQUIRED})
    for name, (low, high) in ranges(bare).items():
        label, unit = FIELDS[name]
        check_float(label, number(label, texts[name]), low / unit, high / unit)
    return Beam.from_si(**values)


def ranges(bare: Beam) -> dict[str, tuple[float, float]]:
    """What a beam allows, in SI, of the hub, the speed and the mass it is given."""
    assert bare.units
    assert bare.units.mass
    fastest = min(PARAMETERS["gamma"].limits[1], MAX_GAMMA_OVER_MU * bare.mu)
    low, high = PARAMETERS["delta"].limits
    return {
        "hub_radius": (low * bare.units.length, high * bare.units.length),
        "rotation_speed": (0.0, fastest / bare.units.time),
        "mass": (0.0, PARAMETERS["alpha"].limits[1] * bare.units.mass),
        "mass_position": (0.0, bare.units.length),
    }


def read(texts: dict[str, Any]) -> dict[str, float]:
    """The fields as keywords of `Beam.from_si`; InvalidInput names the one that is no number."""
    return {name: number(label, texts[name]) * unit for name, (label, unit) in FIELDS.items()}


def number(label: str, text: Any) -> float:
    """The number in a field."""
    try:
        return float(text)
    except (TypeError, ValueError):
        raise InvalidInput(f"{label} = {text!r}: must be a number, as 12.5 or 2.1e5") from None
