"""Today's answers as a file, and the answers of a later code compared with it:

    python scripts/golden.py write tests/golden.json.gz
    python scripts/golden.py compare tests/golden.json.gz [--only KIND] [--quick]

Values are those of the finest tolerance that converges, confirmed by another mesh: the same section
at more stations. Beside them stands their spread: the greatest change by another tolerance, another
mesh or, where the resolution is given, numbers changed in the last digit. `compare` allows

    frequencies       1e-9, relative, and the estimated errors of both
    at the default tolerance: the estimated error alone, which has to be within the tolerance
    motions           the sum of their error bars
    all other values  ten times their spread, and a share of their size (FLOORS)

It prints what is beyond, and ends with 1 if there is anything. What the code that wrote the file
did not meet itself, as error bars that were false, counts with --strict only. A beam for which no
solution was found may have one.
"""

import gzip
import json
import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import _script
import numpy as np
from golden_cases import KINDS, charts, motions, solves
from numpy.typing import ArrayLike, NDArray

from beamviz import Beam, Blade, Hub, Loci, Mass, Motion, Ramp, Solution, loci, motion, solve
from beamviz.errors import BeamvizError

Record = dict[str, Any]

X = (0.3137, 0.7219, 1.0)  # of shapes and the state
RELATIVE = 1e-9  # of frequencies
SLOW = 0.01  # [1/T*] frequency below which an error is relative to this one
DEFAULT, REFERENCE = 1e-6, 1e-10  # tolerances
COARSER = (REFERENCE, 1e-9, 1e-8, 1e-7, DEFAULT)  # the first that converges is compared
FINER = (1e-12, 1e-11)
WIDER_BARS = 10.0  # bars that rounding makes may be this times as wide
SPREADS = 10.0  # so many spreads are allowed
FLOORS = {  # share of the size of a quantity that is allowed
    "position": 1e-8,
    "stretch": 1e-7,
    "root": 1e-7,
    "fraction": 1e-6,
    "shapes": 1e-6,
    "nodes": 1e-5,
    "limit": 1e-7,
    "gamma": 1e-9,
    "angle": 1e-6,
    "energy": 1e-6,
    "tip": 1e-6,
    "at": 1e-8,
    "frequency": 1e-8,
    "gap": 1e-6,
    "index": 1e-4,
}
LAST_DIGITS = (4e-16, -8e-16)  # relative changes of the numbers: what rounding does
CLOSE = 1e-7  # relative distance of two frequencies below which their order is chance
THRESHOLDS = (0.1, 0.5, 0.9)  # of the bending fraction, where a label or a family changes
BORDERLINE = 0.02  # of the veering index, about the least that is listed
LEAST_INDEX = 0.5
CHART_TOLERANCES, CHART_VALUES = (1e-8, 1e-9), 11  # compared, stored
SLOW_CHART_TOLERANCES, MANY_STATIONS = (1e-6, 1e-7), 20  # of blades
MOTION_TOLERANCE, MOTION_CHECK, MOTION_TIMES = 1e-6, 1e-5, 41
# The kinds of events and limits that are compared: others may be added.
EVENTS = (
    *("crossing", "veering", "coalescence", "resonance"),
    *("buckling", "limit point", "second state"),
)
LIMITS = ("no-equilibrium", "unstable", "growing")
REPORTED = 60  # rows of the table, at most
LONG = 3.0  # [s] of a case that is told of


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


def has_resolution(options: Mapping[str, Any]) -> bool:
    """Whether the method has a given resolution, and does not refine to a tolerance."""
    return options.get("method", "auto") not in ("auto", "foac", "zoac")


# The same beam on another mesh, or in numbers changed by rounding.


