"""The oracle against published tables, closed forms and itself, before anything relies on it."""

from itertools import pairwise

import numpy as np
import pytest
from published import (
    CROSSINGS,
    INDEPENDENT,
    INDEPENDENT_CORIOLIS,
    LIMITS,
    RIGID_CORIOLIS,
    TIP_MASS_AT_REST,
    TIP_MASS_FLAPWISE,
    UNIFORM_FLAPWISE,
    bar_at_rest,
    cantilever_at_rest,
)
from scipy.integrate import solve_ivp

from beamviz.beam import Beam
from oracle import CURVATURE, FINE, Spectrum, truth
from oracle.eigen import UnresolvedError
from oracle.equilibrium import STIFFNESS, NoStateError, Resolution, shoot, stretch

RIGID = 10000.0  # slenderness; stretch is (gamma / mu)^2 = 1e-6 at most in the rigid tables
ROUNDING = 1e-12


@pytest.mark.parametrize("row", UNIFORM_FLAPWISE, ids=str)
def test_uniform_beam_flapwise(row):
    """Wright et al. 1982; one unit of the last digit, since 22.0345 is printed as 22.035."""
    gamma, *published = row
    found = truth(Beam(gamma=gamma, mu=RIGID), 3, plane="flapwise").frequencies
    assert found == pytest.approx(published, abs=1e-3)


@pytest.mark.parametrize("row", TIP_MASS_FLAPWISE, ids=str)
def test_tip_mass_flapwise(row):
    """Wright et al. 1982; one unit of the last digit, two figures after the point in the second."""
    gamma, first, second = row
    found = truth(Beam(alpha=1, gamma=gamma, mu=RIGID), 2, plane="flapwise").frequencies
    assert found[0] == pytest.approx(first, abs=1e-3 if first < 10 else 1e-2)
    assert found[1] == pytest.approx(second, abs=1e-2)


@pytest.mark.parametrize(("gamma", "published"), RIGID_CORIOLIS)
def test_coriolis_in_the_linear_axial_model(gamma, published):
    """Hamza Cherif & Houmat: no stretch, rigid tension; four decimals, cut off, not rounded.

    At gamma 50 their few elements leave 0.04 % (frequencies converge from above).
    """
    spectrum = Spectrum(Beam(gamma=gamma), "biot", "material", FINE[0])
    spectrum.f = np.ones_like(spectrum.mesh.x)
    spectrum.N = gamma**2 * (1 - spectrum.mesh.x**2) / 2
    spectrum.stiffness = np.full_like(spectrum.N, 70.0**2)
    tolerance = 1e-4 if gamma <= 10 else 4e-4 * published
    assert np.sqrt(spectrum.coupled(1)[0]) == pytest.approx(published, abs=tolerance)


def test_tip_mass_at_rest():
    """MPE 2017/1568019, table 1, to the digits printed."""
    found = truth(Beam(alpha=1, mu=RIGID)).frequencies
    assert found == pytest.approx(TIP_MASS_AT_REST, rel=5e-7)


@pytest.mark.parametrize("alpha", [0.0, 1e-3, 1.0, 100.0])
def test_tip_mass_at_rest_in_closed_form(alpha):
    """Blevins's characteristic equation of a cantilever with a tip mass."""
    found = truth(Beam(alpha=alpha, mu=RIGID), 4).frequencies
    assert found == pytest.approx(cantilever_at_rest(alpha), rel=ROUNDING)


@pytest.mark.parametrize("delta", [0.0, 3.0])
@pytest.mark.parametrize("alpha", [0.1, 1.0, 10.0])
def test_stretching_of_a_linear_bar_in_closed_form(alpha, delta):
    """omega^2 = mu^2 z^2 - gamma^2 with z tan z = 1 / alpha: biot has a constant stiffness."""
    gamma, mu = 7.0, 70.0
    found = Spectrum(Beam(alpha, 1, gamma, delta, mu), "biot", "spatial", FINE[0]).stretching(1)
    assert found[0] == pytest.approx((mu * bar_at_rest(alpha)) ** 2 - gamma**2, rel=ROUNDING)


@pytest.mark.parametrize(("alpha", "printed"), [(0, 109.9557), (1, 60.2234)])
def test_stretching_at_rest(alpha, printed):
    """z tan z = 1 / alpha at mu 70."""
    spectrum = Spectrum(Beam(alpha=alpha), "green", "spatial", FINE[0])
    assert np.sqrt(spectrum.stretching(1)[0]) == pytest.approx(printed, abs=5e-5)


