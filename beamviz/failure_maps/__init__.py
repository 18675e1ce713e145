"""beamviz stability: maps of where methods fail, and of the stable states of an inward beam, as
pictures, data and text."""

import math
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from beamviz.beam import PARAMETERS, Beam
from beamviz.failure_maps.compute import (
    FULL,
    KINDS,
    METHODS,
    MODES,
    OUTSIDE,
    QUICK,
    RIGHT,
    TRULY_UNSTABLE,
    Map,
    compute_maps,
)
from beamviz.failure_maps.states import (
    FULL_STATES,
    QUICK_STATES,
    STATES,
    StateMap,
    compute_states,
)
from beamviz.files import Files, make_folder, write_files
from beamviz.output import json_text, markdown_table

PAGE = "stability.md"
CORRECT = (RIGHT, TRULY_UNSTABLE, OUTSIDE)


def stability(out: Path, quick: bool, progress: Callable[[str], None]) -> str:
    """Compute every map and write pictures, stability.json and stability.md; the text of the page.

    Raises Unavailable, before anything is computed, for a folder that cannot be written to.
    """
    make_folder(out)
    size, state_size = (QUICK, QUICK_STATES) if quick else (FULL, FULL_STATES)
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        found = compute_maps(size, pool, progress)
        states = compute_states(state_size, pool, progress)
    write_files(out, files(found, states))
    return page(found, states)


def files(found: list[Map], states: StateMap) -> Files:
    """Pictures, data and text by file name."""
    from beamviz.failure_maps.plot import pictures, state_pictures

    data = json_text([*map(as_data, found), states_as_data(states)], indent=None) + "\n"
    contents = {PAGE: page(found, states).encode(), "stability.json": data.encode()}
    for one in found:
        for ending, picture in pictures(one).items():
            contents[f"stability-{one.plane.over}.{ending}"] = picture
    for ending, picture in state_pictures(states).items():
        contents[f"stability-states.{ending}"] = picture
    return contents


def axes_data(found: Map | StateMap) -> dict[str, Any]:
    """The axes of a map: the beam, the speeds and the values of the other number."""
    return {
        "over": found.plane.over,
        "beam": found.plane.beam.numbers,
        "gamma": found.gammas,
        "values": found.values,
    }


def as_data(found: Map) -> dict[str, Any]:
    """One map, with a command for every cell that is not correct."""
    return axes_data(found) | {
        "buckling": [rounded(gamma) for gamma in found.buckling],
        "methods": {
            method.name: {
                "options": method.options,
                "kinds": found.kinds(k),
                "limit": [rounded(gamma) for gamma in found.limits(k)],
                "false loss": [rounded(gamma) for gamma in found.losses[:, k]],
                "failing": list(failing(found, k)),
            }
            for k, method in enumerate(METHODS)
        },
    }


def states_as_data(found: StateMap) -> dict[str, Any]:
    """The map of stable states."""
    return axes_data(found) | {
        "methods": {
            method.name: {"options": method.options, "says": states.refusal}
            if states.refusal
            else {
                "options": method.options | {"state": "stable"},
                "states": states.kinds,
                "buckling": [rounded(gamma) for gamma in states.buckling],
                "limit": [rounded(gamma) for gamma in states.limit],
            }
            for method in METHODS
            for states in (found.methods[method.name],)
        },
    }


def failing(found: Map, method: int) -> Iterator[dict[str, Any]]:
    """Each failing cell of a method: the verdict, its errors, and the command that shows it."""
    for value, row in zip(found.values.tolist(), found.verdicts, strict=True):
        for gamma, cell in zip(found.gammas.tolist(), row, strict=True):
            verdict, place = cell[method], {"gamma": gamma, found.plane.over: value}
            if verdict.kind not in CORRECT:
                yield place | {
                    "kind": verdict.kind,
                    "discretisation error": rounded(verdict.discretisation),
                    "model error": rounded(verdict.model),
                    "says": verdict.message,
                    "command": command(found.plane.beam.replace(**place), METHODS[method].options),
                }


def command(beam: Beam, options: dict[str, Any]) -> str:
    """The command that solves a beam with options of `solve`."""
    numbers = {name: f"{value:.10g}" for name, value in beam.numbers.items()}
    given = {**numbers, "modes": MODES, **options}
    return " ".join(["beamviz modes", *(f"--{name} {value}" for name, value in given.items())])


def rounded(value: float) -> float | None:
    """Seven digits for JSON; None for nan and infinity."""
    return float(f"{value:.7g}") if math.isfinite(value) else None


def page(found: list[Map], states: StateMap) -> str:
    """Shares of each kind, and for each method and kind the slowest beam that shows it."""
    parts = ["# Where methods fail", "", "Shares of the cells of each map [%].", ""]
    for one in found:
        parts += [f"## Speed γ and {PARAMETERS[one.plane.over].symbol} ({one.plane.held})", ""]
        parts += [shares(one), "", "```", *examples(one), "```", ""]
    parts += [f"## Stable states: speed γ and {PARAMETERS[states.plane.over].symbol}", ""]
    parts += [f"An inward beam at constant speed, {states.plane.held}.", ""]
    parts += [state_shares(states), "", "```", *state_examples(states), "```", ""]
    return "\n".join(parts)


def state_shares(found: StateMap) -> str:
    """A table of the share [%] of each kind of state; the refusal of a method without bent ones."""
    rows = []
    for name, states in found.methods.items():
        percent = [
            100 * np.mean(states.kinds == kind) if states.kinds.size else 0 for kind in STATES
        ]
        rows.append([name, *(f"{p:.0f}" if p else "" for p in percent), states.refusal])
    return markdown_table(["method", *STATES, "says"], rows)


def state_examples(found: StateMap) -> Iterator[str]:
    """For each method and each kind of state the command of the slowest beam."""
    for method in METHODS:
        states = found.methods[method.name]
        for kind in STATES if states.kinds.size else ():
            rows, columns = np.nonzero(states.kinds == kind)
            for k in np.argsort(columns, kind="stable")[:1]:
                beam = found.plane.beam.replace(
                    gamma=float(found.gammas[columns[k]]),
                    **{found.plane.over: float(found.values[rows[k]])},
                )
                yield f"# {method.name}: {STATES[kind]}"
                yield command(beam, method.options | {"state": "stable"})


def shares(found: Map) -> str:
    """A table of the share [%] of each kind of verdict, method by method."""
    rows = []
    for k, method in enumerate(METHODS):
        kinds = found.kinds(k)
        percent = {kind: 100 * np.mean(kinds[kinds != OUTSIDE] == kind) for kind in KINDS}
        rows.append([method.name, *(f"{p:.0f}" if p else "" for p in percent.values())])
    return markdown_table(["method", *KINDS], rows)


def examples(found: Map) -> Iterator[str]:
    """For each method and each kind of failure the command of the slowest beam."""
    for k, method in enumerate(METHODS):
        slowest: dict[str, dict[str, Any]] = {}
        for row in sorted(failing(found, k), key=lambda row: row["gamma"]):
            slowest.setdefault(row["kind"], row)
        yield from (f"# {method.name}: {row['kind']}\n{row['command']}" for row in slowest.values())
