"""Page and scene are functions of the state: after hundreds of edits in any order they equal those
of a page that is opened fresh on the resulting address; and in each frame those of a session that
has seen nothing before."""

import pickle
import random
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any, NamedTuple

import pytest
from helpers import slow
from live.coarse import POSSIBLE, coarse_charts
from live.fresh import Guest, Opening, compare_with_fresh, opened
from live.offline import OfflineGuest, offline

from beamviz.beam import NUMBERS, PARAMETERS, Beam
from beamviz.errors import NotConverged
from beamviz.explorer import explorer
from beamviz.explorer.computed_motion import can_move
from beamviz.explorer.experiment import ALTERNATIVES, RANGES
from beamviz.explorer.feature import tabs
from beamviz.explorer.features import motion as motion_tab
from beamviz.explorer.features.beam_pull import BeamPull
from beamviz.explorer.features.files import FILM_LENGTHS
from beamviz.explorer.features.lessons import LessonState
from beamviz.explorer.features.real_beam import PRESETS
from beamviz.explorer.features.run_up import RunUpState
from beamviz.explorer.frame_loop import FrameLoop
from beamviz.explorer.jobs import Job
from beamviz.explorer.links import PAGE
from beamviz.explorer.state import COMPARISONS, NO_COMPARISON
from beamviz.explorer.visitor import Visitor
from beamviz.lessons import NAMES, lesson
from beamviz.scene import START, Scene

Action = tuple[str, Any]
ALL = "all"  # key of the edits that belong to no tab
SIZE = "size"  # key of those of a page that changes its size
# [px] of the scene: two that differ in the strip that the page covers alone, and others.
SIZES = (1280, 720), (390, 480), (1040, 1280), (820, 610)
SCENE = "scene"  # key of those of them that change what the scene shows of a beam
OF_SCENE = (
    *("rotating_frame", "ghosts", "nodes", "tip_path", "forces", "thicken", "dark", "all_modes"),
    "colouring",
    *("amplitude", "only", "turn", "reset_view", "drag", "plane", "state", "alpha", "preferences"),
)
MASS, SLEEVE = "/scene/rotor/mass", "/scene/rotor/sleeve"  # nodes of the scene that can be dragged
WHEEL = "/scene/rotor/wheel/handle"
# What the server of fresh pages begins with: nothing of it is to be seen after a link.
ELSEWHERE = Scene(Beam(alpha=0.3, beta=0.9, gamma=2.5, delta=0.1, mu=55)).changed(
    playing=False, ghosts=False, nodes=False, rotating_frame=True, amplitude=0.07
)
STILL = START.changed(playing=False)
LINKS = (
    "",
    "?gamma=3",
    "?lesson=veering&gamma=4.5",
    "?alpha=2&beta=0.3&delta=-1&gamma=6&mode=2",
    "?compare=mass&stacked=true&gamma=8&alpha=1",
    "?gamma=5&before={gamma=9.0,alpha=2.0}&compare=earlier&alpha=1",
    "?length=0.5&density=7850&area=1e-4&second_moment=1e-10&youngs_modulus=2.1e11&tab=veering",
    "?mode=8&gamma=2",
    "?lesson=nowhere",
    "?alpha=-1&beta=0.25",
    "?spin_up=-6.4&alpha=2.7&beta=0.46&gamma=5&delta=-1&state=stable&tab=loads",
)
ONE_BY_ONE = 0.8  # the part of the edits that a frame shows before the next one is sent
SOLVED = 0.6  # the part of those of which the modes are waited for
POSSIBLE_PART = 0.75  # the part of the rounds in which the beam has a solution and a motion
LEFT = 0.5  # the part of the rounds in which an open lesson is left, or a size that is known
MET = 0.5  # the part of the rounds about lessons in which the challenge is met
BLADES = "tapered-steel-blade", "nrel-5mw-blade"  # others take longer
MOST = 100  # edits of a round
PLAYING = "playing", "motion.begin"  # actions after which the scene may move
PLAYED = 3  # frames of that
PANELS = "real", "blade"  # keys of the edits that belong to panels beside the tabs
CONNECTED = ALL, "frequencies", "motion", "map"  # what edits through a connection are about


