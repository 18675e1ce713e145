"""Links: the address of the page has the scene and the other choices of the visitor.

A page opens with the scene of its address, and the address is updated with the scene. Examples:
?lesson=nodes, ?alpha=1&gamma=10&mode=3, or both, with the keys of other choices.
"""

import math
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from functools import cache, lru_cache
from typing import Any, NamedTuple
from urllib.parse import parse_qsl, urlencode

from beamviz.beam import NUMBERS
from beamviz.checks import check_float, check_int
from beamviz.errors import InvalidInput, unknown_keyword
from beamviz.explorer import page
from beamviz.explorer.camera import DEFAULT
from beamviz.explorer.declarations import Choice
from beamviz.explorer.feature import Feature, first_tab, tabs, usual_state
from beamviz.explorer.features import FEATURES
from beamviz.explorer.features.lesson_player import OwnLessonState, begun_lesson, with_replaced
from beamviz.explorer.features.lessons import Lessons, LessonState, begun, check_guess, outside
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.solutions import within_limits
from beamviz.explorer.state import CHOICES, LASTING, SHARED, TERMS, Case, History, State
from beamviz.explorer.visitor import LinkFormat, Visitor
from beamviz.input_files import check_keys, errors_of_file
from beamviz.lessons import lesson
from beamviz.lessons.lesson_file import LESSON_KEY, STEP_KEY, OwnLesson, unpacked
from beamviz.scene import KEYS as SCENE_KEYS
from beamviz.scene import (
    MAX_LINK,
    Scene,
    check_bool,
    check_choice,
    inline_toml,
    parse_query,
)
from beamviz.server.access import KEY_PARAMETER
from beamviz.si import SI_KEYS, SI_SYNONYMS, SIZE_KEYS, wrong_values

# Parameters with another reader: the key of the server, and the options of viser's page.
RESERVED = {KEY_PARAMETER, "websocket", "fixedDpr", "darkMode", "showStats", "logCamera"}
ROUNDING = 1e-12  # relative: of a number that was in SI units meanwhile
LONGEST_LINK = MAX_LINK + 1000  # [characters] as a page sends it, with the keys of other readers

SIZE = "the size"  # part of a link: the keys that make one beam in SI units
LINES, LINE = 6, 130  # of the message on a link: lines at most, characters of one
# Keys of a link: what of the case is out of range, or not taken by its method; what the case kept
# for comparison has otherwise.
ENTERED, BEFORE = "entered", "before"


def check_before(values: Any, key: str = BEFORE) -> dict[str, Any]:
    """What the case kept for comparison has otherwise. Raises InvalidInput, which names the key of
    the link."""
    values = values if isinstance(values, dict) else {"": values}
    check_keys(values, (*NUMBERS, *CHOICES, *TERMS), key)
    for name, value in values.items():
        if name in NUMBERS:
            check_float(name, value)
        elif name in TERMS:
            check_bool(name, value)
        else:
            check_choice(name, value, CHOICES[name])
    return values


def check_entered(values: Any) -> dict[str, Any]:
    """Numbers as entered, and options of the model. Raises InvalidInput."""
    values = values if isinstance(values, dict) else {"": values}
    numbers = {name: one for name, one in values.items() if name in NUMBERS}
    if any(isinstance(one, dict | list) for one in numbers.values()):
        raise InvalidInput(f"{ENTERED} = {numbers!r}: must be numbers")
    others = {name: one for name, one in values.items() if name not in NUMBERS}
    return numbers | check_before(others, ENTERED)


# Keys of a link for what one case has otherwise than another, and their checks.
DIFFERENCES = {BEFORE: check_before, ENTERED: check_entered}


def linked_choices() -> dict[str, Choice[Any]]:
    """The choices that links know, by their keys."""
    declared = (*SHARED.values(), *(choice for kind in PAGE for choice in kind.choices()))
    return {choice.key.name: choice for choice in declared if choice.key}


class Link(NamedTuple):
    """What a link describes: a scene, None where none of its values is valid; other choices by
    name, and DIFFERENCES of cases by key; the errors of the values that are left out."""

    scene: Scene | None
    values: dict[str, Any]
    refused: tuple[InvalidInput, ...] = ()


