"""Tables in markdown."""

from collections.abc import Sequence


def lines(heading: Sequence[str], body: Sequence[Sequence[str]]) -> list[str]:
    """The lines of a table."""
    return ["| " + " | ".join(row) + " |" for row in (heading, ["---"] * len(heading), *body)]
