"""A motion in time as a scene of films and pages."""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.drawing import BeamScene, camera
from beamviz.drawing.beam_mesh import DEFAULT_SCALE, DrawnBeam
from beamviz.drawing.modes import playback_rate
from beamviz.drawing.motion import UNSTIFFENED, MotionShapes, dominant_frequency, drawn, drawn_beam
from beamviz.drawing.scene_graph import DrawnScene
from beamviz.dynamics import Motion
from beamviz.dynamics.linear import LinearMotion
from beamviz.scene import COLOURINGS, Camera, Scene, ViewOptions

SECONDS = 3.0, 20.0  # shortest and longest film
SAMPLES, MOST_SAMPLES = 40, 4001  # of the shapes, for each T* and in all
USUAL_VIEW = ViewOptions()


class MotionScene:
    """A motion as a scene, in the rotating frame, with that without stiffening over it, if given.
    view: its other choices; rate: time [T*] per second on the screen; seconds: of a film."""

    def __init__(
        self,
        motion: Motion,
        unstiffened: LinearMotion | None = None,
        view: ViewOptions = USUAL_VIEW,
    ):
        view = replace(view, colouring=COLOURINGS[0], rotating_frame=True)
        self.motion, self.scene = motion, Scene(view=view)
        count = min(math.ceil(SAMPLES * motion.t[-1]) + 1, MOST_SAMPLES)
        t = np.linspace(0.0, motion.t[-1], max(count, len(motion.t)))
        self.shapes = MotionShapes(motion, t)
        self.second = MotionShapes(unstiffened) if unstiffened else None
        self.rate = playback_rate(dominant_frequency(motion), float(abs(motion.gamma).max()))
        self.seconds = float(np.clip(motion.t[-1] / self.rate, *SECONDS))

    def beam(self, *, with_mass: bool) -> Beam:
        """The beam to draw."""
        beam = drawn_beam(self.motion)
        return beam if with_mass else beam.replace(alpha=0.0)

    def drawn(self, scale: float, *, with_mass: bool) -> DrawnBeam:
        """The beam, at `scale` [pixels per beam length]."""
        beam, shapes = self.beam(with_mass=with_mass), self.shapes
        forces = shapes.forces if self.scene.view.forces else None
        look = self.scene.view, scale
        return drawn(shapes.sampled, shapes.amplitudes, beam, *look, forces=forces)

    def second_drawn(self, scale: float, *, with_mass: bool) -> DrawnBeam | None:
        """That without stiffening; None without one."""
        if self.second is None:
            return None
        beam, shapes = self.beam(with_mass=with_mass), self.second
        ends = " (diverges)" if shapes.until < self.motion.t[-1] else ""
        look = self.scene.view, scale, UNSTIFFENED + ends
        return drawn(shapes.sampled, shapes.amplitudes, beam, *look)

    def camera(self, aspect: float) -> Camera:
        """A camera that sees the beam at all times."""
        position = camera.viewpoint(self.shapes.sampled, True, aspect)
        reach = 1 + np.linalg.norm(self.reach(), ord=np.inf)
        return Camera((position * reach).tolist())

    def reach(self) -> NDArray:
        """How far the tip moves from the mean (2,)."""
        return abs(self.motion.tip - self.motion.tip.mean(axis=0)).max(axis=0)

    def draw(self, scene: DrawnScene, scale: float = DEFAULT_SCALE) -> BeamScene:
        """The scene, at `scale` [pixels per beam length]."""
        beams = BeamScene(scene)
        self.show(beams, scale, with_mass=bool(self.motion.beam.alpha))
        return beams

    def show(self, beams: BeamScene, scale: float, *, with_mass: bool) -> None:
        """Draw the beam, and that without stiffening."""
        second = self.second_drawn(scale, with_mass=with_mass)
        beams.show(self.drawn(scale, with_mass=with_mass), second)

    def move(self, beams: BeamScene, moment: float) -> None:
        """Move the beam drawn to a time."""
        drawn, with_mass = beams.view(0).drawn, self.motion.has_mass(moment)
        if with_mass != bool(drawn.shapes.beam.alpha):
            self.show(beams, drawn.scale, with_mass=with_mass)
        beams.tell_speed(self.shapes.gamma(moment))
        others = self.second.phases(moment) if self.second else None
        source = beams.view(0).drawn.forces_of_motion
        forces = source.at(moment) if source else None
        beams.move(self.shapes.phases(moment), self.shapes.angle(moment), others, forces)


def beside(unstiffened: LinearMotion | None) -> tuple[NDArray, NDArray, str] | None:
    """The motion without stiffening as a line beside that of the tip: times (n,), deflections (n,)
    and title; None without one."""
    if unstiffened is None:
        return None
    return unstiffened.t, unstiffened.tip[:, 1], UNSTIFFENED
