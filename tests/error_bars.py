"""What `solve` reports as its error, held against the oracle: one scene, one verdict."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from oracle import FINE, QUICK, truth
from oracle.eigen import UnresolvedError
from oracle.equilibrium import NoStateError, shoot
from random_scenes import Scene

from beamviz import Solution, solve
from beamviz.errors import NoEquilibrium, NotConverged

STATIONS = 9  # where the stretch is compared
LIMIT_MARGIN = 1e-4  # relative: the limit is held against the oracle this far to either side
BRANCH = 0.02  # relative difference in stretch of two states that are not the same


def oracle_answer(scene: Scene) -> dict[str, Any]:
    """What the oracle says of a scene, as plain data: `squares`, or why there are none."""
    options = {name: value for name, value in scene.options.items() if name != "tolerance"}
    levels = FINE if scene.beam.delta >= 0 else QUICK  # all eigenvalues of a full matrix
    try:
        found = truth(scene.beam, resolutions=levels, **options)
    except NoStateError:
        return {"missing": "no-equilibrium"}
    except UnresolvedError as error:
        return {"missing": f"unresolved: {error}"}
    stations = np.linspace(0, len(found.x) - 1, STATIONS).astype(int)
    return {
        "squares": found.squares.tolist(),
        "differences": found.square_differences.tolist(),
        "x": found.x[stations].tolist(),
        "stretch": found.stretch[stations].tolist(),
        "tip": found.tip,
    }


def verdict(scene: Scene, answer: dict[str, Any]) -> dict[str, Any]:
    """How the solver's answer stands against the oracle's: `kind`, and where both have modes
    `off`, `reported` and `doubt` (the oracle's own) of each frequency. With the processor's
    `seconds`, which do not grow while other programs run."""
    start = time.process_time()
    solution: Solution | Exception
    try:
        solution = solve(scene.beam, **scene.options)
    except Exception as error:
        solution = error
    seconds = time.process_time() - start
    return _judged(scene, answer, solution) | {"seconds": seconds}


def _judged(scene: Scene, answer: dict[str, Any], solution: Solution | Exception) -> dict[str, Any]:
    if isinstance(solution, Solution):
        return _solved(solution, answer)
    if isinstance(solution, NoEquilibrium):
        return _refused(scene, answer, solution)
    if isinstance(solution, NotConverged):
        return {"kind": "not-converged", "says": str(solution)}
    return {"kind": "crash", "says": repr(solution)}


def _refused(scene: Scene, answer: dict[str, Any], error: NoEquilibrium) -> dict[str, Any]:
    """No equilibrium: the branch from rest ends there for the oracle too. Far beyond, an inward
    beam may have another state, thrown over the axis and in tension."""
    has_state = _state_at(scene)
    below, above = error.limit * (1 - LIMIT_MARGIN), error.limit * (1 + LIMIT_MARGIN)
    true = has_state(below) and not (above < scene.beam.gamma and has_state(above))
    kind = "no-equilibrium" if "squares" not in answer else "another-state"
    return {"kind": kind if true else "wrong-limit", "says": str(error)}


def _state_at(scene: Scene) -> Callable[[float], bool]:
    def has_state(gamma: float) -> bool:
        try:
            shoot(scene.beam.replace(gamma=gamma), scene.options["strain"])
        except NoStateError:
            return False
        return True

    return has_state


def _solved(solution: Solution, answer: dict[str, Any]) -> dict[str, Any]:
    if "squares" not in answer:
        missed = answer["missing"] == "no-equilibrium"
        return {"kind": "missed-limit" if missed else "unknown", "says": answer["missing"]}
    if not _same_branch(solution, answer):
        return {"kind": "wrong-branch", "says": f"tip {solution.equilibrium.tip}"}
    off, reported, doubt = compared(solution, answer)
    kind = "within" if np.all(off <= reported + doubt) else "outside"
    return {
        "kind": kind,
        "off": off.tolist(),
        "reported": reported.tolist(),
        "doubt": doubt.tolist(),
        "sizes": np.sqrt(np.abs(answer["squares"])).tolist(),
    }


def _same_branch(solution: Solution, answer: dict[str, Any]) -> bool:
    """Whether the stretched state is the oracle's: along the beam and at the tip."""
    ours, theirs = solution.equilibrium.stretch(np.array(answer["x"])), np.array(answer["stretch"])
    longest = max(1.0, abs(answer["tip"]))
    tip = abs(solution.equilibrium.tip[0] - answer["tip"])
    return bool(np.all(abs(ours - theirs) < BRANCH * theirs) and tip < BRANCH * longest)


def compared(
    solution: Solution, answer: dict[str, Any]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """True error, reported error and the oracle's own doubt of each frequency (modes,): of
    omega^2 where the two disagree on its sign."""
    squares, doubt = np.array(answer["squares"]), np.array(answer["differences"])
    off = abs(solution.omega_squared - squares)
    root = np.sqrt(abs(solution.omega_squared)) + np.sqrt(abs(squares))
    alike = (solution.omega_squared < 0) == (squares < 0)
    scale = np.where(alike & (root > 0), root, 1.0)
    reported = np.where(alike, solution.errors, solution.omega_squared_errors)
    return off / scale, reported, doubt / scale
