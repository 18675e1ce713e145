"""The page shows what its numbers say: defects that it had once, each kind with a test."""

import re

import numpy as np
import pytest
from live.offline import Desk, offline
from live.server import wait_until
from live.visitor import Visitor, catch_up, frequency_text, pause, visitor

from beamviz.beam import Beam
from beamviz.explorer import explorer
from beamviz.explorer.clock import Clock
from beamviz.explorer.features import files, veering
from beamviz.explorer.features.lessons import formatted, lesson_rate
from beamviz.explorer.features.method_timing import time_method
from beamviz.lessons import LESSONS, lesson
from beamviz.scene import START, Scene
from beamviz.solver import solve

FIRST = START
INWARD = START.beam.replace(delta=-1)


def points(guest: Visitor) -> np.ndarray:
    """Positions (n, 3) of the pieces of the beam."""
    return np.reshape(guest.nodes["/scene/rotor/beam"]["batched_positions"], (-1, 3))


def test_an_unstable_beam_is_drawn_with_its_own_numbers_and_grows(guest):
    """Hub -1 on the start page: the beam points inward. Its bending grows from nearly nothing, and
    by far more than the stable modes swing; choosing a stable mode says that another one grows."""
    guest.choose("delta", -1.0, until="Divergence in bending")
    guest.do("only", 0)
    sizes: list[float] = []
    for _ in range(100):
        guest.receive()
        sizes.append(float(np.abs(points(guest)[:, 1]).max()))
    steps = np.diff(sizes)
    assert max(sizes) > 10 * min(sizes)
    assert (steps > 1e-4).sum() > 4 * (steps < -1e-4).sum()  # it falls only where it begins again
    assert points(guest)[0, 0] < -0.9
    assert points(guest)[-1, 0] > -0.2
    assert "displacement" in guest.texts["legend"]  # and is not grey
    guest.do("only", 3, until=lambda _: "another one does" in guest.texts["scene-caption"])
    (growing,) = re.findall(r'data-do="only" data-value="(\d+)"', guest.texts["scene-caption"])
    guest.do("only", int(growing), until=lambda _: "another" not in guest.texts["scene-caption"])


def test_reduced_motion_shows_the_growth_as_a_still(guest):
    """At its full size, and it stays."""
    guest.do("preferences", "still")
    guest.choose("delta", -1.0, until="Divergence in bending")
    guest.do("only", 0)
    pause(guest)
    still = points(guest)
    assert np.abs(still[:, 1]).max() == pytest.approx(0.15, rel=0.05)
    guest.choose("ghosts", False)
    pause(guest)
    assert np.array_equal(points(guest), still)


@pytest.mark.parametrize("beam", [START.beam, INWARD], ids=["stable", "unstable"])
def test_a_still_is_at_its_full_size_though_the_page_has_moved_before(beam):
    """Until the preference of a visitor who has opened a link arrives."""
    with offline():
        desk = Desk(Scene.of(beam, mode=1).changed(playing=False))

        def clock() -> Clock:
            return desk.session.snapshot.clock

        full = clock()
        desk.do("playing", True)
        for _ in range(500):
            desk.frame()
            if abs(np.sin(clock().phases[0])) < 0.5 or clock().grown < full.grown / 2:
                break
        else:
            raise AssertionError("it has not moved")
        desk.do("preferences", "still")
        desk.frame(2)
        assert np.array_equal(clock().phases, full.phases)
        assert clock().grown == full.grown


def test_a_stable_motion_out_of_plane_hides_no_buckling_in_the_plane():
    """Of a straight beam: the status says so."""
    beam, options = Beam(delta=-1, gamma=3.1), {"plane": "flapwise"}
    equilibrium = solve(beam, **options).equilibrium
    assert equilibrium.stable
    assert equilibrium.buckled_chordwise
    with explorer(Scene(beam, options)) as url, visitor(url) as guest:
        guest.says("Stable out of plane only")
        assert 'class="state bad"' in guest.texts["equilibrium"]


def test_what_is_drawn_without_an_answer_is_said(guest):
    """The nearest values of numbers out of range; the unloaded beam without an equilibrium."""
    guest.choose("alpha", 1e9, until="Drawn with the nearest values in range: α = 100, β = 0.5")
    guest.set(alpha=1.0, strain="biot", mu=10.0, gamma=20.0)
    guest.says("Drawn unloaded")


def test_a_chart_is_that_of_the_beam_that_is_drawn(guest):
    """Of the nearest values, where a number is out of range."""
    heaviest = solve(Beam(alpha=100, beta=0.5)).frequencies[0]
    guest.choose("alpha", 1e9, until="Drawn with the nearest values in range")

    def is_that_of_the_heaviest(_: object) -> bool:
        lines = guest.charts["loci-chart"].get("lines")
        return bool(lines) and lines[0]["y"][0] == pytest.approx(heaviest, rel=1e-4)

    guest.wait(is_that_of_the_heaviest)


