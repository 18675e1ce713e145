"""Small text and small tables of the panels, as HTML."""

from collections.abc import Collection, Iterable, Sequence

SMALL = "font-size:.8em;line-height:1.5;margin:.2em .75em .3em"
HEAD = "font-weight:500;vertical-align:bottom"
MARKED = "background:rgba(204,60,140,.14)"


def table(
    name: str,
    heads: Sequence[str],
    rows: Iterable[Sequence[object]],
    caption: str = "",
    marked: Collection[int] = (),
) -> str:
    """A table of numbers, called `name` for those who hear the page; rows (from 0) may be
    marked."""
    title = f'<caption style="text-align:left;opacity:.8">{caption}</caption>' if caption else ""
    return (
        f'<table aria-label="{name}" style="width:calc(100% - 1.5em);margin:.2em .75em .4em;'
        "border-collapse:collapse;font-size:.8em;font-variant-numeric:tabular-nums;"
        f'line-height:1.6;text-align:right">{title}<tr style="opacity:.65;line-height:1.3">'
        + "".join(f'<th style="{HEAD}">{head}</th>' for head in heads)
        + "</tr>"
        + "".join(line(cells, k in marked) for k, cells in enumerate(rows))
        + "</table>"
    )


def line(cells: Sequence[object], marked: bool) -> str:
    """A row of a table."""
    style = f' style="{MARKED}"' if marked else ""
    return f"<tr{style}>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"
