"""Numbers and messages as text: dimensionless, or in kg or g, mm, rpm and Hz for a real beam."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from charts import chart_of
from hypothesis import given
from hypothesis import strategies as st
from live.offline import local
from live.visitor import PAPER

from beamviz import explorer
from beamviz.beam import PARAMETERS, Beam
from beamviz.drawing import text as messages
from beamviz.drawing.text import measure, rounded_to_error
from beamviz.errors import NoEquilibrium
from beamviz.explorer.computed_loci import chart_data
from beamviz.explorer.feature import tabs
from beamviz.explorer.features import answer
from beamviz.explorer.features.real_beam import MATERIALS
from beamviz.explorer.links import PAGE
from beamviz.exports.html_page import solution_table
from beamviz.files import package_text
from beamviz.scene import Scene
from beamviz.solver import solve
from beamviz.units import Units

STEEL = {"length": 0.3, "area": 25e-6, "second_moment": 25e-12 / 12, **MATERIALS["steel"]}
RULER = Beam.from_si(**STEEL, rotation_speed=20 * math.pi, mass=0.02, mass_position=0.15)
FIRST = Scene(RULER)
sizes = st.floats(1e-3, 1e3)


def test_the_numbers_of_a_real_beam_are_displayed_in_si_units():
    """600 rpm and others, with the digits that are accurate, and without an exponent."""
    assert measure("gamma", RULER.units).text(RULER.gamma, 5) == "600 rpm"
    assert measure("gamma", None).text(4.4641, 4) == "γ = 4.464"
    assert rounded_to_error(22.034491561, 3e-12) == "22.034492"
    assert rounded_to_error(120.9019161, 7e-5) == "120.902"
    hertz = messages.Measure("Hz", "f", "Hz")
    column = [hertz.number(value) for value in (4.28, 32.28, 9999.97)]
    assert column == ["4.2800", "32.280", "10000"]
    texts = [messages.significant(value, 4) for value in (48170.4, 1234.56, 123.456, 0.0123456)]
    assert texts == ["48170", "1235", "123.5", "0.01235"]


@given(st.sampled_from(list(PARAMETERS)), sizes, sizes, sizes, st.floats(0.1, 50))
def test_sliders_in_units_have_round_ends_within_the_limits(name, length, time, mass, high):
    """Round, at least as wide as requested within the limits, with a step of 1, 2 or 5."""
    shown = measure(name, Units(length, time, mass))
    least, most = PARAMETERS[name].limits
    high = min(max(high, least + 0.1), most)
    low, top_, step = shown.range(least, high, 0.01, PARAMETERS[name].limits)
    assert shown.plain(low) == pytest.approx(least)
    if shown.unit:
        assert shown.plain(top_) >= high * (1 - 1e-9)
        ends = float(f"{top_:.2g}"), shown.factor * most
        assert any(top_ == pytest.approx(end, rel=1e-9) for end in ends)
        assert shown.plain(top_) <= min(most, 1.1 * high) * (1 + 1e-9)
        assert step <= shown.factor * 0.01 * (1 + 1e-9)
        assert round(step / 10.0 ** math.floor(math.log10(step * 1.0000001))) in (1, 2, 5)


@pytest.mark.parametrize(("length", "unit"), [(0.3, "mm"), (4.99, "mm"), (5.0, "m"), (61.5, "m")])
def test_lengths_of_a_long_beam_are_in_metres(length, unit):
    """All of them in one unit, but for single ones that are small."""
    units = Units(length, 0.1, 2.0)
    for name in ("beta", "delta"):
        assert measure(name, units).unit == unit
        assert measure(name, units).label.endswith(f" [{unit}]")
    assert messages.lengths("amplitude", "a", units).unit == unit
    assert messages.length_text(0.3, units, 3).endswith(f" {unit}")
    small = f"{100 * length:.3g} µm" if length < 1 else f"{0.1 * length:.3g} mm"
    assert messages.length_text(1e-4, units, 3) == small
    assert messages.length_text(0.3, None, 3) == "0.3 L"


def test_a_message_has_the_numbers_as_the_page_calls_them():
    """With their values in the unit of a real beam."""
    text, units = (
        "gamma = 5: no equilibrium beyond gamma = 4.5e-1 (alpha = 2, mu = 70)",
        RULER.units,
    )
    assert messages.in_words(text, None) == (
        "speed γ = 5: no equilibrium beyond speed γ = 4.5e-1 (mass α = 2, slenderness μ = 70)"
    )
    speeds = [messages.significant(units.rpm(gamma), 6) for gamma in (5, 0.45)]
    assert messages.in_words(text, units) == (
        f"speed {speeds[0]} rpm: no equilibrium beyond speed {speeds[1]} rpm"
        f" (mass {messages.significant(2000 * units.mass, 6)} g, slenderness μ = 70)"
    )


def test_the_chart_of_a_real_beam_is_in_rpm_and_hertz():
    """x and y are those of the dimensionless chart times their units; the axes end at round
    numbers, and a line k per revolution is k times the speed in Hz."""
    chart = chart_of(RULER)
    data, plain = chart_data(chart, (1,)), chart_data(chart_of(RULER.replace(units=None)))
    assert [data[axis]["label"] for axis in "xy"] == ["speed [rpm]", "frequency [Hz]"]
    assert data["x"]["range"] == pytest.approx([0, RULER.units.rpm(chart.request.stop)])
    end = RULER.units.hertz(chart.top)
    assert data["y"]["range"][1] == pytest.approx(float(f"{end:.2g}"))
    assert data["lines"][0]["y"][0] == pytest.approx(RULER.units.hertz(plain["lines"][0]["y"][0]))
    assert data["perRev"]["slope"] == pytest.approx(1 / 60)
    assert chart_of(RULER, "mu").request.measures[1].unit == ""  # T* itself depends on mu


def test_sliders_of_a_real_beam_take_rpm_grams_and_millimetres(guest):
    """They show and give SI values; mu has no slider; a resonance is listed in rpm and hertz."""
    assert guest.props["mu-row"]["hidden"] is True
    numbers = [guest.values[name] for name in ("gamma", "alpha", "beta")]
    assert numbers == pytest.approx([600, 20, 150])
    guest.set(gamma=300.0, alpha=10.0, beta=200.0)
    gamma, alpha = 300 / RULER.units.rpm(1), 0.01 / RULER.units.mass
    same = RULER.replace(gamma=gamma, alpha=alpha, beta=200 / 300)
    guest.shows(same)
    guest.says("300 rpm")
    guest.set(per_rev_2=True, gamma=450.0)
    guest.shows(same.replace(gamma=450 / RULER.units.rpm(1)))
    (resonance,) = chart_of(same, per_rev=2).resonances_at((2,)).values()
    rpm = RULER.units.rpm(resonance.at)
    guest.says(f"<td>2 ×</td><td>{rpm:#.5g}</td><td>{2 * rpm / 60:#.5g}</td>")


def test_the_help_says_what_the_letters_in_its_formulas_are():
    """Those of the table of symbols, in the text below it."""
    letters = {sign for one in PARAMETERS.values() for sign in one.formula if sign.isalpha()}
    paragraphs = " ".join(re.findall("<p>(.*?)</p>", package_text("explorer/page/page.html")))
    assert letters - {"T"} <= {*re.findall(r"\w+", paragraphs.split("number the")[0])}
    assert "T* = " in paragraphs


def test_the_help_explains_the_words_that_lessons_and_tabs_use():
    """Each with a meaning."""
    help_text = package_text("explorer/page/page.html")
    words = re.search('aria-label="words">(.*?)</table>', help_text, re.DOTALL)[1]
    explained = dict(re.findall("<tr><td>(.*?)</td><td>(.+?)</td></tr>", words))
    for word in ("mode", "node", "crossing", "veering", "resonance", "flapwise", "per-rev"):
        assert any(word in known for known in explained)


def test_help_and_readme_name_every_tab():
    """The help says what each shows; a row of the README has the tab."""
    readme = (Path(__file__).parents[2] / "README.md").read_text()
    for tab in tabs(PAGE).values():
        assert len(tab.help.split()) > 4, tab.name
        assert re.search(rf"^\|.*\btab {tab.name}\b", readme, re.MULTILINE), tab.name


def test_every_style_beside_a_feature_is_on_the_page():
    """And every one that a feature names is there."""
    folder = Path(explorer.__file__).parent / "features"
    assert {path.name for path in folder.glob("*.css")} == {kind.style for kind in PAGE} - {""}


def test_the_table_of_an_exported_page_marks_the_modes_shown():
    """One of five."""
    assert solution_table(solve(PAPER), ["B2"]).count("shown") == 1


def test_warnings_name_their_reason_in_the_units_of_the_beam():
    """No equilibrium with the limit, an unstable state with its growth; for a real beam in rpm,
    milliseconds and a growth per second, not gamma and T*."""
    error, units = NoEquilibrium("no equilibrium beyond gamma = 15.7", 15.7), Units(1.0, 0.01)
    told = messages.error_summary(error, Beam(gamma=20, units=units))
    assert told == f"No equilibrium above {units.rpm(15.7):.0f} rpm with this material law"
    buckled, real = (solve(Beam(gamma=5, delta=-1, units=one)) for one in (None, units))
    rate = buckled.growth_rates.max()
    growing = f"a disturbance grows {math.exp(rate):.0f}-fold per T*"
    assert messages.stability_warning(buckled) == f"Divergence in bending\n{growing}"
    assert messages.growth(0.01, None) == "grows tenfold in 2.3e+02 T*"
    tenfold = f"tenfold in {1000 * 0.01 * math.log(10) / rate:.3g} ms"
    assert tenfold in messages.stability_warning(real)
    for words in (
        messages.growth(rate, units),
        f"{real.errors[0] / 0.01:.0e}".replace("e-0", "e-"),
    ):
        assert words in solution_table(real, [])
    assert "T*" not in answer.pace(0.1, units)
    assert "1 ms (1000 times slower)" in answer.pace(0.1, units)
    assert "2 s (2 times faster)" in answer.pace(200.0, units)
    for nearly in (1 - 1e-9, 1.0, 1 + 1e-9):  # rounding decides nothing
        assert answer.pace(nearly / units.time, units) == answer.pace(1 / units.time, units)


@pytest.mark.parametrize(("gamma", "told"), [(34.0, False), (36.0, True), (100.0, True)])
def test_a_stretch_beyond_real_materials_has_a_caution(gamma, told):
    """From gamma / mu = 0.5 on, with the stretch and the reason."""
    solution = solve(Beam(alpha=1, beta=0.5, gamma=gamma))
    caution = messages.stretch_caution(solution)
    percent = 100 * (solution.equilibrium.max_stretch - 1)
    assert (f"by up to {percent:.0f} %: γ / μ = {gamma / 70:.2g}" in caution) is told
    assert bool(caution) is told


def test_a_growth_that_is_zero_within_its_error_is_called_neutral():
    """At the limit of stability of an inward beam; a larger one has its value."""
    limit = 2.9960386598525  # speed gamma at which an inward beam without a mass buckles
    speeds = [limit + k * 1e-14 for k in range(-20, 40)]  # some of them by rounding only
    solutions = [solve(Beam(gamma=gamma, delta=-1), modes=1) for gamma in speeds]
    at_limit = [one for one in solutions if 0 < one.growth_rates[0] <= one.errors[0]]
    assert at_limit
    for one in at_limit:
        assert "neutral" in answer.numbers(one, 0)
    assert "growth ±" in answer.numbers(solve(Beam(gamma=3.0, delta=-1), modes=1), 0)


def test_the_modes_of_both_planes_have_the_shares_of_their_motion():
    """In the title of a mode, by the kinetic energy of its shape; its nodes are those of the larger
    one. In one plane there are no such words."""
    scene = Scene.of(alpha=0, flap=0.8, pitch=20, twist=30, gamma=3, plane="both")
    solution = solve(scene.beam, plane="both")
    x, weights = np.polynomial.legendre.leggauss(40)
    with local(scene) as guest:
        rows = guest.texts["mode-rows"]
        guest.choose("plane", "flapwise")
        guest.wait(lambda _: " % flap" not in guest.texts["mode-rows"])
    titles = re.findall(r'<button[^>]*title="([^"]*)"', rows)
    nodes = re.findall(r"nodes of its (flap|lag|stretching)[^<\"]*</title>", rows)
    assert len(titles) == len(nodes) == len(solution.labels)
    for k, (title, larger) in enumerate(zip(titles, nodes, strict=True)):
        energy = weights @ solution.shape(k, (x + 1) / 2) ** 2
        shares = dict(zip(("stretching", "lag", "flap"), 100 * energy / energy.sum(), strict=True))
        named = {name: float(share) for share, name in re.findall(r"([\d.]+) % (\w+)", title)}
        assert max(named, key=named.__getitem__) == larger
        assert shares == pytest.approx(dict.fromkeys(shares, 0.0) | named, abs=0.6)
