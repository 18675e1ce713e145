"""The commands. Heavy imports are inside them, so that each starts with what it needs."""

import contextlib
import signal
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from beamviz.beam import Beam
from beamviz.checks import check_float, check_int
from beamviz.cli.adjust import BETWEEN, MARGIN, adjust, check_clear, parse_lines
from beamviz.cli.motion import motion
from beamviz.cli.options import (
    AT,
    MODES,
    OVER,
    SWEEP_STORE,
    check_store_options,
    names_file,
    note_unused,
    number,
    option,
    parse_place,
    parse_triple,
    sweep_axes,
    sweep_values,
    takes_beam,
    takes_scene,
)
from beamviz.errors import InvalidInput
from beamviz.export_formats import EXPORT_FORMATS
from beamviz.files import check_suffix, check_writable, json_text, replaced
from beamviz.signals import Terminated
from beamviz.solver.problem import Problem
from beamviz.tables import plural
from beamviz.units import number_of
from beamviz.version import __version__

if TYPE_CHECKING:
    from beamviz.sweeps.run import Progress

Format = Annotated[Literal["table", "json", "csv"], option("Output format.")]
Folder = Annotated[Path, option("Folder to write to.", metavar="DIR")]
FROM_HELP = "Look from this direction, 0,0,1 being above and 0,-1,0 beside the beam."
DIRECTION = option(FROM_HELP, "--from", parser=parse_triple, metavar="X,Y,Z")
ZOOM = number("Zoom factor; 1: the beam fills the picture.")
FOLLOW_HELP = "Lecture: every page follows that of a presenter, who has a second link."
PROCESSES_HELP = (
    "Processes that share the visitors (default: one for each core if --host admits other machines,"
    " else 1; with --follow, and on other systems than Linux, 1)."
)
KEY_FILE_HELP = (
    "File with the key of the link, the same for several servers behind one address (default: a new"
    " key for each run)."
)
PERIODS_HELP = "Periods of the first mode shown (default: as few as make a seamless loop)."
KIND_HELP = (
    "A kind of events to look for; repeat the option for more (default: all but those on request,"
    " see the table in assets/reference.md)."
)
POLYNOMIALS_HELP = (
    "The first flap and edge shapes as polynomials, as an ElastoDyn blade file has them."
)
POINTS_HELP = (
    "Measured frequencies to draw in the --plot; a file as for `beamviz adjust` (default: those of"
    " --scene)."
)
BANDS = option(
    "Multiples of the speed, whose margins are shaded in the --plot.",
    parser=parse_lines,
    metavar="K,K,...",
)
MARGINS_HELP = (
    "Table of the margins to the --per-rev lines at the speed --gamma to write besides the output,"
    " as CSV."
)
EVENTS_HELP = "Table of the events and resonances to write besides the output, as CSV."
SENSITIVITIES_HELP = "With the change of each frequency with each number of the beam."
EXPORTS = {suffix[1:]: row.text for suffix, row in EXPORT_FORMATS.items()}
EXPORT_HELP = "; ".join(f"{name}: {text}" for name, text in EXPORTS.items())
EXPORT_HELP += (
    "; png, svg, pdf: with --sweep, a map of the frequency of --mode over two parameters."
)
EXPORT_NAMES = "OUT." + "|".join([*EXPORTS, "png", "svg", "pdf"])
PAPER_HELP = "table1 .. table4, fig4 .. fig19, numbers (what the text prints), or all."
KEPT = "what is written is kept: run the same command again to resume"
REPEATED = 2.0  # [s] a first solve may take whose time is that of a second one
EVERY = 10.0  # [s] between lines of progress where stderr is no terminal

app = typer.Typer()


def example(line: str) -> str:
    """The last line of the help of a command."""
    return f"Example: beamviz {line}"


def show_version(wanted: bool) -> None:
    """Print the version and end."""
    if wanted:
        print(f"beamviz {__version__}")
        raise typer.Exit


