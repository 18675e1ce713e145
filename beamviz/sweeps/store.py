"""The Zarr store of a sweep: made once, filled chunk by chunk, resumed after any interruption.

Every array has the same chunks. A task writes one chunk of each, `status` last; zarr writes a chunk
into a temporary file that it renames. Every chunk is a file, even one without a number, and has a
checksum: so a chunk that is missing or damaged is recognised, and computed again. The metadata are
complete, and consolidated, from the start. Signals are deferred until zarr has returned: its
asynchronous tasks would print warnings on stderr if they were abandoned.
"""

import contextlib
import errno
import os
import threading
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from beamviz.beam import NUMBERS, Beam
from beamviz.datasets import in_files
from beamviz.errors import InvalidInput, Unavailable, requires
from beamviz.files import check_suffix, discard, temporary, unfinished
from beamviz.signals import defer_signals
from beamviz.solver import solve_many
from beamviz.solver.problem import OPTIONS, options_in
from beamviz.sweeps.arrays import ARRAYS, STATUSES, Arrays, solve_chunk
from beamviz.sweeps.plan import Chunk, Plan, Region, axis_text, make_plan
from beamviz.units import Units
from beamviz.version import __version__

FORMAT = "beamviz sweep 2"
DESCRIPTION = ("title", "format", "beamviz_version")  # attributes that are no arguments
NO_ROOM = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)
DAMAGED = (OSError, RuntimeError, ValueError)  # RuntimeError: of zarr's decoders

RECORDED = (*NUMBERS, "blade", "masses", "root")  # attributes of the beam
WRITING = threading.Lock()  # zarr's configuration is one for all threads


@defer_signals()
def open_store(plan: Plan, path: Path) -> list[Chunk]:
    """Make the store of a sweep, or find it begun; the chunks that are left. Raises InvalidInput
    where it is the store of another sweep, Unavailable where it cannot be written."""
    check_suffix(path, (".zarr",))
    with written(path):
        if not path.exists() and created(plan, path):
            return plan.chunks
        group = open_group(path)
        check_same(plan, group, path)
        left = [chunk for chunk in plan.chunks if not is_intact(path, chunk)]
        if left:
            version = group.attrs["beamviz_version"]  # of the chunks that are there
            check_equal(path, "beamviz_version", version, __version__)
            for unfinished in path.rglob("*.partial"):
                unfinished.unlink(missing_ok=True)
            if not os.access(path / "status", os.W_OK):
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        write_coordinates(plan, group)
    return left


def created(plan: Plan, path: Path) -> bool:
    """Make the store of a sweep; False where another process has made one meanwhile."""
    solve_many([plan.beam], **plan.problem.options)  # raises where options do not fit
    part = temporary(path)
    unfinished.add(part)
    try:
        part.mkdir()
        make_store(plan, part)
        part.rename(path)
    except OSError:
        if not path.exists():
            raise
        return False
    finally:
        discard(part)
    return True


def solve_and_write(path: Path, region: Region, part: Plan) -> None:
    """Solve the part of a sweep that is a chunk of its store, and write it."""
    write_chunk(path, region, solve_chunk(part))


@defer_signals()
def write_chunk(path: Path, region: Region, arrays: Arrays) -> None:
    """Write the results of a chunk, `status` last."""
    with requires("sweep"):
        import zarr
    with WRITING, zarr.config.set({"array.write_empty_chunks": True}), written(path):
        group = open_group(path)
        for name in ARRAYS:
            group[name][region] = arrays[name]


@contextlib.contextmanager
def written(path: Path) -> Iterator[None]:
    """Within, failures to write a part of a store are Unavailable, with the remedy."""
    try:
        yield
    except OSError as error:
        kept = "what is written is kept; " if path.exists() else ""
        remedy = "make room there, or choose" if error.errno in NO_ROOM else "choose"
        raise Unavailable(
            f"cannot write {path}: {error.strerror or error}; {kept}{remedy} another place"
        ) from None


@contextlib.contextmanager
def chunks_read(path: str | Path) -> Iterator[None]:
    """Within, failures to read a chunk of a store are Unavailable, with the remedy."""
    try:
        yield
    except DAMAGED as error:
        raise damaged_chunk(path, str(error)) from None


def damaged_chunk(path: str | Path, fault: str) -> Unavailable:
    """The error of a chunk that cannot be read."""
    return Unavailable(
        f"cannot read {path}: {fault}; a chunk of it is damaged or missing: run the same sweep"
        " again, which computes that chunk again"
    )


