"""The solver against published and independently computed values, each within its digits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from published import (
    INDEPENDENT,
    INDEPENDENT_CORIOLIS,
    LIMITS,
    LINEAR_AXIAL_CORIOLIS,
    MEETINGS,
    TIP_MASS_AT_REST,
    TIP_MASS_FLAPWISE,
    TUBE,
    TUBE_HERTZ,
    UNIFORM_FLAPWISE,
)
from scipy.optimize import brentq

from beamviz import Beam, solve
from beamviz.errors import NoEquilibrium

RIGID = 10000.0  # slenderness; stretch is (gamma / mu)^2 = 1e-6 at most in the rigid tables


def labelled(beam, **options):
    """Frequencies by label, enough of them to hold the first stretching one."""
    solution = solve(beam, modes=7, tolerance=1e-8, **options)
    return dict(zip(solution.labels, solution.frequencies, strict=True))


@pytest.mark.parametrize("row", UNIFORM_FLAPWISE, ids=str)
def test_uniform_beam_flapwise(row):
    """Wright et al. 1982; one unit of the last digit, since 22.0345 is printed as 22.035."""
    gamma, *published = row
    found = solve(Beam(gamma=gamma, mu=RIGID), 3, plane="flapwise").frequencies
    assert found == pytest.approx(published, abs=1e-3)


@pytest.mark.parametrize("row", TIP_MASS_FLAPWISE, ids=str)
def test_tip_mass_flapwise(row):
    """Wright et al. 1982; one unit of the last digit printed."""
    gamma, first, second = row
    found = solve(Beam(alpha=1, gamma=gamma, mu=RIGID), 2, plane="flapwise").frequencies
    assert found[0] == pytest.approx(first, abs=1e-3 if first < 10 else 1e-2)
    assert found[1] == pytest.approx(second, abs=1e-2)


def test_tip_mass_at_rest():
    """MPE 2017/1568019, table 1, to the digits printed."""
    found = solve(Beam(alpha=1, mu=RIGID)).frequencies
    assert found == pytest.approx(TIP_MASS_AT_REST, rel=5e-7)


@pytest.mark.parametrize("alpha", [0.0, 0.01, 1.0, 100.0])
def test_tip_mass_at_rest_in_closed_form(alpha):
    """1 + cos b cosh b = alpha b (sin b cosh b - cos b sinh b), omega = b^2 (Blevins)."""
    solution = solve(Beam(alpha=alpha, mu=RIGID), 4)

    def characteristic(b):  # divided by cosh b
        tip = alpha * b * (np.sin(b) - np.cos(b) * np.tanh(b))
        return 1 / np.cosh(b) + np.cos(b) - tip

    b = np.linspace(0.05, 14, 4000)
    signs = np.sign(characteristic(b))
    crossings = np.flatnonzero(np.diff(signs))[:4]
    roots = np.array([brentq(characteristic, b[i], b[i + 1], xtol=1e-14) for i in crossings])
    assert np.all(np.abs(solution.frequencies - roots**2) <= solution.errors)


@pytest.mark.parametrize("alpha", [0.0, 0.3, 1.0, 30.0])
def test_stretching_at_rest_in_closed_form(alpha):
    """omega = mu z with z tan z = 1 / alpha: 109.9557 and 60.2234 at alpha 0 and 1, mu 70."""
    z = brentq(lambda z: alpha * z * np.sin(z) - np.cos(z), 1e-6, np.pi / 2 + 1e-9)
    assert labelled(Beam(alpha=alpha))["S1"] == pytest.approx(70 * z, rel=1e-8)


def test_spinning_cable():
    """omega_k -> gamma sqrt(k (2k - 1)) flapwise as bending stiffness vanishes like 1 / gamma."""
    ratios = [
        solve(Beam(gamma=g, mu=RIGID), 4, plane="flapwise").frequencies / g for g in (50, 100, 200)
    ]
    k = np.arange(1, 5)
    limit = (ratios[0] - 6 * ratios[1] + 8 * ratios[2]) / 3  # what is left falls with gamma^3
    assert limit == pytest.approx(np.sqrt(k * (2 * k - 1)), rel=1e-2)
    assert limit[0] == pytest.approx(1, abs=1e-5)


def test_tube_with_a_tip_mass():
    """VPCS, test SDLL15, in Hz: four decimals; the fourth mode is the stretching one."""
    beam = Beam.from_si(**TUBE)
    solution = solve(beam)
    assert beam.units is not None
    assert beam.units.hertz(solution.frequencies) == pytest.approx(TUBE_HERTZ, abs=1e-4)
    assert solution.families[3] == "stretching"


@pytest.mark.parametrize("row", INDEPENDENT, ids=str)
def test_independent_values(row):
    """Values computed independently of this project, to seven digits."""
    alpha, beta, gamma, delta, bending, stretching = row
    found = labelled(Beam(alpha, beta, gamma, delta, 70))
    assert [found[f"B{k}"] for k in (1, 2, 3, 4)] == pytest.approx(bending, rel=1e-7)
    assert found["S1"] == pytest.approx(stretching, rel=1e-7)


@pytest.mark.parametrize("row", INDEPENDENT_CORIOLIS, ids=str)
def test_independent_values_with_coriolis(row):
    """Values computed independently of this project, to seven digits."""
    alpha, beta, gamma, delta, published = row
    beam = Beam(alpha, beta, gamma, delta, 70)
    found = solve(beam, len(published), coriolis=True, tolerance=1e-8).frequencies
    assert found == pytest.approx(published, rel=1e-7)


@pytest.mark.parametrize(("gamma", "published"), LINEAR_AXIAL_CORIOLIS)
def test_coriolis_at_slenderness_70(gamma, published):
    """Hamza Cherif & Houmat neglect the stretch: green differs by a third of (gamma / mu)^2.

    From gamma 4 on this is less than the effect of Coriolis.
    """
    found = solve(Beam(gamma=gamma), 1, curvature="material", coriolis=True).frequencies[0]
    assert found == pytest.approx(published, rel=0.35 * (gamma / 70) ** 2)


@pytest.mark.parametrize("row", MEETINGS, ids=str)
def test_meetings_of_the_loci(row):
    """A bending and a stretching locus cross within a unit of the last digit given."""
    over, beam, bending, curvature, at, digit = row
    gaps = []
    for end in (at - digit, at + digit):
        found = labelled(beam.replace(**{over: end}), curvature=curvature)
        gaps.append(found[f"B{bending}"] - found["S1"])
    assert gaps[0] * gaps[1] < 0


def test_coriolis_turns_a_crossing_into_a_veering():
    """alpha = beta = 1: S1 meets B3 at gamma 4.4641; with Coriolis 0.241 is left at 4.650."""

    def gap(gamma, coriolis):
        solution = solve(Beam(alpha=1, gamma=gamma), 4, coriolis=coriolis, tolerance=1e-8)
        return solution.frequencies[3] - solution.frequencies[2]

    assert gap(4.4641, coriolis=False) < 1e-3
    least = gap(4.650, coriolis=True)
    assert least == pytest.approx(0.241, abs=5e-4)
    assert least < min(gap(4.645, coriolis=True), gap(4.655, coriolis=True))


@pytest.mark.parametrize(("strain", "delta", "limit", "digit"), LIMITS)
def test_no_equilibrium_beyond_the_limit(strain, delta, limit, digit):
    """Biot ends at gamma = mu pi / 2, hencky at a fold or where a logarithm bears no more."""
    below = solve(Beam(gamma=limit - 0.1, delta=delta), strain=strain)
    assert below.equilibrium.status == "stable"
    with pytest.raises(NoEquilibrium) as refusal:
        solve(Beam(gamma=limit + 1, delta=delta), strain=strain)
    assert refusal.value.limit == pytest.approx(limit, abs=digit)


def test_inward_beam_buckles():
    """delta = -1: the straight state is unstable in the plane of rotation beyond about 2.97.

    2.9939 without stretch: w'''' + gamma^2 (((1 - x)^2 / 2) w')' = gamma^2 w by a Runge-Kutta
    march. At mu 70 the shortening makes it 2.9960.
    """
    before, beyond = (solve(Beam(gamma=g, delta=-1), 2) for g in (2.9955, 2.9965))
    assert before.equilibrium.status == "stable"
    assert beyond.equilibrium.status == "unstable"
    assert np.isnan(beyond.frequencies[0])
    assert beyond.growth_rates[0] > 0


def test_nodes_of_the_paper():
    """Mode 2 at 0.78344, mode 3 at 0.50355 and 0.86768 (paper, figs. 16-19), to half a digit."""
    nodes = solve(Beam(), 3).nodes
    assert len(nodes[0]) == 0
    assert nodes[1] == pytest.approx([0.78344], abs=5e-6)
    assert nodes[2] == pytest.approx([0.50355, 0.86768], abs=5e-6)


def test_third_frequency_of_the_paper():
    """61.6982 is what 20 cubic elements give; the exact value is 61.697214."""
    assert solve(Beam(), 3, method="ancf", elements=20).frequencies[2] == pytest.approx(
        61.6982, abs=5e-5
    )
    assert solve(Beam(), 3, tolerance=1e-9).frequencies[2] == pytest.approx(61.697214, abs=5e-7)


# ---------------------------------------------------------------------------------------------
# Properties

alphas = st.floats(0, 100)
betas = st.floats(0, 1)
gammas = st.floats(0, 50)
deltas = st.floats(0, 20)
slendernesses = st.floats(10, 10000)
sizes = st.floats(-3, 3).map(lambda power: 10**power)


@given(alphas, betas, gammas, deltas, slendernesses)
def test_flapwise_and_chordwise_differ_by_the_speed(alpha, beta, gamma, delta, mu):
    """omega_flap^2 - omega_chord^2 = gamma^2 in each bending mode, whatever the beam."""
    beam = Beam(alpha, beta, min(gamma, 5 * mu), delta, mu)
    chord, flap = (solve(beam, 6, plane=plane) for plane in ("chordwise", "flapwise"))
    pairs = zip(bending(chord), bending(flap), strict=False)
    for (slow, slow_error), (fast, fast_error) in pairs:
        allowed = 2 * slow * slow_error + 2 * fast * fast_error
        assert abs(fast**2 - slow**2 - beam.gamma**2) <= allowed


def bending(solution):
    """(frequency, error) of the bending modes."""
    rows = zip(solution.families, solution.frequencies, solution.errors, strict=True)
    return [(frequency, error) for family, frequency, error in rows if family == "bending"]


@given(alphas, st.sampled_from([(2, 0), (3, 0), (3, 1), (4, 0), (4, 1), (4, 2)]))
def test_a_mass_at_a_node_changes_nothing(alpha, place):
    """At rest, a mass at a node of mode k leaves omega_k alone (paper, figs. 16-19)."""
    k, which = place
    free = solve(Beam(mu=RIGID), 4, tolerance=1e-9)
    node = float(free.nodes[k - 1][which])
    laden = solve(Beam(alpha=alpha, beta=node, mu=RIGID), 6, tolerance=1e-9)
    near = np.min(np.abs(laden.frequencies - free.frequencies[k - 1]))
    assert near <= 1e-8 * free.frequencies[k - 1]


@given(sizes, sizes, sizes, st.floats(0, 30), alphas, betas, st.floats(0, 5))
def test_frequencies_scale_with_time(length, density, stiffness, gamma, alpha, beta, delta):
    """Beams of one set of five numbers have frequencies [rad/s] that scale with 1 / T*."""
    area, second_moment = length**2 / 100, length**4 / 490000  # mu = 70
    time = 70 * length * np.sqrt(density / stiffness)
    beam = Beam.from_si(
        length=length,
        density=density,
        area=area,
        second_moment=second_moment,
        youngs_modulus=stiffness,
        hub_radius=delta * length,
        rotation_speed=gamma / time,
        mass=alpha * density * area * length,
        mass_position=beta * length,
    )
    assert beam.units is not None
    found, pure = solve(beam), solve(Beam(alpha, beta, gamma, delta, 70))
    scaled = beam.units.angular_frequency(found.frequencies) * time
    assert np.all(np.abs(scaled - pure.frequencies) <= 2 * (found.errors + pure.errors))
