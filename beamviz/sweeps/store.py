"""A sweep: its axes, the numbers and options that do not vary, its chunks, and its Zarr store.

The store is made once, filled chunk by chunk, and resumed after any interruption. Every
array has the same chunks; a task writes one chunk of each, `status` last. zarr writes a chunk into
a temporary file that it renames, so a chunk of `status` is there if and only if the task is done,
however it or others were interrupted. Signals are deferred until zarr has returned: its
asynchronous tasks would print warnings on stderr if they were abandoned.
"""

import contextlib
import errno
import itertools
import math
import os
import shutil
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from beamviz.beam import NUMBERS, Beam, Units, exact_text
from beamviz.errors import InvalidInput, Unavailable, requires
from beamviz.files import check_suffix, temporary
from beamviz.frequency_loci.path import check_values
from beamviz.signals import defer_signals
from beamviz.solver import METHODS, Problem, parse_keywords, solve_many
from beamviz.solver.problem import OPTIONS
from beamviz.version import __version__

MAX_AXES = 5
MAX_VALUES = 1_000_000  # of an axis
ROUNDING = 1e-9  # relative, of a value of an axis that is named again
# Beams of a chunk: about a second of work, so that a cluster's scheduler keeps up, and few enough
# files. A small sweep has about TASKS of them, for all processes to have some.
FAST, COUPLED, SLOW = 16384, 4096, 256
LEAST, LEAST_SLOW = 1024, 16
TASKS = 32
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

Task = tuple[int, ...]  # a chunk, by its position along each axis
Region = tuple[slice, ...]  # of the arrays


