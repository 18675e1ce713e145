"""Random inputs for Beam, solve, loci, the TOML reader and the command line, any number of them.

    python scripts/fuzz.py [--inputs 100000] [--only NAME ...] [--seed N]

Each outcome must be an answer, or an error of the package that names the input (tests/fuzzing.py
has the checks). Prints a row for each kind, with the processor time it took, and the smallest input
found with another outcome; the exit code is 1 if there is one.
"""

import sys
import time
import traceback
from typing import Any

import _script

try:
    from fuzzing import CASES, Case  # type: ignore[import-not-found]
    from hypothesis import HealthCheck, Phase, given, seed, settings
except ModuleNotFoundError:
    sys.exit("fuzz.py: hypothesis is not installed: run scripts/test.py once, which installs it")


def smallest_failure(case: Case, inputs: int, number: int) -> str:
    """The smallest input that fails the check, with its traceback, or ""."""
    limits: dict[str, Any] = {"database": None, "deadline": None, "print_blob": False}
    limits |= {"suppress_health_check": list(HealthCheck)}
    drawn = settings(max_examples=inputs, phases=[Phase.generate, Phase.shrink], **limits)
    try:
        seed(number)(drawn(given(*case.strategies)(case.check)))()
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        return "\n".join([*getattr(error, "__notes__", []), traceback.format_exc(limit=-1)])
    return ""


def main() -> int:
    """Draw inputs, check them, and print the rows."""
    parser = _script.Parser(__doc__)
    parser.add_argument("--inputs", type=_script.count, default=100_000)
    parser.add_argument("--only", nargs="*", choices=list(CASES), default=list(CASES))
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    failures = 0
    for name in options.only:
        began, inputs = time.process_time(), max(int(CASES[name].share * options.inputs), 1)
        found = smallest_failure(CASES[name], inputs, options.seed)
        failures += bool(found)
        seconds, verdict = time.process_time() - began, "FAILED" if found else "passed"
        _script.print_row(name, f"{inputs} inputs", f"{seconds:.0f} s", verdict)
        print(found, end="", flush=True)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
