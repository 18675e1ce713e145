"""Beams, charts and motions from records in JSON, and the answers of the program as records of
arrays."""

import gzip
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from beamviz import Beam, Blade, Hub, Loci, Mass, Motion, Ramp, Solution, loci, motion, solve
from beamviz.errors import BeamvizError

FILE = Path(__file__).with_name("answers.json.gz")
Record = dict[str, Any]

X = (0.3137, 0.7219, 1.0)  # of shapes and the state
DEFAULT = 1e-6  # tolerance
CHART_VALUES, MOTION_TIMES = 11, 41
ARRAYS = (
    *("s", "errors", "fraction", "shapes", "position", "stretch", "root", "limit"),
    *("tip", "gamma", "angle", "energy"),
)


# What is asked for, from records.


def beam_of(record: Mapping[str, Any]) -> Beam:
    """The beam of a record."""
    numbers = dict(record)
    if "blade" in numbers:
        numbers["blade"] = Blade(**numbers["blade"])
    if "masses" in numbers:
        numbers["masses"] = tuple(Mass(**mass) for mass in numbers["masses"])
    return Beam(**numbers)


def drive_of(speed: Mapping[str, Any]) -> Any:
    """The argument `speed` of a motion."""
    (kind,) = speed
    given = speed[kind]
    return {"ramp": lambda: Ramp(**given), "hub": lambda: Hub(**given), "samples": lambda: given}[
        kind
    ]()


def call_of(case: Mapping[str, Any]) -> str:
    """The call that gives an answer of a case."""
    function = {"charts": "loci", "motions": "motion"}.get(case["kind"], "solve")
    names = ("over", "start", "stop", "until")
    given = {name: case[name] for name in names if name in case} | case["options"]
    arguments = ", ".join(f"{name}={value!r}" for name, value in given.items())
    return f"{function}({case['beam']}, {arguments})"


# Answers, as records of arrays.

MEASURED = ("at", "frequency", "gap", "index")  # of an event


def answer(beam: Mapping[str, Any], options: Mapping[str, Any]) -> Record:
    """The solution of a beam, or the kind of its error."""
    try:
        return solution_record(solve(beam_of(beam), **options))
    except BeamvizError as error:
        return error_record(error)


def error_record(error: BeamvizError) -> Record:
    """The kind of an error, and the limit that it names."""
    limit = getattr(error, "limit", None)
    return {"is": error.kind} | ({} if limit is None else {"limit": np.array([limit])})


def solution_record(solution: Solution) -> Record:
    state, x = solution.equilibrium, np.array(X)
    shapes = np.moveaxis(solution.displacement(x), 2, 0)  # (modes, x, 2)
    return {
        "is": "solution",
        "status": state.status,
        "state": state.shape,
        "buckled_chordwise": bool(state.buckled_chordwise),
        "labels": list(solution.labels),
        "families": list(solution.families),
        "s": solution.s,
        "errors": solution.errors,
        "fraction": solution.bending_energy_fraction,
        "shapes": shapes,
        "nodes": [nodes.tolist() for nodes in solution.nodes],
        "position": state.position(x),
        "stretch": np.append(state.stretch(x), state.max_stretch),
        "root": np.array([state.root_force, state.root_shear, state.root_moment]),
    }


def chart_answer(case: Mapping[str, Any], tolerance: float | None) -> Record:
    """Branches at some values, events and limits of a chart, or the kind of an error."""
    values = np.linspace(case["start"], case["stop"], CHART_VALUES)
    options = with_tolerance(case["options"], tolerance)
    try:
        found = loci(beam_of(case["beam"]), case["over"], values, **options)
    except BeamvizError as error:
        return error_record(error)
    return chart_record(found)


def chart_record(found: Loci) -> Record:
    names = ("kind", "branches", *MEASURED, "per_rev")
    return {
        "is": "chart",
        "branches": {
            branch.label: {"s": branch.s, "errors": branch.error} for branch in found.branches
        },
        "events": [
            {name: listed(getattr(event, name)) for name in names} for event in found.events
        ],
        "limits": [
            {"kind": limit.kind, "start": limit.start, "stop": limit.stop} for limit in found.limits
        ],
    }


def listed(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


def motion_answer(case: Mapping[str, Any], tolerance: float) -> Record:
    """The tip over time, or the kind of an error."""
    options = dict(case["options"])
    if "speed" in options:
        options["speed"] = drive_of(options["speed"])
    options |= {"tolerance": tolerance, "points": MOTION_TIMES}
    try:
        return motion_record(motion(beam_of(case["beam"]), case["until"], **options))
    except BeamvizError as error:
        return error_record(error)


def motion_record(moved: Motion) -> Record:
    names = ("tip", "gamma", "angle", "energy")
    arrays = {name: np.array(getattr(moved, name)) for name in names}
    return {"is": "motion", "error": moved.error, **arrays}


def with_tolerance(options: Mapping[str, Any], tolerance: float | None) -> Record:
    """Options with a tolerance; None where the resolution is given."""
    return dict(options) if tolerance is None else {**options, "tolerance": tolerance}


# In the types of JSON arrays are lists, complex ones have their real and imaginary parts.


def unpacked(value: Any, name: str = "") -> Any:
    """A value of the file; quantities as arrays."""
    if isinstance(value, dict) and "real" in value:
        real = np.array(value["real"], float)
        return real + 1j * np.array(value.get("imag", np.zeros(real.shape)), float)
    if isinstance(value, dict):
        return {key: unpacked(each, key) for key, each in value.items()}
    if isinstance(value, list) and name in ARRAYS:
        return np.array(value, float)
    if isinstance(value, str) and value in ("nan", "inf", "-inf"):
        return float(value)
    return value


def case_of(record: Record) -> Record:
    """A case of the file: what was asked for as it is, the answers unpacked."""
    answers = ("answer", "spread", "default")
    return record | {name: unpacked(record[name]) for name in answers if name in record}


def read() -> list[Record]:
    """The cases of the file."""
    with gzip.open(FILE, "rt", encoding="utf-8") as text:
        return [case_of(record) for record in json.load(text)["cases"]]
