"""Reads scenes from model files (URDF, SDF, MJCF) and mesh files.

Drake draws .obj and .gltf meshes itself; trimesh (extra `meshes`) converts the
other formats. In glTF files, y points up, so these scenes are rotated until z
points up. Scenes of other formats are not rotated.
"""

import importlib.util
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from pydrake.common import MemoryFile
from pydrake.geometry import (
    InMemoryMesh,
    Mesh,
    PerceptionProperties,
    QueryObject,
    Role,
)
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.base.errors import FileError, MissingExtraError
from remosplat_drake.capture.rendering.solids import Solid, painted

MODELS = (".urdf", ".sdf", ".xml")
"""Suffixes of model files that Drake's parser reads, in addition to
`.dmd.yaml`.
"""

DRAWN_MESHES = (".obj", ".gltf")
"""Suffixes of mesh files that Drake draws itself."""
CONVERTED_MESHES = (".glb", ".stl", ".ply", ".dae", ".off")
"""Suffixes of mesh files that trimesh converts."""

_WITH_COLLISION = (".urdf", ".sdf")
_GRAY = (0.75, 0.75, 0.75, 1.0)
_Y_UP = (".glb",)
# From z-up to the y-up of glTF, which Drake converts back.
_X_YZ = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])


def read_solids(
    path: Path, X_WM: RigidTransform | None = None, scale: float = 1.0
) -> tuple[Solid, ...]:
    """Reads the solids of a file, with its joints in their default positions.

    Args:
        path: A model file or a mesh file.
        X_WM: Pose of the file's frame M in W; None: the identity.
        scale: Length of the unit of a mesh file [m]. Model files are in metres,
            and ignore it.

    Raises:
        FileError: The file is missing, unreadable or of an unknown format, or
            contains no visible shape.
        MissingExtraError: The file's meshes need trimesh, which is not
            installed.
    """
    X_WM = X_WM or RigidTransform()
    if not path.is_file():
        raise FileError(path, "no such file")
    suffix = path.suffix.lower()
    if suffix in MODELS or path.name.lower().endswith(".dmd.yaml"):
        solids = tuple(solid.moved(X_WM) for solid in _model_solids(path))
    elif suffix in DRAWN_MESHES + CONVERTED_MESHES:
        solids = (_mesh_solid(X_WM, Mesh(path, scale), painted(_GRAY)),)
    else:
        valid = (*MODELS, ".dmd.yaml", *DRAWN_MESHES, *CONVERTED_MESHES)
        raise FileError(path, f"expected a file of {', '.join(valid)}")
    if not solids:
        raise FileError(path, "has no visual geometry")
    return solids


def _model_solids(path: Path) -> Iterator[Solid]:
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    parser = Parser(plant)
    for folder in path.absolute().parents:
        if (folder / "package.xml").is_file():
            parser.package_map().AddPackageXml(folder / "package.xml")
    try:
        if path.suffix.lower() in _WITH_COLLISION:
            text = _without_collision(path)
            parser.AddModelsFromString(text, path.suffix.lower()[1:])
        else:
            parser.AddModels(path)
        plant.Finalize()
    except (
        RuntimeError,
        ValueError,
        OSError,
        ElementTree.ParseError,
    ) as error:
        raise FileError(path, " ".join(str(error).split())) from error
    context = builder.Build().CreateDefaultContext()
    query = scene_graph.get_query_output_port().Eval(
        scene_graph.GetMyContextFromRoot(context)
    )
    yield from solids_of(query)


def _without_collision(path: Path) -> str:
    """Returns a URDF or SDF without invisible parts, with absolute file names.

    Drake rejects models with collision meshes in formats that it cannot read.
    """
    root = ElementTree.parse(path).getroot()
    for element in list(root.iter()):
        for collision in element.findall("collision"):
            element.remove(collision)
    folder = path.absolute().parent
    for element in root.iter():
        name = element.get("filename") or (element.text or "").strip()
        if element.tag not in ("mesh", "uri") or not (folder / name).exists():
            continue
        if "filename" in element.attrib:
            element.set("filename", f"file://{folder / name}")
        elif name:
            element.text = f"file://{folder / name}"
    return ElementTree.tostring(root, encoding="unicode")


def solids_of(query: QueryObject) -> Iterator[Solid]:
    """Iterates over all visible shapes of a scene graph, posed in W."""
    inspector = query.inspector()
    for geometry in inspector.GetAllGeometryIds(Role.kPerception):
        X_WG = query.GetPoseInWorld(geometry)
        shape = inspector.GetShape(geometry)
        look = inspector.GetPerceptionProperties(geometry)
        if isinstance(shape, Mesh):
            yield _mesh_solid(X_WG, shape, look)
        else:
            yield Solid(X_WG, shape, look)


def _mesh_solid(
    X_WG: RigidTransform, mesh: Mesh, look: PerceptionProperties
) -> Solid:
    mesh = _drawable(mesh)
    # These files contain their own colours.
    if mesh.extension() == ".gltf":
        look = PerceptionProperties()
    return Solid(X_WG, mesh, look)


def _drawable(mesh: Mesh) -> Mesh:
    """The mesh itself, or its conversion for Drake."""
    source = mesh.source()
    if not source.is_path() or _is_drawn(source.path(), mesh):
        return mesh
    if importlib.util.find_spec("trimesh") is None:
        raise MissingExtraError(f"drawing {mesh.extension()} files", "meshes")
    converted = InMemoryMesh(mesh_file=_converted(source.path()))
    return Mesh(converted, mesh.scale3())


def _is_drawn(path: Path, mesh: Mesh) -> bool:
    """Whether Drake draws a mesh file as it is.

    Raises:
        FileError: Drake reads this format, but not this file.
    """
    if mesh.extension() not in DRAWN_MESHES:
        return False
    try:
        mesh.GetConvexHull()
        # Drake's renderer rejects an .obj file without normals.
        return path.suffix.lower() != ".obj" or "\nvn " in path.read_text()
    except (RuntimeError, ValueError) as error:
        raise FileError(path, " ".join(str(error).split())) from error


def _converted(path: Path) -> MemoryFile:
    """Converts a mesh to a .gltf file, or without colours to an .obj file."""
    import trimesh

    try:
        scene = trimesh.load_scene(path)
    except Exception as error:  # Its loaders raise exceptions of any type.
        raise FileError(path, f"unreadable mesh: {error}") from error
    parts = [p for p in scene.dump() if isinstance(p, trimesh.Trimesh)]
    if not any(len(part.faces) for part in parts):
        raise FileError(path, "holds no triangles")
    is_y_up = path.suffix.lower() in _Y_UP
    if not is_y_up and not any(part.visual.defined for part in parts):
        text = trimesh.exchange.obj.export_obj(
            trimesh.util.concatenate(parts), include_normals=True
        )
        return MemoryFile(text, ".obj", path.name)
    if not is_y_up:
        scene.apply_transform(_X_YZ)
    files = trimesh.exchange.gltf.export_gltf(
        scene, include_normals=True, merge_buffers=True, embed_buffers=True
    )
    return MemoryFile(files["model.gltf"].decode(), ".gltf", path.name)
