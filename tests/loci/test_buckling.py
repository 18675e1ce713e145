"""Events of the equilibrium along a sweep: buckling, limit points, second stable states."""

import json
import re

import numpy as np
import pytest
from oracle.bent import bent_truth

from beamviz import Beam, NoEquilibrium, loci, solve
from beamviz.solver import end_of_bent_state, other_stable_states

INWARD = Beam(delta=-1)


@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize(
    ("beam", "over", "values", "at"),
    [
        (INWARD, "gamma", np.linspace(2, 5, 16), 2.9960),
        (Beam(gamma=4), "delta", np.linspace(-1.5, 0.5, 16), None),
        (INWARD.replace(gamma=2.5), "alpha", np.linspace(0, 2, 16), None),
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
    before = values < event.at
    assert branch[before][-1] < branch[before][0] or branch[~before][0] < branch[~before][-1]
    assert {branch[before].min(), branch[~before].min()} <= {*branch[before][[0, -1]]} | {
        *branch[~before][[0, -1]]
    }


FOLDING = Beam(4.656, 1, 5.341, -0.09663, 194.4)
SOFT = {"strain": "biot", "curvature": "material"}


def test_a_limit_point_of_the_spin_up():
    """A bent beam that is accelerated snaps through to the other side where the lowest omega^2
    vanishes, as the root of the distance."""
    options = {"modes": 2, "state": "stable", "tolerance": 1e-9, **SOFT}
    found = loci(FOLDING, "spin_up", np.linspace(0, 0.3, 13), **options)
    (event,) = [event for event in found.events if event.kind == "limit point"]
    near = loci(FOLDING, "spin_up", [0.0, event.at - 4e-5, event.at - 1e-5], **options)
    squares = near["B1"].omega_squared
    assert squares[1] / squares[2] == pytest.approx(2, rel=0.02)
    tips = [solution.equilibrium.tip[1] for solution in found["B1"].solutions]
    assert [tip > 0 for tip in tips] == [value < event.at for value in found.values]


SHORT = Beam(delta=-0.5, mu=10, gamma=4.45)  # it has a bent state up to gamma = 4.508896


@pytest.mark.slow
@pytest.mark.parametrize(
    ("over", "values"),
    [
        ("gamma", np.linspace(4.45, 4.6, 6)),
        ("delta", np.linspace(-0.6, -0.45, 6)),
        ("alpha", np.linspace(0, 0.02, 5)),
        ("spin_up", np.linspace(0, 0.6, 4)),
    ],
)
def test_a_limit_point_of_the_bent_state(over, values):
    """A short beam of logarithmic strain has no bent state beyond it: by the differential
    equations, omega_1^4 falls linearly to zero there, to 1e-6."""
    given = {"strain": "hencky", "curvature": "spatial", "coriolis": False, "modes": 2}
    found = loci(SHORT, over, values, state="stable", **given)
    (event,) = [event for event in found.events if event.kind == "limit point"]
    assert [limit.kind for limit in found.limits] == ["no-equilibrium"]
    inside = np.sign(getattr(SHORT, over) - event.at)
    distances, squares = np.array([1e-5, 2e-5]), []
    for distance in distances:
        beam = SHORT.replace(**{over: event.at + inside * distance})
        state = solve(beam, state="bent", **given).equilibrium
        truth = bent_truth(
            *(beam, *given.values()),
            lambda x, s=state: (s.position(x), s.angle(x), s.stretch(x)),
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


def test_a_second_stable_state():
    """A bent beam with a small spin-up has two: one bent by the Euler force and one against it,
    which ends where the beam snaps through. With a larger spin-up, or unbent, it has one."""
    against, given = FOLDING.replace(spin_up=0.05), {"modes": 2, "state": "stable", **SOFT}
    along = solve(against, **given)
    (other,) = other_stable_states(along)
    assert other.equilibrium.stable
    assert other.equilibrium.tip[1] > 0 > along.equilibrium.tip[1]
    end = end_of_bent_state(other, "spin_up", 0.3)
    assert end_of_bent_state(along, "spin_up", 0.3) is None
    found = loci(FOLDING, "spin_up", np.linspace(0, 0.3, 13), **given)
    events = {event.kind: event for event in found.events}
    assert events["limit point"].at == pytest.approx(end, abs=1e-7)
    assert events["second state"].branches == ("B1", "B1 (state 2)")
    assert other_stable_states(solve(FOLDING.replace(spin_up=0.2), **given)) == []
    assert other_stable_states(solve(Beam(delta=-1, gamma=4), state="stable")) == []
