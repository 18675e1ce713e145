"""Results as labelled arrays for xarray, made of plain columns; also for files in netCDF."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import requires
from beamviz.frequency_loci.branches import Branch
from beamviz.units import Units, usual_measure
from beamviz.version import __version__

if TYPE_CHECKING:
    import xarray

QUANTITIES = ("family", "frequency", "growth_rate", "error", "bending_fraction")  # of a mode
PER_TIME = {"units": "1/T*"}
UNITS = {"frequency": PER_TIME, "growth_rate": PER_TIME, "error": PER_TIME}
LOADS = {"force": "E I / L^2", "shear": "E I / L^2", "moment": "E I / L"}  # of the root section


def attributes(beam: Beam, model: Mapping[str, Any], units: Units | None) -> dict[str, Any]:
    """The numbers of a beam, its blade and masses as JSON, its model, its units and the version;
    as files hold them."""
    sizes = units.attributes if units else {}
    return in_files({**beam.attributes, **model, **sizes, "beamviz_version": __version__})


def in_files(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Attributes as files in netCDF hold them, which have no None and no truth values: without
    None, True as 1 and False as 0."""
    given = {name: value for name, value in attributes.items() if value is not None}
    return {name: int(v) if isinstance(v, bool) else v for name, v in given.items()}


def mode_dataset(
    modes: Mapping[str, Any], along: Mapping[str, np.ndarray], attributes: Mapping[str, Any]
) -> "xarray.Dataset":
    """The Dataset of a solution, of `Solution.columns` and `Solution.along_beam`.

    With Coriolis forces shapes are complex: `shape` is their real part and `shape_imag` the
    imaginary one, because netCDF has no complex numbers.
    """
    with requires("xarray"):
        import xarray
    variables: dict[str, Any] = {
        key: ("mode", np.array(modes[key]), UNITS.get(key)) for key in QUANTITIES
    }
    if "in_plane_fraction" in modes:
        variables["in_plane_fraction"] = ("mode", modes["in_plane_fraction"])
    dims, shape, note = ("mode", "x", "component"), along["shape"], {"long_name": "unit modal mass"}
    variables["shape"] = (dims, shape.real, note)
    if np.iscomplexobj(shape):
        variables["shape_imag"] = (dims, shape.imag, note)
    components, position = ["along", "across"], along["position"]
    if shape.shape[-1] == 3:
        components = ["along", "in_plane", "out_of_plane"]
        position = np.column_stack((position, np.zeros(len(position))))
    variables["position"] = (("x", "component"), position, {"units": "L"})
    variables["stretch"] = ("x", along["stretch"])
    for name, unit in LOADS.items():
        variables[name] = ("x", along[name], {"units": unit})
    coordinates = {
        "mode": modes["index"],
        "label": ("mode", np.array(modes["label"])),
        "x": ("x", along["x"], {"units": "L"}),
        "component": components,
    }
    return xarray.Dataset(variables, coordinates, attributes)


def loci_dataset(
    over: str,
    values: np.ndarray,
    branches: Sequence[Branch],
    attributes: Mapping[str, Any],
    units: Units | None = None,
) -> "xarray.Dataset":
    """The Dataset of loci: each quantity by value and branch; where the size is known, frequencies
    in Hz, and the parameter in its usual unit, as rpm, as a second coordinate."""
    with requires("xarray"):
        import xarray
    rows = {key: [getattr(branch, key) for branch in branches] for key in QUANTITIES}
    if branches[0].in_plane_fraction is not None:
        rows["in_plane_fraction"] = [branch.in_plane_fraction for branch in branches]
    rows["family"] = [[name or "" for name in family] for family in rows["family"]]
    fixed = {name: value for name, value in attributes.items() if name != over}
    coordinates: dict[str, Any] = {over: values, "branch": [branch.label for branch in branches]}
    data = xarray.Dataset(
        {key: ((over, "branch"), np.transpose(row), UNITS.get(key)) for key, row in rows.items()},
        coordinates,
        fixed,
    )
    if units is None:
        return data
    return data.assign_coords(in_si(over, values, units)).assign_coords(
        hertz=((over, "branch"), units.hertz(data["frequency"].values), {"units": "Hz"})
    )


def in_si(over: str, values: np.ndarray, units: Units) -> dict[str, Any]:
    """A coordinate of the values of a parameter in its usual unit; {} for one without a unit."""
    measure = usual_measure(over, units)
    if measure is None:
        return {}
    return {measure.scale.key: (over, measure.factor * values, {"units": measure.scale.unit})}


def motion_dataset(
    columns: Mapping[str, np.ndarray], attributes: Mapping[str, Any]
) -> "xarray.Dataset":
    """The Dataset of a motion in time, of `Motion.columns`."""
    with requires("xarray"):
        import xarray
    tip = np.column_stack((columns["tip_x"], columns["tip_y"]))
    return xarray.Dataset(
        {
            "gamma": ("t", columns["gamma"], PER_TIME),
            "angle": ("t", columns["angle"], {"units": "rad"}),
            "tip": (("t", "component"), tip, {"units": "L"}),
            "energy": ("t", columns["energy"], {"units": "E I / L"}),
        },
        {"t": ("t", columns["t"], {"units": "T*"}), "component": ["along", "across"]},
        attributes,
    )
