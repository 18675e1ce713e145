"""Whether the error that `solve` reports is the error it makes, on thousands of random beams.

The truth comes from tests/oracle, the differential equations by collocation. The beams are
drawn over everything that is accepted (tests/oracle/error_bars.py). Run it on a quiet machine; the
oracle takes about half a second a beam, and its answers are kept in a file:

    python scripts/measure_error_bars.py [--beams 5000] [--truths FILE] [--out assets]

With --bent the beams are bent ones (tests/oracle/error_bars.py), the files are
error_bars_bent.json and .md, and what is kept are the verdicts: remove them to measure anew. With
--blades they are blades with dips and jumps, straight or bent, and the names end in _blades. With
--space they are beams and blades that bend in both planes at once, and the names end in _space.
"""

import json
import platform
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from datetime import date
from functools import partial
from pathlib import Path
from typing import Any

import _script
import numpy as np
import scipy
from oracle import error_bars as oracle  # type: ignore[import-not-found]

from beamviz.files import markdown_table
from beamviz.version import __version__

SLOW, SLOW_BENT = 0.05, 1.0  # [s]
LISTED = 40  # scenes in each list of the page
GOOD = ("within", "no-equilibrium", "another-state", "unknown")
SENTENCES = {
    "within": "every error within the reported one",
    "outside": "an error larger than the reported one",
    "no-equilibrium": "no equilibrium, and the limit named is true",
    "another-state": "none that starts at rest, and the limit is true; another beyond the axis",
    "wrong-limit": "no equilibrium claimed, or a wrong limit",
    "missed-limit": "an answer where there is no equilibrium",
    "wrong-branch": "another equilibrium than the one that starts at rest",
    "wrong-family": "bending taken for stretching, or the reverse",
    "not-converged": "did not converge",
    "crash": "crashed",
    "unknown": "the reference itself has no answer",
}


def main() -> None:
    """Measure, write error_bars.json and error_bars.md, print the page."""
    parser = _script.Parser(__doc__)
    parser.add_argument("--beams", type=_script.count, default=5000)
    parser.add_argument("--bent", action="store_true")
    parser.add_argument("--blades", action="store_true")
    parser.add_argument("--space", action="store_true")
    parser.add_argument("--truths", type=Path)
    parser.add_argument("--out", type=Path, default=_script.ROOT / "assets")
    given = parser.parse_args()
    if given.space and (given.bent or given.blades):
        parser.error("--space: the beams are straight, blades among them")
    name = "error_bars" + "_bent" * given.bent + "_blades" * given.blades + "_space" * given.space
    file = given.truths or Path(tempfile.gettempdir()) / f"beamviz-{name}.jsonl"
    if given.bent:
        scene = oracle.random_bent_dip_scene if given.blades else oracle.random_bent_scene
        rows = kept_rows(given.beams, file, partial(bent_row, scene))
    else:
        scene = oracle.random_dip_scene if given.blades else oracle.random_scene
        scene = oracle.random_space_scene if given.space else scene
        answers = kept_rows(given.beams, file, partial(straight_answer, scene))
        rows = [straight_row(scene, answer) for answer in answers]
    counted = summary(rows, SLOW_BENT if given.bent else SLOW)
    text = page(counted, given.bent, given.blades, given.space)
    given.out.mkdir(parents=True, exist_ok=True)
    (given.out / f"{name}.json").write_text(json.dumps(counted, indent=1) + "\n")
    (given.out / f"{name}.md").write_text(text)
    print(text)


def described(scene: Any) -> dict[str, Any]:
    """The command of a scene, and the groups that it belongs to."""
    groups = {"inward": scene.beam.delta < 0, "spin-up": scene.beam.spin_up != 0}
    return groups | {"coriolis": scene.options["coriolis"], "command": scene.command}


def bent_row(drawn: Callable[[int], Any], seed: int) -> dict[str, Any]:
    """A verdict on a bent beam, drawn from a seed."""
    scene = drawn(seed)
    return described(scene) | oracle.bent_verdict(scene)


def straight_answer(drawn: Callable[[int], Any], seed: int) -> dict[str, Any]:
    """The truth about a straight beam, drawn from a seed."""
    return oracle.oracle_answer(drawn(seed))


def straight_row(drawn: Callable[[int], Any], answer: dict[str, Any]) -> dict[str, Any]:
    """A verdict on a straight beam; a slow one is timed again, and its least time counts."""
    scene = drawn(answer["seed"])
    row = {"seed": answer["seed"]} | described(scene) | oracle.verdict(scene, answer)
    for _ in range(3):
        if row["seconds"] > SLOW:
            row["seconds"] = min(row["seconds"], oracle.verdict(scene, answer)["seconds"])
    return row


def kept_rows(count: int, file: Path, row: Callable[[int], dict[str, Any]]) -> list[dict[str, Any]]:
    """The rows of seeds 0 .. count - 1, those in the file not computed again."""
    known = {}
    if file.exists():
        lines = [line for line in file.read_text().splitlines() if line.endswith("}")]
        known = {row["seed"]: row for row in map(json.loads, lines)}
    with file.open("a") as kept:
        for seed in (seed for seed in range(count) if seed not in known):
            known[seed] = {"seed": seed} | row(seed)
            print(json.dumps(known[seed]), file=kept, flush=True)
            if seed % 100 == 0:
                print(f"oracle: {seed} of {count}", file=sys.stderr)
    return [known[seed] for seed in range(count)]


