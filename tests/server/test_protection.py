"""The protection checks itself: at start, on versions it does not know, and in one module only."""

import logging
import multiprocessing
import re
import sys
from unittest import mock

import pytest
import viser
import websockets
from helpers import slow
from live.server import ROOT
from live.visitor import PAPER

from beamviz.errors import Unavailable
from beamviz.explorer import explorer, serve
from beamviz.scene import Scene
from beamviz.server import access, connection, run_server, viser_private
from beamviz.server.access import VisitorCount
from beamviz.server.viser_private import TunnelFreeServer

VISER_ROOMS = ("drawing", "server", "exports", "explorer")  # that may import viser
KEY = {"visitor_key": "the-key-of-this-run"}
SHARED = {"host": "0.0.0.0", **KEY}


# What the self-test reports, by the part of the protection that is replaced.
MESSAGES = (connection.Connection, "recv", websockets.asyncio.server.ServerConnection.recv)
TUNNEL = viser.ViserServer.request_share_url
BROKEN = {
    "a page of a foreign origin can connect": (connection.Access, "refused", lambda *_: None),
    "a visitor without the key can connect": (access, "matches", lambda *_: True),
    "a message that no page sends": MESSAGES,
    "viser's public tunnel can be opened": (TunnelFreeServer, "request_share_url", TUNNEL),
}


FIRST, *OTHERS = BROKEN


@pytest.mark.parametrize("failure", [FIRST, *slow(*OTHERS)])
def test_a_server_without_its_protection_is_not_shared(monkeypatch, caplog, failure):
    """One line names the failure: an error beyond this machine, a line of the log on it."""
    monkeypatch.setattr(*BROKEN[failure])
    public = {"public": "https://beams.example.org", **KEY}
    for reach in (SHARED, public) if failure == FIRST else (SHARED,):
        match = f"self-test.*{failure}.*not served"
        with pytest.raises(Unavailable, match=match) as caught, explorer(Scene(PAPER), **reach):
            pass
        assert "\n" not in str(caught.value)
    connection.log.reported.clear()
    with explorer(Scene(PAPER), **KEY) as url:
        assert url.startswith("http://127.0.0.1:")
    assert [record for record in caplog.records if failure in record.getMessage()]


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="one process on other systems")
def test_several_processes_without_their_protection_are_not_shared(monkeypatch):
    """Each runs the self-test; one error for all, and no process is left."""
    monkeypatch.setattr(*MESSAGES)
    with pytest.raises(Unavailable, match=r"^self-test.*a message that no page sends"):
        serve(Scene(PAPER), host="0.0.0.0", port=0, processes=2)
    assert not multiprocessing.active_children()


def test_the_self_test_is_neither_logged_nor_counted(caplog):
    """It needs one connection at a time."""
    visitor_count = VisitorCount()
    with (
        caplog.at_level(logging.DEBUG, "beamviz"),
        explorer(Scene(PAPER), visitor_count=visitor_count, max_visitors=1, **SHARED),
    ):
        assert not caplog.records
        assert visitor_count.total == 0


@pytest.mark.parametrize(
    ("owner", "name", "path"),
    [
        (viser._messages, "SetPositionMessage", "viser._messages.SetPositionMessage"),
        (viser._messages, "SceneNodeDragMessage", "viser._messages.SceneNodeDragMessage"),
        (viser.infra.WebsockServer, "queue_message", "viser.infra.WebsockServer.queue"),
        (viser.infra.Message, "redundancy_key", "viser.infra.Message.redundancy_key"),
        (viser._scene_api, "SceneApi", "viser._scene_api.SceneApi, which"),
    ],
)
def test_a_missing_attribute_is_named_with_the_versions(monkeypatch, owner, name, path):
    """Before anything is served, and with the remedy."""
    for cls in getattr(owner, "__mro__", (owner,)):
        if name in vars(cls):
            monkeypatch.delattr(cls, name)
    versions = rf"viser {viser.__version__} with websockets {websockets.__version__} lacks"
    match = rf"{versions} {path}.*pip install 'viser>="
    with pytest.raises(Unavailable, match=match), run_server():
        pass


def test_a_server_that_viser_builds_in_another_way_is_refused():
    """If viser no longer calls websockets' `serve`, the server is stopped."""
    with (
        mock.patch.object(viser_private, "TunnelFreeServer") as other,
        pytest.raises(Unavailable, match="unprotected"),
        run_server(),
    ):
        pass
    assert other.return_value.stop.called


# Private attributes of others, undocumented modules, and names of either as text.
INTERNAL = re.compile(
    r"(?<!\bself)(?<!\bcls)\._(?!_|asdict|replace)\w"
    r"|viser\.infra|from viser import _|unittest|['\"]_(?:impl|websock)"
)


def test_one_module_uses_undocumented_parts_of_viser():
    """All others use documented parts; only four folders import viser."""
    modules = {path: path.read_text() for path in (ROOT / "beamviz").rglob("*.py")}
    reaching = {p for p, text in modules.items() if "viser" in text and INTERNAL.search(text)}
    assert reaching == {ROOT / "beamviz" / "server" / "viser_private.py"}
    assert not [path for path, text in modules.items() if "unittest" in text]
    importing = {p for p, text in modules.items() if "import viser" in text or "from viser" in text}
    assert {path.relative_to(ROOT / "beamviz").parts[0] for path in importing} <= set(VISER_ROOMS)
