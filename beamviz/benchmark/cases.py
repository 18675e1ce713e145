"""What is measured: six beams from gentle to harsh, and every method of beamviz."""

from collections.abc import Callable
from functools import partial
from importlib.metadata import PackageNotFoundError
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.solver import solve

MODES = 5
SCENES = {
    "slow": Beam(gamma=2),
    "tip mass": Beam(alpha=1, gamma=5),
    "inner mass": Beam(alpha=1, beta=0.5, gamma=10),
    "fast": Beam(gamma=50, delta=1),
    "fast, inner mass": Beam(alpha=1, beta=0.3, gamma=50, delta=1),
    "fastest": Beam(gamma=200),
}
TOLERANCES = (0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10)
ELEMENTS = (5, 10, 20, 40, 80, 160)


class Solver(NamedTuple):
    """A method of beamviz or another program, at several resolutions.

    `theory` is the model whose exact frequencies it converges to, a key of limits.json; `option`
    says what its resolutions are; `omega_squared` maps beam, resolution and number of modes to
    omega^2 (modes,). For another program, `version` raises PackageNotFoundError where it is not
    installed, and `install` is the command that installs it.
    """

    name: str
    theory: str
    option: str
    resolutions: tuple[float, ...]
    omega_squared: Callable[[Beam, Any, int], np.ndarray]
    version: Callable[[], str] = str
    install: str = ""

    @property
    def missing(self) -> str:
        """Why it cannot run; empty where it can."""
        try:
            self.version()
        except PackageNotFoundError:
            return f"not installed: {self.install}"
        return ""


def _solve(method: str, option: str, beam: Beam, resolution: Any, modes: int) -> np.ndarray:
    options: dict[str, Any] = {option: resolution}
    return solve(beam, modes, method, **options).omega_squared


METHODS = tuple(
    Solver(name, theory, option, resolutions, partial(_solve, name, option))
    for name, theory, option, resolutions in (
        ("auto", "green", "tolerance", TOLERANCES),
        ("ancf", "green", "elements", ELEMENTS),
        ("ancf-planar", "green", "elements", ELEMENTS),
        ("chebyshev", "green", "terms", (8, 12, 16, 24, 32, 48, 64, 96)),
        ("foac", "rigid", "tolerance", TOLERANCES),
        ("linear", "rigid", "elements", ELEMENTS),
        ("assumed-modes", "rigid", "terms", (5, 6, 8, 10, 12, 14, 20)),
        ("power-series", "rigid", "terms", (24, 32, 40, 60, 80, 120)),
        ("zoac", "none", "tolerance", TOLERANCES),
    )
)
