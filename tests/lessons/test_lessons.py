"""The lessons: every number they show holds against the differential equations, and every
challenge can be met, and only by its answer."""

import json
import math
import re
from functools import cache
from typing import Any

import numpy as np
import pytest
from oracle import truth
from oracle.bent import bent_truth
from oracle.equilibrium import shoot, stretch
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from beamviz.beam import NUMBERS, Beam
from beamviz.dynamics import motion
from beamviz.dynamics.drives import Ramp
from beamviz.dynamics.linear import motion_without_stiffening
from beamviz.explorer.experiment import RANGES
from beamviz.lessons import INWARD, LESSONS, NAMED, ON_A_HUB
from beamviz.lessons.model import (
    BARE,
    HIDDEN,
    KANE,
    MEASURED,
    MIDDLE,
    MIN_MASS,
    SPIN_UP_TIME,
    TIP,
    UNDEFINED,
    Lesson,
    strength,
)
from beamviz.solver import solve

EACH = pytest.mark.parametrize("one", LESSONS, ids=NAMED)


@pytest.fixture
def lesson(request) -> Lesson:
    """The lesson that a test is named after."""
    return NAMED[request.function.__name__.removeprefix("test_").replace("_", "-")]


@cache
def omega(beam: Beam, k: int = 0, family: str = "bending", **options) -> float:
    """Frequency k of a family by the oracle."""
    found = truth(beam, **options)
    return float(found.frequencies[[kind == family for kind in found.families]][k])


def test_stiffening(lesson):
    """B1 at gamma 10 and at rest; twice the latter at the answer."""
    speeds = (10, 0, lesson.answer)
    up, rest, there = (omega(BARE.replace(gamma=gamma), plane="flapwise") for gamma in speeds)
    assert (*lesson.numbers, there) == pytest.approx((up, rest, 2 * rest), rel=1e-6)


def test_two_planes(lesson):
    """The squares differ by gamma^2; one is twice the other at the answer."""
    beam, there = BARE.replace(gamma=10), BARE.replace(gamma=lesson.answer)
    up, aside = (omega(beam, plane=plane) ** 2 for plane in ("flapwise", "chordwise"))
    assert lesson.numbers == pytest.approx((up, aside, 100), rel=1e-6)
    assert omega(there, plane="flapwise") == pytest.approx(2 * omega(there), rel=1e-6)


def test_moving_mass(lesson):
    """MPE 2017/1568019, table 1, and Blevins; two thirds at the answer."""
    assert lesson.numbers == pytest.approx((1.557298, 3.516015), abs=1e-6)
    assert omega(TIP.replace(beta=lesson.answer)) == pytest.approx(2 / 3 * 3.516015, rel=1e-6)


def test_nodes(lesson):
    """The paper: 22.0345 and 0.78344; a mass there changes nothing."""
    bare, node, heavy = lesson.numbers
    assert bare == pytest.approx(22.0344916, abs=1e-6)
    assert node == lesson.answer == pytest.approx(0.783445, abs=1e-6)
    assert heavy == pytest.approx(omega(Beam(alpha=5, beta=node), 1), rel=1e-6)
    assert heavy == pytest.approx(bare, abs=1e-5)


def test_mode_shift(lesson):
    """The closed forms of bending (Blevins) and stretching are equal at the answer."""
    before, after, alpha = lesson.numbers
    for mode, beam in ((before, TIP), (after, TIP.replace(alpha=2))):
        assert truth(beam).families[int(mode) - 1] == "stretching"
    assert alpha == lesson.answer == pytest.approx(1.5702506, abs=1e-6)
    z = brentq(lambda z: z * math.tan(z) - 1 / alpha, 1e-6, math.pi / 2 - 1e-6)
    b = math.sqrt(70 * z)
    mass = alpha * b * (math.sin(b) - math.cos(b) * math.tanh(b))
    assert 1 / math.cosh(b) + math.cos(b) - mass == pytest.approx(0, abs=1e-4)


def test_crossing(lesson):
    """gamma 4.4641 (green, spatial): bending and stretching agree there."""
    at, frequency, gap = lesson.numbers
    there = TIP.replace(gamma=at)
    assert at == lesson.answer == pytest.approx(4.4641, abs=5e-5)
    assert omega(there, 2) == pytest.approx(frequency, rel=1e-6)
    stretching = omega(there, 0, "stretching")
    assert (gap, stretching) == (0, pytest.approx(frequency, rel=1e-6))


