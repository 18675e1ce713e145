"""Solutions along one parameter of a beam, and their mode shapes as mass-weighted vectors."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from beamviz.beam import MAX_GAMMA_OVER_MU, NUMBERS, Beam, check_float
from beamviz.errors import BeamvizError, InvalidInput, NoEquilibrium
from beamviz.frequency_loci.axis import Axis
from beamviz.frequency_loci.spectra import Spectra
from beamviz.solver import (
    DEFAULTS,
    Problem,
    displacements,
    family_spectrum,
    greatest_force,
    mesh_spectrum,
    parse_options,
    solve_many,
)
from beamviz.solver.solution import Solution

# Modes solved for beyond those requested: they may enter and leave the lowest ones, or veer with
# them where all couple.
EXTRA_MODES, EXTRA_COUPLED = 2, 4
DESIGNED = 5  # beams by whose meshes that of all others is designed
MAX_POINTS = 10_000
MAX_SOLVES = 4000  # of a sweep, to interpolate and to locate crossings
GAUSS_POINTS = 16  # of a mode vector, plus two for each mode, and some for a buckled beam

CHART_POINTS = 81
CHART_RANGES = {  # at first; the upper end is doubled until the beam lies in the lower CHART_FILL
    "alpha": (0.0, 2.0),
    "beta": (0.0, 1.0),
    "gamma": (0.0, 20.0),
    "delta": (0.0, 1.0),
    "mu": (10.0, 100.0),
    "spin_up": (0.0, 20.0),
}
CHART_FILL = 0.8  # of the range: it stays the same during most of a drag
SI_GAMMA = 5.0  # upper end for beams in SI units, which rotate slowly

Outcome = Solution | BeamvizError  # of one value
_gauss = lru_cache(maxsize=8)(np.polynomial.legendre.leggauss)


def chart_range(beam: Beam, over: str) -> tuple[float, float]:
    """The ends of the axis of a loci chart around a beam, within the limits of the parameter."""
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


def check_values(over: str, values: ArrayLike) -> np.ndarray:
    """The values of a sweep as an array (n,); InvalidInput unless they are 2 .. MAX_POINTS
    ascending numbers within the limits of the parameter."""
    if over not in NUMBERS:
        raise InvalidInput(f"over = {over!r}: must be one of {', '.join(NUMBERS)}")
    try:
        array = np.array(values, float)
    except (TypeError, ValueError, OverflowError):
        raise InvalidInput(f"values of {over}: must be numbers") from None
    if array.ndim != 1 or not 2 <= len(array) <= MAX_POINTS:
        count = len(array) if array.ndim == 1 else f"an array of {array.ndim} dimensions"
        raise InvalidInput(f"values of {over}: must be 2 .. {MAX_POINTS} numbers, not {count}")
    for value in array if not np.isfinite(array).all() else array[[0, -1]]:
        check_float(over, float(value), *NUMBERS[over].limits)
    falls = np.flatnonzero(np.diff(array) <= 0)
    if len(falls):
        first, second = array[falls[0] : falls[0] + 2]
        raise InvalidInput(f"values of {over}: must ascend, but {second:g} follows {first:g}")
    array.flags.writeable = False
    return array


class Points(NamedTuple):
    """Modes at n ascending values of one parameter, m at each, as vectors: shape_i . dual_j = 1 for
    i = j and 0 otherwise. Shapes and duals are smooth functions of the parameter."""

    at: np.ndarray  # (n,)
    omega_squared: np.ndarray  # (n, m) ascending in each row
    shapes: np.ndarray  # (n, m, d)
    duals: np.ndarray  # (n, m, d)
    kinetic: np.ndarray  # (n, 2, m, m) products across the beam, and in all; none if not gyroscopic

    def take(self, index: np.ndarray | slice) -> "Points":
        """The points of an index."""
        return Points(*(array[index] for array in self))


@dataclass
class Sweep:
    """A beam with one parameter set free, and the outcome of each value solved so far."""

    beam: Beam
    over: str
    modes: int
    options: dict[str, Any]
    outcomes: dict[float, Outcome] = field(default_factory=dict)
    extra_modes: int = 0
    designed: tuple[Beam, ...] = ()  # beams between which all share the orders of a mesh

    def __post_init__(self) -> None:
        self.extra_modes = self.most_modes - self.modes

    @cached_property
    def most_modes(self) -> int:
        """How many modes are solved for, if the method has so many."""
        return self.modes + (EXTRA_COUPLED if self.coupled and self.straight else EXTRA_MODES)

    @cached_property
    def problem(self) -> Problem:
        """What is solved at each value."""
        given = {**DEFAULTS, **self.options, "modes": self.modes}
        known = [given.pop(name) for name in DEFAULTS]
        return parse_options(*known, **given)

    @property
    def tolerance(self) -> float:
        """Relative error of a frequency that is asked for."""
        return self.problem.tolerance

    @cached_property
    def straight(self) -> bool:
        """Whether the beam is straight at every value: its frequencies are smooth then."""
        return self.problem.state == "straight" and self.over != "spin_up" and not self.beam.spin_up

    @cached_property
    def coupled(self) -> bool:
        """Whether all modes couple; else the families are independent."""
        moves = self.over == "gamma" or self.beam.gamma > 0
        return not self.straight or (self.problem.gyroscopic and moves)

    @property
    def exhausted(self) -> bool:
        """Whether the search for crossings has used up its solves."""
        return len(self.outcomes) > MAX_SOLVES

    def axis(self, low: float, high: float) -> Axis:
        """A range of the free parameter."""
        self.designed = tuple(map(self.at, np.linspace(low, high, DESIGNED)))
        return Axis(self.over, low, high, greatest_force(self.beam, load=1.0), self.coupled)

    def at(self, value: float) -> Beam:
        """The beam with this value of the free parameter."""
        return self.beam.replace(**{self.over: float(value)})

    def solve(self, values: np.ndarray) -> list[Outcome]:
        """Solution, or NoEquilibrium or NotConverged, at each of some values (n,); those not known
        yet are solved in one batch, with extra modes if the method has them."""
        new = np.array(sorted(set(values.tolist()) - self.outcomes.keys()))
        if len(new):
            self.outcomes.update(zip(new.tolist(), self._solve(new), strict=True))
        return [self.outcomes[value] for value in values.tolist()]

    def _solve(self, values: np.ndarray) -> list[Outcome]:
        beams = [self.at(value) for value in values]
        beyond: list[Outcome] = []
        bounded = self.options.get("strain", "green") != "green" or self.beam.delta < 0
        if self.over == "gamma" and bounded and len(beams) > 1:
            # The highest speed gives the limit of equilibrium: speeds beyond it need no solve.
            beyond = self._solve_many(beams[-1:])
            if isinstance(beyond[0], NoEquilibrium):
                beyond *= int((values > beyond[0].limit).sum())
            beams = beams[: len(beams) - len(beyond)]
        return self._solve_many(beams) + beyond

    def _solve_many(self, beams: list[Beam]) -> list[Outcome]:
        options = {**self.options, "modes": self.modes}
        if self.straight and (self.coupled or self.over in ("beta", "mu")):
            options["mesh_of"] = self.designed
        try:
            return solve_many(beams, extra_modes=self.extra_modes, **options)
        except InvalidInput:
            if not self.extra_modes:
                raise
        self.extra_modes = 0  # the method has no more than those asked for
        return solve_many(beams, **options)

    def spectra(self, values: np.ndarray) -> Spectra:
        """The modes at some values (n,), by family unless all couple; nan without a solution."""
        outcomes, count = self.solve(values), self.most_modes
        shape = len(values), 1 if self.coupled else 2, count
        spectra = Spectra(*(np.full(shape, np.nan) for _ in range(3)))
        squares, errors, bending = spectra
        for i, outcome in enumerate(outcomes):
            if not isinstance(outcome, Solution):
                continue
            found = None if self.coupled else family_spectrum(outcome)
            if found:
                k = found[0].shape[1]
                squares[i, :, :k], errors[i, :, :k] = found
                continue
            fraction = outcome.bending_energy_fraction
            bends = fraction >= 0.5
            groups = [bends | True] if self.coupled else [bends, ~bends]
            for f, own in enumerate(groups):
                k = len(fraction[own])
                squares[i, f, :k] = outcome.omega_squared[own]
                bending[i, f, :k] = fraction[own]
                if outcome.stats.method == "hp":  # of other methods an estimate costs a solve
                    errors[i, f, :k] = outcome.omega_squared_errors[own]
        if not self.coupled:
            bending[:, 0], bending[:, 1] = 1.0, 0.0
        return spectra

    def mesh_spectra(self, values: np.ndarray) -> np.ndarray | None:
        """omega^2 (n, families, k) of all modes of the meshes at some values, infinite beyond the
        last; None where one is not known."""
        found = [isinstance(one, Solution) and mesh_spectrum(one) for one in self.solve(values)]
        known = [one for one in found if isinstance(one, np.ndarray)]
        if len(known) < len(found):
            return None
        families = 1 if self.coupled else 2
        if any(len(one) != families for one in known):
            return None
        spectra = np.full((len(known), families, max(one.shape[1] for one in known)), np.inf)
        for row, one in zip(spectra, known, strict=True):
            row[:, : one.shape[1]] = one
        return spectra

    def points(self, values: np.ndarray) -> Points:
        """The mode vectors at those of some values that have a solution; none once exhausted."""
        if self.exhausted:
            values = values[:0]
        return mode_points(values, self.solve(values), self.gauss_points)

    @cached_property
    def gauss_points(self) -> int:
        """Length of the mode vectors of the whole sweep, by the values solved first."""
        return gauss_points([one for one in self.outcomes.values() if isinstance(one, Solution)])


def gauss_points(solutions: Sequence[Solution]) -> int:
    """Number of Gauss points that keep the modes of solutions orthogonal.

    A beam under the thrust P that grows at the rate g ~ P / 2 has waves of numbers up to
    k = sqrt(P) = sqrt(2 g). Products of two are waves of number 2 k, which n points integrate from
    n = k / 2 on (they are exact to degree 2 n, and exp(2 i k x) over 0 .. 1 is a polynomial of
    degree k but for what falls off fast): sqrt(g / 2) points.
    """
    growth = math.sqrt(max(-min(solution.omega_squared[0] for solution in solutions), 0.0))
    return GAUSS_POINTS + 2 * len(solutions[0].omega_squared) + math.ceil(math.sqrt(growth / 2))


def mode_points(at: np.ndarray, outcomes: Sequence[Outcome], count: int) -> Points:
    """The modes, equal in number, of the outcomes at values (n,) that are solutions.

    Shapes are taken at `count` Gauss points of the whole beam and at the mass, times the roots of
    the weights and of the mass, so inner products are modal masses.
    """
    solutions = [outcome for outcome in outcomes if isinstance(outcome, Solution)]
    at = at[[isinstance(outcome, Solution) for outcome in outcomes]]
    if not solutions:
        return Points(at, *(np.empty((0, 0, 0, 0)[:d]) for d in (2, 3, 3, 4)))
    squares = np.array([solution.omega_squared for solution in solutions])
    none = np.empty((len(at), 2, 0, 0))
    fields, masses = _fields(solutions, count)
    if solutions[0].problem.state != "straight":
        from beamviz.frequency_loci.complex_modes import orthogonal_vectors

        vectors = fields * np.sqrt(masses)
        return Points(at, squares, *orthogonal_vectors(vectors, solutions), none)
    gamma = np.array([solution.beam.gamma for solution in solutions])
    if np.iscomplexobj(fields) and gamma.any():
        return Points(at, squares, *_gyroscopic(_in_phase(fields, squares), masses, squares, gamma))
    shapes = fields.reshape(*squares.shape, -1)
    return Points(at, squares, shapes, (fields * masses).reshape(shapes.shape), none)


def mass_weighted(solutions: Sequence[Solution], squares: np.ndarray, count: int) -> np.ndarray:
    """u and w (n, m, 2, count + 1) of all modes at Gauss points and at the mass, times the roots of
    weights and masses."""
    fields, masses = _fields(solutions, count)
    if np.iscomplexobj(fields):
        fields = _in_phase(fields, squares)
    return fields * np.sqrt(masses)


def _in_phase(fields: np.ndarray, squares: np.ndarray) -> np.ndarray:
    """u and w of gyroscopic modes: (u, i w) of any phase where stable, (u, w) where not."""
    u, w = fields[:, :, 0], fields[:, :, 1]
    stable = (squares >= 0)[:, :, None]
    return np.stack((u.real + u.imag, np.where(stable, w.imag - w.real, w.real)), axis=2)


def _fields(solutions: Sequence[Solution], count: int) -> tuple[np.ndarray, np.ndarray]:
    """Displacements (n, m, 2, count + 1) of all modes at Gauss points and at the mass, each mode
    with a phase of its own; weights and masses there (n, 1, 1, count + 1)."""
    x, w = _gauss(count)
    alpha, beta = np.array([(one.beam.alpha, one.beam.beta) for one in solutions]).T
    stations, masses = (
        np.column_stack((np.broadcast_to(common, (len(own), count)), own))
        for common, own in (((x + 1) / 2, beta), (w / 2, alpha))
    )
    fields = displacements(solutions, stations)  # (n, count + 1, 2, m)
    return fields.swapaxes(1, 3), masses[:, None, None, :]


def _gyroscopic(
    fields: np.ndarray, masses: np.ndarray, squares: np.ndarray, gamma: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shapes, duals and kinetic energies in the product in which modes of M q" + 2 gamma G q' + K q
    = 0 are orthogonal, (omega_i + omega_j) phi_i* M phi_j - 2 i gamma phi_i* G phi_j.

    It follows from the equation of mode j times phi_i*, less that of mode i times phi_j*. An
    unstable mode is (u, w) in place of (u, i w), its omega the growth rate. It is orthogonal to
    both modes of a pair +-omega: to their sum and to their difference, either half of the product.
    Those are added so that the product does not vanish at the onset of instability.
    """
    omega = np.sqrt(abs(squares))[:, :, None]
    stable = (squares >= 0)[:, :, None]
    u, w = fields[:, :, 0], fields[:, :, 1]
    carried_u, carried_w = np.moveaxis(fields * masses, 2, 0)
    across = (w * carried_w).sum(axis=2, keepdims=True) > (u * carried_u).sum(axis=2, keepdims=True)
    half = np.where(stable | ~across, 1.0, -1.0)
    double, signed = 2 * gamma[:, None, None], np.where(stable, omega, -omega)
    shapes = np.concatenate((omega * u, w, w, half * signed * w, half * u, half * u), axis=2)
    duals = np.concatenate(
        (carried_u, signed * carried_w, -double * carried_u)
        + (half * carried_w, half * omega * carried_u, -half * double * carried_w),
        axis=2,
    )
    norms = (shapes * duals).sum(axis=2, keepdims=True)
    size = np.sqrt(np.maximum(abs(norms), np.finfo(float).tiny))
    u, w, carried_u, carried_w = (part / size for part in (u, w, carried_u, carried_w))
    bending = w @ carried_w.mT
    kinetic = np.stack((bending, bending + u @ carried_u.mT), axis=1)
    return shapes / size, duals / size * np.sign(norms), kinetic
