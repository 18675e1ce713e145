"""What a solve returns: equilibrium, modes, errors, and how it was done.

A solution knows its method's degrees of freedom only through functions of x, so nothing
above it needs them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.solver.roots import bisect

BENDING, STRETCHING, MIXED = "bending", "stretching", "mixed"
PURE = 0.9  # share of the kinetic energy that makes a mode one of its family
NODE_GRID = 401
VISIBLE = 1e-7  # share of its amplitude that a mode must reach before it can have a node

Status = Literal["stable", "unstable"]
Axial = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]  # x -> u, f
Displacement = Callable[[np.ndarray], np.ndarray]  # x -> (len(x), 2, modes)


class Model(NamedTuple):
    """What was solved: the method asked for, the beam theory, the plane, the terms kept."""

    method: str
    strain: str
    curvature: str
    coriolis: bool
    plane: str
    stiffening: bool = True
    softening: bool = True


class Stats(NamedTuple):
    """What it took: unknowns solved for (both families), wall time, method, resolution."""

    dof: int
    seconds: float
    method: str
    elements: int
    order: int


@dataclass(frozen=True)
class Equilibrium:
    """The state the modes vibrate about; lengths in units of L, x the reference coordinate."""

    status: Status
    iterations: int
    axial: Axial

    def position(self, x: np.ndarray) -> np.ndarray:
        """Position (len(x), 2) of the points x, measured from the clamp."""
        u, _ = self.axial(_points(x))
        return np.column_stack([u, np.zeros_like(u)])

    def stretch(self, x: np.ndarray) -> np.ndarray:
        """Stretch f = |r'| (len(x),)."""
        return self.axial(_points(x))[1]

    @cached_property
    def tip(self) -> np.ndarray:
        """Position (2,) of the tip."""
        return self.position(np.ones(1))[0]

    @cached_property
    def max_stretch(self) -> float:
        """The largest stretch along the beam."""
        return float(self.stretch(np.linspace(0, 1, NODE_GRID)).max())


@dataclass(frozen=True, eq=False)
class Solution:
    """Equilibrium and modes of one beam; frequencies in units of 1/T*."""

    beam: Beam
    model: Model
    equilibrium: Equilibrium
    stats: Stats
    squares: np.ndarray  # (modes,) omega^2, ascending; negative where unstable
    estimate: Callable[[], np.ndarray]  # -> square_errors; may cost more than the solve
    bending_fractions: np.ndarray  # (modes,) share of the kinetic energy across the beam
    displacement: Displacement

    @cached_property
    def frequencies(self) -> np.ndarray:
        """Frequencies (modes,) in units of 1/T*; nan where unstable."""
        return np.sqrt(np.where(self.squares >= 0, self.squares, np.nan))

    @cached_property
    def growth_rates(self) -> np.ndarray:
        """Growth rates (modes,) in units of 1/T*; 0 where stable."""
        return np.sqrt(np.maximum(-self.squares, 0.0))

    @cached_property
    def square_errors(self) -> np.ndarray:
        """Estimated absolute errors (modes,) of omega^2; infinite where nothing is known."""
        return self.estimate()

    @cached_property
    def errors(self) -> np.ndarray:
        """Estimated absolute errors (modes,) of frequency or growth rate."""
        size = abs(self.squares)
        return self.square_errors / (
            np.sqrt(size) + np.sqrt(np.maximum(size - self.square_errors, 0.0))
        )

    @cached_property
    def families(self) -> tuple[str, ...]:
        """Family of each mode by its share of kinetic energy."""
        return tuple(
            BENDING if share >= PURE else STRETCHING if share <= 1 - PURE else MIXED
            for share in self.bending_fractions
        )

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """B1, S1 ...: counted within the family; a mixed mode counts where its larger share is."""
        letters = ["B" if share >= 0.5 else "S" for share in self.bending_fractions]
        return tuple(f"{a}{letters[: k + 1].count(a)}" for k, a in enumerate(letters))

    def shape(self, k: int, x: np.ndarray) -> np.ndarray:
        """Displacement (len(x), 2) of mode k (from 0) along and across the beam at x in [0, 1].

        Unit modal mass; across means in the plane chordwise, out of it flapwise. Complex with
        Coriolis: the displacement at phase p is the real part of shape * exp(i p).
        """
        if not 0 <= k < len(self.squares):
            raise IndexError(f"mode {k}: this solution has modes 0 .. {len(self.squares) - 1}")
        return self.displacement(_points(x))[:, :, k]

    @cached_property
    def nodes(self) -> tuple[np.ndarray, ...]:
        """Vibration nodes of each mode: where its larger component is always zero."""
        return tuple(self._nodes(k) for k in range(len(self.squares)))

    def _nodes(self, k: int) -> np.ndarray:
        column = int(self.bending_fractions[k] >= 0.5)

        def component(x: np.ndarray) -> np.ndarray:
            values = self.shape(k, x)[:, column]
            return values.imag if np.iscomplexobj(values) and column else values.real

        x = _node_grid(self.beam.beta)
        values = component(x)
        seen = np.maximum.accumulate(abs(values)) > VISIBLE * abs(values).max()
        before = np.flatnonzero(np.diff(np.sign(values)) * seen[:-1])
        return bisect(component, x[before], x[before + 1])


def status(squares: np.ndarray) -> Status:
    """What the lowest omega^2 (modes,), ascending, says of the state."""
    return "stable" if squares[0] >= 0 else "unstable"


def _node_grid(beta: float) -> np.ndarray:
    """Points (k,) in (0, 1], dense where layers may be thin: at the clamp, the mass, the tip."""
    steps = np.geomspace(1e-5, 0.01, 40)
    near = [end + side * steps for end in (0.0, beta, 1.0) for side in (-1, 1)]
    x = np.unique(np.concatenate((np.linspace(0, 1, NODE_GRID), *near)))
    return x[(x > 0) & (x <= 1)]


def _points(x: np.ndarray) -> np.ndarray:
    """x as an array of floats within [0, 1]."""
    x = np.atleast_1d(np.asarray(x, float))
    if x.size and not (x.min() >= 0 and x.max() <= 1):
        raise ValueError(f"x = {x.min():g} .. {x.max():g}: reference points must lie in 0 .. 1")
    return x
