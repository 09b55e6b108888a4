"""Converts visual meshes of the package rtb-data for Drake.

Drake draws .gltf and .obj files; the meshes of the Robotics Toolbox are .dae
and .stl files of up to 16 MB. The first use converts them into the user's cache
directory (a few seconds, offline); later uses read the cache. Without the
`meshes` extra and without the cache there are no meshes, and callers draw
collision primitives instead.
"""

import base64
import dataclasses as dc
import importlib.util
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from pydrake.geometry import GeometryInstance, Mesh
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.base import resources
from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.colors import linear_rgb
from remosplat_drake.robot.visuals import load_visuals

if TYPE_CHECKING:
    import trimesh

# Version of the conversion. Increase it with each change, so that earlier cache
# files are not used.
_VERSION = 3
_MAX_FACES = 32_000
_SMOOTHING_ANGLE = np.deg2rad(30)
# Pure white would show no shading.
_WHITE = 0.93
# Rounding steps of positions [m] and of unit vectors, finer than visible
# details.
_POSITION_STEP, _NORMAL_STEP = 2.0**-16, 2.0**-8
_EXTRA = ("rtbdata", "trimesh", "collada", "fast_simplification", "PIL")

# glTF is y-up, the meshes are z-up; Drake turns glTF files back.
_R_YZ = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])


@dc.dataclass(frozen=True)
class LinkMesh:
    """A mesh file V that Drake can draw, fixed to a link L.

    Attributes:
        path: A .gltf file, which carries its own colours.
        X_LV: Pose of the mesh in its link.
        colour: Red, green, blue and alpha in [0, 1], for viewers without glTF
            materials.
    """

    path: Path
    X_LV: RigidTransform
    colour: tuple[float, ...]


def link_meshes(visuals: Path) -> dict[str, list[LinkMesh]]:
    """Lists the visual meshes of each link; converts uncached meshes.

    Args:
        visuals: The `visuals.yaml` of a robot.

    Returns:
        The meshes by link name; links without a usable mesh are absent. Empty
        without the `meshes` extra and without a cache.

    Raises:
        RemoSplatError: `visuals` is unusable.
    """
    meshes = {}
    for link, entries in load_visuals(visuals).items():
        found = [
            LinkMesh(path, entry.X_LV, tuple(entry.colour))
            for entry in entries
            if (path := _cached(entry.mesh)) is not None
        ]
        if found:
            meshes[link] = found
    return meshes


def register_link_meshes(
    meshes: dict[str, list[LinkMesh]], plant: MultibodyPlant
):
    """Registers visual meshes with a plant's links, for viewers and cameras.

    Args:
        meshes: The meshes by link name, from `link_meshes`.
        plant: A plant that is not yet finalized; its link names must be unique.
    """
    for link, entries in meshes.items():
        body = plant.GetBodyByName(link)
        for i, mesh in enumerate(entries):
            # No colour is set, since the file contains a colour.
            plant.RegisterVisualGeometry(
                body,
                GeometryInstance(
                    mesh.X_LV, Mesh(str(mesh.path)), f"{link}_mesh{i}"
                ),
            )


def source_mesh(mesh: str) -> "trimesh.Trimesh | None":
    """Loads an unconverted mesh of the rtb-data package [m].

    Args:
        mesh: Path inside the rtb-data package.

    Returns:
        The mesh; None without the `meshes` extra.
    """
    path = _source_path(mesh)
    return None if path is None else _load_scene(path).to_geometry()


def _cached(mesh: str) -> Path | None:
    name = mesh.removesuffix(Path(mesh).suffix).replace("/", "-")
    path = resources.cache_dir() / "meshes" / f"v{_VERSION}" / f"{name}.gltf"
    if path.is_file():
        return path
    source = _source_path(mesh)
    if source is None:
        return None
    write_atomically(path, drawable(_load_scene(source)))
    return path


