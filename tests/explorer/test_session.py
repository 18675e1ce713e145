"""Visitors without a browser: a session of their own each, and the latest edit; lectures."""

import gc
import gzip
import re
import threading
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from live.offline import CLOCK, Client, Desk, Workers, lecture, local, offline
from live.server import (
    CAMERA_MESSAGE,
    frame_loop_at,
    held_back,
    http_get,
    last_until,
    raw_socket,
    wait_until,
)
from live.visitor import BEAM, PAPER, Visitor, frequency_text, pause, visitor

from beamviz.beam import NUMBERS, Beam
from beamviz.drawing.comparison import number
from beamviz.drawing.text import growth, rounded_to_error
from beamviz.explorer import computed_loci, explorer, frame_loop, jobs, page, session
from beamviz.explorer import visitor as visitor_module
from beamviz.explorer.feature import usual_state
from beamviz.explorer.features import files
from beamviz.explorer.features import map as map_tab
from beamviz.explorer.features.lessons import LessonState, begun
from beamviz.explorer.features.mass_drag import DragState
from beamviz.explorer.links import PAGE
from beamviz.explorer.state import RATES, State
from beamviz.lessons import lesson
from beamviz.scene import Scene
from beamviz.server.processes import VisitorCount
from beamviz.solver import solve

STILL = Scene(PAPER).changed(playing=False)


def test_a_visitor_gets_the_table_and_the_scene(guest):
    """The first answer has all five modes of the start beam; each slider has an explanation, of a
    sentence or more without symbols; the caption invites to drag the mass."""
    for mode in range(5):
        assert frequency_text(PAPER, mode) in guest.text
    assert "Stable equilibrium" in guest.text
    assert "Drag the orange ball at the tip" in guest.texts["scene-caption"]
    assert BEAM in guest.nodes
    hints = re.findall("<span popover [^>]*>(.*?)</span>", guest.texts["beam"])
    assert len(hints) == len(NUMBERS)
    assert all(len(hint) > 60 and not set(hint) & set("αβγδμ") for hint in hints)


def test_every_number_and_every_part_of_the_model_can_be_edited(guest):
    """The answers are those of solve; a value beyond the usual range of its slider extends it; a
    removed mass returns with its last alpha; the paper's elements include all terms."""
    guest.edit(gamma=120.0)
    guest.wait(lambda _: guest.props["gamma-slider"]["max"] == 200)
    guest.edit(gamma=10.0, alpha=2.5)
    for mass, alpha in ((False, 0), (True, 2.5)):
        guest.choose("mass", mass)
        guest.shows(PAPER.replace(alpha=alpha))
    for name, value in (("plane", "flapwise"), ("curvature", "material"), ("strain", "hencky")):
        guest.edit(**{name: value})
    guest.set(softening=False, method="ancf")
    guest.says("spin softening off: method ancf takes no switched-off term")


def test_without_a_mass_one_can_be_added():
    """Of alpha 1, as there was none; the caption names what there is to drag then."""
    with local(Scene(Beam(gamma=10))) as guest:
        guest.wait(lambda _: "Drag the orange ball at the tip" in guest.texts["scene-caption"])
        guest.choose("mass", True)
        guest.shows(Beam(alpha=1, gamma=10))


@pytest.mark.parametrize("option", ["softening", "coriolis", "stiffening"])
def test_a_term_is_switched_and_back(guest, option):
    """The frequencies are those of `solve` with that option; the case before is compared with."""
    usual = option != "coriolis"
    if option == "stiffening":  # without it the beam is unstable
        guest.choose(option, False, until="Divergence in bending")
    else:
        guest.edit(**{option: not usual})
    guest.says("before, ω")
    guest.says(number(solve(PAPER).frequencies[0]))
    guest.edit(**{option: usual})


@pytest.mark.parametrize("still", [False, True])
def test_a_change_of_view_is_eased_unless_motion_is_reduced(connected, still):
    """For both beams of a comparison, from the first frame on, also while paused."""
    connected.do("preferences", "still" if still else "")
    connected.set(comparison="mass", stacked=True)
    connected.wait(lambda _: "/other/rotor/beam" in connected.nodes)
    pause(connected)
    places: dict[str, list[float]] = {"/scene": [], "/other": []}
    connected.choose("rotating_frame", False)

    def arrived(messages: list[dict[str, Any]]) -> bool:
        for message in messages:
            if message["type"] == "SetPositionMessage" and message["name"] in places:
                places[message["name"]].append(message["position"][0])
        return all(xs and xs[-1] == 0.0 for xs in places.values())

    connected.wait(arrived)
    for xs in places.values():
        assert (len(xs) == 1) == still
        assert still or (xs[0] < -0.45 and np.diff(xs).max() < 0.2)