@pytest.mark.parametrize(
    ("strain", "energy"),
    [
        ("green", lambda f: (f * f - 1) ** 2 / 8),
        ("biot", lambda f: (f - 1) ** 2 / 2),
        ("hencky", lambda f: np.log(f) ** 2 / 2),
    ],
)
def test_force_and_stiffness_are_derivatives_of_the_energy(strain, energy):
    """n and n' are the first and second derivative of e^2 / 2; central differences keep 1e-5."""
    f, h = np.linspace(1.01, 2.6, 12), 1e-3
    low, middle, high = energy(f - h), energy(f), energy(f + h)
    assert stretch(strain, (high - low) / (2 * h)) == pytest.approx(f, rel=1e-5)
    assert STIFFNESS[strain](f) == pytest.approx((high - 2 * middle + low) / h**2, rel=1e-5)


def test_equilibrium_of_a_linear_bar_in_closed_form():
    """Biot, a mass in the middle: X'' = -k^2 (X - ..) on either side, k = gamma / mu."""
    beam = Beam(alpha=2, beta=0.5, gamma=20, delta=1.5, mu=50)
    spectrum = Spectrum(beam, "biot", "spatial", FINE[0])
    k = beam.gamma / beam.mu
    c, s = np.cos(k / 2), np.sin(k / 2)
    # X = delta cos kx + a sin kx inside, b cos k(1 - x) + sin k(1 - x) / -k outside: f(1) = 1
    step = np.array([[s, -c], [c * k - beam.alpha * k**2 * s, -k * s]])
    right = np.array(
        [-beam.delta * c - s / k, beam.alpha * k**2 * beam.delta * c + beam.delta * k * s + c]
    )
    a, b = np.linalg.solve(step, right)
    x = spectrum.mesh.x
    inner = -beam.delta * k * np.sin(k * x) + a * k * np.cos(k * x)
    outer = b * k * np.sin(k * (1 - x)) + np.cos(k * (1 - x))
    assert spectrum.f == pytest.approx(np.where(x < 0.5, inner, outer), rel=ROUNDING)


def test_spinning_cable():
    """omega_k -> gamma sqrt(k (2k - 1)) flapwise as bending stiffness vanishes like 1 / gamma."""
    ratios = [
        truth(Beam(gamma=g, mu=RIGID), 4, plane="flapwise").frequencies / g for g in (50, 100, 200)
    ]
    k = np.arange(1, 5)
    limit = (ratios[0] - 6 * ratios[1] + 8 * ratios[2]) / 3  # the remainder falls with gamma^3
    assert limit == pytest.approx(np.sqrt(k * (2 * k - 1)), rel=1e-2)
    assert limit[0] == pytest.approx(1, abs=1e-5)


@pytest.mark.parametrize(("beam", "values"), INDEPENDENT, ids=str)
def test_independent_values(beam, values):
    """Values computed independently of this project, to seven digits."""
    spectrum = Spectrum(beam, "green", "spatial", FINE[0])
    squares = [*spectrum.bending(4), spectrum.stretching(1)[0]]
    assert np.sqrt(squares) == pytest.approx(values, rel=1e-7)


@pytest.mark.parametrize(("beam", "values"), INDEPENDENT_CORIOLIS, ids=str)
def test_independent_values_with_coriolis(beam, values):
    """Values computed independently of this project, to seven digits."""
    found = truth(beam, len(values), coriolis=True).frequencies
    assert found == pytest.approx(values, rel=1e-7)


@pytest.mark.parametrize("row", CROSSINGS, ids=str)
def test_crossings_of_the_loci(row):
    """A bending and a stretching locus cross within a unit of the last digit given."""
    over, beam, bending, curvature, at, digit = row
    gaps = []
    for end in (at - digit, at + digit):
        spectrum = Spectrum(beam.replace(**{over: end}), "green", curvature, FINE[0])
        gaps.append(spectrum.bending(bending)[-1] - spectrum.stretching(1)[0])
    assert gaps[0] * gaps[1] < 0


@pytest.mark.parametrize(("strain", "delta", "limit", "digit"), LIMITS)
def test_no_equilibrium_beyond_the_limit(strain, delta, limit, digit):
    """Biot ends where its linear bar is in resonance, hencky at a fold or at f = e."""
    margin = max(digit, 1e-4)  # nearer, the tip is too far away for the march
    shoot(Beam(gamma=limit - margin, delta=delta), strain)
    with pytest.raises(NoStateError):
        shoot(Beam(gamma=limit + margin, delta=delta), strain)


