"""CalculiX: quadratic plane-stress elements of a solid, as a process of its own.

The beam is a strip with a square section of height sqrt(12) / mu and Poisson's ratio 0; the mass
is a thin slice of it that is denser. A nonlinear static step under the centrifugal force, then
frequencies about its end. A solid shears and its sections turn with inertia: its limit is its own.
"""

import math
import os
import re
import subprocess
import tempfile
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError
from itertools import pairwise
from pathlib import Path

import numpy as np

from beamviz.beam import Beam
from beamviz.benchmark.external import Peer
from beamviz.errors import NotConverged

PROGRAM = "ccx"
HEIGHT = 2  # elements over the height
SLICE = 0.002  # length of the slice that is the mass, in L
TIMEOUT = 60.0  # [s]
EIGENVALUE = re.compile(r"^ +\d+ +(\S+) +\S+ +\S+ +\S+ *$", re.MULTILINE)
THREADS = {"OMP_NUM_THREADS": "1", "CCX_NPROC_STIFFNESS": "1", "CCX_NPROC_EQUATION_SOLVER": "1"}


def solve(beam: Beam, elements: int, modes: int) -> np.ndarray:
    """omega^2 of the lowest modes (modes,). Raises NotConverged."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "beam.inp").write_text("\n".join(deck(beam, elements, modes)) + "\n")
        try:
            done = subprocess.run(
                [PROGRAM, "beam"],
                cwd=folder,
                env={**os.environ, **THREADS},
                capture_output=True,
                text=True,
                timeout=TIMEOUT,
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise NotConverged(f"CalculiX took more than {TIMEOUT:g} s") from None
        found = EIGENVALUE.findall((Path(folder) / "beam.dat").read_text())
    if len(found) < modes:
        errors = re.findall(r"\*ERROR[^\n]*", done.stdout) or ["no frequencies"]
        raise NotConverged(f"CalculiX: {errors[0].strip()}")
    return np.sort(np.array([float(value) for value in found]))[:modes]


def deck(beam: Beam, elements: int, modes: int) -> Iterator[str]:
    """The lines of its input."""
    height = math.sqrt(12) / beam.mu
    x, dense = columns(beam, elements)
    yield "*NODE"
    rows = 2 * HEIGHT + 1
    for i, at in enumerate(x):
        for j in range(rows):
            if i % 2 == 0 or j % 2 == 0:
                yield f"{i * rows + j + 1}, {at!r}, {height * (j / (rows - 1) - 0.5)!r}, 0."
    for name, wanted in (("PLAIN", False), ("DENSE", True)):
        chosen = [e for e in range(len(dense)) if dense[e] is wanted]
        if chosen:
            yield f"*ELEMENT, TYPE=CPS8R, ELSET={name}"
            yield from (corners(e, k, rows) for e in chosen for k in range(HEIGHT))
            yield f"*SOLID SECTION, ELSET={name}, MATERIAL={name}\n{height!r}"
            rho = 1 / height**2 * (1 + (beam.alpha / SLICE if wanted else 0.0))
            yield f"*MATERIAL, NAME={name}\n*ELASTIC\n{12 / height**4!r}, 0."
            yield f"*DENSITY\n{rho!r}"
    yield "*BOUNDARY"
    yield from (f"{node + 1}, 1, 2" for node in range(rows))
    if beam.gamma:
        yield "*STEP, NLGEOM, INC=200\n*STATIC\n0.25, 1."
        yield "*CONTROLS, PARAMETERS=FIELD\n1e-8, 1e-8"
        yield "*DLOAD"
        for name in ("PLAIN", "DENSE") if any(dense) else ("PLAIN",):
            yield f"{name}, CENTRIF, {beam.gamma**2!r}, {-beam.delta!r}, 0., 0., 0., 0., 1."
        yield "*END STEP"
    yield f"*STEP, PERTURBATION\n*FREQUENCY\n{modes}\n*END STEP"


def columns(beam: Beam, elements: int) -> tuple[list[float], list[bool]]:
    """The x of every column of nodes, corners and midsides, and which elements are dense."""
    cuts = {0.0, 1.0}
    if beam.alpha and beam.beta:
        end = min(beam.beta + SLICE / 2, 1.0)
        cuts |= {end - SLICE, end}
    cuts_in_order = sorted(cuts)
    corners_at, dense = [0.0], []
    for a, b in pairwise(cuts_in_order):
        heavy = bool(beam.alpha) and b - a < 1.5 * SLICE
        count = 1 if heavy else max(1, round(elements * (b - a)))
        corners_at += [a + (b - a) * (i + 1) / count for i in range(count)]
        dense += [heavy] * count
    x = [corners_at[0]]
    for a, b in pairwise(corners_at):
        x += [(a + b) / 2, b]
    return x, dense


def corners(e: int, k: int, rows: int) -> str:
    """The eight nodes of element e along, k across the beam."""
    i, j = 2 * e, 2 * k
    places = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
    nodes = [(i + a) * rows + j + b + 1 for a, b in places]
    return ", ".join(map(str, [e * HEIGHT + k + 1, *nodes]))


def version() -> str:
    """Its version. Raises PackageNotFoundError where it is not on the path."""
    try:
        done = subprocess.run([PROGRAM, "-v"], capture_output=True, text=True, check=False)
    except OSError:
        raise PackageNotFoundError(PROGRAM) from None
    return done.stdout.split()[-1]


CALCULIX = Peer(
    "CalculiX",
    "solid",
    (10, 20, 40, 80),
    solve,
    version,
    "apt-get install calculix-ccx",
    "a solid in plane stress, the whole process timed",
)
