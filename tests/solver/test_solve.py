"""solve(): every method against the others, failures told apart, nothing lost on the way."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from strategies import beams

from beamviz.beam import MAX_GAMMA_OVER_MU, PARAMETERS, Beam
from beamviz.errors import InvalidInput, NoEquilibrium, NotConverged
from beamviz.solver import Solution, solve, solve_many

NONLINEAR = ("auto", "ancf", "ancf-planar")
STRAIGHT = Beam(alpha=1, beta=0.5, gamma=10)  # the beam of the README


CORNERS = [
    Beam(alpha, beta, min(gamma, MAX_GAMMA_OVER_MU * mu), delta, mu)
    for alpha, beta, gamma, delta, mu in itertools.product(
        PARAMETERS["alpha"].limits,
        (0.0, 1e-6, 0.5, 1 - 1e-6, 1.0),
        PARAMETERS["gamma"].limits,
        (0.0, 20.0),
        PARAMETERS["mu"].limits,
    )
]


@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
@pytest.mark.parametrize("coriolis", [False, True])
def test_every_corner_of_the_accepted_domain_solves(plane, coriolis):
    """With green strain and delta >= 0 every beam has a stable answer within the tolerance."""
    for beam in CORNERS:
        solution = solve(beam, plane=plane, coriolis=coriolis)
        assert solution.equilibrium.status == "stable", beam
        assert solution.equilibrium.stretch(np.linspace(0, 1, 9)).min() > 0.999, beam
        assert np.all(np.diff(solution.frequencies) >= 0), beam
        rounding = 1e-9 * solution.frequencies[-1]  # gamma^2 may cancel all but this
        assert np.all(solution.errors <= 1e-6 * solution.frequencies + rounding), beam


@settings(max_examples=40, deadline=None)
@given(beam=beams(gamma=(0, 10)), coriolis=st.booleans(), flapwise=st.booleans())
def test_both_ways_through_the_papers_elements_agree(beam, coriolis, flapwise):
    """The split form and the full planar tangent are the same method, to rounding."""
    options = {"coriolis": coriolis, "plane": "flapwise" if flapwise else "chordwise"}
    split = solve(beam, method="ancf", elements=8, **options)
    full = solve(beam, method="ancf-planar", elements=8, **options)
    assert split.omega_squared == pytest.approx(full.omega_squared, rel=1e-8, abs=1e-8)
    assert split.labels == full.labels


@settings(max_examples=30, deadline=None)
@given(beam=beams(gamma=(0, 20)), beta=st.floats(0.2, 1), coriolis=st.booleans())
def test_the_papers_elements_converge_to_the_default(beam, beta, coriolis):
    """Finer elements come closer to the default method, and their error bars say how far."""
    beam = beam.replace(beta=beta)
    exact = solve(beam, coriolis=coriolis, tolerance=1e-9)
    coarse = solve(beam, method="ancf", elements=8, coriolis=coriolis)
    fine = solve(beam, method="ancf", elements=32, coriolis=coriolis)
    far, near = (abs(s.frequencies - exact.frequencies) for s in (coarse, fine))
    assert np.all(near <= fine.errors + exact.errors)
    assert np.all(far <= coarse.errors + exact.errors)
    assert near.max() <= 0.7 * far.max() + 1e-6


@settings(max_examples=60, deadline=None)
@given(beam=beams(), coriolis=st.booleans(), modes=st.integers(1, 12))
def test_error_bars_hold_against_a_finer_solve(beam, coriolis, modes):
    """What a tolerance of 1e-3 reports covers what a tolerance of 1e-9 finds."""
    rough = solve(beam, modes=modes, coriolis=coriolis, tolerance=1e-3)
    fine = solve(beam, modes=modes, coriolis=coriolis, tolerance=1e-9)
    assert np.all(rough.errors <= 1e-3 * rough.frequencies)
    assert np.all(abs(rough.frequencies - fine.frequencies) <= rough.errors + fine.errors)


@settings(max_examples=30, deadline=None)
@given(beam=beams())
def test_the_planes_differ_by_gamma_squared(beam):
    """omega_flap^2 - omega_chord^2 = gamma^2 of every bending mode (Coriolis off)."""
    chord = solve(beam, modes=8)
    flap = solve(beam, modes=8, plane="flapwise")
    for label in set(chord.labels) & set(flap.labels) - {"S1", "S2", "S3", "S4", "S5"}:
        i, k = chord.labels.index(label), flap.labels.index(label)
        slack = chord.omega_squared_errors[i] + flap.omega_squared_errors[k]
        assert flap.omega_squared[k] - chord.omega_squared[i] == pytest.approx(
            beam.gamma**2, abs=slack + 1e-9
        )


@settings(max_examples=25, deadline=None)
@given(beam=beams(gamma=(0, 10)), k=st.integers(0, 4), coriolis=st.booleans())
def test_shapes_have_unit_modal_mass(beam, k, coriolis):
    """int rho |phi|^2 = 1, the concentrated mass included, by a quadrature of its own."""
    solution = solve(beam, coriolis=coriolis, tolerance=1e-9)
    points, weights = np.polynomial.legendre.leggauss(60)
    parts = [0.0, beam.beta, 1.0] if 0 < beam.beta < 1 else [0.0, 1.0]
    mass = beam.alpha * (abs(solution.shape(k, beam.beta)) ** 2).sum()
    for a, b in itertools.pairwise(parts):
        x = a + (b - a) * (points + 1) / 2
        mass += (b - a) / 2 * weights @ (abs(solution.shape(k, x)) ** 2).sum(axis=1)
    assert mass == pytest.approx(1, abs=1e-6)


def test_many_at_once_are_the_same_as_one_by_one():
    """solve_many() differs from solve() only within the error bars, and holds errors in place."""
    sweep = [Beam(alpha=1, beta=0.5, gamma=gamma, mu=30) for gamma in np.linspace(0, 60, 40)]
    for options in ({}, {"strain": "biot"}, {"coriolis": True}, {"method": "ancf"}):
        for beam, found in zip(sweep, solve_many(sweep, **options), strict=True):
            if isinstance(found, NoEquilibrium):
                with pytest.raises(NoEquilibrium) as caught:
                    solve(beam, **options)
                assert caught.value.limit == found.limit
                continue
            alone = solve(beam, **options)
            assert found.labels == alone.labels
            assert np.all(abs(found.frequencies - alone.frequencies) <= found.errors + alone.errors)
    assert solve_many([]) == []


@pytest.mark.parametrize("method", NONLINEAR)
@pytest.mark.parametrize(
    ("strain", "delta", "limit", "digits"),
    [
        # physics.md 3.7: a fold of the whole beam; the root reaches f = e; resonance of a
        # linear bar, whatever delta.
        ("hencky", 0.0, 45.420, 3),
        ("hencky", 1.0, 31.4887, 4),
        ("biot", 0.0, 70 * math.pi / 2, 6),
        ("biot", 3.0, 70 * math.pi / 2, 6),
    ],
)
def test_the_end_of_equilibrium_is_found_and_named(method, strain, delta, limit, digits):
    """Beyond the limit the error carries it; below it there is an answer."""
    with pytest.raises(NoEquilibrium) as caught:
        solve(Beam(gamma=limit * 1.02, delta=delta), strain=strain, method=method)
    near = 0.5 * 10**-digits if method == "auto" else 1e-3 * limit  # 20 elements see f less well
    assert caught.value.limit == pytest.approx(limit, abs=near)
    assert f"no equilibrium beyond gamma = {caught.value.limit:.6g}"[:34] in str(caught.value)
    below = solve(Beam(gamma=0.97 * limit, delta=delta), strain=strain, method=method)
    assert below.equilibrium.status == "stable"
    assert below.equilibrium.stretch(np.linspace(0, 1, 101)).min() > 0


@pytest.mark.parametrize("method", NONLINEAR)
def test_an_inward_beam_buckles(method):
    """Compressed from delta = -1 the straight state is unstable beyond gamma = 2.9939 (Ritz with
    ten powers of x, rigid axis; 2.9960 at mu = 70), and says so with a growth rate."""
    stable = solve(Beam(gamma=2.99, delta=-1), method=method)
    unstable = solve(Beam(gamma=3.00, delta=-1), method=method)
    assert stable.equilibrium.status == "stable"
    assert unstable.equilibrium.status == "unstable"
    assert np.isnan(unstable.frequencies[0])
    assert unstable.growth_rates[0] > 0
    assert not unstable.growth_rates[1:].any()
    assert unstable.labels[0] == "B1"


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-8])
@pytest.mark.parametrize(
    "beam",
    [
        Beam(alpha=83, beta=0.8125, gamma=25, mu=10),
        Beam(alpha=51.65, beta=0.4847, gamma=200, mu=101.14),
        Beam(gamma=200, delta=2.58, mu=109.8),
    ],
)
def test_beams_that_stretch_far_keep_honest_error_bars(beam, tolerance):
    """Where the stretch falls off all but singularly, more is lost than meets the eye."""
    rough, fine = solve(beam, tolerance=tolerance), solve(beam, tolerance=1e-12)
    assert np.all(
        abs(rough.omega_squared - fine.omega_squared)
        <= rough.omega_squared_errors + fine.omega_squared_errors
    )


def test_an_error_that_cannot_be_known_is_infinite():
    """The paper's elements answer just beyond the limit of equilibrium, which nothing exact can
    be held against."""
    beyond = solve(Beam(alpha=0, beta=0, gamma=92, delta=-2, mu=264), method="ancf")
    assert np.all(np.isinf(beyond.errors))


INWARD = [
    Beam(gamma=5, delta=-1),
    Beam(gamma=30, delta=-0.3, alpha=2),
    Beam(gamma=20, delta=-2, mu=500),
    Beam(gamma=100, delta=-1, mu=1000),
    Beam(alpha=3, beta=0.6, gamma=40, delta=-0.8, mu=300),
]


@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize("beam", INWARD)
def test_unstable_beams_keep_honest_error_bars(beam, coriolis):
    """However far beyond buckling: all modes asked for, errors that are positive and hold."""
    rough, fine = (solve(beam, coriolis=coriolis, tolerance=t) for t in (1e-3, 1e-9))
    assert rough.equilibrium.status == "unstable"
    assert len(rough.omega_squared) == 5
    assert np.all(rough.omega_squared_errors >= 0)
    off = abs(rough.omega_squared - fine.omega_squared)
    slack = 1e-9 * abs(fine.omega_squared) if coriolis else 0
    assert np.all(off <= rough.omega_squared_errors + fine.omega_squared_errors + slack)


@pytest.mark.parametrize("beam", INWARD)
def test_unstable_beams_agree_with_the_papers_elements(beam):
    """Two methods that share no discretisation find the same growth rates."""
    exact, elements = solve(beam), solve(beam, method="ancf", elements=200)
    assert elements.growth_rates == pytest.approx(exact.growth_rates, rel=1e-4)
    assert elements.labels == exact.labels


def test_coriolis_at_the_point_of_buckling_loses_no_mode():
    """Where omega_1 is all but zero the other modes are still there."""
    for gamma in (2.99603, 2.996038663, 2.99605):
        solution = solve(Beam(gamma=gamma, delta=-1), coriolis=True)
        assert solution.omega_squared[1:] == pytest.approx(
            [457.4348, 3738.020, 12099.08, 14487.45], 1e-5
        )


def test_a_growing_shape_moves_as_one():
    """Where nothing oscillates both components grow in phase: the shape is real."""
    shape = solve(Beam(gamma=5, delta=-1), coriolis=True).shape(0, np.linspace(0, 1, 9))
    assert abs(shape.imag).max() < 1e-9 * abs(shape).max()
    assert abs(shape[:, 0]).max() > 1e-3


def test_a_veering_pair_is_mixed():
    """Between S1 and B3 with Coriolis (physics.md 3.1) neither mode is of one family."""
    solution = solve(Beam(alpha=1, gamma=4.65), coriolis=True)
    assert solution.families[2:4] == ("mixed", "mixed")
    assert solution.frequencies[3] - solution.frequencies[2] == pytest.approx(0.241, abs=5e-4)


@settings(max_examples=25, deadline=None)
@given(beam=beams())
def test_every_bending_mode_has_one_node_more_than_the_last(beam):
    """B1 has none, B2 one, and so on, at any speed and with any mass; stretching alike."""
    solution = solve(beam, modes=12)
    for label, nodes in zip(solution.labels, solution.nodes, strict=True):
        assert len(nodes) == int(label[1:]) - 1


def test_coriolis_does_not_move_the_point_of_buckling():
    """At omega = 0 nothing moves and no Coriolis force acts."""
    for gamma, status in ((2.99, "stable"), (3.00, "unstable")):
        solution = solve(Beam(gamma=gamma, delta=-1), coriolis=True)
        assert solution.equilibrium.status == status


def test_coriolis_vanishes_with_the_speed():
    """The coupled answer tends to the uncoupled one as gamma^2."""
    apart = solve(Beam(alpha=1, beta=0.7, gamma=1e-4), tolerance=1e-10)
    coupled = solve(Beam(alpha=1, beta=0.7, gamma=1e-4), tolerance=1e-10, coriolis=True)
    assert coupled.frequencies == pytest.approx(apart.frequencies, rel=1e-8)
    assert coupled.labels == apart.labels


def test_nodes_are_where_the_paper_puts_them():
    """Vibration nodes 0.78344 of mode 2; 0.50355 and 0.86768 of mode 3 (paper, figs. 16-19)."""
    solution = solve(Beam())
    assert solution.nodes[0].size == 0
    assert solution.nodes[1] == pytest.approx([0.78344], abs=5e-6)
    assert solution.nodes[2] == pytest.approx([0.50355, 0.86768], abs=5e-6)


def test_a_mode_seen_out_of_range_is_an_index_error():
    """Modes count from 0; the message says which there are."""
    with pytest.raises(IndexError, match=r"modes 0 \.\. 4"):
        solve(Beam()).shape(5, 0.5)
    with pytest.raises(ValueError, match=r"0 \.\. 1"):
        solve(Beam()).shape(0, 1.5)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"method": "magic"},
            "method = 'magic': must be one of auto, ancf, ancf-planar, linear, foac, zoac,"
            " assumed-modes, power-series, chebyshev",
        ),
        ({"strain": "cauchy"}, "strain = 'cauchy': must be one of green, biot, hencky"),
        ({"curvature": "flat"}, "curvature = 'flat': must be one of spatial, material"),
        ({"plane": "diagonal"}, "plane = 'diagonal': must be one of chordwise, flapwise"),
        ({"modes": 0}, "modes = 0: must be a whole number in 1 .. 20"),
        ({"modes": 2.5}, "modes = 2.5: must be a whole number in 1 .. 20"),
        ({"coriolis": "no"}, "coriolis = 'no': must be True or False"),
        ({"method": []}, "method = []: must be one of auto"),
        ({"tolerance": 1.0}, "tolerance = 1: must lie in 1e-12 .. 0.1"),
        ({"tolerance": math.nan}, "tolerance = nan: must lie in 1e-12 .. 0.1"),
        (
            {"elements": 20},
            "elements = 20: method auto takes no number of elements; methods that do: ancf, "
            "ancf-planar, linear",
        ),
        ({"method": "ancf", "elements": 0}, "elements = 0: must be a whole number in 1 .. 1000"),
        ({"method": "ancf", "elements": 2}, "modes = 5: at most 4 with elements = 2"),
    ],
)
def test_wrong_options_are_named(options, message):
    """The error names the option, the value and what is allowed."""
    with pytest.raises(InvalidInput) as caught:
        solve(STRAIGHT, **options)
    assert message in str(caught.value)


@pytest.mark.parametrize("delta", [-1.0, -1.3, -2.0])
def test_an_inward_biot_beam_ends_where_its_root_is_crushed(delta):
    """Biot, no mass: X'' = -k^2 X with X(0) = delta and X'(1) = 1 has f(0) = 0 where
    k sin k = -1 / delta; k = gamma / mu."""
    k = brentq(lambda k: k * math.sin(k) + 1 / delta, 0.1, 1.5)
    for gamma in (70 * k * 1.02, 200.0):
        with pytest.raises(NoEquilibrium) as caught:
            solve(Beam(gamma=gamma, delta=delta), strain="biot")
        assert caught.value.limit == pytest.approx(70 * k, rel=1e-4)
    near = solve(Beam(gamma=70 * k * 0.98, delta=delta), strain="biot", plane="flapwise")
    assert near.equilibrium.stretch([0.0])[0] < 0.1


def test_a_beam_buckled_beyond_resolving_says_so():
    """Compressed into hundreds of half-waves: an answer at once, with the remedy."""
    for options in ({}, {"coriolis": True}, {"method": "foac"}):
        with pytest.raises(NotConverged, match="lower gamma"):
            solve(Beam(alpha=50, beta=0.3, gamma=200, delta=-1, mu=5000), **options)


def test_no_sweep_resolves_what_one_solve_does_not():
    """Of beams solved together each says the same as alone, on meshes no finer: those of a beam in
    a thousand half-waves would fill the memory."""
    buckled = Beam(alpha=100, gamma=40, delta=-2, mu=10000)
    for sweep in (
        [buckled.replace(gamma=gamma) for gamma in (0.0, 40.0)],
        [buckled.replace(beta=beta) for beta in (0.0, 0.3, 0.4)],
    ):
        first, *others = solve_many(sweep, modes=3)
        assert isinstance(first, Solution)
        assert all("half-waves" in str(other) for other in others)


@pytest.mark.parametrize("gamma", [5.0, 18.0])
def test_buckled_beams_keep_their_digits(gamma):
    """Errors of a compressed beam hold though its stiffness is indefinite."""
    beam = Beam(alpha=6, beta=0.25, gamma=gamma, delta=-1.9, mu=200)
    rough, fine = (solve(beam, modes=20, tolerance=tolerance) for tolerance in (1e-6, 1e-11))
    assert (
        abs(rough.omega_squared - fine.omega_squared)
        <= rough.omega_squared_errors + fine.omega_squared_errors
    ).all()
    assert rough.equilibrium.status == "unstable"
