"""The maps of where methods fail as data, as words, and as files."""

import math
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from beamviz.beam import PARAMETERS
from beamviz.failure_maps.compute import FULL, QUICK, Map, command, maps
from beamviz.failure_maps.verdicts import CONTENDERS, KINDS, OUTSIDE, RIGHT, TRULY_UNSTABLE
from beamviz.files import Files, writable_folder, write_files
from beamviz.output import json_text, markdown_table

PAGE = "stability.md"
SOUND = (RIGHT, TRULY_UNSTABLE, OUTSIDE)


def stability(out: Path, quick: bool, say: Callable[[str], None]) -> str:
    """Compute every map, write pictures and stability.json, and return the page of words."""
    with writable_folder(out):
        write_files(out, {PAGE: b""})  # says before all the work whether this folder will do
        found = maps(QUICK if quick else FULL, say)
        write_files(out, contents(found))
    return words(found)


def contents(found: list[Map]) -> Files:
    """Pictures, data and words, by file name."""
    from beamviz.failure_maps.plot import pictures

    data = json_text([as_data(one) for one in found], indent=None) + "\n"
    named = {PAGE: words(found).encode(), "stability.json": data.encode()}
    for one in found:
        for ending, picture in pictures(one).items():
            named[f"stability-{one.plane.over}.{ending}"] = picture
    return named


def as_data(found: Map) -> dict[str, Any]:
    """One map, with a command for every cell that is not as it should be."""
    return {
        "over": found.plane.over,
        "beam": found.plane.beam.numbers,
        "gamma": found.gammas.tolist(),
        "values": found.values.tolist(),
        "buckling": [number(gamma) for gamma in found.buckling],
        "methods": {
            contender.name: {
                "options": contender.options,
                "kinds": [[cell[k].kind for cell in row] for row in found.cells],
                "limit": [number(gamma) for gamma in found.limits(k)],
                "false loss": [number(gamma) for gamma in found.losses[:, k]],
                "failing": failing(found, k),
            }
            for k, contender in enumerate(CONTENDERS)
        },
    }


def failing(found: Map, contender: int) -> list[dict[str, Any]]:
    """Each failing cell of a method: the verdict, the errors behind it, how to see it again."""
    return [
        {
            "gamma": gamma,
            found.plane.over: value,
            "kind": cell[contender].kind,
            "discretisation error": number(cell[contender].discretisation),
            "model error": number(cell[contender].model),
            "says": cell[contender].says,
            "command": replay(found, gamma, value, contender),
        }
        for value, row in zip(found.values.tolist(), found.cells, strict=True)
        for gamma, cell in zip(found.gammas.tolist(), row, strict=True)
        if cell[contender].kind not in SOUND
    ]


def replay(found: Map, gamma: float, value: float, contender: int) -> str:
    """The command that shows a cell again."""
    beam = found.plane.beam.replace(gamma=gamma, **{found.plane.over: value})
    return command(beam, contender)


def number(value: float) -> float | None:
    """For JSON: three digits of an error or seven of a speed are plenty; None for no number."""
    return float(f"{value:.7g}") if math.isfinite(value) else None


def words(found: list[Map]) -> str:
    """Counts of each kind, and for each method and kind the slowest beam that shows it."""
    parts = ["# Where methods fail", "", "Shares of the cells of each map [%].", ""]
    for one in found:
        parts += [f"## Speed γ and {PARAMETERS[one.plane.over].symbol} ({one.plane.held})", ""]
        parts += [shares(one), "", "```", *examples(one), "```", ""]
    return "\n".join(parts)


def shares(found: Map) -> str:
    """How much of a map each kind takes, method by method."""
    rows = []
    for k, contender in enumerate(CONTENDERS):
        kinds = [cell[k].kind for row in found.cells for cell in row if cell[k].kind != OUTSIDE]
        count = Counter(kinds)
        cells = [f"{100 * count[kind] / len(kinds):.0f}" if count[kind] else "" for kind in KINDS]
        rows.append([contender.name, *cells])
    return markdown_table(["method", *KINDS], rows)


def examples(found: Map) -> list[str]:
    """Commands: of each method and each kind of failure the slowest beam."""
    found_lines = []
    for k, contender in enumerate(CONTENDERS):
        seen: dict[str, dict[str, Any]] = {}
        for row in sorted(failing(found, k), key=lambda row: row["gamma"]):
            seen.setdefault(row["kind"], row)
        found_lines += [
            f"# {contender.name}: {row['kind']}\n{row['command']}" for row in seen.values()
        ]
    return found_lines
