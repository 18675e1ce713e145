"""Equilibria of the planar beam: limits of existence, buckling, bent states, honest failures."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_bvp
from scipy.optimize import brentq

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.solver.constitutive import CURVATURES, STRAIN_LAWS
from beamviz.solver.fem import ancf, assembly, inertia, planar
from beamviz.solver.fem.equilibrium import (
    bent_equilibrium,
    carried,
    leaning,
    straight_equilibrium,
    straight_margin,
)
from beamviz.solver.fem.hermite import coordinates, interpolate, uniform


def model(elements=20, law="green", curvature="spatial", plane="chordwise", **numbers):
    laws = STRAIN_LAWS[law], CURVATURES[curvature]
    return planar.model(Beam(**numbers), uniform(elements), *laws, plane)


def bent(scene, angle=0.3):
    """The stable state found from the straight one, pushed along its buckling mode."""
    return bent_equilibrium(scene, leaning(scene, straight_equilibrium(scene).q, angle))


def potential(scene, q):
    """Elastic energy less the work of the centrifugal force."""
    q_e = coordinates(q)
    arm = inertia.lever_arm(q_e, scene.beam.delta)
    elastic = ancf.energy(scene.elements, scene.material, q_e)
    return elastic - scene.beam.gamma**2 * np.einsum("ei,eij,ej->", arm, scene.C, arm) / 2


# The straight state


def test_linear_law_in_closed_form():
    """A biot bar has u'' + (gamma / mu)^2 (u + delta) = 0: r1 + delta = (sin + delta cos) / cos."""
    gamma, delta, mu = 50.0, 0.5, 70.0
    state = straight_equilibrium(model(law="biot", gamma=gamma, delta=delta, mu=mu))
    k, x = gamma / mu, uniform(20)
    A = (1 / k + delta * math.sin(k)) / math.cos(k)
    r = delta * np.cos(k * x) + A * np.sin(k * x) - delta
    assert state.q[::4] == pytest.approx(r, abs=1e-7)
    assert state.stable
    assert not state.q[1::2].any()


def test_rest():
    """Without rotation the beam is where it was, after no iteration at all."""
    scene = model(alpha=3, beta=0.4, delta=2)
    state = straight_equilibrium(scene)
    assert np.array_equal(state.q, scene.unstressed)
    assert (state.iterations, state.stable) == (0, True)


@given(
    mu=st.floats(10, 10000),
    speed=st.floats(0, 1),
    alpha=st.floats(0, 100),
    delta=st.floats(0, 20),
    curvature=st.sampled_from(sorted(CURVATURES)),
)
@settings(max_examples=40, deadline=None)
def test_green_always_has_an_outward_state(mu, speed, alpha, delta, curvature):
    """With green strain and delta >= 0 every beam with no mass or a tip mass has an equilibrium,
    pulled everywhere and stable."""
    gamma = speed * min(200, 5 * mu)
    scene = model(curvature=curvature, alpha=alpha, gamma=gamma, delta=delta, mu=mu)
    state = straight_equilibrium(scene)
    assert state.stable
    assert scene.slopes(state.q)[:, 0].min() > 1 - 1e-6
    R = scene.residual(state.q, gamma**2)
    assert np.abs(R).max() < 1e-9 * mu**2


# Limits of existence


@pytest.mark.parametrize("delta", [0.0, 1.0, 5.0])
def test_biot_limit(delta):
    """A linear bar has no equilibrium beyond gamma = mu pi / 2, whatever the hub radius."""
    with pytest.raises(NoEquilibrium, match=r"no equilibrium beyond gamma = 109\.955743") as error:
        straight_equilibrium(model(law="biot", gamma=150, delta=delta))
    assert error.value.limit == pytest.approx(70 * math.pi / 2, rel=1e-9)


# Computed independently: a fold of the whole beam at delta 0; at delta 1 the root reaches f = e,
# in a layer that 20 elements resolve to 1e-4.
@pytest.mark.parametrize(
    ("delta", "limit", "tolerance", "reason"),
    [(0, 45.420, 1e-5, "stiffness of the beam"), (1, 31.4887, 1e-4, "hencky force law ends")],
)
def test_hencky_limit(delta, limit, tolerance, reason):
    """Hencky strain has a limit, found, named and explained; just below it there is a state."""
    with pytest.raises(NoEquilibrium, match=reason) as error:
        straight_equilibrium(model(law="hencky", gamma=50, delta=delta))
    found = error.value.limit
    assert found == pytest.approx(limit, rel=tolerance)
    assert straight_equilibrium(model(law="hencky", gamma=found * (1 - 1e-7), delta=delta)).stable
    with pytest.raises(NoEquilibrium):
        straight_equilibrium(model(law="hencky", gamma=found * (1 + 1e-7), delta=delta))


@pytest.mark.parametrize(("law", "delta"), [("green", -1), ("biot", 0.5), ("hencky", 0.5)])
def test_limit_does_not_depend_on_the_speed_asked_for(law, delta):
    """However far beyond the limit the speed is, the same limit is found for the same reason."""
    found = []
    for over in (None, 0.001, 0.03, 0.38237, 0.7):
        gamma = 130.0 if over is None else found[0].limit * (1 + over)
        with pytest.raises(NoEquilibrium) as error:
            straight_equilibrium(model(law=law, gamma=gamma, delta=delta))
        found.append(error.value)
    assert [error.limit for error in found[1:]] == pytest.approx([found[0].limit] * 4, rel=1e-8)
    assert len({str(error).partition(":")[2] for error in found}) == 1


@pytest.mark.parametrize(("law", "end"), [("green", "0.5774"), ("biot", "0")])
def test_inward_limit(law, end):
    """An inward beam is compressed to the end of its force law, never through it."""
    with pytest.raises(NoEquilibrium, match=f"{law} force law ends there, at a stretch of {end}$"):
        straight_equilibrium(model(law=law, gamma=150, delta=-2))


def test_green_inward_limit_in_closed_form():
    """At the root the green law ends where gamma^2 int (|delta| - r1) dx is its least force."""
    scene = model(elements=80, gamma=150, delta=-2)
    with pytest.raises(NoEquilibrium) as error:
        straight_equilibrium(scene)
    gamma = error.value.limit

    def ode(x, y):
        return np.array([stretch(y[1]), gamma**2 / 4900 * (2 - y[0])])

    def stretch(n):
        """The upper root f of f (f^2 - 1) / 2 = n, for n in -0.19245 .. 0."""
        angle = np.arccos(np.clip(n / 0.19245008972987526, -1, 1)) / 3
        return 2 / math.sqrt(3) * np.cos(angle)

    x = np.linspace(0, 1, 201)
    solution = solve_bvp(ode, lambda a, b: np.array([a[0], b[1]]), x, [0.9 * x, x - 1], tol=1e-6)
    assert solution.y[1, 0] == pytest.approx(-0.19245, rel=2e-3)


@pytest.mark.parametrize("law", STRAIN_LAWS)
def test_inverted_states_have_no_margin(law):
    """A beam turned inside out, r1' < 0 somewhere, is off the branch whatever its law says."""
    scene = model(4, law=law)
    q = scene.unstressed
    assert straight_margin(scene, 0.0, q) == pytest.approx(1)
    q[2] = -0.1
    assert straight_margin(scene, 0.0, q) <= 0


