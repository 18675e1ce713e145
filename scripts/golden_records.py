"""Cases of the golden file with their answers, which a second mesh or tolerance confirms."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from golden_answers import (
    DEFAULT,
    MEASURED,
    Record,
    answer,
    chart_answer,
    has_resolution,
    motion_answer,
    with_tolerance,
)
from golden_differences import RELATIVE, counted_limits, frequencies, nearest, size

from beamviz import Blade

REFERENCE = 1e-10  # tolerance
COARSER = (REFERENCE, 1e-9, 1e-8, 1e-7, DEFAULT)  # the first that converges is compared
FINER = (1e-12, 1e-11)
LAST_DIGITS = (4e-16, -8e-16)  # relative changes of the numbers: what rounding does
NO_EFFECT = 1e-8  # of a spin-up
CHART_TOLERANCES = (1e-8, 1e-9)  # compared, stored
SLOW_CHART_TOLERANCES, MANY_STATIONS = (1e-6, 1e-7), 20  # of blades
MOTION_TOLERANCE, MOTION_CHECK = 1e-6, 1e-5


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
        settle = settled if abs(beam.get("spin_up", 1)) > NO_EFFECT else settled_straight
        found, others, note = settle(beam, options, first)
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


def settled(beam: Record, options: Record, first: Record) -> tuple[Record, list[Record], str]:
    """The answer that two meshes agree on, other answers that agree with it, and a note."""
    if first["is"] == "invalid-input":
        return first, [], ""
    fine = finest(beam, options) or first
    meshes, candidates = beam, [fine]
    for _ in range(4):
        if (more := at_more_stations(meshes)) is None:
            break
        meshes = more
        other = finest(meshes, options)
        if other is None:
            continue
        candidates.append(other)
        if agree(candidates[-1], candidates[-2]):
            found = candidates[-2]
            note = "" if len(candidates) == 2 else "confirmed at more stations only"
            near = [
                each for each in (first, *candidates) if each is not found and agree(each, found)
            ]
            return found, near, note
    note = "one mesh" if len(candidates) == 1 else f"{len(candidates)} meshes disagree"
    return candidates[-1] if len(candidates) > 2 else fine, [], note


def settled_straight(
    beam: Record, options: Record, first: Record
) -> tuple[Record, list[Record], str]:
    """`settled` for a beam with a spin-up of no effect: from its straight state, which another part
    of the solver computes."""
    still = {name: value for name, value in beam.items() if name != "spin_up"}
    model = {name: value for name, value in options.items() if name != "state"}
    found, others, note = settled(still, model, answer(still, with_tolerance(model, DEFAULT)))
    return {**found, "state": "bent"}, others, note


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
