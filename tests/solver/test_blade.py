"""Blades: properties along the span, bodies with inertia, root springs."""

import numpy as np
import pytest
from helpers import slow
from scipy.optimize import brentq

from beamviz import InvalidInput, NoEquilibrium, solve, solve_many
from beamviz.beam import Beam
from beamviz.blade import Blade, Mass
from beamviz.presets import preset
from beamviz.solver.bent import other_stable_states

TAPER = Blade.tapered(height=0.5)
BODIES = (Mass(1, 0.5), Mass(1, 1))
TURNING = (Mass(1, 1, (0, 0, 0.1)),)
JUMP = Blade(
    (0, 0.4, 0.4, 1), (1, 0.8, 0.5, 0.2), (1, 0.7, 0.3, 0.1), (1, 0.9, 0.6, 0.4), (2, 1.8, 1.7, 1)
)
BODY = Mass(0.2, 0.7, (0.05, 0.08, 0.1))


@pytest.mark.parametrize(
    ("beam", "plane", "frequencies"),
    [
        # Ozdemir & Kaya, Meccanica 41 (2006) 661, where published; computed independently.
        (Beam(blade=TAPER), "flapwise", (3.823785, 18.317261, 47.264827, 90.450478)),
        (Beam(gamma=5, blade=TAPER), "flapwise", (6.743398, 21.905324, 50.933802, 94.206348)),
        (Beam(gamma=10, blade=TAPER), "flapwise", (11.50155, 30.182742, 60.563866, 104.611959)),
        (Beam(masses=BODIES), "chordwise", (1.496465, 9.46844, 48.560866)),
        (Beam(masses=TURNING), "chordwise", (1.429626, 6.275326, 24.751604)),
        (Beam(gamma=5, root=0), "flapwise", (5, 19.91966, 54.241931)),
    ],
)
def test_independent_values(beam, plane, frequencies):
    """To their digits; at speed these depend on the strain law in the seventh, (gamma / mu)^2."""
    beam = beam.replace(mu=1e4)
    solution = solve(beam, len(frequencies), plane=plane, tolerance=1e-9)
    assert solution.frequencies == pytest.approx(
        frequencies, rel=2e-7 if beam.gamma else 2e-8, abs=1e-6
    )


def test_blades_are_solved_in_stacks():
    """Many beams of a blade at once, as each alone."""
    beams = [
        Beam(alpha=0.3, beta=0.7, gamma=gamma, delta=0.2, blade=blade, masses=masses, root=root)
        for gamma in np.linspace(0, 20, 9)
        for blade, masses, root in ((JUMP, BODIES, np.inf), (None, TURNING, 3), (TAPER, (), 0.5))
    ]
    for coriolis in (False, True):
        for beam, solution in zip(beams, solve_many(beams, coriolis=coriolis), strict=True):
            alone = solve(beam, coriolis=coriolis, tolerance=1e-9)
            assert solution.frequencies == pytest.approx(alone.frequencies, rel=1.1e-6)
            assert np.all(
                abs(solution.frequencies - alone.frequencies) <= solution.errors + alone.errors
            )


@pytest.mark.parametrize(
    ("numbers", "options"),
    [
        ({"alpha": 0.15, "beta": 0.6536, "gamma": 4.46}, {}),
        *slow(({"alpha": 0.118, "beta": 0.9986, "spin_up": -9.229}, {"coriolis": True})),
    ],
)
def test_errors_of_deflected_blades_of_many_stations(numbers, options):
    """Elements span many stations, where the mass has kinks: single coefficients nearly vanish
    there, and the errors of modes must not."""
    beam = preset("nrel-5mw-blade").beam.replace(delta=-1.0, **numbers)
    options = options | {"state": "stable", "strain": "biot", "modes": 8}
    found, finer = (solve(beam, tolerance=tolerance, **options) for tolerance in (1e-6, 1e-7))
    assert (abs(found.s - finer.s) <= found.errors + finer.errors).all()


@pytest.mark.slow
def test_a_blade_of_many_stations_has_no_other_state():
    """The one that was listed here was the same state, with what its first guess held beside the
    trial functions."""
    beam = preset("nrel-5mw-blade").beam.replace(alpha=0.05, gamma=6, delta=-0.5)
    solution = solve(beam, state="bent")
    assert not other_stable_states(solution)


