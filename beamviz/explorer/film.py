"""A computed motion in the scene: which moment of it, and the beam drawn then."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from beamviz.beam import Beam, Units
from beamviz.drawing.beam_mesh import DrawnBeam
from beamviz.drawing.motion import MotionShapes
from beamviz.drawing.text import Measure
from beamviz.scene import ViewOptions

PAUSE = 1.5  # [s] on the screen at the end, before it begins again


@dataclass(frozen=True, eq=False)
class Film:
    """A motion to play. shapes: of it; second: of the one without stiffening, drawn beside it;
    rate: the time [T*] per second on the screen that suits it; has_body: whether the mass is on the
    beam at a time."""

    shapes: MotionShapes
    second: MotionShapes | None
    rate: float
    has_body: Callable[[float], bool]

    @property
    def until(self) -> float:
        """The time [T*] at which it ends."""
        return float(self.shapes.motion.t[-1])

    @property
    def diverged(self) -> float | None:
        """The time at which the motion without stiffening has diverged; None where it does not."""
        end = float(self.second.motion.t[-1]) if self.second else self.until
        return end if end < self.until else None

    def advanced(self, moment: float, time: float) -> float:
        """The moment after a time [T*]; after the end it begins again."""
        moment += time
        return moment if moment < self.until + PAUSE * self.rate else 0.0

    def angle(self, moment: float) -> float:
        """The angle of the hub [rad]."""
        return self.shapes.angle(moment)

    def gamma(self, moment: float) -> float:
        """The speed."""
        motion = self.shapes.motion
        return float(np.interp(moment, motion.t, motion.gamma))

    def tip(self, moment: float) -> float:
        """The deflection of the tip [L]."""
        motion = self.shapes.motion
        return float(np.interp(moment, motion.t, motion.tip[:, 1]))


def time_text(time: float | None, units: Units | None) -> str:
    """A time [T*] as the chart shows it; "" for none."""
    return "" if time is None else times(units).text(time, 3)


def times(units: Units | None) -> Measure:
    """The display of times."""
    if units is None:
        return Measure("time t [T*]", "t")
    return Measure("time [s]", "t", "s", units.time)


def drawn(
    shapes: MotionShapes, beam: Beam, view: ViewOptions, scale: float, title: str = ""
) -> DrawnBeam:
    """A motion as a beam to draw: displacements as they are, without nodes of modes."""
    view = view.changed("colouring", "displacement").changed("all_modes", False)
    view = view.changed("nodes", False)
    sampled = replace(shapes.sampled, beam=beam)
    return DrawnBeam(sampled, view, scale, shapes.amplitudes, title=title)
