"""Functions of upper layers that methods of results call: results are below them and import nothing
from above. The package itself sets them (`beamviz/__init__.py`)."""

TYPE_CHECKING = False  # as in `beamviz/__init__.py`
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

show: "Callable[..., Any]"  # `beamviz.show`: opens the live page of a result
