"""A rotating beam with a concentrated mass: equilibrium, modes, and a live 3D explorer.

What computes and what draws loads on first use, so that `import beamviz` alone stays light.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from beamviz.beam import Beam, Units
from beamviz.errors import BeamvizError, InvalidInput, NoEquilibrium, NotConverged, Unavailable

if TYPE_CHECKING:
    from beamviz.mechanics.solve import Solution, solve
    from beamviz.scene_file import SavedScene
    from beamviz.study.loci import loci

__version__ = "0.1.0"

__all__ = [
    "Beam",
    "BeamvizError",
    "InvalidInput",
    "NoEquilibrium",
    "NotConverged",
    "SavedScene",
    "Solution",
    "Unavailable",
    "Units",
    "__version__",
    "animate",
    "export",
    "loci",
    "screenshot",
    "solve",
]

ON_FIRST_USE = {
    "SavedScene": "beamviz.scene_file",
    "Solution": "beamviz.mechanics.solve",
    "animate": "beamviz.show.film",
    "export": "beamviz.show.export",
    "loci": "beamviz.study.loci",
    "screenshot": "beamviz.show.picture",
    "solve": "beamviz.mechanics.solve",
}


def __getattr__(name: str) -> Any:
    if name not in ON_FIRST_USE:
        raise AttributeError(f"module 'beamviz' has no attribute {name!r}")
    return getattr(import_module(ON_FIRST_USE[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
