"""Assumed modes, power series and Chebyshev collocation: against the oracle, published values and
the limits of other methods; rates declared and measured; where they fail they say so."""

import numpy as np
import pytest
from helpers import within_the_bars
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle import QUICK, truth
from strategies import beams

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.solver import solve


def relative_errors(found, exact):
    """Relative differences of the frequencies of two solutions."""
    return abs(found.frequencies / exact.frequencies - 1)


@pytest.mark.parametrize("seed", range(25))
def test_chebyshev_against_the_oracle(seed):
    """Random beams whose boundary layers 60 polynomials resolve, with any strain law."""
    rng = np.random.default_rng([4, seed])
    beam = Beam(
        rng.choice([0.0, 10 ** rng.uniform(-2, 2)]),
        rng.choice([1.0, rng.uniform(0.05, 0.95)]),
        rng.uniform(0, 25),
        rng.uniform(0, 2),
        10 ** rng.uniform(1.7, 3),
    )
    model = {
        "strain": str(rng.choice(["green", "biot", "hencky"])),
        "curvature": str(rng.choice(["spatial", "material"])),
        "plane": str(rng.choice(["chordwise", "flapwise"])),
    }
    try:
        solution = solve(beam, method="chebyshev", terms=60, **model)
    except NoEquilibrium:
        with pytest.raises(NoEquilibrium):
            solve(beam, **model)
        return
    expected = truth(beam, resolutions=QUICK, **model)
    assert solution.families == expected.families
    away = abs(solution.frequencies - expected.frequencies)
    assert np.all(away <= 1e-8 * expected.frequencies + expected.differences)


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(
    beam=beams(beta=(0.05, 1), gamma=(0, 15), delta=(-1, 1), mu=(70, 70)),
    alpha=st.sampled_from([0.0, 0.1, 1.0, 30.0]),
    plane=st.sampled_from(["chordwise", "flapwise"]),
)
def test_power_series_are_exact_for_rigid_tension(beam, alpha, plane):
    """The limit of foac to 8 digits, unstable beams and interior masses included, with shapes;
    as long as the beam is not much longer than its bending layers."""
    tension = 0.5 + abs(beam.delta) + alpha * abs(beam.beta + beam.delta)
    beam = beam.replace(alpha=alpha, gamma=min(beam.gamma, 12 / tension**0.5))
    found = solve(beam, method="power-series", plane=plane, terms=120)
    exact = solve(beam, method="foac", plane=plane, tolerance=1e-10)
    slack = 1e-8 * (abs(exact.omega_squared) + beam.gamma**2) + exact.omega_squared_errors
    assert np.all(abs(found.omega_squared - exact.omega_squared) <= slack)
    x = np.linspace(0, 1, 5)
    apart = np.diff(exact.omega_squared, prepend=-np.inf, append=np.inf)
    for k in range(5):
        if min(apart[k], apart[k + 1]) > 1.0:
            assert abs(found.shape(k, x)) == pytest.approx(abs(exact.shape(k, x)), abs=1e-4)


@settings(max_examples=25, deadline=None)
@given(
    beam=beams(alpha=(0, 3), gamma=(0, 30), delta=(-1, 1), mu=(70, 70)),
    terms=st.integers(6, 14),
    coriolis=st.booleans(),
)
def test_error_bars_of_assumed_modes_hold(beam, terms, coriolis):
    """The reported errors cover the distance to foac, with few terms and with lost digits."""
    found = solve(beam, method="assumed-modes", terms=terms, coriolis=coriolis)
    exact = solve(beam, method="foac", coriolis=coriolis, tolerance=1e-8)
    if found.labels == exact.labels:
        assert within_the_bars(found, exact, 1e-9 * abs(exact.omega_squared))


# beam, mode (from 0), declared order in 1 / terms of the frequency's error. A mass at the tip has
# a shear force, and one anywhere an axial force, that no basis function has.
ASSUMED_RATES = [
    (Beam(gamma=2), 0, 4.8),
    (Beam(gamma=10), 1, 4.4),
    (Beam(alpha=1, gamma=2), 1, 3),
    (Beam(alpha=1, gamma=2), 3, 1),
    (Beam(alpha=1, beta=0.5, gamma=2), 2, 4),
    (Beam(alpha=1, beta=0.5, gamma=10), 2, 1),
]


