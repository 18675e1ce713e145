"""Bent states: the check values, the pitchfork, spin-up, and an independent solution."""

import json
import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers import slow
from oracle.error_bars import Scene, bent_solution_verdict, bent_verdict
from scipy.optimize import brentq

from beamviz import Beam, InvalidInput, NoEquilibrium, solve
from beamviz.blade import Blade, Mass
from beamviz.solver import solve_many

BUCKLING = 2.9960  # gamma at delta = -1, mu = 70 (green, spatial)
PLAIN = {"strain": "green", "curvature": "spatial", "coriolis": False, "modes": 5}
INWARD, SPINS_UP = Beam(delta=-1, gamma=4), Beam(gamma=5, spin_up=10)
JUMP = Blade(
    (0, 0.4, 0.4, 1), (1, 0.8, 0.5, 0.2), (1, 0.7, 0.3, 0.1), (1, 0.9, 0.6, 0.4), (2, 1.8, 1.7, 1)
)
BODY = Mass(0.2, 0.7, (0.05, 0.08, 0.1))
WING = Beam(alpha=0.3, beta=0.4, gamma=4, delta=-1, blade=JUMP, masses=(BODY,), root=5)


def past_buckling(beam, past):
    """The beam faster by the relative amount `past` than where its straight state buckles."""

    def lowest(gamma):
        return solve(beam.replace(gamma=gamma), 1).omega_squared[0]

    return beam.replace(gamma=brentq(lowest, 0.01, 6, xtol=1e-14) * (1 + past))


PASSING_BUCKLING = [Beam(delta=-0.6, mu=1000), Beam(alpha=20, delta=-0.6, mu=500, root=0.1)]


@pytest.mark.parametrize("past", [1e-8, 1e-6])
@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize("beam", PASSING_BUCKLING)
def test_just_past_buckling_the_higher_modes_are_those_of_the_straight_beam(beam, coriolis, past):
    """They change in proportion to the distance from it. Beside a lowest frequency that nearly
    vanishes, Coriolis forces leave them an error of up to 7e-4, which is reported."""
    buckled = past_buckling(beam, past)
    bent = solve(buckled, 8, state="bent", coriolis=coriolis)
    apart = abs(bent.frequencies - solve(buckled, 8, coriolis=coriolis).frequencies)[1:]
    model = (10 * past + 1e-6) * bent.frequencies[1:]
    assert (apart < model + coriolis * bent.errors[1:]).all()


@pytest.mark.parametrize("past", [1e-8, 1e-6])
@pytest.mark.parametrize("beam", PASSING_BUCKLING)
def test_rounding_just_past_buckling_is_no_growth(beam, past):
    """A spin-up of 1e-13 makes no mode grow by more than about as much."""
    spinning_up = past_buckling(beam, past).replace(spin_up=1e-13)
    found = solve(spinning_up, 8, state="stable", coriolis=True)
    assert found.equilibrium.status == "stable"
    assert found.growth_rates == pytest.approx(np.zeros(8), abs=1e-12)


@pytest.mark.parametrize(
    ("beam", "tip", "frequencies", "with_coriolis"),
    [
        (
            INWARD,  # past buckling
            [-0.018520, 0.858465],
            [4.26199, 17.98849, 46.62805, 101.63256, 171.59710],
            [4.07352, 18.73117, 46.81213, 101.64957, 171.60617],
        ),
        (
            SPINS_UP,
            [0.773540, -0.596033],
            [4.2092623, 23.4846629, 58.0955989, 107.7869031, 144.0152626],
            [4.1467134, 23.6981188, 58.2746715, 107.9283843, 144.1243758],
        ),
    ],
)
def test_known_states(beam, tip, frequencies, with_coriolis):
    """Tip and frequencies; with Coriolis forces a spin-up makes a mode grow."""
    solution, coupled = (solve(beam, state="stable", coriolis=on) for on in (False, True))
    assert solution.equilibrium.shape == "bent"
    assert solution.equilibrium.status == "stable"
    assert solution.equilibrium.tip == pytest.approx(tip, abs=6e-7)
    assert solution.frequencies == pytest.approx(frequencies, abs=6e-6)
    assert coupled.frequencies == pytest.approx(with_coriolis, abs=6e-6)
    assert coupled.growth_rates.max() == pytest.approx(0.018 * bool(beam.spin_up), abs=5e-4)