@pytest.mark.parametrize(("key", "value"), [("plane", "flapwise"), ("all_modes", True)])
def test_a_view_that_was_turned_is_kept_until_the_beam_would_leave_it(guest, session, key, value):
    """A larger hub, for which a beam fitted into the page is seen from farther away, keeps it."""
    turned = CAMERA_MESSAGE | {"position": (1.0, -2.0, 1.5), "look_at": (0.5, 0.0, 0.0)}
    guest.send(**turned)
    wait_until(lambda: session.snapshot.state.turned)
    placed = guest.camera
    guest.edit(delta=2.0)
    guest.edit(delta=3.0)
    assert guest.camera == placed
    guest.choose(key, value, until=lambda _: guest.camera != placed)


def test_the_documented_stations_of_a_slider_move_exist():
    """By names that exist."""
    stations = re.findall(r"^\d+\. `(\w+)\.?(\w*)`", session.__doc__ or "", re.MULTILINE)
    assert stations
    modules = map(vars, (session, jobs, frame_loop, visitor_module, page))
    known = {name: one for module in modules for name, one in module.items()}
    for owner, name in stations:
        assert hasattr(known[owner], name or "__doc__")


def test_the_page_has_our_elements_around_the_scene(url):
    """Once each, compressed or not; its title is the name of the program."""
    _, _, plain = http_get(url)
    for part in (b'id="root"', b'id="scene"', b"const beamviz =", b"<title>beamviz<"):
        assert plain.count(part) == 1
    _, headers, packed = http_get(url, **{"Accept-Encoding": "gzip"})
    assert headers["Content-Encoding"] == "gzip"
    assert gzip.decompress(packed) == plain


def test_an_edit_during_the_start_of_a_session_is_not_lost(url):
    """A page may send as soon as it has a control."""
    with raw_socket(url) as line:
        guest = Visitor(line)
        guest.set(gamma=21.0, colouring="axial strain")
        guest.shows(PAPER.replace(gamma=21))
        guest.says("axial strain, as drawn")


def test_only_changes_are_sent_and_an_invalid_value_is_corrected(guest):
    """No text for an unchanged number; the control of an invalid choice is reset."""
    guest.wait(lambda _: "loci-chart" in guest.charts)
    pause(guest)
    guest.values.clear()
    guest.do("colouring", "rainbow", until=lambda _: "colouring" in guest.values)
    assert guest.values == {"colouring": "displacement"}
    guest.do("pace", "fast", until=lambda _: "pace" in guest.values)  # also one of another type
    assert guest.values == {"colouring": "displacement", "pace": 1.0}


def test_invalid_actions_are_ignored(guest, caplog):
    """With one line in the log, also texts of more than 1000 characters; the next is handled."""
    texts = ["", "1", "[1]", "[1, 2, 3, 4]", "{}", "[1, {}, 2]", '[1, "nothing", 1]', "[" * 900]
    guest.edit(gamma=11)  # for the first text to be another one
    for k, text in enumerate([*texts, "NaN", f'[1, "gamma", "{"9" * 1001}"]']):
        page.log.reported.clear()
        caplog.clear()
        update = {"value": text}
        guest.send(type="GuiUpdateMessage", uuid=guest.parts["bridge"], updates=update)
        guest.edit(gamma=12 + k)
        assert caplog.text.count("unknown action") == 1, text


def test_a_number_out_of_range_is_named(guest):
    """With value and range; the next valid one is solved. What is no number is refused with a
    message, and a number without bounds is out of range."""
    for k, bad in enumerate((1e9, -1.0, 1e300)):
        shown = page.typeset(f"mass α = {bad:.10g}: must lie in 0 .. 100")
        guest.choose("alpha", bad, until=shown)
        guest.said.clear()
        guest.do("export", ".csv", until=lambda _: guest.said)  # which is refused in the same words
        assert "mass α" in guest.said[0]["text"]
        guest.edit(alpha=2.0 + k)
        guest.says("Stable equilibrium")
    guest.choose("alpha", 200.0, until="mass α = 200: must lie in 0 .. 100")
    guest.choose("delta", 50.0, until="hub δ = 50: must lie in")
    guest.says("mass α = 200: must lie in 0 .. 100")
    guest.choose("delta", 0.0)
    guest.choose("mu", 10.0)
    guest.choose("gamma", 60.0, until="= 6: must be at most 5")
    guest.says("mass α = 200: must lie in 0 .. 100")
    guest.set(mu=70.0, gamma=10.0)
    guest.edit(delta=0.0, alpha=2.0)
    guest.says("Stable equilibrium")
    for bad in ("fast", None, True):
        guest.said.clear()
        guest.do("gamma", bad, until=lambda _: guest.said)
        assert guest.said[0]["error"]
        assert "gamma" in guest.said[0]["text"]
    guest.choose("gamma", 10**40, until="Out of range")
    guest.edit(gamma=12.0)
    guest.wait(lambda _: "Out of range" not in guest.text)


