"""What the page says."""

import math

import pytest
from live.visitor import PAPER

from beamviz.beam import Beam, Units
from beamviz.drawing import text as messages
from beamviz.drawing.text import rounded_to_error
from beamviz.errors import NoEquilibrium
from beamviz.explorer.page import html
from beamviz.exports.html_page import solution_table
from beamviz.scene import ViewOptions, clip
from beamviz.solver import solve


def test_the_table_shows_what_the_error_leaves():
    """Digits beyond the error are not printed; SI beams get hertz; shown modes are marked."""
    assert rounded_to_error(22.034491561, 3e-12) == "22.034492"
    assert rounded_to_error(120.9019161, 7e-5) == "120.902"
    solution = solve(PAPER)
    text = solution_table(solution, [1])
    assert text.count("<tr") == 6
    assert text.count("shown") == 1
    assert "stretching" in text
    units = Units(length=1.0, time=0.01)
    text = solution_table(solve(PAPER.replace(units=units)), [1])
    hertz = units.hertz(solution.frequencies[0])
    assert rounded_to_error(hertz, units.hertz(solution.errors[0])) in text


def test_trouble_is_told_apart():
    """No equilibrium names the limit, an unstable state its growth, a stable one says nothing."""
    error = NoEquilibrium("no equilibrium beyond gamma = 15.7", 15.7)
    told = messages.error_summary(error, Beam(gamma=20))
    assert told == "No equilibrium above γ = 15.7 with this material law"
    assert messages.stability_warning(solve(PAPER)) == ""
    buckled = solve(Beam(gamma=5, delta=-1))
    assert buckled.equilibrium.status == "unstable"
    assert messages.stability_warning(buckled) == (
        "Unstable in bending\n"
        f"a disturbance grows {math.exp(buckled.growth_rates.max()):.0f}-fold per T*"
    )
    assert messages.growth(0.01, None) == "grows tenfold in 2.3e+02 T*"


@pytest.mark.parametrize(("gamma", "told"), [(34.0, False), (36.0, True), (100.0, True)])
def test_a_stretch_beyond_real_materials_is_told(gamma, told):
    """In amber from gamma / mu = 0.5 on, with the stretch and the reason."""
    solution = solve(Beam(alpha=1, beta=0.5, gamma=gamma))
    caution = messages.stretch_caution(solution)
    percent = 100 * (solution.equilibrium.max_stretch - 1)
    assert (f"by up to {percent:.0f} %: γ / μ = {gamma / 70:.2g}" in caution) is told
    assert bool(caution) is told


def test_trouble_of_a_real_beam_is_told_in_its_units():
    """rpm, milliseconds and a growth per second, not gamma and T*."""
    units = Units(length=1.0, time=0.01)
    error = NoEquilibrium("no equilibrium beyond gamma = 15.7", 15.7)
    told = messages.error_summary(error, Beam(gamma=20, units=units))
    assert f"above {units.rpm(15.7):.0f} rpm" in told
    buckled = solve(Beam(gamma=5, delta=-1, units=units))
    rate = buckled.growth_rates.max()
    assert f"tenfold in {1000 * 0.01 * math.log(10) / rate:.3g} ms" in messages.stability_warning(
        buckled
    )
    text = solution_table(buckled, [])
    assert messages.growth(rate, units) in text
    assert f"{buckled.errors[0] / 0.01:.0e}" in text
    assert "T*" not in html.pace(0.1, units)
    assert "1 ms (1000 times slower)" in html.pace(0.1, units)
    assert "2000 ms (2 times faster)" in html.pace(200.0, units)


def test_choices_that_make_no_sense_change_nothing():
    """A browser may send anything: not-a-number, too much, the wrong kind, an unknown choice."""
    view = ViewOptions()
    assert view.changed("pace", math.nan) == view
    assert view.changed("pace", "fast") == view
    assert view.changed("colouring", "rainbow") == view
    assert view.changed("amplitude", 1e9).amplitude == clip(1e9, 0.4, 0.0) == 0.4
    assert view.share(3, -5).shares == (0.0, 1.0, 0.0, 0.0)
    assert view.only(2).shares == (0.0, 0.0, 1.0)
