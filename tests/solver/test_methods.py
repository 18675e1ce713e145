"""Finite elements, assumed modes, power series and Chebyshev collocation: against the oracle and
the limits of other methods; rates declared and measured; where they fail they say so."""

import numpy as np
import pytest
from helpers import differences, within_the_bars
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle import QUICK, truth
from strategies import beams

from beamviz import Beam, solve, solve_many
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.solver import METHODS
from beamviz.solver.constitutive import CURVATURES, STRAIN_LAWS

planes = st.sampled_from(["chordwise", "flapwise"])
curvatures = st.sampled_from(sorted(CURVATURES))
MODELS = {"strain": st.sampled_from(sorted(STRAIN_LAWS)), "curvature": curvatures, "plane": planes}

# method, beam, options, elements or terms, label, declared order of the error in the element length
# or in 1 / terms. Elements: bending 4; stretching 6; with an interior mass 1, as the shared
# gradient cannot jump there. Assumed modes converge algebraically, as long as cosh leaves digits: a
# mass at the tip has a shear force, and one anywhere an axial force, that no basis function has.
RATES = [
    ("ancf", Beam(), {}, 20, "B2", 4),
    ("ancf", Beam(alpha=1), {"curvature": "material"}, 10, "B3", 4),
    ("ancf", Beam(gamma=10), {}, 20, "B3", 4),
    ("ancf", Beam(alpha=1, gamma=10), {}, 20, "B2", 4),
    ("ancf", Beam(alpha=1, gamma=10), {"strain": "hencky"}, 20, "B2", 4),
    ("ancf", Beam(alpha=1, gamma=10, delta=1), {}, 20, "B2", 4),
    ("ancf", Beam(gamma=30, delta=0.5), {"strain": "biot"}, 40, "B2", 4),
    ("ancf", Beam(gamma=10, delta=1), {"curvature": "material"}, 20, "B2", 4),
    ("ancf", Beam(alpha=1, gamma=10), {"coriolis": True}, 20, "B1", 4),
    ("ancf", Beam(gamma=10, delta=1), {}, 8, "S1", 6),
    ("ancf", Beam(alpha=1, beta=0.5), {}, 20, "S1", 1),
    ("ancf", Beam(alpha=1, beta=0.5, gamma=10), {}, 20, "S1", 1),
    ("ancf", Beam(alpha=2, beta=0.25, gamma=20), {}, 20, "S1", 1),
    ("linear", Beam(gamma=10, delta=1), {}, 20, "B2", 4),
    ("linear", Beam(alpha=1, gamma=10), {}, 20, "B2", 4),
    ("linear", Beam(alpha=1, beta=0.5), {}, 20, "S1", 1),
    ("assumed-modes", Beam(gamma=2), {}, 5, "B1", 4.8),
    ("assumed-modes", Beam(gamma=10), {}, 5, "B2", 4.4),
    ("assumed-modes", Beam(alpha=1, gamma=2), {}, 5, "B2", 3),
    ("assumed-modes", Beam(alpha=1, gamma=2), {}, 5, "S1", 1),
    ("assumed-modes", Beam(alpha=1, beta=0.5, gamma=2), {}, 5, "B3", 4),
    ("assumed-modes", Beam(alpha=1, beta=0.5, gamma=10), {}, 5, "S1", 1),
]


@pytest.mark.parametrize(("method", "beam", "options", "number", "label", "declared"), RATES)
def test_methods_converge_as_declared(method, beam, options, number, label, declared):
    """The error against the converged solution of the same model, at each doubling of a number."""
    limit = "foac" if METHODS[method].rigid_tension else "auto"
    converged = solve(beam, 6, method=limit, tolerance=1e-11, **options)
    resolution, errors = METHODS[method].resolution.option, []
    for factor in (1, 2, 4) if resolution == "elements" else (1, 2):
        given = {"method": method, resolution: factor * number, "modes": min(6, factor * number)}
        found = solve(beam, **given, **options)
        errors.append(differences(found, converged)[0][found.labels.index(label)])
    observed = np.log2(np.array(errors[:-1]) / errors[1:])
    assert observed == pytest.approx(declared, abs=0.3)


