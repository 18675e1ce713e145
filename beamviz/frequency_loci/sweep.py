"""Solutions along one parameter of a beam, by family and as mode vectors; ranges of charts."""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from beamviz.beam import MAX_GAMMA_OVER_MU, NUMBERS, Beam, check_float
from beamviz.errors import InvalidInput, NoEquilibrium
from beamviz.frequency_loci.axis import Axis
from beamviz.frequency_loci.mode_vectors import (
    Outcome,
    Points,
    gauss_points,
    kinetic_energies,
    mode_points,
)
from beamviz.solver import Problem, solve_many
from beamviz.solver.hp import CommonMesh
from beamviz.solver.hp.equilibrium import greatest_force
from beamviz.solver.solution import Solution, read_only

EXTRA_MODES = 2  # solved for beyond those requested, as they may become one of the lowest
COUPLED_EXTRA_MODES = 4  # so that the interpolated bending fractions, sums over modes, converge
DESIGNED = 5  # number of beams from which the common mesh of a sweep is designed
MAX_SOLVES = 4000  # of a sweep, to interpolate and to locate crossings

CHART_POINTS = 81
CHART_RANGES = {  # the upper end is doubled until the beam lies in the lower CHART_FILL
    "alpha": (0.0, 2.0),
    "beta": (0.0, 1.0),
    "gamma": (0.0, 20.0),
    "delta": (0.0, 1.0),
    "mu": (10.0, 100.0),
    "spin_up": (0.0, 20.0),
}
CHART_FILL = 0.8  # share of the range, which changes rarely while a slider moves
SI_GAMMA = 5.0  # upper end of gamma for beams in SI units, which rotate slowly


def chart_range(beam: Beam, over: str) -> tuple[float, float]:
    """Lower and upper end of a loci chart of a beam, within the limits of the parameter `over`."""
    (least, most), (low, high) = NUMBERS[over].limits, CHART_RANGES[over]
    if over == "gamma":
        high = SI_GAMMA if beam.units else high
        most = min(most, MAX_GAMMA_OVER_MU * beam.mu)
    if over == "mu":
        least = max(least, beam.gamma / MAX_GAMMA_OVER_MU)
    value = getattr(beam, over)
    while value > CHART_FILL * high and high < most:
        high *= 2
    while value < low and low > least:
        low = 2 * low - (low == 0)
    return max(low, least), min(high, most)


def check_values(argument: str, over: str, values: ArrayLike, least: int, most: int) -> np.ndarray:
    """The values of a parameter as a read-only array (n,); InvalidInput unless they are least ..
    most ascending numbers within its limits. argument: where the parameter was named."""
    if over not in NUMBERS:
        raise InvalidInput(f"{argument} {over!r}: must be one of {', '.join(NUMBERS)}")
    try:
        array = np.atleast_1d(np.array(values, float)) + 0.0  # -0.0 becomes 0.0
    except (TypeError, ValueError, OverflowError):
        raise InvalidInput(f"values of {over}: must be numbers") from None
    if array.ndim != 1 or not least <= len(array) <= most:
        count = len(array) if array.ndim == 1 else f"an array of {array.ndim} dimensions"
        raise InvalidInput(f"values of {over}: must be {least} .. {most} numbers, not {count}")
    for value in array if not np.isfinite(array).all() else array[[0, -1]]:
        check_float(over, float(value), *NUMBERS[over].limits)
    falls = np.flatnonzero(np.diff(array) <= 0)
    if len(falls):
        first, second = array[falls[0] : falls[0] + 2]
        raise InvalidInput(f"values of {over}: must ascend, but {second:g} follows {first:g}")
    return read_only(array)


def frequency_rank(squares: np.ndarray) -> np.ndarray:
    """Index (values, families, k) of each mode by frequency among all, from omega^2; nan last."""
    flat = squares.reshape(len(squares), math.prod(squares.shape[1:]))
    return flat.argsort(axis=1).argsort(axis=1).reshape(squares.shape)


class Spectra(NamedTuple):
    """Modes at values of a parameter by family, bending first; or all as one family."""

    squares: np.ndarray  # (values, families, k) omega^2, ascending; nan where not solved for
    errors: np.ndarray  # (values, families, k) of the solver; nan where not estimated
    bending: np.ndarray  # (values, families, k) bending fraction

    def take(self, index: slice) -> "Spectra":
        """The modes at the values with these indices."""
        return Spectra(*(array[index] for array in self))

    @property
    def rank(self) -> np.ndarray:
        """Index (values, families, k) of each mode by frequency among all."""
        return frequency_rank(self.squares)


