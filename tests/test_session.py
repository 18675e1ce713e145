"""Visitors without a browser: private sessions, latest wish, bad input, and a clean end."""

import contextlib
import math
import os
import signal
import socket
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
import websockets.exceptions
from bare import until
from visitor import BEAM, Visitor, redrawn, visitor

from beamviz.beam import Beam, Units
from beamviz.errors import InvalidInput, Unavailable
from beamviz.mechanics.solve import Solution, solve
from beamviz.scene_file import SavedScene
from beamviz.show import server, solving
from beamviz.show.controls import Wanted
from beamviz.show.hosting import hosted
from beamviz.show.panels import Panel
from beamviz.show.readout import significant
from beamviz.show.server import explorer, serve
from beamviz.show.sliders import assign, heard
from beamviz.show.turns import Turns

PAPER = Beam(alpha=1, beta=0.5, gamma=10)


@pytest.fixture(scope="module")
def url() -> Iterator[str]:
    """A running explorer for all tests of this file; every visitor starts from PAPER."""
    with explorer(SavedScene(PAPER)) as address:
        yield address


def frequency(beam: Beam, mode: int = 0, **options: Any) -> str:
    """A frequency as the table prints it."""
    solution = solve(beam, **options)
    return significant(solution.frequencies[mode], solution.errors[mode])


def calm(guest: Visitor) -> None:
    """Pause, and take in what is still on its way."""
    guest.choose("playing", False)
    with contextlib.suppress(TimeoutError):
        while True:
            guest.receive(0.3)


# Each visitor has a session of their own


def test_a_visitor_gets_table_and_picture_at_once(url):
    """The first answer holds all five modes of the starting beam."""
    with visitor(url) as guest:
        for mode in range(5):
            assert frequency(PAPER, mode) in guest.text
        assert "Stable equilibrium" in guest.text
        assert BEAM in guest.nodes


def test_one_visitor_does_not_move_the_beam_of_another(url):
    """A slider of one changes nothing for the other."""
    with visitor(url) as one, visitor(url) as other:
        one.choose("speed γ", 20.0)
        one.says(frequency(PAPER.replace(gamma=20)))
        calm(other)
        assert frequency(PAPER) in other.text
        assert frequency(PAPER.replace(gamma=20)) not in other.text


def test_sliders_and_exact_fields_agree(url):
    """A field beyond the everyday range of its slider is solved, and widens the slider."""
    with visitor(url) as guest:
        guest.choose("γ speed", 120.0)
        guest.says(frequency(PAPER.replace(gamma=120)))
        guest.choose("mass α", 2.5)
        guest.says(frequency(PAPER.replace(gamma=120, alpha=2.5)))


def test_a_hint_says_what_a_slider_does_to_the_beam(url):
    """Each of the five numbers: in a sentence or more, not in its own name."""
    with visitor(url) as guest:
        guest.says("B1")
        for label in ("mass α", "position β", "speed γ", "hub δ", "slenderness μ"):
            hint = guest.hints[label]
            assert len(hint) > 60
            assert not set(hint) & set("αβγδμ")


def test_every_part_of_the_model_can_be_chosen(url):
    """Plane, strain law and curvature change the answer to what solve gives."""
    with visitor(url) as guest:
        guest.choose("plane", "flapwise")
        guest.says(frequency(PAPER, plane="flapwise"))
        guest.choose("curvature", "material")
        guest.says(frequency(PAPER, plane="flapwise", curvature="material"))
        guest.choose("strain", "hencky")
        guest.says(frequency(PAPER, plane="flapwise", curvature="material", strain="hencky"))


def test_hertz_are_shown_for_a_beam_in_si_units():
    """The table is in Hz, and the speed is told in revolutions per minute."""
    units = Units(length=1.0, time=0.01)
    beam = Beam(alpha=1, beta=0.5, gamma=10, units=units)
    with explorer(SavedScene(beam)) as address, visitor(address) as guest:
        solution = solve(beam)
        hertz, error = units.hertz(solution.frequencies[0]), units.hertz(solution.errors[0])
        assert significant(hertz, error) in guest.text
        assert f"{units.rpm(10):.4g} rpm" in guest.text
        assert "times slower" in guest.text


# The latest wish wins


def test_only_the_latest_of_many_edits_is_kept(url, monkeypatch):
    """400 edits in one burst end at the last of them, and most are never solved."""
    solved = []

    def counted(beam: Beam, **options: Any) -> Solution:
        solved.append(beam)
        return solve(beam, **options)

    monkeypatch.setattr(solving, "solve", counted)
    with visitor(url) as guest:
        for k in range(400):
            guest.choose("speed γ", 30 - 0.05 * k)
        guest.says(frequency(PAPER.replace(gamma=30 - 0.05 * 399)))
        calm(guest)
        assert frequency(PAPER.replace(gamma=30 - 0.05 * 399)) in guest.text
    assert len(solved) < 300


