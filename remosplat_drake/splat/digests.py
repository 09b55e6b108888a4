"""Digests of a splat's arrays, by which results are known again."""

import hashlib
from collections.abc import Mapping

import numpy as np

_SHAPES = ("p_GK", "quaternions", "scales", "opacities")
"""The arrays that the digests of all and of the shapes begin with."""


def digests(arrays: Mapping[str, np.ndarray]) -> tuple[str, str]:
    """Computes the SHA-256 digests of all arrays, and of all but the colours.

    Args:
        arrays: The arrays of a `GaussianSplat`, by attribute name.

    Returns:
        Both digests in hexadecimal.
    """
    shapes = hashlib.sha256()
    for name in _SHAPES:
        _update(shapes, arrays[name])
    everything = shapes.copy()
    for name in ("colors", "sh_rest"):
        _update(everything, arrays[name])
    uncertainty = arrays.get("uncertainty")
    if uncertainty is not None:
        for digest in (shapes, everything):
            _update(digest, uncertainty)
    kind = f"{arrays['scales'].shape} {uncertainty is not None}"
    shapes.update(kind.encode())
    return everything.hexdigest(), shapes.hexdigest()


def _update(digest: "hashlib._Hash", array: np.ndarray) -> None:
    digest.update(array.data if array.size else b"")
