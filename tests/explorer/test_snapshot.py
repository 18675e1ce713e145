"""Page and scene are functions of the state: after hundreds of edits in any order they equal those
of a page that is opened fresh on the resulting address."""

import itertools
import random
import re
from collections.abc import Iterator
from typing import Any
from urllib.parse import parse_qsl

import numpy as np
import pytest
from helpers import slow
from live.server import wait_until
from live.visitor import Visitor, catch_up, visitor

from beamviz.beam import NUMBERS
from beamviz.explorer import explorer
from beamviz.explorer.feature import tabs
from beamviz.explorer.features import loci_chart
from beamviz.explorer.features import map as map_tab
from beamviz.explorer.features.real_beam import PRESETS
from beamviz.explorer.session import Session
from beamviz.explorer.state import COMPARISONS
from beamviz.lessons import NAMES
from beamviz.presets import PRESETS as BLADES
from beamviz.scene import START

LINKS = (
    "?gamma=3",
    "?lesson=veering&gamma=4.5",
    "?alpha=2&beta=0.3&delta=-1&gamma=6&mode=2",
    "?compare=mass&stacked=true&gamma=8&alpha=1",
    "?gamma=5&before={gamma=9.0,alpha=2.0}&compare=earlier&alpha=1",
    "?length=0.5&density=7850&area=1e-4&second_moment=1e-10&youngs_modulus=2.1e11&tab=veering",
    "?mode=8&gamma=2",
    "?lesson=nowhere",
    "?alpha=-1&beta=0.25",
)
# Parts of the page that only one tab shows, by the beginnings of their ids.
INSIDE = {
    "loci-": "frequencies",
    "per-rev": "frequencies",
    "map-": "map",
    "veering-": "veering",
    "comparison": "compare",
    "loads-": "loads",
    "run-up-": "run-up",
    "motion-": "motion",
    "motion.": "motion",
    "moment": "motion",
    "experiment": "motion",
    "method": "methods",
    "timing": "methods",
    "export-": "export",
}


def edit(chance: random.Random) -> tuple[str, Any]:
    """An action of the page and its value: sensible, odd or impossible."""
    number = chance.choice(list(NUMBERS))
    low, high, _ = NUMBERS[number].slider
    kind = chance.randrange(20)
    if kind < 6:
        return number, round(chance.uniform(low, high), 3)
    actions: list[tuple[str, Any]] = [
        (number, chance.choice((1e9, -3.0, "fast", 0.0, 1.0))),
        ("gamma", chance.choice((0.0, 4.46, 60.0, 150.0))),
        ("delta", -1.0),
        ("plane", chance.choice(("chordwise", "flapwise"))),
        ("method", chance.choice(("auto", "auto", "ancf", "zoac", "rubber"))),
        ("strain", chance.choice(("green", "hencky", "biot"))),
        ("state", chance.choice(("straight", "stable"))),
        (chance.choice(("coriolis", "softening", "stiffening", "mass")), chance.random() < 0.7),
        ("only", chance.randrange(6)),
        (f"share-{chance.randrange(5)}", chance.random()),
        ("amplitude", chance.uniform(0, 0.5)),
        ("pace", chance.choice((0.0, 0.5, 2.0))),
        (chance.choice(("rotating_frame", "ghosts", "nodes", "thicken")), chance.random() < 0.5),
        ("all_modes", chance.random() < 0.3),
        ("colouring", chance.choice(("displacement", "axial strain"))),
        ("comparison", chance.choice(COMPARISONS)),
        ("stacked", chance.random() < 0.5),
        ("keep", None),
        (chance.choice(("over", "across")), chance.choice(("alpha", "beta", "gamma", "delta"))),
        ("mapped", chance.choice(("gap", "1", "3"))),
        (f"per_rev_{chance.randrange(1, 7)}", chance.random() < 0.5),
        ("lesson", chance.choice(("", "", *NAMES))),
        ("lesson_turn", chance.choice((1, -1))),
        ("lesson_guess", chance.randrange(3)),
        ("rate", chance.choice((0.2, None, "never"))),
        ("go_to_event", chance.choice(("B3 S1 1", "B2 S1 1", "2 B1 1"))),
        ("move_beam", f"{chance.uniform(0, 15):.3g} {chance.uniform(0, 1):.3g}"),
        ("real.preset", chance.choice(list(PRESETS))),
        (chance.choice(("real.length", "real.thickness", "real.width")), chance.uniform(0, 900)),
        ("real.section", chance.choice(("rectangle", "tube", "own"))),
        ("dimensionless", None),
        ("blade.preset", chance.choice(list(BLADES))),
        (f"blade.{chance.choice(('stations', 'masses'))}.remove", chance.randrange(4)),
        (chance.choice(("blade.stations.add", "blade.masses.add", "blade.begin")), None),
        ("blade.root", chance.choice(("clamped", "hinged", "spring", "glued"))),
        ("blade.paste", chance.choice(("0 9 1e3 1e6\n1 8 9e2 1e6", "0,1\n1,x", "words"))),
        ("blade.uniform", None),
        ("damping", chance.uniform(0, 30)),
        ("link", chance.choice(LINKS)),
        *([(chance.choice(("undo", "redo")), None)] * 4),
        ("reset", None),
        ("tab", chance.choice(list(tabs()))),
    ]
    return chance.choice(actions)


