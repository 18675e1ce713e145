"""Where a Firefox is. Standard library only."""

import os
import shutil

FIREFOXES = "firefox", "firefox-esr", "/Applications/Firefox.app/Contents/MacOS/firefox"


def find_firefox() -> str | None:
    """The Firefox named by BEAMVIZ_FIREFOX (a name or a path), else the first one found; none where
    the tests are to have no browser."""
    if os.environ.get("BEAMVIZ_BROWSER") == "none":
        return None
    named = os.environ.get("BEAMVIZ_FIREFOX")
    return next(filter(None, map(shutil.which, [named] if named else FIREFOXES)), None)
