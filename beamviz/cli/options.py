"""The options every command with a beam shares: the five numbers or an SI file, and the model."""

import functools
import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from beamviz.beam import PARAMETERS, Beam
from beamviz.errors import InvalidInput

if TYPE_CHECKING:
    from beamviz.scene import Scene

KEYWORD = inspect.Parameter.KEYWORD_ONLY


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


def numeric_triple(name: str, help: str) -> Any:
    """An option that takes three numbers between commas."""
    return typer.Option(name, help=help, parser=triple, metavar="X,Y,Z")


def triple(text: str) -> tuple[float, float, float]:
    """Three numbers between commas."""
    parts = [number(part) for part in text.split(",")]
    if len(parts) != 3 or not all(isinstance(x, int | float) and math.isfinite(x) for x in parts):
        raise typer.BadParameter(f"{text}: must be three numbers between commas, as 0,-1,0.5")
    x, y, z = map(float, parts)
    return x, y, z


def beam_number(name: str) -> Any:
    """The option for one of the five numbers; Beam has its default."""
    parameter = PARAMETERS[name]
    low, high = parameter.limits
    meaning = f"{parameter.label.capitalize()} {parameter.definition}, {low:g} .. {high:g}"
    return numeric(f"{meaning} (default {parameter.default:g}).", rich_help_panel="Beam")


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

    return declared(wrapper, [own[name] for name in own if name not in ("beam", "options")], shared)


def seen(help: str, *names: str, **settings: Any) -> Any:
    """An option that chooses what is seen."""
    return typer.Option(*names, help=help, rich_help_panel="Scene", **settings)


def scene_and_changes(
    scene: Annotated[
        Path | None,
        seen("A scene saved by the explorer; other options go before it.", metavar="FILE.toml"),
    ] = None,
    lesson: Annotated[
        str | None, seen("The scene of a lesson, in place of a file.", metavar="NAME")
    ] = None,
    mode: Annotated[
        int | None, seen("Mode to show alone (default 2).", parser=number, metavar="NUMBER")
    ] = None,
    dark: Annotated[bool | None, seen("Background (default light).", "--dark/--light")] = None,
) -> tuple["Scene", dict[str, Any]]:
    """The scene of a file, of a lesson or the usual one, and what is to be changed in it."""
    from beamviz.scene import Scene

    if scene and lesson:
        raise InvalidInput(f"--scene {scene} and --lesson {lesson} exclude each other")
    changes = {"mode": mode, "dark": dark}
    changed = {name: value for name, value in changes.items() if value is not None}
    if lesson:
        from beamviz import lessons

        return lessons.lesson(lesson).scene, changed
    return Scene.from_toml(scene) if scene else Scene(), changed


def takes_scene(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options of scene and beam; it receives a `scene` made of them."""
    of_scene = inspect.signature(scene_and_changes).parameters
    of_beam = inspect.signature(beam_and_model).parameters
    own = inspect.signature(command).parameters

    @functools.wraps(command)
    def wrapper(context: typer.Context, **values: Any) -> None:
        seen = {name: values.pop(name) for name in of_scene}
        seen["scene"] = values.pop("scene_file", None) or seen["scene"]
        scene, changes = scene_and_changes(**seen)
        numbers_and_model = {name: values.pop(name) for name in of_beam}
        beam, _ = beam_and_model(**numbers_and_model)  # where --si excludes the numbers
        if numbers_and_model.pop("si"):
            scene = replace(scene, beam=beam)
        given = {k: v for k, v in numbers_and_model.items() if named(context, k)}
        command(scene=scene.changed(**given, **changes), **values)

    context = inspect.Parameter("context", KEYWORD, annotation=typer.Context)
    listed = [context, *(own[name] for name in own if name != "scene")]
    return declared(wrapper, listed, {**of_scene, **of_beam})


def named(context: typer.Context, name: str) -> bool:
    """Whether the command line gives an option, be it with its usual value."""
    source = context.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"


def declared(
    wrapper: Callable[..., None],
    own: Sequence[inspect.Parameter],
    shared: Mapping[str, inspect.Parameter],
) -> Callable[..., None]:
    """`wrapper` as a command with its own parameters and the shared ones."""
    every = [entry.replace(kind=KEYWORD) for entry in (*own, *shared.values())]
    wrapper.__signature__ = inspect.Signature(every)  # type: ignore[attr-defined]
    return wrapper