def edits(chance: random.Random) -> dict[str, list[Action]]:
    """Actions of the page with values: sensible, odd or impossible; by the tab or panel whose
    content depends on them. There are as many each time."""
    number = chance.choice(list(PARAMETERS))
    low, high, _ = NUMBERS[number].slider
    usual = round(chance.uniform(low, high), 3)
    several = [(number, usual)] * 6
    of_motion = chance.choice(list(RANGES))
    first, last, _ = RANGES[of_motion].slider
    chosen = chance.choice(list(ALTERNATIVES))
    turn = "turn", (chance.uniform(-2.0, 2.0), chance.uniform(0.7, 1.5))
    amplitude = "amplitude", chance.uniform(0.0, 0.5)
    found: dict[str, list[Action]] = {
        ALL: [
            *several,
            (number, chance.choice((1e9, -3.0, "fast", 0.0, 1.0))),
            ("gamma", chance.choice((0.0, 4.46, 60.0, 150.0))),
            ("delta", -1.0),
            ("spin_up", chance.choice((0.5, -17.8))),
            ("plane", chance.choice(("chordwise", "flapwise"))),
            ("method", chance.choice(("auto", "auto", "ancf", "zoac", "rubber"))),
            ("strain", chance.choice(("green", "hencky", "biot"))),
            ("curvature", chance.choice(("spatial", "material"))),
            ("state", chance.choice(("straight", "stable", "bent"))),
            (
                chance.choice(("coriolis", "softening", "stiffening", "mass")),
                chance.random() < 0.7,
            ),
            ("only", chance.randrange(6)),
            ("only", chance.randrange(3)),
            (f"share-{chance.randrange(5)}", chance.random()),
            amplitude,
            ("pace", chance.choice((0.0, 0.5, 2.0))),
            *[
                (name, chance.random() < 0.5)
                for name in (
                    "rotating_frame",
                    "ghosts",
                    "nodes",
                    "tip_path",
                    "forces",
                    "thicken",
                    "dark",
                    "playing",
                )
            ],
            *[("all_modes", chance.random() < 0.5)] * 2,
            ("preferences", chance.choice(("", "still", "still dark"))),
            *[turn] * 3,
            ("colouring", chance.choice(("displacement", "axial strain"))),
            *[("rate", chance.choice((0.2, None, "never")))] * 2,
            ("reset_view", None),
            ("real.preset", chance.choice(list(PRESETS))),
            ("dimensionless", None),
            ("comparison", chance.choice(COMPARISONS)),
            ("link", chance.choice(LINKS)),
            *([(chance.choice(("undo", "redo")), None)] * 4),
            ("reset", None),
            ("lesson", chance.choice(("", *NAMES))),
            *[("lesson_turn", chance.choice((1, -1)))] * 2,
            ("lesson_step", chance.randrange(3)),
            ("lesson_guess", chance.randrange(3)),
            *[("own.keep", None), ("own.say", chance.choice(("a", "<b>")))],
            *[("own.edit", chance.randrange(3)), ("own.go", chance.randrange(3))],
            *[("own.turn", chance.choice((1, -1)))] * 2,
            *[("drag", (MASS, chance.uniform(-0.3, 0.3)))] * 3,
            ("drag", (WHEEL, chance.uniform(-0.2, 0.2))),
        ],
        "frequencies": [
            *[(f"per_rev_{chance.randrange(1, 7)}", chance.random() < 0.7)] * 3,
            ("over", chance.choice(("alpha", "beta", "gamma", "delta"))),
            ("go_to_event", chance.choice(("B3 S1 1", "B2 S1 1", "2 B1 1"))),
            *[("comparison", chance.choice(COMPARISONS))] * 2,
            *[("gamma", round(chance.uniform(0, 12), 2))] * 3,
        ],
        "map": [
            (chance.choice(("over", "across")), chance.choice(("alpha", "beta", "gamma"))),
            *[("mapped", chance.choice(("gap", "1", "3")))] * 4,
            ("move_beam", f"{chance.uniform(0, 15):.3g} {chance.uniform(0, 1):.3g}"),
            (number, usual),
        ],
        "veering": [
            ("go_to_event", chance.choice(("B3 S1 1", "B2 S1 1"))),
            ("over", chance.choice(("alpha", "gamma"))),
            *[("gamma", round(chance.uniform(0, 10), 2))] * 3,
            ("alpha", round(chance.uniform(0, 3), 2)),
            ("coriolis", chance.random() < 0.7),
            ("coriolis_percent", float(chance.randrange(0, 101, 10))),
            ("show_shape", chance.choice(("0 before", "1 at", "1 after"))),
        ],
        "compare": [
            *[("comparison", chance.choice(COMPARISONS))] * 2,
            ("stacked", chance.random() < 0.5),
            *[("keep", None)] * 2,
            ("all_modes", chance.random() < 0.5),
            *several[:3],
        ],
        "loads": [*several, ("state", "stable"), ("delta", 1.0)],
        "run-up": [
            *[("force_per_rev", str(chance.randrange(1, 7)))] * 2,
            ("damping", chance.uniform(0, 30)),
            *[("run_up", None)] * 2,
            turn,
            amplitude,
            *[("gamma", round(chance.uniform(0, 10), 2))] * 2,
            (number, usual),
        ],
        "motion": [
            ("experiment", chance.choice(list(motion_tab.PRESETS))),
            *[(f"motion.{of_motion}", round(chance.uniform(first, last), 3))] * 2,
            (f"motion.{chosen}", chance.choice([*ALTERNATIVES[chosen], "flies"])),
            ("motion.unstiffened", chance.random() < 0.5),
            *[("moment", chance.choice((0.0, 0.1, 0.2, 5.0)))] * 2,
            *[("drag", (SLEEVE, chance.uniform(-0.5, 0.5)))] * 3,
            *[("motion.begin", None)] * 3,
            turn,
            amplitude,
            ("only", 0),
            ("gamma", round(chance.uniform(0, 9), 2)),
            ("real.preset", chance.choice(list(PRESETS))),
        ],
        "methods": [
            *[("time_methods", chance.random() < 0.5)] * 2,
            ("method", chance.choice(("auto", "ancf"))),
            (number, usual),
        ],
        "lessons": [
            ("lesson", chance.choice(("", *NAMES))),
            ("lesson_turn", 1),
            ("tab", "lessons"),
            ("met", chance.choice(NAMES)),
            *[("lesson_step", chance.choice((0, 1, 2, 2)))] * 2,
            *[("lesson_guess", chance.randrange(3))] * 2,
            *several,
        ],
        "adjust": [
            *[("goal", chance.choice(("measured", "targets", "clear")))] * 2,
            (f"adjust.free.{chance.choice(('beta', 'delta', 'pitch'))}", chance.random() < 0.5),
            ("adjust.high.beta", chance.choice((0.7, 0.9, 3.0))),
            ("adjust.measured", chance.choice(("", "frequency\n3.1", "gamma, frequency\n1"))),
            ("adjust.match", chance.choice(("0 B2", "0", "4 B1", "B1"))),
            ("adjust.targets", chance.choice(("B1=3.6", "B1"))),
            ("adjust.margin", chance.choice((5.0, 20.0, 900.0))),
            *several[:3],
        ],
        "export": [("film_length", chance.choice(list(FILM_LENGTHS)))],
        "real": [
            ("real.preset", chance.choice(list(PRESETS))),
            *[
                (
                    chance.choice(("real.length", "real.thickness", "real.width")),
                    chance.uniform(0, 900),
                )
            ]
            * 2,
            ("real.section", chance.choice(("rectangle", "tube", "own"))),
            ("real.material", chance.choice(("steel", "glass fibre", "butter"))),
            ("dimensionless", None),
            (number, usual),
        ],
        "blade": [
            ("blade.preset", chance.choice(BLADES)),
            (f"blade.{chance.choice(('stations', 'masses'))}.remove", chance.randrange(4)),
            (chance.choice(("blade.stations.add", "blade.masses.add", "blade.begin")), None),
            ("blade.root", chance.choice(("clamped", "hinged", "spring", "glued"))),
            ("blade.paste", chance.choice(("0 9 1e3 1e6\n1 8 9e2 1e6", "0,1\n1,x", "words"))),
            ("real.section", chance.choice(("along", "rectangle"))),
            (number, usual),
        ],
    }
    of_scene = [one for one in found[ALL] if one[0] in OF_SCENE]
    of_size = [*[("resize", size) for size in SIZES], turn, amplitude, ("reset_view", None)]
    return found | {SCENE: of_scene, SIZE: of_size}


