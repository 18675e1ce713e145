"""The second beam, which the first is compared with: what it is, for each choice."""

from typing import NamedTuple

from beamviz.errors import InvalidInput
from beamviz.explorer.state import EARLIER, NO_COMPARISON, TERMS, Case, State
from beamviz.scene import LINKED, Second


class ComparisonCase(NamedTuple):
    """A case to compare the beam with."""

    title: str = ""  # of the second beam; without a case the reason why there is none
    case: Case | None = None
    choice: str = NO_COMPARISON  # that the case follows from


KEEP = "Keep this beam, then change it"  # label of the button
LABELS = {
    "nothing": "nothing",
    "earlier": "the beam before",
    "ancf": "20 ANCF elements (paper)",
    "coriolis": "Coriolis on / off",
    "mass": "twice the mass",
    "effects": "all effects on",
}
REASONS = {  # why there is no second beam
    "earlier": f"No beam is kept yet: press “{KEEP}”.",
    "coriolis": "Coriolis forces act in the plane of rotation only: choose it, or both planes.",
    "mass": "There is no mass to double: give the beam one first.",
    "effects": "All effects are on already.",
}


def comparison_case(state: State, case: Case) -> ComparisonCase:
    """The case that `case` is compared with."""
    options, alpha = case.options, case.numbers["alpha"]
    choice, title, other = state.comparison, LABELS[state.comparison], None
    if choice == EARLIER:
        title, other = "before", state.kept and state.kept.with_options(modes=options["modes"])
    elif choice == "ancf" and options["method"] == "ancf":
        title, other = "auto", case.with_options(method="auto")
    elif choice == "ancf":
        title, other = "20 ANCF elements", case.with_options(method="ancf")
    elif choice == "coriolis" and options["plane"] != "flapwise":
        on = not options["coriolis"]
        title, other = f"Coriolis {'on' if on else 'off'}", case.with_options(coriolis=on)
    elif choice == "mass" and isinstance(alpha, int | float) and alpha:
        other = case.changed("alpha", 2 * alpha)
    elif choice == "effects" and not all(options[term] for term in TERMS):
        title, other = "all effects", case.with_options(**dict.fromkeys(TERMS, True))
    return ComparisonCase(title if other else REASONS.get(choice, ""), other or None, choice)


def second_of(state: State) -> Second | None:
    """The second beam, for scene files and exports; None without one, and where it has a number out
    of range."""
    case = state.case.with_options(modes=state.shown_case.options["modes"])
    title, other, choice = comparison_case(state, case)
    if other is None:
        return None
    names = LINKED["model"]
    given = choice == EARLIER
    options = {k: other.options[k] for k in names if given or other.options[k] != case.options[k]}
    try:
        beam = other.beam if given or other.numbers != case.numbers else None
    except InvalidInput:
        return None
    return Second(beam, options, title, state.stacked, choice)
