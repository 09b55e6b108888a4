"""Captures with a known error, which `corrected` makes the true ones again.

All depths are cast exactly: from inside a box, which is smooth but for its
edges, and of a pole before a wall.
"""

import dataclasses as dc

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.undistortion import Distortion, distort
from remosplat_drake.reconstruction.alignment.camera_correction import (
    corrected,
    delay_of_motion,
)
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
)
from remosplat_drake.reconstruction.alignment.perturbation import difference

K = np.array([[100.0, 0, 63], [0, 102, 49], [0, 0, 1]])
HEIGHT, WIDTH = 100, 130
HALF_ROOM = np.array([2.0, 1.5, 1.2])
"""Half the sides of the room, whose centre is the origin of W [m]."""

SMOOTH = 0.0002
"""What resampling may cost on smooth surfaces [m]."""


def errors(sizes: dict[int, float]) -> np.ndarray:
    """All errors of a camera, of which some are not zero."""
    result = np.zeros(COUNT)
    for error, size in sizes.items():
        result[error] = size
    return result


def pinhole_rays(K: np.ndarray = K) -> np.ndarray:
    """Slopes (x, y) of the pixels' rays, (h, w, 2)."""
    u, v = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)
    return (np.stack([u, v], axis=-1) - K[:2, 2]) / K[[0, 1], [0, 1]]


def lens_rays(lens: Distortion) -> np.ndarray:
    """Those of a camera with a lens."""
    target = pinhole_rays()
    xy = target.copy()
    for _ in range(60):
        xy += target - distort(lens, xy)
    return xy


def in_the_room(X_WC: np.ndarray, xy: np.ndarray) -> np.ndarray:
    """Depths of the room's walls on rays (..., 2), exact [m]."""
    ray_W = np.append(xy, np.ones((*xy.shape[:-1], 1)), -1) @ X_WC[:3, :3].T
    with np.errstate(divide="ignore"):
        along = (np.sign(ray_W) * HALF_ROOM - X_WC[:3, 3]) / ray_W
    return along.min(axis=-1)


def smooth_parts(depth: np.ndarray) -> np.ndarray:
    """Pixels more than two from the edges of the room and of the image."""
    inverse = 1 / depth
    bent = np.zeros(depth.shape, bool)
    for axis in (0, 1):
        second = np.abs(np.diff(inverse, 2, axis=axis))
        middle = [slice(1, -1) if i == axis else slice(None) for i in (0, 1)]
        bent[tuple(middle)] |= second > 1e-6
    near = np.pad(bent, 3, constant_values=True)
    window = np.lib.stride_tricks.sliding_window_view(near, (7, 7))
    return np.asarray(~window.any(axis=(2, 3)))


