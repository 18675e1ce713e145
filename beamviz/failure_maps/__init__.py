"""beamviz stability: maps of where methods fail, and of the stable states of an inward beam, as
pictures, data and text."""

from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from beamviz.beam import PARAMETERS, Beam
from beamviz.failure_maps import compute
from beamviz.failure_maps.compute import CORRECT, KINDS, METHODS, MODES, OUTSIDE, PLANES, Map
from beamviz.failure_maps.states import STATES, StateMap, compute_states
from beamviz.files import Files, make_folder, write_files
from beamviz.output import json_text, markdown_table

PAGE = "stability.md"
QUICK, QUICK_STATES = (14, 9), (10, 6)  # cells along the speed and across
FULL, FULL_STATES = (32, 20), (22, 12)
STABLE = {"state": "stable"}


def stability(out: Path, quick: bool) -> str:
    """Compute every map and write pictures, stability.json and stability.md; the text of the page.

    Raises Unavailable, before anything is computed, for a folder that cannot be written to.
    """
    make_folder(out)
    size, state_size = (QUICK, QUICK_STATES) if quick else (FULL, FULL_STATES)
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        found = [compute.compute_map(plane, size, pool) for plane in PLANES]
        states = compute_states(state_size, pool)
    write_files(out, files(found, states))
    return page(found, states)


def files(found: list[Map], states: StateMap) -> Files:
    """Pictures, data and text by file name."""
    from beamviz.failure_maps.plot import pictures, state_pictures

    data = json_text([*map(as_data, found), states_as_data(states)], indent=None) + "\n"
    contents = {PAGE: page(found, states).encode(), "stability.json": data.encode()}
    for one in found:
        contents |= pictures(one)
    return contents | state_pictures(states)


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
        "buckling": rounded(found.buckling),
        "methods": {
            method.name: {
                "options": method.options,
                "kinds": found.kinds(k),
                "limit": rounded(found.limits(k)),
                "false loss": rounded(found.losses[:, k]),
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
                "options": method.options | STABLE,
                "states": states.kinds,
                "buckling": rounded(states.buckling),
                "limit": rounded(states.limit),
            }
            for method in METHODS
            for states in (found.methods[method.name],)
        },
    }


def failing(found: Map, method: int) -> Iterator[dict[str, Any]]:
    """Each failing cell of a method: the verdict, its errors, and the command that shows it."""
    for value, row in zip(found.values.tolist(), found.verdicts, strict=True):
        for gamma, cell in zip(found.gammas.tolist(), row, strict=True):
            verdict = cell[method]
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


def page(found: list[Map], states: StateMap) -> str:
    """Shares of each kind, and for each method and kind the slowest beam that shows it."""
    parts = ["# Where methods fail", "", "Shares of the cells of each map [%].", ""]
    for one in found:
        kinds = [one.kinds(k) for k in range(len(METHODS))]
        rows = [
            [method.name, *shares(here[here != OUTSIDE], KINDS)]
            for method, here in zip(METHODS, kinds, strict=True)
        ]
        commands = [
            f"# {method.name}: {kind}\n{command(one.plane.at(*place), method.options)}"
            for method, here in zip(METHODS, kinds, strict=True)
            for kind, place in slowest(one, here).items()
            if kind not in CORRECT
        ]
        parts += [f"## Speed γ and {PARAMETERS[one.plane.over].symbol} ({one.plane.held})", ""]
        parts += [markdown_table(["method", *KINDS], rows), "", "```", *commands, "```", ""]
    parts += [f"## Stable states: speed γ and {PARAMETERS[states.plane.over].symbol}", ""]
    parts += [f"An inward beam at constant speed, {states.plane.held}.", ""]
    rows = [[name, *shares(one.kinds, STATES), one.refusal] for name, one in states.methods.items()]
    commands = []
    for method in METHODS:
        places = slowest(states, states.methods[method.name].kinds)
        for kind in (kind for kind in STATES if kind in places):
            commands += [f"# {method.name}: {STATES[kind]}"]
            commands += [command(states.plane.at(*places[kind]), method.options | STABLE)]
    parts += [markdown_table(["method", *STATES, "says"], rows), "", "```", *commands, "```", ""]
    return "\n".join(parts)


def shares(found: np.ndarray, kinds: Iterable[str]) -> list[str]:
    """The share [%] of each kind among those found; empty where there are none."""
    percent = (100 * np.mean(found == kind) if found.size else 0 for kind in kinds)
    return [f"{p:.0f}" if p else "" for p in percent]


def slowest(found: Map | StateMap, kinds: np.ndarray) -> dict[str, tuple[float, float]]:
    """Speed and other number of the slowest beam of each of the kinds (rows, columns) of a method,
    in the order of speed."""
    places: dict[str, tuple[float, float]] = {}
    for gamma, column in zip(found.gammas, kinds.T, strict=False):  # empty without states
        for value, kind in zip(found.values, column, strict=True):
            places.setdefault(str(kind), (gamma, value))
    return places
