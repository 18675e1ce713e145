"""Options that several commands share: the beam, its model and the scene."""

import functools
import inspect
import math
import re
import sys
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from beamviz.beam import NUMBERS, Beam, check_float, check_int, exact_text
from beamviz.errors import InvalidInput

if TYPE_CHECKING:
    from beamviz.scene import Scene

Elements = Literal["ancf", "ancf-planar", "linear"]
Method = Literal["auto", Elements, "foac", "zoac", "assumed-modes", "power-series", "chebyshev"]
MAX_POINTS = 10_000  # of a sweep
ASCII = str.maketrans({"ρ": "rho", "Ω": "Omega", "√": "sqrt", "²": "^2"})
FILE_HELP = "TOML file with the beam in SI units, in place of these numbers."
TERMS_HELP = "Terms of assumed-modes (default 10), power-series (80) and chebyshev (32)."
SCENE_HELP = "A scene saved by the explorer; other options override it."
STRAIN_HELP = "Axial strain; the paper's is green."
CURVATURE_HELP = "Curvature measure; spatial is the paper's eq. 16."
PLANE_HELP = "Vibration in the plane of rotation, or out of it."
CORIOLIS_HELP = "The gyroscopic term 2 gamma G q', which the paper leaves out."
ELEMENTS_HELP = "Elements of ancf, ancf-planar and linear (default 20)."
TOLERANCE_HELP = "Relative error asked of each frequency."
DARK_HELP = "Background (default light)."
METHOD_HELP = (
    "auto: as accurate as --tolerance asks; ancf: the paper's cubic elements; ancf-planar: the same"
    " with the full planar tangent; linear: prestressed linear elements; foac, zoac: first-order"
    " and no coupling of stretch and bending; assumed-modes, power-series: classical solutions of"
    " foac; chebyshev: collocation."
)
STATE_HELP = (
    "Equilibrium to vibrate about; stable: the straight one if it is stable, else the bent."
)


def parse_number(text: str | float) -> float | str:
    """A number; other text is returned as it is, for the range check to name it."""
    for kind in (int, float):
        try:
            return kind(str(text))  # int() of a default such as 0.25 would truncate it
        except ValueError:
            continue
    return text


def option(help: str, *names: str, panel: str | None = None, **settings: Any) -> Any:
    """An option, by default named like its argument; panel: its group in the help."""
    return typer.Option(*names, help=help, rich_help_panel=panel, **settings)


# An option that takes a number (the function that uses it checks the range), and two groups.
number = functools.partial(option, parser=parse_number, metavar="NUMBER")
model = functools.partial(option, panel="Model")
scene_option = functools.partial(option, panel="Scene")


def parse_triple(text: str) -> tuple[float, float, float]:
    """Three comma-separated numbers; typer.BadParameter for anything else."""
    parts = [parse_number(part) for part in text.split(",")]
    if len(parts) != 3 or not all(isinstance(x, int | float) and math.isfinite(x) for x in parts):
        raise typer.BadParameter(f"{text}: must be three numbers between commas, as 0,-1,0.5")
    x, y, z = map(float, parts)
    return x, y, z


def parameter(name: str) -> Any:
    """The option of one of the beam's numbers."""
    one = NUMBERS[name]
    formula, (low, high) = one.formula.translate(ASCII), one.limits
    limits = f"{low:g} .. {high:g} (default {getattr(Beam, name):g})"
    return number(f"{one.label.capitalize()} {formula}, {limits}.", panel="Beam")


