"""A second beam beside the first: what it is, its frequencies mode by mode, and how it is drawn."""

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from charts import case
from live.server import TIMEOUT
from live.visitor import PAPER, Visitor, catch_up, pause

from beamviz.beam import Beam
from beamviz.drawing import stacked_heights
from beamviz.drawing.beam_mesh import to_hub_frame
from beamviz.drawing.comparison import number, percent
from beamviz.drawing.modes import displacement
from beamviz.drawing.surroundings import HUB_HEIGHT, MIN_HUB
from beamviz.explorer.features import comparison as comparisons
from beamviz.explorer.features.comparison import ComparisonTab, comparison_table
from beamviz.explorer.second_beam import LABELS, ComparisonCase, comparison_case
from beamviz.explorer.state import COMPARISONS, EARLIER, NO_COMPARISON, State
from beamviz.scene import Scene
from beamviz.solver import solve

PAPER_CASE = case(PAPER)
CORIOLIS_CASE = PAPER_CASE.changed("coriolis", True)
OVERLAY = "/scene/rotor/overlay"


@pytest.mark.parametrize(
    ("choice", "own", "other"),
    [
        ("ancf", PAPER_CASE, PAPER_CASE.changed("method", "ancf")),
        ("ancf", PAPER_CASE.changed("method", "ancf"), PAPER_CASE),
        ("coriolis", PAPER_CASE, CORIOLIS_CASE),
        ("coriolis", CORIOLIS_CASE, PAPER_CASE),
        ("mass", PAPER_CASE, PAPER_CASE.changed("alpha", 2.0)),
        ("effects", CORIOLIS_CASE.changed("softening", False), CORIOLIS_CASE),
        ("effects", CORIOLIS_CASE, "All effects are on already."),
        ("mass", PAPER_CASE.changed("alpha", 0.0), "no mass to double"),
        (EARLIER, PAPER_CASE, "No beam is kept"),
        ("coriolis", PAPER_CASE.changed("plane", "flapwise"), "or both planes"),
    ],
)
def test_each_choice_changes_the_beam_or_explains_why_there_is_no_comparison(choice, own, other):
    """A method or a term that is chosen already is replaced by the other. No choice, no text."""
    title, case, _ = comparison_case(replace(State.of(Scene()), comparison=choice), own)
    assert other in title if isinstance(other, str) else case == other
    assert comparison_case(State.of(Scene()), own) == ComparisonCase()


def rows(html: str) -> list[list[str]]:
    """The cells of a table, without the heads."""
    found = re.findall("<tr.*?</tr>", html.replace("−", "-"))[1:]
    return [re.findall(r"<td>(?:<b>)?(.*?)(?:</b>)?</td>", row) for row in found]


def test_modes_are_matched_when_their_order_changes():
    """alpha = 1 and 2 at the tip: S1 is mode 4, then mode 3. A mode without a match has a dash."""
    one, two = solve(Beam(alpha=1, beta=1)), solve(Beam(alpha=2, beta=1))
    assert (one.labels.index("S1"), two.labels.index("S1")) == (3, 2)
    (cells,) = (row for row in rows(comparison_table(("a", one), ("b", two))) if row[0] == "S1")
    before, after = one.frequencies[3], two.frequencies[2]
    assert cells[1:3] == [number(before), number(after)]
    assert float(cells[3].split()[0]) == pytest.approx(100 * (after / before - 1), abs=0.5)
    html = comparison_table(("a", solve(PAPER)), ("b", solve(PAPER, modes=4)))
    assert [row[2:] == ["–", "–"] for row in rows(html)] == [False] * 4 + [True]


def test_modes_mixed_by_coriolis_forces_are_compared_by_shape():
    """At the veering (gamma 4.65) labels differ: B3 and B4 with, S1 and B3 without Coriolis forces.
    No frequency changes by 2 %, none is missing, and a note names the mixture."""
    beam = Beam(alpha=1, beta=1, gamma=4.65)
    on, off = solve(beam, coriolis=True), solve(beam)
    assert set(on.labels) != set(off.labels)
    html = comparison_table(("this beam", on), ("Coriolis off", off))
    assert [abs(float(row[3].split()[0])) < 2 for row in rows(html)] == 5 * [True]
    assert '<p role="note">In this beam: S1 and B3 mixed 50:50.</p>' in html


