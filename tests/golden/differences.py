"""Differences between an answer of the golden file and that of the program now, each over what is
allowed."""

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from golden.answers import (
    DEFAULT,
    MEASURED,
    Record,
    answer,
    chart_answer,
    motion_answer,
    with_tolerance,
)

RELATIVE = 1e-9  # of frequencies
SLOW = 0.01  # [1/T*] frequency below which an error is relative to this one
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
CLOSE = 1e-7  # relative distance of two frequencies below which their order is chance
THRESHOLDS = (0.1, 0.5, 0.9)  # of the bending fraction, where a label or a family changes
LEAST_INDEX, BORDERLINE = 0.5, 0.02  # of the veering index, and about it where it is chance
# The kinds of events and limits that are compared: others may be added.
EVENTS = (
    *("crossing", "veering", "coalescence", "resonance"),
    *("buckling", "limit point", "second state"),
)
LIMITS = ("no-equilibrium", "unstable", "growing")


class Row(NamedTuple):
    """A quantity of a case that was compared. ratio: the difference over what is allowed."""

    quantity: str
    golden: Any
    now: Any
    ratio: float


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
        most = WIDER_BARS * golden["errors"] + widest_bars(s, tolerance)
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


def widest_bars(s: NDArray, tolerance: float) -> NDArray:
    """The errors (modes,) that a tolerance allows: of a slow mode an error of s^2."""
    square = 2 * tolerance * size(s) ** 2
    root = abs(s) + np.sqrt(np.maximum(abs(s) ** 2 - square, 0.0))
    return np.where(abs(s) ** 2 > square, square / np.maximum(root, 1e-300), np.sqrt(square))


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
    most = WIDER_BARS * golden["errors"] + widest_bars(s, DEFAULT)
    most = np.maximum(most, 2 * default["errors"])
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
        errors = (golden["error"], now["error"], case["tolerance"])
        yield bars("error", *(np.array([value]) for value in errors))
    apart = np.linalg.norm(now["tip"] - golden["tip"], axis=1)
    k = int(np.argmax(apart))
    yield Row("tip", golden["tip"][k].tolist(), now["tip"][k].tolist(), float(apart[k] / allowed))
    for name in ("gamma", "angle", "energy"):
        scale = max(float(abs(golden[name]).max()), 1.0)
        yield compared(name, golden[name], now[name], FLOORS[name] * scale + SPREADS * spread[name])
