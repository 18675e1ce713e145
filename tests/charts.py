"""Charts for tests."""

from typing import Any

from beamviz.beam import Beam
from beamviz.show.chart import Chart, Question, computed
from beamviz.show.controls import Wanted

TIP = Beam(alpha=1, beta=1, gamma=3)  # S1 meets B3 at gamma = 4.4641


def charted(beam: Beam, over: str = "gamma", **options: Any) -> Chart:
    """The chart of a beam."""
    question = Question.of(Wanted.of(beam, options), over)
    return Chart(question, computed(question))