def test_families_do_not_mix():
    """A shape has one component, even where bending and stretching are equal to 1e-3."""
    solution = solve(Beam(alpha=1, gamma=4.46417), 6, method="ancf")
    assert min(np.diff(solution.frequencies)) < 1e-2
    shapes = solution.displacement(np.linspace(0, 1, 11))
    assert np.all(shapes[0] == 0)
    assert np.all(np.any(shapes, axis=0).sum(axis=0) == 1)


@pytest.mark.parametrize("strain", STRAIN_LAWS)
@pytest.mark.parametrize("curvature", CURVATURES)
@pytest.mark.parametrize("method", ["auto", "ancf"])
def test_all_models_agree_at_rest(strain, curvature, method):
    """Strain laws and curvature measures differ in nothing at rest."""
    beam = Beam(alpha=0.5, beta=0.4)
    found = solve(beam, method=method, strain=strain, curvature=curvature)
    assert found.frequencies == pytest.approx(solve(beam, method=method).frequencies, rel=1e-8)
    assert found.equilibrium.tip == pytest.approx([1, 0], abs=1e-14)


@settings(max_examples=15)
@given(
    beam=beams(alpha=(0, 100), beta=(1, 1), gamma=(0, 0), delta=(0, 20), mu=(10, 10000)),
    speed=st.floats(0, 1),
    curvature=curvatures,
)
def test_green_always_has_an_outward_state(beam, speed, curvature):
    """With no mass or a tip mass and delta >= 0: in tension everywhere and stable."""
    beam = beam.replace(gamma=speed * min(200, 5 * beam.mu))
    state = solve(beam, method="ancf", curvature=curvature).equilibrium
    assert state.status == "stable"
    assert state.stretch(np.linspace(0, 1, 41)).min() > 1 - 1e-6


@settings(max_examples=5)
@given(
    beam=beams(alpha=(0, 100), beta=(0.05, 1), gamma=(0, 25), delta=(0, 2), mu=(50, 1000)), **MODELS
)
def test_chebyshev_against_the_oracle(beam, **model):
    """Random beams whose boundary layers 60 polynomials resolve, with any strain law."""
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
@settings(max_examples=10)
@given(
    beam=beams(beta=(0.05, 1), gamma=(0, 15), delta=(-1, 1), mu=(70, 70)),
    alpha=st.sampled_from([0.0, 0.1, 1.0, 30.0]),
    plane=planes,
)
def test_power_series_converge_for_rigid_tension(beam, alpha, plane):
    """The limit of foac to 8 digits, unstable beams and interior masses included, with shapes;
    as long as the beam is not much longer than its bending layers."""
    tension = 0.5 + abs(beam.delta) + alpha * abs(beam.beta + beam.delta)
    beam = beam.replace(alpha=alpha, gamma=min(beam.gamma, 12 / tension**0.5))
    found = solve(beam, method="power-series", plane=plane, terms=120)
    converged = solve(beam, method="foac", plane=plane, tolerance=1e-10)
    slack = 1e-8 * (abs(converged.omega_squared) + beam.gamma**2) + converged.omega_squared_errors
    assert np.all(abs(found.omega_squared - converged.omega_squared) <= slack)
    x = np.linspace(0, 1, 5)
    apart = np.diff(converged.omega_squared, prepend=-np.inf, append=np.inf)
    for k in range(5):
        if min(apart[k], apart[k + 1]) > 1.0:
            assert abs(found.shape(k, x)) == pytest.approx(abs(converged.shape(k, x)), abs=1e-4)


@pytest.mark.parametrize("beta", [0.4, 1.0])
@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
def test_power_series_of_a_mass_on_a_hub(beta, plane):
    """The tension inboard of the mass is that at its distance from the axis: as foac has it."""
    beam = Beam(alpha=0.8, beta=beta, gamma=4, delta=0.6)
    found = solve(beam, method="power-series", plane=plane, terms=100)
    converged = solve(beam, method="foac", plane=plane, tolerance=1e-10)
    assert found.frequencies == pytest.approx(converged.frequencies, rel=1e-8)


