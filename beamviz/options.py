"""The options every command with a beam shares: the five numbers or an SI file, and the model."""

import functools
import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from beamviz.beam import LIMITS, NAMES, Beam
from beamviz.errors import InvalidInput

DEFINITIONS = {
    "alpha": "m / (rho A L)",
    "beta": "d / L",
    "gamma": "Omega T*",
    "delta": "a / L",
    "mu": "sqrt(A L^2 / I)",
}


def number(text: str | float) -> float | str:
    """A number, or the text as it is: the check that knows the range names both."""
    for kind in (int, float):
        try:
            return kind(str(text))  # a default comes as a number, and int() would cut it off
        except ValueError:
            continue
    return text


def numeric(help: str, **settings: Any) -> Any:
    """An option that takes a number; what uses it checks its range."""
    return typer.Option(help=help, parser=number, metavar="NUMBER", **settings)


def beam_number(name: str) -> Any:
    """The option for one of the five numbers; Beam has its default."""
    low, high = LIMITS[name]
    default = getattr(Beam, name)
    meaning = f"{NAMES[name].capitalize()} {DEFINITIONS[name]}, {low:g} .. {high:g}"
    return numeric(f"{meaning} (default {default:g}).", rich_help_panel="Beam")


def model(help: str) -> Any:
    """An option that chooses the model."""
    return typer.Option(help=help, rich_help_panel="Model")


def beam_and_model(
    alpha: Annotated[float | None, beam_number("alpha")] = None,
    beta: Annotated[float | None, beam_number("beta")] = None,
    gamma: Annotated[float | None, beam_number("gamma")] = None,
    delta: Annotated[float | None, beam_number("delta")] = None,
    mu: Annotated[float | None, beam_number("mu")] = None,
    si: Annotated[
        Path | None,
        typer.Option(
            help="TOML file with the beam in SI units, in place of the five numbers.",
            metavar="FILE.toml",
            rich_help_panel="Beam",
        ),
    ] = None,
    method: Annotated[
        Literal[
            "auto",
            "ancf",
            "ancf-planar",
            "linear",
            "foac",
            "zoac",
            "assumed-modes",
            "power-series",
            "chebyshev",
        ],
        model(
            "auto: as accurate as --tolerance asks; ancf: the paper's cubic elements;"
            " ancf-planar: the same with all unknowns at once; linear: prestressed linear"
            " elements; foac, zoac: first-order and no coupling of stretch and bending;"
            " assumed-modes, power-series: foac by classical means; chebyshev: collocation."
        ),
    ] = "auto",
    strain: Annotated[
        Literal["green", "biot", "hencky"], model("Axial strain; the paper's is green.")
    ] = "green",
    curvature: Annotated[
        Literal["spatial", "material"], model("Curvature measure; spatial is the paper's eq. 16.")
    ] = "spatial",
    coriolis: Annotated[
        bool, model("The gyroscopic term 2 gamma G q', which the paper leaves out.")
    ] = False,
    plane: Annotated[
        Literal["chordwise", "flapwise"], model("Vibration in the plane of rotation, or out of it.")
    ] = "chordwise",
    elements: Annotated[
        int | None,
        numeric("Elements of ancf, ancf-planar and linear (default 20).", rich_help_panel="Model"),
    ] = None,
    terms: Annotated[
        int | None,
        numeric(
            "Terms of assumed-modes (default 10), power-series (80) and chebyshev (32).",
            rich_help_panel="Model",
        ),
    ] = None,
    tolerance: Annotated[
        float,
        numeric("Relative error asked of each frequency.", rich_help_panel="Model"),
    ] = 1e-6,
) -> tuple[Beam, dict[str, Any]]:
    """The beam, and the keywords of solve() that describe its model."""
    numbers = {"alpha": alpha, "beta": beta, "gamma": gamma, "delta": delta, "mu": mu}
    given: dict[str, Any] = {name: value for name, value in numbers.items() if value is not None}
    options = {
        "method": method,
        "strain": strain,
        "curvature": curvature,
        "coriolis": coriolis,
        "plane": plane,
        "elements": elements,
        "terms": terms,
        "tolerance": tolerance,
    }
    if si is None:
        return Beam(**given), options
    if given:
        name, value = next(iter(given.items()))
        raise InvalidInput(
            f"--{name} {value} and --si {si} exclude each other: the file gives all five numbers"
        )
    return Beam.from_toml(si), options


def takes_beam(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the shared options; it receives `beam` and `options` made of them."""
    shared = inspect.signature(beam_and_model).parameters
    own = inspect.signature(command).parameters

    @functools.wraps(command)
    def wrapper(**values: Any) -> None:
        beam, options = beam_and_model(**{name: values.pop(name) for name in shared})
        command(beam=beam, options=options, **values)

    listed = [own[name] for name in own if name not in ("beam", "options")]
    wrapper.__signature__ = inspect.Signature([*listed, *shared.values()])  # type: ignore[attr-defined]
    return wrapper
