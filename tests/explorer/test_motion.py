"""The tab Motion: what the scene, the charts and the address show of a motion in time."""

import base64
import json
import re
import threading
from collections.abc import Callable
from dataclasses import replace
from html import unescape
from typing import Any, NamedTuple
from urllib.parse import parse_qsl, urlencode

import numpy as np
import pytest
from helpers import slow
from live.browser import NODES, READY, by_id, page
from live.offline import Desk, offline
from live.server import TIMEOUT, held_back, latest, wait_until
from live.visitor import Visitor, catch_up, visitor

from beamviz.beam import Beam
from beamviz.drawing.colours import PALETTES
from beamviz.dynamics import motion
from beamviz.dynamics.drives import Hub
from beamviz.explorer import computed_motion, jobs
from beamviz.explorer.computed_motion import TOLERANCE
from beamviz.explorer.experiment import PULLED, Experiment, Hold, MotionState, with_experiment
from beamviz.explorer.features import real_beam
from beamviz.explorer.features.beam_pull import BeamPull
from beamviz.explorer.features.motion import CONTENT, PRESETS
from beamviz.explorer.links import parse_link
from beamviz.explorer.session import Session
from beamviz.explorer.state import Case, State
from beamviz.presets import PRESETS as PRESETS_OF_BLADES
from beamviz.scene import Scene, inline_toml
from beamviz.solver import solve

FIRST = Scene(Beam(alpha=1, beta=0.5, gamma=3))
SHORT = "?alpha=1&beta=0.5&gamma=3&tab=motion&moving=true&motion={until=4.0}"
CHART, SPECTRUM = "motion-chart", "motion-spectrum"
REFERENCE = TOLERANCE / 10  # of the motions that those of the page are compared with


def has_chart(guest: Visitor, end: float) -> bool:
    """Whether the chart shows a motion until a time."""
    axis = guest.charts[CHART].get("x")
    return bool(axis) and axis["range"][1] == end and "hidden" in guest.props[CHART]


@pytest.fixture
def pulled(guest) -> Visitor:
    """A visitor who has pulled the beam and let go, with reduced motion: paused at the start."""
    guest.do("preferences", "still")
    guest.do("link", SHORT)
    guest.wait(lambda _: has_chart(guest, 4.0) and guest.charts[CHART].get("cursor"))
    return guest


def chosen(session: Session) -> MotionState:
    """What the visitor has chosen of the motion."""
    return session.visitor.state.slice(MotionState)


def tip_drawn(session: Session) -> np.ndarray:
    """Position (2,) of the tip from the clamp, as it was drawn last."""
    return session.view.beam.line[-1, :2] - [session.snapshot.beam.delta, 0]


def test_chart_and_scene_show_the_computed_motion(pulled, session):
    """To the tolerance of the page, twice as both are estimates; the drawn beam is a sum of shapes,
    to 1e-3 L."""
    found = motion(
        FIRST.beam, 4.0, release=PULLED.pull, damping=PULLED.damping, tolerance=REFERENCE
    )
    chart = pulled.charts[CHART]
    shown = np.interp(found.t, chart["at"], chart["lines"][0]["y"])
    assert np.abs(shown - found.tip[:, 1]).max() < 2 * TOLERANCE
    for moment in (0.0, 0.6, 2.35, 4.0):
        pulled.do("moment", moment, until=lambda _, at=moment: pulled.values["moment"] == at)
        wait_until(lambda at=moment: session.visitor.clock.moment == at)
        catch_up(pulled)
        (tip,) = found.position([moment], [1.0])[:, 0]
        assert tip_drawn(session) == pytest.approx(tip, abs=TOLERANCE + 1e-3)


def test_the_motion_is_played_and_paused(pulled, session):
    """The line of the chart moves with it, at one rate; paused, the address has the moment, and a
    fresh page on it shows the same."""
    pulled.choose("playing", True)
    pulled.wait(lambda _: 0.1 < pulled.charts[CHART]["cursor"]["x"] < 3)
    pulled.choose("playing", False)
    catch_up(pulled)
    pulled.wait(lambda _: "moment=" in pulled.parts["address"])
    catch_up(pulled)
    shown = pulled.charts[CHART]["cursor"]["x"]
    assert shown == pytest.approx(session.visitor.clock.moment)
    assert shown > 0.1
    told = dict(parse_qsl(pulled.parts["address"]))["moment"]
    assert float(told) == pytest.approx(shown)
    assert len(told) <= len("0.1234")


def test_a_link_holds_the_motion(pulled, url):
    """Its experiment, the moment, and that the scene shows it; undo goes back."""
    pulled.do("motion.pull", -2.0)
    pulled.do("moment", 1.5)
    pulled.wait(lambda _: "moment=1.5" in pulled.parts["address"])
    scene, values, *_ = parse_link(pulled.parts["address"])
    own = replace(PULLED, until=4.0, pull=-2.0)
    assert values["experiment"] == own
    assert (values["moment"], values["in_motion"], scene.beam) == (1.5, True, FIRST.beam)
    with visitor(url) as fresh:
        fresh.do("preferences", "still")
        fresh.do("link", f"?{pulled.parts['address']}")
        fresh.wait(lambda _: has_chart(fresh, 4.0) and fresh.values.get("moment") == 1.5)
        lowest = min(fresh.charts[CHART]["lines"][0]["y"])
        assert fresh.charts[CHART]["lines"][0]["y"][0] == pytest.approx(lowest, rel=0.05)
    pulled.do("undo", until=lambda _: pulled.values["motion.pull"] == PULLED.pull)


