"""How fast this program is, as ratios measured in one run:

    python scripts/benchmark.py [SECTION ...]

solves    a default solve (equilibrium, 5 modes, error estimates, relative 1e-6), without and with
          Coriolis forces, against scipy.linalg.eigh of a dense problem of as many unknowns
sweeps    201 points with 6 modes against 201 separate solves
bent      a bent solve, without a start and from a neighbour's state, against a straight one that
          has at least as many unknowns
charts    charts of 81 and 201 points, 6 modes, with every crossing and veering located,
          against 161 beams of the same line, 8 modes each, solved together
peers     201 speeds against the closest peer, Exudyn (`pip install exudyn`, not needed for anything
          else): the same planar cubic elements, with the engineering strain and the material
          curvature; its error is against `auto` with these. Nothing but equilibrium and frequencies
          is timed: error bars and the tracking of a chart come on top
motions   motions in time to 1e-4 L, with error bars: Kane's manoeuvre, a beam that is let go, and
          Exudyn's of Kane's manoeuvre and a plucked beam to the same error, without error bars
pictures  a picture and films as whole processes, from a cold start, and frames within one process:
          elapsed time, on a machine that does nothing else

Without a section, all but the last two. Times are of the processor, the least of several repeats,
in one thread.
"""

import subprocess
import sys
import tempfile
import timeit
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from io import BytesIO
from itertools import product
from pathlib import Path
from typing import Any

import _script
import numpy as np
from scipy.linalg import eigh

from beamviz import Beam, NotConverged, Ramp, Scene, loci, motion
from beamviz.evidence.benchmark import exudyn_motion
from beamviz.evidence.benchmark import motion as motion_comparison
from beamviz.evidence.benchmark.external import PEERS
from beamviz.evidence.benchmark.work_precision import least_time
from beamviz.exports import PNG_LEVEL, Renderer, SolvedScene
from beamviz.solver import Solution, solve, solve_many

MIDDLE = Beam(alpha=1, beta=0.5, gamma=10)
SCENES = {
    "at rest": Beam(),
    "gamma 10": Beam(gamma=10),
    "gamma 10, mass at the tip": Beam(alpha=1, gamma=10),
    "gamma 10, mass at 0.5": MIDDLE,
    "gamma 50, delta 1": Beam(gamma=50, delta=1),
    "gamma 50, delta 1, mass at 0.3": Beam(alpha=1, beta=0.3, gamma=50, delta=1),
}
BENT_SCENES = {
    "delta -1, gamma 4": Beam(delta=-1, gamma=4),
    "delta -1, gamma 20, mass at 0.5": Beam(alpha=1, beta=0.5, delta=-1, gamma=20),
    "gamma 5, spin-up 10": Beam(gamma=5, spin_up=10),
}
CHARTS: tuple[tuple[Any, ...], ...] = (  # title, beam, parameter, its range, coriolis
    ("gamma, mass at the tip", Beam(alpha=1), "gamma", (0, 20), False),
    ("gamma, mass at 0.5", Beam(alpha=1, beta=0.5), "gamma", (0, 20), False),
    ("alpha, gamma 10", Beam(gamma=10), "alpha", (0, 2), False),
    ("delta, gamma 10", Beam(alpha=1, gamma=10), "delta", (0, 2), False),
    ("mu, gamma 10", Beam(alpha=1, gamma=10), "mu", (10, 100), False),
    ("beta, gamma 5", Beam(alpha=0.5, gamma=5), "beta", (0, 1), False),
    ("gamma to 100, mass at 0.5", MIDDLE, "gamma", (0, 100), False),
    ("gamma, Coriolis", Beam(alpha=1), "gamma", (0, 20), True),
    ("alpha, Coriolis", MIDDLE, "alpha", (0, 2), True),
    ("delta, Coriolis", MIDDLE, "delta", (0, 2), True),
    ("mu, Coriolis", MIDDLE, "mu", (10, 200), True),
    ("beta, Coriolis", MIDDLE, "beta", (0, 1), True),
    ("gamma to 100, Coriolis", MIDDLE, "gamma", (0, 100), True),
)
POINTS, MODES = 201, 6  # of sweeps and charts


def solves() -> None:
    _script.print_row("default solve", "unknowns", "us", "eigh, us", "ratio", "Coriolis, us")
    for name, beam in SCENES.items():
        dof = solve(beam).stats.dof
        A = np.random.default_rng(0).normal(size=(dof, dof))
        dense = partial(eigh, A + A.T, A @ A.T + dof * np.eye(dof))
        works = partial(solve, beam), dense, partial(solve, beam, coriolis=True)
        seconds, by_eigh, coriolis = np.min([taking_turns(works) for _ in range(200)], axis=0)
        times = 1e6 * seconds, 1e6 * by_eigh, seconds / by_eigh, 1e6 * coriolis
        _script.print_row(name, dof, *times)


