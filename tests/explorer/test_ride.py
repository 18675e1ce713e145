"""The run-up in the page: the speed rises, the picture is the forced response."""

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from live.visitor import PAPER, frequency_text, visitor

from beamviz.beam import Beam, Units
from beamviz.display_units import measure
from beamviz.drawing.modes import Shapes
from beamviz.explorer.app import explorer
from beamviz.explorer.features import run_up as ride_tab
from beamviz.explorer.features.run_up import LARGEST, PER_SECOND, Ride, Run
from beamviz.explorer.state import Case
from beamviz.frequency_loci.forced_response import RunUp, response
from beamviz.scene import Scene
from beamviz.solver import solve


def ridden(beam: Beam = PAPER, per_rev: int = 2, **options: bool) -> Ride:
    """A ride that is about to begin."""
    with ThreadPoolExecutor(1) as pool:
        ride = Ride(pool, lambda: None)
        ride.choose(per_rev)
        ride.start(Case.of(beam, options))
    return ride


def run_of(ride: Ride) -> RunUp:
    """Its run."""
    assert ride.run
    return ride.run


def test_the_speed_rises_through_all_speeds_of_the_run_and_the_ride_ends():
    """So many of them in a second; from rest to the last, never back."""
    ride = ridden()
    run = run_of(ride)
    assert ride.riding
    gammas = []
    while ride.riding:
        gammas.append(ride.advance(0.1))
    assert len(gammas) == math.ceil((len(run.speeds) - 1) / (0.1 * PER_SECOND))
    assert (np.diff(gammas) > 0).all()
    assert gammas[-1] == run.speeds[-1]
    assert ride.advance(0.1) is None


def test_the_picture_stays_a_response_when_the_ride_is_over():
    """From the first solution that is taken up until a mode is chosen, not before: a run may come
    at any moment."""
    ride = ridden()
    assert ride.riding
    assert not ride.driven
    ride.drive(solve(PAPER), Shapes.sampled(solve(PAPER)), 0.15)
    assert ride.driven
    ride.stop()
    assert ride.driven
    ride.shown = False
    assert not ride.driven


def test_it_is_slow_near_a_resonance():
    """A tenth of a second there moves the speed far less than elsewhere."""
    ride = ridden()
    (first, _) = run_of(ride).resonances
    steps = []
    at = 0.0
    while ride.riding:
        gamma = ride.advance(0.1)
        assert gamma is not None
        steps.append((abs(gamma - first.at) < 0.01 * first.at, gamma - at))
        at = gamma
    near = [step for close, step in steps if close]
    assert len(near) >= 5
    assert max(near) < 0.2 * max(step for _, step in steps)


def test_the_ride_ends_where_the_beam_becomes_unstable():
    """An inward beam buckles near gamma 3: the last speed is a stable one."""
    ride = ridden(Beam(delta=-1, gamma=1))
    last = 0.0
    while ride.riding:
        last = ride.advance(1.0) or last
    assert 2.7 < last < 3.0
    assert solve(Beam(delta=-1, gamma=last)).equilibrium.status == "stable"


def test_the_picture_is_the_response_in_another_size():
    """Every point keeps its phase and its share; the highest peak is drawn at twice the amplitude
    set, one of a quarter of it at half that."""
    ride = ridden(coriolis=True)
    run = run_of(ride)
    top = run.speeds[np.nanargmax(run.amplitudes)]
    for gamma in (top, 1.0, 6.0):
        solution = solve(PAPER.replace(gamma=gamma), coriolis=True)
        shapes = Shapes.sampled(solution)
        ride.drive(solution, shapes, 0.15)
        field = response(solution, 2 * gamma, run.damping, shapes.x)
        size = np.abs(ride.field).max() / np.abs(field).max()
        assert np.allclose(ride.field, size * field, atol=1e-12)
        share = np.abs(field).max() / np.nanmax(run.amplitudes)
        assert np.abs(ride.field).max() == pytest.approx(
            LARGEST * 0.15 * math.sqrt(min(share, 1)), rel=1e-6
        )
        ride.phase = 0.0
        quarter = math.pi / 2 / (2 * gamma)
        assert np.allclose(ride.displaced(quarter, gamma), -ride.field.imag, atol=1e-9)


