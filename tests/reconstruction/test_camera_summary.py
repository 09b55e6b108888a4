"""Corrections are told in words, each with the right direction."""

import numpy as np
import pytest

from remosplat_drake.base.errors import FieldError
from remosplat_drake.capture.checks.wide_baselines import WideBaselines
from remosplat_drake.reconstruction.alignment.alignment import Alignment
from remosplat_drake.reconstruction.alignment.alignment_summary import (
    CameraError,
)
from remosplat_drake.reconstruction.alignment.camera_correction import corrected
from remosplat_drake.reconstruction.alignment.camera_errors import (
    ASPECT,
    CENTER_X,
    CENTER_Y,
    COUNT,
    DELAY,
    FOCAL,
    GROWTH,
    K1,
    K2,
    OFFSET,
    READOUT,
    SCALE,
    SHIFT,
    TURN,
    CameraPrior,
)
from remosplat_drake.reconstruction.alignment.lens_check import judge_lens
from remosplat_drake.reconstruction.alignment.odometry_prior import (
    OdometryNoise,
)
from remosplat_drake.reconstruction.alignment.summary import (
    summarize_alignment,
)


def refined(capture, undone: dict, accepted: bool = True) -> Alignment:
    """An alignment that undid some errors, known to a tenth of a per cent."""
    n, errors = len(capture), np.zeros(COUNT)
    errors[list(undone)] = list(undone.values())
    covariance = np.diag(np.full(6 * n + COUNT, 1e-6))
    return Alignment(
        capture=corrected(capture, errors),
        undone=errors,
        error=np.zeros(6 * n + COUNT),
        covariance=covariance,
        noise=OdometryNoise(),
        shared=1.0,
        rows=[],
        groups=1,
        accepted=accepted,
    )


def words(capture, **undone) -> str:
    names = {
        "scale": SCALE, "offset": OFFSET, "growth": GROWTH, "focal": FOCAL,
        "aspect": ASPECT, "x": CENTER_X, "y": CENTER_Y, "k1": K1, "k2": K2,
        "delay": DELAY, "readout": READOUT, "turn": TURN, "shift": SHIFT,
    }  # fmt: skip
    errors = {names[name]: value for name, value in undone.items()}
    result = refined(capture, errors)
    found = summarize_alignment(result, capture.X_WC).words
    first, rest = found.split("(median).")
    assert first.startswith("Cameras were moved by ")
    return rest.strip()


@pytest.mark.parametrize(
    ("error", "value", "told"),
    [
        ("scale", -0.02, "Depths are 2.0 % shorter than the capture says (± 0"),
        ("scale", 0.02, "Depths are 2.0 % longer than the capture says"),
        ("offset", 0.005, "Depths are 5 mm longer than the capture says, near"),
        ("growth", -0.01, "Depths are shorter than the capture says by 1.0 %"),
        ("focal", 0.03, "The focal length is 3.0 % longer than the capture"),
        ("focal", -0.03, "The focal length is 3.0 % shorter than the capture"),
        ("aspect", 0.01, "the vertical focal length is 1.0 % longer than"),
        ("x", 0.05, "The principal point is 4.12 px farther right than"),
        ("y", -0.05, "The principal point is 4.12 px farther up than"),
        ("k1", 0.05, "Images have a radial distortion k1 of +0.050 that"),
        ("k2", -0.05, "Images have a radial distortion k2 of -0.050 that"),
        ("delay", -0.099, "Images are 99 ms older than their poses (± 1 ms)."),
        ("delay", 0.02, "Images are 20 ms newer than their poses"),
        ("readout", 0.03, "Images are read out in 30 ms, from top to bottom"),
        ("readout", -0.03, "Images are read out in 30 ms, from bottom to top"),
        ("turn", np.deg2rad(2), "The camera is 2.00 degrees from its"),
        ("shift", 0.005, "The camera is 5 mm from its configured pose (± 1"),
    ],
)
def test_each_error_is_told_in_one_sentence(scene_capture, error, value, told):
    sentence = words(scene_capture, **{error: value})
    assert told in sentence
    assert sentence.count("(±") == 1 and sentence.endswith(").")


