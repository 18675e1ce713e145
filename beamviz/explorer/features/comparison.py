"""The tab Compare: a second beam on the same clock, as an overlay or in a scene above the first.

Modes of both beams are matched by the correlation of their shapes, not by their labels.
"""

import math
from html import escape
from typing import NamedTuple

import numpy as np

from beamviz.drawing import OVERLAY, BeamView
from beamviz.drawing.beam_mesh import DrawnBeam
from beamviz.drawing.camera import ViewChange
from beamviz.drawing.modes import Clock, SampledModes
from beamviz.drawing.objects import Caption
from beamviz.drawing.text import frequencies
from beamviz.explorer import page
from beamviz.explorer.jobs import SolverAnswer
from beamviz.explorer.state import EARLIER, TERMS, Case, State
from beamviz.explorer.visitor import Feature, Visitor
from beamviz.frequency_loci.identity import identify_modes, match_modes
from beamviz.server.viser_private import ViserScene
from beamviz.solver.solution import Solution


class ComparisonCase(NamedTuple):
    """A case to compare the beam with, and its title; without one the title is the reason."""

    title: str = ""
    case: Case | None = None


LABELS = {
    "nothing": "nothing",
    "earlier": "the beam before",
    "ancf": "20 ANCF elements (paper)",
    "coriolis": "Coriolis on / off",
    "mass": "twice the mass",
    "effects": "all effects on",
}
REASONS = {  # why there is no second beam
    "earlier": "No beam is kept yet: press the button below, then change the beam.",
    "coriolis": "Coriolis forces act in the plane of rotation only: switch the plane to chordwise.",
    "mass": "There is no mass to double: give the beam one first.",
    "effects": "All effects are on already.",
}


def comparison_case(state: State, case: Case) -> ComparisonCase:
    """The case that `case` is compared with."""
    options, alpha = case.options, case.numbers["alpha"]
    choice, title, other = state.comparison, LABELS[state.comparison], None
    if choice == EARLIER:
        title, other = "before", state.kept
    elif choice == "ancf" and options["method"] == "ancf":
        title, other = "auto", case.with_options(method="auto")
    elif choice == "ancf":
        title, other = "20 ANCF elements", case.with_options(method="ancf")
    elif choice == "coriolis" and options["plane"] == "chordwise":
        on = not options["coriolis"]
        title, other = f"Coriolis {'on' if on else 'off'}", case.with_options(coriolis=on)
    elif choice == "mass" and alpha:
        other = case.changed("alpha", 2 * alpha)
    elif choice == "effects" and not all(options[term] for term in TERMS):
        title, other = "all effects", case.with_options(**dict.fromkeys(TERMS, True))
    return ComparisonCase(title, other) if other else ComparisonCase(REASONS.get(choice, ""))


# The second beam in the scene

SPACING = 0.5  # of the two scenes, in beam lengths


class Comparison:
    """The second beam: its solution and its drawing.

    case: the one compared with; choices: those drawn; shapes: the modes drawn, None if nothing is;
    views: the objects that draw it, by whether it is stacked, made when needed; view: that shown.
    """

    def __init__(self, visitor: Visitor):
        self.visitor, self.job = visitor, visitor.solve_job()
        self.case = ComparisonCase()
        self.choices: tuple[object, ...] = ()
        self.clock = Clock()
        self.shapes: SampledModes | None = None
        self.views: dict[bool, BeamView] = {}
        self.view: BeamView | None = None

    @property
    def answer(self) -> SolverAnswer | None:
        """The answer to the case; None before it."""
        answer = self.job.answer
        return answer if answer and answer.request == self.case.case else None

    @property
    def heights(self) -> list[float]:
        """Heights [beam lengths] of the first scene and, if they are stacked, of the second."""
        return [-SPACING / 2, SPACING / 2] if self.shapes and self.visitor.state.stacked else [0.0]

    def draw(self, main: DrawnBeam, clock: Clock, *, driven: bool) -> None:
        """Draw the second beam in modes matching `main`; at rest while a force drives `main`."""
        state, answer = self.visitor.state, self.visitor.answer
        if answer:
            self.case = comparison_case(state, answer.request)
            if self.case.case:
                self.job.request(self.case.case)
        choices, second = (state.comparison, state.kept, state.stacked), self.answer
        restarted = choices != self.choices
        lasts = self.case.case and not (restarted or state.view.all_modes)
        if self.shapes and second is None and lasts:
            return  # it stays until the answer, as the first beam
        drawable = second and not (second.warning or state.view.all_modes)
        self.shapes = second.result if second and drawable else None
        for view in self.views.values():
            view.hide()
        if self.shapes is None:
            self.choices = ()
            return
        partner = corresponding(main.shapes, self.shapes)
        if restarted or len(self.clock.phases) != len(partner):
            self.choices = choices
            phases = dict(enumerate(clock.phases))
            self.clock.phases = np.array([phases.get(k, np.pi / 2) for k in partner])
            self.clock.angle = clock.angle
        sizes = 0.0 * partner if driven else np.array([*main.amplitudes, 0.0])[partner]
        if state.stacked not in self.views:
            root, overlay = ("/other", False) if state.stacked else (OVERLAY, True)
            view = BeamView(
                ViserScene(self.visitor.client.scene), root, alone=False, overlay=overlay
            )
            self.views[state.stacked] = view
        self.view = view = self.views[state.stacked]
        view.height = self.heights[-1]
        title = self.case.title
        view.show(DrawnBeam(self.shapes, state.view, main.scale, sizes, title=title))

    @property
    def captions(self) -> list[Caption]:
        return [caption for view in self.views.values() for caption in view.captions]

    def move(self, time: float, change: ViewChange | None) -> None:
        """Advance by `time` [T*]; change: of the view."""
        shapes, view = self.shapes, self.view
        if shapes is None or view is None:
            return
        self.clock.advance(time, shapes.frequencies, shapes.beam.gamma)
        angle = self.clock.angle
        if change:
            angle = change.continued(angle)
            view.choose_frame(change.rotating_share)
        view.move(self.clock.phases, angle)