@app.callback()
def beamviz(
    version: Annotated[
        bool, option("Show the version.", "--version", callback=show_version, is_eager=True)
    ] = False,
) -> None:
    """A rotating beam with a concentrated mass: equilibrium, modes, and a live 3D explorer."""


@app.command(epilog=example("modes --alpha 1 --beta 0.5 --gamma 10"))
@takes_beam
def modes(
    beam: Beam,
    options: dict[str, Any],
    modes: MODES = Problem.modes,
    sensitivities: Annotated[bool, option(SENSITIVITIES_HELP, "--sensitivities")] = False,
    format: Format = "table",
    polynomials: Annotated[bool, option(POLYNOMIALS_HELP, "--polynomials")] = False,
) -> None:
    """Equilibrium and modes of a beam."""
    from beamviz.output.solution import SOLUTION_FORMATS, WITH_POLYNOMIALS
    from beamviz.solver import solve

    solution = solve(beam, modes=modes, **options)
    if solution.stats.seconds < REPEATED:  # most of which was the first import of libraries
        solution = solve(beam, modes=modes, **options)
    if not polynomials:
        print(SOLUTION_FORMATS[format](solution, sensitivities).rstrip("\n"))
    elif format == "csv":
        raise InvalidInput("--polynomials and --format csv exclude each other: table or json")
    else:
        print(WITH_POLYNOMIALS[format](solution, sensitivities).rstrip("\n"))


@app.command(epilog=example("loci --over gamma --start 0 --stop 20 --plot loci.svg"))
@takes_beam
def loci(
    beam: Beam,
    options: dict[str, Any],
    scene_measured: dict[str, Any],
    context: typer.Context,
    over: OVER,
    start: Annotated[float | None, number("First value of the parameter.")] = None,
    stop: Annotated[float | None, number("Last value of the parameter.")] = None,
    points: Annotated[int, number("Number of values.")] = 201,
    modes: MODES = Problem.modes,
    format: Format = "table",
    plot: Annotated[
        Path | None, option("Chart to write besides the output.", metavar="FILE.png|svg|pdf")
    ] = None,
    events: Annotated[Path | None, option(EVENTS_HELP, metavar="FILE.csv")] = None,
    margins: Annotated[Path | None, option(MARGINS_HELP, metavar="FILE.csv")] = None,
    measured: Annotated[Path | None, option(POINTS_HELP, metavar="FILE.csv")] = None,
    clear: Annotated[Any, BANDS] = None,
    between: Annotated[str, BETWEEN] = "",
    margin: Annotated[Any, MARGIN] = 0.1,
    per_rev: Annotated[int, number("Resonances with 1 .. N times the rotation speed.")] = 0,
    kind: Annotated[list[str] | None, option(KIND_HELP, metavar="NAME")] = None,
    sweep: Annotated[Path | None, SWEEP_STORE] = None,
    at: Annotated[str, AT] = "",
) -> None:
    """Frequencies over one parameter, tracked, with their events: crossings, veerings and more.

    --sweep takes the beam, the values and the model from a line of a store.
    """
    from beamviz.adjusting.goals import ClearGoal
    from beamviz.frequency_loci import MAX_PER_REV, loci
    from beamviz.output.loci import LOCI_FORMATS, events_csv, margins_csv

    others = ["over", "format", "plot", "events", "margins", "measured", "per_rev", "kind"]
    others += ["clear", "between", "margin"]
    check_store_options(context, sweep, ["at"], others)
    for path in (events, margins):
        if path:
            check_suffix(path, [".csv"])
            check_writable(path)
    if plot:
        from beamviz.plotting import SUFFIXES, save_figure
        from beamviz.plotting.loci import draw_chart, has_points

        check_suffix(plot, SUFFIXES)
        check_writable(plot)
    elif measured or clear:
        option = f"--measured {measured}" if measured else f"--clear {','.join(map(str, clear))}"
        raise InvalidInput(f"{option}: is drawn in a chart; give --plot FILE.png too")
    check_clear(clear, between)
    if sweep:
        from beamviz.sweeps import open_line

        over = number_of(over)
        beam, values, options = open_line(sweep, over, parse_place(at))
        modes = options.pop("modes")
    else:
        missing = [name for name, value in (("start", start), ("stop", stop)) if value is None]
        if missing:
            raise InvalidInput(f"Missing option '--{missing[0]}'.")
        values = sweep_values("--", over, beam.units, start, stop, points)
        if not per_rev:
            note_unused(beam, [over])
    check_int("per-rev", per_rev, 0, MAX_PER_REV)
    if per_rev and number_of(over) != "gamma":
        raise InvalidInput(f"per-rev lines need loci over gamma, not over {over}")
    goal = ClearGoal.of(beam, clear, between, margin) if clear else None
    if goal and number_of(over) != "gamma":
        raise InvalidInput(f"--clear needs loci over gamma, not over {over}")
    tracked = loci(beam, over, values, modes, per_rev, kind or None, **options)
    if plot:
        of_scene = scene_measured if has_points(tracked, scene_measured) else None
        lines = sorted({*range(1, per_rev + 1), *(goal.lines if goal else ())})
        chart = draw_chart(tracked, lines, measured=measured or of_scene, clear=goal)
        save_figure(plot, chart)
    for path, text in ((events, events_csv), (margins, margins_csv)):
        if path:
            with replaced(path) as part:
                part.write_text(text(tracked), encoding="utf-8")
    if format == "csv" and tracked.events and not events:
        count = plural(len(tracked.events), "event")
        print(f"beamviz: {count} found; --events FILE.csv writes a table of them", file=sys.stderr)
    print(LOCI_FORMATS[format](tracked).rstrip("\n"))


