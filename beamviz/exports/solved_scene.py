"""A scene with its solution, drawn at any moment, and the loop of its film."""

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from beamviz.checks import check_float, check_floats
from beamviz.drawing import BeamScene, camera, stacked_heights
from beamviz.drawing.beam_mesh import DEFAULT_SCALE, DrawnBeam
from beamviz.drawing.comparison import Pair, pair_heights, pair_of
from beamviz.drawing.modes import SampledModes, playback_rate
from beamviz.drawing.scene_graph import DrawnScene
from beamviz.drawing.text import error_text, stability_warning
from beamviz.errors import BeamvizError, InvalidInput
from beamviz.scene import Camera, Scene
from beamviz.solver import solve
from beamviz.solver.solution import Solution

Direction = tuple[float, float, float]
ZOOMS = (0.1, 100.0)
MAX_CHANGE = 0.05  # relative change of a motion's rate that is not noticed
# At the default pace [s]: a loop of several motions is sought up to this length, is played within
# this time, but with no cycle shorter than this.
LOOP_SECONDS, FILM_SECONDS, CYCLE_SECONDS = 10.0, 3.0, 0.4
GROUND_SYMMETRY = 4  # the ground looks the same after a quarter turn
ROTATION = "rotation"
# Two frequencies that are compared and differ by this much stay different in a loop, which is
# sought up to this number of periods for that, and is played within this time [s].
APART, COMPARED_PERIODS, COMPARED_SECONDS = 0.04, 25, 15.0


class Moment(NamedTuple):
    """Phase (m,) [rad] of every mode, the angle [rad] by which the hub has rotated, and the phases
    of the modes of the second beam."""

    phases: np.ndarray
    angle: float
    other_phases: np.ndarray


class DrawableScene(Protocol):
    """What pictures are made of: a solved scene, or a motion in time."""

    @property
    def scene(self) -> Scene: ...
    def camera(self, aspect: float) -> Camera: ...
    def draw(self, scene: DrawnScene, scale: float = ...) -> BeamScene: ...
    def move(self, beams: BeamScene, moment: Any) -> None: ...


