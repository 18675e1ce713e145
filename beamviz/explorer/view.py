"""The 3D view of a visitor: the beam, or all its modes in rows, and the beam compared with.

`picture_of` says what the scene shows of a snapshot, and `SceneView` draws it: `show` the picture,
`move` a moment of its motion.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from beamviz.drawing import OVERLAY, BeamScene, BeamView, stacked_heights
from beamviz.drawing.beam_mesh import DrawnBeam
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.motion import drawn
from beamviz.drawing.objects import Caption
from beamviz.drawing.scene_graph import DrawnScene
from beamviz.explorer.clock import Clock, growth_rates, suitable_rate
from beamviz.explorer.film import Film, time_text
from beamviz.explorer.solutions import SolverAnswer
from beamviz.explorer.state import NO_COMPARISON, Case, State
from beamviz.frequency_loci.identity import match_modes
from beamviz.scene import ViewOptions

SPACING = 0.5  # of the two scenes, in beam lengths
THIS = "this beam"


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
    held: bool = False  # the beam's frame stays at its place, as a body is dragged
    film: Film | None = None  # a computed motion that is played instead of modes

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
        return [-SPACING / 2, SPACING / 2] if self.second and self.stacked else [0.0]

    @property
    def largest(self) -> float:
        """The end of the colour map: of the beam, or of the row whose colours go furthest."""
        if not self.drawn.in_rows:
            return self.drawn.largest
        view, scale = self.drawn.view, self.drawn.scale
        alone = view.amplitude * np.eye(len(self.modes.modes))
        return max(DrawnBeam(self.modes, view, scale, sizes).largest for sizes in alone)

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


def picture_of(
    answer: SolverAnswer | Case,
    view: ViewOptions,
    scale: float,
    second: SolverAnswer | None = None,
    title: str = "",
    compared: Compared = NOT_COMPARED,
    response: DrawnBeam | None = None,
    force: float = 0.0,
    held: bool = False,
) -> Picture:
    """The picture of an answer, or before the first of a case, and of the answer compared with, of
    this title. Without an equilibrium the beam is drawn unloaded and grey. scale: [pixels per beam
    length]; response: to a force of this frequency [1/T*], if that drives the beam; held: a body is
    in the visitor's hand."""
    if isinstance(answer, Case):
        answer = SolverAnswer(answer)
    drawn = response or DrawnBeam(answer.shapes, view, scale)
    if answer.result is None:
        drawn = replace(drawn, warning=answer.warning)
    other = second.result if second and not (second.warning or view.all_modes) else None
    driven = force if response else None
    picture = Picture(answer.shapes, drawn, driven, stacked=compared.stacked, held=held)
    if other is None:
        return picture
    partner = corresponding(answer.shapes, other)
    sizes = 0.0 * partner if response else np.append(drawn.amplitudes, 0.0)[partner]
    return replace(
        picture,
        drawn=replace(drawn, title=THIS if compared.stacked else ""),
        second=DrawnBeam(other, view, scale, sizes, title=title),
        partner=partner,
        compared=compared,
    )


UNSTIFFENED = "without stiffening"


def with_film(
    picture: Picture, film: Film, view: ViewOptions, scale: float, has_body: bool, diverged: bool
) -> Picture:
    """A picture in which a computed motion is played, with the one without stiffening overlaid.
    has_body: the mass is on the beam; diverged: the latter has got no further."""
    beam = film.beam if has_body else film.beam.replace(alpha=0.0)
    second = None
    if film.second:
        end = f": diverged at {time_text(film.diverged, beam.units)}" if diverged else ""
        title = f"{UNSTIFFENED}{end}"
        second = drawn(film.second.sampled, film.second.amplitudes, beam, view, scale, title)
    return replace(
        picture,
        drawn=drawn(film.shapes.sampled, film.shapes.amplitudes, beam, view, scale),
        force=None,
        second=second,
        partner=None,
        compared=NOT_COMPARED,
        stacked=False,
        film=film,
    )


