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


def as_data(found: Map) -> dict[str, Any]:
    """The beam, the speeds and the values of the other number of a map, and its methods."""
    plane = found.plane
    return {
        "map": plane.name,
        "over": plane.over,
        "beam": plane.beam.numbers,
        "gamma": found.gammas,
        "values": found.values,
        "methods": {one.method.name: method_data(found, one) for one in found.methods},
    }


def method_data(found: Map, one: MethodMap) -> dict[str, Any]:
    """The data of a method: the kinds of cells and which were solved, the speeds of each row, and
    the cells that are not correct."""
    options = {**found.plane.subject.options, **one.method.options}
    if one.refusal:
        return {"options": options, "says": one.refusal}
    speeds = {name: rounded(one.speeds(name)) for name in ("limit", "buckling", "loss")}
    cells = list(cell_data(found, one))
    return {"options": options, "kinds": one.kinds, "solved": one.solved, **speeds, "cells": cells}


def cell_data(found: Map, one: MethodMap) -> Iterator[dict[str, Any]]:
    """Each cell of a method that is not correct: its kind, its errors where it was solved, and the
    command that shows it."""
    for value, line in zip(found.values.tolist(), one.lines, strict=True):
        for gamma, cell in zip(found.gammas.tolist(), line.cells, strict=True):
            if cell.kind not in found.plane.subject.correct:
                discretisation, model = rounded((cell.discretisation, cell.model))
                yield {
                    "gamma": gamma,
                    found.plane.over: value,
                    "kind": cell.kind.name,
                    "solved": cell.solved,
                    "discretisation error": discretisation,
                    "model error": model,
                    "says": cell.message,
                    "command": command(found, one, gamma, value),
                }


def command(found: Map, one: MethodMap, gamma: float, value: float) -> str:
    """The command that solves the beam of a cell by a method."""
    beam: Beam = found.plane.at(gamma, value)
    numbers = {name: f"{number:.10g}" for name, number in beam.numbers.items()}
    given = {**numbers, "modes": MODES, **one.method.options, **found.plane.subject.options}
    return " ".join(["beamviz modes", *(f"--{name} {text}" for name, text in given.items())])


def rounded(values: Iterable[float]) -> list[float]:
    """Numbers to seven digits."""
    return [float(f"{value:.7g}") for value in values]


def page(maps: list[Map]) -> str:
    """Shares of each kind, and for each method and kind the slowest beam that shows it."""
    parts = ["# Where methods fail", "Shares of the cells of each map [%]."]
    for found in maps:
        heading = found.plane.subject.heading.format(found.plane.parameter.symbol)
        parts += [f"## {heading}", f"At constant speed, {found.plane.held}."]
        parts += [shares(found), "\n".join(["```", *commands(found), "```"])]
    return "\n\n".join(parts) + "\n"


def shares(found: Map) -> str:
    """A table of the share [%] of each kind; one more column where methods refuse, with why."""
    kinds = [kind for kind in found.plane.subject.kinds if kind != OUTSIDE]
    heads, rows = ["says"] * any(one.refusal for one in found.methods), []
    for one in found.methods:
        accepted = one.kinds[one.kinds != OUTSIDE.name]
        counts = [np.count_nonzero(accepted == kind.name) for kind in kinds]
        texts = [f"{100 * count / accepted.size:.0f}" if count else "" for count in counts]
        rows.append([one.method.name, *texts, *[one.refusal] * len(heads)])
    return markdown_table(["method", *(kind.name for kind in kinds), *heads], rows)


def commands(found: Map) -> Iterator[str]:
    """The command of the slowest beam of each method and each kind that is not correct."""
    subject = found.plane.subject
    for one, kind in product(found.methods, subject.kinds):
        places = np.argwhere(kind.name == one.kinds.T)  # slowest first
        if kind not in subject.correct and len(places):
            column, row = places[0]
            yield f"# {one.method.name}: {kind.meaning}"
            yield command(found, one, found.gammas[column], found.values[row])