def at_more_stations(beam: Mapping[str, Any]) -> Record | None:
    """The same section at more stations, None where it cannot have more."""
    if "blade" not in beam:
        ones = [1.0] * 4
        return {
            **beam,
            "blade": {"x": [0, 0.31, 0.74, 1], "mass": ones, "bending": ones, "axial": ones},
        }
    blade = Blade(**beam["blade"])
    part = np.linspace(0, 1, blade.degree + 1)
    halves = np.concatenate((0.45 * part, 0.45 + 0.55 * part[1:]))
    rows: dict[str, list[float]] = {name: [] for name in beam["blade"] if name != "degree"}
    for segment in blade.segments:
        jumps = segment.start > 0 and blade.x.count(segment.start) > 1
        places = halves if segment.start == 0 or jumps else halves[1:]
        for name, row in rows.items():
            if name == "x":
                row += (segment.start + places * (segment.stop - segment.start)).tolist()
            else:
                row += segment.polynomials[name](places).tolist()
    rows["x"][-1] = 1.0
    for name in ("mass", "bending", "axial"):
        rows[name][0] = 1.0
    if len(rows["x"]) > 200:
        return None
    return {**beam, "blade": {**rows, "degree": blade.degree}}


def rounded_numbers(beam: Mapping[str, Any]) -> Iterator[Record]:
    """The beam with numbers changed in their last digits."""
    for change in LAST_DIGITS:
        numbers = {name: beam[name] * (1 + change) for name in ("alpha", "gamma", "delta")}
        yield {**beam, **numbers, "mu": min(max(beam["mu"] * (1 + change), 10.0), 10_000.0)}


# Differences, each over what is allowed.


class Row(NamedTuple):
    """A quantity of a case that was compared. ratio: the difference over what is allowed."""

    quantity: str
    golden: Any
    now: Any
    ratio: float


def compared(quantity: str, golden: ArrayLike, now: ArrayLike, allowed: ArrayLike) -> Row:
    """The greatest difference of two arrays over what is allowed. nan equals nan alone."""
    golden, now = np.asarray(golden), np.asarray(now)
    if golden.shape != now.shape:
        return Row(quantity, f"shape {golden.shape}", f"shape {now.shape}", math.inf)
    if not golden.size:
        return Row(quantity, "", "", 0.0)
    allowed = np.broadcast_to(np.maximum(allowed, 1e-300), golden.shape)
    with np.errstate(invalid="ignore"):
        ratios = np.where(golden == now, 0.0, abs(now - golden) / allowed)
    absent = np.isnan(golden), np.isnan(now)
    ratios = np.where(absent[0] & absent[1], 0.0, np.where(absent[0] ^ absent[1], np.inf, ratios))
    worst = np.unravel_index(np.argmax(ratios), ratios.shape)
    return Row(quantity, golden[worst].item(), now[worst].item(), float(ratios[worst]))


def same(quantity: str, golden: Any, now: Any) -> Row:
    """Whether two values are equal."""
    return Row(quantity, golden, now, 0.0 if golden == now else math.inf)


def distance(s: NDArray, other: NDArray, allowed: NDArray) -> tuple[NDArray, NDArray]:
    """The differences of s, and what is allowed of them if `allowed` is for one that is not small:
    the error of a small one is that of its square."""
    least = np.minimum(allowed, 1.0)
    beside = abs(other**2 - s**2) / np.maximum(2 * abs(s) + least, 1e-300)
    return np.minimum(abs(other - s), beside), allowed


def frequencies(quantity: str, golden: NDArray, now: NDArray, allowed: NDArray) -> Row:
    """s (modes,) of two answers."""
    if golden.shape != now.shape:
        return Row(quantity, f"{len(golden)} modes", f"{len(now)} modes", math.inf)
    apart, allowed = distance(golden, now, allowed)
    ratios = np.where(apart == 0, 0.0, apart / np.maximum(allowed, 1e-300))
    if np.isnan(ratios).any():
        ratios = np.where(np.isnan(golden) & np.isnan(now), 0.0, np.nan_to_num(ratios, nan=np.inf))
    worst = int(np.argmax(ratios))
    return Row(quantity, shown(golden[worst]), shown(now[worst]), float(ratios[worst]))


def shown(value: complex) -> Any:
    """s as a frequency where it is one."""
    value = complex(value)
    return value.imag if value.real == 0 else value


def size(s: NDArray) -> NDArray:
    """What the error of a mode is relative to (modes,)."""
    return np.maximum(abs(s), SLOW)