def test_in_lesson_1_a_faster_vibration_looks_faster(guest):
    """The time that passes in a second does not change while the speed does, unless unlocked."""
    name = "stiffening"
    guest.do("lesson", name, until=formatted(lesson(name).question))
    guest.wait(lambda _: "locked" in guest.texts["pace-text"])
    shown = guest.texts["pace-text"]
    assert f"= {lesson_rate(name):.2g} T*" in shown
    for gamma in (5.0, 9.0, 10.0, 40.0):
        guest.choose("gamma", gamma)
        guest.shows(Beam(gamma=gamma), plane="flapwise")
        assert guest.texts["pace-text"] == shown
    guest.do("rate", None, until=lambda _: guest.texts["pace-text"] != shown)
    guest.wait(lambda _: ">lock<" in guest.texts["pace-text"])
    guest.do("rate", 0.125, until=lambda _: "= 0.12 T*" in guest.texts["pace-text"])
    guest.do("rate", "fast")
    guest.edit(gamma=6.0)
    assert "= 0.12 T*" in guest.texts["pace-text"]


def test_all_modes_have_the_scale_of_one(guest):
    """In rows each mode has the full amplitude, and the legend says so; it names the path."""
    guest.wait(lambda _: "0.3 L" in guest.texts["legend"])  # two modes at once
    assert "path" not in guest.texts["legend"]
    guest.choose("tip_path", True, until=lambda _: "path" in guest.texts["legend"])
    guest.choose("all_modes", True, until=lambda _: "0.15 L" in guest.texts["legend"])


def test_several_colour_maps_are_told_from_the_least_to_the_largest():
    """Each mode in its row has its own in strain, as bending hardly has any; in displacement all
    have the same, which is told as one."""
    with offline():
        desk = Desk(Scene.of(Beam(gamma=1), all_modes=True, playing=False))
        guest = desk.guest.visitor
        guest.receive()
        assert "of each beam" not in guest.texts["legend"]
        assert "0.15 L" in guest.texts["legend"]
        desk.do("colouring", "axial strain")
        desk.frame(2)
        guest.receive()
        rows = [row.drawn.largest for row in desk.session.view.scene.rows]
        least, largest = min(rows), max(rows)
        assert largest > 10 * least
        told = re.search(r"0, at the ends ([\d.e×⁻\d -]+?) \.\. ([\d.]+)<", guest.texts["legend"])
        assert "of each beam" in guest.texts["legend"]
        assert float(told[2]) == pytest.approx(largest, rel=0.05)
        assert float(told[1]) == pytest.approx(least, rel=0.05)


def test_a_slider_has_its_usual_range_again(guest):
    """After a value far beyond it."""
    guest.choose("alpha", 1e9, until=lambda _: guest.props["alpha-slider"]["max"] == 100)
    guest.choose("alpha", 1.0, until=lambda _: guest.props["alpha-slider"]["max"] == 5)


def test_a_format_that_cannot_be_written_is_not_offered(monkeypatch):
    """MP4 without PyAV: the button is disabled and says why."""
    monkeypatch.setattr(files, "find_spec", lambda name: None)
    button = re.search(r'<button[^>]*data-value="&quot;.mp4&quot;"[^>]*>', files.export_tab())
    assert " disabled" in button[0]
    assert "Needs the package PyAV" in files.export_tab()
    monkeypatch.setattr(files, "find_spec", lambda name: name)
    assert " disabled" not in files.export_tab()


def test_an_event_is_shown_in_its_two_modes(guest):
    """Going to the crossing of S1 and B3 superimposes these, and no others."""
    guest.wait(lambda _: "B3 S1 1" in guest.texts.get("loci-events", ""))
    guest.do("go_to_event", "B3 S1 1", until=lambda _: guest.values["share-3"] == 1)
    assert [guest.values[f"share-{k}"] for k in range(5)] == [0, 0, 1, 1, 0]


def test_a_stranger_is_told_what_this_is_and_where_to_begin(guest):
    """On the first screen, until the first edit; the button begins lesson 1."""
    caption = guest.texts["scene-caption"]
    assert "A beam on a turning hub, with a mass on it" in re.sub("<.*?>", "", caption)
    assert re.search(r'data-do="lesson" data-value="&quot;stiffening&quot;"', caption)
    assert "1st bending" in guest.texts["mode-rows"]
    guest.edit(gamma=6.0)
    guest.wait(lambda _: guest.texts["scene-caption"] == "")


# Lessons: predict first


@pytest.mark.parametrize("one", LESSONS, ids=lambda one: one.name)
def test_every_lesson_has_guesses_and_begins_unsolved(one):
    """One of them is right; the first scene does not meet the challenge."""
    assert 2 <= len({*one.guesses}) == len(one.guesses) <= 4
    assert one.right in range(len(one.guesses))
    assert not one.check(one.scene.beam, one.scene.options).met