app.command(epilog=example("motion --until 10 --release 1 --damping 0.01"))(takes_beam(motion))


app.command(epilog=example("adjust --free alpha --free beta=0.2:1 --target B1=3 --target B2=20"))(
    takes_beam(adjust)
)


@app.command(epilog=example("sweep map.zarr --over gamma=0:20:101 --over alpha=0,0.5,1"))
@takes_beam
def sweep(
    beam: Beam,
    options: dict[str, Any],
    path: Annotated[
        Path, typer.Argument(help="The Zarr store to write or to resume.", metavar="OUT.zarr")
    ],
    over: Annotated[
        list[str],
        option(
            "An axis of the sweep; repeat the option for more, up to five.",
            metavar="NAME=START:STOP:POINTS|NAME=VALUE,VALUE,...",
        ),
    ],
    modes: MODES = Problem.modes,
    workers: Annotated[
        int | None, number("Processes on this machine (default: one for each core).")
    ] = None,
    scheduler: Annotated[
        str, option("Dask scheduler whose workers are used.", metavar="ADDRESS")
    ] = "",
) -> None:
    """Every combination of parameters, in parallel; interrupted, the same command resumes."""
    from beamviz.sweeps import sweep
    from beamviz.sweeps.run import dask_client
    from beamviz.sweeps.store import count_statuses

    if scheduler and workers is not None:
        raise InvalidInput(
            f"--workers {workers} and --scheduler {scheduler} exclude each other: the cluster has"
            " workers of its own"
        )
    axes = sweep_axes(over, beam.units)
    note_unused(beam, axes)
    with contextlib.ExitStack() as stack:
        client = stack.enter_context(dask_client(scheduler)) if scheduler else None
        line = stack.enter_context(ProgressLine())
        keywords = {"beam": beam, "workers": workers, "progress": line.show, **options}
        sweep(axes, path, modes, client, **keywords)
    print(", ".join(f"{count} {status}" for status, count in count_statuses(path).items()))


