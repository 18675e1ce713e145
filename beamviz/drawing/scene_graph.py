"""What a beam is drawn into: nodes by name with their properties.

`SceneGraph` keeps them for pictures and models. A page has the scene of viser instead
(`beamviz.server.viser_private.ViserScene`), whose methods and properties have the same names.
"""

from collections.abc import Callable, Iterable
from types import SimpleNamespace
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Node = Any  # of a SceneGraph or of viser: properties as attributes


class DrawnScene(Protocol):
    """A scene that a beam can be drawn into. Names of nodes are paths, as /scene/rotor/beam.

    add_mesh_simple: a surface of one colour; add_batched_meshes_simple: instances of one, each with
    its orientation, position, size and colour. set_properties, set_pose: change several properties
    of a node at once; its position (3,), its orientation wxyz (4,) or both.
    """

    @property
    def add_frame(self) -> Callable[..., Node]: ...
    @property
    def add_mesh_simple(self) -> Callable[..., Node]: ...
    @property
    def add_batched_meshes_simple(self) -> Callable[..., Node]: ...
    @property
    def add_cylinder(self) -> Callable[..., Node]: ...
    @property
    def add_line_segments(self) -> Callable[..., Node]: ...
    @property
    def add_light_hemisphere(self) -> Callable[..., Node]: ...
    @property
    def add_light_directional(self) -> Callable[..., Node]: ...
    @property
    def configure_environment_map(self) -> Callable[..., None]: ...
    @property
    def configure_default_lights(self) -> Callable[..., None]: ...
    @property
    def set_properties(self) -> Callable[..., None]: ...
    @property
    def set_pose(self) -> Callable[..., None]: ...


Kind = Literal["frame", "mesh", "instances", "cylinder", "lines", "light"]


class PlacedNode(NamedTuple):
    """A node; its points are at rotation (3, 3) @ point + position (3,) in the scene."""

    node: Node
    rotation: NDArray
    position: NDArray


class SceneGraph:
    """The nodes of a scene that no page shows."""

    def __init__(self) -> None:
        self.nodes: dict[str, Node] = {}  # by name, parents first

    def _add(self, kind: Kind, name: str, **properties: Any) -> Node:
        usual = {
            "visible": True,
            "position": np.zeros(3),
            "wxyz": np.array([1.0, 0.0, 0.0, 0.0]),
            "opacity": None,
            "side": "front",
            "cast_shadow": True,
            "receive_shadow": True,
        }
        self.nodes[name] = SimpleNamespace(**{**usual, "name": name, "kind": kind, **properties})
        return self.nodes[name]

    def add_frame(self, name: str, **properties: Any) -> Node:
        """A frame of reference for the nodes below it."""
        return self._add("frame", name, **properties)

    def add_mesh_simple(
        self, name: str, vertices: NDArray, faces: NDArray, **properties: Any
    ) -> Node:
        """A surface of one colour: vertices (v, 3) and triangles (t, 3)."""
        return self._add("mesh", name, vertices=vertices, faces=faces, **properties)

    def add_batched_meshes_simple(
        self,
        name: str,
        vertices: NDArray,
        faces: NDArray,
        batched_wxyzs: NDArray,
        batched_positions: NDArray,
        **properties: Any,
    ) -> Node:
        """Instances of a surface, with orientations (n, 4) and positions (n, 3)."""
        placed = {"batched_wxyzs": batched_wxyzs, "batched_positions": batched_positions}
        return self._add("instances", name, vertices=vertices, faces=faces, **placed, **properties)

    def add_cylinder(self, name: str, radius: float, height: float, **properties: Any) -> Node:
        """A cylinder along z, its middle at the origin of its node."""
        return self._add("cylinder", name, radius=radius, height=height, **properties)

    def add_line_segments(self, name: str, points: NDArray, colors: Any, **properties: Any) -> Node:
        """Lines (n, 2, 3) of one colour."""
        return self._add("lines", name, points=points, colors=colors, **properties)

    def add_light_hemisphere(self, name: str, **properties: Any) -> Node:
        """Light from above and below."""
        return self._add("light", name, **properties)

    def add_light_directional(self, name: str, **properties: Any) -> Node:
        """Light from one direction."""
        return self._add("light", name, **properties)

    def configure_environment_map(self, hdri: None) -> None:
        """There is none."""

    def configure_default_lights(self, enabled: bool) -> None:
        """There are none."""

    def set_properties(self, node: Node, **properties: NDArray) -> None:
        """Set properties of a node."""
        for name, value in properties.items():
            setattr(node, name, value)

    def set_pose(self, node: Node, **pose: Iterable[float]) -> None:
        """Set the position (3,) of a node, its orientation wxyz (4,) or both."""
        self.set_properties(node, **{k: np.array([*value], float) for k, value in pose.items()})

    def visible(self) -> list[PlacedNode]:
        """The nodes that a page would show, parents first."""
        placed = {"": PlacedNode(None, np.eye(3), np.zeros(3))}
        for name, node in self.nodes.items():
            parent = placed.get(name.rpartition("/")[0])
            if parent and node.visible:
                rotation = parent.rotation @ rotations(np.asarray(node.wxyz, float))
                position = parent.rotation @ np.asarray(node.position, float) + parent.position
                placed[name] = PlacedNode(node, rotation, position)
        del placed[""]
        return [*placed.values()]


def rotations(wxyz: NDArray) -> NDArray:
    """The matrices (..., 3, 3) of unit quaternions (..., 4)."""
    w, x, y, z = np.moveaxis(wxyz, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))