def test_wishes_that_came_in_between_are_skipped(monkeypatch):
    """100 wishes during one slow solve: the next one answers the last of them, no other."""
    gate, solved = threading.Event(), []

    def slow(beam: Beam, **options: Any) -> Solution:
        solved.append(beam.gamma)
        gate.wait(10)
        return solve(beam, **options)

    monkeypatch.setattr(solving, "solve", slow)
    ready = threading.Semaphore(0)
    wanted = Wanted.of(PAPER, {})
    with ThreadPoolExecutor(2) as pool:
        solver = solving.Solver(Turns(pool), wanted, ready.release)
        while not solved:
            time.sleep(0.01)
        for k in range(100):
            solver.want(wanted.changed("gamma", float(k)))
        gate.set()
        assert ready.acquire(timeout=10)
        assert ready.acquire(timeout=10)
        assert solver.answer
        assert solver.answer.beam == PAPER.replace(gamma=99)
        solver.close()
    assert solved == [10.0, 99.0]


def test_what_the_program_sets_is_not_a_choice():
    """A slider that follows its field must not set the field back."""
    heard_values: list[float] = []
    with hosted() as server_:
        slider = server_.gui.add_slider("x", 0.0, 1.0, 0.1, 0.0)
        heard(slider, threading.RLock(), heard_values.append)
        assign(slider, 0.5)
        assert slider.value == 0.5
        assign(slider, math.nan)
        assert slider.value == 0.5
    assert heard_values == []


def test_an_edit_is_seen_soon(url):
    """Half of the edits are drawn within half a second, however busy the machine; what it is
    on a quiet one is measured by scripts/measure_edit_to_update.py."""
    with visitor(url) as guest:
        calm(guest)
        times = []
        for k in range(15):
            start = time.perf_counter()
            guest.choose("speed γ", 11.0 + 0.1 * k)
            guest.wait(redrawn)
            times.append(time.perf_counter() - start)
        assert statistics.median(times) < 0.5


# Bad input and bad physics


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (math.nan, "alpha = nan: must lie in 0 .. 100"),
        (1e9, "alpha = 1000000000: must lie in 0 .. 100"),
        (-1.0, "alpha = -1: must lie in 0 .. 100"),
        (math.inf, "alpha = inf: must lie in 0 .. 100"),
    ],
)
def test_a_bad_number_is_named_and_loses_nothing(url, value, words):
    """The message names the number, its value and its range; the next good one is solved."""
    with visitor(url) as guest:
        guest.choose("mass α", value)
        guest.says(words)
        guest.choose("mass α", 2.0)
        guest.says(frequency(PAPER.replace(alpha=2)))
        guest.says("Stable equilibrium")


def test_nonsense_from_a_browser_does_not_end_a_session(url):
    """Unknown choices, wrong kinds, unknown controls: ignored, and the session goes on."""
    with visitor(url) as guest:
        guest.choose("strain", "rubber")
        guest.choose("colour", "rainbow")
        guest.choose("amplitude", math.nan)
        guest.choose("pace", -math.inf)
        guest.choose("show", "99")
        guest.choose("view", "upside down")
        guest.choose("mode 3", 1e30)
        guest.send(type="GuiUpdateMessage", uuid="nobody", updates={"value": 1})
        guest.choose("speed γ", 12.0)
        guest.says(frequency(PAPER.replace(gamma=12)))


def test_no_equilibrium_is_said_where_the_beam_was_and_greys_it(url):
    """biot has none at mu = 10, gamma = 20: the limit is named, the last picture stays, grey."""
    with visitor(url) as guest:
        guest.choose("strain", "biot")
        guest.choose("slenderness μ", 10.0)
        guest.choose("speed γ", 20.0)
        guest.says("no equilibrium beyond gamma = 10.7")
        guest.wait(lambda _: guest.nodes["/stage/wheel/words"].get("visible"))
        assert "No equilibrium" in guest.nodes["/stage/wheel/words"]["text"]
        assert "opacity:.35" in guest.text
        guest.choose("speed γ", 5.0)
        guest.says("Stable equilibrium")


def test_an_unstable_state_is_said_with_its_growth(url):
    """delta = -1, gamma = 5 without a mass: the straight beam buckles. Its modes are listed; the
    picture stays the last good one, on its drum."""
    with visitor(url) as guest:
        guest.choose("mass α", 0.0)
        guest.choose("speed γ", 5.0)
        guest.says(frequency(Beam(beta=0.5, gamma=5)))
        guest.choose("hub δ", -1.0)
        guest.says("Unstable: the straight beam runs away in bending")
        growth = solve(Beam(beta=0.5, gamma=5, delta=-1)).growth_rates.max()
        guest.says(f"{growth:.4g} t/T*")
        guest.wait(lambda _: guest.nodes["/stage/wheel/words"].get("visible"))
        assert guest.nodes["/stage/wheel/hoop"]["visible"] is False
        guest.choose("speed γ", 1.0)
        guest.wait(lambda _: guest.nodes["/stage/wheel/hoop"]["visible"])


def test_a_first_beam_without_equilibrium_is_shown_in_words():
    """There is no last good picture then: the undeformed beam stands in, grey."""
    beam = Beam(mu=10, gamma=20)
    with (
        explorer(SavedScene(beam, {"strain": "biot"})) as address,
        visitor(address, first="No equilibrium") as guest,
    ):
        guest.says("no equilibrium beyond gamma = 15.7")
        guest.wait(lambda _: guest.nodes["/stage/wheel/words"].get("visible"))


