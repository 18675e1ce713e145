"""Newton-Raphson and load continuation on problems whose answers are known in closed form."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamviz.errors import NotConverged
from beamviz.solver.continuation import continue_load, newton

NO_ANSWER = {
    "no root": lambda q: -(q * q + 1) / (2 * q),
    "too slow": lambda q: -(q**9) / (9 * q**8),
    "stalls far above rounding": lambda q: np.array([1e-6]),
    "singular tangent": lambda q: np.linalg.inv(np.zeros((1, 1))) @ q,
    "nan": lambda q: q * math.nan,
    "infinite": lambda q: q * math.inf,
}


@pytest.mark.parametrize("increment", NO_ANSWER.values(), ids=NO_ANSWER)
def test_no_answer(increment):
    """Where the iteration does not converge the answer is None, neither an exception nor a guess;
    a state that is no number ends it at once."""
    states = []
    assert newton(lambda q: states.append(q) or increment(q), np.array([0.7])) is None
    assert np.isfinite(states).all()


def test_rounding_is_not_mistaken_for_failure():
    """Increments that stop shrinking at the level of rounding end the iteration with an answer."""
    noise = iter([0.1, 1e-4, 5e-8, 3e-8, 5e-8, 4e-8])
    assert newton(lambda q: np.array([next(noise)]), np.zeros(1)) is not None


def follow(target, load, margin=None, reach=lambda load, q: True):
    """A path given by its load as a function of one state, followed to a target. The margin is the
    slope relative to rest unless given; a step from q to a load is solved only where reach(load, q)
    allows it."""

    def slope(q):
        return load(q + 1e-30j).imag / 1e-30

    def solve_at(goal, guess):
        def increment(q):
            if slope(q[0]) <= 0:
                raise np.linalg.LinAlgError
            return np.array([(goal - load(q[0])) / slope(q[0])])

        root = newton(increment, guess) if reach(goal, guess[0]) else None
        return root if root is not None and slope(root.state[0]) > 0 else None

    margin = margin or (lambda _, q: slope(q) / slope(0.0))
    return continue_load(solve_at, np.zeros(1), target, lambda goal, q: margin(goal, q[0]))


@given(peak=st.floats(0.01, 100), bend=st.floats(0.2, 5), beyond=st.floats(1.001, 1e4))
def test_folds_of_all_sizes(peak, bend, beyond):
    """load = peak (1 - (1 - q / bend)^2): the limit is the peak, however far beyond the target; it
    is never passed."""
    path = follow(beyond * peak, lambda q: peak * (1 - (1 - q / bend) ** 2))
    assert path.limit == pytest.approx(peak, rel=1e-9)
    assert path.state[0] < bend


@pytest.mark.parametrize("longest", [0.05, 1.0])
@pytest.mark.parametrize("short", [0.3, 1e-4, 1e-8])
def test_just_below_a_fold(short, longest):
    """A load just below the limit has an equilibrium and gets it, also after steps that failed."""
    path = follow(
        1 - short, lambda q: q * (2 - q), reach=lambda load, q: load - q * (2 - q) < longest
    )
    assert path.limit is None
    assert path.state[0] == pytest.approx(1 - math.sqrt(short), rel=1e-9)


def test_other_limits():
    """Where the state diverges, or its law ends though its slope is still positive."""
    runaway = follow(10.0, lambda q: q / (1 + q))
    assert runaway.limit == pytest.approx(1, rel=1e-9)
    ends = follow(10.0, lambda q: 3 * q if q.real < 1 else 4 - q, lambda load, q: 1 - q)
    assert ends.limit == pytest.approx(3, rel=1e-9)


def test_stop_without_a_limit():
    """A path that stops while its margin is whole did not converge, and says how far it came."""
    with pytest.raises(NotConverged, match=r"followed to 0\.3 of the load .* no limit was found"):
        follow(10.0, lambda q: q, reach=lambda load, q: load < 3)


@pytest.mark.parametrize(
    ("margin", "reach"),
    [
        (None, lambda load, q: load - q < 0.02 or q > 0.1),
        (lambda load, q: max(1 - 0.9 * load, 0.05), lambda load, q: load - q < 0.3),
    ],
)
def test_a_step_too_long_is_no_limit(margin, reach):
    """Nor is a margin that falls in a straight line and then no further."""
    path = follow(10.0, lambda q: q, margin, reach)
    assert path.limit is None
    assert path.state[0] == pytest.approx(10)
