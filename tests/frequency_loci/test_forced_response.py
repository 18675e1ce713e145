"""Resonances: all intersections of loci with per-rev lines, for any speeds of the sweep. The forced
response: against oscillators, and the solution of the differential equations."""

import numpy as np
import pytest
from helpers import slow
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle import FINE, Spectrum
from strategies import beams

from beamviz import Beam, InvalidInput, loci, resonances, solve
from beamviz.frequency_loci.forced_response import (
    quadrature,
    response,
    run_up,
    static_deflection,
)

HEAVY = Beam(alpha=1, beta=1)
TIP = np.ones(1)


def located(found, per_rev, label):
    """The speeds of the resonances of one branch with one line, of four."""
    return [
        one.at for one in resonances(found, 4) if (one.per_rev, one.branches) == (per_rev, (label,))
    ]


def test_resonances():
    """Each lies on a locus and on a line of a multiple of the speed."""
    found = resonances(loci(HEAVY, "gamma", np.linspace(0, 30, 16), coriolis=True), 4)
    assert [(one.per_rev, *one.branches) for one in found][:4] == [(k, "B1") for k in (4, 3, 2, 1)]
    for one in found:
        frequencies = solve(HEAVY.replace(gamma=one.at), coriolis=True, tolerance=1e-9).frequencies
        assert one.frequency == one.per_rev * one.at
        assert abs(frequencies - one.frequency).min() < 1e-6 * one.frequency


@pytest.mark.parametrize("coriolis", [False, True])
def test_no_resonance_is_no_event(coriolis):
    """From gamma 10 to 20 all frequencies are below or above the speed itself: B1 is 3.1 .. 3.9,
    B2 42 .. 78."""
    found = loci(HEAVY, "gamma", [10, 20], per_rev=1, coriolis=coriolis)
    assert [event for event in found.events if event.per_rev] == []
    assert resonances(found) == []


@pytest.mark.parametrize(
    ("delta", "points", "expected"),
    [
        (0.0, 2, [73.591, 85.314]),
        (0.0007236814724, 5, [79.102, 79.238]),
        *slow((0.0, 201, [73.591, 85.314]), (0.0007236814724, 401, [79.102, 79.238])),
        (0.00073, 5, []),
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


@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
def test_the_static_deflection_is_the_unit(plane):
    """The unit of the amplitude, with a mass anywhere: by definition, whatever the beam."""
    for beam in (Beam(), Beam(alpha=2, beta=0.4), Beam(alpha=1, beta=1)):
        still = response(solve(beam, modes=20, plane=plane), 1e-6, 0.01, TIP)[0]
        assert still[1].real == pytest.approx(-1, rel=1e-5)


@settings(max_examples=20)
@given(st.floats(0.001, 0.2), st.floats(0.2, 3.0))
def test_each_mode_answers_as_an_oscillator(damping, ratio):
    """F phi / (omega_k^2 - omega^2 + 2 i zeta omega_k omega), also past its resonance."""
    solution = solve(Beam(alpha=1, gamma=2), modes=3)
    own, omega = solution.frequencies, ratio * solution.frequencies[1]
    x, weight = quadrature(solution.beam)
    force = -weight @ solution.displacement(x)[:, 1]
    oscillators = force / (own**2 - omega**2 + 2j * damping * own * omega)
    expected = solution.displacement(TIP)[0, 1] @ oscillators / static_deflection(solution.beam)
    assert response(solution, omega, damping, TIP)[0, 1] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize("ratio", [0.3, 0.95, 1.2, 4.0])
@pytest.mark.parametrize("beam", [Beam(), Beam(alpha=1, gamma=8, delta=0.2)])
def test_the_sum_of_modes_is_the_solution_of_the_equations(beam, ratio, coriolis):
    """At rest and with a mass at the tip of a rotating beam, below and above the first resonance,
    without damping; along the beam only a few stretching modes are among the twenty."""
    solution, oracle = (
        solve(beam, modes=20, coriolis=coriolis),
        Spectrum(beam, "green", "spatial", FINE[0]),
    )
    omega = ratio * float(solution.frequencies[0])
    expected = oracle.response(omega, coriolis) / static_deflection(beam)
    apart = abs(response(solution, omega, 0.0, oracle.mesh.x.ravel()) - expected)
    assert (apart.max(axis=0) < [0.01, 1e-4] * abs(expected).max(axis=0)).all()


def test_a_run_peaks_at_its_resonances():
    """The tip is farthest where a line meets B1 and B2: half as much damping, twice as far."""
    beam = Beam(alpha=1, beta=0.5)
    run = run_up(beam, 2, 0.02, 20.0)
    assert [one.branches for one in run.resonances] == [("B1",), ("B2",)]
    assert (np.diff(run.speeds) > 0).all()
    for one in run.resonances:
        near = abs(run.speeds - one.at) < 0.05 * one.at
        top = run.speeds[near][np.argmax(run.amplitudes[near])]
        assert top == pytest.approx(one.at, rel=0.02)
        half = run_up(beam, 2, 0.01, 20.0)
        assert half.peak(one) == pytest.approx(2 * run.peak(one), rel=0.1)


def test_an_ellipse_is_measured_at_its_largest():
    """The tip goes round: no moment of it is farther from rest than the amplitude."""
    beam = Beam(alpha=1, beta=0.5)
    run = run_up(beam, 1, 0.02, 12.0, coriolis=True)
    solution = solve(beam.replace(gamma=run.speeds[40]), coriolis=True)
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
        (lambda: run_up(Beam(), 0, 0.02, 5.0), "per_rev = 0"),
        (lambda: run_up(Beam(), 1, 0.5, 5.0), r"damping = 0\.5: must lie in 0\.001 \.\. 0\.2"),
    ],
)
def test_wrong_input(call, message):
    """Per-rev lines need the speed; ranges and mistyped keywords are named."""
    with pytest.raises(InvalidInput, match=message):
        call()


@settings(max_examples=10)
@given(beams(alpha=(0, 2), gamma=(0, 20), delta=(0, 0), mu=(70, 70)), st.booleans())
def test_five_modes_are_enough(beam, coriolis):
    """Five modes are enough for the picture: 2 % of the deflection with all twenty."""
    solutions = (solve(beam, modes=modes, coriolis=coriolis) for modes in (5, 20))
    few, many = (response(one, beam.gamma, 0.05, TIP)[0, 1] for one in solutions)
    assert abs(few - many) < 0.02 * max(abs(many), 1)
