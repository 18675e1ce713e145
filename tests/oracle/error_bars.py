"""Verdicts of the oracle on the errors that `solve` reports, for random scenes.

Scenes are drawn from the whole accepted range, each from a seed of its own: straight beams, and
bent ones, inward past buckling or with a spin-up.
"""

import re
import time
from collections.abc import Callable
from functools import partial
from itertools import count
from typing import Any, NamedTuple

import numpy as np

from beamviz import Beam, Solution, solve
from beamviz.blade import Blade, Mass
from beamviz.errors import BeamvizError, NoEquilibrium, NotConverged
from beamviz.solver.constitutive import STRAIN_LAWS
from oracle import FINE, QUICK, truth
from oracle.bent import BentTruth, bent_truth
from oracle.eigen import UnresolvedError
from oracle.equilibrium import LAWS, NoStateError, shoot

STATIONS = 9  # at which the stretch is compared
LIMIT_MARGIN = 1e-4  # relative: the limit is tested this far below and above
BRANCH = 0.02  # relative difference in stretch between two different states

# Bent beams.
SPIN_UPS = 0.3  # share of the scenes
ROUNDING = 1e-9  # of the oracle, relative
LESS = 0.5  # gamma / mu of laws that carry only so much: beyond, few beams have a state
BENT_LIMIT_MARGIN = 0.1  # relative: there is a state this far below a limit


class Scene(NamedTuple):
    """A beam and the options of `solve`."""

    beam: Beam
    options: dict[str, Any]

    @property
    def command(self) -> str:
        """The command that solves it again."""
        if not self.beam.is_uniform:
            return f"solve({self.beam}, **{self.options})"
        numbers = {name: repr(value) for name, value in self.beam.numbers.items()}
        given = numbers | {name: str(value) for name, value in self.options.items()}
        on = given.pop("coriolis", "False") == "True"
        words = [f"--{name.replace('_', '-')} {value}" for name, value in given.items()]
        return " ".join(["beamviz modes", *words, *(["--coriolis"] if on else [])])


def random_scene(seed: int) -> Scene:
    """Anywhere in the accepted range; corners and the usual places more often than by chance."""
    rng = np.random.default_rng([5, seed])
    plane = str(rng.choice(["chordwise", "flapwise"]))
    options = {
        "modes": int(rng.choice([5, rng.integers(1, 13), 20], p=[0.7, 0.27, 0.03])),
        "strain": random_law(rng),
        "curvature": str(rng.choice(["spatial", "material"])),
        "plane": plane,
        "coriolis": bool(plane == "chordwise" and rng.random() < 0.5),
        "tolerance": float(rng.choice([1e-6, 10 ** rng.uniform(-9, -2)])),
    }
    return Scene(random_beam(rng, options["strain"]), options)


def random_law(rng: np.random.Generator) -> str:
    """One of all strain laws, the default more often than the others."""
    others = len(STRAIN_LAWS) - 1
    return str(rng.choice(list(STRAIN_LAWS), p=[0.6, *[0.4 / others] * others]))


def random_beam(rng: np.random.Generator, strain: str) -> Beam:
    mu = 10 ** rng.uniform(1, 4)
    fastest = min(200.0, 5 * mu)
    outward = {rng.uniform(0, 20): 0.3, 10 ** rng.uniform(-3, np.log10(20)): 0.25, 0.0: 0.2}
    inward = {rng.uniform(-2, 0): 0.15, -(10 ** rng.uniform(-3, np.log10(2))): 0.1}
    delta = pick(rng, outward | inward)
    logarithmic = 10 ** rng.uniform(-2, np.log10(fastest))
    gamma = pick(rng, {rng.uniform(0, fastest): 0.4, logarithmic: 0.5, fastest: 0.1})
    if delta < 0 and rng.random() < 0.7:  # near buckling, and not only far beyond it
        gamma = min(fastest, 10 ** rng.uniform(-2, 1.3))
    if not LAWS[strain].hardens and rng.random() < 0.5:  # else most have no equilibrium
        gamma = min(gamma, rng.uniform(0, 1.6) * mu / (1 + max(delta, 0)) ** 0.5)
    alpha = pick(rng, {10 ** rng.uniform(-3, 2): 0.6, rng.uniform(0, 3): 0.25, 0.0: 0.15})
    edge = 10 ** rng.uniform(-6, -1)
    beta = pick(rng, {rng.uniform(): 0.6, 1.0: 0.15, 0.0: 0.02, edge: 0.1, 1 - edge: 0.13})
    return Beam(alpha, beta, gamma, delta, mu)