def possible_again(guest: Guest, about: str) -> Action | None:
    """An edit that removes one reason why the beam of a visitor has no solution or no motion, or
    takes long; None where there is none. A blade stays one for edits about it."""
    state, answer = guest.session.visitor.state, guest.session.snapshot.answer
    own = state.case.numbers | state.case.options
    if about != "blade" and not state.case.nearest_beam().is_prismatic:
        return "blade.uniform", None
    slow = [name for name in ("spin_up", "state", "method") if own[name] != POSSIBLE[name]]
    if slow:
        return slow[0], POSSIBLE[slow[0]]
    if about != "blade" and (answer is None or answer.result is None or not can_move(state)):
        if state.case.units:
            return "dimensionless", None
        return next(((name, one) for name, one in POSSIBLE.items() if own[name] != one), None)
    return None


class Servers(NamedTuple):
    """An explorer, its frame loop, and how fresh pages of another one, which begins elsewhere, are
    opened."""

    url: str
    loop: FrameLoop
    fresh: Opening


@pytest.fixture(scope="module")
def coarse() -> Iterator[None]:
    """Coarse charts: what is compared is whether they are those of the state, not what they show.
    A fresh page need not compute again what the other has."""
    with coarse_charts(), pytest.MonkeyPatch.context() as patch:
        patch.setattr(Visitor, "job", with_results_of(Visitor.job, {}))
        yield


