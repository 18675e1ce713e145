"""The tab Adjust: measured frequencies, targets and per-rev lines move the beam."""

import pytest
from live.visitor import PAPER

from beamviz.explorer.features.adjust import AdjustState
from beamviz.solver import solve

GAMMAS = (0.0, 4.0, 8.0)


def measured(alpha: float, beta: float, error: float = 0.01) -> str:
    """The two lowest frequencies of the beam with another mass at some speeds."""
    lines = ["gamma, mode, frequency, error"]
    for gamma in GAMMAS:
        solution = solve(PAPER.replace(alpha=alpha, beta=beta, gamma=gamma))
        for label, frequency in list(zip(solution.labels, solution.frequencies, strict=True))[:2]:
            lines.append(f"{gamma}, {label}, {frequency:.9g}, {error}")
    return "\n".join(lines)


def outcome_of(session):
    return session.visitor.state.slice(AdjustState).outcome


def test_a_fit_moves_the_scene_in_one_step_to_undo(guest, session):
    """The mass that was measured is found, told with its deviation, and undone at once."""
    guest.do("tab", "adjust")
    guest.do("adjust.measured", measured(0.7, 0.6))
    guest.do("adjust.run", until=lambda _: outcome_of(session))
    numbers = session.visitor.state.case.numbers
    assert numbers["alpha"] == pytest.approx(0.7, rel=1e-4)
    assert numbers["beta"] == pytest.approx(0.6, rel=1e-4)
    guest.wait(lambda _: "residuals" in guest.texts["adjust-answer"])
    assert "±" in guest.texts["adjust-answer"]
    guest.do("undo")
    assert session.visitor.state.case.beam == PAPER
    assert session.visitor.state.slice(AdjustState).measured


def test_what_is_typed_wrong_is_told_beside_the_field(guest, session):
    """And nothing is computed; right again, the text is gone."""
    guest.do("tab", "adjust")
    guest.do("adjust.measured", "gamma, frequency\n1, high")
    guest.wait(lambda _: "high" in guest.texts["adjust-wrong"])
    guest.do("adjust.run")
    assert outcome_of(session) is None
    guest.do("adjust.measured", measured(1.0, 0.5))
    guest.wait(lambda _: not guest.texts["adjust-wrong"])


def test_one_frequency_does_not_determine_two_numbers(guest, session):
    guest.do("tab", "adjust")
    guest.do("adjust.measured", "frequency, error\n3.0, 0.01")
    guest.do("adjust.run", until=lambda _: outcome_of(session))
    guest.wait(lambda _: "do not determine" in guest.texts["adjust-answer"])


def test_targets_that_no_beam_meets_leave_the_scene(guest, session):
    guest.do("tab", "adjust")
    guest.do("goal", "targets")
    guest.do("adjust.targets", "B1=500")
    guest.do("adjust.run", until=lambda _: outcome_of(session))
    assert session.visitor.state.case.beam == PAPER
    guest.wait(lambda _: "no beam in the bounds" in guest.texts["adjust-answer"])


def test_the_tab_tells_what_moves_the_mode_shown(guest, session):
    guest.do("tab", "adjust")
    guest.wait(lambda _: "adjust-bar" in guest.texts["adjust-effects"])


def test_the_chart_shows_the_measured_points(guest):
    """At their speeds, with a bar of one standard deviation to both sides; over another number at
    that of the beam."""
    guest.do("adjust.measured", measured(0.7, 0.6, error=0.5))

    def points() -> list:
        marks = guest.charts["loci-chart"].get("marks", [])
        return [mark for mark in marks if mark["kind"] == "measured"]

    guest.wait(lambda _: len(points()) == 2 * len(GAMMAS))
    lines = guest.charts["loci-chart"]["lines"]
    bars = [line for line in lines if line["runs"][0][2] == "measured"]
    assert [bar["at"][0] for bar in bars] == [mark["x"] for mark in points()]
    assert [bar["y"][1] - bar["y"][0] for bar in bars] == pytest.approx([1.0] * len(bars))
    guest.do("over", "alpha")
    guest.wait(lambda _: {mark["x"] for mark in points()} == {PAPER.alpha})
    guest.do("adjust.measured", "frequency\nfast")
    guest.wait(lambda _: not points())
