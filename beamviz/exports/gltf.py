"""A small writer of binary glTF 2.0: arrays into a buffer, their descriptions into JSON."""

import json
import struct
from typing import Any

import numpy as np

FLOAT, UNSIGNED = 5126, 5125
VERTICES, INDICES = 34962, 34963
KINDS = {(): "SCALAR", (3,): "VEC3", (4,): "VEC4"}
MAGIC, VERSION, JSON_CHUNK, BINARY_CHUNK = 0x46546C67, 2, 0x4E4F534A, 0x004E4942


class Gltf:
    """A glTF asset in the making; each `add` returns an index that others refer to."""

    def __init__(self, generator: str):
        self.data: dict[str, Any] = {"asset": {"version": "2.0", "generator": generator}}
        self.binary = bytearray()

    def add(self, what: str, entry: dict[str, Any]) -> int:
        """Another node, mesh, material ..."""
        entries = self.data.setdefault(what, [])
        entries.append(entry)
        return len(entries) - 1

    def array(self, values: np.ndarray, target: int | None = None) -> int:
        """An accessor of floats (n,) or (n, 3 or 4), or of indices (n,); `target` says for what."""
        whole = np.issubdtype(values.dtype, np.integer)
        values = np.ascontiguousarray(values, np.uint32 if whole else np.float32)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": values.nbytes}
        self.binary += values.tobytes()  # four bytes a number: always aligned
        entry = {
            "bufferView": self.add("bufferViews", view | ({"target": target} if target else {})),
            "componentType": UNSIGNED if whole else FLOAT,
            "count": len(values),
            "type": KINDS[values.shape[1:]],
            "min": np.atleast_1d(values.min(axis=0)).tolist(),
            "max": np.atleast_1d(values.max(axis=0)).tolist(),
        }
        return self.add("accessors", entry)

    def encoded(self) -> bytes:
        """The .glb file."""
        self.data["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.data, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        chunks = b"".join(
            struct.pack("<II", len(part), kind) + part
            for part, kind in ((text, JSON_CHUNK), (bytes(self.binary), BINARY_CHUNK))
        )
        return struct.pack("<III", MAGIC, VERSION, 12 + len(chunks)) + chunks
