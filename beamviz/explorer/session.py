"""One visitor: what is wanted, what came of it, and what they are told of it."""

import threading
from collections.abc import Callable
from concurrent.futures import Executor
from typing import Any

from viser import CameraHandle, ClientHandle

from beamviz.explorer import url as link
from beamviz.explorer.debounce import Lag
from beamviz.explorer.features.comparison import BEFORE, NOTHING, Comparison
from beamviz.explorer.features.files import SaveLoad, TakeAway
from beamviz.explorer.features.lessons import Guide
from beamviz.explorer.features.loci_tab import Charting
from beamviz.explorer.features.mass_drag import Grip
from beamviz.explorer.features.method_timing import Weighing
from beamviz.explorer.features.presenter import Following, Leader
from beamviz.explorer.features.run_up import Ride
from beamviz.explorer.live_view import LivePicture
from beamviz.explorer.page.commands import Commands
from beamviz.explorer.page.panel import Panel
from beamviz.explorer.page.theme import theme
from beamviz.explorer.request import Wanted
from beamviz.explorer.solve_queue import Turns
from beamviz.explorer.solver_job import Solver
from beamviz.scene import TABLES, Scene, ViewOptions

LONGEST_STEP = 0.2  # [s] the clock never jumps further, even after a stall


class Session:
    """A visitor's scene and controls. Callbacks only store what is wanted; `tick`, called by
    the one animator thread, does all the drawing."""

    def __init__(
        self,
        client: ClientHandle,
        scene: Scene,
        turns: Turns,
        charts: Executor,
        wake: Callable[[], None],
        crowded: Callable[[], bool],
        leader: Leader | None = None,
    ):
        self.client, self.wake, self.lock = client, wake, threading.RLock()
        self.view = scene.view  # what is wanted to be seen
        self.repace = True  # choose the pace anew
        self.following: Following | None = None  # edits may come while the rest is built
        self.lag, self.seen = Lag(crowded), 0.0
        self.solver = Solver(turns, Wanted.by(scene), wake)
        self.charting = Charting(charts, wake, scene.over, scene.per_rev)
        self.weighing = Weighing(charts, wake)
        self.ride = Ride(charts, wake)
        self.comparison = Comparison(client.scene, turns, wake)
        self.picture = LivePicture(client.scene, client.camera, scene, self.comparison, self.ride)
        self.viewing, self.clock = self.picture.viewing, self.picture.clock
        self.panel = Panel(client.gui, Wanted.by(scene), self.view, self)
        self.panel.put(scene)
        self.guide = Guide(client.gui, self.panel, scene)
        Commands(client.gui, self.panel, self.guide)
        SaveLoad(client, self)
        self.take_away = TakeAway(client, self)
        if leader:
            self.following = Following(self, client.gui, leader)
        self.held = False  # the mass is being dragged
        self.grip = Grip(self.picture.scene, lambda: client.camera.position, self)
        theme(client, dark=scene.view.dark)
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
        if name in ("rotating_frame", "all_modes"):
            self.viewing.let_go()
        self.store(lambda view: view.changed(name, value), repace=name == "all_modes")

    def keep(self) -> None:
        """Keep the beam as it is, to compare with."""
        self.comparison.keep(self.solver.wanted)

    def share(self, mode: int, value: Any) -> None:
        """Another share of one mode; the pace is chosen anew."""
        self.ride.shown = False
        self.store(lambda view: view.share(mode, value), repace=True)

    def only(self, mode: int) -> None:
        """One mode alone; the pace is chosen anew."""
        self.ride.shown = False
        with self.lock:
            self.store(lambda view: view.only(mode), repace=True)
            self.panel.show_shares(self.view)

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
        self.see("all_modes", False)
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

    def saved(self) -> Scene:
        """All that is set, as a scene; InvalidInput where that is none."""
        wanted, charting = self.solver.wanted, self.charting
        options = {name: wanted.options[name] for name in TABLES["model"] if name in wanted.options}
        return Scene(
            wanted.beam(), options, self.view, self.viewing.chosen, charting.over, charting.per_rev
        )

    def load(self, scene: Scene) -> None:
        """Show another scene; the pace is chosen anew."""
        self.explore()
        with self.panel.lock, self.lock:
            self.panel.put(scene)
            self.solver.want(Wanted.by(scene))
            self.charting.take(scene.over, scene.per_rev)
            self.viewing.take(scene.camera)
            self.ride.forget()
            self.comparison.forget()
            self.store(lambda _: scene.view, repace=True)

    def store(self, change: Callable[[ViewOptions], ViewOptions], *, repace: bool = False) -> None:
        """Keep a changed view for the next tick."""
        self.explore()
        with self.lock:
            self.view = change(self.view)
            self.repace = self.repace or repace
        self.wake()

    def explore(self) -> None:
        """Whoever moves a control goes their own way."""
        if self.following:
            self.following.explore()

    async def resized(self, _: CameraHandle) -> None:
        """The camera moved; if the page changed its shape, choose the viewpoint anew."""
        if self.viewing.reshaped:
            self.viewing.take(None)
        self.viewing.asked |= self.viewing.overtaken
        if self.viewing.asked or self.picture.zoomed:
            self.wake()

    # What the animator does.

    @property
    def moving(self) -> bool:
        """Whether the picture changes with time."""
        playing = self.view.playing and self.view.pace > 0
        return (playing or self.ride.riding) and not (self.picture.words or self.held)

    @property
    def ticking(self) -> bool:
        """Whether the next frame is needed, whatever happens until then."""
        return self.moving or self.fresh or self.lag.running

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
            or self.view is not self.picture.view
            or self.solver.answer is not self.picture.answer
            or self.comparison.fresh
            or self.ride.fresh
            or self.picture.zoomed
        )

    def tick(self, now: float) -> None:
        """Bring the picture up to `now` [s]."""
        elapsed, self.seen = min(now - self.seen, LONGEST_STEP), now
        if self.following:
            self.following.step()
        if self.ride.riding:
            self.ride_on(elapsed)
        if changed := self.changed:
            self.lag.begin(now)
        with self.client.atomic():
            if changed:
                self.draw()
            time = elapsed * self.picture.pace if self.moving else 0.0
            self.picture.advance(time)
            if self.following:
                self.following.keep_time()
            self.picture.move(time)
        self.client.flush()
        self.follow(now)

    def ride_on(self, elapsed: float) -> None:
        """A little faster."""
        gamma = self.ride.advance(elapsed)
        if gamma is not None:
            with self.lock:
                self.solver.want(self.solver.wanted.changed("gamma", gamma))
            self.panel.numbers.follow("gamma", gamma)

    def draw(self) -> None:
        """Take up the latest answer and view, and tell the panel."""
        with self.lock:
            view, answer = self.view, self.solver.answer
            settled = answer is not None and answer.wanted is self.solver.wanted
            repace, self.repace = self.repace, self.repace and not settled
        dark = self.picture.view.dark
        self.picture.show(answer, view, repace=repace, settled=settled)
        self.tell()
        if view.dark != dark:
            theme(self.client, dark=view.dark)

    def tell(self) -> None:
        """Tell the panel what the picture shows."""
        picture = self.picture
        if picture.answer:
            self.panel.show(picture.answer, picture.shown)
            self.guide.follow(picture.answer)
            self.panel.compare.show(picture.answer, self.comparison)
        self.ride.drawn = self.ride.state
        beam = picture.shapes.beam
        self.panel.ride.show(self.ride, beam.gamma)
        self.panel.show_picture(picture.view.colouring, picture.largest, picture.pace, beam.units)

    def follow(self, now: float) -> None:
        """Have the charts follow what is shown, and draw what has come of it."""
        if self.lag.over(now, busy=self.solver.busy):
            self.charting.follow(self.picture.answer, self.comparison.second)
            self.weighing.follow(self.picture.answer)
        if self.charting.fresh:
            self.charting.draw(self.panel.loci, self.panel.microscope)
        if self.weighing.fresh:
            self.panel.weigh(*self.weighing.shown())

    def close(self) -> None:
        """Nothing more is solved."""
        self.solver.close()
        self.take_away.close()
        self.charting.close()
        self.comparison.close()
        self.ride.close()
        self.weighing.close()
