"""Options that several commands share: the beam, its model and the scene."""

import functools
import inspect
import math
import re
import sys
from collections.abc import Callable, Collection, Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from beamviz.beam import NUMBERS, TOML_SUFFIXES, Beam, rounded_into
from beamviz.checks import check_float, check_int, full_text
from beamviz.errors import InvalidInput, did_you_mean
from beamviz.presets import PRESETS
from beamviz.solver.problem import OPTIONS
from beamviz.units import BY_NAME, Units, parse_over

if TYPE_CHECKING:
    from beamviz.scene import Scene

MAX_POINTS = 10_000  # of a sweep
ASCII = str.maketrans({"ρ": "rho", "Ω": "Omega", "√": "sqrt", "²": "^2"})
FILE_HELP = (
    "The beam in SI units: a TOML file, in place of these numbers; a CSV file of stations along it,"
    f" which gives --mu; or the name of a preset: {', '.join(PRESETS)}."
)
OVER_HELP = (
    "The parameter to vary. For a beam in SI also in a unit, which --start and --stop then have:"
    " rpm, rad/s, kg, beta:mm, ..."
)
SCENE_HELP = "A scene saved by the explorer; other options override it."
LESSON_HELP = "The scene of a lesson, in place of a file; `serve` also opens a lesson's file."
BEAM_SCENE_HELP = (
    "A scene saved by the explorer, for its beam, model and measured frequencies; other options"
    " override it."
)
OVER_FORM = "|".join((*NUMBERS, "UNIT"))
TIP_PATH_HELP = "The curve that the free end runs through."
DARK_HELP = "Background (default light); of a page too, whatever its reader prefers."


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


# An option that takes a number (the function that uses it checks the range), and a group.
number = functools.partial(option, parser=parse_number, metavar="NUMBER")
scene_option = functools.partial(option, panel="Scene")


def parse_triple(text: str) -> tuple[float, float, float]:
    """Three comma-separated numbers, not all 0; typer.BadParameter for anything else."""
    parts = [parse_number(part) for part in text.split(",")]
    numbers = [float(x) for x in parts if not isinstance(x, str) and math.isfinite(x)]
    if not (len(parts) == len(numbers) == 3 and any(numbers)):
        raise typer.BadParameter(
            f"{text}: must be three numbers between commas, not all 0, as 0,-1,0.5"
        )
    x, y, z = numbers
    return x, y, z


def keyword(name: str, kind: Any, settings: Any, default: Any) -> inspect.Parameter:
    """A keyword of a command, with the settings of its option."""
    annotation = Annotated[kind, settings]
    return inspect.Parameter(
        name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation
    )


def beam_keyword(name: str) -> inspect.Parameter:
    """One of the numbers of a beam."""
    parameter = NUMBERS[name]
    formula, (low, high) = parameter.formula.translate(ASCII), parameter.limits
    limits = f"{low:g} .. {high:g} (default {getattr(Beam, name):g})"
    help = f"{parameter.label.capitalize()} {formula}, {limits}."
    return keyword(name, float | None, number(help, panel="Beam"), None)


def solver_keyword(name: str, panel: str | None = "Model") -> inspect.Parameter:
    """One of the options of `solve`."""
    declared = OPTIONS[name]
    if declared.choices:
        return keyword(
            name,
            Literal[tuple(declared.choices)],
            option(declared.text, panel=panel),
            declared.default,
        )
    if declared.kind is bool:
        return keyword(name, bool, option(declared.text, panel=panel), declared.default)
    return keyword(name, declared.kind, number(declared.text, panel=panel), declared.default)