def test_slowing_down_bends_the_beam_the_other_way():
    """A state of -lambda is the mirror image of that of lambda."""
    forward, back = (solve(Beam(gamma=5, spin_up=k), state="bent") for k in (10, -10))
    assert forward.equilibrium.tip == pytest.approx(back.equilibrium.tip * [1, -1], rel=1e-9)
    assert forward.frequencies == pytest.approx(back.frequencies, rel=1e-9)


def test_next_to_the_pitchfork():
    """omega_1^2 of the bent state tends to twice the square of the straight one's growth rate."""
    ratios = []
    for gamma in (3.05, 3.0, 2.998, 2.9965):
        beam = Beam(delta=-1, gamma=gamma)
        bent, straight = solve(beam, state="bent"), solve(beam)
        ratios.append(bent.omega_squared[0] / straight.omega_squared[0])
    assert ratios[1] == pytest.approx(-0.065513 / 0.032764, rel=1e-4)
    assert (np.diff(abs(np.array(ratios) + 2)) < 0).all()
    assert ratios[-1] == pytest.approx(-2, rel=1e-3)


def test_the_stable_state_along_the_speed():
    """Straight below the buckling speed, bent above it; B1 falls to zero and rises again."""
    speeds = np.linspace(2.5, 3.5, 21)
    found = solve_many([Beam(delta=-1, gamma=gamma) for gamma in speeds], state="stable")
    shapes = [solution.equilibrium.shape for solution in found]
    assert shapes == ["bent" if gamma > BUCKLING else "straight" for gamma in speeds]
    lowest = np.array([solution.frequencies[0] for solution in found])
    assert (np.diff(lowest) < 0).tolist() == [True] * 10 + [False] * 10
    assert all(solution.equilibrium.stable for solution in found)


@pytest.mark.parametrize(
    ("beam", "options", "error", "message"),
    [
        (SPINS_UP, {"state": "straight"}, InvalidInput, "spin_up = 10: there is no straight state"),
        (SPINS_UP, {"plane": "flapwise"}, InvalidInput, "chordwise"),
        (INWARD, {"method": "ancf"}, InvalidInput, "method ancf has no bent states; .*auto"),
        (INWARD, {"softening": False}, InvalidInput, "cannot be switched off"),
        (INWARD, {"state": "folded"}, InvalidInput, "must be one of straight, bent, stable"),
        (Beam(delta=-1, gamma=2), {}, NoEquilibrium, "the straight one is stable"),
    ],
)
def test_what_has_no_bent_state_says_so(beam, options, error, message):
    """Wrong input names the value and the remedy; a stable straight beam is physics, not input."""
    with pytest.raises(error, match=message):
        solve(beam, **{"state": "bent", **options})


def test_no_state_beyond_the_limit_of_the_law():
    """The limit is where the last stable state is."""
    beam, options = Beam(gamma=11.95, delta=-1.561, mu=25.01), {"curvature": "material"}
    with pytest.raises(NoEquilibrium) as error:
        solve(beam, state="stable", **options)
    limit = error.value.limit
    assert 7 < limit < 9
    assert solve(beam.replace(gamma=limit * 0.99), state="stable", **options).equilibrium.stable


