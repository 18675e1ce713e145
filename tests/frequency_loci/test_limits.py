"""Limits of sweeps: of equilibrium, of stability and of convergence; and events of the equilibrium:
buckling, limit points, second stable states."""

import json
import pickle
import re
from collections.abc import Callable

import numpy as np
import pytest
from helpers import KNOWN_KINDS, slow, sorted_frequencies
from matplotlib.figure import Figure
from oracle.bent import bent_truth
from scipy.optimize import brentq

from beamviz import Beam, NoEquilibrium, NotConverged, loci, solve, solve_many
from beamviz.frequency_loci import Loci, path
from beamviz.frequency_loci.tracking import INTERVALS
from beamviz.solver.bent import end_of_bent_state, other_stable_states

TIP = Beam(alpha=1, beta=1)
INWARD = Beam(delta=-1)
SHORT = Beam(delta=-0.5, mu=10, gamma=4.45)  # it has a bent state up to gamma = 4.508896
FOLDING = Beam(4.656, 1, 5.341, -0.09663, 194.4)
SOFT = {"strain": "biot", "curvature": "material"}
GAUSS = np.polynomial.legendre.leggauss(40)


@pytest.fixture
def unsolvable(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """From here on no solution converges at speeds `where`."""
    solve_many = path.solve_many

    def fail(where: Callable[[float], bool]) -> None:
        def failing(beams, **options):
            answers = solve_many(beams, **options)
            pairs = zip(beams, answers, strict=True)
            return [NotConverged("no") if where(beam.gamma) else answer for beam, answer in pairs]

        monkeypatch.setattr(path, "solve_many", failing)

    return fail


def test_beyond_the_limit_of_equilibrium():
    """Hencky strain, delta 0: it is gamma 45.420, and all values below it are solved."""
    found = loci(Beam(), "gamma", np.linspace(0, 60, 21), strain="hencky")
    (limit,) = found.limits
    assert (limit.kind, limit.stop) == ("no-equilibrium", 60)
    assert limit.start == pytest.approx(45.420, abs=5e-4)
    assert limit.message == "no equilibrium for gamma = 45.4203 .. 60"
    exists = np.isfinite(sorted_frequencies(found)[:, :5]).all(axis=1)
    assert exists.tolist() == [value < limit.start for value in found.values]
    assert all(branch.family[-1] is None for branch in found.branches)


@pytest.mark.parametrize(
    ("beam", "over", "values"),
    [
        (Beam(gamma=40, beta=0.9), "alpha", np.linspace(0, 1, 11)),
        *slow((Beam(gamma=40), "mu", np.linspace(40, 80, 11))),
    ],
)
def test_limits_over_other_numbers(beam, over, values):
    """The limit is located between two values: an equilibrium exists on one side of it only, at
    each value there."""
    found = loci(beam, over, values, 1, strain="hencky")
    (limit,) = found.limits
    solved = np.isfinite(sorted_frequencies(found)[:, 0])
    assert solved.tolist() == [not limit.start <= value <= limit.stop for value in values]
    edge = limit.stop if limit.start == values[0] else limit.start
    sides = [beam.replace(**{over: edge * (1 + step)}) for step in (-1e-6, 1e-6)]
    outcomes = solve_many(sides, strain="hencky")  # so near to the limit a solve may fail
    beyond = [
        isinstance(o, NoEquilibrium) and o.limit <= side.gamma
        for o, side in zip(outcomes, sides, strict=True)
    ]
    assert sorted(beyond) == [False, True]


def test_the_end_of_a_force_law_over_the_hub_radius():
    """Hencky's ends at the clamp at f = e. Phi(f) = ln f - (ln f)^2 / 2 falls by g (R^2 -
    delta^2) / 2, R = r + delta, g = (gamma / mu)^2, to 0 at the tip; with s^2 = g (R^2 - delta^2)
    the length is 1 = int_0^1 exp(s - 1) s ds / (g sqrt(delta^2 + s^2 / g))."""
    g = (30 / 70) ** 2

    def excess(delta: float) -> float:
        s = (1 + GAUSS[0]) / 2
        return GAUSS[1] / 2 @ (np.exp(s - 1) * s / np.sqrt(delta**2 + s**2 / g)) / g - 1

    (limit,) = loci(Beam(gamma=30), "delta", [0, 2], 1, strain="hencky").limits
    assert limit.start == pytest.approx(brentq(excess, 1, 2, xtol=1e-14), rel=3e-9)


def test_the_end_of_a_compressed_equilibrium_is_that_of_physics():
    """Just before the limit of a compressed beam convergence is slow: at the limit over the hub
    radius gamma is the limit of the speed that a faster beam reports."""
    beam = Beam(alpha=0.0127587733, beta=0.9629133184, gamma=82.3011768324, mu=145.3672840086)
    limit, _ = loci(beam, "delta", np.linspace(-2, 20, 21), 2).limits
    with pytest.raises(NoEquilibrium) as caught:
        solve(beam.replace(delta=limit.stop, gamma=100.0))
    assert caught.value.limit == pytest.approx(beam.gamma, rel=1e-8)


@pytest.mark.slow
def test_a_limit_just_above_a_value_of_the_grid():
    """With a linear force, biot, a beam without a mass ends at gamma / mu = pi / 2. Within 1e-5 of
    it no solve succeeds; it is the limit that is named all the same, not the last value."""
    mu = 50.0
    critical = mu * np.pi / 2
    near = INTERVALS * 5 // 8  # the number of a value of the grid: that close to the limit
    stop = INTERVALS * critical * (1 - 3e-6) / near
    (limit,) = loci(Beam(delta=1, mu=mu), "gamma", np.linspace(0, stop, 5), 1, strain="biot").limits
    assert limit.kind == "no-equilibrium"
    assert limit.start == pytest.approx(critical, rel=1e-8)


@pytest.mark.slow
def test_a_limit_at_zero():
    """With a heavy mass there is an equilibrium at beta = 0 only, where the mass is held: precision
    relative to the limit cannot be reached."""
    heavy = Beam(alpha=3.9, gamma=37, delta=2.7, mu=115)
    (limit,) = loci(heavy, "beta", np.linspace(0, 1, 5), 1, strain="hencky").limits
    assert (limit.kind, limit.stop) == ("no-equilibrium", 1.0)
    assert 0 <= limit.start < 1e-11


@pytest.mark.parametrize("coriolis", [False, True])
def test_loss_of_stability(coriolis):
    """An inward beam, delta -1, buckles at gamma 2.996; B1 continues with a growth rate, omega^2
    passes through zero without a jump."""
    found = loci(INWARD, "gamma", np.linspace(0, 6, 31), coriolis=coriolis)
    (limit,) = found.limits
    assert (limit.kind, limit.stop) == ("unstable", 6)
    assert limit.start == pytest.approx(2.996, abs=1e-3)
    below, above = (solve(INWARD.replace(gamma=limit.start * x)) for x in (1 - 1e-7, 1 + 1e-7))
    assert (below.equilibrium.status, above.equilibrium.status) == ("stable", "unstable")
    first = found["B1"]
    assert abs(np.diff(first.omega_squared, 2)).max() < 4
    assert len(found.branches) == 5
    unstable = found.values > limit.start
    assert np.isnan(first.frequency[unstable]).all()
    assert (first.growth_rate[unstable] > 0).all()
    assert (first.growth_rate[~unstable] == 0).all()
    assert first.family[-1] == "bending"


def test_a_mode_at_the_onset_of_instability_may_have_no_frequency_at_all():
    """The onset is solved until omega^2 is 0 to the last digit, without a warning."""
    beam = Beam(gamma=3.59743089612066, mu=22.860510460066713)
    found = loci(beam, "delta", [-1, 3], 9, coriolis=True, strain="hencky")
    assert found.limits[0].stop == pytest.approx(-0.73235600579, abs=1e-9)


@pytest.mark.slow
def test_a_state_between_two_others_is_named():
    """Stable at rest, not resolved at gamma 50: in between the beam buckles, and is solved."""
    found = loci(Beam(alpha=100, beta=0.2, delta=-2, mu=10000), "gamma", [0, 50, 100], 1)
    unstable, unresolved = found.limits
    assert [unstable.kind, unresolved.kind] == ["unstable", "not-converged"]
    assert unstable.start == pytest.approx(0.55, abs=1e-3)
    assert 20 < unstable.stop == unresolved.start < 30
    assert unresolved.stop == 100


def test_a_gap_in_the_middle(unsolvable):
    """Branches continue after values that did not converge; the limit names these, with less
    precision than a limit of equilibrium."""
    unsolvable(lambda gamma: 4.9 < gamma < 7.1)
    found = loci(TIP, "gamma", np.linspace(0, 10, 21))
    assert [branch.label for branch in found.branches] == ["B1", "B2", "B3", "S1", "B4"]
    (limit,) = found.limits
    assert limit.kind == "not-converged"
    assert (limit.start, limit.stop) == pytest.approx((4.9, 7.1), abs=1e-4)
    assert [event.branches for event in found.events] == [("B3", "S1")]


@pytest.mark.parametrize(
    ("kind", "options", "named"),
    [
        ("crossing", {}, "crossing"),
        ("veering", {"coriolis": True}, "least gap"),
        ("resonance", {"per_rev": 1}, "resonance"),
    ],
)
def test_an_event_that_cannot_be_located_is_reported(unsolvable, kind, options, named):
    """Solves fail around it, between two values of the chart's grid, so that nothing else tells
    that it is there."""
    values, step = [1, 6], 5 / INTERVALS
    (at,) = [each.at for each in loci(TIP, "gamma", values, **options).events if each.kind == kind]
    unsolvable(lambda gamma: abs(gamma - at) < 1e-3)
    found = loci(TIP, "gamma", values, **options)
    assert not [event for event in found.events if event.kind == kind]
    (limit,) = found.limits
    assert limit.kind == "not-located"
    assert limit.message.startswith(f"{named} not located")
    assert at - 2 * step < limit.start < at < limit.stop < at + 2 * step


def test_one_value_between_gaps(unsolvable):
    """A single value with a solution is still returned."""
    unsolvable(lambda gamma: abs(gamma - 5) >= 0.1)
    found = loci(TIP, "gamma", np.linspace(0, 10, 11))
    assert np.isfinite(sorted_frequencies(found)).sum() == 5
    assert len(found.limits) == 2


def test_nowhere_an_equilibrium():
    """The error of the first value, with the limit."""
    with pytest.raises(NoEquilibrium) as caught:
        loci(Beam(), "gamma", [100, 110], strain="hencky")
    assert caught.value.limit == pytest.approx(45.42, abs=0.01)


@pytest.mark.parametrize(
    ("beam", "over", "values", "at", "coriolis"),
    [
        (INWARD, "gamma", np.linspace(2, 5, 7), 2.9960, True),
        *slow(
            (Beam(gamma=4), "delta", np.linspace(-1.5, 0.5, 16), None, False),
            (INWARD.replace(gamma=2.5), "alpha", np.linspace(0, 2, 16), None, True),
        ),
    ],
)
def test_the_beam_buckles_in_a_sweep(beam, over, values, at, coriolis):
    """B1 falls to zero and rises again as one branch; the straight beam's lowest omega^2 changes
    its sign within 1e-6 of the event. Branches are labelled as those of the straight beam."""
    found = loci(beam, over, values, modes=2, state="stable", coriolis=coriolis)
    assert [branch.label for branch in found.branches] == ["B1", "B2"]
    (event,) = [event for event in found.events if event.kind == "buckling"]
    assert event.branches == ("B1", "B1")
    assert event.frequency == 0
    if at:
        assert event.at == pytest.approx(at, abs=1e-4)
    ends = [beam.replace(**{over: event.at + step}) for step in (-1e-6, 1e-6)]
    signs = [np.sign(solve(end, modes=1, tolerance=1e-9).omega_squared[0]) for end in ends]
    assert set(signs) == {-1, 1}
    branch = found["B1"].frequency
    assert np.isfinite(branch).all()
    before, after = branch[values < event.at], branch[values > event.at]
    assert (before[-1], after[0]) == (before.min(), after.min())


@pytest.mark.parametrize("values", [np.linspace(2.9, 3.1, 5), *slow(np.linspace(0, 20, 3))])
def test_a_kink_of_a_gap_is_no_crossing(values):
    """Where the beam buckles the gap between S1 and B4 is least, 10, and grows suddenly; nor is it
    an event that could not be located."""
    found = loci(INWARD, "gamma", values, state="stable", kinds=KNOWN_KINDS)
    assert [event.kind for event in found.events] == ["buckling"]
    assert found.limits == ()
    assert len(found.branches) == 5
    assert (found["S1"].frequency < found["B4"].frequency).all()


PRECISE = {"modes": 2, "state": "stable", "tolerance": 1e-9, **SOFT}


@pytest.fixture(scope="module")
def folding() -> Loci:
    """Over the spin-up: a bent beam that is accelerated snaps through."""
    return loci(FOLDING, "spin_up", np.linspace(0, 0.3, 7), **PRECISE)


def test_a_limit_point_of_the_spin_up(folding):
    """To the other side, where the lowest omega^2 vanishes, as the root of the distance."""
    (event,) = [event for event in folding.events if event.kind == "limit point"]
    near = loci(FOLDING, "spin_up", [0.0, event.at - 4e-5, event.at - 1e-5], **PRECISE)
    squares = near["B1"].omega_squared
    assert squares[1] / squares[2] == pytest.approx(2, rel=0.02)
    tips = [solution.equilibrium.tip[1] for solution in folding["B1"].solutions]
    assert [tip > 0 for tip in tips] == [value < event.at for value in folding.values]


def test_loci_are_interrupted_at_a_limit_point(folding):
    """Beyond it they are those of another state. The lowest one falls to zero before it."""
    (event,) = [event for event in folding.events if event.kind == "limit point"]
    axes = folding.plot(Figure().subplots())
    points = np.concatenate([line.get_xydata() for line in axes.lines if len(line.get_xdata()) > 1])
    heights = points[points[:, 0] == event.at, 1]
    assert np.isnan(heights).sum() >= len(folding.branches)
    assert {*heights[np.isfinite(heights)].tolist()} == {0}


@pytest.mark.slow
def test_a_limit_point_of_the_bent_state():
    """A short beam of logarithmic strain has no bent state beyond it: by the differential
    equations, omega_1^4 falls linearly to zero there, to 1e-6."""
    given = {"strain": "hencky", "curvature": "spatial", "coriolis": False, "modes": 2}
    found = loci(SHORT, "gamma", np.linspace(4.45, 4.6, 4), state="stable", **given)
    beyond = next(limit for limit in found.limits if limit.kind == "no-equilibrium")
    # Beyond the limit some values have "not converged" for an answer.
    assert {limit.kind for limit in found.limits} <= {"no-equilibrium", "not-converged"}
    ends = [event for event in found.events if event.kind == "limit point"]
    event = min(ends, key=lambda end: min(abs(end.at - beyond.start), abs(end.at - beyond.stop)))
    inside = np.sign(SHORT.gamma - event.at)
    distances, squares = np.array([1e-5, 2e-5]), []
    for distance in distances:
        beam = SHORT.replace(gamma=event.at + inside * distance)
        state = solve(beam, state="bent", **given).equilibrium
        truth = bent_truth(
            *(beam, *given.values()), lambda x, s=state: (s.position(x), s.angle(x), s.stretch(x))
        )
        squares.append(truth.omega[0].real ** 4)
    zero = np.roots(np.polyfit(distances, squares, 1))
    assert zero == pytest.approx(0, abs=1e-6)


@pytest.mark.slow
def test_a_bent_state_that_ends_with_its_strain_law():
    """The limit is where solve() finds no state, though no mesh resolves the state near it."""
    beam, given = Beam(delta=-1.93, gamma=10), {"modes": 1, "state": "stable", "strain": "hencky"}
    end = end_of_bent_state(solve(beam, tolerance=1e-3, **given), "gamma", 200)
    with pytest.raises(NoEquilibrium) as error:
        solve(beam.replace(gamma=12.5), **given)
    assert end == pytest.approx(error.value.limit, rel=5e-3)


def test_the_command_line_names_the_event(run, tmp_path):
    """In the table, in JSON and in the chart."""
    arguments = ("loci", "--over", "gamma", "--start", "2", "--stop", "4", "--points", "9")
    arguments += ("--delta=-1", "--state", "stable", "--modes", "2")
    chart = tmp_path / "chart.svg"
    code, out, err = run(*arguments, "--plot", chart)
    assert code == 0, err
    assert re.search(r"buckling +B1 B1 +2\.996039", out)
    assert "buckling" in chart.read_text()
    (event,) = json.loads(run(*arguments, "--format", "json")[1])["events"]
    assert event["kind"] == "buckling"
    assert event["at"] == pytest.approx(2.99604, abs=1e-5)


def test_a_second_stable_state(folding):
    """A bent beam with a small spin-up has two: one bent by the Euler force and one against it,
    which ends where the beam snaps through. With a larger spin-up, or unbent, it has one."""
    along = solve(FOLDING.replace(spin_up=0.05), **PRECISE)
    (other,) = other_stable_states(along)
    assert other.equilibrium.stable
    assert other.stats.seconds > 0
    assert other.equilibrium.tip[1] > 0 > along.equilibrium.tip[1]
    end = end_of_bent_state(other, "spin_up", 0.3)
    assert end_of_bent_state(along, "spin_up", 0.3) is None
    events = {event.kind: event for event in folding.events}
    assert events["limit point"].at == pytest.approx(end, abs=1e-7)
    assert events["second state"].branches == ("B1", "B1 (state 2)")
    assert pickle.loads(pickle.dumps(folding.events)) == folding.events
    assert other_stable_states(solve(FOLDING.replace(spin_up=0.2), **PRECISE)) == []
    assert other_stable_states(solve(Beam(delta=-1, gamma=4), state="stable")) == []