# The number of modes of a command that takes a beam; a scene has its own.
MODES = solver_keyword("modes", panel=None).annotation
OVER = keyword(
    "over", Literal[(*NUMBERS, *BY_NAME)], option(OVER_HELP, metavar=OVER_FORM), None
).annotation
MODEL_KEYWORDS = [solver_keyword(name) for name in OPTIONS if name != "modes"]
# The options that give a factor in place of an option that is on or off, with the name of that.
FACTORS = {f"{name}_factor": name for name, entry in OPTIONS.items() if entry.partial}
FACTOR_KEYWORDS = [
    keyword(
        name,
        float | None,
        number(
            f"A part of the {OPTIONS[switch].feature}, 0 .. 1, as a thought experiment: 1 is"
            f" --{switch}, 0 is --no-{switch}.",
            panel="Model",
        ),
        None,
    )
    for name, switch in FACTORS.items()
]
BEAM_KEYWORDS = [
    *map(beam_keyword, NUMBERS),
    keyword("si", Path | None, option(FILE_HELP, metavar="FILE.toml|csv", panel="Beam"), None),
    *MODEL_KEYWORDS,
    *FACTOR_KEYWORDS,
]
# The scene of a command that takes a beam.
BEAM_SCENE = keyword(
    "scene",
    Path | None,
    option(BEAM_SCENE_HELP, metavar="FILE.toml", panel="Beam"),
    None,
)


def beam_and_model(si: Path | None, **values: Any) -> tuple[Beam, dict[str, Any]]:
    """The beam, and the keywords of `solve` that describe its model."""
    options = {entry.name: values[entry.name] for entry in MODEL_KEYWORDS}
    options |= given_factors(values)
    given = {name: values[name] for name in NUMBERS if values[name] is not None}
    if si is None:
        return Beam(**given), options
    if not (si.suffix or si.exists() or str(si) in PRESETS):
        hint = did_you_mean(str(si), PRESETS)
        raise InvalidInput(f"--si {si}: neither a file nor one of {', '.join(PRESETS)}{hint}")
    known = None if si.exists() else PRESETS.get(str(si))
    is_blade = known is None and si.suffix.lower() not in TOML_SUFFIXES
    for name, value in given.items():
        if name == "mu" or not is_blade:
            option = f"--{name} {value}".replace("_", "-")
            gives = "mu" if is_blade else "all numbers"
            raise InvalidInput(f"{option} and --si {si} exclude each other: the file gives {gives}")
    beam = known.beam if known else Beam.from_file(si)
    if given:
        beam = beam.replace(**given)
        beam.warn_of_doubts()
    note_plane(beam, options["plane"])
    return beam, options


def note_plane(beam: Beam, plane: str) -> None:
    """Note that a flapwise stiffness, which a beam by its stiffnesses has not, is the other one."""
    physical = beam.physical
    by_stiffness = physical is not None and physical.density is None
    if plane != "chordwise" and by_stiffness and physical and physical.flap_stiffness is None:
        text = "no flap_stiffness is given: bending_stiffness is taken in its place"
        print(f"beamviz: --plane {plane}: {text}", file=sys.stderr)


def given_factors(values: dict[str, Any]) -> dict[str, float]:
    """The factors that are given, each by the option of `solve` that it is a value of. Raises
    InvalidInput for one out of range, and for one beside an option that is switched on."""
    factors = {}
    for name, switch in FACTORS.items():
        if values.get(name) is None:
            continue
        option = f"--{name.replace('_', '-')}"
        factors[switch] = check_float(option, values[name], 0.0, 1.0)
        if values[switch]:
            raise InvalidInput(f"{option} {values[name]} and --{switch} exclude each other")
    return factors


def lesson_names(begun: str) -> list[str]:
    """The names that a shell offers for a lesson."""
    from beamviz.lessons import NAMES

    return [name for name in NAMES if name.startswith(begun)]


def names_file(lesson: str | None) -> bool:
    """Whether the lesson given is the file of one's own, not the name of one."""
    return lesson is not None and lesson.endswith(".toml")