def test_a_straight_blade_that_is_stable_has_no_bent_state():
    """What a first guess holds beside the trial functions is no bend."""
    beam = preset("nrel-5mw-blade").beam.replace(alpha=0.05, gamma=4, delta=-0.5)
    assert solve(beam).equilibrium.stable
    with pytest.raises(NoEquilibrium, match="the straight one is stable"):
        solve(beam, state="bent")


def rough_blade(stations: int) -> Blade:
    """Properties that differ by some percent from one station to the next, without a trend."""
    rng = np.random.default_rng(11)
    x = tuple(np.linspace(0, 1, stations).tolist())
    rows = (np.exp(np.append(0.0, rng.normal(0, 0.1, stations - 1))) for _ in range(3))
    return Blade(x, *(tuple(row.tolist()) for row in rows))


@pytest.mark.parametrize("options", [{}, *slow({"coriolis": True}, {"plane": "flapwise"})])
def test_the_bars_hold_where_elements_span_many_stations(options):
    """The reference has elements between stations."""
    beam = Beam(0.3, 0.6, 4, 0.2, 60, blade=rough_blade(40), root=50.0)
    fine = solve(beam, tolerance=1e-11, **options)
    for tolerance in (1e-4, 1e-6, 1e-8):
        rough = solve(beam, tolerance=tolerance, **options)
        assert rough.stats.elements < 20 < fine.stats.elements
        apart = abs(rough.omega_squared - fine.omega_squared)
        assert np.all(apart <= rough.omega_squared_errors + fine.omega_squared_errors)
        assert np.all(rough.errors <= 2 * tolerance * rough.frequencies)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6])
def test_a_soft_dip(tolerance):
    """Values of a Ritz solution with Hermite cubics and graded bubbles."""
    bending = (1.0, 1.0, 1e-3, 1.0, 1.0)
    blade = Blade((0, 0.27, 0.37, 0.47, 1), (1.0,) * 5, bending, (1.0,) * 5)
    right = np.array([3.034583334, 18.877321245, 53.008659974])
    beam = Beam(0, 1, 3, 0, 100, blade=blade)
    for solved in (beam, beam.replace(spin_up=1e-9)):
        options = {} if solved is beam else {"state": "bent"}
        solution = solve(solved, modes=3, tolerance=tolerance, **options)
        assert np.all(abs(solution.frequencies - right) <= solution.errors + 1e-9 * right)


@pytest.mark.parametrize("options", [{}, {"plane": "flapwise"}, {"coriolis": True}])
@pytest.mark.parametrize(
    "beam",
    [
        Beam(gamma=5, blade=TAPER),
        Beam(gamma=5, delta=0.1, alpha=0.3, beta=0.4, blade=JUMP, masses=(BODY,), root=30),
        Beam(gamma=5, delta=0.1, root=0),
    ],
)
@pytest.mark.parametrize(("method", "limit"), [("ancf", "auto"), ("linear", "foac")])
def test_elements_converge_to_the_same(method, limit, beam, options):
    """Cubic elements with nodes at bodies and jumps, to the high-order solution of their model: at
    least of the first order, as neighbours share a gradient where the stretch jumps."""
    true = solve(beam, method=limit, tolerance=1e-9, **options).frequencies
    coarse, fine = (
        abs(solve(beam, method=method, elements=n, **options).frequencies - true) for n in (20, 80)
    )
    assert (fine <= np.maximum(coarse / 3, 2e-6 * true)).all()


@pytest.mark.parametrize("options", [{}, {"plane": "flapwise"}, {"coriolis": True}])
@pytest.mark.parametrize(("method", "limit"), [("ancf", "auto"), ("linear", "foac")])
def test_bodies_close_to_each_other_leave_the_elements_their_digits(method, limit, options):
    """An element of a millionth of the beam between two bodies at the tip would cost all of them,
    and a stable beam its stability."""
    beam = Beam(1, 1 - 1e-6, gamma=5, delta=0.3, masses=(Mass(0.1, 1, (0.01, 0.02, 0.03)),))
    found = solve(beam, 3, method, elements=40, **options)
    true = solve(beam, 3, limit, tolerance=1e-9, **options)
    assert found.equilibrium.status == "stable"
    assert found.frequencies == pytest.approx(true.frequencies, rel=1e-5)


