"""The maps as data and as a page of text."""

from collections.abc import Iterable, Iterator
from itertools import product
from typing import Any

import numpy as np

from beamviz.beam import Beam
from beamviz.evidence.failure_maps.failures import MODES
from beamviz.evidence.failure_maps.kinds import OUTSIDE
from beamviz.evidence.failure_maps.maps import Map, MethodMap
from beamviz.files import markdown_table


def as_data(plane_map: Map) -> dict[str, Any]:
    """The beam, the speeds and the values of the other number of a map, and its methods."""
    plane = plane_map.plane
    return {
        "map": plane.name,
        "over": plane.over,
        "beam": plane.beam.numbers,
        "gamma": plane_map.gammas,
        "values": plane_map.values,
        "methods": {
            method_map.name: method_data(plane_map, method_map) for method_map in plane_map.methods
        },
    }


def method_data(plane_map: Map, method_map: MethodMap) -> dict[str, Any]:
    """The data of a method: the kinds of cells and which were solved, the speeds of each row, and
    the cells that are not correct."""
    options = {**plane_map.plane.subject.options, **method_map.options}
    if method_map.refusal:
        return {"options": options, "says": method_map.refusal}
    speeds = {name: rounded(method_map.speeds(name)) for name in ("limit", "buckling", "loss")}
    cells = list(cell_data(plane_map, method_map))
    return {
        "options": options,
        "kinds": method_map.kinds,
        "solved": method_map.solved,
        **speeds,
        "cells": cells,
    }


def cell_data(plane_map: Map, method_map: MethodMap) -> Iterator[dict[str, Any]]:
    """Each cell of a method that is not correct: its kind, its errors where it was solved, and the
    command that shows it."""
    for value, line in zip(plane_map.values.tolist(), method_map.lines, strict=True):
        for gamma, cell in zip(plane_map.gammas.tolist(), line.cells, strict=True):
            if cell.kind not in plane_map.plane.subject.correct:
                discretisation, model = rounded((cell.discretisation, cell.model))
                yield {
                    "gamma": gamma,
                    plane_map.plane.over: value,
                    "kind": cell.kind.name,
                    "solved": cell.solved,
                    "discretisation error": discretisation,
                    "model error": model,
                    "says": cell.message,
                    "command": command(plane_map, method_map, gamma, value),
                }


def command(plane_map: Map, method_map: MethodMap, gamma: float, value: float) -> str:
    """The command that solves the beam of a cell by a method."""
    beam: Beam = plane_map.plane.at(gamma, value)
    numbers = {name: f"{number:.10g}" for name, number in beam.numbers.items()}
    given = {**numbers, "modes": MODES, **method_map.options, **plane_map.plane.subject.options}
    return " ".join(["beamviz modes", *(f"--{name} {text}" for name, text in given.items())])


def rounded(values: Iterable[float]) -> list[float]:
    """Numbers to seven digits."""
    return [float(f"{value:.7g}") for value in values]


def page(maps: list[Map]) -> str:
    """Shares of each kind, and for each method and kind the slowest beam that shows it."""
    parts = ["# Where methods fail", "Shares of the cells of each map [%]."]
    for plane_map in maps:
        heading = plane_map.plane.subject.heading.format(plane_map.plane.parameter.symbol)
        parts += [f"## {heading}", f"At constant speed, {plane_map.plane.held}."]
        parts += [shares(plane_map), "\n".join(["```", *commands(plane_map), "```"])]
    return "\n\n".join(parts) + "\n"


def shares(plane_map: Map) -> str:
    """A table of the share [%] of each kind; one more column where methods refuse, with why."""
    kinds = [kind for kind in plane_map.plane.subject.kinds if kind != OUTSIDE]
    heads, rows = ["says"] * any(method_map.refusal for method_map in plane_map.methods), []
    for method_map in plane_map.methods:
        accepted = method_map.kinds[method_map.kinds != OUTSIDE.name]
        counts = [np.count_nonzero(accepted == kind.name) for kind in kinds]
        texts = [f"{100 * count / accepted.size:.0f}" if count else "" for count in counts]
        rows.append([method_map.name, *texts, *[method_map.refusal] * len(heads)])
    return markdown_table(["method", *(kind.name for kind in kinds), *heads], rows)


def commands(plane_map: Map) -> Iterator[str]:
    """The command of the slowest beam of each method and each kind that is not correct."""
    subject = plane_map.plane.subject
    for method_map, kind in product(plane_map.methods, subject.kinds):
        places = np.argwhere(kind.name == method_map.kinds.T)  # slowest first
        if kind not in subject.correct and len(places):
            column, row = places[0]
            yield f"# {method_map.name}: {kind.meaning}"
            yield command(plane_map, method_map, plane_map.gammas[column], plane_map.values[row])
