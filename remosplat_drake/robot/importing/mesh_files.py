"""Loads mesh files of many formats, as triangles in metres."""

import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from remosplat_drake.base.errors import RemoSplatError

if TYPE_CHECKING:
    import trimesh

MESHES = (".stl", ".dae", ".obj", ".gltf", ".glb", ".ply", ".off")
"""Suffixes of mesh files that can be read."""

_UNIT = re.compile(r"([\d.eE+-]+) \* meters")


def load_mesh(path: Path, scale: np.ndarray) -> "trimesh.Scene":
    """Loads a mesh file in metres; units and axes are as in RViz.

    Args:
        path: The file.
        scale: Factors along its axes, shape (3,).

    Raises:
        RemoSplatError: The file is of another format, is broken, or has no
            triangles.
    """
    import trimesh

    if path.suffix.lower() not in MESHES:
        problem = f"is none of {', '.join(MESHES)}"
        raise RemoSplatError(f"{path} {problem}")
    try:
        scene = trimesh.load_scene(path)
        unit = _UNIT.match(str(scene.units or ""))
        factor = scale * (float(unit[1]) if unit else 1.0)
        parts = [
            part for part in scene.dump() if isinstance(part, trimesh.Trimesh)
        ]
    # The readers of the formats raise different exceptions.
    except Exception as error:
        problem = " ".join(str(error).split()) or type(error).__name__
        raise RemoSplatError(f"{path} cannot be read: {problem}") from error
    parts = [part for part in parts if len(part.faces)]
    if not parts:
        raise RemoSplatError(f"{path} has no triangles")
    for part in parts:
        part.apply_transform(np.diag([*factor, 1.0]))
    return trimesh.Scene(parts)