@pytest.mark.parametrize("method", ["auto", "foac", "ancf", "linear"])
@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize("gamma", [0, 5])
def test_nothing_holds_a_hinge_about_the_axis(method, coriolis, gamma):
    """A rigid rotation about a hinge on the axis of rotation: a frequency of 0, not an instability.
    The next one is that of a beam hinged and free at rest."""
    solution = solve(Beam(gamma=gamma, root=0), method=method, coriolis=coriolis)
    assert solution.frequencies[0] == 0
    assert solution.growth_rates[0] == 0
    assert solution.equilibrium.status == "stable"
    if not gamma:
        assert solution.frequencies[1] == pytest.approx(15.41820572, rel=1e-5)
    rotation = solution.shape(0, np.linspace(0, 1, 3))[:, 1].real
    assert rotation == pytest.approx(np.sqrt(3) * np.array([0, 0.5, 1]), abs=2e-3)


@pytest.mark.parametrize("method", ["auto", "foac"])
@pytest.mark.parametrize("blade", [None, TAPER])
def test_a_hinge_without_softening_swings_with_the_speed(method, blade):
    """A rigid rotation about a hinge on the axis lifts every point against the tension as out of
    the plane of rotation: its frequency is gamma."""
    beam = Beam(gamma=5, root=0, blade=blade)
    solution = solve(beam, 3, method, softening=False)
    assert solution.frequencies[0] == pytest.approx(5, rel=1e-6)
    assert solution.equilibrium.status == "stable"


@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
@pytest.mark.parametrize(
    ("beam", "square"),
    [
        (Beam(root=1e-16), 3e-16),
        (Beam(root=1e-9), 3e-9),
        (Beam(root=0, gamma=1e-6, delta=1), 1.5e-12),
        (Beam(root=0, gamma=1e-4, delta=1), 1.5e-8),
    ],
)
def test_a_root_that_is_hardly_held_leaves_the_other_modes(beam, square, plane, coriolis):
    """By a weak spring or at a low speed the beam turns slowly about its root, at 3 K or at
    3 gamma^2 delta / 2, and gamma^2 more out of the plane of rotation. Beside it the other modes
    are, to the tolerance, those of a hinged beam at rest."""
    found = solve(beam, plane=plane, coriolis=coriolis)
    still = solve(Beam(root=0))
    flapwise = beam.gamma**2 * (plane == "flapwise")
    assert found.frequencies[0] ** 2 == pytest.approx(square + flapwise, rel=1e-6)
    assert found.labels == still.labels
    assert found.frequencies[1:] == pytest.approx(still.frequencies[1:], rel=1e-6)
    assert (found.errors < 1e-6 * found.frequencies).all()


@pytest.mark.parametrize("alpha", [1, 30, 100])
def test_a_heavy_tip_at_a_weak_spring_leaves_the_other_modes_within_their_errors(alpha):
    """In closed form with a hinge: tan k (1 + 2 alpha k tanh k) = tanh k, omega = k^2. The mass
    hardly moves, as the rotation about the root cancels the bending; rounding is all of the
    error."""

    def characteristic(k):
        return np.sin(k) / np.tanh(k) - np.cos(k) + 2 * alpha * k * np.sin(k)

    near = np.pi * np.arange(1, 7)
    k = np.array([brentq(characteristic, x - 1, x + 1, xtol=1e-15, rtol=1e-15) for x in near])
    found = solve(Beam(alpha=alpha, root=1e-12, mu=1e4), 7)
    assert (abs(found.frequencies[1:] - k**2) < found.errors[1:] + 1e-15 * k**2).all()


@pytest.mark.parametrize("method", ["linear", "ancf"])
def test_elements_keep_their_other_modes_at_a_weak_spring(method):
    """They are those of the same elements with a hinge."""
    found = solve(Beam(root=1e-16), method=method)
    hinged = solve(Beam(root=0), method=method)
    assert found.frequencies[1:4] == pytest.approx(hinged.frequencies[1:4], rel=1e-7)


