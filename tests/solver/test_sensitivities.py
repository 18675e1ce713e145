"""Sensitivities of frequencies to the numbers of the beam, against independent derivatives."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from strategies import beams, blades

from beamviz import Beam, InvalidInput, NoEquilibrium, loci, solve
from beamviz.presets import PRESETS

CLAMPED_MODES = (1.8751040687, 4.6940911330, 7.8547574382)  # beta L of a clamped beam


def difference(beam, number, **options):
    """The derivatives of the frequencies by the difference of two converged solutions."""
    value = getattr(beam, number)
    step = 1e-4 * max(abs(value), 0.3)
    ends = [
        solve(beam.replace(**{number: value + side * step}), tolerance=1e-11, **options)
        for side in (-1, 1)
    ]
    return (ends[1].frequencies - ends[0].frequencies) / (2 * step)


def check(beam, modes, **options):
    """The sensitivities of modes whose frequencies keep a distance from the others."""
    solution = solve(beam, tolerance=1e-10, **options)
    gaps = np.diff(solution.frequencies)
    for number, rates in solution.sensitivities.items():
        expected = difference(beam, number, **options)
        for k in range(modes):
            scale = solution.frequencies[k]
            if gaps[max(k - 1, 0) : k + 1].min() >= 0.05 * scale:
                near = pytest.approx(expected[k], rel=1e-3, abs=1e-5 * scale)
                assert rates[k] == near, (number, k)


@settings(max_examples=4)
@given(
    beams(alpha=(0.1, 5), beta=(0.1, 0.9), gamma=(1, 30), delta=(0.1, 2), mu=(60, 500)),
    blades(),
)
def test_sensitivities_are_those_of_differences(beam, blade):
    """Of random beams and blades."""
    try:
        check(beam, 3)
        check(beam.replace(blade=blade), 2, plane="flapwise")
    except NoEquilibrium:
        return


@pytest.mark.parametrize(
    ("beam", "options"),
    [
        (Beam(alpha=0.7, beta=0.3, gamma=5, mu=40), {"coriolis": True}),
        (Beam(alpha=0.7, beta=0.3, gamma=5, flap=0.25, pitch=30, twist=10, root=5.0), "both"),
        (Beam(alpha=0.2, beta=0.6, gamma=3, delta=-1.2, mu=20), {"state": "bent"}),
        (Beam(alpha=0.2, beta=0.6, gamma=3, mu=40), {"method": "ancf"}),
    ],
)
def test_sensitivities_of_other_models(beam, options):
    check(beam, 3, **({"plane": options} if isinstance(options, str) else options))


def test_of_a_tip_mass_by_the_rayleigh_quotient():
    """d omega / d alpha = - omega w(L)^2 / 2 of a mode of unit modal mass, and w(L) = 2 where there
    is no mass yet: a derivative on one side."""
    solution = solve(Beam(alpha=0), modes=3, tolerance=1e-10)
    expected = [-2 * root**2 for root in CLAMPED_MODES]
    assert solution.sensitivities["alpha"] == pytest.approx(expected, rel=1e-7)
    assert solution.sensitivities["gamma"] == pytest.approx(np.zeros(3), abs=1e-6)


def test_of_a_mass_that_leaves_the_tip():
    """A derivative on one side, from the tip inward."""
    beam, step = Beam(alpha=1, gamma=3), 1e-3
    places = [beam.replace(beta=1 - k * step) for k in range(3)]
    tip, near, farther = (solve(each, 3, tolerance=1e-11).frequencies for each in places)
    expected = (3 * tip - 4 * near + farther) / (2 * step)
    assert solve(beam, 3).sensitivities["beta"] == pytest.approx(expected, rel=1e-3)


def test_modes_keep_their_order_where_loci_cross():
    """Flap and lag of a round section at rest have one frequency: only flap changes with the
    flapwise stiffness, by omega / 2."""
    solution = solve(Beam(), modes=2, plane="both")
    rates = dict(zip(solution.labels, solution.sensitivities["flap"], strict=True))
    assert rates["F1"] == pytest.approx(solution.frequencies[0] / 2, rel=1e-6)
    assert rates["L1"] == pytest.approx(0, abs=1e-6)


def test_only_numbers_that_apply_have_a_sensitivity():
    assert [*solve(Beam()).sensitivities] == ["alpha", "beta", "gamma", "delta", "mu"]
    assert "mu" not in solve(Beam(mu=1e6)).sensitivities
    assert "root" in solve(Beam(root=3.0)).sensitivities
    assert {"flap", "pitch", "twist"} <= solve(Beam(flap=2), plane="both").sensitivities.keys()
    with pytest.raises(InvalidInput):
        solve(Beam(pitch=10, flap=2))


def test_a_mode_without_a_frequency_has_no_sensitivity():
    solution = solve(Beam(gamma=4, delta=-1), modes=2)
    assert math.isnan(solution.frequencies[0])
    assert np.isnan(solution.sensitivities["gamma"][0])
    assert np.isfinite(solution.sensitivities["gamma"][1])


def test_modes_beside_one_that_diverges_have_those_of_differences():
    """Of an inward beam beyond buckling, with Coriolis forces."""
    beam = Beam(alpha=0.5, gamma=4, delta=-1)
    rates = solve(beam, modes=4, coriolis=True).sensitivities
    for number in ("alpha", "gamma", "delta"):
        assert math.isnan(rates[number][0])
        expected = difference(beam, number, modes=4, coriolis=True)
        assert rates[number][1:] == pytest.approx(expected[1:], rel=1e-4)


@pytest.mark.parametrize("coriolis", [1.0, 0.1])
def test_beside_a_veering(coriolis):
    """Where modes exchange their shapes within a small part of the step of another number, as those
    of differences of much smaller steps."""
    beam = Beam(alpha=1, beta=0.5)
    path = loci(beam, "gamma", np.linspace(5, 12, 71), 5, coriolis=coriolis)
    veering = min((e for e in path.events if e.kind == "veering"), key=lambda each: each.gap)
    beam = beam.replace(gamma=veering.at + 0.15 * veering.gap)
    rates = solve(beam, tolerance=1e-12, coriolis=coriolis).sensitivities
    for number in ("gamma", "alpha", "mu"):
        value, step = getattr(beam, number), 1e-6 * max(1.0, getattr(beam, number))
        low, high = (
            solve(beam.replace(**{number: value + side * step}), tolerance=1e-12, coriolis=coriolis)
            for side in (-1, 1)
        )
        expected = (high.frequencies - low.frequencies) / (2 * step)
        assert rates[number] == pytest.approx(expected, rel=1e-4)


def test_of_a_mass_at_the_light_tip_of_a_blade():
    """At rest, by the Rayleigh quotient: d omega / d alpha = - omega w(L)^2 / (2 m)."""
    beam = PRESETS["iea-3.4mw-blade"].beam.replace(gamma=0)
    solution = solve(beam, modes=3, plane="both", tolerance=1e-8)
    x = np.linspace(0, 1, 20001)
    expected = []
    for k, omega in enumerate(solution.frequencies):
        squares = (solution.shape(k, x) ** 2).sum(axis=1)
        mass = np.trapezoid(beam.blade.at("mass", x) * squares, x)
        expected.append(-omega * squares[-1] / (2 * mass))
    assert solution.sensitivities["alpha"] == pytest.approx(expected, rel=1e-4)
