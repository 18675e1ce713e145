"""Verdicts of the oracle on the errors that `solve` reports for bent beams: inward ones past
buckling and ones that spin up, drawn from the whole accepted range, each from a seed of its own."""

import re
from functools import partial
from itertools import count
from typing import Any

import numpy as np

from beamviz import Beam, Solution, solve
from beamviz.errors import BeamvizError, NoEquilibrium
from oracle.bent import bent_truth
from oracle.eigen import UnresolvedError
from oracle.error_bars import Scene, judged

SPIN_UPS = 0.3  # share of the scenes
ROUNDING = 1e-9  # of the oracle, relative
LESS = 0.5  # gamma / mu of laws that carry only so much: beyond, few beams have a state
LIMIT_MARGIN = 0.1  # relative: there is a state this far below a limit


def random_bent_scene(seed: int) -> Scene:
    """A beam whose straight state is unstable or does not exist, and options."""
    for attempt in count():
        rng = np.random.default_rng([17, seed, attempt])
        strain = str(rng.choice(["green", "biot", "hencky"], p=[0.6, 0.2, 0.2]))
        options = {
            "strain": strain,
            "curvature": str(rng.choice(["spatial", "material"])),
            "coriolis": bool(rng.random() < 0.5),
            "modes": int(rng.choice([5, 2, 10], p=[0.7, 0.2, 0.1])),
            "tolerance": float(rng.choice([1e-6, 10 ** rng.uniform(-8, -3)])),
        }
        beam = _random_beam(rng, 5.0 if strain == "green" else LESS)
        if beam.spin_up or _straight_is_unstable(beam, options):
            return Scene(beam, options | {"state": "stable"})
    raise AssertionError


def _random_beam(rng: np.random.Generator, most: float) -> Beam:
    mu = 10 ** rng.uniform(1, 4)
    fastest = min(200.0, most * mu)
    gamma = rng.uniform(0, fastest) if rng.random() < 0.3 else 10 ** rng.uniform(0, 2.3)
    spin_up = rng.choice([-1, 1]) * 10 ** rng.uniform(-2, 2.5) if rng.random() < SPIN_UPS else 0.0
    inward = not spin_up or rng.random() < 0.3
    near = -(10 ** rng.uniform(-3, 0.3))
    return Beam(
        alpha=float(rng.choice([0.0, rng.uniform(0, 5), 10 ** rng.uniform(-2, 2)])),
        beta=float(rng.choice([1.0, rng.uniform(0, 1)], p=[0.3, 0.7])),
        gamma=min(fastest, gamma),
        delta=rng.choice([-rng.uniform(0, 2), near]) if inward else rng.uniform(0, 3),
        mu=mu,
        spin_up=float(spin_up),
    )


def _straight_is_unstable(beam: Beam, options: dict[str, Any]) -> bool:
    try:
        return not solve(beam, modes=1, strain=options["strain"]).equilibrium.stable
    except BeamvizError:
        return True


def bent_verdict(scene: Scene) -> dict[str, Any]:
    """`verdict` on a bent beam."""
    return judged(scene, partial(_solved, scene), partial(_limited, scene))


def _limited(scene: Scene, error: NoEquilibrium) -> dict[str, Any]:
    """A beam that is slower, or that spins up less, must have a state."""
    if np.isnan(error.limit):  # of the spin-up
        (limit,) = re.findall(r"beyond spin_up = (\S+),", str(error))
        less = scene.beam.replace(spin_up=float(limit) * (1 - LIMIT_MARGIN))
    else:
        less = scene.beam.replace(gamma=error.limit * (1 - LIMIT_MARGIN), spin_up=0.0)
    try:
        true = solve(less, **scene.options).equilibrium.stable
    except BeamvizError:
        true = False
    return {"kind": "no-equilibrium" if true else "wrong-limit", "says": str(error)}


def _solved(scene: Scene, solution: Solution) -> dict[str, Any]:
    options, state = scene.options, solution.equilibrium
    model = (options["strain"], options["curvature"], options["coriolis"], options["modes"])
    try:
        truth = bent_truth(
            scene.beam, *model, lambda x: (state.position(x), state.angle(x), state.stretch(x))
        )
    except (UnresolvedError, RuntimeError, FloatingPointError) as error:
        return {"kind": "unknown", "says": str(error)}
    # A mode without a frequency is compared by its growth rate, as its error is that of the rate.
    still = np.isnan(solution.frequencies)
    ours = np.where(still, solution.growth_rates, solution.frequencies)
    theirs = np.where(still, abs(truth.omega.imag), truth.omega.real)
    oracle_error = truth.differences + ROUNDING * abs(truth.omega)
    error = abs(ours - theirs)
    return {
        "kind": "within" if np.all(error <= solution.errors + oracle_error) else "outside",
        "error": error.tolist(),
        "reported": solution.errors.tolist(),
        "oracle_error": oracle_error.tolist(),
        "sizes": abs(truth.omega).tolist(),
    }
