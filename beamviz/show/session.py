"""One visitor: what is wanted, what came of it, and the picture of it as time goes on."""

import math
import threading
from collections.abc import Callable
from concurrent.futures import Executor
from typing import Any

import numpy as np
from viser import CameraHandle, ClientHandle, ViserServer

from beamviz.look import Look
from beamviz.scene_file import TABLES, SavedScene
from beamviz.show import colours, link
from beamviz.show.against import BEFORE, NOTHING
from beamviz.show.charting import Charting
from beamviz.show.commands import Commands
from beamviz.show.compare import Comparison
from beamviz.show.controls import Wanted
from beamviz.show.efforts import Weighing
from beamviz.show.following import Following, Leader
from beamviz.show.grip import Grip
from beamviz.show.guide import Guide
from beamviz.show.motion import Clock, Shapes, amplitudes
from beamviz.show.multiples import Multiples, heights
from beamviz.show.panels import Panel
from beamviz.show.pieces import SCALE, Seen, between
from beamviz.show.ride import Ride
from beamviz.show.save_load import SaveLoad
from beamviz.show.scene import Scene
from beamviz.show.solving import Answer, Solver
from beamviz.show.take_away import TakeAway
from beamviz.show.turns import Turns
from beamviz.show.viewing import Viewing

BRAND = (32, 96, 150)
REST = 0.3  # [s] that a slider has to rest before the charts of a crowd follow
ZOOMED = 1.25  # times larger or smaller: worth other pieces
LONGEST_STEP = 0.2  # [s] the clock never jumps further, even after a stall


