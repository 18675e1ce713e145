"""Beams as the picture takes them, and points as it shows them."""

import math
from typing import Any

import numpy as np
from live.visitor import PAPER
from strategies import beams

from beamviz.beam import Beam
from beamviz.drawing import camera
from beamviz.drawing.modes import SampledModes, displacement
from beamviz.scene import Camera
from beamviz.solver import solve

BEAMS = beams(alpha=(0, 100), gamma=(0, 50), delta=(0, 5))
BENT = Beam(delta=-1, gamma=4)


def sampled(beam: Beam = PAPER, **options: Any) -> SampledModes:
    return SampledModes.sampled(solve(beam, **options))


def single_mode(shapes: SampledModes, mode: int, phase: float, size: float = 0.15) -> np.ndarray:
    """Displacement with one mode (from 0) at `phase` of its period."""
    m = len(shapes.modes)
    return displacement(shapes, np.full(m, 2 * math.pi * phase), size * np.eye(m)[mode])


def projected(points: np.ndarray, view: Camera) -> np.ndarray:
    """Points (n, 3) in front of a camera as (n, 2) to the right and down from the middle of the
    picture, in halves of its height."""
    position = np.array(view.position)
    seen = (points - position) @ camera.axes(position - view.look_at)
    assert (seen[:, 2] > 0).all()
    return seen[:, :2] / (seen[:, 2:] * math.tan(camera.FIELD_OF_VIEW / 2))