def taking_turns(works: Iterable[Callable[[], object]]) -> list[float]:
    """The processor time [s] of each of several works, one call each, so that ratios of the least
    times survive a busy machine."""
    return [least_time(work, 1) for work in works]


def one_by_one(solve_one: Callable[..., object], beams: list[Beam], *given: Any) -> None:
    for beam in beams:
        solve_one(beam, *given)


def sweeps() -> None:
    _script.print_row("201 points, 6 modes", "ms", "one by one", "ratio")
    for name, alpha, beta in (("no mass", 0, 1), ("mass at the tip", 1, 1), ("at 0.5", 1, 0.5)):
        beams = [Beam(alpha, beta, gamma) for gamma in np.linspace(0, 15, POINTS)]
        together = least_time(partial(solve_many, beams, modes=MODES), 10)
        apart = least_time(partial(one_by_one, solve, beams, MODES), 3)
        _script.print_row(name, 1e3 * together, 1e3 * apart, apart / together)


def straight_with(unknowns: int, coriolis: bool) -> partial[Solution]:
    """A solve of a straight beam with as many unknowns, by the number of modes asked for."""
    beam = Beam(alpha=1, beta=0.5, gamma=30, delta=1)
    for tolerance, modes in product((1e-6, 1e-8, 1e-10, 1e-12), (5, 10, 20)):
        one = partial(solve, beam, modes=modes, tolerance=tolerance, coriolis=coriolis)
        if one().stats.dof >= unknowns:
            break
    return one


def bent() -> None:
    _script.print_row("bent solve", "unknowns", "ms", "/ straight", "neighbour")
    for (name, beam), coriolis in product(BENT_SCENES.items(), (False, True)):
        options: dict[str, Any] = {"state": "bent", "coriolis": coriolis}
        unknowns = solve(beam, **options).stats.dof
        straight = least_time(straight_with(unknowns, coriolis), 20)
        cold = least_time(partial(solve, beam, **options), 10)
        beams = [beam.replace(gamma=beam.gamma * (1 + 1e-3 * k)) for k in range(21)]
        near = (least_time(partial(solve_many, beams, **options), 3) - cold) / (len(beams) - 1)
        title = f"{name}, Coriolis" if coriolis else name
        _script.print_row(title, unknowns, 1e3 * cold, cold / straight, near / straight)


def chart(
    beam: Beam, over: str, ends: tuple[float, float], coriolis: bool, count: int = POINTS
) -> int:
    """The chart with all its frequencies read; the number of its crossings and veerings."""
    found = loci(beam, over, np.linspace(*ends, count), MODES, coriolis=coriolis)
    assert sum(np.isfinite(branch.frequency).sum() for branch in found.branches) == count * MODES
    return len(found.events)


def charts() -> None:
    _script.print_row("chart, ms", "events", "81", "201", "161 solves", "81 / 161")
    for name, beam, over, ends, coriolis in CHARTS:
        one = partial(chart, beam, over, ends, coriolis)
        line = [
            beam.replace(**{over: value}) for value in np.linspace(ends[0], ends[1], 161).tolist()
        ]
        solves = partial(solve_many, line, modes=MODES + 2, coriolis=coriolis)
        works = partial(one, 81), one, solves
        times = 1e3 * np.min([taking_turns(works) for _ in range(10)], axis=0)
        _script.print_row(name, one(), *times, times[0] / times[-1])


def peers() -> None:
    exudyn = PEERS[0]
    if exudyn.missing:
        sys.exit(f"{exudyn.name} is {exudyn.missing}")
    model: dict[str, Any] = {"strain": "biot", "curvature": "material"}
    speeds = np.linspace(0, 15, POINTS)
    beams = [Beam(alpha=1, gamma=gamma) for gamma in speeds]
    truth = solve(beams[-1], MODES, tolerance=1e-9, **model).frequencies
    own_error = abs(solve(beams[-1], MODES, **model).frequencies / truth - 1).max()
    ours = least_time(partial(solve_many, beams, modes=MODES, **model), 10)
    tracked = partial(loci, Beam(alpha=1), "gamma", speeds, MODES, **model)

    def show(name: str, seconds: float, error: float) -> None:
        _script.print_row(name, 1e3 * seconds, error, seconds / ours)

    _script.print_row("201 speeds, 6 modes", "ms", "error", "/ auto")
    show("auto", ours, own_error)
    show("auto, tracked, events located", least_time(tracked, 10), own_error)
    for count in (5, 10, 20):
        name = f"Exudyn {exudyn.version()}, {count} elements"
        works = partial(one_by_one, exudyn.omega_squared, beams, count, MODES)
        try:
            found = np.sqrt(exudyn.omega_squared(beams[-1], count, MODES))
            show(name, least_time(works, 1), abs(found / truth - 1).max())
        except NotConverged as failure:
            print(f"{name}: {failure}")