def test_the_force_of_a_pull_has_a_prefix(guest, session):
    """Of a blade in MN, not in seven digits of N; it is typed in that unit."""
    guest.do("blade.preset", "nrel-5mw-blade")
    guest.do("tab", "motion")
    guest.wait(lambda _: "[MN]" in guest.texts.get("motion.pull-label", ""))
    one = PRESETS_OF_BLADES["nrel-5mw-blade"].beam.units.force
    guest.wait(lambda _: guest.values["motion.pull"] == pytest.approx(1e-6 * one, rel=1e-5))
    guest.do("motion.pull", 2e-6 * one)
    wait_until(lambda: chosen(session).experiment.pull == pytest.approx(2.0))


@pytest.mark.parametrize("text", ["{pull=99.0}", "{hub='fast'}", "{colour=1}", "3"])
def test_a_link_with_another_motion_is_refused(text):
    """With the name of what is wrong."""
    (error,) = parse_link(f"motion={text}").refused
    assert re.search("pull|hub|colour|motion|unknown", str(error))


def test_the_modes_are_seen_in_the_spectrum(pulled):
    """Peaks at B1 and B2 of the mode table with Coriolis forces, to the resolution 2 pi / T of the
    spectrum, and lines at the frequencies, labelled."""
    chart = pulled.charts[SPECTRUM]
    lines = {line["label"]: line["at"][0] for line in chart["lines"] if line["label"]}
    solution = solve(FIRST.beam, coriolis=True)
    assert list(lines) == list(solution.labels)
    assert list(lines.values()) == pytest.approx(solution.frequencies.tolist(), rel=1e-5)
    spectrum = next(line for line in chart["lines"] if not line["label"])
    at, height = np.array(chart["at"]), np.array(spectrum["y"])
    width = 2 * np.pi / 4.0
    for label in ("B1", "B2"):
        near = abs(at - lines[label]) <= 3 * width
        assert at[near][height[near].argmax()] == pytest.approx(lines[label], abs=width)


SHOWN_ELSEWHERE = [name for name in PRESETS if name not in ("pull", "stop", "modes")]


@pytest.mark.parametrize("name", ["pull", "stop", "modes", *slow(*SHOWN_ELSEWHERE)])
def test_every_experiment_has_a_motion(guest, name):
    """Within some seconds, which is said in words; the controls without effect are hidden."""
    guest.do("tab", "motion")
    guest.do("gamma", 2.0)
    own = PRESETS[name][1]
    guest.do("experiment", name)
    guest.wait(lambda _: guest.values.get("experiment") == name and has_chart(guest, own.until))
    guest.wait(lambda _: "Before the last change" not in guest.texts["motion-list"])
    assert 'class="note"' not in guest.texts["motion-list"] or own.unstiffened
    assert bool(guest.props["motion.within-row"]["hidden"]) is not own.ramps
    assert "γ = 2" in guest.texts["motion-words"]


def test_without_stiffening_it_diverges_and_the_scene_says_so(guest, session):
    """When it does, not before; the beam itself goes on. The part of the chart after that is
    marked."""
    guest.do("preferences", "still")
    guest.do("link", "?gamma=6&moving=true&motion={pull=0.0,hub='smooth',until=14.0}&tab=motion")
    guest.wait(lambda _: has_chart(guest, 14.0))
    assert guest.charts[CHART]["gaps"] == []
    guest.do("motion.unstiffened", True)
    guest.wait(lambda _: guest.charts[CHART]["gaps"])
    (start, end, text) = guest.charts[CHART]["gaps"][0]
    assert (end, "diverged" in text) == (14.0, True)

    def captions() -> str:
        return " ".join(one["text"] for one in guest.parts["captions"])

    guest.do("moment", start - 0.5, until=lambda _: "without stiffening" in captions())
    catch_up(guest)
    assert "diverged" not in captions()
    guest.do("moment", start + 0.5, until=lambda _: "diverged at t = " in captions())
    last = session.view.scene.others[False].line[-1, 1]
    assert abs(last) == pytest.approx(1.0, abs=0.01)
    assert abs(tip_drawn(session)[1]) < 0.3


def test_the_mass_is_there_while_it_is_on_the_beam(guest, session):
    """Caught and dropped at the time chosen; a beam without a mass gets its last one back."""
    guest.do("preferences", "still")
    guest.do("alpha", 0.0)
    guest.do("tab", "motion")
    for name, before in (("catch", False), ("drop", True)):
        guest.do("experiment", name)
        assert chosen(session).experiment == PRESETS[name][1]
        guest.do("motion.until", 6.0)
        guest.wait(lambda _: has_chart(guest, 6.0) and session.snapshot.film)
        wait_until(lambda: not session.is_busy)
        for moment, there in ((4.9, before), (5.1, not before)):
            guest.do("moment", moment, until=lambda _, at=moment: guest.values["moment"] == at)
            wait_until(lambda there=there: bool(session.view.beam.bodies.shown) is there)
    assert session.visitor.state.case.numbers["alpha"] == 1.0


