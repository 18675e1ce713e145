"""Cases and charts for tests."""

from functools import cache
from typing import Any

from beamviz.beam import Beam
from beamviz.explorer.computed_loci import Chart, ChartRequest
from beamviz.explorer.state import Case
from beamviz.scene import Scene

TIP = Beam(alpha=1, beta=1, gamma=3)  # S1 crosses B3 at gamma = 4.4641


def case(beam: Beam, **options: Any) -> Case:
    """A beam with the model of a scene and other keywords of `solve`."""
    return Case.of(Scene(beam)).with_options(**options)


@cache
def chart_of(beam: Beam, over: str = "gamma", per_rev: int = 0, **options: Any) -> Chart:
    """The chart around a beam, with resonances up to a multiple of the speed; computed once."""
    return ChartRequest.around(case(beam, **options), over, per_rev).chart()
