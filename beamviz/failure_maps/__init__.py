"""beamviz stability: maps of where methods fail, as pictures, data and text."""

import math
from collections.abc import Callable, Iterator
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
from beamviz.files import Files, make_folder, write_files
from beamviz.output import json_text, markdown_table

PAGE = "stability.md"
CORRECT = (RIGHT, TRULY_UNSTABLE, OUTSIDE)


def stability(out: Path, quick: bool, progress: Callable[[str], None]) -> str:
    """Compute every map and write pictures, stability.json and stability.md; the text of the page.

    Raises Unavailable, before anything is computed, for a folder that cannot be written to.
    """
    make_folder(out)
    found = compute_maps(QUICK if quick else FULL, progress)
    write_files(out, files(found))
    return page(found)


def files(found: list[Map]) -> Files:
    """Pictures, data and text by file name."""
    from beamviz.failure_maps.plot import pictures

    data = json_text([as_data(one) for one in found], indent=None) + "\n"
    contents = {PAGE: page(found).encode(), "stability.json": data.encode()}
    for one in found:
        for ending, picture in pictures(one).items():
            contents[f"stability-{one.plane.over}.{ending}"] = picture
    return contents


def as_data(found: Map) -> dict[str, Any]:
    """One map, with a command for every cell that is not correct."""
    return {
        "over": found.plane.over,
        "beam": found.plane.beam.numbers,
        "gamma": found.gammas,
        "values": found.values,
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


def page(found: list[Map]) -> str:
    """Shares of each kind, and for each method and kind the slowest beam that shows it."""
    parts = ["# Where methods fail", "", "Shares of the cells of each map [%].", ""]
    for one in found:
        parts += [f"## Speed γ and {PARAMETERS[one.plane.over].symbol} ({one.plane.held})", ""]
        parts += [shares(one), "", "```", *examples(one), "```", ""]
    return "\n".join(parts)


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