# A shared gradient at an inner mass


def test_carried_force():
    """What the beam carries is the pull of all that lies outboard, the mass included."""
    scene = model(8, alpha=2, beta=0.5, delta=0.3, mu=10)
    x = uniform(8)
    outboard = (1 - x**2) / 2 + 0.3 * (1 - x) + 2 * (0.5 + 0.3) * (x <= 0.5)
    assert carried(scene, 9.0, scene.unstressed) == pytest.approx(9 / 100 * outboard)


@pytest.mark.parametrize(
    "numbers",
    [
        {"alpha": 98, "beta": 0.725, "gamma": 97, "delta": 10.8, "mu": 70},  # false limit
        {"alpha": 33, "beta": 0.966, "gamma": 26, "delta": 19.8, "mu": 1533},  # false buckling
    ],
)
def test_overshoot_at_a_mass_is_not_physics(numbers):
    """Where the gradient shared at a heavy inner mass overshoots into compression, neither a limit
    nor an instability of the beam is reported: the method did not converge."""
    with pytest.raises(NotConverged, match="a limit of the method, not of the beam"):
        straight_equilibrium(model(**numbers))


# Buckling and bent states


def ritz_buckling_speed(delta):
    """The least gamma at which an inextensible inward beam buckles chordwise, by polynomials."""
    x, weights = np.polynomial.legendre.leggauss(40)
    x, weights = (x + 1) / 2, weights / 2
    tension = (1 - x**2) / 2 + delta * (1 - x)
    powers = np.arange(2, 10)[:, None]
    w, dw, ddw = x**powers, powers * x ** (powers - 1), powers * (powers - 1) * x ** (powers - 2)
    K = (weights * ddw) @ ddw.T
    softening = (weights * w) @ w.T - (weights * tension * dw) @ dw.T
    return 1 / math.sqrt(np.linalg.eigvals(np.linalg.solve(K, softening)).real.max())


@pytest.mark.parametrize("delta", [-1.0, -0.3, -2.0])  # at -0.3 pulled everywhere, and yet
def test_buckling_speed(delta):
    """The straight inward beam becomes unstable at the speed of the inextensible one."""

    def lowest(gamma):
        scene = model(gamma=gamma, delta=delta, mu=1000)
        return planar.modes(scene, straight_equilibrium(scene).q, 1)[0][0]

    critical = ritz_buckling_speed(delta)
    assert brentq(lowest, critical - 0.5, critical + 0.5) == pytest.approx(critical, rel=1e-4)
    for factor, stable in ((0.99, True), (1.01, False)):
        scene = model(gamma=factor * critical, delta=delta, mu=1000)
        assert straight_equilibrium(scene).stable is stable