@pytest.mark.parametrize(("beam", "mode", "declared"), ASSUMED_RATES)
def test_assumed_modes_converge_as_declared(beam, mode, declared):
    """Algebraically, as long as cosh leaves digits."""
    exact = solve(beam, method="foac", tolerance=1e-11)
    coarse, fine = (solve(beam, method="assumed-modes", terms=terms) for terms in (5, 10))
    assert coarse.labels[mode] == fine.labels[mode] == exact.labels[mode]
    far, near = (relative_errors(found, exact)[mode] for found in (coarse, fine))
    assert np.log2(far / near) == pytest.approx(declared, abs=0.3)


@pytest.mark.parametrize(
    ("method", "gamma", "terms", "first", "others"),
    [
        ("assumed-modes", 2, 10, 1e-6, 1e-6),
        *(("assumed-modes", 2, n, np.inf, np.inf) for n in (14, 20)),  # beyond twelve, cosh cancels
        ("power-series", 10, 200, 1e-9, np.inf),
        *(("power-series", gamma, 200, np.inf, np.inf) for gamma in (20, 30, 40)),  # lost by speed
    ],
)
def test_lost_digits_are_reported(method, gamma, terms, first, others):
    """The errors cover the distance to foac, however few digits are left."""
    found = solve(Beam(gamma=gamma), method=method, terms=terms)
    exact = solve(Beam(gamma=gamma), method="foac", tolerance=1e-10)
    assert np.all(abs(found.frequencies - exact.frequencies) <= found.errors + exact.errors)
    errors = relative_errors(found, exact)
    assert errors[0] < first
    assert errors.max() < others


@pytest.mark.parametrize(
    "beam", [Beam(gamma=2), Beam(1, 1, 10), Beam(1, 0.5, 10), Beam(0, 1, 5, -1)]
)
def test_chebyshev_converges_exponentially(beam):
    """Each 4 orders more divide the largest of five errors by at least 20, down to rounding."""
    exact = solve(beam, tolerance=1e-11).omega_squared
    found = [solve(beam, method="chebyshev", terms=n).omega_squared for n in (8, 12, 16, 24, 60)]
    errors = abs(np.array(found) / exact - 1).max(axis=1)
    assert np.all(errors[:2] > 20 * errors[1:3])
    assert np.all(errors[3:] < 1e-9)


@pytest.mark.parametrize(("gamma", "terms"), [(20, 40), (30, 60)])
def test_too_few_powers_for_any_digit(gamma, terms):
    """The error bar covers a first frequency that is wrong altogether."""
    found = solve(Beam(gamma=gamma), method="power-series", terms=terms)
    exact = solve(Beam(gamma=gamma), method="foac", tolerance=1e-10)
    here, there = found.labels.index("B1"), exact.labels.index("B1")
    away = abs(found.omega_squared[here] - exact.omega_squared[there])
    assert exact.omega_squared[there] < away <= found.omega_squared_errors[here]


@pytest.mark.parametrize(
    ("gamma", "terms", "message"),
    [
        (60, 400, "gamma = 60: power-series is ill-conditioned here.* method foac"),
        (40, 40, "terms = 40: .* more terms may help"),
        (0, 12, "terms = 12: .* more terms may help"),
    ],
)
def test_power_series_that_do_not_converge(gamma, terms, message):
    """The message says what helps."""
    with pytest.raises(NotConverged, match=message):
        solve(Beam(gamma=gamma), method="power-series", terms=terms)


@pytest.mark.parametrize(
    ("method", "options", "model", "near"),
    [
        ("assumed-modes", {"terms": 10}, "foac", 1e-2),
        ("assumed-modes", {"terms": 10, "coriolis": True}, "foac", 1e-2),
        ("power-series", {}, "foac", 1e-7),
        ("chebyshev", {}, "auto", 1e-7),
    ],
)
def test_shapes_are_those_of_the_model(method, options, model, near):
    """Of unit modal mass, on both sides of a mass, along the beam and across it."""
    beam, x = Beam(alpha=0.5, beta=0.4, gamma=3), np.linspace(0, 1, 11)
    found = solve(beam, method=method, **options)
    options = {"coriolis": options.get("coriolis", False), "tolerance": 1e-9}
    exact = solve(beam, method=model, **options)
    assert found.labels == exact.labels
    for k in range(5):
        assert abs(found.shape(k, x)) == pytest.approx(abs(exact.shape(k, x)), abs=near)
    assert found.equilibrium.tip == pytest.approx(exact.equilibrium.tip, abs=1e-9)
    assert found.equilibrium.stretch(x) == pytest.approx(exact.equilibrium.stretch(x), abs=1e-8)
