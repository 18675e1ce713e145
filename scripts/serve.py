"""Start the explorer: make the environment if needed, then run `beamviz serve`.

    python3 scripts/serve.py [options of `beamviz serve`]

The environment, .venv, has every extra that a user meets: films in MP4, sweeps, maps, xarray.
"""

import os
import subprocess
import sys

from _environment import ensure


def main() -> None:
    """Hand over to the explorer; its options are passed on."""
    command = [str(ensure("all")), "-m", "beamviz", "serve", *sys.argv[1:]]
    if os.name == "nt":  # there exec leaves the terminal before the explorer ends
        sys.exit(subprocess.run(command, check=False).returncode)
    os.execv(command[0], command)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit(130)
