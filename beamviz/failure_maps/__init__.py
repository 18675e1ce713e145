"""beamviz stability: maps of where methods fail, and of the stable states of an inward beam, as
pictures, data and text."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from beamviz.beam import PARAMETERS, Beam
from beamviz.failure_maps import compute
from beamviz.failure_maps.compute import CORRECT, KINDS, METHODS, MODES, OUTSIDE, STATES, Map
from beamviz.files import Files, make_folder, write_files
from beamviz.output import json_text, markdown_table

PAGE = "stability.md"
QUICK, QUICK_STATES = (14, 9), (10, 6)  # cells along the speed and across
FULL, FULL_STATES = (32, 20), (22, 12)
STABLE = {"state": "stable"}
FAILURES = {kind: kind for kind in KINDS if kind not in CORRECT}


def stability(out: Path, quick: bool) -> str:
    """Compute every map and write pictures, stability.json and stability.md; the text of the page.

    Raises Unavailable, before anything is computed, for a folder that cannot be written to.
    """
    make_folder(out)
    size, state_size = (QUICK, QUICK_STATES) if quick else (FULL, FULL_STATES)
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        found = [compute.compute_map(plane, size, pool) for plane in compute.PLANES]
        rows = compute.state_rows, "stable states over "
        states = compute.compute_map(compute.INWARD, state_size, pool, *rows)
    write_files(out, files(found, states))
    return page(found, states)


def files(found: list[Map], states: Map) -> Files:
    """Pictures, data and text by file name."""
    from beamviz.failure_maps.plot import pictures, state_pictures

    data = [as_data(one, verdict_data) for one in found] + [as_data(states, state_data)]
    for one, numbers in zip(found, data, strict=False):
        numbers["buckling"] = rounded(one.speeds(0, "buckling"))  # of the reference
    text = json_text(data, indent=None) + "\n"
    contents = {PAGE: page(found, states).encode(), "stability.json": text.encode()}
    for one in found:
        contents |= pictures(one)
    return contents | state_pictures(states)


def as_data(found: Map, method_data: Callable[[Map, int], dict[str, Any]]) -> dict[str, Any]:
    """The beam, the speeds and the values of the other number of a map, and its methods."""
    return {
        "over": found.plane.over,
        "beam": found.plane.beam.numbers,
        "gamma": found.gammas,
        "values": found.values,
        "methods": {method.name: method_data(found, k) for k, method in enumerate(METHODS)},
    }


def verdict_data(found: Map, method: int) -> dict[str, Any]:
    """The verdicts on a method, with a command for every cell that is not correct."""
    return {
        "options": METHODS[method].options,
        "kinds": found.kinds(method),
        "limit": rounded(found.speeds(method, "limit")),
        "false loss": rounded(found.speeds(method, "loss")),
        "failing": list(failing(found, method)),
    }


def state_data(found: Map, method: int) -> dict[str, Any]:
    """The stable states by a method."""
    options = METHODS[method].options
    if refusal := found.refusal(method):
        return {"options": options, "says": refusal}
    return {
        "options": options | STABLE,
        "states": found.kinds(method),
        "buckling": rounded(found.speeds(method, "buckling")),
        "limit": rounded(found.speeds(method, "limit")),
    }


def failing(found: Map, method: int) -> Iterator[dict[str, Any]]:
    """Each failing cell of a method: the verdict, its errors, and the command that shows it."""
    for value, row in zip(found.values.tolist(), found.rows[method], strict=True):
        for gamma, verdict in zip(found.gammas.tolist(), row.cells, strict=True):
            if verdict.kind not in CORRECT:
                discretisation, model = rounded((verdict.discretisation, verdict.model))
                yield {
                    "gamma": gamma,
                    found.plane.over: value,
                    "kind": verdict.kind,
                    "discretisation error": discretisation,
                    "model error": model,
                    "says": verdict.message,
                    "command": command(found.plane.at(gamma, value), METHODS[method].options),
                }


def command(beam: Beam, options: dict[str, Any]) -> str:
    """The command that solves a beam with options of `solve`."""
    numbers = {name: f"{value:.10g}" for name, value in beam.numbers.items()}
    given = {**numbers, "modes": MODES, **options}
    return " ".join(["beamviz modes", *(f"--{name} {value}" for name, value in given.items())])


def rounded(values: Iterable[float]) -> list[float]:
    """Numbers to seven digits."""
    return [float(f"{value:.7g}") for value in values]


def page(found: list[Map], states: Map) -> str:
    """Shares of each kind, and for each method and kind the slowest beam that shows it."""
    parts = ["# Where methods fail", "", "Shares of the cells of each map [%].", ""]
    for one in found:
        parts += [f"## Speed γ and {PARAMETERS[one.plane.over].symbol} ({one.plane.held})", ""]
        parts += [shares(one, KINDS), "", *commands(one, FAILURES, {}), ""]
    parts += [f"## Stable states: speed γ and {PARAMETERS[states.plane.over].symbol}", ""]
    parts += [f"An inward beam at constant speed, {states.plane.held}.", ""]
    parts += [shares(states, STATES, "says"), "", *commands(states, STATES, STABLE), ""]
    return "\n".join(parts)


def shares(found: Map, kinds: Iterable[str], *heads: str) -> str:
    """A table of the share [%] of each kind; one more column with the message of a refusal."""
    rows = []
    for k, method in enumerate(METHODS):
        cells = found.kinds(k)
        accepted = cells[cells != OUTSIDE]
        percent = [100 * np.mean(accepted == kind) if accepted.size else 0 for kind in kinds]
        texts = [f"{p:.0f}" if p else "" for p in percent]
        rows.append([method.name, *texts, *[found.refusal(k)] * len(heads)])
    return markdown_table(["method", *kinds, *heads], rows)


def commands(found: Map, names: Mapping[str, str], options: dict[str, Any]) -> Iterator[str]:
    """The command of the slowest beam of each method and each of the kinds named, as a block."""
    yield "```"
    for k, method in enumerate(METHODS):
        places: dict[str, tuple[float, float]] = {}
        for gamma, column in zip(found.gammas, found.kinds(k).T, strict=False):  # none if refused
            for value, kind in zip(found.values, column, strict=True):
                places.setdefault(str(kind), (gamma, value))
        for kind in (kind for kind in names if kind in places):
            yield f"# {method.name}: {names[kind]}"
            yield command(found.plane.at(*places[kind]), method.options | options)
    yield "```"
