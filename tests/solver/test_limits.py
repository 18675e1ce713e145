"""Limits of equilibrium and onset of buckling: located, named, and solutions up to them."""

import math

import numpy as np
import pytest
from helpers import slow, within_the_bars
from scipy.optimize import brentq

from beamviz import Beam, Solution, solve
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.solver import solve_many


# Biot has the resonance of a linear bar, mu pi / 2 whatever the hub radius; hencky a
# fold of the whole beam, and at delta 1 a root that reaches f = e in a thin layer.
@pytest.mark.parametrize("method", ["auto", "ancf"])
@pytest.mark.parametrize(
    ("strain", "delta", "limit", "near", "coarse", "reason"),  # tolerances of auto, 20 elements
    [
        *(("biot", delta, 35 * math.pi, 1e-9, 1e-9, r"109\.955743") for delta in (0.0, 5.0)),
        ("hencky", 0.0, 45.420, 1e-5, 1e-5, "stiffness of the beam"),
        ("hencky", 1.0, 31.4887, 2e-6, 1e-4, "hencky force law ends"),
    ],
)
def test_limit_of_the_speed(method, strain, delta, limit, near, coarse, reason):
    """However far beyond the limit; the elements name its reason; a stable state just below. So
    near below that of biot that the stretch exceeds a thousand, the error names it too."""

    def at(gamma):
        return solve(Beam(gamma=gamma, delta=delta), strain=strain, method=method)

    ends = [1.0005 * limit, 1.02 * limit, 150.0]
    if strain == "biot" and delta == 0 and method == "auto":
        ends += [limit + 1e-6, *(limit - np.array([1e-7, 3e-5, 3e-4]))]
        assert at(0.99 * limit).errors.max() < 1e-3
    for gamma in ends:
        with pytest.raises(NoEquilibrium) as caught:
            at(gamma)
        assert caught.value.limit == pytest.approx(limit, rel=near if method == "auto" else coarse)
        if method == "ancf" or strain == "biot":
            assert caught.match(reason)
    below = at(0.97 * limit)
    assert below.equilibrium.status == "stable"
    assert below.equilibrium.stretch(np.linspace(0, 1, 101)).min() > 0
    if strain == "hencky" and method == "ancf":
        found = caught.value.limit
        assert at(found * (1 - 1e-7)).equilibrium.status == "stable"
        with pytest.raises(NoEquilibrium):
            at(found * (1 + 1e-7))


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


@pytest.mark.parametrize(("strain", "end"), [("green", "0.5774"), ("biot", "0")])
def test_inward_limit(strain, end):
    """The paper's elements compress an inward beam to the end of its force law, never through it:
    at the speed that the default method finds too, from whatever speed beyond it."""
    with pytest.raises(NoEquilibrium) as converged:
        solve(Beam(gamma=150, delta=-2), strain=strain)
    for beyond in (1.001, 1.03, 1.38237, 1.7):
        beam = Beam(gamma=converged.value.limit * beyond, delta=-2)
        with pytest.raises(NoEquilibrium, match=f"{strain} force law ends there, .* {end}$") as e:
            solve(beam, method="ancf", strain=strain, elements=80)
        assert e.value.limit == pytest.approx(converged.value.limit, rel=2e-3)


@pytest.mark.parametrize("beam", [Beam(98, 0.725, 97, 10.8), Beam(33, 0.966, 26, 19.8, 1533)])
def test_overshoot_at_a_mass_is_not_physics(beam):
    """Where the gradient shared at a heavy inner mass overshoots into compression, neither a limit
    nor an instability of the beam is reported: the method did not converge."""
    with pytest.raises(NotConverged):
        solve(beam, method="ancf")


@pytest.mark.parametrize(
    ("method", "beam"),
    [
        ("ancf", Beam(alpha=100, beta=0.25, gamma=100, mu=68)),
        ("chebyshev", Beam(gamma=67, delta=-1, mu=13.4)),
    ],
)
def test_beyond_a_limit_there_is_none_although_a_method_fails_before(method, beam):
    """Where the elements overshoot, or the polynomials do not follow the stretch, next to a limit
    of the beam: that is named, as by the default method."""
    resolution = "terms" if method == "chebyshev" else "elements"
    with pytest.raises(NoEquilibrium) as by_default:
        solve(beam, strain="biot")
    with pytest.raises(NoEquilibrium) as caught:
        solve(beam, method=method, strain="biot", **{resolution: 40})
    assert caught.value.limit == pytest.approx(by_default.value.limit, rel=1e-6)


