"""A wall that a splat has 5 mm too far away, and a floater before it."""

import dataclasses as dc
import json

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import FieldError, FileError, RemoSplatError
from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.report.assessment import Assessment, assess
from remosplat_drake.reconstruction.report.quality_report import (
    judge,
    read_report,
    report_path,
    write_report,
)
from remosplat_drake.reconstruction.report.report_page import to_html
from remosplat_drake.reconstruction.workspace import Workspace
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.splat.gaussian_splat import GaussianSplat

WALL = PrimitiveScene((Box(RigidTransform([0, 0, 3]), np.array([2.0, 2, 1])),))
WORKSPACE = Workspace(np.array([-0.3, -0.3, 1.4]), np.array([0.3, 0.3, 2.1]))
SHIFT = 0.005


def _capture() -> Capture:
    """Four looks along z at the wall, whose face is the plane z = 2."""
    n, size = 4, 200
    K = np.array([[size, 0, size / 2], [0, size, size / 2], [0, 0, 1.0]])
    return Capture(
        K=np.tile(K, (n, 1, 1)),
        X_WC=np.tile(np.eye(4), (n, 1, 1)),
        rgb=np.full((n, size, size, 3), 51, np.uint8),
        depth=np.full((n, size, size), 2, np.float32),
    )


def _splat(*floaters: tuple[float, float, float]) -> GaussianSplat:
    """Discs 2 cm apart on the plane z = 2 + SHIFT, and some before it."""
    x = np.arange(-1.2, 1.2, 0.02)
    wall = np.stack([*np.meshgrid(x, x), np.full((len(x),) * 2, 2 + SHIFT)])
    p_GK = np.concatenate(
        [wall.reshape(3, -1).T, np.reshape(floaters, (-1, 3))]
    )
    n = len(p_GK)
    return GaussianSplat(
        p_GK=p_GK,
        quaternions=np.tile([1.0, 0, 0, 0], (n, 1)),
        scales=np.full((n, 2), 0.016),
        opacities=np.full(n, 0.95),
        colors=np.full((n, 3), 0.2),
    )


@pytest.fixture(scope="module")
def assessment() -> Assessment:
    return assess(
        _splat(),
        _capture(),
        [1, 3],
        truth=WALL,
        workspace=WORKSPACE,
        method="laid by hand",
        count=400,
    )


def test_a_shift_of_5_mm_is_an_over_estimate_of_5_mm(assessment):
    report = assessment.report
    rows = {(d.oracle, d.reference): d for d in report.distances}
    assert len(rows) == 4
    exact = rows["sphere-to-ellipsoid", "truth"]
    for value in (exact.median, exact.percentile_99, exact.over):
        assert value == pytest.approx(SHIFT, abs=1e-6)
    assert exact.under == 0
    # The nearest of 80 x 80 pixels is a little beside the nearest point.
    pixels = rows["depth rasterisation", "truth"]
    assert pixels.median == pytest.approx(SHIFT, abs=1e-4)
    assert report.map_error == pytest.approx(SHIFT, abs=2e-4)
    # Samples of the wall 1 cm apart are a little farther than the wall.
    measured = rows["sphere-to-ellipsoid", "capture"]
    assert measured.median == pytest.approx(SHIFT, abs=3e-4)
    assert measured.over <= SHIFT + 1e-6


def test_images_and_coverage_by_hand(assessment):
    report = assessment.report
    images = report.images
    assert images.views == 2
    assert images.depth_median == pytest.approx(SHIFT, abs=1e-5)
    # All is seen or free but for the layer that reaches behind the wall.
    assert report.coverage.free == pytest.approx(12 / 14, abs=0.01)
    assert report.coverage.surface == pytest.approx(1 / 14, abs=0.01)
    assert report.floaters.count == 0
    assert report.scatter == pytest.approx(0, abs=1e-6)


def test_the_verdict_names_the_numbers(assessment):
    trust = assessment.report.trust
    assert "the largest over-estimate is 5.1 mm" in trust
    assert "Stopping distances of 7.1 mm or more are safe here" in trust
    assert "against the true geometry" in trust


