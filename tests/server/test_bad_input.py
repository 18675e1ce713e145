"""What visitors send that makes no sense, and beams without an answer: told, and nothing lost."""

import math

from live.server import raw_socket
from live.visitor import PAPER, Visitor, frequency_text, visitor

from beamviz.beam import Beam
from beamviz.drawing.text import growth
from beamviz.explorer import explorer
from beamviz.scene import Scene
from beamviz.solver import solve


def test_a_number_out_of_range_is_named(guest):
    """With value and range; the next valid one is solved. What is no number is refused too."""
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
    guest.wait(lambda _: not guest.nodes["/scene/rotor/hoop"]["visible"])
    guest.choose("gamma", 1.0)
    guest.wait(lambda _: guest.nodes["/scene/rotor/hoop"]["visible"])


def test_an_edit_during_the_start_of_a_session_is_not_lost(url):
    """A page may send as soon as it has a control."""
    with raw_socket(url) as line:
        guest = Visitor(line)
        guest.choose("gamma", 21.0)
        guest.choose("colouring", "axial strain")
        guest.says(frequency_text(PAPER.replace(gamma=21)))
        assert guest.says("axial strain, as drawn")


def test_a_first_beam_without_equilibrium_is_shown_undeformed():
    """As there is no last stable state, with the limit."""
    scene = Scene(Beam(mu=10, gamma=20), {"strain": "biot"})
    with explorer(scene) as address, visitor(address, first="No equilibrium") as guest:
        guest.says("No equilibrium above γ = 15.71")
        assert "Stable equilibrium" not in guest.text
