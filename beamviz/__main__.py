"""`python -m beamviz`: the command line."""

import sys

from beamviz.cli import main

if __name__ == "__main__":
    sys.exit(main())