def random_blade_scene(seed: int) -> Scene:
    """A blade with tables or polynomials, jumps, bodies with inertia, and a clamp, a spring or a
    hinge at its root, in the range of `random_scene`."""
    options = random_scene(seed).options
    rng = np.random.default_rng([23, seed])
    beam = random_beam(rng, options["strain"])
    if rng.random() < 0.7:  # usual speeds more often
        usual = min(beam.gamma, 10 ** rng.uniform(-1, 1.5), beam.mu / 3)
        beam = beam.replace(gamma=usual, delta=float(np.clip(beam.delta, -1, 3)))
    return Scene(with_random_properties(rng, beam), options)


def random_space_scene(seed: int) -> Scene:
    """A beam or a blade of `random_blade_scene` that bends in both planes, with a pitch, a twist or
    both, uniform ones with a flapwise stiffness of their own."""
    rng = np.random.default_rng([37, seed])
    scene = random_scene(seed) if rng.random() < 0.5 else random_blade_scene(seed)
    beam, options = scene.beam, scene.options | {"plane": "both"}
    options["coriolis"] = bool(rng.random() < 0.5)
    turned = {"pitch": pick(rng, {0.0: 0.2, rng.uniform(-180, 180): 0.5, rng.uniform(-5, 5): 0.3})}
    turned["twist"] = pick(rng, {0.0: 0.3, rng.uniform(-90, 90): 0.7})
    if beam.blade is None:
        turned["flap"] = float(10 ** rng.uniform(-2, 1.5))
    elif rng.random() < 0.7:
        twist = np.cumsum(rng.normal(0, 15, len(beam.blade.x)))
        values = {name: getattr(beam.blade, name) for name in beam.blade.__dataclass_fields__}
        blade = Blade(**values | {"twist": tuple(np.clip(twist, -90, 90).tolist())})
        beam = beam.replace(blade=blade)
    return Scene(beam.replace(**turned), options)


def random_dip_scene(seed: int) -> Scene:
    """A blade of `random_blade_scene` with a table, and dips of its stiffness and jumps in it."""
    for attempt in count():
        scene = random_blade_scene(1000 * attempt + seed)
        if scene.beam.blade and scene.beam.blade.degree == 1:
            rng = np.random.default_rng([29, seed])
            return scene._replace(beam=scene.beam.replace(blade=with_dips(rng, scene.beam.blade)))
    raise AssertionError


def random_bent_dip_scene(seed: int) -> Scene:
    """A deflected blade with a table, and dips of its stiffness and jumps in it."""
    for attempt in count():
        scene = random_bent_scene(1000 * attempt + seed, blades=True)
        if scene.beam.blade and scene.beam.blade.degree == 1:
            rng = np.random.default_rng([31, seed])
            return scene._replace(beam=scene.beam.replace(blade=with_dips(rng, scene.beam.blade)))
    raise AssertionError


def with_dips(rng: np.random.Generator, blade: Blade) -> Blade:
    """The blade with one to three dips of its stiffnesses, each over three more stations, and with
    a jump after half of them."""
    x = np.array(blade.x)
    rows = {name: np.array(getattr(blade, name)) for name in ("mass", "bending", "axial", "flap")}
    for _ in range(rng.integers(1, 4)):
        free = np.flatnonzero(np.diff(x) > 0.01)
        if not len(free):
            break
        k, depth = int(rng.choice(free)), 10 ** -rng.uniform(0.3, 2.5)
        start, stop = x[k], x[k + 1]
        at = start + (stop - start) * np.array([0.3, 0.5, 0.7])
        jump = rng.random() < 0.5
        at = np.append(at, at[-1]) if jump else at
        for name, row in rows.items():
            here = np.interp(at, [start, stop], row[[k, k + 1]])
            here[1] *= 1.0 if name == "mass" else depth
            if jump:
                here[3] *= rng.uniform(0.3, 1.5)
            rows[name] = np.insert(row, k + 1, here)
        x = np.insert(x, k + 1, at)
    values = {name: tuple(np.clip(row, 1e-6, 1e6).tolist()) for name, row in rows.items()}
    return Blade(tuple(x.tolist()), **values)


