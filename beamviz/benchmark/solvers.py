"""Who is measured: every method of this program at several resolutions, and its peers."""

from collections.abc import Callable
from functools import partial
from importlib.metadata import PackageNotFoundError
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.benchmark.calculix import CALCULIX
from beamviz.benchmark.external import Peer
from beamviz.benchmark.exudyn import EXUDYN
from beamviz.benchmark.opensees import OPENSEES
from beamviz.solver import solve

PEERS: tuple[Peer, ...] = (*EXUDYN, OPENSEES, CALCULIX)
TOLERANCES = (0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10)
ELEMENTS = (5, 10, 20, 40, 80, 160)


class Contestant(NamedTuple):
    """A method or a peer; `absent` says why it cannot run."""

    name: str
    theory: str  # the model whose exact frequencies it converges to
    option: str  # what its resolutions are
    resolutions: tuple[float, ...]
    squares: Callable[[Beam, Any, int], np.ndarray]  # beam, resolution, modes -> omega^2 (modes,)
    version: str = ""
    absent: str = ""


def _squares(method: str, option: str, beam: Beam, resolution: Any, modes: int) -> np.ndarray:
    options: dict[str, Any] = {option: resolution}
    return solve(beam, modes, method, **options).omega_squared


def _own(name: str, theory: str, option: str, resolutions: tuple[float, ...]) -> Contestant:
    return Contestant(name, theory, option, resolutions, partial(_squares, name, option))


METHODS = (
    _own("auto", "green", "tolerance", TOLERANCES),
    _own("ancf", "green", "elements", ELEMENTS),
    _own("ancf-planar", "green", "elements", ELEMENTS),
    _own("chebyshev", "green", "terms", (8, 12, 16, 24, 32, 48, 64, 96)),
    _own("foac", "rigid", "tolerance", TOLERANCES),
    _own("linear", "rigid", "elements", ELEMENTS),
    _own("assumed-modes", "rigid", "terms", (5, 6, 8, 10, 12, 14, 20)),
    _own("power-series", "rigid", "terms", (24, 32, 40, 60, 80, 120)),
    _own("zoac", "none", "tolerance", TOLERANCES),
)


def peers() -> list[Contestant]:
    """The other programs; one that is not installed says so."""
    return [_peer(peer) for peer in PEERS]


def _peer(peer: Peer) -> Contestant:
    found, absent = "", ""
    try:
        found = peer.version()
    except PackageNotFoundError:
        absent = f"not installed: {peer.how}"
    return Contestant(
        peer.name, peer.theory, "elements", peer.resolutions, peer.solve, found, absent
    )