def test_veering(lesson):
    """Least gap 0.241 at gamma 4.650, and wider on both sides."""
    gap, at = lesson.numbers
    assert at == lesson.answer == pytest.approx(4.650, abs=1e-3)
    assert gap == pytest.approx(0.241, abs=1e-3)
    beams = [TIP.replace(gamma=at + step) for step in (-0.02, 0, 0.02)]
    low, least, high = (np.diff(truth(beam, coriolis=True).frequencies)[2] for beam in beams)
    assert least == pytest.approx(gap, rel=1e-4)
    assert least < min(low, high)


def test_flap_and_lag(lesson):
    """Flap and lag, each solved in its own plane, agree at the crossing; with a pitch the gap is
    wider on both sides of the least one."""
    crossing, least, at, pitch = lesson.numbers
    flat = Beam(flap=0.25, gamma=crossing)
    flap, lag = (solve(flat, plane=plane).frequencies[0] for plane in ("flapwise", "chordwise"))
    assert flap == pytest.approx(lag, rel=1e-6)
    gaps = [
        np.diff(solve(flat.replace(gamma=at + step, pitch=5), plane="both").frequencies)[0]
        for step in (-0.02, 0, 0.02)
    ]
    assert gaps[1] == pytest.approx(least, rel=1e-5)
    assert gaps[1] < min(gaps[0], gaps[2])
    there = solve(Beam(flap=0.25, gamma=3, pitch=pitch), plane="both").frequencies
    assert there[1] - there[0] == pytest.approx(0.5, abs=1e-6)


def test_twist(lesson):
    """.040, .883 and .267 by the independent computation of test_both_planes.py."""
    assert lesson.numbers[:3] == pytest.approx((0.040, 0.883, 0.267), abs=6e-4)
    turned = Beam(flap=1 / 16, twist=lesson.answer)
    assert solve(turned, plane="both").in_plane_fraction[2] == pytest.approx(0.25, abs=1e-6)


def test_resonance(lesson):
    """omega is three times, and once, the speed."""
    thrice, once = lesson.numbers
    assert thrice == lesson.answer
    assert omega(BARE.replace(gamma=thrice), 1) == pytest.approx(3 * thrice, rel=1e-6)
    assert omega(BARE.replace(gamma=once)) == pytest.approx(once, rel=1e-6)


def test_paradox(lesson):
    """Without stiffening omega^2 = omega_0^2 - gamma^2: it fails at omega_0 = 3.516."""
    speed, true = lesson.numbers
    assert speed == lesson.answer == pytest.approx(3.5160153, abs=1e-6)
    assert true == pytest.approx(omega(BARE.replace(gamma=speed)), rel=1e-6)


def test_spin_up(lesson):
    """Kane, Ryan & Banerjee 1987: 0.5738 m of 10 m at 6.75 s. Without stiffening the equation of
    one mode, b" + (w^2 - gamma^2) b = -gamma' int phi x dx, whose displacement the others change by
    1 %; at the end it doubles within 0.2 T*."""
    lag, at, end = lesson.numbers
    assert lag == pytest.approx(0.057379, abs=5e-5)
    assert at == pytest.approx(6.75 / 0.925820, abs=0.02)
    assert lesson.answer == pytest.approx(3.5160153, abs=1e-6)
    omega, final, within = 3.5160153, 5.554921, 16.20185
    moment = 4 / 1.8751041**2  # phi(1) int phi x dx of unit modal mass (Blevins)

    def rates(t, y):
        turn = 2 * math.pi * t / within
        gamma = final * (t / within - math.sin(turn) / (2 * math.pi))
        rate = final / within * (1 - math.cos(turn))
        return [y[1], (gamma**2 - omega**2) * y[0] - moment * rate]

    def left(t, y):
        return y[0] + 1

    left.terminal = True
    found = solve_ivp(rates, (0, 12), [0, 0], events=left, rtol=1e-8, atol=1e-10)
    assert end == pytest.approx(found.t[-1], abs=0.02)


def test_until_when_both_theories_of_the_spin_up_agree():
    """The tips differ by 2 % at the time in the text, by 7 % one T* later."""
    until = float(re.search(r"until t = ([\d.]+)", NAMED["spin-up"].see)[1])
    speed = Ramp(KANE.gamma, SPIN_UP_TIME)
    both = [run(KANE, 8.0, speed=speed) for run in (motion, motion_without_stiffening)]
    true, linear = (np.interp(until, found.t, found.tip[:, 1]) for found in both)
    assert linear == pytest.approx(true, rel=0.025)