@dataclass(frozen=True)
class Plan:
    """Every combination of the values of some parameters of a beam. axes: the values (n,) by
    parameter, in the order of the dimensions. beam: holds the other numbers."""

    axes: dict[str, np.ndarray]
    beam: Beam
    problem: Problem

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Numbers of values."""
        return tuple(map(len, self.axes.values()))

    @cached_property
    def line(self) -> int:
        """The axis along which beams are solved together: the longest, also of a chunk."""
        return self.shape.index(max(self.shape))

    @cached_property
    def smooth(self) -> bool:
        """Whether omega^2 of each mode is a smooth function of the parameters."""
        hp = METHODS[self.problem.method].package == "hp"
        spin_up = self.beam.spin_up or "spin_up" in self.axes
        return hp and self.problem.state == "straight" and not spin_up

    @cached_property
    def chunk(self) -> tuple[int, ...]:
        """Numbers of values of a chunk: whole lines, if they are not too long, and neighbours. They
        follow from the arguments alone: what is solved together, hence every digit, must not depend
        on the machine."""
        most, least = COUPLED if self.problem.gyroscopic else FAST, LEAST
        if not self.smooth:
            most, least = SLOW, LEAST_SLOW
        left = min(most, max(math.prod(self.shape) // TASKS, least))
        chunk = [1] * len(self.shape)
        names = list(self.axes)  # beams with their mass at one place share their meshes
        others = sorted(range(len(names)), key=lambda axis: (names[axis] == "beta", -axis))
        for axis in (self.line, *others):
            if chunk[axis] == 1:
                pieces = math.ceil(self.shape[axis] / max(left, 1))
                chunk[axis] = math.ceil(self.shape[axis] / pieces)
                left //= chunk[axis]
        return tuple(chunk)

    @cached_property
    def tasks(self) -> list[Task]:
        counts = [math.ceil(n / c) for n, c in zip(self.shape, self.chunk, strict=True)]
        return list(itertools.product(*map(range, counts)))

    def region(self, task: Task) -> Region:
        """The region of a chunk in the arrays."""
        ends = zip(task, self.chunk, self.shape, strict=True)
        return tuple(slice(k * c, min((k + 1) * c, n)) for k, c, n in ends)

    def part(self, task: Task) -> "Plan":
        """The sweep over the values of a chunk."""
        axes = zip(self.axes.items(), self.region(task), strict=True)
        return replace(self, axes={name: values[region] for (name, values), region in axes})

    @property
    def arguments(self) -> dict[str, Any]:
        """The arguments of this sweep besides its axes, by name, in the types of JSON; units unless
        they vary, as over mu."""
        fixed = {name: getattr(self.beam, name) for name in NUMBERS if name not in self.axes}
        units = self.beam.units if "mu" not in self.axes else None
        return {**fixed, **self.problem.options, **(units.attributes if units else {})}


def make_plan(axes: Mapping[str, ArrayLike], beam: Beam, **options: Any) -> Plan:
    """The sweep of validated arguments; InvalidInput names what is wrong."""
    if not axes:
        raise InvalidInput(f"no axis is given: name one or more of {', '.join(NUMBERS)}")
    if len(axes) > MAX_AXES:
        raise InvalidInput(f"{len(axes)} axes, {', '.join(axes)}: must be at most {MAX_AXES}")
    values = {
        name: check_values("axis", name, given, 1, MAX_VALUES) for name, given in axes.items()
    }
    extremes = {name: float(array[0 if name == "mu" else -1]) for name, array in values.items()}
    beam = beam.replace(**extremes)  # its units are kept; raises where gamma / mu is too large
    return Plan(values, beam, parse_keywords(**options))


def find_place(
    axes: Mapping[str, np.ndarray], over: Sequence[str], at: Mapping[str, float]
) -> dict[str, int]:
    """The position on each axis of a sweep but those in `over`, by its value; an axis of one value
    needs none. InvalidInput names what is wrong."""
    known = ", ".join(axes)
    for name in over:
        if name not in axes or len(axes[name]) < 2:
            fault = "has one value in" if name in axes else "is no axis of"
            raise InvalidInput(f"over {name}: {name} {fault} this sweep, which is over {known}")
    for name, value in at.items():
        if name not in axes or name in over:
            fault = "varies" if name in over else f"is no axis of this sweep, which is over {known}"
            raise InvalidInput(f"at {name}={value:g}: {name} {fault}")
    place = {}
    for name in (name for name in axes if name not in over):
        values = axes[name]
        if name not in at and len(values) > 1:
            ends = f"{values[0]:g} .. {values[-1]:g}"
            raise InvalidInput(f"at: {name} is missing, one of its {len(values)} values {ends}")
        value = at.get(name, values[0])
        place[name] = k = int(abs(values - value).argmin())
        if not abs(values[k] - value) <= ROUNDING * abs(value):
            near = exact_text(float(values[k]))
            raise InvalidInput(f"at {name}={value:g}: not in this sweep; the nearest is {near}")
    return place


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
    with requires("sweep"):
        import zarr
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
    with requires("sweep"):
        import zarr
    try:
        group = zarr.open_group(path, mode="r+")
    except (FileNotFoundError, FileExistsError, NotADirectoryError, ValueError, KeyError):
        group = None  # nothing, a file, or metadata of something else
    if group is None or group.attrs.get("format") != FORMAT:
        raise InvalidInput(f"{path}: is no sweep of this program; name another store")
    return group


@defer_signals()
def stored_plan(path: Path) -> Plan:
    """The sweep that a store was made for."""
    group = open_group(path)
    attributes = group.attrs
    fixed = {name: attributes[name] for name in NUMBERS if name in attributes}
    sizes = [attributes[name] for name in ("unit_length_m", "unit_time_s") if name in attributes]
    units = Units(*sizes) if sizes else None
    try:
        arrays = {name: group[name] for name in ARRAYS}
        axes = {name: group[name][:] for name in arrays["status"].metadata.dimension_names}
        options = {name: attributes[name] for name in OPTIONS}
    except KeyError as error:
        raise InvalidInput(
            f"{path}: {error} is missing: damaged, or of beamviz"
            f" {attributes.get('beamviz_version')}, and this is {__version__}; name another store"
        ) from None
    return make_plan(axes, Beam(**fixed, units=units), **options)


@defer_signals()
def write_chunk(path: Path, region: Region, arrays: dict[str, np.ndarray]) -> None:
    """Write the results of a chunk, `status` last."""
    group = open_group(path)
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
