"""How long a film has to be to end where it began."""

import math
from dataclasses import dataclass

import numpy as np

from beamviz.drawing.modes import fitted_rate
from beamviz.errors import InvalidInput
from beamviz.exports.solved_scene import Moment, Shot

UNSEEN = 0.05  # a motion that is faster or slower by less than this looks the same
LONGEST = 10.0  # [s] of a film, unless one period takes longer
QUARTERS = 4  # of a turn: after one of them the ground looks as it did
ROTATION = "rotation"


@dataclass(frozen=True)
class Loop:
    """A film in which every motion goes through whole cycles.

    seconds: its length; periods: of the first motion; phases (m,) and angle [rad]: how far every
    mode and the hub get; changes: by which part each motion runs faster than it should, so that
    it fits.
    """

    seconds: float
    periods: int
    phases: np.ndarray
    angle: float
    changes: dict[str, float]

    def moment(self, share: float) -> Moment:
        """The scene when a share, 0 .. 1, of the film is over."""
        return Moment(math.pi / 2 + share * self.phases, share * self.angle)

    @property
    def words(self) -> str:
        """What was changed so that the film closes, or ""."""
        parts = [
            f"{name} {'stands still' if part == -1 else f'runs {100 * part:+.1f} %'}"
            for name, part in self.changes.items()
            if abs(part) > 5e-4
        ]
        return f"so that the film closes, {', '.join(parts)}" if parts else ""


def looped(shot: Shot, periods: int | None = None, *, ground: bool = True) -> Loop:
    """The shortest film of whole periods of the first mode shown (or `periods` of them) that the
    other motions nearly fit; they are made to fit. ground: whether it is seen to turn under who
    rides on the hub. Raises InvalidInput where nothing can be filmed.
    """
    motions = moving(shot, ground=ground)
    rates = np.array(list(motions.values()))
    rate = shot.scene.view.pace * fitted_rate(
        shot.shapes.frequencies[shot.shown], shot.scene.beam.gamma
    )
    if rate == 0:
        raise InvalidInput("pace = 0: a film needs a pace above 0")
    period = 2 * math.pi / rates[0]
    n = periods or fitting(rates, max(1, int(LONGEST * rate / period)))
    whole = cycles(rates, n)
    changes = whole / (n * rates / rates[0]) - 1
    turned = dict(zip(motions, 2 * math.pi * whole, strict=True))
    quarters = QUARTERS if shot.scene.view.rotating_frame else 1
    return Loop(
        seconds=float(n * period / rate),
        periods=n,
        phases=np.array([turned.get(label, 0.0) for label in shot.shapes.labels]),
        angle=float(turned.get(ROTATION, 0.0) / quarters),
        changes=dict(zip(motions, changes.tolist(), strict=True)),
    )


def moving(shot: Shot, *, ground: bool) -> dict[str, float]:
    """The angular rate [1/T*] at which each motion looks the same again, by its name."""
    motions = {}
    for k in shot.shown:
        label, frequency = shot.shapes.labels[k], float(shot.shapes.frequencies[k])
        if not math.isfinite(frequency):
            raise InvalidInput(
                f"mode = {k + 1}: {label} does not swing but runs away (the straight beam is"
                " unstable), so there is no period to film; choose another mode"
            )
        if frequency > 0:
            motions[label] = frequency
    view, gamma = shot.scene.view, shot.scene.beam.gamma
    if gamma > 0 and (ground or not view.rotating_frame):
        motions[ROTATION] = gamma * (QUARTERS if view.rotating_frame else 1)
    if not motions:
        raise InvalidInput("nothing moves in this scene: show a mode, or let the beam turn")
    return motions


def fitting(rates: np.ndarray, most: int) -> int:
    """The smallest number of periods of the first of `rates`, up to `most`, that nearly all fit,
    or the one they fit best."""
    tried = np.arange(1, most + 1)
    misfits = [np.abs(cycles(rates, int(n)) / (n * rates / rates[0]) - 1).max() for n in tried]
    good = tried[np.array(misfits) <= UNSEEN]
    return int(good[0] if len(good) else tried[np.argmin(misfits)])


def cycles(rates: np.ndarray, n: int) -> np.ndarray:
    """Whole cycles of every motion during n periods of the first."""
    return np.rint(n * rates / rates[0])
