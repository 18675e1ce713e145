"""Many copies of one body in a single node of a scene, and the bodies the scene is made of."""

import numpy as np
import trimesh
from viser import BatchedMeshHandle, SceneApi

from beamviz.server.viser_private import set_properties

HIDDEN = 1e-6  # size of what is not shown


def add_bodies(
    api: SceneApi,
    name: str,
    count: int,
    body: trimesh.Trimesh,
    *,
    flat_shading: bool = True,
    receive_shadow: bool = True,
) -> BatchedMeshHandle:
    """Copies of a body in one node, each with a place, a turn, a size and a colour of its own.

    Such nodes are drawn one frame later than others, so all that move together are of this kind.
    """
    return api.add_batched_meshes_simple(
        name,
        body.vertices,
        body.faces,
        batched_wxyzs=np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)),
        batched_positions=np.zeros((count, 3)),
        batched_scales=np.full((count, 3), HIDDEN),
        batched_colors=np.zeros((count, 3), np.uint8),
        flat_shading=flat_shading,
        receive_shadow=receive_shadow,
        side="double",
        lod="off",
    )


def box() -> trimesh.Trimesh:
    """A unit box."""
    return trimesh.creation.box((1.0, 1.0, 1.0))


def sleeve() -> trimesh.Trimesh:
    """A unit box without its ends, so that in a row of them none peeps out at a bend."""
    whole = box()
    walls = np.abs(whole.face_normals[:, 0]) < 0.5
    return trimesh.Trimesh(whole.vertices, whole.faces[walls], process=False)


def ball() -> trimesh.Trimesh:
    """A sphere of radius 1."""
    return trimesh.creation.icosphere(subdivisions=4)


def put(
    bodies: BatchedMeshHandle,
    centres: np.ndarray,
    wxyz: np.ndarray,
    lengths: np.ndarray,
    paint: np.ndarray,
) -> None:
    """Place copies of a body: where, how turned, how large, in which colours."""
    placed = {
        "batched_positions": centres.astype(np.float32),
        "batched_wxyzs": wxyz.astype(np.float32),
        "batched_scales": lengths.astype(np.float32),
        "batched_colors": paint,
    }
    set_properties(bodies, placed)
