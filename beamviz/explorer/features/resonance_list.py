"""The list of resonances: where a mode comes back a whole number of times in each turn."""

from collections.abc import Sequence

from beamviz.display_units import Measure
from beamviz.explorer.page.html import SMALL, table
from beamviz.frequency_loci.forced_response import Resonance

MOST = 12  # rows
CAPTION = "Resonances: a force that comes so often in each turn excites the mode"


def resonance_list(found: Sequence[Resonance], along: Measure, across: Measure) -> str:
    """The table of resonances in the units of `along` (speed) and `across` (frequency), the
    fastest ones first: there the modes are told apart best."""
    if not found:
        return f'<div style="{SMALL}">No line 1γ .. 5γ meets a mode here.</div>'
    heads = ("per turn", "mode", f"at {along.head}", across.label)
    rows = [
        (f"{one.per_rev} ×", f"<b>{one.branch}</b>", along.number(one.at, 4),
         across.number(one.frequency, 3))
        for one in reversed(found)
    ]  # fmt: skip
    more = len(rows) - MOST
    shown = table("resonances", heads, rows[:MOST], CAPTION)
    return shown + (
        f'<div style="{SMALL}">and {more} more at lower speeds</div>' if more > 0 else ""
    )