def test_another_force_or_damping_ends_the_ride():
    """Its run does not hold any more; nonsense changes nothing."""
    ride = ridden()
    ride.choose(99)
    ride.damp("much")
    ride.damp(math.nan)
    assert ride.riding
    ride.damp(0.05)
    assert (ride.damping, ride.riding, ride.run) == (0.05, False, None)
    ride.damp(9.0)
    assert ride.damping == 0.2


def test_the_chart_shows_run_resonances_and_beam():
    """Amplitudes over the speeds, in rpm for a real beam; a ring on each peak, a dot at gamma."""
    run = run_of(ridden())
    for units in (None, Units(1.0, 0.1)):
        along = measure("gamma", units)
        x, amplitudes, peaks, mark = ride_tab.series(run, along, 4.321)
        assert (np.diff(x) >= 0).all()
        assert len(x) == len(run.speeds) + 1
        at = x[np.isfinite(peaks)] / along.factor
        assert at == pytest.approx([one.at for one in run.resonances])
        assert peaks[np.isfinite(peaks)] == pytest.approx([run.peak(r) for r in run.resonances])
        (k,) = np.flatnonzero(np.isfinite(mark))
        assert x[k] == pytest.approx(along.factor * 4.321)
        assert mark[k] == amplitudes[k]
    assert not np.isfinite(ride_tab.series(run, along, 99.0)[3]).any()
    table = ride_tab.met(run, measure("gamma", None))
    for one in run.resonances:
        assert f"{one.at:.4f}" in table
        assert f"{run.peak(one):.3g} ×" in table


def test_what_cannot_be_run_is_said():
    """The reason stands in place of the chart."""
    ride = ridden(Beam(mu=10, gamma=1))
    assert ride.found
    assert ride_tab.words(Run(ride.found.ask, words="no equilibrium")).count("no equilibrium") == 1
    assert "steady linear response" in ride_tab.words(None)
    assert "same ratio" in ride_tab.words(None)


def test_a_ride_in_the_page(url):
    """It starts from rest and rises; stopped, it stays; a dragged speed keeps the run, another
    mass ends it."""
    with visitor(url) as guest:
        guest.choose("force comes", "2 × per turn")
        guest.choose("Run up from rest", True)
        guest.says('aria-label="run-up"')
        guest.wait(lambda _: 0 < guest.values.get("speed γ", 10.0) < 1)
        guest.wait(lambda _: 0.3 < guest.values["speed γ"] < 5)
        guest.choose("Stop", True)
        guest.wait(lambda _: "Run up from rest" in guest.controls)
        guest.choose("speed γ", 4.0)
        guest.says(frequency_text(PAPER.replace(gamma=4)))
        assert 'aria-label="run-up"' in guest.text
        guest.choose("mass α", 2.0)
        guest.wait(lambda _: 'aria-label="run-up"' not in guest.text)
        guest.choose("damping ζ [%]", "nonsense")
        guest.choose("force comes", "7 × per turn")
        guest.choose("speed γ", 5.0)
        guest.says(frequency_text(PAPER.replace(gamma=5, alpha=2)))


def test_a_run_can_begin_at_an_unstable_beam():
    """Its speed is left at once: the picture is grey until the first speed that holds."""
    scene = Scene(Beam(delta=-1, gamma=10))
    with explorer(scene) as url, visitor(url, first="Unstable") as guest:
        guest.choose("Run up from rest", True)
        guest.wait(lambda _: "Stop" in guest.controls)
        guest.says("Stable equilibrium")
        guest.wait(lambda _: guest.nodes["/stage/wheel/words"].get("visible") is False)