@dataclass
class Sweep:
    """A beam with one free parameter, and the outcome at each value solved so far."""

    beam: Beam
    over: str
    problem: Problem
    outcomes: dict[float, Outcome] = field(default_factory=dict)
    has_extra_modes: bool = True  # False where the method has no more
    common_mesh: CommonMesh | None = None

    @property
    def modes(self) -> int:
        """Number of modes requested."""
        return self.problem.modes

    @cached_property
    def straight(self) -> bool:
        """Whether the beam is straight at every value, so that its frequencies are smooth."""
        return self.problem.state == "straight" and self.over != "spin_up" and not self.beam.spin_up

    @cached_property
    def coupled(self) -> bool:
        """Whether all modes couple; else the families are independent."""
        moves = self.over == "gamma" or self.beam.gamma > 0
        return not self.straight or (self.problem.gyroscopic and moves)

    @cached_property
    def extra_modes(self) -> int:
        """Number of modes solved for beyond those requested, if the method has them."""
        return COUPLED_EXTRA_MODES if self.coupled else EXTRA_MODES

    @property
    def exhausted(self) -> bool:
        """Whether the search for crossings has used up its solves."""
        return len(self.outcomes) > MAX_SOLVES

    def axis(self, low: float, high: float) -> Axis:
        """A range of the free parameter."""
        beams = tuple(map(self.at, np.linspace(low, high, DESIGNED)))
        if not (self.common_mesh and self.common_mesh.beams == beams):
            self.common_mesh = CommonMesh(beams)
        moment = greatest_force(self.beam, load=1.0)
        return Axis(self.over, low, high, moment, self.beam.gamma, self.coupled)

    def at(self, value: float) -> Beam:
        """The beam with this value of the free parameter."""
        return self.beam.replace(**{self.over: float(value)})

    def solve(self, values: np.ndarray) -> list[Outcome]:
        """Solution, or NoEquilibrium or NotConverged, at each of the values (n,); those not solved
        before are solved in one batch, with extra modes if the method has them."""
        new = np.array(sorted(set(values.tolist()) - self.outcomes.keys()))
        if len(new):
            mesh = self.common_mesh
            digits = mesh.digits if mesh else 0.0
            found = self._solve(new)
            if mesh and mesh.digits > digits and self.outcomes:  # refined: all are solved on it
                new = np.array(sorted([*self.outcomes, *new.tolist()]))
                found = self._solve(new)
            self.outcomes.update(zip(new.tolist(), found, strict=True))
        return [self.outcomes[value] for value in values.tolist()]

    def _solve(self, values: np.ndarray) -> list[Outcome]:
        beams = [self.at(value) for value in values]
        beyond: list[Outcome] = []
        bounded = self.problem.strain != "green" or self.beam.delta < 0
        if self.over == "gamma" and bounded and len(beams) > 1:
            # The error at the highest speed has the limit: speeds beyond it need no solve.
            beyond = self._solve_many(beams[-1:])
            if isinstance(beyond[0], NoEquilibrium):
                beyond *= int((values > beyond[0].limit).sum())
            beams = beams[: len(beams) - len(beyond)]
        return self._solve_many(beams) + beyond

    def _solve_many(self, beams: list[Beam]) -> list[Outcome]:
        options: dict[str, Any] = self.problem.options
        if self.straight and (self.coupled or self.over in ("beta", "mu")):
            options["common_mesh"] = self.common_mesh
        if self.has_extra_modes:
            try:
                return solve_many(beams, extra_modes=self.extra_modes, **options)
            except InvalidInput:
                self.has_extra_modes = False
        return solve_many(beams, **options)

    def spectra(self, values: np.ndarray) -> Spectra:
        """The modes at values (n,), by family unless all couple; nan without a solution."""
        outcomes, count = self.solve(values), self.modes + self.extra_modes
        shape = len(values), 1 if self.coupled else 2, count
        spectra = Spectra(*(np.full(shape, np.nan) for _ in range(3)))
        squares, errors, bending = spectra
        for i, outcome in enumerate(outcomes):
            if not isinstance(outcome, Solution):
                continue
            found = None if self.coupled else getattr(outcome.fields, "families", None)
            if found:
                k = min(found[0].shape[1], count)
                squares[i, :, :k], errors[i, :, :k] = (one[:, :k] for one in found)
                continue
            fraction = outcome.bending_energy_fraction
            bends = fraction >= 0.5
            groups: list[Any] = [slice(None)] if self.coupled else [bends, ~bends]
            for f, own in enumerate(groups):
                k = len(fraction[own])
                squares[i, f, :k] = outcome.omega_squared[own]
                bending[i, f, :k] = fraction[own]
                if outcome.stats.method == "hp":  # the estimates of other methods take a solve
                    errors[i, f, :k] = outcome.omega_squared_errors[own]
        if not self.coupled:
            bending[:, 0], bending[:, 1] = 1.0, 0.0
        return spectra

    def ranks(self, values: np.ndarray, family: int, k: int) -> np.ndarray:
        """Indices by frequency (n, 2) of modes k and k + 1 of a family among all."""
        if self.coupled:
            return np.tile([k, k + 1], (len(values), 1))
        return self.spectra(values).rank[:, family, k : k + 2]

    def full_spectra(self, values: np.ndarray) -> np.ndarray | None:
        """omega^2 (n, families, k) of all modes of the discretisation at values (n,), infinite
        beyond the last; None unless known at all values."""
        families = 1 if self.coupled else 2
        fields = [one.fields for one in self.solve(values) if isinstance(one, Solution)]
        found = [getattr(one, "spectrum", None) for one in fields]
        known = [one for one in found if one is not None and len(one) == families]
        if len(known) < len(values):
            return None
        spectra = np.full((len(known), families, max(one.shape[1] for one in known)), np.inf)
        for row, one in zip(spectra, known, strict=True):
            row[:, : one.shape[1]] = one
        return spectra

    def points(self, values: np.ndarray) -> Points:
        """The mode vectors at those values that have a solution; none once exhausted."""
        if self.exhausted:
            values = values[:0]
        return mode_points(values, self.solve(values), self.gauss_points)

    def kinetic_energies(self, values: np.ndarray) -> np.ndarray:
        """The kinetic energies (n, 2, modes) of coupled modes at values (n,) with a solution."""
        solutions = [one for one in self.solve(values) if isinstance(one, Solution)]
        return kinetic_energies(solutions)

    @cached_property
    def gauss_points(self) -> int:
        """Number of Gauss points of the mode vectors, by the values solved first."""
        return gauss_points([one for one in self.outcomes.values() if isinstance(one, Solution)])
