"""Two loci around their crossing or veering, without a coupling and with a part of it, as
background jobs compute them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np

from beamviz.beam import Beam
from beamviz.drawing.text import significant
from beamviz.explorer.computed_loci import PLANES, ChartRequest, LocusLine, lines_of
from beamviz.frequency_loci import Branch, Event, Loci, at_values, loci
from beamviz.frequency_loci.identity import identify_modes
from beamviz.solver.problem import MAX_MODES, OPTIONS
from beamviz.solver.solution import BENDING, STRETCHING

POINTS = 40  # of a sweep; even, so that the middle is not one of them
REACH = 0.2  # of the chart's range, to each side: for the search of an event, and the widest view
MIN_WIDTH = 0.004  # of the chart's range: half width of the narrowest view
WIDE_PITCH = 5.0  # [deg] of the view of flap and lag
MARGIN = 4.0  # half width of the view, over that of a veering
BESIDE = 1e-3  # of the view: offset of shapes from a crossing, where they are not unique
X = np.linspace(0.0, 1.0, 61)
EXCHANGED, KEPT = 0.5, 0.1  # change of the bending fraction: exchange above, none below


class ModeShape(NamedTuple):
    """A mode: displacements along and across the beam at X, (61, 2) or in both planes (61, 3), the
    largest 1; fraction of bending energy; name, or the mixture that it is; fraction of the energy
    in the plane of rotation where it bends in both; its index in the order of frequencies, -1 for
    none."""

    displacement: np.ndarray
    bending_fraction: float
    name: str
    in_plane_fraction: float = 1.0
    mode: int = -1

    def change(self, other: Self) -> float:
        """The greatest change of a fraction to another shape; nan if either has none."""
        bending = abs(other.bending_fraction - self.bending_fraction)
        return max(bending, abs(other.in_plane_fraction - self.in_plane_fraction))


@dataclass(frozen=True, eq=False)
class LociPair:
    """Two loci around their crossing or veering, with a part of their coupling or none.

    coupling: of them, 0 for none; values: (n,) in the view, of the two lines; event: None if the
    two neither cross nor veer; at: its value, else the middle of the view; shapes: of each branch
    before, at and after the event.
    """

    coupling: float
    values: np.ndarray
    lines: list[LocusLine]
    event: Event | None
    at: float
    shapes: tuple[tuple[ModeShape, ModeShape, ModeShape], ...]

    @property
    def places(self) -> tuple[float, float, float]:
        """The values before, at and after the event at which there are shapes."""
        nearest = int(np.argmin(abs(self.values - self.at)))
        first, at, last = self.values[[0, nearest, -1]].tolist()
        return first, at, last

    @property
    def upper_first(self) -> list[int]:
        """The two branches by frequency at the start of the view, the upper one first."""
        return sorted((0, 1), key=lambda k: -float(np.nan_to_num(self.lines[k].frequency[0])))

    @property
    def gap(self) -> tuple[float, float]:
        """The least and the greatest frequency of the two lines where they are closest."""
        k = int(np.argmin(abs(self.values - self.at)))
        low, high = sorted(float(line.frequency[k]) for line in self.lines)
        return low, high


Pairs = tuple[LociPair, ...]  # without the coupling, and with the part that the beam has of it


def uncoupled(chart: ChartRequest) -> ChartRequest:
    """The chart without Coriolis forces, and in both planes without a pitch."""
    beam = chart.beam.replace(pitch=0.0) if chart.options["plane"] == "both" else chart.beam
    return replace(chart, beam=beam, options=chart.options | {"coriolis": False})


@dataclass(frozen=True)
class VeeringRequest:
    """A crossing or veering to magnify. chart: that of the beam; event: of the uncoupled chart."""

    chart: ChartRequest
    event: Event

    @property
    def beam(self) -> Beam:
        return self.chart.beam

    @property
    def kind(self) -> str:
        """What couples the two: "pitch" flap and lag, else "coriolis"."""
        planes = {label[0] for label in self.event.branches} <= set(PLANES)
        return "pitch" if planes and self.chart.options["plane"] == "both" else "coriolis"

    @property
    def couples(self) -> bool:
        """Whether the model has what couples the two."""
        options = self.chart.options
        return self.kind == "pitch" or coriolis_acts(options["plane"], options["method"])

    @property
    def coupling(self) -> float:
        """That of the beam: the pitch [deg], or the factor of the Coriolis forces."""
        return self.beam.pitch if self.kind == "pitch" else float(self.chart.options["coriolis"])

    @property
    def whole(self) -> float:
        """The coupling at which the view has room for the gap."""
        return max(abs(self.beam.pitch), WIDE_PITCH) if self.kind == "pitch" else 1.0

    def coupled(self, coupling: float) -> ChartRequest:
        """The chart of the beam with another coupling."""
        if self.kind == "pitch":
            return replace(self.chart, beam=self.beam.replace(pitch=coupling))
        options = self.chart.options | {"coriolis": OPTIONS["coriolis"].checked(coupling)}
        return replace(self.chart, options=options)

    def pairs(self) -> Pairs:
        """The loci without the coupling and with that of the beam. Raises the errors of `loci`."""
        return self.series([0.0, self.coupling] if self.couples else [0.0])

    def opening(self, steps: int) -> Pairs:
        """The loci without the coupling, and with more of it in equal steps until the whole, or
        that of a beam that has more. Raises the errors of `loci`."""
        most = max(self.coupling, self.whole, key=abs) if self.couples else 0.0
        return self.series(np.linspace(0.0, most, steps + 1).tolist())

    def series(self, couplings: list[float]) -> Pairs:
        """The loci with each coupling, in a view that is the same for all couplings."""
        chart, at = self.chart, self.event.at
        reach = REACH * (chart.stop - chart.start)
        low, high = max(at - reach, chart.start), min(at + reach, chart.stop)
        wide = np.linspace(low, high, POINTS)
        found = {
            coupling: self.loci(wide, coupling)
            for coupling in {*couplings, *([self.whole] if self.couples else [])}
        }
        events = {coupling: same_event(one, self.event, reach) for coupling, one in found.items()}
        centre, half = self.view(events)
        own = [
            event.at + (BESIDE * half if event.kind == "crossing" else 0)
            for coupling in couplings
            if (event := events[coupling])
        ]
        near = np.linspace(max(centre - half, low), min(centre + half, high), POINTS)
        values = np.union1d(near, own)
        return tuple(
            loci_pair(at_values(found[one], values), events[one], self.event, centre, one)
            for one in couplings
        )

    def loci(self, values: np.ndarray, coupling: float) -> Loci:
        """The loci with a coupling, with enough modes for both branches on either side, and for a
        neighbour."""
        modes = min(max(self.event.modes) + 2, MAX_MODES)
        chart = self.coupled(coupling)
        return loci(chart.beam, chart.over, values, **{**chart.options, "modes": modes})

    def view(self, events: Mapping[float, Event | None]) -> tuple[float, float]:
        """Centre and half width of a view of the events by coupling, none and the whole, with room
        for the gap; the widest view where the whole coupling leaves no veering."""
        ends = [event for one in (0.0, self.whole) if (event := events.get(one))]
        places, width = [one.at for one in ends or [self.event]], self.chart.stop - self.chart.start
        centre, half = (min(places) + max(places)) / 2, max(places) - min(places)
        if self.couples and events[self.whole] is None:
            return centre, REACH * width
        half = max(half, MARGIN * max((one.width for one in ends), default=0.0))
        return centre, float(np.clip(half, MIN_WIDTH * width, REACH * width))


def coriolis_acts(plane: str, method: str) -> bool:
    """Whether Coriolis forces couple modes in this plane by this method."""
    return plane != "flapwise" and method in OPTIONS["coriolis"].methods


def same_event(found: Loci, event: Event, reach: float) -> Event | None:
    """The nearest event of the same two branches in other loci, within `reach`."""
    same = [one for one in found.events if {*one.branches} == {*event.branches}]
    nearest = min(same, key=lambda one: abs(one.at - event.at), default=None)
    return nearest if nearest and abs(nearest.at - event.at) <= reach else None


def branches_of(found: Loci, event: Event, at: float) -> tuple[Branch, Branch]:
    """The two branches of an event; the nearest in frequency if the loci have other labels."""
    by_label = {branch.label: branch for branch in found.branches}
    if all(label in by_label for label in event.branches):
        return by_label[event.branches[0]], by_label[event.branches[1]]
    k = int(np.argmin(abs(found.values - at)))
    distance = [abs(branch.frequency[k] - event.frequency) for branch in found.branches]
    first, second = np.argsort(np.nan_to_num(distance, nan=np.inf))[:2]
    return found.branches[first], found.branches[second]


def loci_pair(
    found: Loci, own: Event | None, event: Event, centre: float, coupling: float
) -> LociPair:
    """Two loci with their shapes at the ends of the view and at the event `own`, if any."""
    at = own.at if own else centre
    branches = branches_of(found, own or event, at)
    k = int(np.argmin(abs(found.values - at)))
    shapes = []
    for branch in branches:
        middle = mode_shape(branch, k)
        first, last = (mode_shape(branch, i, middle) for i in (0, -1))
        shapes.append((first, middle, last))
    lines = lines_of(found, found.values, branches)
    return LociPair(coupling, found.values, lines, own, at, tuple(shapes))


def mode_shape(branch: Branch, k: int, other: ModeShape | None = None) -> ModeShape:
    """The shape of a branch at the value of index k, with the sign of positive correlation with
    another shape; nan if it has none.

    With Coriolis forces the phases of axial and transverse motion differ by a quarter of a period:
    the complex shape is real along the beam and imaginary across it, up to a factor.
    """
    solution, mode = branch.solutions[k], int(branch.mode_index[k])
    if solution is None or mode < 0:
        return ModeShape(np.full((len(X), 1), np.nan), np.nan, "")
    shape = solution.shape(mode, X)
    parts = shape.real + shape.imag
    parts /= np.linalg.norm(parts, axis=1).max()
    if other and (parts * other.displacement).sum() < 0:
        parts = -parts
    names = identify_modes(solution)
    name = names.mixtures[mode] or names.labels[mode]
    fraction = float(solution.bending_energy_fraction[mode])
    shares = solution.in_plane_fraction
    in_plane = 1.0 if shares is None else float(shares[mode])
    return ModeShape(parts, fraction, name, in_plane, mode)


def styles_of_components(*, in_space: bool) -> tuple[str, ...]:
    """The styles of the lines of a shape, one for each component of the displacement."""
    return (STRETCHING, "lag", "flap") if in_space else (STRETCHING, BENDING)


# In words


def ends_of(pairs: Pairs) -> tuple[float, float]:
    """The ends of the frequency axis, which a gap in the middle hardly changes."""
    frequency = np.array([line.frequency for pair in pairs for line in pair.lines])
    low, high = np.nanmin(frequency), np.nanmax(frequency)
    margin = 0.06 * (high - low)
    return float(low - margin), float(high + margin)


def outcome(pair: LociPair, request: VeeringRequest) -> str:
    """The kind of the event, its position and the gap, in words."""
    along, across = request.chart.measures
    if pair.event is None:
        return "the gap is too large for a veering."
    at = f"at {along.place(pair.at)}"
    if pair.event.kind == "crossing":
        return f"they cross {at}, uncoupled (gap 0)."
    gap = f"{across.gap(pair.event.gap)} {across.unit}".strip()
    first, _, last = pair.shapes[0]
    change = first.change(last)
    exchange = "they exchange part of their shapes"
    if not change >= KEPT:  # or nan
        exchange = "each keeps its family"
    elif change > EXCHANGED:
        exchange = "they exchange their shapes"
    return f"they veer {at} (gap {gap}); {exchange}."


def coupling_text(coupling: float, request: VeeringRequest) -> str:
    """A coupling in words."""
    if request.kind == "pitch":
        return f"pitch {significant(coupling, 4)}°"
    if not coupling:
        return "without Coriolis forces"
    return "with Coriolis forces" if coupling == 1 else f"{100 * coupling:.3g} % of Coriolis"


def parts_of(shape: ModeShape, request: VeeringRequest) -> dict[str, float]:
    """The shares of a mode, by style: of its kinetic energy in flap and lag where these meet, else
    of its strain energy in bending and stretching."""
    if request.kind == "pitch":
        return {"flap": 1 - shape.in_plane_fraction, "lag": shape.in_plane_fraction}
    return {BENDING: shape.bending_fraction, STRETCHING: 1 - shape.bending_fraction}