def make_store(plan: Plan, path: Path) -> None:
    """The store of a sweep without results: all metadata, and the coordinates."""
    with requires("sweep"):
        import zarr
        from zarr.codecs import ZstdCodec
    group = zarr.create_group(
        path,
        attributes={
            "title": "Natural frequencies of a rotating beam with a concentrated mass",
            "format": FORMAT,
            "beamviz_version": __version__,
            **in_files(plan.arguments),
        },
    )
    for name, values in coordinates(plan).items():
        label = NUMBERS[name].axis_label if name in NUMBERS else "number by frequency"
        group.create_array(
            name,
            shape=values.shape,
            chunks=values.shape,
            dtype=values.dtype,
            dimension_names=[name],
            attributes={"long_name": label, "units": "1", "summary": axis_text(values)},
        )
    for name, array in ARRAYS.items():
        by_mode = (plan.problem.modes,) * len(array.extra)
        group.create_array(
            name,
            shape=plan.shape + by_mode,
            chunks=plan.chunk_shape + by_mode,
            dtype=array.dtype,
            fill_value=array.empty,
            dimension_names=[*plan.axes, *array.extra],
            compressors=ZstdCodec(checksum=True),
            attributes=array.attributes,
        )
    write_coordinates(plan, group)
    with warnings.catch_warnings():  # zarr warns that others may not read them; xarray wants them
        warnings.filterwarnings("ignore", "Consolidated metadata", UserWarning)
        zarr.consolidate_metadata(path)


def coordinates(plan: Plan) -> Arrays:
    """The values of the dimensions."""
    return {**plan.axes, "mode": np.arange(1, plan.problem.modes + 1)}


def write_coordinates(plan: Plan, group: Any) -> None:
    """Write the coordinates that are missing or damaged."""
    for name, values in coordinates(plan).items():
        with contextlib.suppress(*DAMAGED):
            if np.array_equal(group[name][:], values):
                continue
        group[name][:] = values


def is_intact(path: Path, chunk: Chunk) -> bool:
    """Whether a chunk of every array is there and agrees with its checksum. (Read through zarr,
    this would take 30 times as long.)"""
    with requires("sweep"):
        from numcodecs import Zstd
    zstd = Zstd()
    for name, array in ARRAYS.items():
        place = *chunk, *[0] * len(array.extra)
        try:
            zstd.decode(path.joinpath(name, "c", *map(str, place)).read_bytes())
        except DAMAGED:  # a missing one would be read as empty
            return False
    return True


def check_same(plan: Plan, group: Any, path: Path) -> None:
    """InvalidInput that names the first difference where a store is not that of a sweep."""
    names = group["status"].metadata.dimension_names
    old = {"axes": ", ".join(names)}
    old |= {f"values of {name}": group[name].attrs["summary"] for name in names}
    arguments = {name: group.attrs[name] for name in group.attrs if name not in DESCRIPTION}
    arguments |= options_in(group.attrs)
    old |= {name: repr(value) for name, value in arguments.items()}
    new = {"axes": ", ".join(plan.axes)}
    new |= {f"values of {name}": axis_text(values) for name, values in plan.axes.items()}
    new |= {name: repr(value) for name, value in plan.arguments.items()}
    for name in old | new:
        check_equal(path, name, old.get(name, "none"), new.get(name, "none"))


def check_equal(path: Path, name: str, old: str, new: str) -> None:
    """InvalidInput where an argument is another one than that of the store."""
    if old != new:
        raise InvalidInput(
            f"{path} was made with {name} = {old}, not {new}: give the same arguments to resume it,"
            " or name another store"
        )


def open_group(path: Path) -> Any:
    """The store as a zarr group; InvalidInput where it is none of a sweep, or misses a part."""
    with requires("sweep"):
        import zarr
    group: Any
    try:
        group = zarr.open_group(path, mode="r+", use_consolidated=False)
    except (FileNotFoundError, FileExistsError, NotADirectoryError, ValueError, KeyError):
        group = None  # nothing, a file, or metadata of something else
    if group is None or group.attrs.get("format") != FORMAT:
        raise InvalidInput(
            f"{path}: is no sweep of this program, or one of another version; name another store"
        )
    try:
        for name, option in OPTIONS.items():
            if option.default is not None:
                group.attrs[name]
        for name in (*ARRAYS, *group["status"].metadata.dimension_names):
            group[name]
    except KeyError as error:
        made = group.attrs.get("beamviz_version")
        raise InvalidInput(
            f"{path}: {error} is missing: damaged, or of beamviz {made}, and this is {__version__};"
            " name another store"
        ) from None
    return group


@defer_signals()
def stored_plan(path: Path) -> Plan:
    """The sweep that a store was made for."""
    group = open_group(path)
    attributes, axes = group.attrs, {}
    for name in group["status"].metadata.dimension_names:
        with chunks_read(path):
            axes[name] = group[name][:]
        if axis_text(axes[name]) != group[name].attrs["summary"]:
            raise damaged_chunk(path, f"the values of {name} are missing")
    fixed = {name: attributes[name] for name in RECORDED if name in attributes}
    beam = Beam.from_record(fixed, units=Units.from_attributes(attributes))
    return make_plan(axes, beam, **options_in(attributes))


def count_statuses(path: Path) -> dict[str, int]:
    """How many beams of a store have each status."""
    plan, status = stored_plan(path), open_group(path)["status"]
    counts = np.zeros(len(STATUSES), int)
    with chunks_read(path):
        for chunk in plan.chunks:
            counts += np.bincount(status[plan.region(chunk)].ravel(), minlength=len(STATUSES))
    return {name: count for name, count in zip(STATUSES, counts.tolist(), strict=True) if count}
