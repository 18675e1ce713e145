"""The Solution of a state and of the modes about it, whichever method found them."""

from collections.abc import Callable
from typing import Any, NamedTuple

from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.solver.loads import Curve, Loads
from beamviz.solver.problem import Problem
from beamviz.solver.solution import Equilibrium, Fields, Solution, Stats, read_only
from beamviz.solver.stability import status_of


class SolvedState(NamedTuple):
    """An equilibrium."""

    curve: Curve
    breaks: NDArray  # between which the curve is smooth
    iterations: int
    bent_state: Any = None  # a `SavedState` of `beamviz.solver.bent`
    buckled_chordwise: bool = False


class Vibration(NamedTuple):
    """The modes about an equilibrium."""

    s: NDArray  # (modes,) growth rate + i frequency
    fraction: NDArray  # (modes,) share of the kinetic energy across the beam
    fields: Fields
    estimate_errors: Callable[[], NDArray]  # (modes,) of s^2
    # (modes,) share of it in the plane of rotation; None where the beam bends in one plane
    in_plane_fraction: NDArray | None = None
    all_s: NDArray | None = None  # s of more modes, in which an instability is seen


def build_solution(
    beam: Beam, problem: Problem, state: SolvedState, vibration: Vibration, stats: Stats
) -> Solution:
    """The Solution."""
    s, all_s = vibration.s, vibration.all_s
    return Solution(
        beam=beam,
        problem=problem,
        equilibrium=Equilibrium(
            status=status_of(s if all_s is None else all_s),
            iterations=state.iterations,
            loads=Loads(beam, problem.plane != "flapwise", state.breaks, state.curve),
            bent_state=state.bent_state,
            buckled_chordwise=state.buckled_chordwise,
        ),
        stats=stats,
        s=read_only(s),
        estimate_errors=vibration.estimate_errors,
        bending_energy_fraction=read_only(vibration.fraction),
        fields=vibration.fields,
        in_plane_fraction=vibration.in_plane_fraction,
    )
