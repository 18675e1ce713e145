"""The 3D view of a visitor: the beam, or all its modes in rows, and the beam compared with.

`picture_of` says what the scene shows of a snapshot, and `SceneView` draws it: `show` the picture,
`move` a moment of its motion.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from viser import CameraHandle
from viser.transforms import SO3

from beamviz.drawing import BeamScene, stacked_heights
from beamviz.drawing.beam_mesh import DrawnBeam
from beamviz.drawing.comparison import pair_heights, pair_of
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.motion import UNSTIFFENED, drawn
from beamviz.drawing.objects import Caption
from beamviz.drawing.scene_graph import DrawnScene
from beamviz.explorer.clock import Clock, growth_rates, suitable_rate
from beamviz.explorer.film import Film, time_text
from beamviz.explorer.second_beam import ComparisonCase
from beamviz.explorer.solutions import SolverAnswer
from beamviz.explorer.state import NO_COMPARISON, Case, Ray, State
from beamviz.scene import ViewOptions

AXIS = (0.0, 0.0, 1.0)  # of rotation
SAME_END = 0.005  # relative difference of colour maps that the digits of a legend do not show


class Compared(NamedTuple):
    """The choices by which there is a second beam."""

    comparison: str = NO_COMPARISON  # its kind
    kept: Case | None = None  # the case kept for it
    stacked: bool = False  # it is drawn above the first


NOT_COMPARED = Compared()


@dataclass(frozen=True, eq=False)
class Picture:
    """What the scene shows, but for the moment of its motion."""

    modes: SampledModes  # of the beam
    drawn: DrawnBeam  # how the beam moves in its modes
    force: float | None = None  # frequency [1/T*] of a force that drives it; None: it is free
    second: DrawnBeam | None = None  # the beam compared with
    partner: np.ndarray | None = None  # for each mode of the second: the first's (-1: none)
    compared: Compared = NOT_COMPARED  # the choices by which there is a second
    stacked: bool = False  # the second is above the first
    film: Film | None = None  # a computed motion that is played instead of modes
    moment: float | None = None  # [T*] at which that is stopped; None: it plays
    held: bool = False  # the beam's frame stays at its place, as a body is dragged
    plays: bool | None = None  # whether the clock goes on; None: as the visitor has chosen

    @property
    def driven(self) -> bool:
        """Whether it shows something else than modes."""
        return self.force is not None or self.film is not None

    @property
    def shown(self) -> list[int]:
        """The modes (from 0) that it shows; none of a motion that is no sum of modes."""
        if self.driven:
            return []
        return list(range(len(self.modes.modes))) if self.drawn.in_rows else self.drawn.shown

    @cached_property
    def heights(self) -> list[float]:
        """Heights [beam lengths] of the beams one above the other."""
        if self.drawn.in_rows:
            return stacked_heights(len(self.modes.modes))
        return pair_heights(stacked=self.second is not None and self.stacked)

    @property
    def colour_ends(self) -> list[float]:
        """The ends of the colour maps in the scene, the least and the largest where they differ: of
        the beam and one above it, or of the rows. A beam over another has no colours."""
        beams = [self.drawn]
        if self.drawn.in_rows:
            view, scale = self.drawn.view, self.drawn.scale
            alone = view.amplitude * np.eye(len(self.modes.modes))
            beams = [DrawnBeam(self.modes, view, scale, sizes) for sizes in alone]
        elif self.second and self.stacked:
            beams.append(self.second)
        ends = [beam.largest for beam in beams]
        return [min(ends), max(ends)] if not np.allclose(ends, ends[0], SAME_END) else ends[:1]

    @cached_property
    def rate(self) -> float:
        """The time [T*] per second on the screen that suits its motion."""
        shapes, units = self.modes, self.modes.beam.units
        if self.film:
            return self.film.rate
        if self.force is not None:
            return suitable_rate([self.force], shapes.beam.gamma, units)
        rates = np.hypot(np.nan_to_num(shapes.frequencies), np.maximum(growth_rates(shapes), 0.0))
        return suitable_rate(rates[self.shown], shapes.beam.gamma, units)

    @property
    def hidden_growth(self) -> int | None:
        """The mode (from 0) that grows fastest, None where a mode shown grows, or none does."""
        rates = growth_rates(self.modes)
        if self.driven or not (rates > 0).any() or (rates[self.shown] > 0).any():
            return None
        return int(rates.argmax())


def picture_of(answer: SolverAnswer | Case, view: ViewOptions, scale: float) -> Picture:
    """The picture of an answer, or before the first of a case. Without an equilibrium the beam is
    drawn unloaded and grey. scale: [pixels per beam length]."""
    if isinstance(answer, Case):
        answer = SolverAnswer(answer)
    drawn = DrawnBeam(answer.shapes, view, scale)
    if answer.result is None:
        drawn = replace(drawn, warning=answer.warning)
    return Picture(answer.shapes, drawn)


def with_second(
    picture: Picture, state: State, second: SolverAnswer | None, comparison: ComparisonCase
) -> Picture:
    """A picture with the beam compared with, which swings unless a force drives the first; as it
    is, where a motion in time is played."""
    if picture.film or comparison.choice == NO_COMPARISON:
        return picture
    compared = Compared(comparison.choice, state.kept, state.stacked)
    picture = replace(picture, stacked=compared.stacked)
    other = second.result if second and not (second.warning or state.view.all_modes) else None
    if other is None:
        return picture
    pair = pair_of(
        picture.drawn,
        other,
        comparison.title,
        stacked=compared.stacked,
        swings=picture.force is None,
    )
    first, second_drawn, partner = pair
    return replace(picture, drawn=first, second=second_drawn, partner=partner, compared=compared)


def with_film(
    picture: Picture, film: Film, view: ViewOptions, scale: float, moment: float
) -> Picture:
    """A picture in which a computed motion is played, with the one without stiffening overlaid, at
    a moment [T*]: the mass may be off the beam, and the latter may have got no further."""
    beam = film.beam if film.has_body(moment) else film.beam.replace(alpha=0.0)
    second = None
    if film.second:
        end = ""
        if film.diverged is not None and moment >= film.diverged:
            end = f": diverged at {time_text(film.diverged, beam.units)}"
        title = f"{UNSTIFFENED}{end}"
        second = drawn(film.second.sampled, film.second.amplitudes, beam, view, scale, title)
    forces = film.shapes.forces if view.forces else None
    shown = drawn(film.shapes.sampled, film.shapes.amplitudes, beam, view, scale, forces=forces)
    return replace(picture, drawn=shown, force=None, second=second, film=film)


class SceneView:
    """The objects of the scene, seen by a camera. beam: the single one; hints: texts at what is
    taken by the hand."""

    def __init__(self, scene: DrawnScene, camera: CameraHandle):
        self.scene, self.camera = BeamScene(scene), camera
        self.beam = self.scene.view(0)
        self.hints: list[Caption] = []

    @property
    def graph(self) -> DrawnScene:
        """The nodes that objects are added to."""
        return self.scene.scene

    def line_of_sight(self, point: np.ndarray) -> Ray:
        """The present line of sight through a point (3,) of the scene."""
        turn_back = SO3(np.array(self.beam.rotor.wxyz)).inverse()
        eye, middle = np.array(self.camera.position), self.beam.frame.position
        return turn_back.apply(eye - middle), turn_back.apply(point - middle)

    def across(self, point: np.ndarray) -> float | None:
        """The place [L] of a point (3,) of the scene across the picture, to the right of its
        middle; None where the camera looks along the axis of rotation."""
        along = np.array(self.camera.look_at) - np.array(self.camera.position)
        right = np.cross(along, AXIS)
        length = np.linalg.norm(right)
        place = float(right @ point / length) if length > 0 else math.nan
        return place if math.isfinite(place) else None

    def show(self, picture: Picture) -> np.ndarray:
        """Draw a picture. Returns how far the beam's frame was moved (3,) as it was released."""
        before, released = np.array(self.beam.frame.position), self.beam.fixed and not picture.held
        self.beam.fixed = picture.held
        self.scene.show(picture.drawn, picture.second, stacked=picture.stacked)
        return self.beam.frame.position - before if released else np.zeros(3)

    def move(self, picture: Picture, clock: Clock) -> None:
        """Draw a moment."""
        angle, change = clock.angle, clock.transition
        if change:
            angle = change.continued(angle)
            self.scene.choose_frame(change.rotating_share)
        if film := picture.film:
            second = film.second.phases(clock.moment) if film.second else None
            source = picture.drawn.forces_of_motion
            forces = source.at(clock.moment) if source else None
            self.scene.move(film.shapes.phases(clock.moment), angle, second, forces)
            self.scene.tell_speed(film.shapes.gamma(clock.moment))
            return
        phases = clock.drawn_phases(picture.modes)
        if picture.force is not None:  # a whole multiple of the speed
            multiple = picture.force / max(picture.modes.beam.gamma, 1e-300)
            phases = np.array([multiple * clock.angle])
        self.scene.move(phases, angle, clock.other_phases)

    @property
    def captions(self) -> list[Caption]:
        """The texts that the page writes over the scene; the warning is above the scene."""
        return [caption for caption in self.scene.captions if caption is not self.beam.warning]


def fitted_clock(clock: Clock, picture: Picture) -> Clock:
    """The clock with phases for the modes of a picture."""
    clock = clock.for_modes(len(picture.modes.modes))
    if picture.partner is not None:
        clock = clock.with_second(picture.compared, picture.partner)
    return clock
