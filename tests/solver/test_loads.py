"""Axial force, shear, moment and reaction of straight and deflected equilibria."""

import json

import numpy as np
import pytest
from scipy.integrate import quad

from beamviz import solve
from beamviz.beam import Beam
from beamviz.blade import Blade, Mass
from beamviz.output.solution import solution_json

X = np.linspace(0, 1, 21)
JUMP = Blade(
    (0, 0.4, 0.4, 1), (1, 0.8, 0.5, 0.2), (1, 0.7, 0.3, 0.1), (1, 0.9, 0.6, 0.4), (2, 1.8, 1.7, 1)
)
BODY = Mass(0.2, 0.7, (0.05, 0.08, 0.1))


@pytest.mark.parametrize("method", ["auto", "ancf", "linear", "foac", "chebyshev"])
def test_the_force_of_a_uniform_beam(method):
    """gamma^2 int_x^1 rho (x + delta) where the beam hardly stretches: at mu 1e4 by 1e-6."""
    beam = Beam(alpha=0.5, beta=0.7, gamma=5, delta=0.3, mu=1e4)
    found = solve(beam, method=method).equilibrium
    carried = np.where(X <= 0.7, 0.5, 0.0)  # at the mass on the side of the root
    expected = 25 * ((1 - X) * ((1 + X) / 2 + 0.3) + carried)
    assert found.force(X) == pytest.approx(expected, rel=2e-6, abs=1e-12)
    at_mass = 25 * (0.3 * (1.7 / 2 + 0.3) + 0.5)
    assert found.force([0.7]) == pytest.approx([at_mass], rel=2e-6)
    assert found.root_force == found.force([0.0])[0]
    assert (found.shear(X) == 0).all()
    assert (found.moment(X) == 0).all()


def test_the_force_is_that_of_the_stretch():
    """mu^2 EA n(f) of a blade that stretches much, with a body: f from equilibrium of its own."""
    beam = Beam(gamma=20, delta=0.5, mu=20, blade=JUMP, masses=(BODY,))
    found = solve(beam, tolerance=1e-10).equilibrium
    x = X + 0.003 * (X < 1)  # beside the jumps
    f = found.stretch(x[:-1])
    force = 400 * JUMP.at("axial", x[:-1]) * (f * f - 1) * f / 2
    assert found.force(x[:-1]) == pytest.approx(force, rel=1e-6)


@pytest.mark.parametrize(
    "beam",
    [
        Beam(gamma=5, spin_up=10),
        Beam(gamma=4, delta=-1),
        Beam(
            gamma=5, delta=0.1, spin_up=10, alpha=0.3, beta=0.4, blade=JUMP, masses=(BODY,), root=30
        ),
        Beam(gamma=4, delta=-1, blade=JUMP, root=3),
    ],
)
def test_loads_of_deflected_states(beam):
    """Integrals of the centrifugal and Euler forces at the positions, by adaptive quadrature; at
    the root the moment of its spring; inside the moment b(f) EI theta'."""
    found = solve(beam, state="stable", tolerance=1e-9).equilibrium
    bodies = [(body.alpha, body.beta, body.inertia[2]) for body in beam.bodies]

    def rho(x):
        return float(beam.blade.at("mass", x)) if beam.blade else 1.0

    def q(x):
        X, Y = found.position([x])[0] + [beam.delta, 0]
        load, spin_up = beam.gamma**2, beam.spin_up
        return np.array([load * X + spin_up * Y, load * Y - spin_up * X])

    def integral(function, x):
        return quad(function, x, 1, points=[0.4, 0.7], epsrel=1e-9, limit=200)[0]

    for x in (0.0, 0.25):
        position, (angle,) = found.position([x])[0], found.angle([x])
        force = np.array([integral(lambda s, k=k: rho(s) * q(s)[k], x) for k in (0, 1)])

        def moment_of(s, position=position):
            arm = found.position([s])[0] - position
            force = q(s)
            return arm[0] * force[1] - arm[1] * force[0]

        moment = integral(lambda s: rho(s) * moment_of(s), x)
        for alpha, beta, Jz in bodies:
            force += alpha * q(beta)
            moment += alpha * moment_of(beta) - beam.spin_up * Jz
        t, n = [np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]
        assert found.force([x])[0] == pytest.approx(force @ t, rel=1e-7)
        assert found.shear([x])[0] == pytest.approx(force @ n, rel=1e-7)
        assert found.moment([x])[0] == pytest.approx(moment, rel=1e-7)
    if beam.root < np.inf:
        assert found.root_moment == pytest.approx(beam.root * found.angle([0.0])[0], rel=1e-7)
    x = np.array([0.2, 0.55, 0.9])
    slope = (found.angle(x + 1e-5) - found.angle(x - 1e-5)) / 2e-5
    EI = beam.blade.at("bending", x) if beam.blade else 1.0
    assert found.moment(x) == pytest.approx(EI * slope / found.stretch(x) ** 2, rel=1e-4)


def test_a_body_out_of_the_plane_of_rotation():
    """A buckled inward blade that bends flapwise carries the centrifugal moment of its body: at the
    root its spring has the moment of all."""
    beam = Beam(gamma=6, delta=-1, masses=(Mass(0.2, 1.0, (0.1, 0.1, 0.02)),), root=5)
    found = solve(beam, plane="flapwise", state="bent", tolerance=1e-9).equilibrium
    assert abs(found.root_moment) > 0.1
    assert found.root_moment == pytest.approx(5 * found.angle([0.0])[0], rel=1e-7)


def test_loads_in_files():
    """The reaction in JSON, the loads along the beam in a dataset."""
    beam = Beam(gamma=5, spin_up=10)
    solution = solve(beam, state="stable")
    state, root = json.loads(solution_json(solution))["equilibrium"], solution.equilibrium.root
    assert [state[f"root_{name}"] for name in ("force", "shear", "moment")] == pytest.approx(root)
    data = solution.to_xarray()
    assert data["moment"].values[0] == pytest.approx(root.moment)


def test_loads_in_si():
    """The axial force of a steel beam is m Omega^2 (L / 2 + a) but for its stretch, in N."""
    length, density, area, speed, hub = 2.0, 7800.0, 1e-3, 20.0, 0.3
    beam = Beam.from_si(
        length=length,
        density=density,
        area=area,
        second_moment=1e-8,
        youngs_modulus=2.1e11,
        rotation_speed=speed,
        hub_radius=hub,
    )
    state = json.loads(solution_json(solve(beam)))["equilibrium"]
    force = density * area * length * speed**2 * (length / 2 + hub)
    assert state["root_force_newtons"] == pytest.approx(force, rel=1e-4)
    assert state["root_moment_newton_metres"] == 0
