"""Charts by interpolation: the number of solves they take, and their error bars."""

import numpy as np
import pytest

from beamviz import Beam, loci, solve_many


@pytest.mark.parametrize(
    ("beam", "over", "stop", "modes", "coriolis", "most"),
    [
        *(
            (Beam(alpha=alpha, gamma=gamma), "beta", 1, modes, False, 100)
            for alpha, gamma in ((0.38, 12), (1, 5), (3, 0))
            for modes in (3, 5)  # of odd and even orders of the interpolation
        ),
        (Beam(alpha=0.5, gamma=5), "beta", 1, 15, False, 150),  # many half-waves in an element
        # a beam misses the tolerance on the common mesh, which is refined for all
        (Beam(alpha=1, gamma=10, mu=50), "beta", 1, 15, False, 200),
        (Beam(alpha=2.3, beta=0.38, delta=0.15, mu=180), "gamma", 20, 4, True, 100),
        # stretching converges first
        (Beam(alpha=1.8, gamma=10.4, delta=0.2, mu=183), "beta", 1, 10, False, 150),
        (Beam(alpha=8, gamma=2.5, delta=0.8, mu=42), "beta", 1, 3, True, 100),  # bending fractions
        (Beam(alpha=9, gamma=2.5, delta=0.5, mu=77), "beta", 1, 4, True, 150),
        (Beam(alpha=5, gamma=20), "beta", 1, 6, False, 120),  # a layer in an element of its own
        (Beam(alpha=1, gamma=2, delta=-0.5), "beta", 1, 6, True, 120),  # unstable, with Coriolis
        (Beam(alpha=5, beta=0.5, gamma=30, delta=-0.5), "alpha", 8, 6, True, 120),
        (Beam(alpha=1, beta=0.5, delta=1), "gamma", 150, 6, False, 130),  # omega^2 grows by 1000
        (Beam(alpha=1, beta=0.5, gamma=10), "mu", 200, 6, True, 50),  # with four veerings
        (Beam(alpha=1, gamma=3, mu=1000), "beta", 1, 20, False, 400),
        (Beam(alpha=1, gamma=3, mu=1000), "beta", 1, 6, False, 100),  # without a crossing
    ],
)
def test_few_solves(beam, over, stop, modes, coriolis, most):
    """Over the place of the mass a characteristic function replaces loci that all veer, with
    hundreds of solves fewer. All beams of a chart have meshes of the same orders, and rounding
    takes no solves."""
    start = 10 if over == "mu" else 0
    found = loci(beam, over, np.linspace(start, stop, 11), modes, coriolis=coriolis)
    assert found.solves < most


@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize(
    ("over", "stop", "most"), [("gamma", 30, 17), ("alpha", 5, 17), ("mu", 200, 25)]
)
def test_a_short_axis_takes_few_solves(over, stop, most, coriolis):
    """The first order is that of its length."""
    beam, start = Beam(alpha=1, gamma=5), 10 if over == "mu" else 0
    values = np.linspace(start + 0.6 * (stop - start), stop, 9)
    found = loci(beam, over, values, 4, coriolis=coriolis)
    assert found.solves - 4 * len(found.events) < most


@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize("method", ["ancf", "assumed-modes", "linear"])
def test_other_methods_take_few_solves_too(method, coriolis):
    """All eigenvalues of their matrices are known, as those of the default method are."""
    beam, options = Beam(alpha=1, beta=0.5, gamma=8), {"method": method, "coriolis": coriolis}
    found = loci(beam, "mu", np.linspace(20, 100, 9), **options)
    assert found.solves < 50
    exact = solve_many([beam.replace(mu=mu) for mu in found.values.tolist()], **options)
    frequencies = np.sort([branch.frequency for branch in found.branches], axis=0)[:5]
    assert pytest.approx(np.array([one.frequencies for one in exact]), rel=1e-6) == frequencies.T