PLUCKED = Beam(alpha=1, gamma=3)
MOTIONS: dict[str, tuple[Beam, float, dict[str, Any]]] = {
    "Kane's manoeuvre": (Beam(mu=447.2136), 21.6, {"speed": Ramp(5.554921, 16.20185)}),
    "20 T* in B1, amplitude 0.1": (PLUCKED, 20.0, {"start": {"B1": 0.1}}),
    "20 T* in B1, mass at 0.5": (Beam(alpha=1, beta=0.5, gamma=5), 20.0, {"start": {"B1": 0.1}}),
    "20 T*, plucked by 1, damping 0.5 %": (Beam(), 20.0, {"release": 1.0, "damping": 0.005}),
    "20 T*, plucked by 3, mass at the tip": (PLUCKED, 20.0, {"release": 3.0}),
    "20 T*, plucked by 1": (Beam(), 20.0, {"release": 1.0}),
}


def motions() -> None:
    _script.print_row("motion in time", "ms", "error bar", "steps", "unknowns")
    for name, (beam, until, options) in MOTIONS.items():
        work = partial(motion, beam, until, **options)
        done = work()
        seconds = least_time(work, 3)
        _script.print_row(name, 1e3 * seconds, done.error, done.stats.steps, done.stats.dof)
    exudyn_motions()


def exudyn_motions() -> None:
    """Exudyn to 1e-4 L or less, its best of some meshes and steps."""
    if reason := exudyn_motion.missing():
        print(f"Exudyn is {reason}")
        return
    for name, scene in motion_comparison.SCENES.items():
        truth = motion_comparison.reference_tip(scene, motion_comparison.EXUDYN_MODEL)
        best = None
        for elements, times in ((4, 4), (8, 4), (8, 8), (8, 16)):
            work = partial(motion_comparison.peer_tip, scene, elements, times * scene.instants)
            error = float(abs(work() - truth).max())
            if error <= 1e-4:
                best = min(best or (1e9, 0.0), (least_time(work, 2), error))
        if best is not None:
            _script.print_row(f"Exudyn, {name}", 1e3 * best[0], best[1])


def elapsed(work: Callable[[], object]) -> float:
    """The shortest time [s] of several."""
    return min(timeit.repeat(work, number=1, repeat=3))


def pictures() -> None:
    numbers = ["--alpha", "1", "--beta", "0.5", "--gamma", "10"]
    _script.print_row("picture or film", "s", "MB")
    with tempfile.TemporaryDirectory() as folder:
        for name in ("a.png", "a.gif", "a.webp", "a.mp4"):
            path, command = Path(folder) / name, "screenshot" if name == "a.png" else "animate"
            run = [sys.executable, "-m", "beamviz", command, str(path), *numbers]
            seconds = elapsed(partial(subprocess.run, run, cwd=_script.ROOT, check=True))
            _script.print_row(f"{command} {name}", seconds, path.stat().st_size / 1e6)
    solved = SolvedScene(Scene.of(MIDDLE))

    def write_picture(*_: object) -> None:
        picture = Renderer(solved, 1280, 720).picture(solved.moment())
        picture.save(BytesIO(), "PNG", compress_level=PNG_LEVEL)

    _script.print_row("picture of 1280x720 in a batch", elapsed(write_picture))
    with ThreadPoolExecutor(2) as pool:
        seconds = elapsed(lambda: list(pool.map(write_picture, range(6)))) / 6
    _script.print_row("the same on two threads", seconds)
    for size in ((640, 360), (800, 450)):
        frame = partial(Renderer(solved, *size).picture, solved.moment())
        _script.print_row("frame of {}x{}, one thread".format(*size), elapsed(frame))


SECTIONS = {
    section.__name__: section
    for section in (solves, sweeps, bent, charts, motions, peers, pictures)
}

if __name__ == "__main__":
    parser = _script.Parser(__doc__)
    parser.add_argument("sections", nargs="*", metavar="SECTION", type=_script.one_of(SECTIONS))
    for name in parser.parse_args().sections or list(SECTIONS)[:-2]:
        print(f"\n{name}")
        SECTIONS[name]()
