"""Modes about deflected equilibria."""

from beamviz.errors import NotConverged
from beamviz.solver.bent.beam import BentState
from beamviz.solver.pencil import lowest_modes
from beamviz.solver.pencil.matrices import Modes, Pencil


def bent_modes(state: BentState, count: int) -> Modes:
    """The `count` lowest modes about a state. A state without a spin-up has to be stable, which the
    descent to it guarantees. Raises NotConverged where the stiffness of such a state is not
    positive definite."""
    spin_up, C = state.beam.beam.spin_up, state.gyroscopic
    pencil = Pencil(
        K=state.stiffness,
        M=state.inertia,
        C=C,
        F=None if spin_up or C is None else state.factor_of_inertia,
        symmetric=not spin_up,
        softening=state.beam.beam.gamma**2,
    )
    if not spin_up and pencil.factor is None:
        raise NotConverged("the stiffness of a deflected equilibrium is not positive definite")
    return lowest_modes(pencil, count)
