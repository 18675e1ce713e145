"""Work against precision: the time of a solve against the error of its frequencies.

The discretisation error is the largest relative error of the five lowest frequencies against the
exact ones of the method's own model (limits.json); the model error is the distance of these from
the exact ones of the paper's model. They are two quantities and never added: how far an answer is
from the paper's model is a third, of its own. Time is that of the processor, the least of many
calls after a first one, in one thread, assembly included: it is what a calm machine takes, whatever
else runs. A program of its own is timed as a whole.
"""

import json
import os
import time
from collections.abc import Callable, Iterable
from importlib import resources
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.benchmark.cases import MODES, SCENES
from beamviz.benchmark.solvers import Contestant
from beamviz.errors import BeamvizError

REFERENCE = "green"  # the paper's model
FLOOR = 1e-15


class Effort(NamedTuple):
    """How long to measure: seconds of repeats for every row, and of one call at the most. Of the
    resolutions each, or every second one."""

    seconds: float
    budget: float
    every: int = 1

    def chosen(self, resolutions: tuple[float, ...]) -> tuple[float, ...]:
        return resolutions[:: -self.every][::-1]


FULL, QUICK = Effort(0.2, 4.0), Effort(0.03, 0.5, 2)
EXACT = 1e-13  # an error that no finer resolution need improve
REPEATS = 400


class Row(NamedTuple):
    """One solve: its time [s], its error and how far it is from the paper's model, or the reason it
    has none."""

    scene: str
    name: str
    theory: str
    option: str
    resolution: float | None
    seconds: float | None
    error: float | None
    from_paper: float | None = None
    reason: str = ""


Limits = dict[str, dict[str, np.ndarray | str]]  # scene, theory -> omega^2 (modes,) or a reason


def limits() -> Limits:
    """The exact omega^2 of every scene in every model, or why there are none."""
    text = resources.files("beamviz.benchmark").joinpath("limits.json").read_text()
    return {
        scene: {
            theory: values if isinstance(values, str) else np.array([float(v) for v in values])
            for theory, values in theories.items()
        }
        for scene, theories in json.loads(text)["limits"].items()
    }


def error(squares: np.ndarray, exact: np.ndarray) -> float:
    """The largest relative error of a frequency or growth rate, from omega^2 (modes,)."""
    return float(max(abs(squares - exact).max() and (abs(squares / exact - 1) / 2).max(), FLOOR))


def measured(
    contestants: Iterable[Contestant], effort: Effort, say: Callable[[str], None]
) -> list[Row]:
    """A row for every scene, contestant and resolution."""
    exact, everyone, rows = limits(), list(contestants), []
    for scene, beam in SCENES.items():
        for one in everyone:
            say(f"{scene}: {one.name}")
            rows += _line(scene, beam, one, exact[scene], effort)
    return rows


def _line(
    scene: str,
    beam: Beam,
    contestant: Contestant,
    of_models: dict[str, np.ndarray | str],
    effort: Effort,
) -> list[Row]:
    """The rows of one contestant in one scene, coarse to fine; they end with the budget."""
    exact, paper = of_models[contestant.theory], of_models[REFERENCE]
    assert not isinstance(paper, str), "green strain always has an equilibrium outward"
    blank = Row(scene, contestant.name, contestant.theory, contestant.option, None, None, None)
    if contestant.absent:
        return [blank._replace(reason=contestant.absent)]
    if isinstance(exact, str):
        return [blank._replace(reason=exact)]
    rows: list[Row] = []
    spent = 0.0
    for resolution in effort.chosen(contestant.resolutions):
        row = blank._replace(resolution=resolution)
        if spent > effort.budget:
            rows.append(row._replace(reason=f"out of budget: the coarser one took {spent:.1f} s"))
            continue
        start = clock()
        rows.append(_measure(row, beam, contestant, exact, paper, effort))
        spent = rows[-1].seconds or clock() - start
        if (found := rows[-1].error) and found < EXACT:
            break
    return rows


def _measure(
    row: Row,
    beam: Beam,
    contestant: Contestant,
    exact: np.ndarray,
    paper: np.ndarray,
    effort: Effort,
) -> Row:
    """The first call warms up and is the check, the fastest of the others is the time."""
    try:
        squares = contestant.squares(beam, row.resolution, MODES)
    except BeamvizError as failure:
        return row._replace(reason=str(failure))
    return row._replace(
        seconds=least(lambda: contestant.squares(beam, row.resolution, MODES), effort),
        error=error(squares, exact),
        from_paper=error(squares, paper),
    )


def least(work: Callable[[], object], effort: Effort) -> float:
    """The least time [s] of the calls that fit, and of one at least."""
    times: list[float] = []
    began = clock()
    while not times or (len(times) < REPEATS and clock() - began < effort.seconds):
        start = clock()
        work()
        times.append(clock() - start)
    return min(times)


def clock() -> float:
    """Processor time [s] of this process and the programs it has run."""
    times = os.times()
    return time.process_time() + times.children_user + times.children_system


def model_errors() -> dict[str, dict[str, float | str]]:
    """Scene, theory -> how far its exact frequencies are from the paper's model, or a reason."""
    found: dict[str, dict[str, float | str]] = {}
    for scene, theories in limits().items():
        reference = theories[REFERENCE]
        assert not isinstance(reference, str), "green strain always has an equilibrium outward"
        found[scene] = {
            theory: values if isinstance(values, str) else error(values, reference)
            for theory, values in theories.items()
            if theory != REFERENCE
        }
    return found


def front(rows: list[Row], name: str) -> list[tuple[float, float]]:
    """(error, seconds) of a contestant's rows that nothing of its own beats, errors falling."""
    points = sorted(
        (row.seconds, row.error)
        for row in rows
        if row.name == name and row.seconds is not None and row.error is not None
    )
    kept: list[tuple[float, float]] = []
    for seconds, error_of_row in points:
        if not kept or error_of_row < kept[-1][0]:
            kept.append((error_of_row, seconds))
    return kept


def beaten(rows: list[Row], name: str) -> list[tuple[Row, Row]]:
    """Each row of a contestant with one of another that is sooner and no farther from the paper's
    model: none where it is on the Pareto front."""
    timed = [(row, row.seconds, row.from_paper) for row in rows]
    points = [(row, s, e) for row, s, e in timed if s is not None and e is not None]
    return [
        (row, other)
        for row, seconds, off in points
        if row.name == name
        for other, sooner, nearer in points
        if other.name != name and other.scene == row.scene and sooner < seconds and nearer <= off
    ]


def time_at(points: list[tuple[float, float]], wanted: float) -> float | None:
    """The time to an error: that of the first point at least as good, none interpolated."""
    return next((seconds for error_of_point, seconds in points if error_of_point <= wanted), None)


def as_json(rows: list[Row], about: dict[str, Any]) -> str:
    """Everything measured, and about what and where."""
    data = {
        **about,
        "scenes": {scene: beam.numbers for scene, beam in SCENES.items()},
        "rows": [row._asdict() for row in rows],
        "model_errors": model_errors(),
    }
    return json.dumps(data, indent=1) + "\n"