def test_a_floater_is_found_and_makes_distances_too_small():
    splat = _splat((0.1, 0.0, 1.6), (0.0, 0.2, 1.8), (0.0, 0.0, 1.99))
    assessment = assess(
        splat, _capture(), [0], workspace=WORKSPACE, count=200, held_out=False
    )
    n = len(_splat())
    np.testing.assert_array_equal(assessment.floaters.index, [n, n + 1])
    floaters = assessment.report.floaters
    np.testing.assert_allclose(
        floaters.p_WK, [[0.1, 0, 1.6], [0, 0.2, 1.8]], atol=1e-4
    )
    assert floaters.worst == pytest.approx(0.4, abs=1e-4)
    assert max(d.under for d in assessment.report.distances) > 0.1
    assert "2 floaters" in assessment.report.trust
    assert "true geometry is unknown" in assessment.report.trust


def test_views_that_hide_everything_have_no_score():
    hidden = np.ones((4, 200, 200), bool)
    hidden[1:] = False
    capture = dc.replace(_capture(), hidden=hidden)
    for compared, ssim in (([0], 0), ([0, 1], 1)):
        assessment = assess(
            _splat(), capture, compared, workspace=WORKSPACE, count=50
        )
        images = assessment.report.images
        assert images.ssim == pytest.approx(ssim, abs=0.01)


def test_what_cannot_be_compared_is_refused():
    with pytest.raises(RemoSplatError, match="no view"):
        assess(_splat(), _capture(), [])
    elsewhere = Workspace(np.full(3, 50.0), np.full(3, 51.0))
    with pytest.raises(RemoSplatError, match="no surface in the workspace"):
        assess(_splat(), _capture(), [0], workspace=elsewhere)
    behind = Workspace(np.array([-0.3, -0.3, 2]), np.array([0.3, 0.3, 2.4]))
    with pytest.raises(RemoSplatError, match="no free space"):
        assess(_splat(), _capture(), [0], workspace=behind)


@pytest.fixture
def splat_file(tmp_path, assessment):
    path = tmp_path / "wall.ply"
    path.write_bytes(b"the splat")
    write_report(path, assessment.report)
    return path


def test_a_report_survives_its_file(splat_file, assessment):
    assert read_report(splat_file) == assessment.report


def _change(splat_file, change):
    path = report_path(splat_file)
    document = json.loads(path.read_text())
    change(document)
    path.write_text(json.dumps(document))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.pop("map_error"), "map_error: is missing"),
        (lambda d: d.update(map_error="big"), "map_error: expected a number"),
        (lambda d: d.update(map_error=-1), "must not be negative"),
        (lambda d: d.update(mood="good"), "unknown field 'mood'"),
        (lambda d: d["images"].update(psnr=None), "images.psnr"),
    ],
)
def test_a_damaged_report_is_refused(splat_file, change, message):
    _change(splat_file, change)
    with pytest.raises(FieldError, match=message):
        read_report(splat_file)


def test_a_report_of_another_splat_is_refused(splat_file):
    splat_file.write_bytes(b"another splat")
    with pytest.raises(FileError, match="belongs to another splat"):
        read_report(splat_file)
    report_path(splat_file).write_text("{")
    with pytest.raises(FileError, match="not JSON"):
        read_report(splat_file)


def test_the_page_holds_everything_in_itself(assessment):
    page = to_html(assessment, "<wall>")
    assert "&lt;wall&gt;" in page
    assert assessment.report.trust in page
    assert page.count('src="data:image/jpeg;base64,') == 2 * 5
    assert page.count("<svg") == 2
    assert "http://" not in page.replace("http://www.w3.org", "").replace(
        "http://purl.org", ""
    ).replace("http://creativecommons.org", "")


@pytest.mark.parametrize(
    ("over", "words"),
    [
        (0.006, "over-estimate is 6.0 mm"),
        (0.00601, "over-estimate is 6.1 mm"),
        (0.0123, "over-estimate is 13 mm"),
    ],
)
def test_the_verdict_rounds_to_the_safe_side(assessment, over, words):
    report = dc.replace(assessment.report, map_error=over)
    assert words in judge(report)
