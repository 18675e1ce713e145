"""Whether the error that `motion` reports is the error it makes, on random motions.

The truth is the same motion with a quarter of the tolerance, and where it applies (a mass at the
tip, released at a constant speed) the independent integration of tests/oracle/motion.py. Run it on
a quiet machine; what has been computed is kept in a file:

    python scripts/measure_motion_error_bars.py [--motions 210] [--kept FILE] [--out assets]
"""

import json
import sys
import tempfile
import time
from datetime import date
from pathlib import Path
from typing import Any

import _script
import numpy as np
from oracle.motion import tip_by_polynomials  # type: ignore[import-not-found]

from beamviz import Beam, BeamvizError, Hub, Motion, Ramp, motion
from beamviz.files import markdown_table
from beamviz.version import __version__

TOLERANCE, FINER = 1e-4, 0.25  # of the reference, over the tolerance
INDEPENDENT = 12  # of the seeds, by the oracle
ORACLE_ERROR = 2e-5  # of its polynomials of order 9, measured against order 11
POINTS = 401
LIMIT = 20.0  # [s] of a motion, and of its reference


class TookTooLong(Exception):
    """More than the limit."""


class Watch:
    """A `progress` that ends a motion at the limit."""

    def __init__(self) -> None:
        self.start = time.process_time()

    def __call__(self, t: float) -> None:
        if time.process_time() - self.start > LIMIT:
            raise TookTooLong(f"took more than {LIMIT:g} s")


def main() -> None:
    """Measure, write error_bars_motion.json and .md, print the page."""
    parser = _script.Parser(__doc__)
    parser.add_argument("--motions", type=_script.count, default=210)
    parser.add_argument("--kept", type=Path)
    parser.add_argument("--out", type=Path, default=_script.ROOT / "assets")
    given = parser.parse_args()
    file = given.kept or Path(tempfile.gettempdir()) / "beamviz-error_bars_motion.jsonl"
    rows = kept_rows(given.motions, file)
    given.out.mkdir(parents=True, exist_ok=True)
    text = page(rows)
    (given.out / "error_bars_motion.json").write_text(json.dumps(rows, indent=1) + "\n")
    (given.out / "error_bars_motion.md").write_text(text)
    print(text)


def kept_rows(count: int, file: Path) -> list[dict[str, Any]]:
    """The rows of all seeds, those in the file not computed again."""
    lines = file.read_text().splitlines() if file.exists() else []
    known = {row["seed"]: row for row in map(json.loads, lines)}
    seeds = [*range(count), *range(-INDEPENDENT, 0)]
    with file.open("a") as kept:
        for seed in seeds:
            if seed not in known:
                known[seed] = row_of(seed)
                print(json.dumps(known[seed]), file=kept, flush=True)
                print(f"motion {seed} of {count}", file=sys.stderr)
    return [known[seed] for seed in seeds]


def row_of(seed: int) -> dict[str, Any]:
    """A motion, its error bar, its error and what it took."""
    kind, beam, until, options = independent_motion(seed) if seed < 0 else random_motion(seed)
    options |= {"tolerance": TOLERANCE, "points": POINTS}
    described = ", ".join(f"{name}={value!r}" for name, value in options.items())
    row: dict[str, Any] = {
        "seed": seed,
        "kind": kind,
        "call": f"motion({beam!r}, {until!r}, {described})",
    }
    start = time.process_time()
    try:
        moved = motion(beam, until, progress=Watch(), **options)
    except (BeamvizError, TookTooLong) as failure:
        return row | {"reason": f"{type(failure).__name__}: {failure}"}
    row |= {"seconds": time.process_time() - start, "bar": moved.error, "runs": moved.stats.runs}
    try:
        truth, unsure = truth_of(seed, moved, beam, until, options)
    except (BeamvizError, TookTooLong) as failure:
        return row | {"reason": f"no reference: {failure}"}
    error = float(np.linalg.norm(moved.tip - truth, axis=1).max())
    return row | {"error": error, "unsure": unsure}


def truth_of(
    seed: int, moved: Motion, beam: Beam, until: float, options: dict[str, Any]
) -> tuple[np.ndarray, float]:
    """The tip (POINTS, 2) by a reference, and the error of the reference."""
    if seed < 0:
        release = options["release"]
        tip = tip_by_polynomials(beam.alpha, beam.gamma, beam.delta, beam.mu, release, moved.t)
        return tip, ORACLE_ERROR
    finer = motion(beam, until, progress=Watch(), **{**options, "tolerance": FINER * TOLERANCE})
    return finer.tip, finer.error


