"""The oracle's answers about some hundred fixed random beams: python scripts/oracle_values.py

Solver and oracle are held against each other on them by tests/solver/test_fixed_beams.py. The beams
are drawn by tests/oracle/error_bars.py; the file is tests/oracle/fixed.json.gz. Run it after a
change of the oracle, or of what is drawn; it takes some minutes.
"""

import sys

import _script
from oracle import fixed  # type: ignore[import-not-found]


def main() -> None:
    """Draw the beams, ask the oracle, write the file."""
    _script.Parser(__doc__).parse_args()
    cases = []
    for kind, (_, seeds) in fixed.KINDS.items():
        cases += [fixed.made(kind, seed) for seed in seeds]
        print(f"{kind}: {len(cases)} beams so far", file=sys.stderr)
    fixed.write(cases)


if __name__ == "__main__":
    main()
