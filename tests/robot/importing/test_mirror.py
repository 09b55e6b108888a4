"""Two arms that are mirror images are held alike."""

import numpy as np
import pytest

from remosplat_drake.robot.importing.home import guess_home
from remosplat_drake.robot.importing.mirror import find_mirror
from remosplat_drake.robot.robot_model import load_robot
from tests.robot.conftest import THREE_LINK

ACROSS = np.diag([1.0, -1.0, 1.0])


@pytest.mark.parametrize(
    "name", [THREE_LINK.with_name("two_arms.yaml"), "two_pandas"]
)
def test_hands_of_a_mirrored_posture_are_where_the_mirror_has_them(name):
    robot = load_robot(name)
    mirror = find_mirror(robot)
    assert mirror is not None
    rng = np.random.default_rng(2)
    q = robot.q_home + rng.uniform(-0.5, 0.5, robot.n_q)
    left, right = robot.end_effector_poses(q)
    images = robot.end_effector_poses(mirror.image(q))
    np.testing.assert_allclose(images[0][:3, 3], ACROSS @ right[:3, 3])
    np.testing.assert_allclose(images[1][:3, 3], ACROSS @ left[:3, 3])
    held_alike = mirror.symmetric(q)
    np.testing.assert_allclose(mirror.image(held_alike), held_alike)


def test_what_turns_both_arms_to_one_side_is_at_zero(two_arms):
    mirror = find_mirror(two_arms)
    assert mirror is not None
    q = mirror.symmetric(np.full(two_arms.n_q, 0.3))
    # The torso turns about an upright axis.
    assert q[0] == 0.0
    assert (np.abs(q[1:]) == 0.3).all()


def test_a_single_arm_has_no_mirror():
    assert find_mirror(load_robot("panda")) is None


def test_arms_that_differ_have_no_mirror(tmp_path):
    """One of the shoulders is 5 cm farther forward."""
    for path in THREE_LINK.parent.glob("two_arms*"):
        (tmp_path / path.name).write_text(path.read_text())
    model = tmp_path / "two_arms.urdf"
    text = model.read_text()
    assert text.count('xyz="0 0.25 0"') == 1
    model.write_text(text.replace('xyz="0 0.25 0"', 'xyz="0.05 0.25 0"'))
    assert find_mirror(load_robot(tmp_path / "two_arms.yaml")) is None


def test_the_guessed_home_is_its_own_image(two_arms):
    mirror = find_mirror(two_arms)
    assert mirror is not None
    home = guess_home(two_arms)
    np.testing.assert_allclose(mirror.image(home), home, atol=1e-9)
