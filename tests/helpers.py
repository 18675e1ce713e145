"""Scripts as modules, marks for parts of a parametrised test, comparable results, and memory."""

import gc
import importlib.util
import json
import sys
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from beamviz.beam import Beam
from beamviz.drawing.modes import SampledModes
from beamviz.frequency_loci import Loci
from beamviz.solver import solve
from beamviz.solver.solution import Solution
from beamviz.units import Units

SCRIPTS = Path(__file__).resolve().parents[1] / "scripts"


@contextmanager
def traced_memory() -> Iterator[Callable[[], tuple[float, float]]]:
    """A function that tells how much of the memory [MB] allocated since is kept, and the most of it
    at any time."""

    def memory() -> tuple[float, float]:
        gc.collect()
        kept, most = tracemalloc.get_traced_memory()
        return kept / 1e6, most / 1e6

    tracemalloc.start()
    try:
        yield memory
    finally:
        tracemalloc.stop()


def load_script(name: str) -> ModuleType:
    """A fresh copy of a script as a module, its neighbours importable."""
    if str(SCRIPTS) not in sys.path:
        sys.path.append(str(SCRIPTS))
    return load_file(SCRIPTS / f"{name}.py")


def load_file(file: Path) -> ModuleType:
    """A fresh copy of a Python file as a module."""
    spec = importlib.util.spec_from_file_location(f"script_{file.stem}", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def slow(*values: Any) -> list[Any]:
    """Parameters, or tuples of them, for which a test is marked slow."""
    several = (value if isinstance(value, tuple) else (value,) for value in values)
    return [pytest.param(*one, marks=pytest.mark.slow) for one in several]


def strict(text: str) -> Any:
    """JSON read by a parser that refuses NaN and Infinity."""

    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is not JSON")

    return json.loads(text, parse_constant=refuse)


def contents(folder: Path) -> dict[str, bytes]:
    """The bytes of every file in a folder, by name."""
    paths = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


def within_the_bars(found: Solution, reference: Solution, slack: Any = 0.0) -> bool:
    """Whether omega^2 of two solutions differ by no more than their errors, and a slack."""
    error = abs(found.omega_squared - reference.omega_squared)
    allowed = found.omega_squared_errors + reference.omega_squared_errors + slack
    return bool(np.all(error <= allowed))


def differences(found: Solution, reference: Solution) -> tuple[np.ndarray, np.ndarray]:
    """The differences (modes,) of frequencies from those of the same label, and the sums of both
    errors."""
    own = [reference.labels.index(label) for label in found.labels]
    return abs(found.frequencies - reference.frequencies[own]), found.errors + reference.errors[own]


def sampled(beam: Beam, before: SampledModes | None = None, **options: Any) -> SampledModes:
    """The modes of a beam as they are drawn, with the signs of those before."""
    return SampledModes.sampled(solve(beam, **options), before)


def sorted_frequencies(found: Loci) -> np.ndarray:
    """The frequencies (values, branches) of loci in order, nan last."""
    return np.sort(np.column_stack([branch.frequency for branch in found.branches]), axis=1)


def same_beam(found: Beam, beam: Beam) -> None:
    """Equal to the rounding of a few operations."""
    assert found.numbers == pytest.approx(beam.numbers, rel=1e-12)
    assert found.root == pytest.approx(beam.root, rel=1e-12)
    sizes = (beam.units or Units(0, 0)).attributes
    assert (found.units or Units(0, 0)).attributes == pytest.approx(sizes, rel=1e-12)
    assert len(found.masses) == len(beam.masses)
    for mass, other in zip(found.masses, beam.masses, strict=True):
        assert (mass.alpha, mass.beta) == pytest.approx((other.alpha, other.beta), rel=1e-12)
        assert mass.inertia == pytest.approx(other.inertia, rel=1e-12)
    assert (found.blade is None) == (beam.blade is None)
    for name in ("x", "mass", "bending", "axial") if beam.blade else ():
        assert getattr(found.blade, name) == pytest.approx(getattr(beam.blade, name), rel=1e-12)
    if beam.blade:
        assert (found.blade.flap is None) == (beam.blade.flap is None)
        assert (found.blade.flap or ()) == pytest.approx(beam.blade.flap or (), rel=1e-12)


# Of events: tests that say which there are, and no other, ask for these. Another kind may be added.
KNOWN_KINDS = (
    *("crossing", "veering", "close approach", "coalescence"),
    *("buckling", "limit point", "second state"),
)
