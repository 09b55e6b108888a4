"""The shipped Frankie: its numbers agree with their public sources."""

import numpy as np
import pytest
from pydrake.multibody.parsing import (
    LoadModelDirectives,
    Parser,
    ProcessModelDirectives,
)
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import BodyIndex, PdControllerGains
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.base import resources
from remosplat_drake.robot.robot_description import load_robot_description

# Denavit-Hartenberg parameters (a, d, alpha) of the Panda in Craig's
# convention, as its maker publishes them.
DH = [
    (0.0, 0.333, 0.0),
    (0.0, 0.0, -np.pi / 2),
    (0.0, 0.316, np.pi / 2),
    (0.0825, 0.0, np.pi / 2),
    (-0.0825, 0.384, -np.pi / 2),
    (0.0, 0.0, np.pi / 2),
    (0.088, 0.0, np.pi / 2),
]
ARM = [f"panda_joint{i}" for i in range(1, 8)]
FRANKIE = load_robot_description("frankie")


def make_diagram():
    """Frankie with joint control: positions of the arm, speed of the base."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 1e-3)
    parser = Parser(plant)
    parser.SetStrictParsing()
    parser.package_map().Add(
        "remosplat_drake", str(resources.models_dir().parent)
    )
    ProcessModelDirectives(LoadModelDirectives(str(FRANKIE.model_path)), parser)
    for index in plant.GetJointActuatorIndices():
        actuator = plant.get_joint_actuator(index)
        if actuator.name().startswith("base"):
            gains = PdControllerGains(p=0, d=2000)
        else:
            gains = PdControllerGains(p=1000, d=50)
        actuator.set_controller_gains(gains)
    plant.Finalize()
    return builder.Build(), plant


@pytest.fixture(scope="module")
def plant():
    return make_diagram()[1]


def link(a, d, alpha, theta):
    ca, sa, ct, st = (
        np.cos(alpha),
        np.sin(alpha),
        np.cos(theta),
        np.sin(theta),
    )
    return np.array(
        [
            [ct, -st, 0, a],
            [st * ca, ct * ca, -sa, -d * sa],
            [st * sa, ct * sa, ca, d * ca],
            [0, 0, 0, 1],
        ]
    )


def chain(q):
    """X_BE by Denavit-Hartenberg: mount, seven joints, flange, hand, tip."""
    X = np.eye(4)
    X[:3, 3] = [0.15, 0, 0.38]
    for (a, d, alpha), theta in zip(DH, q, strict=True):
        X = X @ link(a, d, alpha, theta)
    return X @ link(0, 0.107, 0, -np.pi / 4) @ link(0, 0.1034, 0, 0)


@pytest.mark.parametrize("pose", ["home", 1, 2, 3])
def test_tool_centre_point_by_denavit_hartenberg(plant, pose):
    q = np.array(FRANKIE.home)
    if pose != "home":
        q = np.random.default_rng(pose).uniform(-1.5, 1.5, 7)
    context = plant.CreateDefaultContext()
    for name, value in zip(ARM, q, strict=True):
        plant.GetJointByName(name).set_angle(context, value)
    X_WE = plant.GetFrameByName("tcp").CalcPoseInWorld(context)
    np.testing.assert_allclose(X_WE.GetAsMatrix4(), chain(q), atol=1e-12)


def test_home_points_the_gripper_almost_straight_down():
    # Joints 2, 4 and 6 share an axis direction: -0.3 + 2.2 - 2.0 = -0.1 rad
    # is left of a gripper pointing straight down.
    X_BE = chain(FRANKIE.home)
    np.testing.assert_allclose(X_BE[2, 2], -np.cos(0.1), atol=1e-12)


def test_base_joints_are_x_y_and_yaw(plant):
    context = plant.CreateDefaultContext()
    assert FRANKIE.base is not None
    x, y, yaw = (plant.GetJointByName(n) for n in FRANKIE.base.joints)
    x.set_translation(context, 1.0)
    y.set_translation(context, 2.0)
    yaw.set_angle(context, np.pi / 2)
    body = plant.GetBodyByName(FRANKIE.base.body)
    X_WB = plant.EvalBodyPoseInWorld(context, body)
    np.testing.assert_allclose(X_WB.translation(), [1, 2, 0], atol=1e-15)
    forward = X_WB.rotation() @ np.array([1.0, 0, 0])
    np.testing.assert_allclose(forward, [0, 1, 0], atol=1e-15)


def test_camera_looks_along_the_gripper(plant):
    context = plant.CreateDefaultContext()
    X_EC = plant.GetFrameByName("wrist_camera").CalcPose(
        context, plant.GetFrameByName("tcp")
    )
    # OpenCV: z forward; the fingers open to the left and right (y of E).
    np.testing.assert_allclose(X_EC.rotation().col(2), [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(X_EC.rotation().col(0), [0, 1, 0], atol=1e-12)
    # The fingertips lie below the image's centre.
    p_CE = X_EC.inverse().translation()
    assert p_CE[1] > 0
    assert p_CE[2] > 0


def test_every_joint_has_an_actuator(plant):
    assert plant.num_velocities() == 12
    assert plant.num_actuators() == 12


def test_description_and_urdf_agree_on_limits(plant):
    joints = [plant.GetJointByName(name) for name in ARM]
    speed = [j.velocity_upper_limits()[0] for j in joints]
    acceleration = [j.acceleration_upper_limits()[0] for j in joints]
    assert speed == FRANKIE.velocity_limits[2:]
    assert acceleration == FRANKIE.acceleration_limits[2:]
    for joint, angle in zip(joints, FRANKIE.home, strict=True):
        lower = joint.position_lower_limits()[0]
        assert lower < angle < joint.position_upper_limits()[0]
    for name, value in FRANKIE.locked.items():
        assert plant.GetJointByName(name).position_upper_limits()[0] == value


def test_inertias_are_physical(plant):
    context = plant.CreateDefaultContext()
    for i in range(1, plant.num_bodies()):
        body = plant.get_body(BodyIndex(i))
        M_BBo = body.CalcSpatialInertiaInBodyFrame(context)
        assert M_BBo.IsPhysicallyValid(), body.name()
    # LD-60 (62 kg), Panda (16.7 kg as identified), hand (0.7 kg).
    assert 79 < plant.CalcTotalMass(context) < 80


def test_holds_its_pose_against_gravity_for_a_second():
    diagram, plant = make_diagram()
    simulator = Simulator(diagram)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    q = np.concatenate(
        [[0.3, -0.2, 0.5], FRANKIE.home, list(FRANKIE.locked.values())]
    )
    plant.SetPositions(context, q)
    for name in ("base", "panda", "hand"):
        model = plant.GetModelInstanceByName(name)
        q_model = plant.GetPositionsFromArray(model, q)
        plant.get_desired_state_input_port(model).FixValue(
            context, np.concatenate([q_model, np.zeros_like(q_model)])
        )
    simulator.AdvanceTo(1.0)
    np.testing.assert_allclose(plant.GetPositions(context), q, atol=0.05)


@pytest.mark.parametrize("q", [FRANKIE.home, [0, 0, 0, -1.5, 0, 1.5, 0]])
def test_no_self_contact_in_ordinary_poses(q):
    diagram, plant = make_diagram()
    context = diagram.CreateDefaultContext()
    own = plant.GetMyMutableContextFromRoot(context)
    for name, value in zip(ARM, q, strict=True):
        plant.GetJointByName(name).set_angle(own, value)
    query = plant.get_geometry_query_input_port().Eval(own)
    assert query.ComputePointPairPenetration() == []