def sensitivity(s: NDArray) -> NDArray:
    """How much more a mode (modes,) changes that has near neighbours."""
    squares = s**2
    apart = abs(squares[:, None] - squares) + np.diag(np.full(len(s), np.inf))
    return np.clip(abs(squares) / np.maximum(apart.min(axis=1), 1e-300), 1.0, 1e6)


def are_close(s: NDArray) -> NDArray:
    """Whether each mode (modes,) has a neighbour with the same s, so that their order is chance."""
    apart = abs(s[:, None] - s) + np.diag(np.full(len(s), np.inf))
    return np.asarray(apart.min(axis=1) < CLOSE * size(s))


def is_ambiguous(answer: Mapping[str, Any], guard: float) -> bool:
    """Whether labels and families are chance: by equal frequencies, by shares at a threshold."""
    near = abs(answer["fraction"][:, None] - THRESHOLDS) < guard
    return bool(near.any() or are_close(answer["s"]).any())


def solve_rows(case: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[Row]:
    """The quantities of an answer at the tolerance of the case."""
    golden, spread = case["answer"], case["spread"]
    yield outcome_row("", golden["is"], now["is"])
    if golden["is"] != now["is"]:
        return
    if golden["is"] != "solution":
        if "limit" in golden and case["limit_counts"]:
            allowed = FLOORS["limit"] * abs(golden["limit"]) + SPREADS * spread["limit"]
            yield compared("limit", golden["limit"], now["limit"], allowed)
        return
    for name in ("status", "state", "buckled_chordwise"):
        yield same(name, golden[name], now[name])
    s, tolerance = golden["s"], case["tolerance"]
    if tolerance is None:
        yield frequencies("s", s, now["s"], RELATIVE * size(s) + SPREADS * spread["s"])
        yield bars_of_resolution(golden["errors"], now["errors"])
    else:
        errors = golden["errors"] + now["errors"]
        yield frequencies("s", s, now["s"], RELATIVE * size(s) + errors)
        most = WIDER_BARS * golden["errors"] + tolerance * size(s)
        yield bars("errors", golden["errors"], now["errors"], most)
    if len(s) != len(now["s"]):
        return
    if not is_ambiguous(golden, 1e-5):
        yield same("labels", golden["labels"], now["labels"])
        yield same("families", golden["families"], now["families"])
    yield from field_rows(golden, now, spread)


def outcome_row(prefix: str, golden: str, now: str) -> Row:
    """Whether there is an answer of the same kind. One may be found where there was none."""
    improved = golden == "not-converged" and now in ("solution", "no-equilibrium")
    return Row(prefix + "answer", golden, now, 0.0 if golden == now or improved else math.inf)


def bars(quantity: str, golden: NDArray, now: NDArray, most: NDArray) -> Row:
    """Estimated errors, of which each has a greatest value."""
    ratios = now / most
    worst = int(np.argmax(np.nan_to_num(ratios, nan=np.inf)))
    return Row(quantity, float(golden[worst]), float(now[worst]), float(ratios[worst]))


def bars_of_resolution(golden: NDArray, now: NDArray) -> Row:
    """Estimated errors at the same resolution: infinite, or the same within a factor of two where
    they are not rounding errors."""
    with np.errstate(invalid="ignore"):
        ratios = np.where(golden == now, 0.0, now / np.maximum(2 * golden, 1e-9))
    worst = int(np.argmax(np.nan_to_num(ratios, nan=np.inf)))
    return Row("errors", float(golden[worst]), float(now[worst]), float(ratios[worst]))


def field_rows(golden: Record, now: Mapping[str, Any], spread: Record) -> Iterator[Row]:
    """State, shapes and shares of the energy."""
    for name in ("position", "stretch", "root"):
        allowed = FLOORS[name] * abs(golden[name]).max() + SPREADS * spread[name]
        yield compared(name, golden[name], now[name], allowed)
    s = golden["s"]
    distinct, sensitive = ~are_close(s), sensitivity(s)
    for name in ("fraction", "shapes"):
        values, floor = golden[name][distinct], FLOORS[name] * sensitive[distinct]
        if name == "shapes":
            floor = floor * abs(values).max(axis=(1, 2), initial=0.0)
        allowed = floor + SPREADS * spread[name][distinct]
        shape = (-1, *[1] * (values.ndim - 1))
        yield compared(name, values, now[name][distinct], allowed.reshape(shape))
    if golden["nodes"] is not None and distinct.all():
        counts = [[len(nodes) for nodes in each["nodes"]] for each in (golden, now)]
        yield same("number of nodes", *counts)
        if counts[0] == counts[1]:
            ours, theirs = (np.concatenate([[], *each["nodes"]]) for each in (golden, now))
            allowed = FLOORS["nodes"] * sensitive.max() + SPREADS * spread["nodes"]
            yield compared("nodes", ours, theirs, allowed)


def default_rows(case: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[Row]:
    """The quantities of an answer at the default tolerance, within its own bars."""
    golden, default = case["answer"], case["default"]
    yield outcome_row("default: ", default["is"], now["is"])
    if not golden["is"] == default["is"] == now["is"] == "solution":
        return
    for name in ("status", "state", "buckled_chordwise"):
        yield same(f"default: {name}", golden[name], now[name])
    s = golden["s"]
    yield frequencies("default: s", s, now["s"], now["errors"] + golden["errors"])
    if len(s) != len(now["s"]):
        return
    most = np.maximum(WIDER_BARS * golden["errors"] + DEFAULT * size(s), 2 * default["errors"])
    yield bars("default: errors", default["errors"], now["errors"], most)
    if not is_ambiguous(golden, 1e-3) and sensitivity(s).max() < 100:
        yield same("default: labels", golden["labels"], now["labels"])


def chart_rows(case: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[Row]:
    """Branches, events and limits of a chart."""
    golden, spread = case["answer"], case["spread"]
    yield outcome_row("", golden["is"], now["is"])
    if golden["is"] != now["is"] or golden["is"] != "chart":
        return
    yield same("branches", list(golden["branches"]), list(now["branches"]))
    for label in golden["branches"].keys() & now["branches"].keys():
        ours, theirs = golden["branches"][label], now["branches"][label]
        allowed = RELATIVE * size(np.nan_to_num(ours["s"]))
        if case["tolerance"] is None:
            allowed += SPREADS * spread["s"][label]
        else:
            allowed += np.nan_to_num(ours["errors"]) + np.nan_to_num(theirs["errors"])
        yield frequencies(f"branch {label}", ours["s"], theirs["s"], allowed)
    yield from event_rows(case, now)
    yield from limit_rows(case, now)


def event_rows(case: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[Row]:
    """Events, each with the nearest one of the same kind and branches."""
    length = case["stop"] - case["start"]
    left = [event for event in now["events"] if event["kind"] in EVENTS]
    for event, spread in zip(case["answer"]["events"], case["spread"]["events"], strict=True):
        name = name_of(event)
        twin = nearest(event, left)
        if twin is None:
            if not is_borderline(event, case):
                yield Row(name, f"at {event['at']:.9g}", "missing", math.inf)
            continue
        left.remove(twin)
        for quantity in MEASURED:
            scale = length if quantity == "at" else max(abs(event["frequency"]), SLOW)
            if quantity == "index":
                scale = 1.0
            allowed = FLOORS[quantity] * scale + SPREADS * spread[quantity]
            yield compared(f"{name}: {quantity}", event[quantity], twin[quantity], allowed)
    for event in left:
        if not is_borderline(event, case):
            yield Row(name_of(event), "none", f"at {event['at']:.9g}", math.inf)


def name_of(event: Mapping[str, Any]) -> str:
    times = f" {event['per_rev']}x" if event["per_rev"] else ""
    return f"{event['kind']}{times} {' '.join(event['branches'])}"


def nearest(event: Mapping[str, Any], others: list[Record]) -> Record | None:
    """The nearest of some events of the same kind and branches."""
    alike = [other for other in others if name_of(other) == name_of(event)]
    return min(alike, key=lambda other: abs(other["at"] - event["at"]), default=None)


def is_borderline(event: Mapping[str, Any], case: Mapping[str, Any]) -> bool:
    """Whether it is chance that an event is listed: at an end of the chart, or a veering whose
    index is at the least that is one."""
    slack = 1e-6 * (case["stop"] - case["start"])
    at_end = min(abs(event["at"] - case["start"]), abs(event["at"] - case["stop"])) < slack
    doubtful = event["kind"] == "veering" and abs(event["index"] - LEAST_INDEX) < BORDERLINE
    return bool(at_end or doubtful)


def limit_rows(case: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[Row]:
    """The ranges without equilibrium or stability; those without convergence may become less."""
    length = case["stop"] - case["start"]
    ours, theirs = counted_limits(case["answer"]), counted_limits(now)
    kinds = [[limit["kind"] for limit in limits] for limits in (ours, theirs)]
    yield same("limits", *kinds)
    if kinds[0] == kinds[1]:
        for k, (golden, limit) in enumerate(zip(ours, theirs, strict=True)):
            for end in ("start", "stop"):
                allowed = FLOORS["at"] * length + SPREADS * case["spread"]["limits"][k][end]
                yield compared(f"{golden['kind']}: {end}", golden[end], limit[end], allowed)


def counted_limits(chart: Mapping[str, Any]) -> list[Record]:
    """The limits of a chart that do not depend on the mesh."""
    return [limit for limit in chart["limits"] if limit["kind"] in LIMITS]


def motion_rows(case: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[Row]:
    """The quantities of a motion at all times."""
    golden, spread = case["answer"], case["spread"]
    yield outcome_row("", golden["is"], now["is"])
    if golden["is"] != now["is"] or golden["is"] != "motion":
        return
    given = case["options"].get("method") == "ancf" or "step" in case["options"]
    if given:  # error bars are those of the resolution
        allowed = FLOORS["tip"] + SPREADS * spread["tip"]
    else:
        allowed = golden["error"] + now["error"]
        errors = (golden["error"], now["error"], MOTION_TOLERANCE)
        yield bars("error", *(np.array([value]) for value in errors))
    apart = np.linalg.norm(now["tip"] - golden["tip"], axis=1)
    k = int(np.argmax(apart))
    yield Row("tip", golden["tip"][k].tolist(), now["tip"][k].tolist(), float(apart[k] / allowed))
    for name in ("gamma", "angle", "energy"):
        scale = max(float(abs(golden[name]).max()), 1.0)
        yield compared(name, golden[name], now[name], FLOORS[name] * scale + SPREADS * spread[name])


# Records of the file.


def solve_case(case: Record) -> Record:
    """A beam with its answers."""
    beam, options = case["beam"], case["options"]
    if has_resolution(options):
        tolerance: float | None = None
        found = answer(beam, options)
        others = [answer(each, options) for each in rounded_numbers(beam)] if "mu" in beam else []
        note = ""
    else:
        tolerance, first = first_converged(beam, options)
        found, others, note = settled(beam, options, tolerance, first)
        case = {**case, "default": default_record(answer(beam, with_tolerance(options, DEFAULT)))}
    limit_counts = "limit" in found and not math.isnan(found["limit"][0])
    case |= {"tolerance": tolerance, "answer": found, "spread": spread_of(found, others)}
    return case | {"limit_counts": limit_counts} | ({"note": note} if note else {})


def default_record(found: Record) -> Record:
    return {name: found[name] for name in ("is", "errors") if name in found}


def first_converged(beam: Record, options: Record) -> tuple[float, Record]:
    """The smallest tolerance of COARSER to which an answer converges, and this; the largest and
    the error where it does to none."""
    for tolerance in COARSER:
        found = answer(beam, with_tolerance(options, tolerance))
        if found["is"] != "not-converged":
            break
    return tolerance, found


def settled(
    beam: Record, options: Record, tolerance: float, first: Record
) -> tuple[Record, list[Record], str]:
    """The answer that two meshes agree on, other answers that agree with it, and a note."""
    if first["is"] not in ("solution", "no-equilibrium"):
        return first, [], ""
    fine = finest(beam, options) or first
    meshes, candidates = beam, [fine]
    for _ in range(3):
        if (more := at_more_stations(meshes)) is None:
            break
        meshes = more
        other = finest(meshes, options)
        if other is None:
            break
        candidates.append(other)
        if agree(candidates[-1], candidates[-2]):
            found = candidates[-2]
            note = "" if len(candidates) == 2 else f"of {len(candidates) - 2} times more stations"
            near = [
                each for each in (first, *candidates) if each is not found and agree(each, found)
            ]
            return found, near, note
    note = "one mesh" if len(candidates) == 1 else f"{len(candidates)} meshes disagree"
    return candidates[-1] if len(candidates) > 2 else fine, [], note


def finest(beam: Record, options: Record) -> Record | None:
    """The answer to the smallest tolerance of FINER that converges, or of COARSER."""
    for tolerance in (*FINER, *COARSER):
        found = answer(beam, with_tolerance(options, tolerance))
        if found["is"] != "not-converged":
            return found
    return None


def agree(one: Record, other: Record) -> bool:
    """Whether two answers are the same, within their errors."""
    if one["is"] != other["is"]:
        return False
    if one["is"] != "solution":
        return True
    if one["s"].shape != other["s"].shape or one["status"] != other["status"]:
        return False
    allowed = RELATIVE / 2 * size(one["s"]) + one["errors"] + other["errors"]
    placed = abs(one["position"] - other["position"]).max() < 1e-4
    return bool(placed) and frequencies("s", one["s"], other["s"], allowed).ratio <= 1


def spread_of(found: Record, others: list[Record]) -> Record:
    """The greatest change of each quantity; of shapes and shares (modes,)."""
    alike = [each for each in others if each["is"] == found["is"]]
    if found["is"] != "solution":
        limits = [abs(each["limit"] - found["limit"]) for each in alike if "limit" in found]
        return {"limit": np.nan_to_num(np.max([np.zeros(1), *limits], axis=0))}
    spread: Record = {}
    for name in ("position", "stretch", "root"):
        spread[name] = max((float(abs(e[name] - found[name]).max()) for e in alike), default=0.0)
    none = np.zeros(len(found["s"]))
    spread["s"] = np.max([none, *(abs(e["s"] - found["s"]) for e in alike)], axis=0)
    for name in ("fraction", "shapes"):
        changes = [abs(e[name] - found[name]).reshape(len(none), -1).max(axis=1) for e in alike]
        spread[name] = np.max([none, *changes], axis=0)
    counts = {tuple(map(len, each["nodes"])) for each in (found, *alike)}
    if len(counts) > 1:
        found["nodes"] = None
    else:
        flat = [np.concatenate([[], *each["nodes"]]) for each in (found, *alike)]
        spread["nodes"] = max(float(abs(each - flat[0]).max(initial=0.0)) for each in flat)
    return spread


def chart_case(case: Record) -> Record:
    """A chart with its answer."""
    if has_resolution(case["options"]):
        found, tolerance = chart_answer(case, None), None
        others = [chart_answer({**case, "beam": e}, None) for e in rounded_numbers(case["beam"])]
    else:
        stations = len(case["beam"].get("blade", {"x": ()})["x"])
        many = stations > MANY_STATIONS
        tolerance, finer = SLOW_CHART_TOLERANCES if many else CHART_TOLERANCES
        found, others = chart_answer(case, finer), [chart_answer(case, tolerance)]
    return case | {
        "tolerance": tolerance,
        "answer": found,
        "spread": chart_spread(found, [each for each in others if each["is"] == found["is"]]),
    }


def chart_spread(found: Record, others: list[Record]) -> Record:
    """The greatest changes of frequencies, by branch, of events and of limits."""
    if found["is"] != "chart":
        return {}

    def changes(one: Record, twins: list[Record], names: tuple[str, ...]) -> Record:
        return {
            name: max((abs(twin[name] - one[name]) for twin in twins), default=0.0)
            for name in names
        }

    frequencies_of_branches = {
        label: max(
            (
                float(np.nan_to_num(abs(other["branches"][label]["s"] - branch["s"])).max())
                for other in others
                if label in other["branches"]
            ),
            default=0.0,
        )
        for label, branch in found["branches"].items()
    }
    events = [
        changes(event, [twin for e in others if (twin := nearest(event, e["events"]))], MEASURED)
        for event in found["events"]
    ]
    limits = []
    for k, limit in enumerate(ours := counted_limits(found)):
        theirs = [counted_limits(each) for each in others]
        limits.append(
            changes(limit, [t[k] for t in theirs if len(t) == len(ours)], ("start", "stop"))
        )
    return {"s": frequencies_of_branches, "events": events, "limits": limits}


def motion_case(case: Record) -> Record:
    """A motion with its answer."""
    found, other = (motion_answer(case, t) for t in (MOTION_TOLERANCE, MOTION_CHECK))
    spread = {}
    if found["is"] == other["is"] == "motion":
        names = ("tip", "gamma", "angle", "energy")
        spread = {name: float(abs(found[name] - other[name]).max()) for name in names}
    return case | {"tolerance": MOTION_TOLERANCE, "answer": found, "spread": spread}


# The file: arrays as lists, complex ones as pairs.

DIGITS = 12
ROUNDED = {"errors": 3, "error": 3, "s": 15, "shapes": 9, "fraction": 9, "nodes": 8}
SPREAD_DIGITS = 2
ARRAYS = (
    *("s", "errors", "fraction", "shapes", "position", "stretch", "root", "limit"),
    *("tip", "gamma", "angle", "energy"),
)


def packed(value: Any, digits: int = DIGITS) -> Any:
    """A value in the types of JSON."""
    if isinstance(value, Mapping):
        return {name: packed(each, digits_of(name, digits)) for name, each in value.items()}
    if isinstance(value, np.ndarray):
        if not np.iscomplexobj(value):
            return packed(value.tolist(), digits)
        parts = {"real": packed(value.real.tolist(), digits)}
        if value.imag.any():
            parts["imag"] = packed(value.imag.tolist(), digits)
        return parts
    if isinstance(value, list | tuple):
        return [packed(each, digits) for each in value]
    if not isinstance(value, float):
        return value
    if not math.isfinite(value):
        return repr(value)
    rounded = float(f"{value:.{digits}g}")
    return int(rounded) if rounded.is_integer() and abs(rounded) < 1e6 else rounded


def digits_of(name: str, digits: int) -> int:
    """The digits of a quantity in a record; fewer in all of a spread."""
    if SPREAD_DIGITS in (digits, ROUNDED.get(name)) or name == "spread":
        return SPREAD_DIGITS
    return ROUNDED.get(name, digits)


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


def read(file: Path) -> Record:
    with gzip.open(file, "rt", encoding="utf-8") as text:
        return dict(json.load(text))


def write(file: Path, wanted: "Selection") -> None:
    """Compute the cases, and write them."""
    began, cases = time.perf_counter(), []
    for all_cases, complete in ((solves, solve_case), (charts, chart_case), (motions, motion_case)):
        for case in all_cases():
            if wanted.takes(case):
                started = time.perf_counter()
                cases.append(complete_case(case, complete))
                report(cases[-1], time.perf_counter() - started)
    text = json.dumps({"made": "scripts/golden.py write", "cases": cases}, separators=(",", ":"))
    with file.open("wb") as target, gzip.GzipFile("", "wb", fileobj=target, mtime=0) as stream:
        stream.write(text.encode())
    print(f"{len(cases)} cases, {file.stat().st_size} bytes, {time.perf_counter() - began:.0f} s")


def complete_case(case: Record, complete: Callable[[Record], Record]) -> Record:
    """A case with its answers in the types of JSON, and the quantities that this code does not meet
    itself."""
    done: Record = json.loads(json.dumps(packed(complete(json.loads(json.dumps(case))))))
    missed = [row for row in rows_of(case_of(done)) if not row.ratio <= 1]
    return done | ({"known": {row.quantity: text(row.now) for row in missed}} if missed else {})


def report(case: Record, seconds: float) -> None:
    """What to know about a case, on stderr."""
    if seconds > LONG or "known" in case or "note" in case:
        told = {name: case[name] for name in ("known", "note") if name in case}
        print(f"{case['name']}: {seconds:.1f} s {told or ''}", file=sys.stderr, flush=True)


def rows_of(case: Record) -> Iterator[Row]:
    """The quantities of a case, computed anew, beside those of the file."""
    beam, options = case["beam"], case["options"]
    if case["kind"] == "charts":
        yield from chart_rows(case, chart_answer(case, case["tolerance"]))
    elif case["kind"] == "motions":
        yield from motion_rows(case, motion_answer(case, case["tolerance"]))
    else:
        yield from solve_rows(case, answer(beam, with_tolerance(options, case["tolerance"])))
        if "default" in case:
            yield from default_rows(case, answer(beam, with_tolerance(options, DEFAULT)))


class Selection(NamedTuple):
    """The cases that are wanted."""

    kind: str | None = None
    name: str = ""
    without: str | None = None
    quick: bool = False

    def takes(self, case: Mapping[str, Any]) -> bool:
        return (
            self.kind in (None, case["kind"])
            and self.name in case["name"]
            and (self.without is None or self.without not in case["name"])
            and (case["quick"] or not self.quick)
        )


def compare(file: Path, wanted: Selection, strict: bool) -> int:
    """Solve again, print what differs, and return 1 if anything does."""
    began, worst = time.perf_counter(), dict[str, float]()
    beyond, known = list[tuple[Record, Row]](), 0
    cases = [record for record in read(file)["cases"] if wanted.takes(record)]
    for record in cases:
        for row in rows_of(case_of(record)):
            if not row.ratio <= 1 and row.quantity in record.get("known", ()) and not strict:
                known += 1
                continue
            kind = f"{record['kind']}, {row.quantity.split(' ')[0]}"
            worst[kind] = max(worst.get(kind, 0.0), row.ratio)
            if not row.ratio <= 1:
                beyond.append((record, row))
    print_table(beyond, worst)
    differing = len({record["name"] for record, _ in beyond})
    print(
        f"{len(cases)} cases, {time.perf_counter() - began:.0f} s: {len(beyond)} differences in"
        f" {differing} cases; {known} that the code of the file had, too"
    )
    return int(bool(beyond))


def print_table(beyond: list[tuple[Record, Row]], worst: Mapping[str, float]) -> None:
    """The differences beyond what is allowed, the calls that have them, and the greatest of all."""
    if beyond:
        print(f"{'case':24} {'quantity':26} {'golden':>26} {'now':>26} {'over allowed':>14}")
    for record, row in beyond[:REPORTED]:
        texts = (f"{text(value):>26}" for value in (row.golden, row.now))
        print(f"{record['name']:24} {row.quantity:26}", *texts, f"{row.ratio:14.3g}")
    if len(beyond) > REPORTED:
        print(f"... and {len(beyond) - REPORTED} more")
    for record in list({record["name"]: record for record, _ in beyond}.values())[:10]:
        print(f"{record['name']}: {call_of(record)}")
    greatest = sorted(worst.items(), key=lambda pair: -pair[1])[:8]
    print("greatest over allowed:", ", ".join(f"{kind} {ratio:.2g}" for kind, ratio in greatest))


def text(value: Any) -> str:
    return f"{value:.12g}" if isinstance(value, float | complex) else str(value)


def main() -> int:
    parser = _script.Parser(__doc__)
    parser.add_argument("action", choices=("write", "compare"))
    parser.add_argument("file", type=Path, metavar="FILE.json.gz")
    parser.add_argument("--only", type=_script.one_of(KINDS), metavar="KIND", help=", ".join(KINDS))
    parser.add_argument("--name", default="", metavar="TEXT", help="cases whose name contains it")
    parser.add_argument("--without", metavar="TEXT", help="no cases whose name contains it")
    parser.add_argument("--quick", action="store_true", help="a part, in 20 s")
    parser.add_argument("--strict", action="store_true", help="also what differed from the start")
    given = parser.parse_args()
    wanted = Selection(given.only, given.name, given.without, given.quick)
    if given.action == "write":
        write(given.file, wanted)
        return 0
    return compare(given.file, wanted, given.strict)


if __name__ == "__main__":
    sys.exit(main())
