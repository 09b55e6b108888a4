"""The three-link arm, with a ball at its wrist that may be large."""

from collections.abc import Callable
from pathlib import Path

import pytest
from self_collision_arm import HOME

from remosplat_drake.robot.robot_model import RobotModel, load_robot

DATA = Path(__file__).resolve().parents[2] / "data"


@pytest.fixture
def make_arm(tmp_path) -> Callable[..., RobotModel]:
    """A function (radius, further lines of the description) -> the arm."""

    def make(radius: float = 0.03, more: str = "") -> RobotModel:
        urdf = (DATA / "three_link.urdf").read_text()
        sphere = '<sphere radius="0.03"/>'
        assert sphere in urdf
        urdf = urdf.replace(sphere, f'<sphere radius="{radius}"/>')
        (tmp_path / "arm.urdf").write_text(urdf)
        text = (DATA / "three_link.yaml").read_text()
        text = text.replace("model: three_link.urdf", "model: arm.urdf")
        text = text.replace("[-0.5, 1.2, 0]", f"[-0.5, {HOME}, 0]")
        text = text.replace(
            " three_link_spheres", f" {DATA}/three_link_spheres"
        )
        (tmp_path / "arm.yaml").write_text(text + more)
        return load_robot(tmp_path / "arm.yaml")

    return make