@pytest.mark.parametrize("law", STRAIN_LAWS)
@pytest.mark.parametrize("curvature", CURVATURES)
@pytest.mark.parametrize("alpha", [0, 1])
def test_bent_state_is_stable(law, curvature, alpha):
    """Past buckling the straight state is unstable and a bent one is found beside it: in
    equilibrium, with a positive definite tangent and a lower potential."""
    scene = model(law=law, curvature=curvature, alpha=alpha, gamma=3.5, delta=-1)
    straight, state = straight_equilibrium(scene), bent(scene)
    assert not straight.stable
    assert planar.modes(scene, straight.q, 1)[0][0] < 0
    assert state.stable
    assert abs(state.q[-3]) > 0.5
    assert np.abs(scene.residual(state.q, 3.5**2)).max() < 1e-9 * scene.beam.mu**2
    K = assembly.dense(scene.tangent(state.q, 3.5**2))
    assert np.linalg.eigvalsh(K).min() > 0
    assert potential(scene, state.q) < potential(scene, straight.q) - 0.1
    assert planar.modes(scene, state.q, 3)[0].min() > 1


def test_bent_states_come_in_pairs():
    """Pushed to the other side the beam bends to the other side, alike."""
    scene = model(gamma=3.5, delta=-1)
    mirrored = np.tile([1.0, -1.0], 42)
    assert bent(scene, -0.3).q == pytest.approx(mirrored * bent(scene, 0.3).q, abs=1e-9)


def test_below_buckling_the_straight_state_returns():
    """Pushed sideways below its buckling speed the beam comes back straight."""
    scene = model(gamma=2.5, delta=-1)
    assert bent(scene).q == pytest.approx(straight_equilibrium(scene).q, abs=1e-9)


def rod(gamma, delta, mu, angle):
    """Tip of the bent rod with f = 1 + N / mu^2 and moment theta', by collocation of its strong
    form: theta, theta', r1, r2 and the force N1, N2 (geometrically exact, no shear), from a guess
    whose tip has turned by `angle`."""

    def ode(x, y):
        theta, moment, r1, r2, N1, N2 = y
        c, s = np.cos(theta), np.sin(theta)
        f = 1 + (N1 * c + N2 * s) / mu**2
        load = [-(gamma**2) * (r1 + delta), -(gamma**2) * r2]
        return np.array([moment, f * (N1 * s - N2 * c), f * c, f * s, *load])

    def ends(a, b):
        return np.array([a[0], a[2], a[3], b[1], b[4], b[5]])

    x = np.linspace(0, 1, 101)
    guess = np.zeros((6, 101))
    guess[:4] = angle * (2 * x - x**2), angle * (2 - 2 * x), x, angle * x**2
    solution = solve_bvp(ode, ends, x, guess, tol=1e-10, max_nodes=100_000)
    assert solution.success
    return solution.y[2:4, -1]


@pytest.mark.parametrize(("gamma", "mu", "angle"), [(3.5, 20, 1.5), (3.5, 70, 1.5), (5, 70, 2.5)])
def test_bent_state_against_the_strong_form(gamma, mu, angle):
    """With biot strain and material curvature the bent tip is that of the geometrically exact rod,
    and 20 to 40 elements approach it at order 4."""
    exact = rod(gamma, -1.0, mu, angle)
    options = {"law": "biot", "curvature": "material", "gamma": gamma, "delta": -1.0, "mu": mu}
    errors = [np.abs(bent(model(n, **options)).q[-4:-2] - exact).max() for n in (20, 40)]
    assert errors[1] < 5e-6
    assert math.log2(errors[0] / errors[1]) > 3.5


@pytest.mark.parametrize("mu", [70, 1000, 10000])
def test_slender_beams_take_no_more_iterations(mu):
    """The mixed iteration does not slow down with slenderness."""
    assert bent(model(gamma=3.5, delta=-1, mu=mu)).iterations < 40


def test_bent_state_has_no_kink():
    """The bent axis leaves the clamp along the beam and keeps its length."""
    scene = model(gamma=3.5, delta=-1)
    q = bent(scene).q
    nodes, x = scene.elements.nodes, np.linspace(0, 1, 201)
    slope = interpolate(nodes, q, x, 1)
    assert slope[0, 0] > 0
    assert slope[0, 1] == 0
    assert np.hypot(*slope.T) == pytest.approx(1, abs=0.01)
    assert np.abs(np.diff(np.arctan2(slope[:, 1], slope[:, 0]))).max() < 0.1


def test_bent_state_that_cannot_be_found():
    """A start from which no unfolded stable state is reached is a failure, not an answer: a beam
    pointing inward at an extreme speed turns over its own clamp."""
    scene = model(10, gamma=200, delta=-2, mu=100)
    start = scene.unstressed.reshape(-1, 2) @ np.diag([-1.0, 1.0])
    with pytest.raises(NotConverged, match="no stable bent state was found at gamma = 200"):
        bent_equilibrium(scene, start.ravel())


def test_flapwise_buckling():
    """Flapwise, without the softening, the inward beam buckles later and bends out all the same."""
    scene = model(gamma=6.5, delta=-1, plane="flapwise")
    assert not straight_equilibrium(scene).stable
    assert bent(scene).stable
    assert straight_equilibrium(model(gamma=5, delta=-1, plane="flapwise")).stable