def test_a_hinged_inward_beam_turns_over():
    """As a pendulum: it grows at the root of gamma^2 |delta| times the static moment over the
    moment of inertia, 3 / 2, if it hardly bends; its stable state points outward."""
    beam = Beam(gamma=2, delta=-1.5, mu=1e4, root=0)
    straight = solve(beam)
    assert straight.equilibrium.status == "unstable"
    assert straight.growth_rates[0] == pytest.approx(2 * 1.5, rel=0.02)
    bent = solve(beam, state="bent")
    assert bent.equilibrium.tip == pytest.approx([-1, 0], abs=1e-3)
    assert solve(beam.replace(delta=1.5)).frequencies[:3] == pytest.approx(
        bent.frequencies[:3], rel=1e-6
    )


@pytest.mark.parametrize("coriolis", [False, True])
def test_slowly_a_hinged_inward_beam_turns_over_within_its_error(coriolis):
    """At the root of 3 / 2 times gamma: by its bending and stretching up to 1e-8 of that more."""
    found = solve(Beam(gamma=1e-5, delta=-1, root=0), coriolis=coriolis)
    growth = np.sqrt(1.5) * 1e-5
    assert found.equilibrium.status == "unstable"
    assert abs(found.growth_rates[0] - growth) < found.errors[0] + 1e-8 * growth


@pytest.mark.parametrize("beam", [Beam(gamma=3, spin_up=1, root=0), Beam(spin_up=1, root=0)])
def test_a_hinge_does_not_hold_a_beam_that_spins_up(beam):
    """About the axis of rotation, and at rest, there is no equilibrium; beyond a hub there is."""
    with pytest.raises(NoEquilibrium):
        solve(beam, state="stable")
    solution = solve(beam.replace(gamma=3, delta=0.5), state="stable", tolerance=1e-9)
    assert solution.equilibrium.status == "stable"
    assert solution.equilibrium.root_moment == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("method", ["auto", "ancf", "linear"])
@pytest.mark.parametrize(("gamma", "buckled"), [(2, False), (5, True)])
def test_a_beam_that_is_soft_flapwise_only_has_not_buckled_chordwise(method, gamma, buckled):
    """Flapwise it is unstable at both speeds; whether it has buckled in the plane of rotation is
    what its chordwise modes say."""
    soft = Blade((0, 1), (1, 1), (1, 1), (1, 1), flap=(0.02, 0.02))
    beam = Beam(gamma=gamma, delta=-1.2, mu=100, blade=soft)
    flapwise, chordwise = (solve(beam, 3, method, plane=p) for p in ("flapwise", "chordwise"))
    assert flapwise.equilibrium.status == "unstable"
    assert flapwise.equilibrium.buckled_chordwise == buckled
    assert chordwise.equilibrium.stable != buckled


def test_a_body_that_is_a_rod_stands_up():
    """Out of the plane of rotation a slender body along the beam (Jx < Jz) is turned back into the
    plane; across the beam (Jx > Jz) it is turned out of it. In the plane it does neither."""
    base = Beam(gamma=5, masses=(Mass(0.1, 1),))
    frequencies = {
        plane: [
            solve(base.replace(masses=(Mass(0.1, 1, inertia),)), plane=plane).frequencies[0]
            for inertia in ((0, 0, 0), (0, 0.01, 0.01), (0.01, 0.01, 0))
        ]
        for plane in ("chordwise", "flapwise")
    }
    point, along, across = frequencies["flapwise"]
    assert across < along < point * 1.01
    point, along, across = frequencies["chordwise"]
    assert along < across == pytest.approx(point)


def test_other_methods_refuse():
    """In a line that names those that do."""
    for method in ("assumed-modes", "power-series", "chebyshev"):
        with pytest.raises(InvalidInput) as caught:
            solve(Beam(blade=TAPER), method=method)
        assert set(caught.value.use["method"]) == {"auto", "ancf", "linear", "foac", "zoac"}
