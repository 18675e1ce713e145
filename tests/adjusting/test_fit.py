"""Fits of measured frequencies and of targets."""

import pickle

import numpy as np
import pytest
from helpers import slow

from beamviz import Beam, InvalidInput, NoAnswer, adjust, solve

SPEEDS = (0, 6)
NOISE = 1e-3


def measurement(beam, speeds=SPEEDS, modes=3, noise=NOISE, seed=0, **options):
    """Frequencies of a beam with relative normal noise, as a table without labels."""
    random = np.random.default_rng(seed)
    rows = []
    for gamma in speeds:
        for frequency in solve(beam.replace(gamma=gamma), modes, **options).frequencies:
            value = frequency * (1 + noise * random.standard_normal())
            rows.append({"gamma": gamma, "frequency": value, "error": frequency * (noise or 1e-6)})
    return rows


@pytest.mark.parametrize("seed", [1, *slow(2)])
def test_a_beam_is_recovered_from_noisy_frequencies(seed):
    """Within four of its standard deviations, which are those of the noise."""
    truth = {"alpha": 0.8, "beta": 0.63}
    answer = adjust(Beam(), [*truth], measured=measurement(Beam(**truth), seed=seed))
    for name, value in truth.items():
        assert abs(answer.free[name] - value) < 4 * answer.errors[name] < 0.02
    assert answer.beam.alpha == answer.free["alpha"]
    assert answer.undetermined == answer.at_bounds == ()
    assert 0.4 < answer.root_mean_square < 1.6
    assert [match.mode for match in answer.matches] == ["B1", "B2", "B3"] * 2


@pytest.mark.parametrize(
    ("truth", "options"),
    [
        ({"delta": 0.7, "mu": 45.0}, {}),
        ({"root": 8.0}, {}),
        *slow(({"flap": 0.3}, {"plane": "both"}), ({"pitch": 25.0}, {"plane": "both"})),
        ({"delta": 1.1}, {"plane": "flapwise"}),
    ],
)
def test_every_number_may_be_free(truth, options):
    """Without noise its value is found to the accuracy of the solver."""
    modes = 4 if options else 5
    start = Beam(flap=0.5) if options.get("plane") == "both" else Beam()
    measured = measurement(start.replace(**truth), noise=0, modes=modes, **options)
    answer = adjust(start, [*truth], measured=measured, **options)
    if "pitch" in truth:  # either way round
        answer.free["pitch"] = abs(answer.free["pitch"])
    assert answer.free == pytest.approx(truth, rel=1e-3)


@pytest.mark.slow
def test_the_standard_deviations_are_those_of_many_measurements():
    """Of twelve, without the errors told, which are those of the residuals then."""
    values, told = [], []
    for seed in range(12):
        rows = measurement(Beam(alpha=0.8, beta=0.63), speeds=(0, 4), seed=seed)
        columns = {name: [row[name] for row in rows] for name in ("gamma", "frequency")}
        answer = adjust(Beam(alpha=1, beta=0.63), ["alpha"], measured=columns)
        values.append(answer.free["alpha"])
        told.append(answer.errors["alpha"])
    assert np.mean(told) == pytest.approx(np.std(values), rel=0.5)


def test_a_number_that_the_data_do_not_determine_is_told():
    """The position of no mass; two numbers of one frequency."""
    rest = measurement(Beam(), speeds=(0,), noise=0)
    assert adjust(Beam(), ["delta"], measured=rest).undetermined == ("delta",)
    answer = adjust(Beam(), ["alpha", "beta"], measured=measurement(Beam(alpha=1), (0,), 1))
    assert answer.undetermined == ("alpha", "beta")
    assert np.isinf([*answer.errors.values()]).all()
    assert answer.alternatives


def test_values_stay_within_their_bounds():
    measured = measurement(Beam(alpha=2), noise=0)
    answer = adjust(Beam(), {"alpha": (0, 1)}, measured=measured)
    assert answer.free == {"alpha": 1}
    assert answer.at_bounds == ("alpha",)
    assert answer.bounds == {"alpha": (0, 1)}


def test_frequencies_without_a_label_find_their_modes():
    """The fourth is S1 of the beam, which most beams within the bounds have elsewhere in order."""
    truth = Beam(alpha=1.6353, beta=0.1176, delta=1.0555, mu=52.837)
    rows = measurement(truth, (0, 9), modes=4, plane="flapwise")
    answer = adjust(truth.replace(mu=150), ["mu"], measured=rows, plane="flapwise")
    assert answer.free == pytest.approx({"mu": 52.837}, rel=0.01)


def test_labels_decide_where_they_are_given():
    """Two frequencies, of the first and the third mode."""
    B1, _, B3 = solve(Beam(alpha=1, beta=0.7), 3).frequencies
    columns = {"mode": ["B1", "B3"], "frequency": [B1, B3]}
    answer = adjust(Beam(alpha=1), ["beta"], measured=columns)
    assert answer.free["beta"] == pytest.approx(0.7, abs=1e-6)
    assert [match.mode for match in answer.matches] == ["B1", "B3"]