@pytest.fixture(scope="module")
def servers(coarse, frame_loops) -> Iterator[Servers]:
    """Explorers whose clocks never run."""
    with explorer(STILL) as url, explorer(ELSEWHERE) as fresh_url:
        yield Servers(url, frame_loops[-2], partial(opened, fresh_url, frame_loops[-1]))


def with_results_of(job: Callable[..., Job], known: dict[tuple[str, bytes], Any]) -> Any:
    """The making of jobs that take from `known` what a page was given before for all that is in the
    same request: a fresh page need not compute again what the other has."""

    def remembering(own: Visitor, name: str, compute: Callable[[Any], Any]) -> Job:
        def found(request: Any) -> Any:
            try:
                key = name, pickle.dumps(request)
            except (TypeError, AttributeError, pickle.PicklingError):  # it has functions
                return compute(request)
            if key not in known:
                try:
                    known[key] = compute(request)
                except NotConverged as error:
                    known[key] = error
            if isinstance(known[key], NotConverged):
                raise known[key]
            return known[key]

        return job(own, name, found)

    return remembering


def do(guest: Guest, action: str, value: Any) -> None:
    """An action of the page, a turn of the view, another size, or a drag in the scene from the
    middle of the beam; what is played goes on for some frames."""
    if action in ("turn", "resize"):
        getattr(guest, action)(*value)
        return
    if action != "drag":
        guest.visitor.do(action, value)
        if action in PLAYING:
            guest.wait(guest.is_handled)
            guest.play(PLAYED)
        return
    node, far = value
    guest.wait(guest.is_handled)
    session = guest.session
    if not (
        session.feature(BeamPull).offered if node == SLEEVE else session.view.beam.frame.visible
    ):
        return  # the browser shows nothing to drag
    delta = session.snapshot.picture.modes.beam.delta
    x, y = (far, 0.0) if node == MASS else (0.0, far)
    points = [(delta + 0.7 + part * x, part * y, 0.0) for part in (0, 0.5, 1, 1)]
    guest.drag(node, *points)


class Edits:
    """Edits at random, as cards are dealt: each kind that belongs to a tab or panel comes once
    before any comes again."""

    def __init__(self, chance: random.Random, guest: Guest):
        self.chance, self.guest = chance, guest
        self.left = {about: list[int]() for about in edits(chance)}

    def deal(self, about: str) -> Action:
        """The next one about a tab or a panel, with another value than the page shows, if any."""
        kinds = edits(self.chance)[about]
        if not self.left[about]:
            self.left[about] = self.chance.sample(range(len(kinds)), len(kinds))
        number = self.left[about].pop()
        several = [kinds[number], *(edits(self.chance)[about][number] for _ in range(5))]
        shown = self.guest.visitor.values
        new = (one for one in several if one[0] not in shown or shown[one[0]] != one[1])
        return next(new, several[0])

    def of_round(self, about: str) -> Iterator[Action]:
        """Edits in quick succession, the last one about a tab or panel, which is there by then."""
        chance, guest = self.chance, self.guest
        yield self.deal(ALL)
        if about != "lessons" and guest.state.slice(LessonState).lesson and chance.random() < LEFT:
            yield "lesson", ""
        if about in tabs(PAGE) and guest.visitor.parts.get("open") != about:
            yield "tab", about
        if chance.random() < POSSIBLE_PART:
            yield from iter(lambda: possible_again(guest, about), None)
        yield from self.shown(about)
        yield self.deal(about)

    def one(self, about: str) -> Iterator[Action]:
        """One edit: no other can make up for what the page has missed of it."""
        yield self.deal(about)

    def shown(self, about: str) -> Iterator[Action]:
        """The edit after which a panel, or a lesson, is there."""
        state, chance = self.guest.state, self.chance
        if about == "lessons":
            name = state.slice(LessonState).lesson
            if not name or chance.random() < LEFT:
                name = chance.choice(NAMES)
                yield "lesson", name
            yield chance.choice((("lesson_step", 2), ("lesson_step", 2), ("tab", "lessons")))
            if chance.random() < MET:
                one = lesson(name)
                yield f"{'motion.' * (one.number == 'pull_at')}{one.number}", one.answer
        if about == "compare" and state.comparison == NO_COMPARISON:
            yield "comparison", chance.choice(COMPARISONS)
        if about == "run-up" and state.slice(RunUpState).forced_response:
            yield "only", 0
        if about == "real" and not state.case.units:
            yield "real.preset", chance.choice(list(PRESETS))
        if about == "blade" and state.case.nearest_beam().is_uniform:
            yield "blade.preset", chance.choice(BLADES)
        if about not in PANELS and state.case.units and chance.random() < LEFT:
            yield "dimensionless", None

    def do(self, actions: Iterator[Action]) -> list[Action]:
        """Do edits; each is shown by a frame, or followed at once by the next."""
        done: list[Action] = []
        for action in actions:
            assert len(done) < MOST, "\n".join(map(str, done))
            do(self.guest, *action)
            done.append(action)
            if self.chance.random() < ONE_BY_ONE:
                solved = self.chance.random() < SOLVED
                self.guest.wait(self.guest.is_solved if solved else self.guest.is_handled)
        return done