def test_a_failure_is_told_in_its_kind(guest):
    """What a motion has not, a beam without equilibrium, a number out of range; then a motion
    again."""
    guest.do("tab", "motion")
    guest.do("motion.until", 2.0)
    for name, value, words in (
        ("plane", "flapwise", "in the plane of rotation"),
        ("stiffening", False, "has all effects"),
        ("spin_up", 5.0, "no constant spin-up"),
        ("gamma", 60.0, "no equilibrium"),
    ):
        if name == "gamma":
            guest.do("strain", "hencky")
        guest.do(name, value)
        guest.wait(lambda _, w=words: w.lower() in guest.texts["motion-words"].lower())
        guest.wait(lambda _: guest.props[CHART]["hidden"] is True)
        guest.do("undo")
        if name == "gamma":
            guest.do("strain", "green")
        guest.wait(lambda _: has_chart(guest, 2.0) and not guest.props[CHART]["hidden"])


def test_nothing_of_another_beam_is_shown_with_a_number_out_of_range(pulled, session):
    """Neither charts nor scene; a pull of the beam that is still drawn does no harm."""
    pulled.do("alpha", 1e9)
    pulled.wait(lambda _: pulled.props[CHART]["hidden"] and session.snapshot.film is None)
    with session.visitor.lock:
        state = session.visitor.state
        released = Hold(1.0, 0.1, held=False)
        session.visitor.set_state(state.with_values(MotionState, hold=released))
    wait_until(lambda: chosen(session).hold is None)
    pulled.do("alpha", 1.0)
    pulled.wait(lambda _: not pulled.props[CHART]["hidden"] and session.snapshot.film)


def test_play_begins_the_motion_and_a_button_ends_it(guest, session):
    """Where the scene shows modes, though these play already. The motion prepared in the tab is not
    marked as chosen until it is in the scene."""
    guest.do("tab", "motion")
    guest.wait(lambda _: has_chart(guest, 20.0))
    assert guest.values["experiment"] == ""
    guest.do("motion.begin", until=lambda _: session.snapshot.film)
    guest.wait(lambda _: guest.values["experiment"] == "pull" and guest.values["playing"])
    assert "Back to the modes" in guest.texts["scene-caption"]
    guest.do("motion.leave", until=lambda _: session.snapshot.film is None)
    guest.wait(lambda _: guest.values["experiment"] == "")


def test_from_the_start_plays(pulled, session):
    """Where the motion is paused, though motion is reduced: the visitor asks for it."""
    (attributes,) = re.findall("<button([^>]*)>Play from the start<", CONTENT)
    (action,) = re.findall('data-do="(.*?)"', attributes)
    pulled.do("moment", 2.5, until=lambda _: pulled.values["moment"] == 2.5)
    for value in re.findall('data-value="(.*?)"', attributes) or [None]:
        pulled.do(action, value and json.loads(value))
    pulled.wait(lambda _: pulled.values["playing"])
    wait_until(lambda: 0 < session.visitor.clock.moment < 2.5)


def test_the_tab_says_that_the_scene_shows_no_motion_yet(guest, session):
    """No line of a moment is in its chart until the motion begins, and after a mode was clicked."""
    guest.do("tab", "motion")
    guest.wait(lambda _: has_chart(guest, 20.0))
    guest.wait(lambda _: "natural modes" in guest.texts["motion-shown"])
    assert guest.charts[CHART]["cursor"] is None
    guest.do("motion.begin", until=lambda _: guest.charts[CHART]["cursor"])
    assert guest.texts["motion-shown"] == ""
    guest.do("only", 1, until=lambda _: guest.charts[CHART]["cursor"] is None)
    guest.wait(lambda _: "natural modes" in guest.texts["motion-shown"])


def test_without_an_equilibrium_the_tab_says_what_the_scene_says(guest):
    """With the same digits of the limit."""
    guest.do("link", "?alpha=1&beta=0.5&gamma=40&strain=hencky&tab=motion")
    guest.wait(lambda _: "No equilibrium above" in guest.texts["equilibrium"])
    (told,) = re.findall("<b>(.*?)</b>", guest.texts["equilibrium"])
    guest.wait(lambda _: "quilibrium" in guest.texts["motion-words"])
    assert guest.texts["motion-words"] == told


def test_an_experiment_that_is_begun_again_begins_at_its_start(pulled, session):
    """Though its motion is known already, and was at another moment."""
    pulled.do("experiment", "stop")
    for _ in range(2):
        pulled.wait(lambda _: has_chart(pulled, 10.0) and session.snapshot.film)
        pulled.do("moment", 2.5, until=lambda _: pulled.values["moment"] == 2.5)
        pulled.do("experiment", "stop", until=lambda _: pulled.values["moment"] == 0)
        catch_up(pulled)
        assert session.visitor.clock.moment == 0
    pulled.do("moment", 2.5, until=lambda _: pulled.values["moment"] == 2.5)
    pulled.do("only", 0)
    pulled.wait(lambda _: session.snapshot.film is None)
    pulled.do("motion.begin", until=lambda _: 0 < session.visitor.clock.moment < 2.5)


def test_a_moment_chosen_while_another_motion_arrives_is_kept(pulled, session, monkeypatch):
    """In the frame of both: the new motion is shown at it, paused, and so is the state."""
    release, compute = threading.Event(), computed_motion.motion
    monkeypatch.setattr(
        computed_motion, "motion", lambda *a, **k: (release.wait(60), compute(*a, **k))[1]
    )
    for moment, alpha in ((1.25, 2.0), (0.75, 1.5)):
        release.clear()
        pulled.do("alpha", alpha)
        catch_up(pulled)
        release.set()
        pulled.do("moment", moment)
        wait_until(lambda alpha=alpha: session.snapshot.film.beam.alpha == alpha)
        pulled.wait(lambda _, at=moment: pulled.values["moment"] == at)
        catch_up(pulled)
        assert session.visitor.clock.moment == chosen(session).moment == moment


