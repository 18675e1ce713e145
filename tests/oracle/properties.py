"""Properties along the span, and bodies, for the oracle."""

import numpy as np

from beamviz import Beam


def at(beam: Beam, name: str, x: np.ndarray, inboard: np.ndarray | bool = False) -> np.ndarray:
    """A property at points x; where it jumps, its value toward the tip, or `inboard` the root."""
    x = np.asarray(x, dtype=float)
    if beam.blade is None:
        return np.full_like(x, beam.flap if name == "flap" else 1.0)
    values = np.empty_like(x)
    for segment in beam.blade.segments:
        beyond = np.where(inboard, x > segment.start, x >= segment.start) | (segment.start == 0)
        place = (x - segment.start) / (segment.stop - segment.start)
        values = np.where(beyond, segment.polynomials[name](place), values)
    return values


def ends(beam: Beam) -> list[float]:
    """The ends of what is smooth: clamp, bodies, ends of the segments of a blade, tip."""
    breaks = beam.blade.breaks if beam.blade else ()
    bodies = [body.beta for body in beam.bodies]
    return sorted({0.0, 1.0, *breaks, *bodies})


def reduced(beam: Beam, x: np.ndarray, bending: str) -> np.ndarray:
    """(EI / rho)^(1/4) at x (n,), or the length over which a property changes e times, whichever is
    less, relative to a uniform beam."""
    values = np.array([at(beam, name, x) for name in ("mass", bending, "axial")])
    change = abs(np.diff(np.log(values), axis=1)).max() / (x[1] - x[0])
    waves = (values[1] / values[0]).min() ** 0.25
    return waves, 1 / (change + 1e-30)
