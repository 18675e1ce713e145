"""Today's answers as a file, and the answers of a later code compared with it:

    python scripts/golden.py write tests/golden.json.gz
    python scripts/golden.py compare tests/golden.json.gz [--only KIND] [--quick]

Values are those of the finest tolerance that converges, confirmed by another mesh: the same section
at more stations. Beside them stands their spread: the greatest change by another tolerance, another
mesh or, where the resolution is given, numbers changed in the last digit. `compare` allows

    frequencies       1e-9, relative, and the estimated errors of both
    at the default tolerance: the estimated error alone, which has to be within the tolerance
    motions           the sum of their error bars
    all other values  ten times their spread, and a share of their size (FLOORS)

It prints what is beyond, and ends with 1 if there is anything. What the code that wrote the file
did not meet itself, as error bars that were false, counts with --strict only. A beam for which no
solution was found may have one.
"""

import gzip
import json
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import _script
from golden_answers import Record, call_of, case_of, packed, read
from golden_cases import KINDS, charts, motions, solves
from golden_differences import Row, rows_of, rows_or_crash
from golden_records import chart_case, motion_case, solve_case

REPORTED, CALLS = 60, 5  # rows of the table and calls, at most
LONG = 3.0  # [s] of a case that is told of


def write(file: Path, wanted: "Selection") -> None:
    """Compute the cases, and write them."""
    began, cases = time.perf_counter(), []
    for all_cases, complete in ((solves, solve_case), (charts, chart_case), (motions, motion_case)):
        for case in all_cases():
            if wanted.takes(case):
                started = time.perf_counter()
                cases.append(complete_case(case, complete))
                report(cases[-1], time.perf_counter() - started)
    text = json.dumps({"made": "scripts/golden.py write", "cases": cases}, separators=(",", ":"))
    with file.open("wb") as target, gzip.GzipFile("", "wb", fileobj=target, mtime=0) as stream:
        stream.write(text.encode())
    print(f"{len(cases)} cases, {file.stat().st_size} bytes, {time.perf_counter() - began:.0f} s")


def complete_case(case: Record, complete: Callable[[Record], Record]) -> Record:
    """A case with its answers in the types of JSON, and the quantities that this code does not meet
    itself."""
    done: Record = json.loads(json.dumps(packed(complete(json.loads(json.dumps(packed(case)))))))
    missed = [row for row in rows_of(case_of(done)) if not row.ratio <= 1]
    return done | ({"known": {row.quantity: text(row.now) for row in missed}} if missed else {})


def report(case: Record, seconds: float) -> None:
    """What to know about a case, on stderr."""
    if seconds > LONG or "known" in case or "note" in case:
        told = {name: case[name] for name in ("known", "note") if name in case}
        print(f"{case['name']}: {seconds:.1f} s {told or ''}", file=sys.stderr, flush=True)


class Selection(NamedTuple):
    """The cases that are wanted."""

    kind: str | None = None
    name: str = ""
    without: str | None = None
    quick: bool = False

    def takes(self, case: Mapping[str, Any]) -> bool:
        return (
            self.kind in (None, case["kind"])
            and self.name in case["name"]
            and (self.without is None or self.without not in case["name"])
            and (case["quick"] or not self.quick)
        )


def compare(file: Path, wanted: Selection, strict: bool) -> int:
    """Solve again, print what differs, and return 1 if anything does."""
    began, worst = time.perf_counter(), dict[str, float]()
    beyond, known = list[tuple[Record, Row]](), 0
    cases = [record for record in read(file)["cases"] if wanted.takes(record)]
    for record in cases:
        for row in rows_or_crash(case_of(record)):
            if not row.ratio <= 1 and row.quantity in record.get("known", ()) and not strict:
                known += 1
                continue
            kind = f"{record['kind']}, {row.quantity.split(' ')[0]}"
            worst[kind] = max(worst.get(kind, 0.0), row.ratio)
            if not row.ratio <= 1:
                beyond.append((record, row))
    print_table(beyond, worst)
    differing = len({record["name"] for record, _ in beyond})
    print(
        f"{len(cases)} cases, {time.perf_counter() - began:.0f} s: {len(beyond)} differences in"
        f" {differing} cases; {known} that the code of the file had, too"
    )
    return int(bool(beyond))


def print_table(beyond: list[tuple[Record, Row]], worst: Mapping[str, float]) -> None:
    """The differences beyond what is allowed, the calls that have them, and the greatest of all."""
    if beyond:
        print(f"{'case':24} {'quantity':26} {'golden':>26} {'now':>26} {'over allowed':>14}")
    for record, row in beyond[:REPORTED]:
        texts = (f"{text(value):>26}" for value in (row.golden, row.now))
        print(f"{record['name']:24} {row.quantity:26}", *texts, f"{row.ratio:14.3g}")
    if len(beyond) > REPORTED:
        print(f"... and {len(beyond) - REPORTED} more")
    for record in list({record["name"]: record for record, _ in beyond}.values())[:CALLS]:
        print(f"{record['name']}: {call_of(record)}")
    greatest = sorted(worst.items(), key=lambda pair: -pair[1])[:8]
    print("greatest over allowed:", ", ".join(f"{kind} {ratio:.2g}" for kind, ratio in greatest))


def text(value: Any) -> str:
    return f"{value:.12g}" if isinstance(value, float | complex) else str(value)


def main() -> int:
    parser = _script.Parser(__doc__)
    parser.add_argument("action", choices=("write", "compare"))
    parser.add_argument("file", type=Path, metavar="FILE.json.gz")
    parser.add_argument("--only", type=_script.one_of(KINDS), metavar="KIND", help=", ".join(KINDS))
    parser.add_argument("--name", default="", metavar="TEXT", help="cases whose name contains it")
    parser.add_argument("--without", metavar="TEXT", help="no cases whose name contains it")
    parser.add_argument("--quick", action="store_true", help="a part, in 20 s")
    parser.add_argument("--strict", action="store_true", help="also what differed from the start")
    given = parser.parse_args()
    wanted = Selection(given.only, given.name, given.without, given.quick)
    if given.action == "write":
        write(given.file, wanted)
        return 0
    return compare(given.file, wanted, given.strict)


if __name__ == "__main__":
    sys.exit(main())
