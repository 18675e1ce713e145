"""A sweep of 201 speeds against the closest peer, in one run: python scripts/benchmark_peers.py

Exudyn (`pip install exudyn`, not needed for anything else) has the same planar cubic elements,
with the engineering strain and the material curvature (ANCFCable2D). The centrifugal force comes
in as an object of its own: K = -gamma^2 M, and its load. Both solve the same beams for 6 modes in
one thread, warm, assembly included. The peer's error is against its own continuum limit, which is
this program's `auto` with strain biot and curvature material. Nothing but equilibrium and
frequencies is timed: this program's error bars and the tracking of its chart come on top.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import sys
from functools import partial
from importlib.metadata import PackageNotFoundError
from typing import Any

import numpy as np
from _arguments import Parser

from beamviz import Beam, NotConverged, loci, solve
from beamviz.benchmark.external import PEERS
from beamviz.benchmark.work_precision import least_time
from beamviz.solver import solve_many

EXUDYN = PEERS[0]
POINTS, MODES = 201, 6
MODEL: dict[str, Any] = {"strain": "biot", "curvature": "material"}


def peer_sweep(beams: list[Beam], elements: int) -> None:
    for beam in beams:
        EXUDYN.omega_squared(beam, elements, MODES)


def one_by_one(beams: list[Beam]) -> None:
    for beam in beams:
        solve(beam, MODES, **MODEL)


def main() -> int:
    """Print one line for each way to sweep."""
    try:
        version = EXUDYN.version()
    except PackageNotFoundError:
        print(f"Exudyn is not installed: {EXUDYN.install}", file=sys.stderr)
        return 1
    beam, speeds = Beam(alpha=1), np.linspace(0, 15, POINTS)
    beams = [beam.replace(gamma=gamma) for gamma in speeds]
    exact = solve(beams[-1], MODES, tolerance=1e-9, **MODEL).frequencies
    chart = least_time(partial(loci, beam, "gamma", speeds, MODES, **MODEL), 10)
    ours = least_time(partial(solve_many, beams, modes=MODES, **MODEL), 10)
    error = abs(solve(beams[-1], MODES, **MODEL).frequencies / exact - 1).max()
    print(f"{'201 speeds, 6 modes':34}{'ms':>9}{'error':>10}{'/ auto':>9}")
    print(f"{'auto':34}{1e3 * ours:9.1f}{error:10.0e}{1:9.1f}")
    apart = least_time(partial(one_by_one, beams), 2)
    print(f"{'auto, 201 separate solves':34}{1e3 * apart:9.1f}{error:10.0e}{apart / ours:9.1f}")
    print(f"{'auto, tracked, events located':34}{1e3 * chart:9.1f}{error:10.0e}{chart / ours:9.1f}")
    for elements in (5, 10, 20):
        name = f"Exudyn {version}, {elements} elements"
        try:
            theirs = least_time(partial(peer_sweep, beams, elements), 1)
        except NotConverged as failure:
            print(f"{name:34}failed: {failure}")
            continue
        squares = EXUDYN.omega_squared(beams[-1], elements, MODES)
        error = abs(np.sqrt(squares) / exact - 1).max()
        print(f"{name:34}{1e3 * theirs:9.1f}{error:10.0e}{theirs / ours:9.1f}")
    return 0


if __name__ == "__main__":
    Parser(__doc__).parse_args()
    sys.exit(main())
