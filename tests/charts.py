"""Charts for tests."""

from typing import Any

from beamviz.beam import Beam
from beamviz.explorer.features.loci_chart import Chart, Question, computed
from beamviz.explorer.state import Case
from beamviz.scene import Scene

TIP = Beam(alpha=1, beta=1, gamma=3)  # S1 meets B3 at gamma = 4.4641


def charted(beam: Beam, over: str = "gamma", **options: Any) -> Chart:
    """The chart of a beam."""
    question = Question.of(Case.of(Scene(beam, options)), over)
    return Chart(question, computed(question))
