"""With what a visitor can compare a beam: the same with one thing changed, or an earlier one."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from beamviz.explorer.request import SWITCHES, Wanted

NOTHING, BEFORE = "nothing", "how it was before"


class Against(NamedTuple):
    """Another beam to compare with: what it is called, and what to solve for it."""

    title: str
    wanted: Wanted


def method(wanted: Wanted) -> Against:
    """The paper's elements, or the exact solution where these are chosen already."""
    if wanted.options.get("method", "auto") == "ancf":
        return Against("exact", with_options(wanted, method="auto"))
    return Against("paper's ANCF, 20 elements", with_options(wanted, method="ancf"))


def coriolis(wanted: Wanted) -> Against | str:
    """With Coriolis forces, or without where they are on."""
    if wanted.options["plane"] == "flapwise":
        return "Coriolis forces act in the plane of rotation only: choose chordwise under Model."
    on = not wanted.options.get("coriolis", False)
    return Against(f"Coriolis {'on' if on else 'off'}", with_options(wanted, coriolis=on))


def twice(wanted: Wanted) -> Against | str:
    """Twice the mass."""
    if wanted.numbers["alpha"] == 0:
        return "There is no mass to double: give the beam one first."
    double = replace(wanted, numbers={**wanted.numbers, "alpha": 2 * wanted.numbers["alpha"]})
    return Against("twice the mass", double)


def all_terms(wanted: Wanted) -> Against | str:
    """Every term of the equations."""
    terms = {"stiffening": True, "softening": True, "coriolis": True}
    whole = with_options(wanted, **terms)
    return "All terms are on already." if on(wanted) == on(whole) else Against("all terms", whole)


def on(wanted: Wanted) -> tuple[bool, ...]:
    """Which terms are on."""
    return tuple(wanted.switched_on(name) for name in SWITCHES)


def with_options(wanted: Wanted, **options: object) -> Wanted:
    """The same beam by other keywords of `solve`."""
    return replace(wanted, options={**wanted.options, **options})


RULES: dict[str, Callable[[Wanted], Against | str]] = {
    "the paper's elements": method,
    "Coriolis on / off": coriolis,
    "twice the mass": twice,
    "all terms on": all_terms,
}
CHOICES = (NOTHING, BEFORE, *RULES)


def against(choice: str, wanted: Wanted, kept: Wanted | None) -> Against | str:
    """What to compare a beam with; words where there is nothing ("" where nothing is chosen)."""
    if choice == NOTHING:
        return ""
    if choice != BEFORE:
        return RULES[choice](wanted)
    if kept is None:
        return "Nothing is kept yet: press the button below, then change the beam."
    return Against("before", kept)
