"""Samples the surfaces of a model file's links, to cover them with spheres."""

import dataclasses as dc
from pathlib import Path

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.parsing import (
    LoadModelDirectives,
    Parser,
    ProcessModelDirectives,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, Joint, RigidBody

from remosplat_drake.base import resources
from remosplat_drake.base.errors import (
    FileError,
    MissingExtraError,
    RemoSplatError,
    unknown_name,
)
from remosplat_drake.robot.fitting.link_surface import (
    collision_surface,
    sample_triangles,
)
from remosplat_drake.robot.fitting.solid_grid import join_solids
from remosplat_drake.robot.fitting.sphere_fitting import (
    POINTS_PER_VOXEL,
    LinkSurface,
    make_link_surface,
    voxel_pitch,
)
from remosplat_drake.robot.meshes import source_mesh
from remosplat_drake.robot.model_file import in_one_line
from remosplat_drake.robot.visuals import LinkVisual, load_visuals

# Number of joint positions at which a neighbour is examined.
_POSITIONS = 9


@dc.dataclass(frozen=True)
class SurfaceOptions:
    """Selection of a model's surfaces that spheres must enclose.

    Attributes:
        links: Names of the links; empty means all that have geometry.
        visuals: A `visuals.yaml` whose meshes replace the collision shapes of
            the links it names, or None.
        with_collision: Links that keep their collision shapes in addition to
            the meshes.
        floor_links: Links that stand on the floor, the plane z = 0.
        weights: Weight of each link (default 1). With a larger weight, the
            link's spheres protrude less.
    """

    links: tuple[str, ...] = ()
    visuals: Path | None = None
    with_collision: tuple[str, ...] = ()
    floor_links: tuple[str, ...] = ()
    weights: dict[str, float] = dc.field(default_factory=dict)


def model_surfaces(
    model: Path, options: SurfaceOptions, seed: int = 0
) -> dict[str, LinkSurface]:
    """Samples the surfaces of a model file's links, and fills their volumes.

    Args:
        model: URDF, SDF or *.dmd.yaml; link names must be unique in it.
        options: Selection of the surfaces.
        seed: Seed of the random points.

    Raises:
        RemoSplatError: The model cannot be read, a link is unknown or has no
            geometry, or the meshes are wanted but not installed.
    """
    points, plant = _sampled(model, options, seed)
    surfaces = {
        link: make_link_surface(
            p_LP, options.weights.get(link, 1.0), link in options.floor_links
        )
        for link, p_LP in points.items()
    }
    return {link: _with_neighbours(link, surfaces, plant) for link in surfaces}


def surface_points(
    model: Path, options: SurfaceOptions, seed: int = 0
) -> dict[str, np.ndarray]:
    """Samples the surfaces of the links of a model file, as points alone.

    Args:
        model: URDF, SDF or *.dmd.yaml; link names must be unique in it.
        options: Selection of the surfaces.
        seed: Seed of the random points.

    Returns:
        Points in the link's frame, shape (n, 3) [m], by link name.

    Raises:
        RemoSplatError: As `model_surfaces`.
    """
    return _sampled(model, options, seed)[0]


def _sampled(
    model: Path, options: SurfaceOptions, seed: int
) -> tuple[dict[str, np.ndarray], MultibodyPlant]:
    scene_graph = SceneGraph()
    plant = load_model(model, scene_graph)
    bodies = [
        plant.get_body(BodyIndex(i)).name() for i in range(plant.num_bodies())
    ]
    named = [*options.links, *options.with_collision, *options.weights]
    for link in [*named, *options.floor_links]:
        if link not in bodies:
            raise RemoSplatError(
                f"{model}: " + unknown_name("link", link, bodies)
            )
    visuals = load_visuals(options.visuals) if options.visuals else {}
    rng = np.random.default_rng(seed)
    points = {}
    for link in options.links or bodies:
        parts = [_mesh_points(visuals[link], rng)] if link in visuals else []
        if not parts or link in options.with_collision:
            parts.append(_shape_points(plant, scene_graph, link, rng))
        p_LP = np.vstack(parts)
        if len(p_LP) or link in options.links:
            points[link] = p_LP
    if not points:
        raise FileError(model, "has no collision geometry")
    return points, plant


def _with_neighbours(
    link: str, surfaces: dict[str, LinkSurface], plant: MultibodyPlant
) -> LinkSurface:
    """Adds the parts of neighbours that are always inside the link."""
    neighbours = []
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        ends = [joint.parent_body(), joint.child_body()]
        names = [body.name() for body in ends]
        if link in names and set(names) <= surfaces.keys():
            L, N = ends if names[0] == link else ends[::-1]
            poses = _relative_poses(plant, joint, L, N)
            neighbours.append((surfaces[N.name()].solid, poses))
    if not neighbours:
        return surfaces[link]
    solid = join_solids(surfaces[link].solid, neighbours)
    return dc.replace(surfaces[link], solid=solid)


def _relative_poses(
    plant: MultibodyPlant, joint: Joint, L: RigidBody, N: RigidBody
) -> list[np.ndarray]:
    """Returns poses X_LN, 4x4, at positions spread over the joint's range."""
    context = plant.CreateDefaultContext()
    if joint.num_positions() != 1:
        ranges = [None]
    else:
        lower = max(joint.position_lower_limits()[0], -np.pi)
        upper = min(joint.position_upper_limits()[0], np.pi)
        ranges = np.linspace(lower, upper, _POSITIONS)
    poses = []
    for position in ranges:
        if position is not None:
            q = plant.GetPositions(context)
            q[joint.position_start()] = position
            plant.SetPositions(context, q)
        X_LN = plant.CalcRelativeTransform(
            context, L.body_frame(), N.body_frame()
        )
        poses.append(X_LN.GetAsMatrix4())
    return poses


def load_model(model: Path, scene_graph: SceneGraph) -> MultibodyPlant:
    """Reads a model file, with its geometry, into a finalized plant.

    Args:
        model: URDF, SDF or *.dmd.yaml.
        scene_graph: A scene graph that gets the geometry.

    Raises:
        FileError: Drake cannot read it.
    """
    plant = MultibodyPlant(time_step=0.0)
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    parser = Parser(plant)
    parser.package_map().Add(
        "remosplat_drake", str(resources.models_dir().parent)
    )
    try:
        if model.name.endswith(".dmd.yaml"):
            ProcessModelDirectives(LoadModelDirectives(str(model)), parser)
        else:
            parser.AddModels(str(model))
    # Drake aborts in C++; from Python, this raises SystemExit.
    except (RuntimeError, ValueError, SystemExit) as error:
        raise FileError(model, in_one_line(error)) from error
    plant.Finalize()
    return plant


def mesh_triangles(visuals: list[LinkVisual]) -> np.ndarray:
    """Loads the visual meshes of a link as triangles in its frame.

    Returns:
        Corners, shape (t, 3, 3) [m].

    Raises:
        MissingExtraError: The meshes are not installed (extra `meshes`).
    """
    parts = []
    for visual in visuals:
        vertices, faces = _mesh(visual)
        parts.append((visual.X_LV @ vertices.T).T[faces])
    return np.concatenate(parts)


def _mesh(visual: LinkVisual) -> tuple[np.ndarray, np.ndarray]:
    mesh = source_mesh(visual.mesh)
    if mesh is None:
        raise MissingExtraError(f"the mesh {visual.mesh}", "meshes")
    return np.array(mesh.vertices), np.array(mesh.faces)


def _mesh_points(
    visuals: list[LinkVisual], rng: np.random.Generator
) -> np.ndarray:
    parts = []
    for visual in visuals:
        vertices, faces = _mesh(visual)
        spacing = voxel_pitch(np.ptp(vertices, axis=0)) / POINTS_PER_VOXEL
        p_VP = sample_triangles(vertices, faces, spacing, rng)
        parts.append((visual.X_LV @ p_VP.T).T)
    return np.vstack(parts)


def _shape_points(
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    link: str,
    rng: np.random.Generator,
) -> np.ndarray:
    inspector = scene_graph.model_inspector()
    coarse = collision_surface(plant, inspector, link, np.inf, rng)
    if len(coarse) == 0:
        return coarse
    spacing = voxel_pitch(np.ptp(coarse, axis=0)) / POINTS_PER_VOXEL
    return collision_surface(plant, inspector, link, spacing, rng)