def test_a_lesson_asks_before_it_tells(guest):
    """What to do and to look for come after a guess, the judgement with the reason."""
    one = lesson("nodes")
    guest.do("lesson", one.name, until=formatted(one.question))
    assert formatted(one.see) not in guest.text
    for number, words in ((0, "not what you expected"), (one.right, "as you expected")):
        guest.do("lesson_step", 0)
        guest.do("lesson_guess", number, until=formatted(one.see))
        assert guest.parts["point"] == ["beta", "alpha"]
        guest.do("lesson_step", 1, until=words)
    for wrong in (7, -1, "most", None):
        guest.do("lesson_guess", wrong)
    guest.do("lesson_step", 0, until=formatted(one.see))


def test_a_challenge_begins_unsolved_and_a_lesson_that_is_met_is_remembered(guest):
    """Also if the experiment ended at its answer; the browser keeps the names of those met."""
    one = lesson("crossing")
    guest.do("lesson", one.name, until=formatted(one.question))
    guest.edit(alpha=1.0, beta=1.0, gamma=one.answer)
    guest.do("lesson_step", 2, until="Not yet.")
    guest.shows(one.scene.beam)
    guest.choose("gamma", one.answer, until="Right!")
    guest.wait(lambda _: guest.parts["met"] == [one.name])
    guest.do("lesson_step", 0)
    guest.do("lesson_step", 2)
    guest.do("met", "nodes nonsense", until=lambda _: guest.parts["met"] == ["crossing", "nodes"])
    guest.forgets(frequency_text(one.scene.beam.replace(gamma=one.answer)))


def test_the_table_has_the_modes_of_the_address(guest):
    """More than usual where a link shows a higher one, and as many after a lower one is chosen."""
    rows = 'data-row="'
    for action, value, count in (("link", "?mode=8", 8), ("only", 1, 8), ("link", "?mode=2", 5)):
        guest.do(action, value)
        catch_up(guest)  # a mode that is chosen leaves the number of rows
        guest.wait(lambda _, count=count: guest.texts["mode-rows"].count(rows) == count)
        shown = guest.texts["mode-rows"].count("class=shown")
        assert shown == 1
    guest.do("link", "?shares=[0,1,0,0,0,0,0,0]")
    guest.wait(lambda _: guest.texts["mode-rows"].count(rows) == 8)


def test_the_tab_veering_says_why_it_shows_nothing(guest):
    """Where the model has no solution, instead of the veering of the model before."""
    guest.do("tab", "veering")
    guest.says("they cross at")
    for key, value in (("coriolis", False), ("method", "zoac"), ("state", "stable")):
        guest.choose(key, value)
    guest.wait(lambda _: "no bent states" in guest.texts["veering-shapes"])
    guest.wait(lambda _: guest.props["veering-chart"]["hidden"])


def test_the_tab_veering_belongs_to_the_beam_that_is_drawn(guest, session):
    """Of the nearest values, where a number is out of range, as in a tab that is opened then."""
    guest.do("tab", "veering")
    guest.says("they cross at")
    before, job = guest.texts["veering-shapes"], session.visitor.jobs[veering.JOB]
    guest.choose("alpha", 1000.0, until="Drawn with the nearest values in range: α = 100")
    wait_until(lambda: job.answer.request.beam.alpha == 100)
    pause(guest)
    assert guest.texts["veering-shapes"] != before
    assert not guest.props["veering-shapes"]["data-outdated"]
    assert guest.charts["veering-chart"]["cursor"] is None
    shown = guest.texts["veering-shapes"]
    guest.do("tab", "frequencies", until=lambda _: guest.texts["veering-shapes"] == "")
    assert guest.props["veering-chart"]["hidden"]
    guest.do("tab", "veering", until=lambda _: guest.texts["veering-shapes"] == shown)


def test_a_limit_of_the_speed_has_the_same_digits_everywhere(guest):
    """Those of the scene: in the charts, of which one over the mass begins without one, in the tabs
    and in what is said of a file."""
    told = "No equilibrium above γ = 31.300 with this material law"
    guest.do("link", "?gamma=60&alpha=1&beta=0.5&strain=hencky&over=alpha&methods=true", told)
    unloaded = "No equilibrium above γ = 45.420 with this material law, at α = 0"
    guest.wait(lambda _: guest.charts["loci-chart"]["message"] == unloaded)
    assert unloaded in guest.texts["loci-events"]
    for tab, text, words in (
        ("veering", "veering-shapes", unloaded),
        ("loads", "loads-text", told),
        ("motion", "motion-words", told),
        ("methods", "timings", told),
    ):
        guest.do("tab", tab)
        guest.wait(lambda _, text=text, words=words: words in guest.texts[text])
    guest.do("export", ".csv")
    guest.wait(lambda _: [one for one in guest.said if told in one["text"]])


def test_a_method_without_an_equilibrium_says_its_limit_as_the_scene_does():
    """In the words of the page."""
    fast = Beam(gamma=60)
    timing = time_method(solve(fast), "tolerance", 1e-4, {"method": "auto", "strain": "hencky"})
    assert timing.reason == "No equilibrium above γ = 45.420 with this material law"
