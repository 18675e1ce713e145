"""The forced response: against closed forms, one mode alone, a direct solve of all equations."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamviz.beam import Beam
from beamviz.errors import InvalidInput
from beamviz.frequency_loci.forced_response import (
    LOADS,
    quadrature,
    response,
    run_up,
    static_deflection,
)
from beamviz.solver import solve

TIP = np.ones(1)


def bent(frequency: float, x: np.ndarray) -> np.ndarray:
    """Deflection at x of a clamped beam at rest under the load -1 exp(i omega t) per length:
    w'''' - omega^2 w = -1 with w, w' = 0 at the clamp and w'', w''' = 0 at the tip."""
    b = math.sqrt(frequency)
    cosh, sinh, cos, sin = math.cosh(b), math.sinh(b), math.cos(b), math.sin(b)
    # w = 1 / omega^2 (1 - C1 cosh bx - C2 sinh bx - C3 cos bx - C4 sin bx)
    equations = [[1, 0, 1, 0], [0, 1, 0, 1], [cosh, sinh, -cos, -sin], [sinh, cosh, sin, -cos]]
    c = np.linalg.solve(np.array(equations), [1.0, 0.0, 0.0, 0.0])
    shapes = np.stack([np.cosh(b * x), np.sinh(b * x), np.cos(b * x), np.sin(b * x)], 1)
    return (1 - shapes @ c) / frequency**2


@pytest.mark.parametrize("frequency", [1.0, 3.0, 10.0, 30.0])
def test_without_rotation_it_is_the_closed_form(frequency):
    """Euler-Bernoulli under a uniform load, no damping; modes beyond the 20th are left out."""
    x = np.linspace(0, 1, 11)
    exact = bent(frequency, x) / (1 / 8)
    found = response(solve(Beam(), modes=20), frequency, 0.0, x)
    assert np.abs(found[:, 1] - exact).max() < 1e-4 * np.abs(exact).max()


def test_the_static_deflection_is_the_unit():
    """The unit of the amplitude, with a mass anywhere: by definition, whatever the beam."""
    for beam in (Beam(), Beam(alpha=2, beta=0.4), Beam(alpha=1, beta=1)):
        still = response(solve(beam, modes=20), 1e-6, 0.01, TIP)[0]
        assert still[1].real == pytest.approx(-1, rel=1e-5)


def test_along_the_beam_it_is_the_closed_form():
    """A bar under the load i exp(i omega t) per length: u'' + k^2 u = -i / mu^2, k = omega / mu;
    u = i / omega^2 (cos kx + tan k sin kx - 1)."""
    omega, mu, x = 40.0, 70.0, np.linspace(0, 1, 11)
    k = omega / mu
    exact = 1j / omega**2 * (np.cos(k * x) + np.tan(k) * np.sin(k * x) - 1)
    found = response(solve(Beam(mu=mu), modes=20), omega, 0.0, x)[:, 0] / 8
    assert np.abs(found - exact).max() < 2e-2 * np.abs(exact).max()  # three stretching modes


@given(st.floats(0.001, 0.2), st.floats(0.2, 3.0))
def test_one_mode_alone_answers_as_an_oscillator(damping, ratio):
    """F phi / (omega_1^2 - omega^2 + 2 i zeta omega_1 omega), also past its resonance."""
    solution = solve(Beam(alpha=1, gamma=2), modes=1)
    (omega1,) = solution.frequencies
    omega = ratio * omega1
    x, weight = quadrature(solution.beam)
    force = -weight @ solution.shape(0, x)[:, 1]
    oscillator = force / (omega1**2 - omega**2 + 2j * damping * omega1 * omega)
    expected = oscillator * solution.shape(0, TIP)[0, 1] / static_deflection(solution.beam)
    found = response(solution, omega, damping, TIP)[0, 1]
    assert found == pytest.approx(expected, rel=1e-9)


class Direct:
    """M, G and K of a rotating beam from many shape functions of its own, all at once: polynomials
    for u and w about the stretched equilibrium, of which only the state comes from the package."""

    COUNT = 16

    def __init__(self, beam: Beam):
        equilibrium = solve(beam).equilibrium
        x, weight = quadrature(beam)
        inner, gauss = x[:-1], weight[:-1]
        f = equilibrium.stretch(inner)
        step = 1e-5
        f1 = (equilibrium.stretch(inner + step) - equilibrium.stretch(inner - step)) / (2 * step)
        n, n1 = (f**3 - f) / 2, (3 * f**2 - 1) / 2  # green
        self.U, dU, _ = self.shapes(x, 1)
        self.W, dW, ddW = self.shapes(x, 2)
        bend = (f[:, None] * ddW[:-1] - f1[:, None] * dW[:-1]) / f[:, None] ** 3  # spatial
        stiff, tension = gauss * beam.mu**2 * n1, gauss * beam.mu**2 * n / f
        spin = beam.gamma**2
        mass = [part.T @ (weight[:, None] * part) for part in (self.U, self.W)]
        Ka = dU[:-1].T @ (stiff[:, None] * dU[:-1]) - spin * mass[0]
        Kb = bend.T @ (gauss[:, None] * bend) + dW[:-1].T @ (tension[:, None] * dW[:-1])
        zero = np.zeros((self.COUNT, self.COUNT))
        cross = self.U.T @ (weight[:, None] * self.W)
        self.K = np.block([[Ka, zero], [zero, Kb - spin * mass[1]]])
        self.M = np.block([[mass[0], zero], [zero, mass[1]]])
        self.G = np.block([[zero, -cross], [cross.T, zero]])
        along, across = LOADS["chordwise"]
        self.F = np.concatenate([along * (weight @ self.U), across * (weight @ self.W)])
        self.beam = beam

    def shapes(self, x: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """x^order times Legendre polynomials, with two derivatives, (len(x), COUNT) each."""
        P = np.polynomial.Polynomial
        basis = [np.polynomial.Legendre.basis(k, domain=[0, 1]) for k in range(self.COUNT)]
        made = [one.convert(kind=P) * P([0, 1]) ** order for one in basis]
        return tuple(np.array([one.deriv(d)(x) for one in made]).T for d in range(3))  # type: ignore[return-value]

    def tip(self, omega: float, coriolis: bool, damping: np.ndarray | float = 0.0) -> np.ndarray:
        """The tip (2,) under the force at omega."""
        gyroscopic = 2j * omega * self.beam.gamma * self.G if coriolis else 0.0
        q = np.linalg.solve(self.K - omega**2 * self.M + gyroscopic + 1j * omega * damping, self.F)
        parts = q[: self.COUNT], q[self.COUNT :]
        ends = [self.shapes(TIP, order)[0][0] for order in (1, 2)]
        tip = [end @ part for end, part in zip(ends, parts, strict=True)]
        return np.array(tip) / static_deflection(self.beam)


@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize("ratio", [0.3, 0.95, 1.2, 4.0])
def test_the_sum_of_modes_is_a_direct_solve(coriolis, ratio):
    """A rotating beam with a mass at the tip, below and above its first resonance, no damping."""
    beam = Beam(alpha=1, beta=1, gamma=8, delta=0.2, mu=70)
    solution = solve(beam, modes=20, coriolis=coriolis)
    omega = ratio * float(solution.frequencies[0])
    expected = Direct(beam).tip(omega, coriolis)
    found = response(solution, omega, 0.0, TIP)[0]
    # along the beam only a few stretching modes are among the twenty
    assert found[1] == pytest.approx(expected[1], rel=2e-3)
    assert found[0] == pytest.approx(expected[0], rel=0.1, abs=2e-3 * abs(expected[1]))


def test_damping_is_that_of_every_mode():
    """A direct solve with the damping matrix that gives each mode the same ratio."""
    beam, damping = Beam(alpha=1, beta=1, gamma=8, mu=70), 0.03
    direct = Direct(beam)
    L = np.linalg.cholesky(direct.M)
    A = np.linalg.solve(L, np.linalg.solve(L, direct.K).T)
    squares, vectors = np.linalg.eigh((A + A.T) / 2)
    C = L @ vectors @ np.diag(2 * damping * np.sqrt(squares)) @ vectors.T @ L.T
    solution = solve(beam, modes=20)
    for ratio in (0.5, 1.0, 1.01):
        omega = ratio * float(solution.frequencies[0])
        expected = direct.tip(omega, False, C)
        found = response(solution, omega, damping, TIP)[0]
        assert found[1] == pytest.approx(expected[1], rel=1e-3)


# A run


def test_a_run_peaks_at_its_resonances():
    """Where 1 gamma meets B1 and 2 gamma meets B2 the tip is farthest: half as much damping,
    twice as far."""
    beam = Beam(alpha=1, beta=0.5)
    run = run_up(beam, 2, 0.02, 20.0)
    assert [one.branch for one in run.resonances] == ["B1", "B2"]
    assert (np.diff(run.speeds) > 0).all()
    for one in run.resonances:
        near = abs(run.speeds - one.at) < 0.05 * one.at
        top = run.speeds[near][np.argmax(run.amplitudes[near])]
        assert top == pytest.approx(one.at, rel=0.02)
        half = run_up(beam, 2, 0.01, 20.0)
        assert half.peak(one) == pytest.approx(2 * run.peak(one), rel=0.1)


def test_an_ellipse_is_measured_at_its_largest():
    """The tip goes round: no moment of it is farther from rest than the amplitude."""
    run = run_up(Beam(alpha=1, beta=0.5), 1, 0.02, 12.0, coriolis=True)
    solution = run.solutions[40]
    assert solution
    tip = response(solution, solution.beam.gamma, 0.02, TIP)[0]
    turn = np.exp(1j * np.linspace(0, 2 * np.pi, 2001))[:, None]
    far = np.linalg.norm((tip * turn).real, axis=1).max()
    assert run.amplitudes[40] == pytest.approx(far, rel=1e-5)


def test_no_steady_response_where_the_beam_is_unstable():
    """An inward beam past its buckling: no amplitude."""
    run = run_up(Beam(delta=-1), 1, 0.02, 6.0)
    assert np.isfinite(run.amplitudes[run.speeds < 2.9]).all()
    assert np.isnan(run.amplitudes[run.speeds > 3.1]).all()


def test_wrong_input():
    """Per-rev and damping with their ranges."""
    with pytest.raises(InvalidInput, match="per_rev = 0"):
        run_up(Beam(), 0, 0.02, 5.0)
    with pytest.raises(InvalidInput, match=r"damping = 0\.5: must lie in 0\.001 \.\. 0\.2"):
        run_up(Beam(), 1, 0.5, 5.0)


@settings(max_examples=10)
@given(st.floats(0, 20), st.floats(0, 2), st.floats(0, 1), st.booleans())
def test_five_modes_are_enough(gamma, alpha, beta, coriolis):
    """Five modes are enough for the picture: 2 % of the deflection with all twenty."""
    beam = Beam(alpha=alpha, beta=beta, gamma=gamma)
    few, many = (
        response(solve(beam, modes=modes, coriolis=coriolis), gamma, 0.05, TIP)[0, 1]
        for modes in (5, 20)
    )
    assert abs(few - many) < 0.02 * max(abs(many), 1)
