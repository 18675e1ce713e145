"""Charts: the style they share, figures as the contents of files, and mode shapes."""

import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from numpy.typing import NDArray

from beamviz.beam import NUMBERS
from beamviz.files import check_suffix, replaced
from beamviz.units import ANGLES, SCALES, Units, display_unit, gap_number, place_number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = {"bending": "#0072B2", "stretching": "#D55E00"}  # Okabe & Ito, safe for the colour-blind
KINDS = {"F": ("flap", "#009E73"), "L": ("lag", "#0072B2"), "S": ("stretching", "#D55E00")}
INK, FAINT = "#222222", "#8A8A8A"
STRIPES = "#777777"  # of hatches
SUFFIXES = (".png", ".svg", ".pdf")
DPI = 200
LINES = {"S": "--", "B": "-", "L": "-", "F": "-"}  # of mode shapes, by the kind of their label
STYLE: Any = {
    "font.family": "DejaVu Sans",  # shipped with matplotlib: the same picture on every machine
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": INK,
    "axes.linewidth": 0.8,
    "hatch.linewidth": 0.5,
    "svg.hashsalt": "beamviz",  # the same picture is the same file
}
CENTRED: Any = {"ha": "center", "va": "center"}
OMEGAS = ("ω₁", "ω₂", "ω₃", "ω₄", "ω₅")
RING: dict[str, Any] = {"marker": "o", "ls": "", "ms": 5.5, "mfc": "white", "mec": INK, "mew": 1.1}
QUANTITIES = {"frequency": "frequency"} | {scale.number: scale.quantity for scale in SCALES}
QUANTITIES |= {name: f"{name} of the section" for name in ANGLES}
UNDATED: Any = {"png": None, "svg": {"Date": None}, "pdf": {"CreationDate": None}}


def new_figure(width: float, height: float, **options: Any) -> "Figure":
    """An empty figure of a size [in]; its texts can be measured, so that labels can be placed."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=DPI, **options)
    FigureCanvasAgg(figure)
    return figure


def current_axes() -> "Axes":
    """The axes that a drawing is made on where none are given."""
    from matplotlib import pyplot

    return pyplot.gca()


class PlotAxis(NamedTuple):
    """An axis of a parameter or of the "frequency"."""

    convert: Callable[[Any], Any]  # from dimensionless numbers to the unit
    label: str
    unit: str  # "" without one
    symbol: str  # of the parameter

    def place(self, value: float) -> str:
        """A place on it, as on the page: "γ = 9.3733" or "42.630 rpm"."""
        shown = place_number(self.convert(value))
        return f"{shown} {self.unit}" if self.unit else f"{self.symbol} = {shown}"

    def gap(self, value: float) -> str:
        """A gap between two frequencies: "0.644" or "0.164 Hz"."""
        return f"{gap_number(self.convert(value))} {self.unit}".rstrip()


def axis_of(name: str, units: Units | None) -> PlotAxis:
    """The axis of a parameter or of the "frequency": as on the page, in rpm, kg, mm or m, and Hz
    for a beam in SI."""
    symbol = "ω" if name == "frequency" else NUMBERS[name].symbol
    if display := display_unit(name, units):
        unit, factor = display
        return PlotAxis(lambda value: factor * value, f"{QUANTITIES[name]} [{unit}]", unit, symbol)
    label = "frequency ω [1/T*]" if name == "frequency" else NUMBERS[name].axis_label
    return PlotAxis(lambda value: value, label, "", symbol)


def figure_bytes(figure: "Figure", extension: str) -> bytes:
    """The contents of a PNG, SVG or PDF file of a figure, the same every time."""
    from matplotlib import rc_context

    buffer = io.BytesIO()
    with rc_context(STYLE):
        figure.savefig(buffer, format=extension, dpi=DPI, metadata=UNDATED[extension])
    return buffer.getvalue()


def save_figure(path: Path, figure: "Figure") -> None:
    """Write a figure in the format of the suffix. Raises InvalidInput, Unavailable."""
    extension = check_suffix(path, SUFFIXES)[1:]
    with replaced(path) as part:
        part.write_bytes(figure_bytes(figure, extension))


def picture_files(figure: "Figure", name: str) -> dict[str, bytes]:
    """The contents of a PNG and an SVG file of a figure, by file name."""
    return {f"{name}.{ending}": figure_bytes(figure, ending) for ending in ("png", "svg")}


def plot_shapes(
    x: NDArray,
    shapes: NDArray,
    labels: Sequence[str],
    frequencies: NDArray,
    axes: "Axes | None" = None,
    units: Units | None = None,
) -> "Axes":
    """Draw mode shapes (modes, len(x)), their largest values scaled to 1, in the colours of the
    kinds that their labels name; with frequencies in Hz for a beam in SI."""
    axes = axes or current_axes()
    for shape, label, frequency in zip(shapes, labels, frequencies, strict=True):
        alpha = max(1.2 - 0.2 * int(label[1:]), 0.3)
        colour = KINDS[label[0]][1] if label[0] in KINDS else COLOURS["bending"]
        style: Any = {"color": colour, "ls": LINES[label[0]], "alpha": alpha}
        unit = display_unit("frequency", units)
        text = f"{unit.factor * frequency:.5g} {unit.unit}" if unit else f"ω = {frequency:.5g}"
        axes.plot(x, shape / abs(shape).max(), label=f"{label}  {text}", **style)
    axes.axhline(0, color="0.7", lw=0.8, zorder=0)
    axes.set(xlim=(0, 1), xlabel="reference coordinate x / L", ylabel="displacement (largest = 1)")
    axes.legend(frameon=False, fontsize=8, loc="upper left")
    return axes
