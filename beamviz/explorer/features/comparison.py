"""The tab Compare: the second beam, which runs on the same clock, and the frequencies of both.

Modes of both beams are matched by the correlation of their shapes, not by their labels.
"""

from html import escape

from beamviz.drawing.comparison import THIS, compared_rows
from beamviz.drawing.text import frequencies
from beamviz.explorer import page
from beamviz.explorer.declarations import Tab
from beamviz.explorer.feature import Feature, waiting_content
from beamviz.explorer.jobs import JobStatus
from beamviz.explorer.page import Content
from beamviz.explorer.second_beam import KEEP, LABELS
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.solutions import SOLUTION, SolverAnswer
from beamviz.explorer.state import EARLIER, State
from beamviz.explorer.visitor import Visitor
from beamviz.frequency_loci.identity import identify_modes
from beamviz.solver.solution import Solution

INVITATION = (
    "A second beam, drawn with this one, shows the effect of one change. If you drag the mass in"
    " the scene, the beam before the drag is shown as an overlay. One above the other, both count"
    " the periods of their mode: which one is ahead?"
)
ALL_SHOWN = "No second beam is drawn beside all modes."
CASES = [page.button(name, data_set="comparison", data_value=key) for key, name in LABELS.items()]
TOOLS = page.group("Compare with", '<span class="soft">Compare with</span>', *CASES)
TOOLS += page.group(
    "How it is drawn",
    '<span class="soft">Drawn</span>',
    page.button("overlaid", data_set="stacked", data_value=False),
    page.button("one above the other", data_set="stacked", data_value=True),
    '<span class="space"></span>',
    page.button(KEEP, data_do="keep"),
)

WAIT = "comparison-wait"  # id of the place for what is computed


class ComparisonTab(Feature):
    """The choice of the second beam, and a table of the frequencies of both beams."""

    tab = Tab(
        "Compare",
        4,
        "A second beam beside the first: another mass, other effects, or the beam before a change",
        f'{TOOLS}{page.waiting_place(WAIT)}<div id="comparison"></div>',
    )

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        self.page.on("keep", lambda _: visitor.change(State.keep))

    def content(self, snapshot: Snapshot) -> Content:
        return table_content(snapshot) | waiting_content(WAIT, missing(snapshot))


def missing(snapshot: Snapshot) -> JobStatus | None:
    """The job that solves the second beam, while there is none yet."""
    lacks = snapshot.comparison.case is not None and snapshot.second is None
    return snapshot.jobs[SOLUTION] if lacks else None


def table_content(snapshot: Snapshot) -> Content:
    """The frequencies of both beams, or a message why there are none."""
    answer, second, (title, case, choice) = snapshot.answer, snapshot.second, snapshot.comparison
    text = f"<p>{escape(title or INVITATION)}</p>" if case is None else ""
    failed = [
        f"{name}: {one.message}"
        for name, one in ((THIS.capitalize(), answer), (title, second))
        if second and one and one.error
    ]
    if failed:
        text = "".join(f"<p>{escape(reason)}</p>" for reason in failed)
    elif second and second.solution and answer and answer.solution:
        pair = (THIS, answer.solution), (title, second.solution)
        table = comparison_table(*(pair[::-1] if choice == EARLIER else pair))
        reason = not_drawn(second, all_modes=snapshot.state.view.all_modes)
        text = page.note(reason) + table
    return page.html("comparison", text)


def not_drawn(second: SolverAnswer, *, all_modes: bool) -> str:
    """Why a second beam is not in the scene; "" if it is."""
    if all_modes and second.solution:
        return ALL_SHOWN
    warning = second.warning.replace("\n", ", ")
    return f"Not drawn: {warning}" if warning else ""


def comparison_table(first: tuple[str, Solution], second: tuple[str, Solution]) -> str:
    """A table (HTML) of the frequencies of two beams with titles, modes matched by shape."""
    (title, this), (other_title, other) = first, second
    unit = frequencies(this.beam.units).label
    heads = ("mode", f"{title}, {unit}", f"{other_title}, {unit}", "change")
    rows = [(f"<b>{name}</b>", *cells) for name, *cells in compared_rows(this, other)]
    notes = mixture_note(title, this) + mixture_note(other_title, other)
    return page.table("comparison", heads, rows) + notes


def mixture_note(title: str, solution: Solution) -> str:
    """A note on the modes of a beam that are mixtures."""
    mixed = identify_modes(solution).summary
    return f'<p role="note">In {escape(title)}: {escape(mixed)}.</p>' if mixed else ""