def test_unknowns_of_many_elements_are_too_many_with_coriolis():
    """Of an unstable beam; fewer elements help, as the error says."""
    beam, options = Beam(gamma=10, delta=-1), {"method": "ancf", "coriolis": True}
    with pytest.raises(NotConverged, match="fewer elements"):
        solve(beam, elements=200, **options)
    assert solve(beam, elements=50, **options).equilibrium.status == "unstable"


def ritz_buckling_speed(delta, softens=True):
    """The least gamma at which an inextensible inward beam buckles, by w = x^2 .. x^9 and the
    tension (1 - x^2) / 2 + delta (1 - x), integrated in closed form; out of the plane of rotation
    the centrifugal force does not soften."""
    p = np.arange(2.0, 10)
    product, total = np.outer(p, p), np.add.outer(p, p)
    K = product * np.outer(p - 1, p - 1) / (total - 3)
    tension = (1 / (total - 1) - 1 / (total + 1)) / 2 + delta * (1 / (total - 1) - 1 / total)
    softening = softens / (total + 1) - product * tension
    return 1 / math.sqrt(np.linalg.eigvals(np.linalg.solve(K, softening)).real.max())


ANCF, CORIOLIS = {"method": "ancf"}, {"coriolis": True}
BUCKLING = [
    # mu = 1000; at delta = -0.3 the beam buckles in tension. Nothing moves at omega = 0: with
    # Coriolis forces the speed is the same.
    *(
        (options, delta, 1000, ritz_buckling_speed(delta))
        for options in ({}, ANCF, CORIOLIS)
        for delta in (-1.0, -0.3, -2.0)
    ),
    # Without softening.
    (ANCF | {"plane": "flapwise"}, -1.0, 1000, ritz_buckling_speed(-1.0, softens=False)),
    # 2.9939 without stretch (a Runge-Kutta march), 2.9960 with the shortening at mu 70.
    *((options, -1.0, 70, 2.99604) for options in ({}, ANCF, CORIOLIS)),
]


@pytest.mark.parametrize(("options", "delta", "mu", "critical"), BUCKLING)
def test_buckling_speed(options, delta, mu, critical):
    """The straight inward beam becomes unstable at the speed of the inextensible one; it says so
    with a growth rate of B1, and of no other mode."""

    def state(gamma):
        return solve(Beam(gamma=gamma, delta=delta, mu=mu), **options)

    found = brentq(lambda gamma: state(gamma).omega_squared[0], 0.9 * critical, 1.1 * critical)
    assert found == pytest.approx(critical, rel=1e-4)
    stable, unstable = (state(factor * critical) for factor in (0.99, 1.01))
    assert [s.equilibrium.status for s in (stable, unstable)] == ["stable", "unstable"]
    assert np.isnan(unstable.frequencies[0])
    assert unstable.growth_rates[0] > 0
    assert not unstable.growth_rates[1:].any()
    assert unstable.labels[0] == "B1"


def test_coriolis_at_the_point_of_buckling_loses_no_mode():
    """The other modes are found where omega_1 is almost zero."""
    for gamma in (2.99603, 2.996038663, 2.99605):
        found = solve(Beam(gamma=gamma, delta=-1), coriolis=True).omega_squared
        assert found[1:] == pytest.approx([457.4348, 3738.020, 12099.08, 14487.45], 1e-5)


@pytest.mark.parametrize("gamma", [2.9960386598525726, 2.99603866, 2.996038])
def test_collocation_at_the_point_of_buckling_loses_no_mode(gamma):
    """20 modes of a beam whose first omega^2 is almost zero."""
    beam = Beam(gamma=gamma, delta=-1)
    found, converged = (solve(beam, 20, method) for method in ("chebyshev", "auto"))
    assert abs(found.omega_squared[0]) < 1e-5
    assert found.frequencies[1:] == pytest.approx(converged.frequencies[1:], rel=1e-6)