def test_a_spin_up_beyond_the_limit_of_an_outward_beam():
    """The limit is that of the straight beam, which is converged."""
    beam, options = Beam(gamma=40, delta=1), {"strain": "hencky"}
    with pytest.raises(NoEquilibrium) as straight:
        solve(beam, **options)
    with pytest.raises(NoEquilibrium) as spins_up:
        solve(beam.replace(spin_up=1.0), state="stable", **options)
    assert spins_up.value.limit == straight.value.limit


@pytest.mark.parametrize(
    ("beam", "strain", "beyond", "limit", "end"),
    [
        (Beam(delta=-0.5, mu=10, gamma=4.45), "hencky", 1.0, 0.53, "collapses"),
        # Drawn out to 12 times its length, clamped almost on the axis: nothing holds it there.
        *slow((Beam(3.307, 1, 32.61, -0.002792, 12.04), "green", -3.09, -0.87, "winds around")),
    ],
)
def test_a_spin_up_beyond_its_limit_point(beam, strain, beyond, limit, end):
    """No equilibrium: a state up to the spin-up that the message names, and the way on around the
    limit point leads to no stable one."""
    options = {"strain": strain, "state": "stable", "modes": 2}
    expected = rf"beyond spin_up = {limit}\d+, to which .* then the beam {end}"
    with pytest.raises(NoEquilibrium, match=expected) as error:
        solve(beam.replace(spin_up=beyond), **options)
    assert np.isnan(error.value.limit)
    assert solve(beam.replace(spin_up=limit), **options).equilibrium.stable


@pytest.mark.parametrize(
    ("plane", "spin_up"), [("chordwise", 0.0), ("chordwise", 0.5), ("flapwise", 0.0)]
)
def test_work_on_shapes_with_and_without_matrices(plane, spin_up):
    """The integrals of the error estimate are products with the tangent and with the displacements
    of the equation of motion, also of a blade with a body on a root spring."""
    solution = solve(WING.replace(spin_up=spin_up), state="bent", plane=plane)
    state = solution.equilibrium.bent_state.restored()
    parts = np.random.default_rng(0).standard_normal((2, state.beam.size, 3))
    for c in (parts[0], parts[0] + 1j * parts[1]):
        products = (c.conj() * (state.stiffness @ c)).sum(axis=0)
        assert state.stiffness_of(c) == pytest.approx(products, rel=1e-12)
        displaced = np.sqrt(state.beam.mass)[:, None] * (state.displacements @ c)
        assert state.displaced(c) == pytest.approx(displaced, abs=1e-14)


def test_a_few_modes_with_coriolis_forces_are_those_of_many():
    """Some modes of a large problem are found in a subspace, many by the whole spectrum: they agree
    to the tolerance of both."""
    beam = Beam(delta=-1, gamma=30, alpha=1, beta=0.6)
    few, many = (solve(beam, state="stable", coriolis=True, modes=n) for n in (4, 16))
    assert few.equilibrium.shape == "bent"
    assert few.frequencies == pytest.approx(many.frequencies[:4], rel=2e-8)
    x = np.linspace(0, 1, 30)
    assert few.displacement(x) == pytest.approx(many.displacement(x)[:, :, :4], abs=1e-5)


def test_shapes_are_orthonormal_and_pickle():
    """Modes of a bent beam have unit modal mass; their nodes are counted along the bent axis."""
    beam = Beam(delta=-1, gamma=4, alpha=1, beta=0.4)
    solution = pickle.loads(pickle.dumps(solve(beam, state="bent")))
    x, w = np.polynomial.legendre.leggauss(400)
    x, w = (x + 1) / 2, w / 2
    fields = solution.displacement(x)
    at_mass = solution.displacement(np.array([0.4]))[0]
    mass = np.einsum("xck,x,xcl->kl", fields, w, fields) + at_mass.T @ at_mass
    assert mass == pytest.approx(np.eye(5), abs=1e-4)  # quadrature across the mass
    assert [len(nodes) for nodes in solution.nodes[:3]] == [0, 1, 2]


