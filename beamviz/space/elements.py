"""The elements of a mesh: where they end, and their orders."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple


class SpanElements(NamedTuple):
    """The elements of a span, or of several that follow each other."""

    ends: tuple[float, ...]  # where each element ends, as a fraction of the span: the last is 1
    orders: tuple[int, ...]  # of modes across the beam: the numbers of Gauss points
    axial_orders: tuple[int, ...]  # of modes along it, at most as high
    spans: int = 1  # how many spans they have in common


class Elements(NamedTuple):
    """The elements of a mesh, as arguments of `make_mesh`."""

    breaks: tuple[float, ...]
    orders: tuple[int, ...]
    axial_orders: tuple[int, ...]

    @property
    def all_orders(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """The orders across the beam and along it: meshes with the same ones form a stack."""
        return self.orders, self.axial_orders

    @property
    def halved(self) -> "Elements":
        """Elements of half the length and the same orders."""
        middles = [(start + end) / 2 for start, end in pairwise(self.breaks)]
        orders, axial_orders = (
            tuple(order for order in row for _ in range(2)) for row in self.all_orders
        )
        return Elements(tuple(sorted((*self.breaks, *middles))), orders, axial_orders)


def joined_elements(ends: Sequence[float], spans: Sequence[SpanElements]) -> Elements:
    """The elements of a beam from those of each span between `ends`."""
    breaks, last = [0.0], 0
    for span in spans:
        start = ends[last]
        last += span.spans
        end = ends[last]
        breaks += [start + (end - start) * fraction for fraction in span.ends[:-1]] + [end]
    orders = tuple(order for span in spans for order in span.orders)
    axial_orders = tuple(order for span in spans for order in span.axial_orders)
    return Elements(tuple(breaks), orders, axial_orders)
