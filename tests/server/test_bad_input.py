"""What visitors send that makes no sense, and beams without an answer: told, and nothing lost."""

import math

import pytest
from live.server import raw_socket
from live.visitor import PAPER, Visitor, frequency_text, visitor

from beamviz.beam import Beam
from beamviz.drawing.text import growth
from beamviz.errors import InvalidInput
from beamviz.explorer.app import explorer
from beamviz.explorer.features.links import within_limits
from beamviz.scene import Scene
from beamviz.solver import solve


def test_a_number_out_of_range_is_named(guest):
    """The message has number, value and range; the next valid one is solved. A value that is no
    number is refused too."""
    for k, bad in enumerate((math.nan, 1e9, -1.0, math.inf)):
        guest.choose("alpha", bad)
        guest.says(f"alpha = {bad:.10g}: must lie in 0 .. 100")
        guest.choose("alpha", 2.0 + k)
        guest.says(frequency_text(PAPER.replace(alpha=2 + k)))
        guest.says("Stable equilibrium")
    for k, bad in enumerate(("fast", None, 10**40)):
        guest.choose("gamma", bad)
        guest.says("out of range")
        guest.choose("gamma", 12.0 + k)
        guest.says(frequency_text(PAPER.replace(alpha=5, gamma=12 + k)))
        guest.wait(lambda _: "out of range" not in guest.text)


def test_without_an_equilibrium_the_last_beam_is_grey(guest):
    """biot has none at mu = 10, gamma = 20: a message names the limit."""
    guest.choose("strain", "biot")
    guest.choose("mu", 10.0)
    guest.choose("gamma", 20.0)
    guest.says("No equilibrium above γ = 10.77")
    guest.wait(lambda _: "No equilibrium" in str(guest.parts["captions"]))
    assert guest.props["mode-rows"]["class"] == "faded"
    guest.choose("gamma", 5.0)
    guest.says("Stable equilibrium")


def test_an_unstable_state_is_shown_with_its_growth(guest):
    """delta = -1, gamma = 5 without a mass: the straight beam buckles. Its modes are listed; the
    scene shows the last stable state."""
    guest.choose("alpha", 0.0)
    guest.choose("gamma", 5.0)
    guest.says(frequency_text(Beam(beta=0.5, gamma=5)))
    guest.choose("delta", -1.0)
    guest.says("Unstable in bending")
    rate = solve(Beam(beta=0.5, gamma=5, delta=-1)).growth_rates.max()
    guest.says(growth(rate, None))
    guest.wait(lambda _: "Unstable" in str(guest.parts["captions"]))
    assert guest.nodes["/scene/rotor/hoop"]["visible"] is False
    guest.choose("gamma", 1.0)
    guest.wait(lambda _: guest.nodes["/scene/rotor/hoop"]["visible"])


def test_a_first_beam_without_equilibrium_is_shown_undeformed():
    """In grey, as there is no last stable state."""
    beam = Beam(mu=10, gamma=20)
    with (
        explorer(Scene(beam, {"strain": "biot"})) as address,
        visitor(address, first="No equilibrium") as guest,
    ):
        guest.says("No equilibrium above γ = 15.71")
        guest.wait(lambda _: "No equilibrium" in str(guest.parts["captions"]))


def test_an_edit_during_the_start_of_a_session_is_not_lost(url):
    """A page may send as soon as it has a control."""
    with raw_socket(url) as line:
        guest = Visitor(line)
        guest.choose("gamma", 21.0)
        guest.choose("colouring", "axial strain")
        guest.says(frequency_text(PAPER.replace(gamma=21)))
        assert guest.says("axial strain, as drawn")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"method": "linear", "elements": 1000}, "elements = 1000: a page solves with at most 200"),
        ({"method": "power-series", "terms": 101}, "terms = 101: a page solves with at most 100"),
    ],
)
def test_a_file_cannot_exceed_the_limits_of_a_page(options, words):
    """The command line can: such a scene can be served and saved, but not uploaded."""
    scene = Scene.from_bytes(Scene(PAPER, options).to_toml().encode(), "scene.toml")
    with pytest.raises(InvalidInput, match=words):
        within_limits(scene)
    within_limits(Scene(PAPER, {"method": "linear", "elements": 200}))