def summary(rows: list[dict[str, Any]], limit: float = SLOW) -> dict[str, Any]:
    """Counts, shares and every scene with a wrong verdict."""
    compared = [row for row in rows if row["kind"] in ("within", "outside")]
    groups = {
        "all": compared,
        "Coriolis": [row for row in compared if row["coriolis"]],
        "no Coriolis": [row for row in compared if not row["coriolis"]],
        "inward (delta < 0)": [row for row in compared if row["inward"]],
        "spin-up": [row for row in compared if row["spin-up"]],
    }
    seconds = [row["seconds"] for row in rows]
    times = {"median": float(np.median(seconds)), "largest": max(seconds)}
    slow = [row for row in rows if row["seconds"] > limit]
    return {
        "version": __version__,
        "machine": f"{platform.machine()}, Python {platform.python_version()}, numpy"
        f" {np.__version__}, scipy {scipy.__version__}",
        "day": date.today().isoformat(),
        "beams": len(rows),
        "kinds": dict(Counter(row["kind"] for row in rows).most_common()),
        "groups": {name: shares(group) for name, group in groups.items()},
        "seconds": times | {"slow": limit, "slower": len(slow)},
        "wrong": [listed(row) for row in rows if row["kind"] not in GOOD],
        "slow": [listed(row) for row in slow],
    }


def shares(rows: list[dict[str, Any]]) -> dict[str, float]:
    """How many beams and frequencies are within their bars, and how wide the bars are."""
    if not rows:
        return {"beams": 0}
    keys = ("error", "reported", "oracle_error")
    error, reported, unsure = (np.concatenate([row[key] for row in rows]) for key in keys)
    ratio = reported / np.maximum(error, 1e-300)
    return {
        "beams": len(rows),
        "beams within": sum(row["kind"] == "within" for row in rows) / len(rows),
        "frequencies": len(error),
        "frequencies within": float(np.mean(error <= reported + unsure)),
        "median reported / true": float(np.median(ratio)),
        "median reported / largest possible true": float(
            np.median(reported / (error + unsure + 1e-300))
        ),
        "90 % reported / true": float(np.quantile(ratio, 0.9)),
    }


def listed(row: dict[str, Any]) -> dict[str, Any]:
    """A scene by its seed and command, with its verdict."""
    keys = ("seed", "kind", "command", "says")
    entry: dict[str, Any] = {key: row[key] for key in keys if key in row}
    entry["ms"] = round(1000 * row["seconds"], 1)
    if row["kind"] == "outside":
        ratio = np.array(row["error"]) / (np.array(row["reported"]) + np.array(row["oracle_error"]))
        entry["worst mode"] = int(ratio.argmax()) + 1
        entry["true / reported"] = round(float(ratio.max()), 2)
    return entry


def page(
    counted: dict[str, Any], bent: bool = False, blades: bool = False, space: bool = False
) -> str:
    """The summary for people, in Markdown."""
    beams, seconds, slow = counted["beams"], counted["seconds"], 1000 * counted["seconds"]["slow"]
    title, option, drawn = "# Honest error bars", "", "beams over everything that is accepted"
    if bent:
        title, option = f"{title} of bent beams", " --bent"
        drawn = "bent beams, inward ones past buckling and ones that spin up"
    if blades:
        title, option = f"{title}: blades", f"{option} --blades"
        drawn = f"{'bent' if bent else 'straight'} blades with dips and jumps"
    if space:
        title, option = f"{title} in both planes", f"{option} --space"
        drawn = "straight beams and blades with a pitch and a twist that bend in both planes"
    counts = ("", "beams", "all errors within bars", "frequencies", "within", "bar / error, median")
    groups = []
    for name, share in counted["groups"].items():
        if share["beams"]:
            row = [name, str(share["beams"]), f"{100 * share['beams within']:.2f} %"]
            row += [str(share["frequencies"]), f"{100 * share['frequencies within']:.3f} %"]
            groups.append([*row, f"{share['median reported / true']:.0f}"])
    kinds = [[SENTENCES[kind], str(number)] for kind, number in counted["kinds"].items()]
    parts = [
        title,
        f"{beams} random {drawn}, solved by `auto`"
        " and held against an independent solution of the differential equations (tests/oracle)."
        f" `python scripts/measure_error_bars.py{option}` computes this page anew.",
        f"beamviz {counted['version']}, {counted['machine']}, {counted['day']}.",
        markdown_table(("verdict", "beams"), kinds),
        markdown_table(counts, groups),
        f"A solve takes {1000 * seconds['median']:.1f} ms of one processor in the median,"
        f" {1000 * seconds['largest']:.0f} ms at most; {seconds['slower']} of"
        f" {beams} take more than {slow:.0f} ms.",
    ]
    lists = {"Wrong": counted["wrong"], f"Slower than {slow:.0f} ms": counted["slow"]}
    for about, rows in lists.items():
        if rows:
            shown = [f"# {remark(row)}\n{row['command']}" for row in rows[:LISTED]]
            if len(rows) > LISTED:
                shown.append(f"... and {len(rows) - LISTED} more in error_bars.json")
            parts += [f"## {about}", "\n".join(["```", *shown, "```"])]
    return "\n\n".join(parts) + "\n"


def remark(row: dict[str, Any]) -> str:
    """The verdict on a listed scene in words."""
    if row["kind"] == "outside":
        times = f"true error {row['true / reported']} times the reported one"
        return f"{times}, mode {row['worst mode']}"
    return f"{row['ms']} ms, {SENTENCES[row['kind']]}"


if __name__ == "__main__":
    main()