def independent_motion(seed: int) -> tuple[str, Beam, float, dict[str, Any]]:
    """A motion that the oracle integrates."""
    draw = np.random.default_rng(1000 - seed).uniform
    beam = Beam(alpha=draw(0, 1), gamma=draw(0, 4), mu=20.0)
    return "released, by the oracle", beam, 0.5, {"release": draw(0.2, 2)}


def random_motion(seed: int) -> tuple[str, Beam, float, dict[str, Any]]:
    """Kind, beam, duration and options of a motion."""
    random = np.random.default_rng(seed)
    draw = random.uniform
    beam = Beam(
        alpha=random.choice([0.0, draw(0, 2)]),
        beta=random.choice([1.0, draw(0.2, 1)]),
        gamma=draw(0, 6),
        delta=random.choice([0.0, draw(0, 1)]),
        mu=float(np.exp(draw(np.log(20), np.log(450)))),
    )
    until = draw(1, 3)
    options: dict[str, Any] = {"damping": float(random.choice([0.0, draw(0, 0.1)]))}
    kinds = (
        *("started in modes", "long and undamped", "released"),
        *("spun up", "stopped", "a table of speeds", "a hub"),
    )
    kind = kinds[seed % len(kinds)]
    if kind == "started in modes":
        options |= {"start": {"B1": draw(0.01, 0.15), "B2": draw(0.0, 0.01)}}
    elif kind == "long and undamped":
        until = draw(10, 60)
        options |= {"start": {"B1": draw(0.01, 0.1), "B2": draw(0.0, 0.02)}, "damping": 0.0}
    elif kind == "released":
        options |= {"release": draw(0.1, 2)}
    elif kind == "spun up":
        options |= {"speed": Ramp(draw(1, 8), draw(0.3, 0.8) * until)}
    elif kind == "stopped":
        options |= {"speed": Ramp(0, draw(0.2, 0.8) * until, "linear", start=beam.gamma)}
    elif kind == "a table of speeds":
        t = np.linspace(0, until, 4).tolist()
        options |= {"speed": (t, [draw(0, 6) for _ in t])}
    else:
        options |= {"speed": Hub(draw(0.2, 2), draw(-2, 2))}
    return kind, beam, until, options


def page(rows: list[dict[str, Any]]) -> str:
    """The result for people, in Markdown."""
    table = []
    for kind in dict.fromkeys(row["kind"] for row in rows):
        own = [row for row in rows if row["kind"] == kind]
        known = [row for row in own if "error" in row]
        ratios = [row["bar"] / max(row["error"], 1e-12) for row in known]
        seconds = [row["seconds"] for row in own if "seconds" in row]
        times = [f"{np.median(seconds):.2f} s", f"{max(seconds):.1f} s"]
        counts = [str(len(own)), str(len(known)), str(sum(map(within, known)))]
        table.append([kind, *counts, f"{np.median(ratios):.1f}", *times])
    known = [row for row in rows if "error" in row]
    kept = sum(map(within, known))
    head = ("", "motions", "compared", "within the bar", "bar / error", "time", "at most")
    parts = [
        "# Honest error bars of motions in time",
        f"Random motions to {TOLERANCE:g} L, the tip held against the same motion to"
        f" {FINER * TOLERANCE:g} L, and {INDEPENDENT} against an independent integration"
        " (tests/oracle). `python scripts/measure_motion_error_bars.py` computes this page anew.",
        f"beamviz {__version__}, {date.today().isoformat()}.",
        f"Within its error bar: {kept} of {len(known)}, {100 * kept / len(known):.1f} %.",
        markdown_table(head, table),
        "bar / error and time are medians; time is of one processor.",
    ]
    lists = {
        "Outside the bar": [row for row in known if not within(row)],
        "Not compared": [row for row in rows if "error" not in row],
    }
    for title, some in lists.items():
        if some:
            lines = [f"# {remark(row)}\n{row['call']}" for row in some]
            parts += [f"## {title}", "\n".join(["```python", *lines, "```"])]
    return "\n\n".join(parts) + "\n"


def within(row: dict[str, Any]) -> bool:
    """Whether the error is within the bar, as far as the reference tells."""
    return row["error"] <= row["bar"] + row["unsure"]


def remark(row: dict[str, Any]) -> str:
    if "error" in row:
        return f"error {row['error']:.1e}, bar {row['bar']:.1e}"
    return row["reason"]


if __name__ == "__main__":
    main()
