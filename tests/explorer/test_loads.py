"""The tab Loads: forces and moments along the beam at its equilibrium, against statics."""

import re
from collections.abc import Iterator

import numpy as np
import pytest
from live.coarse import coarse_charts
from live.server import wait_until
from live.visitor import Visitor, catch_up

from beamviz.beam import Beam
from beamviz.drawing.text import yield_caution
from beamviz.explorer.features.loads import chart_data, loads_along, sentence, text
from beamviz.explorer.features.real_beam import RULER
from beamviz.presets import PRESETS
from beamviz.scene import Scene
from beamviz.solver import solve

FIRST = Scene(RULER.beam)
NREL = PRESETS["nrel-5mw-blade"].beam
SPINNING_UP = RULER.beam.replace(spin_up=8.0)


def line(data: dict) -> tuple[np.ndarray, np.ndarray]:
    """x and y of the line of a chart."""
    return np.array(data["at"], float), np.array(data["lines"][0]["y"], float)


def test_the_axial_force_of_a_ruler_is_that_of_statics():
    """Omega^2 (rho A (L^2 - x^2) / 2 + m L) [N], with its step to 0 beyond the clip at the tip;
    1e-4: the beam is stretched by less."""
    it, si = solve(RULER.beam), RULER.values
    x, loads = loads_along(it)
    data = chart_data("axial", x, loads["axial"], it.beam.units)
    along, force = line(data)
    rho_a, L, speed = si["density"] * si["area"], si["length"], si["rotation_speed"]
    expected = speed**2 * (rho_a * (L**2 - (along / 1000) ** 2) / 2 + si["mass"] * L)
    assert (data["x"]["unit"], data["y"]["unit"]) == ("mm", "N")
    assert force == pytest.approx(expected, rel=1e-4)
    assert data["y"]["range"][0] == 0
    assert data["y"]["range"][1] > force.max()
    found = re.search(r"axial force</td><td>([\d.]+) N<", text(it, loads))
    assert float(found[1]) == pytest.approx(expected[0], rel=1e-3)
    assert "shear force</td>" not in text(it, loads)


def test_a_mass_on_the_beam_is_a_step():
    """Of m Omega^2 d, between two points of the line at the same place."""
    it = solve(Beam(alpha=1, beta=0.5, gamma=2, mu=1000))
    x, loads = loads_along(it)
    (k,) = np.flatnonzero(np.diff(x) < 1e-9)
    assert x[k] == 0.5
    assert loads["axial"][k] - loads["axial"][k + 1] == pytest.approx(1 * 4 * 0.5, rel=1e-4)
    data = chart_data("axial", x, loads["axial"], None)
    assert data["x"]["label"] == "position x / L"
    assert "EI/L²" in data["y"]["label"]


def test_the_root_of_a_beam_that_spins_up_holds_its_inertia():
    """The moment about the axis is the angular momentum's rate of change: lambda times the moment
    of inertia, of the positions at equilibrium, by quadrature. 1e-3: of the trapezoid rule."""
    it = solve(SPINNING_UP, state="stable")
    beam, equilibrium = it.beam, it.equilibrium
    _, loads = loads_along(it)
    fine = np.linspace(0, 1, 2001)
    r = equilibrium.position(fine) + [beam.delta, 0]
    tip = equilibrium.tip + [beam.delta, 0]
    inertia = np.trapezoid((r**2).sum(1), fine) + beam.alpha * (tip**2).sum()
    torque = loads["moment"][0] + beam.delta * loads["shear"][0]
    assert -torque == pytest.approx(beam.spin_up * inertia, rel=1e-3)
    rows = dict(re.findall(r"<td>([a-z ]+)</td><td>-?([\d.]+ \w*N(?: m)?)</td>", text(it, loads)))
    assert rows.keys() == {"axial force", "shear force", "bending moment"}
    in_si = abs(beam.units.newton_metres(equilibrium.root_moment))
    number, unit = rows["bending moment"].split(" ", 1)
    scale = {"N m": 1.0, "mN m": 1e-3, "kN m": 1e3}[unit]
    assert float(number) * scale == pytest.approx(in_si, rel=1e-3)


@pytest.mark.parametrize(
    ("beam", "words"),
    [
        (Beam(), "at rest"),
        (Beam(gamma=5), "grows from the tip to the root"),
        (Beam(gamma=1, delta=-1), "compression"),
        (Beam(gamma=2, spin_up=3), "and turns (the bending moment)"),
    ],
)
def test_a_sentence_says_what_loads_the_beam(beam, words):
    it = solve(beam, state="stable")
    assert words in sentence(it, loads_along(it)[1])


