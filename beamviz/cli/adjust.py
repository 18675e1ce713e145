"""The command `beamviz adjust`."""

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from beamviz.beam import Beam
from beamviz.cli.options import BEAM_KEYWORDS, beam_and_model, number, option
from beamviz.errors import InvalidInput

FREE_HELP = (
    "A number that may change, with its bounds; repeat the option for more. A number of the beam,"
    " root, or of a beam in SI also bending_factor, axial_factor, mass_factor, kg, beta:mm, ..."
)
MEASURED_HELP = (
    "Measured frequencies: columns frequency or hertz, and if known mode, error, and gamma, rpm or"
    " another number (default: those of --scene)."
)
MODES_HELP = (
    "Number of the lowest modes that count (default: as many as the goal needs, at most 20)."
)


def parse_free(text: str) -> tuple[str, tuple[float, float] | None]:
    """NAME or NAME=LOW:HIGH; typer.BadParameter for anything else."""
    name, equals, bounds = text.partition("=")
    if not equals:
        return name, None
    try:
        low, high = map(float, bounds.split(":"))
    except ValueError:
        raise typer.BadParameter(f"{text}: must be NAME or NAME=LOW:HIGH, as beta=0:1") from None
    return name, (low, high)


def parse_target(text: str) -> tuple[str, str]:
    """MODE=FREQUENCY; typer.BadParameter for anything else."""
    mode, equals, frequency = text.partition("=")
    if not (mode and equals and frequency):
        raise typer.BadParameter(f"{text}: must be MODE=FREQUENCY, as B1=4.2 or B1=12Hz")
    return mode, frequency


def parse_lines(text: Any) -> tuple[int, ...]:
    """Whole numbers between commas; typer.BadParameter for anything else."""
    try:
        return tuple(int(part) for part in text.split(","))
    except ValueError:
        raise typer.BadParameter(f"{text}: must be whole numbers between commas, as 1,2") from None


def parse_share(text: Any) -> float:
    """A share, as 0.1 or 10%; typer.BadParameter for anything else."""
    text = str(text).strip()
    try:
        return float(text[:-1]) / 100 if text.endswith("%") else float(text)
    except ValueError:
        raise typer.BadParameter(f"{text}: must be a share, as 0.1 or 10%") from None


# The options of a range of speeds without resonances.
CLEAR = option("Multiples of the speed to avoid.", parser=parse_lines, metavar="K,K,...")
BETWEEN = option("With --clear: range of gamma, or as 200rpm:400rpm.", metavar="A:B")
MARGIN = option("With --clear: least distance from a line.", parser=parse_share, metavar="SHARE|N%")


def check_clear(clear: Any, between: str) -> None:
    """InvalidInput for one of --clear and --between without the other."""
    if bool(clear) != bool(between):
        raise InvalidInput("--clear and --between belong together, as --clear 1,2 --between 2:6")


def adjust(
    beam: Beam,
    options: dict[str, Any],
    scene_measured: dict[str, Any],
    context: typer.Context,
    beam_file: Annotated[
        Path | None, typer.Argument(help="The same as --si.", metavar="BEAM")
    ] = None,
    *,
    free: Annotated[list[Any], option(FREE_HELP, parser=parse_free, metavar="NAME|NAME=LOW:HIGH")],
    measured: Annotated[Path | None, option(MEASURED_HELP, metavar="FILE.csv")] = None,
    target: Annotated[
        list[Any] | None,
        option(
            "Frequency of a mode, [1/T*] or in Hz; repeat the option for more.",
            parser=parse_target,
            metavar="MODE=FREQUENCY",
        ),
    ] = None,
    clear: Annotated[Any, CLEAR] = None,
    between: Annotated[str, BETWEEN] = "",
    margin: Annotated[Any, MARGIN] = 0.1,
    modes: Annotated[int | None, number(MODES_HELP)] = None,
    format: Annotated[Literal["table", "json"], option("Output format.")] = "table",
) -> None:
    """The numbers with which a beam fits a measurement, has target frequencies or keeps clear of
    resonances."""
    from beamviz.adjusting import adjust
    from beamviz.output.adjusted import ADJUSTED_FORMATS

    if beam_file is not None:
        for name in ("si", "scene"):
            if other := context.params[name]:
                raise InvalidInput(f"{beam_file} and --{name} {other} exclude each other")
        given_values = {each.name: context.params[each.name] for each in BEAM_KEYWORDS}
        beam, options = beam_and_model(**{**given_values, "si": beam_file})
    for names, text in ((free, "--free"), (target or [], "--target")):
        keys = [name for name, _ in names]
        for name in keys:
            if keys.count(name) > 1:
                raise InvalidInput(f"{text} {name}: is given twice")
    goals = {"--measured": measured, "--target": target, "--clear": clear}
    given = [name for name, value in goals.items() if value]
    if scene_measured and not given:
        given = ["--scene"]
    if len(given) != 1:
        raise InvalidInput(f"{' and '.join(given) or 'no goal'}: give one of {', '.join(goals)}")
    check_clear(clear, between)
    if modes is not None:
        options = {**options, "modes": modes}
    answer = adjust(
        beam,
        dict(free),
        measured=scene_measured if given == ["--scene"] else measured,
        targets=dict(target) if target else None,
        clear=clear,
        between=between or None,
        margin=margin,
        **options,
    )
    print(ADJUSTED_FORMATS[format](answer).rstrip("\n"))
