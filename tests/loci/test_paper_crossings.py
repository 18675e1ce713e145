"""The crossings of the paper (Nonlinear Dynamics 2017, section 4, figures 5-11): mu 70, delta 0.

The values for both curvature measures were computed independently of this project, in the digits
given here. The paper calls them veerings, but they are crossings: without Coriolis forces bending
and stretching modes are uncoupled.
"""

import numpy as np
import pytest

from beamviz import Beam, loci

TIP = Beam(alpha=1, beta=1)
STOP = {"gamma": 20, "alpha": 2, "beta": 1}
CROSSINGS = [  # beam, swept, for each crossing: bending branch, by material, by spatial curvature
    (Beam(alpha=1, beta=0.5), "gamma", [("B3", "9.206", "9.373")]),
    (Beam(alpha=1, beta=0.8), "gamma", [("B3", "6.662", "6.824"), ("B2", "17.343", "17.589")]),
    (TIP, "gamma", [("B3", "4.406", "4.464"), ("B2", "16.215", "16.319")]),
    (Beam(), "alpha", [("B3", "1.570", "1.570")]),
    (Beam(gamma=5), "alpha", [("B3", "0.921", "0.929")]),
    (Beam(gamma=10), "alpha", [("B3", "0.477", "0.485"), ("B2", "1.747", "1.758")]),
    (
        Beam(alpha=0.5, gamma=5),
        "beta",
        [("B4", "0.0877", "0.0872"), ("B4", "0.2234", "0.2242")],
    ),
]


@pytest.mark.parametrize(("column", "curvature"), [(1, "material"), (2, "spatial")])
@pytest.mark.parametrize(("beam", "over", "expected"), CROSSINGS)
def test_crossings(beam, over, expected, column, curvature):
    """Each printed crossing of a bending locus with the stretching one, and no other event."""
    values = np.linspace(0, STOP[over], 81)
    events = loci(beam, over, values, curvature=curvature).events
    for event, row in zip(events, expected, strict=True):
        assert (event.kind, set(event.branches), event.gap) == ("crossing", {row[0], "S1"}, 0)
        digits = len(row[column].split(".")[1])
        assert event.at == pytest.approx(float(row[column]), abs=0.51 * 10.0**-digits)


def test_elements_of_the_paper():
    """Its own 20 cubic elements move its crossings by less than a printed digit."""
    events = loci(TIP, "gamma", np.linspace(0, 20, 21), method="ancf").events
    assert [event.at for event in events] == pytest.approx([4.464, 16.319], abs=2e-3)


def test_with_coriolis_they_veer():
    """alpha = beta = 1: the crossing at 4.4641 becomes a least gap of 0.241 at gamma 4.650."""
    (event,) = loci(TIP, "gamma", np.linspace(0, 8, 81), coriolis=True).events
    assert (event.kind, event.branches) == ("veering", ("B3", "S1"))
    assert (event.at, event.gap) == pytest.approx((4.650, 0.241), abs=5e-4)
    assert event.index > 0.99