def test_the_lines_of_the_spectrum_are_those_of_the_speed_reached(guest):
    """A motion that ends within its ramp, at a fifth of the speed."""
    own = "motion={pull=0.0,hub='linear',within=20.0,until=4.0}"
    guest.do("link", f"?gamma=5&tab=motion&moving=true&{own}")
    guest.wait(lambda _: has_chart(guest, 4.0))
    at_end = solve(Beam(gamma=1), coriolis=True).frequencies
    shown = [line["at"][0] for line in guest.charts[SPECTRUM]["lines"] if line["label"]]
    assert shown[:2] == pytest.approx(at_end[:2], rel=1e-3)


def test_what_cannot_move_says_so_in_place_of_the_experiment(guest):
    """A body dropped after the end, in the times shown; a beam out of the plane of rotation."""
    guest.do("tab", "motion")
    guest.do("experiment", "drop")
    guest.do("motion.until", 4.0)
    guest.wait(lambda _: "after the end of the motion at t = 4" in guest.texts["motion-words"])
    guest.do("experiment", "pull")
    guest.do("plane", "flapwise")
    guest.wait(lambda _: "in the plane of rotation alone" in guest.texts["motion-words"])
    assert guest.props[CHART]["hidden"] is True


PARTS = ("motion-presets", "motion-settings", "motion-play-row", "moment-row", "motion-files")


def offered(guest: Visitor) -> set[str]:
    """The controls of the tab that are on the page."""
    return {id for id in PARTS if not guest.props[id]["hidden"]}


@pytest.mark.parametrize(
    ("action", "value", "left"),
    [
        ("plane", "flapwise", set()),
        ("alpha", 1e9, set()),
        ("motion.body_at", 9.0, {"motion-presets", "motion-settings"}),
        ("gamma", 60.0, {"motion-presets", "motion-settings"}),
    ],
)
def test_without_a_motion_there_is_nothing_to_play(guest, session, action, value, left):
    """Out of plane, out of range: no experiment, and no pull of the beam in the scene
    either; of a body dropped after the end, or a beam without equilibrium: another experiment."""
    own = "{body='dropped', body_at=1.0, until=2.0}"
    guest.do("link", f"?alpha=1&strain=hencky&tab=motion&motion={own}")
    guest.wait(lambda _: has_chart(guest, 2.0))
    assert offered(guest) == {*PARTS}
    assert session.feature(BeamPull).sleeve.visible
    guest.do(action, value)
    guest.wait(lambda _: offered(guest) == left)
    catch_up(guest)
    assert session.feature(BeamPull).sleeve.visible is bool(left)
    guest.do("undo")
    guest.wait(lambda _: offered(guest) == {*PARTS})


@pytest.mark.parametrize(
    ("action", "value"),
    [
        ("plane", "flapwise"),
        ("stiffening", False),
        ("softening", False),
        ("spin_up", 2.0),
    ],
)
def test_a_button_removes_what_a_motion_has_not(guest, action, value):
    """In the sentence that tells it."""
    guest.do("tab", "motion")
    guest.wait(lambda _: "The hub turns" in guest.texts["motion-words"])
    guest.do(action, value)
    found = guest.wait(lambda _: re.search("<button[^>]*>", guest.texts["motion-words"]))
    told = dict(re.findall(r'(data-\w+)="([^"]*)"', found[0]))
    key = told.get("data-set") or told["data-do"]
    guest.do(key, json.loads(unescape(told.get("data-value", "null"))))
    guest.wait(lambda _: "The hub turns" in guest.texts["motion-words"])


def test_a_long_motion_is_cancelled(connected, monkeypatch):
    """And the next one is computed. It is told once, in the tab, which waits for its first
    motion."""
    release = threading.Event()
    monkeypatch.setattr(computed_motion, "motion", held_back(computed_motion.motion, release))
    monkeypatch.setattr(jobs, "PATIENCE", 0.05)

    def told() -> list[str]:
        texts = connected.texts["work"] + connected.texts["motion-wait"]
        return re.findall("computing: motion[^:]*Cancel", texts)

    connected.do("tab", "motion", until=lambda _: told())
    assert len(told()) == 1
    connected.do("cancel_jobs", until="cancelled: motion")
    release.set()
    connected.do("motion.pull", 0.5)
    connected.do("motion.until", 2.0)
    connected.wait(lambda _: has_chart(connected, 2.0) and not connected.props[CHART]["hidden"])


def test_a_slider_moved_meanwhile_starts_the_motion_again(pulled, session):
    """While it plays: the motion of the new beam, from its beginning, and of the last value where
    several come before one is computed."""
    pulled.choose("playing", True)
    pulled.wait(lambda _: pulled.charts[CHART]["cursor"]["x"] > 1)
    before = session.snapshot.film
    for alpha in (0.4, 0.7, 2.5):
        pulled.do("alpha", alpha)
    pulled.wait(lambda _: session.snapshot.film is not before and session.snapshot.film)
    wait_until(lambda: session.snapshot.film.beam.alpha == 2.5)
    wait_until(lambda: session.visitor.clock.moment < 1)
    heavier = FIRST.beam.replace(alpha=2.5)
    found = motion(heavier, 4.0, release=PULLED.pull, damping=PULLED.damping, tolerance=REFERENCE)

    def is_shown(_) -> bool:
        chart = pulled.charts[CHART]
        shown = np.interp(found.t, chart["at"], chart["lines"][0]["y"])
        return np.abs(shown - found.tip[:, 1]).max() < 2 * TOLERANCE

    pulled.wait(is_shown)


