"""The tab of the run-up: the force, its chart of amplitudes, and the resonances on the way."""

import threading

import numpy as np
from viser import GuiApi, uplot

from beamviz.display_units import Measure, frequencies, measure
from beamviz.explorer.features.loci_chart import PER_REV
from beamviz.explorer.features.run_up import Ride, Run
from beamviz.explorer.page.html import SMALL, table
from beamviz.explorer.page.inputs import Listener, heard
from beamviz.explorer.page.plot_style import COLOURS, LINE, MARK, add_plot, axes, dot
from beamviz.frequency_loci.forced_response import DAMPING, RunUp

HEIGHT = 190  # [px]
STYLES: tuple[uplot.Series, ...] = (
    {},
    {"stroke": COLOURS["bending"], "width": 2, **LINE},
    {"stroke": MARK, "width": 0, "points": dot("#ffffff", MARK, 7)},
    {"stroke": MARK, "width": 0, "points": dot("#D55E00", "#ffffff", 11)},
)
TIP = "tip, times at rest"
OFTEN = {f"{k} × per turn": k for k in PER_REV}
MOST = 1.5  # times the largest amplitude: the end of the axis
LEAST = 1e-4  # of the largest amplitude: what is smaller is below the axis
NOTE = (
    "A force acts on every gram of the beam, like its weight on a beam turning in a vertical plane;"
    " it comes back so often in each turn. The curve is the steady linear response of the tip at"
    " each speed, as if held until it has settled, every mode damped by the same ratio;"
    " 1 is the deflection at rest under the same force. In the picture small ones are enlarged"
    " (square root), and time slows near a resonance."
)


class RideTab:
    """Hands on the force and shows the run."""

    def __init__(self, gui: GuiApi, lock: threading.RLock, listener: Listener):
        ride = listener.ride
        force = gui.add_dropdown("force comes", tuple(OFTEN), hint="Along which line kγ to ride")
        heard(force, lock, lambda label: ride.choose(OFTEN.get(label, 0)))
        damping = gui.add_slider(
            "damping ζ [%]",
            100 * DAMPING[0],
            100 * DAMPING[1],
            0.1,
            100 * ride.damping,
            hint="Damping ratio of every mode: at 100 % a beam let go would just not swing",
        )
        heard(damping, lock, lambda value: ride.damp(percent(value)))
        self.button = gui.add_button("Run up from rest")
        self.button.on_click(lambda _: listener.run_up())
        nothing = (np.array([0.0, 1.0]), np.ones(2), np.ones(2), np.ones(2))
        self.plot = add_plot(gui, nothing, STYLES, plain_axes(""), HEIGHT, visible=False)
        self.table = gui.add_html(f'<div style="{SMALL}">{NOTE}</div>')
        self.known: RunUp | None = None

    def show(self, ride: Ride, gamma: float) -> None:
        """Show the run, with the beam of the scene at its speed gamma on it."""
        self.button.label = "Stop" if ride.riding else "Run up from rest"
        run = ride.run
        self.plot.visible = run is not None
        if run is None:
            self.known = None
            self.table.content = words(ride.found)
            return
        along = measure("gamma", run.beam.units)
        if run is not self.known:
            self.known = run
            self.plot.axes = plain_axes(along.label)
            self.plot.scales = scales(run, along)
            self.table.content = met(run, along) + f'<div style="{SMALL}">{NOTE}</div>'
        self.plot.data = series(run, along, gamma)


def plain_axes(label: str) -> tuple[uplot.Axis, ...]:
    """The axes; a logarithmic one would have nine lines to each power of ten."""
    x, y = axes(label, TIP)
    return x, {**y, "grid": {"show": False}, "ticks": {"show": False}}


def percent(value: object) -> object:
    """A per cent as a share; what is no number stays what it is."""
    return value / 100 if isinstance(value, int | float) else value


def words(found: Run | None) -> str:
    """Why there is no run, or what one is."""
    return f'<div role="note" style="{SMALL}">{found.words if found else NOTE}</div>'


def scales(run: RunUp, along: Measure) -> dict[str, uplot.Scale]:
    """The ends of both axes; amplitudes on a logarithmic one."""
    known = run.amplitudes[np.isfinite(run.amplitudes)]
    low, high = (float(known.min()), float(known.max())) if known.size else (1.0, 1.0)
    ends = max(low, LEAST * high) / MOST, MOST * high
    return {
        "x": {"time": False, "range": (0.0, along.factor * float(run.speeds[-1]))},
        "y": {"distr": 3, "range": ends},
    }


def series(run: RunUp, along: Measure, gamma: float) -> tuple[np.ndarray, ...]:
    """Speeds, amplitudes, the marks of the resonances, and the mark of the beam."""
    here = float(np.interp(gamma, run.speeds, run.amplitudes))
    x = np.append(run.speeds, gamma)
    order = np.argsort(x, kind="stable")
    amplitudes = np.append(run.amplitudes, here)
    peaks, mark = np.full(len(x), np.nan), np.full(len(x), np.nan)
    for one in run.resonances:
        peaks[np.argmin(abs(run.speeds - one.at))] = run.peak(one)
    if gamma <= run.speeds[-1] * (1 + 1e-9):
        mark[-1] = here
    else:
        order = order[:-1]
    return (along.factor * x[order], amplitudes[order], peaks[order], mark[order])


def met(run: RunUp, along: Measure) -> str:
    """The resonances on the way."""
    if not run.resonances:
        return f'<div style="{SMALL}">No mode is met on this line up to here.</div>'
    across = frequencies(run.beam.units)
    heads = ("mode", f"at {along.head}", across.label, "tip moves")
    rows = [
        (
            f"<b>{one.branch}</b>",
            along.number(one.at, 4),
            across.number(one.frequency, 3),
            f"{run.peak(one):.3g} ×",
        )
        for one in run.resonances
    ]
    return table("run-up", heads, rows)