def picture_reads(inputs: Any, response: DrawnBeam | None) -> tuple[Any, ...]:
    """The arguments of `picture_of` for the `Inputs` of a snapshot. response: of the beam to a
    force, if any."""
    state: State = inputs.state
    beam = inputs.beam
    compared = Compared(inputs.comparison.choice, state.kept, state.stacked)
    return (
        inputs.answer or state.case,
        state.view,
        inputs.scale,
        inputs.second,
        inputs.comparison.title,
        NOT_COMPARED if compared.comparison == NO_COMPARISON else compared,
        response,
        state.force_per_rev * beam.gamma if beam else 0.0,
        state.grip is not None,
    )


def corresponding(first: SampledModes, second: SampledModes) -> np.ndarray:
    """The mode of one beam (m,) for each mode of another; -1 where none corresponds."""
    if first.solution is None or second.solution is None:
        return np.full(len(second.modes), -1)
    return match_modes(second.solution, first.solution).partner


class SceneView:
    """The objects of the scene. beam: the single one; others: those of the second beam, by whether
    it is above the first, made when needed."""

    def __init__(self, scene: DrawnScene):
        self.scene, self.drawn_scene = BeamScene(scene), scene
        self.beam = self.scene.view(0)
        self.others: dict[bool, BeamView] = {}

    def show(self, picture: Picture) -> np.ndarray:
        """Draw a picture. Returns how far the beam's frame was moved (3,) as it was released."""
        before, released = np.array(self.beam.frame.position), self.beam.fixed and not picture.held
        self.beam.fixed = picture.held
        self.beam.height = 0.0 if picture.drawn.in_rows else picture.heights[0]
        for view in self.others.values():
            view.hide()
        self.scene.show(picture.drawn)
        if picture.second:
            other = self.other(stacked=picture.stacked)
            other.height = picture.heights[-1]
            other.show(picture.second)
        return self.beam.frame.position - before if released else np.zeros(3)

    def other(self, *, stacked: bool) -> BeamView:
        """The objects of the second beam."""
        if stacked not in self.others:
            root, overlay = ("/other", False) if stacked else (OVERLAY, True)
            self.others[stacked] = BeamView(self.drawn_scene, root, alone=False, overlay=overlay)
        return self.others[stacked]

    def move(self, picture: Picture, clock: Clock) -> None:
        """Draw a moment."""
        angle, change = clock.angle, clock.transition
        other = self.other(stacked=picture.stacked) if picture.second else None
        if change:
            angle = change.continued(angle)
            for view in (self.scene, other):
                if view:
                    view.choose_frame(change.rotating_share)
        if film := picture.film:
            self.move_in(film, clock.moment, angle)
            return
        phases = clock.drawn_phases(picture.modes)
        if picture.force is not None:  # a whole multiple of the speed
            multiple = picture.force / max(picture.modes.beam.gamma, 1e-300)
            phases = np.array([multiple * clock.angle])
        self.scene.move(phases, angle)
        if other and picture.second:
            other.move(clock.other_phases, angle)

    def move_in(self, film: Film, moment: float, angle: float) -> None:
        """Draw a moment of a computed motion, the hub rotated by an angle [rad]."""
        self.scene.move(film.shapes.phases(moment), angle)
        self.scene.tell_speed(film.shapes.gamma(moment))
        if film.second:
            self.other(stacked=False).move(film.second.phases(moment), angle)

    @property
    def captions(self) -> list[Caption]:
        """The texts that the page writes over the scene, those of a beam above the first before its
        own, as one that would cover another is moved down; the warning is above the scene."""
        views = [self.others.get(True), self.scene, self.others.get(False)]
        texts = [caption for view in views if view for caption in view.captions]
        return [caption for caption in texts if caption is not self.beam.warning]


def fitted_clock(clock: Clock, picture: Picture) -> Clock:
    """The clock with phases for the modes of a picture."""
    clock = clock.for_modes(len(picture.modes.modes))
    if picture.partner is not None:
        clock = clock.with_second(picture.compared, picture.partner)
    return clock
