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
from beamviz.solver import solve


def test_the_table_shows_accurate_digits():
    """Digits beyond the error are not printed; SI beams are in hertz; shown modes are marked."""
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


def test_warnings_name_their_reason():
    """No equilibrium with the limit, an unstable state with its growth; a stable one has no
    warning."""
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
def test_a_stretch_beyond_real_materials_has_a_caution(gamma, told):
    """From gamma / mu = 0.5 on, with the stretch and the reason."""
    solution = solve(Beam(alpha=1, beta=0.5, gamma=gamma))
    caution = messages.stretch_caution(solution)
    percent = 100 * (solution.equilibrium.max_stretch - 1)
    assert (f"by up to {percent:.0f} %: γ / μ = {gamma / 70:.2g}" in caution) is told
    assert bool(caution) is told


def test_warnings_of_a_real_beam_are_in_its_units():
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
