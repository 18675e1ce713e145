"""What a constant of the mesh design costs, as a function of its value, over random beams:

    python scripts/fit_mesh_constants.py LAYER_REACH 1.5 2 2.5 [--beams 300] [--tolerance 1e-6]

The constants of beamviz/solver/hp/mesh_design.py choose the first mesh of a beam. Too small a value
makes the first attempt miss the tolerance, and costs another; too large a value costs unknowns. For
every value this prints the share of beams solved at the first attempt, the mean number of unknowns
of the accepted mesh, and the mean of n^3 over all attempts, the work of the eigenproblems, relative
to that of the value in use. The best value has the least work; error bars hold for any.
The beams are those of scripts/measure_error_bars.py, drawn over everything that is accepted.
"""

from contextlib import suppress
from functools import partial
from typing import Any
from unittest.mock import patch

import _script
import numpy as np
from oracle.error_bars import random_scene  # type: ignore[import-not-found]

from beamviz.errors import BeamvizError
from beamviz.solver import solve
from beamviz.solver.hp import mesh_design
from beamviz.solver.hp.refinement import Refinement


def main() -> None:
    """Measure the value in use and those given."""
    known = vars(mesh_design).items()
    numbers = [name for name, x in known if name.isupper() and isinstance(x, int | float)]
    parser = _script.Parser(__doc__)
    parser.add_argument("constant", choices=numbers)
    parser.add_argument("values", type=float, nargs="+")
    parser.add_argument("--beams", type=_script.count, default=300)
    parser.add_argument("--tolerance", type=float, help="in place of that of each random beam")
    given = parser.parse_args()
    measured = partial(measure, given.constant, count=given.beams, tolerance=given.tolerance)
    in_use = float(getattr(mesh_design, given.constant))
    reference = measured(in_use)
    _script.print_row(given.constant, "first attempt", "unknowns", "work", "unsolved")
    for value in sorted({in_use, *given.values}):
        first, unknowns, work, unsolved = measured(value)
        mark = " (in use)" if value == in_use else ""
        _script.print_row(f"{value:g}{mark}", first, unknowns, work / reference[2], unsolved)


def measure(
    name: str, value: float, count: int, tolerance: float | None
) -> tuple[float, float, float, int]:
    """Share of beams solved at the first attempt, mean unknowns of a family, mean n^3 over all
    attempts, and how many beams have no answer, with a constant at a value."""
    sizes: list[int] = []
    solve_stack = Refinement.solve_stack

    def counted(self: Refinement, places: Any, mesh: Any) -> None:
        sizes.append(len(mesh.points))
        solve_stack(self, places, mesh)

    attempts: list[list[int]] = []
    with (
        patch.object(mesh_design, name, type(getattr(mesh_design, name))(value)),
        patch.object(Refinement, "solve_stack", counted),
    ):
        for scene in map(random_scene, range(count)):
            options = scene.options | ({"tolerance": tolerance} if tolerance else {})
            sizes.clear()
            with suppress(BeamvizError):
                solve(scene.beam, **options)
                attempts.append([*sizes])
    rows = [(len(one) == 1, one[-1], sum(n**3 for n in one)) for one in attempts]
    first, last, work = np.mean(rows, axis=0).tolist()
    return first, last, work, count - len(attempts)


if __name__ == "__main__":
    main()
