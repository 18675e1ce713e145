"""Fixed random beams with the oracle's answers, so that a test holds hundreds of them against the
solver in the time that the solver takes. scripts/oracle_values.py writes the file.
"""

import gzip
import json
from collections.abc import Callable, Iterable
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from beamviz import Beam, Solution
from oracle.error_bars import (
    ROUNDING,
    Scene,
    bent_limited,
    bent_oracle,
    bent_verdict,
    held,
    judged,
    oracle_answer,
    random_bent_dip_scene,
    random_bent_scene,
    random_blade_scene,
    random_scene,
    random_space_scene,
    verdict,
)

FILE = Path(__file__).with_name("fixed.json.gz")
SAME_STATE = 1e-3  # [L] between the tips of the same deflected state
KINDS: dict[str, tuple[Callable[[int], Scene], Iterable[int]]] = {  # how they are drawn, and seeds
    "uniform": (random_scene, range(100)),
    "blade": (random_blade_scene, range(120)),
    "both planes": (random_space_scene, range(30)),
    "deflected": (random_bent_scene, range(20)),
    "deflected blade": (partial(random_bent_scene, blades=True), range(30)),
    # Of a strain that is large where the blade is soft, on elements that reach over the dip: there
    # the stretch of a section has two roots, and one fitted to another mesh may be negative.
    "deflected blade with dips": (random_bent_dip_scene, (201, 418)),
}
DEFLECTED = ("deflected", "deflected blade", "deflected blade with dips")
Record = dict[str, Any]


def made(kind: str, seed: int) -> Record:
    """A case of the file: its beam and options, and the oracle's answer."""
    draw, _ = KINDS[kind]
    scene = draw(seed)
    return {
        "kind": kind,
        "seed": seed,
        "beam": scene.beam.record,
        "options": scene.options,
        "answer": answer(kind, scene),
    }


def answer(kind: str, scene: Scene) -> Record:
    """The oracle's answer to a scene, in the types of JSON."""
    return bent_oracle(scene) if kind in DEFLECTED else oracle_answer(scene)


@cache
def read() -> list[Record]:
    """The cases of the file."""
    with gzip.open(FILE, "rt", encoding="utf-8") as text:
        return json.load(text)


def write(cases: list[Record]) -> None:
    """Write the file: the same bytes for the same cases."""
    text = "[\n" + ",\n".join(json.dumps(case) for case in cases) + "\n]\n"
    FILE.write_bytes(gzip.compress(text.encode(), mtime=0))


def name_of(case: Record) -> str:
    return f"{case['kind']} {case['seed']}"


def scene_of(case: Record) -> Scene:
    return Scene(Beam.from_record(case["beam"]), case["options"])


def verdict_of(case: Record) -> Record:
    """The verdict on the solver's answer to a case."""
    scene, known = scene_of(case), case["answer"]
    if case["kind"] not in DEFLECTED:
        return verdict(scene, known)
    if "real" not in known:
        return bent_verdict(scene)
    return judged(scene, partial(bent_beside, scene, known), partial(bent_limited, scene))


def bent_beside(scene: Scene, known: Record, solution: Solution) -> Record:
    """The verdict on a solution of a deflected beam, by the known answer. A beam may have several
    states: to another one than that of the file the oracle has to answer."""
    if np.abs(solution.equilibrium.tip - known["tip"]).max() > SAME_STATE:
        return bent_verdict(scene)
    omega = np.array(known["real"]) + 1j * np.array(known["imag"])
    oracle_error = known["differences"] + ROUNDING * abs(omega)
    return held(abs(solution.s - 1j * omega), solution.errors, oracle_error, abs(omega))