def test_an_unstable_state_is_shown_with_its_growth(guest):
    """An inward beam has buckled: its modes are listed with the rate of the one that grows."""
    guest.edit(alpha=0.0, gamma=5.0)
    guest.choose("delta", -1.0, until="Divergence in bending")
    solution = solve(Beam(beta=0.5, gamma=5, delta=-1))
    fastest = int(solution.growth_rates.argmax())
    rate, error = float(solution.growth_rates[fastest]), float(solution.errors[fastest])
    guest.says(growth(rate, None))
    assert f">{rounded_to_error(rate, error)}<small>growth ±" in guest.texts["mode-rows"]
    post = guest.nodes["/scene/rotor/post"]  # below a drum, not below a ring
    guest.wait(lambda _: not post.get("visible", True))


def test_a_scene_without_equilibrium_shows_the_unloaded_beam_and_no_numbers(frame_loops):
    """The first one, and not the numbers of the scene before, which is another beam."""
    scene, stable = Scene(Beam(gamma=39, delta=1), {"strain": "hencky"}), "Stable equilibrium"
    first = Scene(Beam(mu=10, gamma=20), {"strain": "biot"})
    with explorer(first) as address, visitor(address) as guest:
        guest.says("No equilibrium above γ = 15.708")
        assert stable not in guest.text
        (one,) = frame_loops[-1].sessions.values()
        one.visitor.open(Scene())
        guest.shows(Beam())
        one.visitor.open(scene)
        guest.wait(lambda _: "No equilibrium" in guest.texts["equilibrium"])
        pause(guest)
        assert 'aria-label="modes"' not in guest.text
        assert "No equilibrium" not in str(guest.parts["captions"])  # above the scene once
        assert guest.texts["legend"] == ""  # the beam is grey
        shapes = one.snapshot.picture.modes
        assert shapes.labels == ()
        assert shapes.beam == scene.beam
        assert np.ptp(shapes.centreline[:, 0]) == 1.0
        guest.choose("gamma", 20.0, until=stable)
        guest.shows(Beam(gamma=20, delta=1), strain="hencky")
        guest.wait(lambda _: "displacement" in guest.texts["legend"])
        guest.choose("gamma", 39.0)
        guest.wait(lambda _: "No equilibrium" in guest.texts["equilibrium"])
        guest.forgets(frequency_text(guest.beam, **guest.options))
        assert [one["text"] for one in guest.parts["captions"]] == ["speed γ = 39"]
        guest.set(comparison="effects", time_methods=True)
        guest.do("tab", "methods")
        guest.do("export", ".csv")
        known = "No equilibrium above γ = 31.489"
        for tab in ("comparison", "timings"):
            guest.wait(lambda _, tab=tab: known in guest.texts.get(tab, ""))
        guest.wait(lambda _: guest.said and known in guest.said[-1]["text"])
        assert one.snapshot.picture.modes.beam.gamma == 39


# Lectures: one presents, all see it; each can go exploring and come back

KEY = "the-presenters-key"


@pytest.fixture
def hall(frame_loops) -> Iterator[str]:
    """An explorer in lecture mode."""
    with explorer(Scene(PAPER), presenter_key=KEY) as found:
        yield found