def test_where_a_mode_is_about_to_buckle_the_others_keep_their_digits():
    """Next to its frequency, almost zero, rounding takes the others from Z' Z, not from Z."""
    beam = Beam(alpha=1, beta=1.6e-14, gamma=4, delta=-0.6111255052738858, mu=21)
    beams = beam, beam.replace(delta=-0.6111)
    at, beside = (solve(one, 3, coriolis=True, tolerance=1e-9) for one in beams)
    assert abs(at.omega_squared[0]) < 1e-9
    assert at.frequencies[1:] == pytest.approx(beside.frequencies[1:], rel=1e-4)
    assert np.all(at.omega_squared_errors[1:] < 1e-5 * at.omega_squared[1:])


def test_a_growing_shape_moves_as_one():
    """The components of a growing mode are in phase: the shape is real."""
    shape = solve(Beam(gamma=5, delta=-1), coriolis=True).shape(0, np.linspace(0, 1, 9))
    assert abs(shape.imag).max() < 1e-9 * abs(shape).max()
    assert abs(shape[:, 0]).max() > 1e-3


@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize(
    "beam",
    [
        Beam(gamma=5, delta=-1),
        Beam(gamma=30, delta=-0.3, alpha=2),
        Beam(gamma=20, delta=-2, mu=500),
        Beam(gamma=100, delta=-1, mu=1000),
        Beam(alpha=3, beta=0.6, gamma=40, delta=-0.8, mu=300),
    ],
)
def test_unstable_beams(beam, coriolis):
    """Far beyond buckling: all modes, errors that hold, growth rates as by other elements."""
    rough, fine = (solve(beam, coriolis=coriolis, tolerance=t) for t in (1e-3, 1e-9))
    assert rough.equilibrium.status == "unstable"
    assert len(rough.omega_squared) == 5
    assert np.all(rough.omega_squared_errors >= 0)
    assert within_the_bars(rough, fine, 1e-9 * abs(fine.omega_squared) if coriolis else 0)
    if not coriolis:
        elements = solve(beam, method="ancf", elements=200)
        assert elements.growth_rates == pytest.approx(fine.growth_rates, rel=1e-4)
        assert elements.labels == fine.labels


def test_a_beam_buckled_beyond_resolving_says_so():
    """Compressed into hundreds of half-waves: an answer at once, with the remedy; in a sweep too,
    where meshes for a thousand half-waves would fill the memory."""
    for options in ({}, {"coriolis": True}, {"method": "foac"}):
        with pytest.raises(NotConverged, match="lower gamma"):
            solve(Beam(alpha=50, beta=0.3, gamma=200, delta=-1, mu=5000), **options)
    with pytest.raises(NotConverged):
        solve(Beam(gamma=50, mu=10), method="zoac", coriolis=True)
    buckled = Beam(alpha=100, gamma=40, delta=-2, mu=10000)
    for sweep in (
        [buckled.replace(gamma=gamma) for gamma in (0.0, 40.0)],
        [buckled.replace(beta=beta) for beta in (0.0, 0.3, 0.4)],
    ):
        first, *others = solve_many(sweep, modes=3)
        assert isinstance(first, Solution)
        assert all(isinstance(other, NotConverged) for other in others)


@pytest.mark.parametrize(
    ("strain", "delta", "limit", "speeds"),
    [
        ("hencky", -2.0, 11.893, (150,)),
        *slow(("hencky", -2.0, 11.893, (60,)), ("biot", -0.5, 59.6, (60, 150))),
    ],
)
def test_the_limit_of_deflected_states_does_not_depend_on_the_speed_asked(
    strain, delta, limit, speeds
):
    """It is named by the digits that are certain: of biot, which a layer at the clamp resolves
    slowly, by three."""
    for gamma in speeds:
        with pytest.raises(NoEquilibrium) as caught:
            solve(Beam(gamma=gamma, delta=delta), strain=strain, state="stable")
        assert caught.value.limit == pytest.approx(limit, abs=1e-9)
        assert f" {limit:g}," in str(caught.value)


@pytest.mark.parametrize("mu", [24, 36, 48])
def test_an_inward_beam_does_not_leave_its_branch(mu):
    """A beam that points inward beyond the axis is compressed along its whole length. It also has
    equilibria stretched outward across the axis, which a step of the load must not lead to."""
    beam = Beam(alpha=0.9, beta=1, gamma=104.65, delta=-1.134, mu=mu)
    with pytest.raises(NoEquilibrium) as raised:
        solve(beam)
    assert raised.value.limit == pytest.approx(0.443 * mu, rel=1e-2)  # gamma / mu is what counts
