"""Motion in time of blades, of beams with bodies that turn, and on hinges and springs."""

import math

import numpy as np
import pytest
from helpers import slow

from beamviz import Beam, Hub, Ramp, motion, solve
from beamviz.blade import Blade, Mass
from beamviz.presets import preset

TAPER = Blade.tapered(height=0.5)
JUMPS = Blade((0, 0.4, 0.4, 1), (1, 0.8, 0.5, 0.2), (1, 0.7, 0.3, 0.1), (1, 0.9, 0.6, 0.4))
TURNING = Mass(0.3, 0.6, (0.02, 0.02, 0.05))
BEAMS = {
    "tapered": Beam(gamma=5, blade=TAPER),
    "jumps": Beam(gamma=4, blade=JUMPS, alpha=0.5, beta=0.7),
    "turning bodies": Beam(gamma=3, masses=(TURNING, Mass(0.2, 1.0, (0, 0, 0.03)))),
    "sprung root": Beam(gamma=4, root=5.0, alpha=1, beta=0.5),
    "hinged": Beam(gamma=5, root=0.0, delta=0.3),
    "wind turbine": preset("nrel-5mw-blade").beam.replace(gamma=3),
}


@pytest.mark.parametrize(
    ("name", "label"),
    [*zip(BEAMS, ("B2", "B1") * 3, strict=True), *slow(*zip(BEAMS, ("B1", "B2") * 3, strict=True))],
)
def test_a_small_vibration_has_the_frequency_of_its_mode(name, label):
    """Started in a mode with Coriolis forces, the tip moves as this mode alone does."""
    beam, amplitude = BEAMS[name], 1e-4
    solution = solve(beam, coriolis=True, modes=6)
    k = solution.labels.index(label)
    omega = solution.frequencies[k]
    moved = motion(beam, 4 * math.pi / omega, start={label: amplitude}, tolerance=1e-7, points=101)
    shape = solution.shape(k, np.array([1.0]))[0]
    shape = shape / np.linalg.norm(solution.shape(k, np.linspace(0, 1, 201)), axis=1).max()
    linear = amplitude * (shape * np.exp(1j * omega * moved.t)[:, None]).real
    # The next term is of the second order in the amplitude, 1e-8, times the curvature.
    assert moved.tip - solution.equilibrium.tip == pytest.approx(linear, abs=1e-6)
    assert moved.error <= 1e-7


@pytest.mark.parametrize(
    "name", ["turning bodies", "sprung root", "hinged", *slow("tapered", "jumps", "wind turbine")]
)
def test_a_large_motion_keeps_its_energy(name):
    """The Jacobi integral, after a start with a tenth of a length."""
    moved = motion(BEAMS[name], 2.0, start={"B1": 0.1}, tolerance=1e-5)
    swing = np.ptp(moved.energy)
    alone = motion(BEAMS[name], 0.01, tolerance=1e-5).energy[0]
    assert swing < 1e-3 * abs(moved.energy[0] - alone)


def test_a_stiff_beam_on_a_hinge_is_a_pendulum_in_the_centrifugal_field():
    """A rigid bar hinged at a distance delta from the axis: phi" = -gamma^2 delta S / J sin phi,
    S = 1/2, J = 1/3, integrated at an amplitude of 1 rad by scipy. The bar bends by 1e-4."""
    from scipy.integrate import solve_ivp

    stiff = 1e4  # times as stiff: frequencies of bending are above those of the pendulum
    gamma, delta = 3.0, 0.5
    slow = gamma / math.sqrt(stiff)
    beam = Beam(gamma=slow, delta=delta, root=0.0, mu=1000)
    amplitude = 1e-3
    period = 2 * math.pi / (slow * math.sqrt(1.5 * delta))
    moved = motion(beam, period, start={"B1": amplitude}, tolerance=1e-7, points=41)

    def rates(_, y):
        return [y[1], -(slow**2) * delta * 1.5 * math.sin(y[0])]

    times = moved.t
    exact = solve_ivp(rates, (0, period), [amplitude, 0], t_eval=times, rtol=1e-10, atol=1e-13)
    assert moved.tip[:, 1] == pytest.approx(np.sin(exact.y[0]), abs=2e-6)


def test_a_hinged_beam_that_swings_is_hardly_bent():
    """No moment acts on it at the hinge and at the tip, where a start in its rigid mode bends it by
    no more than its own shape; a clamped one is bent at its root by the force there times L."""
    swinging = motion(Beam(gamma=2, delta=0.2, root=0.0, mu=200), 0.1, start={"B1": 0.2})
    assert abs(swinging.curvature([0.0, 0.1], [0.0, 1.0])).max() < 2e-3
    held = motion(Beam(), 0.1, release=0.01, tolerance=1e-6)
    assert held.curvature([0.0], [0.0, 0.5])[0] == pytest.approx([0.01, 0.005], rel=1e-3)


def test_a_hub_and_its_blade_keep_their_angular_momentum():
    """J gamma + int rho R x v + Jz (theta' + gamma) is constant without a torque."""
    body = Mass(0.3, 0.7, (0.0, 0.0, 0.2))
    beam = Beam(gamma=2, delta=0.2, masses=(body,), blade=TAPER)
    moved = motion(beam, 1.5, speed=Hub(inertia=0.4), start={"B1": 0.1}, points=301)
    x, weight = np.polynomial.legendre.leggauss(40)
    x, weight = (x + 1) / 2, weight / 2
    points = np.append(x, body.beta)
    rho = np.append(weight * TAPER.at("mass", x), body.alpha)
    momenta, step = [], 1e-4
    for k in (40, 130, 260):
        t = moved.t[k]
        before, now, after = moved.position([t - step, t, t + step], points)
        R, v = now + [beam.delta, 0], (after - before) / (2 * step)
        near = np.array([body.beta - 1e-4, body.beta + 1e-4])
        slopes = np.diff(moved.position([t - step, t + step], near), axis=1)[:, 0]
        turning = np.diff(np.arctan2(slopes[:, 1], slopes[:, 0]))[0] / (2 * step)
        gamma = moved.gamma[k]
        momentum = 0.4 * gamma + rho @ (
            gamma * (R**2).sum(axis=1) + R[:, 0] * v[:, 1] - R[:, 1] * v[:, 0]
        )
        momenta.append(momentum + body.inertia[2] * (turning + gamma))
    assert momenta == pytest.approx([momenta[0]] * 3, rel=2e-3)
    assert np.ptp(moved.gamma) > 0.02 * 2  # and the speed is not


def test_a_blade_spun_up_ends_at_its_equilibrium():
    beam = preset("tapered-steel-blade").beam.replace(gamma=0.0)
    moved = motion(beam, 30, speed=Ramp(4, 5), damping=0.1, tolerance=1e-6, points=3)
    steady = solve(beam.replace(gamma=4)).equilibrium
    assert moved.tip[-1] == pytest.approx(steady.tip, abs=3e-6)


def test_a_speed_that_changes_its_sign():
    """Turning the other way is the mirror image, and a reversal goes through rest."""
    forth, back = (motion(Beam(), 3, speed=([0, 1, 2], [0, s, -s]), points=31) for s in (2, -2))
    assert forth.tip == pytest.approx(back.tip * [1, -1], abs=2e-4)
    assert forth.gamma[-1] == -2
    assert abs(forth.tip[:, 1]).max() > 0.01
