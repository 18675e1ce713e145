"""The list of resonances: where a mode comes back a whole number of times in each turn."""

from collections.abc import Sequence

from beamviz.show.measures import Measure
from beamviz.study.resonances import Resonance

MOST = 12  # rows
SMALL = "font-size:.8em;line-height:1.5;margin:.2em .75em .3em"


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
    return (
        '<table aria-label="resonances" style="width:calc(100% - 1.5em);margin:.4em .75em .2em;'
        "border-collapse:collapse;font-size:.8em;font-variant-numeric:tabular-nums;"
        'line-height:1.6;text-align:right"><caption style="text-align:left;opacity:.8">'
        "Resonances: a force that comes so often in each turn excites the mode</caption>"
        + line(heads, "th", "opacity:.65;font-weight:500")
        + "".join(line(row, "td", "") for row in rows[:MOST])
        + "</table>"
        + (f'<div style="{SMALL}">and {more} more at lower speeds</div>' if more > 0 else "")
    )


def line(cells: Sequence[str], tag: str, style: str) -> str:
    """One row of the table."""
    return (
        f'<tr style="{style}">'
        + "".join(f'<{tag} style="font-weight:inherit">{cell}</{tag}>' for cell in cells)
        + "</tr>"
    )