SCENE_KEYWORDS = [
    keyword("scene", Path | None, scene_option(SCENE_HELP, metavar="FILE.toml"), None),
    keyword(
        "lesson",
        str | None,
        scene_option(
            LESSON_HELP,
            metavar="NAME",
            autocompletion=lesson_names,
        ),
        None,
    ),
    keyword("mode", int | None, number("Mode to show alone (default 2).", panel="Scene"), None),
    keyword("dark", bool | None, scene_option(DARK_HELP, "--dark/--light"), None),
    keyword("tip_path", bool | None, scene_option(TIP_PATH_HELP), None),
]


LOOK = "mode", "dark", "tip_path"  # those of how a scene looks


def scene_from_options(
    context: typer.Context, scene: Path | None, lesson: str | None, **values: Any
) -> "Scene":
    """The scene of a file, of a lesson or the default one, with the options of the command line;
    the explorer without any of them has a scene of its own."""
    from beamviz.scene import START, Scene

    look = {name: values.pop(name) for name in LOOK}
    beam, options = beam_and_model(**values)  # also rejects --si beside one of the numbers
    file = context.params.get("scene_file") or scene
    if file and lesson:
        raise InvalidInput(f"--scene {file} and --lesson {lesson} exclude each other")
    if names_file(lesson):
        if context.command.name != "serve":
            raise InvalidInput(
                f"--lesson {lesson}: only `beamviz serve` opens a lesson file; name a lesson of"
                " `beamviz lessons`"
            )
        lesson = None
    if lesson:
        from beamviz import lessons

        start = lessons.lesson(lesson).scene
    else:
        start = Scene.from_toml(file) if file else Scene()
    if si := values.pop("si"):
        start = replace(start, beam=beam)
    values |= options | look
    names = (FACTORS.get(name, name) for name in given_options(context))
    given = {name: values[name] for name in names if name in values}
    if context.command.name == "serve" and not (file or lesson or si or given):
        return START
    return start.changed(**given)


CONTEXT = inspect.Parameter("context", inspect.Parameter.KEYWORD_ONLY, annotation=typer.Context)


def takes_beam(command: Callable[..., None]) -> Callable[..., None]:
    """A decorator: the command has the options of a beam and its model, or of a scene that has
    them, and receives `beam`, `options` and, where it has such a keyword, the measured frequencies
    of the scene as `scene_measured`."""
    has_measured = "scene_measured" in inspect.signature(command).parameters

    def call(given: dict[str, Any], remaining: dict[str, Any]) -> None:
        if given["scene"]:
            usual: dict[str, Any] = dict.fromkeys(("lesson", *LOOK))
            scene = scene_from_options(**given, **usual)
            beam, options, measured = scene.beam, scene.options, scene.measured
        else:
            values = {name: given[name] for name in given if name not in ("context", "scene")}
            (beam, options), measured = beam_and_model(**values), {}
        if has_measured:
            remaining = {**remaining, "scene_measured": measured}
        command(beam=beam, options=options, **remaining)

    made = ("beam", "options", "scene_measured")
    return with_keywords(command, made, [CONTEXT, BEAM_SCENE, *BEAM_KEYWORDS], call)


def takes_scene(command: Callable[..., None]) -> Callable[..., None]:
    """A decorator: the command has the options of a scene, of its beam and its model, and receives
    `scene`."""

    def call(given: dict[str, Any], remaining: dict[str, Any]) -> None:
        command(scene=scene_from_options(**given), **remaining)

    return with_keywords(command, ("scene",), [CONTEXT, *SCENE_KEYWORDS, *BEAM_KEYWORDS], call)