@pytest.mark.parametrize("factor", [{"bending_factor": 0.8}, {"mass_factor": 1.3}])
def test_a_factor_is_recovered_in_si(factor, tmp_path):
    """From a file in Hz and rpm (1/min), with decimal commas; the beam has the size and the speed
    that it had, and the stiffness or the mass that fits."""
    values = {"length": 1.2, "mass_per_length": 4.0, "bending_stiffness": 900.0, "mass": 1.0}
    given = Beam.from_si(**values, axial_stiffness=1e8, rotation_rpm=100)
    name, value = next(iter(factor.items()))
    key = {"bending_factor": "bending_stiffness", "mass_factor": "mass_per_length"}[name]
    changed = {**values, key: values[key] * value}
    lines = ["rpm;frequency", "1/min;Hz"]
    for rpm in (0, 100, 300):
        truth = Beam.from_si(**changed, axial_stiffness=1e8, rotation_rpm=rpm)
        lines += [
            f"{rpm};{f:.9f}".replace(".", ",")
            for f in truth.units.hertz(solve(truth, 2, tolerance=1e-9).frequencies)
        ]
    file = tmp_path / "measured.csv"
    file.write_text("\n".join(lines))
    answer = adjust(given, [name], measured=file)
    expected = Beam.from_si(**changed, axial_stiffness=1e8, rotation_rpm=100)
    assert answer.free[name] == pytest.approx(value, rel=1e-6)
    for number in ("alpha", "gamma", "mu"):
        assert getattr(answer.beam, number) == pytest.approx(getattr(expected, number), rel=1e-6)
    assert answer.beam.units.time == pytest.approx(expected.units.time, rel=1e-6)


def test_numbers_in_a_unit():
    beam = Beam.from_si(length=1.2, mass_per_length=4.0, bending_stiffness=900.0, mass=1.0)
    target = beam.units.hertz(solve(beam.replace(alpha=2 / 4.8)).frequencies[0])
    answer = adjust(beam, {"kg": (0.5, 4)}, targets={"B1": f"{target} Hz"})
    assert answer.free["kg"] == pytest.approx(2, rel=1e-6)


def test_targets():
    answer = adjust(Beam(alpha=1), ["beta"], targets={"B1": 3.0})
    assert solve(answer.beam).frequencies[0] == pytest.approx(3, rel=1e-6)
    assert answer.sensitivities["beta"][0] < 0
    with pytest.raises(NoAnswer, match=r"B1 is 3\.516") as caught:
        adjust(Beam(alpha=1), ["beta"], targets={"B1": 5.0})
    assert caught.value.best.free["beta"] == pytest.approx(0, abs=0.1)
    assert pickle.loads(pickle.dumps(caught.value)).best.free == caught.value.best.free


def test_the_same_call_has_the_same_answer_with_an_error_of_the_data():
    measured = measurement(Beam(alpha=0.8, beta=0.63), speeds=(0, 4))
    first, second = (adjust(Beam(beta=0.63), ["alpha"], measured=measured) for _ in range(2))
    assert first.free == second.free
    assert "alpha=0.799717 ± 0.0026" in repr(first)
    without = {name: [row[name] for row in measured] for name in ("gamma", "frequency")}
    told = adjust(Beam(beta=0.63), ["alpha"], measured=without)
    # The relative noise, 1e-3, times the square root of chi^2 over the degrees of freedom.
    spread = np.sqrt(sum(each.residual**2 for each in first.matches) / (len(measured) - 1))
    assert told.errors["alpha"] == pytest.approx(spread * first.errors["alpha"], rel=0.01)
    assert "<td>alpha</td>" in first._repr_html_()


@pytest.mark.parametrize(
    ("free", "goal", "message"),
    [
        (["alfa"], {"targets": {"B1": 3}}, "did you mean 'alpha'"),
        ([], {"targets": {"B1": 3}}, "0 free numbers"),
        ({"beta": (1, 0)}, {"targets": {"B1": 3}}, "the second must be larger"),
        ({"beta": (0, 2)}, {"targets": {"B1": 3}}, "beta = 2"),
        (["bending_factor"], {"targets": {"B1": 3}}, "SI units"),
        (["rpm"], {"targets": {"B1": 3}}, "SI units"),
        (["beta"], {}, "no goal"),
        (["beta"], {"targets": {"B1": 3}, "clear": 1}, "give one of"),
        (["beta"], {"targets": {"B": 3}}, "must be a label"),
        (["beta"], {"targets": {"F1": 3}}, "in one plane are B and S"),
        (["beta"], {"targets": {"B1": 3}, "plane": "both"}, "in both planes are F, L and S"),
        (["beta"], {"targets": {"B1": -3}}, "above 0"),
        (["beta"], {"targets": {"B1": "3 kg"}}, "must be Hz"),
        (["beta"], {"measured": {"frequenzy": [3]}}, "did you mean 'frequency'"),
        (["beta"], {"measured": {"hertz": [3]}}, "SI units"),
        (["beta"], {"measured": {"frequency": [3, "x"]}}, "row 2, frequency = 'x'"),
        (["beta"], {"measured": {"frequency": [3, 4], "error": [1, None]}}, "or of none"),
        (["gamma"], {"measured": {"frequency": [3], "gamma": [1]}}, "give its values"),
        (["beta"], {"measured": "missing.csv"}, "missing.csv"),
        (["beta"], {"clear": 1, "between": (3, 2)}, "must ascend"),
        (["beta"], {"clear": 1.5, "between": (2, 3)}, "whole number"),
        (["beta"], {"clear": 1}, "two speeds"),
        (["gamma"], {"clear": 1, "between": (2, 3)}, "range of the speed"),
        (["beta"], {"clear": 1, "between": ("200rpm", "300rpm")}, "size of the beam"),
    ],
)
def test_wrong_input_is_named(free, goal, message):
    with pytest.raises(InvalidInput, match=message):
        adjust(Beam(), free, **goal)