def test_the_node_of_b3_near_the_middle():
    """The node in the text is that of the closed form (Blevins), 0.50355; plucked in the middle B2
    is louder relative to B1 than plucked at the tip, and B3 is far less so, but not silent."""
    node = float(re.search(r"x = ([\d.]+)", NAMED["hear-the-modes"].meaning)[1])
    assert node == pytest.approx(0.50355, abs=5e-4)
    found = solve(BARE)
    assert strength(found, "B2", 0.5) > 2 * strength(found, "B2", 1.0)
    assert 0 < strength(found, "B3", 0.5) < 0.1 * strength(found, "B3", 1.0)


def test_hear_the_modes(lesson):
    """At the tip (omega_1 / omega_2)^2 of the paper's 3.516 and 22.0345, to the nonlinearity of a
    deflection of 0.03 L; nothing is heard at the node, which the paper gives."""
    at_tip, node, at_node = lesson.numbers
    assert at_tip == pytest.approx(100 * (3.516015 / 22.0344916) ** 2, rel=0.01)
    assert node == lesson.answer == pytest.approx(0.783445, abs=1e-6)
    assert at_node < 0.005 * at_tip


def test_unknown_mass(lesson):
    """The measured frequencies are those of the hidden mass, in their four digits; the first two
    are those of the other mass, too, whose others are not. Only both numbers meet the challenge."""
    mass, place, other_mass, other_place = lesson.numbers
    text = [float(number) for number in re.findall(r"\d+\.\d+", lesson.do)]
    assert sorted(MEASURED.values()) == sorted(text)
    for beam in (HIDDEN, Beam(alpha=mass, beta=place)):
        found = sorted(truth(beam, 5).frequencies)
        assert found == pytest.approx(sorted(MEASURED.values()), rel=1e-3)
    other = sorted(truth(Beam(alpha=other_mass, beta=other_place), 5).frequencies)
    assert other[:2] == pytest.approx(sorted(MEASURED.values())[:2], rel=1e-3)
    assert abs(other[2] / 49.86 - 1) > 0.01
    assert lesson.check(Beam(alpha=mass, beta=place), lesson.scene.options).met
    assert not lesson.check(Beam(alpha=1.2 * mass, beta=place), lesson.scene.options).met


def test_buckling(lesson):
    """At the speed omega^2 of B1 falls through zero."""
    speed, rest = lesson.numbers
    before, beyond = (truth(INWARD.replace(gamma=speed + step), 1) for step in (-1e-5, 1e-5))
    assert before.squares[0] > 0 > beyond.squares[0]
    assert (speed, rest) == (lesson.answer, pytest.approx(3.516015, abs=1e-6))


def bent_tip(beam: Beam) -> np.ndarray:
    """The tip by the oracle, next to the program's state."""
    state = solve(beam, state="stable").equilibrium

    def guess(x):
        return state.position(x), state.angle(x), state.stretch(x)

    return bent_truth(beam, "green", "spatial", False, 1, guess).tip


def test_folding(lesson):
    """The tip and B1 by the differential equations; beside the clamp at the answer."""
    assert lesson.numbers == pytest.approx((-0.018520, 0.858465, 4.26199), abs=5e-6)
    assert bent_tip(INWARD.replace(gamma=lesson.answer))[0] == pytest.approx(0, abs=1e-8)


def test_lag(lesson):
    """The lag of the tip by the differential equations, 0.3 at the answer."""
    expected = [-bent_tip(Beam(gamma=gamma, spin_up=10))[1] for gamma in (5, 20)]
    assert lesson.numbers == pytest.approx(expected, abs=1e-8)
    assert lesson.numbers[0] == pytest.approx(0.596033, abs=1e-6)
    assert bent_tip(Beam(gamma=lesson.answer, spin_up=10))[1] == pytest.approx(-0.3, abs=1e-8)


def test_stretch_jump(lesson):
    """Stretch on both sides of the mass, by integration from the tip."""
    expected = [100 * (f - 1) for f in stretches(MIDDLE.replace(gamma=10))[1:3]]
    assert lesson.numbers == pytest.approx(expected, rel=1e-6)
    assert stretches(MIDDLE.replace(gamma=lesson.answer))[1] == pytest.approx(1.05, rel=1e-6)


def test_no_equilibrium(lesson):
    """31.4887 at delta 1 and 45.420 at delta 0; green goes on."""
    with_hub, without, root = lesson.numbers
    assert with_hub == lesson.answer == pytest.approx(31.4887, abs=1e-4)
    assert without == pytest.approx(45.420, abs=1e-3)
    assert root == pytest.approx(stretches(ON_A_HUB.replace(gamma=50))[0], rel=1e-6)