class SolvedScene:
    """A scene with its solution; direction, zoom: replace its camera.

    warning: of an unstable equilibrium, else ""; note: of vibrations that grow, else ""; second:
    the solution of the second beam, None without one; second_error: why it has none, else "";
    pair: both as drawn, None where there is one beam in the picture, as beside all modes; heights:
    of the beams drawn, around the middle of the picture; shown: the modes (0-based) in it. Raises
    InvalidInput and the errors of `solve`.
    """

    def __init__(self, scene: Scene, direction: Direction | None = None, zoom: float = 1.0):
        self.scene = scene
        self.direction = None if direction is None else check_direction(direction)
        self.zoom = check_float("zoom", zoom, *ZOOMS)
        self.solution = solve(scene.beam, **scene.solver_options)
        self.shapes = SampledModes.sampled(self.solution)
        growing, text = (
            self.solution.equilibrium.status == "growing",
            stability_warning(self.solution),
        )
        self.warning, self.note = ("", text) if growing else (text, "")
        self.drawn = DrawnBeam(self.shapes, scene.view, warning=self.warning, note=self.note)
        rows = range(len(self.shapes.modes)) if self.drawn.in_rows else []
        self.second, self.second_error = solved_second(scene)
        self.pair = None if rows else self.compared()
        self.heights = stacked_heights(len(rows) or 1)
        if self.pair and scene.second:
            self.drawn = self.pair.first
            self.heights = pair_heights(stacked=scene.second.stacked)
        self.shown = [*rows] or self.drawn.shown

    def compared(self) -> Pair | None:
        """Both beams as drawn; None without a second one, and where that is not stable."""
        given = self.scene.second
        if self.second is None or given is None or stability_warning(self.second):
            return None
        modes = SampledModes.sampled(self.second)
        return pair_of(self.drawn, modes, given.title, stacked=given.stacked)

    def moment(self, phase: float = 0.25) -> Moment:
        """The scene when the first mode shown is at `phase` [periods]; at 0.25 every mode has its
        largest displacement."""
        shown = self.shapes.frequencies[self.shown]
        vibrating = shown[np.isfinite(shown) & (shown > 0)]
        time = (phase - 0.25) * 2 * math.pi / vibrating[0] if len(vibrating) else 0.0
        other = self.pair.second.shapes.frequencies if self.pair else np.zeros(0)
        phases, others = (
            math.pi / 2 + time * np.nan_to_num(rates) for rates in (self.shapes.frequencies, other)
        )
        return Moment(phases, time * self.scene.beam.gamma, others)

    def camera(self, aspect: float) -> Camera:
        """The camera of a picture with width / height = `aspect`."""
        given = self.scene.camera
        if given and not self.direction:
            offset = np.subtract(given.position, given.look_at) / self.zoom
            return Camera((given.look_at + offset).tolist(), given.look_at)
        frame = self.scene.view.rotating_frame
        position = camera.viewpoint(self.shapes, frame, aspect, self.heights, self.direction)
        axial_reach = float(self.drawn.amplitudes @ np.abs(self.shapes.modes[:, :, 0]).max(axis=1))
        return Camera((position * (1 + axial_reach) / self.zoom).tolist())

    def draw(self, scene: DrawnScene, scale: float = DEFAULT_SCALE) -> BeamScene:
        """The beams drawn into a scene, at `scale` [pixels per beam length]."""
        beams = BeamScene(scene)
        second = replace(self.pair.second, scale=scale) if self.pair else None
        stacked = self.scene.second is not None and self.scene.second.stacked
        beams.show(replace(self.drawn, scale=scale), second, stacked=stacked)
        return beams

    def follow(self, loop: "Loop") -> None:
        """Draw the path of the tip in a film, whose rates are not quite the frequencies."""
        self.drawn = replace(self.drawn, rates=loop.phases)
        if self.pair:
            second = replace(self.pair.second, rates=loop.other_phases)
            self.pair = self.pair._replace(second=second)

    def move(self, beams: BeamScene, moment: Moment) -> None:
        """Move the beams drawn to a moment."""
        beams.move(*moment)


def solved_second(scene: Scene) -> tuple[Solution | None, str]:
    """The solution of the second beam, and why there is none: "" where none is asked for."""
    if scene.second is None:
        return None, ""
    other = scene.second_scene
    try:
        return solve(other.beam, **other.solver_options), ""
    except BeamvizError as error:
        return None, error_text(error, other.beam)


def check_direction(direction: Iterable[float]) -> Direction:
    """A direction as three floats, or InvalidInput."""
    numbers = check_floats("direction", direction)
    if len(numbers) != 3 or not any(numbers):
        raise InvalidInput(f"direction = {numbers}: must be three numbers, not all 0")
    x, y, z = numbers
    return x, y, z


