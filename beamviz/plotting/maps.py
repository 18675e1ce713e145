"""A sweep as a picture: one frequency, or the smallest gap, over two of its parameters."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import patheffects, rc_context
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, LogNorm, Normalize
from matplotlib.patches import Patch

from beamviz.beam import NUMBERS, PARAMETERS, Beam
from beamviz.errors import InvalidInput
from beamviz.plotting import INK, STRIPES, STYLE, axis_of, current_axes, new_figure, save_figure
from beamviz.plotting.labels import LabelPlacer
from beamviz.solver.problem import Problem, options_in
from beamviz.sweeps.arrays import SOLVED, STATUSES
from beamviz.sweeps.plan import find_place
from beamviz.sweeps.quantities import Quantity, frequency_of, smallest_gap
from beamviz.sweeps.store import chunks_read, damaged_chunk
from beamviz.units import Units, display_unit, number_of

if TYPE_CHECKING:
    import xarray

SIZE = (7.0, 5.0)  # [in]
NOT_STABLE = {  # by status: hatch of beams, and their colour where they have no number
    "not computed": ("....", "#FFFFFF"),
    "divergence": ("\\\\\\", "#E4E4E4"),
    "no equilibrium": ("////", "#C8C8C8"),
    "not converged": ("xxxx", "#A0A0A0"),
    "flutter": ("||||", "#E4E4E4"),
    "buckled chordwise": ("----", "#E4E4E4"),
}
DECADES = 1e-4  # of the largest gap: colours end there
HALO = [patheffects.withStroke(linewidth=3.0, foreground="white")]


def save_map(path: Path, dataset: "xarray.Dataset", over: Sequence[str], **options: Any) -> None:
    """Write a map in the format of the suffix; see `draw_map`. Raises Unavailable, too."""
    with rc_context(STYLE):
        figure = new_figure(*SIZE, layout="constrained")
        draw_map(dataset, over, ax=figure.add_subplot(), **options)
    save_figure(path, figure)


def draw_map(
    dataset: "xarray.Dataset",
    over: Sequence[str] = (),
    *,
    mode: int | None = None,
    gap: bool = False,
    at: Mapping[str, float] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw a frequency over two parameters of a sweep, and return the axes.

    dataset: of `sweep`. over: the parameters of the horizontal and the vertical axis, by default
    those of a sweep over two. mode: whose frequency (1 is the lowest), or gap=True: the smallest
    gap between neighbouring frequencies.
    at: values of the other axes of the sweep, which may be left out where an axis has one value.
    ax: where to draw, by default the current axes.

    Parts where the family of the mode, or the modes of the gap, change are separated by lines and
    named. Beams that are not stable are hatched by their status, and grey where they have no
    number. Frequencies are in Hz and speeds in rpm for a sweep of a beam in SI. Raises
    InvalidInput, and Unavailable for a damaged store.
    """
    if (mode is None) != gap:
        raise InvalidInput("a map is either of one mode or, with gap, of the smallest gap")
    axes = {str(name): dataset[name].values for name in dataset["status"].dims}
    varied = [name for name, values in axes.items() if len(values) > 1]
    over = [*map(number_of, over)] or (varied if len(varied) == 2 else ())
    if len(over) != 2 or over[0] == over[1]:
        raise InvalidInput(
            f"over {','.join(over) or '(nothing)'}: must be two axes of the sweep, which is over"
            f" {', '.join(axes)}, with a comma between"
        )
    units = Units.from_attributes(dataset.attrs)
    place = find_place(axes, over, at or {}, units)
    source = dataset.encoding.get("source", "the sweep")
    with chunks_read(source):
        part = dataset.isel(place).transpose(over[1], over[0], "mode").load()
    frequency, family, status = (part[name].values for name in ("frequency", "family", "status"))
    if ((np.isnan(frequency[..., 0]) | (family[..., 0] < 0)) & (status == SOLVED)).any():
        raise damaged_chunk(source, "a stable beam has no frequency")
    modes = frequency, family, status
    shown = smallest_gap(*modes) if mode is None else frequency_of(mode, *modes)
    what, values = shown.name, shown.values
    if not np.isfinite(values).any():
        met = ", ".join(STATUSES[code] for code in np.unique(status))
        raise InvalidInput(f"there is no {what} to draw here; the beams are: {met}")
    ax = ax or current_axes()
    along, up = (axis_of(name, units) for name in over)
    x, y = along.convert(axes[over[0]]), up.convert(axes[over[1]])
    unit = display_unit("frequency", units)
    values = unit.factor * values if unit else values
    draw_values(ax, x, y, values, gap, f"{what} [{unit.unit if unit else '1/T*'}]")
    draw_statuses(ax, x, y, status, np.isfinite(values))
    held = {**dataset.attrs, **{name: axes[name][k] for name, k in place.items()}}
    ax.set_title(title(what, over, held), loc="left", fontsize=8)
    ax.set(xlabel=along.label, ylabel=up.label, xlim=x[[0, -1]], ylim=y[[0, -1]])
    name_regions(ax, x, y, shown)
    return ax


