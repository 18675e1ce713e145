"""The command `beamviz` and `python -m beamviz`: the command line."""

import sys

from beamviz.signals import Ended, ending


def main() -> int:
    """Run this process's command line; the exit code."""
    try:
        with ending():
            from beamviz.cli.commands import main

            return main()
    except Ended as end:
        return end.code


if __name__ == "__main__":
    sys.exit(main())