def with_random_properties(rng: np.random.Generator, beam: Beam) -> Beam:
    """The beam with properties along its span, bodies and a root."""
    masses = [random_body(rng) for _ in range(rng.choice([0, 1, 2, 3], p=[0.5, 0.25, 0.15, 0.1]))]
    root = pick(rng, {np.inf: 0.6, 10 ** rng.uniform(-2, 4): 0.3, 0.0: 0.1})
    blade = random_blade(rng) if rng.random() < 0.85 else None
    return beam.replace(blade=blade, masses=masses, root=root)


def random_body(rng: np.random.Generator) -> Mass:
    """A body, with moments of inertia that a body may have, or none."""
    size = 10 ** rng.uniform(-4, -0.5) * (rng.random() < 0.7)
    a, b, c = size * rng.dirichlet((1, 1, 1))  # int x^2, y^2, z^2 dm
    alpha = pick(rng, {10 ** rng.uniform(-3, 1): 0.9, 0.0: 0.1})
    beta = pick(rng, {rng.uniform(0.01, 1): 0.7, 1.0: 0.3})
    return Mass(alpha, beta, (b + c, a + c, a + b))


def random_blade(rng: np.random.Generator) -> Blade:
    """A tapered section, or properties in a table, most of them falling toward the tip."""
    if rng.random() < 0.3:
        return Blade.tapered(*(rng.uniform(0, 0.9) for _ in range(2)))
    degree = int(rng.choice([1, 2, 3], p=[0.7, 0.15, 0.15]))
    stations = 1 + degree * int(rng.integers(1, 7))
    x = np.concatenate(([0.0], np.sort(rng.uniform(0.02, 0.98, stations - 2)), [1.0]))
    x = x if degree == 1 else np.linspace(0, 1, stations)
    place = int(rng.integers(1, stations - 1)) if degree == 1 and stations > 2 else None
    if place and rng.random() < 0.5:  # a jump
        x = np.insert(x, place, x[place])
    fall = rng.choice([0.1, 0.5, 1.0])
    rows = {}
    for name in ("mass", "bending", "axial", "flap"):
        steps = rng.normal(-fall / 2, fall if degree == 1 else 0.1, len(x))
        steps[0] = 0 if name != "flap" else rng.uniform(-2, 2)
        rows[name] = tuple(np.exp(np.clip(np.cumsum(steps), -8, 3)).tolist())
    return Blade(tuple(x.tolist()), **rows, degree=degree)


def pick(rng: np.random.Generator, weights: dict[float, float]) -> float:
    """One of the keys, by weight."""
    return float(rng.choice(list(weights), p=list(weights.values())))


def oracle_answer(scene: Scene) -> dict[str, Any]:
    """The oracle's answer to a scene, as plain data: `squares`, or why there are none."""
    options = {name: value for name, value in scene.options.items() if name != "tolerance"}
    levels = FINE if scene.beam.delta >= 0 else QUICK  # all eigenvalues of a full matrix
    try:
        found = truth(scene.beam, resolutions=levels, **options)
    except NoStateError:
        return {"missing": "no-equilibrium"}
    except (UnresolvedError, RuntimeError) as error:  # or a matrix that is singular to rounding
        return {"missing": f"unresolved: {error}"}
    stations = np.linspace(0, len(found.x) - 1, STATIONS).astype(int)
    return {
        "squares": found.squares.tolist(),
        "families": list(found.families),
        "differences": found.square_differences.tolist(),
        "x": found.x[stations].tolist(),
        "stretch": found.stretch[stations].tolist(),
        "tip": found.tip,
    }


