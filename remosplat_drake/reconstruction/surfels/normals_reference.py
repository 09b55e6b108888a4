"""Readable reference of `normals.depth_normals`."""

import numpy as np

from remosplat_drake.capture.capture import back_project
from remosplat_drake.reconstruction.surfels.normals import MAX_BEND, REACHES


def depth_normals_reference(K: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """Computes unit normals from a depth image, as `depth_normals` does."""
    p_C = back_project(K, depth, np.eye(4))
    normal = np.full(p_C.shape, np.nan)
    for reach in REACHES:
        spanned = _spanned_normals(p_C, reach)
        normal = np.where(np.isfinite(normal), normal, spanned)
    return normal


def _spanned_normals(p_C: np.ndarray, reach: int) -> np.ndarray:
    """Normals from the pixels `reach` away; NaN where they span an edge."""
    r = reach
    center = p_C[r:-r, r:-r]
    right, left = p_C[r:-r, 2 * r :], p_C[r:-r, : -2 * r]
    below, above = p_C[2 * r :, r:-r], p_C[: -2 * r, r:-r]
    smooth = np.ones(center.shape[:2], bool)
    for ahead, behind in ((right, left), (below, above)):
        bend = np.linalg.norm(ahead + behind - 2 * center, axis=-1)
        step = np.linalg.norm(ahead - behind, axis=-1)
        smooth &= bend < MAX_BEND * step
    inner = np.cross(below - above, right - left)
    towards_camera = np.sign(-(inner * center).sum(axis=-1, keepdims=True))
    unit = inner / np.linalg.norm(inner, axis=-1, keepdims=True)
    normal = np.full(p_C.shape, np.nan)
    normal[r:-r, r:-r] = np.where(
        smooth[..., None], unit * towards_camera, np.nan
    )
    return normal