@pytest.mark.parametrize("stacked", [False, True])
def test_both_beams_run_on_one_clock(guest, session, stacked):
    """With twice the mass: a mode begins at the phase of its partner, with its own frequency."""
    pause(guest)
    guest.set(stacked=stacked, comparison="mass")
    double = PAPER.replace(alpha=2)
    guest.says(frequency(double))
    catch_up(guest)
    picture, clock, solution = session.snapshot.picture, session.visitor.clock, solve(double)
    main, ours = picture.modes.labels, clock.phases
    assert clock.other_phases == pytest.approx([ours[main.index(one)] for one in solution.labels])
    after = clock.advanced(0.01, picture.modes, picture.second.shapes)
    advanced = (after.other_phases - clock.other_phases - 0.01 * solution.frequencies) % math.tau
    assert np.minimum(advanced, math.tau - advanced).max() < 1e-9
    view = session.view.scene.others[stacked]
    shapes = view.shapes
    moved = displacement(shapes, clock.other_phases, 0.15 * np.eye(5)[1])
    centreline, _ = to_hub_frame(shapes, shapes.centreline + moved)
    if stacked:
        middle = (centreline[:-1] + centreline[1:]) / 2
        assert np.allclose(view.beam.batched_positions, middle, atol=1e-6)
        height = max(picture.heights)
        assert view.frame.position[2] == height == -min(picture.heights)
        assert view.surroundings.floor.visible is False
    else:
        rings = view.body.vertices.reshape(len(shapes.x), 4, 3).mean(axis=1)
        assert np.allclose(rings, centreline, atol=1e-6)
        assert np.allclose(view.bodies.collars.batched_positions, centreline[shapes.mass])
        assert view.surroundings is None  # those of the first beam are there
        assert view.reference is None
    session.view.move(picture, clock.advanced(20.0, picture.modes, picture.second.shapes))
    told = [caption.text for caption in session.view.captions if "period" in caption.text]
    periods = 20 * solution.frequencies[1] / math.tau
    assert len(told) == 2 * stacked
    assert not told or abs(int(re.findall(r"\d+", told[0])[0]) - periods) <= 2


@pytest.mark.parametrize("beam", [PAPER, *(Beam(delta=delta, gamma=1) for delta in (-1, 0, 2))])
def test_each_row_shows_one_mode(guest, session, beam):
    """Five rows instead of one beam, and back; in row k the beam moves as mode k; titles name the
    modes. At the clamp is a small drum: whole hubs above each other would cover the beams."""
    guest.do("load", f"beam.toml\n{Scene.of(beam, all_modes=True, playing=False).to_toml()}")
    guest.shows(beam)
    guest.wait(lambda _: guest.nodes["/mode 5"].get("visible"))
    catch_up(guest)
    assert guest.nodes["/scene"]["visible"] is False
    rows, phases = session.view.scene.rows, session.visitor.clock.phases
    levels = [part.frame.position[2] for part in rows]
    assert levels == stacked_heights(5) == sorted(levels, reverse=True)
    for k, part in enumerate(rows):
        shapes, hub = part.shapes, part.surroundings.hub.vertices
        moved = displacement(shapes, phases, 0.15 * np.eye(5)[k])
        line, _ = to_hub_frame(shapes, shapes.centreline + moved)
        middle = (line[:-1] + line[1:]) / 2
        assert np.allclose(part.beam.batched_positions, middle, atol=1e-6)
        assert part.title.text.startswith(shapes.labels[k])
        assert np.ptp(hub, axis=0) == pytest.approx([2 * MIN_HUB, 2 * MIN_HUB, HUB_HEIGHT])
        centre = beam.delta - (beam.delta != 0) * MIN_HUB
        assert hub.mean(axis=0) == pytest.approx([centre, 0, 0], abs=1e-6)
    guest.do("only", 1, until=lambda _: guest.nodes["/scene"]["visible"])
    assert not any(guest.nodes[f"/mode {k}"]["visible"] for k in range(1, 6))


def frequency(beam: Beam, mode: int = 0, **options: Any) -> str:
    """A frequency as the comparison prints it."""
    return number(solve(beam, **options).frequencies[mode])


def overlay_is(guest: Visitor, *, visible: bool) -> None:
    """Wait until the overlay is visible or hidden."""
    guest.wait(lambda _: guest.nodes[OVERLAY].get("visible") is visible)


def test_an_overlay_is_visible_while_a_slider_moves(guest):
    """The last one is drawn until the next answer; it may be a scene, and ends with the choice."""
    guest.choose("comparison", "coriolis", until=frequency(PAPER, coriolis=True))
    overlay_is(guest, visible=True)
    for gamma in (6.0, 7.0, 8.0):
        guest.choose("gamma", gamma)
        expected = frequency(PAPER.replace(gamma=gamma), coriolis=True)
        while expected not in guest.text:
            guest.receive(TIMEOUT)
            assert guest.nodes[OVERLAY]["visible"]
    guest.choose("stacked", True, until=lambda _: "/other/rotor/beam" in guest.nodes)
    overlay_is(guest, visible=False)
    guest.choose("stacked", False)
    overlay_is(guest, visible=True)
    guest.choose("plane", "flapwise")  # without Coriolis forces
    overlay_is(guest, visible=False)
    guest.choose("comparison", "mass")
    guest.says(frequency(PAPER.replace(alpha=2, gamma=8), plane="flapwise"))
    guest.choose("comparison", "rubber")
    catch_up(guest)
    overlay_is(guest, visible=True)
    assert LABELS.keys() == {*COMPARISONS}
    assert all(f">{name}</button>" in ComparisonTab.tab.content for name in LABELS.values())
    assert guest.values["comparison"] == "mass"
    guest.choose("comparison", NO_COMPARISON)
    overlay_is(guest, visible=False)
    guest.says("shows the effect of one change")


