"""The tree that is read off a plant, and the kernels on a tree by hand."""

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot import kinematics as kin

URDF = """
<robot name="r">
  <link name="ground"/>
  <link name="slider"/><link name="arm"/><link name="plate"/>
  <joint name="slide" type="prismatic">
    <parent link="ground"/><child link="slider"/>
    <origin xyz="0 0 2"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
  <joint name="turn" type="revolute">
    <parent link="slider"/><child link="arm"/>
    <origin xyz="1 0 0"/><axis xyz="0 0 2"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/>
  </joint>
  <joint name="glue" type="fixed">
    <parent link="arm"/><child link="plate"/>
    <origin xyz="0 0.5 0"/>
  </joint>
</robot>
"""


@pytest.fixture
def plant() -> MultibodyPlant:
    plant = MultibodyPlant(time_step=0.0)
    Parser(plant).AddModelsFromString(URDF, "urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("ground"))
    plant.Finalize()
    return plant


def poses(tree: kin.KinematicTree, q) -> dict[str, np.ndarray]:
    X_WB, _ = kin.body_poses(tree.arrays, np.array(q, float))
    return dict(zip(tree.names, X_WB, strict=True))


def test_poses_by_hand(plant):
    """Up by 0.5 and a quarter turn: the plate lies behind the arm's axis."""
    tree = kin.make_kinematic_tree(plant, ["slide", "turn"], {})
    X_W = poses(tree, [0.5, np.pi / 2])
    np.testing.assert_allclose(X_W["arm"][:3, 3], [1, 0, 2.5], atol=1e-15)
    np.testing.assert_allclose(X_W["plate"][:3, 3], [0.5, 0, 2.5], atol=1e-15)
    np.testing.assert_allclose(X_W["plate"][:3, 0], [0, 1, 0], atol=1e-15)


def test_many_configurations_have_the_poses_of_each(plant):
    tree = kin.make_kinematic_tree(plant, ["slide", "turn"], {})
    states = np.array([[0.5, 1.0], [-0.3, 0.2]])
    X_WBs = kin.body_poses_at(tree.arrays, states)
    for X_WB, q in zip(X_WBs, states, strict=True):
        np.testing.assert_array_equal(X_WB, list(poses(tree, q).values()))


def test_q_follows_the_given_joint_order(plant):
    forward = kin.make_kinematic_tree(plant, ["slide", "turn"], {})
    swapped = kin.make_kinematic_tree(plant, ["turn", "slide"], {})
    np.testing.assert_array_equal(
        poses(forward, [0.1, 0.2])["plate"],
        poses(swapped, [0.2, 0.1])["plate"],
    )


def test_locked_joints_keep_their_position(plant):
    tree = kin.make_kinematic_tree(plant, ["turn"], {"slide": -0.25})
    assert poses(tree, [0.0])["arm"][2, 3] == 1.75


def test_point_jacobian_by_hand():
    """A slide along z, and a turn about z through (1, 0, 0)."""
    J = kin.point_jacobians(
        np.array([[0.0, 0, 1], [0, 0, 1]]),
        np.array([[0.0, 0, 0], [1, 0, 0]]),
        np.array([False, True]),
        np.array([[False, False], [True, False], [True, True]]),
        np.array([1, 2, 0]),
        np.array([[3.0, 1, 0]] * 3),
    )
    slide, turn = [0, 0, 1], [-1, 2, 0]
    np.testing.assert_array_equal(J[0].T, [slide, [0, 0, 0]])
    np.testing.assert_array_equal(J[1].T, [slide, turn])
    np.testing.assert_array_equal(J[2], np.zeros((3, 2)))


def test_chain_runs_from_the_world_outwards(plant):
    tree = kin.make_kinematic_tree(plant, ["slide", "turn"], {})
    chain = tree.chain(tree.index("plate"))
    assert [tree.names[i] for i in chain] == [
        "ground",
        "slider",
        "arm",
        "plate",
    ]


def test_the_tree_is_read_only(plant):
    tree = kin.make_kinematic_tree(plant, ["slide", "turn"], {})
    with pytest.raises(ValueError, match="read-only"):
        tree.offset[0] = 1.0


def test_unknown_names_list_the_known_ones(plant):
    with pytest.raises(RemoSplatError, match=r"'spin'.*slide"):
        kin.make_kinematic_tree(plant, ["spin"], {})
    tree = kin.make_kinematic_tree(plant, ["slide", "turn"], {})
    with pytest.raises(RemoSplatError, match=r"'wing'.*plate"):
        tree.index("wing")


def test_other_joint_types_are_refused():
    plant = MultibodyPlant(time_step=0.0)
    floating = '<robot name="f"><link name="a"/></robot>'
    Parser(plant).AddModelsFromString(floating, "urdf")
    plant.Finalize()
    with pytest.raises(RemoSplatError, match="supported: revolute"):
        kin.make_kinematic_tree(plant, [], {})