def test_an_edit_that_comes_while_the_session_is_built_is_not_lost(monkeypatch):
    """A page may send before the server has finished with it."""
    put = Panel.put

    def early(panel: Panel, scene: SavedScene) -> None:
        put(panel, scene)
        panel.listener.want("gamma", 21.0)
        panel.listener.see("colouring", "axial strain")

    monkeypatch.setattr(Panel, "put", early)
    first = frequency(PAPER.replace(gamma=21))
    with explorer(SavedScene(PAPER)) as address, visitor(address, first=first) as guest:
        assert guest.says("axial strain, as drawn")


# Work, and the end of it


def test_nothing_is_computed_while_nothing_moves(monkeypatch):
    """A paused visitor, and none at all, cost no time: the animator does not even wake."""
    woken: list[float] = []
    sleep = server.Animator.sleep

    def counted(animator: server.Animator, due: float) -> set[int]:
        woken.append(due)
        return sleep(animator, due)

    monkeypatch.setattr(server.Animator, "sleep", counted)
    with explorer(SavedScene(PAPER)) as address:
        with visitor(address) as guest:
            calm(guest)
            count = len(woken)
            assert load(0.6) < 0.02
            assert len(woken) == count
        time.sleep(0.3)
        count = len(woken)
        assert load(0.6) < 0.02
        assert len(woken) == count


def load(seconds: float) -> float:
    """The share of one core this process uses."""
    start = time.process_time()
    time.sleep(seconds)
    return (time.process_time() - start) / seconds


def test_a_visitor_who_leaves_is_forgotten(monkeypatch):
    """Their session is closed, and the animator keeps none of it."""
    made: list[server.Animator] = []

    class Watched(server.Animator):
        def __init__(self, *given: Any):
            super().__init__(*given)
            made.append(self)

    monkeypatch.setattr(server, "Animator", Watched)
    with explorer(SavedScene(PAPER)) as address:
        with visitor(address):
            assert len(made[0].sessions) == 1
        end = time.monotonic() + 5
        while made[0].sessions and time.monotonic() < end:
            time.sleep(0.02)
        assert not made[0].sessions


def test_a_page_of_another_site_cannot_open_a_session(url):
    """A browser names the page it acts for; only our own may connect."""
    with (
        pytest.raises(websockets.exceptions.InvalidStatus, match="403"),
        visitor(url, origin="http://evil.example"),
    ):
        pass
    local = url.replace("127.0.0.1", "localhost")
    with visitor(local, origin=local) as guest:
        assert BEAM in guest.nodes


def test_a_busy_port_is_said_in_one_line():
    """Unavailable names the address and the remedy; no other port is taken silently."""
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(Unavailable, match=rf"127\.0\.0\.1:{port} .*--port") as caught:
            serve(SavedScene(PAPER), port=port)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("host", ["999.1.1.1", "192.0.2.1", "no such host"])
def test_a_host_that_is_not_here_is_said_at_once(host):
    """viser would wait for ever on it."""
    start = time.monotonic()
    with pytest.raises(Unavailable, match="--host"):
        serve(SavedScene(PAPER), host=host, port=0)
    assert time.monotonic() - start < 15


def test_options_that_make_no_sense_are_refused_before_serving():
    """An unknown strain law raises what solve raises."""
    with pytest.raises(InvalidInput, match="rubber"):
        serve(SavedScene(PAPER, {"strain": "rubber"}), port=0)


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_the_server_cleanly(ending):
    """With a visitor watching: exit code 0, one line on stdout, nothing on stderr, port free."""
    process = subprocess.Popen(
        [sys.executable, "-c", SERVE],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.getcwd()},
    )
    try:
        assert process.stdout
        line = process.stdout.readline()
        address = next(word for word in line.split() if word.startswith("http://127.0.0.1:"))
        with contextlib.suppress(websockets.exceptions.ConnectionClosed), visitor(address) as guest:
            process.send_signal(ending)
            while True:
                guest.receive(10)
        output, errors = process.communicate(timeout=20)
    finally:
        process.kill()
    assert process.returncode == 0
    assert (output, errors) == ("", "")
    with socket.socket() as free:
        free.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        free.bind(("127.0.0.1", int(address.rsplit(":", 1)[1])))


SERVE = """
from beamviz.beam import Beam
from beamviz.scene_file import SavedScene
from beamviz.show.server import serve
serve(SavedScene(Beam(alpha=1, beta=0.5, gamma=10)), port=0)
"""


def test_no_thread_is_left_behind():
    """After an explorer has ended, neither what opens sessions nor its solvers run."""
    before = set(threading.enumerate())
    with explorer(SavedScene(PAPER)) as address, visitor(address):
        names = {thread.name.split("_")[0] for thread in set(threading.enumerate()) - before}
        assert "opener" in names

    def names_left() -> set[str]:
        return {thread.name.split("_")[0] for thread in set(threading.enumerate()) - before}

    until(lambda: not {"opener", "solver", "charter"} & names_left())
