"""`GltfBuffer`: stores arrays as the binary part of a glTF document."""

import base64

import numpy as np

FLOAT = 5126
SIGNED = 5122
UNSIGNED = 5123
"""glTF's codes for types of numbers: 32-bit floats, and signed and unsigned
16-bit integers, which represent fractions from -1 or 0 to 1."""

_DTYPES = {FLOAT: "<f4", SIGNED: "<i2", UNSIGNED: "<u2"}
_LARGEST = {SIGNED: 32767, UNSIGNED: 65535}
_ALIGNMENT = 4


class GltfBuffer:
    """A buffer of a glTF document, to which arrays are appended.

    Args:
        number: Index of the buffer in the document.
        first: Index of the buffer's first view and accessor: the number of
            views in the previous buffers.

    Attributes:
        views: glTF's descriptions of the position of each array.
        accessors: glTF's descriptions of the type and shape of each array.
    """

    def __init__(self, number: int = 0, first: int = 0):
        self._number = number
        self._first = first
        self._data = bytearray()
        self.views: list[dict] = []
        self.accessors: list[dict] = []

    def add_shares(self, values: np.ndarray, kind: int) -> int:
        """Adds numbers from 0 to 1, or from -1 to 1, with 16 bits each.

        Args:
            values: The numbers, shape (n, width).
            kind: SIGNED or UNSIGNED.

        Returns:
            The index of the accessor.
        """
        whole = np.rint(np.asarray(values, float) * _LARGEST[kind])
        return self._add(whole.astype(_DTYPES[kind]), kind, normalized=True)

    def add_floats(self, values: np.ndarray) -> int:
        """Adds numbers, shape (n, width); returns the accessor's index."""
        return self._add(np.asarray(values, _DTYPES[FLOAT]), FLOAT)

    def add_indices(self, values: np.ndarray) -> int:
        """Adds indices below 65536, shape (n,); returns the accessor's index.

        Args:
            values: The indices of vertices.
        """
        column = np.asarray(values, _DTYPES[UNSIGNED]).reshape(-1, 1)
        return self._add(column, UNSIGNED)

    def uri(self) -> dict:
        """Returns glTF's description of the buffer, with all of its bytes."""
        text = base64.b64encode(self._data).decode()
        return {
            "byteLength": len(self._data),
            "uri": f"data:application/octet-stream;base64,{text}",
        }

    def _add(self, data: np.ndarray, kind: int, normalized=False) -> int:
        width = data.shape[1]
        self.views.append(
            {
                "buffer": self._number,
                "byteOffset": len(self._data),
                "byteLength": data.nbytes,
            }
        )
        self._data += data.tobytes()
        self._data += bytes(-len(self._data) % _ALIGNMENT)
        self.accessors.append(
            {
                "bufferView": self._first + len(self.views) - 1,
                "componentType": kind,
                "normalized": normalized,
                "count": len(data),
                "type": "SCALAR" if width == 1 else f"VEC{width}",
                "min": data.min(axis=0).tolist(),
                "max": data.max(axis=0).tolist(),
            }
        )
        return self._first + len(self.accessors) - 1
