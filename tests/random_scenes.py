"""Random beams and models over everything that is accepted, each from a seed of its own."""

from typing import Any, NamedTuple

import numpy as np

from beamviz import Beam


class Scene(NamedTuple):
    """A beam and the options of `solve`."""

    beam: Beam
    options: dict[str, Any]

    @property
    def command(self) -> str:
        """The command that solves it again."""
        numbers = {name: repr(value) for name, value in self.beam.numbers.items()}
        given = numbers | {name: str(value) for name, value in self.options.items()}
        on = given.pop("coriolis", "False") == "True"
        words = [f"--{name} {value}" for name, value in given.items()]
        return " ".join(["beamviz modes", *words, *(["--coriolis"] if on else [])])


def random_scene(seed: int) -> Scene:
    """Anywhere in the accepted range; corners and the usual places more often than by chance."""
    rng = np.random.default_rng([5, seed])
    options = random_options(rng)
    return Scene(random_beam(rng, options["strain"]), options)


def random_options(rng: np.random.Generator) -> dict[str, Any]:
    plane = str(rng.choice(["chordwise", "flapwise"]))
    return {
        "modes": int(rng.choice([5, rng.integers(1, 13), 20], p=[0.7, 0.27, 0.03])),
        "strain": str(rng.choice(["green", "biot", "hencky"], p=[0.6, 0.2, 0.2])),
        "curvature": str(rng.choice(["spatial", "material"])),
        "plane": plane,
        "coriolis": bool(plane == "chordwise" and rng.random() < 0.5),
        "tolerance": float(rng.choice([1e-6, 10 ** rng.uniform(-9, -2)])),
    }


def random_beam(rng: np.random.Generator, strain: str) -> Beam:
    mu = 10 ** rng.uniform(1, 4)
    fastest = min(200.0, 5 * mu)
    delta = pick(
        rng,
        {
            rng.uniform(0, 20): 0.3,
            10 ** rng.uniform(-3, np.log10(20)): 0.25,
            0.0: 0.2,
            rng.uniform(-2, 0): 0.15,
            -(10 ** rng.uniform(-3, np.log10(2))): 0.1,
        },
    )
    logarithmic = 10 ** rng.uniform(-2, np.log10(fastest))
    gamma = pick(rng, {rng.uniform(0, fastest): 0.4, logarithmic: 0.5, fastest: 0.1})
    if delta < 0 and rng.random() < 0.7:  # near buckling, and not only far beyond it
        gamma = min(fastest, 10 ** rng.uniform(-2, 1.3))
    if strain != "green" and rng.random() < 0.5:  # else most have no equilibrium
        gamma = min(gamma, rng.uniform(0, 1.6) * mu / (1 + max(delta, 0)) ** 0.5)
    alpha = pick(rng, {10 ** rng.uniform(-3, 2): 0.6, rng.uniform(0, 3): 0.25, 0.0: 0.15})
    edge = 10 ** rng.uniform(-6, -1)
    beta = pick(rng, {rng.uniform(): 0.6, 1.0: 0.15, 0.0: 0.02, edge: 0.1, 1 - edge: 0.13})
    return Beam(alpha, beta, gamma, delta, mu)


def pick(rng: np.random.Generator, weights: dict[float, float]) -> float:
    """One of the keys, by weight."""
    return float(rng.choice(list(weights), p=list(weights.values())))