def with_keywords(
    command: Callable[..., None],
    made: Collection[str],
    keywords: Iterable[inspect.Parameter],
    call: Callable[[dict[str, Any], dict[str, Any]], None],
) -> Callable[..., None]:
    """A command with more keywords. made: the arguments that `call` makes of these; call: calls the
    command with the values of these, and those of its own keywords."""
    more = {entry.name: entry for entry in keywords}
    remaining = {
        name: entry.replace(kind=inspect.Parameter.KEYWORD_ONLY)
        for name, entry in inspect.signature(command).parameters.items()
        if name not in made
    }

    @functools.wraps(command)
    def wrapper(**values: Any) -> None:
        call({name: values[name] for name in more}, {name: values[name] for name in remaining})

    signature = inspect.Signature([*(remaining | more).values()])
    wrapper.__signature__ = signature  # type: ignore[attr-defined]
    return wrapper


def sweep_values(
    prefix: str, over: str, units: Units | None, start: object, stop: object, points: object
) -> list[float]:
    """Equally spaced values of one of the beam's numbers, which may be in a unit, as "rpm";
    InvalidInput names the wrong one, with a prefix as an option has it."""
    name, factor = parse_over(over, units)
    low, high = (factor * limit for limit in NUMBERS[name].limits)
    ends = []
    for option, value in ((f"{prefix}start", start), (f"{prefix}stop", stop)):
        if isinstance(value, int | float):
            value = rounded_into(value, low, high)  # in a unit it may be the limit but for rounding
        try:
            ends.append(check_float(over, value, low, high))
        except InvalidInput as error:
            raise InvalidInput(f"{option}: {error}") from None
    first, last = ends
    if last <= first:
        texts = f"{prefix}start {full_text(first)} {prefix}stop {full_text(last)}"
        raise InvalidInput(f"{texts}: stop must be above start")
    steps = check_int(f"{prefix}points", points, 2, MAX_POINTS) - 1
    return [first + (last - first) * i / steps for i in range(steps)] + [last]


def sweep_axes(texts: Iterable[str], units: Units | None) -> dict[str, list[float]]:
    """The axes given as NAME=START:STOP:POINTS or NAME=VALUE,VALUE,..., NAME also in a unit, as
    "rpm"; InvalidInput names a wrong one."""
    axes: dict[str, list[float]] = {}
    for text in texts:
        is_range = ":" in text.partition("=")[2]
        valid = not is_range or re.fullmatch("[^=]+=[^:,]+:[^:,]+:[^:,]+", text)
        form = "NAME=START:STOP:POINTS or NAME=VALUE,VALUE,..."
        known = (*NUMBERS, *BY_NAME)
        name, numbers = named_numbers(f"--over {text}", text if valid else "", form, known)
        if name in axes:
            raise InvalidInput(f"--over {text}: {name} is given twice")
        try:
            parse_over(name, units)  # the unit of a range or of values is known
            axes[name] = sweep_values("", name, units, *numbers) if is_range else numbers
        except InvalidInput as error:
            raise InvalidInput(f"--over {text}: {error}") from None
    return axes


def parse_place(text: str) -> dict[str, float]:
    """The values given as NAME=VALUE,NAME=VALUE; InvalidInput names a wrong one."""
    place = {}
    for part in filter(None, text.split(",")):
        valid = "" if ":" in part.partition("=")[2] else part
        known = (*NUMBERS, *BY_NAME)
        name, values = named_numbers(f"--at {part}", valid, "NAME=VALUE", known)
        place[name] = values[0]
    return place


def named_numbers(
    option: str, text: str, form: str, known: Collection[str]
) -> tuple[str, list[float]]:
    """One of the known names, and values, from a text as NAME=VALUE,VALUE or NAME=VALUE:VALUE.
    Raises InvalidInput, which names the option and the form expected."""
    name, _, values = text.partition("=")
    numbers = [parse_number(part) for part in re.split("[:,]", values)]
    floats = [float(value) for value in numbers if not isinstance(value, str)]
    if name not in known or len(floats) < len(numbers):
        hint = did_you_mean(name, known) if name not in known else ""
        raise InvalidInput(f"{option}: must be {form}, NAME one of {', '.join(known)}{hint}")
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
            option = f"--{name.replace('_', '-')} {full_text(given)}"
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