class Session:
    """A visitor's scene and controls. Callbacks only store what is wanted; `tick`, called by
    the one animator thread, does all the drawing."""

    def __init__(
        self,
        client: ClientHandle,
        scene: SavedScene,
        turns: Turns,
        charts: Executor,
        wake: Callable[[], None],
        crowded: Callable[[], bool],
        leader: Leader | None = None,
    ):
        self.client, self.wake, self.lock = client, wake, threading.RLock()
        self.look = self.drawn = scene.look  # what is wanted to be seen, and what is seen
        self.viewing = Viewing(client.camera, scene.camera)
        self.repace = True  # choose the pace anew
        self.following: Following | None = None  # edits may come while the rest is built
        self.clock, self.seen = Clock(), 0.0
        self.scale = SCALE  # that the picture was drawn for
        self.crowded, self.chart_due = crowded, math.inf
        self.answer: Answer | None = None
        self.shapes = Shapes.at_rest(scene.beam, scene.options["plane"])
        self.solver = Solver(turns, Wanted.by(scene), wake)
        self.charting = Charting(charts, wake, scene.over, scene.per_rev)
        self.comparison = Comparison(client.scene, turns, wake)
        self.ride = Ride(charts, wake)
        self.weighing = Weighing(charts, wake)
        self.scene, self.multiples = Scene(client.scene), Multiples(client.scene)
        self.panel = Panel(client.gui, Wanted.by(scene), self.look, self)
        self.panel.put(scene)
        self.guide = Guide(client.gui, self.panel, scene)
        Commands(client.gui, self.panel, self.guide)
        SaveLoad(client, self)
        self.take_away = TakeAway(client, self)
        if leader:
            self.following = Following(self, client.gui, leader)
        self.held = False  # the mass is being dragged
        self.grip = Grip(self.scene, lambda: client.camera.position, self)
        theme(client, dark=scene.look.dark)
        client.camera.on_update(self.resized)
        link.follow(client, self.guide, self.load)

    # What the panel hands on, from any thread (sliders.Listener says what).

    def want(self, name: str, value: Any) -> None:
        """Another number or keyword is wanted."""
        self.explore()
        with self.lock:
            if name == "plane":
                self.viewing.let_go()
            wanted = self.solver.wanted.changed(name, value)
            if wanted != self.solver.wanted:
                self.solver.want(wanted)
                self.ride.stop() if name == "gamma" else self.ride.forget()

    def see(self, name: str, value: Any) -> None:
        """Another choice of the picture."""
        if name in ("riding", "together"):
            self.viewing.let_go()
        self.store(lambda look: look.changed(name, value), repace=name == "together")

    def keep(self) -> None:
        """Keep the beam as it is, to compare with."""
        self.comparison.keep(self.solver.wanted)

    def share(self, mode: int, value: Any) -> None:
        """Another share of one mode; the pace is chosen anew."""
        self.ride.shown = False
        self.store(lambda look: look.share(mode, value), repace=True)

    def only(self, mode: int) -> None:
        """One mode alone; the pace is chosen anew."""
        self.ride.shown = False
        with self.lock:
            self.store(lambda look: look.only(mode), repace=True)
            self.panel.show_shares(self.look)

    def reset(self) -> None:
        """The beam back to what the lesson, or the page, began with."""
        self.guide.reset()

    def reset_view(self) -> None:
        """The camera back to where the beam fills the picture."""
        self.viewing.take(None)
        self.wake()

    def sweep(self, over: str) -> None:
        """Another axis of the loci chart."""
        self.charting.sweep(over)

    def show_per_rev(self, shown: bool) -> None:
        """Per-rev lines in the loci chart, or none."""
        self.charting.show_per_rev(shown)

    def meet(self, number: int) -> None:
        """Move the beam to a meeting (from 0) of the loci chart."""
        if target := self.charting.choose(number):
            self.panel.numbers.put(*target)

    def remember(self) -> None:
        """Keep it unless it is compared with something else."""
        if self.comparison.choice in (NOTHING, BEFORE):
            self.keep()

    def run_up(self) -> None:
        """Start the run-up, or stop it."""
        self.explore()
        if self.ride.riding:
            self.ride.stop()
            return
        self.see("together", False)
        self.panel.loci.show_lines()
        self.ride.start(self.solver.wanted)

    def hold(self) -> None:
        """The mass was taken: time stands still, and how the beam was stays to be seen."""
        self.held = True
        self.remember()

    def drag(self, beta: float) -> None:
        """The mass was dragged along the beam."""
        self.panel.numbers.put("beta", beta)

    def release(self) -> None:
        """The mass was let go."""
        self.held = False
        self.wake()

    def saved(self) -> SavedScene:
        """All that is set, as a scene; InvalidInput where that is none."""
        wanted, charting = self.solver.wanted, self.charting
        options = {name: wanted.options[name] for name in TABLES["model"] if name in wanted.options}
        return SavedScene(
            wanted.beam(), options, self.look, self.viewing.chosen, charting.over, charting.per_rev
        )

    def load(self, scene: SavedScene) -> None:
        """Show another scene; the pace is chosen anew."""
        self.explore()
        with self.panel.lock, self.lock:
            self.panel.put(scene)
            self.solver.want(Wanted.by(scene))
            self.charting.take(scene.over, scene.per_rev)
            self.viewing.take(scene.camera)
            self.ride.forget()
            self.comparison.forget()
            self.store(lambda _: scene.look, repace=True)

    def store(self, change: Callable[[Look], Look], *, repace: bool = False) -> None:
        """Keep a changed look for the next tick."""
        self.explore()
        with self.lock:
            self.look = change(self.look)
            self.repace = self.repace or repace
        self.wake()

    def explore(self) -> None:
        """Whoever moves a control goes their own way."""
        if self.following:
            self.following.explore()

    # What the animator does.

    @property
    def moving(self) -> bool:
        """Whether the picture changes with time."""
        playing = self.look.playing and self.look.pace > 0
        return (playing or self.ride.riding) and not (self.words or self.held)

    @property
    def ticking(self) -> bool:
        """Whether the next frame is needed, whatever happens until then."""
        return self.moving or self.fresh or self.chart_due < math.inf

    @property
    def fresh(self) -> bool:
        """Whether something waits to be drawn."""
        behind = self.following is not None and self.following.behind
        return self.changed or self.charting.fresh or self.weighing.fresh or behind

    @property
    def changed(self) -> bool:
        """Whether the scene itself waits to be drawn."""
        return (
            self.viewing.asked
            or self.look is not self.drawn
            or self.solver.answer is not self.answer
            or self.comparison.fresh
            or self.ride.fresh
            or self.zoomed
        )

    @property
    def words(self) -> str:
        """What is wrong with what is wanted, or ""."""
        return self.answer.words if self.answer else ""

    def tick(self, now: float) -> None:
        """Bring the picture up to `now` [s]."""
        elapsed, self.seen = min(now - self.seen, LONGEST_STEP), now
        if self.following:
            self.following.step()
        if self.ride.riding:
            self.ride_on(elapsed)
        changed = self.changed
        with self.client.atomic():
            if changed:
                self.draw()
            time = elapsed * self.pace if self.moving else 0.0
            self.clock.advance(time, self.shapes.frequencies, self.shapes.beam.gamma)
            if self.following:
                self.following.keep_time()
            self.move(time)
            self.comparison.move(time, self.shapes, self.amplitudes)
            self.multiples.move(self.clock.phases, self.drawn.amplitude, self.clock.angle)
        self.client.flush()
        if changed:
            self.chart_due = now + (REST if self.crowded() else 0.0)
        if now >= self.chart_due and not (self.crowded() and self.solver.busy):
            self.chart_due = math.inf
            self.charting.follow(self.answer, self.comparison.second)
            self.weighing.follow(self.answer)
        if self.charting.fresh:
            self.charting.draw(self.panel.loci, self.panel.microscope)
        if self.weighing.fresh:
            self.panel.weigh(*self.weighing.shown())

    def move(self, time: float) -> None:
        """Move the beam on by `time` [T*]: as its modes swing, or as the force drives it."""
        if self.ride.driven:
            moved = self.ride.displaced(time, self.shapes.beam.gamma)
            moved = between(self.shapes.x, moved, self.scene.shapes.x)
            self.scene.displace(moved, self.largest, self.clock.angle)
        else:
            self.scene.move(self.clock.phases, self.amplitudes, self.clock.angle)

    def ride_on(self, elapsed: float) -> None:
        """A little faster."""
        gamma = self.ride.advance(elapsed)
        if gamma is not None:
            with self.lock:
                self.solver.want(self.solver.wanted.changed("gamma", gamma))
            self.panel.numbers.follow("gamma", gamma)

    def draw(self) -> None:
        """Take up the latest answer and look, and tell the panel."""
        with self.lock:
            dark = self.drawn.dark
            self.drawn, self.answer = self.look, self.solver.answer
            settled = self.answer is not None and self.answer.wanted is self.solver.wanted
            repace, self.repace = self.repace, self.repace and not settled
        if self.answer and self.answer.shapes and not self.words:
            self.shapes = self.answer.shapes
        if self.ride.shown and self.answer and self.answer.solution:
            self.ride.drive(self.answer.solution, self.shapes, self.drawn.amplitude)
        self.clock.fit(self.swinging, self.shapes.beam.gamma, keep=not repace)
        self.show_others()
        self.scene.show(self.shapes, self.drawn, self.shown, words=self.words, seen=self.sight)
        if self.answer:
            self.panel.show(self.answer, self.shown)
            self.guide.follow(self.answer)
            self.panel.compare.show(self.answer, self.comparison)
        self.ride.drawn = self.ride.state
        self.panel.ride.show(self.ride, self.shapes.beam.gamma)
        self.panel.show_picture(
            self.drawn.colouring, self.largest, self.pace, self.shapes.beam.units
        )
        levels = heights(self.multiples.count) or self.comparison.levels
        self.viewing.look_at(self.shapes, self.drawn.riding, levels, settled=settled)
        if self.drawn.dark != dark:
            theme(self.client, dark=self.drawn.dark)

    def show_others(self) -> None:
        """The beam compared with, or all modes in place of the one scene."""
        if self.answer:
            self.comparison.follow(self.answer.wanted)
        self.scale = self.viewing.scale
        self.comparison.show(self.shapes, self.clock, self.drawn, self.shown, self.scale)
        self.scene.height = self.comparison.levels[0]
        together = self.drawn.together and len(self.shapes.modes) > 0 and not self.words
        self.scene.stage.visible = not together
        if together:
            self.multiples.show(self.shapes, self.drawn, self.scale)
        else:
            self.multiples.hide()

    async def resized(self, _: CameraHandle) -> None:
        """The camera moved; if the page changed its shape, choose the viewpoint anew."""
        if self.viewing.reshaped:
            self.reset_view()
        elif self.zoomed:
            self.wake()

    @property
    def zoomed(self) -> bool:
        """Whether the camera came so much nearer, or went, that the beam is to be cut anew."""
        return not 1 / ZOOMED < self.viewing.scale / self.scale < ZOOMED

    @property
    def pace(self) -> float:
        """Time [T*] that passes in one second."""
        return self.clock.rate * self.drawn.pace

    @property
    def shown(self) -> list[int]:
        """The modes (from 0) in the picture."""
        if self.ride.driven:
            return []
        if self.drawn.together:
            return list(range(len(self.shapes.modes)))
        return [k for k in range(len(self.shapes.modes)) if self.amplitudes[k] > 0]

    @property
    def swinging(self) -> np.ndarray:
        """The frequencies in the picture."""
        if self.ride.driven:
            return np.array([self.ride.per_rev * self.shapes.beam.gamma])
        return self.shapes.frequencies[self.shown]

    @property
    def largest(self) -> float:
        """The value at the end of the colour map."""
        colouring = self.drawn.colouring
        if self.ride.driven:
            return self.ride.largest(self.shapes, colouring, self.drawn.amplitude)
        return colours.colour_range(self.shapes, colouring, self.amplitudes)

    @property
    def sight(self) -> Seen:
        """What the picture shows of the beam."""
        look = self.drawn
        if self.ride.driven:
            return Seen(self.ride.field[None], self.scale, look.colouring, self.largest)
        return Seen.of(self.shapes, self.amplitudes, look.colouring, self.scale)

    @property
    def amplitudes(self) -> np.ndarray:
        """Amplitude (m,) of every mode; none while the beam is driven."""
        modes = len(self.shapes.modes)
        return np.zeros(modes) if self.ride.driven else amplitudes(self.drawn, modes)

    def close(self) -> None:
        """Nothing more is solved."""
        self.solver.close()
        self.take_away.close()
        self.charting.close()
        self.comparison.close()
        self.ride.close()
        self.weighing.close()


def theme(side: ClientHandle | ViserServer, *, dark: bool) -> None:
    """A dark or a light page, without viser's own buttons."""
    side.gui.configure_theme(
        dark_mode=dark, show_logo=False, show_share_button=False, brand_color=BRAND
    )
