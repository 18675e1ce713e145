"""Check the types of the page's scripts with TypeScript: python scripts/check_page.py

Uses `tsc`, or else `npx`, which fetches it. Where neither works nothing is checked, and the exit
code is 77. The types of the messages are those of messages.d.ts (see scripts/message_types.py).
"""

import shutil
import subprocess
import sys
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1] / "beamviz" / "explorer" / "page" / "jsconfig.json"
TYPESCRIPT = "typescript@5.9"
NOT_CHECKED = 77  # exit code of a test that could not be run, as automake has it


def compiler() -> list[str]:
    """The command of TypeScript; [] where there is none that works."""
    tsc, npx = shutil.which("tsc"), shutil.which("npx")
    commands = [[tsc]] if tsc else []
    commands += [[npx, "--yes", "--package", TYPESCRIPT, "tsc"]] if npx else []
    return next(filter(works, commands), [])


def works(command: list[str]) -> bool:
    """Whether a command tells its version: npx cannot fetch TypeScript without a network."""
    return subprocess.run([*command, "--version"], capture_output=True, check=False).returncode == 0


def main() -> int:
    """Check; 0 if there is no error, NOT_CHECKED if there is no TypeScript."""
    if not (command := compiler()):
        message = "the page's scripts were NOT CHECKED: TypeScript (tsc, or npx of Node) is missing"
        print(message, file=sys.stderr)
        return NOT_CHECKED
    return subprocess.run([*command, "-p", str(PROJECT)], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