@settings(max_examples=12)
@given(
    beam=beams(alpha=(0, 3), gamma=(0, 30), delta=(-1, 1), mu=(70, 70)),
    terms=st.integers(6, 14),
    coriolis=st.booleans(),
)
def test_error_bars_of_assumed_modes_hold(beam, terms, coriolis):
    """The reported errors cover the distance to foac, with few terms and with lost digits."""
    found = solve(beam, method="assumed-modes", terms=terms, coriolis=coriolis)
    converged = solve(beam, method="foac", coriolis=coriolis, tolerance=1e-8)
    if found.labels == converged.labels:
        assert within_the_bars(found, converged, 1e-9 * abs(converged.omega_squared))


@pytest.mark.parametrize(
    ("method", "options", "modes"),
    [
        ("ancf", {"elements": 3}, 6),
        ("assumed-modes", {"terms": 6}, 6),
        ("power-series", {}, 8),
    ],
)
def test_extra_modes_are_those_that_the_method_has(method, options, modes):
    """Those beyond the number of elements or terms are left out."""
    beam = Beam(gamma=4, delta=-1)
    (found,) = solve_many([beam], extra_modes=2, modes=6, method=method, **options)
    assert len(found.frequencies) == modes


def test_a_mode_without_a_partner_has_no_finite_error():
    """Lost digits make a bending mode the lowest: two stretching modes are lower, and its error is
    more than its distance to either of them."""
    beam = Beam(alpha=1.6, beta=0.015, gamma=190, delta=0.4, mu=38)
    found = solve(beam, 1, "assumed-modes", terms=100)
    converged = solve(beam, 5, "foac", tolerance=1e-9)
    place = converged.labels.index(found.labels[0])
    away = abs(found.omega_squared[0] - converged.omega_squared[place])
    assert away <= found.omega_squared_errors[0] + converged.omega_squared_errors[place]


def test_too_many_assumed_modes_say_that_fewer_help():
    """Where rounding leaves no stiffness to vibrate with."""
    beam, options = Beam(gamma=60, delta=-1), {"method": "assumed-modes"}
    with pytest.raises(NotConverged, match=r"terms = 100: .* fewer terms help"):
        solve(beam, terms=100, **options)
    assert solve(beam, terms=10, **options).equilibrium.status == "unstable"


@pytest.mark.parametrize("method", ["linear", "power-series", "assumed-modes", "foac"])
def test_a_beam_whose_lowest_mode_stretches_has_buckled_chordwise(method):
    """What its chordwise modes say, although the one mode asked for does not bend."""
    beam = Beam(alpha=100, gamma=2.42, delta=-0.065, mu=11.3)
    flapwise, chordwise = (solve(beam, 1, method, plane=p) for p in ("flapwise", "chordwise"))
    assert flapwise.labels == ("S1",)
    assert flapwise.equilibrium.buckled_chordwise
    assert chordwise.equilibrium.status == "unstable"


@pytest.mark.parametrize(
    ("method", "gamma", "terms", "least", "first", "others"),
    [
        ("assumed-modes", 2, 10, 0, 1e-6, 1e-6),
        ("assumed-modes", 2, 14, 0, np.inf, np.inf),  # beyond twelve, cosh cancels
        ("assumed-modes", 2, 20, 0, np.inf, np.inf),
        ("power-series", 10, 200, 0, 1e-9, np.inf),
        *(("power-series", gamma, 200, 0, np.inf, np.inf) for gamma in (20, 30, 40)),  # by speed
        ("power-series", 20, 40, 1, np.inf, np.inf),  # too few powers for any digit
        ("power-series", 30, 60, 1, np.inf, np.inf),
    ],
)
def test_lost_digits_are_reported(method, gamma, terms, least, first, others):
    """The errors cover the distance to foac, however few digits are left, also of a first frequency
    that is wrong altogether."""
    found = solve(Beam(gamma=gamma), method=method, terms=terms)
    converged = solve(Beam(gamma=gamma), method="foac", tolerance=1e-10, modes=10)
    away, allowed = differences(found, converged)
    assert np.all(away <= allowed)
    relative = (
        away / converged.frequencies[[converged.labels.index(label) for label in found.labels]]
    )
    assert least <= relative[found.labels.index("B1")] < first
    assert relative.max() < others


