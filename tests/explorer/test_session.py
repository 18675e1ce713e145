"""Visitors without a browser: a session of their own each, and the latest edit."""

import gzip
import re
import threading
from typing import Any

import numpy as np
import pytest
from live.server import http_get
from live.visitor import BEAM, PAPER, beam_moved, frequency_text, pause, visitor

from beamviz import explorer as server
from beamviz.beam import NUMBERS, Beam
from beamviz.explorer import explorer, jobs, page, session
from beamviz.explorer import visitor as visitor_module
from beamviz.explorer.features.comparison import number
from beamviz.scene import Scene
from beamviz.solver import solve

# Each visitor has a session of their own


def test_a_visitor_gets_the_table_and_the_scene(guest):
    """The first answer has all five modes of the start beam; each slider has an explanation, of a
    sentence or more without symbols."""
    for mode in range(5):
        assert frequency_text(PAPER, mode) in guest.text
    assert "Stable equilibrium" in guest.text
    assert BEAM in guest.nodes
    hints = re.findall("<span popover [^>]*>(.*?)</span>", guest.texts["beam"])
    assert len(hints) == len(NUMBERS)
    for hint in hints:
        assert len(hint) > 60
        assert not set(hint) & set("αβγδμ")


def test_a_field_extends_the_range_of_its_slider(guest):
    """A value beyond the usual range is solved, and the slider gets the full range."""
    guest.choose("gamma", 120.0)
    guest.wait(lambda _: guest.props["gamma-slider"]["max"] == 200)
    guest.says(frequency_text(PAPER.replace(gamma=120)))
    guest.choose("alpha", 2.5)
    guest.says(frequency_text(PAPER.replace(gamma=120, alpha=2.5)))


@pytest.mark.parametrize("still", [False, True])
def test_a_change_of_view_is_eased_unless_motion_is_reduced(guest, still):
    """For both beams of a comparison, from the first frame on, also while paused."""
    guest.do("preferences", "still" if still else "")
    guest.choose("comparison", "mass")
    guest.do("stacked", True)
    guest.wait(lambda _: "/other/rotor/beam/16" in guest.nodes)
    pause(guest)
    places: dict[str, list[float]] = {"/scene": [], "/other": []}
    guest.choose("rotating_frame", False)

    def arrived(messages: list[dict[str, Any]]) -> bool:
        for message in messages:
            if message["type"] == "SetPositionMessage" and message["name"] in places:
                places[message["name"]].append(message["position"][0])
        return all(xs and xs[-1] == 0.0 for xs in places.values())

    guest.wait(arrived)
    for xs in places.values():
        assert (len(xs) == 1) == still
        assert still or (xs[0] < -0.45 and np.diff(xs).max() < 0.2)


def test_every_part_of_the_model_can_be_chosen(guest):
    """The answers for plane, strain law and curvature are those of solve."""
    chosen: dict[str, str] = {}
    for name, value in (("plane", "flapwise"), ("curvature", "material"), ("strain", "hencky")):
        guest.choose(name, value)
        chosen[name] = value
        guest.says(frequency_text(PAPER, **chosen))


def test_moving_a_slider_starts_no_thread(guest, monkeypatch):
    """100 moves, each drawn."""
    started: list[threading.Thread] = []
    start = threading.Thread.start
    pause(guest)
    monkeypatch.setattr(threading.Thread, "start", lambda one: (started.append(one), start(one)))
    for k in range(100):
        guest.choose("gamma", 11.0 + 0.1 * k)
        guest.wait(beam_moved)
    assert started == []


def test_the_documented_stations_of_a_slider_move_exist():
    """At most eight, by names that exist."""
    stations = re.findall(r"^\d+\. `(\w+)\.?(\w*)`", session.__doc__ or "", re.MULTILINE)
    assert 5 <= len(stations) <= 8
    modules = (session, jobs, server, visitor_module, page)
    for owner, name in stations:
        found = [getattr(module, owner) for module in modules if hasattr(module, owner)]
        assert found
        assert not name or hasattr(found[0], name)


# Messages between the page and the server


def test_the_page_has_our_elements_around_the_scene(url):
    """Once each, compressed or not; its title is the name of the program."""
    _, _, plain = http_get(url)
    for part in (b'id="root"', b'id="scene"', b"const beamviz =", b"<title>beamviz<"):
        assert plain.count(part) == 1
    _, headers, packed = http_get(url, **{"Accept-Encoding": "gzip"})
    assert headers["Content-Encoding"] == "gzip"
    assert gzip.decompress(packed) == plain


