"""The ranges of the mapping's settings."""

import pytest

from remosplat_drake.base.errors import FieldError
from remosplat_drake.mapping.mapping_config import MappingConfig


def test_usable_values():
    MappingConfig(latency=0.0)


@pytest.mark.parametrize(
    ("field", "value", "problem"),
    [
        ("device", "gpu", "valid: auto, cpu, cuda, none"),
        ("frames", 0, r"\[1, 1000\], got 0"),
        ("discs", -1, r"\[1, 1e\+07\]"),
        ("max_frames", 0, r"\[1, 10000\]"),
        ("voxel", 0.0, "must be positive, got 0.0"),
        ("voxel", 0.001, "makes .* voxels"),
        ("max_depth", float("nan"), "must be finite"),
        ("robot_margin", -0.1, "must not be negative"),
        ("latency", -1.0, "must not be negative, got -1.0"),
        ("volume_lower", [0.0, 0.0], "expected 3 entries"),
        ("volume_upper", [2.5, -2.5, 2.5], "must exceed volume_lower"),
        ("volume_upper", [2.5, float("inf"), 2.5], "must be finite"),
    ],
)
def test_an_unusable_value_is_named(field, value, problem):
    named = rf"MappingConfig: {field}(\[1\])?: .*{problem}"
    with pytest.raises(FieldError, match=named):
        MappingConfig(**{field: value})