class ProgressLine:
    """The progress of a sweep: on a terminal a line that is written anew; elsewhere one now and
    then, and the last."""

    def __init__(self) -> None:
        self.terminal, self.shown, self.text = sys.stderr.isatty(), time.monotonic(), ""

    def __enter__(self) -> "ProgressLine":
        return self

    def __exit__(self, kind: Any, error: BaseException | None, *_: Any) -> None:
        if self.text:
            print(f"\r{self.text}" if self.terminal else self.text, file=sys.stderr)
        if isinstance(error, Terminated):
            error.add_note(KEPT)

    def show(self, progress: "Progress") -> None:
        """Show the progress."""
        self.text = f"beamviz: {progress}"
        now = time.monotonic()
        if self.terminal:
            print(f"\r{self.text}\x1b[K", end="", file=sys.stderr, flush=True)
        elif now - self.shown > EVERY:
            print(self.text, file=sys.stderr, flush=True)
            self.shown, self.text = now, ""


@app.command(epilog=example("serve --alpha 1 --gamma 10 --open"))
@takes_scene
def serve(
    scene: Any,
    context: typer.Context,
    scene_file: Annotated[
        Path | None, typer.Argument(help="The same as --scene.", metavar="SCENE.toml")
    ] = None,
    host: Annotated[
        str, option("Address to listen on; 0.0.0.0 admits other machines that have the link.")
    ] = "127.0.0.1",
    port: Annotated[int, number("Port to listen on.")] = 8080,
    open: Annotated[bool, option("Open the page in the default browser.")] = False,
    visitors: Annotated[int, number("Largest number of simultaneous visitors.")] = 60,
    public_url: Annotated[
        str, option("Its address behind a reverse proxy.", metavar="https://NAME[/PATH]")
    ] = "",
    follow: Annotated[bool, option(FOLLOW_HELP, "--follow")] = False,
    processes: Annotated[int | None, number(PROCESSES_HELP)] = None,
    key_file: Annotated[Path | None, option(KEY_FILE_HELP, metavar="FILE")] = None,
) -> None:
    """The explorer in a browser; Ctrl-C ends it. Without a beam, a model or a scene it opens on a
    beam with a mass in rotation, two modes superimposed."""
    from beamviz.explorer import serve

    lesson: Any = context.params.get("lesson")
    port = check_int("port", port, 1, 65535)
    visitors = check_int("visitors", visitors, 1, 1000)
    if processes is not None:
        processes = check_int("processes", processes, 1, 64)
    try:
        given = (host, port, open, public_url, visitors, follow, processes, key_file)
        serve(scene, *given, lesson if names_file(lesson) else None)
    except Terminated as end:
        if end.number != signal.SIGTERM:  # which is how a service is ended
            raise


@app.command(epilog=example("screenshot beam.png --alpha 1 --beta 0.5 --gamma 10 --mode 3"))
@takes_scene
def screenshot(
    scene: Any,
    path: Annotated[Path, typer.Argument(help="The picture to write.", metavar="OUT.png")],
    direction: Annotated[Any, DIRECTION] = None,
    zoom: Annotated[float, ZOOM] = 1.0,
    width: Annotated[int, number("Width in pixels.")] = 1280,
    height: Annotated[int, number("Height in pixels.")] = 720,
    phase: Annotated[float, number("Phase of the vibration in cycles, 0 .. 1.")] = 0.25,
    transparent: Annotated[bool, option("Transparent background.", "--transparent")] = False,
) -> None:
    """The 3D scene as a picture, without a display."""
    from beamviz.exports import screenshot

    phase = check_float("phase", phase, 0, 1)
    screenshot(path, scene, width, height, phase, transparent, direction, zoom)


@app.command(epilog=example("animate beam.gif --gamma 10 --mode 2"))
@takes_scene
def animate(
    scene: Any,
    path: Annotated[Path, typer.Argument(help="The film to write.", metavar="OUT.gif|webp|mp4")],
    direction: Annotated[Any, DIRECTION] = None,
    zoom: Annotated[float, ZOOM] = 1.0,
    width: Annotated[int, number("Width in pixels.")] = 800,
    height: Annotated[int, number("Height in pixels.")] = 450,
    fps: Annotated[float, number("Frames per second, 5 .. 50.")] = 25.0,
    periods: Annotated[int | None, number(PERIODS_HELP)] = None,
) -> None:
    """The 3D scene as a seamlessly looping film, without a display."""
    from beamviz.exports import animate

    with contextlib.ExitStack() as stack:

        def progress(count: int) -> Iterable[int]:
            return stack.enter_context(
                typer.progressbar(range(count), label="beamviz: frames", file=sys.stderr)
            )

        loop = animate(path, scene, width, height, fps, periods, direction, zoom, progress)
    if loop.note:
        print(f"beamviz: {loop.note}", file=sys.stderr)


