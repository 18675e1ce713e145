"""The verdicts on many scenes counted, and as a page."""

import platform
from collections import Counter
from collections.abc import Iterable
from datetime import date
from typing import Any

import numpy as np
import scipy

from beamviz import __version__

SLOW = 0.05  # [s]
LISTED = 40  # scenes named in the page
COMPARED = ("within", "outside")
GOOD = ("within", "no-equilibrium", "another-state", "unknown")
SENTENCES = {
    "within": "every error within the reported one",
    "outside": "an error larger than the reported one",
    "no-equilibrium": "no equilibrium, and the limit named is true",
    "another-state": "none that starts at rest, and the limit is true; another beyond the axis",
    "wrong-limit": "no equilibrium claimed, or a wrong limit",
    "missed-limit": "an answer where there is no equilibrium",
    "wrong-branch": "another equilibrium than the one that starts at rest",
    "not-converged": "did not converge",
    "crash": "crashed",
    "unknown": "the reference itself has no answer (too many waves in a buckled beam)",
}


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Counts, shares and every scene that is not as it should be."""
    compared = [row for row in rows if row["kind"] in COMPARED]
    groups = {
        "all": compared,
        "Coriolis": [row for row in compared if row["coriolis"]],
        "no Coriolis": [row for row in compared if not row["coriolis"]],
        "inward (delta < 0)": [row for row in compared if row["inward"]],
    }
    wrong = [row for row in rows if row["kind"] not in GOOD]
    slow = [row for row in rows if row["seconds"] > SLOW]
    return {
        "version": __version__,
        "machine": f"{platform.machine()}, Python {platform.python_version()}, numpy"
        f" {np.__version__}, scipy {scipy.__version__}",
        "day": date.today().isoformat(),
        "beams": len(rows),
        "kinds": dict(Counter(row["kind"] for row in rows).most_common()),
        "groups": {name: shares(group) for name, group in groups.items()},
        "seconds": {
            "median": float(np.median([row["seconds"] for row in rows])),
            "largest": max(row["seconds"] for row in rows),
            "above 50 ms": len(slow),
        },
        "wrong": [listed(row) for row in wrong],
        "slow": [listed(row) for row in slow],
    }


def shares(rows: list[dict[str, Any]]) -> dict[str, float]:
    """How many beams and frequencies are within their bars, and how wide the bars are."""
    off, reported, doubt = (
        together(row[key] for row in rows) for key in ("off", "reported", "doubt")
    )
    if not len(off):
        return {"beams": 0}
    return {
        "beams": len(rows),
        "beams within": sum(row["kind"] == "within" for row in rows) / len(rows),
        "frequencies": len(off),
        "frequencies within": float(np.mean(off <= reported + doubt)),
        "median reported / true": float(np.median(reported / np.maximum(off, 1e-300))),
        "median reported / largest possible true": float(
            np.median(reported / (off + doubt + 1e-300))
        ),
        "90 % reported / true": float(np.quantile(reported / np.maximum(off, 1e-300), 0.9)),
    }


def together(lists: Iterable[list[float]]) -> np.ndarray:
    """Lists end to end."""
    return np.array([value for values in lists for value in values])


def listed(row: dict[str, Any]) -> dict[str, Any]:
    """What one needs to see a scene again."""
    said = {name: row[name] for name in ("seed", "kind", "command", "says") if name in row}
    said["ms"] = round(1000 * row["seconds"], 1)
    if row["kind"] == "outside":
        ratio = np.array(row["off"]) / (np.array(row["reported"]) + np.array(row["doubt"]))
        said["worst mode"] = int(ratio.argmax()) + 1
        said["true / reported"] = round(float(ratio.max()), 2)
    return said


def page(counted: dict[str, Any]) -> str:
    """The summary for people, in Markdown."""
    kinds, seconds = counted["kinds"], counted["seconds"]
    lines = [
        "# Honest error bars",
        "",
        f"{counted['beams']} random beams over everything that is accepted, solved by `auto`"
        " and held against an independent solution of the differential equations (tests/oracle)."
        " `python scripts/measure_error_bars.py` computes this page anew.",
        "",
        f"beamviz {counted['version']}, {counted['machine']}, {counted['day']}.",
        "",
        "| verdict | beams |",
        "|---|---|",
        *(f"| {SENTENCES[kind]} | {number} |" for kind, number in kinds.items()),
        "",
        "| | beams | all errors within bars | frequencies | within | bar / error, median |",
        "|---|---|---|---|---|---|",
        *(group_row(name, share) for name, share in counted["groups"].items() if share["beams"]),
        "",
        f"A solve takes {1000 * seconds['median']:.1f} ms of one processor in the median,"
        f" {1000 * seconds['largest']:.0f} ms at most; {seconds['above 50 ms']} of"
        f" {counted['beams']} take more than 50 ms.",
    ]
    lines += listing("Not as it should be", counted["wrong"])
    lines += listing("Slower than 50 ms", counted["slow"])
    return "\n".join(lines) + "\n"


def group_row(name: str, share: dict[str, float]) -> str:
    """One row of the table of shares."""
    return (
        f"| {name} | {share['beams']} | {100 * share['beams within']:.2f} %"
        f" | {share['frequencies']} | {100 * share['frequencies within']:.3f} %"
        f" | {share['median reported / true']:.0f} |"
    )


def listing(title: str, rows: list[dict[str, Any]]) -> list[str]:
    """Scenes with the commands that show them."""
    if not rows:
        return []
    shown = [f"# {said(row)}\n{row['command']}" for row in rows[:LISTED]]
    more = [f"... and {len(rows) - LISTED} more in error_bars.json"] if len(rows) > LISTED else []
    return ["", f"## {title}", "", "```", *shown, *more, "```"]


def said(row: dict[str, Any]) -> str:
    """What is noteworthy about a scene."""
    if row["kind"] == "outside":
        return (
            f"true error {row['true / reported']} times the reported one, mode {row['worst mode']}"
        )
    return f"{row['ms']} ms, {SENTENCES[row['kind']]}"
