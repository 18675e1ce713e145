"""The command `beamviz` and `python -m beamviz`: the command line."""

import sys

from beamviz.signals import Terminated, terminate_on_signal


def main() -> int:
    """Run this process's command line; the exit code."""
    try:
        with terminate_on_signal():
            from beamviz.cli import main

            return main()
    except Terminated as end:
        return end.code


if __name__ == "__main__":
    sys.exit(main())
