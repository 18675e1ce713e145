"""Blades: properties along the span, bodies with inertia, root springs."""

import numpy as np
import pytest

from beamviz import solve, solve_many
from beamviz.beam import Beam
from beamviz.blade import Blade, Mass

TAPER = Blade.tapered(height=0.5)
BODIES = (Mass(1, 0.5), Mass(1, 1))
TURNING = (Mass(1, 1, (0, 0, 0.1)),)


@pytest.mark.parametrize(
    ("beam", "plane", "frequencies"),
    [
        # Ozdemir & Kaya, Meccanica 41 (2006) 661, where published; computed independently.
        (Beam(blade=TAPER), "flapwise", (3.823785, 18.317261, 47.264827, 90.450478)),
        (Beam(gamma=5, blade=TAPER), "flapwise", (6.743398, 21.905324, 50.933802, 94.206348)),
        (Beam(gamma=10, blade=TAPER), "flapwise", (11.50155, 30.182742, 60.563866, 104.611959)),
        (Beam(masses=BODIES), "chordwise", (1.496465, 9.46844, 48.560866)),
        (Beam(masses=TURNING), "chordwise", (1.429626, 6.275326, 24.751604)),
        (Beam(gamma=5, root=0), "flapwise", (5, 19.91966, 54.241931)),
    ],
)
def test_independent_values(beam, plane, frequencies):
    """To their digits; at speed these depend on the strain law in the seventh, (gamma / mu)^2."""
    beam = beam.replace(mu=1e4)
    solution = solve(beam, len(frequencies), plane=plane, tolerance=1e-9)
    assert solution.frequencies == pytest.approx(
        frequencies, rel=2e-7 if beam.gamma else 2e-8, abs=1e-6
    )


def test_blades_are_solved_in_stacks():
    """Many beams of a blade at once, as each alone."""
    jump = Blade((0, 0.4, 0.4, 1), (1, 0.8, 0.5, 0.2), (1, 0.7, 0.3, 0.1), (1, 0.9, 0.6, 0.4))
    beams = [
        Beam(alpha=0.3, beta=0.7, gamma=gamma, delta=0.2, blade=blade, masses=masses, root=root)
        for gamma in np.linspace(0, 20, 9)
        for blade, masses, root in ((jump, BODIES, np.inf), (None, TURNING, 3), (TAPER, (), 0.5))
    ]
    for coriolis in (False, True):
        for beam, solution in zip(beams, solve_many(beams, coriolis=coriolis), strict=True):
            alone = solve(beam, coriolis=coriolis, tolerance=1e-9)
            assert solution.frequencies == pytest.approx(alone.frequencies, rel=1.1e-6)
            assert np.all(
                abs(solution.frequencies - alone.frequencies) <= solution.errors + alone.errors
            )