def test_a_comparison_without_a_solution_says_why(guest):
    """Of the beam kept, of this one, or of both: the tab is never empty."""
    guest.do("tab", "compare")
    guest.do("keep", until=">before, ")
    this, kept = "This beam: No equilibrium above", "before: No equilibrium above"
    guest.set(delta=-1.0, gamma=50.0)
    guest.says(this)
    assert kept not in guest.text
    guest.do("keep", until=kept)
    guest.says(this)
    guest.set(gamma=1.0)
    guest.forgets(this)
    guest.says(kept)


def test_a_kept_beam_stays_while_the_other_changes(guest):
    """The button keeps it; the change is relative to it. Another scene ends the comparison."""
    guest.do("keep", until=">before, ")
    guest.edit(gamma=20.0)
    guest.says(frequency(PAPER.replace(gamma=20)))
    guest.says(frequency(PAPER))
    overlay_is(guest, visible=True)
    guest.do("reset")
    overlay_is(guest, visible=False)
    guest.says("shows the effect of one change")


@pytest.mark.parametrize(
    ("edits", "stays"),
    [
        ({"coriolis": True}, False),
        ({"coriolis": True, "comparison": EARLIER}, True),
        ({"keep": None}, True),
        ({"keep": None, "coriolis": True}, True),
    ],
)
def test_going_to_an_event_ends_a_comparison_that_the_visitor_did_not_choose(guest, edits, stays):
    """A switched term keeps the beam before it, which has other numbers than the event."""
    for action, value in edits.items():
        guest.do(action, value)
    guest.wait(lambda _: guest.values["comparison"] == EARLIER)
    overlay_is(guest, visible=True)
    guest.wait(lambda _: "B3 S1 1" in guest.texts.get("loci-events", ""))
    guest.do("go_to_event", "B3 S1 1", until=lambda _: guest.values["share-3"] == 1)
    overlay_is(guest, visible=stays)
    assert (guest.values["comparison"] == EARLIER) is stays
    if not stays:
        guest.do("undo")
        overlay_is(guest, visible=True)
        assert guest.values["comparison"] == EARLIER


@pytest.mark.parametrize(
    ("change", "text"),
    [(230.4, "+230 %"), (-9.14, "−9.1 %"), (0.0123, "+0.012 %"), (np.nan, "–")],
)
def test_a_change_has_two_digits_and_no_exponent(change, text):
    assert percent(change) == text


def test_with_all_modes_the_table_is_there_and_the_scene_says_why_the_second_beam_is_not(guest):
    """It is drawn again when one mode is shown."""
    guest.do("tab", "compare")
    guest.do("all_modes", True)
    guest.do("comparison", "mass", until="twice the mass, ")
    assert len(rows(guest.texts["comparison"])) >= 5
    guest.wait(lambda _: comparisons.ALL_SHOWN in guest.texts["scene-caption"])
    assert comparisons.ALL_SHOWN in guest.texts["comparison"]
    guest.do("only", 0)
    guest.wait(lambda _: comparisons.ALL_SHOWN not in guest.texts["scene-caption"])
    guest.wait(lambda _: guest.nodes[OVERLAY].get("visible"))


def test_a_second_beam_that_is_not_drawn_is_missed_at_once(guest):
    """While all modes are shown the reason stands above the table, where it is seen."""
    guest.choose("comparison", "mass", until="twice the mass, ω")
    guest.choose("all_modes", True)
    guest.wait(lambda _: comparisons.ALL_SHOWN in guest.texts["comparison"])
    text = guest.texts["comparison"]
    assert text.index(comparisons.ALL_SHOWN) < text.index("<table")


def test_without_a_beam_before_the_button_that_keeps_one_is_named(guest):
    """By its own words, wherever it is on a page of this width."""
    guest.do("comparison", "earlier")
    guest.wait(lambda _: "No beam is kept yet" in guest.texts["comparison"])
    (named,) = re.findall("“(.*?)”", guest.texts["comparison"])
    assert f'data-do="keep">{named}<' in ComparisonTab.tab.content
    guest.do("comparison", "nothing")