def draw_statuses(
    ax: Axes, x: np.ndarray, y: np.ndarray, status: np.ndarray, known: np.ndarray
) -> None:
    """Hatch the beams that are not stable by status, with a legend; grey where none is known."""
    handles = []
    for name, (hatch, colour) in NOT_STABLE.items():
        here = status == STATUSES.index(name)
        if not here.any():
            continue
        empty = here & ~known
        if empty.any():
            grey = np.ma.masked_where(~empty, empty)
            ax.pcolormesh(x, y, grey, cmap=ListedColormap([colour]), rasterized=True)
        stripes = ax.contourf(x, y, here, levels=[0.5, 1.5], colors="none", hatches=[hatch])
        stripes.set(edgecolor=STRIPES, linewidth=0)
        fill = colour if empty.any() else "none"
        handles.append(Patch(facecolor=fill, edgecolor=STRIPES, hatch=hatch, lw=0.5, label=name))
    if handles:
        ax.legend(
            handles=handles,
            loc="upper left",
            bbox_to_anchor=(0, -0.12),
            borderaxespad=0,
            ncols=len(handles),
            frameon=False,
            fontsize=8,
        )


def draw_values(
    ax: Axes, x: np.ndarray, y: np.ndarray, values: np.ndarray, logarithmic: bool, label: str
) -> None:
    """Colours and their bar; lines of equal values at its ticks where they are not logarithmic."""
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    norm, ends = Normalize(low, high), "neither"
    if logarithmic := logarithmic and high > 0:
        least = max(low, DECADES * high)
        norm, ends = LogNorm(least, high, clip=True), "min" if low < least else "neither"
    known = np.ma.masked_invalid(values)
    mesh = ax.pcolormesh(x, y, known, norm=norm, cmap="viridis", rasterized=True)
    figure: Any = ax.get_figure()
    bar = figure.colorbar(mesh, ax=ax, label=label, extend=ends)
    ticks = [tick for tick in bar.get_ticks() if low < tick < high]
    if ticks and not logarithmic:
        ax.contour(x, y, known, levels=ticks, colors="white", linewidths=0.5)


def name_regions(ax: Axes, x: np.ndarray, y: np.ndarray, shown: Quantity) -> None:
    """Lines between regions of different kinds, and the names of the larger of them."""
    for border in shown.borders:
        ax.contour(x, y, border, levels=[0.5], colors=INK, linewidths=0.9)
    placer, style = LabelPlacer(ax), {"color": INK, "fontsize": 7.5, "path_effects": HALO}
    for name, row, column in shown.regions:
        placer.annotate(name, x[column], y[row], inside=True, **style)


def is_given(held: Mapping[str, Any], name: str) -> bool:
    """Whether a number has another value than that by default."""
    default = getattr(Beam, name)
    return bool(held.get(name, default) != default)


def title(what: str, over: Sequence[str], held: Mapping[str, Any]) -> str:
    """The quantity shown, the numbers held fixed, and the model."""
    numbers = ", ".join(
        f"{number.symbol} = {held[name]:.5g}"
        for name, number in NUMBERS.items()
        if name not in over and (name in PARAMETERS or is_given(held, name))
    )
    head = f"{what.capitalize()} at {numbers}".replace("-", "−")
    return f"{head}\n{Problem(**options_in(held)).described}"
