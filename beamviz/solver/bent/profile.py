"""What a solution keeps of a deflected state: its values at the Gauss points, from which it and its
modes follow as functions of x, and what it can be computed again from. The matrices that it was
found with take a hundred times as much memory, and a chart has hundreds of solutions."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.solver.bent.beam import BentBeam, BentState, corotational_components
from beamviz.solver.problem import Problem
from beamviz.space.elements import Elements
from beamviz.space.grid import Grid


class SavedState(NamedTuple):
    """A state without its matrices; see `BentState`."""

    elements: Elements
    beam: Beam
    problem: Problem
    q: NDArray
    iterations: int

    def restored(self) -> BentState:
        """The state."""
        return BentState(BentBeam(self.elements, self.beam, self.problem), self.q, self.iterations)


def saved(state: BentState) -> SavedState:
    """A state without its matrices."""
    bent = state.beam
    return SavedState(bent.elements, bent.beam, bent.problem, state.q, state.iterations)


class Profile(NamedTuple):
    """A state as a function of x."""

    grid: Grid
    f: NDArray  # (n,)
    kappa: NDArray  # (n,)
    root_angle: float
    gradient: NDArray  # (2, n) r' = f (cos theta, sin theta)


def profile_of(state: BentState) -> Profile:
    """A state as a function of x."""
    gradient = np.stack((state.slope.real, state.slope.imag))
    return Profile(state.beam.grid, state.f, state.kappa, float(state.root_angle), gradient)


def curve(profile: Profile, x: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Position, stretch and angle of a state."""
    grid, from_clamp = profile.grid, profile.grid.from_clamp(x)
    angle = from_clamp @ profile.kappa + profile.root_angle
    return from_clamp @ profile.gradient.T, grid.at(x) @ profile.f, angle


def fields(profile: Profile, moved: NDArray, x: NDArray) -> NDArray:
    """Displacements (len(x), 2, modes) along and across the deflected beam, of their derivatives
    `moved` (2, n, modes) in x and in y (`BentState.gradients`)."""
    from_clamp = profile.grid.from_clamp(x)
    angle = from_clamp @ profile.kappa + profile.root_angle
    dx, dy = from_clamp @ moved
    return corotational_components(dx, dy, angle)
