"""What a peer is: another program that solves the same beam."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from beamviz.beam import Beam


class Peer(NamedTuple):
    """Another program: the theory whose limit it converges to, its resolutions, how it solves."""

    name: str
    theory: str
    resolutions: tuple[int, ...]
    solve: Callable[[Beam, int, int], np.ndarray]  # beam, resolution, modes -> omega^2 (modes,)
    version: Callable[[], str]  # raises ImportError where it is not installed
    how: str  # to install it
    model: str