def test_after_a_pause_too_the_motion_of_another_beam_begins_at_its_start(pulled, session):
    """If it is played again by then; paused it is shown at the moment of the pause."""
    pulled.do("moment", 2.0, until=lambda _: pulled.values["moment"] == 2)
    pulled.do("alpha", 2.0)
    pulled.wait(lambda _: session.snapshot.film and session.snapshot.film.beam.alpha == 2)
    wait_until(lambda: session.visitor.clock.moment == 2)
    pulled.choose("playing", True)
    pulled.wait(lambda _: pulled.charts[CHART]["cursor"]["x"] > 2.2)
    assert "moment" not in dict(parse_qsl(pulled.parts["address"]))
    pulled.do("alpha", 2.5)
    pulled.wait(lambda _: session.snapshot.film.beam.alpha == 2.5)
    wait_until(lambda: session.visitor.clock.moment < 2)


def test_an_earlier_motion_is_called_one_until_the_next_is_computed(pulled, monkeypatch):
    """In the scene and beside the charts, from the first moment."""
    release, compute = threading.Event(), computed_motion.motion
    monkeypatch.setattr(
        computed_motion, "motion", lambda *a, **k: (release.wait(60), compute(*a, **k))[1]
    )
    assert "The tip is at most" in pulled.texts["motion-list"]
    try:
        pulled.do("alpha", 2.5)
        pulled.wait(lambda _: "Before the last change the tip" in pulled.texts["motion-list"])
        pulled.wait(lambda _: "before the last change" in pulled.texts["scene-caption"])
    finally:
        release.set()
    pulled.wait(lambda _: "The tip is at most" in pulled.texts["motion-list"])
    pulled.wait(lambda _: "Motion in time" in pulled.texts["scene-caption"])


def test_the_reason_against_a_motion_goes_with_its_beam(guest, monkeypatch):
    """While the motion of the next beam is computed, the sentence is about that."""
    guest.do("link", SHORT)
    guest.do("plane", "flapwise")
    guest.wait(lambda _: "in the plane of rotation alone" in guest.texts["motion-words"])
    release, compute = threading.Event(), computed_motion.motion
    monkeypatch.setattr(
        computed_motion, "motion", lambda *a, **k: (release.wait(60), compute(*a, **k))[1]
    )
    try:
        guest.do("undo")
        guest.wait(lambda _: "the beam is pulled" in guest.texts["motion-words"])
    finally:
        release.set()


def test_a_hub_is_turned_by_a_torque(guest, session):
    """From rest, backwards too: the tip, the speed that the scene tells, and the lines of the
    spectrum at the speed reached. The controls of the hub are there, and a link holds them."""
    guest.do("preferences", "still")
    own = {"pull": 0.0, "hub": "torque", "torque": -3.0, "inertia": 0.8, "damping": 0.0}
    guest.do("link", f"?alpha=1&tab=motion&moving=true&motion={inline_toml(own | {'until': 2.0})}")
    guest.wait(lambda _: has_chart(guest, 2.0))
    for name in ("torque", "inertia"):
        assert guest.props[f"motion.{name}-row"]["hidden"] is False
    found = motion(Beam(alpha=1), 2.0, speed=Hub(0.8, -3.0), tolerance=REFERENCE)
    chart = guest.charts[CHART]
    shown = np.interp(found.t, chart["at"], chart["lines"][0]["y"])
    assert np.abs(shown - found.tip[:, 1]).max() < 2 * TOLERANCE
    guest.do("moment", 1.5, until=lambda _: guest.values["moment"] == 1.5)

    def told() -> str:
        return " ".join(one["text"] for one in guest.parts["captions"])

    gamma = float(np.interp(1.5, found.t, found.gamma))
    assert gamma < -1
    guest.wait(lambda _: f"γ = {gamma:.3g}" in told())
    lines = [line["at"][0] for line in guest.charts[SPECTRUM]["lines"] if line["label"]]
    last = Beam(alpha=1, gamma=abs(float(found.gamma[-1])))
    assert lines[0] == pytest.approx(solve(last, coriolis=True).frequencies[0], rel=1e-3)
    assert parse_link(guest.parts["address"]).values["experiment"] == Experiment(**own, until=2.0)
    assert "under a torque of M = −3" in guest.texts["motion-words"]


def test_a_motion_starts_in_modes(guest, session):
    """Of the amplitudes chosen, in place of the force; a link holds them. A pull of the beam in the
    scene is a force again."""
    guest.do("preferences", "still")
    own = {"start": "modes", "B1": 0.05, "B2": 0.02, "until": 2.0}
    guest.do("link", f"?gamma=3&tab=motion&moving=true&motion={inline_toml(own)}")
    guest.wait(lambda _: has_chart(guest, 2.0))
    found = motion(
        Beam(gamma=3),
        2.0,
        start={"B1": 0.05, "B2": 0.02},
        damping=PULLED.damping,
        tolerance=REFERENCE,
    )
    chart = guest.charts[CHART]
    shown = np.interp(found.t, chart["at"], chart["lines"][0]["y"])
    assert np.abs(shown - found.tip[:, 1]).max() < 2 * TOLERANCE
    hidden = {name: guest.props[f"motion.{name}-row"]["hidden"] for name in ("pull", "B1", "B3")}
    assert hidden == {"pull": True, "B1": False, "B3": False}
    guest.do("motion.B3", 0.01)
    guest.wait(lambda _: "B3" in guest.parts["address"])
    assert parse_link(guest.parts["address"]).values["experiment"] == Experiment(**own, B3=0.01)
    assert "swings with 0.05 L in B1 and 0.02 L in B2" in guest.texts["motion-words"]
    with session.visitor.lock:
        state = session.visitor.state
        released = Hold(1.0, 0.1, held=False)
        session.visitor.set_state(state.with_values(MotionState, hold=released))
    guest.wait(lambda _: guest.values["motion.start"] == "pulled")


