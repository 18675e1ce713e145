"""The Zarr store of a sweep: made once, filled chunk by chunk, resumed after any interruption.

Every array has the same chunks; a task writes one chunk of each, `status` last. zarr writes a chunk
into a temporary file that it renames, so a chunk of `status` is there if and only if the task is
done, however it or others were interrupted. Signals are deferred until zarr has returned: its
asynchronous tasks would print warnings on stderr if they were abandoned.
"""

import contextlib
import errno
import os
import shutil
import zlib
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from beamviz import __version__
from beamviz.beam import NUMBERS, Beam, Units, exact_text
from beamviz.errors import InvalidInput, Unavailable, optional
from beamviz.files import check_suffix, temporary
from beamviz.signals import defer_signals
from beamviz.solver import DEFAULTS, solve_many
from beamviz.sweeps.plan import Plan, Task, make_plan

STATUSES = ("not computed", "solved", "unstable", "no equilibrium", "not converged")
FAMILIES = ("bending", "stretching", "mixed")
ERROR = "estimated absolute error of frequency or growth rate"
MODES = ("mode",)  # the last dimension of most arrays
ARRAYS: dict[str, tuple[str, tuple[str, ...], float, dict[str, Any]]] = {
    # type, dimensions beyond the axes, value where there is none, attributes
    "frequency": ("f8", MODES, np.nan, {"long_name": "frequency", "units": "1/T*"}),
    "error": ("f4", MODES, np.nan, {"long_name": ERROR, "units": "1/T*"}),
    "growth_rate": ("f8", MODES, np.nan, {"long_name": "growth rate", "units": "1/T*"}),
    "family": ("i1", MODES, -1, {"long_name": "family"}),
    "limit": ("f8", (), np.nan, {"long_name": "largest gamma with an equilibrium"}),
    "status": ("i1", (), 0, {}),
}
FLAGS = {"family": FAMILIES, "status": STATUSES}
FORMAT = "beamviz sweep 1"
NO_ROOM = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)