def verdict(scene: Scene, answer: dict[str, Any]) -> dict[str, Any]:
    """The solver's answer against the oracle's: `kind` and processor time `seconds`; where both
    have modes also the `error`, the `reported` one and the `oracle_error` of each frequency."""
    return judged(scene, partial(_solved, answer), partial(_no_equilibrium, scene, answer))


def judged(
    scene: Scene,
    solved: Callable[[Solution], dict[str, Any]],
    limited: Callable[[NoEquilibrium], dict[str, Any]],
) -> dict[str, Any]:
    """The verdict on the solver's answer, by its kind, and the processor time that it takes."""
    start = time.process_time()
    solution: Solution | Exception
    try:
        solution = solve(scene.beam, **scene.options)
    except Exception as error:
        solution = error
    seconds = time.process_time() - start
    if isinstance(solution, Solution):
        found = solved(solution)
    elif isinstance(solution, NoEquilibrium):
        found = limited(solution)
    elif isinstance(solution, NotConverged):
        found = {"kind": "not-converged", "says": str(solution)}
    else:
        found = {"kind": "crash", "says": repr(solution)}
    return found | {"seconds": seconds}


def _no_equilibrium(scene: Scene, answer: dict[str, Any], error: NoEquilibrium) -> dict[str, Any]:
    """The branch from rest must end there for the oracle too. Far beyond, an inward beam may have
    another state, across the axis and in tension."""

    def has_state(gamma: float) -> bool:
        try:
            shoot(scene.beam.replace(gamma=gamma), scene.options["strain"])
        except NoStateError:
            return False
        return True

    below, above = error.limit * (1 - LIMIT_MARGIN), error.limit * (1 + LIMIT_MARGIN)
    true = has_state(below) and not (above < scene.beam.gamma and has_state(above))
    kind = "another-state" if "squares" in answer else "no-equilibrium"
    return {"kind": kind if true else "wrong-limit", "says": str(error)}


def _solved(answer: dict[str, Any], solution: Solution) -> dict[str, Any]:
    if "squares" not in answer:
        missed = answer["missing"] == "no-equilibrium"
        return {"kind": "missed-limit" if missed else "unknown", "says": answer["missing"]}
    # The branch that starts at rest has this stretch along the beam and this tip.
    theirs, tip = np.array(answer["stretch"]), answer["tip"]
    apart = abs(solution.equilibrium.stretch(np.array(answer["x"])) - theirs)
    away = abs(solution.equilibrium.tip[0] - tip)
    if not (np.all(apart < BRANCH * theirs) and away < BRANCH * max(1.0, abs(tip))):
        return {"kind": "wrong-branch", "says": f"tip {solution.equilibrium.tip}"}
    # Errors of frequency, but of omega^2 where the two disagree on its sign.
    ours, squares = solution.omega_squared, np.array(answer["squares"])
    root = np.sqrt(abs(ours)) + np.sqrt(abs(squares))
    alike = (ours < 0) == (squares < 0)
    scale = np.where(alike & (root > 0), root, 1.0)
    reported = np.where(alike, solution.errors, solution.omega_squared_errors)
    oracle_error, sizes = np.array(answer["differences"]) / scale, np.sqrt(abs(squares))
    found = held(abs(ours - squares) / scale, reported, oracle_error, sizes)
    distinct = np.all(np.diff(sizes) > 2 * np.maximum(reported, oracle_error)[1:])
    known = distinct and "mixed" not in answer["families"]
    if found["kind"] == "within" and known and list(solution.families) != answer["families"]:
        return {"kind": "wrong-family", "says": f"{solution.families}"}
    return found


def held(
    error: np.ndarray, reported: np.ndarray, oracle_error: np.ndarray, sizes: np.ndarray
) -> dict[str, Any]:
    """The verdict on errors (modes,), and they."""
    kind = "within" if np.all(error <= reported + oracle_error) else "outside"
    names = ("error", "reported", "oracle_error", "sizes")
    values = (error.tolist(), reported.tolist(), oracle_error.tolist(), sizes.tolist())
    return {"kind": kind, **dict(zip(names, values, strict=True))}