def _source_path(mesh: str) -> Path | None:
    if any(importlib.util.find_spec(name) is None for name in _EXTRA):
        return None
    spec = importlib.util.find_spec("rtbdata")
    assert spec is not None and spec.submodule_search_locations is not None
    path = Path(next(iter(spec.submodule_search_locations))) / mesh
    return path if path.is_file() else None


def _load_scene(path: Path) -> "trimesh.Scene":
    import trimesh

    return trimesh.load_scene(path)


def drawable(
    scene: "trimesh.Scene", colour: Sequence[float] | None = None
) -> bytes:
    """Makes a .gltf that Drake draws, smooth-shaded, with few triangles.

    Args:
        scene: Meshes with z up [m].
        colour: Red, green, blue and alpha in [0, 1] of all of it; None keeps
            the meshes' own colours.
    """
    import trimesh

    parts = _by_colour(scene)
    if colour is not None:
        whole = trimesh.util.concatenate(list(parts.values()))
        parts = {tuple(255 * value for value in colour): whole}
    total = sum(len(part.faces) for part in parts.values())
    scene = trimesh.Scene()
    for colour, part in parts.items():
        part.merge_vertices(merge_tex=True, merge_norm=True)
        if total > _MAX_FACES:
            share = round(_MAX_FACES * len(part.faces) / total)
            part = part.simplify_quadric_decimation(
                face_count=max(share, 12), aggression=3
            )
        part = trimesh.graph.smooth_shade(part, angle=_SMOOTHING_ANGLE)
        part.apply_transform(_R_YZ)
        part.visual = trimesh.visual.TextureVisuals(
            material=trimesh.visual.material.PBRMaterial(
                baseColorFactor=_linear(colour),
                metallicFactor=0.1,
                roughnessFactor=0.6,
            )
        )
        scene.add_geometry(part)
    files = trimesh.exchange.gltf.export_gltf(
        scene, include_normals=True, merge_buffers=True, embed_buffers=True
    )
    return rounded(files["model.gltf"])


def rounded(document: bytes) -> bytes:
    """Rounds positions and normals of a .gltf, so that it can be compressed.

    Args:
        document: A .gltf whose only buffer is part of it.
    """
    gltf = json.loads(document)
    (buffer,) = gltf["buffers"]
    head, text = buffer["uri"].split(",")
    data = bytearray(base64.b64decode(text))
    steps = {"POSITION": _POSITION_STEP, "NORMAL": _NORMAL_STEP}
    chosen = {
        primitive["attributes"][name]: step
        for mesh in gltf["meshes"]
        for primitive in mesh["primitives"]
        for name, step in steps.items()
        if name in primitive["attributes"]
    }
    for index, step in chosen.items():
        accessor = gltf["accessors"][index]
        view = gltf["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        values = np.frombuffer(data, "<f4", 3 * accessor["count"], start)
        values[:] = step * np.rint(values / step)
    buffer["uri"] = f"{head},{base64.b64encode(data).decode()}"
    return json.dumps(gltf).encode()


def _linear(colour: tuple) -> list[float]:
    """Converts a display colour in 0..255 to glTF's linear one; keeps alpha."""
    rgba = np.array(colour) / 255
    rgba[:3] = linear_rgb(_WHITE * rgba[:3])
    return rgba.tolist()


def _by_colour(scene: "trimesh.Scene") -> dict[tuple, "trimesh.Trimesh"]:
    """Returns the scene's meshes in its frame, joined if colours are equal."""
    import trimesh

    groups: dict[tuple, list[trimesh.Trimesh]] = {}
    for part in scene.dump():
        if not isinstance(part, trimesh.Trimesh):
            continue  # Skips stray edges of the drawing.
        material = getattr(part.visual, "material", part.visual)
        colour = tuple(int(x) for x in material.main_color)
        bare = trimesh.Trimesh(part.vertices, part.faces, process=False)
        groups.setdefault(colour, []).append(bare)
    return {
        colour: trimesh.util.concatenate(parts)
        for colour, parts in groups.items()
    }
