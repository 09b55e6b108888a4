"""A scenario's mistakes in `teleop` are named."""

import pytest

from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.strict_yaml import load_text
from remosplat_drake.teleop.teleop_config import TeleopConfig


def read(text: str) -> TeleopConfig:
    return load_text(TeleopConfig, text, "a.yaml", TeleopConfig())


def test_the_defaults_are_usable():
    config = read("{}")
    assert config.max_speed == 0.25
    assert config.pose_stream is None


def test_everything_can_be_given():
    config = read(
        "max_rotation: 0.5\n"
        "workspace_lower: [0, -1, 0.2]\n"
        "poses: {shelf: {translation: [1, 0, 0.5], rpy_deg: [0, 90, 0]}}\n"
        "gamepad: {dead_man: 4}\n"
        "pose_stream: {channel: MINE, lcm_url: 'memq://'}\n"
    )
    assert config.max_rotation == 0.5
    assert config.gamepad.dead_man == 4
    assert config.pose_stream is not None
    assert config.pose_stream.channel == "MINE"
    assert config.poses["shelf"].matrix()[0, 2] == pytest.approx(1)


@pytest.mark.parametrize(
    ("text", "field", "problem"),
    [
        ("max_speed: 0", "max_speed", "positive"),
        ("max_rotation_acceleration: -1", "max_rotation_acc", "positive"),
        ("workspace_lower: [0, 0]", "workspace_lower", "3 entries"),
        ("workspace_lower: [0, 0, 2]", "workspace_upper", "z of 2.0"),
        ("poses: {a: {translation: [9, 0, 1]}}", "poses.a", "workspace"),
        ("poses: {a: {rpy_deg: [1]}}", "poses.a.rpy_deg", "3 entries"),
        ("gamepad: {dead_man: -1}", "gamepad.dead_man", "not be negative"),
        ("gamepad: {dead_zone: 1}", "gamepad.dead_zone", "[0, 1)"),
        ("gamepad: {max_lead: 0}", "gamepad.max_lead", "positive"),
        ("gamepad: {speed: 0}", "gamepad.speed", "positive"),
        ("scan: {pan_deg: 91}", "scan.pan_deg", "[0, 90]"),
        ("scan: {timeout: 0}", "scan.timeout", "positive"),
        ("scan: {dwell: -1}", "scan.dwell", "negative"),
        ("pose_stream: {expiry: 0}", "pose_stream.expiry", "positive"),
        ("pose_stream: {channel: ''}", "pose_stream.channel", "empty"),
        ("pose_stream: {lcm_url: tcp}", "pose_stream.lcm_url", "udpm"),
    ],
)
def test_mistakes(text, field, problem):
    with pytest.raises(FieldError) as error:
        read(text)
    assert f"a.yaml:1: {field}" in str(error.value)
    assert problem in str(error.value)
