"""The comparison of integrators of motions in time: its numbers, its charts, and the table of
ratios in assets/motion.md, as `beamviz benchmark --peers` measures it. Run it on a quiet machine,
with Exudyn installed:

    python scripts/measure_motions.py [--out assets]

It writes motion.json, motion-time-error.png and motion-failures.png, and renews the table between
two marks in motion.md; it takes some minutes. --table renews the table alone, from motion.json.
"""

import json
import math
from pathlib import Path
from typing import Any

import _script

from beamviz.evidence.benchmark import environment, motion, motion_files, print_progress
from beamviz.evidence.benchmark.external import PEERS
from beamviz.evidence.benchmark.exudyn_motion import missing
from beamviz.files import markdown_table, write_files
from beamviz.version import __version__

TARGETS = (1e-3, 1e-4, 1e-5, 3e-6)  # errors of the tip [L]
START, END = "<!-- measured -->\n", "<!-- end -->\n"


def main() -> None:
    parser = _script.Parser(__doc__)
    parser.add_argument("--out", type=Path, default=_script.ROOT / "assets")
    parser.add_argument("--table", action="store_true")
    given = parser.parse_args()
    if not given.table:
        if reason := missing():
            parser.error(f"Exudyn is {reason}")
        measure(given.out)
    page = given.out / "motion.md"
    page.write_text(renewed(page.read_text(), stored_rows(given.out)))
    print(table(stored_rows(given.out)))


def measure(folder: Path) -> None:
    """Measure everything, and write the numbers and the charts."""
    exudyn = tuple(peer for peer in PEERS if peer.name == motion.EXUDYN)
    about = environment(exudyn, quick=False, release=__version__)
    work = motion.FULL
    rows = motion.measure(work, True, print_progress)
    cells = motion.trials(motion.NAMES, work.mus, work.steps, print_progress)
    files = motion_files(rows, cells, about)
    write_files(folder, {name: files[name] for name in files if not name.endswith(".svg")})


def stored_rows(folder: Path) -> list[motion.MotionRow]:
    """The rows of the numbers in a folder."""
    stored = json.loads((folder / "motion.json").read_text())["time against error"]
    none: dict[str, Any] = {"seconds": math.nan, "error": math.nan}
    return [
        motion.MotionRow(**none | {k: v for k, v in row.items() if v is not None}) for row in stored
    ]


def table(rows: list[motion.MotionRow]) -> str:
    """Exudyn's time to some errors, as far as it reaches them, and over that of a single run of
    radau and of `auto`."""
    lines = []
    for scene in motion.SCENES:
        for target in TARGETS:
            peer, radau, auto = (
                motion.time_to_error(rows, scene, name, target)
                for name in (motion.EXUDYN, "radau", "auto")
            )
            if peer:
                ratios = (f"{peer / ours:.1f}" if ours else "" for ours in (radau, auto))
                lines.append([scene, f"{target:g}", f"{peer:.3f} s", *ratios])
    head = (
        "motion",
        "error of the tip [L]",
        "Exudyn",
        "over a run of `radau`",
        "over `auto`, with error bar",
    )
    return markdown_table(head, lines)


def renewed(page: str, rows: list[motion.MotionRow]) -> str:
    """A page with the table between its marks made of these rows."""
    before, _, rest = page.partition(START)
    _, _, after = rest.partition(END)
    return f"{before}{START}{table(rows)}\n{END}{after}"


if __name__ == "__main__":
    main()
