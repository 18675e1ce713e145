"""The tab Adjust: measured frequencies, targets and per-rev lines move the beam."""

import numpy as np
import pytest
from live.visitor import PAPER

from beamviz.adjusting.fit import compared
from beamviz.explorer.features.adjust import AdjustState
from beamviz.measured import columns_of_text, measured_frequencies
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
    guest.wait(lambda _: "residuals" in guest.texts["adjust-matches"])
    assert "±" in guest.texts["adjust-answer"]
    assert "poor fit" not in guest.texts["adjust-answer"]
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


def test_a_poor_fit_is_told(guest, session):
    """Flapwise frequencies, of a beam that bends in the plane of rotation."""
    guest.do("tab", "adjust")
    guest.do("adjust.free.beta", False)
    guest.do("adjust.measured", "gamma, frequency\n0, 3.4\n10, 11.2")
    guest.do("adjust.run", until=lambda _: outcome_of(session))
    guest.wait(lambda _: "poor fit" in guest.texts["adjust-answer"])


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


def shown(guest, kind: str) -> list:
    """The marks of a kind in the chart of the tab Frequencies."""
    return [mark for mark in guest.charts["loci-chart"].get("marks", []) if mark["kind"] == kind]


def lines_of(guest, style: str, chart: str = "loci-chart") -> list:
    lines = guest.charts.get(chart, {}).get("lines", [])
    return [line for line in lines if line["runs"][0][2] == style]


def test_the_chart_shows_the_measured_points(guest):
    """At their speeds, with a bar of one standard deviation to both sides; over another number
    only those at the speed of the beam."""
    guest.do("adjust.measured", measured(0.7, 0.6, error=0.5))
    guest.wait(lambda _: len(shown(guest, "measured")) == 2 * len(GAMMAS))
    bars = lines_of(guest, "measured")
    assert [bar["at"][0] for bar in bars] == [mark["x"] for mark in shown(guest, "measured")]
    assert [bar["y"][1] - bar["y"][0] for bar in bars] == pytest.approx([1.0] * len(bars))
    guest.do("over", "alpha")
    guest.wait(lambda _: not shown(guest, "measured"))
    guest.do("gamma", GAMMAS[1])
    guest.wait(lambda _: [mark["x"] for mark in shown(guest, "measured")] == [PAPER.alpha] * 2)
    guest.do("adjust.measured", "frequency\nfast")
    guest.wait(lambda _: not shown(guest, "measured"))


def test_the_charts_show_the_bands_to_keep_free(guest, session):
    """In both tabs, of each line between the two speeds: a locus of the beam lies in them before,
    and none after."""

    def in_bands(chart: str) -> bool:
        data = guest.charts[chart]
        at = np.linspace(3.0, 5.0, 101)
        loci = [
            np.interp(at, line.get("at", data["at"]), np.array(line["y"], float))
            for line in data["lines"]
            if line["label"]
        ]
        (band,) = lines_of(guest, "kept-free", chart)
        low, high = (np.interp(at, [3, 5], np.array(band["y"])[k]) for k in ([0, 1], [3, 2]))
        return any(((low < locus) & (locus < high)).any() for locus in loci)

    guest.do("tab", "adjust")
    guest.do("goal", "clear")
    guest.do("adjust.free.beta", False)
    guest.do("adjust.between", "3:5")
    guest.wait(lambda _: lines_of(guest, "kept-free", "adjust-chart"))
    assert in_bands("adjust-chart")
    assert in_bands("loci-chart")
    (band,) = lines_of(guest, "kept-free")
    assert (band["at"], band["y"]) == ([3, 5, 5, 3, 3], [2.7, 4.5, 5.5, 3.3, 2.7])
    assert guest.charts["loci-chart"]["perRev"]["multiples"] == [1]
    guest.do("adjust.run", until=lambda _: outcome_of(session))
    assert outcome_of(session).reason == ""
    guest.wait(lambda _: not in_bands("adjust-chart"))
    guest.do("goal", "measured")
    guest.wait(lambda _: not lines_of(guest, "kept-free"))


