"""Random inputs for Beam, solve, loci, the TOML reader and the command line, any number of them.

    python scripts/fuzz.py [--inputs 100000] [--only NAME ...] [--seed N]

Each outcome must be an answer, or an error of the package that names the input (tests/fuzzing.py
has the checks). Prints a row for each kind, with the processor
time it took, and the smallest input found with another outcome; the exit code is 1 if there is
one.
"""

import sys
import time
import traceback
from pathlib import Path

try:
    from hypothesis import HealthCheck, Phase, given, seed, settings
except ModuleNotFoundError:
    sys.exit("fuzz.py: hypothesis is not installed: run scripts/test.py once, which installs it")

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from _arguments import Parser, count  # noqa: E402
from fuzzing import CASES  # type: ignore[import-not-found]  # noqa: E402

# Share of each kind in all inputs: more of those that are quick to check.
SHARES = {
    "Beam": 0.4,
    "TOML": 0.3,
    "command line": 0.15,
    "solve": 0.1,
    "solve, odd keywords": 0.03,
    "loci, odd ranges": 0.01,
    "loci": 0.008,
    "loci, wild": 0.002,
}


def smallest_failure(name: str, inputs: int, number: int) -> str:
    """The smallest input that fails the check, with its traceback, or ""."""
    check, strategies = CASES[name]
    drawn = settings(
        max_examples=inputs,
        database=None,
        deadline=None,
        suppress_health_check=list(HealthCheck),
        phases=[Phase.generate, Phase.shrink],
        print_blob=False,
    )
    try:
        seed(number)(drawn(given(*strategies)(check)))()
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        return "\n".join([*getattr(error, "__notes__", []), traceback.format_exc(limit=-1)])
    return ""


def main() -> int:
    """Draw inputs, check them, and print the rows."""
    parser = Parser(__doc__)
    parser.add_argument("--inputs", type=count, default=100_000)
    parser.add_argument("--only", nargs="*", choices=list(CASES), default=list(CASES))
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    failures = 0
    for name in options.only:
        began, inputs = time.process_time(), max(int(SHARES[name] * options.inputs), 1)
        found = smallest_failure(name, inputs, options.seed)
        failures += bool(found)
        verdict = "FAILED" if found else "passed"
        print(f"{name:<20} {inputs:>7} inputs {time.process_time() - began:7.0f} s  {verdict}")
        print(found, end="", flush=True)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
