"""Settings of every test, made before numpy is imported, and shared fixtures."""

import os
import re
import signal
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import hypothesis
import pytest
from live.browser import READY, Page, find_browser, page, start_browser

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # timings compare one thread with one thread

# The phase that explains a failure takes minutes.
PHASES = [phase for phase in hypothesis.Phase if phase is not hypothesis.Phase.explain]
hypothesis.settings.register_profile("beamviz", deadline=None, derandomize=True, phases=PHASES)
hypothesis.settings.load_profile("beamviz")


def pytest_configure(config: pytest.Config) -> None:
    """With pytest-xdist, start the one browser of the run before its processes."""
    parallel = getattr(config.option, "numprocesses", None) and not hasattr(config, "workerinput")
    if parallel and not config.option.collectonly and find_browser():
        start_browser()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Quick tests first, in the order of what they need: a solver, a server or process, a
    browser. Tests of a file that share something stay in its order, the slow ones among them."""
    counts = Counter(item.path for item in items)

    def order(item: pytest.Item) -> tuple[bool, int, int]:
        """Of browsers the longest files first, as the last one to start is waited for."""
        is_slow = item.get_closest_marker("slow") is not None and not shares(str(item.path))
        return is_slow, needs(item), -counts[item.path] if needs(item) else 0

    items.sort(key=order)


def needs(item: pytest.Item) -> int:
    """0: nothing that runs beside the test; 1: a server or a process, 2: a browser."""
    if not isinstance(item, pytest.Function):
        return 0
    modules = {getattr(each, "__module__", None) or "" for each in vars(item.module).values()}
    if "live.browser" in modules:
        return 2
    return int(any(name.partition(".")[0] == "live" for name in modules))


SHARED = re.compile(r'scope="module"|\b(?:url|shown|connected|plain)\b')  # fixtures of a file


@cache
def shares(file: str) -> bool:
    """Whether the tests of a file use what is made once for all of them."""
    return bool(SHARED.search(Path(file).read_text(encoding="utf-8")))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """With `--dist loadscope` of pytest-xdist: tests of a file that share something stay in one of
    its processes, others are given out one by one."""
    if config.getvalue("dist") != "loadscope":
        return None
    from xdist.scheduler import LoadScopeScheduling

    class Scheduling(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = nodeid.partition("::")[0]
            return file if shares(str(config.rootpath / file)) else nodeid

    return Scheduling(config, log)


STEEL = """\
length = 2.0
density = 7850
area = 4e-4
second_moment = 1.2e-8
youngs_modulus = 2.1e11
rotation_speed = 25
mass = 0.5
"""


@pytest.fixture
def run(capsys):
    """Run a command line; its exit code, stdout and stderr."""
    from beamviz.cli import main

    def run(*arguments: str) -> tuple[int, str, str]:
        code = main(list(arguments))
        out, err = capsys.readouterr()
        return code, out, err

    return run


@pytest.fixture
def steel(tmp_path: Path) -> str:
    """A beam file in SI units."""
    file = tmp_path / "steel.toml"
    file.write_text(STEEL)
    return str(file)


@pytest.fixture(scope="module")
def frame_loops() -> Iterator[list[Any]]:
    """The frame loops of all explorers started after this, in their order."""
    from beamviz import explorer as server

    made: list[Any] = []

    class Watched(server.FrameLoop):
        def __init__(self, *given: Any):
            super().__init__(*given)
            made.append(self)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(server, "FrameLoop", Watched)
        yield made


@pytest.fixture(scope="module")
def url(request: pytest.FixtureRequest, frame_loops) -> Iterator[str]:
    """A running explorer for all tests of a file; every visitor starts from PAPER, or from the
    scene that the file calls FIRST."""
    from live.server import usual_port
    from live.visitor import PAPER

    from beamviz.explorer import explorer
    from beamviz.scene import Scene

    first = getattr(request.module, "FIRST", Scene(PAPER))
    with explorer(first, port=usual_port()) as address:
        yield address


@pytest.fixture
def guest(request: pytest.FixtureRequest) -> Iterator[Any]:
    """A new visitor, without a connection (live.offline.Local), of an explorer that begins with
    PAPER, or with the scene that the file calls FIRST."""
    from live.offline import local
    from live.visitor import PAPER

    from beamviz.scene import Scene

    with local(getattr(request.module, "FIRST", Scene(PAPER))) as visiting:
        yield visiting


@pytest.fixture
def session(guest) -> Any:
    """The session of `guest`."""
    return guest.session


@pytest.fixture
def connected(request: pytest.FixtureRequest, url: str) -> Iterator[Any]:
    """A new visitor (live.visitor) of the explorer of the file."""
    from live.visitor import visitor

    with visitor(url) as visiting:
        if hasattr(request.module, "FIRST"):
            visiting.beam = request.module.FIRST.beam
        yield visiting


@pytest.fixture
def served(connected, url, frame_loops) -> Any:
    """The session of `connected` in the explorer of the file."""
    from live.server import frame_loop_at

    sessions = frame_loop_at(url, frame_loops).sessions
    return sessions[max(sessions)]


@pytest.fixture(scope="module")
def shown(url) -> Iterator[Page]:
    """One page of the explorer of the file, which its tests use in turn."""
    with page(url, 1440, 900) as opened:
        opened.wait(f"{READY} && document.querySelectorAll('#mode-rows tbody tr').length === 5")
        yield opened


@pytest.fixture(scope="module")
def plain() -> Iterator[Any]:
    """viser's own server, unprotected, for comparison."""
    from live.server import plain_viser_server

    with plain_viser_server() as server:
        yield server


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Ctrl-C is a KeyboardInterrupt, also in a background job of a shell, which ignores it; the
    handlers of signals are restored."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    for number, handler in before.items():
        signal.signal(number, handler)
