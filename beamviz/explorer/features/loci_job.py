"""One visitor's loci: the chart, its choices, and the meeting under the microscope."""

import contextlib
from collections.abc import Callable
from concurrent.futures import Executor

from beamviz.errors import InvalidInput
from beamviz.explorer.features.loci_chart import SPANS, Chart, Charts, Point, Question
from beamviz.explorer.features.loci_tab import ChartTab
from beamviz.explorer.features.veering import Closeups, Target, same
from beamviz.explorer.features.veering_tab import MicroscopeTab
from beamviz.explorer.jobs import stale
from beamviz.explorer.request import Wanted
from beamviz.explorer.solver_job import Answer
from beamviz.frequency_loci import Event


class Charting:
    """Follows the scene, one step behind it: `follow` hears of a new answer, `draw` shows what
    has been computed since."""

    def __init__(self, pool: Executor, wake: Callable[[], None], over: str, per_rev: bool):
        self.wake, self.over, self.per_rev = wake, over, per_rev
        self.chosen: Event | None = None
        self.charts, self.closeups = Charts(pool, wake), Closeups(pool, wake)
        self.others = Charts(pool, wake)  # of the beam that is compared with
        self.answer: Answer | None = None
        self.other: Wanted | None = None
        self.drawn: tuple = ()

    # What the visitor chooses, from any thread.

    def sweep(self, over: str) -> None:
        """Another axis."""
        if over in SPANS and over != self.over:
            self.over, self.chosen = over, None
            self.wake()

    def take(self, over: str, per_rev: bool) -> None:
        """Axis and per-rev lines of a scene."""
        self.sweep(over)
        self.show_per_rev(per_rev)

    def show_per_rev(self, shown: bool) -> None:
        """Per-rev lines, or none."""
        self.per_rev = bool(shown)
        self.wake()

    def choose(self, number: int) -> tuple[str, float] | None:
        """Take a meeting under the microscope; the number to set and its value there."""
        chart = self.charts.answer
        if chart is None or not 0 <= number < len(chart.events):
            return None
        self.chosen = chart.events[number]
        self.wake()
        return chart.question.over, self.chosen.at

    # What the animator does.

    @property
    def state(self) -> tuple:
        """What the tabs depend on."""
        return (
            self.answer, self.over, self.per_rev, self.chosen,
            self.charts.answer, self.closeups.answer, self.other, self.others.answer,
        )  # fmt: skip

    @property
    def fresh(self) -> bool:
        """Whether something waits to be drawn."""
        return stale(self.drawn, self.state)

    def follow(self, answer: Answer | None, other: Wanted | None) -> None:
        """Ask for the chart around what the scene shows, and for that of the `other` beam on the
        same axis, unless they are there already."""
        self.answer, self.other = answer, other
        if answer is None:
            return
        with contextlib.suppress(InvalidInput):  # the panel says so; the last chart stays
            question = Question.of(answer.wanted, self.over)
            if question != self.charts.wanted:
                self.charts.want(question)
            if other and (second := question.asked_of(other)) != self.others.wanted:
                self.others.want(second)

    def draw(self, loci: ChartTab, microscope: MicroscopeTab) -> None:
        """Show the latest of everything."""
        self.follow(self.answer, self.other)
        chart = self.charts.answer
        if chart is not None and not self.charts.busy:
            self.look_closer(chart)
        self.drawn = self.state
        if chart is None:
            return
        solution = self.answer.solution if self.answer else None
        point = Point.of(solution, chart.question.over) if solution else None
        second = self.others.answer if self.other else None
        loci.show(chart, point, self.per_rev, self.chosen, second)
        closeup = self.closeups.answer if self.chosen else None
        microscope.show(closeup, lost=self.chosen is not None and self.chosen not in chart.events)

    def look_closer(self, chart: Chart) -> None:
        """Keep the chosen meeting under the microscope while the chart changes."""
        if self.chosen is None or chart.loci is None or chart.question.over != self.over:
            return
        question = chart.question
        self.chosen = same(chart.loci, self.chosen, question.stop - question.start) or self.chosen
        target = Target(question, self.chosen)
        if self.chosen in chart.events and target != self.closeups.wanted:
            self.closeups.want(target)

    def close(self) -> None:
        """Nothing more is computed."""
        self.charts.close()
        self.closeups.close()
        self.others.close()
