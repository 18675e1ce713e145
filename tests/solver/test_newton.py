"""Newton-Raphson and load continuation on problems whose answers are known in closed form."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from beamviz.errors import NotConverged
from beamviz.solver.continuation import continue_load, newton, vanishing_load


def scalar(function, slope):
    """The Newton increment of one equation in one unknown."""
    return lambda q: -function(q) / slope(q)


@given(c=st.floats(0.1, 100))
def test_square_root(c):
    """Newton finds the square root of c from c + 1 to rounding, in a few iterations."""
    root = newton(scalar(lambda q: q * q - c, lambda q: 2 * q), np.array([c + 1]))
    assert root is not None
    assert root.state[0] == pytest.approx(math.sqrt(c), rel=1e-15)
    assert root.iterations <= 12


def raises(q):
    raise np.linalg.LinAlgError


@pytest.mark.parametrize(
    "increment",
    [
        pytest.param(scalar(lambda q: q * q + 1, lambda q: 2 * q), id="no root"),
        pytest.param(scalar(lambda q: q**9, lambda q: 9 * q**8), id="too slow"),
        pytest.param(lambda q: np.array([1e-6]), id="stalls far above rounding"),
        pytest.param(raises, id="singular tangent"),
        pytest.param(lambda q: q * math.nan, id="nan"),
        pytest.param(lambda q: q * math.inf, id="infinite"),
    ],
)
def test_no_answer(increment):
    """Where the iteration does not converge the answer is None, neither an exception nor a guess;
    a state that is no number ends it at once."""
    calls = []

    def counted(q):
        calls.append(q)
        return increment(q)

    assert newton(counted, np.array([0.7])) is None
    assert np.isfinite(calls).all()


def test_rounding_is_not_mistaken_for_failure():
    """Increments that stop shrinking at the level of rounding end the iteration with an answer."""
    noise = iter([0.1, 1e-4, 4e-10, 3e-10, 5e-10, 4e-10])
    root = newton(lambda q: np.array([next(noise)]), np.zeros(1))
    assert root is not None
    assert root.iterations == 4


class Curve:
    """A path given by its load as a function of one state, and the slope of that function.

    margin(load, q) is the slope relative to rest unless given; a step from q to a load is
    solved only where reach(load, q) allows it.
    """

    def __init__(self, load, slope, margin=None, reach=lambda load, q: True):
        self.load, self.slope, self.reach = load, slope, reach
        self.margin = margin or (lambda load, q: slope(q) / slope(0.0))
        self.solved: list[float] = []

    def solve_at(self, load, guess):
        self.solved.append(load)

        def increment(q):
            if self.slope(q[0]) <= 0:
                raise np.linalg.LinAlgError
            return np.array([(load - self.load(q[0])) / self.slope(q[0])])

        root = newton(increment, guess) if self.reach(load, guess[0]) else None
        return root if root is not None and self.slope(root.state[0]) > 0 else None

    def follow(self, target):
        return continue_load(
            self.solve_at, np.zeros(1), target, lambda load, state: self.margin(load, state[0])
        )


def hardening():
    return Curve(lambda q: q + q**3, lambda q: 1 + 3 * q**2)


def line(**options):
    return Curve(lambda q: q, lambda q: 1.0, **options)


def test_target_within_reach():
    """A hardening path reaches its load, and the first try is the whole load."""
    curve = hardening()
    path = curve.follow(10.0)
    assert path.limit is None
    assert path.state[0] == pytest.approx(2.0, rel=1e-14)
    assert curve.solved == [10.0]


def test_no_load():
    """Without a load the start is the answer and nothing is solved."""
    path = hardening().follow(0.0)
    assert (path.limit, path.iterations) == (None, 0)
    assert path.state.tolist() == [0]


@given(peak=st.floats(0.01, 100), bend=st.floats(0.2, 5), beyond=st.floats(1.001, 1e4))
def test_folds_of_all_sizes(peak, bend, beyond):
    """load = peak (1 - (1 - q / bend)^2): the limit is the peak, however far beyond the target; it
    is never passed, and found in a few dozen solves."""
    curve = Curve(
        lambda q: peak * (1 - (1 - q / bend) ** 2), lambda q: 2 * peak * (1 - q / bend) / bend
    )
    path = curve.follow(beyond * peak)
    assert path.limit == pytest.approx(peak, rel=1e-9)
    assert path.state[0] < bend
    assert len(curve.solved) < 60


@pytest.mark.parametrize("longest", [0.05, 1.0])
@pytest.mark.parametrize("short", [0.3, 1e-2, 1e-4, 1e-6, 1e-8])
def test_just_below_a_fold(short, longest):
    """A load below the limit, however little, has an equilibrium and gets it, also after steps
    that failed for being too long and with the limit in full sight."""
    curve = Curve(
        lambda q: q * (2 - q),
        lambda q: 2 * (1 - q),
        reach=lambda load, q: load - q * (2 - q) < longest,
    )
    path = curve.follow(1 - short)
    assert path.limit is None
    assert path.state[0] == pytest.approx(1 - math.sqrt(short), rel=1e-9)


def test_runaway():
    """q = load / (1 - load) runs away at load 1, where its stiffness falls to zero linearly."""
    curve = Curve(lambda q: q / (1 + q), lambda q: (1 + q) ** -2)
    assert curve.follow(5.0).limit == pytest.approx(1, rel=1e-9)


def test_law_that_ends():
    """A law that ends at q = 1 under a load of 3 ends the path there, its slope still positive."""
    curve = Curve(lambda q: 3 * q, lambda q: 3.0 if q < 1 else -1.0, margin=lambda load, q: 1 - q)
    assert curve.follow(10.0).limit == pytest.approx(3, rel=1e-9)


def test_stop_without_a_limit():
    """A path that stops while its margin is whole did not converge, and says how far it came."""
    curve = line(reach=lambda load, q: load < 3)
    with pytest.raises(NotConverged, match=r"followed to 0\.3 of the load .* no limit was found"):
        curve.follow(10.0)


def test_steps_shrink_and_grow_again():
    """A step that is too long is no limit; after a difficult start the steps double: 1000 loads of
    0.01 take a dozen steps. The iterations of accepted steps are added up."""
    curve = line(reach=lambda load, q: load - q < 0.02 or q > 0.1)
    path = curve.follow(10.0)
    assert path.limit is None
    assert path.state[0] == pytest.approx(10)
    assert len(curve.solved) < 40
    assert path.iterations < 40


def test_margin_that_heads_for_zero_and_stays():
    """A margin that falls in a straight line and then no further is no limit."""
    curve = line(
        margin=lambda load, q: max(1 - 0.9 * load, 0.05), reach=lambda load, q: load - q < 0.3
    )
    assert curve.follow(10.0).limit is None


@given(
    limit=st.floats(0.1, 100),
    slope=st.floats(-2, 2),
    curvature=st.floats(-2, 2),
    first=st.floats(0.01, 0.5),
)
def test_vanishing_load(limit, slope, curvature, first):
    """A load cubic in the margin is extrapolated to its limit exactly from four points, unless it
    is past the limit by then."""
    margins = first * 0.4 ** np.arange(4)
    loads = limit + slope * margins + curvature * margins**2 - margins**3
    assume(abs(limit - loads[-1]) > 1e-9)
    expected = limit if limit > loads[-1] else math.inf
    assert vanishing_load(margins, loads) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("margins", [[], [0.5], [0.5, 0.5], [0.4, 0.5]])
def test_nothing_to_extrapolate(margins):
    """Without margins that fall no limit is in sight."""
    loads = np.arange(1.0, 1.0 + len(margins))
    assert vanishing_load(np.array(margins), loads) == math.inf