@pytest.mark.parametrize(
    "beam", [Beam(gamma=2), Beam(1, 1, 10), Beam(1, 0.5, 10), Beam(0, 1, 5, -1)]
)
def test_chebyshev_converges_exponentially(beam):
    """Each 4 orders more divide the largest of five errors by at least 20, down to rounding."""
    converged = solve(beam, tolerance=1e-11).omega_squared
    found = [solve(beam, method="chebyshev", terms=n).omega_squared for n in (8, 12, 16, 24, 60)]
    errors = abs(np.array(found) / converged - 1).max(axis=1)
    assert np.all(errors[:2] > 20 * errors[1:3])
    assert np.all(errors[3:] < 1e-9)


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


def test_power_series_of_a_compressed_beam():
    """Its modes lie from minus the fourth part of the squared compression upward. Solutions that do
    not grow cost digits too: with more compression none is left, whatever the number of terms."""
    beam = Beam(gamma=30, delta=-1, mu=100)
    found = solve(beam, 3, "power-series", terms=200)
    converged = solve(beam, 3, "foac", tolerance=1e-9)
    assert found.growth_rates == pytest.approx(converged.growth_rates, rel=1e-3)
    with pytest.raises(NotConverged, match="method foac"):
        solve(beam.replace(gamma=60), method="power-series", terms=1000)


@pytest.mark.parametrize(("beta", "places"), [(2 / 3, [4, 5, 6]), (0.4, [3, 5, 6])])
def test_power_series_find_stretching_modes_close_to_each_other(beta, places):
    """A heavy mass near a node of both the bar inboard of it and the bar beyond: two frequencies
    differ by a thousandth."""
    beam = Beam(alpha=100, beta=beta, mu=10)
    found = solve(beam, 8, "power-series")
    converged = solve(beam, 8, "foac", tolerance=1e-10)
    assert found.labels == converged.labels
    assert [k for k in range(2, 7) if found.families[k] == "stretching"] == places
    assert found.frequencies == pytest.approx(converged.frequencies, rel=1e-8)


@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
@pytest.mark.parametrize(
    ("beam", "terms"),
    [
        (Beam(15.3, 0.51, 200, 4.39, 255), 100),
        (Beam(2.08, 1, 159, 15.8, 83), 32),
        (Beam(1.68, 0.41, 177, 8.7, 111), 100),
    ],
)
def test_collocation_of_an_outward_beam_is_stable(beam, terms, plane):
    """Where layers are not resolved some omega^2 are rounding, -1e16 too: no modes of the beam."""
    found = solve(beam, 2, "chebyshev", terms=terms, plane=plane)
    converged = solve(beam, 2, plane=plane)
    assert found.equilibrium.status == "stable"
    assert found.frequencies == pytest.approx(converged.frequencies, rel=1e-2)


def test_shapes_have_unit_modal_mass_where_layers_are_not_resolved():
    """The integral of their squares is of twice the order of the polynomials."""
    x, weights = np.polynomial.legendre.leggauss(100)
    shapes = solve(Beam(gamma=160, delta=2), method="chebyshev").displacement((x + 1) / 2)
    masses = weights / 2 @ (shapes**2).sum(axis=1)
    assert masses == pytest.approx(np.ones(5), abs=1e-9)


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
    converged = solve(beam, method=model, **options)
    assert found.labels == converged.labels
    for k in range(5):
        assert abs(found.shape(k, x)) == pytest.approx(abs(converged.shape(k, x)), abs=near)
    assert found.equilibrium.tip == pytest.approx(converged.equilibrium.tip, abs=1e-9)
    assert found.equilibrium.stretch(x) == pytest.approx(converged.equilibrium.stretch(x), abs=1e-8)