def test_sizes_of_principal_points_are_those_of_the_capture(scene_capture):
    """In pixels of the given focal length, even where that was wrong."""
    result = refined(scene_capture, {CENTER_X: 0.01, FOCAL: 0.03, ASPECT: 0.1})
    table = summarize_alignment(result, scene_capture.X_WC).camera
    moved = result.capture.K[0, 0, 2] - scene_capture.K[0, 0, 2]
    (center,) = [e for e in table if e.name.startswith("principal point to")]
    assert center.value == pytest.approx(moved)
    assert (center.unit, center.undone) == ("px", True)


def test_turn_and_shift_of_the_mount_are_one_sentence(scene_capture):
    undone = {TURN: 0.03, TURN + 1: 0.04, SHIFT + 2: -0.004}
    result = refined(scene_capture, undone)
    told = summarize_alignment(result, scene_capture.X_WC).words
    assert "is 2.86 degrees and 4 mm from its configured pose" in told
    assert "(± 0.06 degrees, ± 1 mm)" in told


def test_nothing_is_told_of_what_was_left(scene_capture):
    """But the table has it: what was found, and that it was left."""
    result = refined(scene_capture, {})
    result.error[-COUNT + FOCAL] = 0.001
    summary = summarize_alignment(result, scene_capture.X_WC)
    assert summary.words.endswith("(median).")
    assert len(summary.camera) == COUNT
    assert not any(error.undone for error in summary.camera)
    (focal,) = [e for e in summary.camera if e.name == "focal length"]
    assert str(focal) == "+0.1 ± 0.1 %"


def test_values_have_the_decimals_that_their_deviation_allows():
    assert str(CameraError("k", 0.04987, 0.0002)) == "+0.0499 ± 0.0002"
    assert str(CameraError("k", -0.3, 3.0, "mm")) == "+0 ± 3 mm"
    assert str(CameraError("k", 12.0, 0.0, "ms")) == "+12.0000 ± 0.0000 ms"


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"focal": -1.0}, "CameraPrior: focal: must not be negative, got -1"),
        ({"turn": 4.0}, "CameraPrior: turn: must lie in [0, 3.14159], got 4"),
        ({"delay": float("nan")}, "CameraPrior: delay: must be finite"),
        ({"scale": 2.0}, "CameraPrior: scale: must lie in [0, 1], got 2"),
    ],
)
def test_a_prior_out_of_range_is_named(values, says):
    with pytest.raises(FieldError) as error:
        CameraPrior(**values)
    assert says in str(error.value)


def test_an_exact_camera_has_depths_that_are_not():
    deviations = CameraPrior.exact(0.05).deviations()
    assert deviations[SCALE] == 0.05
    assert deviations[OFFSET] == CameraPrior.offset > 0
    assert np.count_nonzero(deviations) == 2


def disagreeing(offset: float) -> WideBaselines:
    """Ten pairs of views that disagree, where noise explains 1 mm."""
    one = np.ones(10)
    return WideBaselines(
        frames=5,
        pairs=np.zeros((10, 2), int),
        baseline=one,
        offset=offset * one,
        noise=1e-3 * one,
        scale=0.0,
        unscaled=offset * one,
        judged=np.zeros((10, 2), int),
        through=np.zeros((10, 2), int),
    )


@pytest.mark.parametrize(
    ("k1", "offset", "told"),
    [
        (-0.3, 0.01, True),
        (-0.3, 0.002, False),  # Two numbers describe this lens.
        (0.05, 0.01, False),  # Poses, then, and not the lens.
    ],
)
def test_a_lens_is_told_if_it_is_strange_and_not_undone(k1, offset, told):
    undone = np.zeros(COUNT)
    undone[K1] = k1
    findings = judge_lens(disagreeing(offset), undone)
    assert [finding.name for finding in findings] == ["lens"] * told
    if told:
        assert "k1 -0.30 and k2 +0.00 was corrected" in findings[0].problem