@pytest.mark.parametrize(
    ("beam", "over", "stop", "modes", "most"),
    [
        (Beam(alpha=0.7, beta=0.6, gamma=3), "mu", 100, 20, 0.03),
        (Beam(alpha=1, beta=0.5, gamma=10), "mu", 200, 6, 2e-3),
        (Beam(alpha=1), "gamma", 20, 6, 2e-3),
    ],
)
def test_bending_fractions_of_mixtures(beam, over, stop, modes, most):
    """With Coriolis forces they change between 0 and 1 at veerings; of many modes less exact."""
    found = loci(beam, over, np.linspace(10, stop, 41), modes, coriolis=True)
    beams = [beam.replace(**{over: value}) for value in found.values.tolist()]
    exact = solve_many(beams, modes=modes, coriolis=True)
    fractions = np.array([solution.bending_energy_fraction for solution in exact])
    for branch in found.branches:
        there = branch.mode_index >= 0
        own = fractions[there, branch.mode_index[there]]
        assert abs(branch.bending_fraction[there] - own).max() < most


@pytest.mark.parametrize(
    ("beam", "over", "values"),
    [
        (Beam(alpha=7.276, gamma=10.636, mu=44.93), "beta", (0, 1, 0.7358, 0.7395)),
        (Beam(alpha=8.335, beta=0.7118, delta=1.398, mu=127.8), "gamma", (0, 40, 14.06, 14.07)),
    ],
)
def test_three_close_frequencies(beam, over, values):
    """Three roots of the characteristic function between two of its samples are found."""
    start, stop, low, high = values
    inside = np.linspace(low, high, 9)
    found = loci(beam, over, [start, *inside, stop], 8, coriolis=True)
    exact = solve_many([beam.replace(**{over: x}) for x in inside], modes=8, coriolis=True)
    frequencies = np.sort([branch.frequency[1:-1] for branch in found.branches], axis=0)[:8]
    assert pytest.approx(frequencies.T, rel=1e-6) == np.array([one.frequencies for one in exact])


@pytest.mark.parametrize(
    ("beam", "over", "values", "modes", "coriolis"),
    [
        # the last coefficients are small by chance, beside a veering
        (Beam(6.102315685, 1, 0.5, 0, 175.5022314), "beta", [0, 0.66612, 1], 12, False),
        # every other error is smaller than that of the end of the iteration for roots
        (Beam(7.631887987, 1, 0.5, -0.0193525956, 38.45935017), "beta", [0, 0.16616, 1], 10, False),
        # extra modes are less accurate
        (Beam(alpha=1, gamma=5), "gamma", np.linspace(0, 10, 21), 6, True),
        (Beam(alpha=1, gamma=5), "beta", np.linspace(0, 1, 21), 6, True),
        (Beam(alpha=0.1, delta=0.8, mu=51), "gamma", np.linspace(0, 20, 21), 6, True),
        (Beam(2.9, 0.8, delta=1.1, mu=23), "gamma", np.linspace(0, 19, 21), 6, True),
        (Beam(0.2, 0.7, 11, mu=118), "delta", np.linspace(0, 2, 21), 6, True),
    ],
)
def test_error_bars_hold_and_meet_the_tolerance(beam, over, values, modes, coriolis):
    """They contain the errors of truncation, of roots and of the modes solved for."""
    found = loci(beam, over, values, modes, coriolis=coriolis)
    beams = [beam.replace(**{over: value}) for value in found.values.tolist()]
    exact = solve_many(beams, modes=modes, coriolis=coriolis, tolerance=1e-10)
    frequencies, errors = (
        np.array([getattr(one, key) for one in exact]) for key in ("frequencies", "errors")
    )
    for branch in found.branches:
        at = np.flatnonzero((branch.mode_index >= 0) & (branch.mode_index < modes))
        index = at, branch.mode_index[at]
        off = abs(branch.frequency[at] - frequencies[index])
        assert (off <= branch.error[at] + errors[index]).all(), branch.label
        assert (branch.error[at] <= 1.1e-6 * branch.frequency[at]).all()
