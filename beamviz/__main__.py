"""`python -m beamviz` and the command `beamviz`: the command line as a process."""

import os
import signal
import sys


def main() -> int:
    """Run the command line of this process and return its exit code. While it is being loaded,
    Ctrl-C and SIGTERM end the process at once: nothing is open yet."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, _: end_at_once(number))
    from beamviz.cli import main as run

    code = run()
    # The shutdown of Python is not to be ended by a second signal, nor by the alarm of `reraise`.
    for name in ("SIGALRM", "SIGINT", "SIGTERM") if code > 128 else ("SIGALRM",):
        if hasattr(signal, name):  # Windows has no alarm
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    return code


def end_at_once(number: int) -> None:
    """End the process with one line."""
    name = "interrupted" if number == signal.SIGINT else "terminated"
    os.write(2, f"beamviz: {name}\n".encode())
    os._exit(128 + number)


if __name__ == "__main__":
    sys.exit(main())
