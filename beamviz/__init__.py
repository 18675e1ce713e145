"""A rotating beam with a concentrated mass: equilibrium, modes, and a live 3D explorer.

Modules that compute or draw are imported on first use, so that `import beamviz` stays fast.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from beamviz.beam import Beam, Units
from beamviz.errors import BeamvizError, InvalidInput, NoEquilibrium, NotConverged, Unavailable

if TYPE_CHECKING:
    from beamviz.frequency_loci import Event, Loci, loci
    from beamviz.frequency_loci.forced_response import Resonance, RunUp, resonances, run_up
    from beamviz.scene import Scene
    from beamviz.solver import Solution, solve, solve_many

__version__ = "0.1.0"

__all__ = [
    "Beam",
    "BeamvizError",
    "Event",
    "InvalidInput",
    "Loci",
    "NoEquilibrium",
    "NotConverged",
    "Resonance",
    "RunUp",
    "Scene",
    "Solution",
    "Unavailable",
    "Units",
    "__version__",
    "animate",
    "export",
    "loci",
    "resonances",
    "run_up",
    "screenshot",
    "solve",
    "solve_many",
    "sweep",
]

ON_FIRST_USE = {
    "Event": "beamviz.frequency_loci",
    "Loci": "beamviz.frequency_loci",
    "Resonance": "beamviz.frequency_loci.forced_response",
    "RunUp": "beamviz.frequency_loci.forced_response",
    "Scene": "beamviz.scene",
    "Solution": "beamviz.solver",
    "animate": "beamviz.exports",
    "export": "beamviz.exports",
    "loci": "beamviz.frequency_loci",
    "resonances": "beamviz.frequency_loci.forced_response",
    "run_up": "beamviz.frequency_loci.forced_response",
    "screenshot": "beamviz.exports",
    "solve": "beamviz.solver",
    "solve_many": "beamviz.solver",
    "sweep": "beamviz.sweeps",
}


def __getattr__(name: str) -> Any:
    if name not in ON_FIRST_USE:
        raise AttributeError(f"module 'beamviz' has no attribute {name!r}")
    return getattr(import_module(ON_FIRST_USE[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