def test_each_point_shows_its_mode_which_can_be_changed(guest, session):
    """The nearest one is the usual; a choice is written into the data, which links carry."""

    def typed() -> str:
        return session.visitor.state.slice(AdjustState).measured

    guest.do("tab", "adjust")
    guest.do("adjust.measured", "gamma, frequency, error\n0, 1.6, 0.1\n4, 16, 0.5")
    guest.wait(lambda _: "auto: B1" in guest.texts["adjust-matches"])
    assert "auto: B2" in guest.texts["adjust-matches"]
    guest.do("adjust.match", "1 B3")
    assert typed().splitlines()[1:] == ["0, 1.6, 0.1,", "4, 16, 0.5, B3"]
    guest.wait(lambda _: 'value="1 B3" selected' in guest.texts["adjust-matches"])
    match = compared(PAPER, measured_frequencies(PAPER, columns_of_text(typed())), {}).matches[1]
    assert match.mode == "B3"
    guest.wait(lambda _: f"{match.residual:+.2f}" in guest.texts["adjust-matches"])
    guest.do("adjust.match", "1")
    guest.wait(lambda _: "auto: B2" in guest.texts["adjust-matches"])
    guest.do("adjust.match", "7 B1")
    assert len(typed().splitlines()) == 3


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (
            "# run 7\ngamma;omega;label\n-;1/T*;\n\n0;3,50;\n# again\n4;22,0; B1\n",
            "# run 7\ngamma;omega;label\n-;1/T*;\n\n0;3,50;\n# again\n4;22,0; B2",
        ),
        ("Freq\tgamma\n3.50\t0\n22\t4", "Freq\tgamma\t mode\n3.50\t0\t\n22\t4\t B2"),
        ("# one\nFreq\n3.50\n22", "# one\nFreq, mode\n3.50,\n22, B2"),
        (
            '"gamma" , mode, Freq\n"0",B1,3.50\n4,B1,22',
            '"gamma" , mode, Freq\n"0",B1,3.50\n4,B2,22',
        ),
    ],
)
def test_a_choice_of_a_mode_keeps_all_else_of_the_text(guest, session, before, after):
    guest.do("adjust.measured", before)
    guest.do("adjust.match", "1 B2")
    assert session.visitor.state.slice(AdjustState).measured == after


def test_a_label_with_a_raised_digit_is_told(guest, session):
    """ "²" is a digit, and no number."""
    guest.do("tab", "adjust")
    guest.do("adjust.measured", "mode, frequency\nB², 22")
    guest.wait(lambda _: "mode = &#x27;B²&#x27;" in guest.texts["adjust-wrong"])
    guest.do("adjust.measured", "mode, frequency\nB2, 22")
    for wrong in ("² B1", "0 B²"):
        guest.do("adjust.match", wrong)
        assert session.visitor.state.slice(AdjustState).measured == "mode, frequency\nB2, 22"


def test_many_settings_are_compared_by_no_edit(guest, session):
    """The beam is not solved at each of hundreds of speeds unasked; too many lines are refused."""
    guest.do("tab", "adjust")
    speeds = [f"{k / 100}, 3.5" for k in range(300)]
    guest.do("adjust.measured", "\n".join(["gamma, frequency", *speeds]))
    guest.wait(lambda _: "residuals are shown for up to 40" in guest.texts["adjust-matches"])
    assert not guest.texts["adjust-wrong"]
    guest.do("adjust.measured", "frequency\n" + 20_000 * "1\n")
    guest.wait(lambda _: "20001 lines: must be 1 .. 1000" in guest.texts["adjust-wrong"])


def test_a_scene_file_brings_measured_frequencies_back(guest, session):
    """What has an error is not saved."""
    guest.do("adjust.measured", measured(0.7, 0.6))
    scene = session.visitor.scene_to_save()
    assert len(measured_frequencies(PAPER, scene.measured)) == 2 * len(GAMMAS)
    guest.do("adjust.measured", "frequency\nfast")
    assert session.visitor.scene_to_save().measured == {}
    guest.do("load", f"scene.toml\n{scene.to_toml()}")
    assert session.visitor.scene_to_save().measured == scene.measured
    guest.wait(lambda _: len(shown(guest, "measured")) == 2 * len(GAMMAS))