def test_the_stress_is_beside_the_force_and_a_note_beyond_the_yield_stress():
    """A 1 m bar of steel: at 1500 rpm rho Omega^2 L^2 / 2 = 96.8 MPa, 41 % of the yield stress; at
    2450 rpm 258 MPa, above it, which the headline says too. Without a yield stress none is said,
    and without a material no stress."""
    bar = {"length": 1.0, "density": 7850.0, "area": 5e-4, "youngs_modulus": 210e9}
    bar |= {"second_moment": 0.05 * 0.01**3 / 12, "section_height": 0.01}
    strong = bar | {"yield_stress": 235e6}
    slow, fast, unknown = (
        solve(Beam.from_si(**values, rotation_rpm=rpm))
        for values, rpm in ((strong, 1500), (strong, 2450), (bar, 2450))
    )
    shown = [text(it, loads_along(it)[1]) for it in (slow, fast, unknown, solve(Beam(gamma=5)))]
    assert "<td>48.44 kN</td><td>96.9 MPa</td>" in shown[0]
    assert "Greatest stress: 96.9 MPa at the root: 41 % of the yield stress, 235 MPa." in shown[0]
    assert [one.count('class="yields"') for one in shown] == [0, 1, 0, 0]
    note = "Greatest stress: 259 MPa at the root: 110 % of the yield stress, 235 MPa."
    assert f'<p class="yields">{note}' in shown[1]
    assert "Greatest stress: 259 MPa at the root.</p>" in shown[2]
    assert "MPa" not in shown[3]
    told = [yield_caution(it) for it in (slow, fast, unknown, solve(Beam(gamma=5)))]
    assert [bool(one) for one in told] == [False, True, False, False]
    assert "Stress up to 259 MPa, above the yield stress, 235 MPa" in told[1]


def test_the_stress_of_bending_is_beside_the_moment():
    """M h / (2 I) at the root of a beam that spins up, of either sign; without a height it is not
    known, which is said."""
    bar = {"length": 1.2, "density": 7850.0, "area": 5e-4, "youngs_modulus": 210e9}
    bar |= {"second_moment": 0.05 * 0.01**3 / 12, "rotation_speed": 1.0}
    bar |= {"angular_acceleration": 20.0}
    known, unknown = (
        solve(Beam.from_si(**bar, **height), state="stable")
        for height in ({"section_height": 0.01}, {})
    )
    moment = 20 * 7850 * 5e-4 * 1.2**3 / 3
    shown = text(known, loads_along(known)[1])
    found = re.search(r"bending moment</td><td>(-?[\d.]+) N m</td><td>± ([\d.]+) MPa<", shown)
    assert abs(float(found[1])) == pytest.approx(moment, rel=5e-3)
    assert float(found[2]) == pytest.approx(moment * 0.005 / bar["second_moment"] / 1e6, rel=5e-3)
    shown = text(unknown, loads_along(unknown)[1])
    assert "N m</td><td>not known</td>" in shown
    assert "without that of bending, for which the height of the section is not known" in shown


# The page


def hidden(guest: Visitor) -> list[str]:
    """The charts that are not there."""
    return [name for name in ("axial", "shear", "moment") if guest.props[f"loads-{name}"]["hidden"]]


@pytest.fixture
def coarse() -> Iterator[None]:
    """Coarse charts of the other tabs."""
    with coarse_charts():
        yield


@pytest.mark.usefixtures("coarse")
def test_the_tab_follows_the_beam(guest):
    """A straight beam has an axial force only; one that spins up all three, and a beam without an
    equilibrium none, with the reason. Units are those of the beam."""
    guest.do("tab", "loads", until="On the beam at its root")
    assert hidden(guest) == ["shear", "moment"]
    assert "no shear force and no bending moment" in guest.texts["loads-text"]
    guest.do("spin_up", 2000.0, until="and turns (the bending")
    guest.wait(lambda _: hidden(guest) == [])
    guest.do("spin_up", 0.0, until="A straight beam has no shear")
    guest.do("blade.preset", "nrel-5mw-blade")
    guest.wait(lambda _: guest.charts["loads-axial"]["y"]["unit"] == "kN")
    assert guest.charts["loads-axial"]["x"]["range"] == pytest.approx([0, 61.5])
    force = solve(NREL).equilibrium.root_force
    newtons = NREL.units.newtons(force)
    assert guest.charts["loads-axial"]["lines"][0]["y"][0] == pytest.approx(newtons / 1e3, rel=1e-5)
    guest.do("dimensionless")
    guest.wait(lambda _: "EI/L²" in guest.charts["loads-axial"]["y"]["label"])
    guest.do("link", "?strain=biot&mu=10&gamma=20&tab=loads", until="No equilibrium")
    guest.wait(lambda _: hidden(guest) == ["axial", "shear", "moment"])


@pytest.mark.usefixtures("coarse")
def test_a_closed_tab_is_not_computed(guest, session):
    """It shows what it showed, and the present beam once it is open again."""
    guest.do("tab", "loads", until="On the beam at its root")
    before = guest.texts["loads-text"]
    guest.do("tab", "export")
    guest.do("blade.preset", "nrel-5mw-blade")
    guest.shows(NREL)
    wait_until(lambda: not session.is_busy)
    catch_up(guest)
    assert guest.texts["loads-text"] == before
    guest.do("tab", "loads", until=lambda _: "kN" in guest.texts["loads-text"])


def test_a_beam_at_rest_is_not_stretched():
    """Rounding of the stretch is not shown as one."""
    shown = text(it := solve(Beam()), loads_along(it)[1])
    assert "No part of it is stretched" in shown
    assert "nothing loads it" in shown
