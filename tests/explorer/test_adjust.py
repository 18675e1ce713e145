"""The tab Adjust: the scene moves to the beam that fits, or that keeps clear."""

import pytest

from beamviz import Beam, solve
from beamviz.explorer.features.adjust import AdjustState

TRUE = Beam(alpha=0.3, beta=0.65, gamma=10)


def labels_of(beam: Beam) -> str:
    """The data with the labels that the solver gives."""
    found = solve(beam, modes=5)
    lines = [
        f"{label},{frequency:.6f},{1e-3 * frequency:.6f}"
        for label, frequency in zip(found.labels, found.frequencies, strict=True)
    ]
    return "\n".join(["mode,frequency,error", *lines])


def test_the_scene_moves_to_the_beam_that_fits(guest):
    """One undo brings the beam before it back; the data stay."""
    guest.do("tab", "adjust")
    guest.do("measured", labels_of(TRUE))
    before = guest.session.visitor.state.case.beam
    guest.do("adjust", None, until=lambda _: "adjusted numbers" in guest.texts["adjust-result"])
    guest.wait(lambda _: guest.session.visitor.state.case.beam != before)
    beam = guest.session.visitor.state.case.beam
    assert (beam.alpha, beam.beta) == pytest.approx((TRUE.alpha, TRUE.beta), rel=1e-4)
    guest.wait(lambda _: "The scene shows it" in guest.texts["adjust-result"])
    guest.do("undo", None)
    state = guest.session.visitor.state
    assert state.case.beam == before
    assert state.slice(AdjustState).measured == labels_of(TRUE)
    guest.wait(lambda _: "changed since" in guest.texts["adjust-result"])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "no data"),
        ("mode,frequency\nB1,fast", "fast"),
        ("mode,speed\nB1,3", "frequency, hertz"),
    ],
)
def test_what_cannot_be_read_is_said(guest, text, words):
    """The beam stays, and so does what was typed."""
    before = guest.session.visitor.state.case
    guest.do("tab", "adjust")
    guest.do("measured", text)
    guest.do("adjust", None, until=lambda _: words in guest.texts["adjust-result"])
    assert guest.session.visitor.state.case == before
    assert guest.session.visitor.state.slice(AdjustState).measured == text


def test_a_beam_clear_of_resonances(guest):
    """In a range of speeds, by the lines of the frequency chart."""
    guest.do("tab", "adjust")
    for action, value in {
        "adjust_goal": "clear", "clear_between": "6 .. 9", "clear_margin": "0.05", "per_rev": 1,
    }.items():  # fmt: skip
        guest.do(action, value)
    guest.do("adjust", None, until=lambda _: "Least margin" in guest.texts["adjust-result"])
    guest.do("clear_between", "fast")
    guest.do("adjust", None, until=lambda _: "between" in guest.texts["adjust-result"])


def test_what_moves_the_mode_most(guest):
    """The bars are those of the sensitivities of the mode that is shown."""
    guest.do("tab", "adjust")
    guest.do("only", 0, until=lambda _: "1 % more of" in guest.texts["adjust-sensitivities"])
    solution = solve(guest.session.visitor.state.case.beam, modes=5)
    share = float(solution.sensitivities["gamma"][0]) * solution.beam.gamma
    share /= float(solution.frequencies[0])
    assert f"{share:+.2f} %" in guest.texts["adjust-sensitivities"].replace("\u2212", "-")