def test_without_stiffening_there_is_no_start_in_modes(guest):
    """Which the tab says, beside the motion itself."""
    guest.do("tab", "motion")
    guest.do("experiment", "modes")
    guest.do("motion.unstiffened", True)
    guest.wait(lambda _: "no start in modes" in guest.texts["motion-list"])
    assert guest.props[CHART]["hidden"] is False


def test_a_mode_ends_the_motion_in_the_scene(pulled, session):
    """It is drawn then; the motion stays in the tab."""
    assert session.snapshot.film
    pulled.do("only", 0)
    pulled.wait(lambda _: session.snapshot.film is None)
    assert session.snapshot.picture.shown == [0]
    pulled.do("moment", 1.0)
    pulled.wait(lambda _: session.snapshot.film is not None)


def test_times_and_forces_have_the_units_of_a_real_beam(guest):
    """Seconds, newtons, millimetres."""
    guest.do("real.preset", "steel beam")
    guest.do("tab", "motion")
    guest.wait(lambda _: guest.charts[CHART].get("x", {}).get("unit") == "s")
    assert guest.texts["motion.pull-label"].endswith("[N]")
    assert guest.charts[CHART]["y"]["unit"] == "mm"


@pytest.mark.parametrize(
    ("size", "name", "value", "words", "taken"),
    [
        ("", "pull_at", 2.0, r"pull at x / L = 2: must lie in 0\.05 \.\. 1", 1.0),
        ("", "pull_at", 0.0, r"pull at x / L = 0: must lie in 0\.05 \.\. 1", 0.05),  # the clamp
        ("", "until", 1e3, r"length of the motion \[T\*\] = 1000: .* 0\.5 \.\. 60", 60.0),
        ("steel beam", "until", 1e9, r"length of the motion \[s\] = 1e\+09: .* \.\. 8\.03", 8.03),
    ],
)
def test_a_number_of_a_motion_out_of_range_is_told(guest, size, name, value, words, taken):
    """With its limits, in the units of the page; the nearest number is taken."""
    guest.do("link", "?alpha=1")
    if size:
        guest.do("real.preset", size, until=lambda _: "[s]" in guest.texts["motion.until-label"])
    guest.do(f"motion.{name}", value)
    guest.wait(lambda _: any(re.search(words, one["text"]) for one in guest.said))
    guest.wait(lambda _: guest.values[f"motion.{name}"] == pytest.approx(taken, rel=2e-3))
    guest.said.clear()
    guest.do(f"motion.{name}", 1.0)
    catch_up(guest)
    assert not guest.said


def test_a_beam_that_stays_at_rest_is_told_so(guest):
    """Without a force: without a distance that is but rounding."""
    guest.do("link", "?alpha=1&gamma=5&tab=motion&motion={pull=0.0,until=2.0}")
    guest.wait(lambda _: "less than" in guest.texts["motion-list"])
    assert "at most" not in guest.texts["motion-list"]


def test_the_values_of_an_experiment_are_checked():
    """Clamped by a control, refused by a link; caught and dropped are events."""
    assert PULLED.changed("pull", 1e9).pull == 50
    assert PULLED.changed("pull", "much") == PULLED
    assert PULLED.changed("hub", "fast") == PULLED
    assert PULLED.changed("unstiffened", 1) == PULLED
    assert Experiment.of({"body": "caught", "body_at": 2.0}).arguments["catch"] == 2.0
    state = with_experiment(State.of(Scene()), PRESETS["catch"][1])
    assert state.slice(MotionState).in_motion
    assert state.case == Case.of(Scene()).changed("alpha", 1.0)


@pytest.mark.parametrize("kind", [".csv", *slow(".npz", ".svg", ".html")])
def test_the_motion_is_downloaded(pulled, kind):
    """As a file named after it."""
    pulled.do("export_motion", kind)
    pulled.wait(lambda _: f"motion{kind}: done" in str(pulled.said), TIMEOUT)


@pytest.mark.slow
def test_the_beam_is_pulled_by_a_mouse_and_let_go(url, frame_loops):
    """Held where the pointer is, to 0.02 L; then the motion begins with the force that held it."""
    with page(f"{url}/{SHORT}", 1440, 900) as shown:
        shown.wait(READY)
        session = latest(frame_loops)
        shown.send("playing", False)
        shown.send("moment", 0.4)
        wait_until(lambda: session.snapshot.film and session.visitor.clock.moment == 0.4)

        def place(x: float, y: float) -> list[float]:
            return shown.evaluate(f"""(() => {{
              const {{ camera, canvas }} = window.__viserMutable, wheel = {NODES}['/scene/rotor'];
              const place = wheel.position.clone().set({x}, {y}, 0);
              const at = wheel.localToWorld(place).project(camera);
              const r = canvas.getBoundingClientRect();
              return [r.left + r.width * (1 + at.x) / 2, r.top + r.height * (1 - at.y) / 2];
            }})()""")

        shown.catch_up()
        x, y = tip_drawn(session)
        shown.drag(
            shown.at_rest(lambda: place(x - 0.02, y)),
            place(0.93, -0.3),
            taken=lambda: chosen(session).hold,
            arrived=lambda: abs(chosen(session).hold.deflection + 0.3) < 0.02,
        )
        wait_until(lambda: chosen(session).experiment.pull < 0)
        own = chosen(session).experiment
        held = motion(FIRST.beam, 0.1, release=own.pull, release_at=own.pull_at)
        assert own.pull_at == 1.0
        assert held.tip[0, 1] == pytest.approx(-0.3, abs=0.02)
        assert session.visitor.state.view.playing
        shown.wait(f"{by_id('motion.pull-field')}.value === '{own.pull:g}'")