class Flight:
    """A camera that flies through the room, and how fast it does."""

    def position(self, time: float) -> np.ndarray:
        waves = np.sin([1.1 * time, 0.9 * time + 1, 1.3 * time + 2])
        return np.array([0.6, 0.5, 0.3]) * waves

    def rotation(self, time: float) -> Rotation:
        looking = Rotation.from_euler("x", -np.pi / 2 - 0.2)
        return (
            Rotation.from_euler("z", 0.5 * np.sin(1.2 * time))
            * Rotation.from_euler("y", 0.4 * np.cos(time))
            * looking
        )

    def X_WC(self, time: float) -> np.ndarray:
        X = np.eye(4)
        X[:3, :3] = self.rotation(time).as_matrix()
        X[:3, 3] = self.position(time)
        return X

    def motions(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Velocity and acceleration by central differences, (6,) each."""
        h = 1e-4
        here = self.X_WC(time)[None]
        ahead, back = (
            difference(self.X_WC(time + step)[None], here)[0]
            for step in (h, -h)
        )
        return (ahead - back) / (2 * h), (ahead + back) / h**2


FLIGHT, TIMES = Flight(), np.array([0.3, 1.1, 2.0])


def taken(
    xy: np.ndarray | None = None, late: float = 0.0, rolling: float = 0.0
) -> Capture:
    """Images of the flight, with the poses and velocities of `TIMES`.

    Args:
        xy: The pixels' true rays; None: those of a pinhole camera.
        late: Time from a pose to its image [s].
        rolling: Time from the first row of an image to the last one [s].
    """
    xy = pinhole_rays() if xy is None else xy
    rows = late + rolling * ((np.arange(HEIGHT) + 0.5) / HEIGHT - 0.5)
    depth = [
        [in_the_room(FLIGHT.X_WC(t + row), xy[i]) for i, row in enumerate(rows)]
        for t in TIMES
    ]
    motions = np.array([FLIGHT.motions(t) for t in TIMES])
    shape = (len(TIMES), HEIGHT, WIDTH)
    return Capture(
        K=np.tile(K, (len(TIMES), 1, 1)),
        X_WC=np.array([FLIGHT.X_WC(t) for t in TIMES]),
        rgb=np.zeros((*shape, 3), np.uint8),
        depth=np.array(depth, np.float32),
        velocity_W=motions[:, 0],
        acceleration_W=motions[:, 1],
    )


@pytest.fixture(scope="module")
def true() -> Capture:
    return taken()


def test_no_errors_change_nothing(true):
    same = corrected(true, np.zeros(COUNT))
    for name in ("K", "X_WC", "depth", "velocity_W", "acceleration_W"):
        np.testing.assert_array_equal(getattr(same, name), getattr(true, name))
    assert same.hidden is None


def test_depths_follow_their_polynomial(true):
    """What is told is z' with z' + 0.02 z' + 0.004 + 0.01 z'^2 = z."""
    z = true.depth.astype(float)
    wrong = (-1.02 + np.sqrt(1.02**2 + 4 * 0.01 * (z - 0.004))) / (2 * 0.01)
    told = dc.replace(true, depth=wrong.astype(np.float32))
    found = corrected(told, errors({SCALE: 0.02, OFFSET: 0.004, GROWTH: 0.01}))
    np.testing.assert_allclose(found.depth, true.depth, atol=1e-6)


def test_unknown_depths_stay_so_and_none_becomes_negative(true):
    depth = true.depth.copy()
    depth[:, :10], depth[:, 10:20] = 0, 0.002
    found = corrected(dc.replace(true, depth=depth), errors({OFFSET: -0.003}))
    assert not found.depth[:, :20].any()
    assert (found.depth[:, 20:] > 0).all()


def test_lenses_are_undone_exactly(true):
    wrong = true.K.copy()
    wrong[:, 0, 0] /= 1.03
    wrong[:, 1, 1] /= 1.03 - 0.002
    wrong[:, 0, 2] -= 0.01 * wrong[:, 0, 0]
    wrong[:, 1, 2] += 0.004 * wrong[:, 1, 1]
    found = corrected(
        dc.replace(true, K=wrong),
        errors({FOCAL: 0.03, ASPECT: -0.002, CENTER_X: 0.01, CENTER_Y: -0.004}),
    )
    np.testing.assert_allclose(found.K, true.K, rtol=1e-14)
    np.testing.assert_array_equal(found.depth, true.depth)


@pytest.mark.parametrize(
    "lens",
    [Distortion(k1=0.05), Distortion(k1=-0.08), Distortion(k2=0.05)],
)
def test_distorted_images_become_those_of_pinhole_cameras(true, lens):
    bent = taken(lens_rays(lens))
    smooth = np.array([smooth_parts(depth) for depth in true.depth])
    found = corrected(bent, errors({K1: lens.k1, K2: lens.k2}))
    assert found.hidden is not None
    shown = smooth & ~found.hidden
    assert shown.mean() > 0.5
    assert np.abs(bent.depth - true.depth)[shown].max() > 0.01
    np.testing.assert_allclose(
        found.depth[shown], true.depth[shown], atol=SMOOTH
    )


def test_what_the_lens_did_not_show_is_hidden(true):
    """A pinhole camera sees more than one whose lens magnifies corners."""
    lens = Distortion(k1=0.1)
    found = corrected(true, errors({K1: lens.k1}))
    there = distort(lens, pinhole_rays()) * K[[0, 1], [0, 1]] + K[:2, 2]
    outside = np.any((there < 0) | (there >= [WIDTH, HEIGHT]), axis=-1)
    assert outside[0, 0] and not outside[50, 60]
    assert found.hidden is not None
    for hidden in found.hidden:
        np.testing.assert_array_equal(hidden, outside)


def test_rows_of_a_rolling_shutter_are_taken_at_one_time(true):
    rolled = taken(rolling=0.02)
    smooth = np.array([smooth_parts(depth) for depth in true.depth])
    found = corrected(rolled, errors({READOUT: 0.02}))
    shown = smooth & (found.depth > 0)
    assert shown.sum() > 0.95 * smooth.sum()
    before = np.abs(rolled.depth - true.depth)[shown]
    after = np.abs(found.depth - true.depth)[shown]
    assert before.max() > 0.007
    assert after.max() < SMOOTH


@pytest.mark.parametrize(("accelerated", "order"), [(True, 3), (False, 2)])
def test_late_images_get_the_poses_that_they_were_taken_at(accelerated, order):
    """Half the delay leaves an eighth of the error, or else a quarter."""
    capture = taken()
    if not accelerated:
        capture = dc.replace(capture, acceleration_W=None)
    left = []
    for delay in (0.1, 0.05):
        found = corrected(capture, errors({DELAY: delay}))
        expected = np.array([FLIGHT.X_WC(t + delay) for t in TIMES])
        left.append(np.abs(difference(found.X_WC, expected)).max(axis=1))
    ratio = left[0] / left[1]
    np.testing.assert_allclose(ratio, 2.0**order, rtol=0.15)
    assert left[1].max() < (1e-4 if accelerated else 3e-3)


def test_late_images_get_the_velocities_of_their_time(true):
    found = corrected(true, errors({DELAY: 0.01}))
    expected = [FLIGHT.motions(t + 0.01)[0] for t in TIMES]
    assert found.velocity_W is not None
    np.testing.assert_allclose(found.velocity_W, expected, atol=2e-4)


def test_without_velocities_no_time_is_undone(true):
    still = dc.replace(true, velocity_W=None, acceleration_W=None)
    found = corrected(still, errors({DELAY: 0.1, READOUT: 0.03}))
    np.testing.assert_array_equal(found.X_WC, still.X_WC)
    np.testing.assert_allclose(found.depth, still.depth, rtol=1e-6)


def test_cameras_are_put_where_they_sit_on_their_carriers(true):
    X_CD = np.eye(4)
    X_CD[:3, :3] = Rotation.from_rotvec([0.02, -0.03, 0.01]).as_matrix()
    X_CD[:3, 3] = [0.003, 0.002, -0.004]
    told = dc.replace(true, X_WC=true.X_WC @ np.linalg.inv(X_CD))
    error = np.zeros(COUNT)
    error[TURN : TURN + 3] = [0.02, -0.03, 0.01]
    error[SHIFT : SHIFT + 3] = [0.003, 0.002, -0.004]
    found = corrected(told, error)
    np.testing.assert_allclose(found.X_WC, true.X_WC, atol=1e-14)
    np.testing.assert_array_equal(found.depth, true.depth)


def test_unknown_and_hidden_pixels_move_with_their_surroundings(true):
    """The lens draws the middle of both patches by about six pixels."""
    lens = Distortion(k1=0.1)
    depth, hidden = true.depth.copy(), np.zeros(true.depth.shape, bool)
    depth[:, 10:30, 90:110] = 0
    hidden[:, 70:90, 15:35] = True
    told = dc.replace(true, depth=depth, hidden=hidden)
    found = corrected(told, errors({K1: lens.k1}))
    assert found.hidden is not None
    there = distort(lens, pinhole_rays()) * K[[0, 1], [0, 1]] + K[:2, 2]
    column, row = np.floor(there).astype(int).transpose(2, 0, 1)
    inside = (column >= 0) & (column < WIDTH) & (row >= 0) & (row < HEIGHT)
    for kind, patch in (("unknown", depth[0] == 0), ("hidden", hidden[0])):
        expected = np.zeros((HEIGHT, WIDTH), bool)
        expected[inside] = patch[row[inside], column[inside]]
        assert 200 < expected.sum() < 400, kind
        assert not found.depth[:, expected].any(), kind
        if kind == "hidden":
            assert found.hidden[:, expected].all()
            assert not found.hidden[:, inside & ~expected].any()


@pytest.mark.parametrize(
    "error",
    [errors({K1: 0.1}), errors({READOUT: 0.05})],
    ids=["lens", "rolling"],
)
def test_no_depth_is_between_a_pole_and_the_wall_behind_it(true, error):
    """A pole one metre away before a wall at three."""
    pole = np.abs(pinhole_rays()[..., 0] - 0.1) < 0.1
    depth = np.tile(np.where(pole, 1, 3), (len(true), 1, 1)).astype(np.float32)
    found = corrected(dc.replace(true, depth=depth), error)
    known = found.depth[found.depth > 0]
    # Within an image of 50 ms, a camera goes some centimetres at most.
    either = np.minimum(np.abs(known - 1), np.abs(known - 3))
    assert either.max() < 0.1
    assert (known > 2).any() and (known < 2).any()


def moving(seed: int, count: int = 40) -> tuple[Capture, np.ndarray]:
    """Cameras of no images, and velocities that change all the time."""
    rng = np.random.default_rng(seed)
    X_WC = np.tile(np.eye(4), (count, 1, 1))
    X_WC[:, :3, 3] = rng.uniform(-1, 1, (count, 3))
    velocity_W = rng.normal(0, 0.4, (count, 6))
    capture = Capture(
        K=np.tile(K, (count, 1, 1)),
        X_WC=X_WC,
        rgb=np.zeros((count, 1, 1, 3), np.uint8),
        depth=np.zeros((count, 1, 1), np.float32),
        velocity_W=velocity_W,
    )
    return capture, velocity_W


def rigid_motion(capture: Capture, seed: int) -> np.ndarray:
    """Errors of poses in a world that is turned, moved and too large."""
    turn, shift = np.random.default_rng(seed).normal(0, 0.02, (2, 3))
    p_WC = capture.X_WC[:, :3, 3]
    motion = np.empty((len(capture), 6))
    motion[:, :3] = turn
    motion[:, 3:] = np.cross(turn, p_WC) + shift + 0.03 * p_WC
    return motion


@pytest.mark.parametrize("seed", [0, 1])
def test_a_delay_is_told_among_rigid_motions(seed):
    capture, velocity_W = moving(seed)
    motion = rigid_motion(capture, seed) + 0.08 * velocity_W
    delay, left = delay_of_motion(capture, motion)
    assert delay == pytest.approx(0.08, abs=1e-12)
    assert left < 1e-12


def test_a_rigid_motion_is_no_delay():
    capture, _ = moving(0)
    delay, _ = delay_of_motion(capture, rigid_motion(capture, 0))
    assert abs(delay) < 1e-12


def test_noise_beside_a_delay_is_left():
    """A tenth of the delay's size leaves a hundredth of the squares."""
    capture, velocity_W = moving(2)
    noise = np.random.default_rng(2).normal(0, 0.1 * 0.08 * 0.4, (40, 6))
    delay, left = delay_of_motion(capture, 0.08 * velocity_W + noise)
    assert delay == pytest.approx(0.08, abs=0.003)
    assert 0.005 < left < 0.02


def test_a_smooth_drift_is_no_delay():
    """It leaves nearly all of what there is to explain."""
    capture, _ = moving(3)
    drift = np.linspace(0, 0.1, 40)[:, None] ** 2 * np.arange(1.0, 7)
    _, left = delay_of_motion(capture, drift)
    assert left > 0.9


def test_nothing_is_known_of_a_delay_without_velocities():
    capture, velocity_W = moving(0)
    motion = 0.08 * velocity_W
    still = dc.replace(capture, velocity_W=None)
    assert delay_of_motion(still, motion) == (0.0, 1.0)


def test_a_cable_of_one_pixel_survives_the_read_out():
    """An upright cable at 1 m before a wall at 2 m; the camera goes sideways.

    At 1 m/s and 40 ms, its image leans by 4 pixels; then it stands upright.
    """
    speed, readout, x = 1.0, 0.04, 0.05
    time = readout * ((np.arange(HEIGHT) + 0.5) / HEIGHT - 0.5)
    column = np.floor((x - speed * time) * K[0, 0] + K[0, 2]).astype(int)
    depth = np.full((1, HEIGHT, WIDTH), 2.0, np.float32)
    depth[0, np.arange(HEIGHT), column] = 1.0
    assert np.ptp(column) >= 3
    leaning = Capture(
        K=K[None],
        X_WC=np.eye(4)[None],
        rgb=np.zeros((1, HEIGHT, WIDTH, 3), np.uint8),
        depth=depth,
        velocity_W=np.array([[0, 0, 0, speed, 0, 0]]),
    )
    upright = corrected(leaning, errors({READOUT: readout})).depth[0]
    rows, columns = np.nonzero(np.abs(upright - 1) < 1e-3)
    assert np.unique(rows).tolist() == list(range(HEIGHT))
    assert np.abs(columns - np.floor(x * K[0, 0] + K[0, 2])).max() <= 1
    wall = upright[np.abs(upright - 1) > 1e-3]
    np.testing.assert_allclose(wall[wall > 0], 2, atol=1e-6)
