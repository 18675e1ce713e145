"""beamviz benchmark: measure every method, write the chart and the numbers, report the ratios."""

import contextlib
import os
import platform
import sys
from collections.abc import Iterator
from datetime import date
from importlib.metadata import version
from pathlib import Path
from typing import Any

from beamviz.benchmark import work_precision
from beamviz.benchmark.external import PEERS
from beamviz.benchmark.work_precision import (
    FULL,
    METHODS,
    QUICK,
    SCENES,
    Row,
    Solver,
    dominated,
    lapack_times,
    pareto_front,
    time_to_error,
)
from beamviz.files import writable_folder, write_files
from beamviz.output import json_text

NAME = "benchmark"
TARGETS = (1e-2, 1e-4, 1e-6)
LAPACK_REPEATS = {False: 400, True: 50}  # by `quick`


def benchmark(folder: Path, quick: bool, peers: bool, release: str) -> str:
    """Write benchmark.png, .svg and .json to a folder; the ratios as text.

    `release` is the version of beamviz that they name. Raises Unavailable, before anything is
    measured, for a folder that cannot be written to.
    """
    with writable_folder(folder):
        (folder / f"{NAME}.json").touch()
    solvers = METHODS + (PEERS if peers else ())
    rows = work_precision.measure(solvers, QUICK if quick else FULL, progress)
    progress("bare LAPACK")
    times = {scene: lapack_times(beam, LAPACK_REPEATS[quick]) for scene, beam in SCENES.items()}
    ratios = {
        "bare_lapack": {scene: found.solve / found.lapack for scene, found in times.items()},
        "eigh": {scene: found.solve / found.eigh for scene, found in times.items()},
    }
    about = environment(solvers, quick, release) | ratios
    with writable_folder(folder):
        write_files(folder, files(rows, about))
    return "\n".join(summary(rows, ratios))


def progress(text: str) -> None:
    """A line on stderr, apart from the answer of the command."""
    print(text, file=sys.stderr)


def environment(solvers: tuple[Solver, ...], quick: bool, release: str) -> dict[str, Any]:
    """The machine, the date and the versions of a measurement."""
    versions = {"beamviz": release, "python": platform.python_version()}
    versions |= {name: version(name) for name in ("numpy", "scipy")}
    versions |= {one.name.partition(",")[0]: one.version() for one in solvers if not one.missing}
    return {
        "date": date.today().isoformat(),
        "machine": {"processor": processor(), "cores": os.cpu_count()},
        "versions": {name: number for name, number in versions.items() if number},
        "threads": os.environ.get("OPENBLAS_NUM_THREADS", "not set"),
        "effort": "quick" if quick else "full",
    }


def processor() -> str:
    """The model of the processor."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def files(rows: list[Row], about: dict[str, Any]) -> dict[str, bytes]:
    """The contents of the files by name."""
    from beamviz.benchmark.plot import draw
    from beamviz.plotting import picture_files

    models = work_precision.model_errors()
    versions = ", ".join(f"{name} {number}" for name, number in about["versions"].items())
    caption = f"{about['date']}, one thread of {about['machine']['processor']}.\n{versions}."
    data = {
        **about,
        "scenes": {scene: beam.numbers for scene, beam in SCENES.items()},
        "rows": rows,
        "model_errors": models,
    }
    text = json_text(data, indent=1) + "\n"
    contents = picture_files(draw(rows, models, caption)) | {"json": text.encode()}
    return {f"{NAME}.{ending}": content for ending, content in contents.items()}


def summary(rows: list[Row], ratios: dict[str, dict[str, float]]) -> Iterator[str]:
    """Times at equal error relative to auto's; whether auto is on the Pareto front; and auto's
    times relative to those of its eigenproblems alone."""
    head = "".join(f"{scene:>18}" for scene in SCENES)
    for target in TARGETS:
        yield f"{f'time to error {target:g} / auto':34}{head}"
        for name in dict.fromkeys(row.name for row in rows):
            cells = "".join(f"{_ratio(rows, scene, name, target):>18}" for scene in SCENES)
            yield f"{name:34}{cells}"
        yield ""
    yield from front_report(rows, "auto")
    yield ""
    for name, key in ("LAPACK", "bare_lapack"), ("scipy.linalg.eigh", "eigh"):
        cells = "".join(f"{ratios[key][scene]:>18.1f}" for scene in SCENES)
        yield f"{f'auto / its {name} alone':34}{cells}"


def front_report(rows: list[Row], name: str) -> Iterator[str]:
    """Whether a solver is on the Pareto front of time and distance from the paper's model."""
    pairs = dominated(rows, name)
    if not pairs:
        yield f"{name} is on the Pareto front: nothing is faster and as close to the paper's model"
    for row, other in pairs:
        yield (
            f"{row.scene}: {other.name}, {other.option} {other.resolution:g}, is faster and as"
            f" close to the model as {name}, {row.option} {row.resolution:g}"
        )


def _ratio(rows: list[Row], scene: str, name: str, target: float) -> str:
    """A time relative to auto's, or why there is none."""
    here = [row for row in rows if row.scene == scene]
    ours, theirs = (time_to_error(pareto_front(here, one), target) for one in ("auto", name))
    if ours and theirs:
        return f"{theirs / ours:.2g}" if theirs < 10 * ours else f"{theirs / ours:.0f}"
    reasons = [row.reason for row in here if row.name == name]
    return "no answer" if all(reasons) else "not reached"
