"""Beams as the picture takes them."""

import math
from typing import Any

import numpy as np
from live.visitor import PAPER
from strategies import beams

from beamviz.beam import Beam
from beamviz.drawing.modes import SampledModes, displacement
from beamviz.solver import solve

BEAMS = beams(alpha=(0, 100), gamma=(0, 50), delta=(0, 5))


def sampled(beam: Beam = PAPER, **options: Any) -> SampledModes:
    """The shapes of a beam."""
    return SampledModes.sampled(solve(beam, **options))


def single_mode(shapes: SampledModes, mode: int, phase: float, size: float = 0.15) -> np.ndarray:
    """Displacement with one mode (from 0) at `phase` of its period."""
    m = len(shapes.modes)
    return displacement(shapes, np.full(m, 2 * math.pi * phase), size * np.eye(m)[mode])
