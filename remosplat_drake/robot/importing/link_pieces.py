"""Fits convex pieces to the meshes of an imported robot."""

from collections.abc import Callable, Mapping

import numpy as np

from remosplat_drake.base.directions import spread_directions
from remosplat_drake.robot.fitting.convex_pieces import convex_piece
from remosplat_drake.robot.fitting.enclosing_piece import Enclosed
from remosplat_drake.robot.fitting.mesh_truth import MeshTruth
from remosplat_drake.robot.fitting.piece_fitting import ACCURACY, fit_pieces
from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.importing.link_shapes import write_pieces
from remosplat_drake.robot.importing.urdf import Urdf
from remosplat_drake.robot.robot_description import RobotDescription
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sampling import position_ranges, random_states
from remosplat_drake.robot.self_collision.shapes import (
    CollisionShapes,
    read_collision_shapes,
)
from remosplat_drake.robot.sphere_model import SphereModel

_DIRECTIONS = 1000
"""Number of corners of the polyhedron that represents a ball's surface."""

POSTURES = 2000
"""Number of random postures in which distances are compared."""


def fit_link_pieces(
    urdf: Urdf,
    description: RobotDescription,
    meshes: dict[str, list[Enclosed]],
    states: Mapping[str, Mapping[str, float]],
    findings: Findings,
    on_progress: Callable[[str, int, int], None] = lambda what, i, n: None,
) -> None:
    """Fits convex pieces to the meshes, and writes them and the model file.

    Args:
        urdf: The robot; its links' elements are changed.
        description: The same robot, whose model file is written again.
        meshes: The result of `convert_shapes`.
        states: Positions of joints by name, for each state that the robot's
            files name [rad, m].
        findings: Receives a summary of the pieces' accuracy.
        on_progress: Called with the name of the present step, the number of
            finished links, and the number of links.

    Raises:
        RemoSplatError: A mesh cannot be covered with convex pieces.
    """
    if not meshes:
        return
    what = "cutting links into convex pieces"
    on_progress(what, 0, len(meshes))
    model, folder = description.model_path, description.model_path.parent
    write_pieces(urdf, folder, {})
    urdf.write(model)
    no_spheres = SphereModel("none", (), np.zeros((0, 3)), np.zeros(0))
    robot = RobotModel(description, no_spheres)
    primitives = read_collision_shapes(description, no_spheres)
    truth = MeshTruth(
        robot, _surfaces(meshes, primitives), _states(robot, states)
    )
    fitted = fit_pieces(
        meshes, primitives, truth, lambda i, n: on_progress(what, i, n)
    )
    write_pieces(urdf, folder, fitted.pieces)
    urdf.write(model)
    findings.find(
        "shapes",
        f"{len(fitted)} convex pieces of {len(fitted.pieces)} links, checked"
        f" in {len(truth.states)} postures",
    )
    for error in fitted.errors:
        findings.doubt(
            " and ".join(error.links),
            f"are {1e3 * error.distance:.0f} mm apart, but their convex "
            f"pieces are {1e3 * error.error:.0f} mm nearer, in one of "
            f"{len(truth.states)} postures; the goal is at most "
            f"{1e3 * ACCURACY:g} mm",
        )


def _surfaces(
    meshes: dict[str, list[Enclosed]], primitives: CollisionShapes
) -> dict[str, np.ndarray]:
    """Returns the triangles of all meshes and primitives of each link."""
    parts = {
        link: [mesh.surface for mesh in own] for link, own in meshes.items()
    }
    for link, shape in zip(primitives.links, primitives.shapes, strict=True):
        around = shape.radius * spread_directions(_DIRECTIONS)
        corners = (shape.vertices[:, None] + around).reshape(-1, 3)
        parts.setdefault(link, []).append(convex_piece(corners, 0.0).surface)
    return {link: np.concatenate(own) for link, own in parts.items()}


def _states(
    robot: RobotModel, named: Mapping[str, Mapping[str, float]]
) -> np.ndarray:
    """Returns random configurations, and the named states."""
    rng = np.random.default_rng(0)
    states = [random_states(robot, POSTURES, rng)]
    for positions in named.values():
        state = [positions.get(joint, 0.0) for joint in robot.joint_names]
        states.append(np.clip([state], *position_ranges(robot)))
    return np.vstack(states)
