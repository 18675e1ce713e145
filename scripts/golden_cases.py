"""The beams, charts and motions of the golden file, drawn from seeds: records in the types of JSON.

Each has a name, a kind, a beam and the other arguments. scripts/golden.py adds the answers.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import count
from typing import Any

import numpy as np

from beamviz import Beam, Blade, Mass, solve
from beamviz.errors import BeamvizError

Record = dict[str, Any]
Random = np.random.Generator

LAWS = ("green", "biot", "hencky")
CURVATURES = ("spatial", "material")
INWARD = Beam(gamma=10, delta=-1.2, mu=70)  # buckled
CLAMP = float("inf")

# Blades: the WindPACT 1.5 MW blade, whose section at the root is far heavier than the others, over
# its values at the root; and sections with soft places.
HEAVY_ROOT = Blade(
    x=(0, 0.02105, *(k / 19 for k in range(1, 20))),
    mass=(
        *(1, 0.12457, 0.1255, 0.12704, 0.12858, 0.13013, 0.12318, 0.11624, 0.1093, 0.10236),
        *(0.09541, 0.0849, 0.07438, 0.06386, 0.05334, 0.04282, 0.03583, 0.02883, 0.02183),
        *(0.01484, 0.00784),
    ),
    bending=(
        *(1, 0.1523, 0.1422, 0.12536, 0.10853, 0.091695, 0.080018, 0.068341, 0.056664, 0.044988),
        *(0.03331, 0.028363, 0.023415, 0.018468, 0.01352, 0.0085726, 0.0070625, 0.0055536),
        *(0.0040435, 0.0025347, 0.0010245),
    ),
    axial=(
        *(1, 0.12457, 0.1255, 0.12704, 0.12858, 0.13013, 0.12318, 0.11624, 0.1093, 0.10236),
        *(0.09541, 0.0849, 0.07438, 0.06386, 0.05334, 0.04282, 0.03583, 0.02883, 0.02183),
        *(0.014838, 0.0078426),
    ),
    flap=(
        *(1, 0.1523, 0.13287, 0.10049, 0.068104, 0.035722, 0.030537, 0.025352, 0.020165, 0.01498),
        *(0.0097937, 0.0081352, 0.0064765, 0.0048181, 0.0031596, 0.001501, 0.0012068, 0.00091259),
        *(0.00061837, 0.00032416, 0.000029942),
    ),
)
HEAVY = Beam(blade=HEAVY_ROOT, gamma=1.0286, delta=0.05263, mu=64.55)


def dipped(depth: float, centre: float, half: float, others: bool = False) -> Blade:
    """A section that is soft in bending about one place, or in all properties."""
    dip = (1.0, 1.0, depth, 1.0, 1.0)
    rest = dip if others else (1.0,) * 5
    return Blade((0, centre - half, centre, centre + half, 1), rest, dip, rest)


def several_dips(depth: float, half: float, centres: Sequence[float]) -> Blade:
    """A section with several soft places."""
    x, bending = [0.0], [1.0]
    for centre in centres:
        x += [centre - half, centre, centre + half]
        bending += [1.0, depth, 1.0]
    ones = (1.0,) * (len(x) + 1)
    return Blade((*x, 1.0), ones, (*bending, 1.0), ones)


def stepped(at: float, mass: float, bending: float, axial: float) -> Blade:
    """Two uniform parts."""
    return Blade((0, at, at, 1), (1, 1, mass, mass), (1, 1, bending, bending), (1, 1, axial, axial))


DIP = Beam(blade=dipped(0.001, 0.37, 0.1), gamma=3, mu=100)
BLADES: dict[str, Beam] = {
    "steel": Beam.from_toml("beamviz/presets/tapered_steel_blade.toml").replace(units=None),
    "nrel": Beam.from_toml("beamviz/presets/nrel_5mw_blade.toml").replace(units=None),
    "heavy root": HEAVY,
    "dip": DIP,
    "three stations": DIP.replace(blade=Blade((0, 0.5, 1), (1,) * 3, (1, 0.001, 1), (1,) * 3)),
    "narrow dips": DIP.replace(blade=several_dips(0.05, 0.005, (0.2, 0.45, 0.7))),
    "soft in all": DIP.replace(blade=dipped(0.05, 0.6, 0.05, others=True)),
    "stepped": Beam(blade=stepped(0.4, 0.3, 0.1, 0.4), gamma=5, delta=0.1, mu=80),
    "stiff outboard": Beam(blade=stepped(0.4, 2.0, 8.0, 3.0), gamma=5, delta=0.1, mu=80),
    "cone": Beam(blade=Blade.tapered(0.8, 0.5), gamma=8, delta=0.2, mu=120),
}


def rounded(value: float) -> float:
    """A number of six digits, which is shorter in a file."""
    return float(f"{value:.6g}")


def pick(rng: Random, weights: Mapping[float, float]) -> float:
    """One of the keys, by weight."""
    return float(rng.choice(list(weights), p=list(weights.values())))


def random_beam(rng: Random, strain: str = "green") -> Beam:
    """A beam anywhere in the accepted range; its corners and the usual places more often."""
    mu = 10 ** rng.uniform(1, 4)
    fastest = min(200.0, 5 * mu)
    inward = {rng.uniform(-2, 0): 0.15, -(10 ** rng.uniform(-3, 0.3)): 0.1}
    delta = pick(
        rng, {rng.uniform(0, 20): 0.2, 10 ** rng.uniform(-3, 1.3): 0.35, 0.0: 0.2} | inward
    )
    logarithmic = 10 ** rng.uniform(-2, np.log10(fastest))
    gamma = pick(rng, {rng.uniform(0, fastest): 0.3, logarithmic: 0.55, fastest: 0.05, 0.0: 0.1})
    if delta < 0 and rng.random() < 0.7:
        gamma = min(gamma, 10 ** rng.uniform(-2, 1.3))
    if strain == "hencky" and rng.random() < 0.7:  # else most have no equilibrium
        gamma = min(gamma, rng.uniform(0, 1.0) * mu / (1 + max(delta, 0)) ** 0.5)
    alpha = pick(rng, {10 ** rng.uniform(-3, 2): 0.5, rng.uniform(0, 3): 0.3, 0.0: 0.2})
    edge = 10 ** rng.uniform(-5, -1)
    beta = pick(rng, {rng.uniform(): 0.6, 1.0: 0.2, 0.0: 0.02, edge: 0.08, 1 - edge: 0.1})
    numbers = {"alpha": alpha, "beta": beta, "gamma": gamma, "delta": delta, "mu": mu}
    return Beam.from_record({name: rounded(value) for name, value in numbers.items()})


def usual(rng: Random, beam: Beam) -> Beam:
    """The same at a usual speed and hub."""
    gamma = min(beam.gamma, 10 ** rng.uniform(-1, 1.5), beam.mu / 3)
    return beam.replace(gamma=rounded(gamma), delta=float(np.clip(beam.delta, -1, 3)))


def random_model(rng: Random, planes: bool = True) -> Record:
    """Options of the theory, the usual ones more often; only those that are not the default."""
    flapwise = bool(planes and rng.random() < 0.35)
    drawn = {
        "strain": str(rng.choice(LAWS, p=[0.6, 0.2, 0.2])),
        "curvature": str(rng.choice(CURVATURES, p=[0.65, 0.35])),
        "plane": "flapwise" if flapwise else "chordwise",
        "coriolis": bool(not flapwise and rng.random() < 0.5),
        "modes": int(rng.choice([5, 3, 8, 12, 20], p=[0.6, 0.15, 0.15, 0.06, 0.04])),
    }
    default = {"strain": "green", "curvature": "spatial", "plane": "chordwise", "modes": 5}
    return {name: value for name, value in drawn.items() if value != default.get(name, False)}


def random_body(rng: Random) -> Mass:
    """A body, with moments of inertia that a body may have, or none."""
    size = 10 ** rng.uniform(-4, -0.5) * (rng.random() < 0.75)
    a, b, c = size * rng.dirichlet((1, 1, 1))  # int x^2, y^2, z^2 dm
    beta = pick(rng, {rng.uniform(0.01, 1): 0.7, 1.0: 0.3})
    inertia = rounded(b + c), rounded(a + c), rounded(a + b)
    return Mass(rounded(10 ** rng.uniform(-3, 1)), rounded(beta), inertia)


def random_blade(rng: Random) -> Blade:
    """A tapered section, or properties in a table, most of them falling toward the tip."""
    if rng.random() < 0.25:
        return Blade.tapered(*(rounded(rng.uniform(0, 0.9)) for _ in range(2)))
    degree = int(rng.choice([1, 2, 3], p=[0.7, 0.15, 0.15]))
    stations = 1 + degree * int(rng.integers(1, 7))
    x = np.concatenate(([0.0], np.sort(rng.uniform(0.02, 0.98, stations - 2)), [1.0]))
    x = x if degree == 1 else np.linspace(0, 1, stations)
    if degree == 1 and stations > 2 and rng.random() < 0.5:  # a jump
        place = int(rng.integers(1, stations - 1))
        x = np.insert(x, place, x[place])
    fall = rng.choice([0.1, 0.5, 1.0])
    rows = {}
    for name in ("mass", "bending", "axial", "flap"):
        steps = rng.normal(-fall / 2, fall if degree == 1 else 0.1, len(x))
        steps[0] = 0 if name != "flap" else rng.uniform(-2, 2)
        values = np.exp(np.clip(np.cumsum(steps), -6, 3))
        rows[name] = tuple(map(rounded, values.tolist()))
    return Blade(tuple(map(rounded, x.tolist())), **rows, degree=degree)


def with_bodies(rng: Random, beam: Beam, least: int = 0) -> Beam:
    """The beam with bodies and another root."""
    bodies = [random_body(rng) for _ in range(max(least, int(rng.choice([0, 1, 2, 3]))))]
    root = pick(rng, {CLAMP: 0.4, rounded(10 ** rng.uniform(-2, 4)): 0.4, 0.0: 0.2})
    return beam.replace(masses=tuple(bodies), root=root)


def is_deflected(beam: Beam, options: Record) -> bool:
    """Whether the straight state is unstable, or does not exist."""
    model = {name: options[name] for name in ("strain", "curvature") if name in options}
    try:
        return not solve(beam, modes=1, **model).equilibrium.stable
    except BeamvizError:
        return True


def random_deflected(rng: Random, strain: str, spin_up: bool) -> Beam:
    """An inward beam that may have buckled, or one that spins up."""
    mu = 10 ** rng.uniform(1, 3.5)
    fastest = min(100.0, (0.4 if strain == "hencky" else 2.0) * mu)
    delta = rng.uniform(0, 2) if spin_up and rng.random() < 0.8 else -rng.uniform(0.3, 2)
    spin = rng.choice([-1, 1]) * 10 ** rng.uniform(-1, 2) if spin_up else 0.0
    return Beam(
        alpha=rounded(pick(rng, {0.0: 0.3, rng.uniform(0, 3): 0.5, 10 ** rng.uniform(-2, 2): 0.2})),
        beta=rounded(pick(rng, {1.0: 0.3, rng.uniform(0, 1): 0.7})),
        gamma=rounded(min(fastest, 10 ** rng.uniform(0, 1.7))),
        delta=rounded(delta),
        mu=rounded(mu),
        spin_up=rounded(spin),
    )


QUICK = {  # of so many cases of a kind one is quick
    "straight": 1,
    "bodies": 1,
    "methods": 1,
    "refused": 1,
    "blades": 2,
    "deflected": 3,
    "deflected blades": 4,
    "limits": 5,
}


def seeded(
    kind: str, number: int, draw: Callable[[Random, int], tuple[Beam, Record] | None]
) -> Iterator[Record]:
    """Records of a kind, each from seeds of its own: the first for which there is a beam."""
    for k in range(number):
        for attempt in count():
            drawn = draw(np.random.default_rng([sum(map(ord, kind)), k, attempt]), k)
            if drawn:
                beam, options = drawn
                method = options.get("method", "")
                yield solve_record(f"{method or kind} {k}", kind, k, beam.record, options)
                break


def solve_record(name: str, kind: str, k: int, beam: Record, options: Record) -> Record:
    quick = k % QUICK[kind] == QUICK[kind] - 1
    return {"name": name, "kind": kind, "quick": quick, "beam": beam, "options": options}


def straight(rng: Random, k: int) -> tuple[Beam, Record]:
    options = random_model(rng)
    beam = random_beam(rng, options.get("strain", "green"))
    if k % 12 == 5:
        options["stiffening"] = False
    if k % 12 == 11:
        options["softening"] = False
    return (usual(rng, beam) if k % 2 else beam), options


def bodies(rng: Random, k: int) -> tuple[Beam, Record]:
    options = random_model(rng)
    beam = usual(rng, random_beam(rng, options.get("strain", "green")))
    return with_bodies(rng, beam, least=k % 2), options


def blades(rng: Random, k: int) -> tuple[Beam, Record]:
    options = random_model(rng)
    if k % 2:
        beam = list(BLADES.values())[k // 2 % len(BLADES)]
        if k // 2 >= len(BLADES):
            beam = with_bodies(rng, beam, least=1)
        return beam, options
    beam = usual(rng, random_beam(rng, options.get("strain", "green")))
    beam = beam.replace(blade=random_blade(rng))
    return (with_bodies(rng, beam) if k % 4 else beam), options


def deflected(rng: Random, k: int) -> tuple[Beam, Record] | None:
    options = random_model(rng, planes=k % 5 == 4)
    beam = random_deflected(rng, options.get("strain", "green"), k % 5 in (1, 3))
    if not beam.spin_up and not is_deflected(beam, options):
        return None
    state = "stable" if k % 3 or beam.spin_up else "bent"
    return beam, options | {"state": state}


def deflected_blades(rng: Random, k: int) -> tuple[Beam, Record] | None:
    options = random_model(rng, planes=k % 7 == 6) | {"state": "bent" if k % 2 else "stable"}
    if k < 2 * len(BLADES):
        beam = list(BLADES.values())[k // 2]
        spin_up, inward = rounded(10 ** rng.uniform(-1, 1)), -rounded(rng.uniform(0.8, 1.5))
        if k % 2:
            return beam.replace(spin_up=spin_up), options | {"plane": "chordwise"}
        beam = beam.replace(delta=inward, gamma=rounded(rng.uniform(1, 2) * max(beam.gamma, 4)))
    else:
        beam = random_deflected(rng, options.get("strain", "green"), k % 3 == 0)
        beam = beam.replace(gamma=min(beam.gamma, 20.0), mu=max(beam.mu, 50.0))
        if k % 4:
            beam = beam.replace(blade=random_blade(rng))
        beam = with_bodies(rng, beam, least=not k % 4)
    if beam.spin_up:
        return beam, options | {"plane": "chordwise", "state": "stable"}
    return (beam, options) if is_deflected(beam, options) else None


def methods(rng: Random, k: int) -> tuple[Beam, Record]:
    """Every method but auto, in turn."""
    method = METHODS[k % len(METHODS)]
    series = method in ("assumed-modes", "power-series", "chebyshev")
    options = random_model(rng)
    options.pop("modes", None)
    if method in ("power-series", "chebyshev"):
        options.pop("coriolis", None)
    beam = usual(rng, random_beam(rng, options.get("strain", "green")))
    turn = k // len(METHODS)
    if method in ("ancf", "linear", "foac", "zoac") and turn % 3 == 1:
        beam = beam.replace(blade=random_blade(rng))
        beam = with_bodies(rng, beam)
    elif method in ("ancf", "ancf-planar", "linear"):
        options["elements"] = int(rng.choice([6, 11, 20, 40]))
    elif series:
        beam = beam.replace(gamma=min(beam.gamma, 8.0))
        options["terms"] = {"assumed-modes": 8, "power-series": 60, "chebyshev": 30}[method]
    if method == "ancf-planar" and turn % 2:
        beam = random_deflected(rng, options.get("strain", "green"), turn % 4 == 1)
        options |= {"state": "stable", "plane": "chordwise"}
    elif method in ("foac", "zoac") and turn % 4 == 2:
        options["softening" if turn % 8 == 2 else "stiffening"] = False
    return beam, {"method": method} | {
        name: value for name, value in options.items() if (name, value) != ("plane", "chordwise")
    }


METHODS = (
    *("ancf", "ancf-planar", "linear", "foac", "zoac"),
    *("assumed-modes", "power-series", "chebyshev"),
)


def limits(rng: Random, k: int) -> tuple[Beam, Record] | None:
    """Beams without an equilibrium."""
    options = random_model(rng, planes=k % 4 == 3)
    options.pop("modes", None)
    mu, fast = 10 ** rng.uniform(1, 3), rng.uniform(1, 4)
    if k % 3 == 0:
        options["strain"] = "hencky"
        beam = Beam(rounded(rng.uniform(0, 2)), rounded(rng.uniform()), min(200.0, mu), 1, mu)
    else:
        strain = options.get("strain", "green")
        beam = Beam(rounded(rng.uniform(0, 2)), 1, min(200.0, fast * mu), -1.5 * rng.random(), mu)
        if k % 3 == 2:
            beam = random_deflected(rng, strain, True).replace(spin_up=rounded(1000 * rng.random()))
            options["state"] = "stable"
            if options.get("plane"):
                return None
    if k % 5 == 1:
        beam = beam.replace(blade=random_blade(rng))
    beam = Beam.from_record(
        {n: rounded(v) if isinstance(v, float) else v for n, v in beam.record.items()}
    )
    try:
        solve(beam, **options)
    except BeamvizError as error:
        return (beam, options) if error.kind == "no-equilibrium" else None
    return None


def refused() -> Iterator[Record]:
    """Input that is not accepted. Beams are given as records, since some are none."""
    beam, blade = Beam(gamma=2).record, BLADES["stepped"].record
    wrong: list[tuple[Record, Record]] = [
        ({"gamma": 250}, {}),
        ({"gamma": 100, "mu": 15}, {}),
        ({"alpha": -1}, {}),
        ({"beta": 1.5}, {}),
        ({"delta": -3}, {}),
        ({"speed": 3}, {}),
        ({**beam, "root": -1}, {}),
        ({**blade, "blade": {**blade["blade"], "mass": [1, 1, -1, 1]}}, {}),
        ({**blade, "blade": {**blade["blade"], "x": [0, 0.6, 0.4, 1]}}, {}),
        ({**beam, "masses": [{"alpha": 1, "beta": 2}]}, {}),
        (beam, {"modes": 0}),
        (beam, {"modes": 21}),
        (beam, {"strain": "cauchy"}),
        (beam, {"tolerance": 1}),
        (beam, {"method": "chebyshev", "coriolis": True}),
        (beam, {"method": "ancf", "terms": 5}),
        (beam, {"method": "ancf", "elements": 2}),
        (beam, {"method": "ancf", "softening": False}),
        (beam, {"method": "foac", "state": "bent"}),
        (beam, {"state": "bent", "stiffening": False}),
        (blade, {"method": "chebyshev"}),
        ({**beam, "spin_up": 3}, {}),
        ({**beam, "spin_up": 3}, {"state": "stable", "plane": "flapwise"}),
    ]
    for k, (numbers, options) in enumerate(wrong):
        yield solve_record(f"refused {k}", "refused", k, numbers, options)


def solves() -> Iterator[Record]:
    """The beams and options of `solve`."""
    yield from seeded("straight", 110, straight)
    yield from seeded("bodies", 40, bodies)
    yield from seeded("blades", 60, blades)
    yield from seeded("deflected", 60, deflected)
    yield from seeded("deflected blades", 44, deflected_blades)
    yield from seeded("methods", 9 * len(METHODS), methods)
    yield from seeded("limits", 15, limits)
    yield from refused()


# Charts.

A, B = Beam(alpha=1, beta=0.5, gamma=10), Beam(alpha=0.5, beta=0.3, gamma=6, delta=0.5, mu=40)
CHARTS: list[tuple[Beam, str, float, float, Record]] = [
    (A, "gamma", 0, 20, {}),
    (A, "gamma", 0, 20, {"coriolis": True}),
    (A, "gamma", 0, 60, {"per_rev": 3}),
    (B, "gamma", 0, 30, {"modes": 8}),
    (B, "gamma", 0, 30, {"coriolis": True, "modes": 8, "per_rev": 2}),
    (B, "gamma", 0, 40, {"plane": "flapwise", "per_rev": 6}),
    (B, "gamma", 1, 30, {"strain": "biot", "curvature": "material"}),
    (B, "gamma", 0, 30, {"strain": "hencky"}),
    (B, "gamma", 0, 60, {"strain": "hencky", "coriolis": True}),
    (Beam(mu=20), "gamma", 0, 30, {"coriolis": True}),
    (Beam(mu=1000, delta=1), "gamma", 0, 100, {"modes": 6}),
    (Beam(alpha=5, beta=0.8, mu=30), "gamma", 0, 25, {"coriolis": True, "modes": 7}),
    (A, "alpha", 0, 5, {}),
    (A, "alpha", 0, 5, {"coriolis": True}),
    (B, "alpha", 0, 50, {"modes": 7}),
    (B, "alpha", 0, 10, {"coriolis": True, "modes": 7}),
    (A, "beta", 0, 1, {}),
    (A, "beta", 0, 1, {"coriolis": True}),
    (B, "beta", 0, 1, {"modes": 8}),
    (B, "beta", 0.1, 0.9, {"coriolis": True, "modes": 8}),
    (Beam(alpha=20, gamma=5, mu=50), "beta", 0, 1, {"modes": 6}),
    (A, "delta", 0, 3, {}),
    (A, "delta", -1.5, 1, {"coriolis": True}),
    (A, "delta", -1.5, 1, {"state": "stable"}),
    (B, "delta", -1, 2, {"strain": "biot"}),
    (A, "mu", 20, 200, {}),
    (A, "mu", 20, 200, {"coriolis": True}),
    (B, "mu", 10, 500, {"modes": 7, "strain": "biot"}),
    (Beam(alpha=0.2, beta=0.7, gamma=30, mu=70), "mu", 20, 120, {"coriolis": True, "modes": 6}),
    (INWARD, "gamma", 0, 12, {}),
    (INWARD, "gamma", 0, 12, {"state": "stable"}),
    (INWARD, "gamma", 0, 12, {"state": "stable", "coriolis": True}),
    (INWARD.replace(alpha=0.5, beta=0.6), "gamma", 1, 15, {"state": "stable"}),
    (INWARD, "gamma", 6, 20, {"state": "bent", "modes": 4}),
    (INWARD, "gamma", 0, 12, {"state": "stable", "plane": "flapwise"}),
    (INWARD, "delta", -1.8, -0.2, {"state": "stable"}),
    (INWARD.replace(mu=20), "gamma", 0, 30, {"strain": "biot"}),
    (Beam(alpha=1, beta=0.5, gamma=6), "spin_up", -20, 20, {"state": "stable"}),
    (Beam(gamma=10, delta=0.5), "spin_up", 0, 60, {"state": "stable", "coriolis": True}),
    (INWARD, "spin_up", -10, 10, {"state": "stable", "modes": 3}),
    (Beam(gamma=3, spin_up=15), "gamma", 0, 12, {"state": "stable", "coriolis": True}),
    (Beam(alpha=1, beta=0.6, gamma=4, spin_up=5), "alpha", 0, 3, {"state": "stable"}),
    (BLADES["steel"], "gamma", 0, 20, {"per_rev": 2}),
    (BLADES["steel"], "gamma", 0, 20, {"plane": "flapwise", "per_rev": 4}),
    (BLADES["nrel"], "gamma", 0, 12, {"modes": 4}),
    (BLADES["nrel"], "gamma", 0, 12, {"plane": "flapwise", "modes": 4, "per_rev": 6}),
    (BLADES["stepped"], "gamma", 0, 30, {"coriolis": True, "modes": 6}),
    (BLADES["cone"], "mu", 20, 150, {"coriolis": True}),
    (BLADES["cone"], "delta", 0, 2, {"modes": 6}),
    (BLADES["soft in all"], "gamma", 0, 10, {}),
    (BLADES["stepped"].replace(delta=-1.0), "gamma", 0, 8, {"state": "stable", "modes": 3}),
    (
        Beam(masses=(Mass(0.5, 0.6, (0.01, 0.02, 0.025)),), root=5.0, delta=0.2),
        *("gamma", 0, 20, {"coriolis": True}),
    ),
    (Beam(masses=(Mass(0.5, 1.0, (0.01, 0.02, 0.025)),), root=0.0, delta=0.2), "gamma", 1, 20, {}),
    (Beam(alpha=1, gamma=5, root=2.0, masses=(Mass(0.3, 0.4),)), "beta", 0.05, 1, {"modes": 6}),
    (Beam(root=0.0, delta=0.29, mu=1000), "gamma", 1, 15, {"plane": "flapwise"}),
    (A, "gamma", 0, 6, {"method": "zoac"}),
    (A, "gamma", 0, 30, {"method": "foac", "coriolis": True}),
    (A, "gamma", 0, 20, {"method": "ancf", "coriolis": True}),
    (A, "beta", 0, 1, {"method": "linear", "elements": 10}),
    (A, "gamma", 0, 20, {"method": "chebyshev"}),
    (B, "gamma", 0, 10, {"method": "assumed-modes", "coriolis": True}),
]


QUICK_CHARTS = (0, 1, 12, 13, 16, 21, 22, 25, 26, 29, 34, 42, 46, 48, 51, 54, 55)


def charts() -> Iterator[Record]:
    """The arguments of `loci`."""
    for k, (beam, over, start, stop, options) in enumerate(CHARTS):
        yield {
            "name": f"chart {k}",
            "kind": "charts",
            "quick": k in QUICK_CHARTS,
            "beam": beam.record,
            "over": over,
            "start": start,
            "stop": stop,
            "options": options,
        }


# Motions. Some are damped: a load that ends at once makes waves that hardly any step resolves.

KANE = Beam(mu=444)
CARRIER = Beam(alpha=0.5, beta=0.7, gamma=2, delta=0.1, mu=60)
SHORT = CARRIER.replace(mu=20)
SPEEDS = ((0.0, 0.5, 1.2, 2.0), (2.0, 3.0, 0.5, 1.5))
STOP = {"to": 0, "within": 1.3, "shape": "linear", "start": 2.0}
TORQUE = ((0.0, 0.7, 1.5), (2.0, -3.0, 0.0))
BENT = {"start": {"B1": 0.1}}
MOTIONS: dict[str, tuple[Beam, float, Record]] = {
    "ramp": (KANE, 3, {"speed": {"ramp": {"to": 4, "within": 2}}}),
    "linear stop": (CARRIER, 2, {"speed": {"ramp": STOP}, "damping": 0.02}),
    "samples": (CARRIER, 2, {"speed": {"samples": SPEEDS}, "damping": 0.05}),
    "hub": (CARRIER, 2, {"speed": {"hub": {"inertia": 0.6, "torque": 1.5}}}),
    "torque in time": (CARRIER, 2, {"speed": {"hub": {"inertia": 1.5, "torque": TORQUE}}}),
    "released": (Beam(alpha=1, gamma=2, mu=50), 2, {"release": 1.0}),
    "released inboard": (CARRIER, 2, {"release": 3.0, "release_at": 0.7, "damping": 0.02}),
    "modes": (CARRIER, 2, {"start": {"B1": 0.1, "B2": 0.01}}),
    "damped": (Beam(alpha=0.3, beta=0.5, gamma=4, mu=100), 2, {**BENT, "damping": 0.05}),
    "stretching": (Beam(gamma=1, mu=20), 0.5, {"start": {"S1": 0.01}}),
    "buckled": (INWARD.replace(gamma=5), 1.5, {"state": "bent", **BENT, "damping": 0.02}),
    "catch": (CARRIER, 1, {"catch": 0.4, "body_velocity": (0.1, -0.2), "damping": 0.3}),
    "drop": (CARRIER, 1, {"drop": 0.4, "damping": 0.1, "start": {"B1": 0.05}}),
    "biot": (SHORT, 1, {"strain": "biot", "curvature": "material", **BENT}),
    "hencky": (SHORT, 1, {"strain": "hencky", **BENT}),
    "ancf": (CARRIER, 1, {"method": "ancf", "elements": 8, "release": 1.0}),
    "gauss": (CARRIER, 1, {"integrator": "gauss", **BENT}),
    "generalised-alpha": (
        CARRIER,
        1,
        {"integrator": "generalised-alpha", "step": 0.002, "release": 1.0},
    ),
}
QUICK_MOTIONS = ("damped", "catch", "biot", "ramp")


def motions() -> Iterator[Record]:
    """The arguments of `motion`."""
    for name, (beam, until, options) in MOTIONS.items():
        yield {
            "name": f"motion, {name}",
            "kind": "motions",
            "quick": name in QUICK_MOTIONS,
            "beam": beam.record,
            "until": until,
            "options": options,
        }


KINDS = (
    *("straight", "bodies", "blades", "deflected", "deflected blades", "methods", "limits"),
    *("refused", "charts", "motions"),
)
