"""sweep(axes, out): every combination of parameters, in parallel, into a Zarr store."""

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from beamviz.beam import Beam
from beamviz.datasets import in_si
from beamviz.errors import InvalidInput, requires, unknown_keyword
from beamviz.solver.problem import OPTIONS
from beamviz.sweeps.arrays import ARRAYS
from beamviz.sweeps.plan import find_place, make_plan
from beamviz.sweeps.run import Report, run
from beamviz.sweeps.store import stored_plan

if TYPE_CHECKING:
    import xarray


def sweep(
    axes: Mapping[str, ArrayLike],
    out: str | Path | None,
    modes: int = 5,
    executor: Any = None,
    *,
    beam: Beam | None = None,
    workers: int | None = None,
    progress: Report | None = None,
    **options: Any,
) -> "xarray.Dataset":
    """Frequencies of every combination of parameters, as a Zarr store and an xarray Dataset.

    axes: ascending values by parameter, up to five: {"gamma": values, "alpha": values, ...}; of a
    beam in SI also in a unit, as {"rpm": values, "kg": values} (see `loci`). out:
    the store, "NAME.zarr"; None: none is kept, the Dataset is in memory. executor: a
    concurrent.futures.Executor or a Dask Client; by default `workers` processes of this machine
    (all cores; in a script, call it under `if __name__ == "__main__"`). beam: the numbers that do
    not vary. progress: called with a Progress after each chunk. options: as for solve().

    The Dataset, which reads the store as it is used, has frequency, error and growth_rate [1/T*]
    and family by mode, and status and limit of each beam; codes are named in `flag_meanings`.

    Interrupted at any moment and called again with the same arguments, it resumes. Raises
    InvalidInput, also where the store was made with other arguments, and Unavailable.
    """
    for name in options.keys() - OPTIONS.keys():
        raise unknown_keyword(
            "keyword", name, (*OPTIONS, "axes", "out", "executor", "beam", "workers", "progress")
        )
    if executor is not None and not hasattr(executor, "submit"):
        raise InvalidInput(
            f"executor = {executor!r}: must be a concurrent.futures.Executor or a Dask Client"
        )
    with requires("sweep"):
        import xarray  # noqa: F401
        import zarr  # noqa: F401
    plan = make_plan(axes, beam or Beam(), modes=modes, **options)
    if out is not None:
        run(plan, Path(out), executor, workers, progress)
        return open_sweep(out)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sweep.zarr"
        run(plan, path, executor, workers, progress)
        return open_sweep(path).load()


def open_sweep(path: str | Path) -> "xarray.Dataset":
    """The store of a sweep as a Dataset that reads it as it is used; of a beam in SI with its axes
    in their usual units, as rpm, as further coordinates."""
    with requires("sweep"):
        import xarray
    plan = stored_plan(Path(path))
    data = xarray.open_dataset(path, engine="zarr")[list(ARRAYS)]
    if plan.beam.units is None:
        return data
    rows = (in_si(name, values, plan.beam.units) for name, values in plan.axes.items())
    return data.assign_coords({key: row for each in rows for key, row in each.items()})


def open_line(
    path: Path, over: str, at: Mapping[str, float]
) -> tuple[Beam, list[float], dict[str, Any]]:
    """A line of a store: its beam, the values along one axis, and the options of `solve`. at:
    values of the other axes; those of one value need none."""
    plan = stored_plan(path)
    place = find_place(plan.axes, [over], at, plan.beam.units)
    beam = plan.beam.replace(**{name: float(plan.axes[name][k]) for name, k in place.items()})
    return beam, plan.axes[over].tolist(), plan.problem.options
