"""The command `beamviz motion`."""

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from beamviz.beam import Beam
from beamviz.cli.options import given_options, number, option
from beamviz.cli.quantities import dimensionless, force, speed, time
from beamviz.errors import InvalidInput

OUT = typer.Argument(
    help="csv, npz: numbers; png, svg, pdf: a chart; gif, webp, mp4: a film; html: a page.",
    metavar="OUT.csv|npz|png|svg|pdf|gif|webp|mp4|html",
)
START_HELP = "Amplitude [L] of a mode to start from; repeat the option for more."
RELEASE_HELP = "Transverse force [E I / L^2] that holds the beam until t = 0."
FORMAT_HELP = "Format of what is printed; beside OUT, nothing is unless this is given."
NEEDS = {"within": "ramp-to", "ramp-to": "within", "ramp": "ramp-to", "release-at": "release"}
UNUSED = {  # options of the model that other commands have, and their defaults here
    "terms": None,
    "stiffening": True,
    "softening": True,
}


def parse_start(text: str) -> tuple[str, float]:
    """MODE:AMPLITUDE; typer.BadParameter for anything else."""
    mode, _, amplitude = text.partition(":")
    try:
        return mode, float(amplitude)
    except ValueError:
        raise typer.BadParameter(f"{text}: must be MODE:AMPLITUDE, as B1:0.1") from None


def motion(
    beam: Beam,
    options: dict[str, Any],
    context: typer.Context,
    path: Annotated[Path | None, OUT] = None,
    until: Annotated[Any, time("The time [T*] until which the beam moves.")] = 10.0,
    ramp_to: Annotated[Any, speed("Speed gamma at the end of a ramp from --gamma.")] = None,
    within: Annotated[Any, time("Time [T*] of the ramp.")] = None,
    ramp: Annotated[Literal["smooth", "linear"], option("Shape of the ramp.")] = "smooth",
    release: Annotated[Any, force(RELEASE_HELP)] = 0.0,
    release_at: Annotated[float, number("Its place, from 0 at the root to 1 at the tip.")] = 1.0,
    start: Annotated[
        list[Any] | None, option(START_HELP, parser=parse_start, metavar="MODE:AMPLITUDE")
    ] = None,
    damping: Annotated[float, number("Damping ratio of all modes.")] = 0.0,
    catch: Annotated[Any, time("Time [T*] at which the mass docks.")] = None,
    drop: Annotated[Any, time("Time [T*] at which the mass is released.")] = None,
    points: Annotated[int, number("Number of times in the output.")] = 401,
    integrator: Annotated[str, option("Integrator; see the reference.")] = "radau",
    step: Annotated[Any, time("Constant step in time [T*].")] = None,
    tip_path: Annotated[bool, option("The curve of the tip, in a film or page.")] = False,
    format: Annotated[Literal["table", "json", "csv"], option(FORMAT_HELP)] = "table",
) -> None:
    """Motion in time: released, set swinging, spun up or stopped; numbers, chart, film or page.

    --tolerance is that of the tip [L], 1e-4 where it is not given. Times, speeds and forces of a
    beam in SI may have a unit: --until 2s --ramp-to 300rpm --within 500ms --release 20N.
    """
    from beamviz.dynamics import motion as move
    from beamviz.dynamics.drives import Ramp

    if path:
        from beamviz.exports.motion_files import SUFFIXES, export_motion
        from beamviz.files import check_suffix, check_writable
        from beamviz.scene import ViewOptions

        check_suffix(path, SUFFIXES)
        check_writable(path)
    check_needs(context)
    given = {"until": until, "within": within, "catch": catch, "drop": drop, "step": step}
    times: dict[str, Any] = {
        name: dimensionless(name, value, "time", beam) for name, value in given.items()
    }
    to, within = dimensionless("ramp-to", ramp_to, "speed", beam), times.pop("within")
    drive = Ramp(to, within, ramp, start=beam.gamma) if to is not None and within else None
    moved = move(
        beam,
        **times,
        speed=drive,
        release=dimensionless("release", release, "force", beam),
        release_at=release_at,
        start=amplitudes(start or []),
        damping=damping,
        points=points,
        integrator=integrator,
        **model_options(context, options),
    )
    if path:
        export_motion(path, moved, view=ViewOptions(tip_path=tip_path))
        if "format" not in given_options(context):
            return
    from beamviz.output.motion import MOTION_FORMATS

    print(MOTION_FORMATS[format](moved).rstrip("\n"))


def check_needs(context: typer.Context) -> None:
    """InvalidInput for an option that has no effect without another."""
    given = [name.replace("_", "-") for name in given_options(context)]
    for name, other in NEEDS.items():
        if name in given and other not in given:
            raise InvalidInput(f"--{name} needs --{other}")


def amplitudes(pairs: list[tuple[str, float]]) -> dict[str, float]:
    """Amplitudes by mode; InvalidInput for a mode that is given twice."""
    by_mode: dict[str, float] = {}
    for mode, amplitude in pairs:
        if mode in by_mode:
            raise InvalidInput(f"--start {mode}:{amplitude:g}: {mode} is given twice")
        by_mode[mode] = amplitude
    return by_mode


def model_options(context: typer.Context, options: dict[str, Any]) -> dict[str, Any]:
    """The keywords of `beamviz.motion` among those of `solve`; InvalidInput for one that it has
    not."""
    given = given_options(context)
    if options["plane"] != "chordwise":
        raise InvalidInput(
            f"--plane {options['plane']}: a motion in time is in the plane of rotation; leave the"
            " option out"
        )
    for name, default in UNUSED.items():
        if name in given and options[name] != default:
            shown = f"--no-{name}" if options[name] is False else f"--{name} {options[name]}"
            raise InvalidInput(f"{shown}: a motion in time has no such option")
    if "coriolis" in given and not options["coriolis"]:
        raise InvalidInput("--no-coriolis: a motion in time always has Coriolis forces")
    if "coriolis_factor" in given:
        raise InvalidInput("--coriolis-factor: a motion in time has the whole of Coriolis forces")
    kept = {name: options[name] for name in ("method", "strain", "curvature", "state", "elements")}
    return kept | ({"tolerance": options["tolerance"]} if "tolerance" in given else {})