def beam_and_model(
    alpha: Annotated[float | None, parameter("alpha")] = None,
    beta: Annotated[float | None, parameter("beta")] = None,
    gamma: Annotated[float | None, parameter("gamma")] = None,
    delta: Annotated[float | None, parameter("delta")] = None,
    mu: Annotated[float | None, parameter("mu")] = None,
    spin_up: Annotated[float | None, parameter("spin_up")] = None,
    si: Annotated[Path | None, option(FILE_HELP, metavar="FILE.toml", panel="Beam")] = None,
    method: Annotated[Method, model(METHOD_HELP)] = "auto",
    strain: Annotated[Literal["green", "biot", "hencky"], model(STRAIN_HELP)] = "green",
    curvature: Annotated[Literal["spatial", "material"], model(CURVATURE_HELP)] = "spatial",
    coriolis: Annotated[bool, model(CORIOLIS_HELP)] = False,
    plane: Annotated[Literal["chordwise", "flapwise"], model(PLANE_HELP)] = "chordwise",
    state: Annotated[Literal["straight", "bent", "stable"], model(STATE_HELP)] = "straight",
    elements: Annotated[int | None, number(ELEMENTS_HELP, panel="Model")] = None,
    terms: Annotated[int | None, number(TERMS_HELP, panel="Model")] = None,
    tolerance: Annotated[float, number(TOLERANCE_HELP, panel="Model")] = 1e-6,
) -> tuple[Beam, dict[str, Any]]:
    """The beam, and the keywords of `solve` that describe its model."""
    options: dict[str, Any] = dict(locals())
    numbers = {name: options.pop(name) for name in NUMBERS}
    given = {name: value for name, value in numbers.items() if value is not None}
    del options["si"]
    if si is None:
        return Beam(**given), options
    for name, value in given.items():
        option = f"--{name} {value}".replace("_", "-")
        raise InvalidInput(f"{option} and --si {si} exclude each other: the file gives all numbers")
    return Beam.from_toml(si), options


def scene_from_options(
    context: typer.Context,
    scene: Annotated[Path | None, scene_option(SCENE_HELP, metavar="FILE.toml")] = None,
    lesson: Annotated[
        str | None, scene_option("The scene of a lesson, in place of a file.", metavar="NAME")
    ] = None,
    mode: Annotated[int | None, number("Mode to show alone (default 2).", panel="Scene")] = None,
    dark: Annotated[bool | None, scene_option(DARK_HELP, "--dark/--light")] = None,
    **beam_options: Any,
) -> tuple["Scene"]:
    """The scene of a file, of a lesson or the default one, with the options of the command line;
    the explorer without any of them has a scene of its own."""
    from beamviz.scene import START, Scene

    beam, _ = beam_and_model(**beam_options)  # also rejects --si beside one of the numbers
    file = context.params.get("scene_file") or scene
    if file and lesson:
        raise InvalidInput(f"--scene {file} and --lesson {lesson} exclude each other")
    if lesson:
        from beamviz import lessons

        start = lessons.lesson(lesson).scene
    else:
        start = Scene.from_toml(file) if file else Scene()
    if si := beam_options.pop("si"):
        start = replace(start, beam=beam)
    values = {"mode": mode, "dark": dark, **beam_options}
    given = {name: values[name] for name in given_options(context) if name in values}
    if context.command.name == "serve" and not (file or lesson or si or given):
        return (START,)
    return (start.changed(**given),)