@app.command(epilog=example("export beam.html --alpha 1 --gamma 10"))
@takes_scene
def export(
    scene: Any,
    context: typer.Context,
    path: Annotated[Path, typer.Argument(help=EXPORT_HELP, metavar=EXPORT_NAMES)],
    sweep: Annotated[Path | None, SWEEP_STORE] = None,
    over: Annotated[
        str,
        option(
            "With --sweep: the axes of the map (default: those of a sweep over two).",
            metavar="NAME,NAME",
        ),
    ] = "",
    at: Annotated[str, AT] = "",
    gap: Annotated[
        bool, option("With --sweep: the smallest gap between frequencies.", "--gap")
    ] = False,
) -> None:
    """The scene, its numbers, or a map of a sweep as a file."""
    check_store_options(context, sweep, ["over", "at", "gap"], ["path", "mode"])
    if sweep:
        from beamviz.plotting.maps import save_map
        from beamviz.sweeps import open_sweep

        mode = context.params["mode"] or (None if gap else len(scene.view.shares))
        place = parse_place(at)
        names = [name for name in over.split(",") if name]
        save_map(path, open_sweep(sweep), names, mode=mode, gap=gap, at=place)
        return
    from beamviz.exports import export

    for second in export(path, scene)[1:]:
        print(f"beamviz: also {second}", file=sys.stderr)


@app.command(epilog=example("lessons --format json"))
def lessons(
    format: Annotated[Literal["table", "json"], option("Output format.")] = "table",
) -> None:
    """Lists the lessons of the explorer."""
    from beamviz.lessons import LESSONS, lessons_table

    records = {"lessons": [lesson.record for lesson in LESSONS]}
    print(json_text(records) if format == "json" else lessons_table())


def paper_names(begun: str) -> list[str]:
    """The names that a shell offers for a table or figure."""
    from beamviz.evidence.paper import ALL, NAMES

    return [name for name in (*NAMES, ALL) if name.startswith(begun)]


@app.command(epilog=example("reproduce table1 fig4 --out paper"))
def reproduce(
    out: Folder,
    names: Annotated[
        list[str] | None,
        typer.Argument(
            help=PAPER_HELP, metavar="NAME", show_default="all", autocompletion=paper_names
        ),
    ] = None,
) -> None:
    """The paper's tables and figures, beside the numbers its text prints."""
    from beamviz.evidence.paper import ALL, reproduce

    print(reproduce(names or [ALL], out))


@app.command(epilog=example("benchmark --quick --out benchmark"))
def benchmark(
    out: Folder,
    quick: Annotated[
        bool,
        option("Every second resolution, each repeated for 0.03 s, not 0.2 s: 20 s.", "--quick"),
    ] = False,
    peers: Annotated[
        bool, option("Exudyn, OpenSees, CalculiX and pyBModes too, where installed.", "--peers")
    ] = False,
) -> None:
    """Speed against accuracy of every method and integrator: charts, and the numbers as JSON."""
    from beamviz.evidence.benchmark import benchmark

    print(benchmark(out, quick=quick, peers=peers, release=__version__))


@app.command(epilog=example("stability --quick --out stability"))
def stability(
    out: Folder,
    quick: Annotated[
        bool, option("A fifth of the cells, in a third of the time.", "--quick")
    ] = False,
) -> None:
    """Where each method fails: maps over speed and hub radius, mass, slenderness, with commands;
    and the stable states of an inward beam, straight or bent."""
    from beamviz.evidence.failure_maps import stability

    print(stability(out, quick))