def stretches(beam: Beam) -> list[float]:
    """Stretch at the clamp and on both sides of the mass, by the oracle's march from the tip."""
    places = [(piece[2], x) for piece in shoot(beam, "green") for x in piece[:2]]
    N = np.array([solution(x)[1] for solution, x in places])
    return stretch("green", N / beam.mu**2).tolist()


# The challenges


@EACH
def test_only_the_answer_meets_the_challenge(one: Lesson):
    """Within the tolerance, where a step of the slider falls; not beyond it, nor at the start."""
    name, within = one.number, one.within
    low, high, step = RANGES[name].slider if one.of_pull else NUMBERS[name].slider
    values = np.arange(round((high - low) / step) + 1) * step + low
    assert abs(values - one.answer).min() <= within
    for away, met in ((0, True), (0.9, True), (-0.9, True), (1.2, False), (-1.2, False)):
        assert one.check(*case(one, one.answer + away * within)).met is met
    assert not one.check(one.scene.beam, one.scene.options).met


def case(one: Lesson, value: float) -> tuple[Beam, dict[str, Any], float]:
    """The arguments of `check` with a value of the number of the challenge."""
    if one.of_pull:
        return one.scene.beam, one.scene.options, value
    beam = one.scene.beam.replace(**{one.number: value})
    if one.at_most is not None:  # it has a second number, the first of the fact
        beam = beam.replace(alpha=one.numbers[0])
    return beam, one.scene.options, 1.0


@EACH
def test_anything_else_has_to_be_as_in_the_lesson(one: Lesson):
    """Another hub, another slenderness, another law: named, with the value to go back to."""
    beam, options, at = case(one, one.answer)
    mu = f"the slenderness μ back to {beam.mu:g}"
    back = {
        f"strain back to {options['strain']}": one.check(beam, {**options, "strain": "biot"}, at),
        mu: one.check(beam.replace(mu=71), options, at),
    }
    if options["coriolis"]:
        back["Coriolis back to on"] = one.check(beam, {"coriolis": False}, at)
    for words, (met, said) in back.items():
        assert not met
        assert words in said


def test_what_is_free_may_differ():
    """Any mass that is felt, for the node; either plane, where both are compared."""
    nodes, planes = NAMED["nodes"], NAMED["two-planes"]
    beam = nodes.scene.beam.replace(beta=0.785)
    assert nodes.check(beam.replace(alpha=3), {}).met
    met, said = nodes.check(beam.replace(alpha=MIN_MASS / 2), {})
    assert not met
    assert f"{MIN_MASS:g}" in said
    assert planes.check(Beam(gamma=8), {"plane": "flapwise"}).met


@EACH
def test_a_lesson_shows_its_mode_and_says_its_numbers(one: Lesson):
    """The mode to look at exists, every place of the sentence is filled, terms are marked. The
    gauge says something else at the answer than at the start, in finite numbers."""
    assert sum(one.scene.view.shares) == 1
    assert not re.search("[{}]|nan", one.proof)
    assert one.meaning.count("*") in (2, 4)
    cases = case(one, one.answer - 0.5 * one.within), (one.scene.beam, one.scene.options, 1.0)
    said = {one.measured(solve(beam, **options), at) for beam, options, at in cases}
    assert len(said - {UNDEFINED}) == 2


def test_a_gauge_without_a_value_says_so():
    """Where a mode of the challenge is not among those solved, or has no frequency."""
    crossing, nodes = NAMED["crossing"], NAMED["nodes"]
    assert crossing.measured(solve(TIP, modes=2)) == UNDEFINED
    assert nodes.measured(solve(TIP.replace(delta=-1, gamma=20))) == UNDEFINED


def test_lessons_are_listed(run):
    """As a table, and as JSON with everything in it."""
    code, table, _ = run("lessons")
    assert (code, len(NAMED)) == (0, len(LESSONS))
    assert all(one.name in table and one.title in table for one in LESSONS)
    assert max(map(len, table.splitlines())) <= 88
    rows = json.loads(run("lessons", "--format", "json")[1])["lessons"]
    assert [row["name"] for row in rows] == list(NAMED)
    row = rows[list(NAMED).index("veering")]
    assert row["scene"]["model"]["coriolis"] is True
    assert row["scene"]["beam"] == TIP.replace(gamma=2).numbers
    assert row["challenge"]["answers"] == pytest.approx([4.650], abs=1e-3)
    assert "0.241" in row["proof"]["words"]
