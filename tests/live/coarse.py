"""Coarse charts and short motions, for tests of what is on the page, not of what charts show."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

from beamviz.beam import Beam
from beamviz.errors import NotConverged
from beamviz.explorer import computed_loci, computed_motion, computed_veering
from beamviz.explorer.features import map as map_tab
from beamviz.explorer.features import method_timing, run_up
from beamviz.frequency_loci import forced_response

POSSIBLE: dict[str, Any] = {"strain": "green", "spin_up": 0.0, "method": "auto"}
POSSIBLE |= {"alpha": 1.0, "beta": 0.5, "gamma": 5.0, "delta": 0.25, "mu": 70.0}
POSSIBLE |= {"plane": "chordwise", "softening": True, "stiffening": True, "state": "straight"}


@contextmanager
def coarse_charts() -> Iterator[None]:
    """Context with coarse charts and maps, and short motions."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(computed_loci, "CHART_POINTS", 15)
        patch.setattr(computed_loci, "loci", coarse_loci(computed_loci.loci))
        patch.setattr(computed_veering, "POINTS", 12)
        patch.setattr(map_tab, "SIZE", (9, 5))
        patch.setattr(map_tab, "SMALL_SIZE", (3, 2))
        patch.setattr(run_up, "PER_SECOND", 1e4)
        patch.setattr(run_up, "run_up", short_run_up(run_up.run_up))
        patch.setattr(forced_response, "SPEEDS", 9)
        patch.setattr(method_timing, "REPEATS", 1)
        resolutions = {name: one[:1] for name, one in method_timing.RESOLUTIONS.items()}
        patch.setattr(method_timing, "RESOLUTIONS", resolutions)
        for name in ("motion", "motion_without_stiffening"):
            patch.setattr(computed_motion, name, coarse_motion(getattr(computed_motion, name)))
        yield


def coarse_loci(compute: Callable[..., Any]) -> Callable[..., Any]:
    """A computation of loci; where each solution takes long, in the beginning of the range only."""

    def found(beam: Beam, over: str, values: np.ndarray, **given: Any) -> Any:
        usual = all(given[name] == POSSIBLE[name] for name in ("state", "method"))
        quick = usual and beam.is_uniform and not beam.spin_up and max(beam.gamma, values[-1]) < 40
        return compute(beam, over, values if quick else values[:2], **given)

    return found


def short_run_up(compute: Callable[..., Any]) -> Callable[..., Any]:
    """A computation of run-ups that end early."""
    return lambda beam, per_rev, damping, stop, **given: compute(
        beam, per_rev, damping, min(stop, 4.0), **given
    )


def coarse_motion(compute: Callable[..., Any]) -> Callable[..., Any]:
    """A computation of motions that end early, and of none of a beam that is flung about: that
    takes minutes."""

    def found(beam: Beam, until: float, **given: Any) -> Any:
        if beam.delta < 0 or beam.gamma > 6:
            raise NotConverged("this motion takes too long for a test")
        return compute(beam, until=min(until, 0.3), **given | {"points": 9, "tolerance": 1e-2})

    return found