def parse_link(query: str) -> Link | None:
    """The link of a query, without the values that are not valid; None for no keys. Raises
    InvalidInput for more keys than a link has."""
    keys = {key: value for key, value in parse_query(query).items() if key not in RESERVED}
    if not keys:
        return None
    with suppress(InvalidInput):
        return described(keys)
    found, valid, tried = Link(None, {}), dict[str, Any](), None
    refused = dict[str, InvalidInput]()
    left = parts_of(keys)
    while left != tried:  # a value may be valid only after one that comes later
        tried, refused = left, {}
        for name, part in tried.items():
            try:
                found, valid = described(merged(valid, part)), merged(valid, part)
            except InvalidInput as error:
                refused[name] = error
        left = {name: tried[name] for name in refused}
    return found._replace(refused=tuple(mistakes(refused, keys)))


def parts_of(keys: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """The keys of a link, each alone, and so those in a table; but together those that make one
    beam in SI units."""
    parts: dict[str, dict[str, Any]] = {}
    tables = table_keys()
    for key, value in keys.items():
        if key in tables and isinstance(value, dict):
            parts |= {f"{key}.{name}": {key: {name: entry}} for name, entry in value.items()}
        else:
            parts.setdefault(SIZE if key in SIZE_KEYS else key, {})[key] = value
    return parts


def merged(keys: dict[str, Any], part: dict[str, Any]) -> dict[str, Any]:
    """The keys of a link with a part more."""
    both = keys.keys() & part.keys() & table_keys()
    return keys | part | {key: keys[key] | part[key] for key in both}


def table_keys() -> set[str]:
    """The keys of tables, whose entries are valid or not each alone."""
    tables = {key for key, choice in linked_choices().items() if choice.key and choice.key.is_table}
    return tables | DIFFERENCES.keys()


def mistakes(refused: dict[str, InvalidInput], keys: dict[str, Any]) -> Iterable[InvalidInput]:
    """The errors of the refused parts of a link; without a size of the beam, those of all its
    values in SI units, as none of them has a meaning alone."""
    if "position" in refused and "look_at" in refused:  # of which that is no mistake of its own
        with suppress(InvalidInput):
            described({"position": list(DEFAULT.position), "look_at": keys["look_at"]})
            refused = {name: error for name, error in refused.items() if name != "look_at"}
    if SIZE not in refused:
        return refused.values()
    si = {key: keys[key] for key in SI_KEYS if key in keys}
    others = [error for name, error in refused.items() if name not in {SIZE, *si}]
    found = {str(error): error for error in (refused[SIZE], *wrong_values(si))}
    return [*found.values(), *others]


def listed(errors: Iterable[InvalidInput]) -> str:
    """Errors on a line each, long ones without their middle; of many the first ones."""
    lines = [str(error).replace("\n", " ") for error in errors]
    half = LINE // 2
    lines = [one if len(one) <= LINE else f"{one[:half]} … {one[-half:]}" for one in lines]
    if len(lines) > LINES:
        lines[LINES - 1 :] = [f"and {len(lines) - LINES + 1} more"]
    return "\n".join(lines)


def described(keys: dict[str, Any]) -> Link:
    """The link of these keys and values; one of no more than a step of an own lesson has the scene
    and the choices of that. Raises InvalidInput."""
    if keys.keys() == {LESSON_KEY, STEP_KEY}:
        steps = unpacked(keys[LESSON_KEY]).steps
        first = check_int(STEP_KEY, keys[STEP_KEY], 1, len(steps)) - 1
        keys = parse_query(steps[first].link) | keys
    choices = linked_choices()
    others = (*choices, *DIFFERENCES)
    names = (*SCENE_KEYS, *SI_KEYS, *others)
    for key in keys:
        if key not in names:
            raise unknown_keyword("key", key, names, SI_SYNONYMS)
    values: dict[str, Any] = {}
    for key, choice in choices.items():
        if choice.key and key in keys:
            values[choice.name] = choice.key.read(keys[key])
    if "tab" in values:
        check_choice("tab", values["tab"], tuple(tabs(PAGE)))
    if "guess" in values:
        check_guess(values["guess"], values.get("lesson", ""))
    check_own_lesson(values)
    values |= {key: check(keys[key]) for key, check in DIFFERENCES.items() if key in keys}
    base = lesson(values["lesson"]).scene if "lesson" in values else Scene()
    scene = Scene.from_query({key: keys[key] for key in keys if key not in others}, base)
    return Link(within_limits(scene), values)


def check_own_lesson(values: dict[str, Any]) -> None:
    """Check the scenes of an own lesson, and which step is open, by the choices of a link. Raises
    InvalidInput."""
    lesson = values.get("own_lesson", OwnLesson())
    steps = lesson.steps
    if wrong := wrong_scene(lesson):
        raise InvalidInput(wrong)
    if (shown := values.get("own_step")) is None:
        return
    if not steps or values.get("lesson"):
        lack = "there is another lesson" if steps else f"there is no {LESSON_KEY}"
        raise InvalidInput(f"{STEP_KEY} = {shown + 1}: {lack}")
    check_int(STEP_KEY, shown + 1, 1, len(steps))


@lru_cache(16)
def wrong_scene(lesson: OwnLesson) -> str:
    """The error of the first scene of a lesson that is not valid; "" where all are."""
    try:
        for k, step in enumerate(lesson.steps, 1):
            with errors_of_file(f"{LESSON_KEY}, step {k}"):
                described(parse_query(step.link))
    except InvalidInput as error:
        return str(error)
    return ""


def usual(state: State, scene: Scene, name: str) -> State:
    """The state that a link describes by a scene alone, or by that and the name of a lesson: the
    choices that it does not name are the usual ones."""
    before = outside(state)
    state = state.under(state, lambda choice: "ends" if choice.key else "changes")
    state = replace(state, over=State.over, kept=None, tab=first_tab(PAGE))
    if name:
        begins = begun(state, lesson(name), scene)
        return begins.with_values(LessonState, before_lesson=before)
    return state.loaded(scene).with_values(LessonState, before_lesson=None).at_home(scene)


def linked(state: State, scene: Scene, values: dict[str, Any]) -> State:
    """The state that a link describes by its scene, other choices and differences of cases."""
    name, before = values.get("lesson", ""), state
    if not name:
        scene = scene.changed(**{name: getattr(state.view, name) for name in LASTING})
    state = usual(state, scene, name)
    for choice in linked_choices().values():
        if choice.name in values:
            state = state.with_choice(choice, values[choice.name])
    for kind in PAGE:
        state = kind.linked(state, values)
    if not name:
        state = state.at_home(scene)
    state = with_replaced(state.with_values(OwnLessonState, followed=None), before)
    state = replace(state, case=changed_case(state.case, values.get(ENTERED, {})))
    if BEFORE in values:
        state = replace(state, kept=changed_case(state.case, values[BEFORE]))
    if values.get("own_step") is None:
        return state
    home = read_scene(before, values["own_lesson"].steps[values["own_step"]].link)
    state = replace(state, opened=home.opened, opened_slices=home.opened_slices)
    return state.with_values(LessonState, before_lesson=outside(before))


def opened_lesson(state: State, lesson: OwnLesson, name: str) -> State:
    """The state in which a page opens on a lesson from a file of this name. Raises InvalidInput."""
    return begun_lesson(state, lesson, name, read_scene)


def read_scene(state: State, query: str) -> State:
    """The state that the query of a link describes. Raises InvalidInput for any value that is not
    valid."""
    link = parse_link(query)
    if link is None:
        raise InvalidInput(f"link = {query!r}: has no scene; copy the address of a page")
    if link.refused or link.scene is None:
        raise InvalidInput(listed(link.refused))
    return linked(state, link.scene, link.values)


def changed_case(case: Case, values: dict[str, Any]) -> Case:
    """A case with other values of some numbers and options."""
    for key, value in values.items():
        case = case.changed(key, value)
    return case


class Links(Feature):
    """The address of one visitor's page."""

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        visitor.links = LinkFormat(scene_query, read_scene)
        visitor.page.on("link", self.open, str, max_text=LONGEST_LINK)

    def open(self, query: Any) -> None:
        """Show the scene of the address, which the page sends when it starts, when there is nothing
        to undo, and when the visitor goes back or forward."""
        visitor, text = self.visitor, query.lstrip("?") if isinstance(query, str) else ""
        reserved = tuple(pair for pair in parse_qsl(text) if pair[0] in RESERVED)
        with visitor.lock:
            with visitor.reporting("The link is not valid"):
                link = parse_link(text)
                if link is None and visitor.state.reserved is not None:
                    link = Link(visitor.first.opened, {})
                if link and (scene := link.scene):
                    visitor.change(lambda state: linked(state, scene, link.values), loads=True)
                if link:
                    self.report(link)
            if visitor.state.reserved is None:
                visitor.history = History()
            visitor.update(lambda state: replace(state, reserved=reserved))

    def report(self, link: Link) -> None:
        """Say which values of a link were left out, and why."""
        if link.refused:
            title = "Opened without a part of the link" if link.scene else "The link is not valid"
            self.page.say(f"{title}:\n{listed(link.refused)}", error=True)

    def content(self, snapshot: Snapshot) -> Content:
        """The address, and the scene, which is hidden until it is that of the address for the first
        time."""
        state = snapshot.state
        is_shown = state.reserved is not None and snapshot.settled
        return self.address(state) | (page.props("scene", data_ready="") if is_shown else {})

    def address(self, state: State) -> Content:
        """The address of the state, unless the page has not sent its own; none, with the reason,
        for a beam that is too long for one."""
        if state.reserved is None:
            return page.props("copy-link", disabled=False, title=None)
        query = reason = ""
        try:
            query = query_of(state, self.visitor.first)
        except InvalidInput as error:
            reason = str(error)
        found = {("address",): "&".join(filter(None, (urlencode(state.reserved), query)))}
        return found | page.props("copy-link", disabled=bool(reason), title=reason or None)


def query_of(state: State, first: State) -> str:
    """The query of a link to a state; "" for that of a page that opens without a query, `first`, or
    of a presenter."""
    scene = replace(state, case=state.case.nearest).to_scene()
    own = {name: getattr(state.view, name) for name in LASTING}
    first = replace(first, view=replace(first.view, **own))
    pairs = extra_pairs(state)
    if state.following or (scene == first.to_scene() and pairs == extra_pairs(first)):
        return ""
    return joined_query(state, scene, pairs)


def scene_query(state: State) -> str:
    """The query of a link to the scene of a state, with the choices about it, outside of lessons.
    Raises InvalidInput where it is too long."""
    state = state.with_slice(LessonState()).with_slice(OwnLessonState())
    is_shown = state.tab != Lessons.tab.key
    state = state if is_shown else replace(state, tab=first_tab(PAGE))
    scene = replace(state, case=state.case.nearest).to_scene()
    return joined_query(state, scene, extra_pairs(state))


def joined_query(state: State, scene: Scene, pairs: dict[str, Any]) -> str:
    """The query of a link to a state by its scene, and the keys and values of all else."""
    name = state.slice(LessonState).lesson
    base = lesson(name).scene if name else Scene()
    of_scene = scene.to_query(base, without=LASTING)
    found = "&".join(filter(None, (urlencode(pairs), of_scene)))
    if len(found) > MAX_LINK:
        for key, choice in linked_choices().items():
            if choice.key and choice.key.is_long:
                pairs.pop(key, None)
        found = "&".join(filter(None, (urlencode(pairs), of_scene)))
    if not of_scene and pairs.keys() <= {LESSON_KEY, STEP_KEY}:  # alone these have another scene
        found = "&".join(filter(None, (found, f"gamma={scene.beam.gamma!r}")))
    return found


@cache
def with_usual_choices(name: str, over: str) -> State:
    """A state with the choices that a link describes by the name of a lesson, or "", and the
    abscissa of its scene. It takes as long as all else of an address, which each edit changes."""
    scene = (lesson(name).scene if name else Scene()).changed(over=over)
    return usual(usual_state(scene, PAGE), scene, name)


def extra_pairs(state: State) -> dict[str, Any]:
    """The keys and values of a link to a state that are not those of its scene: where a link
    without them describes another one."""
    name = state.slice(LessonState).lesson
    without = with_usual_choices(name, state.over)
    values: dict[str, Any] = {"lesson": name} if name else {}
    for key, choice in linked_choices().items():
        if choice.key and state[choice] != without[choice]:
            values[key] = choice.key.write(state[choice])
    if entered := inline_table(state.case, state.case.nearest):
        values[ENTERED] = entered
    if state.kept is not None:
        values[BEFORE] = inline_table(state.kept, state.case) or "{}"
    words = {True: "true", False: "false"}
    return {
        key: words[one] if isinstance(one, bool) else one
        for key, one in values.items()
        if one is not None
    }


def is_same(one: Any, other: Any) -> bool:
    """Whether two values are equal, numbers up to what SI units and back leave of them."""
    numbers = isinstance(one, float) and isinstance(other, float)
    return math.isclose(one, other, rel_tol=ROUNDING) if numbers else one == other


def inline_table(case: Case, other: Case) -> str:
    """What a case has otherwise than another one, as an inline table of TOML; "" for nothing."""
    values, others = case.options | case.numbers, other.options | other.numbers
    known = (*NUMBERS, *CHOICES, *TERMS)
    changed = {k: v for k, v in values.items() if k in known and not is_same(v, others[k])}
    return inline_toml(changed) if changed else ""


PAGE: tuple[type[Feature], ...] = (*FEATURES, Links)  # all features of the page