def test_all_visitors_see_the_page_of_the_presenter(hall, frame_loops):
    """Numbers, answers, view, comparison, tab, lesson, clock."""
    with visitor(f"{hall}/?token={KEY}") as lead, visitor(hall) as one, visitor(hall) as other:
        lead.set(gamma=21.0, colouring="axial strain")
        for guest in (one, other):
            guest.shows(PAPER.replace(gamma=21))
            guest.wait(lambda _, guest=guest: guest.values.get("gamma") == 21.0)
            guest.says("axial strain, as drawn")
        lead.do("comparison", "mass")
        lead.do("tab", "compare")
        for guest in (one, other):
            guest.says(">twice the mass, ")
            guest.wait(lambda _, guest=guest: guest.parts.get("open") == "compare")
        sessions = list(frame_loop_at(hall, frame_loops).sessions.values())
        assert len({id(session.visitor.state.view) for session in sessions}) == 1
        for _ in range(3):  # frames of all three, without an edit
            angles = [session.visitor.clock.angle for session in sessions]
            wait_until(lambda last=angles: not {*last} & {s.visitor.clock.angle for s in sessions})
        lead.choose("playing", False)
        wait_until(lambda: not any(session.is_moving for session in sessions))
        wait_until(lambda: len({session.visitor.clock.angle for session in sessions}) == 1)
        lead.do("lesson", "nodes", until=lesson("nodes").question)
        lead.do("lesson_step", 1)
        for guest in (one, other):
            guest.says(lesson("nodes").proof)


def test_the_key_of_visitors_does_not_present(frame_loops):
    """Where both are needed, as on a network: who has the key of visitors follows and is counted;
    the presenter is not, and finds a place in a full hall."""
    keys = {"visitor_key": "that-of-all", "presenter_key": KEY}
    counted = VisitorCount()
    with explorer(Scene(PAPER), visitor_count=counted, max_visitors=1, **keys) as found:
        own = found.partition("/?")[0]
        with visitor(found) as one:
            wait_until(lambda: counted.total == 1)
            with visitor(f"{own}/?token={KEY}") as lead:
                sessions = frame_loop_at(own, frame_loops).sessions
                wait_until(lambda: len(sessions) == 2)
                assert counted.total == 1
                assert [session.visitor.presents for session in sessions.values()] == [False, True]
                lead.do("gamma", 21.0)
                one.wait(lambda _: one.values.get("gamma") == 21.0)
                one.do("gamma", 5.0)  # explores alone
                one.wait(lambda _: one.values.get("gamma") == 5.0)
                lead.do("beta", 0.25, until=lambda _: lead.values.get("beta") == 0.25)
                assert lead.values["gamma"] == 21.0
        wait_until(lambda: counted.total == 0)


def test_no_chart_stays_of_a_visitor_who_follows_a_presenter_without_one(hall, monkeypatch):
    """Neither its lines nor that of the beam; the chart of the presenter comes."""
    release = threading.Event()
    with visitor(hall) as one:
        one.wait(lambda _: one.charts["loci-chart"]["lines"] and one.charts["loci-chart"]["cursor"])
        monkeypatch.setattr(computed_loci, "loci", held_back(computed_loci.loci, release))
        with visitor(f"{hall}/?token={KEY}"):
            try:
                one.wait(lambda _: one.charts["loci-chart"]["lines"] == [])
                one.wait(lambda _: one.charts["loci-chart"]["cursor"] is None)
            finally:
                release.set()
            one.wait(lambda _: one.charts["loci-chart"]["lines"])


@pytest.mark.slow
def test_a_visitor_explores_and_follows_again(hall):
    """From the scene and the lesson of the presenter; no other page changes; a checkbox returns."""
    with visitor(f"{hall}/?token={KEY}") as lead, visitor(hall) as one, visitor(hall) as other:
        lead.do("lesson", "nodes")
        one.says(lesson("nodes").question)
        lead.choose("gamma", 21.0)
        one.shows(PAPER.replace(gamma=21))
        one.edit(alpha=2.0)
        lead.do("lesson", "")
        lead.choose("gamma", 22.0)
        other.shows(PAPER.replace(gamma=22))
        assert lesson("nodes").question in one.text
        assert lesson("nodes").question not in other.text
        own = frequency_text(one.beam)
        assert own in one.text
        assert own not in lead.text + other.text
        one.choose("following", True)
        one.shows(PAPER.replace(gamma=22))


def test_undo_after_the_return_to_a_presenter_shows_the_own_scene_again(hall):
    """As it was when the visitor returned; a second one takes back their last edit of it. Redo
    shows what was seen of the presenter then."""
    with visitor(f"{hall}/?token={KEY}") as lead, visitor(hall) as one:
        one.edit(alpha=2.0)
        one.edit(beta=0.7)
        lead.choose("gamma", 21.0)
        one.choose("following", True)
        one.shows(PAPER.replace(gamma=21))
        own = PAPER.replace(alpha=2)
        for action, beam in (
            ("undo", own.replace(beta=0.7)),
            ("redo", PAPER.replace(gamma=21)),
            ("undo", own.replace(beta=0.7)),
            ("undo", own),
        ):
            one.do(action)
            one.shows(beam)
            one.wait(lambda _: one.values["following"] is False)