def newest(loop: Any) -> Session:
    """The session of the last visitor."""
    return loop.sessions[max(loop.sessions)]


def settled(guest: Visitor, loop: Any, session: Session) -> None:
    """Wait until the page of a visitor shows the answers to all that it has sent."""

    def shown() -> tuple[Any, ...] | None:
        """The state and the answers of the last frame, whose contents may be on their way and whose
        requests may come yet; None while something is computed, or other answers are known."""
        waits = session.is_busy or session.is_moving or loop.woken or loop.later
        answers = {key: job.answer for key, job in session.visitor.jobs.items()}
        seen = {key: status.answer for key, status in session.snapshot.jobs.items()}
        return None if waits or answers != seen else (session.visitor.state, answers)

    catch_up(guest)
    before = None
    while before is None or shown() != before:  # a frame drawn meanwhile may have asked for more
        before = wait_until(shown, 300.0)
        catch_up(guest)


def is_shown(id: str, tab: str) -> bool:
    """Whether an element is outside of the tabs, or in the open one."""
    return next((one == tab for start, one in INSIDE.items() if id.startswith(start)), True)


def page_of(guest: Visitor) -> dict[str, Any]:
    """What a visitor sees of the page: of parts that are on it, in the open tab or outside."""
    tab = guest.parts["open"]
    shown = [text for key, text in guest.texts.items() if is_shown(key, tab)]
    there = {*re.findall(r'(?:id|data-set)="([^"]+)"', "".join([*shown, tabs()[tab].content]))}
    props = {
        f"{key}.{name}": one
        for key, changes in guest.props.items()
        for name, one in changes.items()
        if key in there and key not in ("undo", "redo")
    }
    parts: dict[str, dict[str, Any]] = {
        "text": {key: re.sub(r"[\d.]+ ms,", "", text) for key, text in guest.texts.items()},
        "value": {key: one for key, one in guest.values.items() if key != "following"},
        "chart": {
            key: one for key, one in guest.charts.items() if not guest.props[key].get("hidden")
        },
        "props": props,
    }
    seen = {
        f"{kind} {key}": one
        for kind, content in parts.items()
        for key, one in content.items()
        if is_shown(key, tab) and (kind == "props" or key in there)
    }
    address = {key: numbers(one) for key, one in parse_qsl(guest.parts.get("address", ""))}
    return seen | {"address": address, **{key: guest.parts[key] for key in PARTS}}


PARTS = ("open", "captions", "met")


def numbers(text: str) -> float | str:
    """A number, with what rounding leaves of it in SI units and back, or another text."""
    try:
        return float(text)
    except ValueError:
        return text


def scene_of(guest: Visitor) -> dict[str, Any]:
    """The visible nodes of the scene with their properties and places; of the points of captions
    those that have a text."""
    texts = {caption["name"] for caption in guest.parts["captions"]}
    hidden = {name for name, node in guest.nodes.items() if node.get("visible") is False}
    nodes = {}
    for name, node in guest.nodes.items():
        parents = [name[:k] for k, sign in enumerate(name) if sign == "/" and k] + [name]
        is_caption = re.search(r"/(node \d+|body \d+|warning|title|speed)$", name)
        if not hidden & {*parents} and (name in texts or not is_caption):
            at_origin = {"position": (0.0, 0.0, 0.0), "wxyz": (1.0, 0.0, 0.0, 0.0)}
            nodes[name] = at_origin | {key: one for key, one in node.items() if key != "visible"}
    return nodes


def is_records(content: Any) -> bool:
    """Whether it is a list of objects."""
    return isinstance(content, list) and all(isinstance(one, dict) for one in content)