def test_moment_balance_agrees_with_the_eigenvalue():
    """Where Lambda - gamma^2 loses no digits, the moments about the axis give the same omega."""
    beam = Beam(alpha=1, beta=0.6, gamma=20, delta=2)
    spectrum = Spectrum(beam, "green", "spatial", FINE[0])
    squares, Y = spectrum._family(spectrum._bending(), 1 / spectrum.force[1], 3, beam.gamma**2)
    balanced = [spectrum._balance(y) for y in Y.T]
    assert balanced == pytest.approx(squares, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("curvature", CURVATURE)
def test_a_march_from_the_tip_finds_the_same_frequencies(curvature):
    """Two motions free at the tip, marched to the clamp: some mixture of them has w = theta = 0.

    A Runge-Kutta method that shares the equations with the oracle, but neither its points nor its
    eigenvalue solver. It keeps nine digits.
    """
    beam = Beam(alpha=1, beta=0.3, gamma=30, delta=1)
    spectrum = Spectrum(beam, "green", curvature, FINE[0])
    tip = beam.delta + np.sum(spectrum.mesh.lengths / 2 * (spectrum.f @ spectrum.mesh.Q[-1]))
    for omega in np.sqrt(spectrum.bending(4)):
        ends = [clamp_determinant(beam, curvature, tip, omega * (1 + e)) for e in (-1e-9, 1e-9)]
        assert ends[0] * ends[1] < 0


def clamp_determinant(beam, curvature, tip, omega):
    """Determinant of (w, theta) at the clamp of the two motions free at the tip."""
    c, spin = CURVATURE[curvature], beam.gamma**2
    Lambda = omega**2 + spin
    unit = np.sqrt(spin)  # of m, its square of V: all unknowns of one size

    def slope(_, y):
        (X, N), (w, theta, V, m) = y[:2], y[2:].reshape(4, 2)
        f = stretch("green", N / beam.mu**2)
        shear = f * (N * theta / unit - V * unit)
        rates = f * theta, f ** (2 * c) * m * unit, -Lambda / spin * w, shear
        return np.concatenate([[f, -spin * X], np.ravel(rates)])

    y = np.zeros((5, 2))
    y[0] = tip, 0.0
    y[1:3] = np.eye(2)
    stations = np.concatenate([np.linspace(1, beam.beta, 15), np.linspace(beam.beta, 0, 7)[1:]])
    for right, left in pairwise(stations):
        if right == beam.beta:
            y[0, 1] += beam.alpha * spin * y[0, 0]
            y[3] += beam.alpha * Lambda / spin * y[1]
        run = solve_ivp(slope, (right, left), y.ravel(), "DOP853", rtol=1e-12, atol=1e-14)
        y = run.y[:, -1].reshape(5, 2)
        Q, R = np.linalg.qr(y[1:])  # the two motions kept apart, their orientation too
        y[1:] = Q * np.sign(np.diag(R))
    return np.linalg.det(y[1:3])


EXTREMES = [
    Beam(alpha=100, beta=1, gamma=200, delta=20, mu=40),
    Beam(alpha=100, beta=0.5, gamma=200, delta=20, mu=40),
    Beam(alpha=0, beta=1, gamma=200, delta=20, mu=40),
    Beam(alpha=0, beta=1, gamma=50, delta=20, mu=10),
    Beam(alpha=33, beta=0.57, gamma=124, delta=0, mu=25),
    Beam(alpha=100, beta=0.999, gamma=200, delta=0, mu=40),
    Beam(alpha=1, beta=0.001, gamma=200, delta=20, mu=10000),
]


@pytest.mark.slow
@pytest.mark.parametrize("curvature", CURVATURE)
@pytest.mark.parametrize("beam", EXTREMES, ids=str)
def test_extremes_are_resolved(beam, curvature):
    """Stretch up to 50, layers down to 1e-7, omega a thousandth of gamma: still 1e-9."""
    found = truth(beam, curvature=curvature)
    assert np.all(found.differences <= 1e-9 * found.frequencies)


def test_too_coarse_a_resolution_is_refused():
    """Two resolutions that disagree raise, they return nothing."""
    coarse = Resolution(4, 4.0, 20.0), Resolution(5, 4.0, 20.0)
    with pytest.raises(UnresolvedError):
        truth(Beam(alpha=1, beta=0.3, gamma=50, delta=1), resolutions=coarse)


@pytest.mark.parametrize(("gamma", "mu"), [(2.9939, 10000), (2.9960, 70)])
def test_an_inward_beam_buckles(gamma, mu):
    """A rigid column under its own centrifugal load (delta -1): a zero of the determinant of the
    clamp; the shortening at mu 70 makes it later."""
    before, after = (truth(Beam(gamma=gamma + off, delta=-1, mu=mu), 2) for off in (-1e-4, 1e-4))
    assert before.squares[0] > 0 > after.squares[0]


@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize("beam", [Beam(0.7, 0.4, 2, -0.6, 40), Beam(0.7, 0.4, 9, -0.6, 40)])
def test_an_inward_beam_turns_into_an_outward_one(beam, coriolis):
    """All eigenvalues at once and the Arnoldi process for positive ones meet at delta = 0-."""
    inward, outward = (truth(beam.replace(delta=d), coriolis=coriolis) for d in (-1e-9, 0.0))
    assert inward.squares == pytest.approx(outward.squares, rel=1e-7)