def test_a_visitor_cannot_present(hall):
    """Without the presenter's key: another one, though drawn again, stays at the first scene."""
    with visitor(f"{hall}/?token=guessed") as one, visitor(hall) as other:
        one.edit(gamma=21.0)
        other.choose("dark", True, until=lambda _: other.values["dark"] is True)
        assert other.values["gamma"] == PAPER.gamma
        assert "following" in one.values
        assert "You present" not in one.text


def test_a_presenter_may_leave_and_return(hall, frame_loops):
    """Meanwhile the last scene is kept."""
    with visitor(hall) as one:
        with visitor(f"{hall}/?token={KEY}") as lead:
            assert "following" not in lead.values
            lead.says("You present")
            lead.choose("gamma", 21.0)
            one.shows(PAPER.replace(gamma=21))
            lead.choose("playing", False)
        wait_until(lambda: len(frame_loop_at(hall, frame_loops).sessions) == 1)
        assert frequency_text(PAPER.replace(gamma=21)) in one.text
        with visitor(f"{hall}/?token={KEY}") as lead:
            lead.choose("gamma", 5.0)
            one.shows(PAPER.replace(gamma=5))


def test_a_presenter_with_two_pages_may_close_either(hall, frame_loops):
    """The one that was opened last is seen, and after it the other one."""
    with visitor(hall) as one, visitor(f"{hall}/?token={KEY}") as lead:
        with visitor(f"{hall}/?token={KEY}") as second:
            second.choose("gamma", 21.0)
            one.shows(PAPER.replace(gamma=21))
        wait_until(lambda: len(frame_loop_at(hall, frame_loops).sessions) == 2)
        lead.choose("gamma", 5.0)
        one.shows(PAPER.replace(gamma=5))


@pytest.mark.parametrize(
    ("tab", "action", "value", "expected"),
    [
        ("frequencies", "go_to_event", "", {}),
        ("map", "move_beam", "20 2", {"gamma": 20.0, "alpha": 2.0}),
    ],
)
def test_a_visitor_of_a_lecture_clicks_in_what_is_shown(monkeypatch, tab, action, value, expected):
    """In the chart or the map of the presenter; the page has none of its own."""
    monkeypatch.setattr(map_tab, "SIZE", (5, 4))
    with offline():
        lead, one = Desk(STILL), Desk(STILL)
        both = lecture(lead, one)
        lead.do("tab", tab)
        lead.do("delta", 2.0)
        both(10)
        one.guest.visitor.receive()
        if not value:
            mark = one.guest.visitor.charts["loci-chart"]["marks"][0]
            value, expected = mark["value"], {"gamma": mark["x"]}
        one.do(action, value)
        one.frame()
        numbers = one.state.case.numbers
        assert {name: numbers[name] for name in expected} == pytest.approx(expected, rel=1e-5)
        assert not one.state.following


def test_a_visitor_of_a_lecture_sees_their_own_file(monkeypatch):
    """How it goes on, not how that of the presenter does."""
    release = threading.Event()
    monkeypatch.setattr(files, "export", lambda *given: last_until(release))
    with offline():
        lead, one = Desk(STILL), Desk(STILL)
        both = lecture(lead, one)
        for desk, other in ((lead, one), (one, lead)):
            desk.do("export", ".csv")
            wait_until(lambda desk=desk: desk.visitor.jobs["file"].status.note)
            both(2)
            texts = [page.guest.visitor.texts for page in (desk, other) if page.address is not None]
            assert [bool(text["export-state"]) for text in texts] == [True, False]
            desk.do("cancel_export")
            both(2)
    release.set()


def test_a_visitor_of_a_lecture_cannot_cancel_what_the_presenter_computes():
    """They are told how it goes on, and that it was cancelled, without buttons of no effect."""
    with offline():
        lead, one = Desk(STILL), Desk(STILL)
        both = lecture(lead, one)
        lead.do("tab", "map")
        both()
        threads = lead.guest.workers  # which are all at work elsewhere
        threads.chance, threads.run = None, lambda: None
        lead.do("alpha", 3.0)
        for tab in ("map", "frequencies"):
            lead.do("tab", tab)
            both()
            CLOCK.time += 2 * jobs.PATIENCE
            both(2)
            texts = [told(page) for page in (lead, one)]
            assert all("computing" in text for text in texts)
            assert ["Cancel" in text for text in texts] == [True, False]
        lead.do("cancel_jobs")
        both(2)
        texts = [told(page) for page in (lead, one)]
        assert all("cancelled" in text for text in texts)
        assert ["Compute again" in text for text in texts] == [True, False]


