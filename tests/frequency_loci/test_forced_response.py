"""Resonances: all intersections of loci with per-rev lines, for any speeds of the sweep. The forced
response: against closed forms, one mode alone, a direct solve of all equations."""

import math

import numpy as np
import pytest
from helpers import slow
from hypothesis import given, settings
from hypothesis import strategies as st

from beamviz import Beam, BeamvizError, InvalidInput, loci, solve, solve_many
from beamviz.frequency_loci.forced_response import (
    LOADS,
    quadrature,
    resonances,
    response,
    run_up,
    static_deflection,
)

HEAVY = Beam(alpha=1, beta=1)
TIP = np.ones(1)


def located(found, per_rev, label):
    """The speeds of the resonances of one branch with one line, of four."""
    return [one.at for one in resonances(found, 4) if (one.per_rev, one.branch) == (per_rev, label)]


def test_resonances():
    """Each lies on a locus and on a line of a multiple of the speed."""
    found = resonances(loci(HEAVY, "gamma", np.linspace(0, 30, 16), coriolis=True), 4)
    assert [(one.per_rev, one.branch) for one in found][:4] == [(k, "B1") for k in (4, 3, 2, 1)]
    for one in found:
        frequencies = solve(HEAVY.replace(gamma=one.at), coriolis=True, tolerance=1e-9).frequencies
        assert one.frequency == one.per_rev * one.at
        assert abs(frequencies - one.frequency).min() < 1e-6 * one.frequency


@pytest.mark.parametrize(
    ("delta", "points", "expected"),
    [
        *((0.0, points, [73.591, 85.314]) for points in (2, 5, 201)),
        *((0.0007236814724, points, [79.102, 79.238]) for points in (5, 401)),
        (0.00073, 101, []),
    ],
)
def test_few_speeds_are_enough(delta, points, expected):
    """4x B3 has two resonances, closer together than the speeds of the sweep; with a little more
    hub radius the locus misses its line."""
    found = loci(Beam(delta=delta), "gamma", np.linspace(0, 200, points), modes=6)
    assert located(found, 4, "B3") == pytest.approx(expected, abs=1e-3)


def test_up_to_the_end_of_an_equilibrium():
    """With Hencky strain it ends at gamma 45.420. Between the last speed of the sweep and that S2
    falls below B3 and intersects the 4x line."""
    found = loci(Beam(), "gamma", np.linspace(0, 60, 61), modes=6, strain="hencky")
    (at,) = located(found, 4, "S2")
    assert 45 < at < found.limits[0].start
    there = solve(Beam(gamma=at), 6, strain="hencky")
    assert there.frequencies[there.labels.index("S2")] == pytest.approx(4 * at, rel=1e-6)


def test_a_resonance_at_a_speed_of_the_sweep_is_found_once():
    """At a value of the sweep exactly, and with a rounding error."""
    (at,) = located(loci(HEAVY, "gamma", np.linspace(0, 5, 6)), 2, "B1")
    for value in (at, np.nextafter(at, 0), np.nextafter(at, 9)):
        again = located(loci(HEAVY, "gamma", [0.0, 0.5, value, 3.0]), 2, "B1")
        assert again == pytest.approx([at], rel=1e-9)


def random_sweep(seed):
    """A beam, the end of its sweep, the number of speeds and the options."""
    chance = np.random.default_rng(seed)
    beam = Beam(
        alpha=chance.choice([0, 10 ** chance.uniform(-1, 1)]),
        beta=chance.choice([1.0, chance.uniform(0.1, 1)]),
        delta=chance.choice([0, chance.uniform(0, 1), -chance.uniform(0, 0.5)]),
        mu=10 ** chance.uniform(1.6, 2.5),
    )
    options = {
        "coriolis": bool(chance.integers(2)),
        "strain": str(chance.choice(["green", "green", "hencky", "biot"])),
    }
    return beam, float(chance.uniform(10, 150)), int(chance.choice([3, 6, 21, 81])), options


def dense_resonances(beam, stop, options):
    """Intersections of sorted frequencies on a dense grid of direct solves: no tracking, no
    interpolation; for each (per_rev, speed before, speed after)."""
    speeds = np.linspace(0, stop, 1501)[:-1]
    f = np.full((1500, 5), np.nan)
    outcomes = solve_many([beam.replace(gamma=x) for x in speeds], **options)
    for row, outcome in zip(f, outcomes, strict=True):
        if not isinstance(outcome, BeamvizError):
            row[:] = np.nan_to_num(outcome.frequencies, nan=0.0)
    for k in (1, 2, 3):
        above = f > k * speeds[:, None]
        changes = (above[1:] != above[:-1]) & np.isfinite(f[1:] + f[:-1])
        for i, _ in np.argwhere(changes):
            yield k, speeds[i], speeds[i + 1]


@pytest.mark.parametrize("seed", [4, 5, *slow(0, 1, 2, 3)])
def test_against_direct_solves(seed):
    """Every intersection on a dense grid is found within its step, for any sweep."""
    beam, stop, points, options = random_sweep(seed)
    found = loci(beam, "gamma", np.linspace(0, stop, points), **options)
    remaining = [(one.per_rev, one.at) for one in resonances(found, 3)]
    ends = [limit.start for limit in found.limits if limit.kind == "no-equilibrium"]
    for k, low, high in dense_resonances(beam, min([stop, *ends]), options):
        here = [one for one in remaining if one[0] == k and low - 1e-6 <= one[1] <= high + 1e-6]
        assert here, (k, low, high)
        remaining.remove(here[0])
    for k, at in remaining:  # closer together than the dense grid, or just before a limit
        frequencies = solve(beam.replace(gamma=at), **options).frequencies
        assert np.nanmin(abs(frequencies - k * at)) < 1e-5 * k * at


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
        f1 = (equilibrium.stretch(inner + 1e-5) - equilibrium.stretch(inner - 1e-5)) / 2e-5
        n, n1 = (f**3 - f) / 2, (3 * f**2 - 1) / 2  # green
        self.U, dU, _ = self.shapes(x, 1)
        self.W, dW, ddW = self.shapes(x, 2)
        bend = (f[:, None] * ddW[:-1] - f1[:, None] * dW[:-1]) / f[:, None] ** 3  # spatial
        stiff, tension = gauss * beam.mu**2 * n1, gauss * beam.mu**2 * n / f
        spin, self.beam = beam.gamma**2, beam
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
        parts = zip((1, 2), np.split(q, 2), strict=True)
        tip = [self.shapes(TIP, order)[0][0] @ part for order, part in parts]
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


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: resonances(loci(HEAVY, "alpha", [0, 1]), 3),
            "need loci over gamma, not over alpha",
        ),
        (lambda: resonances(loci(HEAVY, "gamma", [0, 1]), per_rev=3), "'per_rev': known: count"),
        (lambda: run_up(Beam(), 0, 0.02, 5.0), "per_rev = 0"),
        (lambda: run_up(Beam(), 1, 0.5, 5.0), r"damping = 0\.5: must lie in 0\.001 \.\. 0\.2"),
    ],
)
def test_wrong_input(call, message):
    """Per-rev lines need the speed; ranges and mistyped keywords are named."""
    with pytest.raises(InvalidInput, match=message):
        call()


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
