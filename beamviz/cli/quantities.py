"""Quantities on the command line: a dimensionless number, or of a beam whose size is known one with
its unit, as 2s, 300rpm or 50N."""

from functools import partial
from typing import Any

import typer

from beamviz.beam import Beam
from beamviz.cli.options import option
from beamviz.conversions import CONVERSIONS, GivenQuantity, parse_quantity
from beamviz.errors import InvalidInput
from beamviz.units import Units

UNITS = {  # of each kind of quantity, their sizes in SI
    "time": CONVERSIONS["s"],
    "speed": CONVERSIONS["rad/s"],
    "force": CONVERSIONS["N"],
}


def parse_option(text: str) -> GivenQuantity:
    """A number, perhaps with a unit; typer.BadParameter for anything else."""
    given = parse_quantity(str(text))
    if given:
        return given
    try:
        return GivenQuantity(float(text), "")  # one that is not finite, which the range refuses
    except ValueError:
        raise typer.BadParameter(f"{text!r} is not a number, nor one with a unit") from None


def quantity(kind: str, help: str) -> Any:
    """An option of this kind."""
    return option(help, parser=parse_option, metavar=f"NUMBER[{'|'.join(UNITS[kind])}]")


time, speed, force = (partial(quantity, kind) for kind in UNITS)


def dimensionless(name: str, given: GivenQuantity | float | None, kind: str, beam: Beam) -> Any:
    """The dimensionless number of a quantity, None of None. Raises InvalidInput for a unit of
    another kind, or of a beam whose size is not known."""
    if not isinstance(given, GivenQuantity):
        return given
    if not given.unit:
        return given.value
    shown = f"--{name} {given.value:g}{given.unit}"
    if given.unit not in UNITS[kind]:
        raise InvalidInput(f"{shown}: a {kind} is in {', '.join(UNITS[kind])}, or dimensionless")
    size = unit_of(kind, beam.units) if beam.units else None
    if size is None:
        raise InvalidInput(f"{shown}: the size of the beam is not known; give it in SI units: --si")
    return given.value * UNITS[kind][given.unit] / size


def unit_of(kind: str, units: Units) -> float | None:
    """The dimensionless 1 of a kind of quantity in SI; None of a force where the mass is not
    known."""
    return {"time": units.time, "speed": 1 / units.time, "force": units.force}[kind]
