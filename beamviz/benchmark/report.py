"""beamviz benchmark: measure, write the chart and the numbers, and say the ratios."""

import os
import platform
import sys
from collections.abc import Iterator
from datetime import date
from importlib.metadata import version
from pathlib import Path
from typing import Any

from beamviz.benchmark import solvers as contestants
from beamviz.benchmark import work_precision as workprecision
from beamviz.benchmark.cases import SCENES
from beamviz.benchmark.lapack import bare
from beamviz.benchmark.solvers import Contestant
from beamviz.benchmark.work_precision import FULL, QUICK, Row, beaten, front, time_at
from beamviz.plotting.files import write, writing_to

NAME = "benchmark"
TARGETS = (1e-2, 1e-4, 1e-6)
LAPACK_REPEATS = {False: 400, True: 50}


def benchmark(folder: Path, quick: bool, peers: bool, release: str) -> str:
    """Write benchmark.png, .svg and .json to the folder; the summary in words. The release of
    beamviz is named in them.

    Raises Unavailable for a folder that cannot be written to.
    """
    with writing_to(folder):
        (folder / f"{NAME}.json").touch()
    everyone = [*contestants.METHODS, *(contestants.peers() if peers else [])]
    rows = workprecision.measured(everyone, QUICK if quick else FULL, say)
    say("bare LAPACK")
    alone = {name: bare(beam, LAPACK_REPEATS[quick]) for name, beam in SCENES.items()}
    ratios = {
        "bare_lapack": {name: found.ratio for name, found in alone.items()},
        "eigh": {name: found.ratio_to_eigh for name, found in alone.items()},
    }
    about = surroundings(everyone, quick, release) | ratios
    with writing_to(folder):
        write(folder, {f"{NAME}.{ending}": data for ending, data in files(rows, about).items()})
    return "\n".join(summary(rows, ratios))


def say(text: str) -> None:
    """Progress, apart from what the command answers."""
    print(text, file=sys.stderr)


def surroundings(everyone: list[Contestant], quick: bool, release: str) -> dict[str, Any]:
    """What was measured on, when, and with which versions."""
    versions = {name: version(name) for name in ("numpy", "scipy")}
    versions |= {one.name.partition(",")[0]: one.version for one in everyone if one.version}
    return {
        "date": date.today().isoformat(),
        "machine": {"processor": processor(), "cores": os.cpu_count()},
        "versions": {"beamviz": release, "python": platform.python_version()} | versions,
        "threads": os.environ.get("OPENBLAS_NUM_THREADS", "not set"),
        "effort": "quick" if quick else "full",
    }


def processor() -> str:
    """The model of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def files(rows: list[Row], about: dict[str, Any]) -> dict[str, bytes]:
    """The contents of the files by ending."""
    from beamviz.benchmark import plot as workprecision_plot
    from beamviz.paper.plots import saved

    figure = workprecision_plot.draw(rows, workprecision.model_errors(), words(about))
    return saved(figure) | {"json": workprecision.as_json(rows, about).encode()}


def words(about: dict[str, Any]) -> str:
    """What stands below the chart."""
    machine, versions = about["machine"], about["versions"]
    others = ", ".join(f"{name} {number}" for name, number in versions.items())
    return f"{about['date']}, one thread of {machine['processor']}.\n{others}."


def summary(rows: list[Row], ratios: dict[str, dict[str, float]]) -> Iterator[str]:
    """Times at equal error against auto's; whether anything is sooner than auto and as near to the
    paper's model; and auto's times against that of its eigenproblems alone, by LAPACK's bare
    routines and by scipy.linalg.eigh."""
    names = list(dict.fromkeys(row.name for row in rows))
    head = "".join(f"{scene:>18}" for scene in SCENES)
    for target in TARGETS:
        yield f"{f'time to error {target:g} / auto':34}{head}"
        for name in names:
            cells = "".join(f"{_cell(rows, scene, name, target):>18}" for scene in SCENES)
            yield f"{name:34}{cells}"
        yield ""
    yield from on_the_front(rows, "auto")
    yield ""
    for name, key in ("LAPACK", "bare_lapack"), ("scipy.linalg.eigh", "eigh"):
        cells = "".join(f"{ratios[key][scene]:>18.1f}" for scene in SCENES)
        yield f"{f'auto / its {name} alone':34}{cells}"


def on_the_front(rows: list[Row], name: str) -> Iterator[str]:
    """Whether a method is on the Pareto front of time and distance from the paper's model."""
    pairs = beaten(rows, name)
    if not pairs:
        yield f"{name} is on the Pareto front: nothing is sooner and as near to the paper's model"
    for ours, theirs in pairs:
        yield (
            f"{ours.scene}: {theirs.name}, {theirs.option} {theirs.resolution:g}, is sooner and as"
            f" near to the model as {name}, {ours.option} {ours.resolution:g}"
        )


def _cell(rows: list[Row], scene: str, name: str, target: float) -> str:
    """A ratio, or why there is none."""
    here = [row for row in rows if row.scene == scene]
    ours, theirs = (time_at(front(here, one), target) for one in ("auto", name))
    if ours and theirs:
        return f"{theirs / ours:.2g}" if theirs < 10 * ours else f"{theirs / ours:.0f}"
    reasons = [row.reason for row in here if row.name == name]
    return "no answer" if all(reasons) else "not reached"