def test_the_command_line(run):
    """`beamviz modes` takes --state and --spin-up, and says which shape the state has."""
    code, out, _ = run("modes", "--delta=-1", "--gamma", "4", "--state", "stable")
    assert code == 0
    assert "stable, bent, tip at (-0.01852021, 0.8584648)" in out
    arguments = ("--gamma", "5", "--spin-up", "10", "--state", "bent", "--format", "json")
    data = json.loads(run("modes", *arguments)[1])
    assert data["beam"]["spin_up"] == 10
    assert data["equilibrium"]["shape"] == "bent"
    assert data["modes"][0]["frequency"] == pytest.approx(4.2092623, abs=1e-7)
    assert run("modes", *arguments[:4])[0] == 2
    assert run("modes", "--delta=-1", "--gamma", "2", "--state", "bent")[0] == 3


@pytest.mark.slow
def test_a_spin_up_is_in_every_file(run, tmp_path, steel):
    """Numbers, page and model of the beam that spins up; in SI units an angular acceleration."""
    beam = ("--gamma", "5", "--state", "stable")
    for name in ("a.npz", "a.html"):
        code, _, err = run("export", str(tmp_path / name), *beam, "--spin-up", "10")
        assert code == 0, err
    with np.load(tmp_path / "a.npz") as arrays:
        assert dict(zip(arrays["beam_names"], arrays["beam"], strict=True))["spin_up"] == 10
        assert arrays["frequencies"][0] == pytest.approx(4.2092623, abs=1e-7)
    page = (tmp_path / "a.html").read_text()
    assert "λ = 10" in page
    assert "spin_up = 10" in page
    over = ("--over", "spin_up", "--start", "0", "--stop", "10", "--points", "5")
    chart = json.loads(run("loci", *beam, *over, "--format", "json")[1])
    assert chart["branches"][0]["frequency"][-1] == pytest.approx(4.2092623, abs=1e-7)
    file = Path(steel)
    file.write_text(f"{file.read_text()}angular_acceleration = 200\n")
    beam = json.loads(run("modes", "--si", file, "--state", "bent", "--format", "json")[1])["beam"]
    assert beam["spin_up"] == pytest.approx(200 * 7850 * 4e-4 * 2**4 / (2.1e11 * 1.2e-8))
    file.write_text("[si]\n" + file.read_text().replace("200", "2e5"))
    code, _, err = run("screenshot", "a.png", "--scene", file)
    assert code == 2
    assert "angular_acceleration T*^2 = spin_up = 3987.30" in err


@pytest.mark.parametrize(
    ("beam", "options"),
    [
        # A heavy mass on a beam that stretches to 14 times its length, thin layers at both.
        *slow((Beam(1.29, 0.61, 100.5, -1.997, 20.77), {})),
        *slow((Beam(alpha=3, beta=0.7, gamma=100, delta=-1, mu=1000), {})),
        # The spin-up has a limit point on the way: the state lies behind it, and grows.
        (
            Beam(4.656, 1, 5.341, -0.09663, 194.4, spin_up=-45.14),
            {"strain": "biot", "curvature": "material"},
        ),
    ],
)
def test_states_that_are_hard_to_reach(beam, options):
    """They are states of the differential equations, their frequencies within the error bars."""
    found = bent_verdict(Scene(beam, PLAIN | {"coriolis": True, "state": "stable"} | options))
    assert found["kind"] == "within", found


@pytest.mark.slow
def test_a_mode_outside_its_error_is_recognised():
    """The verdict turns when a frequency or a growth rate moves by more than its error."""
    scene = Scene(INWARD, PLAIN | {"modes": 3})
    solution = solve(scene.beam, state="bent", modes=3)
    assert bent_solution_verdict(scene, solution)["kind"] == "within"
    for direction in (1, 1j):
        moved = replace(solution, s=solution.s + 2 * direction * solution.errors)
        assert bent_solution_verdict(scene, moved)["kind"] == "outside"