def differences(first: Any, second: Any, path: str = "") -> Iterator[str]:
    """Where two contents differ, numbers by more than rounding."""
    if isinstance(first, dict) and isinstance(second, dict):
        for key in first.keys() | second.keys():
            yield from differences(first.get(key), second.get(key), f"{path}/{key}")
    elif is_records(first) and is_records(second) and len(first) == len(second):
        for k, pair in enumerate(zip(first, second, strict=True)):
            yield from differences(*pair, f"{path}/{k}")
    elif isinstance(first, float | list | tuple) and isinstance(second, float | int | list | tuple):
        try:
            close = np.allclose(
                np.array(first, float), np.array(second, float), 1e-5, 1e-6, equal_nan=True
            )
        except (ValueError, TypeError):  # not numbers, or not as many
            close = list(first) == list(second)
        if not close:
            yield f"{path}: {str(first)[:200]} != {str(second)[:200]}"
    elif isinstance(first, str) and isinstance(second, str):
        texts, others = (re.split(NUMBER, re.sub(ERROR, "", one)) for one in (first, second))
        if len(texts) != len(others) or texts[::2] != others[::2]:
            yield f"{path}: {changed_part(first, second)}"
        else:
            pairs = zip(texts[1::2], others[1::2], strict=True)
            if any(abs(float(a) - float(b)) > 1.01 * last_digit(a) for a, b in pairs):
                yield f"{path}: {changed_part(first, second)}"
    elif first != second:
        yield f"{path}: {str(first)[:300]} != {str(second)[:300]}"


NUMBER = r"(\d+\.?\d*(?:e[-+]?\d+)?)"
ERROR = r"± [\d.e-]+"  # estimated, of the size of rounding


def last_digit(text: str) -> float:
    """One unit of the last digit of a number, at most the sixth: what rounding changes of a tie."""
    mantissa, _, exponent = text.partition("e")
    unit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    return max(unit, 1e-6 * abs(float(text)))


def changed_part(first: str, second: str) -> str:
    """Two texts from a little before the first character that differs."""
    same = itertools.takewhile(lambda pair: pair[0] == pair[1], zip(first, second, strict=False))
    start = max(len([*same]) - 60, 0)
    return f"…{first[start : start + 300]} != …{second[start : start + 300]}"


@pytest.fixture(scope="module")
def start(frame_loops) -> Iterator[str]:
    """An explorer whose clocks never run, with coarse charts and maps: what is compared is whether
    they are those of the state, not what they show."""
    with pytest.MonkeyPatch.context() as patch, explorer(START.changed(playing=False)) as url:
        patch.setattr(loci_chart, "CHART_POINTS", 15)
        patch.setattr(map_tab, "SIZE", (9, 5))
        patch.setattr(map_tab, "SMALL_SIZE", (5, 3))
        yield url


@pytest.mark.parametrize("seed", [5, *slow(1, 2, 4, 6)])
def test_a_page_equals_a_fresh_one_on_its_address(start, frame_loops, seed):
    """Four times, each after 25 edits without a pause, with reduced motion: no clock runs."""
    chance = random.Random(seed)
    with visitor(start) as guest:
        guest.do("preferences", "still")
        guest.do("link", "")
        loop, session = frame_loops[-1], newest(frame_loops[-1])
        for _ in range(4):
            done = [edit(chance) for _ in range(25)]
            done += [("real.length", chance.uniform(200, 900)), ("tab", chance.choice(TABS))]
            done += [(name, one) for name, one in VALID.items() if chance.random() < 0.4]
            for action, value in done:
                guest.do(action, value)
            settled(guest, loop, session)
            compare_with_fresh(start, guest, loop, done)


TABS = ("frequencies", "veering", "compare", "lessons", "export", "map")
VALID = {"alpha": 1.0, "beta": 0.5, "gamma": 5.0, "delta": 0.25, "mu": 70.0, "spin_up": 0.0}


def compare_with_fresh(url: str, guest: Visitor, loop: Any, done: Any) -> None:
    """Compare a page with a fresh one, which has the same memory of lessons."""
    address = guest.parts.get("address", "")
    with visitor(url) as fresh:
        fresh.do("preferences", "still")
        fresh.do("met", " ".join(guest.parts["met"]))
        fresh.do("link", f"?{address}")
        settled(fresh, loop, newest(loop))
        found = [*differences(page_of(guest), page_of(fresh), "page")]
        found += differences(scene_of(guest), scene_of(fresh), "scene")
        assert found == [], "\n".join([address, *map(str, done), *found])
