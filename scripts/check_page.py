"""Check the types of the page's scripts with TypeScript: python scripts/check_page.py

Uses `tsc`, or else `npx`, which fetches it; where neither is installed nothing is checked. The
types of the messages are those of messages.d.ts (see scripts/message_types.py).
"""

import shutil
import subprocess
import sys
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1] / "beamviz" / "explorer" / "page" / "jsconfig.json"
TYPESCRIPT = "typescript@5.9"


def compiler() -> list[str]:
    """The command of TypeScript; [] where there is none."""
    if tsc := shutil.which("tsc"):
        return [tsc]
    npx = shutil.which("npx")
    return [npx, "--yes", "--package", TYPESCRIPT, "tsc"] if npx else []


def main() -> int:
    """Check; 0 if there is no error, or no TypeScript."""
    if not (command := compiler()):
        print("neither tsc nor npx is installed: the page's scripts are not checked")
        return 0
    return subprocess.run([*command, "-p", str(PROJECT)], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