def told(desk: Desk) -> str:
    """What a page says of running jobs."""
    assert desk.address is not None
    texts = desk.guest.visitor.texts
    return " ".join(text for id, text in texts.items() if id == "work" or id.endswith("-wait"))


def test_a_reset_is_made_of_the_state_that_it_replaces():
    """As where a lesson is begun meanwhile, on another thread."""
    with offline():
        visitor = Desk(STILL).visitor
        change, nodes = visitor.change, lesson("nodes")

        def late(edit: Any, **options: Any) -> None:
            change(partial(begun, lesson=nodes))
            change(edit, **options)

        visitor.change = late
        visitor.reset()
        assert visitor.state.slice(LessonState).lesson == "nodes"
        assert visitor.state.case.beam == nodes.scene.beam


def test_a_file_is_not_kept_after_it_was_sent(monkeypatch):
    """Films are large."""
    monkeypatch.setattr(files, "export", lambda path, scene: path.write_bytes(b"numbers"))
    with offline():
        desk, sent = Desk(STILL), list[bytes]()
        send = lambda name, content, **options: sent.append(content)  # noqa: E731
        desk.visitor.client.send_file_download = send
        desk.do("alpha", 3.25)
        desk.do("export", ".csv")
        wait_until(lambda: sent)
        desk.frame(3)

        def kept() -> bool:
            gc.collect()
            found = [one for one in gc.get_objects() if isinstance(one, files.File)]
            return any(one.scene.beam.alpha == 3.25 for one in found)

        wait_until(lambda: not kept())


def test_a_beam_as_good_as_at_rest_is_shown():
    """Though nothing of it can be seen to move."""
    with offline():
        desk = Desk(STILL)
        for mode in range(5):
            desk.do(f"share-{mode}", 0.0)
        desk.do("gamma", 5e-324)
        desk.frame(3)
        assert desk.session.snapshot.beam.gamma == 5e-324
        assert desk.session.snapshot.rate < RATES[1]


def test_an_edit_before_a_page_is_ready_is_in_its_address():
    """It is not that of the page without a query."""
    with offline():
        client: Any = Client()
        first = usual_state(STILL, PAGE)
        early = visitor_module.Visitor(client, first, Workers(), schedule=lambda: None)
        early.change(partial(State.changed, name="gamma", value=21.0))
        own = session.Session(early, PAGE)
        early.update(lambda state: replace(state, reserved=()))
        own.tick(2.0)
        assert "gamma=21" in early.page.sent[("address",)]


def test_a_mass_is_let_go_of_beyond_the_tip(guest, session):
    """Taken left of its middle and pulled outward, it stays at the tip."""
    guest.do("preferences", "still")
    guest.edit(beta=1.0)
    start = float(session.view.beam.frame.position[0])
    guest.drag("/scene/rotor/mass", *((start + x, 0.0, 0.0) for x in (0.95, 1.1, 1.2, 1.2)))
    guest.choose("ghosts", False, until=lambda _: not session.visitor.state.view.ghosts)
    wait_until(lambda: session.visitor.state.slice(DragState).grip is None)
    assert session.visitor.state.case.numbers["beta"] == 1.0


def test_both_planes_have_their_modes_on_the_page(guest):
    """Flap and lag by name, without an error, and the page says where a pitch has no effect."""
    guest.edit(plane="both", flap=0.1, pitch=30.0)
    guest.do("gamma", 5.0, until="1st flap")
    assert guest.texts["section-note"] == ""
    guest.do("flap", 1.0, until=lambda _: "no effect" in guest.texts["section-note"])


def test_a_turned_section_in_a_single_plane_leads_to_both(guest):
    """The reason, a button, and the sliders that may turn it back."""
    guest.edit(plane="both", flap=0.1, pitch=30.0)
    guest.do("plane", "chordwise", until="a turned section couples bending")
    assert 'data-set="plane"' in guest.texts["equilibrium"]
    assert [guest.props[f"{name}-row"]["hidden"] for name in ("flap", "pitch", "twist")] == [
        *(False, False, True)
    ]
    guest.do("pitch", 0.0, until="1st bending")
