"""A rotating beam with a concentrated mass: equilibrium, modes, and a live 3D explorer.

Every name is imported on first use, so that `import beamviz` and the start of a command are fast.
"""

from importlib import import_module

TYPE_CHECKING = False  # as of `typing`, which takes longer to import than all of this
if TYPE_CHECKING:
    from typing import Any

    from beamviz.adjusting import adjust
    from beamviz.adjusting.result import Adjusted
    from beamviz.beam import Beam
    from beamviz.blade import Blade, Mass
    from beamviz.dynamics import Motion, motion
    from beamviz.dynamics.drives import Hub, Ramp
    from beamviz.errors import (
        BeamvizError,
        ImplausibleInput,
        InvalidInput,
        LeftOut,
        NoAnswer,
        NoEquilibrium,
        NotConverged,
        Unavailable,
    )
    from beamviz.frequency_loci import Event, Loci, loci, resonances
    from beamviz.frequency_loci.forced_response import RunUp, run_up
    from beamviz.notebook import View, show
    from beamviz.scene import Scene
    from beamviz.solver import solve, solve_many
    from beamviz.solver.solution import Solution
    from beamviz.units import Units
    from beamviz.version import __version__

__all__ = [
    "Adjusted",
    "Beam",
    "BeamvizError",
    "Blade",
    "Event",
    "Hub",
    "ImplausibleInput",
    "InvalidInput",
    "LeftOut",
    "Loci",
    "Mass",
    "Motion",
    "NoAnswer",
    "NoEquilibrium",
    "NotConverged",
    "Ramp",
    "RunUp",
    "Scene",
    "Solution",
    "Unavailable",
    "Units",
    "View",
    "__version__",
    "adjust",
    "animate",
    "export",
    "loci",
    "motion",
    "resonances",
    "run_up",
    "screenshot",
    "show",
    "solve",
    "solve_many",
    "sweep",
]

ON_FIRST_USE = {
    "beamviz.adjusting": ("adjust",),
    "beamviz.adjusting.result": ("Adjusted",),
    "beamviz.beam": ("Beam",),
    "beamviz.blade": ("Blade", "Mass"),
    "beamviz.dynamics": ("Motion", "motion"),
    "beamviz.dynamics.drives": ("Hub", "Ramp"),
    "beamviz.errors": (
        "BeamvizError",
        "ImplausibleInput",
        "LeftOut",
        "InvalidInput",
        "NoAnswer",
        "NoEquilibrium",
        "NotConverged",
        "Unavailable",
    ),
    "beamviz.exports": ("animate", "export", "screenshot"),
    "beamviz.frequency_loci": ("Event", "Loci", "loci", "resonances"),
    "beamviz.frequency_loci.forced_response": ("RunUp", "run_up"),
    "beamviz.notebook": ("View", "show"),
    "beamviz.scene": ("Scene",),
    "beamviz.solver": ("Solution", "solve", "solve_many"),
    "beamviz.sweeps": ("sweep",),
    "beamviz.units": ("Units",),
    "beamviz.version": ("__version__",),
}


def __getattr__(name: str) -> "Any":
    for module, names in ON_FIRST_USE.items():
        if name in names:
            return getattr(import_module(module), name)
    raise AttributeError(f"module 'beamviz' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