@contextmanager
def begun(servers: Servers) -> Iterator[Guest]:
    """A new visitor with reduced motion: no clock runs."""
    with opened(servers.url, servers.loop) as guest:
        guest.visitor.do("preferences", "still")
        guest.visitor.do("link", "")
        yield guest


def comparisons(
    guest: Guest, fresh: Opening, seed: int, subjects: Sequence[str]
) -> Iterator[tuple[list[Action], list[str]]]:
    """The last edits of a visitor, and where their page then differs from a fresh one, about each
    of the subjects: after some edits, and one more once their answers are there."""
    edits = Edits(random.Random(seed), guest)
    for about in edits.chance.sample(subjects, len(subjects)):
        done = edits.do(edits.of_round(about))
        guest.wait(lambda: guest.is_let_go() and not guest.session.is_busy)
        done += edits.do(edits.one(about))
        yield done, compare_with_fresh(guest, fresh, START)


@pytest.mark.slow
def test_a_page_equals_a_fresh_one_on_its_address(servers):
    """Through a connection, with the threads of the jobs; what is played is paused before."""
    with begun(servers) as guest:
        for done, found in comparisons(guest, servers.fresh, 5, CONNECTED):
            assert not found, "\n".join([*map(str, done), *found])


def offline_comparisons(
    seed: int, subjects: Sequence[str]
) -> Iterator[tuple[list[Action], list[str]]]:
    """The last edits of a visitor without a connection, and where the page then differs from a
    fresh one."""
    with offline():
        guest = OfflineGuest(STILL, seed)
        guest.visitor.do("preferences", "still")
        guest.visitor.do("link", "")
        fresh = partial(OfflineGuest.opened, ELSEWHERE)
        yield from comparisons(guest, fresh, seed, subjects)


QUICK = ALL, "frequencies", "compare", "motion", "lessons", "real", SIZE
# Seeds, with what edits are about. Jobs end, and frames come, in another order with each.
OFFLINE_RUNS = {11: QUICK, 13: (ALL, "blade", *(key for key in tabs(PAGE) if key not in QUICK))}


@pytest.mark.parametrize("seed", [11, *slow(13)])
def test_an_edited_page_equals_a_fresh_one_which_has_other_answers_in_its_past(coarse, seed):
    """Without a connection, so that jobs end and frames come in many orders."""
    for done, found in offline_comparisons(seed, OFFLINE_RUNS[seed]):
        assert not found, "\n".join([*map(str, done), *found])


def test_a_control_shows_the_state_again_where_an_action_leaves_that_as_it_is():
    """In a frame of its own, not that of the next edit, as for an event that a new chart does not
    have any more."""
    with offline():
        guest = OfflineGuest(STILL)
        guest.settle()
        shown = guest.visitor.values["go_to_event"]
        guest.visitor.do("go_to_event", "B9 S9 1")
        guest.settle()
        assert guest.visitor.values["go_to_event"] == shown