@pytest.mark.slow
def test_the_keyboard_moves_through_the_motion(url):
    """Arrow keys on the line of the chart, and on the slider of the force."""
    with page(f"{url}/{SHORT}", 1440, 900) as shown:
        shown.wait(f"{READY} && !!document.querySelector('#{CHART} .operating:not([hidden])')")
        shown.send("playing", False, until="location.search.includes('moment')")
        line = f"document.querySelector('#{CHART} .operating')"
        before = float(shown.evaluate(f"{line}.ariaValueNow"))
        shown.evaluate(f"{line}.focus()")
        shown.key("ArrowRight", until=f"+{line}.ariaValueNow > {before}")
        slider = by_id("motion.pull-slider")
        shown.evaluate(f"{slider}.focus()")
        shown.key("ArrowRight", until="location.search.includes('pull')")
        assert shown.problems == []
        assert base64.b64decode(shown.call("Page.captureScreenshot")["data"])[:4] == b"\x89PNG"


class Moment(NamedTuple):
    """What a page says at a moment of a motion: in its headline and above the modes; whether these
    are pale; the speed in the scene, whether it has an arrow, and whether that points backwards."""

    title: str
    modes: str
    pale: bool
    speed: str
    arrow: bool
    backward: bool


def at_moment(desk: Desk, moment: float) -> Moment:
    desk.do("moment", moment)
    desk.frame(2)
    guest, around = desk.guest.visitor, desk.session.view.beam.surroundings
    guest.receive()
    title = re.search("<b>(.*?)</b>", guest.texts["equilibrium"])
    below = re.search('note-below"[^>]*>(.*?)</p>', guest.texts["mode-rows"])
    return Moment(
        title[1],
        below[1] if below else "",
        'class="pale"' in guest.texts["mode-rows"],
        around.speed.text,
        around.arrow.visible,
        around.arrow.wxyz[0] == 0,
    )


@pytest.fixture
def moved() -> Callable[..., Desk]:
    """A page with the motion of an experiment of a beam, which stands."""

    def shown(beam: Beam, **experiment: Any) -> Desk:
        desk = Desk(Scene(beam).changed(playing=False))
        desk.do("preferences", "still")
        own = Experiment(**experiment).text
        values = {"gamma": beam.gamma, "alpha": beam.alpha, "tab": "motion", "moving": "true"}
        desk.do("link", f"?{urlencode(values | {'motion': own})}")
        desk.frame(5)
        assert desk.session.snapshot.film
        return desk

    with offline():
        yield shown


AT_3, AT_REST = "Modes at γ = 3: {}the speed now.", "speed γ = 0"


def test_a_hub_that_stops_is_at_rest_in_all_that_the_page_says(moved):
    """Though the numbers of the beam are those of before: the title is that of the motion, the
    modes are said to be of another speed, and no arrow turns."""
    desk = moved(Beam(gamma=3), pull=0.0, hub="stop", until=2.0)
    turning = Moment("The hub stops", AT_3.format(""), False, "speed γ = 3", True, False)
    assert at_moment(desk, 0.0) == turning
    stopped = Moment("The hub has stopped", AT_3.format("not "), True, AT_REST, False, False)
    assert at_moment(desk, 1.0) == stopped
    desk.do("only", 0)
    desk.frame(3)
    desk.guest.visitor.receive()
    assert "Stable equilibrium</b>" in desk.guest.visitor.texts["equilibrium"]
    assert 'class="pale"' not in desk.guest.visitor.texts["mode-rows"]
    around = desk.session.view.beam.surroundings
    assert (around.arrow.visible, around.speed.text) == (True, "speed γ = 3")


def test_a_hub_that_speeds_up_has_the_modes_of_the_table_at_the_end(moved):
    """At rest, on the way, and at its speed."""
    desk = moved(Beam(gamma=3), pull=0.0, hub="linear", within=1.0, until=2.0)
    up, at = "The hub speeds up to γ = 3", "The hub turns at γ = 3"
    assert at_moment(desk, 0.0) == Moment(up, AT_3.format("not "), True, AT_REST, False, False)
    half = Moment(up, AT_3.format("not "), True, "speed γ = 1.5", True, False)
    assert at_moment(desk, 0.5) == half
    assert at_moment(desk, 1.5) == Moment(at, AT_3.format(""), False, "speed γ = 3", True, False)


