"""Terms left out: the effect of stiffening, softening and Coriolis forces on the frequencies."""

import numpy as np
import pytest

from beamviz.beam import Beam
from beamviz.solver import solve, solve_many

BEAM = Beam(alpha=1, beta=0.5, gamma=10, delta=0.5)
GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(60)


def by_family(solution):
    """Frequencies of bending and of stretching modes."""
    bending = np.array(solution.families) == "bending"
    return solution.frequencies[bending], solution.frequencies[~bending]


def test_without_softening_every_square_is_higher_by_gamma_squared():
    """In the plane of rotation the softening is a multiple of the mass."""
    whole, without = (
        solve(BEAM, modes=6, softening=softening, tolerance=1e-10) for softening in (True, False)
    )
    for a, b in zip(by_family(whole), by_family(without), strict=True):
        np.testing.assert_allclose(b**2, a**2 + BEAM.gamma**2, rtol=1e-9)


def test_out_of_the_plane_only_stretching_softens():
    """Flapwise bending has no softening to leave out."""
    whole, without = (
        solve(BEAM, modes=6, plane="flapwise", softening=softening) for softening in (True, False)
    )
    np.testing.assert_array_equal(by_family(whole)[0], by_family(without)[0])
    assert (by_family(without)[1] > by_family(whole)[1]).all()


def test_without_stiffening_a_slender_beam_softens_only():
    """A beam too stiff to stretch keeps its modes at rest: omega^2 = omega_0^2 - gamma^2, which is
    what zoac says, and falls to zero at gamma = 3.516."""
    rest = solve(Beam(), tolerance=1e-10).frequencies[0]
    turning = Beam(gamma=3, mu=1e4)
    without = solve(turning, stiffening=False, tolerance=1e-10).frequencies[0]
    assert without**2 == pytest.approx(rest**2 - 9, rel=1e-5)
    assert solve(turning, method="zoac").frequencies[0] == pytest.approx(without, rel=1e-5)
    assert solve(Beam(gamma=3.52, mu=1e4), stiffening=False).equilibrium.status == "unstable"


def test_rigid_tension_without_stiffening_is_no_coupling():
    """foac without its tension is zoac."""
    a = solve(BEAM, method="foac", stiffening=False)
    b = solve(BEAM, method="zoac")
    np.testing.assert_array_equal(a.omega_squared, b.omega_squared)


@pytest.mark.parametrize("softening", [True, False])
def test_coriolis_forces_with_and_without_softening(softening):
    """The coupled frequencies are those of the uncoupled modes with the gyroscopic term between
    them, M q" + 2 gamma G q' + K q = 0 in first order."""
    apart = solve(BEAM, modes=20, softening=softening)
    x = (GAUSS + 1) / 4
    x, w = np.append(np.append(x, x + 0.5), 0.5), np.append(np.tile(WEIGHTS / 4, 2), BEAM.alpha)
    u, v = np.moveaxis(apart.displacement(x), 1, 0)
    C = 2 * BEAM.gamma * (v.T @ (w[:, None] * u) - u.T @ (w[:, None] * v))
    n = len(C)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.diag(apart.omega_squared), -C]])
    expected = np.sort(np.linalg.eigvals(A).imag)[n : n + 3]
    coupled = solve(BEAM, modes=3, coriolis=True, softening=softening).frequencies
    np.testing.assert_allclose(coupled, expected, rtol=2e-3)


def test_together_as_apart():
    """A sweep leaves out the same terms."""
    beams = [Beam(alpha=1, gamma=gamma) for gamma in (4.0, 5.0)]
    options = {"stiffening": False, "softening": False}
    for beam, together in zip(beams, solve_many(beams, **options), strict=True):
        alone = solve(beam, **options).frequencies
        np.testing.assert_allclose(together.frequencies, alone, rtol=1e-6)