def shared_options(
    build: Callable[..., tuple], *extra: Callable[..., Any]
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """A decorator that adds the options of `build` (and, for its **keywords, of `extra`) to a
    command, which receives the values that `build` makes of them as its first arguments."""
    shared = {
        name: entry.replace(kind=inspect.Parameter.KEYWORD_ONLY)
        for function in (build, *extra)
        for name, entry in inspect.signature(function).parameters.items()
        if entry.kind is not inspect.Parameter.VAR_KEYWORD
    }

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        own = {
            name: entry.replace(kind=inspect.Parameter.KEYWORD_ONLY)
            for name, entry in inspect.signature(command).parameters.items()
            if name not in ("beam", "options", "scene")
        }

        @functools.wraps(command)
        def wrapper(**values: Any) -> None:
            received = build(**{name: values[name] for name in shared})
            command(*received, **{name: values[name] for name in own})

        entries = {**own, **shared}.values()
        wrapper.__signature__ = inspect.Signature(list(entries))  # type: ignore[attr-defined]
        return wrapper

    return decorate


takes_beam = shared_options(beam_and_model)
takes_scene = shared_options(scene_from_options, beam_and_model)


def sweep_values(
    prefix: str, over: str, start: object, stop: object, points: object
) -> list[float]:
    """Equally spaced values of one of the beam's numbers; InvalidInput names the wrong one, with a
    prefix as an option has it."""
    ends = []
    for option, value in ((f"{prefix}start", start), (f"{prefix}stop", stop)):
        try:
            ends.append(check_float(over, value, *NUMBERS[over].limits))
        except InvalidInput as error:
            raise InvalidInput(f"{option}: {error}") from None
    first, last = ends
    if last <= first:
        texts = f"{prefix}start {exact_text(first)} {prefix}stop {exact_text(last)}"
        raise InvalidInput(f"{texts}: stop must be above start")
    steps = check_int(f"{prefix}points", points, 2, MAX_POINTS) - 1
    return [first + (last - first) * i / steps for i in range(steps)] + [last]


def sweep_axes(texts: Iterable[str]) -> dict[str, list[float]]:
    """The axes given as NAME=START:STOP:POINTS or NAME=VALUE,VALUE,...; InvalidInput names a wrong
    one."""
    axes: dict[str, list[float]] = {}
    for text in texts:
        valid = ":" not in text or re.fullmatch("[^:,]+:[^:,]+:[^:,]+", text)
        form = "NAME=START:STOP:POINTS or NAME=VALUE,VALUE,..."
        name, numbers = named_numbers(f"--over {text}", text if valid else "", form)
        if name in axes:
            raise InvalidInput(f"--over {text}: {name} is given twice")
        try:
            axes[name] = sweep_values("", name, *numbers) if ":" in text else numbers
        except InvalidInput as error:
            raise InvalidInput(f"--over {text}: {error}") from None
    return axes


def parse_place(text: str) -> dict[str, float]:
    """The values given as NAME=VALUE,NAME=VALUE; InvalidInput names a wrong one."""
    place = {}
    for part in filter(None, text.split(",")):
        valid = "" if ":" in part else part
        name, values = named_numbers(f"--at {part}", valid, "NAME=VALUE")
        place[name] = values[0]
    return place


def named_numbers(option: str, text: str, form: str) -> tuple[str, list[float]]:
    """One of the beam's numbers by name, and values of it, from a text as NAME=VALUE,VALUE or
    NAME=VALUE:VALUE. Raises InvalidInput, which names the option and the form expected."""
    name, _, values = text.partition("=")
    numbers = [parse_number(part) for part in re.split("[:,]", values)]
    floats = [float(value) for value in numbers if not isinstance(value, str)]
    if name not in NUMBERS or len(floats) < len(numbers):
        raise InvalidInput(f"{option}: must be {form}, NAME one of {', '.join(NUMBERS)}")
    return name, floats


def given_options(context: typer.Context) -> list[str]:
    """The names of the options on the command line, also of those with their default value."""
    sources = {name: context.get_parameter_source(name) for name in context.params}
    return [name for name, source in sources.items() if source and source.name == "COMMANDLINE"]


def note_unused(beam: Beam, axes: Iterable[str]) -> None:
    """Note the options without effect as an axis varies their number; a file has all numbers."""
    for name in axes if not beam.units else ():
        given = getattr(beam, name)
        if given != getattr(Beam, name):
            option = f"--{name.replace('_', '-')} {exact_text(given)}"
            print(f"beamviz: {option} is not used: --over {name} varies it", file=sys.stderr)


def check_store_options(
    context: typer.Context, store: Path | None, needing: Iterable[str], others: Iterable[str]
) -> None:
    """InvalidInput for an option `needing` a store that is given without one, and beside a store
    for any other than these and `others`."""
    for name in given_options(context):
        option = f"--{name.replace('_', '-')}"
        if store and name not in ("sweep", *needing, *others):
            raise InvalidInput(f"{option} and --sweep {store} exclude each other: the store has it")
        if not store and name in needing:
            raise InvalidInput(f"{option}: needs --sweep STORE.zarr")


SWEEP_STORE = option("Sweep store to read the beams and the model from.", metavar="STORE.zarr")
AT = option("With --sweep: values of its other axes.", metavar="NAME=VALUE,...")