def test_a_hub_that_turns_back_has_an_arrow_backwards(moved):
    """Under a torque against its rotation: with J = 5 and a beam of 1/3 it loses 3 in about 1.6."""
    desk = moved(Beam(gamma=3), pull=0.0, hub="torque", torque=-10.0, inertia=5.0, until=4.0)
    before, after = at_moment(desk, 0.5), at_moment(desk, 4.0)
    assert (before.arrow, before.backward) == (True, False)
    assert (after.arrow, after.backward, after.pale) == (True, True, True)
    assert float(after.speed.rpartition(" ")[2]) == pytest.approx(3 - 10 / (5 + 1 / 3) * 4, abs=0.5)


@pytest.mark.parametrize(("body", "first"), [("caught", True), ("dropped", False)])
def test_modes_of_another_mass_are_pale(moved, body, first):
    """Those of the table have the mass, also before it is caught and after it is dropped."""
    desk = moved(Beam(alpha=1, gamma=3), body=body, body_at=1.0, until=2.0, damping=0.2)
    words = {False: "Modes with the mass: as now.", True: "Modes with the mass: not as now."}
    for moment, pale in ((0.5, first), (1.5, not first)):
        now = at_moment(desk, moment)
        assert (now.modes, now.pale) == (words[pale], pale)
        assert now.title.startswith("The hub turns at γ = 3")
        assert now.title.endswith("mass off the beam" if pale else "mass on the beam")


def test_a_motion_at_the_speed_of_the_table_is_about_its_equilibrium(moved):
    """Nothing is pale then, and the panel is no longer."""
    desk = moved(Beam(gamma=3), until=1.0)
    for moment in (0.0, 1.0):
        now = at_moment(desk, moment)
        assert now == Moment("The hub turns at γ = 3", "", False, "speed γ = 3", True, False)
    assert "about its stable equilibrium" in desk.guest.visitor.texts["equilibrium"]


@pytest.mark.parametrize(
    ("beam", "experiment"),
    [
        (Beam(gamma=5), {"pull": 0.0, "hub": "stop", "until": 4.0}),
        (Beam(gamma=2), {"pull": 0.0, "hub": "stop", "until": 2.0}),
        (Beam(), {"pull": 1.0, "until": 2.0}),
    ],
)
def test_the_colours_of_a_motion_end_at_its_largest_displacement(moved, beam, experiment):
    """From the unloaded beam, at any point and time: as the motion itself has it, to the two digits
    shown; and at that time the beam has the last colour."""
    desk = moved(beam, **experiment)
    found, x = desk.session.visitor.jobs["motion"].answer.result.motion, np.linspace(0, 1, 101)
    moved_by = np.linalg.norm(found.position(found.t, x) - np.stack([x, 0 * x], 1), axis=2)
    far = moved_by.max()
    desk.guest.visitor.receive()
    told = re.search(r"([\d.]+) L</span>", desk.guest.visitor.texts["legend"])
    assert float(told[1]) == pytest.approx(far, rel=0.05)
    desk.do("moment", float(found.t[moved_by.max(axis=1).argmax()]))
    desk.frame(2)
    last = desk.session.view.beam.beam.batched_colors[-1]
    assert np.abs(last.astype(int) - PALETTES["displacement"][-1]).max() < 12


def test_a_bar_moves_as_the_uniform_beam_that_it_is_in_the_plane():
    """Its stiffness out of the plane has no part in it; it is drawn with its own section."""
    beam = real_beam.STEEL_BEAM.beam
    assert not beam.is_uniform
    with offline():
        desk = Desk(Scene(beam).changed(playing=False))
        desk.do("tab", "motion")
        desk.do("experiment", "pull")
        desk.frame(5)
    own = desk.session.visitor.jobs["motion"].answer.result
    given = {"release": PULLED.pull, "damping": PULLED.damping, "tolerance": REFERENCE}
    uniform = motion(beam.replace(blade=None), own.motion.t[-1], **given)
    shown = np.interp(uniform.t, own.motion.t, own.motion.tip[:, 1])
    assert shown == pytest.approx(uniform.tip[:, 1], abs=2 * TOLERANCE)
    sizes = desk.session.view.beam.beam.batched_scales[0, 1:]
    assert sizes == pytest.approx([0.005, 0.03], rel=1e-6)


@pytest.mark.parametrize("name", ["nrel-5mw-blade", *slow("tapered-steel-blade")])
def test_a_blade_moves_as_its_motion(name):
    """Pulled aside and let go, at its speed; with a force that would fold its soft tip over, a
    smaller one is offered."""
    beam = PRESETS_OF_BLADES[name].beam
    with offline():
        desk = Desk(Scene(beam).changed(playing=False))
        desk.do("tab", "motion")
        desk.do("experiment", "pull")
        desk.frame(5)
        if soft := name == "nrel-5mw-blade":
            desk.guest.visitor.receive()
            words = desk.guest.visitor.texts["motion-words"]
            assert "would fold" in words
            assert 'data-do="motion.less"' in words
            desk.do("motion.less")
            desk.frame(5)
    shown = desk.session.visitor.jobs["motion"].answer.result.motion
    assert shown.beam.blade == beam.blade
    assert shown.error <= TOLERANCE
    assert np.ptp(shown.tip[:, 1]) > 0.05
    if soft:  # stiffened by the rotation, less than without
        assert abs(shown.tip[0, 1]) == pytest.approx(0.068, abs=0.007)
    else:
        options = {"damping": PULLED.damping, "tolerance": REFERENCE}
        own = motion(beam, 4.0, release=PULLED.pull, **options)
        tip = np.interp(own.t, shown.t, shown.tip[:, 1])
        assert tip == pytest.approx(own.tip[:, 1], abs=2 * TOLERANCE)
