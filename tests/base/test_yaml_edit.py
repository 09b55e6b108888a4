"""Values that are set in YAML text; all else stays to the letter."""

import pytest
import yaml

from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.yaml_edit import with_values

BLOCK = """# My robot.
Kitchen:  # where I cook
  wrist_camera:
    # Measured on Monday.
    translation:
      - 0.1   # x
      - 0.2
      - 0.3
    # Pixels.
    width: 640
  time_limit: 5  # [s]

Other: {time_limit: 3}
"""
NEW = {"translation": "[1.0, 2.0, 3.0]", "rpy_deg": "[4.0, 5.0, 6.0]"}


def changed(text: str, path=("Kitchen", "wrist_camera")) -> dict:
    new = with_values(text, path, NEW, "my.yaml")
    document = yaml.safe_load(new)
    before = yaml.safe_load(text)
    camera = document["Kitchen"].pop("wrist_camera")
    old = before["Kitchen"].pop("wrist_camera", None) or {}
    assert document == before
    assert camera == old | yaml.safe_load(
        "\n".join(f"{k}: {v}" for k, v in NEW.items())
    )
    return camera


def test_a_block_keeps_its_comments():
    changed(BLOCK)
    new = with_values(BLOCK, ("Kitchen", "wrist_camera"), NEW, "my.yaml")
    for comment in ("# My robot.", "# where I cook", "# Measured on Monday."):
        assert comment in new
    assert "    # Pixels.\n    width: 640\n" in new
    assert new.endswith(BLOCK[BLOCK.index("  time_limit: 5") :])


@pytest.mark.parametrize(
    "text",
    [
        "Kitchen:\n  wrist_camera: {}\n  time_limit: 5\n",
        "Kitchen:\n  wrist_camera: {width: 4} # small\n",
        "Kitchen:\n  wrist_camera: {translation: [0, 0, 0], rpy_deg: [0,1,2]}",
        "Kitchen:\n  wrist_camera: {rpy_deg: [0,1,2], width: 3}\n",
        "Kitchen:\n  wrist_camera:\n  time_limit: 5\n",
        "Kitchen:\n  wrist_camera:\n    width: 7\n",
        "Kitchen:\n  # Fast.\n  time_limit: 5\n",
        "Kitchen: {time_limit: 5}\n",
        "Kitchen: {}\n",
    ],
)
def test_whatever_there_was_the_values_are_set(text):
    changed(text)


@pytest.mark.parametrize("value", ["5", "[1]", "!CameraConfig {fps: 3}"])
def test_something_else_is_left_alone(value):
    text = f"Kitchen:\n  wrist_camera: {value}\n"
    with pytest.raises(
        FieldError, match=r"Kitchen.wrist_camera: is not a plain"
    ):
        with_values(text, ("Kitchen", "wrist_camera"), NEW, "my.yaml")