def test_invalid_actions_are_ignored(guest, caplog):
    """With one line in the log, also texts of more than 1000 characters; the next is handled."""
    texts = ["", "1", "[1]", "[1, 2, 3, 4]", "{}", "[1, {}, 2]", '[1, "nothing", 1]', "[" * 900]
    guest.do("gamma", 11)
    for k, text in enumerate([*texts, "NaN", f'[1, "gamma", "{"9" * 1001}"]']):
        page.log.reported.clear()
        caplog.clear()
        update = {"value": text}
        guest.send(type="GuiUpdateMessage", uuid=guest.parts["bridge"], updates=update)
        guest.do("gamma", 12 + k)
        guest.says(frequency_text(PAPER.replace(gamma=12 + k)))
        assert caplog.text.count("unknown action") == 1, text


def test_only_changes_are_sent_and_an_invalid_value_is_corrected(guest):
    """No text for an unchanged number; the control of an invalid choice is reset."""
    guest.wait(lambda _: "loci-chart" in guest.charts)
    pause(guest)
    guest.values.clear()
    guest.do("playing", "no")
    guest.wait(lambda _: "playing" in guest.values)
    assert guest.values == {"playing": True}


# Switches for the terms of the equations


@pytest.mark.parametrize("option", ["softening", "coriolis", "stiffening"])
def test_a_term_is_switched_and_back(guest, option):
    """The frequencies are those of `solve` with that option; the case before is compared with."""
    usual = option != "coriolis"
    guest.choose(option, not usual)
    if option == "stiffening":  # without it the beam is unstable
        guest.says("Unstable in bending")
        assert guest.props["playing"]["disabled"]  # nothing moves
    else:
        guest.says(frequency_text(PAPER, **{option: not usual}))
    guest.says("before, ω")
    guest.says(number(solve(PAPER).frequencies[0]))
    guest.choose(option, usual)
    guest.says(frequency_text(PAPER))


def test_the_mass_is_removed_and_restored(url):
    """alpha is 0 without it, then its last value, or 1 if it had none; the switch shows it."""
    with visitor(url) as guest:
        guest.choose("alpha", 2.5)
        guest.says(frequency_text(PAPER.replace(alpha=2.5)))
        guest.choose("mass", False)
        guest.says(frequency_text(PAPER.replace(alpha=0)))
        guest.choose("mass", True)
        guest.says(frequency_text(PAPER.replace(alpha=2.5)))
    with explorer(Scene(Beam(gamma=10))) as address, visitor(address) as guest:
        guest.choose("mass", True)
        guest.says(frequency_text(Beam(alpha=1, gamma=10)))


def test_a_method_without_switches_names_those_with_them(guest):
    """The paper's elements include all terms."""
    guest.choose("softening", False)
    guest.choose("method", "ancf")
    guest.says("softening = False: method ancf takes no switched-off term")


@pytest.mark.parametrize(
    ("beam", "words"), [(PAPER, "Drag the mass along"), (Beam(), "Drag the line of the speed")]
)
def test_the_page_invites_to_drag_what_there_is(beam, words):
    """The mass, if the beam has one."""
    with explorer(Scene(beam)) as url, visitor(url) as guest:
        guest.wait(lambda _: words in guest.texts["scene-caption"])


# Scenes without an equilibrium


def test_a_scene_without_equilibrium_shows_the_unloaded_beam_and_no_numbers(frame_loops):
    """Not those of the scene before, which is another beam."""
    scene = Scene(Beam(gamma=39, delta=1), {"strain": "hencky"})
    with explorer(Scene()) as address, visitor(address) as guest:
        guest.says(frequency_text(Beam()))
        (one,) = frame_loops[-1].sessions.values()
        one.visitor.load(scene)
        guest.says("No equilibrium")
        pause(guest)
        assert 'aria-label="modes"' not in guest.text
        assert "No equilibrium" not in str(guest.parts["captions"])  # above the scene once
        assert guest.texts["legend"] == ""  # the beam is grey
        assert one.view.shapes.labels == ()
        assert one.view.shapes.beam == scene.beam
        assert np.ptp(one.view.shapes.centreline[:, 0]) == 1.0
        guest.choose("gamma", 20.0)
        guest.says("Stable equilibrium")
        stable = frequency_text(Beam(gamma=20, delta=1), strain="hencky")
        guest.says(stable)
        guest.wait(lambda _: "displacement" in guest.texts["legend"])
        guest.choose("gamma", 39.0)
        guest.says("No equilibrium")
        pause(guest)
        assert stable in guest.text  # the last answer of this scene
        assert guest.props["mode-rows"]["class"] == "faded"
        assert guest.parts["captions"] == []  # neither its speed nor the reason, which is above
        guest.choose("comparison", "effects")
        guest.do("tab", "methods")
        guest.do("time_methods", True)
        guest.do("export", ".csv")
        known = "No equilibrium above γ = 31.49"
        for tab in ("comparison", "timings"):
            guest.wait(lambda _, tab=tab: known in guest.texts.get(tab, ""))
        guest.wait(lambda _: guest.said and known in guest.said[-1]["text"])
        assert one.view.shapes.beam.gamma == 20
