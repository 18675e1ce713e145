"""Switches for the terms of the equations, and what they leave to be seen."""

import pytest
from live.visitor import frequency_text, visitor

from beamviz.beam import Beam
from beamviz.explorer.app import explorer
from beamviz.explorer.features.comparison import number
from beamviz.explorer.state import State
from beamviz.scene import Scene
from beamviz.solver import solve

BEAM = Beam(alpha=1, beta=0.5, gamma=3)
FIRST, START = Scene(BEAM), State.of(Scene(BEAM))


@pytest.mark.parametrize(
    "option",
    ["softening", "coriolis", "stiffening"],
)
def test_a_term_is_switched_and_back(guest, option):
    """The frequencies are those of `solve` with that option; the case before is compared with."""
    usual = START.values[option]
    guest.choose(option, not usual)
    if option == "stiffening":  # without it the beam is unstable at gamma = 3 already
        guest.says("Unstable in bending")
    else:
        guest.says(frequency_text(BEAM, **{option: not usual}))
    guest.says("before, ω")
    guest.says(number(solve(BEAM).frequencies[0]))
    guest.choose(option, usual)
    guest.says(frequency_text(BEAM))


def test_the_mass_is_removed_and_restored(url):
    """Without it alpha is 0; restored, it has its last value, or 1 if it had none."""
    with visitor(url) as guest:
        guest.choose("alpha", 2.5)
        guest.says(frequency_text(BEAM.replace(alpha=2.5)))
        guest.choose("mass", False)
        guest.says(frequency_text(BEAM.replace(alpha=0)))
        guest.choose("mass", True)
        guest.says(frequency_text(BEAM.replace(alpha=2.5)))
    with explorer(Scene(Beam(gamma=3))) as address, visitor(address) as guest:
        guest.choose("mass", True)
        guest.says(frequency_text(Beam(alpha=1, gamma=3)))


def test_the_switch_of_the_mass_shows_its_slider(guest):
    """alpha = 0 switches it off, any other value on."""
    guest.choose("alpha", 0.0)
    guest.wait(lambda _: guest.values.get("mass") is False)
    guest.choose("alpha", 0.5)
    guest.wait(lambda _: guest.values.get("mass") is True)


def test_a_method_without_switches_names_those_with_them(guest):
    """The paper's elements include all terms."""
    guest.choose("softening", False)
    guest.choose("method", "ancf")
    guest.says("softening = False: method ancf takes no switched-off term")


def test_the_page_invites_to_drag_what_there_is():
    """The mass, if the beam has one."""
    for scene, words in ((FIRST, "Drag the mass along"), (Scene(), "Drag the line of the speed")):
        with explorer(scene) as url, visitor(url) as guest:
            guest.wait(lambda _, words=words: words in guest.texts["scene-caption"])