class Loop:
    """A film in which every motion completes whole cycles: the shortest one of whole periods of the
    first mode shown (or of `periods` of them) in which every other motion nearly does so. Their
    rates are changed so that they do.

    film: with the ground, which rotates in the rotating frame, and played within FILM_SECONDS;
    else a model without ground, within LOOP_SECONDS. With `periods` it may be longer. Raises
    InvalidInput where nothing moves or an unstable mode is shown.

    seconds: its length; periods: of the first motion; phases (m,), other_phases and angle [rad]:
    the advance of every mode of the first and the second beam, and of the hub; changes: relative
    change of each motion's rate that closes the film, by name (-1: it stands still).
    """

    def __init__(self, solved: SolvedScene, periods: int | None = None, *, film: bool = True):
        motions = motion_rates(solved, ground=film)
        rates = np.array(list(motions.values()))
        view, shapes = solved.scene.view, solved.shapes
        rate = playback_rate(shapes.frequencies[solved.shown], solved.scene.beam.gamma)
        if view.pace == 0:
            raise InvalidInput("pace = 0: a film needs a pace above 0")
        period, apart = 2 * math.pi / rates[0], differences(solved)
        most = max(1, int(LOOP_SECONDS * rate / period), COMPARED_PERIODS if apart else 0)
        largest = min([MAX_CHANGE, *(difference / 2 for difference in apart)])
        tried = np.array([periods]) if periods else np.arange(1, most + 1)
        cycles_run = tried[:, None] * rates / rates[0]  # cycles of each motion
        cycles = np.rint(cycles_run)
        changes = cycles / cycles_run - 1
        # The first film whose rates change by so little, else the one with least change.
        best = int(np.maximum(np.abs(changes).max(axis=1), largest).argmin())
        self.periods = int(tried[best])
        self.changes = dict(zip(motions, changes[best].tolist(), strict=True))
        advance = dict(zip(motions, 2 * math.pi * cycles[best], strict=True))
        self.phases = np.array([advance.get(label, 0.0) for label in shapes.labels])
        other = solved.pair.second if solved.pair else None
        names = [second_name(other, label) for label in other.shapes.labels] if other else []
        self.other_phases = np.array([advance.get(name, 0.0) for name in names])
        symmetry = GROUND_SYMMETRY if view.rotating_frame else 1
        self.angle = float(advance.get(ROTATION, 0.0) / symmetry)
        within = max(FILM_SECONDS if film else LOOP_SECONDS, CYCLE_SECONDS * cycles[best].max())
        within = min(within, COMPARED_SECONDS) if apart else within
        length = min(self.periods * period / rate, math.inf if periods else within)
        self.seconds = float(length / view.pace)

    def moment(self, part: float) -> Moment:
        """The scene when a part (0 .. 1) of the film has passed."""
        phases, others = (
            math.pi / 2 + part * advance for advance in (self.phases, self.other_phases)
        )
        return Moment(phases, part * self.angle, others)

    @property
    def note(self) -> str:
        """The changes as a sentence, or ""."""
        parts = [
            f"{name} {described_change(change)}"
            for name, change in self.changes.items()
            if abs(change) > 5e-4
        ]
        return f"so that the film closes, {', '.join(parts)}" if parts else ""


def described_change(change: float) -> str:
    """A relative change of a rate in words."""
    if change == -1:
        return "stands still"
    return f"runs {100 * abs(change):.1f} % {'faster' if change > 0 else 'slower'}"


def second_name(second: DrawnBeam, label: str) -> str:
    """The name of a motion of the second beam."""
    return f"{label} of {second.title!r}"


def differences(solved: SolvedScene) -> list[float]:
    """The relative differences, of at least APART, between the frequencies of modes of the second
    beam that move and of their partners."""
    if solved.pair is None:
        return []
    frequencies, (_, second, partner) = solved.shapes.frequencies, solved.pair
    pairs = [(second.shapes.frequencies[j], frequencies[partner[j]]) for j in second.shown]
    return [apart for a, b in pairs if b > 0 and (apart := abs(float(a / b) - 1)) >= APART]


def motion_rates(solved: SolvedScene, *, ground: bool) -> dict[str, float]:
    """The angular rate [1/T*] at which each motion repeats, by its name."""
    motions = {}
    for k in solved.shown:
        label, frequency = solved.shapes.labels[k], float(solved.shapes.frequencies[k])
        if not math.isfinite(frequency):
            raise InvalidInput(
                f"mode = {k + 1}: {label} does not vibrate but grows (divergence), so"
                " there is no period to film; choose another mode"
            )
        if frequency > 0:
            motions[label] = frequency
    if solved.pair:
        second = solved.pair.second
        for k in second.shown:
            if (frequency := float(second.shapes.frequencies[k])) > 0:
                motions[second_name(second, second.shapes.labels[k])] = frequency
    rotating, gamma = solved.scene.view.rotating_frame, solved.scene.beam.gamma
    if gamma > 0 and (ground or not rotating):
        motions[ROTATION] = gamma * (GROUND_SYMMETRY if rotating else 1)
    if not motions:
        raise InvalidInput("nothing moves in this scene: show a mode, or let the beam rotate")
    return motions
