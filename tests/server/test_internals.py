"""What viser keeps to itself is touched in one file, which says what versions it was tested on."""

import ast
from pathlib import Path

import pytest
import viser
import websockets

from beamviz.server import viser_private as hardening

ROOT = Path(__file__).parents[2]
FILES = sorted(
    path
    for folder in ("drawing", "server", "exports", "explorer")
    for path in (ROOT / "beamviz" / folder).rglob("*.py")
)
THE_ONE = ROOT / "beamviz" / "server" / "viser_private.py"


NAMED_TUPLE = ("_asdict", "_replace")  # public in spite of their underscore


def hidden(name: str) -> bool:
    """Whether a name is private by its underscore; `__init__` and its like are not."""
    return name.startswith("_") and not name.endswith("__") and name not in NAMED_TUPLE


def internals(text: str) -> set[str]:
    """What in a module is not meant to be seen from outside viser: private names of others,
    modules of viser that are not documented, replaced parts, and attributes taken by their name
    as text."""
    found = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Attribute) and hidden(node.attr):
            if not (isinstance(node.value, ast.Name) and node.value.id in ("self", "cls")):
                found.add(node.attr)
        elif isinstance(node, ast.Import):
            found |= {a.name for a in node.names if undocumented(a.name)}
        elif isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            found |= {name for name in names if undocumented(name)}
        elif isinstance(node, ast.Constant) and str(node.value).startswith(("_impl", "_websock")):
            found.add(str(node.value))
    return found


def undocumented(module: str) -> bool:
    """Whether a module, or a name in it, is viser's own business, or replaces parts of others."""
    first, *rest = module.split(".")
    ours = first == "viser" and (rest[:1] == ["infra"] or any(map(hidden, rest)))
    return ours or module == "unittest.mock" or module.startswith("unittest.mock.")


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_viser_is_reached_into_in_one_file(path):
    """All others use what it offers."""
    found = internals(path.read_text())
    assert bool(found) == (path == THE_ONE), found


@pytest.mark.parametrize(
    "line",
    [
        "from viser import _messages",
        "from viser._messages import GuiUpdateMessage",
        "import viser.infra",
        "from viser.infra import Message",
        "from unittest import mock",
        "client.gui._websock_interface",
        "server._event_loop.stop()",
        "getattr(node, '_impl')",
    ],
)
def test_what_counts_as_reaching_in(line):
    """Each of these would be noticed."""
    assert internals(line)


def test_what_is_public_may_be_used():
    """Names that viser documents, and names of our own."""
    assert not internals("import viser\nfrom viser import GuiApi\nself._known = node.visible")


def test_the_versions_installed_are_those_tested():
    """So all other tests of the protection say something about them."""
    hardening.check_versions()
    assert viser.__version__ == hardening.TESTED["viser"]
    assert websockets.__version__.startswith(hardening.TESTED["websockets"])


def test_only_what_shows_knows_viser():
    """So these are all the files that could reach into it."""
    others = set((ROOT / "beamviz").rglob("*.py")) - set(FILES)
    assert others
    assert not [path for path in others if "import viser" in path.read_text()]
    assert not [path for path in others if "from viser" in path.read_text()]
