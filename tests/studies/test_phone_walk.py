"""A long capture like a phone's is one that is read, and a good one."""

import numpy as np
import pytest

from apps.studies import phone_walk
from remosplat_drake.capture.checks.overlap import measure_overlap
from remosplat_drake.capture.formats import detect_format, read_capture

pytest.importorskip("PIL")
pytest.importorskip("av")


def test_it_is_read_as_it_was_walked(tmp_path):
    flags = ["--frames", "4", "--scale", "1.5"]
    assert phone_walk.main([str(tmp_path), *flags]) == 0
    assert detect_format(tmp_path) == "stray-scanner"
    capture = read_capture(tmp_path)
    assert len(capture) == 4 and capture.size == phone_walk.SIZE
    np.testing.assert_allclose(capture.K[:, 0, 0], phone_walk.FOCAL)
    first = phone_walk.walk(0.0).GetAsMatrix4()
    np.testing.assert_allclose(capture.X_WC[0], first, atol=1e-9)
    # Depths tremble by a per cent each, and two may differ by two.
    assert measure_overlap(capture).agreement > 0.8
    # A walk: slower than 1 m/s and 1 rad/s.
    assert capture.velocity_W is not None
    speed = np.linalg.norm(capture.velocity_W.reshape(4, 2, 3), axis=2)
    assert (speed < 1).all() and (speed > 0.1).all()


def test_refuses_no_frames(tmp_path, capsys):
    assert phone_walk.main([str(tmp_path), "--frames", "0"]) == 2
    assert "--frames: must be positive" in capsys.readouterr().err
