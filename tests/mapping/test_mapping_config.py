"""The ranges of the mapping's settings."""

import pytest

from remosplat_drake.errors import FieldError
from remosplat_drake.mapping.config import MappingConfig, check_mapping


def test_the_defaults_are_usable():
    check_mapping(MappingConfig(), "here")
    check_mapping(MappingConfig(unknown="obstacle", latency=0.0), "here")


@pytest.mark.parametrize(
    ("field", "value", "problem"),
    [
        ("unknown", "solid", "unknown choice 'solid'.*free, obstacle"),
        ("device", "gpu", "valid: auto, cpu, cuda, none"),
        ("frames", 0, "at least 1, got 0"),
        ("discs", -1, "at least 1"),
        ("max_frames", 0, "at least 1"),
        ("voxel", 0.0, "must be positive, got 0.0"),
        ("voxel", 0.001, "makes .* voxels"),
        ("max_depth", float("nan"), "must be positive"),
        ("robot_margin", -0.1, "must not be negative"),
        ("latency", -1.0, "must not be negative, got -1.0"),
        ("volume_lower", [0.0, 0.0], "expected 3 entries"),
        ("volume_upper", [2.5, -2.5, 2.5], "must exceed volume_lower"),
        ("volume_upper", [2.5, float("inf"), 2.5], "must exceed volume_lower"),
    ],
)
def test_an_unusable_value_is_named(field, value, problem):
    config = MappingConfig(**{field: value})
    with pytest.raises(FieldError, match=f"here: mapping.{field}: .*{problem}"):
        check_mapping(config, "here")
