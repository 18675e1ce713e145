"""Charts, and features without a page, for tests."""

import threading
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from beamviz.beam import Beam
from beamviz.explorer.features.loci_chart import Chart, ChartRequest
from beamviz.explorer.jobs import Job, SolveJob
from beamviz.explorer.state import Case, State
from beamviz.scene import Scene

TIP = Beam(alpha=1, beta=1, gamma=3)  # S1 crosses B3 at gamma = 4.4641


def case(beam: Beam, **options: Any) -> Case:
    """A beam with the model of a scene and other keywords of `solve`."""
    return Case.of(Scene(beam)).with_options(**options)


def chart_of(beam: Beam, over: str = "gamma", per_rev: int = 0, **options: Any) -> Chart:
    """The chart around a beam, with resonances up to a multiple of the speed."""
    return ChartRequest.around(case(beam, **options), over, per_rev).chart()


class SynchronousVisitor:
    """A visitor whose jobs are done at once, for features without a page."""

    def __init__(self, scene: Scene, api: Any = None):
        self.state, self.answer = State.of(scene), None
        self.client, self.lock = SimpleNamespace(scene=api), threading.RLock()
        self.solver = self.solve_job()
        self.change(lambda state: state)

    def change(self, edit: Callable[[State], State]) -> None:
        """Edit the state, and solve its case."""
        self.set_state(edit(self.state))

    def set_state(self, state: State) -> None:
        """Take another state, and solve its case."""
        self.state = state
        self.solver.request(state.shown_case)
        self.answer = self.solver.answer

    def job(self, name: str, compute: Callable[[Any], Any]) -> Job:
        """A job done at once."""
        return Job(name, compute, lambda work: work(), lambda: None)

    def solve_job(self) -> SolveJob:
        """A solver job done at once."""
        queue: Any = SimpleNamespace(solve=lambda work, is_quick: work())
        return SolveJob(queue, lambda: None)

    def wake(self) -> None:
        """Nothing waits."""