# Bent beams.


def random_bent_scene(seed: int, blades: bool = False) -> Scene:
    """A beam whose straight state is unstable or does not exist, and options; or such a blade, in
    the range of usual speeds."""
    for attempt in count():
        rng = np.random.default_rng([17, seed, attempt])
        strain = random_law(rng)
        options = {
            "strain": strain,
            "curvature": str(rng.choice(["spatial", "material"])),
            "coriolis": bool(rng.random() < 0.5),
            "modes": int(rng.choice([5, 2, 10], p=[0.7, 0.2, 0.1])),
            "tolerance": float(rng.choice([1e-6, 10 ** rng.uniform(-8, -3)])),
        }
        beam = _random_bent_beam(rng, 5.0 if LAWS[strain].hardens else LESS)
        if blades:
            beam = beam.replace(gamma=min(beam.gamma, 20.0), mu=max(beam.mu, 50.0))
            beam = with_random_properties(rng, beam)
        try:
            straight = solve(beam, modes=1, strain=strain, state="straight").equilibrium.stable
        except BeamvizError:  # also of a beam with a spin-up: it has no straight state
            straight = False
        if not straight:
            return Scene(beam, options | {"state": "stable"})
    raise AssertionError


def _random_bent_beam(rng: np.random.Generator, most: float) -> Beam:
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


def bent_verdict(scene: Scene) -> dict[str, Any]:
    """`verdict` on a bent beam."""
    return judged(scene, partial(bent_solution_verdict, scene), partial(bent_limited, scene))


def bent_oracle(scene: Scene) -> dict[str, Any]:
    """The oracle's answer about the state that `solve` finds, as plain data, or why there is
    none."""
    try:
        truth = bent_truth_of(scene, solve(scene.beam, **scene.options))
    except BeamvizError as error:
        return {"missing": error.kind}
    except (UnresolvedError, RuntimeError, FloatingPointError) as error:
        return {"missing": f"unresolved: {error}"}
    return {
        "real": truth.omega.real.tolist(),
        "imag": truth.omega.imag.tolist(),
        "differences": truth.differences.tolist(),
        "tip": truth.tip.tolist(),
    }


def bent_limited(scene: Scene, error: NoEquilibrium) -> dict[str, Any]:
    """A beam that is slower, or that spins up less, must have a state."""
    if np.isnan(error.limit):  # of the spin-up
        (limit,) = re.findall(r"beyond spin_up = (\S+),", str(error))
        less = scene.beam.replace(spin_up=float(limit) * (1 - BENT_LIMIT_MARGIN))
    else:
        less = scene.beam.replace(gamma=error.limit * (1 - BENT_LIMIT_MARGIN), spin_up=0.0)
    try:
        true = solve(less, **scene.options).equilibrium.status != "unstable"
    except BeamvizError:
        true = False
    return {"kind": "no-equilibrium" if true else "wrong-limit", "says": str(error)}


def bent_solution_verdict(scene: Scene, solution: Solution) -> dict[str, Any]:
    """The verdict on a solution of a bent beam."""
    try:
        truth = bent_truth_of(scene, solution)
    except (UnresolvedError, RuntimeError, FloatingPointError) as error:
        return {"kind": "unknown", "says": str(error)}
    distance = abs(solution.s - 1j * truth.omega)  # of frequency and growth rate together
    oracle_error = truth.differences + ROUNDING * abs(truth.omega)
    return held(distance, solution.errors, oracle_error, abs(truth.omega))


def bent_truth_of(scene: Scene, solution: Solution) -> BentTruth:
    """The state next to that of a solution, and its modes. Raises UnresolvedError."""
    options, state = scene.options, solution.equilibrium
    model = (options["strain"], options["curvature"], options["coriolis"], options["modes"])
    return bent_truth(
        scene.beam, *model, lambda x: (state.position(x), state.angle(x), state.stretch(x))
    )
