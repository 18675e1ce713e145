"""A beam that is pulled aside, let go at any point, and the motion without stiffening."""

import numpy as np
import pytest

from beamviz import Beam, motion, solve
from beamviz.dynamics.drives import Ramp
from beamviz.dynamics.linear import DIVERGED, motion_without_stiffening
from beamviz.dynamics.pull import pulled
from beamviz.errors import InvalidInput

SMALL = 0.02  # [E I / L^2] a force whose deflection of 0.007 L is small: nonlinear terms are 5e-5


def test_a_force_holds_the_beam_at_a_deflection():
    """The independent value of a tip mass at gamma 3: 3 E I / L^2 hold its tip at (0.854723,
    0.491853). At rest a small force bends the beam by F x^3 / 3 at its own point (Blevins), to the
    jump of the shear force there, which polynomials of order 10 smooth."""
    found = pulled(Beam(alpha=1, gamma=3), 0.491853)
    assert found.force == pytest.approx(3, abs=2e-5)
    assert found.position(np.ones(1))[0] == pytest.approx((0.854723, 0.491853), abs=2e-6)
    for x in (1.0, 0.6, 0.3):
        assert pulled(Beam(), 1e-3 * x**3 / 3, x).force == pytest.approx(1e-3, rel=2e-3)


@pytest.mark.parametrize(("deflection", "at"), [(float("nan"), 1.0), ("far", 1.0), (0.1, 0.0)])
def test_what_cannot_be_pulled_is_named(deflection, at):
    """The root does not move."""
    with pytest.raises(InvalidInput):
        pulled(Beam(gamma=1), deflection, at)


def test_a_motion_begins_where_the_beam_was_held():
    """At the tip and elsewhere, on both sides of a mass."""
    beam = Beam(alpha=1, beta=0.5, gamma=3)
    for at, deflection in ((1.0, 0.3), (0.8, -0.2), (0.35, 0.05)):
        force = pulled(beam, deflection, at).force
        found = motion(beam, 0.1, release=force, release_at=at)
        assert found.position([0.0], [at])[0, 0, 1] == pytest.approx(deflection, abs=1e-5)


@pytest.mark.parametrize(
    ("beam", "options"),
    [
        (Beam(gamma=0.1), {"release": SMALL}),
        (Beam(gamma=0.1, delta=0.2), {"release": SMALL, "release_at": 0.6, "damping": 0.02}),
        (Beam(alpha=1, beta=0.7), {"release": SMALL, "drop": 0.9}),
        (Beam(alpha=1, beta=0.7), {"release": SMALL, "catch": 0.9}),
        (Beam(alpha=0.5, beta=0.7), {"speed": Ramp(0.2, 1.0)}),
    ],
    ids=["released", "elsewhere", "dropped", "caught", "spun up"],
)
def test_small_motions_are_the_same_without_stiffening(beam, options):
    """But for stiffening, 1.2 gamma^2 of omega^2 = 12.4. To 2 % of the deflection: the modes that
    are left out, and the change of phase by stiffening."""
    until = 1.2
    found = motion(beam, until, tolerance=1e-5, **options)
    other = motion_without_stiffening(beam, until, tolerance=1e-5, **options)
    assert other.t[-1] == until
    largest = np.abs(found.tip[:, 1]).max()
    assert np.abs(other.tip[:, 1] - found.tip[:, 1]).max() < 0.02 * largest


def test_without_stiffening_a_fast_beam_diverges():
    """Beyond the frequency of B1 at rest, not below it; then as exp(sqrt(gamma^2 - omega^2) t)."""
    omega = solve(Beam()).frequencies[0]
    speeds = (0.9 * omega, 1.3 * omega)
    slow, fast = (
        motion_without_stiffening(Beam(gamma=g, mu=1000), 8, release=1e-4) for g in speeds
    )
    assert slow.t[-1] == 8
    assert fast.t[-1] < 8
    assert np.abs(fast.tip[-1] - [1, 0]).max() == pytest.approx(DIVERGED, abs=1e-6)
    late = fast.tip[:, 1] / fast.tip[-1, 1] > 0.01
    rate = np.polyfit(fast.t[late], np.log(np.abs(fast.tip[late, 1])), 1)[0]
    assert rate == pytest.approx(np.sqrt(speeds[1] ** 2 - omega**2), rel=1e-3)
    assert fast.position(fast.t[-1:], [1.0])[0, 0] == pytest.approx(fast.tip[-1])


def test_coriolis_forces_stretch_a_beam_that_swings():
    """Without stiffening too: mu^2 u" = -2 gamma dw/dt, so that the tip moves outward with its
    velocity across."""
    swings = motion_without_stiffening(Beam(gamma=0.3, mu=20), 4, release=1e-3, points=801)
    velocity = np.gradient(swings.tip[:, 1], swings.t)
    outward = swings.tip[:, 0] - swings.tip[0, 0]
    assert np.corrcoef(outward, velocity)[0, 1] > 0.8


def test_the_linear_theory_takes_no_start_in_modes_and_no_spring():
    """Which is said."""
    with pytest.raises(InvalidInput, match="no start in modes"):
        motion_without_stiffening(Beam(), 1.0, start={"B1": 0.1})
    with pytest.raises(InvalidInput, match="uniform"):
        motion_without_stiffening(Beam(root=5), 1.0, release=0.1)


def test_a_body_docks_with_its_velocity_without_stiffening_too():
    """At a low speed both theories agree: a blow of 0.01 L/T* moves the tip by less than 0.01 L,
    in both to 1 % of it."""
    beam, given = Beam(alpha=1, gamma=0.1), {"catch": 0.5, "body_velocity": (0.0, 0.01)}
    linear = motion_without_stiffening(beam, 1.0, points=11, **given)
    full = motion(beam, 1.0, points=11, tolerance=1e-6, **given)
    assert abs(full.tip[-1, 1]) > 1e-3
    assert linear.tip[-1, 1] == pytest.approx(full.tip[-1, 1], rel=0.01)
