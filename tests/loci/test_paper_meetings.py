"""Every meeting the paper names (Nonlinear Dynamics 2017, section 4, figures 5-11): mu 70, delta 0.

The values for both curvature measures were computed independently of this project, in the digits
given here. What the paper calls veering are crossings: without Coriolis nothing couples a bending
with a stretching mode.
"""

import numpy as np
import pytest

from beamviz import Beam, loci

GAMMA, ALPHA, BETA = (
    ("gamma", np.linspace(0, 20, 81)),
    ("alpha", np.linspace(0, 2, 81)),
    ("beta", np.linspace(0, 1, 81)),
)
MEETINGS = [  # beam, swept, loci counted by frequency, material, spatial
    (Beam(alpha=1, beta=0.5), GAMMA, (3, 4), ["9.206"], ["9.373"]),
    (Beam(alpha=1, beta=0.8), GAMMA, (3, 4), ["6.662"], ["6.824"]),
    (Beam(alpha=1, beta=0.8), GAMMA, (2, 3), ["17.343"], ["17.589"]),
    (Beam(alpha=1, beta=1), GAMMA, (3, 4), ["4.406"], ["4.464"]),
    (Beam(alpha=1, beta=1), GAMMA, (2, 3), ["16.215"], ["16.319"]),
    (Beam(gamma=0, beta=1), ALPHA, (3, 4), ["1.570"], ["1.570"]),
    (Beam(gamma=5, beta=1), ALPHA, (3, 4), ["0.921"], ["0.929"]),
    (Beam(gamma=10, beta=1), ALPHA, (3, 4), ["0.477"], ["0.485"]),
    (Beam(gamma=10, beta=1), ALPHA, (2, 3), ["1.747"], ["1.758"]),
    (Beam(alpha=0.5, gamma=5), BETA, (4, 5), ["0.0877", "0.2234"], ["0.0872", "0.2242"]),
]


@pytest.mark.parametrize("curvature", ["material", "spatial"])
@pytest.mark.parametrize(("beam", "swept", "counted", "material", "spatial"), MEETINGS)
def test_meeting(beam, swept, counted, material, spatial, curvature):
    """Each printed place, as a crossing of a bending locus with the stretching one."""
    over, values = swept
    events = loci(beam, over, values, curvature=curvature).events
    bending = f"B{counted[0]}"
    found = [event for event in events if set(event.branches) == {bending, "S1"}]
    wanted = material if curvature == "material" else spatial
    assert {event.kind for event in found} == {"crossing"}
    assert {event.gap for event in found} == {0.0}
    for event, digits in zip(found, wanted, strict=True):
        assert event.at == pytest.approx(
            float(digits), abs=0.51 * 10.0 ** -len(digits.split(".")[1])
        )


@pytest.mark.parametrize("curvature", ["material", "spatial"])
def test_no_other_meetings(curvature):
    """The first five loci meet nowhere else in the ranges of the paper's figures."""
    for (beam, (over, values), _, _, _), count in zip(
        MEETINGS, (1, 2, 2, 2, 2, 1, 1, 2, 2, 2), strict=True
    ):
        assert len(loci(beam, over, values, curvature=curvature).events) == count


def test_elements_of_the_paper():
    """Its own 20 cubic elements move its meetings by less than a printed digit."""
    (first, second) = loci(
        Beam(alpha=1, beta=1), "gamma", np.linspace(0, 20, 21), method="ancf"
    ).events
    assert first.at == pytest.approx(4.464, abs=2e-3)
    assert second.at == pytest.approx(16.319, abs=2e-3)


def test_with_coriolis_they_veer():
    """alpha = beta = 1: the crossing at 4.4641 becomes a least gap of 0.241 at gamma 4.650."""
    (event,) = loci(Beam(alpha=1, beta=1), "gamma", np.linspace(0, 8, 81), coriolis=True).events
    assert event.kind == "veering"
    assert event.branches == ("B3", "S1")
    assert event.at == pytest.approx(4.650, abs=5e-4)
    assert event.gap == pytest.approx(0.241, abs=5e-4)
    assert event.index > 0.99