def corresponding(first: SampledModes, second: SampledModes) -> np.ndarray:
    """The mode of one beam (m,) for each mode of another; -1 where none corresponds."""
    if first.solution is None or second.solution is None:
        return np.full(len(second.modes), -1)
    return match_modes(second.solution, first.solution).partner


# The tab

THIS = "this beam"
INVITATION = (
    "A second beam, drawn with this one, shows the effect of one change. If you drag the mass in"
    " the scene, the beam before the drag is shown as an overlay."
)
CASES = [page.button(name, data_set="comparison", data_value=key) for key, name in LABELS.items()]
TAB = page.group("Compare with", '<span class="soft">Compare with</span>', *CASES)
TAB += page.group(
    "How it is drawn",
    '<span class="soft">Drawn</span>',
    page.button("overlaid", data_set="stacked", data_value=False),
    page.button("one above the other", data_set="stacked", data_value=True),
    '<span class="space"></span>',
    page.button("Keep this beam, then change it", data_do="keep"),
)


class ComparisonTab(Feature):
    """The choice of the second beam, and a table of the frequencies of both beams."""

    def __init__(self, visitor: Visitor, comparison: Comparison):
        super().__init__(visitor)
        self.comparison = comparison
        self.page.html("tab-compare", f'{TAB}<div id="comparison"></div>')
        self.page.on("keep", lambda _: visitor.change(State.keep))

    def show(self) -> None:
        """Show the frequencies of both beams, or a message why there are none."""
        case, answer, second = self.comparison.case, self.visitor.answer, self.comparison.answer
        if not self.redraws(case, answer, second):
            return
        if case.case is None:
            self.page.html("comparison", f"<p>{escape(case.title or INVITATION)}</p>")
        elif second and second.error:
            self.page.html("comparison", f"<p>{escape(f'{case.title}: {second.message}')}</p>")
        elif second and second.solution and answer and answer.solution:
            pair = (THIS, answer.solution), (case.title, second.solution)
            earlier = self.visitor.state.comparison == EARLIER
            self.page.html("comparison", comparison_table(*(pair[::-1] if earlier else pair)))


def comparison_table(first: tuple[str, Solution], second: tuple[str, Solution]) -> str:
    """A table (HTML) of the frequencies of two beams with titles, modes matched by shape."""
    (title, this), (other_title, other) = first, second
    partner = match_modes(this, other).partner
    unit = frequencies(this.beam.units).label
    heads = ("mode", f"{title}, {unit}", f"{other_title}, {unit}", "change")
    rows = [row(this, k, other, int(j)) for k, j in enumerate(partner)]
    rows += [row(this, -1, other, j) for j in range(len(other.labels)) if j not in partner]
    notes = mixture_note(title, this) + mixture_note(other_title, other)
    return page.table("comparison", heads, rows) + notes


def row(this: Solution, k: int, other: Solution, j: int) -> tuple[str, ...]:
    """The row of mode k of a beam and mode j of another; -1 for one that is not solved."""
    pair = (this, k), (other, j)
    labels = dict.fromkeys(identify_modes(solution).labels[i] for solution, i in pair if i >= 0)
    first, second = (
        frequencies(one.beam.units).factor * float(one.frequencies[i]) if i >= 0 else math.nan
        for one, i in pair
    )
    change = 100 * (second / first - 1) if first > 0 else math.nan
    changed = f"{change:+.2g} %".replace("-", "\u2212") if math.isfinite(change) else "–"
    return f"<b>{' → '.join(labels)}</b>", number(first), number(second), changed


def number(frequency: float) -> str:
    """A frequency as text, with six digits; a dash for nan."""
    return f"{frequency:#.6g}".rstrip(".") if math.isfinite(frequency) else "–"


def mixture_note(title: str, solution: Solution) -> str:
    """A note on the modes of a beam that are mixtures."""
    mixed = identify_modes(solution).summary
    return f'<p role="note">In {escape(title)}: {escape(mixed)}.</p>' if mixed else ""