@defer_signals()
def open_store(plan: Plan, path: Path) -> list[Task]:
    """Make the store of a sweep, or find it begun; the tasks that are left. Raises InvalidInput
    where it is the store of another sweep, Unavailable where it cannot be written."""
    check_suffix(path, (".zarr",))
    with written(path):
        if not path.exists():
            solve_many([plan.beam], **plan.problem.options)  # raises where options do not fit
            part = temporary(path)
            try:
                part.mkdir()
                _create(plan, part)
                part.rename(path)
            finally:
                shutil.rmtree(part, ignore_errors=True)
        chunks = path / "status" / "c"
        left = [task for task in plan.tasks if not chunks.joinpath(*map(str, task)).exists()]
        check_same(plan, path, bool(left))
        for unfinished in path.rglob("*.partial") if left else ():
            unfinished.unlink(missing_ok=True)
        if left and not os.access(path / "status", os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    return left


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
    except (OSError, RuntimeError) as error:  # RuntimeError: of zarr's decoders
        raise Unavailable(
            f"cannot read {path}: {error}; a chunk of it is damaged: delete the store and run the"
            " sweep again"
        ) from None


def _create(plan: Plan, path: Path) -> None:
    """The template of a sweep: all metadata, and the coordinates."""
    zarr = optional("zarr", "sweep")
    group = zarr.create_group(
        path,
        attributes={
            "title": "Natural frequencies of a rotating beam with a concentrated mass",
            "format": FORMAT,
            "beamviz_version": __version__,
            **plan.arguments,
        },
    )
    modes = np.arange(1, plan.problem.modes + 1)
    for name, values in {**plan.axes, "mode": modes}.items():
        label = NUMBERS[name].axis_label if name in NUMBERS else "number by frequency"
        group.create_array(
            name,
            data=values,
            chunks=values.shape,
            dimension_names=[name],
            attributes={"long_name": label, "units": "1"},
        )
    for name, (kind, extra, empty, about) in ARRAYS.items():
        if codes := FLAGS.get(name):
            meanings = " ".join(code.replace(" ", "_") for code in codes)
            about = {**about, "flag_meanings": meanings, "flag_values": list(range(len(codes)))}
        group.create_array(
            name,
            shape=plan.shape + (plan.problem.modes,) * len(extra),
            chunks=plan.chunk + (plan.problem.modes,) * len(extra),
            dtype=kind,
            fill_value=empty,
            dimension_names=[*plan.axes, *extra],
            attributes=about,
        )


def check_same(plan: Plan, path: Path, unfinished: bool) -> None:
    """InvalidInput that names the first difference where a store is not that of a sweep."""
    group, other = open_group(path), stored_plan(path)
    old, new = ({"axes": ", ".join(one.axes)} for one in (other, plan))
    for one, texts in ((other, old), (plan, new)):
        texts |= {f"values of {name}": axis_text(values) for name, values in one.axes.items()}
        texts |= {name: repr(value) for name, value in one.arguments.items()}
    if unfinished:
        old["beamviz_version"], new["beamviz_version"] = group.attrs["beamviz_version"], __version__
    for name in old | new:
        before, now = (texts.get(name, "none") for texts in (old, new))
        if before != now:
            raise InvalidInput(
                f"{path} was made with {name} = {before}, not {now}: give the same arguments to"
                " resume it, or name another store"
            )


def open_group(path: Path) -> Any:
    """The store as a zarr group; InvalidInput where it is none of a sweep."""
    zarr = optional("zarr", "sweep")
    try:
        group = zarr.open_group(path, mode="r+")
    except (FileNotFoundError, FileExistsError, NotADirectoryError, ValueError, KeyError):
        group = None  # nothing, a file, or metadata of something else
    if group is None or group.attrs.get("format") != FORMAT:
        raise InvalidInput(f"{path}: is no sweep of this program; name another store")
    return group


def stored_plan(path: Path) -> Plan:
    """The sweep that a store was made for, read once."""
    made = None
    with contextlib.suppress(OSError):  # of no store, which is reported when it is opened
        metadata = (path / "zarr.json").stat()
        made = metadata.st_ino, metadata.st_mtime_ns  # others where it was deleted and made anew
    return _read_plan(path, made)


@lru_cache(maxsize=4)
@defer_signals()
def _read_plan(path: Path, made: tuple[int, int] | None) -> Plan:
    """The sweep that a store was made for. made: identifies its metadata."""
    group = open_group(path)
    attributes = group.attrs
    fixed = {name: attributes[name] for name in NUMBERS if name in attributes}
    sizes = [attributes[name] for name in ("unit_length_m", "unit_time_s") if name in attributes]
    units = Units(*sizes) if sizes else None
    try:
        arrays = {name: group[name] for name in ARRAYS}
        axes = {name: group[name][:] for name in arrays["status"].metadata.dimension_names}
        options = {name: attributes[name] for name in DEFAULTS}
    except KeyError as error:
        raise InvalidInput(
            f"{path}: {error} is missing: damaged, or of beamviz"
            f" {attributes.get('beamviz_version')}, and this is {__version__}; name another store"
        ) from None
    return make_plan(axes, Beam(**fixed, units=units), **options)


@defer_signals()
def write_chunk(path: Path, plan: Plan, task: Task, arrays: dict[str, np.ndarray]) -> None:
    """Write the results of a task, `status` last."""
    group, region = open_group(path), plan.region(task)
    with written(path):
        for name in ARRAYS:
            group[name][region] = arrays[name]


def count_statuses(path: Path) -> dict[str, int]:
    """How many beams of a store have each status."""
    plan, status = stored_plan(path), open_group(path)["status"]
    counts = np.zeros(len(STATUSES), int)
    with chunks_read(path):
        for task in plan.tasks:
            counts += np.bincount(status[plan.region(task)].ravel(), minlength=len(STATUSES))
    return {name: count for name, count in zip(STATUSES, counts.tolist(), strict=True) if count}


def axis_text(values: np.ndarray) -> str:
    """A short text of the values of an axis."""
    texts = [exact_text(value) for value in values.tolist()]
    if len(texts) <= 6:
        return ", ".join(texts)
    checksum = f"{zlib.crc32(values.tobytes()):08x}"
    return f"{texts[0]} .. {texts[-1]} ({len(texts)} values, checksum {checksum})"
