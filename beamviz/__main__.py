"""`python -m beamviz`: the command line."""

import sys

from beamviz.cli import main

sys.exit(main())
