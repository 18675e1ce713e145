"""A rotating beam with a concentrated mass: equilibrium, modes, and a live 3D explorer.

The solver loads on first use, so that `import beamviz` alone stays light.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from beamviz.beam import Beam, Units
from beamviz.errors import BeamvizError, InvalidInput, NoEquilibrium, NotConverged, Unavailable

if TYPE_CHECKING:
    from beamviz.mechanics.solve import Solution, solve
    from beamviz.study.loci import loci

__version__ = "0.1.0"

__all__ = [
    "Beam",
    "BeamvizError",
    "InvalidInput",
    "NoEquilibrium",
    "NotConverged",
    "Solution",
    "Unavailable",
    "Units",
    "__version__",
    "loci",
    "solve",
]

ON_FIRST_USE = {
    "Solution": "beamviz.mechanics.solve",
    "loci": "beamviz.study.loci",
    "solve": "beamviz.mechanics.solve",
}


def __getattr__(name: str) -> Any:
    if name not in ON_FIRST_USE:
        raise AttributeError(f"module 'beamviz' has no attribute {name!r}")
    return getattr(import_module(ON_FIRST_USE[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
